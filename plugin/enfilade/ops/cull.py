# SPDX-License-Identifier: GPL-3.0-or-later
"""Culled view on and off, cull for one camera, visible from here, restore."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatVectorProperty, StringProperty

from .. import session
from ..analysis import Shot
from ..rules.building import Camera
from ..scene import apply_result, collections, cull, frame_table
from ..scene.cameras import view_camera
from ..scene.shots import shot_of
from .common import EXPECTED, failed, redraw, registration


class ENFILADE_OT_culled_view(bpy.types.Operator):
    """Show in the 3D view only what the active camera (or the view itself) sees, and follow it; again to switch off"""

    bl_idname = "enfilade.culled_view"
    bl_label = "Culled View"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        camera = context.scene.camera
        if context.scene.enfilade.follow == "camera" and (camera is None or camera.type != "CAMERA"):
            cls.poll_message_set("The scene has no active camera")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        found = session.get(scene)
        if found is not None and found.live is not None:
            count = session.stop_live(scene, found)
            self.report({"INFO"}, f"{count} objects shown again")
            redraw(context)
            return {"FINISHED"}
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        try:
            session.start_live(scene, found)
        except EXPECTED as error:
            session.stop_live(scene, found)
            return failed(self, error)
        if not found.live.looks:
            self.report({"INFO"}, "On, and waiting for a 3D view or a camera")
        else:
            look = found.live.looks[-1]
            self.report({"INFO"}, f"{look.kept} objects stay, {len(found.candidates) - look.kept} hidden")
        redraw(context)
        return {"FINISHED"}


class ENFILADE_OT_cull(bpy.types.Operator):
    """Hide what a camera doesn't need, as set under Hide from and Keep"""

    bl_idname = "enfilade.cull"
    bl_label = "Cull for Camera"
    bl_options = {"REGISTER", "UNDO"}

    camera: StringProperty(name="Camera", description="Empty: the active one", options={"SKIP_SAVE"})
    all_cameras: BoolProperty(name="All cameras", description="Keep what any camera needs", default=False)

    def execute(self, context):
        scene = context.scene
        if self.all_cameras:
            cameras = [o for o in scene.objects if o.type == "CAMERA"]
        else:
            named = scene.objects.get(self.camera) if self.camera else scene.camera
            cameras = [named] if named is not None and named.type == "CAMERA" else []
        if not cameras:
            self.report({"ERROR"}, f"No camera named {self.camera}" if self.camera else "The scene has no active camera")
            return {"CANCELLED"}
        settings = scene.enfilade
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        found.live = None
        apply_result.restore(scene)
        shots = [shot_of(scene, c) for c in cameras]
        found.analyser.occluders = "off" if found.occluder_moved() else settings.occluders
        result = cull.cull(found.analyser, shots, settings.method, settings.keep_text, cull.has_sky(scene))
        result.names |= found.moved
        found.views = result.views
        applied = cull.write(scene, found.building, result, settings.mode, {"cameras": [c.name for c in cameras]})
        session.touch()
        message = f"{applied.kept} objects stay, {applied.hidden} hidden"
        if applied.linked:
            message += f", {applied.linked} of a library can't be hidden"
        self.report({"INFO"}, message)
        for note in result.notes:
            self.report({"WARNING"}, note)
        redraw(context)
        return {"FINISHED"}


class ENFILADE_OT_visible_from_here(bpy.types.Operator):
    """List and select what can be seen from where the 3D view stands, whichever way it looks"""

    bl_idname = "enfilade.visible_from_here"
    bl_label = "Visible from Here"
    bl_options = {"REGISTER", "UNDO"}

    position: FloatVectorProperty(name="Position", description="Where the eye is, metres", subtype="XYZ", unit="LENGTH",
                                  size=3, options={"SKIP_SAVE"})
    room: BoolProperty(name="From anywhere in the room", description="From any point of the room where the eye is, not from the eye alone",
                       default=False)
    camera: BoolProperty(name="The camera's", description="From where the scene's camera is, not the 3D view", default=False)
    around: BoolProperty(name="All round", description="Whichever way one looks; off: as the 3D view looks", default=True)

    def invoke(self, context, event):
        if context.region_data is not None and not self.camera:
            self.position = np.linalg.inv(np.array(context.region_data.view_matrix))[:3, 3]
        return self.execute(context)

    def execute(self, context):
        scene = context.scene
        try:
            found = session.ensure(context)
        except EXPECTED as error:
            return failed(self, error)
        if self.camera and scene.camera is None:
            self.report({"ERROR"}, "The scene has no active camera")
            return {"CANCELLED"}
        if self.around or self.camera or self.room or context.region_data is None:
            matrix = np.eye(4)
            matrix[:3, 3] = scene.camera.matrix_world.translation if self.camera else self.position
            camera = Camera("Here", matrix, "PANO", 2.0 * np.pi, np.pi, clip=(1e-3, 1e6))
        else:
            camera = view_camera(scene, context.region_data, context.space_data)
        found.analyser.occluders = "off"
        shot = Shot("Here", scene.frame_current, [camera])
        if self.room:
            view = found.analyser.look_from_room(shot)
        else:
            view = found.analyser.look(shot, "portal")
        found.views = [view]
        names = {found.building.objects[o].source_id for o in view.objects}
        if context.mode == "OBJECT":
            for obj in context.view_layer.objects:
                obj.select_set(obj.name_full in names and obj.visible_get())
        session.touch()
        rooms = ", ".join(found.building.rooms[r].name for r in view.rooms) or "no room"
        self.report({"INFO"}, f"{len(names)} objects in {rooms}")
        redraw(context)
        return {"FINISHED"}


class ENFILADE_OT_restore(bpy.types.Operator):
    """Show again everything that Enfilade hid, exactly as it was, and remove its lists and frame table"""

    bl_idname = "enfilade.restore"
    bl_label = "Restore"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        scene = context.scene
        found = session.get(scene)
        if found is not None:
            found.live = None
        count = apply_result.restore(scene) + cull.unkey(scene)
        frame_table.remove(scene)
        collections.remove_lists(scene)
        session.touch()
        self.report({"INFO"}, f"{count} objects shown again")
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_culled_view, ENFILADE_OT_cull, ENFILADE_OT_visible_from_here, ENFILADE_OT_restore)
register, unregister = registration(CLASSES)
