# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed since the last Detect is told to whom it matters: Bake Animation, the panel, a file opened again."""

from __future__ import annotations

import bpy
import pytest
from enfilade import session
from enfilade.scene import cull, frame_table, since_detect
from enfilade.ui import panel_data
from kit import box, camera, empty_scene, two_rooms
from test_geometry import DOORS, WALLS
from test_modal_bake import Frames, Window


def building() -> bpy.types.Scene:
    scene = empty_scene()
    for n, (low, high) in enumerate((*WALLS, *DOORS)):
        box(f"Wall.{n:03d}" if n < len(WALLS) else f"Door_{n}", low, high)
    box("Table", (1, 1, 0), (2, 2, 0.8))
    box("Cart", (4, 2, 0), (4.5, 2.5, 0.8))
    scene.camera = camera("Eye", (0.5, 2, 1.5), (5, 2, 1.5))
    bpy.context.view_layer.update()
    assert bpy.ops.enfilade.detect(source="geometry") == {"FINISHED"}
    return scene


def told() -> list[str]:
    """What Bake Animation says about it."""
    operator = Frames()
    operator.last = 3
    assert operator.execute(Window()) == {"FINISHED"}
    scene = bpy.context.scene
    frame_table.remove(scene)
    cull.unkey(scene)
    bpy.ops.enfilade.restore()
    return [line for line in operator.said if "since the last Detect" in line]


def cut(obj: bpy.types.Object) -> None:
    """As an opening is: the bounds stay."""
    import bmesh

    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(mesh, edges=mesh.edges[:], cuts=1, use_grid_fill=True)
    mesh.faces.ensure_lookup_table()
    bmesh.ops.delete(mesh, geom=[mesh.faces[0]], context="FACES_ONLY")
    mesh.to_mesh(obj.data)
    mesh.free()


@pytest.mark.parametrize("change", ["move", "cut", "delete", "modifier", "corner"])
def test_a_changed_wall_is_told(addon, change, tmp_path):
    scene = building()
    assert told() == []
    wall = bpy.data.objects["Wall.008"]
    if change == "move":
        wall.location.x += 0.01
    elif change == "cut":
        cut(wall)
    elif change == "delete":
        bpy.data.objects.remove(wall)
    elif change == "modifier":
        wall.modifiers.new("hole", "BOOLEAN")
    else:
        wall.data.vertices[0].co.x -= 0.01
        wall.data.update()
    bpy.context.view_layer.update()
    assert told() == ["1 object was moved, edited, hidden or deleted since the last Detect: rooms and openings are as they were found then. "
                      "Detect again if that is part of the building."]
    path = str(tmp_path / "changed.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    found = session.ensure(bpy.context)
    problems = [p for p in found.problems if p.code == since_detect.CODE]
    assert len(problems) == 1 and problems[0].names == ([] if change == "delete" else ["Wall.008"])
    assert any(row.code == since_detect.CODE for row in panel_data.of(scene).problems)
    assert bpy.ops.enfilade.detect(source="geometry") == {"FINISHED"}
    assert told() == [] and not any(p.code == since_detect.CODE for p in session.get(scene).problems)


def test_what_changes_no_room_is_not_told(addon, tmp_path):
    scene = building()
    bpy.data.objects["Wall.008"].name = "Partition"
    box("Chair", (3, 2, 0), (3.4, 2.4, 0.9))
    cart = bpy.data.objects["Cart"]
    cart.keyframe_insert("location", frame=1)
    bpy.ops.enfilade.detect(source="geometry")
    cart.location.y = 1
    cart.keyframe_insert("location", frame=3)
    scene.frame_set(2)
    assert told() == []
    bpy.ops.enfilade.cull()  # hidden by us is no change
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "same.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "same.blend"))
    assert not any(p.code == since_detect.CODE for p in session.ensure(bpy.context).problems)
    assert told() == []


def test_the_panel_counts_what_moved(addon):
    scene = building()
    assert panel_data.of(scene).moved == 0
    bpy.data.objects["Wall.008"].location.x += 0.5
    bpy.context.view_layer.update()
    assert panel_data.of(scene).moved == 1
    bpy.ops.enfilade.detect(source="geometry")
    assert panel_data.of(scene).moved == 0


def test_marks_are_read_anew_and_need_no_telling(addon):
    scene = two_rooms()
    bpy.ops.enfilade.detect()
    bpy.data.objects["Chair B"].location.x += 0.5
    bpy.context.view_layer.update()
    assert since_detect.KEY not in scene and told() == []
