# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings in walls that only triangles show: holes under a lintel.

Free columns that end under a solid which is thin across (a wall), where the air beside it goes on higher. What is found is shut while rooms are
told apart; each becomes an opening, put outward on the planes around it. A gap as high as the room is no opening: rooms that meet there are one
(closing gaps between wall ends was tried: it divides rooms at piers and wardrobes more often than it finds doors). Coordinates: the work frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .building import DOOR, HOLE, OPEN, WINDOW
from .geometry_elements import Element
from .geometry_grid import CAP, CLOSED, SOLID, Grid, between_jambs, boxes, dilate, label2
from .geometry_pace import Progress
from .geometry_rooms import Planes
from .probing import Frame, Passage

WALL = 0.70  # m: what is wider than that is a ceiling, a slab or a landing, no lintel
CLEAR = (0.40, 3.20)  # m of free height under a lintel: from a small window to a gate
WIDEST = 3.20  # m along the wall down to the floor: a beam over an open room is longer
SILL = 0.30  # m above the floor from which on a hole is a window, of any width: wall above and below
LEVEL_HEAD = 2  # voxels that a lintel's underside may vary: more is a slope
UNDER_CAP = 0.40  # m: what hangs no lower under a floor that was never drawn is a beam, no lintel
JAMB = (0.5, 1.5, 2.5)  # voxels beyond the columns of a hole where its jambs begin
DOOR_SIZE = ((0.5, 2.4), (1.7, 2.6))  # m: width and height of what is called a door


@dataclass
class Hole:
    columns: np.ndarray  # int (n, 2): y, x
    low: int  # first free layer
    high: int  # layer of the lintel


def find(native: Any, grid: Grid, planes: Planes, watch: Progress) -> list[Element]:
    """All holes, shut in the grid."""
    found = []
    for hole in watch.over(lintels(native, grid, watch), 0.8):
        e = _element(grid, hole, planes)
        if e is not None:
            _shut(grid, hole)
            found.append(e)
    return found


def _shut(grid: Grid, hole: Hole) -> None:
    y, x = hole.columns[:, 0], hole.columns[:, 1]
    part = grid.blocked[hole.low : hole.high, y, x]
    grid.blocked[hole.low : hole.high, y, x] = np.where(part == 0, CLOSED, part)


def lintels(native: Any, grid: Grid, watch: Progress) -> list[Hole]:
    down, _ = native.voxels.runs(grid.blocked)
    solid = grid.blocked & SOLID > 0
    least, most = grid.count(CLEAR[0]), grid.count(CLEAR[1])
    half = grid.count(WALL) // 2
    under = np.zeros(grid.shape, dtype=np.uint8)
    for k in watch.over(range(1, grid.shape[0]), 0.0, 0.5):
        d = down[k - 1]
        below = solid[k] & (d >= least) & (d <= most)
        if not below.any():
            continue
        # Thin: no square of WALL fits into the solid here.
        core = ~dilate(native, ~solid[k], half)
        under[k - 1] = below & ~dilate(native, core, half)
    tall = under.astype(bool)
    tall[1:] |= under[:-1] > 0
    tall[:-1] |= under[1:] > 0
    labels, count = native.voxels.label(tall.astype(np.uint8))
    result = []
    for label, where in watch.over(boxes(native, labels, count), 0.5, 0.8):
        k, j, i = np.nonzero((labels[where] == label) & (under[where] > 0))
        if not len(k):
            continue
        k, j, i = k + where[0].start, j + where[1].start, i + where[2].start
        head = int(np.median(k))
        level = np.abs(k - head) <= LEVEL_HEAD
        if level.mean() < 0.7:
            continue
        k, j, i = k[level], j[level], i[level]
        bottoms = k - down[k, j, i].astype(int) + 1
        for low, mine in _by_bottom(grid, bottoms):
            columns = np.column_stack([j[mine], i[mine]])
            for part in _together(native, columns):
                top = int(k[mine].max()) + 1
                if _is_hole(grid, columns[part], low, top, down):
                    result.append(Hole(columns[part], low, top))
    return result


