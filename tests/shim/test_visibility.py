# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera sees, from Python: who is seen, who is not, why, and what stays valid for how long."""

from __future__ import annotations

import gc
import threading
from pathlib import Path

import enfilade_native as native
import numpy as np
import pytest
from enfilade_native import visibility
from rooms import camera_at, suite

SCENES = Path(__file__).resolve().parents[1] / "scenes"

IN_LINE = [(1.0, 2.0), (1.0, 2.0), (1.0, 2.0)]
# The last door stands aside: from the middle of room 0, looking through two doors in line, room 3 can't be seen.
ASIDE = [(1.4, 1.6), (1.4, 1.6), (0.0, 0.3)]


@pytest.mark.parametrize("method", ["box", "clip"])
def test_doors_in_line_show_every_room(method):
    with suite(IN_LINE) as scene, native.View(scene) as view:
        seen = view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)), method)
        assert sorted(seen.cells.tolist()) == [0, 1, 2, 3]
        assert sorted(seen.objects.tolist()) == [0, 1, 2, 3]
        assert seen.stats["cells"] == 4 and seen.stats["microseconds"] >= 0


@pytest.mark.parametrize("method", ["box", "clip"])
def test_a_door_aside_hides_what_is_behind_it(method):
    with suite(ASIDE) as scene, native.View(scene) as view:
        seen = view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)), method)
        assert sorted(seen.cells.tolist()) == [0, 1, 2]
        assert 3 not in seen.objects


def test_the_frustum_knows_no_walls():
    with suite(ASIDE) as scene, native.View(scene) as view:
        assert sorted(view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)), "frustum").objects.tolist()) == [0, 1, 2, 3]


def test_a_camera_that_looks_away_sees_its_own_room_only():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        assert view.query(camera_at((1, 1.5, 1), (0, 1.5, 1))).cells.tolist() == [0]


def test_why_names_the_portals_on_the_way():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        seen = view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)))
        assert view.why_cell(0) == []
        assert view.why_cell(3) == [0, 1, 2]
        assert view.why_object(2) == [0, 1]
        at = seen.cells.tolist().index(3)
        assert seen.why(int(seen.cell_step[at])) == [0, 1, 2]
        away = view.query(camera_at((1, 1.5, 1), (0, 1.5, 1)))
        assert 3 not in away.cells
        with pytest.raises(native.InvalidArgumentError):
            view.why_cell(3)


def test_closing_a_door_takes_what_is_behind_it_without_a_commit():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        camera = camera_at((1, 1.5, 1), (9, 1.5, 1))
        view.query(camera)
        scene.set_opening_state(1, "closed")
        after = view.query(camera)
        assert sorted(after.cells.tolist()) == [0, 1]
        assert after.cells_left.tolist() == [2, 3] and after.cells_entered.tolist() == []
        scene.set_opening_state(1, "glass")
        assert sorted(view.query(camera).cells.tolist()) == [0, 1, 2, 3]


def test_an_answer_stays_as_it_was_after_the_next_query():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        first = view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)))
        kept = first.cells.copy()
        for _ in range(20):
            view.query(camera_at((13, 1.5, 1), (16, 1.5, 1)))
        assert np.array_equal(first.cells, kept)


def test_two_eyes_see_what_each_sees():
    with suite(ASIDE) as scene, native.View(scene) as view:
        cameras = [camera_at((1, 1.5, 1), (9, 1.5, 1)), camera_at((9, 0.2, 1), (16, 0.2, 1))]
        each = set(view.query(cameras[0]).cells.tolist()) | set(view.query(cameras[1]).cells.tolist())
        assert set(view.query_union(cameras).cells.tolist()) == each


