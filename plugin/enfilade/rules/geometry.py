# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings from geometry alone: no spaces, no marks.

Two modes. *classes*: it is known what is a wall, a door, a window (from IFC classes or from names): openings are shut as bodies. *triangles*:
nothing but triangles, a polygon soup even: openings are told by lintels and jambs. Then, in a frame turned to the walls' main direction, on a grid of
10 cm: floors found, holes in them capped, air told apart storey by storey and grown back, rooms put on the planes of walls, and
each opening probed for the two rooms it joins. Everything errs to open: a doubtful wall is an opening, no contact is lost.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import (
    geometry_contacts,
    geometry_frame,
    geometry_grid,
    geometry_holes,
    geometry_ifc,
    geometry_leaves,
    geometry_rooms,
    geometry_soup,
    ifc_neighbours,
    ifc_openings,
    ifc_states,
)
from .building import (
    DOOR,
    ERROR,
    EXTERIOR,
    GLASS,
    HOLE,
    INFO,
    OPEN,
    VIRTUAL,
    WARNING,
    WINDOW,
    Building,
    Opening,
    Problem,
    Room,
)
from .geometry_elements import FURNITURE, OPENINGS, SHELL, SITE, STAIR, UNKNOWN, Element, soup
from .geometry_grid import CLOSED, OUTSIDE, SOLID, Grid
from .geometry_pace import Cancelled, Estimate, Progress, Stages
from .probing import Frame, Passage

__all__ = ["CLASSES", "TRIANGLES", "Cancelled", "Element", "GeometryError", "detect", "elements_of_ifc", "read_ifc", "soup"]

CLASSES, TRIANGLES = "classes", "triangles"
TALLEST = 200.0  # m: what is higher and doesn't fit the grid is drawn in other units
HALL = 6.0  # m: higher than that are few rooms of a building, or its unit is no metre
STANDING = 0.5  # m2: nobody stands in what has less floor
FRAME = 0.2  # m between a leaf and the wall around it
REVEAL = 0.6  # m of wall beside a leaf, on either side
LEAST_DOORS = 1  # openings that must be classed before names are believed
DEFAULT_STATE = {DOOR: OPEN, WINDOW: GLASS, HOLE: OPEN}


class GeometryError(ValueError):
    """Nothing can be found in this geometry; the message says why."""


def elements_of_ifc(path: str | os.PathLike[str], furniture: bool = False, mode: str = CLASSES) -> list[Element]:
    """What a file draws, as elements; its spaces aren't read. furniture: whether it is kept (mode TRIANGLES)."""
    from . import ifc
    from .ifc_placement import model_offset
    from .ifc_units import length_unit

    model = ifc.open_model(path)
    offset = model_offset(model, length_unit(model))
    if mode == CLASSES:
        return geometry_ifc.classed(model, offset, ifc_states.DoorStates())
    return [e for e in geometry_ifc.drawn(model, offset) if furniture or e.kind not in (FURNITURE, SITE)]


def mode_of(elements: Sequence[Element]) -> str:
    """CLASSES when walls and at least one opening are told by name or class, else TRIANGLES."""
    shell = sum(e.kind == SHELL for e in elements)
    openings = sum(e.kind in OPENINGS for e in elements)
    unknown = sum(len(e.triangles) for e in elements if e.kind == UNKNOWN)
    known = sum(len(e.triangles) for e in elements if e.kind == SHELL)
    return CLASSES if shell and openings >= LEAST_DOORS and known >= unknown else TRIANGLES