def _by_bottom(grid: Grid, bottoms: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """Columns whose floors or sills are level, as masks; sills and floors of one lintel are different holes."""
    order = np.unique(bottoms)
    groups: list[list[int]] = []
    for b in order.tolist():
        if groups and b - groups[-1][-1] <= grid.count(0.25):
            groups[-1].append(b)
        else:
            groups.append([b])
    return [(g[0], np.isin(bottoms, g)) for g in groups]


def _together(native: Any, columns: np.ndarray) -> list[np.ndarray]:
    """Columns that hang together in plan, as masks."""
    low = columns.min(axis=0)
    mask = np.zeros(columns.max(axis=0) - low + 1, dtype=bool)
    mask[columns[:, 0] - low[0], columns[:, 1] - low[1]] = True
    regions, count = label2(native, mask)
    owner = regions[columns[:, 0] - low[0], columns[:, 1] - low[1]]
    return [owner == n for n in range(1, count + 1)]


def _is_hole(grid: Grid, columns: np.ndarray, low: int, top: int, down: np.ndarray) -> bool:
    frame = _frame(columns)
    length, depth = frame[3] * grid.step, frame[4] * grid.step
    if length < 0.35 or depth > WALL + 2 * grid.step:
        return False
    if not _between_jambs(grid, frame, low, top):
        return False  # under a sill that sticks out of a facade, down to the next one
    # The floor on both sides tells a door from a window; the air on at least one side goes on above the head.
    normal = frame[1]
    beside = [_beside(grid, columns, s * normal, depth) for s in (1.0, -1.0)]
    higher, sill = 0, []
    for cells in beside:
        if not len(cells):
            continue
        y, x = cells[:, 0], cells[:, 1]
        above = min(top + 1, grid.shape[0] - 1)
        beam = (grid.blocked[top : top + grid.count(UNDER_CAP), y, x] & CAP > 0).any(axis=0)
        higher += bool(((grid.blocked[above, y, x] == 0) & ~beam).mean() > 0.5)
        middle = (low + top) // 2
        d = down[middle, y, x].astype(int)
        free = d > 0
        if free.any():
            sill.append(int(np.median(np.minimum(d[free], 254))) - (middle - low + 1))
    if not higher or not sill:
        return False
    bottom = grid.origin[2] + low * grid.step
    if any(abs(level - bottom) < SILL for level in grid.levels):
        return length <= WIDEST
    if min(sill) < grid.count(SILL):  # over the higher of the floors beside it
        return length <= WIDEST and top - low >= grid.count(DOOR_SIZE[1][0])
    return True


def _between_jambs(grid: Grid, frame: tuple[np.ndarray, np.ndarray, np.ndarray, float, float], low: int, top: int) -> bool:
    """Whether something stands at both ends of a hole for half of its height at least: wall, or what shuts the next hole."""
    middle, normal, along, length, depth = frame
    across = np.linspace(-0.5, 0.5, max(2, int(depth))) * max(0.0, depth - 1.0)
    heights = grid.origin[2] + (np.arange(low, top) + 0.5) * grid.step
    ends = []
    for sign in (-1.0, 1.0):
        cells = np.array([[middle + sign * (0.5 * length + off) * along + t * normal for t in across] for off in JAMB])
        plan = np.broadcast_to((grid.origin[:2] + cells * grid.step)[:, :, None], (*cells.shape[:2], len(heights), 2))
        points = np.concatenate([plan, np.broadcast_to(heights[:, None], (*plan.shape[:3], 1))], axis=3)
        ends.append(grid.solid(points.reshape(-1, 3), SOLID | CLOSED | CAP).reshape(plan.shape[:3]))
    return between_jambs(ends)


def _frame(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, float]:
    """Middle (x, y), normal, direction along; length and depth in voxels. Axes of the grid unless the hole is plainly askew."""
    points = columns[:, ::-1].astype(np.float64) + 0.5
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    size = np.ptp(points, axis=0) + 1.0
    filled = len(points) / float(size.prod())
    if filled > 0.7 or len(points) < 12:
        along = np.array([1.0, 0.0]) if size[0] >= size[1] else np.array([0.0, 1.0])
        return middle, np.array([-along[1], along[0]]), along, float(size.max()), float(size.min())
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    along, normal = axes[0], axes[1]
    spread = np.ptp((points - middle) @ np.stack([along, normal]).T, axis=0) + 1.0
    return middle, normal, along, float(spread[0]), float(spread[1])


def _beside(grid: Grid, columns: np.ndarray, normal: np.ndarray, depth: float) -> np.ndarray:
    """Columns a wall's depth and half a metre out on one side, (n, 2) y, x within the grid."""
    shift = np.round(normal * (0.5 * depth + 0.35) / grid.step).astype(int)
    middle, _, _, _, _ = _frame(columns)
    n = normal / np.linalg.norm(normal)
    offset = (columns[:, ::-1] + 0.5 - middle) @ n
    spine = columns[np.abs(offset) <= 0.75]
    cells = spine + shift[::-1]
    good = ((cells >= 0) & (cells < np.array(grid.shape[1:]))).all(axis=1)
    return cells[good]


def _element(grid: Grid, hole: Hole, planes: Planes) -> Element | None:
    """The opening of a hole: its box, each side moved outward onto the plane in the next voxel."""
    middle, normal, along, length, depth = _frame(hole.columns)
    axes = abs(along[0]) > 0.999 or abs(along[1]) > 0.999
    centre = grid.origin[:2] + middle * grid.step
    z0, z1 = (float(grid.origin[2] + k * grid.step) for k in (hole.low, hole.high))
    half = 0.5 * length * grid.step
    thick = 0.5 * depth * grid.step
    # Outward: what is free may reach into the next voxel on every side.
    u0, u1 = -half - grid.step, half + grid.step
    bottom, top = z0 - grid.step, z1 + grid.step
    box_low, box_high = centre - half, centre + half
    if axes:
        a = int(abs(along[1]) > 0.5)  # the axis that runs along the wall
        at = float(centre[a])
        low = np.array([float(centre[1 - a]) - thick, z0])
        high = np.array([float(centre[1 - a]) + thick, z1])
        for sign in (-1.0, 1.0):
            edge = at + sign * half
            plane = planes.walls[a].outward(edge - 0.02 * sign, edge + sign * (grid.step + 0.02), low, high, sign)
            if plane is not None:
                if sign * along[a] < 0:
                    u0 = (plane - at) * along[a]
                else:
                    u1 = (plane - at) * along[a]
    plane = planes.levels.outward(z1 - 0.02, z1 + grid.step + 0.02, box_low, box_high, 1.0)
    top = plane if plane is not None else top
    plane = planes.levels.outward(z0 + 0.02, z0 - grid.step - 0.02, box_low, box_high, -1.0)
    bottom = plane if plane is not None else bottom
    if top - bottom < 0.2 or u1 - u0 < 0.2:
        return None
    frame = Frame.along(np.array([normal[0], normal[1], 0.0]), np.array([*centre, 0.5 * (top + bottom)]))
    sign = 1.0 if float(frame.u[:2] @ along) > 0 else -1.0
    v0, v1 = sorted((sign * u0, sign * u1))
    h = 0.5 * (top - bottom)
    section = [(v0, -h), (v1, -h), (v1, h), (v0, h)]
    passage = planes.through_wall(Passage(frame, section, (-thick, thick), (-thick, thick)), grid.step)
    width, height = u1 - u0, top - bottom
    sill = not any(abs(level - bottom) < SILL for level in grid.levels)
    if sill:
        kind = WINDOW
    elif DOOR_SIZE[0][0] <= width <= DOOR_SIZE[0][1] and DOOR_SIZE[1][0] <= height <= DOOR_SIZE[1][1]:
        kind = DOOR
    else:
        kind = HOLE
    corners = passage.corners
    return Element("", kind, corners, np.zeros((0, 3), dtype=np.int64), "", OPEN, "", passage)
