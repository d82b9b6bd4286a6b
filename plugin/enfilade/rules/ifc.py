# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads an IFC file (2X3, 4, 4X3) into a `Building`: rooms, openings, objects, storeys, problems.

Only what the question needs is made: spaces and voids first, then walls and slabs without their voids (to tell through
which faces a void goes and where rooms touch openly); doors, furniture and the rest only when objects are asked for.
"""

from __future__ import annotations

import codecs
import os
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import (
    ifc_boundaries,
    ifc_elements,
    ifc_glazing,
    ifc_library,
    ifc_neighbours,
    ifc_openings,
    ifc_shapes,
    ifc_spaces,
    ifc_states,
    ifc_units,
)
from .blockers import Blockers
from .building import EXTERIOR, WARNING, Building, Problem, Room
from .ifc_placement import Frame, drawing_frame, model_offset, storeys
from .ifc_units import length_unit
from .probing import Passage

Cancelled = ifc_shapes.Cancelled
# What can close a room off. Stairs, railings and furniture can't; doors and windows stand in voids.
SHELL = (
    "IfcWall", "IfcSlab", "IfcRoof", "IfcCurtainWall", "IfcPlate", "IfcMember", "IfcCovering", "IfcColumn", "IfcBeam",
    "IfcFooting", "IfcBuildingElementProxy", "IfcBuildingElementPart", "IfcChimney", "IfcShadingDevice",
)  # fmt: skip


class IfcError(ValueError):
    """The file can't be read as IFC; the message says why."""


def open_model(path: str | os.PathLike[str]) -> Any:
    """The parsed file. IfcError names the file and the reason; IfcLibraryMissing when IfcOpenShell isn't there."""
    ifc = ifc_library.load()
    name = os.fspath(path)
    if not os.path.isfile(name):
        raise IfcError(f"no such file: {name}")
    with open(name, "rb") as file:
        head = file.read(512)
    marked = head.startswith(codecs.BOM_UTF8)  # the library's parser takes offence at it
    if b"ISO-10303-21" not in head and not head.startswith(b"PK") and b"<" not in head[:64]:
        raise IfcError(f"{name} isn't an IFC file (it doesn't begin with ISO-10303-21)")
    try:
        model = ifc.file.from_string(_text(name)) if marked else ifc.open(name)
        model.by_type("IfcProduct")
    except Exception as error:  # the library raises several kinds
        if "schema" in str(error).lower():
            raise IfcError(f"{name} can't be read: {error}. Export it again as IFC2X3, IFC4 or IFC4X3.") from error
        raise IfcError(f"{name} can't be read: {error}") from error
    return model


def read_ifc(
    path: str | os.PathLike[str],
    *,
    progress: ifc_shapes.Progress | None = None,
    door_states: ifc_states.DoorStates | Mapping[str, str] | str | None = None,
    objects: bool = True,
    local: bool = False,
    model: Any = None,
) -> Building:
    """The building in a file.

    progress(fraction, label): called now and then; returning False raises Cancelled. door_states: None, "open" or
    "closed" for doors without a say of their own, a mapping GlobalId or name -> state, or `DoorStates`.
    objects: whether the bounds of what is drawn are read too (the slow part). local: coordinates near the origin: whole
    kilometres are taken off models on a national grid, told in `Building.offset`; else world coordinates of the file.
    model: an already opened file. Raises IfcError, IfcLibraryMissing, Cancelled.
    """
    building, _ = read_with_outcomes(
        path, progress=progress, door_states=door_states, objects=objects, local=local, model=model
    )
    return building


