# SPDX-License-Identifier: GPL-3.0-or-later
"""An IFC model as elements for the search by geometry: walls whole, voids and loose doors as known passages; its spaces are never read."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import ifc_elements, ifc_glazing, ifc_openings, ifc_passages, ifc_shapes, ifc_states
from .building import DOOR, HOLE, WINDOW
from .geometry_elements import FURNITURE, SHELL, SITE, STAIR, Element
from .ifc_placement import storey_of, storeys
from .ifc_units import length_unit
from .probing import Passage

_KINDS = (
    ("IfcSite", SITE), ("IfcDoor", DOOR), ("IfcWindow", WINDOW), ("IfcStair", STAIR), ("IfcStairFlight", STAIR),
    ("IfcRamp", STAIR), ("IfcRampFlight", STAIR), ("IfcRailing", STAIR), ("IfcTransportElement", STAIR),
    ("IfcFurnishingElement", FURNITURE), ("IfcDistributionElement", FURNITURE), ("IfcElementAssembly", FURNITURE),
    ("IfcDiscreteAccessory", FURNITURE), ("IfcFastener", FURNITURE),
)  # fmt: skip


def kind_of(product: Any) -> str:
    for name, kind in _KINDS:
        if product.is_a(name):
            return kind
    return SHELL


def drawn(model: Any, offset: np.ndarray, progress: ifc_shapes.Progress | None = None) -> list[Element]:
    """Every drawn mesh, voids cut out, with its class: what a scene made from the file shows."""
    return [
        Element(s.product.Name or "", kind_of(s.product), s.world, s.triangles, s.product.GlobalId)
        for s in ifc_elements.shapes(model, offset, cut=True, progress=progress)
    ]


def classed(
    model: Any, offset: np.ndarray, states: ifc_states.DoorStates, progress: ifc_shapes.Progress | None = None
) -> list[Element]:
    """Shell elements without their voids cut out, and for each void, door, window and pane a passage."""
    names = {step: name for step, name, _ in storeys(model, length_unit(model))}
    shapes = {s.product.id(): s for s in ifc_elements.shapes(model, offset, cut=False, progress=progress)}
    voids = _voids(model, offset, shapes)
    loose = ifc_glazing.find(model)
    panes = ifc_glazing.shapes(model, loose, offset, None)
    adopted = ifc_glazing.adopt(loose, panes, voids)
    found: list[Element] = []
    glass = {p.id() for _, parts in loose.panes for p in parts}
    for shape in shapes.values():
        kind = kind_of(shape.product)
        if kind not in (DOOR, WINDOW) and shape.product.id() not in glass:
            found.append(Element(shape.product.Name or "", kind, shape.world, shape.triangles, shape.product.GlobalId))
    for element, shape, host, host_shape in voids:
        found += _void(element, shape, host, host_shape, adopted, names, states)
    for filler, wall in loose.fillers:
        shape = panes.get(filler.id())
        if shape is not None:
            host = ifc_glazing.host_of(wall, shape, panes)
            kind = DOOR if filler.is_a("IfcDoor") else WINDOW
            found += _opening(filler, kind, ifc_passages.of_filler(shape, host), names, states, shape)
    for wall, parts in loose.panes:
        for passage in ifc_passages.of_panes([panes[p.id()] for p in parts if p.id() in panes]):
            found += _opening(wall, WINDOW, passage, names, states, None)
    return found


def _voids(model: Any, offset: np.ndarray, solid: dict[int, ifc_shapes.Shape]) -> list[tuple[Any, Any, Any, Any]]:
    elements = list(model.by_type("IfcOpeningElement"))
    shapes = ifc_shapes.make(model, elements, cut=False, offset=offset, label="voids")
    result = []
    for e in elements:
        host = next((r.RelatingBuildingElement for r in e.VoidsElements or ()), None)
        result.append((e, shapes.get(e.id()), host, None if host is None else _whole(host, solid)))
    return result


def _whole(host: Any, solid: dict[int, ifc_shapes.Shape]) -> ifc_shapes.Shape | None:
    """The host's shape, or that of its parts together."""
    if host.id() in solid:
        return solid[host.id()]
    parts = [solid[p.id()] for p in ifc_openings.parts_of(host) if p.id() in solid]
    if not parts:
        return None
    first = np.cumsum([0] + [len(s.world) for s in parts])
    triangles = np.concatenate([s.triangles + n for s, n in zip(parts, first, strict=False)])
    return ifc_shapes.Shape(host, "", np.concatenate([s.world for s in parts]), triangles, np.eye(4))


def _void(
    element: Any, shape: Any, host: Any, host_shape: Any, adopted: dict[int, Any], names: dict[int, str],
    states: ifc_states.DoorStates,
) -> list[Element]:  # fmt: skip
    if shape is None or (host is not None and ifc_openings.is_no_boundary(host)):
        return []
    passage = ifc_passages.of_void(shape, host_shape, ifc_passages.placement_axis(host))
    if passage is None or not passage.cuts:
        return []
    fillers = [r.RelatedBuildingElement for r in element.HasFillings or ()]
    if not fillers and element.id() in adopted:
        fillers = [adopted[element.id()]]
    leader = ifc_openings.leader_of(fillers)
    if leader is None:
        return _opening(element, HOLE, passage, names, states, shape)
    return _opening(leader, DOOR if leader.is_a("IfcDoor") else WINDOW, passage, names, states, shape)


def _opening(
    product: Any, kind: str, passage: Passage | None, names: dict[int, str], states: ifc_states.DoorStates, shape: Any
) -> list[Element]:
    if passage is None:
        return []
    storey = storey_of(product, names)
    state = ifc_states.state_of(product, kind, storey, states) if kind != HOLE else "open"
    mesh = (shape.world, shape.triangles) if shape is not None else (passage.corners, np.zeros((0, 3), dtype=np.int64))
    name = product.Name or f"{product.is_a()} {product.GlobalId}"
    return [Element(name, kind, *mesh, product.GlobalId, state, storey, passage)]
