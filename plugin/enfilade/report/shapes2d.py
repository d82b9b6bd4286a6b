# SPDX-License-Identifier: GPL-3.0-or-later
"""Small convex geometry for drawing: sections, hulls, clipping, offsets, areas.

Nothing here decides what is visible; it only draws what was decided. Points are float64 (n, 2) in metres.
"""

from __future__ import annotations

import math

import numpy as np

# Two plan points closer than this are one point on paper [metres]; a tenth of a millimetre is invisible at any scale
# a building is drawn in.
SAME_POINT = 1e-4


def following(points: np.ndarray) -> np.ndarray:
    """Each corner's next, the first after the last."""
    return np.concatenate((points[1:], points[:1]))


def hull(points: np.ndarray) -> np.ndarray:
    """Convex hull, counter-clockwise, collinear points dropped (Andrew's monotone chain). (n, 2) -> (k, 2)."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 3:
        return points
    listed = sorted({(round(float(x), 7), round(float(y), 7)) for x, y in points})
    if len(listed) < 3:
        return np.array(listed)

    def half(sequence):
        chain: list[tuple[float, float]] = []
        for p in sequence:
            while len(chain) >= 2:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 1e-12:
                    break
                chain.pop()
            chain.append(p)
        return chain

    lower, upper = half(listed), half(reversed(listed))
    return np.array(lower[:-1] + upper[:-1])


def section(vertices: np.ndarray, z: float) -> np.ndarray:
    """Horizontal section of the convex hull of `vertices` (n, 3) at height z: a convex polygon (k, 2), k = 0 when missed.

    Every segment between a vertex above and one below is cut; the hull of the cuts is the section, whatever the faces.
    """
    vertices = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    if not np.isfinite(vertices).all():
        vertices = vertices[np.isfinite(vertices).all(axis=1)]
    if len(vertices) < 3 or not (vertices[:, 2].min() <= z <= vertices[:, 2].max()):
        return np.zeros((0, 2))
    above, below = vertices[vertices[:, 2] > z], vertices[vertices[:, 2] < z]
    cuts = [vertices[vertices[:, 2] == z][:, :2]]
    if len(above) and len(below):
        if len(above) * len(below) > 250_000:  # a very round cell: its outline hardly changes when thinned out
            above, below = above[:: 1 + len(above) // 500], below[:: 1 + len(below) // 500]
        t = (z - below[:, None, 2]) / (above[None, :, 2] - below[:, None, 2])
        cuts.append((below[:, None, :2] + t[..., None] * (above[None, :, :2] - below[:, None, :2])).reshape(-1, 2))
    return hull(np.concatenate(cuts))


def polygon_section(polygon: np.ndarray, z: float) -> np.ndarray | None:
    """Where a planar polygon (k, 3) crosses height z: the two ends (2, 2) of a segment, or None."""
    cut = section(polygon, z)
    if len(cut) < 2:
        return None
    if len(cut) == 2:
        return cut
    far = ((cut[:, None] - cut[None]) ** 2).sum(axis=2)  # a polygon lying in the plane: its longest diagonal
    i, j = np.unravel_index(int(far.argmax()), far.shape)
    return cut[[i, j]]


def area(polygon: np.ndarray) -> float:
    """Signed area, positive counter-clockwise [m2]."""
    if len(polygon) < 3:
        return 0.0
    q = polygon - polygon[0]
    x, y = q[:, 0], q[:, 1]
    return 0.5 * float(np.dot(x, following(y)) - np.dot(y, following(x)))


def centroid(polygon: np.ndarray) -> np.ndarray:
    """Centre of mass; the mean of the corners for degenerate polygons."""
    a = area(polygon)
    if abs(a) < 1e-9:
        return polygon.mean(axis=0)
    q = polygon - polygon[0]
    n = following(q)
    cross = q[:, 0] * n[:, 1] - n[:, 0] * q[:, 1]
    return polygon[0] + ((q + n) * cross[:, None]).sum(axis=0) / (6.0 * a)


def hull_volume(vertices: np.ndarray) -> float:
    """Volume of the convex hull of (n, 3) points [m3]: section areas are quadratic between vertex heights, so Simpson's
    rule on each layer is exact."""
    vertices = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    if len(vertices) < 4:
        return 0.0
    heights = np.unique(np.round(vertices[:, 2], 6))
    if len(heights) > 64:  # curved cells: layers finer than this add nothing to two decimals
        heights = np.linspace(heights[0], heights[-1], 65)
    total = 0.0
    for low, high in zip(heights[:-1], heights[1:], strict=False):
        thick = high - low
        inner = thick * 1e-6
        a, m, b = (abs(area(section(vertices, z))) for z in (low + inner, (low + high) / 2, high - inner))
        total += thick * (a + 4 * m + b) / 6
    return total


def clip(polygon: np.ndarray, point: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The part of a convex polygon where (p - point) . normal >= 0."""
    if len(polygon) == 0:
        return polygon
    side = (polygon - point) @ normal
    if (side >= 0).all():
        return polygon
    out = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if side[i] >= 0:
            out.append(polygon[i])
        if (side[i] > 0 > side[j]) or (side[i] < 0 < side[j]):
            t = side[i] / (side[i] - side[j])
            out.append(polygon[i] + t * (polygon[j] - polygon[i]))
    return np.array(out) if len(out) >= 3 else np.zeros((0, 2))


