# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings from IFC: voids with what fills them, doors and windows without a void, glazed walls.

Every product that could let one look from room to room ends as an `Opening`, or as a Problem that says why not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import convex_polygons as cp
from . import ifc_passages, ifc_states
from .building import DOOR, ERROR, HOLE, INFO, WARNING, WINDOW, Opening, Problem, Room
from .ifc_placement import storey_of
from .ifc_shapes import Shape
from .polyhedra import Polyhedron
from .probing import REACH, End, Passage, Probe, at_boundary, outside_end, probe

THIN = 2e-3  # m: a passage shorter than this is a polygon, not a body
GAP_TOLD = 0.02  # m between void and room from which on the gap is worth a line in the problems


@dataclass
class Outcome:
    """How one product fared, for the table of figures."""

    product: str
    kind: str
    source_id: str
    fate: str  # "joined", "exterior", "same-room", "no-room", "false-portal", "cuts-nothing", "no-extent"
    rooms: list[tuple[int, int]] = field(default_factory=list)


@dataclass
class Context:
    rooms: Sequence[Room]
    solids: list[Polyhedron]
    exterior: int  # index of the exterior room
    storeys: dict[int, str]
    states: ifc_states.DoorStates
    openings: list[Opening]
    problems: list[Problem]
    outcomes: list[Outcome]
    holes: dict[int, list[Passage]] = field(default_factory=dict)  # voids by their host's STEP id
    passages: dict[int, Passage] = field(default_factory=dict)  # of thick openings, by index
    narrow: dict[tuple[int, int], np.ndarray] = field(default_factory=dict)  # (opening, room) -> `End.narrow`
    axes: np.ndarray | None = None  # float64 (3, 3), rows: the working frame's axes in the file's world; None: the same
    _bounds: tuple[np.ndarray, np.ndarray] | None = None  # of the solids, float64 (n, 3) each

    def probe(self, passage: Passage) -> Probe:
        """`probing.probe` among the rooms whose bounds come near."""
        return probe(passage, self.solids, self.near(passage))

    def near(self, passage: Passage) -> list[int]:
        """Rooms whose bounds come near a passage."""
        if self._bounds is None:
            self._bounds = tuple(
                np.array([getattr(s, side) for s in self.solids]).reshape(-1, 3) for side in ("low", "high")
            )
        reach = 2.0 * REACH + passage.host[1] - passage.host[0]
        low, high = passage.low - reach, passage.high + reach
        near = np.nonzero((self._bounds[0] <= high).all(axis=1) & (self._bounds[1] >= low).all(axis=1))[0]
        return near.tolist()


def add_voids(
    context: Context, voids: list[tuple[Any, Shape | None, Any, Shape | None]], adopted: dict[int, Any]
) -> None:
    """voids: (opening element, its shape, host, the uncut host's shape). adopted: what fills an opening element without
    the file saying so, by the element's STEP id."""
    for element, shape, host, host_shape in voids:
        try:
            _add_void(context, element, shape, host, host_shape, adopted)
        except (ValueError, ArithmeticError, IndexError, AttributeError) as error:
            # One odd void must not cost the rest of the building; it is told as an error, for it may hide something.
            context.outcomes.append(Outcome(element.Name or "", HOLE, element.GlobalId, "no-extent"))
            context.problems.append(
                Problem(
                    ERROR, "opening-failed", f"the void '{element.Name}' ({element.GlobalId}) can't be used: {error}",
                    [element.Name or ""], None if shape is None else _centre(shape), "check the void's geometry",
                )
            )  # fmt: skip


