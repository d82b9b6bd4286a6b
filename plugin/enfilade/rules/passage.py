# SPDX-License-Identifier: GPL-3.0-or-later
"""Which two rooms an opening joins, and where it meets them: lines sent through the opening along its possible axes.

A thick opening (the void of a door in its wall) says nothing about which way one walks through it: voids may be deeper
than wide. So every axis that has an end face at both ends is tried; along each, lines through the body are cut by the
rooms' faces, and the stretch that lies in no room is the wall. The axis with the thinnest wall between two different
rooms (or a room and the outdoors) wins. Ends are then cut where the rooms' faces are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .box_index import BoxIndex
from .shapes import (
    Solid,
    cross,
    cut_convex,
    flatness,
    newell,
    plane_basis,
    polygon_area,
    support_polygon,
    unit,
)

OUTDOORS = -1
# How far beyond an opening's end a room may begin (metres): finishes and reveals; the second, larger reach is a fallback
# that joins rather than loses a room (safe direction) and is reported.
REACH = 0.30
FAR_REACH = 1.00
# Two crossings nearer than this are one (metres).
SAME = 1e-3


@dataclass
class Passage:
    rooms: tuple[int, int]  # indices, OUTDOORS for no room
    axis: np.ndarray  # unit, from rooms[0] to rooms[1]
    gap: float  # metres of wall between the rooms along the axis
    planes: tuple[tuple[np.ndarray, float] | None, tuple[np.ndarray, float] | None]  # (n, n.p), outward of the body
    votes: float  # share of the lines that agree, 0 to 1
    reach: float


@dataclass
class _Line:
    rooms: tuple[int, int]
    span: tuple[float, float]
    normals: tuple[np.ndarray | None, np.ndarray | None]


class RoomIndex:
    """Rooms by bounding box: which may be near a box. solids[i] is None for a room without geometry."""

    def __init__(self, solids: Sequence[Solid | None]):
        self.solids = list(solids)
        n = len(self.solids)
        self.low = np.full((n, 3), np.inf)
        self.high = np.full((n, 3), -np.inf)
        for i, solid in enumerate(self.solids):
            if solid is not None:
                self.low[i], self.high[i] = solid.low, solid.high
        self._boxes = BoxIndex(self.low, self.high)

    def near(self, low: np.ndarray, high: np.ndarray) -> list[int]:
        return self._boxes.near(low, high).tolist()


def candidate_axes(body: np.ndarray, faces: Sequence[Sequence[int]] | None, most: int = 12) -> list[np.ndarray]:
    """Directions (one of each opposite pair) along which the body has a face at either end, largest ends first."""
    if faces:
        quick = _axes_of_faces(body, faces)
        if len(quick) > 1:
            return quick[:most]
    directions = [unit(newell(body[list(f)])) for f in faces] if faces else []
    thickness_axis = flatness(body)[1]
    u, v = plane_basis(thickness_axis)
    directions += [thickness_axis, u, v, *np.eye(3)]
    found: list[tuple[float, np.ndarray]] = []
    for d in directions:
        if not np.isfinite(d).all() or np.linalg.norm(d) < 0.5:
            continue
        if any(abs(float(d @ other)) > 1.0 - 1e-6 for _, other in found):
            continue
        ends = support_polygon(body, d), support_polygon(body, -d)
        if ends[0] is None or ends[1] is None:
            continue
        found.append((min(polygon_area(ends[0]), polygon_area(ends[1])), d))
    found.sort(key=lambda item: -item[0])
    return [d for _, d in found[:most]]


def _axes_of_faces(body: np.ndarray, faces: Sequence[Sequence[int]]) -> list[np.ndarray]:
    """Directions in which faces look both ways, those with the largest such faces first: a box has three."""
    sums: list[tuple[np.ndarray, list[float]]] = []  # direction; area that looks along it, area that looks back
    for area in _area_vectors(body, faces):
        size = float(np.linalg.norm(area))
        if size == 0.0:
            continue
        direction = area / size
        for known, sides in sums:
            along = float(known @ direction)
            if abs(along) > 1.0 - 1e-6:
                sides[0 if along > 0 else 1] += size
                break
        else:
            sums.append((direction, [size, 0.0]))
    both = [(min(sides), direction) for direction, sides in sums if min(sides) > 0.0]
    return [direction for _, direction in sorted(both, key=lambda item: -item[0])]


def _area_vectors(body: np.ndarray, faces: Sequence[Sequence[int]]) -> np.ndarray:
    """Newell's vector of each face, float64 (n, 3); those of equally many corners at once."""
    result = np.empty((len(faces), 3))
    sizes = np.array([len(f) for f in faces])
    for size in set(sizes.tolist()):
        which = np.nonzero(sizes == size)[0]
        corners = body[np.array([faces[i] for i in which])]  # (n, size, 3)
        a = corners - corners.sum(axis=1, keepdims=True) / size
        result[which] = cross(a, a[:, [*range(1, size), 0]]).sum(axis=1)
    return result


