# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a room's boundary is open air: rooms that touch without a wall, and faces that nothing drawn stands behind.

Each face of each room is cut into trapezoids by the outlines of everything near it (trapezoids.py): the other rooms'
faces, the passages that end there, and what is drawn of the shell (walls, slabs, roofs, ceilings, uncut, their voids
beside them). Within one trapezoid nothing changes, so one point answers for it, and gaps are found to the micrometre. A
trapezoid is backed when something of the shell lies close behind it, or when a passage ends there. What is left over is
open: to the room that touches there, else to the exterior, which is whatever no room claims. Open parts become virtual
portals, never smaller than what is open.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from . import convex_polygons as cp
from . import trapezoids
from .blockers import Blockers, free_edges
from .polyhedra import Face, Polyhedron, inside
from .probing import Frame, Passage

OFF_ROUND = 1.7e-5  # m: models are drawn in round numbers, and a turned one differs by rounding; no limit may lie on one
TOUCH = 0.05 + OFF_ROUND  # m: faces nearer than this touch
# m behind a face in which a wall counts as its backing; the core counts what is drawn that near as in the room
BACKING = 0.1 - OFF_ROUND
SCAN = 0.4 - OFF_ROUND  # m to both sides in which a wall is recognised that a face runs inside of (rooms drawn to its middle)
INTO_ROOM = 0.05 - OFF_ROUND  # m before the face: walls drawn a little into the room back it too
FLUSH = 1e-3 - OFF_ROUND  # m: what stands nearer than this to a face leaves no air between
SPREAD = 0.5  # m sideways that an open part reaches to where the backing stands off the face
SLIT = 4.7e-4  # m: gaps narrower than this are the rounding of models drawn to the millimetre
GROW = 1e-3  # m outward on every portal: drawn triangles are single precision, and meshes are drawn to the millimetre
FULL = 0.7  # a hull that is open for less than this share is cut in two
EXACT = 6  # pieces up to which a part is given piece by piece; beyond, hulls stand in
MOST = 24  # portals from one face to one room; beyond, hulls of several parts stand in
CORNER = 2e-3  # m that rooms may be apart and still touch over a corner
CHUNK = 256  # trapezoids looked at in one go
# radians off square in which looks past stand-off backing are tried
SLANTS = np.array([0.0, 0.06, 0.15, 0.35, 0.7, 1.05, 1.3, 1.45, 1.52, 1.55, 1.562])
FLAT = 1.4  # radians off square from which looks, being long, go each direction for itself, lest all that stands around is asked
REACH = 20.0  # sideways a unit of depth, that all around a place is open which is looked past
FAR = 3.0  # m sideways that such a look goes at most
LARGEST = 12  # triangles parallel to a face that such looks are held against before all others
TRIED = 80  # trapezoids of a face from which they are tried
ROUND = 12  # directions around, at each slant


@dataclass
class OpenPart:
    """A part of a room's boundary that is open."""

    room: int
    other: int  # the room that touches there, -1: the exterior
    polygon: np.ndarray  # float64 (k, 3), world, convex, on the room's face
    area: float  # of what is open of it, m2
    normal: np.ndarray  # out of `room`
    gap: float = 0.0  # m to the other room's face
    over_corner: bool = False
    astride: bool = False  # over a corner, with the other room on both sides of the face's plane
    width: float = 0.0  # m, of its widest open piece where that is narrowest


def find(
    solids: list[Polyhedron],
    blockers: Blockers,
    ends: list[list[np.ndarray]],
    progress: Callable[[float], bool] | None = None,
) -> list[OpenPart]:
    """Every open part; touching rooms are reported once, from the lower index. ends[room]: polygons (k, 3) where
    passages meet the room."""
    result: list[OpenPart] = []
    lows = np.array([s.low for s in solids]).reshape(-1, 3)
    highs = np.array([s.high for s in solids]).reshape(-1, 3)
    for i, solid in enumerate(solids):
        near = np.nonzero((lows <= solid.high + TOUCH).all(axis=1) & (highs >= solid.low - TOUCH).all(axis=1))[0]
        neighbours = [int(j) for j in near if j != i]
        for face in solid.faces:
            result += _open_parts(i, solid, face, solids, neighbours, blockers, ends[i])
        if progress is not None and progress((i + 1) / len(solids)) is False:
            break
    # A look over a corner crosses both rooms' faces: the portal belongs on the one whose plane parts the rooms.
    parting = [p for p in result if p.over_corner and not p.astride]
    return [p for p in result if not p.astride or not any(_same_corner(p, q) for q in parting)]


