# SPDX-License-Identifier: GPL-3.0-or-later
"""Which leaves, panes and solid boxes of a polygon soup fill a hole in a wall: doors and windows. The grid tells, once the shell is in it.

Each is looked at in the direction of its own upright faces, so that walls askew to the grid have doors as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import geometry_frame
from .box_index import BoxIndex
from .building import DOOR, GLASS, OPEN, WINDOW
from .geometry_elements import Element
from .geometry_grid import SOLID, WALKABLE, Grid, between_jambs, mark
from .geometry_pace import Progress
from .geometry_soup import BROADEST_BAR, DOOR_WIDE, PANEL_THICK, STRING_THICK, Soup, beside, equal_runs

AIR_OVER = 0.5  # share of a deep piece's columns with air, and a ceiling, over them: more than a frame's under its lintel
HANGS, FILLS, WALL = "hangs", "fills", "wall"
DEEPEST = 0.7  # m: a window with its sills is no deeper; what is may be a cupboard under a beam
FRAME = 0.15  # m that a frame reaches beyond its leaf
SASHES = 1.2  # m: and that far at most where it holds other sashes too
NEAR_FRAME = 0.03  # m between what touches
DOOR_LEAF = 0.06  # m: what is as high as its room, between jambs, is a leaf up to that thick, and a wall beyond
NEAR_SOLID = (0.05, 0.15, 0.25)  # m from a leaf or its frame: lintel and jambs begin there
BEHIND = (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)  # m to either side of a leaf where its wall would be if there were no hole
IN_WALL = 0.1  # m: a leaf flush with one face of its wall has the wall's middle that far to a side
CLEAR_OF_WALL = 0.6  # m to either side of a leaf: beyond the wall's face


def settle(native: Any, grid: Grid, soup: Soup, watch: Progress) -> list[Element]:
    """Leaves that fill a hole in a wall, together with their frames, as openings; the others are marked as solid, and what is tall too."""
    result: list[Element] = []
    for e in watch.over([*soup.tall, *soup.plugs], 0.0, 0.2):
        turn, box = _own_frame(e), e.vertices
        low, high = _extent(box @ turn)
        tall = float((high - low)[:2].min()) > PANEL_THICK
        if _is_box_in_hole(grid, turn, low, high, tall):
            result.append(_opening(box, grid))
        elif not (tall and _stands_free(native, grid, e)):
            mark(native, grid, [(e.vertices, e.triangles)], SOLID)
    result += _skylights(native, grid, soup.lids)
    for turn, leaves in watch.over(_by_direction(soup.leaves), 0.2, 0.5):
        frames = BoxIndex(*_bounds(soup.frames, turn))
        for group, low, high in _together(leaves, turn, frames):
            thin = int(np.argmin((high - low)[:2]))
            reach = np.full(3, FRAME)
            reach[thin] = PANEL_THICK
            framing = frames.near(low - reach, high + reach)
            framing = framing[((frames.low[framing] >= low - reach) & (frames.high[framing] <= high + reach)).all(axis=1)]
            around = [soup.frames[k].vertices for k in framing.tolist()]
            corners = np.concatenate([*(e.vertices for e in group), *around, np.array([low, high]) @ turn.T])
            thickest = max(float(np.ptp((e.vertices @ turn)[:, thin])) for e in group)
            what = _place(_Probe(grid, turn, thin, 0.5 * (low[thin] + high[thin])), low, high, thickest, *_extent(corners @ turn))
            if what == WALL:
                mark(native, grid, [(e.vertices, e.triangles) for e in group], SOLID)
            if what == FILLS:
                result.append(_opening(corners, grid))
    return result


def _skylights(native: Any, grid: Grid, lids: Sequence[Element]) -> list[Element]:
    """Lids that lie over air with a roof all round them; the others are marked as solid."""
    result = []
    for group, low, high in _grouped(lids, *_bounds(lids, np.eye(3))) if lids else []:
        if _closes_hole(grid, low, high):
            result.append(_opening(np.concatenate([e.vertices for e in group]), grid))
        else:
            mark(native, grid, [(e.vertices, e.triangles) for e in group], SOLID)
    return result


def _closes_hole(grid: Grid, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether under the middle of a lid in the box low..high there is a room's height of air, and something solid on its four sides, a roof's thickness
    below it at most."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    spread = np.linspace(-0.5, 0.5, 3)
    under = np.arange(low[2] - DEEPEST - WALKABLE, low[2] - 0.5 * grid.step, grid.step)
    inner = [(middle[0] + a * half[0], middle[1] + b * half[1], z) for a in spread for b in spread for z in under]
    if grid.solid(np.array(inner)).mean() > 0.2:
        return False
    edge = under[under > low[2] - DEEPEST]
    sides = []
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            points = np.zeros((len(spread), len(NEAR_SOLID), len(edge), 3))
            points[..., axis] = middle[axis] + sign * (half[axis] + np.array(NEAR_SOLID)[:, None])
            points[..., 1 - axis] = (middle[1 - axis] + spread * half[1 - axis])[:, None, None]
            points[..., 2] = edge
            sides.append(grid.solid(points.reshape(-1, 3)).reshape(points.shape[:3]).any(axis=(1, 2)).all())
    return all(sides)


def _own_frame(e: Element) -> np.ndarray:
    """Columns: the directions that an element's upright faces run along and across, and up, float64 (3, 3)."""
    corners = e.vertices[e.triangles]
    turn = geometry_frame.own_directions(corners, np.zeros(len(corners), dtype=np.int64), 1)
    return geometry_frame.rotation(float(np.degrees(turn[0])))


