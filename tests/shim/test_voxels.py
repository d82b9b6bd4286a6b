# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel grids through the shim: marks are conservative, labels and growth agree with slow and simple answers."""

import enfilade_native as native
import numpy as np
import pytest
from enfilade_native import voxels


def test_marks_hold_every_point_of_a_triangle():
    rng = np.random.default_rng(4)
    for _ in range(30):
        corners = rng.uniform(-0.5, 2.5, (3, 3))
        grid = np.zeros((8, 9, 10), np.uint8)
        voxels.mark(grid, (0, 0, 0), 0.2, corners, [[0, 1, 2]], 4)
        u = rng.random((4000, 2))
        u[u.sum(axis=1) > 1] = 1 - u[u.sum(axis=1) > 1]
        points = corners[0] + u[:, :1] * (corners[1] - corners[0]) + u[:, 1:] * (corners[2] - corners[0])
        index = np.floor(points / 0.2).astype(int)
        inside = ((index >= 0) & (index < (10, 9, 8))).all(axis=1)
        assert (grid[tuple(index[inside].T[::-1])] == 4).all()
        centres = (np.argwhere(grid)[:, ::-1] + 0.5) * 0.2
        plane = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        away = np.abs((centres - corners[0]) @ plane) / np.linalg.norm(plane)
        assert (away <= 0.2 * np.sqrt(3) / 2 + 1e-6).all()  # nothing that the plane doesn't touch


def test_a_closed_box_lets_nothing_out():
    grid = np.zeros((20, 20, 20), np.uint8)
    c = np.array([(x, y, z) for z in (0.5, 1.5) for y in (0.5, 1.5) for x in (0.5, 1.5)])
    quads = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
    voxels.mark(grid, (0.013, 0.007, -0.011), 0.1, c, [t for a, b, d, e in quads for t in ((a, b, d), (a, d, e))])
    labels, count = voxels.label((grid == 0).astype(np.uint8))
    assert count == 2 and labels[0, 0, 0] == 1 and labels[10, 10, 10] == 2


def test_labels_are_numbered_by_first_voxel_and_kinds_stay_apart():
    kinds = np.zeros((1, 3, 6), np.uint8)
    kinds[0] = [[1, 0, 2, 2, 0, 1], [1, 1, 0, 2, 1, 1], [0, 1, 1, 1, 1, 0]]
    labels, count = voxels.label(kinds)
    assert count == 2
    assert labels[0].tolist() == [[1, 0, 2, 2, 0, 1], [1, 1, 0, 2, 1, 1], [0, 1, 1, 1, 1, 0]]


def test_growth_goes_round_walls_and_meets_half_way():
    passable = np.ones((1, 1, 9), np.uint8)
    labels = np.zeros((1, 1, 9), np.uint32)
    labels[0, 0, 0], labels[0, 0, 8] = 7, 3
    voxels.grow(labels, passable, 2)
    assert labels[0, 0].tolist() == [7, 7, 7, 0, 0, 0, 3, 3, 3]
    voxels.grow(labels, passable)
    assert labels[0, 0].tolist() == [7, 7, 7, 7, 3, 3, 3, 3, 3]
    passable[0, 0, 4] = 0
    labels[0, 0, 1:] = 0
    voxels.grow(labels, passable)
    assert labels[0, 0].tolist() == [7, 7, 7, 7, 0, 0, 0, 0, 0]


def test_boxes_runs_and_wider_masks():
    labels = np.zeros((3, 4, 5), np.uint32)
    labels[1, 2, 3] = labels[2, 2, 1] = 2
    boxes = voxels.boxes(labels, 2)
    assert boxes[2].tolist() == [[1, 2, 1], [4, 3, 3]] and boxes[1, 1].tolist() == [0, 0, 0]
    voxels.rename(labels, [0, 0, 7])
    assert labels[1, 2, 3] == 7 and labels.sum() == 14
    blocked = (labels > 0).astype(np.uint8)
    down, up = voxels.runs(blocked)
    assert down[:, 2, 3].tolist() == [255, 0, 1] and up[:, 2, 3].tolist() == [1, 0, 255]
    voxels.widen(blocked, (1, 0, 1))
    assert blocked[:, 2].tolist() == [[0, 0, 1, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, 1]] and blocked.sum() == 13


def test_bad_input_is_told():
    grid = np.zeros((2, 2, 2), np.uint8)
    with pytest.raises(native.BadInputError, match="triangle 0: corner 3"):
        voxels.mark(grid, (0, 0, 0), 1.0, np.zeros((3, 3)), [[0, 1, 3]])
    with pytest.raises(native.BadInputError, match="finite"):
        voxels.mark(grid, (0, 0, 0), 1.0, np.full((3, 3), np.nan), [[0, 1, 2]])
    with pytest.raises(native.BadInputError, match="step"):
        voxels.mark(grid, (0, 0, 0), 0.0, np.zeros((3, 3)), [[0, 1, 2]])
    with pytest.raises(native.InvalidArgumentError):
        voxels.label(np.zeros((2, 2), np.uint8))
    with pytest.raises(native.InvalidArgumentError):
        voxels.grow(np.zeros((2, 2, 2), np.uint32), np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(native.InvalidArgumentError):
        voxels.widen(np.zeros((2, 2, 2), np.uint8), (1, 1, 256))
    with pytest.raises(native.BadInputError, match="label 3 of 2"):
        voxels.rename(np.full((1, 1, 2), 3, np.uint32), [0, 1, 2])
    with pytest.raises(native.BadInputError, match="label"):
        voxels.grow(np.full((1, 1, 2), 1 << 31, np.uint32), np.ones((1, 1, 2), np.uint8))
