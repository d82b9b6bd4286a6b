# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene to rooms to hidden objects: small scenes with one thing to see each, and the sample house."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from enfilade import native
from enfilade.analysis import Analyser, Shot
from enfilade.scene import apply_result, cull, detect, extract_annotated
from enfilade.scene.shots import shot_of
from kit import HOUSE, box, camera, empty_scene, rendered_index, two_rooms


def seen_from(scene, method="portal", keep="camera"):
    building = detect.detect(scene, bpy.context.view_layer)
    analyser = Analyser(native.load(), building)
    result = cull.cull(analyser, [shot_of(scene, scene.camera)], method, keep, sky=False)
    return building, analyser, result


def test_an_open_door_shows_the_chair_behind_it_and_a_closed_one_hides_it():
    _, _, result = seen_from(two_rooms("open"))
    assert result.names == {"Chair A", "Chair B"}
    _, _, result = seen_from(two_rooms("closed"))
    assert result.names == {"Chair A"}
    _, _, result = seen_from(two_rooms("glass"))
    assert result.names == {"Chair A", "Chair B"}


def test_a_clipping_start_that_reaches_into_a_wall_hides_nothing_and_says_so():
    scene = two_rooms("closed")
    scene.camera = camera("Wall eye", (3.7, 3.0, 1.2), (6.0, 1.8, 0.6))
    scene.camera.data.clip_start = 0.5
    _, _, result = seen_from(scene)
    assert "Chair B" in result.names
    assert len(result.notes) == 1 and "Wall eye" in result.notes[0] and "Lower Clip Start" in result.notes[0]
    scene.camera.data.clip_start = 0.01
    _, _, result = seen_from(scene)
    assert "Chair B" not in result.names and result.notes == []


def test_the_reason_names_the_door():
    building, _, result = seen_from(two_rooms())
    chair = next(i for i, o in enumerate(building.objects) if o.name == "Chair B")
    assert [building.openings[o].name for o in result.views[0].why[chair]] == ["AB"]


def test_from_the_whole_room_keeps_what_the_camera_sees():
    _, _, point = seen_from(two_rooms())
    _, _, region = seen_from(two_rooms(), "pluecker")
    assert point.names <= region.names and "Chair C" not in region.names


@pytest.mark.parametrize("keep", ["shadow", "bounces=0", "bounces=2"])
def test_keep_sets_grow_and_stay_within_reach(keep):
    scene = two_rooms()
    data = bpy.data.lights.new("Lamp", "POINT")
    lamp = bpy.data.objects.new("Lamp", data)
    lamp.location = (6, 3.5, 2)
    scene.collection.objects.link(lamp)
    bpy.context.view_layer.update()
    _, _, result = seen_from(scene, keep=keep)
    assert {"Chair A", "Chair B"} <= result.names and "Chair C" not in result.names


def test_marked_shapes_are_no_scenery_and_properties_win_over_names():
    scene = two_rooms()
    box("Room_service trolley", (1, 1, 0), (1.2, 1.2, 1), enfilade="ignore")
    bpy.data.objects["Chair C"]["enfilade"] = "nonsense"
    building, _, _ = seen_from(scene)
    assert {o.name for o in building.objects} == {"Chair A", "Chair B", "Chair C"}
    assert [p.code for p in building.problems if p.code == "unknown-mark"] == ["unknown-mark"]


def test_a_room_collection_is_the_hull_of_its_meshes_or_of_its_bound():
    scene = empty_scene()
    for name, x in (("A", 0.0), ("B", 4.0)):
        shelf = bpy.data.collections.new(f"Room_{name}")
        scene.collection.children.link(shelf)
        for part in (box(f"floor {name}", (x, 0, -0.1), (x + 4, 4, 0)), box(f"lid {name}", (x, 0, 2.5), (x + 4, 4, 2.6))):
            scene.collection.objects.unlink(part)
            shelf.objects.link(part)
        if name == "B":
            bound = box("Bound B", (x, 0, 0), (x + 4, 4, 2.5))
            scene.collection.objects.unlink(bound)
            shelf.objects.link(bound)
    box("Portal_AB", (4, 1, 0), (4, 2, 2))
    bpy.context.view_layer.update()
    building = detect.detect(scene, bpy.context.view_layer)
    heights = {r.name: np.ptp(r.vertices[:, 2]) for r in building.rooms}
    assert heights == pytest.approx({"A": 2.7, "B": 2.5})
    assert "Bound B" not in {o.name for o in building.objects}
    assert {building.rooms[i].name for i in building.openings[0].rooms} == {"A", "B"}


