# SPDX-License-Identifier: GPL-3.0-or-later
"""Small exact-enough geometry for extractors: closed polyhedra, points in them, convex bodies cut by planes.

Plain numpy, float64, metres, z up. Nothing here decides visibility; it only shapes what the core is given. Where a
tolerance is needed it is named, has a unit and a reason.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Two corners nearer than this are one corner (metres): a tenth of the 1 mm that building models are drawn to.
WELD = 1e-4
# A body thinner than this is a flat polygon (metres): thinner than any wall or leaf, thicker than drawing noise.
FLAT = 2e-3


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products along the last axis, (..., 3). Same bits as numpy's own, which takes ten times as long for a few
    vectors: detection asks half a million times in a large building."""
    a, b = np.asarray(a), np.asarray(b)
    out = np.empty(np.broadcast(a, b).shape)
    ax, ay, az, bx, by, bz = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    np.subtract(ay * bz, az * by, out=out[..., 0])
    np.subtract(az * bx, ax * bz, out=out[..., 1])
    np.subtract(ax * by, ay * bx, out=out[..., 2])
    return out


def newell(points: np.ndarray) -> np.ndarray:
    """Area vector of a polygon, twice its area long. points: float64 (n, 3)."""
    count = len(points)
    a = points - points.sum(axis=0) / count
    return cross(a, a[[*range(1, count), 0]]).sum(axis=0)


