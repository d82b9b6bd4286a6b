# SPDX-License-Identifier: GPL-3.0-or-later
"""What the window shows of problems and of scenes that lack something: many alike, none placed, no camera."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
from enfilade import session
from enfilade.ops import diagnose
from enfilade.rules.building import WARNING, Problem
from enfilade.scene import cameras, markers
from enfilade.ui import overlay, panel_data
from kit import two_rooms


def troubled(count: int) -> session.Session:
    scene = two_rooms()
    assert bpy.ops.enfilade.detect() == {"FINISHED"}
    found = session.get(scene)
    found.problems[:] = [
        Problem(WARNING, "room-open", f"room '{i}' is open over 3.5 m2", ["Chair A"], (0.1 * i, 0.0, 1.0), "draw the wall") for i in range(count)
    ] + [Problem(WARNING, "lonely", "one of its kind", [], (9.0, 9.0, 9.0), "")]
    session.touch()
    return found


def points(found) -> np.ndarray:
    return np.concatenate([p for p, _ in overlay.build(found, bpy.context.scene.enfilade).points])


def test_a_few_are_all_marked_and_of_many_one_a_neighbourhood(addon):
    assert len(points(troubled(overlay.CROWD))) == overlay.CROWD + 1
    drawn = points(troubled(200))
    assert overlay.NEIGHBOURHOODS <= len(drawn) <= overlay.NEIGHBOURHOODS + 3
    assert any(np.allclose(p, 9.0) for p in drawn)


def test_a_kind_can_be_switched_off_in_the_view_and_for_markers(addon):
    found = troubled(30)
    assert bpy.ops.enfilade.mute_problem(code="room-open") == {"FINISHED"}
    assert len(points(found)) == 1
    bpy.ops.enfilade.mark_problems()
    assert sorted(o.name for o in bpy.data.objects if "enfilade_problem" in o) == ["31 lonely"]
    bpy.ops.enfilade.mark_problems()
    bpy.ops.enfilade.mute_problem(code="room-open")
    bpy.ops.enfilade.mark_problems()
    made = [o for o in bpy.data.objects if "enfilade_problem" in o]
    assert len(made) == 31 > markers.MOST_NAMED and not any(o.show_name for o in made)
    assert made[0]["message"] and made[0]["remedy"] and made[0]["objects"] == "Chair A"


def test_the_panel_tells_them_once_and_the_magnifier_steps_through(addon):
    found = troubled(30)
    rows = panel_data.of(bpy.context.scene).problems
    assert [(r.code, r.count, r.placed) for r in rows] == [("room-open", 30, True), ("lonely", 1, True)]
    assert rows[0].message == "Room '0' is open over 3.5 m\u00b2" and rows[0].remedy == "Draw the wall"
    places = []
    for _ in range(31):
        assert bpy.ops.enfilade.show_problem(index=rows[0].index, alike=True) == {"FINISHED"}
        places.append(tuple(round(x, 3) for x in bpy.context.scene.cursor.location))
    assert len(set(places[:30])) == 30 and places[30] == places[0]
    assert tuple(np.round(found.problems[0].position, 3)) in places


def test_the_magnifier_leaves_the_camera_to_look_at_the_place(addon):
    """In a camera's view moving the view would show nothing of the place."""
    found = troubled(1)
    view = SimpleNamespace(view_perspective="CAMERA", view_location=None, view_distance=0.0)
    diagnose.ENFILADE_OT_show_problem._frame(SimpleNamespace(region_data=view), found.problems[1], [])
    assert view.view_perspective == "PERSP" and view.view_location == (9.0, 9.0, 9.0) and view.view_distance == 4.0


def test_cameras_are_added_where_there_are_none(addon):
    scene = two_rooms()
    bpy.data.objects.remove(scene.camera)
    bpy.context.view_layer.update()
    assert bpy.ops.enfilade.detect() == {"FINISHED"}
    assert any(p.code == cameras.NO_CAMERA for p in session.get(scene).problems)
    assert bpy.ops.enfilade.add_cameras(count=2) == {"FINISHED"}
    # C has no door: nobody looks from there first
    assert sorted(o.name for o in scene.objects if o.type == "CAMERA") == ["Camera A", "Camera B"] and scene.camera is not None
    assert not any(p.code == cameras.NO_CAMERA for p in session.get(scene).problems)
    assert bpy.ops.enfilade.culled_view() == {"FINISHED"}


def test_a_look_of_the_live_view_makes_only_what_it_changes_anew(addon):
    scene = two_rooms()
    settings = scene.enfilade
    bpy.ops.enfilade.culled_view()
    found = session.get(scene)
    data, drawn = panel_data.of(scene), overlay.of_view(found, settings)
    assert data.live and ("B", "AB") in data.seen
    revision = session.revision
    scene.camera.rotation_euler.z += np.pi
    bpy.context.view_layer.update()
    after, turned = panel_data.of(scene), overlay.of_view(found, settings)
    assert session.revision == revision  # nothing else is asked to be looked at again
    assert [room for room, _ in after.seen] == ["A"] and after.seen_figures != data.seen_figures and after.applied != data.applied
    assert after.opening_of is data.opening_of and after.problems is data.problems and after.figures is data.figures
    assert [(len(points), colour) for points, colour, _ in turned.lines] != [(len(points), colour) for points, colour, _ in drawn.lines]
    assert overlay._outlines(found.building)[0] is overlay._outlines(found.building)[0]
    bpy.ops.enfilade.culled_view()
    assert not panel_data.of(scene).live
