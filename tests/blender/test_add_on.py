# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on as registered: operators without a window, the live view, what the panels show, on and off again."""

from __future__ import annotations

import bpy
import enfilade
import pytest
from enfilade import migrate, native, session
from enfilade.scene import collections
from enfilade.ui import error_log, overlay, panel_data
from kit import HOUSE, two_rooms, visibility


def test_detect_cull_restore_by_operators(addon):
    scene = two_rooms()
    before = visibility()
    assert bpy.ops.enfilade.detect() == {"FINISHED"}
    data = panel_data.of(scene)
    assert data.detected and dict(data.figures)["Rooms"] == "3"
    scene.enfilade.mode = "render"
    assert bpy.ops.enfilade.cull() == {"FINISHED"}
    assert bpy.data.objects["Chair C"].hide_render and not bpy.data.objects["Chair B"].hide_render
    assert panel_data.of(scene).applied == "1 hidden (renders)"
    assert ("B", "AB") in panel_data.of(scene).seen
    assert bpy.ops.enfilade.restore() == {"FINISHED"}
    after = visibility()
    before.pop("scene keys"), after.pop("scene keys")
    assert after == before


def test_the_culled_view_follows_the_camera(addon):
    scene = two_rooms()
    assert bpy.ops.enfilade.culled_view() == {"FINISHED"}
    chair = bpy.data.objects["Chair B"]
    assert session.get(scene).live and not chair.hide_viewport and bpy.data.objects["Chair C"].hide_viewport
    scene.camera.rotation_euler.z += 3.14159
    bpy.context.view_layer.update()  # what a mouse move does: the handler looks again
    assert chair.hide_viewport
    scene.camera.rotation_euler.z -= 3.14159
    bpy.context.view_layer.update()
    bpy.context.view_layer.update()
    assert not chair.hide_viewport and chair.visible_get()
    assert bpy.ops.enfilade.culled_view() == {"FINISHED"}
    assert not bpy.data.objects["Chair C"].hide_viewport


def test_an_object_that_the_user_moves_is_no_longer_hidden(addon):
    scene = two_rooms()
    bpy.ops.enfilade.culled_view()
    bpy.data.objects["Chair B"].location.y += 0.5
    bpy.context.view_layer.update()
    assert session.get(scene).moved == {"Chair B"}
    scene.camera.rotation_euler.z += 3.14159
    bpy.context.view_layer.update()
    assert not bpy.data.objects["Chair B"].hide_viewport
    assert session.get(scene).moved == {"Chair B"}  # showing and hiding the others moved nothing


def test_a_moved_room_asks_for_a_new_detection(addon):
    scene = two_rooms()
    bpy.data.objects["Room_A"]["enfilade"] = "room"
    bpy.ops.enfilade.detect()
    assert not session.get(scene).stale
    bpy.data.objects["Room_A"].location.z += 1.0
    bpy.context.view_layer.update()
    assert session.get(scene).stale and panel_data.of(scene).stale


def test_asking_in_a_culled_file_leaves_it_culled(addon, tmp_path):
    scene = two_rooms()
    scene.enfilade.mode = "viewport"
    bpy.ops.enfilade.cull()
    path = str(tmp_path / "culled.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    before = visibility()
    assert bpy.data.objects["Chair C"].hide_viewport
    assert bpy.ops.enfilade.visible_from_here(position=(0.3, 2.0, 1.2)) == {"FINISHED"}
    assert visibility() == before
    found = session.get(bpy.context.scene)
    assert found.candidates == {"Chair A", "Chair B", "Chair C"}  # the hidden one was looked at all the same


def test_visible_from_here_selects(addon):
    two_rooms()
    assert bpy.ops.enfilade.visible_from_here(position=(0.3, 2.0, 1.2)) == {"FINISHED"}
    assert {o.name for o in bpy.context.selected_objects} == {"Chair A", "Chair B"}


def test_frames_rooms_report_and_export_run_without_a_window(addon, tmp_path):
    scene = two_rooms()
    assert bpy.ops.enfilade.bake_frames(first=1, last=3) == {"FINISHED"}
    assert bpy.ops.enfilade.restore() == {"FINISHED"}
    assert bpy.ops.enfilade.bake_rooms() == {"FINISHED"}
    assert ("Pairs in sight", "1 of 3") in panel_data.of(scene).figures
    assert bpy.ops.enfilade.export_scene(filepath=str(tmp_path / "s.enf.json")) == {"FINISHED"}
    with native.load().Scene.load(str(tmp_path / "s.enf.json")) as again:
        again.commit()
        assert again.counts.rooms == 3
    assert bpy.ops.enfilade.report(directory=str(tmp_path / "report")) == {"FINISHED"}
    assert (tmp_path / "report" / "report.html").stat().st_size > 1000


def test_from_anywhere_in_the_cameras_room(addon):
    two_rooms()
    assert bpy.ops.enfilade.visible_from_here(camera=True, room=True) == {"FINISHED"}
    assert {o.name for o in bpy.context.selected_objects} == {"Chair A", "Chair B"}
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="camera"):
        bpy.ops.enfilade.visible_from_here(camera=True)


