# SPDX-License-Identifier: GPL-3.0-or-later
"""Add cameras: some to begin with, in the largest rooms."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty

from .. import session
from ..scene import cameras
from .common import EXPECTED, failed, redraw, registration


class ENFILADE_OT_add_cameras(bpy.types.Operator):
    """Put cameras into the largest rooms, looking where most is seen"""

    bl_idname = "enfilade.add_cameras"
    bl_label = "Add Cameras"
    bl_options = {"REGISTER", "UNDO"}

    count: IntProperty(name="How many", default=3, min=1, max=100)

    def execute(self, context):
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        made = cameras.add_suggested(context.scene, found.building, self.count)
        found.problems[:] = [p for p in found.problems if p.code != cameras.NO_CAMERA]
        session.touch()
        self.report({"INFO"}, f"Added {', '.join(c.name for c in made)}" if made else "There are such cameras already")
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_add_cameras,)
register, unregister = registration(CLASSES)
