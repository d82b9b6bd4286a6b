# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangle meshes of IFC products, made by IfcOpenShell's geometry iterator on all cores.

Only the representations that bound space are made: `Box`, `FootPrint` and axes are left alone.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import ifc_library, ifc_rounds
from .ifc_placement import Frame, rounded

Progress = Callable[[float, str], bool]  # (fraction 0..1, what is being done) -> False cancels

# The geometry library's kernels. The quick one hands what it can't make to the exact one; only flat faces come out alike.
EXACT, QUICK = "opencascade", "hybrid-cgal-simple-opencascade"


class Cancelled(RuntimeError):
    """The user stopped a long operation."""


@dataclass
class Shape:
    """One product's mesh. Instances of one mapped item share `local` and `triangles` by `mesh`."""

    product: Any  # the IFC entity
    mesh: str  # equal for instances of one mesh
    local: np.ndarray  # float64 (n, 3), in the product's own coordinates, metres
    triangles: np.ndarray  # int32 (m, 3)
    matrix: np.ndarray  # float64 (4, 4), world from local; world = file's coordinates in metres less `offset`
    material_of: np.ndarray | None = None  # int32 (m,), index into `materials`, -1 = none
    materials: list[tuple[str, tuple[float, float, float], float]] = field(default_factory=list)  # name, rgb, alpha

    _world: np.ndarray | None = None

    @property
    def world(self) -> np.ndarray:
        """Vertices in world coordinates, float64 (n, 3)."""
        if self._world is None:
            self._world = self.local @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return self._world


def make(
    model: Any,
    products: Iterable[Any],
    *,
    cut: bool,
    offset: np.ndarray,
    materials: bool = False,
    progress: Progress | None = None,
    label: str = "",
    bounds: bool = False,
) -> dict[int, Shape]:
    """Meshes by STEP id of the products that have one, in the products' order; products without a shape are simply absent.

    cut: whether walls lose what their voids take away. offset: float64 (3,), taken off the world coordinates before they
    are multiplied out, so that national-grid coordinates lose no digits. bounds: only the corners' extents count, not how faces are
    cut into triangles nor which way they look: shapes of flat faces are made three times as fast.
    """
    wanted = [p for p in products if getattr(p, "Representation", None) is not None]
    shapes: dict[int, Shape] = {}
    if bounds:
        rounds = ifc_rounds.of(model)
        flat = [p for p in wanted if p.id() not in rounds]
        _run(model, flat, shapes, cut, offset, materials, progress, label, kernel=QUICK)
    exact = [p for p in wanted if p.id() not in shapes]
    _run(model, exact, shapes, cut, offset, materials, progress, label)
    # A void that isn't made must not be taken for none: the wall is drawn with its hole all the same.
    mended = [p for p in wanted if p.id() not in shapes and _unset_derived(p)]
    _run(model, mended, shapes, cut, offset, materials, progress, label)
    # The library's threads end in any order, and what is made of the shapes may go by theirs.
    return {p.id(): shapes[p.id()] for p in wanted if p.id() in shapes}


def _unset_derived(product: Any) -> bool:
    """Some tools write `*` (derived) for attributes without a value; the kernel then refuses the product. Whether there were any."""
    if "*" not in str(product):
        return False
    for i in range(len(product)):
        if product[i] is None:
            product[i] = None  # writes `$`
    return True


def _run(
    model: Any,
    wanted: list[Any],
    shapes: dict[int, Shape],
    cut: bool,
    offset: np.ndarray,
    materials: bool,
    progress: Progress | None,
    label: str,
    kernel: str = EXACT,
) -> None:
    """Adds the shapes of the wanted products that the kernel can make."""
    if not wanted:
        return
    ifc = ifc_library.load()
    settings = ifc.geom.settings()
    settings.set("disable-opening-subtractions", not cut)
    settings.set("weld-vertices", True)
    settings.set("apply-default-materials", False)
    # Circle segments: coarser circles are polygons inside the true circle; the difference is below what a model's
    # own tessellation differs by, and drawn meshes use the same segments.
    threads = max(1, min(os.cpu_count() or 1, 16))
    try:
        iterator = ifc.geom.iterator(settings, model, threads, include=wanted, geometry_library=kernel)
        if not iterator.initialize():
            return
    except RuntimeError:
        if kernel == EXACT:
            raise
        return  # a library built without the quick kernel
    cache: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray | None, list]] = {}
    done = 0
    while True:
        raw = iterator.get()
        geometry = raw.geometry
        key = str(geometry.id)
        if key not in cache:
            vertices = np.array(geometry.verts, dtype=np.float64).reshape(-1, 3)
            triangles = np.array(geometry.faces, dtype=np.int32).reshape(-1, 3)
            material_of, names = None, []
            if materials:
                material_of = np.array(geometry.material_ids, dtype=np.int32)
                names = [_material(m) for m in geometry.materials]
            cache[key] = (vertices, triangles, material_of, names)
        vertices, triangles, material_of, names = cache[key]
        matrix = np.array(raw.transformation.matrix, dtype=np.float64).reshape(4, 4).T.copy()
        matrix[:3, 3] -= offset
        if len(triangles) and np.isfinite(vertices).all():
            shapes[raw.id] = Shape(model.by_id(raw.id), key, vertices, triangles, matrix, material_of, names)
        done += 1
        if progress is not None and done % 16 == 0 and progress(done / len(wanted), label) is False:
            raise Cancelled(label)
        if not iterator.next():
            break


def in_frame(shapes: dict[int, Shape], frame: Frame) -> dict[int, Shape]:
    """The shapes, made about the frame's origin, in its axes, their corners rounded."""
    for shape in shapes.values():
        shape.matrix = frame.of_matrix(shape.matrix)
        shape._world = rounded(shape.local @ shape.matrix[:3, :3].T + shape.matrix[:3, 3])
    return shapes


def _material(material: Any) -> tuple[str, tuple[float, float, float], float]:
    colour = material.diffuse
    rgb = (float(colour.r()), float(colour.g()), float(colour.b())) if hasattr(colour, "r") else tuple(colour)
    transparency = getattr(material, "transparency", 0.0)
    alpha = 1.0 - transparency if transparency == transparency else 1.0  # NaN: not given
    return str(material.name), rgb, float(alpha)
