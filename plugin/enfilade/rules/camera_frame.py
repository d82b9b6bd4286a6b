# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Blender camera sees, from its settings: lens, sensor fit, shift, pixel aspect, orthographic scale.

The arithmetic of Blender's own view plane (source/blender/blenkernel/intern/camera.cc, camera_params_compute_viewplane),
put in our own words and checked against `Object.calc_matrix_camera` by tests/blender.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass
class Lens:
    """The settings that shape the picture. Lengths of lens and sensor in millimetres; the rest in metres."""

    type: str = "PERSP"
    lens: float = 50.0
    sensor_fit: str = "AUTO"  # AUTO, HORIZONTAL, VERTICAL
    sensor_width: float = 36.0
    sensor_height: float = 24.0
    shift_x: float = 0.0  # in units of the fitted side
    shift_y: float = 0.0
    ortho_scale: float = 6.0  # metres along the fitted side


@dataclass
class Raster:
    """The picture: pixels after the percentage, and the shape of a pixel."""

    width: int = 1920
    height: int = 1080
    aspect_x: float = 1.0
    aspect_y: float = 1.0


@dataclass
class Frame:
    angle_x: float  # radians; 0 for orthographic
    angle_y: float
    shift_x: float  # fraction of the picture's width, height
    shift_y: float
    ortho_width: float  # metres; 0 for perspective
    ortho_height: float


def frame_of(lens: Lens, raster: Raster) -> Frame:
    """The camera's field after sensor fit. A panoramic camera gets the whole sphere (safe for every panorama type)."""
    if lens.type == "PANO":
        return Frame(2.0 * math.pi, math.pi, 0.0, 0.0, 0.0, 0.0)
    width, height = max(1, raster.width), max(1, raster.height)
    ycor = raster.aspect_y / raster.aspect_x
    fit = lens.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if raster.aspect_x * width >= raster.aspect_y * height else "VERTICAL"
    # AUTO takes the sensor's width whichever way the picture lies; only an explicit VERTICAL takes its height
    sensor = lens.sensor_height if lens.sensor_fit == "VERTICAL" else lens.sensor_width
    fitted = float(width) if fit == "HORIZONTAL" else ycor * height
    shift_x = lens.shift_x * fitted / width
    shift_y = lens.shift_y * fitted / (ycor * height)
    if lens.type == "ORTHO":
        unit = lens.ortho_scale / fitted
        return Frame(0.0, 0.0, shift_x, shift_y, unit * width, unit * ycor * height)
    half = 0.5 * sensor / (max(lens.lens, 1e-6) * fitted)
    return Frame(
        2.0 * math.atan(half * width), 2.0 * math.atan(half * ycor * height), shift_x, shift_y, 0.0, 0.0
    )


def rigid(matrix: np.ndarray) -> tuple[np.ndarray, bool, bool]:
    """A camera's matrix without scale, as Blender and Cycles look through it: float64 (4, 4).

    Returns the matrix, whether x had to be mirrored (a camera under a negative scale shows the mirror image: the same
    volume with shift_x turned round), and whether the axes were sheared (then they were squared up; the caller reports).
    """
    out = np.array(matrix, dtype=np.float64)
    axes = out[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    axes = axes / np.where(lengths > 0.0, lengths, 1.0)
    mirrored = float(np.linalg.det(axes)) < 0.0
    if mirrored:
        axes[:, 0] = -axes[:, 0]
    sheared = float(np.abs(axes.T @ axes - np.eye(3)).max()) > 1e-5  # single-precision matrices are good to 1e-6
    back = axes[:, 2]
    up = axes[:, 1] - float(axes[:, 1] @ back) * back
    up /= np.linalg.norm(up)
    out[:3, :3] = np.stack([np.cross(up, back), up, back], axis=1)
    out[3] = (0.0, 0.0, 0.0, 1.0)
    return out, mirrored, sheared