def test_an_occluder_hides_what_stands_behind_it():
    with suite(IN_LINE) as scene:
        wardrobe = scene.add_object("Wardrobe", [[2.5, 0, 0], [3, 3, 2.5]])
        scene.commit()
        camera = camera_at((1, 1.5, 1), (9, 1.5, 1))
        with native.View(scene) as view:
            assert len(view.query(camera, occluders=1).cells) == 4
        for polygons in (None, [[[2.7, 0, 0], [2.7, 3, 0], [2.7, 3, 2.5], [2.7, 0, 2.5]]]):
            scene.set_occluder(wardrobe, polygons)
            scene.commit()
            with native.View(scene) as view:
                hidden = view.query(camera, occluders=1)
                assert hidden.cells.tolist() == [0] and hidden.stats["portals_occluded"] == 1
                assert wardrobe in hidden.objects.tolist()
                assert len(view.query(camera).cells) == 4
        with pytest.raises(native.BadInputError, match="leaves the object's bounds"):
            scene.set_occluder(wardrobe, [[[2, 0, 0], [2.7, 3, 0], [2.7, 3, 2.5]]])
        with pytest.raises(native.InvalidArgumentError, match="without polygons"):
            scene.set_occluder(wardrobe, [])


def test_a_region_sees_what_its_points_see():
    with suite(ASIDE) as scene, native.View(scene) as view:
        bounds = [[0.5, 0.5, 0.5], [1.5, 2.5, 1.5]]
        region = set(view.query_region(bounds).cells.tolist())
        for eye in ((0.5, 0.5, 0.5), (1.5, 2.5, 1.5), (1, 1.5, 1)):
            assert set(view.query(camera_at(eye, (9, 1.5, 1))).cells.tolist()) <= region


def test_groups_join_objects_of_one_mesh():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)))
        groups = {mesh: sorted(objects.tolist()) for mesh, objects in view.groups()}
        assert groups == {0: [0, 2], 1: [1, 3]}


def test_a_view_keeps_its_scene_alive():
    scene = suite(IN_LINE)
    view = native.View(scene)
    scene.close()
    del scene
    gc.collect()
    assert len(view.query(camera_at((1, 1.5, 1), (9, 1.5, 1))).cells) == 4
    view.close()
    with pytest.raises(native.StateError):
        view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)))


def test_shared_views_answer_in_several_threads_at_once():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        answers: list[list[int]] = []

        def walk(own: visibility.View) -> None:
            for step in range(200):
                x = 0.5 + 0.07 * step
                answers.append(sorted(own.query(camera_at((x, 1.5, 1), (x + 5, 1.5, 1))).cells.tolist()))

        threads = [threading.Thread(target=walk, args=(view.shared(),)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(answers) == 800
        assert len({tuple(a) for a in answers}) <= 8


def test_wrong_input_is_refused_with_a_reason():
    with suite(IN_LINE) as scene, native.View(scene) as view:
        with pytest.raises(native.StateError):
            view.result()
        with pytest.raises(native.InvalidArgumentError, match="method"):
            view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)), "magic")
        with pytest.raises(native.InvalidArgumentError, match="wobble"):
            view.query(camera_at((1, 1.5, 1), (9, 1.5, 1)), wobble=1)
        bad = camera_at((1, 1.5, 1), (9, 1.5, 1))
        bad.matrix_world[0, 3] = np.nan
        with pytest.raises(native.EnfError):
            view.query(bad)
    with native.Scene() as empty, pytest.raises(native.StateError):
        native.View(empty)


def test_a_building_seen_from_outdoors_is_swept_or_looked_at_exactly_as_asked_for():
    with native.Scene.load(SCENES / "window_to_the_exterior.enf.json") as scene:
        scene.commit()
        view = native.View(scene)
        camera = camera_at((8, 1.5, 1.5), (2, 1.5, 1.5))
        swept, exact, auto = view.query(camera, outdoors=2), view.query(camera, outdoors=1), view.query(camera)
        assert swept.stats["swept"] == 1 and swept.stats["windows"] == 1 and exact.stats["swept"] == 0
        assert auto.stats["swept"] == 1 and auto.stats["windows"] == 0  # from afar; a room and its window: the frustum's answer
        assert sorted(swept.cells.tolist()) == sorted(exact.cells.tolist()) == [0, 1]
        assert set(auto.cells.tolist()) >= {0, 1}
        assert len(swept.why(int(swept.cell_step[swept.cells.tolist().index(0)]))) == 1
        scene.set_opening_state(0, "closed")
        assert view.query(camera, outdoors=2).cells.tolist() == [1]
