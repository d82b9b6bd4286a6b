# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rooms a passage through a wall or slab joins, and the polygons where it meets them.

A passage is a convex cross-section swept along the axis through its host. From the middle of the host the rooms' faces
that look at it are searched outward on both sides, and each is projected along the axis into the cross-section: no
single probe can miss a room that the passage meets only in part. Rooms that overlap the void cut it off at their face;
rooms that begin beyond it are reached by prolonging it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from . import convex_polygons as cp
from .ifc_shapes import Shape
from .polyhedra import Polyhedron, inside
from .shapes import cross as vec_cross

REACH = 0.5  # m beyond host and void in which a room's face is looked for; a leaf's far side needs at least 0.28
PAST_HOST = 0.02  # m that a room's face may lie beyond the host's far side: rooms drawn to the wall's centre or over it
MIN_AREA = 2e-4  # m2 (1.4 cm squared): meets smaller than that are rounding of the model, not a view
MIN_WIDTH = 2e-3  # m: a strip narrower than this is a corner that touches, not a view
STANDS_OFF = 4.7e-4  # m between a room's face and its wall from which on a look slips in between; less is rounding to 1 mm
FARTHEST_SLIP = 0.5  # m sideways that such a look is followed
OVERLAPS = 0.05  # m beyond a room's face where another room still is that overlaps it; less far they touch (`touching.find`)
SHALLOW = 0.1  # m into the wall that looks needn't be followed: the core counts what is drawn that near as in the room


@dataclass
class Frame:
    """Right-handed frame: n along the passage, (u, v) across it."""

    origin: np.ndarray
    u: np.ndarray
    v: np.ndarray
    n: np.ndarray

    def __post_init__(self) -> None:
        self._axes = np.stack([self.u, self.v, self.n])

    @staticmethod
    def along(n: np.ndarray, origin: np.ndarray, hint: np.ndarray | None = None) -> Frame:
        """hint: a direction that u follows as far as it can; for upright hosts u is level."""
        n = n / np.linalg.norm(n)
        up = np.array([0.0, 0.0, 1.0])
        if abs(n[2]) < 0.9:
            u = vec_cross(up, n)
        else:
            reference = hint if hint is not None and np.linalg.norm(vec_cross(hint, n)) > 1e-6 else np.array([1.0, 0, 0])
            u = reference - n * (reference @ n)
        u = u / np.linalg.norm(u)
        return Frame(origin, u, vec_cross(n, u), n)

    def local(self, points: np.ndarray) -> np.ndarray:
        """(k, 3) world to (k, 3) of u, v, n."""
        return self.turned(points - self.origin)

    def turned(self, directions: np.ndarray) -> np.ndarray:
        """(k, 3) directions of the world in u, v, n."""
        return directions @ self._axes.T

    def world(self, points: np.ndarray) -> np.ndarray:
        return self.origin + points @ self._axes


@dataclass
class Passage:
    """section: convex polygon in the frame's (u, v). The void reaches over void[0]..void[1] along n, the host over
    host[0]..host[1]."""

    frame: Frame
    section: cp.Polygon
    void: tuple[float, float]
    host: tuple[float, float]
    cuts: bool = True  # whether the void takes anything away from its host
    wall: Shape | None = None  # the host, uncut

    def __post_init__(self) -> None:
        self.corners = self.frame.world(np.array([(x, y, t) for t in self.void for x, y in self.section]))
        self.low, self.high = self.corners.min(axis=0), self.corners.max(axis=0)

    @cached_property
    def outer(self) -> np.ndarray:
        """Corners of the void's prism 0.1 mm outside its surface, float64 (2 k, 3): one end's ring, then the other's."""
        ring = cp.grow(self.section, 1e-4)
        return self.frame.world(
            np.array([(x, y, t) for t in (self.void[0] - 1e-4, self.void[1] + 1e-4) for x, y in ring])
        )


@dataclass
class End:
    """Where a passage meets one room (room >= 0) or the outside (room = -1)."""

    room: int
    polygon: np.ndarray  # float64 (k, 3), world
    depth: float  # along n, of the point nearest the host's middle
    share: float  # of the section's area
    gap: float = 0.0  # m between the void and the room's face
    narrow: np.ndarray | None = None  # the polygon before it was widened for looks that slip in from beside; None: it wasn't


@dataclass
class Probe:
    low: list[End] = field(default_factory=list)  # on the side -n
    high: list[End] = field(default_factory=list)
    within: int = -1  # the room that holds the middle of the passage: a partition inside one room
    holding: list[int] = field(default_factory=list)  # all rooms that hold some of the middle


