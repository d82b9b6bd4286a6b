# SPDX-License-Identifier: GPL-3.0-or-later
"""Mending marked meshes, states of openings, markers, other tools' files, and scenes that an IFC add-on loaded."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from enfilade import registration, session
from enfilade.rules import scene_file
from enfilade.scene import collections, detect, exchange, repair
from kit import ROOT, box, empty_scene, two_rooms
from mathutils import Matrix, Vector
from test_batch import run


@pytest.fixture
def add_on():
    registration.register()
    yield
    registration.unregister()


def _pairs(building):
    return sorted((o.kind, tuple(sorted(building.rooms[r].name for r in o.rooms))) for o in building.openings if o.rooms)


def _detect():
    bpy.context.view_layer.update()
    return detect.detect(bpy.context.scene, bpy.context.view_layer)


def _damage(scene) -> bpy.types.Object:
    """Room A loses a face and turns one inwards; it stands turned and scaled, so that world and local differ."""
    obj = scene.objects["Room_A"]
    vertices = [tuple(v.co) for v in obj.data.vertices]
    faces = [list(p.vertices) for p in obj.data.polygons][:5]
    faces[1].reverse()
    turn = Matrix.Rotation(0.5, 4, "Z") @ Matrix.Diagonal((2.0, 2.0, 2.0, 1.0))
    obj.data.clear_geometry()
    obj.data.from_pydata([tuple(turn.inverted() @ Vector(v)) for v in vertices], [], faces)
    obj.matrix_world = turn
    bpy.context.view_layer.update()
    return obj


def test_meshes_are_mended_one_by_one_and_all_at_once(add_on):
    scene = two_rooms()
    obj = _damage(scene)
    assert [f.name for f in repair.offers(scene)] == ["Room_A"]
    assert bpy.ops.enfilade.check_marks() == {"FINISHED"}
    assert bpy.ops.enfilade.fix_marks(name="Room_A", kinds={"split"}) == {"CANCELLED"}
    assert bpy.ops.enfilade.fix_marks(name="") == {"FINISHED"}
    assert repair.offers(scene) == [] and len(obj.data.polygons) == 6
    building = _detect()
    assert not [p for p in building.problems if p.code == "room-not-closed"]
    room = next(r for r in building.rooms if r.name == "A")
    assert np.allclose(room.vertices.min(axis=0), (0, 0, 0), atol=1e-5) and np.allclose(room.vertices.max(axis=0), (4, 4, 2.5), atol=1e-5)


def test_what_cannot_be_mended_says_why(add_on):
    scene = two_rooms()
    obj = _damage(scene)
    obj.modifiers.new("Bend", "SIMPLE_DEFORM")
    done, refused = repair.apply_all(scene, {"fill", "flip", "snap"})
    assert done == [] and refused[0][0] == "Room_A" and "modifiers" in refused[0][1]


def test_states_are_set_by_opening_storey_and_class_and_survive_detect(add_on):
    scene = two_rooms()
    bpy.ops.enfilade.detect()
    door = session.get(scene).building.openings[0]
    assert door.state == "open"
    bpy.context.view_layer.objects.active = scene.objects["Door_AB"]
    assert bpy.ops.enfilade.set_opening_state(scope="OPENING", state="closed") == {"FINISHED"}
    assert door.state == "closed"
    bpy.ops.enfilade.detect()
    assert session.get(scene).building.openings[0].state == "closed"
    assert bpy.ops.enfilade.set_opening_state(scope="OPENING", state="found") == {"FINISHED"}
    assert bpy.ops.enfilade.set_opening_state(scope="CLASS", name="door", state="glass") == {"FINISHED"}
    bpy.ops.enfilade.detect()
    assert session.get(scene).building.openings[0].state == "glass"
    with pytest.raises(RuntimeError, match="a class is one of"):
        bpy.ops.enfilade.set_opening_state(scope="CLASS", name="roof", state="open")


def test_problems_get_markers_that_tell_what_to_do(add_on):
    scene = two_rooms()
    box("Window_Lost", (40, 40, 0), (41, 40.2, 1))
    bpy.context.view_layer.update()
    bpy.ops.enfilade.detect()
    found = session.get(scene)
    index = next(i for i, p in enumerate(found.problems) if p.code == "opening-no-room")
    bpy.ops.enfilade.mark_problems()
    shelf = collections.child(scene, collections.PROBLEMS)
    marker = next(o for o in shelf.objects if o["enfilade_problem"] == index)
    assert marker["remedy"] and "Window_Lost" in marker["objects"] and tuple(marker.location) == pytest.approx((40.5, 40.1, 0.5))
    bpy.ops.enfilade.show_problem(index=index)
    assert bpy.context.view_layer.objects.active.name == "Window_Lost" and scene.objects["Window_Lost"].select_get()
    count = len(found.building.objects)
    bpy.ops.enfilade.detect()  # markers are no scenery
    assert len(session.get(scene).building.objects) == count
    bpy.ops.enfilade.mark_problems()
    assert collections.child(scene, collections.PROBLEMS) is None


def test_cells_go_out_and_come_back_as_marked_objects(add_on, tmp_path):
    two_rooms()
    building = _detect()
    bpy.ops.enfilade.detect()
    assert bpy.ops.enfilade.export_scene(filepath=str(tmp_path / "x.enf.json")) == {"FINISHED"}
    assert bpy.ops.enfilade.write_indoorgml(filepath=str(tmp_path / "x.gml")) == {"FINISHED"}
    assert _pairs(scene_file.read(tmp_path / "x.enf.json")) == _pairs(building)
    for name in ("x.enf.json", "x.gml"):
        empty_scene()
        bpy.ops.enfilade.import_cells(filepath=str(tmp_path / name))
        again = _detect()
        rooms = {r.name for r in again.rooms}
        assert {"A", "B", "C"} <= rooms
        if name == "x.enf.json":
            assert _pairs(again) == _pairs(building)
    with pytest.raises(RuntimeError, match="can't be read"):
        bpy.ops.enfilade.import_cells(filepath=str(tmp_path / "nothing.gml"))
    with pytest.raises(exchange.ExchangeError, match="shows no IFC model"):
        exchange.write_ifc(bpy.context.scene, building, str(tmp_path / "y.ifc"))


def _loaded(hidden: bool) -> None:
    """As an IFC add-on leaves a scene: triangle meshes by IFC name, spaces hidden, a collection a storey."""
    scene = empty_scene()
    storey = bpy.data.collections.new("IfcBuildingStorey/Ground")
    scene.collection.children.link(storey)
    walls = [("Middle", (4, 0, 0), (4.2, 1.5, 2.5)), ("Middle 2", (4, 2.5, 0), (4.2, 5, 2.5)), ("Lintel", (4, 1.5, 2.1), (4.2, 2.5, 2.5)),
             ("West", (-0.3, -0.3, 0), (0, 5.3, 2.5)), ("East", (8, -0.3, 0), (8.3, 5.3, 2.5)), ("South", (0, -0.3, 0), (8, 0, 2.5)),
             ("North", (0, 5, 0), (8, 5.3, 2.5))]
    made = [box(f"IfcWall/{name}", low, high) for name, low, high in walls]
    made += [box("IfcSlab/Floor", (-0.3, -0.3, -0.3), (8.3, 5.3, 0)), box("IfcSlab/Roof", (-0.3, -0.3, 2.5), (8.3, 5.3, 2.8)),
             box("IfcDoor/D1", (4.05, 1.5, 0), (4.1, 2.5, 2.1)), box("IfcSpace/A", (0, 0, 0), (4, 5, 2.5)), box("IfcSpace/B", (4.2, 0, 0), (8, 5, 2.5))]
    for obj in made:
        storey.objects.link(obj)
        scene.collection.objects.unlink(obj)
        if obj.name.startswith("IfcSpace/"):
            obj.hide_viewport = hidden


@pytest.mark.parametrize("hidden", [False, True])
def test_a_scene_that_draws_an_ifc_model_needs_no_file(hidden):
    _loaded(hidden)
    building = _detect()
    assert building.source == "ifc scene" and [r.storey for r in building.rooms[:2]] == ["Ground", "Ground"]
    assert _pairs(building) == [("door", ("A", "B"))]
    assert not any(o.name.startswith("IfcSpace/") for o in building.objects)
    assert [p.severity for p in building.problems if p.code == "ifc-scene"] == ["info"]
    bpy.context.scene["enfilade_ifc_path"] = "/nowhere/house.ifc"  # the file moved away
    assert _pairs(_detect()) == [("door", ("A", "B"))]


def test_batch_lists_mends_draws_and_writes(tmp_path):
    _damage(two_rooms())
    path = tmp_path / "damaged.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    found, _ = run(path, "detect", "--check")
    assert [f["object"] for f in found["mending"]["offered"]] == ["Room_A"] and all(f["remedy"] for f in found["mending"]["offered"])
    found, _ = run(path, "detect", "--mend", "all", "--state", "D?=open", "--state", "class:door=closed", "--picture", tmp_path / "pictures",
                   "--markers", "--write-indoorgml", tmp_path / "x.gml", "--save", tmp_path / "mended.blend")  # fmt: skip
    assert [f["object"] for f in found["mending"]["done"]] == ["Room_A", "Room_A"] and found["mending"]["offered"] == []
    assert found["pictures"] and all((tmp_path / "pictures").glob("*.png")) and found["written"]["indoorgml"]["cells"] == 4
    assert [p["names"] for p in found["problems"] if p["code"] == "unknown-opening"] == [["D?"]]
    run(path, "detect", "--state", "AB=ajar", expect=1)
    run(path, "detect", "--mend", "paint", expect=1)
    run(path, "detect", "--write-ifc", tmp_path / "y.ifc", expect=2)


def test_cells_come_in_by_the_batch_command(tmp_path):
    found, _ = run(None, "import", ROOT / "tests" / "scenes" / "two_rooms.enf.json", "--save", tmp_path / "t.blend")
    assert found["rooms"] == 2 and found["openings_joined"] == found["openings"] >= 1
    assert found["marked"] == found["rooms"] + found["openings"]
    again, done = run(tmp_path / "t.blend", "detect", "--save", tmp_path / "u.blend")
    assert again["source"] == "annotated" and again["openings_joined"] == found["openings"]
    assert again["before"]["rooms"] == 0 and "rooms 2, " in done.stderr
    third, _ = run(tmp_path / "u.blend", "detect")
    assert third["before"]["rooms"] == 2
    for name, text in (("none.gml", None), ("odd.enf.json", "{"), ("odd.gml", "<x")):
        if text is not None:
            (tmp_path / name).write_text(text)
        run(None, "import", tmp_path / name, expect=2)


def test_furniture_of_an_ifc_file_comes_when_it_is_needed(tmp_path):
    from enfilade.rules import ifc_library

    if not ifc_library.available():
        pytest.skip("IfcOpenShell is not at hand")
    from plugin_plain.ifc_blocks import two_rooms as ifc_rooms

    model, wall = ifc_rooms()
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4.0, 2, 0), (4.2, 2.9, 2.1)), door)
    model.product("Chair", "IfcFurnishingElement", ((1, 1, 0), (1.5, 1.5, 1)))
    file = model.save(tmp_path)
    found, _ = run(None, "detect", "--ifc", file, "--scene-json", tmp_path / "s.enf.json")
    bare, _ = run(None, "detect", "--ifc", file)
    assert (found["objects"], bare["objects"]) == (9, 0) and found["portals"] == bare["portals"]
    part, _ = run(None, "detect", "--ifc", file, "--draw", "built", "--add-cameras", 1, "--save", tmp_path / "b.blend")
    assert part["objects"] == 8
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "b.blend"))
    assert "IfcDoor/D1" in bpy.data.objects and "IfcFurnishingElement/Chair" not in bpy.data.objects
    _, done = run(tmp_path / "b.blend", "cull", "--save", tmp_path / "c.blend")
    assert "1 objects that were left in the IFC file" in done.stderr
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "c.blend"))
    chair, door = bpy.data.objects["IfcFurnishingElement/Chair"], bpy.data.objects["IfcDoor/D1"]
    shelves = [{c for c in o.users_collection if c.name.startswith("Ifc")} for o in (chair, door)]
    assert shelves[0] == shelves[1] != set()
    _, done = run(tmp_path / "c.blend", "cull")
    assert "left in the IFC file" not in done.stderr
    file.unlink()
    run(tmp_path / "b.blend", "cull", expect=2)
