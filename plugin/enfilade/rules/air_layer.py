# SPDX-License-Identifier: GPL-3.0-or-later
"""The air between a room's face and what is drawn behind it: whether it is closed all round, and where it leads if not.

The face's plane, a margin around included, is cut into trapezoids by the outlines of all that is drawn in the layer;
the layer is cut into slabs at the depths of what lies parallel to the face. In each cell of that grid there is air, a
solid or a room, the same all over it. Air is followed from cell to cell: exactly, with no look sampled. What isn't watertight
is only as thick as it is drawn, and air that leads beyond the margin counts as leading outdoors: both err to open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import trapezoids
from .blockers import Blockers
from .face_view import FLUSH, INTO_ROOM, OFF_ROUND, FaceView, at_depth, covers, depth_planes, near_triangles
from .polyhedra import Polyhedron
from .shapes import cross as vec_cross

MARGIN = 0.25  # m around what stands off in which air is followed
STEP = 4.7e-4  # m: depths nearer than this are one, as is the rounding of models drawn to the millimetre
SEAM = 3e-4  # m that neighbouring trapezoids may be apart: three times `trapezoids.SAME`
SLANTED_CUTS = (FLUSH, INTO_ROOM)  # m: depths at which slanted faces are cut too
MOST = 10_000  # trapezoids (half a second) in which air is followed; where more is drawn behind a face it leads everywhere
AIR, SOLID = -1, -2  # else the index of a room
OUTDOORS = -1


@dataclass
class Exit:
    """Where air from before the face leads to."""

    target: int  # a room, or OUTDOORS
    pieces: np.ndarray  # trapezoids (k, 6) in which it gets there
    thickness: float  # m, of the layer before the face where it is thickest
    width: float  # m across the pieces; inf: they go on beyond the margin
    followed: bool = True  # False: there was too much to follow, and the air counts as leading there


class AirLayer:
    """What is drawn, and which rooms lie, in the first `depth` metres behind a part of a face, and around that."""

    def __init__(self, view: FaceView, part: np.ndarray, depth: float, blockers: Blockers, rooms: dict[int, Polyhedron]) -> None:
        """part: trapezoids (n, 6) of the face."""
        self.depth, self.frame = depth, view.frame
        self.low = np.array([part[:, 0].min(), part[:, 2:4].min()]) - MARGIN
        self.high = np.array([part[:, 1].max(), part[:, 4:].max()]) + MARGIN
        x, y = np.column_stack([self.low, self.high])
        box = view.frame.world(np.array([(i, j, t) for i in x for j in y for t in (-depth, depth)]))
        low, high = box.min(axis=0), box.max(axis=0)
        self.rooms = {i: r for i, r in rooms.items() if (r.low <= high).all() and (r.high >= low).all()}
        which = blockers.of_owners(np.unique(blockers.owner[blockers.near(low, high)]))
        local = view.frame.local(blockers.triangles[which].reshape(-1, 3)).reshape(-1, 3, 3)
        over = (local[:, :, :2].min(axis=1) <= self.high).all(axis=1) & (local[:, :, :2].max(axis=1) >= self.low).all(axis=1)
        which, local = which[over], local[over]
        edges = self._outlines(blockers, which, local)
        normals = vec_cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        faces = np.abs(normals[:, 2]) > np.maximum(1e-6 * np.abs(normals).max(axis=1), 1e-10)  # else seen edge-on
        which, self.triangles, normals = which[faces], local[faces], normals[faces]
        self.owner, self.sheet = blockers.owner[which], blockers.sheets[which]
        self.planes = depth_planes(self.triangles, normals)
        self.enters = -np.sign(normals[:, 2]).astype(int) * blockers.winding(self.owner)  # 0: of no solid
        inner = [view.frame.local(r.vertices) for r in self.rooms.values()]
        for r, flat in zip(self.rooms.values(), inner, strict=True):
            edges += [at_depth(flat[r.triangles], t) for t in (*SLANTED_CUTS, depth)]
        z = self.triangles[:, :, 2]
        level = z[np.ptp(z, axis=1) < STEP]  # in models that are askew, what is parallel to the face is so but for rounding
        flat = np.concatenate([level.reshape(-1), *(v[:, 2] for v in inner)])
        levels = np.unique(_steps(np.concatenate([flat[(flat > FLUSH) & (flat < depth)], SLANTED_CUTS])))
        self.levels = np.concatenate([[0], levels[(levels > 0) & (levels < _steps(depth))], [_steps(depth)]])
        self.edges = np.concatenate(edges)

    def _outlines(self, blockers: Blockers, which: np.ndarray, local: np.ndarray) -> list[np.ndarray]:
        """What parts air from solids: sections at several depths, and the outlines of all that begins or ends between them."""
        found = [at_depth(local, t) for t in (*SLANTED_CUTS, self.depth)]
        between = (local[:, :, 2].max(axis=1) > FLUSH) & (local[:, :, 2].min(axis=1) < self.depth)
        for sheet in np.unique(blockers.sheets[which[between]]).tolist():
            found.append(self.frame.local(blockers.edges_of(sheet).reshape(-1, 3)).reshape(-1, 2, 3)[:, :, :2].reshape(-1, 4))
        return found

    def exits(self, pieces: np.ndarray, before: np.ndarray, backed: np.ndarray, unbacked: np.ndarray, own: int) -> list[Exit]:
        """Where the air leads that lies before trapezoids `before` (bool) of `pieces` (n, 6), which fill the layer's rectangle.
        backed: bool, of which something is known to stand within the layer; unbacked: where the face itself is open; own: the
        room that the face is of."""
        if len(pieces) > MOST:
            return self._everywhere(pieces[before], own)
        cells, closed_above = self._cells(pieces)
        closed_above[backed, -1] = True  # what leans ends somewhere in its last slab, which counts as air
        air = cells == AIR
        i, j = _neighbours(pieces)
        node = np.arange(cells.size).reshape(cells.shape)
        up = air[:, :-1] & air[:, 1:] & ~closed_above[:, :-1]
        beside = air[i] & air[j]
        label = _components(
            cells.size,
            np.concatenate([node[i][beside], node[:, :-1][up]]),
            np.concatenate([node[j][beside], node[:, 1:][up]]),
        ).reshape(cells.shape)
        below = np.column_stack([np.zeros(len(air), dtype=bool), closed_above[:, :-1]])
        top = np.cumprod(air & ~below, axis=1).sum(axis=1)  # slabs of air on the face
        before = before & air[:, 0]
        layered = before & (backed | (top < cells.shape[1]))
        # What stands before the face alone is gone round where the face is open beside it.
        passed_by = before & ~layered & np.isin(label[:, 0], label[unbacked & air[:, 0], 0])
        reached = air & np.isin(label, label[layered | passed_by, 0])
        thickness = float(self.levels[top[layered].max(initial=0)]) * STEP
        rim = (pieces[:, 0] < self.low[0] + SEAM) | (pieces[:, 1] > self.high[0] - SEAM)
        rim |= (pieces[:, 2:4].min(axis=1) < self.low[1] + SEAM) | (pieces[:, 4:].max(axis=1) > self.high[1] - SEAM)
        ways = {OUTDOORS: reached[:, -1] & ~closed_above[:, -1] | (reached & rim[:, None]).any(axis=1)}
        for room in self.rooms.keys() - {own}:
            there = cells == room
            ways[room] = (reached[:, :-1] & there[:, 1:] & ~closed_above[:, :-1]).any(axis=1)
            ways[room][j[(reached[i] & there[j]).any(axis=1)]] = True
            ways[room][i[(reached[j] & there[i]).any(axis=1)]] = True
        result = []
        for target, there in sorted(ways.items()):
            both = there[i] & there[j]
            group = _components(len(pieces), i[both], j[both])
            for g in np.unique(group[there]):
                members = there & (group == g)
                width = np.inf if target >= 0 or rim[members].any() else _extent(pieces[members])
                result.append(Exit(target, pieces[members], thickness, width))
        return result

    def _everywhere(self, pieces: np.ndarray, own: int) -> list[Exit]:
        """Exits outdoors and to each room near, all over the rectangle that trapezoids (k, 6) lie in."""
        low, high = pieces[:, 2:4].min(), pieces[:, 4:].max()
        whole = np.array([[pieces[:, 0].min(), pieces[:, 1].max(), low, low, high, high]])
        return [Exit(t, whole, self.depth, np.inf, followed=False) for t in (OUTDOORS, *sorted(self.rooms.keys() - {own}))]

    def _cells(self, pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is in each cell, int (n, slabs); and bool (n, slabs), whether a sheet parts it from the cell above."""
        centres = trapezoids.centres(pieces)
        slabs = len(self.levels) - 1
        cells = np.full((len(pieces), slabs), AIR)
        closed_above = np.zeros((len(pieces), slabs), dtype=bool)
        middle = 0.5 * (self.levels[:-1] + self.levels[1:]) * STEP
        for index, room in self.rooms.items():
            cells[self._held(room, centres, middle)] = index
        for part, some in near_triangles(centres, self.triangles):
            self._fill(pieces[part], centres[part], some, cells[part], closed_above[part])
        return cells, closed_above

    def _held(self, room: Polyhedron, centres: np.ndarray, middle: np.ndarray) -> np.ndarray:
        """Which cells over points (n, 2), at depths `middle` (slabs,), a room holds: bool (n, slabs). By the faces beyond each cell
        that a line square to the layer leaves the room by, less those that it enters it by."""
        faces = [f for f in room.faces if abs(float(f.normal @ self.frame.n)) >= 1e-6]  # else seen edge-on
        beyond = np.zeros((len(centres), len(middle) + 1), dtype=int)  # by how many middles lie before the crossing
        if faces:
            of = np.repeat(np.arange(len(faces)), [len(f.triangles) for f in faces])
            triangles = self.frame.local(room.vertices[np.concatenate([f.triangles for f in faces])].reshape(-1, 3)).reshape(-1, 3, 3)
            normals = self.frame.turned(np.array([f.normal for f in faces]))[of]
            planes = depth_planes(triangles, normals)
            for part, some in near_triangles(centres, triangles):
                at, k = _met(centres[part], triangles[some], of[some])
                k, x = some[k], centres[part][at]
                depth = planes[k, 0] * x[:, 0] + planes[k, 1] * x[:, 1] + planes[k, 2]
                np.add.at(beyond[part], (at, np.searchsorted(middle, depth)), np.sign(normals[k, 2]).astype(int))
        return np.cumsum(beyond[:, :0:-1], axis=1)[:, ::-1] != 0

    def _fill(
        self, pieces: np.ndarray, centres: np.ndarray, some: np.ndarray, cells: np.ndarray, closed_above: np.ndarray
    ) -> None:
        """Enters solids and sheets into the cells of some trapezoids."""
        at, k = _met(centres, self.triangles[some], 3 * self.sheet[some] + self.enters[some] + 1)
        if not len(at):
            return
        k = some[k]
        plane = self.planes[k]
        depth = plane[:, 0] * centres[at, 0] + plane[:, 1] * centres[at, 1] + plane[:, 2]
        order = np.lexsort((depth, self.owner[k], at))
        at, k, depth, plane = at[order], k[order], depth[order], plane[order]
        x, y = pieces[at][:, [0, 1, 1, 0]], pieces[at][:, [2, 3, 5, 4]]
        corner = plane[:, :1] * x + plane[:, 1:2] * y + plane[:, 2:]  # depths at the trapezoids' corners
        corner = np.where(np.abs(corner) <= FLUSH, 0, _steps(corner))
        least = np.maximum(np.searchsorted(self.levels, corner.min(axis=1), side="right") - 1, 0)
        most = np.searchsorted(self.levels, corner.max(axis=1))
        same = (at[1:] == at[:-1]) & (self.owner[k[1:]] == self.owner[k[:-1]])
        start, last = np.concatenate([[True], ~same]), np.concatenate([~same, [True]])
        run = np.cumsum(start) - 1
        total = np.cumsum(self.enters[k])
        within = total - (total - self.enters[k])[start][run]  # how often one is inside its product behind each face
        sound = within[last] == 0  # else wound wrongly: no solid
        np.logical_and.at(sound, run, within >= 0)
        begin = np.nonzero(sound[run] & (within > 0) & ~last)[0]
        count = np.zeros((cells.shape[0], cells.shape[1] + 2), dtype=int)
        np.add.at(count, (at[begin], most[begin]), 1)
        np.add.at(count, (at[begin], np.maximum(least[begin + 1], most[begin])), -1)
        cells[(np.cumsum(count, axis=1)[:, :-2] > 0) & (cells == AIR)] = SOLID
        flat = (least == most) & (least > 0)
        closed_above[at[flat], least[flat] - 1] = True


