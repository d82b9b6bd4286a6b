# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that the user marked as occluders: what stands behind is hidden when asked for, and only when it surely is hidden."""

from __future__ import annotations

import bpy
import pytest
from enfilade import session
from kit import box, two_rooms


def wardrobe(scene, mark=1) -> bpy.types.Object:
    """Before the door, wider and higher than it."""
    made = box("Wardrobe", (3.2, 0.8, 0), (3.7, 3.2, 2.4), enfilade_occluder=mark)
    bpy.context.view_layer.update()
    return made


def hidden_by(scene, occluders="on") -> set[str]:
    scene.enfilade.mode, scene.enfilade.occluders = "viewport", occluders
    bpy.ops.enfilade.detect()
    bpy.ops.enfilade.cull()
    out = {o.name for o in bpy.data.objects if o.hide_viewport}
    bpy.ops.enfilade.restore()
    return out


@pytest.mark.parametrize("mark", [1, "box"])
def test_a_wardrobe_before_the_door_hides_the_room_behind(addon, mark):
    scene = two_rooms()
    wardrobe(scene, mark)
    assert hidden_by(scene, "off") == {"Chair C"}
    assert hidden_by(scene, "on") == {"Chair B", "Chair C"}
    assert hidden_by(scene, "auto") == {"Chair C"}  # three objects: not worth it


def test_one_that_is_lower_than_the_door_hides_nothing(addon):
    scene = two_rooms()
    box("Sideboard", (3.2, 0.8, 0), (3.7, 3.2, 0.7), enfilade_occluder=1)
    bpy.context.view_layer.update()
    assert hidden_by(scene) == {"Chair C"}


def glassy(obj) -> None:
    material = bpy.data.materials.new("pane")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
    obj.data.materials.append(material)


def animated(obj) -> None:
    obj.keyframe_insert("location", frame=1)


def without_camera_rays(obj) -> None:
    obj.visible_camera = False


def wired(obj) -> None:
    obj.display_type = "WIRE"


def thinner_in_renders(obj) -> None:
    modifier = obj.modifiers.new("thick", "SOLIDIFY")
    modifier.show_render = False


@pytest.mark.parametrize("change", [glassy, animated, without_camera_rays, wired, thinner_in_renders])
def test_what_may_not_block_sight_does_not_count(addon, change):
    scene = two_rooms()
    change(wardrobe(scene))
    bpy.context.view_layer.update()
    assert "Chair B" not in hidden_by(scene)
    bpy.ops.enfilade.detect()
    assert "occluder-left-out" in {p.code for p in session.get(scene).problems}


def test_the_live_view_forgets_occluders_that_the_user_moves(addon):
    scene = two_rooms()
    made = wardrobe(scene)
    scene.enfilade.occluders = "on"
    bpy.ops.enfilade.culled_view()
    chair = bpy.data.objects["Chair B"]
    assert chair.hide_viewport
    made.location.y += 3.0
    bpy.context.view_layer.update()
    assert not chair.hide_viewport
    bpy.ops.enfilade.culled_view()
