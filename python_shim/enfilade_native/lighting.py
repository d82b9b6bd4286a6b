# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lights may reach which cell, and the light that arrives straight from them (csrc/include/enfilade/lighting.h)."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from ._signatures import LightSetsHandle
from .buffers import Rows, address_of
from .errors import InvalidArgumentError
from .handles import Owned, Owner
from .scene import NONE, Scene, _number_of

KINDS = ("POINT", "SPOT", "AREA", "SUN")
METHODS = ("beams", "region")


@dataclass(frozen=True)
class Light:
    """One light, in Blender's words. Lengths in metres, angles in radians."""

    kind: str = "POINT"
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)  # the way a spot, an area, a sun shines
    sides: tuple[tuple[float, float, float], tuple[float, float, float]] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # area: half its sides
    radius: float = 0.0  # point, spot: of the ball; sun: half its angular diameter
    spot_angle: float = math.pi / 4
    spot_blend: float = 0.0
    spread: float = math.pi  # area
    intensity: tuple[float, float, float] = (1.0, 1.0, 1.0)  # W/sr; area: W/(m2 sr); sun: W/m2
    reach: float = math.inf
    ellipse: bool = False
    cosine: bool = False  # spot: fainter off its axis, as Cycles had it before Blender 4.0

    def to_c(self) -> _structs.EnfLight:
        out = library().enf_default_light()
        out.kind = _number_of(self.kind, KINDS, "light kind")
        out.position[:], out.direction[:], out.intensity[:] = self.position, self.direction, self.intensity
        out.side[0][:], out.side[1][:] = self.sides
        out.radius, out.spot_angle, out.spot_blend, out.reach = self.radius, self.spot_angle, self.spot_blend, self.reach
        out.spread, out.ellipse, out.cosine = self.spread, int(self.ellipse), int(self.cosine)
        return out


def light_array(lights: Sequence[Light]) -> Any:
    """A ctypes array of EnfLight."""
    return (_structs.EnfLight * max(1, len(lights)))(*(light.to_c() for light in lights))


class LightSets(Owned):
    """Per cell the lights that may reach it, as doors stand now. Context manager, or close()."""

    closed_message = "these light sets are closed"

    def __init__(self, scene: Scene, lights: Sequence[Light], method: str = "beams", threads: int = 0) -> None:
        """method: "beams", or "region": for lights with a size also by the from-region engine (tighter, slower)."""
        handle = LightSetsHandle()
        array = light_array(lights)
        library().enf_light_sets_create(scene.handle, array, len(lights), _number_of(method, METHODS, "method"), threads,
                                        ctypes.byref(handle))
        self._owner = Owner(handle, "enf_light_sets_destroy")
        self.cell_count = int(scene.counts.cells)
        first = library().enf_light_sets_first(handle)
        self._first = np.frombuffer(ctypes.string_at(address_of(first), 8 * (self.cell_count + 1)), np.uint64)
        total = int(self._first[-1])
        found = library().enf_light_sets_lights(handle)
        self._lights = np.frombuffer(ctypes.string_at(address_of(found), 4 * total), np.uint32) if total else np.zeros(0, np.uint32)

    def of(self, cell: int) -> np.ndarray:
        """The lights of a cell, ascending."""
        if not 0 <= cell < self.cell_count:
            raise InvalidArgumentError(f"there is no cell {cell}")
        return self._lights[int(self._first[cell]) : int(self._first[cell + 1])]

    def cells_of(self, light: int) -> np.ndarray:
        """The cells a light may reach, ascending."""
        hits = np.nonzero(self._lights == light)[0]
        return np.searchsorted(self._first, hits, side="right").astype(np.int64) - 1

    @property
    def stats(self) -> dict[str, float]:
        c = library().enf_default_light_sets_stats()
        library().enf_light_sets_stats(self.handle, ctypes.byref(c))
        return {name: getattr(c, name) for name, _ in c._fields_ if name != "struct_size"}


@dataclass(frozen=True)
class DirectLight:
    irradiance: np.ndarray  # float32 (n, 3) W/m2
    lights: np.ndarray  # uint16 (n,) lights that reach the point
    shadow_rays: int
    lights_asked: int


def direct_light(lights: Sequence[Light], positions: Any, normals: Any, cells: Any = None, *, raycaster: Any = None,
                 triangles: Any = None, light_sets: LightSets | None = None, samples: int = 1, threads: int = 0) -> DirectLight:
    """Light that arrives straight at points. positions, normals: float64 (n, 3); cells: (n,) that hold them, None: found.
    Without light_sets every light is asked: the same figures, more shadow rays."""
    place, facing = Rows(positions, 3, "positions"), Rows(normals, 3, "normals")
    if place.count != facing.count:
        raise InvalidArgumentError(f"{place.count} positions and {facing.count} normals")
    points = np.zeros(place.count, np.dtype([("position", np.float64, 3), ("normal", np.float64, 3), ("cell", np.uint32), ("seed", np.uint32)]))
    points["position"], points["normal"] = place.array, facing.array
    points["cell"] = NONE if cells is None else np.asarray(cells, np.uint32)
    points["seed"] = np.arange(place.count, dtype=np.uint32)
    out = np.zeros((place.count, 3), np.float32)
    counts = np.zeros(place.count, np.uint16)
    c = library().enf_default_direct_light()
    array = light_array(lights)
    c.lights, c.light_count, c.samples, c.threads = array, len(lights), samples, threads
    c.raycaster = raycaster.handle if raycaster is not None else None
    c.triangles = triangles.handle if triangles is not None else None
    c.light_sets = light_sets.handle if light_sets is not None else None
    library().enf_direct_light(ctypes.byref(c), points.ctypes.data_as(ctypes.POINTER(_structs.EnfLitPoint)), place.count,
                               out.ctypes.data, counts.ctypes.data)
    return DirectLight(out, counts, int(c.shadow_rays), int(c.lights_asked))
