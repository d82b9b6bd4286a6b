# SPDX-License-Identifier: GPL-3.0-or-later
"""Preview: what the active camera sees, by the core's rays, as images in Blender.

In a window the rays run in a thread that touches no Blender data, and a timer looks after it; Esc stops it and keeps what there is.
Without one the same operator runs to its end.
"""

from __future__ import annotations

import threading

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, IntProperty

from .. import native, session
from ..commands import PREVIEW_PASSES
from ..scene import cameras
from ..scene.preview import Previewer
from .common import EXPECTED, Progress, failed, redraw, register_classes, unregister_classes

IMAGE = "Enfilade Preview"


class ENFILADE_OT_preview(bpy.types.Operator):
    """Draw what the active camera sees by rays through the rooms: shaded, rooms, objects, depth, openings looked through, lights"""

    bl_idname = "enfilade.preview"
    bl_label = "Preview"
    bl_options = {"REGISTER"}

    picture: EnumProperty(name="Picture", items=[("all", "All", "")] + [(p, p.capitalize(), "") for p in PREVIEW_PASSES], default="all")
    cells: BoolProperty(name="Rooms only", description="Draw the rooms' cells alone, no mesh of the scene", default=False)
    lit: BoolProperty(name="Lamps", description="With the scene's lamps; else soft light from all around", default=True)
    percentage: IntProperty(name="Size", description="Of the render's resolution", default=100, min=1, max=100, subtype="PERCENTAGE")

    _progress = None
    _thread = None

    @classmethod
    def poll(cls, context):
        if context.scene.camera is None or context.scene.camera.type != "CAMERA":
            cls.poll_message_set("The scene has no active camera")
            return False
        return True

    def _start(self, context) -> None:
        self._found = session.ensure(context)
        raster = cameras.raster_of(context.scene)
        size = [max(1, min(16384, v * self.percentage // 100)) for v in (raster.width, raster.height)]
        self._previewer = Previewer(native.load(), context.scene, self._found.building, cells_only=self.cells, lit=self.lit)
        try:
            self._run = self._previewer.prepare(context.scene.camera, *size)
        except Exception:
            self._previewer.close()
            raise

    def execute(self, context):
        try:
            self._start(context)
        except EXPECTED as error:
            return failed(self, error)
        try:
            made = self._run()
            return self._show(context, made)
        finally:
            self._previewer.close()

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._start(context)
        except EXPECTED as error:
            return failed(self, error)
        self._state = {"fraction": 0.0, "stop": False, "made": None, "error": None}
        state, run = self._state, self._run

        def progress(fraction: float) -> bool:
            state["fraction"] = fraction
            return not state["stop"]

        def work() -> None:
            try:
                state["made"] = run(progress)
            except Exception as error:
                state["error"] = error

        self._thread = threading.Thread(target=work, daemon=True)
        self._thread.start()
        self._progress = Progress(context, self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._state["stop"] = True
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        self._progress.show(context, "preview", self._state["fraction"])
        if self._thread.is_alive():
            return {"PASS_THROUGH"}
        self._progress.end(context)
        try:
            if self._state["error"] is not None:
                return failed(self, self._state["error"])
            return self._show(context, self._state["made"])
        finally:
            self._previewer.close()

    def _show(self, context, made):
        from ..report import preview_passes

        rooms = self._previewer.room_of(made.layers)
        names = [r.long_name or r.name for r in self._found.building.rooms]
        for name in PREVIEW_PASSES if self.picture == "all" else (self.picture,):
            drawn, _ = preview_passes.draw(name, made.layers, rooms, names, made.names)
            _to_image(f"{IMAGE} {name}", drawn)
        _open_image(context, f"{IMAGE} {'shaded' if self.picture == 'all' else self.picture}")
        for note in made.notes:
            self.report({"WARNING"}, note)
        seconds = sum(made.seconds.values())
        self.report({"INFO"}, f"{made.camera}: {made.counts.get('objects', 0)} objects in {seconds:.2f} s; images '{IMAGE} ...'")
        redraw(context)
        return {"FINISHED"}


def _to_image(name: str, pixels: np.ndarray) -> bpy.types.Image:
    """uint8 (h, w, 3), row 0 at the top, into an image of that name."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is None or image.source != "GENERATED":
        image = bpy.data.images.new(name, width, height)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    out = np.ones((height, width, 4), np.float32)
    out[..., :3] = pixels[::-1].astype(np.float32) / 255.0
    image.pixels.foreach_set(out.reshape(-1))
    image.update()
    return image


def _open_image(context, name: str) -> None:
    """In whichever image editor is open; none is opened for it."""
    image = bpy.data.images.get(name)
    for window in context.window_manager.windows if image is not None else ():
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return


CLASSES = (ENFILADE_OT_preview,)


def register() -> None:
    register_classes(CLASSES)


def unregister() -> None:
    unregister_classes(CLASSES)