def unit(vector: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


def weld(vertices: np.ndarray, faces: Sequence[Sequence[int]], tolerance: float = WELD):
    """Merges corners nearer than `tolerance` and drops faces that collapse. Returns vertices, faces."""
    vertices = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    if len(vertices) == 0:
        return vertices, []
    origin = vertices.min(axis=0)
    # Two grids, half a step apart, would be needed to catch every near pair; corners of modelled rooms are either
    # exactly shared or centimetres apart, so one grid with rounding does, after exact duplicates are gone.
    keys = np.round((vertices - origin) / tolerance).astype(np.int64)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    inverse = np.asarray(inverse).reshape(-1)
    merged = vertices[first]
    kept: list[list[int]] = []
    for face in faces:
        ring: list[int] = []
        for corner in face:
            index = int(inverse[corner])
            if not ring or ring[-1] != index:
                ring.append(index)
        if len(ring) > 1 and ring[0] == ring[-1]:
            ring.pop()
        if len(set(ring)) >= 3:
            kept.append(ring)
    used = sorted({i for ring in kept for i in ring})
    if len(used) < len(merged) and kept:
        renumber = {old: new for new, old in enumerate(used)}
        merged = merged[used]
        kept = [[renumber[i] for i in ring] for ring in kept]
    return np.ascontiguousarray(merged), kept


def open_edges(faces: Sequence[Sequence[int]]) -> int:
    """How many directed edges lack their opposite: 0 for a closed, consistently wound surface."""
    count: dict[tuple[int, int], int] = {}
    for face in faces:
        for a, b in zip(face, list(face[1:]) + [face[0]], strict=True):
            count[(a, b)] = count.get((a, b), 0) + 1
    return sum(1 for (a, b), n in count.items() if count.get((b, a), 0) != n)


def signed_volume(vertices: np.ndarray, faces: Sequence[Sequence[int]]) -> float:
    """Volume in m3; positive when the faces run counter-clockwise seen from outside."""
    origin = vertices.mean(axis=0)
    total = 0.0
    for a, b, c in triangles(faces):
        p, q, r = vertices[a] - origin, vertices[b] - origin, vertices[c] - origin
        total += float(np.dot(p, cross(q, r)))
    return total / 6.0


def triangles(faces: Sequence[Sequence[int]]) -> np.ndarray:
    """Fans of the faces, int64 (t, 3). Signed sums over them are right for non-convex faces too."""
    out = [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]
    return np.array(out, dtype=np.int64).reshape(-1, 3)


def planarise(vertices: np.ndarray, faces: Sequence[Sequence[int]], tolerance: float = WELD) -> list[list[int]]:
    """Splits faces that are out of plane by more than `tolerance` (metres) into triangles."""
    out: list[list[int]] = []
    for face in faces:
        if len(face) > 3:
            corners = vertices[face]
            normal = unit(newell(corners))
            if np.abs((corners - corners.mean(axis=0)) @ normal).max() > tolerance:
                out.extend([face[0], face[i], face[i + 1]] for i in range(1, len(face) - 1))
                continue
        out.append(list(face))
    return out


class Solid:
    """A closed polyhedron that can be asked about points and rays.

    vertices: float64 (n, 3); faces: counter-clockwise from outside. Immutable, so threads may share it.
    """

    def __init__(self, vertices: np.ndarray, faces: Sequence[Sequence[int]]):
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = [list(f) for f in faces]
        tri = triangles(self.faces)
        self.corners = self.vertices[tri]  # (t, 3, 3)
        self.low = self.vertices.min(axis=0)
        self.high = self.vertices.max(axis=0)
        e1, e2 = self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        self._edges = e1, e2, np.linalg.norm(e1, axis=1) * np.linalg.norm(e2, axis=1)
        normals = cross(e1, e2)
        lengths = np.linalg.norm(normals, axis=1)
        self.normals = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]

    def contains(self, points: np.ndarray) -> np.ndarray:
        """bool (m,) for points float64 (m, 3), by winding number: right for any orientation-consistent closed surface,
        and sensible for one with small holes. On the surface itself the answer is either."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        inside = np.zeros(len(points), dtype=bool)
        near = np.all((points >= self.low) & (points <= self.high), axis=1)
        if not near.any():
            return inside
        rel = self.corners[None, :, :, :] - points[near][:, None, None, :]  # (m, t, 3, 3)
        length = np.linalg.norm(rel, axis=3)
        a, b, c = rel[:, :, 0], rel[:, :, 1], rel[:, :, 2]
        la, lb, lc = length[:, :, 0], length[:, :, 1], length[:, :, 2]
        det = np.einsum("mti,mti->mt", a, cross(b, c))
        den = (
            la * lb * lc
            + np.einsum("mti,mti->mt", a, b) * lc
            + np.einsum("mti,mti->mt", b, c) * la
            + np.einsum("mti,mti->mt", c, a) * lb
        )
        winding = np.arctan2(det, den).sum(axis=1) / (2.0 * np.pi)
        inside[near] = winding > 0.5
        return inside

    def ray_hits(self, origin: np.ndarray, direction: np.ndarray) -> list[tuple[float, int]]:
        """(distance, triangle) of every crossing of the line origin + t * direction, all t, ascending."""
        return self.lines_hit(np.asarray(origin, dtype=np.float64)[None, :], direction)[0]

    def lines_hit(self, origins: np.ndarray, direction: np.ndarray) -> list[list[tuple[float, int]]]:
        """The same for parallel lines from origins float64 (m, 3): a list for each."""
        e1, e2, scale = self._edges
        p = cross(direction, e2)
        det = np.einsum("ij,ij->i", e1, p)
        ok = np.abs(det) > 1e-9 * np.where(scale > 0, scale, 1.0)  # relative: parallel to the triangle
        out: list[list[tuple[float, int]]] = [[] for _ in range(len(origins))]
        which = np.nonzero(ok)[0]
        if not len(which):
            return out
        inv = 1.0 / det[which]
        s = origins[:, None, :] - self.corners[which, 0]  # (m, t, 3)
        u = np.einsum("mti,ti->mt", s, p[which]) * inv
        q = cross(s, e1[which])
        v = (q @ direction) * inv
        t = np.einsum("mti,ti->mt", q, e2[which]) * inv
        edge = -1e-9  # relative barycentric slack: a ray through an edge meets both neighbours rather than none
        for m, i in zip(*np.nonzero((u >= edge) & (v >= edge) & (u + v <= 1.0 - edge)), strict=True):
            out[m].append((float(t[m, i]), int(which[i])))
        for hits in out:
            hits.sort()
        return out


def hull_2d(points: np.ndarray) -> np.ndarray:
    """Indices of the convex hull of float64 (n, 2), counter-clockwise, without collinear corners."""
    corners = points.tolist()  # plain floats: a hull of eight corners is made ten thousand times in a large building
    order = sorted(range(len(corners)), key=corners.__getitem__)
    scale = 0.0
    if corners:
        scale = max(max(c[k] for c in corners) - min(c[k] for c in corners) for k in (0, 1))
    slack = 1e-12 * scale * scale  # area below which three corners count as collinear: rounding, relative

    def half(sequence):
        chain: list[int] = []
        for i in sequence:
            bx, by = corners[i]
            while len(chain) >= 2:
                (ox, oy), (ax, ay) = corners[chain[-2]], corners[chain[-1]]
                if (ax - ox) * (by - oy) - (ay - oy) * (bx - ox) > slack:
                    break
                chain.pop()
            chain.append(i)
        return chain

    lower, upper = half(order), half(order[::-1])
    return np.array(lower[:-1] + upper[:-1], dtype=np.int64)


def plane_basis(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors u, v with u x v = normal."""
    helper = np.zeros(3)
    helper[int(np.argmin(np.abs(normal)))] = 1.0
    u = unit(cross(helper, normal))
    return u, cross(normal, u)


