# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras and frames to `analysis.Shot`: motion blur, depth of field and stereo are part of what a picture sees."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ..analysis import Shot, widened
from . import cameras

SHUTTER_POSES = 5


def shot_of(scene: bpy.types.Scene, obj: bpy.types.Object, frame: int | None = None) -> Shot:
    """The shot at a frame (default: now). Moves the scene's frame when asked for another or when the shutter needs it, and
    puts it back."""
    now = scene.frame_current, scene.frame_subframe
    target = now[0] if frame is None else frame
    try:
        if scene.render.use_motion_blur:
            times = target + np.linspace(*_shutter(scene), SHUTTER_POSES)
            return _shot_anywhere(scene, obj, target, [_poses(scene, obj, t) for t in times])
        if target != now[0] or now[1]:
            scene.frame_set(target)
        return shot_at_rest(scene, obj, bpy.context.evaluated_depsgraph_get())
    finally:
        if (scene.frame_current, scene.frame_subframe) != now:
            scene.frame_set(now[0], subframe=now[1])


def shot_at_rest(scene: bpy.types.Scene, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Shot:
    """This moment through a camera's lens: depth of field and stereo, no shutter."""
    views = cameras.cameras_of_views(scene, obj)
    poses = [cameras.read_camera(scene, o, depsgraph) for o in views]
    if any(o.data.dof.use_dof for o in views):
        return _shot_anywhere(scene, obj, scene.frame_current, [poses])
    pair = cameras.read_eyes(scene, obj, depsgraph) or (poses if len(poses) > 1 else [])
    if pair:
        return Shot(obj.name, scene.frame_current, poses[:1], eyes=pair)
    return _shot_anywhere(scene, obj, scene.frame_current, [poses])


def _shot_anywhere(scene: bpy.types.Scene, obj: bpy.types.Object, frame: int, poses: list[list]) -> Shot:
    """Poses by moment and view, with lenses that are more than points: eyes anywhere near them, when need be."""
    views = cameras.cameras_of_views(scene, obj)
    lenses = [_lens(scene, o) for o in views]
    radius = max(r for r, _ in lenses)
    if len(views) > 1:
        radius = max(radius, 1e-6)  # metres: several cameras and moments are asked as the box that holds them
    return Shot(obj.name, frame, [widened(p, slope) for moment in poses for p, (_, slope) in zip(moment, lenses, strict=True)], radius)


def _poses(scene: bpy.types.Scene, obj: bpy.types.Object, time: float) -> list:
    whole = math.floor(time)
    scene.frame_set(whole, subframe=time - whole)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return [cameras.read_camera(scene, o, depsgraph) for o in cameras.cameras_of_views(scene, obj)]


def _shutter(scene: bpy.types.Scene) -> tuple[float, float]:
    """When the shutter opens and closes, frames from the current one."""
    length = float(scene.render.motion_blur_shutter)
    where = getattr(getattr(scene, "cycles", None), "motion_blur_position", None) or getattr(
        scene.render, "motion_blur_position", "CENTER"
    )
    return {"START": (0.0, length), "END": (-length, 0.0)}.get(where, (-0.5 * length, 0.5 * length))


def _lens(scene: bpy.types.Scene, obj: bpy.types.Object) -> tuple[float, float]:
    """How far the eye may be from the camera (metres), and how much wider it looks (tangent)."""
    data = obj.data
    radius, slope = 0.0, 0.0
    if data.dof.use_dof:
        stop = max(float(data.dof.aperture_fstop), 1e-5)
        aperture = 1.0 / (2.0 * stop) if data.type == "ORTHO" else 1e-3 * float(data.lens) / (2.0 * stop)
        ratio = max(float(data.dof.aperture_ratio), 1e-5)
        aperture *= max(1.0, ratio, 1.0 / ratio)  # a squeezed lens: no smaller than its longer side
        focus = float(data.dof.focus_distance)
        if data.dof.focus_object is not None:
            matrix = np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64))
            point = np.array([*data.dof.focus_object.matrix_world.translation, 1.0])
            focus = abs(float((matrix @ point)[2]))
        radius, slope = aperture, aperture / max(focus, 1e-3)
    if cameras.is_stereo(scene):  # out of focus or in motion, or orthographic: eyes anywhere within reach of the camera
        half = float(data.stereo.interocular_distance) * (0.5 if data.stereo.pivot == "CENTER" else 1.0)
        away = max(float(data.stereo.convergence_distance), 1e-3)
        radius += half
        slope += 2.0 * half / away  # converging pairs turn by as much as they are shifted; twice covers both ways of doing it
    return radius, slope
