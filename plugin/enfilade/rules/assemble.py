# SPDX-License-Identifier: GPL-3.0-or-later
"""Building to native scene: the core cuts rooms into cells, thick openings become cells with two portals.

Plain Python and numpy. Rooms, openings, objects, lights and cameras keep their indices: room i of the building is room i
of the scene. An object that can't go in (bounds not finite) is left out and always counts as visible.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from . import core_problems
from .building import ERROR, EXTERIOR, INFO, WARNING, Building, Problem, Room
from .results import Cells
from .shapes import plane_basis, unit

NONE = 0xFFFFFFFF


class AssemblyError(RuntimeError):
    """The core refused the building. `problems` says why, in names."""

    def __init__(self, message: str, problems: list[Problem]):
        super().__init__(message)
        self.problems = problems


@dataclass
class Assembled:
    building: Building
    scene: Any  # enfilade_native.Scene, committed
    room_cells: list[list[int]]  # cells of each room
    opening_cells: list[int | None]  # the cell of a thick opening
    native_objects: np.ndarray  # int64 (building objects,): index in the scene, -1: left out
    building_objects: np.ndarray  # int64 (scene objects,): index in the building
    problems: list[Problem] = field(default_factory=list)  # the building's and the core's
    seconds: float = 0.0
    # room and opening that a core problem is about, by id() of the problem
    blame: dict[int, tuple[int | None, int | None]] = field(default_factory=dict)

    @cached_property
    def left_out(self) -> list[int]:
        """Building objects that the core doesn't know, ascending."""
        return np.flatnonzero(self.native_objects < 0).tolist()


def assemble(native: Any, building: Building) -> Assembled:
    """Builds and commits. AssemblyError when nothing can be made of it; lesser trouble is in `.problems`.

    A room or an opening that the core refuses doesn't spoil the rest: such a room counts as part of whatever is in no
    room (so everything that opens into it stays in sight), such an opening as a flat rectangle that contains it.
    """
    begin = time.perf_counter()
    refused = _Refused()
    outdoors = True
    for _ in range(MOST_TRIES):
        made, error = _try(native, building, refused, outdoors)
        if error is not None and outdoors:
            # Cells round a building whose parts lie oddly may fit no facade: one cell for all that is outside always does.
            outdoors = False
            made, error = _try(native, building, refused, outdoors)
        if error is None:
            made.seconds = time.perf_counter() - begin
            return made
        if not refused.learn(building, made):
            raise AssemblyError(f"The core refuses this building: {error}", made.problems) from error
    raise AssemblyError("The core refuses this building, however it is simplified.", made.problems)


# Each try can only find what the one before hid: shapes first, then how they lie together.
MOST_TRIES = 8


@dataclass
class _Refused:
    rooms: set[int] = field(default_factory=set)
    openings: set[int] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)

    def learn(self, building: Building, made: Assembled) -> bool:
        """Takes the core's errors in. False: nothing new, another try would end alike."""
        before = len(self.rooms) + len(self.openings)
        for p in made.problems:
            if p.severity != ERROR or not p.code.startswith("core-"):
                continue
            room, opening = made.blame.get(id(p), (None, None))
            if opening is not None and opening not in self.openings:
                self.openings.add(opening)
                what = f"{building.openings[opening].name} is simplified to a rectangle"
            elif opening is not None and (side := self._smaller(building, opening)) is not None:
                # Even the rectangle is refused: the rooms lie so that no polygon leads from one to the other.
                self.rooms.add(side)
                what = f"Room {building.rooms[side].name} counts as outdoors because of {building.openings[opening].name}"
            elif room is not None and room not in self.rooms and building.rooms[room].vertices is not None:
                self.rooms.add(room)
                what = f"Room {building.rooms[room].name} counts as outdoors"
            else:
                continue
            self.problems.append(
                Problem(ERROR, "shape-refused", f"{what}: {p.message}", p.names, p.position, "Mend its shape and detect again.")
            )
        return len(self.rooms) + len(self.openings) > before

    def _smaller(self, building: Building, opening: int) -> int | None:
        """Of an opening's rooms the one with the smaller bounds that isn't given up yet; None when both are."""
        left = [
            r
            for r in building.openings[opening].rooms or ()
            if r not in self.rooms and building.rooms[r].kind != EXTERIOR and building.rooms[r].vertices is not None
        ]
        return min(left, key=lambda r: float(np.prod(np.ptp(building.rooms[r].vertices, axis=0))), default=None)


