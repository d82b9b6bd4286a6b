# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances are grouped into few boxes that cover every one; cameras keep their frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from enfilade.rules.camera_frame import Lens, Raster, frame_of, rigid
from enfilade.rules.instances import MOST_GROUPS, box_corners, group_boxes


def test_groups_cover_every_box_and_stay_tight():
    rng = np.random.default_rng(1)
    centres = np.concatenate([rng.normal(c, 0.5, (300, 3)) for c in ((0, 0, 0), (50, 0, 0), (0, 80, 0))])
    boxes = np.stack([centres - 0.2, centres + 0.2], axis=1)
    groups = group_boxes(boxes)
    assert 3 <= len(groups) <= MOST_GROUPS
    for box in boxes:
        assert any((g[0] <= box[0]).all() and (g[1] >= box[1]).all() for g in groups)
    assert max(np.linalg.norm(g[1] - g[0]) for g in groups) < 20


def test_a_cap_bounds_the_groups():
    centres = np.random.default_rng(2).uniform(0, 1000, (5000, 3))
    assert len(group_boxes(np.stack([centres, centres + 0.01], axis=1))) <= MOST_GROUPS
    assert group_boxes(np.zeros((0, 2, 3))) == []


def test_world_bounds_follow_rotation_and_mirroring():
    box = np.array([[[0, 0, 0], [1, 2, 3]]], float)
    turn = np.eye(4)
    turn[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, -1]]
    turn[:3, 3] = (10, 20, 30)
    assert np.allclose(box_corners(box, turn[None]), [[[8, 20, 27], [10, 21, 30]]])


def test_sensor_fit_follows_the_longer_side():
    wide = frame_of(Lens(lens=18.0), Raster(2000, 1000))
    assert wide.angle_x == pytest.approx(math.radians(90)) and wide.angle_y == pytest.approx(2 * math.atan(0.5))
    tall = frame_of(Lens(lens=18.0), Raster(1000, 2000))
    assert tall.angle_y == pytest.approx(math.radians(90))
    ortho = frame_of(Lens(type="ORTHO", ortho_scale=10.0, shift_x=0.5), Raster(1000, 2000))
    assert (ortho.ortho_width, ortho.ortho_height) == pytest.approx((5.0, 10.0))
    assert ortho.shift_x == pytest.approx(1.0)  # half of the fitted side is the whole of the other


def test_a_sheared_camera_is_squared_up_and_said():
    m = np.eye(4)
    m[0, 1] = 0.5
    out, mirrored, sheared = rigid(m)
    assert sheared and not mirrored and np.allclose(out[:3, :3].T @ out[:3, :3], np.eye(3))