def _section(body: np.ndarray, axis: np.ndarray, heights: np.ndarray, centre: float) -> np.ndarray | None:
    """Corners of the body's section across the axis at its middle: read off where it is a box, else cut."""
    low, high = heights < centre, heights > centre
    if len(body) == 8 and low.sum() == 4 and high.sum() == 4:
        below, above = body[low], body[high]
        flat = below - (heights[low] - centre)[:, None] * axis
        other = above - (heights[high] - centre)[:, None] * axis
        if np.ptp(heights[low]) < 1e-9 and np.ptp(heights[high]) < 1e-9:
            away = np.abs(flat[:, None] - other[None]).max(axis=2).min(axis=1)
            if away.max() < 1e-9:
                return flat
    return cut_convex(body, axis, centre)[1]


def _trace_all(
    starts: list[np.ndarray], axis, half: float, reach: float, rooms: list[int], index: RoomIndex
) -> list[_Line | None]:
    """Cuts the lines start + t * axis, |t| <= half + reach, by the rooms; for each the wall nearest to t = 0 and who is
    beside it.

    half: half the body's length along the axis, metres. What lies only within `reach` beyond the body is no wall of it.
    """
    low, high = -half - reach, half + reach
    cuts: list[list[tuple[float, int, int]]] = [[(low, -1, -1), (high, -1, -1)] for _ in starts]
    origins = np.array(starts)
    ends = np.concatenate([origins + low * axis, origins + high * axis])
    first, last = ends.min(axis=0) - SAME, ends.max(axis=0) + SAME
    rooms = [r for r in rooms if (index.low[r] <= last).all() and (index.high[r] >= first).all()]
    if not rooms:
        return [None] * len(starts)
    for room in rooms:
        for mine, hits in zip(cuts, index.solids[room].lines_hit(origins, axis), strict=True):
            mine += [(t, room, tri) for t, tri in hits if low < t < high]
    every: list[list[tuple[float, int, int]]] = []
    for mine in cuts:
        mine.sort(key=lambda c: c[0])
        marks = [mine[0]]
        for cut in mine[1:]:
            if cut[0] - marks[-1][0] > SAME:
                marks.append(cut)
        every.append(marks)
    middles = [np.array([0.5 * (a[0] + b[0]) for a, b in zip(m, m[1:], strict=False)]) for m in every]
    points = np.concatenate([start + t[:, None] * axis for start, t in zip(starts, middles, strict=True)])
    owner = np.full(len(points), OUTDOORS)
    for room in rooms:
        owner[index.solids[room].contains(points) & (owner == OUTDOORS)] = room
    begin = np.cumsum([0] + [len(t) for t in middles])
    return [
        _wall(marks, owner[a:b].tolist(), half, index) if len(marks) > 1 else None
        for marks, a, b in zip(every, begin, begin[1:], strict=False)
    ]