def detect(
    elements: Sequence[Element],
    *,
    mode: str = "auto",
    progress: Callable[[float, str], bool] | None = None,
    native: Any = None,
) -> Building:
    """The building in these elements. mode: "auto", CLASSES or TRIANGLES. progress(fraction, label) -> False raises Cancelled."""
    from .. import native as native_module

    native = native or native_module.load()
    if mode == "auto":
        mode = mode_of(elements)
    elements = [e for e in elements if len(e.vertices) and (len(e.triangles) or e.passage is not None)]
    for e in elements:
        if not np.isfinite(e.vertices).all():
            raise GeometryError(f"{e.name or 'the mesh'} has corners that aren't finite numbers")
    shell = [e for e in elements if e.kind in (SHELL, UNKNOWN)]
    if not shell:
        raise GeometryError("there are no walls: nothing in this geometry can part rooms")
    turn = geometry_frame.main_direction(e.mesh for e in shell)
    rotation = geometry_frame.rotation(-turn)
    corners = np.concatenate([e.vertices for e in shell])
    middle = np.round(0.5 * (corners.min(axis=0) + corners.max(axis=0)))
    offset = -(rotation @ middle)
    elements = [e.moved(rotation, offset) for e in elements if e.kind not in (FURNITURE, SITE, STAIR)]
    told, words = _told(elements)
    stages = Stages(progress, told)
    watch = stages.begin("pieces", words)
    if mode == TRIANGLES:
        soups = [geometry_soup.judged(native, e, watch) for e in watch.over(elements)]
        elements = [e for s in soups for e in s.shell]
    shell = [e for e in elements if e.kind in (SHELL, UNKNOWN)]
    if not shell:
        raise GeometryError(f"all of it is thin or low, {_extent(corners)}: nothing in this geometry can part rooms. See that a unit is a metre")
    building = Building(source="geometry")
    grid = _grid(shell, building)
    watch = stages.begin("voxels")
    geometry_grid.mark(native, grid, (e.mesh for e in watch.over(shell, 0.0, 0.4)), SOLID)
    watch.at(0.4)
    geometry_grid.fill_hollows(native, grid, watch)
    watch = stages.begin("openings")
    lower, upper = geometry_grid.wall_edges(e.mesh for e in shell)
    if mode == TRIANGLES:
        grid.levels = geometry_grid.wall_bases(lower)
        elements += [e for s in soups for e in geometry_leaves.settle(native, grid, s, watch)]
    loose = [part for e in elements if e.kind in OPENINGS for part in ([e] if e.passage is not None else geometry_soup.parts_of(e))]
    passages = [(e, e.passage or passage_of_mesh(e)) for e in loose]
    passages = [(e, p if e.passage is not None else through_wall(grid, p)) for e, p in watch.over(passages, 0.5) if p is not None]
    for _, p in passages:
        _shut(native, grid, p)
    stages.begin("levels")
    triangles = np.concatenate([e.vertices[e.triangles] for e in shell if len(e.triangles)])
    geometry_grid.close_levels(native, grid, lower, upper, geometry_grid.floor_faces(triangles))
    planes = geometry_rooms.Planes(triangles, [level for level, _ in grid.caps])
    passages = [(e, p if e.passage is not None else planes.through_wall(p, grid.step)) for e, p in passages]
    watch = stages.begin("holes")
    if mode == TRIANGLES:
        holes = geometry_holes.find(native, grid, planes, watch)
        passages += [(e, e.passage) for e in holes]
        for number, (e, _) in enumerate(passages, 1):
            e.name = e.name or f"{e.kind.title()} {number}"
    labels, count = geometry_grid.regions(native, grid, stages.begin("regions"))
    made = geometry_rooms.shapes(native, grid, labels, count, planes, stages.begin("shapes"))
    _fill(native, building, grid, labels, made, passages, stages.begin("rooms joined"))
    voids = _tell_voids(building, made)
    _tell_scale(building, made)
    stages.close()
    _move_back(building, rotation, offset)
    building.statistics = {
        **{f"{k} s": v for k, v in stages.spent.items()},
        "told s": sum(told.seconds.values()),
        "told MiB": told.bytes / 2**20,
        "turned degrees": turn,
        "step m": grid.step,
        "voxels": float(grid.blocked.size),
        "regions": float(count - OUTSIDE),
        "voids": float(voids),
    }
    words = "the classes of the elements" if mode == CLASSES else "triangles alone"
    building.problems.insert(
        0, Problem(INFO, "geometry-mode", f"rooms were found from {words}: {len(made) - voids} rooms on a grid of {grid.step:.2f} m, "
                   f"turned by {turn:.2f} degrees; {len(grid.caps)} levels with holes closed by horizontal portals")
    )  # fmt: skip
    if not made:
        building.problems.append(
            Problem(ERROR, "no-rooms", f"no air in this geometry, {_extent(corners)}, is shut in by walls",
                    remedy="see that z is up and a unit is a metre; or mark the rooms by hand")
        )  # fmt: skip
    return building


def _extent(corners: np.ndarray) -> str:
    return f"{' x '.join(f'{x:.3g}' for x in np.ptp(corners, axis=0))} m in x, y and z"


def _bounds(shell: list[Element]) -> tuple[np.ndarray, np.ndarray]:
    return np.min([e.vertices.min(axis=0) for e in shell], axis=0), np.max([e.vertices.max(axis=0) for e in shell], axis=0)


