# SPDX-License-Identifier: GPL-3.0-or-later
"""Report: the HTML, JSON, CSV and pictures of who sees what."""

from __future__ import annotations

import os

import bpy
from bpy.props import BoolProperty, StringProperty

from .. import native, session, view_measures
from ..analysis import AnalysisError
from ..scene.cameras import scene_cameras
from ..scene.shots import shot_of
from .common import EXPECTED, failed, redraw, register_classes, unregister_classes


class ENFILADE_OT_report(bpy.types.Operator):
    """Write a report: what each camera sees and through which openings, which rooms see each other"""

    bl_idname = "enfilade.report"
    bl_label = "Report"
    bl_options = {"REGISTER"}

    directory: StringProperty(name="Folder", description="Empty: as set in the panel", subtype="DIR_PATH", options={"SKIP_SAVE"})
    matrix: BoolProperty(name="Who sees whom", description="With the room-to-room matrix", default=True)
    open_after: BoolProperty(name="Open", description="Open it in the browser", default=False)

    def execute(self, context):
        from ..report import write_report

        scene = context.scene
        folder = bpy.path.abspath(self.directory or scene.enfilade.report_dir)
        if folder.startswith("//"):
            self.report({"ERROR"}, "Save the file first, or choose a folder that isn't beside it")
            return {"CANCELLED"}
        try:
            found = session.ensure(context)
            views = [found.analyser.look(shot_of(scene, c), scene.enfilade.method) for c in scene_cameras(scene)]
            if self.matrix and found.matrix is None:
                try:
                    found.matrix = found.analyser.room_matrix("exact", scene.enfilade.time_limit)
                except AnalysisError as error:
                    self.report({"WARNING"}, f"No room matrix: {error}")
            analysis = found.analyser.analysis(views, found.matrix if self.matrix else None, scene.name)
            analysis.measures = view_measures.survey(native.load(), found.analyser, views)
            os.makedirs(folder, exist_ok=True)
            write_report(analysis, folder)
        except EXPECTED as error:
            return failed(self, error)
        page = os.path.join(folder, "report.html")
        self.report({"INFO"}, f"Report in {page}")
        if self.open_after and not bpy.app.background:
            bpy.ops.wm.path_open(filepath=page)
        session.touch()
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_report,)


def register() -> None:
    register_classes(CLASSES)


def unregister() -> None:
    unregister_classes(CLASSES)
