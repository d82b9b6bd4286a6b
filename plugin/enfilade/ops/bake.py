# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work: who sees whom between rooms, and the culling table of an animation. Progress, Esc cancels.

In a window the work runs beside Blender (the core's own threads; frames in small steps) and a timer polls it. Without one
the same operator runs to its end.
"""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty

from .. import session
from ..scene import apply_result, cull, frame_table, kept_rows, sweep
from .common import EXPECTED, Progress, failed, redraw, registration


class ENFILADE_OT_bake_rooms(bpy.types.Operator):
    """Find out which rooms see each other, from anywhere in them, with a sightline for each pair"""

    bl_idname = "enfilade.bake_rooms"
    bl_label = "Who Sees Whom"
    bl_options = {"REGISTER"}

    method: EnumProperty(
        name="Method",
        items=(("exact", "Exact", "Every pair proven or refuted"), ("flow", "Flow", "Faster, keeps a little more"),
               ("sample", "Sampled", "A lower bound: sightlines found by trying")),
        default="exact",
    )

    _job = None
    _progress = None

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._scene, self._found = context.scene, session.ensure(context)
            self._job = self._found.analyser.start_matrix(self.method, context.scene.enfilade.time_limit)
        except EXPECTED as error:
            return failed(self, error)
        self._progress = Progress(context, self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if not self._wanted():
            self._progress.end(context)
            self.cancel(context)
            return {"CANCELLED"}
        if event.type == "ESC":
            self._job.cancel()
            return {"RUNNING_MODAL"}  # meant for us: nothing else is to be left by it
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        state = self._job.progress
        self._progress.show(context, state.phase, state.fraction)
        if not state.done:
            return {"PASS_THROUGH"}
        self._progress.end(context)
        with self._job as job:
            try:
                # also after Esc: what is decided by then is kept, the rest counts as seen
                matrix = self._found.analyser.matrix_of(job.take(), self.method)
            except self._found.analyser.native.EnfError as error:
                return failed(self, error)
        return self._finish(context, self._scene, self._found, matrix)

    def cancel(self, context):
        """Another file is opened, Blender quits, or the scene was detected anew: the bake goes with it."""
        self._job.close()

    def _wanted(self) -> bool:
        try:
            return session.get(self._scene) is self._found
        except ReferenceError:  # the scene was deleted
            return False

    def execute(self, context):
        try:
            found = session.ensure(context)
            matrix = found.analyser.room_matrix(self.method, context.scene.enfilade.time_limit)
        except EXPECTED as error:
            return failed(self, error)
        return self._finish(context, context.scene, found, matrix)

    def _finish(self, context, scene, found, matrix):
        stats = matrix.statistics
        stopped, known = bool(stats.get("interrupted")), found.matrix
        if stopped and known is not None and known.method in ("exact", matrix.method) and not known.statistics.get("interrupted"):
            self.report({"INFO"}, "Stopped: what was known before stays")
            return {"CANCELLED"}
        found.matrix = matrix
        if matrix.method == "exact" and not stopped:
            rows = found.analyser.kept_rows()
            if rows is not None:
                kept_rows.store(scene, rows)
        rooms = len(found.building.rooms)
        message = f"{int(matrix.visible.sum())} of {rooms * rooms} room pairs see each other"
        if stats.get("pairs_kept"):
            message += f"; {int(stats['pairs_reopened'])} pairs of cells asked again, {int(stats['pairs_kept'])} kept"
        if stopped:
            message += f"; stopped early, {int(stats['undecided_pairs'])} pairs of cells undecided count as seen"
        self.report({"INFO"}, message)
        session.touch()
        redraw(context)
        return {"FINISHED"}


class ENFILADE_OT_bake_frames(bpy.types.Operator):
    """Work out for each frame what the camera needs, and apply it as frames are drawn or rendered"""

    bl_idname = "enfilade.bake_frames"
    bl_label = "Bake Animation"
    bl_options = {"REGISTER", "UNDO"}

    first: IntProperty(name="First", description="-1: the scene's", default=-1, options={"SKIP_SAVE"})
    last: IntProperty(name="Last", description="-1: the scene's", default=-1, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        if context.scene.camera is None:
            cls.poll_message_set("The scene has no active camera")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        settings = scene.enfilade
        first = scene.frame_start if self.first < 0 else self.first
        last = scene.frame_end if self.last < 0 else self.last
        if last < first:
            self.report({"ERROR"}, f"Frames {first} to {last} run backwards")
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        try:
            frame_table.remove(scene)
            found = session.make(context, settings.source, settings.ifc_path or None)
            shots = sweep.walk(scene, found.building, None, first, last,
                               lambda f, _: manager.progress_update(0.5 * f))
            # bounds have grown to where things go: the core needs them anew
            from ..analysis import Analyser

            found.analyser.close()
            found.analyser = Analyser(session.native.load(), found.building, settings.occluders)
            stay = {}
            sky = cull.has_sky(scene)
            for n, (frame, group) in enumerate(sorted(shots.items())):
                manager.progress_update(0.5 + 0.5 * n / len(shots))
                stay[frame] = cull.cull(found.analyser, group, settings.method, settings.keep_text, sky, why=False).names
        except EXPECTED as error:
            return failed(self, error)
        finally:
            manager.progress_end()
        table = cull.table(found.building, stay, settings.mode)
        frame_table.store(scene, table)
        frame_table.apply_frame(scene, scene.frame_current)
        session.touch()
        self.report({"INFO"}, f"{len(stay)} frames; {len(apply_result.hidden_objects())} objects hidden now")
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_bake_rooms, ENFILADE_OT_bake_frames)
register, unregister = registration(CLASSES)
