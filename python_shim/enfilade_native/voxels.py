# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel grids (csrc/include/enfilade/voxels.h): marked by triangles, labelled, grown, measured. Plain functions on numpy arrays.

A grid is an array of shape (nz, ny, nx), C-contiguous: grid[k, j, i] is the cube from origin + step * (i, j, k). ctypes
frees the GIL meanwhile.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from ._library import library
from .buffers import Flat, Rows
from .errors import InvalidArgumentError


def _grid(array: np.ndarray, dtype: Any, what: str) -> np.ndarray:
    if not isinstance(array, np.ndarray) or array.ndim != 3 or array.dtype != dtype or not array.flags.c_contiguous:
        raise InvalidArgumentError(f"{what}: wanted a C-contiguous {np.dtype(dtype).name} array (nz, ny, nx)")
    return array


def _size(array: np.ndarray) -> np.ndarray:
    return np.array(array.shape[::-1], dtype=np.uint32)


def mark(grid: np.ndarray, origin: Any, step: float, vertices: Any, triangles: Any, value: int = 1) -> None:
    """Sets the bits `value` of the voxels that triangles touch, in place. grid: uint8. origin: (3,) metres. step: metres.
    vertices: float64 (n, 3). triangles: (m, 3) corner indices."""
    _grid(grid, np.uint8, "grid")
    size = _size(grid)
    start = Flat(origin, "origin", np.float64, 3)
    points = Rows(vertices, 3, "vertices")
    corners = Flat(triangles, "triangles", np.uint32)
    library().enf_voxels_mark(
        size.ctypes.data, start.address, float(step), points.address, points.count, points.stride, corners.address,
        corners.count // 3, value, grid.ctypes.data,
    )  # fmt: skip


def label(kinds: np.ndarray) -> tuple[np.ndarray, int]:
    """Regions of equal, non-zero voxels that hang together by faces: uint32 labels from 1 on (0 where kinds is 0), and how
    many. kinds: uint8."""
    _grid(kinds, np.uint8, "kinds")
    size, labels, count = _size(kinds), np.empty(kinds.shape, np.uint32), ctypes.c_uint32()
    library().enf_voxels_label(size.ctypes.data, kinds.ctypes.data, labels.ctypes.data, ctypes.byref(count))
    return labels, int(count.value)


def grow(labels: np.ndarray, passable: np.ndarray, steps: int = 0) -> None:
    """Spreads labels through passable voxels, in place, at most `steps` voxels far (0: as far as they get). labels: uint32,
    below 2^31. passable: uint8, same shape."""
    _grid(labels, np.uint32, "labels")
    _grid(passable, np.uint8, "passable")
    if labels.shape != passable.shape:
        raise InvalidArgumentError(f"labels {labels.shape} and passable {passable.shape} differ in shape")
    size = _size(labels)
    library().enf_voxels_grow(size.ctypes.data, passable.ctypes.data, int(steps), labels.ctypes.data)


def boxes(labels: np.ndarray, count: int) -> np.ndarray:
    """The boxes of labels 0..count, uint32 (count + 1, 2, 3): the first voxel along x, y, z and one beyond the last; a label that stands
    nowhere ends at 0. labels: uint32, none above count."""
    _grid(labels, np.uint32, "labels")
    size, found = _size(labels), np.empty((count + 1, 2, 3), np.uint32)
    library().enf_voxels_boxes(size.ctypes.data, labels.ctypes.data, int(count), found.ctypes.data)
    return found


def runs(blocked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Free voxels (0) from each one on downward and upward along z, itself counted, uint8: 255 at most, and where the run leaves the grid.
    blocked: uint8."""
    _grid(blocked, np.uint8, "blocked")
    size, down, up = _size(blocked), np.empty(blocked.shape, np.uint8), np.empty(blocked.shape, np.uint8)
    library().enf_voxels_runs(size.ctypes.data, blocked.ctypes.data, down.ctypes.data, up.ctypes.data)
    return down, up


def widen(mask: np.ndarray, reach: Any) -> None:
    """Sets to 1 what lies within `reach` voxels (along x, y, z; 254 at most) of what isn't 0, in boxes, in place. mask: uint8."""
    _grid(mask, np.uint8, "mask")
    size, steps = _size(mask), Flat(reach, "reach", np.uint8, 3)
    library().enf_voxels_widen(size.ctypes.data, steps.address, mask.ctypes.data)


def rename(labels: np.ndarray, names: Any) -> None:
    """Puts names[label] for each label, in place. labels, names: uint32; names as long as the highest label + 1."""
    _grid(labels, np.uint32, "labels")
    size, wanted = _size(labels), Flat(names, "names", np.uint32)
    library().enf_voxels_rename(size.ctypes.data, wanted.address, wanted.count - 1, labels.ctypes.data)
