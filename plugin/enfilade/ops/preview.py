# SPDX-License-Identifier: GPL-3.0-or-later
"""Preview: what the active camera sees, by the core's rays, as images in Blender. Esc stops it and keeps what there is."""

from __future__ import annotations

import contextlib

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, IntProperty

from .. import native, session
from ..report.preview_passes import TITLES
from ..rules.names import Names
from ..scene import cameras
from ..scene.preview import MOST_SIDE, Previewer
from .common import Background, redraw, registration

IMAGE = "Enfilade Preview"


class ENFILADE_OT_preview(Background, bpy.types.Operator):
    """Draw what the active camera sees by rays through the rooms: shaded, rooms, objects, depth, openings looked through, lights"""

    bl_idname = "enfilade.preview"
    bl_label = "Preview"
    bl_options = {"REGISTER"}

    picture: EnumProperty(name="Picture", items=[("all", "All", "")] + [(p, p.capitalize(), "") for p in TITLES], default="all")
    cells: BoolProperty(name="Rooms only", description="Draw the rooms' cells alone, no mesh of the scene", default=False)
    lit: BoolProperty(name="Lamps", description="With the scene's lamps; else soft light from all around", default=True)
    percentage: IntProperty(name="Size", description="Of the render's resolution", default=100, min=1, max=100, subtype="PERCENTAGE")

    @classmethod
    def poll(cls, context):
        if context.scene.camera is None or context.scene.camera.type != "CAMERA":
            cls.poll_message_set("The scene has no active camera")
            return False
        return True

    def prepare(self, context):
        self._previewer = None
        self._found = session.ensure(context)
        raster = cameras.raster_of(context.scene)
        size = [max(1, min(MOST_SIDE, v * self.percentage // 100)) for v in (raster.width, raster.height)]
        self._previewer = Previewer(native.load(), context.scene, self._found.building, cells_only=self.cells, lit=self.lit)
        return self._previewer.prepare(context.scene.camera, *size)

    def close(self):
        if self._previewer is not None:
            self._previewer.close()
            self._previewer = None

    def finish(self, context, made):
        from ..report import preview_passes

        rooms = self._previewer.room_of(made.layers)
        names = Names(self._found.building).rooms()
        for name in TITLES if self.picture == "all" else (self.picture,):
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
    """In whichever image editor is open; where none is, as Blender opens one for a render (a window of its own unless set otherwise)."""
    image = bpy.data.images.get(name)
    if image is None or bpy.app.background:
        return
    if not _show_in_editor(context, image):
        with contextlib.suppress(RuntimeError):  # no window that could open another
            bpy.ops.render.view_show("INVOKE_DEFAULT")
        _show_in_editor(context, image)


def _show_in_editor(context, image: bpy.types.Image) -> bool:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return True
    return False


CLASSES = (ENFILADE_OT_preview,)
register, unregister = registration(CLASSES)
