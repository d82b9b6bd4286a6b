# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a problem in the scene; copy what a bug report needs. Always registered, also without the core."""

from __future__ import annotations

import platform
import sys

import bpy
from bpy.props import IntProperty

from .. import VERSION, native
from ..ui import error_log
from .common import redraw, register_classes, unregister_classes


def diagnostics() -> str:
    usable, line = native.status()
    lines = [
        f"Enfilade {'.'.join(map(str, VERSION))}",
        f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}, {platform.platform()}",
        f"Core: {line}" if usable else f"Core is missing: {line}",
        f"Package: {__package__.rpartition('.')[0]}",
    ]
    for module in ("numpy", "OpenImageIO", "ifcopenshell"):
        found = sys.modules.get(module)
        version = getattr(found, "__version__", getattr(found, "VERSION_STRING", "loaded")) if found else "not loaded"
        lines.append(f"{module}: {version}")
    lines += [f"{e.where}: {e.message} (x{e.count})" for e in error_log.entries()]
    return "\n".join(lines)


class ENFILADE_OT_copy_diagnostics(bpy.types.Operator):
    """Copy versions, library path and recent errors to the clipboard, for a bug report"""

    bl_idname = "enfilade.copy_diagnostics"
    bl_label = "Copy Diagnostics"

    def execute(self, context):
        text = diagnostics()
        if bpy.app.background:
            print(text)
        else:
            context.window_manager.clipboard = text
        self.report({"INFO"}, "Copied")
        return {"FINISHED"}


class ENFILADE_OT_show_problem(bpy.types.Operator):
    """Select the objects concerned and look at the place"""

    bl_idname = "enfilade.show_problem"
    bl_label = "Show"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Problem", default=0, min=0)

    def execute(self, context):
        from .. import session

        found = session.get(context.scene)
        if found is None or self.index >= len(found.problems):
            self.report({"ERROR"}, "That problem is gone: detect again")
            return {"CANCELLED"}
        problem = found.problems[self.index]
        names = set(problem.names)
        if context.mode == "OBJECT":
            for obj in context.view_layer.objects:
                chosen = obj.name in names or obj.name_full in names
                if chosen and not obj.visible_get():
                    continue
                obj.select_set(chosen)
                if chosen:
                    context.view_layer.objects.active = obj
        if problem.position is not None:
            context.scene.cursor.location = problem.position
            if context.region_data is not None:
                context.region_data.view_location = problem.position
        message = problem.message + (f" {problem.remedy}" if problem.remedy else "")
        self.report({"INFO"}, message)
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_copy_diagnostics, ENFILADE_OT_show_problem)


def register() -> None:
    register_classes(CLASSES)


def unregister() -> None:
    unregister_classes(CLASSES)