def _try(native: Any, building: Building, refused: _Refused, outdoors: bool) -> tuple[Assembled, Exception | None]:
    problems = list(building.problems) + list(refused.problems)
    scene = native.Scene()
    room_cells = _add_rooms(native, scene, building, problems, refused.rooms)
    opening_cells = _add_openings(native, scene, building, room_cells, problems, refused.openings)
    native_objects, building_objects = _add_objects(scene, building, room_cells, problems)
    for light in building.lights:
        if np.isfinite(light.position).all():
            scene.add_light(light.name, light.position)
    for camera in building.cameras:
        try:
            scene.add_camera(camera.name, camera)
        except native.EnfError as error:
            problems.append(Problem(WARNING, "camera-refused", f"Camera {camera.name}: {error}", [camera.name]))
    made = Assembled(building, scene, room_cells, opening_cells, native_objects, building_objects, problems)
    failure: Exception | None = None
    try:
        if outdoors:
            _cut_outdoors(made)
        scene.commit()
    except native.EnfError as error:
        failure = error
    _core_problems(made)
    if failure is not None:
        scene.close()
    return made, failure


def _cut_outdoors(made: Assembled) -> None:
    """The outdoors as cells round the building, so that facades hide what lies behind them. They belong to the exterior room."""
    first = made.scene.counts.cells
    done = made.scene.decompose_exterior(room_tops=[room.top for room in made.building.rooms])
    if done.outcome == "done":
        made.room_cells[int(made.scene.cell_rooms[first])].extend(range(first, first + done.cells))


def _elsewhere(scene, building: Building, room_cells: list[list[int]]) -> list[int]:
    """The cell of whatever is in no room; made when the building has no exterior."""
    for i, room in enumerate(building.rooms):
        if room.kind == EXTERIOR and i < len(room_cells) and room_cells[i] and room.vertices is None:
            return room_cells[i]
    building.rooms.append(Room("Exterior", EXTERIOR))
    index = scene.add_room("Exterior", "exterior")
    room_cells.append([scene.add_cell(index)])
    return room_cells[-1]


def _add_rooms(native, scene, building, problems, refused: set[int]) -> list[list[int]]:
    room_cells: list[list[int]] = []
    homeless: list[int] = []
    for i, room in enumerate(building.rooms):
        index = scene.add_room(room.name or f"Room {i}", "exterior" if room.kind == EXTERIOR else "interior")
        if room.kind == EXTERIOR and (room.vertices is None or len(room.vertices) == 0):
            room_cells.append([scene.add_cell(index)])
            continue
        room_cells.append([])
        if room.vertices is None or len(room.vertices) == 0 or i in refused:
            homeless.append(i)
            continue
        try:
            if room.faces:
                room_cells[i] = list(scene.add_room_polyhedron(index, room.vertices, room.faces))
            else:
                room_cells[i] = [scene.add_cell(index, room.vertices)]
        except native.EnfError as error:
            problems.append(
                Problem(
                    WARNING,
                    "room-as-hull",
                    f"Room {room.name} could not be cut into convex cells ({error}); its hull is used.",
                    [room.source_id or room.name],
                    tuple(room.vertices.mean(axis=0)),
                    "Check the room's mesh: closed, not crossing itself.",
                )
            )
            try:
                room_cells[i] = [scene.add_cell(index, room.vertices)]
            except native.EnfError as worse:
                problems.append(
                    Problem(ERROR, "room-refused", f"Room {room.name}: {worse}", [room.source_id or room.name])
                )
                homeless.append(i)
    if homeless and any(o.rooms is not None and set(o.rooms) & set(homeless) for o in building.openings):
        outside = _elsewhere(scene, building, room_cells)
        for i in homeless:
            room_cells[i] = outside
    return room_cells