def read_with_outcomes(
    path: str | os.PathLike[str],
    *,
    progress: ifc_shapes.Progress | None = None,
    door_states: ifc_states.DoorStates | Mapping[str, str] | str | None = None,
    objects: bool = True,
    local: bool = False,
    model: Any = None,
) -> tuple[Building, list[ifc_openings.Outcome]]:
    """As `read_ifc`, with the fate of every product that might have been an opening."""
    model = model if model is not None else open_model(path)
    try:
        return _read(model, path, progress, ifc_states.DoorStates.of(door_states), objects, local)
    except (AttributeError, TypeError, IndexError, KeyError, RuntimeError) as error:
        if isinstance(error, Cancelled):
            raise
        # References that lead nowhere surface as missing attributes, deep in the file.
        raise IfcError(f"{os.fspath(path)} is damaged or of a kind not known here: {error}") from error


def _read(
    model: Any,
    path: str | os.PathLike[str],
    progress: ifc_shapes.Progress | None,
    states: ifc_states.DoorStates,
    objects: bool,
    local: bool,
) -> tuple[Building, list[ifc_openings.Outcome]]:
    clock = _Clock()
    unit = length_unit(model)
    offset = model_offset(model, unit) if local else np.zeros(3)
    frame = drawing_frame(model, unit)
    floors = storeys(model, unit)
    names = {step: name for step, name, _ in floors}
    building = Building(source="ifc", storeys=[(name, height) for _, name, height in floors])
    if _is_cut_short(path):
        building.problems.append(
            Problem(
                WARNING, "file-cut-short", f"{os.path.basename(os.fspath(path))} ends before its end mark: part is missing",
                remedy="copy or export the file again",
            )
        )  # fmt: skip
    clock.stage("open")

    spaces = ifc_spaces.read(model, frame, names, _part(progress, 0.0, 0.2))
    building.rooms = [*spaces.rooms]
    building.problems += spaces.problems
    exterior = len(building.rooms)
    building.rooms.append(Room("Exterior", EXTERIOR))
    if not spaces.rooms:
        building.problems.append(
            Problem(
                WARNING, "no-spaces", "the file has no spaces: rooms must come from the geometry of walls and slabs",
                remedy="take the source Geometry (detect --source geometry --ifc FILE), export the file with spaces, or mark rooms by hand",
            )
        )  # fmt: skip
    clock.stage("spaces")

    context = ifc_openings.Context(
        building.rooms, spaces.solids, exterior, names, states, building.openings,
        building.problems, [], axes=frame.axes,
    )  # fmt: skip
    solid: dict[int, ifc_shapes.Shape] = {}  # uncut shapes made so far, by STEP id
    voids = _voids(model, frame, solid, _part(progress, 0.2, 0.5))
    loose = ifc_glazing.find(model)
    panes = ifc_shapes.in_frame(ifc_glazing.shapes(model, loose, frame.origin, _part(progress, 0.5, 0.6)), frame)
    clock.stage("voids")
    ifc_openings.add_voids(context, voids, ifc_glazing.adopt(loose, panes, voids))
    ifc_glazing.add(context, loose, panes)
    ifc_neighbours.add(context)
    clock.stage("openings")
    if spaces.rooms:
        solid.update(panes)
        blockers = _blockers(model, frame, solid, context.holes, _part(progress, 0.6, 0.65))
        clock.stage("shell")
        ifc_boundaries.add(context, blockers, _part(progress, 0.65, 0.7))
        clock.stage("boundaries")
    move(building, frame, offset)
    building.offset = tuple(float(x) for x in offset)
    if objects:
        shapes = ifc_elements.shapes(model, offset, cut=False, progress=_part(progress, 0.7, 1.0))
        building.objects = [ifc_elements.object_of(s) for s in shapes]
        clock.stage("objects")
    building.statistics = clock.seconds
    return building, context.outcomes


