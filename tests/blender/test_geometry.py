# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms from what a scene draws: by the names of objects, and from one joined mesh without names."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from enfilade import session
from enfilade.scene import apply_result, cull, detect, frame_table
from kit import box, empty_scene, visibility

WALLS = (
    ((-0.2, -0.2, -0.3), (6.2, 4.2, 0)), ((-0.2, -0.2, 2.6), (6.2, 4.2, 2.9)), ((-0.2, 4, 0), (6.2, 4.2, 2.6)),
    ((-0.2, 0, 0), (0, 4, 2.6)), ((6, 0, 0), (6.2, 4, 2.6)), ((-0.2, -0.2, 0), (1, 0, 2.6)), ((2, -0.2, 0), (6.2, 0, 2.6)),
    ((1, -0.2, 2.1), (2, 0, 2.6)), ((3, 0, 0), (3.1, 1, 2.6)), ((3, 2, 0), (3.1, 4, 2.6)), ((3, 1, 2.1), (3.1, 2, 2.6)),
)  # fmt: skip
DOORS = (((1, -0.12, 0), (2, -0.08, 2.1)), ((3.03, 1, 0), (3.07, 2, 2.1)))


def found(scene) -> tuple[int, int]:
    """Rooms, and openings that join two different ones."""
    bpy.context.view_layer.update()
    building = detect.detect(scene, bpy.context.view_layer)
    assert building.source == "geometry"
    return sum(r.kind == "interior" for r in building.rooms), sum(o.rooms is not None for o in building.openings)


def test_named_objects_and_one_mesh_give_the_same_rooms():
    scene = empty_scene()
    for n, (low, high) in enumerate(WALLS):
        box(f"Wall.{n:03d}", low, high)
    for n, (low, high) in enumerate(DOORS):
        box(f"Door_{n}", low, high)
    assert found(scene) == (2, 2)
    scene = empty_scene()
    objects = [box(f"Part {n}", low, high) for n, (low, high) in enumerate((*WALLS, *DOORS))]
    with bpy.context.temp_override(active_object=objects[0], selected_editable_objects=objects):
        bpy.ops.object.join()
    assert found(scene) == (2, 2)


def test_an_empty_scene_is_told():
    scene = empty_scene()
    with pytest.raises(detect.DetectError, match="nothing drawn"):
        detect.detect(scene, bpy.context.view_layer, "geometry")


def test_detect_sees_what_keyframes_hide_now(addon):
    """The partition is hidden by our keys in the viewport: what is hidden isn't evaluated. Keys go when something else is found."""
    scene = empty_scene()
    for n, (low, high) in enumerate((*WALLS, *DOORS)):
        box(f"Wall.{n:03d}" if n < len(WALLS) else f"Door_{n}", low, high)
    hidden = [f"Wall.{n:03d}" for n in (8, 9, 10)]
    table = frame_table.FrameTable(apply_result.VIEWPORT, hidden, {1: np.ones(3, dtype=bool)})
    assert cull.keyframe(scene, table) > 0
    scene.frame_set(1)
    before = visibility()
    search = detect.Search(scene, bpy.context.view_layer, "geometry")
    assert visibility() == before and all(bpy.data.objects[n].hide_viewport for n in hidden)
    assert bpy.data.objects[hidden[0]] not in [i.object.original for i in bpy.context.evaluated_depsgraph_get().object_instances]
    search.run()
    assert sum(r.kind == "interior" for r in search.apply(scene, bpy.context.view_layer).rooms) == 2
    assert bpy.ops.enfilade.detect(source="geometry") == {"FINISHED"}
    assert sum(r.kind == "interior" for r in session.get(scene).building.rooms) == 2
    assert not any(apply_result.KEYED_KEY in o for o in scene.objects)
