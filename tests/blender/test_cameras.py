# SPDX-License-Identifier: GPL-3.0-or-later
"""Our camera frame is Blender's: compared with the projection matrix that Blender itself computes."""

from __future__ import annotations

import itertools

import bpy
import numpy as np
import pytest
from enfilade.scene.cameras import read_camera, read_eyes
from kit import camera, empty_scene

SIZES = [(1920, 1080, 1.0, 1.0), (600, 900, 1.0, 1.0), (800, 800, 1.0, 2.0), (1920, 800, 1.5, 1.0)]


def window_of(c) -> np.ndarray:
    """left, right, bottom, top at distance 1 (perspective) or in metres (orthographic), from our fields."""
    if c.type == "ORTHO":
        half = np.array([c.ortho_width, c.ortho_height]) / 2
    else:
        half = np.tan([c.angle_x / 2, c.angle_y / 2])
    shift = 2.0 * half * np.array([c.shift_x, c.shift_y])
    return np.array([shift[0] - half[0], shift[0] + half[0], shift[1] - half[1], shift[1] + half[1]])


def window_of_blender(scene, obj, c) -> np.ndarray:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    r = scene.render
    m = np.array(
        obj.calc_matrix_camera(
            depsgraph, x=r.resolution_x, y=r.resolution_y, scale_x=r.pixel_aspect_x, scale_y=r.pixel_aspect_y
        ),
        dtype=np.float64,
    )
    corners = []
    for x, y in ((-1, -1), (1, 1)):
        if c.type == "ORTHO":
            corners.append(((x - m[0, 3]) / m[0, 0], (y - m[1, 3]) / m[1, 1]))
        else:
            corners.append(((x + m[0, 2]) / m[0, 0], (y + m[1, 2]) / m[1, 1]))
    (l, b), (r_, t) = corners
    return np.array([l, r_, b, t])


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("size", SIZES)
def test_lens_fit_shift_and_aspect(kind, size):
    scene = empty_scene()
    obj = camera("Eye", (1, 2, 3), (4, 5, 3.5))
    scene.render.resolution_x, scene.render.resolution_y = size[:2]
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = size[2:]
    scene.render.resolution_percentage = 100
    data = obj.data
    data.type = kind
    for fit, lens, shift in itertools.product(("AUTO", "HORIZONTAL", "VERTICAL"), (18.0, 85.0), ((0, 0), (0.3, -0.7))):
        data.sensor_fit, data.lens, data.ortho_scale = fit, lens, lens / 5
        data.sensor_width, data.sensor_height = 36.0, 20.0
        data.shift_x, data.shift_y = shift
        bpy.context.view_layer.update()
        ours = read_camera(scene, obj)
        assert window_of(ours) == pytest.approx(window_of_blender(scene, obj, ours), rel=1e-5, abs=1e-6), (fit, lens, shift)
        assert ours.clip == pytest.approx((data.clip_start, data.clip_end))


def test_a_panorama_looks_everywhere():
    scene = empty_scene()
    obj = camera("Eye", (0, 0, 0), (1, 0, 0))
    obj.data.type = "PANO"
    ours = read_camera(scene, obj)
    assert ours.type == "PANO" and ours.angle_x == pytest.approx(2 * np.pi)


def test_a_scaled_and_mirrored_camera_sees_the_mirrored_picture():
    scene = empty_scene()
    obj = camera("Eye", (1, 2, 3), (4, 5, 3.5))
    obj.data.shift_x = 0.25
    bpy.context.view_layer.update()
    plain = read_camera(scene, obj)
    obj.scale = (-3.0, 2.0, 0.5)
    bpy.context.view_layer.update()
    turned = read_camera(scene, obj)
    axes = turned.matrix_world[:3, :3]
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-9) and np.linalg.det(axes) == pytest.approx(1.0)
    assert turned.shift_x == pytest.approx(-plain.shift_x)
    assert np.allclose(turned.matrix_world[:3, 2], plain.matrix_world[:3, 2], atol=1e-6)


def test_an_animated_camera_is_read_from_the_depsgraph():
    scene = empty_scene()
    obj = camera("Eye", (0, 0, 0), (1, 0, 0))
    for frame in (1, 11):
        obj.location.x = float(frame)
        obj.keyframe_insert("location", frame=frame)
    scene.frame_set(6)
    ours = read_camera(scene, obj, bpy.context.evaluated_depsgraph_get())
    assert 1.0 < ours.matrix_world[0, 3] < 11.0


class _Eyes(bpy.types.RenderEngine):
    """Draws nothing; notes where Blender has each eye of the scene's camera stand, and its shift."""

    bl_idname, bl_label = "ENFILADE_EYES", "Eyes"
    seen: dict = {}

    def render(self, depsgraph):
        obj = depsgraph.scene.camera.evaluated_get(depsgraph)
        for name in ("left", "right"):
            self.active_view_set(name)
            _Eyes.seen[name] = np.array(self.camera_model_matrix(obj), dtype=np.float64), self.camera_shift_x(obj)


@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL", "TOE"])
def test_both_eyes_of_a_stereo_camera_stand_where_blender_has_them(mode):
    scene = empty_scene()
    obj = scene.camera = camera("Eye", (1, 2, 3), (4, 5, 3.5))
    obj.scale = (1.0, 2.0, 0.5)
    data, render = obj.data, scene.render
    assert read_eyes(scene, obj) == []
    render.use_multiview, render.views_format = True, "STEREO_3D"
    render.resolution_x, render.resolution_y, render.resolution_percentage = 16, 9, 100
    data.lens, data.sensor_width, data.sensor_height, data.shift_x = 35.0, 36.0, 20.0, 0.1
    data.stereo.convergence_mode, data.stereo.interocular_distance, data.stereo.convergence_distance = mode, 0.4, 2.0
    bpy.utils.register_class(_Eyes)
    try:
        render.engine = "ENFILADE_EYES"
        for pivot, fit in itertools.product(("LEFT", "RIGHT", "CENTER"), ("AUTO", "VERTICAL")):
            data.stereo.pivot, data.sensor_fit = pivot, fit
            bpy.ops.render.render()
            pair = read_eyes(scene, obj, bpy.context.evaluated_depsgraph_get())
            for name, eye in zip(("left", "right"), pair, strict=True):
                matrix, shift = _Eyes.seen[name]
                matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
                assert np.allclose(eye.matrix_world, matrix, atol=2e-6), (mode, pivot, name)
                kept, data.shift_x = data.shift_x, shift  # what a camera with this shift has for a frame
                assert eye.shift_x == pytest.approx(read_camera(scene, obj).shift_x, abs=1e-6), (mode, pivot, fit, name)
                data.shift_x = kept
    finally:
        render.engine = "BLENDER_WORKBENCH"
        bpy.utils.unregister_class(_Eyes)
