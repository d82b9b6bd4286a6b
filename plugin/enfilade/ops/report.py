# SPDX-License-Identifier: GPL-3.0-or-later
"""Report: the HTML, JSON, CSV and pictures of who sees what."""

from __future__ import annotations

import os

import bpy
from bpy.props import BoolProperty, StringProperty

from .. import native, session
from ..rules.names import sentence
from ..scene.cameras import scene_cameras
from ..scene.detect import counts_of
from ..scene.shots import shot_of
from .common import Background, redraw, registration


class ENFILADE_OT_report(Background, bpy.types.Operator):
    """Write a report: what each camera sees and through which openings, which rooms see each other. Esc stops it"""

    bl_idname = "enfilade.report"
    bl_label = "Report"
    bl_options = {"REGISTER"}

    directory: StringProperty(name="Folder", description="Empty: as set in the panel", subtype="DIR_PATH", options={"SKIP_SAVE"})
    matrix: BoolProperty(name="Who sees whom", description="With the room-to-room matrix", default=True)
    open_after: BoolProperty(name="Open", description="Open it in the browser", default=False)

    def prepare(self, context):
        from .. import reporting

        scene = context.scene
        folder = bpy.path.abspath(self.directory or scene.enfilade.report_dir)
        if folder.startswith("//"):
            raise OSError("Save the file first, or choose a folder that isn't beside it")
        self._folder, self._found = folder, session.ensure(context)
        building = self._found.building
        shots = [shot_of(scene, c) for c in scene_cameras(scene)]
        title = bpy.path.display_name_from_filepath(bpy.data.filepath) or scene.name
        wanted = reporting.Wanted(
            title=title,
            detected=counts_of(scene).sentence(),
            method=scene.enfilade.method,
            matrix="exact" if self.matrix else "none",
            known=self._found.matrix if self.matrix else None,
            time_limit=scene.enfilade.time_limit,
        )
        return lambda progress: reporting.make(native.load(), building, shots, folder, wanted, progress)

    def finish(self, context, made):
        if session.get(context.scene) is self._found and self.matrix and not made.stopped:
            self._found.matrix = made.matrix
        session.touch()
        redraw(context)
        for note in made.notes:
            self.report({"WARNING"}, sentence(note))
        if made.stopped:
            self.report({"WARNING"}, f"Stopped: the report in {self._folder} isn't whole")
            return {"CANCELLED"}
        page = os.path.join(self._folder, "report.html")
        self.report({"INFO"}, f"Report in {page}")
        if self.open_after and not bpy.app.background:
            bpy.ops.wm.path_open(filepath=page)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_report,)
register, unregister = registration(CLASSES)