def _told(elements: list[Element]) -> tuple[Estimate, str]:
    """What the search will take, from the extent and the triangles of all that may part rooms, before anything is made."""
    step, shape = geometry_grid.plan(*_bounds([e for e in elements if e.kind in (SHELL, UNKNOWN)]))
    triangles = sum(len(e.triangles) for e in elements)
    told = Estimate.of(float(np.prod([float(n) for n in shape])), triangles, sum(e.kind in OPENINGS for e in elements))
    return told, f"{triangles:,} triangles, a grid of {step:.2f} m, {told.words}"


def _grid(shell: list[Element], building: Building) -> Grid:
    low, high = _bounds(shell)
    step, shape = geometry_grid.plan(low, high)
    voxels = float(np.prod([float(n) for n in shape]))
    if voxels > 4.0 * geometry_grid.MOST_VOXELS:
        raise GeometryError(
            f"{high[0] - low[0]:.0f} x {high[1] - low[1]:.0f} x {high[2] - low[2]:.0f} m need {Estimate.of(voxels, 0).bytes / 1e9:.1f} GB at {step:.2f} m: "
            + ("scale it, if a unit is a millimetre or a centimetre" if high[2] - low[2] > TALLEST else
               "hide what isn't part of the building (terrain, surroundings), or work on one building at a time")
        )  # fmt: skip
    if step > geometry_grid.STEP:
        building.problems.append(
            Problem(WARNING, "coarse-grid", f"the building is so large that its grid is {step:.2f} m instead of {geometry_grid.STEP:.2f} m: "
                    "thin rooms may be lost", remedy="work on one part at a time")
        )  # fmt: skip
    return geometry_grid.make(low, high)


def passage_of_mesh(e: Element) -> Passage | None:
    """The way through a door or window that is only known by its mesh: across its thinner horizontal side; a flat one lies in a roof or floor."""
    points = e.vertices
    size = np.ptp(points, axis=0)
    from . import convex_polygons as cp

    if size[2] < 0.5 * min(size[0], size[1]):
        axis = np.array([0.0, 0.0, 1.0])
    else:
        outline = np.array(cp.hull((x, y) for x, y, _ in points))
        if len(outline) < 3:
            edge = outline[-1] - outline[0]
            axis = np.array([-edge[1], edge[0], 0.0])
        else:
            best = None
            for k in range(len(outline)):
                d = outline[k] - outline[k - 1]
                length = np.hypot(*d)
                if length < 1e-6:
                    continue
                d = d / length
                u, v = np.ptp(outline @ d), np.ptp(outline @ np.array([-d[1], d[0]]))
                normal = np.array([-d[1], d[0], 0.0]) if v <= u else np.array([d[0], d[1], 0.0])
                if best is None or u * v < best[0] - 1e-6:
                    best = (u * v, normal)
            axis = best[1] if best else np.array([1.0, 0.0, 0.0])
    frame = Frame.along(axis, 0.5 * (points.min(axis=0) + points.max(axis=0)))
    local = frame.local(points)
    section = cp.grow(cp.hull((x, y) for x, y, _ in local), 0.02)
    if len(section) < 3:
        return None
    reach = (float(local[:, 2].min()), float(local[:, 2].max()))
    return Passage(frame, cp.limit_corners(section, 8), reach, reach)


def through_wall(grid: Grid, p: Passage) -> Passage:
    """A leaf's passage lengthened through the wall that its sides stand in, at most REVEAL each way.

    The wall goes on while both jambs and the lintel do: floors go on for ever, so do walls that meet it in a corner beside the door.
    """
    low, high = np.array(p.section).min(axis=0), np.array(p.section).max(axis=0)
    sides = 4 if abs(p.frame.n[2]) > 0.5 else 3  # a skylight has no floor
    rings = []
    for off in (1.0, 2.0):  # voxels: a frame may stand between leaf and wall
        reach = off * grid.step
        across, up = np.linspace(low[0], high[0], 7)[1:-1], np.linspace(low[1], high[1], 7)[1:-1]
        rings.append([(low[0] - reach, y) for y in up] + [(high[0] + reach, y) for y in up]
                     + [(x, high[1] + reach) for x in across] + [(x, low[1] - reach) for x in across])  # fmt: skip
    host = list(p.host)
    for side, sign in ((0, -1.0), (1, 1.0)):
        for _ in range(int(REVEAL / (0.5 * grid.step))):
            t = host[side] + 0.5 * sign * grid.step
            solid = np.zeros(len(rings[0]), dtype=bool)
            for ring in rings:
                index = grid.index(p.frame.world(np.array([(x, y, t) for x, y in ring])))
                inside = grid.inside(index)
                solid[inside] |= grid.blocked[tuple(index[inside].T)] & SOLID > 0
            if (solid.reshape(4, -1)[:sides].mean(axis=1) < 0.5).any():
                break
            host[side] = t
    return Passage(p.frame, _widened(grid, p, low, high), p.void, (host[0], host[1]))


