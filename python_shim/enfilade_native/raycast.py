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
from .buffers import Flat, Rows
from .errors import InvalidArgumentError
from .handles import Owned, Owner
from .scene import NONE, Camera, Scene
from .triangles import Triangles

RAY = np.dtype(
    [("origin", np.float64, 3), ("direction", np.float64, 3), ("max_distance", np.float64), ("cell", np.uint32),
     ("reserved", np.uint32)]
)
HIT = np.dtype(
    [("distance", np.float64), ("surface", np.uint32), ("cell", np.uint32), ("portals", np.uint32),
     ("openings", np.uint32)]
)


METHODS = {"auto": 0, "single": 1, "packets8": 2, "packets16": 3, "waves": 4}
IMAGE_METHODS = {"spans": 0, "tiles": 1, "packets": 2}


@dataclass(frozen=True)
class RayHits:
    """What n rays met. Arrays are the caller's own."""

    distance: np.ndarray  # float32 (n,) in units of the direction's length; inf: nothing nearer than max_distance
    surface: np.ndarray  # uint32 (n,) face of the scene, face count + portal of a closed leaf, then triangles; NONE: nothing
    cell: np.ndarray  # uint32 (n,) where the ray ended, i.e. where one that bounces off begins; NONE: the origin is in no cell
    portals: np.ndarray  # uint8 (n,) openings and seams passed, at most 255
    normal: np.ndarray  # float32 (n, 3) unit, towards the ray's side; 0, 0, 0 where nothing is hit
    uv: np.ndarray  # float32 (n, 2) metres on the surface: u is level, v climbs


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
    normal: np.ndarray | None = None  # float32 (height, width, 3) as RayHits.normal, when asked for
    uv: np.ndarray | None = None  # float32 (height, width, 2) as RayHits.uv, when asked for


