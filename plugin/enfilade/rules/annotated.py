# SPDX-License-Identifier: GPL-3.0-or-later
"""Annotated shapes (rooms and openings somebody marked in the scene) to a Building.

Plain numpy, no bpy: `scene/extract_annotated.py` reads the marks, this decides what they mean. The convention stands
in plugin/README.md. Whatever is doubtful becomes a Problem with a remedy; nothing is repaired silently.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from . import building as b
from .passage import FAR_REACH, OUTDOORS, RoomIndex, find_passage, shape_passage, thin_sides
from .shapes import (
    FLAT,
    Solid,
    convex_polygon,
    flatness,
    open_edges,
    planarise,
    polygon_area,
    signed_volume,
    weld,
)

ROOM, EXTERIOR, IGNORE = "room", "exterior", "ignore"
OPENING_KINDS = {"door": b.DOOR, "window": b.WINDOW, "hole": b.HOLE, "portal": b.HOLE, "virtual": b.VIRTUAL}
ROLES = (ROOM, EXTERIOR, IGNORE, *OPENING_KINDS)
DEFAULT_STATE = {b.DOOR: b.OPEN, b.WINDOW: b.GLASS, b.HOLE: b.OPEN, b.VIRTUAL: b.OPEN}
_PREFIX = re.compile(r"^(room|exterior|door|window|hole|portal)[_./ ]", re.IGNORECASE)
# Metres of wall that a vertical way through counts as more: doors stand upright, roof windows exist, holes lie in slabs.
VERTICAL_COST = {b.DOOR: 10.0, b.WINDOW: 0.5, b.HOLE: 0.0, b.VIRTUAL: 0.0}
DRAW_IT = "Draw the passage as a box or a plane; an empty must be displayed as a cube."
# Metres that a flat opening may stand beside its wall: one drawn by eye, or on the face of a wall drawn thicker.
STRAY = 0.15
# Floors nearer than this belong to one storey (metres): steps and split levels below half a flight of stairs.
SAME_STOREY = 1.0


@dataclass
class Shape:
    """One annotated object or collection.

    vertices: float64 (n, 3), world metres. faces: corner indices, counter-clockwise from outside once the volume is
    positive (a mirrored object comes inside out and is turned here). None: the convex hull of the vertices.
    """

    name: str
    role: str
    vertices: np.ndarray
    faces: list[list[int]] | None = None
    state: str = ""
    rooms: list[str] = field(default_factory=list)  # names of the rooms it must join
    storey: str = ""
    long_name: str = ""
    source_id: str = ""
    place: tuple[float, float, float] | None = None  # where it stands, of what has no geometry to tell it


def role_of(name: str, value: object = None) -> str:
    """The role of an object or collection from its custom property (wins) or its name; "" for none.

    An unknown property value counts as none here; the caller reports it.
    """
    if value is not None and str(value).strip():
        role = str(value).strip().lower()
        return role if role in ROLES else ""
    match = _PREFIX.match(name)
    return match.group(1).lower() if match else ""


def label_of(name: str, role: str) -> str:
    """What a person calls it: the name without the prefix that marks it ("Room_Hall" -> "Hall")."""
    match = _PREFIX.match(name)
    if match and match.group(1).lower() == role and len(name) > match.end():
        return name[match.end() :]
    return name


def build(shapes: Sequence[Shape], problems: Sequence[b.Problem] = ()) -> b.Building:
    """Rooms, openings and storeys from annotated shapes; objects, lights and cameras are the caller's to add."""
    out = b.Building(source="annotated", problems=list(problems))
    solids: list[Solid | None] = []
    names: dict[str, int] = {}
    for shape in shapes:
        if shape.role == ROOM:
            solid = _add_room(out, shape)
            solids.append(solid)
            for key in (shape.name, label_of(shape.name, ROOM), shape.long_name):
                if key:
                    names.setdefault(key.lower(), len(out.rooms) - 1)
    exterior_names = [s for s in shapes if s.role == EXTERIOR]
    index = RoomIndex(solids)
    outdoors: list[int] = []
    for shape in shapes:
        if shape.role in OPENING_KINDS:
            opening = _add_opening(out, shape, index, names)
            if opening.rooms is not None and OUTDOORS in opening.rooms:
                outdoors.append(len(out.openings) - 1)
    if outdoors or exterior_names:
        exterior = len(out.rooms)
        first = exterior_names[0] if exterior_names else None
        out.rooms.append(
            b.Room(
                name=label_of(first.name, EXTERIOR) if first else "Exterior",
                kind=b.EXTERIOR,
                source_id=first.source_id if first else "",
            )
        )
        for i in outdoors:
            a, c = out.openings[i].rooms
            out.openings[i].rooms = (exterior if a == OUTDOORS else a, exterior if c == OUTDOORS else c)
    name_storeys(out)
    if not any(r.kind == b.INTERIOR for r in out.rooms):
        out.problems.append(
            b.Problem(
                b.ERROR,
                "no-rooms",
                "No room is marked in this scene.",
                remedy='Give a closed mesh of each room\'s air the custom property enfilade = "room", or name it Room_...',
            )
        )
    return out


