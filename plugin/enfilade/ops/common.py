# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share: one way to tell a person what went wrong, one way to register."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import bpy

from ..analysis import AnalysisError
from ..native import NativeMissing
from ..rules.assemble import AssemblyError
from ..scene.detect import DetectError

EXPECTED = (AnalysisError, DetectError, AssemblyError, NativeMissing, OSError)


def failed(operator: bpy.types.Operator, error: Exception) -> set[str]:
    """Reports a sentence and cancels. Unexpected errors are not caught by callers: they are bugs and show as such."""
    operator.report({"ERROR"}, str(error))
    return {"CANCELLED"}


def registration(classes, forget: Callable[[], None] | None = None) -> tuple[Callable[[], None], Callable[[], None]]:
    """A module's register and unregister. forget: called before its classes go."""

    def register() -> None:
        for cls in classes:
            bpy.utils.register_class(cls)

    def unregister() -> None:
        if forget is not None:
            forget()
        for cls in reversed(classes):
            bpy.utils.unregister_class(cls)

    return register, unregister


class Progress:
    """Of a modal operator: a timer that wakes it, Blender's bar, and a line in the status bar while it runs."""

    def __init__(self, context: bpy.types.Context, operator: bpy.types.Operator) -> None:
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(operator)
        context.window_manager.progress_begin(0.0, 1.0)

    def show(self, context: bpy.types.Context, what: str, fraction: float) -> None:
        context.window_manager.progress_update(fraction)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Enfilade: {what}, {fraction:.0%}   Esc stops it")

    def end(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)


class Task:
    """Work and what is known of it. Plain data, no operator: that may be gone, its file closed, while the thread still runs."""

    def __init__(self, work, doing: str) -> None:
        self.fraction, self.doing, self.stop, self.name = 0.0, doing, False, doing
        self.given: Any = None
        self.error: Exception | None = None
        self._work = work
        self.thread = threading.Thread(target=self.run, daemon=True)

    def run(self) -> None:
        def progress(fraction: float, text: str = "") -> bool:
            self.fraction, self.doing = fraction, text or self.doing
            return not self.stop

        try:
            self.given = self._work(progress)
        except Exception as error:  # told at the end: a thread has nobody to tell
            self.error = error


running: list[Task] = []  # beside Blender now; the panel shows them


class Background:
    """Of an operator whose work takes long: in a window it runs in a thread that touches no Blender data while a timer looks after it,
    and Esc stops it; without one the same operator runs to its end.

    The operator has `prepare(context)`, which gives the work: called with progress(fraction, text), which returns False to stop; then
    `finish(context, what the work gave)`, and maybe `close()`, called last whatever happened."""

    def close(self) -> None:
        """Lets go of what `prepare` took."""

    @classmethod
    def idle(cls) -> bool:
        """For `poll`: whether none of its kind runs."""
        if any(task.name == cls.bl_label for task in running):
            cls.poll_message_set(f"{cls.bl_label} is at work: Esc stops it")
            return False
        return True

    def _start(self, context: bpy.types.Context) -> bool:
        try:
            self._task = Task(self.prepare(context), self.bl_label)
        except EXPECTED as error:
            failed(self, error)
            self.close()
            return False
        except Exception:
            self.close()
            raise
        return True

    def _end(self, context: bpy.types.Context) -> set[str]:
        try:
            return failed(self, self._task.error) if self._task.error is not None else self.finish(context, self._task.given)
        finally:
            self.close()

    def execute(self, context):
        if not self._start(context):
            return {"CANCELLED"}
        self._task.run()
        return self._end(context)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        if not self._start(context):
            return {"CANCELLED"}
        self._task.thread.start()
        running.append(self._task)
        self._progress = Progress(context, self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._task.stop = True
            return {"RUNNING_MODAL"}  # meant for us: nothing else is to be left by it
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        self._progress.show(context, self._task.doing, self._task.fraction)
        redraw(context, "UI")
        if self._task.thread.is_alive():
            return {"PASS_THROUGH"}
        running.remove(self._task)
        self._progress.end(context)
        return self._end(context)

    def cancel(self, context):
        """Another file is opened, or Blender quits: what the thread uses must outlive it."""
        self._task.stop = True
        self._task.thread.join()
        running.remove(self._task)
        self.close()


def redraw(context: bpy.types.Context, part: str | None = None) -> None:
    """The 3D views, or a part of them: "UI" is the sidebar."""
    if context.screen is None:
        return
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if part is None or region.type == part:
                        region.tag_redraw()