def _steps(depth: np.ndarray | float) -> np.ndarray:
    return np.round((np.asarray(depth) + OFF_ROUND) / STEP).astype(int)


def _met(points: np.ndarray, triangles: np.ndarray, group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which points lie in which triangles, int (k,) each; in one of each group at most: on the line between two of a face both are met."""
    at, k = np.nonzero(covers(points, triangles))
    once = np.unique(at * (int(group.max()) + 1) + group[k], return_index=True)[1]
    return at[once], k[once]


def _neighbours(pieces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of trapezoids (n, 6) that share more than a corner of their outlines: int (k,) each."""
    x0, x1, b0, b1, t0, t1 = pieces.T
    # Across upright lines: the right side of one meets the left side of another.
    found = [_facing(x1, b1, t1, x0, b0, t0)]
    # Along the line between two of one strip.
    order = np.lexsort((b0 + b1, x1, x0))
    i, j = order[:-1], order[1:]
    stacked = (x0[i] == x0[j]) & (x1[i] == x1[j]) & (np.abs(t0[i] - b0[j]) < SEAM) & (np.abs(t1[i] - b1[j]) < SEAM)
    found.append((i[stacked], j[stacked]))
    # Across level lines, where strips of two halves of the plane meet.
    top, bottom = np.nonzero(np.abs(t0 - t1) < SEAM)[0], np.nonzero(np.abs(b0 - b1) < SEAM)[0]
    i, j = _facing(t0[top], x0[top], x1[top], b0[bottom], x0[bottom], x1[bottom])
    found.append((top[i], bottom[j]))
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])


