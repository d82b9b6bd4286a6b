# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Blender camera sees, from its settings: lens, sensor fit, shift, pixel aspect, orthographic scale.

The arithmetic of Blender's own view plane (source/blender/blenkernel/intern/camera.cc, camera_params_compute_viewplane),
put in our own words and checked against `Object.calc_matrix_camera` by tests/blender.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
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


def _dot(a, b) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def rigid(matrix: Iterable[Iterable[float]]) -> tuple[np.ndarray, bool, bool]:
    """A camera's matrix (rows of an array or of Blender's own) without scale, as Blender and Cycles look through it: float64 (4, 4).

    Returns the matrix, whether x had to be mirrored (a camera under a negative scale shows the mirror image: the same
    volume with shift_x turned round), and whether the axes were sheared (then they were squared up; the caller reports).
    """
    # In plain floats: called at every move of a followed camera, and numpy takes longer over three vectors than they do.
    rows = [list(map(float, row)) for row in matrix]
    axes = []
    for c in range(3):
        x, y, z = rows[0][c], rows[1][c], rows[2][c]
        length = math.sqrt(x * x + y * y + z * z) or 1.0
        axes.append((x / length, y / length, z / length))
    right, up, back = axes
    mirrored = _dot(_cross(right, up), back) < 0.0
    # single-precision matrices are good to 1e-6
    sheared = max(abs(_dot(right, up)), abs(_dot(up, back)), abs(_dot(back, right))) > 1e-5
    sheared = sheared or any(abs(_dot(a, a) - 1.0) > 1e-5 for a in axes)
    along = _dot(up, back)
    up = tuple(u - along * b for u, b in zip(up, back, strict=True))
    length = math.sqrt(_dot(up, up))
    up = tuple(u / length for u in up) if length > 0.0 else (math.nan,) * 3  # a flat matrix: the core says so
    right = _cross(up, back)
    out = np.array([[right[r], up[r], back[r], rows[r][3]] for r in range(3)] + [[0.0, 0.0, 0.0, 1.0]])
    return out, mirrored, sheared