def _by_direction(elements: Sequence[Element]) -> list[tuple[np.ndarray, list[Element]]]:
    """Elements whose upright faces run alike (to 2 degrees), with their common frame."""
    groups: list[tuple[np.ndarray, list[Element]]] = []
    for e in elements:
        turn = _own_frame(e)
        members = next((m for t, m in groups if float(t[:, 0] @ turn[:, 0]) > 0.9994), None)
        if members is None:
            groups.append((turn, members := []))
        members.append(e)
    return groups


def _extent(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return points.min(axis=0), points.max(axis=0)


def _is_box_in_hole(grid: Grid, turn: np.ndarray, low: np.ndarray, high: np.ndarray, tall: bool) -> bool:
    thin = int(np.argmin((high - low)[:2]))
    probe = _Probe(grid, turn, thin, 0.5 * (low[thin] + high[thin]))
    if tall:
        ends = np.array([-1.0, 1.0]) * (0.5 * (high - low)[thin] + max(NEAR_SOLID))
        places = np.linspace(low[1 - thin], high[1 - thin], 7)[1:-1]
        if (high - low)[thin] > DEEPEST or probe.solid(places, ends, _heights(low, high)).any(axis=(1, 2)).mean() > 0.5:
            return False  # a wall behind it: a cupboard in a niche
    return _place(probe, low, high, np.inf, low, high) == FILLS and probe.between_jambs(low, high)


def _together(leaves: Sequence[Element], turn: np.ndarray, frames: BoxIndex) -> list[tuple[list[Element], np.ndarray, np.ndarray]]:
    """Leaves that are sashes of one opening, beside each other or within one frame: the leaves, and the bounds of the frames round them."""
    if not leaves:
        return []
    wide = np.array([_framed(a, b, frames) for a, b in zip(*_bounds(leaves, turn), strict=True)])
    return _grouped(leaves, wide[:, 0], wide[:, 1])


def _grouped(elements: Sequence[Element], low: np.ndarray, high: np.ndarray) -> list[tuple[list[Element], np.ndarray, np.ndarray]]:
    """Elements whose boxes low..high lie beside each other, and the box of each group."""
    group = beside(low, high)
    order = np.argsort(group, kind="stable")
    members = [m.tolist() for m in np.split(order, equal_runs(group[order])[0][1:])]
    return [([elements[i] for i in m], low[m].min(axis=0), high[m].max(axis=0)) for m in members]


def _framed(low: np.ndarray, high: np.ndarray, frames: BoxIndex) -> tuple[np.ndarray, np.ndarray]:
    """The bounds of a leaf, grown to those of the frame it stands in with other sashes: a pair of bars that run along two sides of it and end
    alike, or a piece round it."""
    thin = int(np.argmin((high - low)[:2]))
    reach = FRAME + NEAR_FRAME
    near = frames.near(low - reach, high + reach)
    near = near[frames.high[near, thin] - frames.low[near, thin] <= STRING_THICK]
    a, b = frames.low[near], frames.high[near]
    best = low, high
    for axis, side in ((2, 1 - thin), (1 - thin, 2)):
        over = np.stack([low[axis] - a[:, axis], b[:, axis] - high[axis]])  # beyond the leaf, m
        along = (over >= -NEAR_FRAME).all(axis=0) & (over <= SASHES).all(axis=0)
        narrow = along & ((b - a)[:, side] <= BROADEST_BAR)
        first, last = narrow & (b[:, side] <= low[side] + NEAR_FRAME), narrow & (a[:, side] >= high[side] - NEAR_FRAME)
        alike = np.abs(over[:, first][:, :, None] - over[:, last][:, None]).max(axis=0) <= NEAR_FRAME
        round_it = along & (over.min(axis=0) <= reach) & (np.abs([a[:, side] - low[side], b[:, side] - high[side]]) <= reach).all(axis=0)
        for k in [*np.nonzero(first)[0][alike.any(axis=1)].tolist(), *np.nonzero(round_it)[0].tolist()]:
            grown = low.copy(), high.copy()
            grown[0][axis], grown[1][axis] = min(low[axis], a[k, axis]), max(high[axis], b[k, axis])
            best = max(best, grown, key=lambda box: float((box[1] - box[0]).sum()))
    return best


def _bounds(elements: Sequence[Element], turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners in a frame of its own, float64 (n, 3) each."""
    if not elements:
        return np.zeros((0, 3)), np.zeros((0, 3))
    points = np.concatenate([e.vertices for e in elements]) @ turn
    starts = np.cumsum([0, *(len(e.vertices) for e in elements[:-1])])
    return np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)


def _opening(corners: np.ndarray, grid: Grid) -> Element:
    floor = any(abs(float(corners[:, 2].min()) - z) < 0.3 for z in grid.levels)
    kind = DOOR if floor and np.ptp(corners[:, 2]) > 1.7 else WINDOW
    state = OPEN if kind == DOOR else GLASS
    return Element("", kind, corners, np.zeros((0, 3), dtype=np.int64), "", state)


def _stands_free(native: Any, grid: Grid, e: Element) -> bool:
    """Whether a room's air goes on over much of a piece: a cupboard, or a door drawn open. Under the sky nothing is told."""
    low, high = grid.index(np.array([e.vertices.min(axis=0), e.vertices.max(axis=0)]))
    k = min(int(high[0]) + 2, grid.shape[0] - 1)
    box = tuple(slice(max(0, a), b + 1) for a, b in zip(low, high, strict=True))
    own = np.zeros([s.stop - s.start for s in box], dtype=np.uint8)
    origin = grid.origin + np.array([s.start for s in box][::-1]) * grid.step
    native.voxels.mark(own, origin, grid.step, e.vertices, e.triangles, SOLID)
    columns = (own > 0).any(axis=0)
    over = grid.blocked[(slice(k, None), *box[1:])]
    free = (over[0] & SOLID == 0) & (over & SOLID > 0).any(axis=0)
    return bool(free[columns].mean() >= AIR_OVER)


@dataclass
class _Probe:
    """Asks the grid about points round what is thin along one axis of its own frame: every place along, offset across, height."""

    grid: Grid
    turn: np.ndarray  # float64 (3, 3), the frame's axes as columns
    thin: int
    middle: float

    def solid(self, along: Sequence[float], across: Sequence[float], heights: Sequence[float]) -> np.ndarray:
        """bool (len(along), len(across), len(heights))"""
        points = np.zeros((len(along), len(across), len(heights), 3))
        points[..., 1 - self.thin] = np.array(along)[:, None, None]
        points[..., self.thin] = self.middle + np.array(across)[None, :, None]
        points[..., 2] = np.array(heights)
        return self.grid.solid(points.reshape(-1, 3) @ self.turn.T).reshape(points.shape[:3])

    def between_jambs(self, low: np.ndarray, high: np.ndarray) -> bool:
        """Whether something solid stands at both ends, for most of the height."""
        along = 1 - self.thin
        ends = [[end + sign * off for off in NEAR_SOLID] for end, sign in ((low[along], -1.0), (high[along], 1.0))]
        return between_jambs(self.solid(end, [0.0, -IN_WALL, IN_WALL], _heights(low, high)) for end in ends)


def _place(
    probe: _Probe, low: np.ndarray, high: np.ndarray, thickest: float, frame_low: np.ndarray, frame_high: np.ndarray
) -> str:
    """What leaves in the box low..high, thin along an axis, with a frame round them, are: HANGS before a wall; FILLS a hole in one, under a
    lintel (solid above, with air on at least one side of it) or, as high as the room, between two jambs with air on both sides; or WALL."""
    along = 1 - probe.thin
    places = np.linspace(low[along], high[along], 7)[1:-1]
    heights = _heights(low, high)
    if probe.solid(places, BEHIND, heights).any(axis=1).mean() > 0.5:
        return HANGS
    tops = [top + rise for top in (high[2], frame_high[2]) for rise in NEAR_SOLID]
    lintel = probe.solid(places, [0.0, -IN_WALL, IN_WALL], tops)
    covered = lintel.any(axis=(1, 2))
    if covered.sum() < 3:
        return WALL
    first = np.array(tops)[lintel.any(axis=1).argmax(axis=1)]  # where the lintel of each place was met
    for side in (-CLEAR_OF_WALL, CLEAR_OF_WALL):
        if sum(not probe.solid([p], [side], [z]).any() for p, z in zip(places[covered], first[covered], strict=True)) >= 3:
            return FILLS
    if thickest > DOOR_LEAF or high[along] - low[along] > DOOR_WIDE:
        return WALL
    if not probe.between_jambs(frame_low, frame_high):
        return WALL
    return WALL if probe.solid(places, [-CLEAR_OF_WALL, CLEAR_OF_WALL], heights).any() else FILLS


def _heights(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.linspace(low[2], high[2], 5)[1:-1]
