# SPDX-License-Identifier: GPL-3.0-or-later
"""Check marked meshes and mend them: one offered fix, or all of some kinds. Every mending can be undone."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from .. import session
from ..rules import repair as rules
from ..scene import repair
from .common import redraw, registration

_KINDS = (
    ("snap", "Snap", "Join corners that lie close together without meeting"),
    ("fill", "Fill", "Close holes with faces"),
    ("flip", "Flip", "Turn faces outwards"),
    ("planarize", "Planarize", "Move corners into their faces' planes"),
    ("split", "Split", "Cut bent faces into triangles"),
)
_TOLERANCE = dict(name="Tolerance", description="How far a corner may be moved", default=rules.TOLERANCE, min=1e-4, max=0.5,
                  subtype="DISTANCE", precision=4)
offered: list[rules.Fix] = []  # of the last check: what the panel lists
mended_from = 0  # how many there were before the last mending


class ENFILADE_OT_check_marks(bpy.types.Operator):
    """Look over the meshes of marked rooms and openings, and list what can be mended"""

    bl_idname = "enfilade.check_marks"
    bl_label = "Check Marks"
    bl_options = {"REGISTER"}

    tolerance: FloatProperty(**_TOLERANCE)

    def execute(self, context):
        global mended_from
        offered[:] = repair.offers(context.scene, self.tolerance)
        mended_from = len(offered)
        self.report({"WARNING"} if offered else {"INFO"}, f"{len(offered)} meshes can be mended" if offered else "All marked meshes are sound")
        redraw(context)
        return {"FINISHED"}


class ENFILADE_OT_fix_marks(bpy.types.Operator):
    """Mend marked meshes: the one named, or all"""

    bl_idname = "enfilade.fix_marks"
    bl_label = "Mend"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Object", description="Which marked object; empty: all")
    kinds: EnumProperty(name="Kinds", items=_KINDS, options={"ENUM_FLAG"}, default={k[0] for k in _KINDS})
    tolerance: FloatProperty(**_TOLERANCE)

    def execute(self, context):
        global mended_from
        scene = context.scene
        before = repair.offers(scene, self.tolerance)
        mended_from = len(before)
        if self.name:
            fix = next((f for f in before if f.name == self.name and f.kind in self.kinds), None)
            if fix is None:
                self.report({"INFO"}, f"Nothing to mend in {self.name}")
                return {"CANCELLED"}
            reason = repair.apply(scene, fix)
            done, refused = ([], [(fix.name, reason)]) if reason else ([fix], [])
        else:
            done, refused = repair.apply_all(scene, set(self.kinds), self.tolerance)
        offered[:] = repair.offers(scene, self.tolerance)
        for name, reason in refused:
            self.report({"WARNING"}, f"{name} was left alone: {reason}")
        found = session.get(scene)
        if found is not None and done:
            found.stale = True
            session.touch()
        self.report({"INFO"}, f"{len(done)} fixes made, {len(offered)} to mend (was {mended_from})")
        redraw(context)
        return {"FINISHED"} if done else {"CANCELLED"}


CLASSES = (ENFILADE_OT_check_marks, ENFILADE_OT_fix_marks)
register, unregister = registration(CLASSES, offered.clear)
