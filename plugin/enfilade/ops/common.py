# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share: one way to tell a person what went wrong, one way to register."""

from __future__ import annotations

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


def register_classes(classes) -> None:
    for cls in classes:
        bpy.utils.register_class(cls)


def unregister_classes(classes) -> None:
    for cls in reversed(classes):
        bpy.utils.unregister_class(cls)


class Progress:
    """Of a modal operator: a timer that wakes it, Blender's bar, and a line in the status bar while it runs."""

    def __init__(self, context: bpy.types.Context, operator: bpy.types.Operator) -> None:
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(operator)
        context.window_manager.progress_begin(0.0, 1.0)

    def show(self, context: bpy.types.Context, what: str, fraction: float) -> None:
        context.window_manager.progress_update(fraction)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Enfilade: {what} {fraction:.0%}   Esc cancels")

    def end(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)


def redraw(context: bpy.types.Context) -> None:
    if context.screen is None:
        return
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
