# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work: who sees whom between rooms, and the culling table of an animation. Beside Blender in a window; Esc stops it."""

from __future__ import annotations

import time

import bpy
from bpy.props import EnumProperty, IntProperty

from .. import native, session
from ..analysis import Analyser, AnalysisError
from ..scene import apply_result, cull, detect, frame_table, kept_rows, since_detect, sweep
from .common import Background, redraw, registration


class ENFILADE_OT_bake_rooms(Background, bpy.types.Operator):
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

    @classmethod
    def poll(cls, context):
        return cls.idle()

    def prepare(self, context):
        self._scene, self._found = context.scene.name, session.ensure(context)
        job = self._job = self._found.analyser.start_matrix(self.method, context.scene.enfilade.time_limit)

        def work(progress):
            while not (state := job.progress).done:
                if not progress(state.fraction, state.phase):
                    job.cancel()
                time.sleep(0.02)
            return job.take()  # also after Esc: what is decided by then is kept, the rest counts as seen

        return work

    def close(self):
        if self._job is not None:
            self._job.close()

    def wanted(self):
        scene = bpy.data.scenes.get(self._scene)
        return scene is not None and session.get(scene) is self._found

    def finish(self, context, taken):
        if not self.wanted():
            return {"CANCELLED"}  # detected anew, or deleted: the bake goes with it
        scene, found = bpy.data.scenes[self._scene], self._found
        matrix = found.analyser.matrix_of(taken, self.method)
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


class ENFILADE_OT_bake_frames(Background, bpy.types.Operator):
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
        return cls.idle()

    def prepare(self, context):
        scene, settings = context.scene, context.scene.enfilade
        first = scene.frame_start if self.first < 0 else self.first
        last = scene.frame_end if self.last < 0 else self.last
        if last < first:
            raise AnalysisError(f"Frames {first} to {last} run backwards")
        core = native.load()
        if session.get(scene) is None:
            session.make(context, settings.source, settings.ifc_path or None)
        self._scene, self._whole = scene.name, last - first + 1
        known = frame_table.load(scene)
        frame_table.remove(scene)  # it would hide, frame by frame, what is to be looked at
        try:
            with apply_result.all_shown(context.view_layer):
                self._building = building = detect.current(scene, context.view_layer)
                shots = yield from sweep.steps(scene, building, None, first, last)
        finally:
            if known is not None:
                frame_table.store(scene, known)
                frame_table.apply_frame(scene, scene.frame_current)
        method, keep, occluders, sky = settings.method, settings.keep_text, settings.occluders, cull.has_sky(scene)

        def work(progress):
            analyser = Analyser(core, building, occluders)  # of bounds that have grown to where things go
            stay = {}
            try:
                for n, (frame, group) in enumerate(sorted(shots.items())):
                    if not progress(n / len(shots), f"frame {frame}"):
                        break
                    stay[frame] = cull.cull(analyser, group, method, keep, sky, why=False).names
            finally:
                analyser.close()
            return stay

        return work

    def finish(self, context, stay):
        scene = bpy.data.scenes.get(self._scene)
        if not stay or scene is None:
            self.report({"INFO"}, "Stopped: all is as it was")
            return {"CANCELLED"}
        cull.unkey(scene)
        apply_result.restore(scene)
        frame_table.store(scene, cull.table(self._building, stay, scene.enfilade.mode))
        frame_table.apply_frame(scene, scene.frame_current)
        session.touch()
        message = f"{len(stay)} frames; {len(apply_result.hidden_objects())} objects hidden now"
        if len(stay) < self._whole:
            message = f"Stopped: {len(stay)} of {self._whole} frames, up to {max(stay)}; the others show everything"
        self.report({"INFO"}, message)
        for problem in self._building.problems:
            if problem.code == since_detect.CODE:
                self.report({"WARNING"}, f"{problem.message}. {problem.remedy}")
        redraw(context)
        return {"FINISHED"}


CLASSES = (ENFILADE_OT_bake_rooms, ENFILADE_OT_bake_frames)
register, unregister = registration(CLASSES)
