# SPDX-License-Identifier: GPL-3.0-or-later
"""Open, close, glaze: states of openings by opening, storey or class, kept in the scene over every new Detect."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, StringProperty

from .. import session
from ..rules import opening_rules
from ..scene import detect
from ..ui import panel_data
from .common import redraw, registration


def active_opening(context) -> str:
    """The key of the opening that the active object is or marks; "" for none."""
    obj = context.active_object
    return panel_data.of(context.scene).opening_of.get(obj.name_full, "") if obj is not None else ""


class ENFILADE_OT_set_opening_state(bpy.types.Operator):
    """Say whether doors and windows are open, closed or glass: one, all of a storey, or all of a class"""

    bl_idname = "enfilade.set_opening_state"
    bl_label = "Set Opening State"
    bl_options = {"REGISTER", "UNDO"}

    scope: EnumProperty(
        name="Scope",
        items=(
            ("OPENING", "This opening", "The opening of the active object, or the one named"),
            ("STOREY", "Storey", "Doors, windows and holes of the storey named"),
            ("CLASS", "Class", "All doors, windows, holes or virtual openings"),
            ("DOORS", "All other doors", "Doors without a say of their own"),
        ),
        default="OPENING",
    )
    name: StringProperty(name="Name", description="Opening, storey or class; empty: the active object's opening")
    state: EnumProperty(
        name="State",
        items=(
            ("open", "Open", "Seen and walked through"),
            ("closed", "Closed", "Nothing is seen through it"),
            ("glass", "Glass", "Seen through, closed"),
            ("found", "As Found", "What the model says"),
        ),
        default="closed",
    )

    @classmethod
    def description(cls, context, properties):
        of = {"OPENING": properties.name or "the active door or window", "STOREY": f"all of {properties.name}",
              "CLASS": f"all {properties.name}s", "DOORS": "all other doors"}[properties.scope]
        return {"open": f"Let {of} stand open", "closed": f"Shut {of}: nothing is seen through", "glass": f"Shut {of}, seen through",
                "found": f"As found: {of} as the model says"}[properties.state]

    def execute(self, context):
        name = self.name or (active_opening(context) if self.scope == "OPENING" else "")
        if not name and self.scope != "DOORS":
            self.report({"ERROR"}, "Which one? Make a door's or window's object active, or name it")
            return {"CANCELLED"}
        key = {"OPENING": name, "STOREY": f"storey:{name}", "CLASS": f"class:{name}", "DOORS": "doors"}[self.scope]
        rules = detect.rules_of(context.scene)
        try:
            if self.state == "found":
                if rules.pop(key, None) is None:
                    self.report({"INFO"}, f"Nothing was said of {name or 'all doors'}")
                    return {"FINISHED"}
            else:
                rules.update(opening_rules.parse([f"{key}={self.state}"]))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        detect.set_rules(context.scene, rules)
        found = session.get(context.scene)
        if found is None:
            self.report({"INFO"}, "Noted for the next Detect")
            return {"FINISHED"}
        if self.state == "found" or self.scope == "DOORS":
            found.stale = True  # what was found is read anew
            session.touch()
            self.report({"INFO"}, "Detect again to apply it")
            return {"FINISHED"}
        before = [o.state for o in found.building.openings]
        changed = opening_rules.apply(found.building, rules)
        for i, (old, opening) in enumerate(zip(before, found.building.openings, strict=True)):
            if old != opening.state:
                found.analyser.set_state(i, opening.state)
        found.views, found.matrix, found.live_key = [], None, b""
        session.touch()
        self.report({"INFO"}, f"{changed} openings changed")
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_set_opening_state,)
register, unregister = registration(CLASSES)
