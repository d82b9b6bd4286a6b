# SPDX-License-Identifier: GPL-3.0-or-later
"""Detect: rooms, openings and objects of the scene. Beside Blender in a window; the scene changes at the end, in one undo step."""

from __future__ import annotations

import time

import bpy
from bpy.props import EnumProperty, StringProperty

from .. import native, session
from ..rules.building import INFO, INTERIOR
from ..scene import detect
from .common import EXPECTED, Background, failed, redraw, registration


class ENFILADE_OT_detect(Background, bpy.types.Operator):
    """Find rooms, doors and windows in this scene. Whatever was hidden by Enfilade is shown again. Esc stops it, and all stays as it was"""

    bl_idname = "enfilade.detect"
    bl_label = "Detect"
    bl_options = {"REGISTER", "UNDO"}

    source: EnumProperty(
        name="Source",
        items=(("scene", "As set", "As set in the panel"), ("auto", "Automatic", ""), ("annotated", "Marked objects", ""),
               ("ifc", "IFC file", ""), ("geometry", "Geometry", "")),
        default="scene",
        options={"SKIP_SAVE"},
    )
    ifc: StringProperty(name="IFC file", description="Empty: as set in the panel", subtype="FILE_PATH", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return cls.idle()

    def prepare(self, context):
        native.load()
        scene = context.scene
        settings = scene.enfilade
        source = settings.source if self.source == "scene" else self.source
        self._begin = time.perf_counter()
        # names, not the scene itself: an undo meanwhile replaces it
        self._scene, self._layer = scene.name, context.view_layer.name
        self._search = detect.Search(scene, context.view_layer, source, self.ifc or settings.ifc_path or None)

        def work(progress) -> bool:
            try:
                self._search.run(progress)
            except detect.STOPPED:
                return False
            return True

        return work

    def finish(self, context, whole):
        if not whole:
            self.report({"INFO"}, "Stopped: all is as it was")
            return {"CANCELLED"}
        scene = bpy.data.scenes.get(self._scene)
        layer = scene.view_layers.get(self._layer) if scene is not None else None
        if layer is None:
            self.report({"ERROR"}, f"Scene {self._scene} is gone: detect again")
            return {"CANCELLED"}
        try:
            made = session.take(scene, layer, self._search, self._begin)
        except EXPECTED as error:
            return failed(self, error)
        rooms = sum(1 for r in made.building.rooms if r.kind == INTERIOR)
        joined = sum(1 for o in made.building.openings if o.rooms is not None)
        trouble = sum(1 for p in made.problems if p.severity != INFO)
        self.report(
            {"WARNING"} if trouble else {"INFO"},
            f"{rooms} rooms, {joined} openings, {len(made.candidates)} objects in {made.seconds:.2f} s"
            + (f"; {trouble} problems, see the panel" if trouble else ""),
        )
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_detect,)
register, unregister = registration(CLASSES)
