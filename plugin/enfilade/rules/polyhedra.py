# SPDX-License-Identifier: GPL-3.0-or-later
"""From a triangle mesh to a closed polyhedron with planar faces, as a room needs it.

Triangles are welded, oriented outward and coplanar neighbours merged into faces, so that a box comes out as six
quadrilaterals. A mesh that can't be closed is told so; the caller falls back to its convex hull (larger: safe).
"""

from __future__ import annotations

from collections import defaultdict, deque
from dataclasses import dataclass

import numpy as np

from . import flat_holes
from .shapes import cross as vec_cross

WELD = 1e-4  # m: corners nearer than this are one corner. Models are drawn to 1 mm at best.
COPLANAR_ANGLE = 2e-3  # sine between neighbours of one face: 0.11 degrees
COPLANAR_DISTANCE = 2e-4  # m, between the corners of one face and its plane


@dataclass
class Face:
    """A planar face: unit normal n outward, n.x = d, and the triangles that make it up."""

    normal: np.ndarray  # float64 (3,)
    d: float
    triangles: np.ndarray  # int (k, 3) into the polyhedron's vertices


@dataclass
class Polyhedron:
    vertices: np.ndarray  # float64 (n, 3)
    triangles: np.ndarray  # int (m, 3), outward
    closed: bool
    faces: list[Face]
    loops: list[list[int]]  # the faces as simple polygons; a face with a hole gives several
    repaired: str = ""  # what had to be done, "" = nothing
    low: np.ndarray | None = None  # float64 (3,), bounds
    high: np.ndarray | None = None

    @property
    def volume(self) -> float:
        return signed_volume(self.vertices, self.triangles)


def build(vertices: np.ndarray, triangles: np.ndarray) -> Polyhedron:
    """vertices float64 (n, 3), triangles int (m, 3), in any order and orientation."""
    repaired = ""
    v, t = weld(vertices, triangles, WELD)
    if len(t) and not is_closed(t):
        t2 = split_at_t_junctions(v, t, 10 * WELD)
        if is_closed(t2):
            t, repaired = t2, "corners that lay on other faces' edges were joined to them"
        else:
            v3, t3 = weld(v, t, 20 * WELD)  # 2 mm
            t3 = split_at_t_junctions(v3, t3, 20 * WELD)
            if is_closed(t3):
                v, t, repaired = v3, t3, "gaps up to 2 mm were welded"
            elif (t4 := flat_holes.close(v, t2)) is not None and is_closed(t4):
                t, repaired = t4, "missing faces were put in, faces drawn twice or across it taken off"
    t, closed = orient(v, t)
    faces = merge_coplanar(v, t)
    loops = [loop for face in faces for loop in face_loops(v, face)]
    low, high = (v.min(axis=0), v.max(axis=0)) if len(v) else (np.zeros(3), np.zeros(3))
    return Polyhedron(v, t, closed, faces, loops, repaired, low, high)