def _same_corner(part: OpenPart, other: OpenPart) -> bool:
    """Whether `other` stands for `part`: between the same rooms, and all along it."""
    if {part.room, part.other} != {other.room, other.other}:
        return False
    low, high = other.polygon.min(axis=0) - 1.5 * BACKING, other.polygon.max(axis=0) + 1.5 * BACKING
    return bool((part.polygon >= low).all() and (part.polygon <= high).all())


def _open_parts(
    i: int,
    solid: Polyhedron,
    face: Face,
    solids: list[Polyhedron],
    neighbours: list[int],
    blockers: Blockers,
    ends: list[np.ndarray],
) -> list[OpenPart]:
    view = FaceView(solid.vertices, face, blockers)
    if view.is_empty:
        return []
    for polygon in ends:
        view.add_passage(polygon)
    claims = [c for j in neighbours for c in view.claims_of(j, solids[j], face.normal)]
    seen = view.look([c.edges for c in claims])
    if not len(seen.pieces):
        return []
    result: list[OpenPart] = []
    limits = _convex(view.flat)
    claimed = np.zeros(len(seen.pieces), dtype=bool)
    for claim in claims:
        shared = trapezoids.within_triangles(seen.points, claim.triangles)
        claimed |= shared
        if claim.room < i:
            continue  # told from the other side
        # Inside a wall (rooms drawn to its middle): what comes next ahead is a face that looks away, and something lies
        # behind; else a wall closes the view only where it stands right at the interface.
        free = shared & ~seen.passage & ~seen.in_solid & ~(seen.near <= max(claim.gap, 0.0) + FLUSH)
        # Between faces that don't quite meet a look may slip sideways by as much.
        grow = max(GROW, abs(claim.gap))
        result += _parts(i, claim.room, view.frame, seen.pieces[free], claim.gap, face.normal, grow, [*limits, *_convex(claim.triangles)])
    own = ~claimed & ~seen.passage & ~seen.in_solid
    free = own & ~(seen.ahead <= BACKING)
    stands_off = own & ~free & (np.abs(seen.ahead) > FLUSH) & (seen.near > FLUSH)
    past = _past_backing(view, seen, stands_off, [solid, *(solids[j] for j in neighbours)], blockers)
    groups = _cover(past) if len(past) <= EXACT else [(cp.hull(q for p in past for q in p), past)]
    for hull, members in groups:
        result.append(_part(i, -1, view.frame, hull, members, 0.0, face.normal, GROW, limits))
    if free.any():
        stands_off = own & ~free & (np.abs(seen.ahead) > FLUSH)
        if stands_off.any():
            # A look that leaves where a wall stands off a little can slip sideways to where nothing stands.
            reach = [cp.grow(hull, SPREAD) for hull, _ in _cover(trapezoids.join(seen.pieces[free]))]
            seen = view.look([c.edges for c in claims] + [trapezoids.polygon_edges(p) for p in reach])
            claimed = np.zeros(len(seen.pieces), dtype=bool)
            for claim in claims:
                claimed |= trapezoids.within_triangles(seen.points, claim.triangles)
            own = ~claimed & ~seen.passage & ~seen.in_solid
            reached = np.zeros(len(seen.pieces), dtype=bool)
            for polygon in reach:
                reached |= trapezoids.within_polygon(seen.points, polygon)
            free = own & (~(seen.ahead <= BACKING) | (reached & (np.abs(seen.ahead) > FLUSH)))
        result += _parts(i, -1, view.frame, seen.pieces[free], 0.0, face.normal, GROW, limits)
    stands_off = own & ~free & (seen.ahead > FLUSH)
    if stands_off.any():
        for j in neighbours:
            beside, places = _cavities(view, seen, stands_off, solids[j])
            if len(places):
                around = cp.grow(cp.hull(places), SPREAD)
                found = _parts(i, j, view.frame, seen.pieces[stands_off][beside], 0.0, face.normal, GROW, [*limits, around])
                inward = view.frame.world(np.column_stack([places, np.full(len(places), -2.0 * CORNER)]))
                astride = bool(inside(inward, solids[j]).any())
                for part in found:
                    part.over_corner, part.astride = True, astride
                result += found
    return result


