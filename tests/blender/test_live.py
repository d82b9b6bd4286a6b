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


def shelve(scene: bpy.types.Scene) -> None:
    """The things into a collection a room; some are in a larger one besides."""
    every = bpy.data.collections.new("Every other")
    scene.collection.children.link(every)
    for r in range(5):
        shelf = bpy.data.collections.new(f"Shelf {r}")
        scene.collection.children.link(shelf)
        for k in range(6):
            thing = bpy.data.objects[f"thing {r}{k}"]
            shelf.objects.link(thing)
            thing["was"] = thing.name
            if k % 2:
                every.objects.link(thing)
            scene.collection.objects.unlink(thing)
    bpy.context.view_layer.update()


def disturb(scene: bpy.types.Scene, i: int) -> None:
    """What people do to objects and collections: each changes where others stand in Blender's lists."""
    shelf = bpy.data.collections.get(f"Shelf {i % 5}")
    objects = [o for o in bpy.data.objects if o.name.startswith("thing")]
    match i % 7:
        case 0:  # deleted: all that come after it move up
            bpy.data.objects.remove(objects[0])
        case 1:  # to the end of its collection
            if shelf is not None and len(shelf.objects):
                first = shelf.objects[0]
                shelf.objects.unlink(first)
                shelf.objects.link(first)
        case 2:  # made anew; names sort before the others
            box(f"a new one {i}", (1 + i, 1, 1), (1.2 + i, 1.2, 1.2))
        case 3:  # renamed, which sorts it elsewhere
            objects[-1].name = f"b {i}"
        case 4:
            if shelf is not None:
                for o in list(shelf.objects):
                    scene.collection.objects.link(o)
                bpy.data.collections.remove(shelf)
        case 5:
            if shelf is not None:
                shelf.name = f"Renamed {i}"
        case 6:  # hidden by the user's hand
            next((o for o in objects if not o.hide_viewport), objects[0]).hide_viewport = True


def test_objects_and_collections_may_change_at_every_step(addon):
    scene = suite()
    shelve(scene)
    error_log.clear()
    bpy.ops.enfilade.culled_view()
    for i in range(35):
        disturb(scene, i)
        users = {o["was"] for o in bpy.data.objects if o.hide_viewport and "enfilade_hidden" not in o}
        step(scene, i)
        there = {o["was"] for o in scene.objects if "was" in o}
        now = {o["was"] for o in bpy.data.objects if o.hide_viewport}
        assert error_log.entries() == []
        assert now - users == (expected(scene) & there) - users, i
    bpy.ops.enfilade.culled_view()
    assert {o["was"] for o in bpy.data.objects if o.hide_viewport} == users and users
    assert not any("enfilade_hidden" in o for o in bpy.data.objects)


def test_flags_are_written_to_nobody_else_however_wrong_the_places_remembered_are(addon):
    scene = suite()
    shelve(scene)
    things = [o for o in bpy.data.objects if o.name.startswith("thing")]
    things[3].hide_viewport = True
    rng = np.random.default_rng(5)
    for _ in range(40):
        apply_result._find_homes()
        places = list(apply_result._homes.values())
        for i, address in enumerate(list(apply_result._homes)):
            if rng.random() < 0.3:
                apply_result._homes[address] = places[rng.integers(len(places))]
            elif rng.random() < 0.1:
                apply_result._homes[address] = ("gone", i)
        apply_result._orders["gone"] = np.arange(len(places))
        before = {o.name: o.hide_viewport for o in bpy.data.objects}
        chosen = [things[i] for i in rng.choice(len(things), 8, replace=False)]
        hide = [o for o in chosen[:4] if not o.hide_viewport]
        show = [o for o in chosen[4:] if o.hide_viewport and apply_result.HIDDEN_KEY in o]
        apply_result._write(apply_result.VIEWPORT, hide, show)
        after = {o.name: o.hide_viewport for o in bpy.data.objects}
        assert after == before | {o.name: True for o in hide} | {o.name: False for o in show}
    apply_result.restore(scene)
    assert hidden() == {things[3].name}


def with_a_library(folder) -> tuple[bpy.types.Scene, list[bpy.types.Object]]:
    """The suite, with what is in room 3 linked and in room 1 overridden; of the overrides every other one may be edited."""
    suite()
    for r in (1, 3):
        store = bpy.data.collections.new(f"Store {r}")
        for k in range(6):
            store.objects.link(bpy.data.objects[f"thing {r}{k}"])
        store.use_fake_user = True
    path = str(folder / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    scene = suite()
    for r in (1, 3):
        for k in range(6):
            bpy.data.objects.remove(bpy.data.objects[f"thing {r}{k}"])
    with bpy.data.libraries.load(path, link=True) as (_, into):
        into.collections = ["Store 1", "Store 3"]
    scene.collection.children.link(into.collections[1])
    into.collections[0].override_hierarchy_create(scene, bpy.context.view_layer)
    overrides = [o for o in scene.objects if o.override_library is not None]
    for o in overrides[::2]:
        o.override_library.is_system_override = False
    bpy.context.view_layer.update()
    assert len(overrides) == 6 and sum(apply_result.is_writable(o) for o in overrides) == 3
    return scene, overrides


def test_flags_go_past_what_cannot_be_written(addon, tmp_path):
    """Blender's own bulk write passes over such objects, and gives what was meant for them to those that come after."""
    _, overrides = with_a_library(tmp_path)
    things = [o for o in bpy.data.objects if o.name.startswith("thing")]
    rng = np.random.default_rng(7)
    for i in range(60):
        for o in things:
            o.hide_viewport = bool(rng.random() < 0.5)
        if i % 2:  # unknown to the places remembered
            o = overrides[rng.integers(len(overrides))]
            o.override_library.is_system_override = not o.override_library.is_system_override
        before = {o.name_full: o.hide_viewport for o in things}
        chosen = [o for o in rng.choice(np.array(things, dtype=object), 6, replace=False) if apply_result.is_writable(o)]
        hide, show = [o for o in chosen if not o.hide_viewport], [o for o in chosen if o.hide_viewport]
        apply_result._set_flags("hide_viewport", hide, show)
        after = {o.name_full: o.hide_viewport for o in things}
        assert after == before | {o.name_full: not before[o.name_full] for o in chosen}
        apply_result._find_homes()
        turned = [(o, before[o.name_full]) for o in chosen]
        assert apply_result._set_where_they_stood("hide_viewport", turned)  # in bulk, not one by one
        assert {o.name_full: o.hide_viewport for o in things} == before


def test_linked_objects_stay_and_of_overrides_those_that_may_be_edited_are_hidden(addon, tmp_path):
    scene, overrides = with_a_library(tmp_path)
    fixed = {o.name_full for o in scene.objects if not apply_result.is_writable(o)}
    error_log.clear()
    bpy.ops.enfilade.culled_view()
    were_hidden: set[str] = set()
    for i in range(25):
        if i == 12:  # in the middle of it what may be written changes
            overrides[1].override_library.is_system_override = False
            fixed.remove(overrides[1].name_full)
        step(scene, i)
        now = {o.name_full for o in scene.objects if o.hide_viewport}
        assert error_log.entries() == []
        assert now <= expected(scene) - fixed
        assert expected(scene) - fixed - now <= {overrides[1].name_full}  # it may have been due before
        were_hidden |= now
    assert were_hidden & {o.name_full for o in overrides}
    bpy.ops.enfilade.culled_view()
    assert not [o.name_full for o in bpy.data.objects if o.hide_viewport]