def _wall(marks: list[tuple[float, int, int]], owner: list[int], half: float, index: RoomIndex) -> _Line | None:
    """The wall of one traced line: the stretch in no room, or the touch of two rooms, that is nearest to t = 0."""
    # runs: (room, t0, t1, mark index at start, at end)
    runs: list[list] = []
    for i, room in enumerate(owner):
        if runs and runs[-1][0] == room:
            runs[-1][2], runs[-1][4] = marks[i + 1][0], i + 1
        else:
            runs.append([int(room), marks[i][0], marks[i + 1][0], i, i + 1])

    def normal_at(mark: int) -> np.ndarray | None:
        _, room, tri = marks[mark]
        return None if room < 0 else index.solids[room].normals[tri]

    best: tuple[float, _Line] | None = None
    for i, (room, t0, t1, m0, m1) in enumerate(runs):
        if room == OUTDOORS:
            before = runs[i - 1][0] if i > 0 else OUTDOORS
            after = runs[i + 1][0] if i + 1 < len(runs) else OUTDOORS
            if before == OUTDOORS and after == OUTDOORS:
                continue
            if min(t1, half) - max(t0, -half) <= SAME:
                continue  # the body isn't in this wall at all
            line = _Line((before, after), (t0, t1), (normal_at(m0) if i > 0 else None,
                                                     normal_at(m1) if i + 1 < len(runs) else None))
        elif i + 1 < len(runs) and runs[i + 1][0] != OUTDOORS:
            # two rooms that touch: a wall of no thickness
            line = _Line((room, runs[i + 1][0]), (t1, t1), (normal_at(m1), normal_at(m1)))
            t0 = t1
        else:
            continue
        off = max(0.0, t0, -t1)
        # touching or nearest the opening's middle; different rooms before the same room twice
        key = off + (0.0 if line.rooms[0] != line.rooms[1] else 1e3)
        if best is None or key < best[0]:
            best = (key, line)
    if best:
        return best[1]
    inside = next((r[0] for r in runs if r[1] <= 0.0 <= r[2] and r[0] != OUTDOORS), None)
    return None if inside is None else _Line((inside, inside), (0.0, 0.0), (None, None))


def find_passage(body: np.ndarray, faces, index: RoomIndex, wanted: set[int] | None = None,
                 vertical_cost: float = 0.0) -> Passage | None:
    """The way through a body (n, 3), or None when no room is near. `wanted`: the two rooms it must join, if fixed.

    vertical_cost: metres of wall that a way straight up or down counts as more: nobody walks up through a door.
    """

    def cost(p: Passage) -> float:
        # A thin wall that most lines agree on; a way outdoors is the second choice (any body near an outer wall has one).
        metres = p.gap / p.votes + (0.3 if OUTDOORS in p.rooms else 0.0)
        return metres + (vertical_cost if abs(float(p.axis[2])) > 0.9 else 0.0)

    for reach in (REACH, FAR_REACH):
        low, high = body.min(axis=0) - reach - SAME, body.max(axis=0) + reach + SAME
        rooms = index.near(low, high)
        if wanted is not None:
            rooms = [r for r in rooms if r in wanted]
        if not rooms:
            continue
        found = [p for axis in candidate_axes(body, faces) if (p := _along(body, axis, rooms, index, reach))]
        good = [p for p in found if p.rooms[0] != p.rooms[1]]
        if wanted is not None and good:
            exact = [p for p in good if set(p.rooms) == wanted]
            good = exact or good
        if good:
            return min(good, key=cost)
        if found:
            return min(found, key=cost)
    return None