def _widened(grid: Grid, p: Passage, low: np.ndarray, high: np.ndarray) -> list[tuple[float, float]]:
    """The section as a rectangle whose sides are moved outward to the wall: over a frame, and over the voxel in which the wall begins."""
    middle = 0.5 * (p.host[0] + p.host[1])
    ends = [list(low), list(high)]
    for axis in (0, 1):
        across = np.linspace(low[1 - axis], high[1 - axis], 7)[1:-1]
        for side, sign in ((0, -1.0), (1, 1.0)):
            at = ends[side][axis]
            reach = 0.0
            while reach < FRAME:
                reach += 0.5 * grid.step
                points = np.full((len(across), 3), middle)
                points[:, axis], points[:, 1 - axis] = at + sign * reach, across
                index = grid.index(p.frame.world(points))
                index = index[grid.inside(index)]
                if len(index) and (grid.blocked[tuple(index.T)] & SOLID > 0).mean() >= 0.5:
                    break
            ends[side][axis] = at + sign * (min(reach, FRAME) + grid.step)
    (x0, y0), (x1, y1) = ends
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def _shut(native: Any, grid: Grid, p: Passage) -> None:
    """Marks the body of an opening as closed: its section swept through the host, and what lies between."""
    n = len(p.section)
    corners = p.frame.world(np.array([(x, y, t) for t in p.host for x, y in p.section]))
    fan = [(0, i, i + 1) for i in range(1, n - 1)]
    sides = [t for i in range(n) for j in [(i + 1) % n] for t in ((i, j, j + n), (i, j + n, i + n))]
    triangles = np.array(fan + [(a + n, b + n, c + n) for a, b, c in fan] + sides)
    depth = p.host[1] - p.host[0]
    vertices = [corners]
    faces = [triangles]
    # Sheets inside, a voxel apart: a thick body is closed all through.
    for k in range(1, int(depth / grid.step) + 1):
        sheet = p.frame.world(np.array([(x, y, p.host[0] + depth * k / (int(depth / grid.step) + 1)) for x, y in p.section]))
        faces.append(np.array(fan) + sum(len(v) for v in vertices))
        vertices.append(sheet)
    native.voxels.mark(grid.blocked, grid.origin, grid.step, np.concatenate(vertices), np.concatenate(faces), CLOSED)


