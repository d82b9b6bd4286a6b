# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do between two clicks: other scenes, deleted and renamed things, collections pulled apart. Nothing is lost or left half changed."""

from __future__ import annotations

import bpy
import pytest
from enfilade import session
from enfilade.scene import apply_result
from enfilade.ui import panel_data
from kit import box, two_rooms, visibility

CHAIRS = {"Chair A", "Chair B", "Chair C"}


def hidden() -> set[str]:
    return {o.name for o in bpy.data.objects if o.hide_viewport}


def turn(scene: bpy.types.Scene, angle: float) -> None:
    scene.camera.rotation_euler.z += angle
    bpy.context.view_layer.update()


def second_scene(first: bpy.types.Scene) -> bpy.types.Scene:
    """A scene that shows the same objects but chair C, and is the window's now."""
    other = bpy.data.scenes.new("Other")
    for obj in first.objects:
        if obj.name != "Chair C":
            other.collection.objects.link(obj)
    other.camera = first.camera
    if bpy.context.window is not None:
        bpy.context.window.scene = other
    other.view_layers[0].update()
    return other


def in_scene(scene: bpy.types.Scene):
    return bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0])


def test_asking_in_another_scene_leaves_what_is_hidden_for_the_first(addon):
    first = two_rooms()
    first.enfilade.mode = "viewport"
    turn(first, 3.14159)  # away from everything
    assert bpy.ops.enfilade.cull() == {"FINISHED"} and hidden() == CHAIRS
    state = apply_result.state_of(first)
    other = second_scene(first)
    with in_scene(other):
        assert bpy.ops.enfilade.visible_from_here(position=(0.3, 2.0, 1.2)) == {"FINISHED"}
    assert hidden() == CHAIRS
    assert apply_result.state_of(first) == state and not apply_result.state_of(other)
    assert "for Scene" in panel_data.of(other).applied  # and can be restored from there
    with in_scene(other):
        assert bpy.ops.enfilade.restore() == {"FINISHED"}
    assert not hidden() and not panel_data.of(first).applied


def test_restoring_in_another_scene_is_noticed_by_the_culled_view(addon):
    first = two_rooms()
    bpy.ops.enfilade.culled_view()
    turn(first, 3.14159)
    assert hidden() == CHAIRS
    with in_scene(second_scene(first)):
        bpy.ops.enfilade.restore()
    assert not hidden()
    if bpy.context.window is not None:
        bpy.context.window.scene = first
    with in_scene(first):
        turn(first, 0.1)
        first.view_layers[0].update()
    assert hidden() == CHAIRS
    bpy.ops.enfilade.culled_view()
    assert not hidden()


def test_a_scene_that_takes_over_a_name_takes_over_no_rooms(addon):
    scene = two_rooms()
    bpy.ops.enfilade.detect()
    scene.name = "Old"
    new = bpy.data.scenes.new("Scene")
    assert new.name == "Scene" and session.get(new) is None


@pytest.mark.parametrize("name", ["Door_AB", "Room_B"])
def test_deleted_and_moved_marks_ask_for_a_new_detection_and_chairs_do_not(addon, name):
    scene = two_rooms()
    bpy.ops.enfilade.culled_view()
    found = session.get(scene)
    turn(scene, 3.14159)
    bpy.data.objects.remove(bpy.data.objects["Chair C"])
    box("Stool", (1, 1, 0), (1.2, 1.2, 0.4))
    turn(scene, 0.1)
    assert hidden() == {"Chair A", "Chair B"} and not found.stale
    if name == "Door_AB":
        bpy.data.objects.remove(bpy.data.objects[name])
    else:
        bpy.data.objects[name].location.x += 1.0
    bpy.context.view_layer.update()
    turn(scene, 0.1)
    assert found.stale and panel_data.of(scene).stale
    assert bpy.ops.enfilade.detect() == {"FINISHED"}  # without the door, or the room where it was
    assert not session.get(scene).stale and not hidden()


def test_rooms_deleted_between_two_detections_leave_nothing_hidden(addon):
    scene = two_rooms()
    scene.enfilade.mode = "viewport"
    turn(scene, 3.14159)
    bpy.ops.enfilade.cull()
    for name in ("Room_A", "Room_B", "Room_C"):
        bpy.data.objects.remove(bpy.data.objects[name])
    with pytest.raises(RuntimeError):
        bpy.ops.enfilade.detect(source="annotated")
    assert hidden() == CHAIRS  # a Detect that fails changes nothing
    bpy.ops.enfilade.restore()
    assert not hidden() and not any(apply_result.HIDDEN_KEY in o for o in bpy.data.objects)


def test_an_object_that_is_left_in_our_lists_alone_stays_in_the_scene(addon):
    scene = two_rooms()
    shelf = bpy.data.collections.new("Shelf")
    scene.collection.children.link(shelf)
    chair = bpy.data.objects["Chair B"]
    scene.collection.objects.unlink(chair)
    shelf.objects.link(chair)
    bpy.context.view_layer.update()
    scene.enfilade.mode = "viewport"
    turn(scene, 3.14159)
    bpy.ops.enfilade.cull()
    shelf.objects.unlink(chair)
    bpy.ops.enfilade.cull()
    bpy.ops.enfilade.restore()
    assert [c.name for c in chair.users_collection] == [scene.collection.name] and chair.name in scene.objects


@pytest.mark.parametrize("mode", apply_result.MODES)
def test_what_is_hidden_excluded_or_renamed_by_hand_stays_so(addon, mode):
    scene = two_rooms()
    shelf = bpy.data.collections.new("Shelf")
    scene.collection.children.link(shelf)
    for name in ("Chair B", "Chair C"):
        copy = bpy.data.objects[name].copy()
        copy.name = f"{name} stored"
        shelf.objects.link(copy)
    layer = bpy.context.view_layer
    layer.layer_collection.children["Shelf"].exclude = True
    bpy.data.objects["Chair A"].hide_set(True)
    turn(scene, 3.14159)
    scene.enfilade.mode = mode
    before = visibility()
    bpy.ops.enfilade.cull()
    assert len(apply_result.hidden_objects(mode)) == 2
    shelf.name = "Attic"
    bpy.data.collections["Enfilade Visible"].name = "mine now"
    bpy.data.objects["Chair B"].hide_set(True)  # by hand, while we hide it too
    bpy.ops.enfilade.cull()
    bpy.ops.enfilade.restore()
    assert bpy.data.objects["Chair B"].hide_get()
    bpy.data.objects["Chair B"].hide_set(False)
    shelf.name = "Shelf"
    assert layer.layer_collection.children["Shelf"].exclude
    after = visibility()
    assert after == before