def _along(body, axis, rooms, index, reach) -> Passage | None:
    heights = body @ axis
    centre_height = 0.5 * float(heights.min() + heights.max())
    middle = body.mean(axis=0)
    middle = middle + (centre_height - middle @ axis) * axis
    section = _section(body, axis, heights, centre_height)
    starts = [middle]
    if section is not None:
        middle = section.mean(axis=0)
        # the middle, and half way to the corners: enough to outvote a chair rail or a pillar beside the opening
        starts = [middle] + [middle + 0.5 * (corner - middle) for corner in section[:: max(1, len(section) // 4)]]
    half = 0.5 * float(np.ptp(heights))
    lines_found = _trace_all(starts, axis, half, reach, rooms, index)
    traced = [(s, line) for s, line in zip(starts, lines_found, strict=True) if line]
    if not traced:
        return None
    lines = [line for _, line in traced]
    tally: dict[tuple[int, int], list[_Line]] = {}
    for line in lines:
        tally.setdefault(line.rooms, []).append(line)
    pair = max(tally, key=lambda p: (p[0] != p[1], len(tally[p]), -min(line.span[1] - line.span[0] for line in tally[p])))
    agreed = tally[pair]
    t0 = min(line.span[0] for line in agreed) if pair[0] != OUTDOORS else -half
    t1 = max(line.span[1] for line in agreed) if pair[1] != OUTDOORS else half
    if pair[0] == OUTDOORS:
        t0 = min(t0, t1)
    if pair[1] == OUTDOORS:
        t1 = max(t0, t1)
    base = float(starts[0] @ axis)
    beginnings = [s for s, line in traced if line.rooms == pair]
    planes = []
    for side, sign in ((0, -1.0), (1, 1.0)):
        if pair[side] == OUTDOORS:
            planes.append(None)
            continue
        planes.append(_room_plane(agreed, side, sign * axis, beginnings, axis, base))
    return Passage(pair, axis, max(0.0, t1 - t0), (planes[0], planes[1]), len(agreed) / len(starts), reach)


def _room_plane(lines: list[_Line], side: int, outward: np.ndarray, starts, axis, base) -> tuple[np.ndarray, float]:
    """The plane in which the body is cut: the room's own face where all lines meet one plane, else across the axis at
    the crossing nearest to the wall (safe: the body keeps clear of the room, and nothing of the passage is lost)."""
    spans = [line.span[side] for line in lines]
    normals = [line.normals[side] for line in lines]
    if all(n is not None for n in normals):
        first = normals[0] if normals[0] @ outward > 0 else -normals[0]
        same = all(abs(float(n @ first)) > 1.0 - 1e-6 for n in normals)
        steep = float(first @ outward) > 0.5  # a face seen edge-on would stretch the end without limit
        square = float(first @ outward) > 1.0 - 1e-9
        if same and steep and (square and max(spans) - min(spans) < SAME):
            point = base * axis + spans[0] * axis
            return outward, float(outward @ point)
        if same and steep and len(lines) == len(starts):
            points = [s + t * axis for s, t in zip(starts, spans, strict=True)]
            offsets = [float(first @ p) for p in points]
            if max(offsets) - min(offsets) < SAME:
                return first, offsets[0]
    t = max(spans) if side == 0 else min(spans)
    return outward, float(outward @ (axis * (base + t)))


def shape_passage(body: np.ndarray, passage: Passage) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]] | None:
    """Body and end polygons, cut or lengthened to the rooms' faces. None when they leave nothing (rooms that touch or
    overlap there): the caller uses a thin polygon instead."""
    points = np.asarray(body, dtype=np.float64)
    for side, sign in ((0, -1.0), (1, 1.0)):
        plane = passage.planes[side]
        if plane is None:
            continue
        outward = sign * passage.axis
        normal, offset = plane
        end = support_polygon(points, outward)
        if end is None:
            return None
        short = offset - float((end @ normal).min())
        if short > 0.0:  # the body ends before the room begins: lengthen it past the plane, then cut
            points = np.concatenate([points, end + outward * (short / float(normal @ outward))])
        rest, section = cut_convex(points, normal, offset)
        if section is None:
            on = rest[np.abs(rest @ normal - offset) < SAME]
            if len(on) < 3:
                return None
        points = rest
    ends = []
    for side, sign in ((0, -1.0), (1, 1.0)):
        plane = passage.planes[side]
        normal = sign * passage.axis if plane is None else plane[0]
        end = support_polygon(points, normal)
        if end is None:
            return None
        ends.append(end)
    if float(np.ptp(points @ passage.axis)) < SAME:
        return None
    return points, (ends[0], ends[1])


def thin_sides(polygon: np.ndarray, index: RoomIndex, wanted: set[int] | None = None) -> tuple[int, int] | None:
    """The rooms on both sides of a flat polygon (k, 3), found by walking out along its normal. None: no room near."""
    normal = unit(newell(polygon))
    middle = polygon.mean(axis=0)
    starts = [middle] + [middle + 0.5 * (c - middle) for c in polygon[:: max(1, len(polygon) // 4)]]
    for reach in (REACH, FAR_REACH):
        rooms = index.near(polygon.min(axis=0) - reach, polygon.max(axis=0) + reach)
        if wanted is not None:
            rooms = [r for r in rooms if r in wanted]
        if not rooms:
            continue
        sides = []
        for sign in (-1.0, 1.0):
            votes: dict[int, int] = {}
            for start in starts:
                room = _first_room(start, sign * normal, reach, rooms, index)
                votes[room] = votes.get(room, 0) + 1
            sides.append(max(votes, key=lambda r: (r != OUTDOORS, votes[r])))
        if sides[0] != OUTDOORS or sides[1] != OUTDOORS:
            return sides[0], sides[1]
    return None


def _first_room(start, direction, reach, rooms, index) -> int:
    cuts = {SAME, reach}
    for room in rooms:
        cuts.update(t for t, _ in index.solids[room].ray_hits(start, direction) if SAME < t < reach)
    marks = sorted(cuts)
    middles = np.array([0.5 * (a + b) for a, b in zip(marks, marks[1:], strict=False)])
    points = start + middles[:, None] * direction
    inside = {room: index.solids[room].contains(points) for room in rooms}
    for i in range(len(middles)):
        for room in rooms:
            if inside[room][i]:
                return room
    return OUTDOORS
