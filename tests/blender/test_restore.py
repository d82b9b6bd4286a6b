# SPDX-License-Identifier: GPL-3.0-or-later
"""Hiding can be undone exactly: at once, after saving and loading, after a crash, after the user changed things."""

from __future__ import annotations

import bpy
import pytest
from enfilade.scene import apply_result, collections, cull, detect
from kit import HOUSE, two_rooms, visibility

MODES = apply_result.MODES


def hide_some(scene, mode, names=("Chair B", "Chair C")):
    everything = {"Chair A", "Chair B", "Chair C"}
    return apply_result.apply(scene, everything - set(names), everything, mode)


@pytest.mark.parametrize("mode", MODES)
def test_hiding_and_restoring_leaves_no_trace(mode):
    scene = two_rooms()
    bpy.data.objects["Chair C"].hide_render = True  # the user's own
    before = visibility()
    applied = hide_some(scene, mode)
    assert applied.hidden + applied.already == 2
    assert visibility() != before
    assert apply_result.restore(scene) == applied.hidden
    assert visibility() == before


@pytest.mark.parametrize("mode", MODES)
def test_it_survives_saving_and_loading(mode, tmp_path):
    scene = two_rooms()
    before = visibility()
    hide_some(scene, mode)
    path = str(tmp_path / "culled.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert apply_result.restore(bpy.context.scene) == 2
    assert visibility() == before


@pytest.mark.parametrize("mode", MODES)
def test_what_the_user_changes_in_between_stays(mode):
    scene = two_rooms()
    attribute = {"safe": "visible_camera", "viewport": "hide_viewport", "render": "hide_render"}[mode]
    hidden, shown = (False, True) if mode == "safe" else (True, False)
    hide_some(scene, mode)
    setattr(bpy.data.objects["Chair B"], attribute, shown)  # shows one of ours by hand
    setattr(bpy.data.objects["Chair A"], attribute, hidden)  # hides one that we kept
    bpy.data.objects["Chair C"].name = "Stool"  # renames one of ours
    copy = bpy.data.objects["Stool"].copy()  # duplicates it, hidden as it is
    scene.collection.objects.link(copy)
    apply_result.restore(scene)
    assert getattr(bpy.data.objects["Chair B"], attribute) == shown
    assert getattr(bpy.data.objects["Chair A"], attribute) == hidden
    assert getattr(bpy.data.objects["Stool"], attribute) == shown
    assert getattr(copy, attribute) == shown
    assert not [o for o in bpy.data.objects if apply_result.HIDDEN_KEY in o]


def test_a_crash_between_mark_and_flag_harms_nothing():
    scene = two_rooms()
    before = visibility()
    bpy.data.objects["Chair B"][apply_result.HIDDEN_KEY] = 7  # marked, never hidden
    apply_result.restore(scene)
    assert visibility() == before


def test_damaged_state_counts_as_nothing_and_restores_all_the_same():
    scene = two_rooms()
    before = visibility()
    hide_some(scene, "render")
    scene[apply_result.STATE_KEY] = "{not json"
    assert apply_result.state_of(scene) == {}
    assert apply_result.restore(scene) == 2
    assert visibility() == before


def test_modes_can_be_mixed_and_all_go_back():
    scene = two_rooms()
    before = visibility()
    for mode in MODES:
        hide_some(scene, mode)
    hide_some(scene, "safe", ["Chair A"])
    assert bpy.data.objects["Chair B"].visible_camera and bpy.data.objects["Chair B"].hide_render
    apply_result.restore(scene)
    assert visibility() == before


def test_a_second_cull_writes_the_difference_only():
    scene = two_rooms()
    assert hide_some(scene, "render").changed == 2
    assert hide_some(scene, "render").changed == 0
    assert hide_some(scene, "render", ["Chair A", "Chair B"]).changed == 2
    assert not bpy.data.objects["Chair C"].hide_render and bpy.data.objects["Chair A"].hide_render


def test_the_lists_add_no_visibility_and_go_with_restore():
    scene = two_rooms()
    shelf = bpy.data.collections.new("Shelf")
    scene.collection.children.link(shelf)
    chair = bpy.data.objects["Chair C"]
    scene.collection.objects.unlink(chair)
    shelf.objects.link(chair)
    shelf.hide_render = shelf.hide_viewport = True
    bpy.context.view_layer.update()
    before = visibility()
    collections.list_objects(scene, [chair], [bpy.data.objects["Chair B"]])
    bpy.context.view_layer.update()
    assert not chair.visible_get()
    assert {c.name for c in chair.users_collection} == {"Shelf", "Enfilade Visible"}
    tree = collections.tree_of(scene)
    assert tree.name == "Enfilade" and not any("ifc" in c.name.lower() for c in tree.children_recursive)
    collections.remove_lists(scene)
    bpy.context.view_layer.update()
    assert visibility() == before


def test_the_sample_house_comes_back_exactly_after_everything(tmp_path):
    from enfilade import native
    from enfilade.analysis import Analyser
    from enfilade.scene.shots import shot_of

    bpy.ops.wm.open_mainfile(filepath=str(HOUSE))
    before = visibility()
    scene = bpy.context.scene
    building = detect.detect(scene, bpy.context.view_layer)
    analyser = Analyser(native.load(), building)
    for mode in MODES:
        result = cull.cull(analyser, [shot_of(scene, scene.camera)], "portal", "camera", True)
        applied = cull.write(scene, building, result, mode)
        assert applied.hidden > 50
    collections.draw_cells(scene, analyser.analysis([]).cells, building.rooms, [o.state for o in building.openings])
    outdoors = bpy.data.objects["Enfilade cells Exterior"]
    assert outdoors.hide_viewport and len(outdoors.data.polygons) > 12
    assert not bpy.data.objects["Enfilade cells Living"].hide_viewport
    path = str(tmp_path / "house_culled.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    apply_result.restore(bpy.context.scene)
    collections.remove_tree(bpy.context.scene)
    bpy.context.view_layer.update()
    assert visibility() == before
    analyser.close()