def test_an_instancer_stays_when_any_of_its_instances_is_seen():
    scene = two_rooms()
    source = bpy.data.collections.new("Stools")
    for x in (5.5, -2.0):
        stool = box(f"Stool {x}", (x, 1.9, 0), (x + 0.2, 2.1, 0.5))
        scene.collection.objects.unlink(stool)
        source.objects.link(stool)
    empty = bpy.data.objects.new("Stool set", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", source
    scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    building, _, result = seen_from(scene)
    assert "Stool set" in result.names
    assert len([o for o in building.objects if o.source_id == "Stool set"]) == 2  # far apart: two boxes, one switch
    empty.location.x = -4.2
    bpy.context.view_layer.update()
    _, _, result = seen_from(scene)
    assert {"Chair A", "Chair B"} <= result.names


def test_objects_whose_render_differs_from_the_viewport_are_always_kept():
    scene = two_rooms()
    array = bpy.data.objects["Chair C"].modifiers.new("Row", "ARRAY")
    array.show_viewport = False
    building, _, _ = seen_from(scene)
    assert "Chair C" not in {o.name for o in building.objects}
    assert "object-always-kept" in [p.code for p in building.problems]
    bpy.data.objects["Chair B"].hide_viewport = True
    building, _, _ = seen_from(scene)
    assert "hidden-in-viewport" in [p.code for p in building.problems]


def test_nothing_marked_says_what_to_do():
    scene = empty_scene()
    box("Cube", (0, 0, 0), (1, 1, 1))
    with pytest.raises(detect.DetectError, match="enfilade"):
        detect.detect(scene, bpy.context.view_layer)


@pytest.mark.parametrize("mode", ["safe", "render"])
def test_a_render_shows_exactly_the_same_objects(mode, tmp_path):
    scene = two_rooms()
    names = ["Chair A", "Chair B", "Chair C"]
    whole = rendered_index(tmp_path / "whole.exr", names)
    building, _, result = seen_from(scene)
    applied = cull.write(scene, building, result, mode)
    assert applied.hidden == 1
    assert rendered_index(tmp_path / "culled.exr", names) == whole
    # and hiding works at all: hide what is seen, and it is gone
    apply_result.restore(scene)
    apply_result.apply(scene, {"Chair A"}, names, mode)
    assert rendered_index(tmp_path / "wrong.exr", names) == whole - {"Chair B"}


def test_hiding_an_instancer_hides_its_instances(tmp_path):
    scene = two_rooms()
    source = bpy.data.collections.new("Stools")
    stool = box("Stool", (5.5, 1.9, 1.0), (5.9, 2.3, 1.5))
    scene.collection.objects.unlink(stool)
    source.objects.link(stool)
    empty = bpy.data.objects.new("Stool set", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", source
    scene.collection.objects.link(empty)
    names = ["Stool", "Chair B"]
    assert rendered_index(tmp_path / "a.exr", names) == {"Stool", "Chair B"}
    for mode in ("safe", "render"):
        apply_result.apply(scene, set(), {"Stool set"}, mode)
        assert rendered_index(tmp_path / f"{mode}.exr", names) == {"Chair B"}, mode
        apply_result.restore(scene)
    assert rendered_index(tmp_path / "b.exr", names) == {"Stool", "Chair B"}


def test_both_eyes_of_a_stereo_pair_are_asked_exactly():
    scene = two_rooms()
    scene.render.use_multiview, scene.render.views_format = True, "STEREO_3D"
    stereo = scene.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.3, 2.0
    for stereo.convergence_mode in ("OFFAXIS", "PARALLEL", "TOE"):
        for stereo.pivot in ("LEFT", "CENTER"):
            shot = shot_of(scene, scene.camera)
            assert len(shot.eyes) == 2 and shot.eye_radius == 0.0
            analyser = Analyser(native.load(), detect.detect(scene, bpy.context.view_layer))
            both = analyser.look(shot)
            each = [analyser.look(Shot(shot.name, shot.frame, [eye])) for eye in shot.eyes]
            analyser.close()
            assert both.objects == sorted({*each[0].objects, *each[1].objects})
            assert both.cells == sorted({*each[0].cells, *each[1].cells})
    scene.render.use_motion_blur = True  # in motion: anywhere near the camera, which holds both eyes
    wide = shot_of(scene, scene.camera)
    assert not wide.eyes and wide.eye_radius == pytest.approx(0.15)
    stereo.pivot = "LEFT"
    assert shot_of(scene, scene.camera).eye_radius == pytest.approx(0.3)


def test_views_with_cameras_of_their_own_are_all_asked():
    scene = two_rooms()
    scene.camera.name = "Eye_L"
    other = camera("Eye_R", (1.0, 2.0, 1.5), (1.0, -2.0, 1.5))
    scene.render.use_multiview, scene.render.views_format = True, "MULTIVIEW"
    shot = shot_of(scene, scene.camera)
    assert [c.name for c in shot.eyes] == ["Eye_L", "Eye_R"]
    scene.render.use_motion_blur = True
    assert len(shot_of(scene, scene.camera).poses) == 10 and shot_of(scene, scene.camera).eye_radius > 0
    scene.render.use_motion_blur = False
    other.data.dof.use_dof = True
    assert not shot_of(scene, scene.camera).eyes and len(shot_of(scene, scene.camera).poses) == 2
    scene.render.views["right"].use = False
    assert not shot_of(scene, scene.camera).eyes and shot_of(scene, scene.camera).eye_radius == 0


def test_depth_of_field_and_stereo_widen_the_view():
    scene = two_rooms()
    plain = shot_of(scene, scene.camera)
    scene.camera.data.dof.use_dof = True
    scene.camera.data.dof.aperture_fstop = 0.5
    wide = shot_of(scene, scene.camera)
    assert wide.eye_radius == pytest.approx(0.05, rel=1e-3)
    assert wide.camera.angle_x > plain.camera.angle_x
    _, _, result = seen_from(scene)
    assert {"Chair A", "Chair B"} <= result.names


def test_the_sample_house_is_found_whole():
    bpy.ops.wm.open_mainfile(filepath=str(HOUSE))
    scene = bpy.context.scene
    marks = extract_annotated.find_marks(scene)
    building = detect.detect(scene, bpy.context.view_layer)
    rooms = [r for r in building.rooms if r.kind == "interior"]
    assert len(rooms) == marks.rooms == 8
    assert [name for name, _ in building.storeys] == ["Ground floor", "First floor"]
    assert all(o.rooms is not None and o.rooms[0] != o.rooms[1] for o in building.openings)
    assert len(building.openings) == sum(1 for r in marks.objects.values() if r in ("door", "window", "hole", "virtual"))
    drawn = {o.source_id for o in building.objects}
    assert not drawn & set(marks.objects)
    analyser = Analyser(native.load(), building)
    assert analyser.made.room_cells and min(len(c) for c in analyser.made.room_cells) >= 1
    frustum = analyser.look(shot_of(scene, scene.camera), "frustum")
    box_view = analyser.look(shot_of(scene, scene.camera), "box")
    clip = analyser.look(shot_of(scene, scene.camera), "clip")
    region = analyser.look(shot_of(scene, scene.camera), "pluecker")
    assert set(clip.objects) <= set(box_view.objects) <= set(frustum.objects)
    assert set(clip.cells) <= set(region.cells)
    assert 0 < len(clip.objects) < len(building.objects)
    analyser.close()


def test_marks_in_an_instance_and_another_unit_are_told():
    scene = two_rooms()
    hidden = bpy.data.collections.new("Wing")
    for obj in [o for o in scene.objects if o.name in ("Room_C", "Chair C")]:
        scene.collection.objects.unlink(obj)
        hidden.objects.link(obj)
    wing = bpy.data.objects.new("Wing here", None)
    wing.instance_type, wing.instance_collection, wing.location = "COLLECTION", hidden, (0.0, 0.0, 3.0)
    scene.collection.objects.link(wing)
    scene.unit_settings.scale_length = 0.001
    bpy.context.view_layer.update()
    building = detect.detect(scene, bpy.context.view_layer)
    told = {p.code: p for p in building.problems}
    assert told["marks-in-instance"].names == ["Wing here"] and "Room_C" in told["marks-in-instance"].message
    assert told["marks-in-instance"].position is not None and "0.001" in told["unit-scale"].message and told["unit-scale"].remedy
    scene.unit_settings.scale_length = 1.0
    assert "unit-scale" not in {p.code for p in detect.detect(scene, bpy.context.view_layer).problems}
