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
from dataclasses import dataclass, replace

import numpy as np

from . import convex_polygons as cp
from . import trapezoids
from .air_layer import MARGIN, AirLayer, Exit
from .blockers import Blockers
from .face_view import BACKING, FLUSH, OFF_ROUND, SLIT, TOUCH, Claim, FaceView, Seen
from .polyhedra import Face, Polyhedron, inside
from .probing import Frame

GROW = 1e-3  # m outward on every portal: drawn triangles are single precision, and meshes are drawn to the millimetre
FULL = 0.7  # a hull that is open for less than this share is cut in two
EXACT = 6  # pieces up to which a part is given piece by piece; beyond, hulls stand in
MOST = 24  # portals from one face to one room; beyond, hulls of several parts stand in
CORNER = 2e-3  # m that rooms may be apart and still touch over a corner
FLATTEST = 113.0  # m sideways a metre of depth: flatter looks (half a degree) through the air behind a face aren't followed,
FAR = 3.0  # nor is one farther than this, m


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
    followed: bool = True  # False: so much is drawn behind the face that the air there counts as leading outdoors


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
        around = _near(i, lows, highs, MARGIN)
        neighbours = _near(i, lows, highs, TOUCH)
        for face in solid.faces:
            result += _open_parts(i, face, solids, neighbours, [i, *around], blockers, ends[i])
        if progress is not None and progress((i + 1) / len(solids)) is False:
            break
    # A look over a corner crosses both rooms' faces: the portal belongs on the one whose plane parts the rooms. Where neither
    # does, each is open to the outdoors there.
    parting = [p for p in result if p.over_corner and not p.astride]
    astride = [p for p in result if p.astride and not any(_same_corner(p, q) for q in parting)]
    outdoors = [replace(p, room=room, other=-1, astride=False) for p in astride for room in (p.room, p.other)]
    return [p for p in result if not p.astride] + outdoors


def _near(i: int, lows: np.ndarray, highs: np.ndarray, reach: float) -> list[int]:
    """The other rooms whose bounds come as near to room i's."""
    near = (lows <= highs[i] + reach).all(axis=1) & (highs >= lows[i] - reach).all(axis=1)
    return [j for j in np.nonzero(near)[0].tolist() if j != i]


def _same_corner(part: OpenPart, other: OpenPart) -> bool:
    """Whether `other` stands for `part`: between the same rooms, and all along it."""
    if {part.room, part.other} != {other.room, other.other}:
        return False
    low, high = other.polygon.min(axis=0) - 1.5 * BACKING, other.polygon.max(axis=0) + 1.5 * BACKING
    return bool((part.polygon >= low).all() and (part.polygon <= high).all())


def _open_parts(
    i: int,
    face: Face,
    solids: list[Polyhedron],
    neighbours: list[int],
    around: list[int],
    blockers: Blockers,
    ends: list[np.ndarray],
) -> list[OpenPart]:
    """Those of one face of room i. neighbours: the rooms that may touch it; around: all rooms near, itself too."""
    view = FaceView(solids[i].vertices, face, blockers)
    if view.is_empty:
        return []
    for polygon in ends:
        view.add_passage(polygon)
    claims = [c for j in neighbours for c in view.claims_of(j, solids[j], face.normal)]
    edges = [c.edges for c in claims]
    seen = view.look(edges)
    if not len(seen.pieces):
        return []
    result: list[OpenPart] = []
    limits = _convex(view.flat)
    for claim in claims:
        if claim.room < i:
            continue  # told from the other side
        # Inside a wall (rooms drawn to its middle): what comes next ahead is a face that looks away, and something lies
        # behind; else a wall closes the view only where it stands right at the interface.
        free = trapezoids.within_triangles(seen.points, claim.triangles)
        free &= ~seen.passage & ~seen.in_solid & ~(seen.near <= max(claim.gap, 0.0) + FLUSH)
        # Between faces that don't quite meet a look may slip sideways by as much.
        grow = max(GROW, abs(claim.gap))
        result += _parts(i, claim.room, view.frame, seen.pieces[free], claim.gap, face.normal, grow, [*limits, *_convex(claim.triangles)])
    free, stands_off = _unbacked(seen, claims)
    part = seen.pieces[stands_off]
    ways = _ways_out(view, part, claims, i, {j: solids[j] for j in around}, blockers) if len(part) else []
    outdoors = [polygon for way in ways if way.target < 0 for polygon in _within_reach(way)]
    if outdoors:
        seen, free, slips = _look_within(view, claims, outdoors)
        free |= slips
    for j in around:
        held = free.copy()
        held[free] = inside(view.frame.world(np.column_stack([seen.points[free], np.full(free.sum(), CORNER)])), solids[j])
        if j != i and held.any():  # rooms that overlap: who leaves one there is in the other
            result += _parts(i, j, view.frame, seen.pieces[held], 0.0, face.normal, GROW, limits)
            free &= ~held
    exposed = _parts(i, -1, view.frame, seen.pieces[free], 0.0, face.normal, GROW, limits)
    followed = all(way.followed for way in ways)
    result += [replace(part, followed=followed) for part in exposed]
    for way in ways:
        if way.target >= 0:
            result += _over_corner(view, claims, way, i, solids, face.normal, limits)
    return result