def _add_void(
    context: Context, element: Any, shape: Shape | None, host: Any, host_shape: Shape | None, adopted: dict[int, Any]
) -> None:
    fillers = [r.RelatedBuildingElement for r in element.HasFillings or ()]
    if not fillers and element.id() in adopted:
        fillers = [adopted[element.id()]]
    leader = leader_of(fillers)
    kind = DOOR if leader is not None and leader.is_a("IfcDoor") else WINDOW if leader is not None else HOLE
    name = (leader.Name if leader is not None else element.Name) or element.Name or f"Opening {element.GlobalId}"
    source = leader.GlobalId if leader is not None else element.GlobalId
    position = None if shape is None else _centre(shape)
    if host is not None and is_no_boundary(host):
        context.outcomes.append(Outcome(name, kind, source, "false-portal"))
        context.problems.append(
            Problem(
                INFO, "false-portal",
                f"void '{element.Name}' is cut into {host.is_a()} '{host.Name}', not into a wall or slab: no portal",
                [name, host.Name or ""], position,
            )
        )  # fmt: skip
        return
    if shape is None:
        context.outcomes.append(Outcome(name, kind, source, "no-extent"))
        context.problems.append(
            Problem(WARNING, "opening-without-geometry", f"'{name}' has no void to look through", [name])
        )
        return
    across = ifc_passages.placement_axis(host)
    if across is not None and context.axes is not None:
        across = context.axes @ across
    passage = ifc_passages.of_void(shape, host_shape, across)
    if passage is None:
        context.outcomes.append(Outcome(name, kind, source, "no-extent"))
        context.problems.append(
            Problem(WARNING, "opening-without-geometry", f"the void of '{name}' is flat", [name], position)
        )
        return
    if not passage.cuts:
        context.outcomes.append(Outcome(name, kind, source, "cuts-nothing"))
        context.problems.append(
            Problem(
                INFO, "void-beside-host",
                f"the void of '{name}' lies beside {host.is_a()} '{host.Name}' and takes nothing away: no portal",
                [name, host.Name or ""], position,
            )
        )  # fmt: skip
        return
    if host is not None:
        for product in (host, *parts_of(host)):
            context.holes.setdefault(product.id(), []).append(passage)
    if not ifc_passages.is_convex_enough(shape, passage):
        context.problems.append(
            Problem(
                INFO, "void-not-convex", f"the void of '{name}' isn't convex along its axis; its hull stands in",
                [name], position,
            )
        )  # fmt: skip
    product = leader if leader is not None else element
    storey = storey_of(product, context.storeys) or storey_of(element, context.storeys)
    state = ifc_states.state_of(product, kind, storey, context.states) if leader is not None else "open"
    add_passage(context, passage, name, kind, state, source)


def add_passage(context: Context, passage: Passage, name: str, kind: str, state: str, source: str) -> Outcome:
    """Probes a passage and adds an opening for each pair of rooms that it joins."""
    found = context.probe(passage)
    outcome = Outcome(name, kind, source, "no-room")
    context.outcomes.append(outcome)
    position = tuple(float(x) for x in passage.frame.world(_middle(passage))[0])
    if found.holding:
        moved = at_boundary(passage, [context.solids[r] for r in found.holding])
        if moved is not None:
            passage, found = moved, context.probe(moved)
            found.within = -1
    if found.within >= 0 and _only(found, found.within):
        outcome.fate = "same-room"
        room = context.rooms[found.within].name
        context.problems.append(
            Problem(
                INFO, "opening-inside-room",
                f"{kind} '{name}' stands in a partition inside room '{room}', which has no boundary there: no portal",
                [name, room], position,
            )
        )  # fmt: skip
        return outcome
    low, high = _with_outside(passage, found.low, -1.0), _with_outside(passage, found.high, 1.0)
    if all(e.room < 0 for e in low + high):
        context.problems.append(
            Problem(
                INFO, "opening-no-room", f"{kind} '{name}' has no room on either side", [name], position,
                "model the spaces beside it if it matters",
            )
        )  # fmt: skip
        return outcome
    pairs = [(a, b) for a in low for b in high if not (a.room < 0 and b.room < 0)]
    pairs.sort(key=lambda p: -(p[0].share * p[1].share))
    for number, (a, b) in enumerate(pairs):
        label = name if number == 0 else f"{name} ({number + 1})"
        _add(context, passage, label, kind, state, source, a, b)
        outcome.rooms.append(tuple(context.exterior if e.room < 0 else e.room for e in (a, b)))
    joined = [p for p in outcome.rooms if context.exterior not in p and p[0] != p[1]]
    outcome.fate = "joined" if joined else "exterior" if any(context.exterior in p for p in outcome.rooms) else "same-room"
    if len(pairs) > 1:
        names = sorted({context.rooms[r].name for p in outcome.rooms for r in p})
        context.problems.append(
            Problem(
                INFO, "opening-several-rooms", f"{kind} '{name}' meets {len(names)} rooms: {', '.join(names)}",
                [name, *names], position,
            )
        )  # fmt: skip
    gap = max((e.gap for e in low + high), default=0.0)
    if gap > GAP_TOLD:
        context.problems.append(
            Problem(
                INFO, "opening-gap",
                f"{kind} '{name}' ends {gap:.3f} m before its room; the passage was prolonged and widened by as much",
                [name], position,
            )
        )  # fmt: skip
    return outcome


