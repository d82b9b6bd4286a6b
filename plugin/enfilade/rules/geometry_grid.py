# SPDX-License-Identifier: GPL-3.0-or-later
"""The voxel grid that rooms are looked for in: what is solid, how free columns run, and the levels where floors are missing.

Arrays are (nz, ny, nx). Lengths are metres and become voxels through `Grid.count`. Coordinates are those of the work frame: turned
so that most walls run along x and y, near the origin.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .geometry_pace import Progress

STEP = 0.10  # m: 0.20 loses thin rooms and slabs (a duplex house breaks), 0.05 costs ten times and gains nothing
COARSEST = 0.20  # m
MOST_VOXELS = 60_000_000  # 15 bytes each at the peak: 0.9 GB, so that with the triangles it stays below 2 GB
MARGIN = 4  # voxels of outdoors round the building: flooding it must get round every corner
WALKABLE = 1.80  # m of free height a person needs: what is lower is no storey of its own (plenums over ceilings are 1.0 to 1.7)
SPAN = 1.80  # m free above and below a level where a floor may be missing
BAND = (0.30, 2.00)  # m above a floor: where rooms are told apart; sills and steps lie below, lintels and ducts above
LANDING = 0.40  # m between a hole in a floor and the floor around it: railings stand there, and make two voxels solid
HANGING = 0.30  # m below a level without floors: ceilings of the storey below may hang that near
STRONG = 0.3  # of the longest level's walls: sills and lintels of cut walls begin and end less
LEAST_WALL = 0.1  # m: what is lower is the edge of a hung ceiling, no wall nor slab
UNDER = 1.5  # m of air below a missing floor: ceilings hang that far below it at most
FLOORLESS = 0.3  # share of a room's floor: with less it is missing, not full of holes
BESIDE_STAIR = 0.5  # m from a hole's free columns that air beside and under a flight in it may reach
DEEP_HOLE = 0.1  # m2 of a hole in a floor that must be free for SPAN below it; else it is a lower floor (split levels)
FREE_STEP = 1.20  # m above the floor at which only walls stand between a hole and its landing

HOLLOW = 0.50  # m: less than the narrowest cupboard one can see into, more than the hollow of most walls

SOLID, CLOSED, CAP = 1, 2, 4


@dataclass
class Grid:
    """origin: float64 (3,), the low corner. step: m. blocked: uint8 bits of SOLID, CLOSED, CAP."""

    origin: np.ndarray
    step: float
    blocked: np.ndarray
    levels: list[float] = field(default_factory=list)  # m, floors that rooms stand on, ascending
    caps: list[tuple[float, int]] = field(default_factory=list)  # level in m, layer of its voxels

    @property
    def shape(self) -> tuple[int, int, int]:
        return self.blocked.shape

    def count(self, metres: float) -> int:
        """Voxels in a length, at least 1."""
        return max(1, int(round(metres / self.step)))

    def layer(self, z: float) -> int:
        return int(np.floor((z - self.origin[2]) / self.step))

    def index(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) world to voxel indices (n, 3) as (z, y, x); may lie outside."""
        return np.floor((np.asarray(points) - self.origin) / self.step).astype(np.int64)[:, ::-1]

    def inside(self, index: np.ndarray) -> np.ndarray:
        return ((index >= 0) & (index < np.array(self.shape))).all(axis=1)

    def solid(self, points: np.ndarray, bits: int = SOLID) -> np.ndarray:
        """Whether each of the points (n, 3) lies in a voxel with one of these bits; bool (n,)."""
        index = self.index(points)
        there = self.inside(index)
        result = np.zeros(len(points), dtype=bool)
        result[there] = self.blocked[tuple(index[there].T)] & bits > 0
        return result


def between_jambs(ends: Iterable[np.ndarray]) -> bool:
    """Whether something stands at each end of a hole for half of its height at least. ends: what is solid there, bool (beyond the end, across, height)."""
    return all(solid.any(axis=(0, 1)).mean() >= 0.5 for solid in ends)