def test_sightlines_become_curves_and_go_again(addon):
    scene = two_rooms()
    assert bpy.ops.enfilade.draw_sightlines() == {"FINISHED"}
    drawn = collections.child(scene, collections.SIGHTLINES).objects
    assert [o.name for o in drawn] == ["A - B (AB)"]
    (curve,) = drawn
    assert curve["enfilade_openings"] == "AB" and list(curve["enfilade_rooms"]) == ["A", "B"]
    splines = curve.data.splines
    assert len(splines) == 3  # the line, and the door's two faces
    start, end = (curve.location.x + p.co[0] for p in splines[0].points)
    assert min(start, end) < 4.0 and max(start, end) > 4.2
    assert bpy.ops.enfilade.draw_sightlines(room="C") == {"FINISHED"}
    assert not collections.child(scene, collections.SIGHTLINES).objects
    with pytest.raises(RuntimeError, match="Nowhere"):
        bpy.ops.enfilade.draw_sightlines(room="Nowhere")
    assert bpy.ops.enfilade.draw_sightlines() == {"FINISHED"}
    assert collections.child(scene, collections.SIGHTLINES) is None and not bpy.data.curves


def test_who_sees_whom_stays_with_the_file(addon, tmp_path):
    two_rooms()
    assert bpy.ops.enfilade.bake_rooms() == {"FINISHED"}
    path = str(tmp_path / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    found = session.ensure(bpy.context)
    assert found.matrix is not None and found.matrix.visible.sum() == 5 and found.matrix.statistics["pairs_reopened"] == 0
    # another door state: the rows are brought up to date, and only what the door can change is asked
    bpy.data.objects["Door_AB"]["enfilade_state"] = "closed"
    session.drop()
    found = session.ensure(bpy.context)
    assert found.matrix.visible.sum() == 3 and found.matrix.statistics["pairs_reopened"] > 0
    # another geometry: they are as if they weren't there
    bpy.data.objects["Door_AB"].location.y += 0.5
    bpy.context.view_layer.update()
    session.drop()
    assert session.ensure(bpy.context).matrix is None


def test_a_scene_without_marks_says_so_and_cancels(addon):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with pytest.raises(RuntimeError, match="room"):
        bpy.ops.enfilade.detect()


def test_marks_are_set_by_hand(addon):
    two_rooms()
    bpy.ops.object.select_all(action="DESELECT")
    bpy.data.objects["Chair A"].select_set(True)
    assert bpy.ops.enfilade.mark(role="hole") == {"FINISHED"}
    assert bpy.data.objects["Chair A"]["enfilade"] == "hole"
    bpy.ops.enfilade.mark(role="none")
    assert "enfilade" not in bpy.data.objects["Chair A"]


def test_problems_are_grouped_and_shown_where_they_are(addon):
    scene = two_rooms()
    from kit import box

    box("Door_far", (90, 0, 0), (91, 1, 2))
    bpy.ops.enfilade.detect()
    data = panel_data.of(scene)
    row = next(r for r in data.problems if "Door_far" in r.message)
    assert row.remedy and data.problem_counts[1] >= 1
    assert bpy.ops.enfilade.show_problem(index=row.index) == {"FINISHED"}
    assert [o.name for o in bpy.context.selected_objects] == ["Door_far"]
    assert scene.cursor.location.x == pytest.approx(90.5)


def test_loading_a_file_forgets_the_scene_before_and_migrates(addon):
    two_rooms()
    bpy.ops.enfilade.detect()
    bpy.ops.wm.open_mainfile(filepath=str(HOUSE))
    assert session.get(bpy.context.scene) is None
    assert bpy.context.scene.enfilade.version == 1
    bpy.context.scene.enfilade.version = 99
    assert migrate.run() and "newer" in migrate.run()[0]


def test_the_overlay_draws_what_was_found(addon):
    bpy.ops.wm.open_mainfile(filepath=str(HOUSE))
    scene = bpy.context.scene
    bpy.ops.enfilade.detect()
    bpy.ops.enfilade.cull()
    found = session.get(scene)
    found.matrix = found.analyser.room_matrix("exact")
    scene.enfilade.show_sightlines = True
    drawing = overlay.build(found, scene.enfilade)
    assert {colour for _, colour, _ in drawing.lines} >= {overlay.START, overlay.UNSEEN, overlay.LINE}
    assert len(drawing.triangles) == 3  # open, glass, closed
    assert all(len(p) % 2 == 0 and p.shape[1] == 3 for p, _, _ in drawing.lines)
    assert all(len(p) % 3 == 0 for p, _ in drawing.triangles)


def test_settings_have_descriptions_and_limits(addon):
    for name, prop in bpy.types.Scene.bl_rna.properties["enfilade"].fixed_type.properties.items():
        if name in {"rna_type", "name", "version"}:
            continue
        assert prop.description, name
        if prop.type in {"INT", "FLOAT"}:
            assert prop.hard_max > prop.hard_min


def test_off_and_on_leaves_nothing(addon):
    enfilade.unregister()
    assert not hasattr(bpy.types.Scene, "enfilade")
    assert not [n for n in dir(bpy.ops.enfilade) if not n.startswith("_")]
    groups = ("load_post", "frame_change_pre", "depsgraph_update_post", "render_init", "render_complete", "render_cancel")
    for group in groups:
        assert not [h for h in getattr(bpy.app.handlers, group) if "enfilade" in h.__module__]
    enfilade.register()


def test_without_the_core_only_the_explanation_registers(monkeypatch):
    monkeypatch.setattr(native, "load", lambda: (_ for _ in ()).throw(native.NativeMissing("the core is elsewhere")))
    enfilade.register()
    try:
        assert not hasattr(bpy.types.Scene, "enfilade")
        assert hasattr(bpy.types, "VIEW3D_PT_enfilade_missing")
        assert native.status() == (False, "the core is elsewhere")
    finally:
        enfilade.unregister()
    assert not hasattr(bpy.types, "VIEW3D_PT_enfilade_missing")


def test_errors_are_counted_once():
    error_log.clear()
    for _ in range(3):
        error_log.add("here", "something")
    assert [(e.message, e.count) for e in error_log.entries()] == [("something", 3)]
    error_log.clear()
