# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn, as triangles (csrc/include/enfilade/triangles.h).

Add meshes, commit, ask. Committed triangles may be read by any number of threads at once.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from ._signatures import TrianglesHandle
from .buffers import Flat, Rows
from .errors import InvalidArgumentError
from .handles import Owned, Owner
from .scene import _number_of

KINDS = ("diffuse", "mirror", "glass", "clear")
TRIANGLE_HIT = np.dtype(
    [("distance", np.float64), ("normal", np.float64, 3), ("triangle", np.uint32), ("object", np.uint32),
     ("material", np.uint32), ("reserved", np.uint32)]
)


@dataclass(frozen=True)
class Material:
    """What a surface does to light. colour, emission: linear RGB."""

    kind: str = "diffuse"  # KINDS; clear: alpha below one half, not there for any ray
    colour: tuple[float, float, float] = (0.7, 0.7, 0.7)
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ior: float = 1.45  # of glass

    def to_c(self) -> _structs.EnfMaterial:
        out = _structs.EnfMaterial()
        out.kind, out.ior = _number_of(self.kind, KINDS, "material"), self.ior
        out.colour[:], out.emission[:] = self.colour, self.emission
        return out


class Triangles(Owned):
    """Meshes in one tree. Context manager, or close()."""

    closed_message = "these triangles are closed"

    def __init__(self, origin: Any = (0.0, 0.0, 0.0)) -> None:
        """origin: (3,) metres, what coordinates are rounded about; the middle of the scene keeps the digits."""
        middle = Flat(origin, "origin", np.float64, 3)
        handle = TrianglesHandle()
        library().enf_triangles_create(middle.array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), ctypes.byref(handle))
        self._owner = Owner(handle, "enf_triangles_destroy")

    def add_material(self, material: Material) -> int:
        number = ctypes.c_uint32()
        library().enf_triangles_add_material(self.handle, ctypes.byref(material.to_c()), ctypes.byref(number))
        return int(number.value)

    def add_mesh(self, object_: int, vertices: Any, triangles: Any, materials: Any = None, normals: Any = None) -> None:
        """vertices: float64 (n, 3) world metres. triangles: (m, 3) vertex numbers. materials: (m,) from add_material, None:
        material 0, grey. normals: float32 (m, 3, 3) shading normals of the corners, None: flat."""
        rows = Rows(vertices, 3, "vertices")
        corners = Flat(triangles, "triangles", np.uint32)
        if corners.count % 3:
            raise InvalidArgumentError(f"triangles: {corners.count} vertex numbers, not three each")
        count = corners.count // 3
        kinds = None if materials is None else Flat(materials, "materials", np.uint32, count)
        shading = None if normals is None else Flat(normals, "normals", np.float32, 9 * count)
        library().enf_triangles_add_mesh(
            self.handle, object_, rows.address, rows.count, rows.stride, corners.address, count,
            kinds.address if kinds else None, shading.address if shading else None,
        )

    def commit(self) -> None:
        library().enf_triangles_commit(self.handle)

    @property
    def counts(self) -> dict[str, int]:
        """triangles, without_area (left out), bytes, materials."""
        c = library().enf_default_triangle_counts()
        library().enf_triangles_counts(self.handle, ctypes.byref(c))
        return {name: int(getattr(c, name)) for name in ("triangles", "without_area", "bytes", "materials")}

    def hit(self, origins: Any, directions: Any, max_distances: Any = None) -> np.ndarray:
        """The nearest triangles. origins, directions: float64 (n, 3). -> (n,) of dtype TRIANGLE_HIT."""
        origin, direction = Rows(origins, 3, "origins"), Rows(directions, 3, "directions")
        if origin.count != direction.count:
            raise InvalidArgumentError(f"{origin.count} origins and {direction.count} directions")
        starts, ways = np.ascontiguousarray(origin.array), np.ascontiguousarray(direction.array)
        limits = None if max_distances is None else Flat(max_distances, "max_distances", np.float64, origin.count)
        hits = np.zeros(origin.count, TRIANGLE_HIT)
        library().enf_triangles_hit(
            self.handle, starts.ctypes.data, ways.ctypes.data, limits.address if limits else None, origin.count,
            hits.ctypes.data_as(ctypes.POINTER(_structs.EnfTriangleHit)),
        )
        return hits
