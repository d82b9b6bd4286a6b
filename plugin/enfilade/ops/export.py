# SPDX-License-Identifier: GPL-3.0-or-later
"""Export the scene for the command line tool; draw cells, portals and sightlines as objects."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from .. import session
from ..scene import collections
from .common import EXPECTED, failed, registration


class ENFILADE_OT_export_scene(bpy.types.Operator):
    """Write rooms, cells, portals and objects as *.enf.json: what makes a question reproducible without Blender"""

    bl_idname = "enfilade.export_scene"
    bl_label = "Export Scene (.enf.json)"
    bl_options = {"REGISTER"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.enf.json", options={"HIDDEN"})

    def invoke(self, context, event):
        if not self.filepath:
            self.filepath = bpy.path.ensure_ext(bpy.path.display_name(bpy.data.filepath or "scene"), ".enf.json")
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if not self.filepath:
            self.report({"ERROR"}, "No file named")
            return {"CANCELLED"}
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        try:
            found.analyser.scene.save(bpy.path.abspath(self.filepath))
        except found.analyser.native.EnfError as error:
            return failed(self, error)
        self.report({"INFO"}, f"Wrote {self.filepath}")
        return {"FINISHED"}


class ENFILADE_OT_draw_cells(bpy.types.Operator):
    """Add cells and portals as objects to the Enfilade collections (they never render); again to remove them"""

    bl_idname = "enfilade.draw_cells"
    bl_label = "Cells as Objects"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        scene = context.scene
        if collections.child(scene, collections.CELLS) is not None:
            collections.remove_cells(scene)
            return {"FINISHED"}
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        collections.draw_cells(
            scene, found.cells, found.building.rooms, [o.state for o in found.building.openings]
        )
        return {"FINISHED"}


class ENFILADE_OT_draw_sightlines(bpy.types.Operator):
    """Add a curve for each sightline between two rooms, with the outlines of the openings it passes; again to remove them"""

    bl_idname = "enfilade.draw_sightlines"
    bl_label = "Sightlines as Curves"
    bl_options = {"REGISTER", "UNDO"}

    room: StringProperty(name="Room", description="Only those from this room; empty: all", default="", options={"SKIP_SAVE"})
    toggle: BoolProperty(name="Toggle", description="Remove those that are there", default=False, options={"SKIP_SAVE"})

    def execute(self, context):
        scene = context.scene
        if collections.child(scene, collections.SIGHTLINES) is not None and (self.toggle or not self.room):
            collections.remove_child(scene, collections.SIGHTLINES)
            return {"FINISHED"}
        try:
            found = session.ensure(context)
            if found.matrix is None:
                found.matrix = found.analyser.room_matrix("exact", scene.enfilade.time_limit)
        except EXPECTED as error:
            return failed(self, error)
        names = [r.name for r in found.building.rooms]
        if self.room and self.room not in names:
            self.report({"ERROR"}, f"There is no room '{self.room}'; there are {', '.join(names)}")
            return {"CANCELLED"}
        wanted = [s for s in found.matrix.sightlines if not self.room or self.room in (names[s.rooms[0]], names[s.rooms[1]])]
        collections.draw_sightlines(scene, wanted, names, [o.name for o in found.building.openings], found.cells)
        session.touch()
        self.report({"INFO"}, f"{len(wanted)} sightlines drawn as curves")
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_export_scene, ENFILADE_OT_draw_cells, ENFILADE_OT_draw_sightlines)
register, unregister = registration(CLASSES)