def _facing(
    a: np.ndarray, a_low: np.ndarray, a_high: np.ndarray, b: np.ndarray, b_low: np.ndarray, b_high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Indices of all pairs of sides that lie on one line (at a and b, less than SEAM apart) and share more than STEP of it. Sides of
    one kind hardly overlap each other: sorted along all lines, one after the other, those that another meets stand together."""
    both = np.concatenate([a, b])
    order = np.argsort(both, kind="stable")
    line = np.empty(len(both))
    line[order] = np.cumsum(np.diff(both[order], prepend=-np.inf) >= SEAM)
    shift = line * 4.0 * max(float(np.abs(v).max(initial=1.0)) for v in (a_low, a_high, b_low, b_high))
    shift_a, shift_b = shift[: len(a)], shift[len(a) :]
    order = np.argsort(b_low + shift_b, kind="stable")
    begins = (b_low + shift_b)[order]
    ended = np.maximum.accumulate((b_high + shift_b)[order])  # by the side up to which all before have ended
    first, last = np.searchsorted(ended, a_low + shift_a), np.searchsorted(begins, a_high + shift_a)
    count = np.maximum(last - first, 0)
    i = np.repeat(np.arange(len(a)), count)
    j = order[np.arange(len(i)) + np.repeat(first - np.cumsum(count) + count, count)]
    shared = np.minimum(a_high[i], b_high[j]) - np.maximum(a_low[i], b_low[j]) > STEP
    shared &= np.abs(a[i] - b[j]) < SEAM
    return i[shared], j[shared]


def _components(count: int, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """The least node that hangs together with each of `count` nodes, int (count,), over edges i, j: trees are hung into each
    other by their roots, then flattened, until no edge joins two of them."""
    root = np.arange(count)
    while True:
        a, b = root[i], root[j]
        apart = a != b
        if not apart.any():
            return root
        i, j = i[apart], j[apart]
        low, high = np.minimum(a, b)[apart], np.maximum(a, b)[apart]
        order = np.lexsort((low, high))
        high, first = np.unique(high[order], return_index=True)
        root[high] = low[order][first]
        while (root[root] != root).any():
            root = root[root]


def _extent(pieces: np.ndarray) -> float:
    """The diagonal of what trapezoids (k, 6) cover, m."""
    return float(np.hypot(np.ptp(pieces[:, :2]), np.ptp(pieces[:, 2:])))
