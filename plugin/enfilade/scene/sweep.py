# SPDX-License-Identifier: GPL-3.0-or-later
"""One pass over a frame range: the shots of every frame, and objects' bounds grown to wherever they go meanwhile.

An object that moves is where it was and where it will be: its bounds over the whole range stand for it at each frame, which
keeps more than needed, never less.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator

import bpy
import numpy as np

from ..analysis import Shot
from ..rules.building import Building, Object
from . import extract_annotated, extract_mesh
from .shots import shot_of

Progress = Callable[[float, str], bool]


class Cancelled(RuntimeError):
    """The caller's progress function said stop."""


def walk(
    scene: bpy.types.Scene,
    building: Building,
    cameras: list[bpy.types.Object] | None,
    first: int,
    last: int,
    progress: Progress | None = None,
) -> dict[int, list[Shot]]:
    """Shots of each camera by frame: `steps`, all at once."""
    with contextlib.closing(steps(scene, building, cameras, first, last)) as walking:
        while True:
            try:
                fraction, text = next(walking)
            except StopIteration as end:
                return end.value
            if progress is not None and progress(fraction, text) is False:
                raise Cancelled("cancelled")


def steps(
    scene: bpy.types.Scene, building: Building, cameras: list[bpy.types.Object] | None, first: int, last: int
) -> Generator[tuple[float, str], None, dict[int, list[Shot]]]:
    """Yields how far it is, frame by frame, and returns the shots of each camera by frame; `building.objects` is grown in place. The
    scene's frame is put back.

    cameras None: the active one of each frame, which markers on the timeline may switch.
    """
    now = scene.frame_current, scene.frame_subframe
    marks = extract_annotated.find_marks(scene)
    known = {o.name: o for o in building.objects}
    by_source: dict[str, list[Object]] = {}
    for o in building.objects:
        by_source.setdefault(o.source_id, []).append(o)
    shots: dict[int, list[Shot]] = {}
    # With motion blur things also are where they were between frames: one frame more at either end covers the shutter.
    margin = 1 if scene.render.use_motion_blur else 0
    frames = range(first - margin, last + margin + 1)
    try:
        for n, frame in enumerate(frames):
            yield n / len(frames), "walking the frames"
            scene.frame_set(frame)
            depsgraph = bpy.context.evaluated_depsgraph_get()
            _grow(known, by_source, extract_mesh.extract(depsgraph, marks.ignored).objects, building)
            if first <= frame <= last:
                now_used = cameras if cameras is not None else [scene.camera] if scene.camera is not None else []
                shots[frame] = [shot_of(scene, camera, frame) for camera in now_used]
    finally:
        scene.frame_set(now[0], subframe=now[1])
    return shots


def _grow(known, by_source, objects: list[Object], building: Building) -> None:
    strange: set[str] = set()
    for obj in objects:
        mine = known.get(obj.name)
        if mine is None:
            strange.add(obj.source_id)
        elif not np.array_equal(mine.bounds, obj.bounds):
            mine.bounds = _union(mine.bounds, obj.bounds)
            mine.occluder = None  # it isn't always there
    for source in strange:
        # its instances are grouped otherwise at this frame (or it appeared only now): one box for all of it from here on
        boxes = [o.bounds for o in objects if o.source_id == source]
        mine = by_source.get(source)
        if mine is None:
            new = Object(source, boxes[0], source_id=source)
            building.objects.append(new)
            known[source] = new
            mine = by_source[source] = [new]
        for o in mine:
            for box in boxes:
                o.bounds = _union(o.bounds, box)
                o.occluder = None


def _union(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.stack([np.minimum(a[0], b[0]), np.maximum(a[1], b[1])])