def _side(building: Building, room_cells: list[list[int]], room: int) -> tuple[str, int] | None:
    cells = room_cells[room]
    if not cells:
        return None
    # A room of one cell (and every exterior) is named by its cell: nothing to split.
    return ("cell", cells[0]) if len(cells) == 1 else ("room", room)


def _add_openings(native, scene, building, room_cells, problems, refused: set[int]) -> list[int | None]:
    opening_cells: list[int | None] = []
    for i, opening in enumerate(building.openings):
        index = scene.add_opening(opening.name or f"Opening {i}", opening.kind, opening.state)
        opening_cells.append(None)
        if opening.rooms is None:
            continue
        sides = [_side(building, room_cells, room) for room in opening.rooms]
        if sides[0] is None or sides[1] is None:
            problems.append(
                Problem(
                    WARNING,
                    "opening-without-room",
                    f"{opening.name} joins a room without volume; sight doesn't pass there.",
                    [opening.source_id or opening.name],
                    remedy="Mend the room.",
                )
            )
            continue
        if sides[0] == sides[1] and sides[0][0] == "cell":
            continue  # both lead into whatever is in no room
        try:
            if i in refused:
                flat = opening.polygon if opening.polygon is not None else opening.ends[0]
                scene.join(sides[0], sides[1], _rectangle(flat), index)
            elif opening.body is not None and opening.ends is not None:
                cell = scene.add_cell(None, opening.body, opening=index)
                opening_cells[-1] = cell
                for side, end in zip(sides, opening.ends, strict=True):
                    _join(native, scene, side, ("cell", cell), end, index)
            elif opening.polygon is not None:
                _join(native, scene, sides[0], sides[1], opening.polygon, index)
        except native.EnfError as error:
            problems.append(
                Problem(
                    ERROR,
                    "opening-refused",
                    f"{opening.name}: {error}",
                    [opening.source_id or opening.name],
                    remedy="Check that the opening is convex and has an area.",
                )
            )
    return opening_cells


def _join(native, scene, side_a, side_b, polygon, opening) -> None:
    """Joins; a polygon the core refuses is replaced by its bounding rectangle, which contains it (safe direction)."""
    try:
        scene.join(side_a, side_b, polygon, opening)
    except native.BadInputError:
        scene.join(side_a, side_b, _rectangle(polygon), opening)


def _rectangle(polygon: np.ndarray) -> np.ndarray:
    """The bounding rectangle of a polygon in its own plane, float64 (4, 3)."""
    points = np.asarray(polygon, dtype=np.float64)
    centred = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    normal = unit(axes[2])
    u, v = plane_basis(normal)
    a, c = points @ u, points @ v
    height = float((points @ normal).mean())
    corners = ((a.min(), c.min()), (a.max(), c.min()), (a.max(), c.max()), (a.min(), c.max()))
    return np.array([x * u + y * v + height * normal for x, y in corners])


def _add_objects(scene, building, room_cells, problems) -> tuple[np.ndarray, np.ndarray]:
    count = len(building.objects)
    native_objects = np.full(count, -1, dtype=np.int64)
    if not count:
        return native_objects, np.zeros(0, dtype=np.int64)
    bounds = np.array([np.asarray(o.bounds, dtype=np.float64).reshape(2, 3) for o in building.objects])
    fine = np.isfinite(bounds).all(axis=(1, 2)) & (bounds[:, 0] <= bounds[:, 1]).all(axis=1)
    numbers: dict[str, int] = {}
    meshes = [numbers.setdefault(o.mesh, len(numbers)) if o.mesh else NONE for o in building.objects]
    order: list[int] = []
    free: list[int] = []
    for i, obj in enumerate(building.objects):
        if not fine[i]:
            continue
        if obj.rooms is None:
            free.append(i)
            continue
        cells = sorted({c for room in obj.rooms for c in room_cells[room]})
        if not cells:
            free.append(i)
            continue
        native_objects[i] = scene.add_object(obj.name, bounds[i], cells, meshes[i])
        order.append(i)
    if free:
        added = scene.add_objects([building.objects[i].name for i in free], bounds[free], [meshes[i] for i in free])
        native_objects[free] = np.arange(added.start, added.stop)
        order += free
    if not fine.all():
        bad = [building.objects[int(i)].name for i in np.nonzero(~fine)[0]]
        problems.append(
            Problem(INFO, "object-without-bounds", f"{len(bad)} objects have no usable bounds and are always kept.", bad[:20])
        )
    for i, obj in enumerate(building.objects):
        if obj.occluder is not None and native_objects[i] >= 0:
            scene.set_occluder(int(native_objects[i]), None if isinstance(obj.occluder, str) else obj.occluder)
    return native_objects, np.array(order, dtype=np.int64)


