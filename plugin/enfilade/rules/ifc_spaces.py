# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms from IfcSpace: closed polyhedra with names, storeys and GlobalIds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import ifc_shapes, polyhedra
from .building import ERROR, INFO, WARNING, Problem, Room
from .ifc_placement import Frame, storey_of
from .shapes import flatness

NEARLY = 0.5  # m that spaces which hold each other may differ: one drawn to the finish, one to the wall's outer face
SAME_VOLUME = 0.4  # by which doubles of a room may differ
MIN_VOLUME = 1e-3  # m3: less is a leftover of modelling, not a room


@dataclass
class Spaces:
    rooms: list[Room]
    solids: list[polyhedra.Polyhedron]  # beside rooms
    outdoor: list[Any]  # spaces that are open air: they belong to the exterior
    problems: list[Problem]


def read(
    model: Any, frame: Frame, storeys: dict[int, str], progress: ifc_shapes.Progress | None = None
) -> Spaces:
    """Every IfcSpace with a volume, in file order, in the frame's axes."""
    result = Spaces([], [], [], [])
    spaces = [s for s in model.by_type("IfcSpace") if not _has_parts(s)]
    made = ifc_shapes.make(model, spaces, cut=False, offset=frame.origin, progress=progress, label="spaces")
    shapes = ifc_shapes.in_frame(made, frame)
    for space in spaces:
        name = space.Name or f"Space {space.GlobalId}"
        shape = shapes.get(space.id())
        if shape is None:
            result.problems.append(
                Problem(
                    WARNING, "room-without-geometry", f"space '{name}' has no volume in the file and is left out",
                    [name], remedy="give the space a Body representation",
                )
            )  # fmt: skip
            continue
        if _is_outdoor(space):
            result.outdoor.append(space)
            result.problems.append(
                Problem(INFO, "outdoor-space", f"space '{name}' is external: it belongs to the exterior", [name])
            )
            continue
        add(result, name, shape, storey_of(space, storeys), space.GlobalId, space.LongName or "")
    drop_overlays(result)
    return result


def add(spaces: Spaces, name: str, shape: ifc_shapes.Shape, storey: str, source_id: str, long_name: str = "") -> None:
    """One space with a volume, or a problem that says why it has none."""
    solid = polyhedra.build(shape.world, shape.triangles)
    centre = tuple(float(x) for x in 0.5 * (solid.low + solid.high))
    flat = len(solid.triangles) == 0 or flatness(solid.vertices)[0] < polyhedra.WELD  # drawn as its footprint
    if flat or (solid.closed and solid.volume < MIN_VOLUME):
        spaces.problems.append(
            Problem(WARNING, "room-empty", f"space '{name}' encloses no volume and is left out", [name], centre)
        )
        return
    room = Room(name, storey=storey, source_id=source_id, vertices=solid.vertices, long_name=long_name,
                faces=[list(loop) for loop in solid.loops])  # fmt: skip
    if not solid.closed:
        room.faces = None  # the convex hull: larger, so nothing visible is lost
        spaces.problems.append(
            Problem(
                ERROR if len(solid.vertices) < 4 else WARNING, "room-not-closed",
                f"space '{name}' isn't closed; its convex hull stands in for it", [name], centre,
                "close the space's surface in the authoring tool",
            )
        )  # fmt: skip
    elif solid.repaired:
        spaces.problems.append(Problem(INFO, "room-repaired", f"space '{name}': {solid.repaired}", [name], centre))
    spaces.rooms.append(room)
    spaces.solids.append(solid)


def drop_overlays(spaces: Spaces) -> None:
    """Takes out spaces that lie over others: gross areas and zones that hold whole rooms, and doubles of a room.

    A dropped space costs no view: what of it no other room claims is the exterior's.
    """
    solids = spaces.solids
    volumes = [abs(s.volume) for s in solids]
    dropped: dict[int, tuple[str, str]] = {}
    lows = np.array([s.low for s in solids]).reshape(-1, 3)
    highs = np.array([s.high for s in solids]).reshape(-1, 3)
    for i, outer in enumerate(solids):
        held, names = 0.0, []
        contained = (lows >= outer.low - NEARLY).all(axis=1) & (highs <= outer.high + NEARLY).all(axis=1)
        for j in np.nonzero(contained)[0].tolist():
            if i == j or j in dropped:
                continue
            inner = solids[j]
            apart = volumes[i] / max(volumes[j], MIN_VOLUME) - 1.0
            if abs(apart) < SAME_VOLUME and _lies_in(inner, outer) and _lies_in(outer, inner):
                if apart > 0.01 or (apart > -0.01 and j < i):  # the net room stays, of equal ones the first
                    message = f"space '{spaces.rooms[i].name}' is the same as '{spaces.rooms[j].name}' and is left out"
                    dropped[i] = ("room-double", message)
                    break
                continue
            if _lies_in(inner, outer):
                held += volumes[j]
                names.append(spaces.rooms[j].name)
        if i not in dropped and len(names) > 1 and held > 0.5 * volumes[i]:
            message = f"space '{spaces.rooms[i].name}' holds {len(names)} other spaces and is left out as a gross area"
            dropped[i] = ("room-holds-rooms", message)
    for i, (code, message) in dropped.items():
        where = tuple(float(x) for x in 0.5 * (solids[i].low + solids[i].high))
        spaces.problems.append(Problem(INFO, code, message, [spaces.rooms[i].name], where))
    spaces.rooms = [r for i, r in enumerate(spaces.rooms) if i not in dropped]
    spaces.solids = [s for i, s in enumerate(solids) if i not in dropped]


def _lies_in(inner: polyhedra.Polyhedron, outer: polyhedra.Polyhedron) -> bool:
    """Whether nearly all of one solid lies in another, by points well inside it."""
    centre = inner.vertices.mean(axis=0)
    probes = np.concatenate([[centre], centre + 0.8 * (inner.vertices - centre)])
    probes = probes[polyhedra.inside(probes, inner)]
    return len(probes) > 0 and bool(polyhedra.inside(probes, outer).mean() > 0.9)


def _has_parts(space: Any) -> bool:
    """Whether other spaces divide this one up: then they are the rooms."""
    for relation in getattr(space, "IsDecomposedBy", ()) or ():
        if any(p.is_a("IfcSpace") and p.Representation is not None for p in relation.RelatedObjects):
            return True
    return False


def _is_outdoor(space: Any) -> bool:
    """IFC4: PredefinedType EXTERNAL. IFC2X3: InteriorOrExteriorSpace EXTERNAL."""
    if space.is_a("IfcSpace"):
        for attribute in ("PredefinedType", "InteriorOrExteriorSpace"):
            if getattr(space, attribute, None) == "EXTERNAL":
                return True
    return False
