# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a problem in the scene; copy what a bug report needs. Always registered, also without the core."""

from __future__ import annotations

import platform
import sys

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from .. import VERSION, native
from ..rules import ifc_library
from ..rules.names import sentence
from ..scene import collections, markers
from ..ui import error_log
from .common import redraw, registration


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


class ENFILADE_OT_copy_ifc_command(bpy.types.Operator):
    """Copy the command that installs IfcOpenShell for this Blender, to paste it into a terminal"""

    bl_idname = "enfilade.copy_ifc_command"
    bl_label = "Copy Command"

    def execute(self, context):
        context.window_manager.clipboard = ifc_library.install_command()
        self.report({"INFO"}, "Copied: paste it into a terminal, then Detect")
        return {"FINISHED"}


class ENFILADE_OT_show_problem(bpy.types.Operator):
    """Select the objects concerned and look at the place; of several alike, the next one each time"""

    bl_idname = "enfilade.show_problem"
    bl_label = "Show"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Problem", default=0, min=0)
    alike: BoolProperty(name="Others alike", description="The one after the one shown last, of those of this kind", default=False,
                        options={"SKIP_SAVE"})

    _last: dict[str, int] = {}  # kind -> the one shown last

    def execute(self, context):
        from .. import session

        found = session.get(context.scene)
        if found is None or self.index >= len(found.problems):
            self.report({"ERROR"}, "That problem is gone: detect again")
            return {"CANCELLED"}
        index, count = self.index, ""
        if self.alike:
            code = found.problems[index].code
            kind = [i for i, p in enumerate(found.problems) if p.code == code]
            index = next((i for i in kind if i > self._last.get(code, -1)), kind[0])
            self._last[code] = index
            count = f"{kind.index(index) + 1} of {len(kind)}: "
        problem = found.problems[index]
        chosen = self._objects(context, problem.names)
        marker = markers.at(context.scene, index)
        if context.mode == "OBJECT":
            for obj in context.view_layer.objects:
                obj.select_set(obj in chosen or obj == marker)
            if chosen or marker is not None:
                context.view_layer.objects.active = chosen[0] if chosen else marker
        if problem.position is not None:
            context.scene.cursor.location = problem.position
        self._frame(context, problem, chosen)
        message = sentence(problem.message).rstrip(".") + (f". {sentence(problem.remedy)}" if problem.remedy else "")
        self.report({"INFO"}, count + message)
        redraw(context)
        return {"FINISHED"}

    @staticmethod
    def _objects(context, names) -> list:
        """The objects that a problem is about: by name, by GlobalId, or by the name within an IFC object's name."""
        wanted = set(names)
        return [
            obj
            for obj in context.view_layer.objects
            if obj.visible_get() and wanted & {obj.name, obj.name_full, obj.get("enfilade_global_id", ""), obj.name.partition("/")[2]}
        ]

    @staticmethod
    def _frame(context, problem, chosen) -> None:
        """Brings the place into view, from as far as the objects concerned are large."""
        view = context.region_data
        if view is None:
            return
        if problem.position is not None:
            view.view_location = problem.position
        elif chosen:
            view.view_location = chosen[0].matrix_world.translation
        else:
            return
        if view.view_perspective == "CAMERA":  # what follows moves no camera
            view.view_perspective = "PERSP"
        size = max((max(obj.dimensions) for obj in chosen), default=2.0)
        view.view_distance = min(max(2.0 * size, 4.0), 40.0)


class ENFILADE_OT_mute_problem(bpy.types.Operator):
    """Mark problems of this kind in the 3D view, or don't"""

    bl_idname = "enfilade.mute_problem"
    bl_label = "Mark This Kind"
    bl_options = {"REGISTER", "UNDO"}

    code: StringProperty(name="Kind")

    def execute(self, context):
        settings = context.scene.enfilade
        settings.muted_problems = ";".join(sorted(settings.muted ^ {self.code}))
        return {"FINISHED"}


class ENFILADE_OT_mark_problems(bpy.types.Operator):
    """Put an empty at each problem, named after it, with what to do in its custom properties; again to remove them"""

    bl_idname = "enfilade.mark_problems"
    bl_label = "Markers"
    bl_options = {"REGISTER", "UNDO"}

    infos: BoolProperty(name="Notes too", description="Not only what should be mended", default=False)

    def execute(self, context):
        from .. import session

        scene = context.scene
        if collections.child(scene, collections.PROBLEMS) is not None:
            markers.remove(scene)
            return {"FINISHED"}
        found = session.get(scene)
        if found is None:
            self.report({"ERROR"}, "Detect first")
            return {"CANCELLED"}
        count = markers.draw(scene, found.problems, self.infos, scene.enfilade.muted)
        self.report({"INFO"}, f"{count} problems marked")
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_copy_diagnostics, ENFILADE_OT_copy_ifc_command, ENFILADE_OT_show_problem, ENFILADE_OT_mute_problem, ENFILADE_OT_mark_problems)
register, unregister = registration(CLASSES)
