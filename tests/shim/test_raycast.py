# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and pictures through the shim."""

import enfilade_native as native
import numpy as np
import pytest


@pytest.fixture
def scene():
    """Two rooms of 4 x 4 x 3 m in a row along x, a doorway between them."""
    scene = native.Scene()
    room = scene.add_room("row")
    for x in (0.0, 4.0):
        corners = [[x + 4 * (i & 1), 4 * (i >> 1 & 1), 3 * (i >> 2)] for i in range(8)]
        scene.add_cell(room, corners)
    scene.add_portal(0, 1, [[4, 1, 0], [4, 2, 0], [4, 2, 2], [4, 1, 2]])
    scene.commit()
    return scene


def test_rays_reach_the_far_wall_through_the_doorway(scene):
    with native.Raycaster(scene) as rays:
        hits = rays.shoot([[1, 1.5, 1], [1, 3, 1]], [[1, 0, 0], [1, 0, 0]])
    assert hits["distance"] == pytest.approx([7, 3])
    assert list(hits["cell"]) == [1, 0]
    assert list(hits["portals"]) == [1, 0]


def test_a_picture_shows_both_rooms(scene):
    matrix = np.array([[0, 0, -1, 1], [-1, 0, 0, 1.5], [0, 1, 0, 1.5], [0, 0, 0, 1]], float)
    camera = native.Camera(matrix_world=matrix, angle_x=1.4, angle_y=1.2)
    with native.Raycaster(scene) as rays:
        picture = rays.image(camera, 64, 48)
    assert picture.depth.shape == (48, 64)
    assert set(np.unique(picture.cell)) == {0, 1}
    assert picture.depth[24, 32] == pytest.approx(7)
    assert picture.portals.max() == 1


def test_wrong_input_is_refused(scene):
    with native.Raycaster(scene) as rays:
        with pytest.raises(native.InvalidArgumentError, match="2 origins and 1 directions"):
            rays.shoot([[0, 0, 0], [1, 1, 1]], [[1, 0, 0]])
        with pytest.raises(native.InvalidArgumentError, match="0 x 10"):
            rays.image(native.Camera(), 0, 10)
    with pytest.raises(native.StateError):
        _ = rays.face_count