def _fill(
    native: Any, building: Building, grid: Grid, labels: np.ndarray, made: list[geometry_rooms.Shape],
    passages: list[tuple[Element, Passage]], watch: Progress,
) -> None:  # fmt: skip
    """Rooms, storeys, openings and contacts of the building, in the work frame."""
    made.sort(key=lambda s: (round(s.floor, 1), float(s.solid.low[0]), float(s.solid.low[1])))
    room_of: dict[int, int] = {}
    levels: list[float] = []
    for number, shape in enumerate(made):
        if not levels or shape.floor - levels[-1] > 1.0:
            levels.append(shape.floor)
        building.rooms.append(
            Room(
                name=f"{'Void' if _is_void(shape) else 'Room'} {len(levels) - 1}.{number + 1:02d}", storey=f"Level {len(levels) - 1}",
                vertices=shape.solid.vertices, faces=[list(f) for f in shape.solid.loops], top=shape.top,
            )
        )  # fmt: skip
        room_of.setdefault(shape.label, number)
    building.storeys = [(f"Level {i}", z) for i, z in enumerate(levels)]
    exterior = len(building.rooms)
    building.rooms.append(Room("Exterior", EXTERIOR))
    room_of[OUTSIDE] = exterior
    context = ifc_openings.Context(
        building.rooms, [s.solid for s in made], exterior, {}, ifc_states.DoorStates(), building.openings, building.problems, []
    )
    drawn: dict[int, Passage] = {}
    for e, p in watch.over(passages, 0.0, 0.7):
        state = e.state or DEFAULT_STATE.get(e.kind, OPEN)
        first, told = len(building.openings), len(building.problems)
        ifc_openings.add_passage(context, p, e.name or e.kind, e.kind, state, e.source_id)
        joined = {r for o in building.openings[first:] for r in o.rooms or ()}
        if exterior in joined and (longer := _to_rooms(grid, labels, p, {room_of[x] for x in room_of} - joined, room_of)) is not None:
            del building.openings[first:], building.problems[told:]
            context.passages = {k: passage for k, passage in context.passages.items() if k < first}
            ifc_openings.add_passage(context, longer, e.name or e.kind, e.kind, state, e.source_id)
        drawn.update(dict.fromkeys(range(first, len(building.openings)), _as_drawn(e, p)))
    ifc_neighbours.add(context, {k: drawn[k] for k in context.passages})
    for c in geometry_contacts.find(native, grid, labels, watch):
        a, b = (room_of.get(x) for x in c.labels)
        if a is None or b is None or a == b:
            continue
        names = [building.rooms[i].name for i in (a, b)]
        where = tuple(float(x) for x in np.mean(c.ends, axis=(0, 1)))
        name = f"{'Hole' if c.cap else 'Contact'} {len(building.openings) + 1}"
        if c.cap:
            opening = Opening(name, HOLE, OPEN, rooms=(a, b), polygon=c.ends[0])
        elif exterior in (a, b):  # the outdoors end where the room does
            opening = Opening(name, VIRTUAL, OPEN, rooms=(a, b), polygon=np.mean(c.ends, axis=0))
        else:
            rooms, ends = ((a, b), c.ends) if a < b else ((b, a), c.ends[::-1])
            opening = Opening(name, VIRTUAL, OPEN, rooms=rooms, body=np.concatenate(ends), ends=ends)
        building.openings.append(opening)
        if c.area < geometry_contacts.LEAK and not c.cap:
            building.problems.append(
                Problem(WARNING, "rooms-leak", f"{names[0]} and {names[1]} meet through a gap of {c.area:.2f} m2", names, where,
                        "Close the gap in the walls, or mark an opening there.")
            )  # fmt: skip
    _tell_necks(native, building, grid, labels, room_of, watch)


def _as_drawn(e: Element, p: Passage) -> Passage:
    """A passage as wide as its opening is drawn: that of a leaf was widened to its wall. A pier between two windows stays between them."""
    leaf = passage_of_mesh(e) if e.passage is None else None
    return p if leaf is None else Passage(p.frame, leaf.section, p.host, p.host)


def _is_void(shape: geometry_rooms.Shape) -> bool:
    """Whether nobody can stand in it: the hollow over a ceiling, a shaft, a niche of what was drawn. It stays a room of the scene, so that from
    a camera in there is seen what can be."""
    return float(np.ptp(shape.solid.vertices[:, 2])) < geometry_grid.WALKABLE or shape.area < STANDING


def _tell_voids(building: Building, made: list[geometry_rooms.Shape]) -> int:
    """One line for all voids; gives how many there are."""
    voids = [(shape, room) for shape, room in zip(made, building.rooms, strict=False) if _is_void(shape)]
    voids.sort(key=lambda v: -v[0].area)
    if voids:
        low = sum(float(np.ptp(shape.solid.vertices[:, 2])) < geometry_grid.WALKABLE for shape, _ in voids)
        building.problems.append(
            Problem(INFO, "voids", f"{len(voids)} of what was found are voids in which nobody can stand, {low} of them lower than {geometry_grid.WALKABLE:.1f} m, "
                    f"the largest {voids[0][1].name} with {voids[0][0].area:.0f} m2: hollows over ceilings, shafts, niches. They count as no rooms, but what can be "
                    "seen from in there is kept", [room.name for _, room in voids], tuple(float(x) for x in voids[0][1].vertices.mean(axis=0)))
        )  # fmt: skip
    return len(voids)


def _tell_scale(building: Building, made: list[geometry_rooms.Shape]) -> None:
    """A problem when most of the rooms' floor is in rooms as high as halls: it may be drawn in feet."""
    rooms = [(shape.area, float(np.ptp(shape.solid.vertices[:, 2]))) for shape in made if not _is_void(shape)]
    high = [room for room in rooms if room[1] > HALL]
    if 2.0 * sum(area for area, _ in high) > sum(area for area, _ in rooms):
        building.problems.append(
            Problem(WARNING, "odd-scale", f"most of the rooms' floor is in rooms higher than {HALL:.0f} m, the largest is {max(high)[1]:.1f} m high",
                    remedy="If these are no halls, see that a unit is a metre (scale feet by 0.3048) and z is up.")
        )  # fmt: skip