def _core_problems(made: Assembled) -> None:
    """Adds the core's problems in the building's names, and remembers which room or opening each is about."""
    building, scene = made.building, made.scene
    cell_room = {c: i for i, cells in enumerate(made.room_cells) for c in cells}
    cell_opening = {c: i for i, c in enumerate(made.opening_cells) if c is not None}
    portal_openings = None
    rooms_of_cells = [building.rooms[r].name if r < len(building.rooms) else "" for r in np.array(scene.cell_rooms).tolist()]
    told = {name for p in building.problems for name in p.names}
    found: list[Problem] = []
    for p in scene.problems:
        room = opening = None
        names: list[str] = []
        if p.index is not None:
            if p.item == "room":
                room = p.index
            elif p.item == "opening":
                opening = p.index
            elif p.item == "cell":
                room, opening = cell_room.get(p.index), cell_opening.get(p.index)
            elif p.item == "object" and p.index < len(made.building_objects):
                names = [building.objects[int(made.building_objects[p.index])].source_id]
            elif p.item == "portal":
                if portal_openings is None:
                    portal_openings = np.array(scene.portal_openings)
                o = int(portal_openings[p.index]) if p.index < len(portal_openings) else NONE
                opening = None if o == NONE else o
        if room is not None and room < len(building.rooms):
            names = [building.rooms[room].source_id or building.rooms[room].name]
        if opening is not None and opening < len(building.openings):
            names = [building.openings[opening].source_id or building.openings[opening].name]
        subject = ""
        if opening is not None and opening < len(building.openings):
            subject = f"{building.openings[opening].kind} '{building.openings[opening].name}'"
        elif room is not None and room < len(building.rooms):
            subject = f"room '{building.rooms[room].name}'"
        if p.code in core_problems.TOLD_BEFORE and told.intersection(names):
            continue
        message, remedy = core_problems.reword(p.message, subject, rooms_of_cells), core_problems.remedy_of(p.code)
        problem = Problem(p.severity, core_problems.code_of(p.code), message, names, p.position or _place(building, room, opening), remedy)
        found.append(problem)
        made.blame[id(problem)] = (room, opening)
    made.problems += core_problems.gathered(found)


def _place(building: Building, room: int | None, opening: int | None) -> tuple[float, float, float] | None:
    """The middle of what a problem is about."""
    points = None
    if opening is not None and opening < len(building.openings):
        points = building.openings[opening].body
        points = building.openings[opening].polygon if points is None else points
    elif room is not None and room < len(building.rooms):
        points = building.rooms[room].vertices
    return None if points is None or not len(points) else tuple(float(x) for x in 0.5 * (points.min(axis=0) + points.max(axis=0)))


def cells_of(assembled: Assembled) -> Cells:
    """Copies of the core's cells and portals, for drawing."""
    scene = assembled.scene
    cell_first = np.array(scene.cell_vertex_first)
    cell_points = np.array(scene.cell_vertices)
    portal_first = np.array(scene.portal_vertex_first)
    portal_points = np.array(scene.portal_vertices)
    return Cells(
        rooms=np.array(scene.cell_rooms),
        openings=np.array(scene.cell_openings),
        hulls=[cell_points[a:b] for a, b in zip(cell_first, cell_first[1:], strict=False)],
        portals=[portal_points[a:b] for a, b in zip(portal_first, portal_first[1:], strict=False)],
        portal_cells=np.array(scene.portal_cells),
        portal_openings=np.array(scene.portal_openings),
    )