def convex_polygon(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Convex hull of points that lie about one plane, float64 (k, 3), counter-clockwise about `normal`, put exactly
    into the plane through their farthest point along the normal."""
    u, v = plane_basis(normal)
    flat = np.stack([points @ u, points @ v], axis=1)
    ring = hull_2d(flat)
    height = float((points @ normal).mean())
    return flat[ring, 0:1] * u + flat[ring, 1:2] * v + height * normal


def cut_convex(points: np.ndarray, normal: np.ndarray, offset: float) -> tuple[np.ndarray, np.ndarray | None]:
    """Cuts the convex hull of `points` (n, 3) with the plane normal.p = offset.

    Returns the corners of the part with normal.p <= offset (section corners included; empty when nothing is left) and
    the section polygon (k, 3), counter-clockwise about `normal`, or None when the plane doesn't cross it.
    """
    height = points @ normal - offset
    slack = 1e-9 * max(1.0, float(np.ptp(points, axis=0).max()))  # metres: rounding of the products above
    below, above = points[height < -slack], points[height > slack]
    on = points[np.abs(height) <= slack]
    pieces = [on]
    if len(below) and len(above):
        hb, ha = height[height < -slack], height[height > slack]
        t = hb[:, None] / (hb[:, None] - ha[None, :])
        pieces.append((below[:, None, :] + t[:, :, None] * (above[None, :, :] - below[:, None, :])).reshape(-1, 3))
    section_points = np.concatenate(pieces)
    section = None
    if len(section_points) >= 3:
        section = convex_polygon(section_points, normal)
        if len(section) < 3:
            section = None
    rest = [below, on]
    if section is not None:
        rest.append(section)
    return np.concatenate(rest), section


def support_polygon(points: np.ndarray, normal: np.ndarray, tolerance: float = 1e-3) -> np.ndarray | None:
    """The face of the hull of `points` farthest along `normal`, as a polygon, or None when that is an edge or a corner.
    tolerance: metres within which corners count as lying in the end face."""
    height = points @ normal
    top = points[height >= height.max() - tolerance]
    if len(top) < 3:
        return None
    polygon = convex_polygon(top, normal)
    return polygon if len(polygon) >= 3 else None


def flatness(points: np.ndarray) -> tuple[float, np.ndarray]:
    """Extent along the thinnest direction (metres) and that direction (unit)."""
    centred = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    normal = axes[2] if len(axes) > 2 else cross(axes[0], axes[1])
    along = centred @ normal
    return float(np.ptp(along)), unit(normal)


def polygon_area(polygon: np.ndarray) -> float:
    return 0.5 * float(np.linalg.norm(newell(polygon)))