def _to_rooms(grid: Grid, labels: np.ndarray, p: Passage, missed: set[int], room_of: dict[int, int]) -> Passage | None:
    """The passage lengthened, by REVEAL at most, to where the air beyond it is that of a room it should have met: walls may bend away
    from a straight leaf. None when there is no such room."""
    inner = 0.8 * (np.array(p.section) - np.mean(p.section, axis=0)) + np.mean(p.section, axis=0)
    ends, found = list(p.host), False
    for side, sign in ((0, -1.0), (1, 1.0)):
        for k in range(1, int(2 * REVEAL / grid.step) + 1):
            t = p.host[side] + 0.5 * sign * k * grid.step
            index = grid.index(p.frame.world(np.column_stack([inner, np.full(len(inner), t)])))
            here = labels[tuple(index[grid.inside(index)].T)]
            if (here > 0).mean() < 0.5 if len(here) else True:
                continue
            room = room_of.get(int(np.bincount(here[here > 0]).argmax()))
            if room is not None and room in missed:
                ends[side], found = t, True
            break
    reach = ends[0], ends[1]
    return Passage(p.frame, p.section, reach, reach) if found else None


def _tell_necks(native: Any, building: Building, grid: Grid, labels: np.ndarray, room_of: dict[int, int], watch: Progress) -> None:
    """Problems where rooms run together, or out into the open, through a gap too wide to be closed unasked."""
    rise = grid.count(geometry_contacts.NECK_AT)
    # The layer of each column's highest solid voxel: under it lies what has a ceiling.
    ceiling = grid.shape[0] - 1 - (grid.blocked[::-1] & SOLID > 0).argmax(axis=0)
    for label, where in watch.over(geometry_grid.boxes(native, labels, int(labels.max())), 0.8):
        if label != OUTSIDE and label not in room_of:
            continue
        name = building.rooms[room_of[label]].name
        if label == OUTSIDE:
            heights = sorted({grid.layer(level) + rise for level in grid.levels})
        else:
            heights = [min(where[0].start + rise, where[0].stop - 1)]
        for k in (k for k in heights if where[0].start <= k < where[0].stop):
            corner = np.array([where[2].start, where[1].start, k])
            covered = ceiling[where[1:]] >= k if label == OUTSIDE else None
            for at, width in geometry_contacts.necks(native, grid, labels[(k, *where[1:])] == label, corner, covered):
                what = "a room may run out into the open" if label == OUTSIDE else f"{name} may be two rooms that run together"
                building.problems.append(
                    Problem(WARNING, "rooms-leak", f"{what}: the gap is {width:.1f} m wide", [name], tuple(float(x) for x in at),
                            "Close the gap in the walls, or draw a door or a lintel there.")
                )  # fmt: skip


def _move_back(building: Building, rotation: np.ndarray, offset: np.ndarray) -> None:
    def back(points: np.ndarray | None) -> np.ndarray | None:
        return None if points is None else (points - offset) @ rotation

    for room in building.rooms:
        room.vertices = back(room.vertices)
        room.top -= float(offset[2])
    for o in building.openings:
        o.body, o.polygon = back(o.body), back(o.polygon)
        o.ends = None if o.ends is None else (back(o.ends[0]), back(o.ends[1]))
    for p in building.problems:
        if p.position is not None:
            p.position = tuple(float(x) for x in back(np.array(p.position)))
    building.storeys = [(name, z - float(offset[2])) for name, z in building.storeys]


def read_ifc(
    path: str | os.PathLike[str], *, mode: str = "auto", states: Any = None, progress: Callable[[float, str], bool] | None = None,
    model: Any = None,
) -> Building:
    """The building in an IFC file by its geometry, near the origin as `ifc.read_ifc(local=True)` has it. model: the file, opened."""
    from . import ifc
    from .ifc_placement import model_offset
    from .ifc_units import length_unit

    model = model if model is not None else ifc.open_model(path)
    offset = model_offset(model, length_unit(model))
    if mode == TRIANGLES:
        elements = [soup([e for e in geometry_ifc.drawn(model, offset) if e.kind != SITE])]
    else:
        elements = geometry_ifc.classed(model, offset, ifc_states.DoorStates.of(states))
    building = detect(elements, mode=mode, progress=progress)
    building.offset = tuple(float(x) for x in offset)
    return building