def plan(low: np.ndarray, high: np.ndarray) -> tuple[float, tuple[int, int, int]]:
    """Step and shape (nz, ny, nx) for a building within low..high, before anything is made."""
    step = STEP
    while True:
        shape = tuple(int(n) for n in np.ceil((high - low) / step)[::-1] + 2 * MARGIN)
        total = int(np.prod([float(n) for n in shape]))
        if total <= MOST_VOXELS or step >= COARSEST:
            return step, shape
        step = min(COARSEST, step * max(1.02, (total / MOST_VOXELS) ** (1 / 3)))


def make(low: np.ndarray, high: np.ndarray) -> Grid:
    step, shape = plan(low, high)
    # A little off, so that faces on whole decimetres don't fall on voxels' faces and mark both neighbours.
    origin = low - (MARGIN + 0.03719) * step
    return Grid(origin, step, np.zeros(shape, dtype=np.uint8))


def mark(native: Any, grid: Grid, meshes: Iterable[tuple[np.ndarray, np.ndarray]], bit: int) -> None:
    for vertices, triangles in meshes:
        native.voxels.mark(grid.blocked, grid.origin, grid.step, vertices, triangles, bit)


def dilate(native: Any, mask: np.ndarray, steps: int = 1, rise: int = 0) -> np.ndarray:
    """Grown by squares of 2 * steps + 1 in the last two axes, and by `rise` up and down. mask: bool (ny, nx) or (nz, ny, nx)."""
    wide = np.array(mask, dtype=np.uint8, order="C")
    if wide.size:
        native.voxels.widen(wide.reshape(-1, *wide.shape[-2:]), (steps, steps, rise))
    return wide.view(bool)


def fill_hollows(native: Any, grid: Grid, watch: Progress) -> None:
    """Makes the inside of walls and slabs solid: air that is shut in and nowhere HOLLOW wide in all three directions.

    Parity would need closed meshes; in a soup nobody knows whose a triangle is.
    """
    labels, count = native.voxels.label((grid.blocked == 0).astype(np.uint8))
    watch.at(0.6)
    wide = np.zeros(count + 1, dtype=bool)
    for side in (labels[0], labels[-1], labels[:, 0], labels[:, -1], labels[:, :, 0], labels[:, :, -1]):
        wide[side] = True
    steps = grid.count(HOLLOW) // 2
    core = np.where(dilate(native, grid.blocked != 0, steps, steps), np.uint32(0), labels)
    watch.at(0.8)
    wide |= native.voxels.boxes(core, count)[:, 1, 0] > 0
    wide[0] = True
    native.voxels.rename(labels, np.where(wide, 0, SOLID))
    grid.blocked |= labels.astype(np.uint8)


def label2(native: Any, mask: np.ndarray) -> tuple[np.ndarray, int]:
    """Regions of a plan (ny, nx) by edges."""
    labels, count = native.voxels.label(np.ascontiguousarray(mask[None], dtype=np.uint8))
    return labels[0], count


def reached(native: Any, mask: np.ndarray, start: np.ndarray, steps: int) -> np.ndarray:
    """What lies in mask within `steps` of start, walking inside mask."""
    front = start
    for _ in range(steps):
        front = front | (dilate(native, front) & mask)
    return front


