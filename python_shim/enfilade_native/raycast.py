# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and pictures through the cells (csrc/include/enfilade/raycast.h).

A Raycaster belongs to one committed scene; any number of threads may use it at once. ctypes frees the GIL meanwhile.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from ._signatures import RaycasterHandle
from .buffers import Rows
from .errors import InvalidArgumentError, StateError
from .scene import NONE, Camera, Scene

RAY = np.dtype(
    [("origin", np.float64, 3), ("direction", np.float64, 3), ("max_distance", np.float64), ("cell", np.uint32),
     ("reserved", np.uint32)]
)
HIT = np.dtype(
    [("distance", np.float64), ("surface", np.uint32), ("cell", np.uint32), ("portals", np.uint32),
     ("openings", np.uint32)]
)


@dataclass(frozen=True)
class RayImage:
    """A picture, row 0 at the top. Arrays are the caller's own."""

    depth: np.ndarray  # float32 (height, width) metres along the view axis, inf where nothing is hit
    surface: np.ndarray  # uint32 (height, width) face of the scene, or face count + portal of a closed leaf; NONE: nothing
    cell: np.ndarray  # uint32 (height, width) where the pixel's ray ended
    portals: np.ndarray  # uint8 (height, width) openings and seams looked through
    spans: int
    visits: int
    patched: int


class _RaycasterOwner:
    __slots__ = ("handle", "scene_owner")

    def __init__(self, handle: RaycasterHandle, scene_owner: object) -> None:
        self.handle, self.scene_owner = handle, scene_owner

    def __del__(self) -> None:
        handle, self.handle = self.handle, None
        if handle:
            library().enf_raycaster_destroy(handle)


class Raycaster:
    """The faces and portals of one committed scene, packed for rays. Context manager, or close()."""

    def __init__(self, scene: Scene) -> None:
        handle = RaycasterHandle()
        library().enf_raycaster_create(scene.handle, ctypes.byref(handle))
        self._owner: _RaycasterOwner | None = _RaycasterOwner(handle, scene.owner)

    @property
    def handle(self) -> RaycasterHandle:
        if self._owner is None:
            raise StateError("this raycaster is closed")
        return self._owner.handle

    @property
    def face_count(self) -> int:
        return int(library().enf_raycaster_face_count(self.handle))

    def close(self) -> None:
        self._owner = None

    def __enter__(self) -> Raycaster:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def shoot(self, origins: Any, directions: Any, max_distance: float = np.inf, cells: Any = None) -> np.ndarray:
        """Walks rays. origins, directions: float64 (n, 3), metres. cells: uint32 (n,) that hold the origins, or None.
        Gives a structured array (n,) of dtype HIT: distance in units of the direction's length, surface, cell, portals."""
        origin, direction = Rows(origins, 3, "origins"), Rows(directions, 3, "directions")
        if origin.count != direction.count:
            raise InvalidArgumentError(f"{origin.count} origins and {direction.count} directions")
        rays = np.zeros(origin.count, RAY)
        rays["origin"], rays["direction"], rays["max_distance"] = origin.array, direction.array, max_distance
        rays["cell"] = NONE if cells is None else np.asarray(cells, np.uint32)
        hits = np.zeros(origin.count, HIT)
        library().enf_raycast_rays(
            self.handle, rays.ctypes.data_as(ctypes.POINTER(_structs.EnfRay)), origin.count,
            hits.ctypes.data_as(ctypes.POINTER(_structs.EnfRayHit)),
        )
        return hits

    def normals(self, surfaces: Any) -> np.ndarray:
        """Unit normals of surfaces (uint32 (n,) as hits give them), float64 (n, 3): a face's into its cell; 0, 0, 0 for NONE."""
        numbers, where = np.unique(np.asarray(surfaces, np.uint32), return_inverse=True)
        found = np.zeros((len(numbers), 3))
        c = library().enf_default_surface()
        for i, number in enumerate(numbers.tolist()):
            if number != NONE:
                library().enf_raycaster_surface(self.handle, number, ctypes.byref(c))
                found[i] = c.normal[:]
        return found[where.reshape(-1)]

    def image(self, camera: Any, width: int, height: int, threads: int = 0) -> RayImage:
        """What a perspective camera (a Camera, or anything with its attributes) sees of walls, floors and doors."""
        c = library().enf_default_raycast_image()
        if not (0 < int(width) <= 16384 and 0 < int(height) <= 16384):
            raise InvalidArgumentError(f"a picture of {width} x {height} pixels: 1 to 16384 a side are possible")
        c.width, c.height, c.threads = int(width), int(height), int(threads)
        shape = (c.height, c.width)
        arrays = {"depth": np.empty(shape, np.float32), "surface": np.empty(shape, np.uint32),
                  "cell": np.empty(shape, np.uint32), "portals": np.empty(shape, np.uint8)}
        for name, field in _structs.EnfRaycastImage._fields_:
            if name in arrays:
                setattr(c, name, arrays[name].ctypes.data_as(field))
        library().enf_raycast_image(self.handle, ctypes.byref(Camera.of(camera).to_c()), ctypes.byref(c))
        return RayImage(**arrays, spans=int(c.spans), visits=int(c.visits), patched=int(c.patched))
