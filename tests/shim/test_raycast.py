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


def test_many_rays_at_once_agree_with_the_reference(scene):
    rng = np.random.default_rng(5)
    origins = rng.uniform((0.1, 0.1, 0.1), (7.9, 3.9, 2.9), (500, 3))
    directions = rng.normal(size=(500, 3))
    with native.Raycaster(scene) as rays:
        wanted = rays.shoot(origins, directions)
        every = [rays.closest(origins, directions, method=m, threads=t)
                 for m in ("auto", "single", "packets8", "packets16", "waves") for t in (1, 2)]
        cells = rays.closest(origins, directions, cells=(origins[:, 0] > 4).astype(np.uint32), coherent=True)
        normals = rays.normals(wanted["surface"])
    for hits in [*every, cells]:
        assert hits.distance == pytest.approx(wanted["distance"], rel=1e-5)
        assert np.array_equal(hits.surface, wanted["surface"]) and np.array_equal(hits.cell, wanted["cell"])
        assert np.array_equal(hits.portals, wanted["portals"])
        assert hits.normal == pytest.approx(normals, abs=1e-6)
        assert hits.uv.shape == (500, 2) and np.isfinite(hits.uv).all()


def test_limits_and_shadows(scene):
    origins, directions = [[1, 1.5, 1], [1, 3, 1], [20, 0, 0]], [[2, 0, 0]] * 3
    with native.Raycaster(scene) as rays:
        far, near = rays.closest(origins, directions), rays.closest(origins, directions, max_distance=[3.4, 1.6, 9])
        assert far.distance.tolist() == [3.5, 1.5, np.inf] and near.distance.tolist() == [np.inf, 1.5, np.inf]
        assert near.surface.tolist()[0] == far.cell.tolist()[2] == native.NONE
        assert rays.blocked(origins, directions, max_distance=3).tolist() == [False, True, False]
        assert rays.blocked(origins[:2], directions[:2], max_distance=3, cells=0, target_cells=1).tolist() == [False, True]
        assert rays.closest([], []).distance.shape == (0,)


def test_furniture_is_met_before_walls(scene):
    with native.Triangles((4.0, 2.0, 1.5)) as table, native.Raycaster(scene) as rays:
        table.add_mesh(3, [(2, 0, 0), (2, 4, 0), (2, 4, 3), (2, 0, 3)], [[0, 1, 2], [0, 2, 3]])
        table.commit()
        rays.furnish(table)
        ray = ([[1, 1.5, 1]], [[1, 0, 0]])
        assert rays.closest(*ray).distance.tolist() == [1.0]
        assert rays.closest(*ray, furniture=False).distance.tolist() == [7.0]
        rays.furnish(None)
        assert rays.closest(*ray).distance.tolist() == [7.0]


def test_pictures_by_all_methods_are_the_same_and_tell_frames(scene):
    matrix = np.array([[0, 0, -1, 1], [-1, 0, 0, 1.5], [0, 1, 0, 1.5], [0, 0, 0, 1]], float)
    camera = native.Camera(matrix_world=matrix, angle_x=1.4, angle_y=1.2)
    with native.Raycaster(scene) as rays:
        pictures = [rays.image(camera, 64, 48, method=m, frames=True) for m in ("spans", "tiles", "packets")]
        with pytest.raises(native.InvalidArgumentError, match="spans, tiles, packets"):
            rays.image(camera, 64, 48, method="magic")
    for picture in pictures:
        assert np.array_equal(picture.surface, pictures[0].surface) and picture.depth == pytest.approx(pictures[0].depth, rel=1e-5)
        assert picture.normal.shape == (48, 64, 3) and picture.normal[24, 32] == pytest.approx([-1, 0, 0])
        assert picture.uv == pytest.approx(pictures[0].uv, abs=1e-4)


def test_wrong_rays_are_refused(scene):
    with native.Raycaster(scene) as rays:
        with pytest.raises(native.InvalidArgumentError, match="2 origins and 1 directions"):
            rays.closest([[0, 0, 0], [1, 1, 1]], [[1, 0, 0]])
        with pytest.raises(native.InvalidArgumentError, match="packets16"):
            rays.closest([[1, 1, 1]], [[1, 0, 0]], method="magic")
        with pytest.raises(native.InvalidArgumentError, match="cells"):
            rays.closest([[1, 1, 1]], [[1, 0, 0]], cells=-1)
        hits = rays.closest([[np.nan, 1, 1], [1, 1, 1]], [[1, 0, 0], [0, 0, 0]])
        assert np.isinf(hits.distance).all() and (hits.cell == native.NONE).all() and not hits.normal.any()
