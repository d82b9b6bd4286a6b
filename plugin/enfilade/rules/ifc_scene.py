# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings of a scene that draws an IFC model whose file isn't at hand: objects named `IfcSpace/...`, `IfcDoor/...`.

Names, materials and meshes are all there is. Walls are drawn with their holes already cut, so what a door or window stands in is told
by the hole's own faces; holes that nothing fills are found where a room is open and another lies right behind. All else goes
the way of a file's elements (`ifc.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from . import building as b
from . import ifc_boundaries, ifc_glazing, ifc_passages, ifc_spaces, ifc_states, polyhedra
from .annotated import name_storeys
from .blockers import Blockers
from .ifc_openings import Context, add_passage
from .ifc_shapes import Shape
from .probing import REACH, Frame, Passage
from .shapes import polygon_area
from .touching import OpenPart

SPACES = ("IfcSpace",)
FILLERS = {"IfcDoor": b.DOOR, "IfcDoorStandardCase": b.DOOR, "IfcWindow": b.WINDOW, "IfcWindowStandardCase": b.WINDOW}
VOIDS = ("IfcOpeningElement", "IfcOpeningStandardCase")
SHELL = ("IfcWall", "IfcSlab", "IfcRoof", "IfcCovering", "IfcColumn", "IfcBeam", "IfcMember", "IfcPlate", "IfcCurtainWall",
         "IfcFooting", "IfcBuildingElement", "IfcChimney", "IfcShadingDevice")  # fmt: skip
PANES = ("IfcPlate", "IfcCurtainWall")  # seen through unless their materials say otherwise
TEMPLATES = ("Type", "Style")  # end of the classes of `IfcDoorType/...`, `IfcDoorStyle/...`: what products are made after
OWN_MEMBER = 0.5  # of a filler's box that lies in a void for the void to be its passage
NEXT_STOREY = 0.5  # m below a storey's elevation from which on a floor is of that storey
NEAR = 0.3  # m between a filler's bounds and those of what it stands in
THICKEST = 1.0  # m of wall or slab that an unfilled hole is looked through
# Of open boundary that counts as a hole somebody meant; what is less leads outdoors, as what was never drawn does.
LEAST_HOLE, LOWEST_HOLE = 0.5, 1.5  # m2; m of height, where it is upright


@dataclass
class Piece:
    """One object of the scene."""

    name: str  # the object's full name
    local: np.ndarray  # float64 (n, 3), in the object's own axes
    faces: list[list[int]]
    matrix: np.ndarray  # float64 (4, 4)
    storey: str = ""
    materials: tuple[str, ...] = ()
    global_id: str = ""

    @property
    def ifc_class(self) -> str:
        return self.name.partition("/")[0]

    @property
    def label(self) -> str:
        return self.name.partition("/")[2] or self.name

    @property
    def source_id(self) -> str:
        return self.global_id or self.name

    def shape(self) -> Shape:
        return Shape(SimpleNamespace(id=lambda: self.name), self.name, self.local, _fans(self.faces), self.matrix)


def is_wanted(name: str) -> bool:
    """Whether an object of that name can be a room, an opening, or close a room off."""
    ifc_class, slash, _ = name.partition("/")
    return bool(slash) and (ifc_class in (*SPACES, *FILLERS, *VOIDS) or _is_shell(ifc_class))


def is_template(name: str) -> bool:
    """A type's own mesh, drawn at the origin: no part of the building."""
    ifc_class, slash, _ = name.partition("/")
    return bool(slash) and ifc_class.startswith("Ifc") and ifc_class.endswith(TEMPLATES)


