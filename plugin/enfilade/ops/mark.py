# SPDX-License-Identifier: GPL-3.0-or-later
"""Mark selected objects as rooms, doors, windows ... (the custom property of plugin/README.md)."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ..rules.annotated import ROLES
from .common import registration

_ITEMS = tuple((role, role.capitalize(), "") for role in ROLES if role != "portal") + (("none", "No Mark", "Remove the mark"),)


class ENFILADE_OT_mark(bpy.types.Operator):
    """Say what the selected objects are: a room's air, a door, a window, a hole ..."""

    bl_idname = "enfilade.mark"
    bl_label = "Mark as"
    bl_options = {"REGISTER", "UNDO"}

    role: EnumProperty(name="Role", items=_ITEMS, default="room")

    @classmethod
    def poll(cls, context):
        if not context.selected_objects:
            cls.poll_message_set("Nothing is selected")
            return False
        return True

    def execute(self, context):
        count = 0
        for obj in context.selected_objects:
            if self.role == "none":
                if "enfilade" in obj:
                    del obj["enfilade"]
                    count += 1
                continue
            obj["enfilade"] = self.role
            count += 1
            if self.role in {"room", "exterior"}:
                obj.hide_render = True
                obj.display_type = "WIRE"
        self.report({"INFO"}, f"{count} objects marked; run Detect")
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_mark,)
register, unregister = registration(CLASSES)
