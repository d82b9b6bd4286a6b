# SPDX-License-Identifier: GPL-3.0-or-later
"""Trapezoidal decomposition of a rectangle by line segments: exact pieces in which nothing changes.

Vertical lines through every end and crossing of the segments cut the plane into strips; within a strip the segments
don't cross and part it into trapezoids (de Berg et al., Computational Geometry, chapter 6, without the randomised search
structure: all strips of a leaf are made at once in numpy). Rectangles with many segments are halved first, so that the
cost stays near-linear in what is really there.
"""

from __future__ import annotations

import numpy as np

from . import convex_polygons as cp

CROWDED = 72  # segments in a rectangle beyond which it is halved
SMALL = 5e-3  # m: rectangles aren't halved below this; what is finer is left as one piece too many, never as one too few
SAME = 1e-4  # m: ends nearer than this are one, as corners of rooms are (polyhedra.WELD); a model that is turned
# comes with noise of a hundredth of that, and must be cut alike


def decompose(segments: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Trapezoids that fill the rectangle low..high (2,): float64 (n, 6) of x0, x1, bottom y at x0 and x1, top y at x0
    and x1. segments: float64 (m, 4) of x, y, x, y."""
    result: list[np.ndarray] = []
    _halve(_lines(segments), float(low[0]), float(low[1]), float(high[0]), float(high[1]), 0, result)
    return np.concatenate(result) if result else np.zeros((0, 6))


def _lines(s: np.ndarray) -> np.ndarray:
    """Segments from left to right; those on one line that meet are one."""
    turned = (s[:, 0] > s[:, 2]) | ((s[:, 0] == s[:, 2]) & (s[:, 1] > s[:, 3]))
    s = np.where(turned[:, None], s[:, [2, 3, 0, 1]], s)
    along = s[:, 2:] - s[:, :2]
    length = np.linalg.norm(along, axis=1)
    s, along = s[length > SAME], (along / np.maximum(length, 1e-300)[:, None])[length > SAME]
    d = along[:, 0] * s[:, 1] - along[:, 1] * s[:, 0]
    t0 = np.einsum("ij,ij->i", along, s[:, :2])
    t1 = np.einsum("ij,ij->i", along, s[:, 2:])
    key = np.round(np.column_stack([along * 1e4, d * 1e4])).astype(np.int64)
    order = np.lexsort((t0, key[:, 2], key[:, 1], key[:, 0]))
    kept: list[np.ndarray] = []
    last, end = None, 0.0
    for k, key_k, a, b in zip(order.tolist(), key[order].tolist(), t0[order].tolist(), t1[order].tolist(), strict=True):
        if key_k == last and a <= end + SAME:
            if b > end:
                kept[-1][2:] = s[k, 2:]
                end = b
            continue
        kept.append(s[k].copy())
        last, end = key_k, b
    return np.array(kept).reshape(-1, 4)


def _halve(
    s: np.ndarray, x0: float, y0: float, x1: float, y1: float, idle: int, result: list[np.ndarray]
) -> None:
    """idle: how often in a row halving has hardly thinned the segments out."""
    if x1 - x0 < SAME or y1 - y0 < SAME:
        return
    before = len(s)
    near = (s[:, 2] >= x0 - SAME) & (s[:, 0] <= x1 + SAME)
    near &= (np.maximum(s[:, 1], s[:, 3]) >= y0 - SAME) & (np.minimum(s[:, 1], s[:, 3]) <= y1 + SAME)
    s = s[near]
    idle = idle + 1 if len(s) > 0.9 * before else 0
    if len(s) <= CROWDED or max(x1 - x0, y1 - y0) < SMALL or idle > 3:
        result.append(_strips(s, x0, y0, x1, y1))
    elif x1 - x0 >= y1 - y0:
        middle = _median(s[:, [0, 2]], x0, x1)
        _halve(s, x0, y0, middle, y1, idle, result)
        _halve(s, middle, y0, x1, y1, idle, result)
    else:
        middle = _median(s[:, [1, 3]], y0, y1)
        _halve(s, x0, y0, x1, middle, idle, result)
        _halve(s, x0, middle, x1, y1, idle, result)


def _median(ends: np.ndarray, low: float, high: float) -> float:
    """A cut at an end that is there already, where that leaves both halves a fair share."""
    inner = np.sort(ends[(ends > low + SAME) & (ends < high - SAME)])
    middle = 0.5 * (low + high)
    if len(inner):
        found = float(inner[len(inner) // 2])
        if 0.2 < (found - low) / (high - low) < 0.8:
            return found
    return middle


def _strips(s: np.ndarray, x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    lines = np.concatenate([s, [[x0, y0, x1, y0], [x0, y1, x1, y1]]])
    run = lines[:, 2] - lines[:, 0]
    upright = run < SAME
    xs = [lines[:, 0], lines[:, 2]]
    lines, run = lines[~upright], run[~upright]
    slope = (lines[:, 3] - lines[:, 1]) / run
    base = lines[:, 1] - slope * lines[:, 0]
    xs.append(_crossings(lines, slope, base))
    x = np.concatenate(xs)
    x = _apart(np.sort(x[(x > x0 + SAME) & (x < x1 - SAME)]))
    x = np.concatenate([[x0], x, [x1]])
    left, right = x[:-1], x[1:]
    middle = 0.5 * (left + right)
    active = (lines[:, 0] <= middle[:, None]) & (lines[:, 2] >= middle[:, None])
    height = middle[:, None] * slope + base
    active &= (height >= y0 - SAME) & (height <= y1 + SAME)
    order = np.argsort(np.where(active, height, np.inf), axis=1, kind="stable")
    count = active.sum(axis=1)
    most = int(count.max(initial=0))
    order = order[:, :most]
    below, above = order[:, :-1], order[:, 1:]
    good = np.arange(1, most) < count[:, None]
    row, column = np.nonzero(good)
    b, a = below[row, column], above[row, column]
    l, r = left[row], right[row]
    made = np.column_stack([l, r, l * slope[b] + base[b], r * slope[b] + base[b], l * slope[a] + base[a], r * slope[a] + base[a]])
    made[:, 2:] = np.clip(made[:, 2:], y0, y1)
    thick = made[:, 4] + made[:, 5] - made[:, 2] - made[:, 3] > 2.0 * SAME
    return made[thick]


def _apart(x: np.ndarray) -> np.ndarray:
    """Ascending numbers thinned out so that none is nearer than SAME to the one before."""
    if not len(x) or np.diff(x).min(initial=1.0) > SAME:
        return x
    kept = [x[0]]
    for value in x.tolist():
        if value - kept[-1] > SAME:
            kept.append(value)
    return np.array(kept)


def _crossings(lines: np.ndarray, slope: np.ndarray, base: np.ndarray) -> np.ndarray:
    i, j = np.triu_indices(len(lines), 1)
    apart = slope[i] - slope[j]
    sure = np.abs(apart) > 1e-6  # else parallel: they meet nowhere or lie on one line
    i, j = i[sure], j[sure]
    x = (base[j] - base[i]) / apart[sure]
    within = (x >= np.maximum(lines[i, 0], lines[j, 0])) & (x <= np.minimum(lines[i, 2], lines[j, 2]))
    return x[within]


def centres(trapezoids: np.ndarray) -> np.ndarray:
    """A point inside each, float64 (n, 2)."""
    return np.column_stack([0.5 * (trapezoids[:, 0] + trapezoids[:, 1]), trapezoids[:, 2:].mean(axis=1)])


def areas(trapezoids: np.ndarray) -> np.ndarray:
    t = trapezoids
    return 0.5 * (t[:, 1] - t[:, 0]) * (t[:, 4] + t[:, 5] - t[:, 2] - t[:, 3])


def outline_edges(triangles: np.ndarray) -> np.ndarray:
    """The edges (n, 4) of triangles (m, 3, 2) of one plane that aren't shared by two of them."""
    flat = np.round(triangles, 6)
    cross = (flat[:, 1, 0] - flat[:, 0, 0]) * (flat[:, 2, 1] - flat[:, 0, 1]) - (flat[:, 1, 1] - flat[:, 0, 1]) * (
        flat[:, 2, 0] - flat[:, 0, 0]
    )
    flat = np.where((cross < 0.0)[:, None, None], flat[:, ::-1], flat)
    edges: dict[tuple[float, ...], int] = {}
    for corners in flat.tolist():
        for k in range(3):
            a, b = corners[k - 1], corners[k]
            back = (b[0], b[1], a[0], a[1])
            if edges.get(back, 0) > 0:
                edges[back] -= 1
            else:
                key = (a[0], a[1], b[0], b[1])
                edges[key] = edges.get(key, 0) + 1
    return np.array([e for e, n in edges.items() if n > 0]).reshape(-1, 4)


def polygon_edges(polygon: cp.Polygon) -> np.ndarray:
    corners = np.asarray(polygon, dtype=np.float64).reshape(-1, 2)
    return np.concatenate([np.roll(corners, 1, axis=0), corners], axis=1)


def within_polygon(points: np.ndarray, polygon: cp.Polygon) -> np.ndarray:
    """bool (n,): which points (n, 2) lie in a convex counter-clockwise polygon."""
    good = np.ones(len(points), dtype=bool)
    for i in range(len(polygon)):
        (ax, ay), (bx, by) = polygon[i - 1], polygon[i]
        good &= (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax) >= 0.0
    return good


def within_triangles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """bool (n,): which points (n, 2) lie in any of the triangles (m, 3, 2), of either winding."""
    found = np.zeros(len(points), dtype=bool)
    if not len(points) or not len(triangles):
        return found
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    step = max(1, 500_000 // len(triangles))
    for first in range(0, len(points), step):
        p = points[first : first + step, None, :]
        s = [
            (q[:, 0] - o[:, 0]) * (p[..., 1] - o[:, 1]) - (q[:, 1] - o[:, 1]) * (p[..., 0] - o[:, 0])
            for o, q in ((a, b), (b, c), (c, a))
        ]
        inside = ((s[0] >= 0) & (s[1] >= 0) & (s[2] >= 0)) | ((s[0] <= 0) & (s[1] <= 0) & (s[2] <= 0))
        found[first : first + step] = inside.any(axis=1)
    return found


def join(trapezoids: np.ndarray) -> list[cp.Polygon]:
    """Fewer convex polygons that cover the same, and don't depend on where rectangles were halved: the union is cut
    once more, by its own outline alone."""
    pieces = _join(trapezoids)
    if len(pieces) < 2:
        return pieces
    ends = np.array([c for p in pieces for c in p])
    segments = _lines(np.concatenate([polygon_edges(p) for p in pieces]))
    if len(segments) > 6 * CROWDED:
        return pieces
    again = _strips(segments, *ends.min(axis=0).tolist(), *ends.max(axis=0).tolist())
    points = centres(again)
    inside = np.zeros(len(points), dtype=bool)
    for p in pieces:
        inside |= within_polygon(points, p)
    return _join(again[inside])


def _join(trapezoids: np.ndarray) -> list[cp.Polygon]:
    """Stacked ones first, then neighbouring strips while the outline stays convex."""
    if not len(trapezoids):
        return []
    order = np.lexsort((trapezoids[:, 2] + trapezoids[:, 3], trapezoids[:, 1], trapezoids[:, 0]))
    stacked: list[list[float]] = []
    for t in trapezoids[order].tolist():
        if stacked:
            s = stacked[-1]
            if s[0] == t[0] and s[1] == t[1] and abs(s[4] - t[2]) < 3 * SAME and abs(s[5] - t[3]) < 3 * SAME:
                s[4], s[5] = t[4], t[5]
                continue
        stacked.append(t)
    # Open to the right, by the x where they end: (bottom chain, top chain) of corners.
    growing: dict[float, list[tuple[list[cp.Point], list[cp.Point]]]] = {}
    for x0, x1, b0, b1, t0, t1 in stacked:
        bottom, top = [(x0, b0), (x1, b1)], [(x0, t0), (x1, t1)]
        candidates = growing.get(x0, [])
        for n, (below, above) in enumerate(candidates):
            if abs(below[-1][1] - b0) < SAME and abs(above[-1][1] - t0) < SAME:
                if _bends(below, bottom[1]) >= -SAME and _bends(above, top[1]) <= SAME:
                    bottom, top = _prolong(below, bottom[1]), _prolong(above, top[1])
                    del candidates[n]
                break
        growing.setdefault(x1, []).append((bottom, top))
    done = [piece for pieces in growing.values() for piece in pieces]
    return [p for bottom, top in done if len(p := cp.hull(bottom + top)) > 2]


def _bends(chain: list[cp.Point], p: cp.Point) -> float:
    """The turn at a chain's last corner towards p, as an area per length: positive to the left."""
    (ax, ay), (bx, by) = chain[-2], chain[-1]
    return ((bx - ax) * (p[1] - by) - (by - ay) * (p[0] - bx)) / (p[0] - ax)


def _prolong(chain: list[cp.Point], p: cp.Point) -> list[cp.Point]:
    return [*(chain[:-1] if abs(_bends(chain, p)) < 1e-6 else chain), p]
