# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a room's boundary is open air: rooms that touch without a wall, and faces that nothing drawn stands behind.

Each face of each room is rastered; a cell is backed when something of the shell (walls, slabs, roofs, ceilings, uncut)
lies close behind it, or when a passage ends there. What is left over is open: to the room that touches there, else to the
exterior, which is whatever no room claims. Open parts become virtual portals, grown by one raster cell: never too small.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import convex_polygons as cp
from .blockers import Blockers
from .polyhedra import Face, Polyhedron
from .probing import Frame, Passage

TOUCH = 0.05  # m: faces nearer than this touch
BACKING = 0.1  # m behind a face in which a wall counts as its backing; the core counts what is drawn that near as in the room
SCAN = 0.4  # m to both sides in which a wall is recognised that a face runs inside of (rooms drawn to its middle)
INTO_ROOM = 0.05  # m before the face: walls drawn a little into the room back it too
CELL = 0.025  # m, the raster; finer for narrow faces, up to twice as coarse for large ones
FLUSH = 5e-3  # m: what stands nearer than this to a face leaves no air between
SPREAD = 0.5  # m sideways that an open part reaches into cells whose backing stands off the face
MANY = 24  # triangles of a face beyond which its exact outline isn't merged: the raster covers it as well
SLIT = 2  # cells: open strips narrower than this are gaps between drawn things, not openings (bridged)
FULL = 0.7  # a hull that is open for less than this share is cut in two


@dataclass
class OpenPart:
    """A part of a room's boundary that is open."""

    room: int
    other: int  # the room that touches there, -1: the exterior
    polygon: np.ndarray  # float64 (k, 3), world, convex, on the room's face
    area: float  # of the open cells, m2
    normal: np.ndarray  # out of `room`
    gap: float = 0.0  # m to the other room's face


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
    return result


def _open_parts(
    i: int,
    solid: Polyhedron,
    face: Face,
    solids: list[Polyhedron],
    neighbours: list[int],
    blockers: Blockers,
    ends: list[np.ndarray],
) -> list[OpenPart]:
    corners = solid.vertices[face.triangles]  # (k, 3, 3)
    edges = np.concatenate([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1], corners[:, 0] - corners[:, 2]])
    hint = edges[int(np.argmax(np.round(np.linalg.norm(edges, axis=1), 4)))]
    frame = Frame.along(face.normal, face.normal * face.d, hint)
    flat = frame.local(corners.reshape(-1, 3)).reshape(-1, 3, 3)
    grid = _Grid(flat[:, :, 0].min(), flat[:, :, 1].min(), flat[:, :, 0].max(), flat[:, :, 1].max())
    if grid.cells == 0:
        return []
    own = np.zeros(grid.shape, dtype=bool)
    for tri in flat:
        grid.fill(own, tri[:, :2])
    if not own.any():
        return []
    ahead, near, leaving, behind = _depths(frame, grid, corners, blockers)
    passage = np.zeros(grid.shape, dtype=bool)
    for polygon in ends:
        local = frame.local(polygon)
        if np.abs(local[:, 2]).max() < BACKING and abs(_normal_z(local)) > 0.9:
            grid.fill(passage, np.array(cp.grow(cp.hull((x, y) for x, y, _ in local), 1e-3)))
    result: list[OpenPart] = []
    limits = _convex(flat)
    # Rooms that touch here. Inside a wall (rooms drawn to its middle): what comes next ahead is a face that looks
    # away, and something lies behind; else a wall closes the view only where it stands right at the interface.
    in_solid = leaving & np.isfinite(near) & behind
    claimed = np.zeros(grid.shape, dtype=bool)
    for j in neighbours:
        for other in solids[j].faces:
            if other.normal @ face.normal > -0.9994:  # 2 degrees
                continue
            there = frame.local(solids[j].vertices[other.triangles.reshape(-1)]).reshape(-1, 3, 3)
            gap = float(there[:, :, 2].mean())
            if abs(gap) > TOUCH:
                continue
            shared = np.zeros(grid.shape, dtype=bool)
            for tri in there:
                grid.fill(shared, tri[:, :2])
            shared &= own
            if not shared.any():
                continue
            claimed |= shared
            if j < i:
                continue  # told from the other side
            free = shared & ~passage & ~in_solid & ~(near <= max(gap, 0.0) + FLUSH)
            whole = free.sum() > 0.98 * (shared & ~passage).sum() and len(flat) + len(there) <= MANY
            outlines = _overlap(flat, there) if whole else None
            result += _parts(i, j, frame, grid, free, gap, face.normal, outlines, [*limits, *_convex(there)])
    free = own & ~claimed & ~passage & ~in_solid & ~(ahead <= BACKING)
    if free.any():
        # A look that leaves where a wall stands off a little can slip sideways to where nothing stands.
        free = _spread(free, own & ~claimed & ~passage & ~in_solid & (np.abs(ahead) > FLUSH), round(SPREAD / grid.size))
        whole = free.sum() > 0.98 * own.sum() and len(flat) <= MANY
        outlines = cp.merge([_counter_clockwise(t) for t in flat]) if whole else None
        result += _parts(i, -1, frame, grid, free, 0.0, face.normal, outlines, limits)
    return result