def _ways_out(
    view: FaceView, part: np.ndarray, claims: list[Claim], i: int, rooms: dict[int, Polyhedron], blockers: Blockers
) -> list[Exit]:
    """Where the air behind a face of room i leads to in `part` (n, 6), the trapezoids whose backing stands off."""
    layer = AirLayer(view, part, BACKING, blockers, rooms)
    seen = view.look([*(c.edges for c in claims), layer.edges], (layer.low, layer.high))
    beside = np.zeros(len(seen.around), dtype=bool)
    free, stands_off = _unbacked(seen, claims)
    backed = stands_off & (seen.near <= BACKING)
    free, stands_off, backed = (np.concatenate([own, beside]) for own in (free, stands_off, backed))
    return layer.exits(np.concatenate([seen.pieces, seen.around]), stands_off, backed, free, i)


def _look_within(view: FaceView, claims: list[Claim], reach: list[cp.Polygon]) -> tuple[Seen, np.ndarray, np.ndarray]:
    """The face cut by `reach` too; which trapezoids are unbacked, and which have their backing stand off and lie within reach."""
    seen = view.look([*(c.edges for c in claims), *(trapezoids.polygon_edges(p) for p in reach)])
    free, stands_off = _unbacked(seen, claims)
    within = np.zeros(len(seen.pieces), dtype=bool)
    for polygon in reach:
        within |= trapezoids.within_polygon(seen.points, polygon)
    return seen, free, stands_off & within


def _over_corner(
    view: FaceView, claims: list[Claim], way: Exit, i: int, solids: list[Polyhedron], normal: np.ndarray, limits: list[cp.Polygon]
) -> list[OpenPart]:
    """What the air behind a face opens to a room beside it: one polygon, so that it lies at that room too."""
    seen, _, slips = _look_within(view, claims, _within_reach(way))
    for claim in claims:
        if claim.room == way.target:  # the face is open to it there already
            slips &= ~trapezoids.within_triangles(seen.points, claim.triangles)
    pieces = [p for p in trapezoids.join(seen.pieces[slips]) if cp.width(p) > SLIT]
    if not pieces:
        return []
    part = _part(i, way.target, view.frame, cp.hull(q for p in pieces for q in p), pieces, 0.0, normal, GROW, limits)
    places = trapezoids.centres(way.pieces)
    inward = view.frame.world(np.column_stack([places, np.full(len(places), -2.0 * CORNER)]))
    part.over_corner, part.astride = True, bool(inside(inward, solids[way.target]).any())
    return [part]


def _unbacked(seen: Seen, claims: list[Claim]) -> tuple[np.ndarray, np.ndarray]:
    """Which of a face's own trapezoids nothing stands behind; and which have their backing stand off them, be it another room."""
    own, backed = ~seen.passage & ~seen.in_solid, seen.ahead <= BACKING
    for claim in claims:
        touched = trapezoids.within_triangles(seen.points, claim.triangles)
        if claim.gap > FLUSH:
            backed |= touched
        else:
            own &= ~touched
    free = own & ~backed
    return free, own & ~free & (np.abs(seen.ahead) > FLUSH) & (seen.near > FLUSH)


def _within_reach(way: Exit) -> list[cp.Polygon]:
    """Convex polygons that hold all of a face from where a look can slip out by `way`. Outdoors it must get as deep as BACKING
    over the exit: from as far away as it travels in the layer at that slope."""
    reach = min(FAR, FLATTEST * way.thickness)
    if way.target < 0 and way.thickness < BACKING:
        reach = min(reach, way.width * way.thickness / (BACKING - way.thickness))
    return [cp.grow(hull, reach + CORNER) for hull, _ in _cover(trapezoids.join(way.pieces))]


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
