# SPDX-License-Identifier: GPL-3.0-or-later
"""What an IFC model draws: walls, slabs, doors, windows, furniture, terrain; not spaces, voids, grids or notes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from . import ifc_shapes
from .building import Object

ALL, BUILT, REST = "all", "built", "rest"  # parts of what is drawn: everything; shell and fittings; furniture and all else
NOT_DRAWN = ("IfcFeatureElementSubtraction", "IfcVirtualElement", "IfcSpatialZone")
# Read in this order, so that what bounds the rooms is there first and furniture comes last.
_SHELL = ("IfcWall", "IfcSlab", "IfcRoof", "IfcCurtainWall", "IfcPlate", "IfcMember", "IfcColumn", "IfcBeam", "IfcCovering")
_FITTINGS = ("IfcDoor", "IfcWindow", "IfcStair", "IfcStairFlight", "IfcRamp", "IfcRampFlight", "IfcRailing")


def drawn(model: Any, part: str = ALL) -> list[Any]:
    """Products with a shape that is drawn: shell, then doors and stairs (these are BUILT), then all else (the REST)."""
    products = [e for e in model.by_type("IfcElement") if not any(_is(e, c) for c in NOT_DRAWN)]
    products += list(model.by_type("IfcSite"))
    products = [p for p in products if p.Representation is not None]

    def rank(product: Any) -> int:
        return 0 if any(_is(product, c) for c in _SHELL) else 1 if any(_is(product, c) for c in _FITTINGS) else 2

    ranked = [(rank(p), p) for p in products]
    chosen = [(r, p) for r, p in ranked if part == ALL or (part == REST) == (r == 2)]
    return [p for _, p in sorted(chosen, key=lambda item: (item[0], item[1].id()))]


def shapes(
    model: Any,
    offset: np.ndarray,
    *,
    cut: bool = True,
    materials: bool = False,
    progress: ifc_shapes.Progress | None = None,
    part: str = ALL,
) -> Iterator[ifc_shapes.Shape]:
    """The drawn meshes in the order of `drawn`, voids cut out; cut=False leaves walls whole (for bounds: as large or
    larger, and several times faster)."""
    products = drawn(model, part)
    made = ifc_shapes.make(
        model, products, cut=cut, offset=offset, materials=materials, progress=progress, label="drawn meshes",
        bounds=not cut and not materials,
    )
    for product in products:
        if product.id() in made:
            yield made[product.id()]


def object_of(shape: ifc_shapes.Shape) -> Object:
    """Name, bounds and identity of one drawn thing."""
    product = shape.product
    world = shape.world
    return Object(
        name=object_name(product),
        bounds=np.stack([world.min(axis=0), world.max(axis=0)]),
        source_id=product.GlobalId,
        mesh=shape.mesh,
    )


def object_name(product: Any) -> str:
    """As Bonsai names it: `IfcDoor/D01`, `IfcDoor/None` for a product without a name."""
    return f"{product.is_a()}/{product.Name}"


def _is(product: Any, name: str) -> bool:
    return bool(product.is_a(name))