def build(
    pieces: Sequence[Piece],
    storeys: Sequence[tuple[str, float]] = (),
    progress: Callable[[float, str], bool] | None = None,
) -> b.Building:
    """The building; its problems say what a file would have told better. storeys: name and elevation, ascending."""
    lines = [p.name for p in pieces if not p.faces]
    pieces = [p for p in pieces if p.faces]
    by_class = {c: [p for p in pieces if p.ifc_class == c and len(p.local) > 3] for c in {p.ifc_class for p in pieces}}
    spaces = ifc_spaces.Spaces([], [], [], [])
    for piece in (p for c in SPACES for p in by_class.get(c, [])):
        ifc_spaces.add(spaces, piece.label, piece.shape(), piece.storey or _storey_at(piece, storeys), piece.source_id)
    ifc_spaces.drop_overlays(spaces)
    out = b.Building(source="ifc scene", problems=spaces.problems, storeys=list(storeys))
    out.rooms = [*spaces.rooms, b.Room("Exterior", b.EXTERIOR)]
    if not storeys:
        name_storeys(out)
    context = Context(
        out.rooms, spaces.solids, len(spaces.rooms), {}, ifc_states.DoorStates(), out.openings, out.problems, []
    )
    if lines:
        out.problems.append(
            b.Problem(
                b.WARNING, "drawn-as-lines",
                f"{len(lines)} walls, doors or windows are drawn as lines, without faces ({', '.join(lines[:3])}): they part and join nothing",
                lines[:20], remedy="Show their Body representation (Bonsai switches by object), or name the IFC file.",
            )
        )  # fmt: skip
    shell = {p.name: p.shape() for p in pieces if _is_shell(p.ifc_class)}
    _add_fillers(context, by_class, shell)
    _add_panes(context, [p for p in pieces if p.name in shell], shell)
    if spaces.rooms and shell:
        blockers = Blockers(list(shell.values()))
        _add_holes(context, ifc_boundaries.open_parts(context, blockers, progress), blockers)
        ifc_boundaries.add(context, blockers, progress)
    return out


def _is_shell(ifc_class: str) -> bool:
    return ifc_class.startswith(SHELL) and not ifc_class.endswith(TEMPLATES)


def _storey_at(piece: Piece, storeys: Sequence[tuple[str, float]]) -> str:
    floor = float((piece.local @ piece.matrix[2, :3]).min() + piece.matrix[2, 3])
    reached = [name for name, height in storeys if height <= floor + NEXT_STOREY]
    return reached[-1] if reached else storeys[0][0] if storeys else ""


def _add_fillers(context: Context, by_class: dict[str, list[Piece]], shell: dict[str, Shape]) -> None:
    """Doors and windows, through their voids where those are drawn, and voids that nothing fills."""
    voids = {p.name: p.shape() for c in VOIDS for p in by_class.get(c, [])}
    labels = {p.name: p for c in VOIDS for p in by_class.get(c, [])}
    hosts = list(shell.values())
    for name, kind in FILLERS.items():
        for piece in by_class.get(name, []):
            filler = piece.shape()
            own = next((n for n, v in voids.items() if _holds(v, filler)), None)
            shape = filler if own is None else voids.pop(own)
            state = b.GLASS if kind == b.WINDOW else b.OPEN
            _add(context, _passage(shape, hosts), piece, kind, state)
    for name, void in voids.items():
        _add(context, _passage(void, hosts), labels[name], b.HOLE, b.OPEN)


def _add(context: Context, passage: Passage | None, piece: Piece, kind: str, state: str) -> None:
    if passage is not None:
        add_passage(context, passage, piece.label, kind, state, piece.source_id)


def _passage(filler: Shape, hosts: Sequence[Shape]) -> Passage | None:
    low, high = filler.world.min(axis=0), filler.world.max(axis=0)
    near = [h for h in hosts if (h.world.min(axis=0) <= high + NEAR).all() and (h.world.max(axis=0) >= low - NEAR).all()]
    found = ifc_passages.of_reveals(filler, near)
    if found is not None:
        return found
    # Nothing is cut for it: its own thinnest side is what it is passed along.
    across = filler.matrix[:3, int(np.argmin(np.ptp(filler.local, axis=0)))]
    return ifc_passages.of_points(filler.world, across / np.linalg.norm(across), 0.5 * (low + high), None)


