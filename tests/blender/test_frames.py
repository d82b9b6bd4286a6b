# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk: what is hidden at each frame comes from a table, in the window, in a render with and without persistent data."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from enfilade import handlers, native
from enfilade.analysis import Analyser
from enfilade.scene import apply_result, cull, detect, frame_table, sweep
from kit import box, rendered_index, two_rooms, visibility

NAMES = ["Chair A", "Chair B", "Chair C"]


def turning() -> bpy.types.Scene:
    """Frame 1 looks at the door and B behind it, frame 3 away from it."""
    scene = two_rooms()
    eye = scene.camera
    for frame, angle in ((1, eye.rotation_euler.z), (3, eye.rotation_euler.z + np.pi)):
        eye.rotation_euler.z = angle
        eye.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(1)
    return scene


def bake(scene, mode="render"):
    building = detect.detect(scene, bpy.context.view_layer)
    shots = sweep.walk(scene, building, [scene.camera], 1, 3)
    analyser = Analyser(native.load(), building)
    stay = {f: cull.cull(analyser, s, "portal", "camera", False, why=False).names for f, s in shots.items()}
    table = cull.table(building, stay, mode)
    return table, stay


def test_the_table_follows_the_camera_and_survives_the_file(tmp_path):
    scene = turning()
    before = visibility()
    table, stay = bake(scene)
    assert "Chair B" in stay[1] and "Chair B" not in stay[3]
    frame_table.store(scene, table)
    again = frame_table.load(scene)
    assert again.names == table.names
    assert all(np.array_equal(again.frames[f], table.frames[f]) for f in (1, 2, 3))
    path = str(tmp_path / "walk.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert frame_table.apply_frame(scene, 3) is not None
    assert bpy.data.objects["Chair B"].hide_render
    frame_table.apply_frame(scene, 99)  # beyond the table: everything shows
    assert not any(bpy.data.objects[n].hide_render for n in NAMES)
    frame_table.remove(scene)
    apply_result.restore(scene)
    assert visibility() == before


@pytest.mark.parametrize("persistent", [False, True])
@pytest.mark.parametrize("mode", ["safe", "render"])
def test_an_animation_render_shows_each_frame_as_the_whole_scene_does(mode, persistent, tmp_path):
    """Frames are written by one animation render; each must show what a still of the whole scene shows."""
    from enfilade.rules import compare_images

    scene = turning()
    whole = {}
    for frame in (1, 2, 3):
        scene.frame_set(frame)
        whole[frame] = rendered_index(tmp_path / f"whole{frame}.exr", NAMES)
    assert "Chair B" in whole[1] and "Chair B" not in whole[3]
    scene.frame_set(1)
    table, _ = bake(scene, mode)
    # the table is tested, not the camera: say that B is hidden at frame 2 alone
    table.frames = {f: np.array([n == "Chair B" and f == 2 for n in table.names]) for f in (1, 2, 3)}
    frame_table.store(scene, table)
    scene.camera.animation_data_clear()
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.use_persistent_data = persistent
    scene.render.filepath = str(tmp_path / "anim_")
    scene.render.use_file_extension = True
    hook = handlers.on_frame_change_pre
    bpy.app.handlers.frame_change_pre.append(hook)
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.frame_change_pre.remove(hook)
    b_index = NAMES.index("Chair B") + 1
    seen = [
        b_index in np.unique(compare_images.index_channel(compare_images.read_layers(str(tmp_path / f"anim_{f:04d}.exr"))))
        for f in (1, 2, 3)
    ]
    assert seen == [True, False, True]


def test_keyframes_do_the_same_without_the_add_on(tmp_path):
    scene = turning()
    before = visibility()
    table, stay = bake(scene)
    assert cull.keyframe(scene, table) > 0
    for frame in (1, 2, 3):
        scene.frame_set(frame)
        for name in NAMES:
            assert bpy.data.objects[name].hide_render == (name not in stay[frame]), (name, frame)
    scene.frame_set(50)
    assert not any(bpy.data.objects[n].hide_render for n in NAMES)
    scene.frame_set(1)
    assert cull.unkey(scene) > 0
    assert visibility() == before
    assert not any(bpy.data.objects[n].animation_data for n in NAMES)


def test_a_moving_object_is_kept_wherever_it_goes():
    scene = turning()
    cart = box("Cart", (-4.0, 1.0, 0), (-3.5, 1.5, 1.0))  # in C, not to be seen
    cart.location = (0, 0, 0)
    cart.keyframe_insert("location", frame=1)
    cart.location = (9.0, 1.0, 0)  # in B, in line with the door
    cart.keyframe_insert("location", frame=2)
    scene.frame_set(1)
    _, stay = bake(scene)
    assert "Cart" in stay[1]


def test_a_damaged_table_is_an_error_not_a_guess():
    scene = turning()
    table, _ = bake(scene)
    text = table.to_json()
    for broken in ("", "[]", text[: len(text) // 2], text.replace('"render"', '"nonsense"', 1)):
        with pytest.raises(ValueError):
            frame_table.FrameTable.from_json(broken)


def test_markers_switch_the_camera_within_a_range():
    from kit import camera

    scene = two_rooms()
    away = camera("Away", (3.8, 2.0, 1.2), (0.0, 2.0, 1.0))
    for name, frame, obj in (("a", 1, scene.camera), ("b", 2, away)):
        scene.timeline_markers.new(name, frame=frame).camera = obj
    building = detect.detect(scene, bpy.context.view_layer)
    shots = sweep.walk(scene, building, None, 1, 2)
    assert [shots[f][0].name for f in (1, 2)] == ["Eye", "Away"]
