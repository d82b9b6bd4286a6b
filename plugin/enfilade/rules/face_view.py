# SPDX-License-Identifier: GPL-3.0-or-later
"""One face of a room in its own plane: what lies near it, cut into trapezoids within which nothing changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from . import convex_polygons as cp
from . import trapezoids
from .blockers import Blockers, free_edges
from .polyhedra import Face, Polyhedron
from .probing import Frame, Passage
from .shapes import cross as vec_cross

OFF_ROUND = 1.7e-5  # m: models are drawn in round numbers, and a turned one differs by rounding; no limit may lie on one
TOUCH = 0.05 + OFF_ROUND  # m: faces nearer than this touch
# m behind a face in which a wall counts as its backing; the core counts what is drawn that near as in the room
BACKING = 0.1 - OFF_ROUND
SCAN = 0.4 - OFF_ROUND  # m to both sides in which a wall is recognised that a face runs inside of (rooms drawn to its middle)
INTO_ROOM = 0.05 - OFF_ROUND  # m before the face: walls drawn a little into the room back it too
FLUSH = 1e-3 - OFF_ROUND  # m: what stands nearer than this to a face leaves no air between
SLIT = 4.7e-4  # m: gaps narrower than this are the rounding of models drawn to the millimetre
CHUNK = 256  # trapezoids looked at in one go


@dataclass
class Claim:
    """A neighbour's face that touches this one."""

    room: int
    gap: float  # m from this face to it
    triangles: np.ndarray  # (m, 3, 2) in this face's plane
    edges: np.ndarray  # (k, 4)


@dataclass
class Seen:
    """The face's trapezoids, and per trapezoid what stands before and behind it."""

    pieces: np.ndarray  # (n, 6)
    points: np.ndarray  # (n, 2), one inside each
    passage: np.ndarray  # bool (n,): a passage ends there
    ahead: np.ndarray  # m to the first blocker from INTO_ROOM before the face up to SCAN behind it, inf: none
    near: np.ndarray  # the same from the face itself on
    in_solid: np.ndarray  # bool (n,): the face runs inside a wall
    around: np.ndarray  # (m, 6): trapezoids beside the face


