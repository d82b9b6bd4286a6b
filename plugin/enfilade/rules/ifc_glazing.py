# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings that have no void: doors and windows in curtain walls, panes of glass, walls made of glass."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import ifc_passages, ifc_shapes, ifc_states
from .building import DOOR, INFO, WINDOW, Problem
from .ifc_openings import Context, add_passage
from .ifc_placement import storey_of
from .ifc_shapes import Shape

NEAR = 0.25  # m between a filler's bounds and the void it stands in without saying so (a skylight on its kerb)
OPAQUE_WORDS = re.compile(
    r"alumin|steel|stahl|metal|wood|holz|concrete|beton|brick|ziegel|gypsum|gips|insul|dämm|spandrel|solid|opaque|stone",
    re.IGNORECASE,
)


@dataclass
class Loose:
    """What stands without a void of its own."""

    fillers: list[tuple[Any, Any]] = field(default_factory=list)  # door or window, its curtain wall or None
    panes: list[tuple[Any, list[Any]]] = field(default_factory=list)  # curtain wall, glass wall; its glass parts


def find(model: Any) -> Loose:
    """Doors and windows that fill no void, and what is made of glass."""
    result = Loose()
    for name in ("IfcDoor", "IfcWindow"):
        for product in model.by_type(name):
            if product.FillsVoids or product.Representation is None:
                continue
            result.fillers.append((product, _curtain_wall(product)))
    for wall in model.by_type("IfcCurtainWall"):
        parts = [p for p in _descendants(wall) if p.Representation is not None]
        plates = [p for p in parts if p.is_a("IfcPlate") or p.is_a("IfcBuildingElementPart")]
        glass = [p for p in plates if not _is_opaque(p)]
        if glass:
            result.panes.append((wall, glass))
        elif wall.Representation is not None and not plates and not _is_opaque(wall):
            result.panes.append((wall, [wall]))
    for name in ("IfcWall", "IfcPlate"):
        for product in model.by_type(name):
            if product.Representation is None or _curtain_wall(product) is not None:
                continue
            if ifc_states.is_glass_only(product):
                result.panes.append((product, [product]))
    return result


def shapes(model: Any, loose: Loose, offset: np.ndarray, progress: ifc_shapes.Progress | None) -> dict[int, Shape]:
    """Shapes of everything loose, and of the parts of the curtain walls that doors stand in, by STEP id."""
    products = {f.id(): f for f, _ in loose.fillers}
    products.update({p.id(): p for _, parts in loose.panes for p in parts})
    for _, wall in loose.fillers:
        if wall is not None:
            products.update({p.id(): p for p in _descendants(wall) if p.is_a("IfcPlate") or p.is_a("IfcMember")})
    return ifc_shapes.make(model, products.values(), cut=False, offset=offset, progress=progress, label="curtain walls")


def adopt(
    loose: Loose, made: dict[int, Shape], voids: list[tuple[Any, Shape | None, Any, Shape | None]]
) -> dict[int, Any]:
    """Loose fillers that stand in or on an unfilled void, taken off `loose`: void's STEP id -> filler."""
    adopted: dict[int, Any] = {}
    for filler, wall in list(loose.fillers):
        shape = made.get(filler.id())
        if shape is None:
            continue
        low, high = shape.world.min(axis=0), shape.world.max(axis=0)
        for element, void, _, _ in voids:
            if void is None or element.HasFillings or element.id() in adopted:
                continue
            v_low, v_high = void.world.min(axis=0), void.world.max(axis=0)
            shared = np.minimum(high, v_high) - np.maximum(low, v_low)
            size = np.minimum(high - low, v_high - v_low)
            # In two directions they cover each other, in the third they are near.
            if (shared > -NEAR).all() and (shared > 0.7 * size).sum() >= 2:
                adopted[element.id()] = filler
                loose.fillers.remove((filler, wall))
                break
    return adopted


def add(context: Context, loose: Loose, made: dict[int, Shape]) -> None:
    """Adds openings for all that is loose."""
    for filler, wall in loose.fillers:
        shape = made.get(filler.id())
        if shape is None:
            continue
        passage = ifc_passages.of_filler(shape, host_of(wall, shape, made))
        if passage is None:
            continue
        kind = DOOR if filler.is_a("IfcDoor") else WINDOW
        storey = storey_of(filler, context.storeys)
        state = ifc_states.state_of(filler, kind, storey, context.states)
        add_passage(context, passage, filler.Name or filler.is_a(), kind, state, filler.GlobalId)
    for wall, parts in loose.panes:
        storey = storey_of(wall, context.storeys)
        state = ifc_states.state_of(wall, WINDOW, storey, context.states)
        passages = ifc_passages.of_panes([made[p.id()] for p in parts if p.id() in made])
        for number, passage in enumerate(passages):
            name = wall.Name or wall.is_a()
            name = name if number == 0 else f"{name} [{number + 1}]"
            add_passage(context, passage, name, WINDOW, state, wall.GlobalId)
        if passages:
            context.problems.append(
                Problem(
                    INFO, "glazed-wall",
                    f"{wall.is_a()} '{wall.Name}' is seen through: {len(parts)} panes in {len(passages)} planes",
                    [wall.Name or ""],
                    remedy="give opaque panels an opaque material, or override its state",
                )
            )  # fmt: skip


def host_of(wall: Any, filler: Shape, made: dict[int, Shape]) -> Shape | None:
    """What of a curtain wall (None: of none) stands round a filler, as one shape."""
    if wall is None:
        return None
    return _nearby([made[p.id()] for p in _descendants(wall) if p.id() in made and not p.is_a("IfcDoor")], filler)


def _nearby(shapes_: list[Shape], filler: Shape) -> Shape | None:
    """The panes and mullions within half a metre of the filler, as one shape."""
    low, high = filler.world.min(axis=0) - 0.5, filler.world.max(axis=0) + 0.5
    chosen = [s for s in shapes_ if (s.world.min(axis=0) <= high).all() and (s.world.max(axis=0) >= low).all()]
    if not chosen:
        return None
    count = np.cumsum([0] + [len(s.world) for s in chosen])
    return Shape(
        chosen[0].product, "", np.concatenate([s.world for s in chosen]),
        np.concatenate([s.triangles + n for s, n in zip(chosen, count, strict=False)]), np.eye(4),
    )  # fmt: skip


def _curtain_wall(product: Any) -> Any:
    here, depth = product, 0
    while here is not None and depth < 8:
        if here.is_a("IfcCurtainWall"):
            return here
        here = next((r.RelatingObject for r in getattr(here, "Decomposes", ()) or ()), None)
        depth += 1
    return None


def _descendants(product: Any) -> list[Any]:
    found: list[Any] = []
    for relation in getattr(product, "IsDecomposedBy", ()) or ():
        for child in relation.RelatedObjects:
            found += [child, *_descendants(child)]
    return found


def _is_opaque(product: Any) -> bool:
    """Only what says so by its materials; everything else is taken as seen through (errs to open)."""
    return says_opaque(ifc_states.material_names(product))


def says_opaque(materials: Iterable[str]) -> bool:
    return any(OPAQUE_WORDS.search(n) for n in materials) and not any(ifc_states.GLASS_WORDS.search(n) for n in materials)