def probe(passage: Passage, rooms: list[Polyhedron], candidates: list[int] | None = None) -> Probe:
    """Finds both ends. rooms: indexed by room; candidates: which to look at (None: all, by bounds)."""
    frame, section = passage.frame, passage.section
    middle = 0.5 * (passage.host[0] + passage.host[1])
    reach = (min(passage.host[0], passage.void[0]) - REACH, max(passage.host[1], passage.void[1]) + REACH)
    corners = np.array([(x, y, t) for t in reach for x, y in section])
    box = frame.world(corners)
    low, high = box.min(axis=0) - 1e-3, box.max(axis=0) + 1e-3
    near = [
        i
        for i in (range(len(rooms)) if candidates is None else candidates)
        if (rooms[i].low <= high).all() and (rooms[i].high >= low).all()
    ]
    result = Probe()
    inner = _sample(section)
    for i in near:
        points = frame.world(np.column_stack([inner, np.full(len(inner), middle)]))
        share = inside(points, rooms[i]).mean()
        if share > 0.5:
            result.within = i
        if share > 0.0:
            result.holding.append(i)
    result.low = _side(passage, rooms, near, middle, reach[0], -1.0)
    result.high = _side(passage, rooms, near, middle, reach[1], 1.0)
    return result


def at_boundary(passage: Passage, rooms: list[Polyhedron], within: float = 0.25) -> Passage | None:
    """A passage whose middle lies inside these rooms (panes drawn a little into them), moved onto their boundary; None
    when that is farther than `within` metres: then it stands in a partition."""
    middle = 0.5 * (passage.host[0] + passage.host[1])
    shares: dict[float, float] = {}  # depth of the boundary -> area of the section that it covers
    for room in rooms:
        for face in room.faces:
            k = float(face.normal @ passage.frame.n)
            if abs(k) < 0.7:
                continue
            local = passage.frame.local(room.vertices[face.triangles.reshape(-1)])
            depth = float(local[:, 2].mean())
            # Positive: the face closes the room off on that side.
            if (depth - middle) * k < 0.0 or abs(depth - middle) > within:
                continue
            shared = sum(
                cp.area(piece)
                for tri in local.reshape(-1, 3, 3)
                if (piece := cp.clip(_counter_clockwise(tri), passage.section))
            )
            key = next((d for d in shares if abs(d - depth) < 0.02), depth)
            shares[key] = shares.get(key, 0.0) + shared
    good = [d for d, shared in shares.items() if shared > 0.3 * cp.area(passage.section)]
    if not good:
        return None
    depth = min(good, key=lambda d: abs(d - middle))
    return Passage(passage.frame, passage.section, (depth, depth), (depth, depth))


def _counter_clockwise(tri: np.ndarray) -> cp.Polygon:
    flat = [(float(p[0]), float(p[1])) for p in tri]
    return flat if cp.area(flat) >= 0.0 else flat[::-1]


def _side(
    passage: Passage, rooms: list[Polyhedron], near: list[int], middle: float, limit: float, sign: float
) -> list[End]:
    """Ends on one side; sign +1 looks along +n."""
    frame, section = passage.frame, passage.section
    section_area = cp.area(section)
    into_host = 0.5 * (passage.host[1] - passage.host[0]) + PAST_HOST
    # (distance from the middle, room, polygon in u v, plane as t = a u + b v + c)
    hits: list[tuple[float, int, list[cp.Polygon], tuple[float, float, float]]] = []
    for i in near:
        for face in rooms[i].faces:
            facing = float(face.normal @ frame.n) * sign
            if facing > -0.05:  # looks away, or is seen edge-on (3 degrees)
                continue
            k = float(face.normal @ frame.n)
            a = -float(face.normal @ frame.u) / k
            b = -float(face.normal @ frame.v) / k
            c = (face.d - float(face.normal @ frame.origin)) / k
            local = frame.local(rooms[i].vertices[face.triangles.reshape(-1)])
            if (sign * (local[:, 2] - limit) > 0.0).all():
                continue
            pieces: list[cp.Polygon] = []
            for tri in local.reshape(-1, 3, 3):
                piece = cp.clip(_counter_clockwise(tri), section)
                if len(piece) > 2 and cp.area(piece) > 1e-9:
                    pieces.append(piece)
            if not pieces:
                continue
            depths = [sign * (a * x + b * y + c - middle) for p in pieces for x, y in p]
            if max(depths) < -into_host or min(depths) > sign * (limit - middle):
                continue
            hits.append((min(depths), i, cp.merge(pieces), (a, b, c)))
    hits.sort(key=lambda h: (h[0], h[1]))
    ends: dict[int, list[tuple[list[cp.Polygon], tuple[float, float, float], float]]] = {}
    taken: list[tuple[int, cp.Polygon]] = []

    def shares(j: int, i: int, piece: cp.Polygon, plane: tuple[float, float, float]) -> bool:
        """Whether room j, whose nearer face lies before a piece of room i's, holds what is behind that too: then both look through."""
        if j == i:
            return False
        x, y = np.mean(piece, axis=0).tolist()
        behind = plane[0] * x + plane[1] * y + plane[2] + sign * OVERLAPS
        return bool(inside(frame.world(np.array([[x, y, behind]])), rooms[j])[0])

    for nearest, i, pieces, plane in hits:
        whole = sum(cp.area(p) for p in pieces)
        covered = ((j, q) for p in pieces for j, t in taken if (q := cp.clip(p, t)))
        hidden = sum(abs(cp.area(q)) for j, q in covered if not shares(j, i, q, plane))
        if whole - hidden < max(MIN_AREA, 1e-3 * section_area):
            continue  # lies behind a nearer face everywhere
        outline = cp.hull(q for p in pieces for q in p)
        if cp.width(outline) < MIN_WIDTH:
            continue
        taken += [(i, p) for p in pieces]
        ends.setdefault(i, []).append((pieces, plane, nearest))
    result = []
    for i, parts in ends.items():
        outline = cp.hull(q for pieces, _, _ in parts for p in pieces for q in p)
        share = min(1.0, sum(cp.area(p) for pieces, _, _ in parts for p in pieces) / section_area)
        nearest = min(p[2] for p in parts)
        void_end = sign * ((passage.void[1] if sign > 0 else passage.void[0]) - middle)
        gap = max(0.0, nearest - max(void_end, 1e-9))
        plane = parts[0][1]
        same = all(max(abs(plane[k] - p[1][k]) for k in range(3)) < 1e-3 for p in parts)
        if not same:
            # Several planes (a niche, a bent wall): one polygon square to the passage, at the nearest of them. Every
            # line within the section crosses it before it reaches the room's faces.
            spread = max(p[2] for p in parts) - nearest
            outline = cp.grow(outline, max(spread, 1e-6))
            outline = cp.clip(outline, section) if gap <= 5e-3 else cp.grow(outline, gap)
            plane = (0.0, 0.0, middle + sign * nearest)
        narrow = outline
        if same:
            slip = _slip(passage, sign, [sign * (plane[0] * x + plane[1] * y + plane[2]) for x, y in outline], gap)
            if max(slip) > 0.0:
                outline = _beside(passage, rooms[i], plane, slip) or outline
        polygons = []
        for each in (outline, narrow):
            each = cp.limit_corners(each, 24)
            polygons.append(frame.world(np.array([(x, y, plane[0] * x + plane[1] * y + plane[2]) for x, y in each])))
        result.append(End(i, polygons[0], sign * nearest, share, gap, polygons[1] if outline is not narrow else None))
    result.sort(key=lambda e: -e.share)
    return result


