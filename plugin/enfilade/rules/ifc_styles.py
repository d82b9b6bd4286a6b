# SPDX-License-Identifier: GPL-3.0-or-later
"""How the surfaces of an IFC product are drawn: their styles' names, and whether any of them is seen through."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

SEEN_THROUGH = 0.05  # share of light from which on a surface counts as transparent; renderers write opaque as 0 or nearly
DEEPEST = 8  # maps and solids within each other that are followed


def styles_of(product: Any, materials: Iterable[Any]) -> list[Any]:
    """The surface styles of a product's shape and of its materials."""
    found = []
    shape = getattr(product, "Representation", None)
    for representation in getattr(shape, "Representations", None) or ():
        for item in _items(representation):
            for styled in getattr(item, "StyledByItem", None) or ():
                found += _surface_styles(styled)
    for material in materials:
        for definition in getattr(material, "HasRepresentation", None) or ():
            for representation in definition.Representations or ():
                for styled in representation.Items or ():
                    found += _surface_styles(styled)
    return found


def is_transparent(style: Any) -> bool:
    """Whether a surface style lets light through."""
    return any((getattr(s, "Transparency", None) or 0.0) > SEEN_THROUGH for s in style.Styles or ())


def _items(representation: Any) -> Iterator[Any]:
    """What a representation is drawn of, through maps and the solids that others are cut from."""
    pending = [(item, 0) for item in representation.Items or ()]
    while pending:
        item, depth = pending.pop()
        yield item
        if depth >= DEEPEST:
            continue
        if item.is_a("IfcMappedItem"):
            pending += [(i, depth + 1) for i in item.MappingSource.MappedRepresentation.Items or ()]
        elif item.is_a("IfcBooleanResult"):
            pending.append((item.FirstOperand, depth + 1))


def _surface_styles(styled: Any) -> list[Any]:
    if not styled.is_a("IfcStyledItem"):
        return []
    found = []
    for style in styled.Styles or ():
        found += style.Styles if style.is_a("IfcPresentationStyleAssignment") else [style]
    return [s for s in found if s is not None and hasattr(s, "is_a") and s.is_a("IfcSurfaceStyle")]
