# SPDX-License-Identifier: GPL-3.0-or-later
"""Detect: rooms, openings and objects of the scene."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, StringProperty

from .. import session
from .common import EXPECTED, failed, redraw, registration


class ENFILADE_OT_detect(bpy.types.Operator):
    """Find rooms, doors and windows in this scene. Whatever was hidden by Enfilade is shown again first"""

    bl_idname = "enfilade.detect"
    bl_label = "Detect"
    bl_options = {"REGISTER", "UNDO"}

    source: EnumProperty(
        name="Source",
        items=(("scene", "As set", ""), ("auto", "Automatic", ""), ("annotated", "Marked objects", ""), ("ifc", "IFC file", ""),
               ("geometry", "Geometry", "")),
        default="scene",
        options={"SKIP_SAVE"},
    )
    ifc: StringProperty(name="IFC file", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def execute(self, context):
        settings = context.scene.enfilade
        source = settings.source if self.source == "scene" else self.source
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)

        def progress(fraction: float, _label: str) -> bool:
            manager.progress_update(fraction)
            return True

        try:
            made = session.make(context, source, self.ifc or settings.ifc_path or None, progress)
        except EXPECTED as error:
            return failed(self, error)
        finally:
            manager.progress_end()
        rooms = sum(1 for r in made.building.rooms if r.kind == "interior")
        joined = sum(1 for o in made.building.openings if o.rooms is not None)
        trouble = sum(1 for p in made.problems if p.severity != "info")
        self.report(
            {"WARNING"} if trouble else {"INFO"},
            f"{rooms} rooms, {joined} openings, {len(made.candidates)} objects in {made.seconds:.2f} s"
            + (f"; {trouble} problems, see the panel" if trouble else ""),
        )
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_detect,)
register, unregister = registration(CLASSES)