def _voids(
    model: Any, frame: Frame, solid: dict[int, ifc_shapes.Shape], progress: ifc_shapes.Progress | None
) -> list[tuple[Any, ifc_shapes.Shape | None, Any, ifc_shapes.Shape | None]]:
    elements = list(model.by_type("IfcOpeningElement"))
    hosts: dict[int, Any] = {}
    for e in elements:
        for relation in e.VoidsElements or ():
            hosts[e.id()] = relation.RelatingBuildingElement
    wanted = {h.id(): h for h in hosts.values() if not ifc_openings.is_no_boundary(h)}
    parts = {i: ifc_openings.parts_of(h) for i, h in wanted.items() if h.Representation is None}
    products = [h for i, h in wanted.items() if i not in parts] + [p for ps in parts.values() for p in ps]
    shapes = _make(model, elements, frame, progress, "voids")
    solid.update(_make(model, products, frame, progress, "walls and slabs"))
    whole = dict(solid)
    for step, children in parts.items():
        together = [solid[c.id()] for c in children if c.id() in solid]
        if together:
            whole[step] = _union(wanted[step], together)
    result = []
    for e in elements:
        host = hosts.get(e.id())
        result.append((e, shapes.get(e.id()), host, whole.get(host.id()) if host is not None else None))
    return result


def _blockers(
    model: Any,
    frame: Frame,
    solid: dict[int, ifc_shapes.Shape],
    holes: dict[int, list[Passage]],
    progress: ifc_shapes.Progress | None,
) -> Blockers:
    """The shell, its voids beside it; what one sees through (glass) is in it, since panes are passages of their own."""
    products = {e.id(): e for name in SHELL for e in ifc_units.by_type(model, name)}
    missing = [e for i, e in products.items() if i not in solid]
    made = _make(model, missing, frame, progress, "shell")
    shapes = [solid.get(i) or made.get(i) for i in products]
    return Blockers([s for s in shapes if s is not None], holes)


def _make(
    model: Any, products: list[Any], frame: Frame, progress: ifc_shapes.Progress | None, label: str
) -> dict[int, ifc_shapes.Shape]:
    """Uncut shapes in the frame's axes, by STEP id."""
    made = ifc_shapes.make(model, products, cut=False, offset=frame.origin, progress=progress, label=label)
    return ifc_shapes.in_frame(made, frame)


def _text(name: str) -> str:
    """A STEP file without its byte order mark."""
    with open(name, encoding="utf-8-sig", errors="replace") as file:
        return file.read()


def _is_cut_short(path: str | os.PathLike[str]) -> bool:
    """Whether a STEP file lacks its end mark; False where that can't be told."""
    try:
        with open(path, "rb") as file:
            if b"ISO-10303-21" not in file.read(256):
                return False
            file.seek(0, os.SEEK_END)
            file.seek(max(0, file.tell() - 4096))
            return b"END-ISO-10303-21" not in file.read()
    except OSError:
        return False


def _union(product: Any, shapes: list[ifc_shapes.Shape]) -> ifc_shapes.Shape:
    """One shape in world coordinates made of several."""
    vertices, triangles, count = [], [], 0
    for s in shapes:
        vertices.append(s.world)
        triangles.append(s.triangles + count)
        count += len(s.world)
    return ifc_shapes.Shape(product, "", np.concatenate(vertices), np.concatenate(triangles), np.eye(4))


def move(building: Building, frame: Frame, offset: np.ndarray) -> None:
    """From the frame to the file's world less `offset`."""

    def out(points: np.ndarray | None) -> np.ndarray | None:
        return None if points is None else frame.out(points, offset)

    for room in building.rooms:
        room.vertices = out(room.vertices)
    for opening in building.openings:
        opening.body, opening.polygon = out(opening.body), out(opening.polygon)
        opening.ends = None if opening.ends is None else (out(opening.ends[0]), out(opening.ends[1]))
    for problem in building.problems:
        if problem.position is not None:
            problem.position = tuple(float(x) for x in out(np.array(problem.position)))


def _part(progress: ifc_shapes.Progress | None, start: float, end: float) -> ifc_shapes.Progress | None:
    if progress is None:
        return None
    return lambda fraction, label: progress(start + (end - start) * fraction, label)


class _Clock:
    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self._last
        self._last = now
