# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex polygons in a plane: hull, clip, offset, cover. Lists of (x, y), counter-clockwise.

Everything that simplifies here grows the polygon, never shrinks it: polygons end as apertures one sees through.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

Point = tuple[float, float]
Polygon = list[Point]


def hull(points: Iterable[Sequence[float]]) -> Polygon:
    """Convex hull (Andrew's monotone chain); fewer than 3 corners when the points are collinear.

    Coordinates are rounded to a nanometre first: points of one upright edge that differ in the last bits of x would
    sort in any order of y, and a true corner would be dropped as a collinear one.
    """
    ordered = sorted({(round(float(p[0]), 9), round(float(p[1]), 9)) for p in points})
    if len(ordered) < 3:
        return ordered
    chains: list[Polygon] = []
    for sequence in (ordered, ordered[::-1]):
        chain: Polygon = []
        for p in sequence:
            # Only what is collinear to rounding goes (1e-13 m2: far below the area between rounded points).
            while len(chain) > 1 and _cross(chain[-2], chain[-1], p) <= 1e-13:
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return chains[0] + chains[1]


def area(polygon: Sequence[Point]) -> float:
    total = 0.0
    for i in range(len(polygon)):
        (x0, y0), (x1, y1) = polygon[i - 1], polygon[i]
        total += x0 * y1 - x1 * y0
    return 0.5 * total


def clip(polygon: Polygon, convex: Polygon) -> Polygon:
    """`polygon` within `convex` (Sutherland & Hodgman 1974); both convex. Empty when they don't overlap."""
    result = polygon
    for i in range(len(convex)):
        a, b = convex[i - 1], convex[i]
        source, result = result, []
        if len(source) < 3:
            return []
        side = [_cross(a, b, p) for p in source]
        for j in range(len(source)):
            s0, s1 = side[j - 1], side[j]
            if (s0 < 0.0) != (s1 < 0.0):
                t = s0 / (s0 - s1)
                (x0, y0), (x1, y1) = source[j - 1], source[j]
                result.append((x0 + t * (x1 - x0), y0 + t * (y1 - y0)))
            if s1 >= 0.0:
                result.append(source[j])
    return result if len(result) > 2 else []


def width(polygon: Polygon) -> float:
    """The smallest width of a convex polygon, across one of its edges."""
    best = math.inf
    for i in range(len(polygon)):
        a, b = polygon[i - 1], polygon[i]
        length = math.dist(a, b)
        if length > 1e-12:
            best = min(best, max(_cross(a, b, p) for p in polygon) / length)
    return best


def contains(polygon: Polygon, p: Point, margin: float = 0.0) -> bool:
    """Whether p lies inside or within `margin` of the polygon's edges' lines."""
    for i in range(len(polygon)):
        a, b = polygon[i - 1], polygon[i]
        if _cross(a, b, p) < -margin * math.dist(a, b):
            return False
    return True


def grow(polygon: Polygon, distance: float) -> Polygon:
    """Moves every edge outward by `distance`; sharp corners are mitred at most twice that far, then cut off."""
    grown: list[Point] = []
    n = len(polygon)
    for i in range(n):
        p = polygon[i]
        n0, n1 = _outward(polygon[i - 1], p), _outward(p, polygon[(i + 1) % n])
        bisector = (n0[0] + n1[0], n0[1] + n1[1])
        length2 = bisector[0] ** 2 + bisector[1] ** 2
        if length2 > 1.0:  # mitre up to twice the distance
            k = 2.0 * distance / length2
            grown.append((p[0] + k * bisector[0], p[1] + k * bisector[1]))
        else:  # a square cap: still outside the true offset
            t0, t1 = (-n0[1], n0[0]), (-n1[1], n1[0])
            grown.append((p[0] + distance * (n0[0] + t0[0]), p[1] + distance * (n0[1] + t0[1])))
            grown.append((p[0] + distance * (n1[0] - t1[0]), p[1] + distance * (n1[1] - t1[1])))
    return hull(grown)


def limit_corners(polygon: Polygon, most: int) -> Polygon:
    """At most `most` corners, by dropping edges and prolonging their neighbours outward, the cheapest first."""
    result = list(polygon)
    while len(result) > most:
        best, best_area, best_corner = -1, math.inf, (0.0, 0.0)
        n = len(result)
        for i in range(n):  # drop the edge i, i+1
            a, b, c, d = result[i - 1], result[i], result[(i + 1) % n], result[(i + 2) % n]
            corner = _meet(a, b, d, c)
            if corner is not None and _cross(b, corner, c) > 0.0:
                added = 0.5 * _cross(b, corner, c)
                if added < best_area:
                    best, best_area, best_corner = i, added, corner
        if best < 0:
            return result
        result[best] = best_corner
        del result[(best + 1) % n]
    return result


def merge(pieces: list[Polygon], tolerance: float = 1e-6) -> list[Polygon]:
    """Joins interior-disjoint convex pieces whose union is convex (hull area = sum of areas within `tolerance` m2)."""
    todo = [p for p in pieces if len(p) > 2]
    total = sum(area(p) for p in todo)
    if len(todo) > 1:
        whole = hull(q for p in todo for q in p)
        if area(whole) - total <= tolerance * max(1.0, total):
            return [whole]
    merged = True
    while merged and len(todo) > 1:
        merged = False
        for i in range(len(todo)):
            for j in range(i + 1, len(todo)):
                both = hull(todo[i] + todo[j])
                if area(both) - area(todo[i]) - area(todo[j]) <= tolerance:
                    todo[i] = both
                    del todo[j]
                    merged = True
                    break
            if merged:
                break
    return todo


def ears(polygon: Polygon) -> list[tuple[int, int, int]]:
    """Triangles that fill a simple polygon, convex or not, counter-clockwise: indices into it, by ear clipping."""
    left, result = list(range(len(polygon))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            ear = [polygon[a], polygon[b], polygon[c]]
            if area(ear) <= 1e-12:
                continue
            if any(contains(ear, polygon[m], -1e-9) for m in left if m not in (a, b, c)):
                continue
            break
        else:
            k = 0  # no ear is left but slivers: any corner will do
        result.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    return [*result, (left[0], left[1], left[2])]


def _cross(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _outward(a: Point, b: Point) -> Point:
    length = math.dist(a, b) or 1.0
    return ((b[1] - a[1]) / length, (a[0] - b[0]) / length)


def _meet(a: Point, b: Point, c: Point, d: Point) -> Point | None:
    """Where the line a-b prolonged beyond b meets the line c-d prolonged beyond d."""
    rx, ry, sx, sy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    denominator = rx * sy - ry * sx
    if abs(denominator) < 1e-12 * (math.hypot(rx, ry) * math.hypot(sx, sy) + 1e-300):
        return None
    t = ((c[0] - a[0]) * sy - (c[1] - a[1]) * sx) / denominator
    u = ((c[0] - a[0]) * ry - (c[1] - a[1]) * rx) / denominator
    if t < 1.0 or u < 1.0:
        return None
    return (a[0] + t * rx, a[1] + t * ry)