def offset(polygon: np.ndarray, distance: float) -> np.ndarray:
    """A counter-clockwise convex polygon grown by `distance`, corners mitred (sharp ones bevelled)."""
    n = len(polygon)
    if n < 3:
        return polygon
    edges = following(polygon) - polygon
    length = np.hypot(edges[:, 0], edges[:, 1])
    keep = length > SAME_POINT
    if keep.sum() < 3:
        return polygon
    polygon, edges, length = polygon[keep], edges[keep], length[keep]
    normal = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / length[:, None]
    out = []
    for i in range(len(polygon)):
        a, b = normal[i - 1], normal[i]
        cos = float(a @ b)
        if cos > -0.5:
            out.append(polygon[i] + (a + b) * distance / (1.0 + cos))
        else:
            out.extend((polygon[i] + a * distance, polygon[i] + b * distance))
    return np.array(out)


def contains(polygon: np.ndarray, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
    """Which points (m, 2) lie in a counter-clockwise convex polygon, at least `margin` from its edges. bool (m,)."""
    points = np.atleast_2d(points)
    if len(polygon) < 3:
        return np.zeros(len(points), dtype=bool)
    edges = following(polygon) - polygon
    length = np.maximum(np.hypot(edges[:, 0], edges[:, 1]), 1e-12)
    away = points[:, None, :] - polygon[None]
    return ((edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]) / length >= margin).all(axis=1)


# Edges of two cells of one room lie on one line when they are this near [metres]: cells come from exact cuts, written
# out and sectioned; a wall is 50 times thicker.
ON_ONE_LINE = 2e-3


def shared_edges(a: np.ndarray, b: np.ndarray) -> list[tuple[int, float, float]]:
    """Where edges of b run along edges of a: (edge of a, from, to), as fractions of that edge."""
    found = []
    for i in range(len(a)):
        p, q = a[i], a[(i + 1) % len(a)]
        d = q - p
        n = math.hypot(*d)
        if n < SAME_POINT:
            continue
        u = d / n
        for j in range(len(b)):
            r, s = b[j], b[(j + 1) % len(b)]
            if max(abs(u[0] * (e - p)[1] - u[1] * (e - p)[0]) for e in (r, s)) > ON_ONE_LINE:
                continue
            t0, t1 = sorted((float(u @ (r - p)), float(u @ (s - p))))
            t0, t1 = max(t0, 0.0), min(t1, n)
            if t1 - t0 > SAME_POINT:
                found.append((i, t0 / n, t1 / n))
    return found


def outline(pieces: list[np.ndarray]) -> list[np.ndarray]:
    """The visible outline of convex pieces that tile one room: segments (2, 2), edges shared by two pieces left out."""
    segments = []
    boxes = [(p.min(axis=0) - 0.01, p.max(axis=0) + 0.01) for p in pieces]
    for i, piece in enumerate(pieces):
        gaps: dict[int, list[tuple[float, float]]] = {}
        for j, other in enumerate(pieces):
            if i == j or (boxes[i][0] > boxes[j][1]).any() or (boxes[j][0] > boxes[i][1]).any():
                continue
            for edge, t0, t1 in shared_edges(piece, other):
                gaps.setdefault(edge, []).append((t0, t1))
        for k in range(len(piece)):
            p, d = piece[k], piece[(k + 1) % len(piece)] - piece[k]
            at = 0.0
            for t0, t1 in sorted(gaps.get(k, [])) + [(1.0, 1.0)]:
                if t0 - at > 1e-6:
                    segments.append(np.array([p + at * d, p + t0 * d]))
                at = max(at, t1)
    return segments