def _add_panes(context: Context, pieces: Sequence[Piece], shell: dict[str, Shape]) -> None:
    """Curtain walls' panes unless they say that they are opaque, and whatever is of glass alone."""
    for piece in pieces:
        pane = piece.ifc_class.startswith(PANES) and not ifc_glazing.says_opaque(piece.materials)
        if pane or ifc_states.says_glass_only(piece.materials):
            for passage in ifc_passages.of_panes([shell[piece.name]]):
                _add(context, passage, piece, b.WINDOW, b.GLASS)


def _add_holes(context: Context, parts: Sequence[OpenPart], blockers: Blockers) -> None:
    """Where a room is open to what no room claims, and the next room begins right behind: an unfilled hole of wall or slab."""
    for part in parts:
        if part.other >= 0 or not _is_hole(part) or any(_covered(p, part) for p in context.passages.values()):
            continue
        solid = context.solids[part.room]
        middle = part.polygon.mean(axis=0)
        normal = np.cross(part.polygon[1] - part.polygon[0], part.polygon[2] - part.polygon[0])
        normal /= max(float(np.linalg.norm(normal)), 1e-12)
        if polyhedra.inside((middle + 1e-3 * normal)[None], solid)[0]:
            normal = -normal
        depth = _next_room(context, part.room, middle, normal, blockers)
        if depth > 0.0:
            frame = Frame.along(normal, middle, part.polygon[1] - part.polygon[0])
            section = ifc_passages.section_of(frame, part.polygon)
            if section:
                passage = Passage(frame, section, (0.0, depth), (0.0, depth))
                names = [context.rooms[part.room].name]
                add_passage(context, passage, f"Hole of {names[0]}", b.HOLE, b.OPEN, "")


def _is_hole(part: OpenPart) -> bool:
    extent = np.ptp(part.polygon, axis=0)
    level = extent[2] < 0.3 * max(extent[0], extent[1])
    whole = part.area > 0.8 * polygon_area(part.polygon)  # no strips along a wall's edges with the wall between them
    return whole and part.area >= LEAST_HOLE and (level or extent[2] >= LOWEST_HOLE)


def _next_room(context: Context, room: int, start: np.ndarray, normal: np.ndarray, blockers: Blockers) -> float:
    """How far ahead another room begins with nothing drawn before it, metres; 0: none within THICKEST."""
    end = start + THICKEST * normal
    hit = float(blockers.first_hit((start + 1e-3 * normal)[None], end[None])[0]) * THICKEST
    steps = np.arange(0.02, min(THICKEST, hit), 0.02)
    points = start + steps[:, None] * normal
    nearest = np.inf
    for j, solid in enumerate(context.solids):
        if j == room or not len(points) or (solid.low > points.max(axis=0)).any() or (solid.high < points.min(axis=0)).any():
            continue
        held = polyhedra.inside(points, solid)
        if held.any():
            nearest = min(nearest, float(steps[np.argmax(held)]))
    return nearest if np.isfinite(nearest) else 0.0


def _covered(passage: Passage, part: OpenPart) -> bool:
    """Whether a passage that is known already goes through the middle of it: from the room on the other side, most often."""
    u, v, t = passage.frame.local(part.polygon.mean(axis=0)[None])[0]
    return passage.void[0] - REACH < t < passage.void[1] + REACH and ifc_passages.cp.contains(passage.section, (u, v))


def _holds(void: Shape, filler: Shape) -> bool:
    """Whether a void's bounds hold most of a filler's."""
    low, high = void.world.min(axis=0), void.world.max(axis=0)
    f_low, f_high = filler.world.min(axis=0), filler.world.max(axis=0)
    shared = np.maximum(np.minimum(high, f_high) - np.maximum(low, f_low), 0.0)
    return bool(np.prod(shared) > OWN_MEMBER * np.prod(np.maximum(f_high - f_low, 1e-3)))


def _fans(faces: Sequence[Sequence[int]]) -> np.ndarray:
    return np.array([(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)], dtype=np.int64).reshape(-1, 3)
