# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures without a renderer (csrc/include/enfilade/preview.h)."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from .errors import InvalidArgumentError
from .lighting import Light, LightSets, light_array
from .raycast import Raycaster
from .scene import Camera, _number_of
from .triangles import Triangles

PANORAMAS = ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL", "FISHEYE_LENS_POLYNOMIAL",
             "EQUIANGULAR_CUBEMAP_FACE", "CENTRAL_CYLINDRICAL")
ROWS_AT_ONCE = 64  # between two looks at progress


@dataclass(frozen=True)
class Panorama:
    """How a panoramic camera bends its picture. Angles in radians, lengths of lens and sensor in millimetres."""

    kind: str = "EQUIRECTANGULAR"
    longitude: tuple[float, float] = (-math.pi, math.pi)
    latitude: tuple[float, float] = (-math.pi / 2, math.pi / 2)  # of a cylinder: heights over its radius
    field: float = math.pi
    lens: float = 10.5
    sensor: tuple[float, float] = (36.0, 24.0)
    polynomial: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass
class Layers:
    """Layers of a picture, row 0 at the top. See EnfPreview for what each holds."""

    depth: np.ndarray  # float32 (h, w) metres, inf where nothing is
    object: np.ndarray  # uint32 (h, w)
    cell: np.ndarray  # uint32 (h, w)
    openings: np.ndarray  # uint8 (h, w)
    normal: np.ndarray  # float32 (h, w, 3)
    albedo: np.ndarray  # float32 (h, w, 3)
    direct: np.ndarray  # float32 (h, w, 3)
    surroundings: np.ndarray  # float32 (h, w, 3)
    open: np.ndarray  # float32 (h, w)
    lit: np.ndarray  # uint16 (h, w)
    coverage: np.ndarray  # float32 (h, w, 4, 2)
    rows: int  # rendered: fewer than h when it was cancelled
    counts: dict[str, int]


class Picture:
    """What to render: cells, triangles, lights. Keeps what it was given alive."""

    def __init__(self, raycaster: Raycaster | None = None, triangles: Triangles | None = None, lights: Sequence[Light] = (),
                 light_sets: LightSets | None = None, threads: int = 0, **options: Any) -> None:
        """options: numbers of EnfPreview by name (max_bounces, ambient_samples, ambient_reach, light_samples, edge_samples), and
        sky, ground, background as colours."""
        self._parts = (raycaster, triangles, light_sets)
        self._lights = light_array(lights)
        c = self._c = library().enf_default_preview()
        c.raycaster = raycaster.handle if raycaster is not None else None
        c.triangles = triangles.handle if triangles is not None else None
        c.lights, c.light_count = self._lights, len(lights)
        c.light_sets = light_sets.handle if light_sets is not None else None
        c.threads = threads
        for name, value in options.items():
            if name in ("sky", "ground"):
                getattr(c, name)[:] = value
            elif name == "background":
                c.background[0][:], c.background[1][:] = value
            elif name in ("max_bounces", "ambient_samples", "ambient_reach", "light_samples", "edge_samples"):
                setattr(c, name, value)
            else:
                raise InvalidArgumentError(f"no preview option '{name}'")

    def render(self, camera: Any, width: int, height: int, panorama: Panorama | None = None, smooth: bool = True,
               edges: bool = True, progress: Callable[[float], Any] | None = None) -> Layers:
        """All layers of one camera. progress(fraction) may return False: then what is rendered stays, and `rows` tells how much."""
        if not (0 < int(width) <= 16384 and 0 < int(height) <= 16384):
            raise InvalidArgumentError(f"a picture of {width} x {height} pixels: 1 to 16384 a side are possible")
        c = _structs.EnfPreview.from_buffer_copy(self._c)
        c.width, c.height = int(width), int(height)
        if panorama is not None:
            c.panorama.kind = _number_of(panorama.kind, PANORAMAS, "panorama")
            c.panorama.longitude[:], c.panorama.latitude[:] = panorama.longitude, panorama.latitude
            c.panorama.field, c.panorama.lens = panorama.field, panorama.lens
            c.panorama.sensor_width, c.panorama.sensor_height = panorama.sensor
            c.panorama.polynomial[:] = panorama.polynomial
        shape = (c.height, c.width)
        arrays = {
            "depth": np.full(shape, np.inf, np.float32), "object": np.full(shape, 0xFFFFFFFF, np.uint32),
            "cell": np.full(shape, 0xFFFFFFFF, np.uint32), "openings": np.zeros(shape, np.uint8),
            "normal": np.zeros((*shape, 3), np.float32), "albedo": np.zeros((*shape, 3), np.float32),
            "direct": np.zeros((*shape, 3), np.float32), "surroundings": np.zeros((*shape, 3), np.float32),
            "open": np.ones(shape, np.float32), "lit": np.zeros(shape, np.uint16),
            "coverage": np.zeros((*shape, 4, 2), np.float32),
        }
        for name, field in _structs.EnfPreview._fields_:
            if name in arrays:
                setattr(c, name, arrays[name].ctypes.data_as(field))
        eye = Camera.of(camera).to_c()
        done = 0
        passes = [library().enf_preview] + ([library().enf_preview_edges] if edges else [])
        for k, call in enumerate(passes):
            for row in range(0, c.height, ROWS_AT_ONCE):
                c.row_first, c.row_count = row, min(ROWS_AT_ONCE, c.height - row)
                call(ctypes.byref(c), ctypes.byref(eye))
                done = done if k else row + c.row_count
                if progress is not None and progress((k + (row + c.row_count) / c.height) / len(passes)) is False:
                    return self._layers(c, arrays, done)
            if k == 0 and smooth and c.ambient_samples:
                library().enf_preview_smooth(arrays["open"].ctypes.data, arrays["depth"].ctypes.data, arrays["normal"].ctypes.data,
                                             c.width, c.height, c.threads)
        return self._layers(c, arrays, done)

    @staticmethod
    def _layers(c: _structs.EnfPreview, arrays: dict[str, np.ndarray], rows: int) -> Layers:
        names = ("rays", "bounce_rays", "ambient_rays", "shadow_rays", "lights_asked", "edge_pixels")
        return Layers(**arrays, rows=rows, counts={n: int(getattr(c, n)) for n in names})