# ---- levels ----------------------------------------------------------------------------------------------------
def wall_edges(meshes: Iterable[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper level edges of upright triangles: two arrays (n, 2) of height and length, m."""
    lower, upper = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for vertices, triangles in meshes:
        t = vertices[triangles]
        normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
        size = np.linalg.norm(normal, axis=1)
        t = t[(np.abs(normal[:, 2]) < 0.1 * size) & (size > 1e-6)]
        for k in range(3):
            a, b, c = t[:, k], t[:, (k + 1) % 3], t[:, (k + 2) % 3]
            level = np.abs(a[:, 2] - b[:, 2]) < 5e-3
            rise = c[:, 2] - a[:, 2]
            edge = np.column_stack([0.5 * (a[:, 2] + b[:, 2]), np.linalg.norm((b - a)[:, :2], axis=1)])
            lower.append(edge[level & (rise > LEAST_WALL)])
            upper.append(edge[level & (rise < -LEAST_WALL)])
    return np.concatenate(lower), np.concatenate(upper)


def peaks(heights: np.ndarray, weights: np.ndarray, least: float, apart: float) -> list[float]:
    """Heights where much weight gathers within 0.1 m, strongest first taken, none within `apart` of a stronger one."""
    if not len(heights):
        return []
    low = heights.min()
    bins = np.round((heights - low) / 0.05).astype(int)
    histogram = np.bincount(bins, weights)
    smooth = np.convolve(histogram, np.ones(3), "same")
    result: list[float] = []
    for k in np.argsort(-smooth, kind="stable"):
        if smooth[k] < least:
            break
        near = np.abs(bins - k) <= 1
        z = float(np.average(heights[near], weights=weights[near])) if weights[near].sum() > 0 else 0.0
        if all(abs(z - other) >= apart for other in result):
            result.append(z)
    return result


def wall_bases(edges: np.ndarray) -> list[float]:
    """The heights at which most walls begin (or, for upper edges, end): (n, 2) of height and length to heights, m."""
    found = peaks(edges[:, 0], edges[:, 1], max(5.0, 0.05 * float(edges[:, 1].sum())), 0.8)
    lengths = {z: float(edges[np.abs(edges[:, 0] - z) < 0.1, 1].sum()) for z in found}
    return [z for z in found if lengths[z] >= STRONG * max(lengths.values())]


def floor_faces(triangles: np.ndarray) -> np.ndarray:
    """Height and area of level triangles, float64 (n, 2), of triangles (m, 3, 3)."""
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.linalg.norm(cross, axis=1)
    level = (np.abs(cross[:, 2]) > 0.9999 * size) & (size > 1e-6)
    return np.column_stack([triangles[level][:, :, 2].mean(axis=1), 0.5 * size[level]])


def _drawn_at(z: float, faces: np.ndarray, reach: float) -> float:
    """The height within reach of z at which most of a floor is drawn; z when none is."""
    near = faces[np.abs(faces[:, 0] - z) <= reach]
    if not len(near):
        return z
    heights, inverse = np.unique(np.round(near[:, 0], 3), return_inverse=True)
    best = int(np.argmax(np.bincount(np.asarray(inverse).reshape(-1), near[:, 1])))
    return float(np.median(near[np.round(near[:, 0], 3) == heights[best], 0]))


def close_levels(native: Any, grid: Grid, lower: np.ndarray, upper: np.ndarray, faces: np.ndarray) -> None:
    """Caps where floors have holes or were never drawn, and over walls that carry no roof.

    A level is where people can stand under cover (walkable columns) or where walls begin. At a level, columns free for SPAN above and
    below are a hole: capped when it has a landing. A level that has no floor at all is capped everywhere, under sills and shelves too. Walls' tops without anything
    above are a level of that second kind. A cap never closes a view: it is a horizontal portal.
    """
    walk = grid.count(WALKABLE)
    span = grid.count(SPAN)
    nz = grid.shape[0]
    down, up = native.voxels.runs(grid.blocked)
    solid = grid.blocked & SOLID > 0
    floor = np.zeros(grid.shape, dtype=bool)
    floor[:-1] = solid[:-1] & (up[1:] >= walk) & (up[1:] < 255)
    area = grid.step**2
    per_layer = floor.reshape(nz, -1).sum(axis=1) * area
    tops = grid.origin[2] + (np.arange(nz) + 1) * grid.step
    floors = [_drawn_at(z, faces, grid.step) for z in peaks(tops, per_layer, max(4.0, 0.08 * float(per_layer.max())), 0.3)]
    # Sills, lintels and plinths begin walls too, but much less of them than storeys do.
    bases, heads = wall_bases(lower), wall_bases(upper)
    undrawn = [b for b in bases if all(abs(b - f) > 0.5 for f in floors)]
    # Where no floor is drawn over them, ceilings look like floors; no wall stands on one, and another storey begins too low over it.
    floors = [f for f in floors if any(abs(b - f) <= 0.5 for b in bases) or not any(0.5 < b - f < WALKABLE + grid.step for b in undrawn)]
    levels = floors + undrawn
    grid.levels = sorted(levels)
    for level in levels:  # the largest first: what it caps, a lesser one (sills, steps) finds too low
        _close(native, grid, level, floor, down, up, span, base=any(abs(level - b) <= 0.5 for b in bases), drawn=level in floors)
    for level in heads:
        _cover(grid, level, down, up, span)


def _layer_of(grid: Grid, level: float) -> int:
    return min(max(grid.layer(level - 0.25 * grid.step), 1), grid.shape[0] - 2)


def _close(
    native: Any, grid: Grid, level: float, floor: np.ndarray, down: np.ndarray, up: np.ndarray, span: int, base: bool, drawn: bool
) -> None:
    k = _layer_of(grid, level)
    reach = grid.count(0.15)
    here = floor[max(0, k - reach) : k + reach + 1].any(axis=0)
    waist = min(k + grid.count(FREE_STEP), grid.shape[0] - 1)
    passable = grid.blocked[waist] == 0
    missing, bare = _without_floor(native, grid, k, passable, down, up, span) if base else (False, np.zeros_like(passable))
    # A stair may stand in a hole: below it need not be free everywhere, only somewhere.
    hole = down[k] >= grid.count(HANGING)
    if not missing and not drawn:
        return  # walls begin here (sills, lintels), but a hole needs a floor round it
    if not missing:
        hole &= up[k].astype(int) + down[k] > span  # flights over flights, and sloped roofs, leave less than that above the level
        hole &= up[k] < 255  # under the sky: outdoors, which a door at floor level would join with the hole
    regions, count = label2(native, hole)
    if count == 0:
        return
    wanted = np.zeros(count + 1, dtype=bool)
    if missing:
        wanted[1:] = True
    else:
        steps = grid.count(LANDING)
        near = reached(native, passable | hole, here & passable, steps) & hole
        touching = np.bincount(regions[near], minlength=count + 1)
        deep = np.bincount(regions[hole & (down[k] >= span)], minlength=count + 1) * grid.step**2
        wanted = (touching >= 3) & (deep >= DEEP_HOLE)  # three columns: less is a corner
        border = np.unique(np.concatenate([regions[0], regions[-1], regions[:, 0], regions[:, -1]]))
        wanted[border] = False
        wanted[0] = False
    chosen = wanted[regions] & hole | bare & (down[k] >= grid.count(HANGING)) & (up[k] < 255)
    # Beside and under the flights in a hole, and over the tops of walls, there is air too: what is left open there would join the storeys.
    chosen = reached(native, (grid.blocked[k] == 0) & ((up[k] < 255) | missing), chosen, grid.count(BESIDE_STAIR))
    if chosen.any():
        grid.blocked[k][chosen] |= CAP
        grid.caps.append((level, k))
        _cut(grid, k, chosen, down, up)


def _without_floor(
    native: Any, grid: Grid, k: int, passable: np.ndarray, down: np.ndarray, up: np.ndarray, span: int
) -> tuple[bool, np.ndarray]:
    """Whether a level where walls begin, at layer k, has no floor at all, and the rooms of it that have none, bool (ny, nx). passable: where one gets
    through at the height of a waist. What is enclosed is judged, a storey's height above and nearly one below for most of it: sills and lintels are no
    level. A floor within reach below the waist counts: steps, a split level."""
    regions, count = label2(native, passable)
    border = np.unique(np.concatenate([regions[0], regions[-1], regions[:, 0], regions[:, -1]]))
    cells = np.bincount(regions.ravel(), minlength=count + 1)
    cells[border] = cells[0] = 0
    ground = grid.blocked[max(0, k - grid.count(0.3)) : k + grid.count(0.15) + 1].any(axis=0)
    floored, above, below = (
        np.bincount(regions[mask], minlength=count + 1) * (cells > 0) for mask in (ground, up[k] >= span, down[k] >= grid.count(UNDER))
    )

    def lacks(total: np.ndarray, floored: np.ndarray, above: np.ndarray, below: np.ndarray) -> np.ndarray:
        return (floored < FLOORLESS * total) & (2 * above >= total) & (2 * below >= total)

    missing = bool(cells.any() and lacks(cells.sum(), floored.sum(), above.sum(), below.sum()))
    rooms = lacks(cells, floored, above, below) & (cells * grid.step**2 >= LEAST_LOW)
    return missing, rooms[regions]


def _cover(grid: Grid, level: float, down: np.ndarray, up: np.ndarray, span: int) -> None:
    """Caps columns open to the sky at a height where walls end."""
    k = _layer_of(grid, level)
    sky = (down[k] >= span) & (down[k] < 255) & (up[k] == 255)
    if sky.any():
        grid.blocked[k][sky] |= CAP
        grid.caps.append((level, k))
        _cut(grid, k, sky, down, up)


def _cut(grid: Grid, k: int, chosen: np.ndarray, down: np.ndarray, up: np.ndarray) -> None:
    """Runs after a cap at layer k, as `runs` would give them."""
    blocked = ~chosen  # columns that aren't concerned end the walk at once
    going = ~blocked
    for j in range(k, -1, -1):
        going &= grid.blocked[j] == 0 if j < k else True
        if not going.any():
            break
        up[j][going] = k - j if k - j < 255 else 255
    going = chosen.copy()
    for j in range(k, grid.shape[0]):
        going &= grid.blocked[j] == 0 if j > k else True
        if not going.any():
            break
        down[j][going] = min(j - k, 255)


# ---- regions ---------------------------------------------------------------------------------------------------
OUTSIDE = 1  # the label of the exterior
LEAST_SEED = 0.4  # m2 of band in plan: less is a nook
LEAST_WIDTH = 3  # voxels from the middle of a room to its walls: narrower is the hollow of a wall
FLOOR = 0.40  # m above the floor: along it air belongs together however low it is (under a slope), for steps lower than that
PARAPET = 0.60  # m: half-height walls and counters up to that thick part nothing
REVEAL = 0.40  # m: what is left nearer than that to a region is its niche
LEAST_LOW = 3.0  # m2 in plan of air too low to stand in: more is a room of its own (a plenum, an attic, a crawl space)


def regions(native: Any, grid: Grid, watch: Progress, seeds_apart: int = 1) -> tuple[np.ndarray, int]:
    """Labels of the free voxels, uint32 (nz, ny, nx): 0 none, OUTSIDE, then rooms; and the highest label.

    Rooms are told apart in the band above each floor, farther than `seeds_apart` voxels from what is solid, and grown back: gaps narrower than
    twice that bridge by themselves. First along floors, then up and down, then into niches. Low air that is left is a room of its own if it is large,
    else part of what it meets.
    """
    low, high = grid.count(BAND[0]), grid.count(BAND[1])
    down, up = native.voxels.runs(grid.blocked)
    height = down.astype(np.uint16) + up
    height -= 1
    free = grid.blocked == 0
    band = (down > low) & (down <= high) & (height >= grid.count(WALKABLE))
    band |= free & (down == 255)
    watch.at(0.15)
    # Over what is lower than the band (half-height walls, counters) air hangs together where it does on both sides.
    over = grid.count(PARAPET) // 2
    band |= ~dilate(native, ~dilate(native, band, over), over) & free
    floor = free & ((down <= grid.count(FLOOR)) | (down == 255))
    del height, down, up
    watch.at(0.3)
    band &= ~dilate(native, ~free, seeds_apart)
    watch.at(0.35)
    labels, count = native.voxels.label(band.astype(np.uint8))
    del band
    watch.at(0.5)
    count = _numbered(native, grid, labels, count, seeds_apart)
    watch.at(0.55)
    _upright(labels, free)
    watch.at(0.6)
    native.voxels.grow(labels, floor.astype(np.uint8))
    watch.at(0.7)
    _upright(labels, free)
    passable = free.astype(np.uint8)
    native.voxels.grow(labels, passable, grid.count(REVEAL))
    watch.at(0.8)
    count = _low_rooms(native, grid, labels, free, count)
    watch.at(0.9)
    native.voxels.grow(labels, passable)
    return labels, count


def _numbered(native: Any, grid: Grid, labels: np.ndarray, count: int, seeds_apart: int) -> int:
    """Drops nooks and hollows, makes all that reaches the grid's sides OUTSIDE, and numbers the rest on; gives the highest label."""
    columns = np.zeros(count + 1, dtype=np.int64)
    wide = np.zeros(count + 1, dtype=bool)
    for label, where in boxes(native, labels, count):
        plan_ = (labels[where] == label).any(axis=0)
        columns[label] = plan_.sum()
        wide[label] = _is_wide(native, plan_, LEAST_WIDTH - 1 - seeds_apart)
    is_outer = np.zeros(count + 1, dtype=bool)
    for side in (labels[:, 0], labels[:, -1], labels[:, :, 0], labels[:, :, -1]):
        is_outer[side] = True
    is_outer[0] = False
    keep = (columns * grid.step**2 >= LEAST_SEED) & wide & ~is_outer
    keep[0] = False
    number = np.zeros(count + 1, dtype=np.uint32)
    number[is_outer] = OUTSIDE
    number[keep] = np.arange(keep.sum(), dtype=np.uint32) + OUTSIDE + 1
    native.voxels.rename(labels, number)
    return int(keep.sum()) + OUTSIDE


def _is_wide(native: Any, mask: np.ndarray, steps: int) -> bool:
    """Whether some cell is farther than `steps` from what isn't in the mask."""
    return bool((~dilate(native, ~np.pad(mask, 1), max(0, steps))).any())


def _upright(labels: np.ndarray, free: np.ndarray) -> None:
    """Labels go up and down their columns as far as these are free; what two labels reach goes to the lower one."""
    for k in range(1, len(labels)):
        take = free[k] & (labels[k] == 0)
        labels[k][take] = labels[k - 1][take]
    for k in range(len(labels) - 2, -1, -1):
        take = free[k] & (labels[k] == 0)
        labels[k][take] = labels[k + 1][take]


def _low_rooms(native: Any, grid: Grid, labels: np.ndarray, free: np.ndarray, count: int) -> int:
    """New labels for large leftovers, low attics and crawl spaces shut on all sides too: what stands there is in a room. Gives the highest label."""
    rest = free & (labels == 0)
    left, many = native.voxels.label(rest.astype(np.uint8))
    for label, where in boxes(native, left, many):
        plan_ = (left[where] == label).any(axis=0)
        if plan_.sum() * grid.step**2 < LEAST_LOW or where[0].stop - where[0].start < grid.count(REVEAL) or not _is_wide(native, plan_, LEAST_WIDTH - 1):
            continue
        part = labels[where]
        part[left[where] == label] = count = count + 1
    return count


def boxes(native: Any, labels: np.ndarray, count: int) -> list[tuple[int, tuple[slice, slice, slice]]]:
    """Bounding boxes of labels 1..count."""
    found = native.voxels.boxes(labels, count)[:, :, ::-1].tolist()
    return [(label, tuple(map(slice, *found[label]))) for label in range(1, count + 1) if found[label][1][0]]
