# SPDX-License-Identifier: GPL-3.0-or-later
"""Which products of an IFC model have curves in their shape.

The geometry library's exact kernel takes three times as long as its polyhedral one, and for shapes of flat faces both give the
same corners. Round ones differ by how many segments a circle gets: those are left to the exact kernel, as drawn meshes are.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

# Whatever isn't straight, and profiles that may have fillets. What isn't known here isn't a curve or is taken by its parts.
_ROUND = (
    "IfcConic", "IfcBoundedCurve", "IfcParameterizedProfileDef", "IfcSweptAreaSolid", "IfcSweptDiskSolid", "IfcElementarySurface",
    "IfcSweptSurface", "IfcBoundedSurface", "IfcCsgPrimitive3D", "IfcSectionedSolid", "IfcSectionedSpine",
)  # fmt: skip
_STRAIGHT = {
    "IfcPolyline", "IfcCompositeCurve", "IfcRectangleProfileDef", "IfcExtrudedAreaSolid", "IfcPlane", "IfcCurveBoundedPlane",
    "IfcRectangularTrimmedSurface", "IfcSurfaceOfLinearExtrusion", "IfcBlock", "IfcRectangularPyramid",
}  # fmt: skip
# The way up from a curve to the products that are made of it.
_CARRIERS = (
    "IfcRepresentationItem", "IfcProfileDef", "IfcRepresentation", "IfcRepresentationMap", "IfcProductRepresentation", "IfcProduct",
)  # fmt: skip

_known: WeakKeyDictionary[Any, set[int]] = WeakKeyDictionary()


def of(model: Any) -> set[int]:
    """STEP ids of the products with something round in a body (curves of plans and axes don't count)."""
    found = _known.get(model)
    if found is None:
        found = _known[model] = _find(model)
    return found


def _find(model: Any) -> set[int]:
    stack = []
    for name in _ROUND:
        try:
            stack += [e for e in model.by_type(name) if not _is_straight(e)]
        except RuntimeError:
            continue  # not of this schema
    seen = {e.id() for e in stack}
    products: set[int] = set()
    while stack:
        entity = stack.pop()
        if entity.is_a("IfcProduct"):
            products.add(entity.id())
            continue
        if entity.is_a("IfcRepresentation") and entity.RepresentationIdentifier in ("Axis", "FootPrint", "Annotation"):
            continue
        for user in model.get_inverse(entity):
            if user.id() not in seen and any(user.is_a(c) for c in _CARRIERS):
                seen.add(user.id())
                stack.append(user)
    return products


def _is_straight(entity: Any) -> bool:
    kind = entity.is_a()
    if kind == "IfcTrimmedCurve":
        return entity.BasisCurve.is_a("IfcLine")
    if kind == "IfcIndexedPolyCurve":
        return not any(s.is_a("IfcArcIndex") for s in entity.Segments or ())
    return kind in _STRAIGHT
