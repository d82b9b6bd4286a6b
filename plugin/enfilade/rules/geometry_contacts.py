# SPDX-License-Identifier: GPL-3.0-or-later
"""Where regions of free voxels meet without a wall: holes in floors (caps), open sides, and gaps that leak.

A hole is a flat portal in its floor. Rooms that meet in free air end in steps of voxels, and their outlines reach over each other: the portal
between them is a slab from the middle of the last voxels on one side to the middle of those on the other, so that who stands where
both rooms are stands in it too. Safe direction: rectangles round the voxels that meet, grown by one voxel; nothing that meets is left without one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .geometry_grid import CAP, Grid, dilate, label2
from .geometry_pace import Progress

NECK = 3  # voxels on either side: a gap of twice that joins rooms into one, and is told
NECK_AT = 1.20  # m above the floor: sills and furniture lie below
LEAST_PART = 3.0  # m2 of each part beside a neck, without the voxels near walls: a bay or a niche is no room
COVERED = 0.9  # share of a room's columns that have a ceiling; what lies under eaves and balconies has less
LEAK = 0.5  # m2: smaller contacts are gaps in what was drawn, told as such
STAIR_WALL = 0.3  # m: what stands in a hole between two flights is no thicker than twice that
TOGETHER = 3  # voxels: contacts of one pair in planes that near are one portal


@dataclass
class Contact:
    labels: tuple[int, int]  # that on the low side of the axis first
    axis: int  # 0 x, 1 y, 2 z: what the portal faces
    ends: tuple[np.ndarray, np.ndarray]  # float64 (4, 3) each, where it meets the two; the same one twice: it is flat
    area: float  # m2 of voxel faces that meet
    cap: bool  # a hole in a floor


def find(native: Any, grid: Grid, labels: np.ndarray, watch: Progress) -> list[Contact]:
    found: list[Contact] = []
    for axis in watch.over((0, 1, 2), 0.7, 0.8):  # x, y, z
        dim = 2 - axis
        a = np.moveaxis(labels, dim, 0)[:-1]
        b = np.moveaxis(labels, dim, 0)[1:]
        index = np.nonzero(a != b)  # few; and few of these meet in air
        low, high = a[index], b[index]
        meet = (low != 0) & (high != 0)
        found += _group(native, grid, axis, tuple(i[meet] for i in index), low[meet], high[meet], False)
    cap = grid.blocked & CAP != 0
    cap[0] = cap[-1] = False
    k, j, i = np.nonzero(cap)
    below, above = labels[k - 1, j, i], labels[k + 1, j, i]
    meet = (below != 0) & (above != 0) & (below != above)
    index = (k[meet], j[meet], i[meet])
    found += _group(native, grid, 2, index, below[meet], above[meet], True)
    return found


def necks(native: Any, grid: Grid, mask: np.ndarray, corner: np.ndarray, covered: np.ndarray | None = None) -> list[tuple[np.ndarray, float]]:
    """Where a room is as narrow as a gap in a wall, with room on both sides: position float64 (3,) and width in m of each. mask: a level
    slice of it, bool (ny, nx); corner: int (3,), x, y, z of the slice's first voxel in the grid. covered: for outdoors, the columns under a ceiling, of which
    one side must be made (else it is no room)."""
    if covered is not None:  # outdoors goes on round the grid
        beyond = 3 * NECK
        mask, covered = np.pad(mask, beyond, constant_values=True), np.pad(covered, beyond)
        corner = corner - (beyond, beyond, 0)
    parts, count = label2(native, ~dilate(native, np.pad(~mask, NECK, constant_values=True), NECK)[NECK:-NECK, NECK:-NECK])
    large = np.bincount(parts.ravel(), minlength=count + 1) * grid.step**2 >= LEAST_PART
    large[0] = False
    if large.sum() < 2:
        return []
    parts = np.ascontiguousarray(np.where(large[parts], parts, 0)[None], dtype=np.uint32)
    native.voxels.grow(parts, np.ascontiguousarray(mask[None], dtype=np.uint8))
    parts = parts[0]
    places: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for a, b, along in ((parts[:-1], parts[1:], 0), (parts[:, :-1], parts[:, 1:], 1)):
        y, x = np.nonzero((a != b) & (a > 0) & (b > 0))
        for i, j in zip(y.tolist(), x.tolist(), strict=True):
            pair = (int(min(a[i, j], b[i, j])), int(max(a[i, j], b[i, j])))
            places.setdefault(pair, []).append((j + 1.0 - 0.5 * (1 - along), i + 1.0 - 0.5 * along))
    result = []
    for pair, cells in places.items():
        if covered is not None and max(covered[parts == n].mean() for n in pair) < COVERED:
            continue
        at = np.array(cells)
        width = float(np.ptp(at, axis=0).max() + 1.0) * grid.step
        if width <= (2 * NECK + 1) * grid.step:
            result.append((grid.origin + (np.array([*at.mean(axis=0), 0.5]) + corner) * grid.step, width))
    return result


def _group(
    native: Any, grid: Grid, axis: int, index: tuple[np.ndarray, ...], a: np.ndarray, b: np.ndarray, cap: bool
) -> list[Contact]:
    """index: (plane, row, column) of the lower voxel of each meeting; for axis x: (x, z, y), y: (y, z, x), z: (z, y, x)."""
    if not len(a):
        return []
    low, high = a.astype(np.int64), b.astype(np.int64)
    key = low * (int(max(low.max(), high.max())) + 1) + high
    order = np.lexsort((index[0], key))
    key, plane, rows, columns = key[order], index[0][order], index[1][order], index[2][order]
    first = np.nonzero(np.concatenate([[True], (key[1:] != key[:-1]) | (plane[1:] - plane[:-1] > TOGETHER)]))[0]
    result = []
    for s, e in zip(first, [*first[1:], len(key)], strict=True):
        pair = (int(low[order[s]]), int(high[order[s]]))
        r0, c0 = rows[s:e].min(), columns[s:e].min()
        mask = np.zeros((rows[s:e].max() - r0 + 1, columns[s:e].max() - c0 + 1), dtype=bool)
        mask[rows[s:e] - r0, columns[s:e] - c0] = True
        # Pieces a voxel apart belong together: a chain of rectangles would only cost. In a hole, the wall between two flights parts nothing either.
        regions, count = label2(native, dilate(native, mask, grid.count(STAIR_WALL) if cap else 1))
        counts = np.zeros(count + 1, dtype=np.int64)
        owner = regions[rows[s:e] - r0, columns[s:e] - c0]
        np.add.at(counts, owner, 1)
        for region in range(1, count + 1):
            if not counts[region]:
                continue
            mine = owner == region
            rr, cc, pp = rows[s:e][mine], columns[s:e][mine], plane[s:e][mine]
            box = (int(rr.min()) - 1, int(rr.max()) + 2, int(cc.min()) - 1, int(cc.max()) + 2)
            first, last = float(pp.min()) + 0.5, float(pp.max()) + 1.5
            if cap:
                layer = int(np.median(pp))
                heights = [(level - grid.origin[2]) / grid.step for level, k in grid.caps if k == layer]
                first = last = float(heights[0]) if heights else layer + 0.5
            ends = _rectangle(grid, axis, first, box), _rectangle(grid, axis, last, box)
            result.append(Contact(pair, axis, ends, float(counts[region]) * grid.step**2, cap))
    return result


def _rectangle(grid: Grid, axis: int, at: float, box: tuple[int, int, int, int]) -> np.ndarray:
    r0, r1, c0, c1 = box
    corners = []
    for r, c in ((r0, c0), (r0, c1), (r1, c1), (r1, c0)):
        x, y, z = {0: (at, c, r), 1: (c, at, r), 2: (c, r, at)}[axis]
        corners.append((x, y, z))
    return grid.origin + np.array(corners, dtype=np.float64) * grid.step