def _add_room(out: b.Building, shape: Shape) -> Solid | None:
    label = label_of(shape.name, ROOM)
    room = b.Room(name=label, storey=shape.storey, source_id=shape.source_id or shape.name, long_name=shape.long_name)
    out.rooms.append(room)
    vertices = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
    if len(vertices) < 4 or not np.isfinite(vertices).all() or flatness(vertices)[0] < FLAT:
        out.problems.append(
            b.Problem(
                b.ERROR,
                "room-without-volume",
                f"Room {label} has no volume ({len(vertices)} corners).",
                [shape.name],
                tuple(vertices.mean(axis=0)) if len(vertices) and np.isfinite(vertices).all() else None,
                "Draw the room's air as a closed mesh.",
            )
        )
        # keep the slot: indices of rooms stay those of the shapes, and the core is given nothing
        return None
    faces = shape.faces
    if faces:
        vertices, faces = weld(vertices, faces)
        faces = planarise(vertices, faces)
        missing = open_edges(faces)
        if missing:
            out.problems.append(
                b.Problem(
                    b.WARNING,
                    "room-not-closed",
                    f"Room {label}: {missing} edges of its mesh lack a neighbour; its convex hull is used instead.",
                    [shape.name],
                    tuple(vertices.mean(axis=0)),
                    "Close the mesh (Mesh > Clean Up > Fill Holes) and recalculate normals outside.",
                )
            )
        elif signed_volume(vertices, faces) < 0.0:
            faces = [face[::-1] for face in faces]
    room.vertices = vertices
    room.faces = faces if faces else None
    return Solid(vertices, faces) if faces else None


def _add_opening(out: b.Building, shape: Shape, index: RoomIndex, names: dict[str, int]) -> b.Opening:
    kind = OPENING_KINDS[shape.role]
    label = label_of(shape.name, shape.role)
    state = shape.state.strip().lower()
    if state not in (b.OPEN, b.CLOSED, b.GLASS):
        if state:
            out.problems.append(
                b.Problem(
                    b.WARNING,
                    "unknown-state",
                    f'{shape.name}: enfilade_state "{shape.state}" is none of open, closed, glass; '
                    f"taken as {DEFAULT_STATE[kind]}.",
                    [shape.name],
                )
            )
        state = DEFAULT_STATE[kind]
    opening = b.Opening(name=label, kind=kind, state=state, source_id=shape.source_id or shape.name)
    out.openings.append(opening)
    points = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
    if len(points) < 3 or not np.isfinite(points).all():
        _opening_problem(out, shape, "opening-without-shape", f"{shape.name} has no shape.", DRAW_IT)
        return opening
    wanted = _wanted_rooms(out, shape, names)
    thickness, normal = flatness(points)
    bent = thickness >= FLAT  # a sheet all the same, when it has no inside
    if not bent or (thickness < STRAY and shape.faces and open_edges(shape.faces)):
        polygon = convex_polygon(points, normal)
        if len(polygon) < 3 or polygon_area(polygon) < FLAT * FLAT:
            _opening_problem(out, shape, "opening-without-shape", f"{shape.name} has no area.", DRAW_IT)
            return opening
        sides = None if bent else thin_sides(polygon, index, wanted)
        if sides is not None and sides[0] != sides[1]:
            opening.polygon, opening.rooms = polygon, sides
            return opening
        points, faces = _thickened(polygon, normal, STRAY + 0.5 * thickness)
        stray = find_passage(points, faces, index, wanted, VERTICAL_COST[kind])
        if stray is None or stray.rooms[0] == stray.rooms[1] or abs(float(stray.axis @ normal)) < 0.9:
            return _nowhere(out, shape, opening) if sides is None else _one_room(out, shape, opening, sides[0])
        told = (
            ("opening-bent", f"{shape.name} is bent by {thickness:.3f} m; it was taken flat.", "Flatten it: Check Marks offers to, within its tolerance.")
            if bent
            else ("opening-beside-wall", f"{shape.name} stands beside the wall that it leads through; it was moved there.",
                  "Move it into the wall, or draw the passage as a box.")
        )
        _opening_problem(out, shape, *told, b.INFO)
        shape = replace(shape, vertices=points, faces=faces)

    passage = find_passage(points, shape.faces, index, wanted, VERTICAL_COST[kind])
    if passage is None:
        return _nowhere(out, shape, opening)
    if passage.rooms[0] == passage.rooms[1]:
        return _one_room(out, shape, opening, passage.rooms[0])
    if wanted is not None and set(passage.rooms) - {OUTDOORS} != wanted - {OUTDOORS}:
        _opening_problem(
            out,
            shape,
            "opening-other-rooms",
            f"{shape.name} touches only one of the rooms that enfilade_rooms names.",
            "Move the opening so that it reaches both rooms, or correct enfilade_rooms.",
        )
    if passage.reach >= FAR_REACH:
        _opening_problem(
            out,
            shape,
            "opening-gap",
            f"{shape.name} ends more than 0.3 m before a room; it was lengthened to reach it.",
            "Let the opening's body touch the rooms on both sides.",
        )
    shaped = shape_passage(points, passage)
    opening.rooms = passage.rooms
    if shaped is not None:
        opening.body, opening.ends = shaped
    else:
        opening.polygon = _middle_section(points, passage.axis, passage.planes)
    return opening


