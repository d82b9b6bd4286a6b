# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender cameras to `rules.building.Camera`."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..rules.building import Building, Camera
from ..rules.camera_frame import Lens, Raster, frame_of, rigid
from ..rules.stereo import Stereo, eyes
from ..rules.viewpoints import suggest

NO_CAMERA = "no-camera"  # a problem's code


def raster_of(scene: bpy.types.Scene) -> Raster:
    """The picture a render of the scene makes. A border is ignored: the whole frame contains it."""
    r = scene.render
    return Raster(
        int(r.resolution_x * r.resolution_percentage / 100),
        int(r.resolution_y * r.resolution_percentage / 100),
        r.pixel_aspect_x,
        r.pixel_aspect_y,
    )


def read_camera(
    scene: bpy.types.Scene, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None
) -> Camera:
    """The camera as it is now, or as `depsgraph` evaluated it (the only truth during an animation render)."""
    evaluated = obj.evaluated_get(depsgraph) if depsgraph is not None else obj
    return _camera(scene, evaluated, evaluated.matrix_world, _lens(evaluated.data))


def read_eyes(scene: bpy.types.Scene, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> list[Camera]:
    """Left and right eye of a stereo camera; none where the scene isn't rendered in stereo, or an eye is more than a point."""
    evaluated = obj.evaluated_get(depsgraph) if depsgraph is not None else obj
    data = evaluated.data
    if not is_stereo(scene) or data.type == "ORTHO" or (data.type == "PANO" and data.stereo.use_spherical_stereo):
        return []
    settings = data.stereo
    stereo = Stereo(settings.convergence_mode, settings.pivot, settings.interocular_distance, settings.convergence_distance)
    matrix = np.array(evaluated.matrix_world, dtype=np.float64)
    return [_camera(scene, evaluated, m, lens) for m, lens in eyes(matrix, _lens(data), stereo)]


def cameras_of_views(scene: bpy.types.Scene, obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The cameras that a render through `obj` looks through: of each view its own, told by suffix, when the scene says so."""
    render = scene.render
    if not render.use_multiview or render.views_format != "MULTIVIEW":
        return [obj]
    suffixes = [v.camera_suffix for v in render.views if v.use]
    base = next((obj.name[: -len(s)] for s in suffixes if s and obj.name.endswith(s)), None)
    found = [] if base is None else [scene.objects.get(base + s) for s in suffixes]
    return [obj, *(o for o in found if o is not None and o != obj and o.type == "CAMERA")]


def is_stereo(scene: bpy.types.Scene) -> bool:
    return scene.render.use_multiview and scene.render.views_format == "STEREO_3D"


def _lens(data: bpy.types.Camera) -> Lens:
    return Lens(
        type=data.type,
        lens=data.lens,
        sensor_fit=data.sensor_fit,
        sensor_width=data.sensor_width,
        sensor_height=data.sensor_height,
        shift_x=data.shift_x,
        shift_y=data.shift_y,
        ortho_scale=data.ortho_scale,
    )


def _camera(scene: bpy.types.Scene, obj: bpy.types.Object, world: Matrix | np.ndarray, lens: Lens) -> Camera:
    data = obj.data
    frame = frame_of(lens, raster_of(scene))
    matrix, mirrored, _ = rigid(world)
    return Camera(
        name=obj.name_full,
        matrix_world=matrix,
        type=data.type if data.type in ("PERSP", "ORTHO", "PANO") else "PANO",
        angle_x=frame.angle_x,
        angle_y=frame.angle_y,
        shift_x=-frame.shift_x if mirrored else frame.shift_x,
        shift_y=frame.shift_y,
        ortho_width=frame.ortho_width,
        ortho_height=frame.ortho_height,
        clip=(float(data.clip_start), float(data.clip_end)),
    )


def scene_cameras(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """Every camera object of the scene, by name: the active one first."""
    cameras = sorted((o for o in scene.objects if o.type == "CAMERA"), key=lambda o: o.name_full)
    if scene.camera in cameras:
        cameras.remove(scene.camera)
        cameras.insert(0, scene.camera)
    return cameras


def add_suggested(scene: bpy.types.Scene, building: Building, count: int) -> list[bpy.types.Object]:
    """Cameras into the largest rooms, looking where most of it and its doors are seen; those that are there by name are left alone."""
    made = [_add(scene, name, matrix) for name, matrix in suggest(building, count) if name not in bpy.data.objects]
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    building.cameras = [read_camera(scene, o, depsgraph) for o in scene_cameras(scene)]
    building.problems = [p for p in building.problems if p.code != NO_CAMERA]
    return made


def _add(scene: bpy.types.Scene, name: str, matrix: np.ndarray) -> bpy.types.Object:
    data = bpy.data.cameras.new(name)
    data.lens = 20.0  # wide enough to show a room
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    obj.matrix_world = Matrix(matrix.tolist())
    if scene.camera is None:
        scene.camera = obj
    return obj


def view_camera(scene: bpy.types.Scene, region_3d, space) -> Camera:
    """The 3D view itself as a camera: what somebody who navigates freely sees. Read from its matrices, so that any lens
    and the view's own clipping are right."""
    window = np.array(region_3d.window_matrix, dtype=np.float64)
    world = np.linalg.inv(np.array(region_3d.view_matrix, dtype=np.float64))
    matrix, _, _ = rigid(world)
    clip = (float(space.clip_start), float(space.clip_end))
    if region_3d.is_perspective:
        return Camera(
            "View",
            matrix,
            "PERSP",
            angle_x=2.0 * float(np.arctan(1.0 / window[0, 0])),
            angle_y=2.0 * float(np.arctan(1.0 / window[1, 1])),
            shift_x=0.5 * float(window[0, 2]),
            shift_y=0.5 * float(window[1, 2]),
            clip=clip,
        )
    return Camera(
        "View",
        matrix,
        "ORTHO",
        ortho_width=2.0 / float(window[0, 0]),
        ortho_height=2.0 / float(window[1, 1]),
        shift_x=-0.5 * float(window[0, 3]),
        shift_y=-0.5 * float(window[1, 3]),
        clip=(-clip[1], clip[1]),
    )
