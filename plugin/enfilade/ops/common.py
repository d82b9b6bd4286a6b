# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share: one way to tell a person what went wrong, one way to register."""

from __future__ import annotations

import inspect
import math
import textwrap
import threading
import time
from collections.abc import Callable
from typing import Any

import bpy

from ..analysis import AnalysisError
from ..native import NativeMissing
from ..rules.assemble import AssemblyError
from ..scene.detect import DetectError

LINE = 110  # characters of a popup's line
EXPECTED = (AnalysisError, DetectError, AssemblyError, NativeMissing, OSError)


def failed(operator: bpy.types.Operator, error: Exception) -> set[str]:
    """Reports a sentence and cancels. Unexpected errors are not caught by callers: they are bugs and show as such."""
    text = str(error)
    if isinstance(error, OSError) and error.filename and error.strerror:
        text = f"{error.filename} can't be used: {error.strerror}."
    if not bpy.app.background:  # the popup breaks no lines, and ends at the window's edge
        text = "\n".join(textwrap.wrap(text, LINE, break_long_words=False, break_on_hyphens=False))
    operator.report({"ERROR"}, text)
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

    def __init__(self, name: str) -> None:
        self.fraction, self.doing, self.stop, self.name = 0.0, name, False, name
        self.given: Any = None
        self.error: Exception | None = None
        self.work: Any = None
        self.thread = threading.Thread(target=self.run, daemon=True)

    def run(self) -> None:
        try:
            self.given = self.work(self.tell)
        except Exception as error:  # told at the end: a thread has nobody to tell
            self.error = error

    def tell(self, fraction: float, text: str = "") -> bool:
        self.fraction, self.doing = fraction, text or self.doing
        return not self.stop


running: list[Task] = []  # beside Blender now; the panel shows them


class Background:
    """Of an operator whose work takes long: in a window it runs in a thread that touches no Blender data while a timer looks after it,
    and Esc stops it; without one the same operator runs to its end.

    The operator has `prepare(context)`, which gives the work: called with progress(fraction, text), which returns False to stop; then
    `finish(context, what the work gave)`, and maybe `close()`, called last whatever happened. Where Blender's data must be read for
    long (frame by frame), `prepare` is a generator that yields (fraction, text) and returns the work: the window then shows how far it
    is, and takes nothing but Esc, which closes the generator; `finish` gets None."""

    _steps = None  # the generator, while it prepares

    def close(self) -> None:
        """Lets go of what `prepare` took."""

    def wanted(self) -> bool:
        """Whether what it works for is still there; else it is stopped."""
        return True

    @classmethod
    def idle(cls) -> bool:
        """For `poll`: whether none of its kind runs."""
        if any(task.name == cls.bl_label for task in running):
            cls.poll_message_set(f"{cls.bl_label} is at work: Esc stops it")
            return False
        return True

    def _start(self, context: bpy.types.Context) -> bool:
        self._task = Task(self.bl_label)
        return self._try(lambda: self._take(self.prepare(context)))

    def _take(self, prepared: Any) -> None:
        if inspect.isgenerator(prepared):
            self._steps = prepared
        else:
            self._task.work = prepared

    def _step(self, seconds: float) -> bool:
        """Prepares on, as many steps as fit; False: it went wrong, and is told."""
        end = time.perf_counter() + seconds

        def steps() -> None:
            try:
                while True:
                    self._task.tell(*next(self._steps))
                    if time.perf_counter() > end:
                        return
            except StopIteration as last:
                self._steps, self._task.work = None, last.value

        return self._try(steps)

    def _try(self, part: Callable[[], None]) -> bool:
        try:
            part()
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
        if not self._start(context) or (self._steps is not None and not self._step(math.inf)):
            return {"CANCELLED"}
        self._task.run()
        return self._end(context)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        if not self._start(context):
            return {"CANCELLED"}
        if self._steps is None:
            self._task.thread.start()
        running.append(self._task)
        self._progress = Progress(context, self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._task.stop = True
            return {"RUNNING_MODAL"}  # meant for us: nothing else is to be left by it
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if self._steps is None else {"RUNNING_MODAL"}
        if not self.wanted():
            self._task.stop = True
        self._progress.show(context, self._task.doing, self._task.fraction)
        redraw(context, "UI")
        if self._steps is not None:
            return self._prepare_on(context)
        if self._task.thread.is_alive():
            return {"PASS_THROUGH"}
        self._leave(context)
        return self._end(context)

    def _prepare_on(self, context: bpy.types.Context) -> set[str]:
        if self._task.stop:
            self._drop_steps()
            self._leave(context)
            return self._end(context)
        if not self._step(0.08):
            self._leave(context)
            return {"CANCELLED"}
        if self._steps is None:
            self._task.thread.start()
        return {"RUNNING_MODAL"}

    def _drop_steps(self) -> None:
        if self._steps is not None:
            self._steps.close()
            self._steps = None

    def _leave(self, context: bpy.types.Context) -> None:
        running.remove(self._task)
        self._progress.end(context)

    def cancel(self, context):
        """Another file is opened, or Blender quits: what the thread uses must outlive it."""
        self._task.stop = True
        self._drop_steps()
        if self._task.thread.ident is not None:
            self._task.thread.join()
        if self._task in running:
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
