# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings of a scene that draws an IFC model whose file isn't at hand: objects named `IfcSpace/...`, `IfcDoor/...`.

Names and meshes are all there is, so a door's or window's own box is its passage (lengthened to the rooms at both ends),
and what stands open between spaces is found from the walls and slabs as drawn. The file, when there is one, tells more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from . import annotated, ifc_boundaries, ifc_states, polyhedra
from . import building as b
from .blockers import Blockers
from .ifc_openings import Context
from .ifc_shapes import Shape

SPACES = ("IfcSpace",)
FILLERS = {"IfcDoor": b.DOOR, "IfcDoorStandardCase": b.DOOR, "IfcWindow": b.WINDOW, "IfcWindowStandardCase": b.WINDOW}
VOIDS = ("IfcOpeningElement", "IfcOpeningStandardCase")
SHELL = ("IfcWall", "IfcSlab", "IfcRoof", "IfcCovering", "IfcColumn", "IfcBeam", "IfcMember", "IfcPlate", "IfcCurtainWall",
         "IfcFooting", "IfcBuildingElement", "IfcChimney", "IfcShadingDevice")  # fmt: skip
OWN_MEMBER = 0.5  # of a filler's box that lies in a void for the void to be its passage


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
    def world(self) -> np.ndarray:
        return self.local @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    @property
    def triangles(self) -> np.ndarray:
        return np.array([(f[0], f[i], f[i + 1]) for f in self.faces for i in range(1, len(f) - 1)], dtype=np.int64).reshape(-1, 3)


def build(pieces: Sequence[Piece], progress: Callable[[float, str], bool] | None = None) -> b.Building:
    """The building; its problems say what a file would have told better."""
    by_class = {c: [p for p in pieces if p.ifc_class == c and len(p.local) > 3] for c in {p.ifc_class for p in pieces}}
    voids = [p for c in VOIDS for p in by_class.get(c, [])]
    shapes = [_room(p) for c in SPACES for p in by_class.get(c, [])]
    used: set[str] = set()
    for name, kind in FILLERS.items():
        for piece in by_class.get(name, []):
            void = next((v for v in voids if v.name not in used and _holds(v, piece)), None)
            if void is not None:
                used.add(void.name)
            shapes.append(_opening(piece, void or piece, kind, b.GLASS if kind == b.WINDOW else b.OPEN))
    shapes += [_opening(v, v, b.HOLE, b.OPEN) for v in voids if v.name not in used]
    out = annotated.build(shapes)
    out.source = "ifc scene"
    out.problems = [p for p in out.problems if p.code != "no-rooms"]
    _add_boundaries(out, [p for p in pieces if p.ifc_class.startswith(SHELL)], progress)
    return out


def _room(piece: Piece) -> annotated.Shape:
    solid = polyhedra.build(piece.world, piece.triangles)  # as the file's reader does: Bonsai's meshes are triangles
    faces = [list(loop) for loop in solid.loops] if solid.closed else piece.faces
    return annotated.Shape(piece.label, annotated.ROOM, solid.vertices if solid.closed else piece.world, faces,
                           storey=piece.storey, source_id=piece.global_id or piece.name)  # fmt: skip


def _opening(piece: Piece, shape: Piece, kind: str, state: str) -> annotated.Shape:
    low, high = shape.local.min(axis=0), shape.local.max(axis=0)
    corners = np.array([(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    world = corners @ shape.matrix[:3, :3].T + shape.matrix[:3, 3]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return annotated.Shape(piece.label, kind, world, faces, state, storey=piece.storey, source_id=piece.global_id or piece.name)


def _holds(void: Piece, filler: Piece) -> bool:
    """Whether a void's bounds hold most of a filler's."""
    low, high = void.world.min(axis=0), void.world.max(axis=0)
    f_low, f_high = filler.world.min(axis=0), filler.world.max(axis=0)
    shared = np.maximum(np.minimum(high, f_high) - np.maximum(low, f_low), 0.0)
    return bool(np.prod(shared) > OWN_MEMBER * np.prod(np.maximum(f_high - f_low, 1e-3)))


def _add_boundaries(out: b.Building, shell: list[Piece], progress: Callable[[float, str], bool] | None) -> None:
    rooms = [i for i, r in enumerate(out.rooms) if r.kind == b.INTERIOR and r.vertices is not None and r.faces]
    if not rooms or not shell:
        return
    exterior = next((i for i, r in enumerate(out.rooms) if r.kind == b.EXTERIOR), -1)
    if exterior < 0:
        exterior = len(out.rooms)
        out.rooms.append(b.Room("Exterior", b.EXTERIOR))
    if rooms != list(range(len(rooms))):
        return  # a room without a closed shape: the numbers of rooms and solids would part
    solids = [polyhedra.build(r.vertices, _fans(r.faces)) for r in (out.rooms[i] for i in rooms)]
    blockers = Blockers([
        Shape(SimpleNamespace(id=lambda n=n: n), p.name, p.local, p.triangles, p.matrix) for n, p in enumerate(shell)
    ])  # fmt: skip
    context = Context(out.rooms, solids, exterior, {}, ifc_states.DoorStates(), out.openings, out.problems, [])
    ifc_boundaries.add(context, blockers, progress)


def _fans(faces: Sequence[Sequence[int]]) -> np.ndarray:
    return np.array([(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)], dtype=np.int64).reshape(-1, 3)
