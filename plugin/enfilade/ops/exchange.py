# SPDX-License-Identifier: GPL-3.0-or-later
"""Write rooms back into IFC or as IndoorGML; bring cells and portals of another tool in as marked objects."""

from __future__ import annotations

import os

import bpy
from bpy.props import StringProperty

from .. import session
from ..scene import exchange
from .common import EXPECTED, failed, registration


class _Write:
    bl_options = {"REGISTER"}

    def invoke(self, context, event):
        if not self.filepath:
            self.filepath = bpy.path.display_name(bpy.data.filepath or "rooms") + self.ending
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if not self.filepath:
            self.report({"ERROR"}, "No file named")
            return {"CANCELLED"}
        try:
            self.report({"INFO"}, self.write(context, session.ensure(context).building))
        except (exchange.ExchangeError, *EXPECTED) as error:
            return failed(self, error)
        return {"FINISHED"}


class ENFILADE_OT_write_ifc(_Write, bpy.types.Operator):
    """Copy the IFC model with the rooms and space boundaries that it lacks. The model itself is never written to"""

    bl_idname = "enfilade.write_ifc"
    bl_label = "Rooms into IFC Copy"
    ending = " with rooms.ifc"

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.ifc", options={"HIDDEN"})

    def write(self, context, building) -> str:
        made = exchange.write_ifc(context.scene, building, self.filepath, context.scene.enfilade.ifc_path or None)
        return f"{made['spaces']} spaces and {made['boundaries']} boundaries added, {made['spaces_there']} spaces were there"


class ENFILADE_OT_write_indoorgml(_Write, bpy.types.Operator):
    """Write rooms and openings as IndoorGML: cells and transitions"""

    bl_idname = "enfilade.write_indoorgml"
    bl_label = "IndoorGML"
    ending = ".gml"

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.gml", options={"HIDDEN"})

    def write(self, context, building) -> str:
        cells, transitions = exchange.write_indoorgml(building, self.filepath)
        return f"{cells} cells and {transitions} transitions written"


class ENFILADE_OT_import_cells(bpy.types.Operator):
    """Bring cells and portals of a scene file (.enf.json) or IndoorGML in as marked rooms and openings"""

    bl_idname = "enfilade.import_cells"
    bl_label = "Import Cells"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.json;*.gml;*.xml", options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            building = exchange.read(self.filepath)
        except exchange.ExchangeError as error:
            return failed(self, error)
        made = exchange.add_marked(context.scene, building, os.path.basename(self.filepath))
        trouble = f"; {len(building.problems)} problems, the first: {building.problems[0].message}" if building.problems else ""
        self.report({"WARNING"} if trouble else {"INFO"}, f"{len(made)} marked objects; run Detect{trouble}")
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_write_ifc, ENFILADE_OT_write_indoorgml, ENFILADE_OT_import_cells)
register, unregister = registration(CLASSES)
