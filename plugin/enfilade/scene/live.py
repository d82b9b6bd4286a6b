# SPDX-License-Identifier: GPL-3.0-or-later
"""The culled view while it follows a camera: what entered and what left since the last look, and nothing else is written.

Objects of Blender are held between two looks only to be spared finding them by name among tens of thousands; `forget_objects`
drops them whenever Blender may have replaced them (undo, reload), and one that has died in between is found anew.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

import bpy
import numpy as np

from ..analysis import EXACTLY, OCCLUDERS, VIEW_METHODS, Analyser, AnalysisError, Shot
from ..rules.building import Camera
from ..rules.results import View
from . import apply_result, cull

HISTORY = 250  # looks whose figures are kept


@dataclass
class Look:
    """One look of the live view, in figures."""

    frame: int
    kept: int  # objects of the file that stay
    entered: int  # of these, shown since the look before
    left: int  # hidden since the look before
    changed: int  # flags written
    query_us: float
    look_ms: float  # finding out
    write_ms: float  # writing flags; what Blender makes of them comes after


class Live:
    def __init__(self, analyser: Analyser, candidates: set[str]):
        self.analyser = analyser
        self.names = sorted(candidates)
        slots = {name: i for i, name in enumerate(self.names)}
        objects = analyser.building.objects
        # an object in the file may be several to the core: the instances of an instancer
        self._slot_of = np.array([slots[objects[int(b)].source_id] for b in analyser.made.building_objects], dtype=np.int64)
        self._slots = slots
        self._seen = np.zeros(len(self.names), dtype=np.int32)  # how many of them the camera sees
        for b in analyser.made.left_out:
            self._seen[slots[objects[b].source_id]] += 1
        self._blocking = {o.source_id for o in objects if o.occluder is not None}
        self._view = analyser.native.View(analyser.scene)
        self._shown: np.ndarray | None = None  # bool (names,): as last written; None: not known
        self._objects: list[bpy.types.Object | None] | None = None
        self._hidden = 0
        self.looks: deque[Look] = deque(maxlen=HISTORY)

    def forget_objects(self) -> None:
        """After undo or reload: what is written may differ from what we know."""
        self._objects = None
        self._shown = None

    # ---- what is seen ----

    def _query(self, shot: Shot | None, cameras: list[Camera], method: str, occluders: int):
        if shot is not None and shot.eye_radius > 0.0:
            eye = shot.camera.matrix_world[:3, 3]
            return self._view.query_region(np.stack([eye - shot.eye_radius, eye + shot.eye_radius]), look=shot.camera,
                                           method=method)
        if len(cameras) == 1:
            return self._view.query(cameras[0], method=method, occluders=occluders, outdoors=EXACTLY)
        return self._view.query_union(cameras[:16], method=method, occluders=occluders, outdoors=EXACTLY)

    def look(self, scene: bpy.types.Scene, shots: list[Shot], moved: set[str], begin: float) -> list[View]:
        """Looks through all the shots (cameras, or the 3D views themselves) and writes what changed. begin: when
        (perf_counter) we were called for it."""
        settings = scene.enfilade
        if settings.keep == "camera" and settings.method in VIEW_METHODS:
            views, wanted, microseconds = self._look_through(shots, settings, moved)
        else:  # light, or whole rooms: the sets are found anew
            result = cull.cull(self.analyser, shots, settings.method, settings.keep_text, cull.has_sky(scene))
            views, microseconds = result.views, sum(v.microseconds for v in result.views)
            wanted = np.zeros(len(self.names), dtype=bool)
            wanted[[self._slots[n] for n in result.names]] = True
        wanted[[self._slots[n] for n in moved if n in self._slots]] = True
        looked = time.perf_counter()
        before = self._shown
        changed = self._write(scene, wanted)
        done = time.perf_counter()
        entered = int((wanted & ~before).sum()) if before is not None else int(wanted.sum())
        left = int((before & ~wanted).sum()) if before is not None else 0
        self.looks.append(
            Look(scene.frame_current, int(wanted.sum()), entered, left, changed, microseconds, 1e3 * (looked - begin),
                 1e3 * (done - looked))
        )
        return views

    def _look_through(self, shots: list[Shot], settings, moved: set[str]) -> tuple[list[View], np.ndarray, float]:
        method = VIEW_METHODS[settings.method]
        single = shots[0] if len(shots) == 1 else None
        try:
            result = self._query(single, [c for s in shots for c in s.eyes or [s.camera]], method, self._occluders(settings.occluders, moved))
        except self.analyser.native.EnfError as error:
            self._seen[:] = 0
            raise AnalysisError(f"{shots[0].name}: {error}") from error
        np.add.at(self._seen, self._slot_of[result.objects_entered], 1)
        np.subtract.at(self._seen, self._slot_of[result.objects_left], 1)
        # the openings on the way are for reading: not for thousands
        view = self.analyser.as_view(shots[0], method, result, why=len(result.objects) < 1000)
        return [view], self._seen > 0, view.microseconds

    def _occluders(self, wanted: str, moved: set[str]) -> int:
        """Off once one of them isn't where it was detected."""
        return 0 if self._blocking & moved else OCCLUDERS.index(wanted)

    # ---- what is written ----

    def _write(self, scene: bpy.types.Scene, wanted: np.ndarray) -> int:
        if self._shown is None or apply_result.STATE_KEY not in scene:  # or restored, from another scene maybe
            keep = {self.names[i] for i in np.flatnonzero(wanted)}
            applied = apply_result.apply(scene, keep, self.names, apply_result.VIEWPORT, {"live": True})
            self._shown, self._hidden = wanted.copy(), applied.hidden
            return applied.changed
        different = np.flatnonzero(wanted != self._shown)
        if not len(different):
            return 0
        show = [o for o in map(self._object_of(scene), different[wanted[different]].tolist()) if o is not None]
        hide = [o for o in map(self._object_of(scene), different[~wanted[different]].tolist()) if o is not None]
        hidden, shown = apply_result.apply_difference(apply_result.VIEWPORT, hide, show)
        self._shown = wanted.copy()
        self._hidden += hidden - shown
        apply_result.note_state(scene, apply_result.VIEWPORT, self._hidden, {"live": True})
        return hidden + shown

    def _object_of(self, scene: bpy.types.Scene):
        if self._objects is None:
            by_name = {o.name_full: o for o in scene.objects}
            self._objects = [by_name.get(n) for n in self.names]

        def find(slot: int) -> bpy.types.Object | None:
            """None once it was deleted. Renamed it is the same, and if we hid it, it must come back."""
            obj = self._objects[slot]
            try:
                if obj is not None and obj.id_data is not None:
                    return obj
            except ReferenceError:  # deleted
                self._objects[slot] = next((o for o in scene.objects if o.name_full == self.names[slot]), None)
            return self._objects[slot]

        return find
