# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a door or window is open, closed or glass: from type, material and property sets, erring to open.

A door stands open unless the file says in so many words that it can't be opened and is opaque, or the user's overrides
close it. What is glass is seen through whatever else holds.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from . import ifc_styles
from .building import CLOSED, GLASS, OPEN

GLASS_WORDS = re.compile(
    r"glas|glaz|verre|vitr|vidr|cristal|vetr[oai]|szkło|szyba|szklan|skl[oeěí]n?|stakl|sticl|stikl|klaas|lasi|üveg"
    r"|стекл|скло|стъкл|υαλ|γυαλ|زجاج|kính|ガラス|玻璃|유리",
    re.IGNORECASE,
)


@dataclass
class DoorStates:
    """The user's say over what the file says. The most particular rule wins: opening, then storey, then class.

    Keys of `openings`: GlobalId or name. `storeys`: storey name. `classes`: IFC class ("IfcDoor") or kind ("door").
    `doors`: what a door without any rule is: OPEN; CLOSED closes those that aren't glass.
    """

    openings: Mapping[str, str] = field(default_factory=dict)
    storeys: Mapping[str, str] = field(default_factory=dict)
    classes: Mapping[str, str] = field(default_factory=dict)
    doors: str = OPEN

    @staticmethod
    def of(value: DoorStates | Mapping[str, str] | str | None) -> DoorStates:
        """From what a caller gives: nothing, "open" or "closed", or a mapping of openings to states."""
        if isinstance(value, DoorStates):
            return value
        if value is None:
            return DoorStates()
        if isinstance(value, str):
            _check(value)
            return DoorStates(doors=value)
        for state in value.values():
            _check(state)
        return DoorStates(openings=dict(value))

    def override(self, ids: list[str], storey: str, classes: list[str]) -> str | None:
        for key in ids:
            if key in self.openings:
                return self.openings[key]
        if storey in self.storeys:
            return self.storeys[storey]
        for name in classes:
            if name in self.classes:
                return self.classes[name]
        return None


def state_of(product: Any, kind: str, storey: str, rules: DoorStates) -> str:
    """The state of a door, window, panel or glazed wall."""
    said = rules.override(
        [x for x in (product.GlobalId, product.Name) if x], storey, [product.is_a(), *_bases(product), kind]
    )
    if said is not None:
        return said
    glazed = is_glazed(product)
    if kind != "door":
        return GLASS
    if glazed:
        return GLASS if rules.doors == CLOSED else OPEN
    if rules.doors != OPEN:
        return rules.doors
    return CLOSED if _is_fixed_and_opaque(product) else OPEN


def is_glazed(product: Any) -> bool:
    """Whether any material, style, name or property of the product speaks of glass, or it is drawn transparent."""
    if any(isinstance(v, (int, float)) and v > 0.0 for v in values(product, "GlazingAreaFraction")):
        return True
    materials = materials_of(product)
    styles = ifc_styles.styles_of(product, materials)
    kind = type_of(product)
    named = [product.Name, product.ObjectType, getattr(kind, "Name", None), *(t.Name for t in (*materials, *styles) if hasattr(t, "Name"))]
    return any(GLASS_WORDS.search(n) for n in named if n) or any(ifc_styles.is_transparent(s) for s in styles)


def is_glass_only(product: Any) -> bool:
    """Whether all the product's materials are glass: a wall or plate that is seen through as a whole."""
    return says_glass_only(material_names(product))


def says_glass_only(materials: Sequence[str]) -> bool:
    return bool(materials) and all(GLASS_WORDS.search(n) for n in materials)


def material_names(product: Any) -> list[str]:
    """Names of the materials of a product and of its type, and of what they are made of."""
    return [m.Name for m in materials_of(product) if getattr(m, "Name", None)]


def materials_of(product: Any) -> list[Any]:
    """The materials of a product and of its type, and what they are made of: layers, constituents."""
    found: list[Any] = []
    for thing in (product, type_of(product)):
        for relation in getattr(thing, "HasAssociations", None) or ():
            if relation.is_a("IfcRelAssociatesMaterial"):
                _materials(relation.RelatingMaterial, found, 0)
    return found


def values(product: Any, name: str) -> list[Any]:
    """What all property sets of a product and of its type say under a name: they may contradict each other."""
    properties = [p for s in _property_sets(product) for p in getattr(s, "HasProperties", None) or ()]
    singles = [p for p in properties if p.is_a("IfcPropertySingleValue")]
    return [p.NominalValue.wrappedValue for p in singles if p.Name == name and p.NominalValue is not None]


def _property_sets(product: Any) -> list[Any]:
    """Of a product and of its type."""
    relations = getattr(product, "IsDefinedBy", None) or ()
    own = [r.RelatingPropertyDefinition for r in relations if r.is_a("IfcRelDefinesByProperties")]
    return own + list(getattr(type_of(product), "HasPropertySets", None) or ())


def type_of(product: Any) -> Any:
    for inverse in ("IsTypedBy", "IsDefinedBy"):
        for relation in getattr(product, inverse, None) or ():
            if relation.is_a("IfcRelDefinesByType"):
                return relation.RelatingType
    return None


def _is_fixed_and_opaque(product: Any) -> bool:
    """Only when all that is said of it agrees: a door whose sets contradict each other stands open."""
    panels = [s for s in _property_sets(product) if s.is_a("IfcDoorPanelProperties")]
    if not panels or any(p.PanelOperation != "FIXEDPANEL" for p in panels):
        return False
    fractions = values(product, "GlazingAreaFraction")
    return bool(material_names(product)) and bool(fractions) and all(f == 0.0 for f in fractions)


def _materials(material: Any, found: list[Any], depth: int) -> None:
    if material is None or depth > 6:
        return
    found.append(material)
    if material.is_a("IfcMaterialList"):
        children = material.Materials
    elif material.is_a("IfcMaterialLayerSetUsage"):
        children = [material.ForLayerSet]
    elif material.is_a("IfcMaterialLayerSet"):
        children = material.MaterialLayers
    elif material.is_a("IfcMaterialConstituentSet"):
        children = material.MaterialConstituents or ()
    elif material.is_a("IfcMaterialProfileSet"):
        children = material.MaterialProfiles or ()
    elif hasattr(material, "Material"):
        children = [material.Material]
    else:
        children = ()
    for child in children:
        _materials(child, found, depth + 1)


def _bases(product: Any) -> list[str]:
    return [c for c in ("IfcDoor", "IfcWindow", "IfcCurtainWall", "IfcPlate", "IfcWall") if product.is_a(c)]


def _check(state: str) -> None:
    if state not in (OPEN, CLOSED, GLASS):
        raise ValueError(f"unknown opening state '{state}' (open, closed or glass)")
