# SPDX-License-Identifier: GPL-3.0-or-later
"""The culled view while it follows: only what changed is written, and whatever the user does meanwhile stays the user's."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from enfilade import handlers, session
from enfilade.scene import apply_result
from enfilade.ui import error_log
from kit import box, camera, empty_scene, visibility


def suite() -> bpy.types.Scene:
    """Five rooms in a row, doors here and there, six things in each."""
    scene = empty_scene()
    rng = np.random.default_rng(3)
    for r in range(5):
        x = 4.2 * r
        box(f"Room_{r}", (x, 0, 0), (x + 4, 4, 2.5)).hide_render = True
        if r:
            y = 0.3 + 2.4 * rng.random()
            box(f"Door_{r}", (x - 0.2, y, 0), (x, y + 1, 2.1)).hide_render = True
        for k in range(6):
            at = np.array([x + 3.5 * rng.random(), 3.5 * rng.random(), 2.0 * rng.random()])
            box(f"thing {r}{k}", at, at + 0.3)
    scene.camera = camera("Eye", (0.5, 2, 1.5), (4, 2, 1.5))
    bpy.context.view_layer.update()
    return scene


def hidden() -> set[str]:
    return {o.name for o in bpy.data.objects if o.hide_viewport}


def step(scene: bpy.types.Scene, i: int) -> None:
    scene.camera.location = (0.5 + 0.45 * i, 2.0 + 0.5 * np.sin(i), 1.5)
    scene.camera.rotation_euler.z += 0.3
    bpy.context.view_layer.update()


def expected(scene: bpy.types.Scene) -> set[str]:
    """Hidden, if all were looked up and written anew."""
    found = session.get(scene)
    view = found.analyser.look(session.live_shots(scene)[0], "portal")
    return found.candidates - {found.building.objects[o].source_id for o in view.objects}


def test_after_every_step_exactly_the_unseen_is_hidden_and_only_the_change_is_written(addon):
    scene = suite()
    before = visibility()
    bpy.ops.enfilade.culled_view()
    live = session.get(scene).live
    last = hidden()
    for i in range(40):
        step(scene, i)
        now = hidden()
        assert now == expected(scene)
        shown = {o.name for o in bpy.context.view_layer.objects if o.visible_get() and o.name.startswith("thing")}
        assert shown == session.get(scene).candidates - now
        look = live.looks[-1]
        assert (look.entered, look.left, look.changed) == (len(last - now), len(now - last), len(last ^ now))
        assert apply_result.state_of(scene)["hidden"] == len(now)
        last = now
    assert sum(look.changed for look in live.looks) > 40
    bpy.ops.enfilade.culled_view()
    after = visibility()
    assert after == before


@pytest.mark.parametrize(("keep", "method"), [("shadow", "portal"), ("camera", "pluecker"), ("camera", "frustum")])
def test_the_other_ways_of_keeping_are_followed_too(addon, keep, method):
    scene = suite()
    error_log.clear()
    scene.enfilade.keep, scene.enfilade.method = keep, method
    bpy.ops.enfilade.culled_view()
    for i in range(6):
        step(scene, i)
        assert error_log.entries() == []
        assert hidden() <= expected(scene)
    bpy.ops.enfilade.culled_view()
    assert hidden() == set()


def test_what_the_user_hides_deletes_or_renames_meanwhile_stays_so(addon):
    scene = suite()
    bpy.ops.enfilade.culled_view()
    step(scene, 0)
    things = [o for o in bpy.data.objects if o.name.startswith("thing")]
    seen = [o for o in things if not o.hide_viewport]
    unseen = [o for o in things if o.hide_viewport]
    seen[0].hide_viewport = True  # by the user's hand
    mine = seen[0].name
    bpy.data.objects.remove(unseen[0])
    unseen[1].name = "renamed"
    for i in range(1, 30):
        step(scene, i)
    assert session.get(scene).live is not None  # it didn't give up
    assert bpy.data.objects[mine].hide_viewport
    bpy.ops.enfilade.culled_view()
    assert hidden() == {mine}
    assert not any("enfilade_hidden" in o for o in bpy.data.objects)


def test_after_undo_the_view_is_brought_up_to_date(addon):
    scene = suite()
    bpy.ops.enfilade.culled_view()
    step(scene, 1)
    for obj in bpy.data.objects:  # as undo would: flags and marks of some earlier time
        if "enfilade_hidden" in obj:
            obj.hide_viewport = False
            del obj["enfilade_hidden"]
    handlers.on_undo()
    bpy.context.view_layer.update()
    step(scene, 2)
    assert hidden() == expected(scene)
    bpy.ops.enfilade.culled_view()
    assert hidden() == set()


def test_a_file_saved_while_culled_is_put_right_after_reload(addon, tmp_path):
    scene = suite()
    before = visibility()
    bpy.ops.enfilade.culled_view()
    step(scene, 3)
    path = str(tmp_path / "live.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)  # a crash would leave the same
    scene = bpy.context.scene
    assert session.get(scene) is None and hidden()
    assert bpy.ops.enfilade.culled_view() == {"FINISHED"}
    step(scene, 4)
    assert hidden() == expected(scene)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert bpy.ops.enfilade.restore() == {"FINISHED"}
    scene = bpy.context.scene
    scene.camera.location, scene.camera.rotation_euler = (0.5, 2, 1.5), scene.camera.rotation_euler
    after = visibility()
    before.pop("scene keys"), after.pop("scene keys")
    assert after == before
