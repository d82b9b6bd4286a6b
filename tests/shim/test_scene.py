# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene from Python: what goes in comes out, errors name index and reason, memory is safe."""

from __future__ import annotations

import gc
import json
import threading

import enfilade_native as native
import numpy as np
import pytest
from enfilade_native import library as load

BOX_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(x0, y0, z0, x1, y1, z1):
    return np.array(
        [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0], [x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
        dtype=float,
    )


DOOR = [[4, 1, 0], [4, 2, 0], [4, 2, 2], [4, 1, 2]]


def two_rooms() -> native.Scene:
    """Hall 4 m wide, bath 2 m wide behind the door at x = 4; a chair in each; committed."""
    scene = native.Scene()
    hall, bath = scene.add_room("Hall"), scene.add_room("Bäd 浴室")
    scene.add_cell(hall, box(0, 0, 0, 4, 3, 2.5), BOX_FACES)
    scene.add_cell(bath, box(4, 0, 0, 6, 3, 2.5))
    door = scene.add_opening("D01", "door", "open")
    scene.add_portal(0, 1, DOOR, door)
    scene.add_objects(["Chair", "Stool"], [[[1, 1, 0], [2, 2, 1]], [[5, 1, 0], [5.5, 2, 1]]], meshes=[7, 7])
    scene.add_light("Lamp", (2, 1, 2))
    scene.add_camera("Cam", native.Camera(np.eye(4), angle_x=1.0, angle_y=0.8, clip=(0.2, 50.0)))
    scene.commit()
    return scene


def test_what_was_added_can_be_read():
    with two_rooms() as scene:
        assert scene.counts == native.SceneCounts(2, 2, 1, 1, 2, 1, 1, 0, 0)
        assert scene.room_names == ["Hall", "Bäd 浴室"]
        assert scene.room_kind(0) == "interior"
        assert scene.opening_names == ["D01"] and scene.opening(0) == ("door", "open")
        assert scene.object_names == ["Chair", "Stool"]
        assert scene.cell_rooms.tolist() == [0, 1]
        assert scene.cell_openings.tolist() == [native.NONE, native.NONE]
        assert scene.portal_cells.tolist() == [[0, 1]]
        assert scene.portal_openings.tolist() == [0]
        assert sorted(map(tuple, scene.portal_polygons()[0])) == sorted(map(tuple, np.array(DOOR, float)))
        assert scene.cell_hulls()[0].shape == (8, 3)
        assert scene.object_cells(0).tolist() == [0] and scene.object_cells(1).tolist() == [1]
        camera = scene.camera("Cam")
        assert (camera.type, camera.angle_x, camera.clip) == ("PERSP", 1.0, (0.2, 50.0))


def test_points_are_located():
    with two_rooms() as scene:
        assert scene.locate((1, 1, 1)).tolist() == [0]
        assert scene.locate((5, 1, 1)).tolist() == [1]
        assert sorted(scene.locate((4, 1.5, 1)).tolist()) == [0, 1]


def test_doors_close_without_a_commit():
    with two_rooms() as scene:
        held = scene.portal_cells
        scene.set_opening_state(0, "closed")
        assert scene.opening(0) == ("door", "closed")
        assert scene.counts.closed_portals == 1
        assert scene.committed and held.shape == (1, 2)


def test_a_saved_scene_loads_the_same(tmp_path):
    path = tmp_path / "zwei räume.enf.json"
    with two_rooms() as scene:
        scene.save(path)
        with native.Scene.load(path) as again:
            again.commit()
            assert again.counts == scene.counts
            assert again.room_names == scene.room_names
            assert np.array_equal(again.portal_vertices, scene.portal_vertices)
    with native.Scene.loads(path.read_bytes()) as third:
        assert third.room_names[1] == "Bäd 浴室"


def test_unknown_keys_of_a_file_are_kept(tmp_path):
    path = tmp_path / "a.enf.json"
    with two_rooms() as scene:
        scene.save(path)
    data = json.loads(path.read_text())
    data["author"] = {"name": "someone"}
    data["rooms"][0]["colour"] = [1, 2, 3]
    path.write_text(json.dumps(data))
    with native.Scene.load(path) as scene:
        scene.save(path)
    again = json.loads(path.read_text())
    assert again["author"] == {"name": "someone"} and again["rooms"][0]["colour"] == [1, 2, 3]


def test_views_are_read_only_and_not_copies():
    with two_rooms() as scene:
        a, b = scene.cell_vertices, scene.cell_vertices
        assert a.ctypes.data == b.ctypes.data
        with pytest.raises(ValueError):
            a[0, 0] = 1.0


def test_views_outlive_the_scene_and_free_it_in_the_end():
    gc.collect()
    before = load().enf_live_bytes()
    scene = two_rooms()
    vertices = scene.cell_vertices
    expected = vertices.copy()
    scene.close()
    del scene
    gc.collect()
    assert load().enf_live_bytes() > before
    assert np.array_equal(vertices, expected)
    del vertices
    gc.collect()
    assert load().enf_live_bytes() == before


def test_editing_under_a_held_view_is_refused():
    with two_rooms() as scene:
        rooms = scene.cell_rooms
        with pytest.raises(native.StateError, match="arrays of this scene"):
            scene.add_room("More")
        assert rooms.tolist() == [0, 1]
        del rooms
        assert scene.add_room("More") == 2
        assert not scene.committed


def test_a_closed_scene_says_so():
    scene = two_rooms()
    scene.close()
    scene.close()
    with pytest.raises(native.StateError, match="closed"):
        _ = scene.counts


def test_a_dangling_reference_fails_the_commit_with_index_and_reason():
    with native.Scene() as scene:
        scene.add_room("Hall")
        scene.add_cell(0, box(0, 0, 0, 1, 1, 1))
        scene.add_portal(0, 9, [[1, 0, 0], [1, 1, 0], [1, 1, 1]])
        with pytest.raises(native.BadInputError) as raised:
            scene.commit()
        problem = next(p for p in raised.value.problems if p.severity == "error")
        assert (problem.item, problem.index) == ("portal", 0)
        assert "9" in problem.message


def test_nan_is_refused_with_its_index():
    with native.Scene() as scene:
        scene.add_room("Hall")
        vertices = box(0, 0, 0, 1, 1, 1)
        vertices[3, 1] = np.nan
        with pytest.raises(native.BadInputError):
            scene.add_cell(0, vertices)
            scene.commit()
        assert not scene.committed


@pytest.mark.parametrize(
    "data",
    [b"", b"{", b"[]", b"null", b'{"format": "other"}', b"\xff\xfe\x00", b"PRT2\n1\n", b'{"format": "enfilade-scene", "version": 99}'],
)
def test_bad_files_are_refused_with_a_sentence(data, tmp_path):
    with pytest.raises(native.BadInputError) as raised:
        native.Scene.loads(data).commit()
    assert len(str(raised.value)) > 10
    path = tmp_path / "bad"
    path.write_bytes(data)
    with pytest.raises(native.BadInputError):
        native.Scene.load(path).commit()


def test_a_missing_file_is_an_os_error(tmp_path):
    with pytest.raises(OSError, match="nothing-here"):
        native.Scene.load(tmp_path / "nothing-here.enf.json")


def test_wrong_shapes_and_words_are_refused_before_c():
    with native.Scene() as scene:
        room = scene.add_room("Hall")
        with pytest.raises(native.InvalidArgumentError, match="shape"):
            scene.add_cell(room, [[0, 0], [1, 1]])
        with pytest.raises(native.InvalidArgumentError, match="cave"):
            scene.add_room("X", "cave")
        with pytest.raises(native.InvalidArgumentError, match="-1"):
            scene.add_cell(-1, box(0, 0, 0, 1, 1, 1))
        with pytest.raises(native.InvalidArgumentError, match="whole numbers"):
            scene.add_cell(room, box(0, 0, 0, 1, 1, 1), [[0, -1, 2]])
        with pytest.raises(native.InvalidArgumentError, match="zero character"):
            scene.add_room("a\0b")
        with pytest.raises(native.InvalidArgumentError, match="names for"):
            scene.add_objects(["a"], np.zeros((2, 2, 3)))
        with pytest.raises(native.InvalidArgumentError):
            scene.room_name(17)


def test_rows_that_lie_apart_go_in_as_they_are():
    wide = np.full((8, 5), np.nan)
    wide[:, :3] = box(0, 0, 0, 1, 2, 3)
    with native.Scene() as scene:
        room = scene.add_room("Hall")
        scene.add_cell(room, wide[:, :3])
        scene.add_cell(room, box(0, 0, 0, 1, 2, 3).astype(np.float32))
        scene.add_cell(room, np.asfortranarray(box(0, 0, 0, 1, 2, 3)))
        scene.add_cell(room, box(0, 0, 0, 1, 2, 3)[::-1])
        hulls = scene.cell_hulls()
        assert np.array_equal(hulls[0], hulls[1]) and np.array_equal(hulls[1], hulls[2])
        assert np.array_equal(hulls[3], hulls[0][::-1])


def test_many_objects_keep_names_bounds_and_meshes_apart():
    names = [f"Möbel {i}" for i in range(1000)] + [""]
    bounds = np.zeros((1001, 2, 3))
    bounds[:, 0, 0] = np.arange(1001) / 1001
    bounds[:, 1] = bounds[:, 0] + 0.1
    with native.Scene() as scene:
        scene.add_room("Hall")
        scene.add_cell(0, box(-1, -1, -1, 4, 4, 4))
        assert scene.add_objects(names, bounds) == range(0, 1001)
        assert scene.add_objects([], np.zeros((0, 2, 3))) == range(1001, 1001)
        scene.commit()
        assert scene.object_names == names
        assert all(scene.object_cells(i).tolist() == [0] for i in (0, 500, 1000))


def test_rooms_as_people_draw_them():
    """An L-shaped prism becomes convex cells with seams; a door joins it to a box given as a polyhedron."""
    outline = [(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)]
    with native.Scene() as scene:
        ell, side = scene.add_room("L"), scene.add_room("Side")
        cells = scene.add_room_prism(ell, [outline], 0.0, 2.5)
        others = scene.add_room_polyhedron(side, box(4, 0, 0, 6, 2, 2.5), BOX_FACES)
        door = scene.add_opening("D", "door")
        portals = scene.join(("room", ell), ("room", side), [(4, 0.5, 0), (4, 1.5, 0), (4, 1.5, 2), (4, 0.5, 2)], door)
        scene.commit()
        assert len(cells) >= 2 and len(others) == 1 and len(portals) >= 1
        assert scene.counts.seams >= 1
        assert {int(c) for c in scene.cell_rooms[list(cells)]} == {ell}
        inside = scene.locate((3, 1, 1))
        assert len(inside) and set(scene.cell_rooms[inside].tolist()) == {ell}


def test_errors_stay_with_the_thread_that_made_them():
    def fail(text, out):
        for _ in range(300):
            try:
                native.Scene.load(text)
            except native.EnfIOError as error:
                out.append(text in str(error))

    results: list[bool] = []
    threads = [threading.Thread(target=fail, args=(f"missing-{i}", results)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 1200 and all(results)


def test_no_bytes_are_left_behind():
    gc.collect()
    before = load().enf_live_bytes()
    for _ in range(5):
        with two_rooms() as scene:
            assert scene.counts.cells == 2
        with pytest.raises(native.BadInputError):
            native.Scene.loads(b"{")
    del scene
    gc.collect()
    assert load().enf_live_bytes() == before