def _depths(
    frame: Frame, grid: _Grid, corners: np.ndarray, blockers: Blockers
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Per cell: the distance to the first blocker from INTO_ROOM before the face up to SCAN behind it (inf: none);
    the same from the face itself on; whether the latter is a face seen from inside its solid; and whether any blocker
    lies within SCAN on the room's side."""
    ahead = np.full(grid.shape, np.inf, dtype=np.float32)
    near = np.full(grid.shape, np.inf, dtype=np.float32)
    leaving = np.zeros(grid.shape, dtype=bool)
    behind = np.zeros(grid.shape, dtype=bool)
    points = corners.reshape(-1, 3)
    chosen = blockers.near(points.min(axis=0) - SCAN, points.max(axis=0) + SCAN)
    if not len(chosen):
        return ahead, near, leaving, behind
    local = frame.local(blockers.triangles[chosen].reshape(-1, 3)).reshape(-1, 3, 3)
    normals = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
    least, most = local.min(axis=1), local.max(axis=1)
    useful = (least[:, 2] <= SCAN) & (most[:, 2] >= -SCAN)
    useful &= np.abs(normals[:, 2]) > np.maximum(1e-9 * np.abs(normals).max(axis=1), 1e-10)  # else seen edge-on
    useful &= (least[:, 0] <= grid.x[-1]) & (most[:, 0] >= grid.x[0])
    useful &= (least[:, 1] <= grid.y[-1]) & (most[:, 1] >= grid.y[0])
    chosen, local, normals = chosen[useful], local[useful], normals[useful]
    low, high = points.min(axis=0) - SCAN, points.max(axis=0) + SCAN
    for index, tri, normal, least_t, most_t in zip(
        chosen, local, normals, least[useful, 2].tolist(), most[useful, 2].tolist(), strict=True
    ):
        a, b = -normal[0] / normal[2], -normal[1] / normal[2]
        c = tri[0, 2] - a * tri[0, 0] - b * tri[0, 1]
        if max(abs(a), abs(b)) < 1e-7:  # parallel to the face, as most are: one depth for all its cells
            c, a, b = float(tri[:, 2].mean()), 0.0, 0.0
        window = grid.window(tri[:, :2])
        if window is None:
            continue
        rows, columns, x, y, within = window
        t: np.ndarray | np.float32 = np.float32(c)
        if a != 0.0 or b != 0.0:
            t = (b * y + c).astype(np.float32)[:, None] + (a * x).astype(np.float32)[None, :]
        for hole in blockers.holes_of(index):
            if (hole.low <= high).all() and (hole.high >= low).all():
                _cut(frame, hole, x, y, t, within)
        view = (rows, columns)
        if least_t <= INTO_ROOM:
            behind[view] |= within & (t >= -SCAN) & (t < INTO_ROOM)
        if most_t >= -INTO_ROOM:
            part = ahead[view]
            np.copyto(part, t, where=within & (t >= -INTO_ROOM) & (t <= SCAN) & (t < part))
        if most_t >= -FLUSH:
            part = near[view]
            nearer = within & (t >= -FLUSH) & (t <= SCAN) & (t < part)
            np.copyto(part, t, where=nearer)
            np.copyto(leaving[view], normal[2] > 0.0, where=nearer)
    return ahead, near, leaving, behind


def _cut(
    frame: Frame, hole: Passage, x: np.ndarray, y: np.ndarray, t: np.ndarray | np.float32, within: np.ndarray
) -> None:
    """Takes the cells of a triangle that lie in a void out of `within`."""
    bounds = frame.local(hole.corners)
    (x0, y0, t0), (x1, y1, t1) = bounds.min(axis=0), bounds.max(axis=0)
    c0, c1 = np.searchsorted(x, [x0 - 1e-3, x1 + 1e-3])
    r0, r1 = np.searchsorted(y, [y0 - 1e-3, y1 + 1e-3])
    if c0 >= c1 or r0 >= r1 or np.max(t) < t0 - 1e-3 or np.min(t) > t1 + 1e-3:
        return
    r, k = np.nonzero(within[r0:r1, c0:c1])
    if not len(r):
        return
    r, k = r + r0, k + c0
    depth = t[r, k] if np.ndim(t) else np.full(len(r), t)
    gone = hole.holds(frame.world(np.column_stack([x[k], y[r], depth])))
    within[r[gone], k[gone]] = False


def _parts(
    i: int,
    j: int,
    frame: Frame,
    grid: _Grid,
    free: np.ndarray,
    gap: float,
    normal: np.ndarray,
    outlines: list[cp.Polygon] | None,
    limits: list[cp.Polygon],
) -> list[OpenPart]:
    """Convex polygons that cover the free cells; `outlines`, where given, is the exact answer. limits: convex
    polygons that nothing need reach beyond."""
    kept = _without_slits(free)
    if not kept.any():
        return []
    parts = []
    if outlines is not None and len(outlines) <= 8:
        total = sum(cp.area(p) for p in outlines)
        for outline in outlines:
            share = cp.area(outline) / total * float(free.sum()) * grid.size**2
            parts.append((cp.limit_corners(outline, 16), share))
    else:
        for component in _components(kept):
            parts += [
                (cp.limit_corners(_within(cp.grow(hull, grid.size), limits), 16), count * grid.size**2)
                for hull, count in _hulls(component, grid)
            ]
    result = []
    for outline, size in parts:
        points = frame.world(np.array([(x, y, 0.5 * gap) for x, y in outline]))
        result.append(OpenPart(i, j, points, size, normal, gap))
    return result


def _within(outline: cp.Polygon, limits: list[cp.Polygon]) -> cp.Polygon:
    for limit in limits:
        outline = cp.clip(outline, limit) or outline
    return outline


def _overlap(flat: np.ndarray, there: np.ndarray) -> list[cp.Polygon]:
    """The faces' common part, as few convex polygons as merging finds."""
    a = cp.merge([_counter_clockwise(t) for t in flat])
    b = cp.merge([_counter_clockwise(t) for t in there])
    return cp.merge([piece for p in a for q in b if (piece := cp.clip(p, q)) and cp.area(piece) > 1e-6])


def _convex(flat: np.ndarray) -> list[cp.Polygon]:
    """A face's outline when it is convex, else nothing."""
    whole = cp.hull((p[0], p[1]) for t in flat for p in t)
    total = sum(cp.area(_counter_clockwise(t)) for t in flat)
    return [whole] if len(whole) > 2 and cp.area(whole) - total <= 1e-6 * max(1.0, total) else []


def _counter_clockwise(tri: np.ndarray) -> cp.Polygon:
    flat = [(float(p[0]), float(p[1])) for p in tri]
    return flat if cp.area(flat) >= 0.0 else flat[::-1]


def _normal_z(local: np.ndarray) -> float:
    """The share of a polygon's normal along its frame's n, by Newell's sum."""
    following = np.roll(local, -1, axis=0)
    newell = np.cross(local, following).sum(axis=0)
    length = float(np.linalg.norm(newell))
    return float(newell[2]) / length if length > 0.0 else 0.0


def _without_slits(free: np.ndarray) -> np.ndarray:
    """Components that somewhere hold a square of SLIT cells; thinner ones are gaps between drawn things."""
    if free.shape[0] < SLIT or free.shape[1] < SLIT:
        return np.zeros_like(free)
    core = free[:-1, :-1] & free[1:, :-1] & free[:-1, 1:] & free[1:, 1:]
    kept = np.zeros_like(free)
    kept[:-1, :-1] |= core
    kept[1:, :-1] |= core
    kept[:-1, 1:] |= core
    kept[1:, 1:] |= core
    # What hangs on by a single cell is kept with it: grown back by one within the free cells.
    grown = kept.copy()
    grown[1:] |= kept[:-1]
    grown[:-1] |= kept[1:]
    grown[:, 1:] |= kept[:, :-1]
    grown[:, :-1] |= kept[:, 1:]
    return grown & free


def _spread(mask: np.ndarray, allowed: np.ndarray, steps: int) -> np.ndarray:
    """Grows the mask through allowed cells, a cell a step."""
    for _ in range(steps):
        grown = mask.copy()
        grown[1:] |= mask[:-1]
        grown[:-1] |= mask[1:]
        grown[:, 1:] |= mask[:, :-1]
        grown[:, :-1] |= mask[:, 1:]
        grown &= allowed | mask
        if (grown == mask).all():
            break
        mask = grown
    return mask


def _components(mask: np.ndarray) -> list[np.ndarray]:
    """Connected components (by edges) as arrays of (row, column), int (k, 2); union of row runs."""
    runs: list[tuple[int, int, int]] = []
    parent: list[int] = []

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    previous: list[int] = []
    for r in range(mask.shape[0]):
        line = np.concatenate([[False], mask[r], [False]])
        changes = np.nonzero(line[1:] != line[:-1])[0]
        current = []
        for start, end in zip(changes[::2], changes[1::2], strict=True):
            k = len(runs)
            runs.append((r, int(start), int(end)))
            parent.append(k)
            for m in previous:
                if runs[m][1] < end and runs[m][2] > start:
                    parent[root(m)] = root(k)
            current.append(k)
        previous = current
    groups: dict[int, list[np.ndarray]] = {}
    for k, (r, start, end) in enumerate(runs):
        columns = np.arange(start, end)
        groups.setdefault(root(k), []).append(np.column_stack([np.full(len(columns), r), columns]))
    return [np.concatenate(g) for g in groups.values()]


def _hulls(cells: np.ndarray, grid: _Grid, depth: int = 0) -> list[tuple[cp.Polygon, int]]:
    """Convex hulls that cover the cells, cut in two where a hull is mostly closed."""
    rows, columns = cells[:, 0], cells[:, 1]
    order = np.lexsort((columns, rows))
    cells = cells[order]
    rows, columns = cells[:, 0], cells[:, 1]
    firsts = np.nonzero(np.concatenate([[True], rows[1:] != rows[:-1]]))[0]
    lasts = np.concatenate([firsts[1:], [len(rows)]]) - 1
    points = []
    for f, last in zip(firsts, lasts, strict=True):
        for dy in (0, 1):
            points.append(grid.corner(rows[f] + dy, columns[f]))
            points.append(grid.corner(rows[f] + dy, columns[last] + 1))
    hull = cp.hull(points)
    if depth >= 4 or len(cells) * grid.size**2 > FULL * cp.area(hull):
        return [(hull, len(cells))]
    best = None
    for axis in (0, 1):
        low, high = int(cells[:, axis].min()), int(cells[:, axis].max())
        for cut in {low + (high - low + 1) * k // 8 for k in range(1, 8)}:
            side = cells[:, axis] < cut
            if not side.any() or side.all():
                continue
            cost = sum(
                (np.ptp(part[:, 0]) + 1) * (np.ptp(part[:, 1]) + 1) for part in (cells[side], cells[~side])
            )
            if best is None or cost < best[0]:
                best = (cost, side)
    if best is None:
        return [(hull, len(cells))]
    return [h for side in (best[1], ~best[1]) for h in _hulls(cells[side], grid, depth + 1)]


class _Grid:
    """Square cells over a rectangle of the face's plane; a cell is what its centre is."""

    def __init__(self, x0: float, y0: float, x1: float, y1: float) -> None:
        width, height = x1 - x0, y1 - y0
        least = min(width, height)
        # Faces beyond 9 m2 get coarser cells, up to twice as wide from 36 m2 on.
        size = CELL * min(2.0, max(1.0, math.sqrt(width * height) / 3.0))
        self.size = float(min(size, max(least / 8.0, 0.005)))
        if width * height / self.size**2 > 2_000_000:  # bounded memory: coarser cells on huge faces
            self.size = float(np.sqrt(width * height / 2_000_000))
        self.shape = (int(np.ceil(height / self.size - 1e-9)), int(np.ceil(width / self.size - 1e-9)))
        self.cells = self.shape[0] * self.shape[1]
        self.x0, self.y0 = float(x0), float(y0)
        self.x = self.x0 + (np.arange(self.shape[1]) + 0.5) * self.size
        self.y = self.y0 + (np.arange(self.shape[0]) + 0.5) * self.size

    def corner(self, row: int, column: int) -> tuple[float, float]:
        return (self.x0 + float(column) * self.size, self.y0 + float(row) * self.size)

    def window(
        self, polygon: np.ndarray
    ) -> tuple[slice, slice, np.ndarray, np.ndarray, np.ndarray] | None:
        """Rows, columns, their centres, and which lie in the convex polygon (k, 2)."""
        corners = polygon[:, :2].tolist()
        xs, ys = [p[0] for p in corners], [p[1] for p in corners]
        c0 = max(0, math.ceil((min(xs) - self.x0) / self.size - 0.5))
        c1 = min(self.shape[1], math.floor((max(xs) - self.x0) / self.size - 0.5) + 1)
        r0 = max(0, math.ceil((min(ys) - self.y0) / self.size - 0.5))
        r1 = min(self.shape[0], math.floor((max(ys) - self.y0) / self.size - 0.5) + 1)
        if c0 >= c1 or r0 >= r1:
            return None
        x, y = self.x[c0:c1], self.y[r0:r1]
        within: np.ndarray | None = None
        sign = 1.0 if cp.area(corners) >= 0.0 else -1.0
        for i in range(len(corners)):
            (ax, ay), (bx, by) = corners[i - 1], corners[i]
            dx, dy = sign * (bx - ax), sign * (by - ay)
            # Inclusive: a centre on the seam between two triangles belongs to both. The left side is dx (y - ay), the
            # right dy (x - ax): two vectors, compared as an outer product without a third array.
            left = dx * (y - ay) + 1e-9
            right = dy * (x - ax)
            if left.min() >= right.max():
                continue  # the whole window lies on this side
            good = left[:, None] >= right[None, :]
            within = good if within is None else within & good
        if within is None:
            within = np.ones((r1 - r0, c1 - c0), dtype=bool)
        return slice(r0, r1), slice(c0, c1), x, y, within

    def fill(self, mask: np.ndarray, polygon: np.ndarray) -> None:
        window = self.window(polygon)
        if window is not None:
            rows, columns, _, _, within = window
            mask[rows, columns] |= within
