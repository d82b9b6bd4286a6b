# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees whom and the animation's table as they run in a window: the operators' handlers driven by made-up events, for without a
window they never are modal."""

from __future__ import annotations

import time
from types import SimpleNamespace

import bpy
import pytest
from enfilade import session
from enfilade.ops import bake, common
from enfilade.scene import frame_table, kept_rows
from kit import two_rooms, visibility


class Driven(common.Background):
    """Stands in for the operator: its functions, and what Blender would give it."""

    bl_label = "Who Sees Whom"
    method = "exact"
    _job = None

    def __init__(self) -> None:
        self.said: list[str] = []

    def report(self, kind, text: str) -> None:
        self.said.append(text)


for name in ("prepare", "finish", "wanted", "close"):
    setattr(Driven, name, getattr(bake.ENFILADE_OT_bake_rooms, name))


class Frames(common.Background):
    """The same of the animation."""

    bl_label = "Bake Animation"
    first, last = 1, 12

    def __init__(self) -> None:
        self.said: list[str] = []

    report = Driven.report


for name in ("prepare", "finish"):
    setattr(Frames, name, getattr(bake.ENFILADE_OT_bake_frames, name))


class Window:
    """A context with a window: notes what the bar and the status line show."""

    def __init__(self) -> None:
        self.bar: list[float] = []
        self.line: str | None = None
        self.timers = 0
        self.scene, self.view_layer, self.window, self.screen = bpy.context.scene, bpy.context.view_layer, None, None
        self.window_manager = SimpleNamespace(
            event_timer_add=self.add_timer, event_timer_remove=self.remove_timer, modal_handler_add=lambda operator: None,
            progress_begin=lambda low, high: None, progress_update=self.bar.append, progress_end=lambda: None)
        self.workspace = SimpleNamespace(status_text_set=lambda text: setattr(self, "line", text))

    def add_timer(self, seconds, window=None):
        self.timers += 1
        return self

    def remove_timer(self, timer) -> None:
        self.timers -= 1


class Held:
    """A bake that lasts until it is cancelled, with next to nothing decided by then."""

    def __init__(self, job) -> None:
        self._job, self.held = job, True

    @property
    def progress(self):
        state = self._job.progress
        return SimpleNamespace(done=state.done and not self.held, fraction=0.4, phase="search")

    def cancel(self) -> None:
        self.held = False
        self._job.cancel()

    def close(self) -> None:
        self._job.close()

    def take(self):
        return self._job.take()

    def __enter__(self):
        return self

    def __exit__(self, *unused) -> None:
        self.close()


@pytest.fixture
def windowed(addon, monkeypatch):
    monkeypatch.setattr(common, "bpy", SimpleNamespace(app=SimpleNamespace(background=False), types=bpy.types))
    two_rooms()
    return Window()


def event(kind: str) -> SimpleNamespace:
    return SimpleNamespace(type=kind)


HANGS = 1800  # s: what lasts so long on any machine will never end


def until(condition) -> None:
    end = time.monotonic() + HANGS
    while not condition():
        assert time.monotonic() < end, "it doesn't come to that"
        time.sleep(0.01)


def run_to_end(operator, window, going=({"PASS_THROUGH"},)) -> set[str]:
    """Lets the timer wake it until it answers anything else than that it goes on."""
    answers = []

    def ended() -> bool:
        answers.append(operator.modal(window, event("TIMER")))
        return answers[-1] not in going

    until(ended)
    return answers[-1]


def hold(monkeypatch, found) -> None:
    start = found.analyser.start_matrix
    monkeypatch.setattr(found.analyser, "start_matrix", lambda method, limit: Held(start(method, 1e-9)))


def data() -> tuple:
    return tuple(sorted(x.name for x in kind) for kind in (bpy.data.objects, bpy.data.collections, bpy.data.texts)), visibility()


def test_it_runs_while_blender_goes_on(windowed):
    operator = Driven()
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert windowed.timers == 1 and [t.name for t in common.running] == ["Who Sees Whom"]
    assert operator.modal(windowed, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert run_to_end(operator, windowed) == {"FINISHED"}
    assert windowed.timers == 0 and windowed.line is None
    assert windowed.bar == sorted(windowed.bar) and all(0 <= f <= 1 for f in windowed.bar)
    assert session.get(windowed.scene).matrix.visible.sum() == 5
    assert kept_rows.load(windowed.scene)
    assert operator.said[-1].startswith("5 of 9 room pairs")


def test_esc_stops_it_and_what_is_open_counts_as_seen(windowed, monkeypatch):
    found = session.ensure(windowed)
    hold(monkeypatch, found)
    before = data()
    operator = Driven()
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    until(lambda: common.running[0].doing == "search")
    assert operator.modal(windowed, event("TIMER")) == {"PASS_THROUGH"}
    assert windowed.line == "Enfilade: search, 40%   Esc stops it"
    assert operator.modal(windowed, event("ESC")) == {"RUNNING_MODAL"}  # the key goes no further
    assert run_to_end(operator, windowed) == {"FINISHED"}
    assert windowed.timers == 0 and windowed.line is None
    assert found.matrix.statistics["interrupted"] and found.matrix.visible.sum() >= 5
    assert "stopped early" in operator.said[-1]
    assert data() == before and kept_rows.load(windowed.scene) is None  # half an answer isn't kept with the file


def test_esc_leaves_what_was_known_before(windowed, monkeypatch):
    found = session.ensure(windowed)
    assert Driven().execute(windowed) == {"FINISHED"}
    known, rows, before = found.matrix, kept_rows.load(windowed.scene), data()
    cells = {cell: list(row) for cell, row in found.analyser._rows.items()}
    hold(monkeypatch, found)
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    operator.modal(windowed, event("ESC"))
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert found.matrix is known and kept_rows.load(windowed.scene) == rows and data() == before
    assert {cell: list(row) for cell, row in found.analyser._rows.items()} == cells
    assert "stays" in operator.said[-1]


@pytest.mark.parametrize("gone", [session.drop, lambda: (session.drop(), session.ensure(bpy.context))])
def test_detected_anew_meanwhile(windowed, monkeypatch, gone):
    hold(monkeypatch, session.ensure(windowed))
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    gone()
    assert run_to_end(operator, windowed) == {"CANCELLED"}
    assert windowed.timers == 0 and windowed.line is None and not common.running
    assert session.ensure(bpy.context).matrix is None


def test_another_file_meanwhile(windowed, monkeypatch):
    hold(monkeypatch, session.ensure(windowed))
    operator = Driven()
    operator.invoke(windowed, event("LEFTMOUSE"))
    operator.cancel(windowed)  # as Blender does before it opens one
    operator.cancel(windowed)
    bpy.ops.wm.read_factory_settings(use_empty=True)


def animate() -> None:
    camera = bpy.context.scene.camera
    camera.keyframe_insert("location", frame=1)
    camera.location.x = 6.0
    camera.keyframe_insert("location", frame=12)


def test_frames_are_walked_in_steps_that_take_nothing_but_esc(windowed):
    animate()
    scene, before = windowed.scene, data()
    scene.frame_set(3)
    operator = Frames()
    assert operator.invoke(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert [t.name for t in common.running] == ["Bake Animation"] and frame_table.load(scene) is None
    assert operator.modal(windowed, event("LEFTMOUSE")) == {"RUNNING_MODAL"}  # nobody may change what is being walked
    assert run_to_end(operator, windowed, ({"PASS_THROUGH"}, {"RUNNING_MODAL"})) == {"FINISHED"} and not common.running and windowed.timers == 0 and windowed.line is None
    assert sorted(frame_table.load(scene).frames) == list(range(1, 13)) and scene.frame_current == 3
    assert windowed.bar and operator.said[-1].startswith("12 frames") and data() != before


def test_esc_while_frames_are_walked_leaves_all_as_it_was(windowed, monkeypatch):
    animate()
    run = Frames()
    assert run.execute(windowed) == {"FINISHED"}
    scene = windowed.scene
    known, before = frame_table.load(scene).to_json(), data()
    monkeypatch.setattr(common.time, "perf_counter", iter(range(10**6)).__next__)  # each step takes a second
    operator = Frames()
    operator.invoke(windowed, event("LEFTMOUSE"))
    operator.modal(windowed, event("TIMER"))
    operator.modal(windowed, event("ESC"))
    assert operator.modal(windowed, event("TIMER")) == {"CANCELLED"}
    assert operator.said == ["Stopped: all is as it was"] and not common.running
    assert frame_table.load(scene).to_json() == known
    (_, now), (_, was) = data(), before
    assert {n: (now[n], was.get(n)) for n in now if now[n] != was.get(n)} == {}


def test_esc_after_that_keeps_the_frames_that_are_known(windowed, monkeypatch):
    animate()
    look, asked = bake.cull.cull, []

    def slow(*given, **named):
        asked.append(1)
        if len(asked) == 5:
            operator._task.stop = True
        return look(*given, **named)

    monkeypatch.setattr(bake.cull, "cull", slow)
    operator = Frames()
    assert operator.execute(windowed) == {"FINISHED"}
    assert sorted(frame_table.load(windowed.scene).frames) == [1, 2, 3, 4, 5]
    assert operator.said[-1] == "Stopped: 5 of 12 frames, up to 5; the others show everything"
