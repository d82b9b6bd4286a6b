# SPDX-License-Identifier: GPL-3.0-or-later
"""Detect as it runs in a window: beside Blender, the scene changes at the end and all at once, Esc leaves everything as it was."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import bpy
import pytest
from enfilade import session
from enfilade.ops import analyse, common
from enfilade.rules import ifc_shapes
from enfilade.scene import detect, kept_text
from kit import DATA, box, empty_scene, two_rooms, visibility
from test_modal_bake import Window, event, run_to_end, until


class Driven(common.Background):
    """Stands in for the operator: its functions, and what Blender would give it."""

    bl_label = "Detect"
    source = "scene"
    ifc = ""

    def __init__(self) -> None:
        self.said: list[tuple[set, str]] = []

    def report(self, kind, text: str) -> None:
        self.said.append((kind, text))


for name in ("prepare", "finish"):
    setattr(Driven, name, getattr(analyse.ENFILADE_OT_detect, name))


@pytest.fixture
def windowed(addon, monkeypatch):
    monkeypatch.setattr(common, "bpy", SimpleNamespace(app=SimpleNamespace(background=False), types=bpy.types))
    two_rooms()
    return Window()


@pytest.fixture
def held(monkeypatch):
    """The search waits at its first step until it is let go, or told to stop."""
    gate, search = threading.Event(), detect.Search.run

    def run(self, progress=None):
        while not gate.wait(0.01):
            if progress(0.25, "walls") is False:
                raise ifc_shapes.Cancelled("walls")
        search(self, progress)

    monkeypatch.setattr(detect.Search, "run", run)
    return gate


def data() -> tuple:
    kinds = (bpy.data.objects, bpy.data.meshes, bpy.data.collections, bpy.data.texts, bpy.data.materials)
    return tuple(sorted(x.name for x in kind) for kind in kinds), visibility(), sorted(bpy.context.scene.keys())


def test_blender_goes_on_and_the_scene_changes_at_the_end(windowed, held):
    before = data()
    operator = Driven()
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert [t.name for t in common.running] == ["Detect"]
    until(lambda: common.running[0].fraction == 0.25)
    assert operator.modal(windowed, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert operator.modal(windowed, event("TIMER")) == {"PASS_THROUGH"}
    assert windowed.line == "Enfilade: walls, 25%   Esc stops it"
    assert data() == before and session.get(windowed.scene) is None
    held.set()
    assert run_to_end(operator, windowed) == {"FINISHED"}
    assert windowed.timers == 0 and windowed.line is None and not common.running
    assert len(session.get(windowed.scene).building.openings) == 1
    assert operator.said[-1][1].startswith("3 rooms, 1 openings")


def test_esc_leaves_everything_as_it_was(windowed, held):
    bpy.ops.object.select_all(action="DESELECT")
    held.set()
    run = Driven()
    run.invoke(windowed, event("LEFTMOUSE"))
    run_to_end(run, windowed)
    bpy.ops.enfilade.cull()
    held.clear()
    found, before = session.get(windowed.scene), data()
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    assert operator.modal(windowed, event("ESC")) == {"RUNNING_MODAL"}  # the key goes no further
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert operator.said[-1] == ({"INFO"}, "Stopped: all is as it was")
    assert session.get(windowed.scene) is found and data() == before
    assert windowed.timers == 0 and windowed.line is None and not common.running


def test_the_panel_can_stop_it_too(windowed, held):
    assert not bpy.ops.enfilade.stop.poll()
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    assert not analyse.ENFILADE_OT_detect.poll(windowed)  # one at a time
    assert bpy.ops.enfilade.stop() == {"FINISHED"}
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert analyse.ENFILADE_OT_detect.poll(windowed)


def test_another_file_meanwhile(windowed, held):
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    operator.cancel(windowed)  # as Blender does before it opens one
    assert not common.running
    bpy.ops.wm.read_factory_settings(use_empty=True)


def test_the_scene_is_deleted_meanwhile(windowed, held):
    doomed = windowed.scene
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    windowed.scene = bpy.data.scenes.new("other")
    bpy.data.scenes.remove(doomed)
    held.set()
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert "is gone" in operator.said[-1][1]


def test_bad_input_is_told_and_nothing_stays_behind(windowed):
    operator = Driven()
    operator.ifc = "/nowhere/house.ifc"
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"CANCELLED"}
    assert operator.said == [({"ERROR"}, "There is no file /nowhere/house.ifc.")]
    assert windowed.timers == 0 and not common.running


def test_an_error_in_the_search_is_told_at_its_end(windowed):
    empty_scene()
    windowed.scene, windowed.view_layer = bpy.context.scene, bpy.context.view_layer
    box("Room_Alone", (0, 0, 0), (4, 4, 3))
    windowed.scene.enfilade.source = "annotated"
    bpy.data.objects["Room_Alone"].name = "Alone"
    before = data()
    operator = Driven()
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert operator.said[-1][0] == {"ERROR"} and "No room is marked" in operator.said[-1][1]
    assert data() == before


def test_an_ifc_model_comes_in_whole_or_not_at_all(windowed, monkeypatch):
    path = DATA / "ifc" / "3rooms_Heater_AirTerminal_Table_with_SB.ifc"
    if not path.is_file():
        pytest.skip(f"no {path}")
    empty_scene()
    windowed.scene, windowed.view_layer = bpy.context.scene, bpy.context.view_layer
    gate, told, tell = threading.Event(), [], common.Task.tell

    def slow(task, fraction, text=""):
        """The search waits half way until it is let go."""
        told.append(fraction)
        tell(task, fraction, text)
        if fraction > 0.5:
            gate.wait()
        return tell(task, fraction, text)

    monkeypatch.setattr(common.Task, "tell", slow)
    operator = Driven()
    operator.ifc = str(path)
    before = data()
    for end in ({"CANCELLED"}, {"FINISHED"}):
        gate.clear()
        told.clear()
        assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
        until(lambda: common.running[0].fraction > 0.5)
        assert operator.modal(windowed, event("TIMER")) == {"PASS_THROUGH"} and windowed.bar[-1] == told[-1]
        assert data() == before
        if end == {"CANCELLED"}:
            operator.modal(windowed, event("ESC"))
        gate.set()
        assert run_to_end(operator, windowed) == end
        assert (data() == before) == (end == {"CANCELLED"})
    assert told == sorted(told) and len(set(told)) > 3
    assert len(bpy.data.meshes) > 5 and session.get(windowed.scene).building.source == "ifc"


def test_what_a_detect_found_goes_when_it_was_undone(addon):
    scene = two_rooms()
    assert bpy.ops.enfilade.detect() == {"FINISHED"}
    session.forget_objects()
    assert session.get(scene) is not None
    del scene[detect.STAMP_KEY]  # as undo leaves it
    session.forget_objects()
    assert session.get(scene) is None


def test_long_texts_are_kept_in_lines(addon):
    scene = empty_scene()
    content = "\u00e9 " + "0123456789, " * 100_000
    kept_text.store(scene, "enfilade_building", "Enfilade building", content)
    assert max(len(line.body) for line in bpy.data.texts["Enfilade building"].lines) <= kept_text.LINE
    assert kept_text.load(scene, "enfilade_building") == content
