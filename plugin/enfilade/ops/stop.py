# SPDX-License-Identifier: GPL-3.0-or-later
"""Stop: what runs beside Blender, from the panel, as Esc does."""

from __future__ import annotations

import bpy

from .common import registration, running


class ENFILADE_OT_stop(bpy.types.Operator):
    """Stop what is at work. Esc does the same"""

    bl_idname = "enfilade.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return bool(running)

    def execute(self, context):
        for task in running:
            task.stop = True
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_stop,)
register, unregister = registration(CLASSES)