def _thickened(polygon: np.ndarray, normal: np.ndarray, by: float) -> tuple[np.ndarray, list[list[int]]]:
    """A flat opening as a body that reaches so far to both sides."""
    k = len(polygon)
    points = np.concatenate([polygon - by * normal, polygon + by * normal])
    sides = [[i, (i + 1) % k, k + (i + 1) % k, k + i] for i in range(k)]
    return points, [list(range(k))[::-1], list(range(k, 2 * k)), *sides]


def _middle_section(points, axis, planes) -> np.ndarray:
    """The body's shadow along the axis, in the plane where the two rooms meet: never smaller than the passage."""
    offset = None
    for plane, sign in zip(planes, (-1.0, 1.0), strict=True):
        if plane is not None:
            normal, d = plane
            offset = d * sign / max(float(normal @ (sign * axis)), 0.5)
    if offset is None:
        offset = float((points @ axis).mean())
    flat = points + (offset - points @ axis)[:, None] * axis
    return convex_polygon(flat, axis)


def _wanted_rooms(out, shape, names) -> set[int] | None:
    if not shape.rooms:
        return None
    wanted: set[int] = set()
    for name in shape.rooms:
        if name.lower() in ("exterior", "outside", "outdoors", ""):
            wanted.add(OUTDOORS)
        elif name.lower() in names:
            wanted.add(names[name.lower()])
        else:
            _opening_problem(
                out, shape, "unknown-room", f'{shape.name}: enfilade_rooms names "{name}", which is no room.',
                "Use the rooms' names, separated by semicolons.",
            )
            return None
    return wanted


def _opening_problem(out, shape, code, message, remedy, severity=b.WARNING) -> None:
    points = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
    where = tuple(float(x) for x in points.mean(axis=0)) if len(points) and np.isfinite(points).all() else shape.place
    out.problems.append(b.Problem(severity, code, message, [shape.name], where, remedy))


def _nowhere(out, shape, opening) -> b.Opening:
    _opening_problem(
        out, shape, "opening-no-room", f"{shape.name} is within 1 m of no room; it joins nothing.",
        "Move it between two rooms, or mark the room it belongs to.",
    )
    return opening


def _one_room(out, shape, opening, room: int) -> b.Opening:
    if room == OUTDOORS:
        return _nowhere(out, shape, opening)
    _opening_problem(
        out, shape, "opening-same-room",
        f"{shape.name} lies inside {out.rooms[room].name} alone (a partition's door, say); sight needs no portal there.",
        "Split the room there if it should be two.", b.INFO,
    )
    return opening


def name_storeys(out: b.Building) -> None:
    """Rooms without a storey get one by the height of their floor; storeys are listed from below."""
    floors: dict[str, float] = {}
    nameless: list[tuple[float, int]] = []
    for i, room in enumerate(out.rooms):
        if room.vertices is None or len(room.vertices) == 0:
            continue
        z = float(room.vertices[:, 2].min())
        if room.storey:
            floors[room.storey] = min(z, floors.get(room.storey, np.inf))
        else:
            nameless.append((z, i))
    levels: list[tuple[float, list[int]]] = []
    for z, i in sorted(nameless):
        near = [name for name, floor in floors.items() if abs(floor - z) < SAME_STOREY]
        if near:
            out.rooms[i].storey = near[0]
        elif levels and z - levels[-1][0] < SAME_STOREY:
            levels[-1][1].append(i)
        else:
            levels.append((z, [i]))
    for n, (z, members) in enumerate(levels):
        name = f"Level {n}"
        floors[name] = z
        for i in members:
            out.rooms[i].storey = name
    out.storeys = sorted(floors.items(), key=lambda item: item[1])