class FaceView:
    """One face of a room in its own plane, with what lies near it."""

    def __init__(self, vertices: np.ndarray, face: Face, blockers: Blockers) -> None:
        """vertices: float64 (n, 3), what the face's triangles index."""
        corners = vertices[face.triangles]  # (k, 3, 3)
        edges = np.diff(free_edges(corners), axis=1)[:, 0]  # not the diagonals: how a face is cut up is chance
        hint = edges[int(np.argmax(np.round(np.linalg.norm(edges, axis=1) + OFF_ROUND, 4)))] if len(edges) else None
        if hint is not None and hint @ (blockers.middle - corners[0, 0]) < 0.0:
            hint = -hint  # towards the building's middle, however it is turned
        self.frame = Frame.along(face.normal, face.normal * face.d, hint)
        self.flat = self.frame.local(corners.reshape(-1, 3)).reshape(-1, 3, 3)[:, :, :2]
        points = self.flat.reshape(-1, 2)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.is_empty = bool((self.high - self.low < SLIT).any())
        self._passages: list[cp.Polygon] = []
        self._edges = [trapezoids.outline_edges(self.flat)]
        if not self.is_empty:
            self._take(corners.reshape(-1, 3), blockers)

    def _take(self, points: np.ndarray, blockers: Blockers) -> None:
        low, high = points.min(axis=0) - SCAN, points.max(axis=0) + SCAN
        chosen = blockers.near(low, high)
        local = self.frame.local(blockers.triangles[chosen].reshape(-1, 3)).reshape(-1, 3, 3)
        normals = vec_cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        least, most = local.min(axis=1), local.max(axis=1)
        useful = (least[:, 2] <= SCAN) & (most[:, 2] >= -SCAN)
        useful &= np.abs(normals[:, 2]) > np.maximum(1e-6 * np.abs(normals).max(axis=1), 1e-10)  # else seen edge-on
        useful &= (least[:, :2] <= self.high).all(axis=1) & (most[:, :2] >= self.low).all(axis=1)
        chosen, local, normals = chosen[useful], local[useful], normals[useful]
        self.blockers = local
        self.looks_along = normals[:, 2] > 0.0
        self.owner = blockers.owner[chosen]
        self.planes = depth_planes(local, normals)
        self.holes: list[tuple[np.ndarray, cp.Polygon]] = []  # (which of the blockers, where they are cut away)
        sheets, member = np.unique(blockers.sheets[chosen], return_inverse=True)
        edges = [blockers.edges_of(sheet) for sheet in sheets.tolist()]
        if edges:
            self._edges.append(self.frame.local(np.concatenate(edges).reshape(-1, 3)).reshape(-1, 2, 3)[:, :, :2].reshape(-1, 4))
        for n, sheet in enumerate(sheets.tolist()):
            for hole in blockers.holes_of_sheet(sheet):
                if (hole.low <= high).all() and (hole.high >= low).all():
                    polygon = self._section(hole, *blockers.plane_of(sheet))
                    if len(polygon) > 2:
                        self.holes.append((np.nonzero(member == n)[0], polygon))
                        self._edges.append(trapezoids.polygon_edges(polygon))
        slanted = self.planes[:, :2].any(axis=1)
        if slanted.any():
            for depth in (-SCAN, -INTO_ROOM, -FLUSH, FLUSH, INTO_ROOM, BACKING, SCAN):
                self._edges.append(at_depth(local[slanted], depth))

    def _section(self, hole: Passage, normal: np.ndarray, d: float) -> cp.Polygon:
        """Where a void's prism, its surface included (0.1 mm), meets a sheet's plane: in this face's plane."""
        corners = hole.outer
        height = corners @ normal - d
        k = len(corners) // 2
        ring = np.arange(k)
        pairs = np.concatenate(
            [
                np.column_stack([ring, np.roll(ring, -1)]),
                np.column_stack([ring + k, np.roll(ring, -1) + k]),
                np.column_stack([ring, ring + k]),
            ]
        )
        p, q = height[pairs[:, 0]], height[pairs[:, 1]]
        cut = (p < 0.0) != (q < 0.0)
        if not cut.any():
            return []
        t = (p[cut] / (p[cut] - q[cut]))[:, None]
        points = corners[pairs[cut, 0]] * (1.0 - t) + corners[pairs[cut, 1]] * t
        return cp.hull((x, y) for x, y, _ in self.frame.local(points))

    def add_passage(self, polygon: np.ndarray) -> None:
        """polygon: (k, 3), where a passage ends; taken when it lies in this face."""
        local = self.frame.local(polygon)
        if np.abs(local[:, 2]).max() < BACKING and abs(_normal_z(local)) > 0.9:
            outline = cp.grow(cp.hull((x, y) for x, y, _ in local), 1e-3)
            self._passages.append(outline)
            self._edges.append(trapezoids.polygon_edges(outline))

    def claims_of(self, j: int, solid: Polyhedron, normal: np.ndarray) -> list[Claim]:
        found = []
        for other in solid.faces:
            if other.normal @ normal > -0.9994:  # 2 degrees
                continue
            there = self.frame.local(solid.vertices[other.triangles.reshape(-1)]).reshape(-1, 3, 3)
            gap = float(there[:, :, 2].mean())
            if abs(gap) > TOUCH:
                continue
            flat = there[:, :, :2]
            if (flat.min(axis=(0, 1)) > self.high).any() or (flat.max(axis=(0, 1)) < self.low).any():
                continue
            found.append(Claim(j, gap, flat, trapezoids.outline_edges(flat)))
        return found

    def look(self, more: list[np.ndarray], box: tuple[np.ndarray, np.ndarray] | None = None) -> Seen:
        """more: further edges (k, 4) to cut by; box: low and high (2,) of what is cut, if not the face's own bounds."""
        low, high = box or (self.low, self.high)
        pieces = trapezoids.decompose(np.concatenate([*self._edges, *more]), low, high)
        points = trapezoids.centres(pieces)
        own = trapezoids.within_triangles(points, self.flat)
        around = pieces[~own]
        pieces, points = pieces[own], points[own]
        passage = np.zeros(len(points), dtype=bool)
        for polygon in self._passages:
            passage |= trapezoids.within_polygon(points, polygon)
        ahead = np.full(len(points), np.inf)
        near, leaving, behind = ahead.copy(), np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
        if len(self.blockers):
            for part, some in near_triangles(points, self.blockers):
                ahead[part], near[part], leaving[part], behind[part] = self._depths(points[part], some)
        return Seen(pieces, points, passage, ahead, near, leaving & np.isfinite(near) & behind, around)

    def _depths(self, points: np.ndarray, some: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """ahead, near, whether the latter is seen from inside, and whether a face of its product lies behind that looks back, among some
        blockers."""
        x, y = points[:, :1], points[:, 1:]
        over = covers(points, self.blockers[some])
        for which, polygon in self.holes:
            cut = np.isin(some, which)
            if cut.any():
                gone = trapezoids.within_polygon(points, polygon)
                over[np.ix_(gone, cut)] = False
        planes = self.planes[some]
        t = planes[:, 0] * x + planes[:, 1] * y + planes[:, 2]
        good = over & (t <= SCAN)
        ahead = np.where(good & (t >= -INTO_ROOM), t, np.inf).min(axis=1)
        nearest = np.where(good & (t >= -FLUSH), t, np.inf)
        first = nearest.argmin(axis=1)
        owner, looks_along = self.owner[some], self.looks_along[some]
        behind = over & (t >= -SCAN) & (t < INTO_ROOM) & ~looks_along & (owner == owner[first][:, None])
        return ahead, nearest[np.arange(len(points)), first], looks_along[first], behind.any(axis=1)


def near_triangles(points: np.ndarray, triangles: np.ndarray) -> Iterator[tuple[slice, np.ndarray]]:
    """Slices of CHUNK points (n, 2), and which of the triangles (m, 3, >=2) have bounds that meet theirs, where any have: trapezoids
    come in the order that they stand in, so few do."""
    low, high = triangles[:, :, :2].min(axis=1), triangles[:, :, :2].max(axis=1)
    for first in range(0, len(points), CHUNK):
        part = slice(first, first + CHUNK)
        some = np.nonzero((low <= points[part].max(axis=0)).all(axis=1) & (high >= points[part].min(axis=0)).all(axis=1))[0]
        if len(some):
            yield part, some


def covers(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """bool (n, m): which triangles (m, 3, >=2) points (n, 2) lie in, of either winding."""
    x, y = points[:, :1], points[:, 1:]
    sides = []
    for k in range(3):
        a, b = triangles[:, k], triangles[:, (k + 1) % 3]
        sides.append((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0]))
    return ((sides[0] >= 0) & (sides[1] >= 0) & (sides[2] >= 0)) | ((sides[0] <= 0) & (sides[1] <= 0) & (sides[2] <= 0))


def at_depth(triangles: np.ndarray, depth: float) -> np.ndarray:
    """Segments (k, 4) along which triangles (m, 3, 3) pass a depth."""
    height = triangles[:, :, 2] - depth
    passing = (height.min(axis=1) < 0.0) & (height.max(axis=1) > 0.0)
    triangles, height = triangles[passing], height[passing]
    following, next_height = triangles[:, [1, 2, 0]], height[:, [1, 2, 0]]
    crosses = (height < 0.0) != (next_height < 0.0)  # two sides of each triangle
    p, q = height[crosses], next_height[crosses]
    a, b = triangles[crosses][:, :2], following[crosses][:, :2]
    return (a + (p / (p - q))[:, None] * (b - a)).reshape(-1, 4)


def depth_planes(triangles: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Depths of triangles (n, 3, 3) over a face: float64 (n, 3) of a, b, c in a x + b y + c; normals: theirs, of any length."""
    a, b = -normals[:, 0] / normals[:, 2], -normals[:, 1] / normals[:, 2]
    c = triangles[:, 0, 2] - a * triangles[:, 0, 0] - b * triangles[:, 0, 1]
    level = np.maximum(np.abs(a), np.abs(b)) < 1e-7  # parallel to the face, as most are: one depth
    a[level], b[level], c[level] = 0.0, 0.0, triangles[level, :, 2].mean(axis=1)
    return np.column_stack([a, b, c])


def _normal_z(local: np.ndarray) -> float:
    """The share of a polygon's normal along its frame's n, by Newell's sum."""
    following = np.roll(local, -1, axis=0)
    newell = vec_cross(local, following).sum(axis=0)
    length = float(np.linalg.norm(newell))
    return float(newell[2]) / length if length > 0.0 else 0.0