def _slip(passage: Passage, sign: float, depths: list[float], gap: float) -> tuple[float, float]:
    """How far along u and v beside the section a look may leave the room and still get through: between its face (at
    `depths`, along sign n) and the wall lies air that belongs to nobody. A look that gets SHALLOW deep within the section is no
    flatter than section by depth, and slips sideways by as much of the air's depth."""
    wall_end = sign * (passage.host[1] if sign > 0 else passage.host[0])
    off = max(depths) - wall_end
    thickness = min(passage.host[1] - passage.host[0], SHALLOW)
    least = gap if gap > 5e-3 else 0.0  # air between void and room too: 45 degrees at least
    if passage.wall is None or off <= STANDS_OFF or thickness < 1e-3:
        return least, least
    extent = np.ptp(np.array(passage.section), axis=0)
    u, v = (max(least, min(FARTHEST_SLIP, off * float(e) / thickness)) for e in extent)
    return u, v


def _beside(
    passage: Passage, room: Polyhedron, plane: tuple[float, float, float], slip: tuple[float, float]
) -> cp.Polygon:
    """The hull of a room's faces in a plane (t = a u + b v + c) within the section widened by `slip`."""
    frame = passage.frame
    wide = cp.hull((x + i * slip[0], y + j * slip[1]) for x, y in passage.section for i in (-1, 1) for j in (-1, 1))
    corners = []
    for face in room.faces:
        local = frame.local(room.vertices[face.triangles.reshape(-1)])
        if np.abs(plane[0] * local[:, 0] + plane[1] * local[:, 1] + plane[2] - local[:, 2]).max() < 1e-3:
            corners += [q for tri in local.reshape(-1, 3, 3) for q in cp.clip(_counter_clockwise(tri), wide)]
    return cp.hull(corners)


def outside_end(passage: Passage, sign: float, section: cp.Polygon | None = None) -> End:
    """The end at the host's outer face (or the void's, where that reaches farther)."""
    t = max(passage.host[1], passage.void[1]) if sign > 0 else min(passage.host[0], passage.void[0])
    # Voids far deeper than their wall end in the open air: the wall's face is where the outside begins.
    face = passage.host[1] if sign > 0 else passage.host[0]
    if passage.host[1] > passage.host[0]:
        t = face
    outline = cp.limit_corners(section or passage.section, 24)
    local = np.array([(x, y, t) for x, y in outline])
    return End(-1, passage.frame.world(local), t - 0.5 * (passage.host[0] + passage.host[1]), 1.0)


def _sample(section: cp.Polygon) -> np.ndarray:
    """Points spread evenly inside the section, float64 (k, 2)."""
    corners = np.array(section)
    low, high = corners.min(axis=0), corners.max(axis=0)
    steps = np.array([0.08, 0.3, 0.5, 0.7, 0.92])
    grid = [(x, y) for x in low[0] + steps * (high[0] - low[0]) for y in low[1] + steps * (high[1] - low[1])]
    inner = [p for p in grid if cp.contains(section, p)]
    return np.array(inner or [corners.mean(axis=0)])