def weld(vertices: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Joins corners within `tolerance` (by sorted sweep, so the grid's position doesn't matter); degenerate triangles go."""
    n = len(vertices)
    order = np.argsort(vertices[:, 0], kind="stable")
    target = np.full(n, -1)
    kept: list[int] = []
    recent: deque[int] = deque()
    for i in order:
        p = vertices[i]
        while recent and vertices[recent[0], 0] < p[0] - tolerance:
            recent.popleft()
        match = -1
        for k in recent:
            if np.abs(vertices[k] - p).max() <= tolerance:
                match = k
                break
        if match < 0:
            recent.append(i)
            match = i
            kept.append(i)
        target[i] = match
    kept.sort()
    index = np.full(n, -1)
    index[kept] = np.arange(len(kept))
    t = index[target[triangles]] if len(triangles) else triangles
    if len(t):
        good = (t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])
        t = t[good]
        # Two equal triangles back to back are a membrane inside the solid: both go.
        seen: dict[tuple[int, ...], list[int]] = defaultdict(list)
        for k, tri in enumerate(t.tolist()):
            seen[tuple(sorted(tri))].append(k)
        drop = [k for group in seen.values() if len(group) > 1 for k in (group if len(group) % 2 == 0 else group[1:])]
        t = np.delete(t, drop, axis=0)
    return vertices[kept], t


def is_closed(triangles: np.ndarray) -> bool:
    """Whether every edge belongs to an even number of triangles, two as a rule."""
    if len(triangles) < 4:
        return False
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    return bool((counts % 2 == 0).all())


def split_at_t_junctions(vertices: np.ndarray, triangles: np.ndarray, tolerance: float) -> np.ndarray:
    """Splits triangles whose open edges have other corners on them."""
    result = [tuple(t) for t in triangles.tolist()]
    for _ in range(200):
        count: dict[tuple[int, int], int] = defaultdict(int)
        for t in result:
            for k in range(3):
                count[_key(t[k], t[(k + 1) % 3])] += 1
        opened = {e for e, c in count.items() if c % 2}
        if not opened:
            break
        candidates = sorted({i for e in opened for i in e})
        points = vertices[candidates]
        changed = False
        for n, t in enumerate(result):
            for k in range(3):
                a, b, c = t[k], t[(k + 1) % 3], t[(k + 2) % 3]
                if _key(a, b) not in opened:
                    continue
                direction = vertices[b] - vertices[a]
                length = float(np.linalg.norm(direction))
                if length < tolerance:
                    continue
                along = (points - vertices[a]) @ direction / length
                away = np.linalg.norm(points - vertices[a] - np.outer(along / length, direction), axis=1)
                hits = [
                    candidates[h]
                    for h in np.nonzero((away < tolerance) & (along > tolerance) & (along < length - tolerance))[0]
                    if candidates[h] not in t
                ]
                if hits:
                    result[n] = (a, hits[0], c)
                    result.append((hits[0], b, c))
                    changed = True
                    break
            if changed:
                break
        if not changed:
            break
    return np.array(result, dtype=int).reshape(-1, 3)


def orient(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, bool]:
    """Consistent, outward orientation, and whether the mesh is closed. Shells inside others keep facing inward."""
    if not len(triangles):
        return triangles, False
    closed = is_closed(triangles)
    t = triangles.copy()
    users: dict[tuple[int, int], list[int]] = defaultdict(list)
    for n, tri in enumerate(t.tolist()):
        for k in range(3):
            users[_key(tri[k], tri[(k + 1) % 3])].append(n)
    shell = np.full(len(t), -1)
    shells = 0
    for seed in range(len(t)):
        if shell[seed] >= 0:
            continue
        shell[seed] = shells
        queue = deque([seed])
        while queue:
            n = queue.popleft()
            tri = t[n].tolist()
            for k in range(3):
                a, b = tri[k], tri[(k + 1) % 3]
                around = users[_key(a, b)]
                if len(around) != 2:
                    continue  # ambiguous: keep what the file says
                m = around[0] if around[1] == n else around[1]
                if shell[m] >= 0:
                    continue
                other = t[m].tolist()
                if (a, b) in [(other[i], other[(i + 1) % 3]) for i in range(3)]:
                    t[m] = t[m][::-1]
                shell[m] = shells
                queue.append(m)
        shells += 1
    for s in range(shells):
        mine = shell == s
        positive = signed_volume(vertices, t[mine]) > 0.0
        others = t[~mine]
        inside = False
        if shells > 1 and len(others):
            inside = abs(winding_number(vertices[t[mine][0, :1]], vertices, others)[0]) > 0.75
        if positive == inside:
            t[mine] = t[mine][:, ::-1]
    return t, closed


def signed_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    if not len(triangles):
        return 0.0
    a, b, c = (vertices[triangles[:, k]] - vertices[triangles[0, 0]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, vec_cross(b, c)).sum() / 6.0)


def winding_number(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Generalised winding number (Jacobson et al. 2013, by van Oosterom & Strackee's solid angle) of points (p, 3):
    1 inside, 0 outside, robust to small gaps."""
    result = np.empty(len(points))
    step = max(1, 2_000_000 // max(1, len(triangles)))
    for start in range(0, len(points), step):
        p = points[start : start + step, None, :]
        a, b, c = (vertices[triangles[:, k]][None] - p for k in range(3))
        la, lb, lc = (np.sqrt(np.einsum("ijk,ijk->ij", x, x)) for x in (a, b, c))
        numerator = np.einsum("ijk,ijk->ij", a, vec_cross(b, c))
        ab, bc, ca = (np.einsum("ijk,ijk->ij", x, y) for x, y in ((a, b), (b, c), (c, a)))
        denominator = la * lb * lc + ab * lc + bc * la + ca * lb
        result[start : start + step] = np.arctan2(numerator, denominator).sum(axis=1) / (2.0 * np.pi)
    return result


def inside(points: np.ndarray, solid: Polyhedron) -> np.ndarray:
    """bool (p,): which points lie in the polyhedron."""
    mask = ((points >= solid.low) & (points <= solid.high)).all(axis=1)
    if mask.any():
        mask[mask] = np.abs(winding_number(points[mask], solid.vertices, solid.triangles)) > 0.5
    return mask


def merge_coplanar(vertices: np.ndarray, triangles: np.ndarray) -> list[Face]:
    """Groups neighbouring triangles of one plane."""
    if not len(triangles):
        return []
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    cross = vec_cross(b - a, c - a)
    size = np.linalg.norm(cross, axis=1)
    normals = cross / np.maximum(size, 1e-300)[:, None]
    users: dict[tuple[int, int], list[int]] = defaultdict(list)
    for n, tri in enumerate(triangles.tolist()):
        for k in range(3):
            users[_key(tri[k], tri[(k + 1) % 3])].append(n)
    group = np.full(len(triangles), -1)
    faces: list[Face] = []
    for seed in np.argsort(-size, kind="stable").tolist():  # the largest triangle has the best normal
        if group[seed] >= 0:
            continue
        normal, d = normals[seed], float(normals[seed] @ a[seed])
        group[seed] = len(faces)
        members, queue = [seed], deque([seed])
        while queue:
            n = queue.popleft()
            tri = triangles[n].tolist()
            for k in range(3):
                for m in users[_key(tri[k], tri[(k + 1) % 3])]:
                    if group[m] >= 0:
                        continue
                    thin = size[m] < 1e-9  # slivers have no normal of their own
                    if not thin and (
                        normals[m] @ normal <= 0.0 or np.linalg.norm(vec_cross(normals[m], normal)) > COPLANAR_ANGLE
                    ):
                        continue
                    if np.abs(vertices[triangles[m]] @ normal - d).max() > COPLANAR_DISTANCE:
                        continue
                    group[m] = len(faces)
                    members.append(m)
                    queue.append(m)
        faces.append(Face(normal, d, triangles[sorted(members)]))
    return faces


def face_loops(vertices: np.ndarray, face: Face) -> list[list[int]]:
    """The face as simple polygons, counter-clockwise from outside: one where it has no hole, else convex pieces."""
    whole = _boundary(face.triangles.tolist())
    if whole is not None:
        return [whole]
    # A hole: join triangles while the piece stays convex, so that no piece has one.
    pieces = [list(t) for t in face.triangles.tolist()]
    merged = True
    while merged:
        merged = False
        edge_owner = {(p[i - 1], p[i]): n for n, p in enumerate(pieces) for i in range(len(p))}
        for n, p in enumerate(pieces):
            for i in range(len(p)):
                m = edge_owner.get((p[i], p[i - 1]))
                if m is None or m == n:
                    continue
                joined = _boundary([p, pieces[m]])
                if joined is not None and _is_convex(vertices, joined, face.normal):
                    pieces[n] = joined
                    del pieces[m]
                    merged = True
                    break
            if merged:
                break
    return pieces


def _boundary(polygons: list[list[int]]) -> list[int] | None:
    """The outline of polygons that share edges; None when it isn't one simple loop."""
    following: dict[int, int] = {}
    edges = {(p[i - 1], p[i]) for p in polygons for i in range(len(p))}
    for a, b in edges:
        if (b, a) not in edges:
            if a in following:
                return None
            following[a] = b
    if not following:
        return None
    start = min(following)
    loop = [start]
    while (after := following.get(loop[-1])) != start:
        if after is None or len(loop) > len(following):
            return None  # triangles that overlap or leave gaps have no single outline
        loop.append(after)
    return loop if len(loop) == len(following) else None


def _is_convex(vertices: np.ndarray, loop: list[int], normal: np.ndarray) -> bool:
    edges = np.diff(vertices[[*loop, loop[0]]], axis=0)
    return bool((vec_cross(edges[[-1, *range(len(loop) - 1)]], edges) @ normal > -1e-9).all())


def _key(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a < b else (b, a)
