# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings kept in the scene, under the one name `Scene.enfilade`."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

VERSION = 1  # of what we store in files; see migrate.py


def _overlay_changed(self, context) -> None:
    from .ui import overlay

    overlay.sync(context)


class EnfiladeSettings(bpy.types.PropertyGroup):
    """Enfilade's settings of one scene"""

    version: IntProperty(name="Version", default=0, options={"HIDDEN"})
    source: EnumProperty(
        name="Source",
        description="Where rooms and openings come from",
        items=(
            ("auto", "Automatic", "An IFC file if one is named, else what is marked in the scene, else its bare geometry"),
            ("annotated", "Marked objects", 'Objects and collections with the custom property "enfilade", or named Room_..., Door_... '),
            ("ifc", "IFC file", "Spaces and openings of an IFC model"),
            ("geometry", "Geometry", "Rooms and openings found from walls, slabs, doors and windows, or from triangles alone"),
        ),
        default="auto",
    )
    ifc_path: StringProperty(name="IFC file", description="The IFC model this scene shows", subtype="FILE_PATH")
    method: EnumProperty(
        name="Method",
        description="How precisely the view through openings is followed",
        items=(
            ("portal", "Openings", "What the camera sees through doors and windows, clipped exactly"),
            ("box", "Openings, coarse", "The same with rectangles: faster, keeps a little more"),
            ("pluecker", "Whole room", "What is seen from anywhere in the camera's room: the camera may move about in it"),
            ("frustum", "View alone", "Whatever is in the camera's view, walls or not: for comparison"),
        ),
        default="portal",
    )
    keep: EnumProperty(
        name="Keep",
        description="What must stay besides what the camera sees",
        items=(
            ("camera", "What is seen", "Only what the camera sees"),
            ("shadow", "And shadows", "Also what may stand between it and a light"),
            ("bounces", "And bounced light", "Also what light may meet on its way, bounce by bounce"),
        ),
        default="camera",
    )
    bounces: IntProperty(name="Bounces", description="How often light may bounce on its way to what is seen",
                         default=2, min=0, max=32)
    mode: EnumProperty(
        name="Hide from",
        description="How objects are hidden",
        items=(
            ("safe", "Camera rays", "Hidden from the camera only: light, shadows and reflections stay (Cycles)"),
            ("render", "Renders", "Not rendered at all: saves time and memory; keep shadow casters or bounced light with it"),
            ("viewport", "3D view", "Hidden in the 3D view; renders are as before"),
        ),
        default="safe",
    )
    follow: EnumProperty(
        name="Follow",
        description="What the culled view follows",
        items=(
            ("camera", "Camera", "The scene's camera: look at the building from elsewhere, and see what the camera needs"),
            ("view", "3D views", "The 3D views themselves: what is hidden from where you look is gone. With several, what any of them sees"),
        ),
        default="camera",
    )
    occluders: EnumProperty(
        name="Occluders",
        description='Whether objects with the custom property "enfilade_occluder" hide what stands behind them',
        items=(
            ("off", "Off", "Only walls hide"),
            ("on", "On", "Always: finds what is hidden by furniture and facades, at some 0.1 ms a look"),
            ("auto", "Automatic", "Where many objects are in view and occluders cover a good part of it"),
        ),
        default="off",
    )
    report_dir: StringProperty(name="Report folder", description="Where the report is written", default="//enfilade_report",
                               subtype="DIR_PATH")
    time_limit: FloatProperty(name="Time limit", description="Seconds for the room matrix, 0 for none. What isn't decided by then "
                              "counts as seen", default=60.0, min=0.0, soft_max=3600.0, subtype="TIME_ABSOLUTE")
    show_overlay: BoolProperty(name="Show in 3D view", description="Draw rooms and openings over the 3D view", default=True,
                               update=_overlay_changed)
    show_rooms: BoolProperty(name="Rooms", description="Outline rooms: seen ones strong, others faint", default=True,
                             update=_overlay_changed)
    show_openings: BoolProperty(name="Openings", description="Fill openings: green open, blue glass, red closed", default=True,
                                update=_overlay_changed)
    show_sightlines: BoolProperty(name="Sightlines", description="Lines that prove which rooms see each other, once baked",
                                  default=False, update=_overlay_changed)
    show_problems: BoolProperty(name="Problems", description="Mark where problems were found", default=True,
                                update=_overlay_changed)

    muted_problems: StringProperty(name="Not shown", description="Kinds of problems that aren't marked in the 3D view", default="",
                                   update=_overlay_changed)

    @property
    def muted(self) -> set[str]:
        """Codes of problems that aren't marked."""
        return set(filter(None, self.muted_problems.split(";")))

    @property
    def keep_text(self) -> str:
        """As the commands spell it."""
        return f"bounces={self.bounces}" if self.keep == "bounces" else self.keep


CLASSES = (EnfiladeSettings,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.enfilade = PointerProperty(type=EnfiladeSettings)


def unregister() -> None:
    del bpy.types.Scene.enfilade
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