def _past_backing(
    view: FaceView, seen: _Seen, stands_off: np.ndarray, rooms: list[Polyhedron], blockers: Blockers
) -> list[cp.Polygon]:
    """Where, of the trapezoids whose backing stands off, a slanted look gets past it: air behind the face leads round the edge
    of a wall that ends short of the room's corner. Looks are tried from along the trapezoids' outlines; what lies between
    those that get past and end in none of the rooms is given, as far around as they reach sideways."""
    found: list[cp.Polygon] = []
    outlines = {k: cp.hull(map(tuple, _corners(seen.pieces[k]).tolist())) for k in np.nonzero(stands_off)[0].tolist()}
    which = [k for k, outline in outlines.items() if cp.width(outline) > SLIT]
    tried = which[:: max(1, -(-len(which) // TRIED))]
    boxes = []
    aside, depth, group = _looks()
    for k in tried:
        corners = _corners(seen.pieces[k])
        points = np.vstack([corners, 0.5 * (corners + np.roll(corners, 1, axis=0))])
        inward = seen.points[k] - points
        away = np.linalg.norm(inward, axis=1)[:, None]
        points += inward / np.maximum(away, 1e-12) * np.minimum(0.1 * away, CORNER)
        past = ~view.meets_backing(points, aside) & (depth > min(float(seen.near[k]), BACKING) + FLUSH)
        if not past.any():
            continue
        whence, way = np.nonzero(past)
        along = np.column_stack([aside[whence, way], np.ones(len(way))]) * depth[way, None]
        local = np.column_stack([points[whence], np.full(len(way), 1e-6)])
        start, end = view.frame.world(local), view.frame.world(local + along)
        reach = CORNER + min(float(seen.near[k]), BACKING) * REACH
        enough = float(np.ptp(corners, axis=0).max()) < reach  # one point opens all of it
        is_open = np.zeros(len(points), dtype=bool)
        for one in np.unique(group[way]):
            mine = np.nonzero((group[way] == one) & ~is_open[whence])[0]
            free = mine[~np.isfinite(blockers.first_hit(start[mine], end[mine]))]
            for room in rooms:
                free = free[~inside(end[free], room)]
            is_open[whence[free]] = True
            if is_open.all() or (enough and is_open.any()):
                break
        open_at = points[is_open]
        if len(open_at):
            around = cp.hull((x + i * reach, y + j * reach) for x, y in open_at for i in (-1, 1) for j in (-1, 1))
            boxes.append((open_at.min(axis=0) - reach, open_at.max(axis=0) + reach))
            part = cp.clip(outlines[k], around)
            if part and cp.width(part) > SLIT:
                found.append(part)
    # What wasn't tried is open like what is near.
    for k in sorted(set(which) - set(tried)) if boxes else ():
        corners = _corners(seen.pieces[k])
        low, high = corners.min(axis=0), corners.max(axis=0)
        if any((high >= a).all() and (low <= b).all() for a, b in boxes):
            found.append(outlines[k])
    return found


@cache
def _looks() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions of looks past backing: how far aside they go a unit of depth, (8, w, 2); how deep, m (w,); and which are asked together,
    int (w,). Each of a trapezoid's 8 points looks round from an angle of its own: gaps between studs are narrow."""
    turn = (np.arange(ROUND) + np.arange(8)[:, None, None] / 8.0) * (2.0 * np.pi / ROUND)
    turn = np.repeat(turn, len(SLANTS), axis=1).reshape(8, -1)
    slant = np.repeat(SLANTS, ROUND)
    tangent = np.tan(slant)
    aside = tangent[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=2)
    depth = np.minimum(BACKING + INTO_ROOM, FAR / np.maximum(tangent, 1e-9))
    return aside, depth, np.where(slant > FLAT, np.arange(len(slant)), -1)


def _corners(piece: np.ndarray) -> np.ndarray:
    """A trapezoid's corners, float64 (4, 2)."""
    x0, x1, b0, b1, t0, t1 = piece
    return np.array([(x0, b0), (x1, b1), (x1, t1), (x0, t0)])


def _cavities(
    view: FaceView, seen: _Seen, stands_off: np.ndarray, other: Polyhedron
) -> tuple[np.ndarray, list[cp.Point]]:
    """The air between a face and backing that stands off it belongs to nobody. Which of the trapezoids `stands_off`
    have such air that borders on another room (rooms that touch over a corner), and places where it does."""
    pieces, depth = seen.pieces[stands_off], seen.ahead[stands_off]
    x = pieces[:, [0, 1, 1, 0]] + np.array([-CORNER, CORNER, CORNER, -CORNER])
    y = pieces[:, [2, 3, 5, 4]] + np.array([-CORNER, -CORNER, CORNER, CORNER])
    beside = np.zeros(len(pieces), dtype=bool)
    places: list[cp.Point] = []
    corners = np.stack([x, y], axis=2)  # (n, 4, 2)
    flat = np.concatenate([corners, corners], axis=1)
    t = np.concatenate([np.zeros((len(pieces), 4)), np.repeat(depth[:, None], 4, axis=1)], axis=1)
    world = view.frame.world(np.concatenate([flat, t[:, :, None]], axis=2).reshape(-1, 3)).reshape(-1, 8, 3)
    near = (world.min(axis=1) < other.high).all(axis=1) & (world.max(axis=1) > other.low).all(axis=1)
    for k in np.nonzero(near)[0].tolist():
        ring = []
        for a, b in zip(corners[k], np.roll(corners[k], -1, axis=0), strict=True):
            steps = min(40, max(1, int(np.hypot(*(b - a)) / 0.1)))
            ring += [a + (b - a) * s / steps for s in range(steps)]
        outline = np.array(ring)
        for share in (0.1, 0.5, 0.9):
            points = view.frame.world(np.column_stack([outline, np.full(len(outline), share * depth[k])]))
            held = inside(points, other)
            if held.any():
                beside[k] = True
                places += [(float(p[0]), float(p[1])) for p in outline[held]]
    return beside, places


@dataclass
class _Claim:
    """A neighbour's face that touches this one."""

    room: int
    gap: float  # m from this face to it
    triangles: np.ndarray  # (m, 3, 2) in this face's plane
    edges: np.ndarray  # (k, 4)


@dataclass
class _Seen:
    """The face's trapezoids, and per trapezoid what stands before and behind it."""

    pieces: np.ndarray  # (n, 6)
    points: np.ndarray  # (n, 2), one inside each
    passage: np.ndarray  # bool (n,): a passage ends there
    ahead: np.ndarray  # m to the first blocker from INTO_ROOM before the face up to SCAN behind it, inf: none
    near: np.ndarray  # the same from the face itself on
    in_solid: np.ndarray  # bool (n,): the face runs inside a wall


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
        normals = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        least, most = local.min(axis=1), local.max(axis=1)
        useful = (least[:, 2] <= SCAN) & (most[:, 2] >= -SCAN)
        useful &= np.abs(normals[:, 2]) > np.maximum(1e-6 * np.abs(normals).max(axis=1), 1e-10)  # else seen edge-on
        useful &= (least[:, :2] <= self.high).all(axis=1) & (most[:, :2] >= self.low).all(axis=1)
        chosen, local, normals = chosen[useful], local[useful], normals[useful]
        self.blockers = local
        self.looks_along = normals[:, 2] > 0.0
        a, b = -normals[:, 0] / normals[:, 2], -normals[:, 1] / normals[:, 2]
        c = local[:, 0, 2] - a * local[:, 0, 0] - b * local[:, 0, 1]
        level = np.maximum(np.abs(a), np.abs(b)) < 1e-7  # parallel to the face, as most are: one depth
        a[level], b[level], c[level] = 0.0, 0.0, local[level, :, 2].mean(axis=1)
        self.planes = np.column_stack([a, b, c])
        close = np.nonzero(level & (c > 1e-5) & (c < BACKING))[0]  # what may back the face from a little way off
        self._close = close[np.argsort(-np.abs(normals[close, 2]))][:LARGEST]
        self.holes: list[tuple[np.ndarray, cp.Polygon]] = []  # (which of the blockers, where they are cut away)
        sheets, member = np.unique(blockers.sheets[chosen], return_inverse=True)
        for n, sheet in enumerate(sheets.tolist()):
            edges = self.frame.local(blockers.edges_of(sheet).reshape(-1, 3)).reshape(-1, 2, 3)
            self._edges.append(edges[:, :, :2].reshape(-1, 4))
            for hole in blockers.holes_of_sheet(sheet):
                if (hole.low <= high).all() and (hole.high >= low).all():
                    polygon = self._section(hole, *blockers.plane_of(sheet))
                    if len(polygon) > 2:
                        self.holes.append((np.nonzero(member == n)[0], polygon))
                        self._edges.append(trapezoids.polygon_edges(polygon))
        slanted = ~level
        if slanted.any():
            for depth in (-SCAN, -INTO_ROOM, -FLUSH, FLUSH, INTO_ROOM, BACKING, SCAN):
                self._edges.append(_at_depth(local[slanted], depth))

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

    def meets_backing(self, points: np.ndarray, aside: np.ndarray) -> np.ndarray:
        """bool (n, w): which looks from points (n, 2) of the face, going `aside` (n, w, 2) a unit of depth, meet one of the
        largest drawn triangles parallel to it: most do, and this tells it at a small part of what asking all that is drawn takes."""
        met = np.zeros(aside.shape[:2], dtype=bool)
        low, high = points.min(axis=0), points.max(axis=0)
        steepest = np.abs(aside).max()
        for k in self._close.tolist():
            depth, corners = self.planes[k, 2], self.blockers[k]
            reach = depth * steepest
            if (corners[:, :2].min(axis=0) > high + reach).any() or (corners[:, :2].max(axis=0) < low - reach).any():
                continue
            n, w = np.nonzero(~met)
            met[n, w] = _covers(points[n] + depth * aside[n, w], corners[None])[:, 0]
            if met.all():
                break
        return met

    def claims_of(self, j: int, solid: Polyhedron, normal: np.ndarray) -> list[_Claim]:
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
            found.append(_Claim(j, gap, flat, trapezoids.outline_edges(flat)))
        return found

    def look(self, more: list[np.ndarray]) -> _Seen:
        """more: further edges (k, 4) to cut by."""
        pieces = trapezoids.decompose(np.concatenate([*self._edges, *more]), self.low, self.high)
        points = trapezoids.centres(pieces)
        own = trapezoids.within_triangles(points, self.flat)
        pieces, points = pieces[own], points[own]
        passage = np.zeros(len(points), dtype=bool)
        for polygon in self._passages:
            passage |= trapezoids.within_polygon(points, polygon)
        ahead = np.full(len(points), np.inf)
        near, leaving, behind = ahead.copy(), np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
        if len(self.blockers):
            low, high = self.blockers[:, :, :2].min(axis=1), self.blockers[:, :, :2].max(axis=1)
            for first in range(0, len(points), CHUNK):
                part = slice(first, first + CHUNK)  # neighbours stand together: few triangles concern them
                some = np.nonzero(
                    (low <= points[part].max(axis=0)).all(axis=1) & (high >= points[part].min(axis=0)).all(axis=1)
                )[0]
                if len(some):
                    ahead[part], near[part], leaving[part], behind[part] = self._depths(points[part], some)
        return _Seen(pieces, points, passage, ahead, near, leaving & np.isfinite(near) & behind)

    def _depths(self, points: np.ndarray, some: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """ahead, near, whether the latter is seen from inside, and whether anything lies behind, among some blockers."""
        x, y = points[:, :1], points[:, 1:]
        covers = _covers(points, self.blockers[some])
        for which, polygon in self.holes:
            cut = np.isin(some, which)
            if cut.any():
                gone = trapezoids.within_polygon(points, polygon)
                covers[np.ix_(gone, cut)] = False
        planes = self.planes[some]
        t = planes[:, 0] * x + planes[:, 1] * y + planes[:, 2]
        behind = (covers & (t >= -SCAN) & (t < INTO_ROOM)).any(axis=1)
        good = covers & (t <= SCAN)
        ahead = np.where(good & (t >= -INTO_ROOM), t, np.inf).min(axis=1)
        nearest = np.where(good & (t >= -FLUSH), t, np.inf)
        first = nearest.argmin(axis=1)
        return ahead, nearest[np.arange(len(points)), first], self.looks_along[some[first]], behind


def _covers(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """bool (n, m): which triangles (m, 3, >=2) points (n, 2) lie in, of either winding."""
    x, y = points[:, :1], points[:, 1:]
    sides = []
    for k in range(3):
        a, b = triangles[:, k], triangles[:, (k + 1) % 3]
        sides.append((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0]))
    return ((sides[0] >= 0) & (sides[1] >= 0) & (sides[2] >= 0)) | ((sides[0] <= 0) & (sides[1] <= 0) & (sides[2] <= 0))


def _at_depth(triangles: np.ndarray, depth: float) -> np.ndarray:
    """Segments (k, 4) along which triangles (m, 3, 3) pass a depth."""
    height = triangles[:, :, 2] - depth
    triangles = triangles[(height.min(axis=1) < 0.0) & (height.max(axis=1) > 0.0)]
    found = []
    for tri in triangles:
        ends = []
        for k in range(3):
            a, b = tri[k], tri[(k + 1) % 3]
            p, q = a[2] - depth, b[2] - depth
            if (p < 0.0) != (q < 0.0):
                ends.append(a[:2] + (p / (p - q)) * (b[:2] - a[:2]))
        if len(ends) == 2:
            found.append(np.concatenate(ends))
    return np.array(found).reshape(-1, 4)


def _parts(
    i: int,
    j: int,
    frame: Frame,
    free: np.ndarray,
    gap: float,
    normal: np.ndarray,
    grow: float,
    limits: list[cp.Polygon],
) -> list[OpenPart]:
    """Convex polygons that cover the free trapezoids (n, 6). limits: convex polygons that nothing need reach beyond."""
    pieces = [p for p in trapezoids.join(free) if cp.width(p) > SLIT]
    result = []
    for hull, members in _cover(pieces):
        result.append(_part(i, j, frame, hull, members, gap, normal, grow, limits))
    return result


def _part(
    i: int,
    j: int,
    frame: Frame,
    hull: cp.Polygon,
    members: list[cp.Polygon],
    gap: float,
    normal: np.ndarray,
    grow: float,
    limits: list[cp.Polygon],
) -> OpenPart:
    """hull: what is open, given as a whole; members: the open pieces in it."""
    outline = cp.limit_corners(_within(cp.grow(hull, grow), limits), 16)
    points = frame.world(np.array([(x, y, 0.5 * gap) for x, y in outline]))
    area = sum(cp.area(p) for p in members)
    return OpenPart(i, j, points, area, normal, gap, width=max(cp.width(p) for p in members))


def _cover(pieces: list[cp.Polygon]) -> list[tuple[cp.Polygon, list[cp.Polygon]]]:
    """Convex polygons that cover the pieces, with the pieces that each stands for."""
    groups = _touching(pieces)
    if len(groups) > MOST:
        groups = [list(pieces)]
    return [found for group in groups for found in _hulls(group)]


def _hulls(pieces: list[cp.Polygon], depth: int = 0) -> list[tuple[cp.Polygon, list[cp.Polygon]]]:
    hull = cp.hull(p for piece in pieces for p in piece)
    filled = sum(cp.area(p) for p in pieces)
    if filled > 0.98 * cp.area(hull) or len(pieces) == 1:
        return [(hull, pieces)]
    if depth == 0 and len(pieces) <= 2 * EXACT:
        merged = cp.merge(pieces)
        if len(merged) <= EXACT:
            return [(p, [q for q in pieces if cp.contains(p, _centre(q), 1e-6)] or [p]) for p in merged]
    if depth >= 4 or filled > FULL * cp.area(hull):
        return [(hull, pieces)]
    centres = np.array([_centre(p) for p in pieces])
    best = None
    for axis in (0, 1):
        for cut in np.quantile(centres[:, axis], (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)):
            side = centres[:, axis] < cut + OFF_ROUND
            if not side.any() or side.all():
                continue
            halves = [[p for p, s in zip(pieces, side, strict=True) if s == wanted] for wanted in (True, False)]
            cost = sum(cp.area(cp.hull(q for p in half for q in p)) for half in halves)
            if best is None or cost < best[0]:
                best = (cost, halves)
    if best is None:
        return [(hull, pieces)]
    return [h for half in best[1] for h in _hulls(half, depth + 1)]


def _touching(pieces: list[cp.Polygon]) -> list[list[cp.Polygon]]:
    """Groups of pieces that hang together by more than a corner."""
    if len(pieces) < 2:
        return [list(pieces)] if pieces else []
    low = np.array([np.min(p, axis=0) for p in pieces]) - 1e-5
    high = np.array([np.max(p, axis=0) for p in pieces]) + 1e-5
    parent = list(range(len(pieces)))

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for i in range(len(pieces)):
        close = np.nonzero((low[i + 1 :] <= high[i]).all(axis=1) & (high[i + 1 :] >= low[i]).all(axis=1))[0] + i + 1
        grown = None
        for j in close.tolist():
            if root(i) == root(j):
                continue
            grown = grown or cp.grow(pieces[i], 1e-5)
            shared = cp.clip(pieces[j], grown)
            # A common edge of a millimetre: 1e-5 deep, as far as the growth.
            if shared and cp.area(shared) > 1e-8:
                parent[root(j)] = root(i)
    groups: dict[int, list[cp.Polygon]] = {}
    for k, piece in enumerate(pieces):
        groups.setdefault(root(k), []).append(piece)
    return list(groups.values())


def _centre(polygon: cp.Polygon) -> cp.Point:
    return (sum(p[0] for p in polygon) / len(polygon), sum(p[1] for p in polygon) / len(polygon))


def _within(outline: cp.Polygon, limits: list[cp.Polygon]) -> cp.Polygon:
    for limit in limits:
        outline = cp.clip(outline, limit) or outline
    return cp.hull(outline)  # clipping along a common edge leaves corners twice


def _convex(flat: np.ndarray) -> list[cp.Polygon]:
    """A face's outline when it is convex, else nothing."""
    whole = cp.hull((p[0], p[1]) for t in flat for p in t)
    total = sum(abs(cp.area(t.tolist())) for t in flat)
    return [whole] if len(whole) > 2 and cp.area(whole) - total <= 1e-6 * max(1.0, total) else []


def _normal_z(local: np.ndarray) -> float:
    """The share of a polygon's normal along its frame's n, by Newell's sum."""
    following = np.roll(local, -1, axis=0)
    newell = np.cross(local, following).sum(axis=0)
    length = float(np.linalg.norm(newell))
    return float(newell[2]) / length if length > 0.0 else 0.0