def parts_of(product: Any) -> list[Any]:
    """What a product is made of, where its parts carry the shape."""
    found = []
    for relation in getattr(product, "IsDecomposedBy", ()) or ():
        for child in relation.RelatedObjects:
            found += [child] if getattr(child, "Representation", None) is not None else parts_of(child)
    return found


def is_no_boundary(host: Any) -> bool:
    """Whether a void in this product can't part two rooms: furniture, fixtures, what hangs or stands in a room."""
    return any(
        host.is_a(name)
        for name in ("IfcFurnishingElement", "IfcDistributionElement", "IfcRailing", "IfcTransportElement")
    )


def _add(
    context: Context, passage: Passage, name: str, kind: str, state: str, source: str, a: End, b: End
) -> None:
    turned = (context.exterior if a.room < 0 else a.room) > (context.exterior if b.room < 0 else b.room)
    ends = (b, a) if turned else (a, b)  # the lower room first: which way the axis points is chance
    rooms = tuple(context.exterior if e.room < 0 else e.room for e in ends)
    opening = Opening(name=name, kind=kind, state=state, source_id=source, rooms=rooms)
    context.narrow.update({(len(context.openings), e.room): e.narrow for e in ends if e.narrow is not None})
    if b.depth - a.depth > THIN:
        opening.ends = (ends[0].polygon, ends[1].polygon)
        opening.body = np.concatenate([a.polygon, b.polygon])
        context.passages[len(context.openings)] = passage
    else:
        # The rooms meet or overlap inside the wall: one polygon half way, within which all views between them pass.
        local = passage.frame.local(np.concatenate([a.polygon, b.polygon]))
        outline = cp.limit_corners(cp.hull((x, y) for x, y, _ in local), 24)
        t = 0.5 * (float(local[:, 2].min()) + float(local[:, 2].max()))
        opening.polygon = passage.frame.world(np.array([(x, y, t) for x, y in outline]))
    context.openings.append(opening)


def _with_outside(passage: Passage, ends: list[End], sign: float) -> list[End]:
    """The ends of one side, and the outside where rooms cover less than half of the section."""
    covered = sum(e.share for e in ends)
    if covered >= 0.5:
        return ends
    return [*ends, outside_end(passage, sign)]


def _only(found: Probe, room: int) -> bool:
    return all(e.room == room for e in found.low + found.high)


def leader_of(fillers: list[Any]) -> Any:
    """The filler that names the opening: a door before a window before anything else."""
    order = {"IfcDoor": 0, "IfcWindow": 1}
    best = None
    for f in fillers:
        rank = next((r for c, r in order.items() if f.is_a(c)), 2)
        if best is None or rank < best[0]:
            best = (rank, f)
    return best[1] if best else None


def _middle(passage: Passage) -> np.ndarray:
    corners = np.array(passage.section)
    return np.array([[*corners.mean(axis=0), 0.5 * (passage.host[0] + passage.host[1])]])


def _centre(shape: Shape) -> tuple[float, float, float]:
    return tuple(float(x) for x in 0.5 * (shape.world.min(axis=0) + shape.world.max(axis=0)))