class Raycaster(Owned):
    """The faces and portals of one committed scene, packed for rays. Context manager, or close()."""

    closed_message = "this raycaster is closed"

    def __init__(self, scene: Scene) -> None:
        handle = RaycasterHandle()
        library().enf_raycaster_create(scene.handle, ctypes.byref(handle))
        self._scene_owner = scene.owner
        self._owner = Owner(handle, "enf_raycaster_destroy", self._scene_owner)

    @property
    def face_count(self) -> int:
        return int(library().enf_raycaster_face_count(self.handle))

    @property
    def origin(self) -> np.ndarray:
        """float64 (3,) world metres: single precision coordinates of `closest` and `blocked` are rounded about this point."""
        out = np.zeros(3)
        library().enf_raycaster_origin(self.handle, out.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
        return out

    def furnish(self, triangles: Triangles | None) -> None:
        """From now on `closest`, `blocked` and `image` meet these committed triangles too; None: walls alone again."""
        library().enf_raycaster_furnish(self.handle, triangles.handle if triangles is not None else None)
        self.owner.keeps = (self._scene_owner, triangles.owner if triangles is not None else None)

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

    def _batch(self, origins: Any, directions: Any, max_distance: Any, cells: Any, target_cells: Any, coherent: bool,
               method: str, threads: int, furniture: bool) -> tuple[Any, list[np.ndarray], int]:
        """The C struct, the arrays it points to, and how many rays. Origins lose no digit far from the world's origin: they are
        made relative in double precision before they are rounded."""
        origin, direction = Rows(origins, 3, "origins"), Rows(directions, 3, "directions")
        if origin.count != direction.count:
            raise InvalidArgumentError(f"{origin.count} origins and {direction.count} directions")
        if method not in METHODS:
            raise InvalidArgumentError(f"method {method!r}: one of {', '.join(METHODS)}")
        batch, count = library().enf_default_ray_batch(), origin.count
        batch.count, batch.method, batch.coherent, batch.threads = count, METHODS[method], int(coherent), int(threads)
        batch.without_furniture = int(not furniture)
        near = (origin.array - self.origin).astype(np.float32)
        towards = direction.array.astype(np.float32)
        arrays = {f"{what}_{axis}": np.ascontiguousarray(source[:, i])
                  for what, source in (("origin", near), ("direction", towards)) for i, axis in enumerate("xyz")}
        if max_distance is not None:
            arrays["max_distance"] = np.ascontiguousarray(np.broadcast_to(np.asarray(max_distance, np.float32), (count,)))
        for name, value in (("cell", cells), ("target_cell", target_cells)):
            if value is not None:
                arrays[name] = Flat(np.broadcast_to(value, (count,)), f"{name}s", np.uint32, count).array
        for name, field in _structs.EnfRayBatch._fields_:
            if name in arrays:
                setattr(batch, name, arrays[name].ctypes.data_as(field))
        return batch, list(arrays.values()), count

    def closest(self, origins: Any, directions: Any, *, max_distance: Any = None, cells: Any = None, coherent: bool = False,
                method: str = "auto", threads: int = 0, furniture: bool = True) -> RayHits:
        """The nearest hit of each ray, many at once and in single precision: far faster than `shoot`.

        origins: (n, 3) world metres. directions: (n, 3), any length > 0; distances are in its units. max_distance: (n,) or a number,
        in the same units; None: any. cells: uint32 (n,) or a number, that hold the origins; None: found first (costs more than a
        short walk). coherent: rays next to each other go alike (pixels of a 4 x 4 block after each other). method: "auto", "single",
        "packets8", "packets16", "waves". threads: 0, one a core; the same bits for any number. furniture: False, walls alone."""
        batch, kept, count = self._batch(origins, directions, max_distance, cells, None, coherent, method, threads, furniture)
        arrays = {"distance": np.empty(count, np.float32), "surface": np.empty(count, np.uint32), "cell": np.empty(count, np.uint32),
                  "portals": np.empty(count, np.uint8), "normal": np.empty((count, 3), np.float32),
                  "uv": np.empty((count, 2), np.float32)}
        hits = library().enf_default_ray_hits()
        for name, field in _structs.EnfRayHits._fields_:
            if name in arrays:
                setattr(hits, name, arrays[name].ctypes.data_as(field))
        library().enf_raycast_closest(self.handle, ctypes.byref(batch), ctypes.byref(hits))
        del kept
        return RayHits(**arrays)

    def blocked(self, origins: Any, directions: Any, *, max_distance: Any = 1.0, cells: Any = None, target_cells: Any = None,
                coherent: bool = False, method: str = "auto", threads: int = 0, furniture: bool = True) -> np.ndarray:
        """Whether anything is met before max_distance, bool (n,); arguments as for `closest`. With directions that reach from points
        to a light the default 1 is the light's distance. target_cells: uint32 (n,) or a number, the cells that hold the rays' ends:
        a ray that reaches it is past all walls. Glass lets pass. Origins in no cell: False, the safe direction (lit)."""
        batch, kept, count = self._batch(origins, directions, max_distance, cells, target_cells, coherent, method, threads, furniture)
        out = np.zeros(count, np.uint8)
        library().enf_raycast_any(self.handle, ctypes.byref(batch), out.ctypes.data_as(ctypes.POINTER(ctypes.c_uint8)))
        del kept
        return out.astype(bool)

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

    def image(self, camera: Any, width: int, height: int, threads: int = 0, *, method: str = "spans", frames: bool = False,
              furniture: bool = True) -> RayImage:
        """What a perspective camera (a Camera, or anything with its attributes) sees of walls, floors and doors, and of the
        furniture. method: "spans", "tiles" or "packets", the same picture. frames: normal and uv of each pixel too."""
        c = library().enf_default_raycast_image()
        if not (0 < int(width) <= 16384 and 0 < int(height) <= 16384):
            raise InvalidArgumentError(f"a picture of {width} x {height} pixels: 1 to 16384 a side are possible")
        if method not in IMAGE_METHODS:
            raise InvalidArgumentError(f"method {method!r}: one of {', '.join(IMAGE_METHODS)}")
        c.width, c.height, c.threads = int(width), int(height), int(threads)
        c.method, c.without_furniture = IMAGE_METHODS[method], int(not furniture)
        shape = (c.height, c.width)
        arrays = {"depth": np.empty(shape, np.float32), "surface": np.empty(shape, np.uint32),
                  "cell": np.empty(shape, np.uint32), "portals": np.empty(shape, np.uint8)}
        if frames:
            arrays |= {"normal": np.empty((*shape, 3), np.float32), "uv": np.empty((*shape, 2), np.float32)}
        for name, field in _structs.EnfRaycastImage._fields_:
            if name in arrays:
                setattr(c, name, arrays[name].ctypes.data_as(field))
        library().enf_raycast_image(self.handle, ctypes.byref(Camera.of(camera).to_c()), ctypes.byref(c))
        return RayImage(**arrays, spans=int(c.spans), visits=int(c.visits), patched=int(c.patched))
