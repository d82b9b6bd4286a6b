# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene: rooms, convex cells, portals, openings, objects, lights, cameras (csrc/include/enfilade/scene.h).

Create or load, add, commit, query. Metres, z up, float64. A Scene may be used by several threads at once for reading
once committed; the calls let go of Python's global lock while C works.
"""

from __future__ import annotations

import ctypes
import os
import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from ._signatures import SceneHandle
from .buffers import Flat, Rows, View, address_of, faces_flat
from .errors import BadInputError, InvalidArgumentError, StateError
from .handles import Owned, Owner

NONE = 0xFFFFFFFF  # "no index", ENF_NONE

ROOM_KINDS = ("interior", "exterior")
OPENING_KINDS = ("door", "window", "hole", "virtual")
OPENING_STATES = ("open", "closed", "glass")
CAMERA_TYPES = ("PERSP", "ORTHO", "PANO")
SEVERITIES = ("info", "warning", "error")
EXTERIOR_OUTCOMES = ("done", "none", "already", "several", "too_complex")
ITEMS = ("scene", "room", "cell", "portal", "opening", "object", "light", "camera")


def _number_of(word: str | int, words: Sequence[str], what: str) -> int:
    if isinstance(word, str):
        if word not in words:
            raise InvalidArgumentError(f"{what}: '{word}' is none of {', '.join(words)}")
        return words.index(word)
    if not 0 <= int(word) < len(words):
        raise InvalidArgumentError(f"{what}: {word} is not in 0..{len(words) - 1}")
    return int(word)


def _word(number: int, words: Sequence[str]) -> str:
    return words[number] if number < len(words) else f"unknown {number}"


def _index(value: int | None, what: str = "index") -> int:
    """None is "no index"; ctypes would wrap anything else into 32 bits without a word."""
    if value is None:
        return NONE
    number = int(value)
    if not 0 <= number <= NONE:
        raise InvalidArgumentError(f"{what} {number} is not in 0..{NONE}")
    return number


def _text(value: str, what: str) -> bytes:
    if "\0" in value:
        raise InvalidArgumentError(f"{what}: a name can't hold a zero character")
    # Names from Blender files may hold bytes that are no UTF-8; as lone surrogates they travel, '?' would rename them.
    return value.encode("utf-8", "surrogateescape")


def _string(value: bytes | None) -> str:
    return "" if value is None else value.decode("utf-8", "surrogateescape")


@dataclass(frozen=True)
class Problem:
    """Something commit found. `item` and `index` say where; index None: the whole scene."""

    severity: str  # "info", "warning", "error"
    item: str  # "scene", "room", "cell", ...
    index: int | None
    code: int
    message: str
    position: tuple[float, float, float] | None  # metres


@dataclass(frozen=True)
class SceneCounts:
    rooms: int
    cells: int
    portals: int
    openings: int
    objects: int
    lights: int
    cameras: int
    seams: int  # portals between two cells of one room
    closed_portals: int  # portals of closed openings


@dataclass(frozen=True)
class Exterior:
    """What decompose_exterior did. Only "done" changed the scene."""

    outcome: str  # EXTERIOR_OUTCOMES
    cells: int  # made; they come last
    seams: int
    portals: int  # that led outdoors
    split: int  # of these, in more than one piece now
    bodies: int  # rooms, walls and slabs that were taken out of the outdoors
    leaves: int  # parts before merging
    wall_gap: float  # as used, metres
    slab_gap: float
    seconds: float


def _identity() -> np.ndarray:
    return np.eye(4)


@dataclass
class Camera:
    """What a camera sees with. The camera looks along its -z, +y is up, as in Blender.

    matrix_world: (4, 4), metres. angle_x, angle_y: full field of view after sensor fit, radians; 0 = the core's default.
    shift: fractions of the view's width and height. ortho_width, ortho_height: metres. clip: near, far, metres.
    """

    matrix_world: np.ndarray = field(default_factory=_identity)
    type: str = "PERSP"
    angle_x: float = 0.0
    angle_y: float = 0.0
    shift_x: float = 0.0
    shift_y: float = 0.0
    ortho_width: float = 0.0
    ortho_height: float = 0.0
    clip: tuple[float, float] | None = None

    @classmethod
    def of(cls, camera: Any) -> Camera:
        """Any object with these fields as attributes (such as the plugin's own camera)."""
        if isinstance(camera, cls):
            return camera
        known = {name: getattr(camera, name) for name in _CAMERA_FIELDS if hasattr(camera, name)}
        if "matrix_world" not in known:
            raise InvalidArgumentError(f"a {type(camera).__name__} has no matrix_world: not a camera")
        return cls(**known)

    def to_c(self) -> _structs.EnfCamera:
        out = library().enf_default_camera()
        out.type = _number_of(self.type, CAMERA_TYPES, "camera type")
        matrix = np.ascontiguousarray(self.matrix_world, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise InvalidArgumentError(f"camera matrix: shape {matrix.shape}, wanted (4, 4)")
        out.world_from_camera[:] = matrix.ravel().tolist()
        for name in ("angle_x", "angle_y", "ortho_width", "ortho_height"):
            if getattr(self, name):
                setattr(out, name, getattr(self, name))
        out.shift_x, out.shift_y = self.shift_x, self.shift_y
        if self.clip is not None:
            out.clip_near, out.clip_far = self.clip
        return out

    @classmethod
    def from_c(cls, c: _structs.EnfCamera) -> Camera:
        return cls(
            np.array(c.world_from_camera[:]).reshape(4, 4),
            _word(c.type, CAMERA_TYPES),
            c.angle_x,
            c.angle_y,
            c.shift_x,
            c.shift_y,
            c.ortho_width,
            c.ortho_height,
            (c.clip_near, c.clip_far),
        )


_CAMERA_FIELDS = [f.name for f in fields(Camera)]


class Scene(Owned):
    """A building as the core knows it. Use as a context manager, or call close().

    Arrays that come back are read-only views into the scene's memory. They stay valid after close(); while one is held,
    adding and committing raise StateError (the memory would move under it): copy what is kept across an edit.
    """

    closed_message = "this scene is closed"

    def __init__(self) -> None:
        handle = SceneHandle()
        library().enf_scene_create(ctypes.byref(handle))
        self._adopt(handle)

    def _adopt(self, handle: SceneHandle) -> None:
        self._owner = Owner(handle, "enf_scene_destroy")
        self._views: weakref.WeakSet[View] = weakref.WeakSet()
        self._jobs: weakref.WeakSet[Any] = weakref.WeakSet()  # bakes that may still read this scene
        self._committed = False

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Reads *.enf.json or *.prt. Not committed yet. EnfIOError, BadInputError (with line or index and reason)."""
        handle = SceneHandle()
        # UTF-8 on every platform: the core turns it into what the system wants.
        library().enf_scene_load(os.fspath(path).encode("utf-8", "surrogateescape"), ctypes.byref(handle))
        scene = cls.__new__(cls)
        scene._adopt(handle)
        return scene

    @classmethod
    def loads(cls, data: bytes | bytearray | memoryview) -> Scene:
        """Like load, from memory; the bytes aren't copied on their way in."""
        array = np.frombuffer(data, dtype=np.uint8)
        handle = SceneHandle()
        library().enf_scene_load_memory(array.ctypes.data if array.size else None, array.size, ctypes.byref(handle))
        scene = cls.__new__(cls)
        scene._adopt(handle)
        return scene

    def _idle(self) -> SceneHandle:
        if any(job.running for job in self._jobs):
            raise StateError("a bake still reads this scene: cancel it or wait for its end before changing the scene")
        return self.handle

    def _edit(self) -> SceneHandle:
        handle = self._idle()
        if len(self._views):
            raise StateError(
                f"{len(self._views)} arrays of this scene are still held and would be left pointing at freed memory: "
                "copy or drop them before adding or committing"
            )
        self._committed = False
        return handle

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes *.enf.json, never half a file."""
        library().enf_scene_save_json(self.handle, os.fspath(path).encode("utf-8", "surrogateescape"))

    # ---- adding ----

    def add_room(self, name: str, kind: str | int = "interior") -> int:
        out = ctypes.c_uint32()
        number = _number_of(kind, ROOM_KINDS, "room kind")
        library().enf_scene_add_room(self._edit(), _text(name, "room"), number, ctypes.byref(out))
        return out.value

    def add_cell(
        self,
        room: int | None,
        vertices: Any = (),
        faces: Sequence[Sequence[int]] | None = None,
        opening: int | None = None,
    ) -> int:
        """A convex cell. vertices: float64 (n, 3); faces: corner indices, counter-clockwise from outside; None: hull."""
        rows = Rows(vertices, 3, "cell vertices")
        sizes, indices = faces_flat(faces, "cell faces")
        out = ctypes.c_uint32()
        library().enf_scene_add_cell(
            self._edit(),
            _index(room, "room"),
            _index(opening, "opening"),
            rows.address,
            rows.count,
            rows.stride,
            sizes.address,
            sizes.count,
            indices.address,
            ctypes.byref(out),
        )
        return out.value

    def add_opening(self, name: str, kind: str | int = "hole", state: str | int = "open") -> int:
        out = ctypes.c_uint32()
        library().enf_scene_add_opening(
            self._edit(),
            _text(name, "opening"),
            _number_of(kind, OPENING_KINDS, "opening kind"),
            _number_of(state, OPENING_STATES, "opening state"),
            ctypes.byref(out),
        )
        return out.value

    def add_portal(self, cell_a: int, cell_b: int, polygon: Any, opening: int | None = None) -> int:
        """A convex planar polygon, float64 (n, 3), between two cells; without an opening it is always open."""
        rows = Rows(polygon, 3, "portal polygon")
        out = ctypes.c_uint32()
        library().enf_scene_add_portal(
            self._edit(),
            _index(cell_a, "cell"),
            _index(cell_b, "cell"),
            rows.address,
            rows.count,
            rows.stride,
            _index(opening, "opening"),
            ctypes.byref(out),
        )
        return out.value

    def add_object(
        self, name: str, bounds: Any, cells: Iterable[int] | None = None, mesh: int | None = None
    ) -> int:
        """bounds: (2, 3), min and max, metres. cells None: placed at commit."""
        box = Flat(np.asarray(bounds, dtype=np.float64), "object bounds", np.float64, 6)
        where = Flat(list(cells) if cells is not None else (), "object cells", np.uint32)
        out = ctypes.c_uint32()
        library().enf_scene_add_object(
            self._edit(),
            _text(name, "object"),
            box.address,
            where.address,
            where.count,
            _index(mesh, "mesh"),
            ctypes.byref(out),
        )
        return out.value

    def add_objects(self, names: Sequence[str], bounds: Any, meshes: Any = None) -> range:
        """Many objects at once, placed at commit. bounds: (n, 2, 3) or (n, 6), metres; meshes: (n,) or None.

        Returns the indices they got."""
        boxes = np.asarray(bounds, dtype=np.float64)
        boxes = Rows(boxes.reshape(len(boxes), -1) if boxes.size else boxes, 6, "object bounds")
        if len(names) != boxes.count:
            raise InvalidArgumentError(f"{len(names)} names for {boxes.count} bounds")
        joined = b"".join(_text(name, "object") + b"\0" for name in names)
        numbers = None if meshes is None else Flat(meshes, "meshes", np.uint32, len(names))
        out = ctypes.c_uint32()
        library().enf_scene_add_objects(
            self._edit(),
            boxes.count,
            joined,
            len(joined),
            boxes.address,
            boxes.stride,
            numbers.address if numbers else None,
            ctypes.byref(out),
        )
        return range(out.value, out.value + boxes.count)

    def set_occluder(self, index: int, polygons: Sequence[Any] | None = None) -> None:
        """What of object `index` surely blocks sight: convex planar polygons (n, 3) in its solid, metres; None: its whole box.

        Views hide what stands behind with `occluders=1` (always) or `2` (when it pays)."""
        parts = [np.asarray(polygon, dtype=np.float64).reshape(-1, 3) for polygon in polygons or ()]
        if polygons is not None and not parts:
            raise InvalidArgumentError("an occluder without polygons")
        corners = Rows(np.concatenate(parts) if parts else np.zeros((0, 3)), 3, "occluder corners")
        sizes = Flat([len(part) for part in parts], "occluder polygons", np.uint32)
        library().enf_scene_set_occluder(
            self._edit(), _index(index, "object"), corners.address, corners.stride, sizes.address, sizes.count
        )

    def add_light(self, name: str, position: Any) -> int:
        point = Flat(np.asarray(position, dtype=np.float64), "light position", np.float64, 3)
        out = ctypes.c_uint32()
        library().enf_scene_add_light(self._edit(), _text(name, "light"), point.address, ctypes.byref(out))
        return out.value

    def add_camera(self, name: str, camera: Any) -> int:
        """camera: a Camera, or anything with its attributes."""
        c = Camera.of(camera).to_c()
        out = ctypes.c_uint32()
        library().enf_scene_add_camera(self._edit(), _text(name, "camera"), ctypes.byref(c), ctypes.byref(out))
        return out.value

    # ---- building from rooms as people draw them ----

    def add_room_polyhedron(self, room: int, vertices: Any, faces: Sequence[Sequence[int]]) -> range:
        """Cuts a closed polyhedron (faces counter-clockwise from outside, may be non-convex) into convex cells.

        Returns the cells added. Shapes that aren't closed become their hull, and a problem says so."""
        rows = Rows(vertices, 3, "room vertices")
        sizes, indices = faces_flat(faces, "room faces")
        first, count = ctypes.c_uint32(), ctypes.c_uint32()
        library().enf_scene_add_room_polyhedron(
            self._edit(),
            _index(room, "room"),
            rows.address,
            rows.count,
            rows.stride,
            sizes.address,
            sizes.count,
            indices.address,
            ctypes.byref(first),
            ctypes.byref(count),
        )
        return range(first.value, first.value + count.value)

    def add_room_prism(self, room: int, rings: Sequence[Any], z0: float, z1: float) -> range:
        """rings: outline first, then holes, each float64 (n, 2); from height z0 to z1. Returns the cells added."""
        parts = [np.asarray(ring, dtype=np.float64).reshape(-1, 2) for ring in rings]
        corners = Rows(np.concatenate(parts) if parts else np.zeros((0, 2)), 2, "rings")
        sizes = Flat([len(part) for part in parts], "ring sizes", np.uint32)
        first, count = ctypes.c_uint32(), ctypes.c_uint32()
        packed = np.ascontiguousarray(corners.array)
        library().enf_scene_add_room_prism(
            self._edit(),
            _index(room, "room"),
            packed.ctypes.data if packed.size else None,
            sizes.address,
            sizes.count,
            z0,
            z1,
            ctypes.byref(first),
            ctypes.byref(count),
        )
        return range(first.value, first.value + count.value)

    def join(
        self,
        side_a: tuple[str, int],
        side_b: tuple[str, int],
        polygon: Any,
        opening: int | None = None,
    ) -> range:
        """A portal polygon between rooms or cells, split among the cells of each side. Sides: ("room", i), ("cell", i).

        Returns the portals added."""
        kinds = ("room", "cell")
        rows = Rows(polygon, 3, "portal polygon")
        first, count = ctypes.c_uint32(), ctypes.c_uint32()
        library().enf_scene_join(
            self._edit(),
            _number_of(side_a[0], kinds, "side"),
            _index(side_a[1], "side"),
            _number_of(side_b[0], kinds, "side"),
            _index(side_b[1], "side"),
            rows.address,
            rows.count,
            rows.stride,
            _index(opening, "opening"),
            ctypes.byref(first),
            ctypes.byref(count),
        )
        return range(first.value, first.value + count.value)

    def decompose_exterior(
        self, wall_gap: float | None = None, slab_gap: float | None = None, margin: float = 0.0, max_cells: int | None = None,
        room_tops: Any = None,
    ) -> Exterior:
        """Cuts the outdoors into convex cells round the rooms; call it when all rooms and portals are added, before commit.

        What lies between facing walls at most `wall_gap` metres apart (floors and ceilings: `slab_gap`) isn't outdoors; None:
        as thick as the walls that openings go through are. margin: metres of outdoors in cells; 0: a quarter of the extent.
        room_tops: float64 (rooms,) heights from which on what is in a room may be outdoors too, inf: nowhere; None: no room's."""
        given = library().enf_default_exterior_def()
        if wall_gap is not None:
            given.wall_gap = wall_gap
        if slab_gap is not None:
            given.slab_gap = slab_gap
        if max_cells is not None:
            given.max_cells = max_cells
        given.margin = margin
        tops = None if room_tops is None else Flat(room_tops, "room_tops", np.float64)
        if tops is not None:
            given.room_tops, given.room_count = tops.array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), tops.count
        out = _structs.EnfExteriorReport(struct_size=ctypes.sizeof(_structs.EnfExteriorReport))
        library().enf_scene_decompose_exterior(self._edit(), ctypes.byref(given), ctypes.byref(out))
        numbers = {f.name: getattr(out, f.name) for f in fields(Exterior)}
        return Exterior(**(numbers | {"outcome": _word(out.outcome, EXTERIOR_OUTCOMES)}))

    # ---- commit and problems ----

    def commit(self) -> None:
        """Validates and builds what queries need. BadInputError when a problem is an error; `problems` lists all."""
        handle = self._edit()
        try:
            library().enf_scene_commit(handle)
        except BadInputError as error:
            error.problems = self.problems  # type: ignore[attr-defined]
            raise
        self._committed = True

    @property
    def committed(self) -> bool:
        return self._committed

    @property
    def problems(self) -> list[Problem]:
        handle = self.handle
        c = _structs.EnfProblem()
        found = []
        for i in range(library().enf_scene_problem_count(handle)):
            library().enf_scene_problem(handle, i, ctypes.byref(c))
            position = tuple(c.position[:])
            found.append(
                Problem(
                    _word(c.severity, SEVERITIES),
                    _word(c.item, ITEMS),
                    None if c.index == NONE else c.index,
                    c.code,
                    # The C side cuts at a byte count, which may fall inside a character.
                    c.message.decode("utf-8", "replace"),
                    None if any(v != v for v in position) else position,  # type: ignore[arg-type]
                )
            )
        return found

    # ---- reading ----

    @property
    def counts(self) -> SceneCounts:
        c = _structs.EnfSceneCounts(struct_size=ctypes.sizeof(_structs.EnfSceneCounts))
        library().enf_scene_counts(self.handle, ctypes.byref(c))
        return SceneCounts(*(getattr(c, f.name) for f in fields(SceneCounts)))

    def _array(self, getter: str, shape: tuple[int, ...], dtype: Any) -> np.ndarray:
        pointer = getattr(library(), getter)(self.handle)
        address = address_of(pointer)
        if not address or 0 in shape:
            empty = np.zeros(tuple(shape), dtype=dtype)
            empty.flags.writeable = False
            return empty
        view = View(self._owner, address, shape, dtype)
        self._views.add(view)
        return np.asarray(view)

    @property
    def cell_rooms(self) -> np.ndarray:
        """uint32 (cells,): room of each cell, NONE for the cell of an opening."""
        return self._array("enf_scene_cell_rooms", (self.counts.cells,), np.uint32)

    @property
    def cell_openings(self) -> np.ndarray:
        """uint32 (cells,): opening whose passage the cell is, else NONE."""
        return self._array("enf_scene_cell_openings", (self.counts.cells,), np.uint32)

    @property
    def portal_cells(self) -> np.ndarray:
        """uint32 (portals, 2)."""
        return self._array("enf_scene_portal_cells", (self.counts.portals, 2), np.uint32)

    @property
    def portal_openings(self) -> np.ndarray:
        """uint32 (portals,): opening or NONE."""
        return self._array("enf_scene_portal_openings", (self.counts.portals,), np.uint32)

    @property
    def portal_vertex_first(self) -> np.ndarray:
        """uint32 (portals + 1,) into portal_vertices."""
        return self._array("enf_scene_portal_vertex_first", (self.counts.portals + 1,), np.uint32)

    @property
    def portal_vertices(self) -> np.ndarray:
        """float64 (sum, 3), metres."""
        first = self.portal_vertex_first
        return self._array("enf_scene_portal_vertices", (int(first[-1]), 3), np.float64)

    @property
    def cell_vertex_first(self) -> np.ndarray:
        """uint32 (cells + 1,) into cell_vertices."""
        return self._array("enf_scene_cell_vertex_first", (self.counts.cells + 1,), np.uint32)

    @property
    def cell_vertices(self) -> np.ndarray:
        """float64 (sum, 3), metres."""
        first = self.cell_vertex_first
        return self._array("enf_scene_cell_vertices", (int(first[-1]), 3), np.float64)

    def cell_hulls(self) -> list[np.ndarray]:
        """The vertices of each cell, float64 (n, 3) views."""
        first, vertices = self.cell_vertex_first.tolist(), self.cell_vertices
        return [vertices[a:b] for a, b in zip(first[:-1], first[1:], strict=True)]

    def portal_polygons(self) -> list[np.ndarray]:
        """The polygon of each portal, float64 (k, 3) views."""
        first, vertices = self.portal_vertex_first.tolist(), self.portal_vertices
        return [vertices[a:b] for a, b in zip(first[:-1], first[1:], strict=True)]

    def _name(self, getter: str, index: int, what: str) -> str:
        name = getattr(library(), getter)(self.handle, _index(index, what))
        if name is None:
            raise InvalidArgumentError(f"{what} {index} is not in the scene")
        return _string(name)

    def room_name(self, room: int) -> str:
        return self._name("enf_scene_room_name", room, "room")

    def room_kind(self, room: int) -> str:
        self.room_name(room)  # the C call has no way to say "out of range"
        return _word(library().enf_scene_room_kind(self.handle, room), ROOM_KINDS)

    def opening_name(self, opening: int) -> str:
        return self._name("enf_scene_opening_name", opening, "opening")

    def object_name(self, index: int) -> str:
        return self._name("enf_scene_object_name", index, "object")

    def camera_name(self, camera: int) -> str:
        return self._name("enf_scene_camera_name", camera, "camera")

    @property
    def room_names(self) -> list[str]:
        return [self.room_name(i) for i in range(self.counts.rooms)]

    @property
    def opening_names(self) -> list[str]:
        return [self.opening_name(i) for i in range(self.counts.openings)]

    @property
    def object_names(self) -> list[str]:
        return [self.object_name(i) for i in range(self.counts.objects)]

    @property
    def camera_names(self) -> list[str]:
        return [self.camera_name(i) for i in range(self.counts.cameras)]

    def opening(self, opening: int) -> tuple[str, str]:
        """(kind, state) of an opening."""
        kind, state = ctypes.c_uint32(), ctypes.c_uint32()
        library().enf_scene_opening(self.handle, _index(opening, "opening"), ctypes.byref(kind), ctypes.byref(state))
        return _word(kind.value, OPENING_KINDS), _word(state.value, OPENING_STATES)

    def set_opening_state(self, opening: int, state: str | int) -> None:
        """Opens or closes; needs no new commit. Not while another thread queries this scene."""
        number = _number_of(state, OPENING_STATES, "opening state")
        library().enf_scene_set_opening_state(self._idle(), _index(opening, "opening"), number)

    def object_cells(self, index: int) -> np.ndarray:
        """uint32 (n,): the cells an object is drawn in; after commit."""
        cells, count = ctypes.POINTER(ctypes.c_uint32)(), ctypes.c_uint32()
        library().enf_scene_object_cells(
            self.handle, _index(index, "object"), ctypes.byref(cells), ctypes.byref(count)
        )
        return np.array(cells[: count.value], dtype=np.uint32)

    def camera(self, camera: int | str) -> Camera:
        """A camera of the scene by index or name."""
        if isinstance(camera, str):
            names = self.camera_names
            if camera not in names:
                raise InvalidArgumentError(f"no camera '{camera}'; there are: {', '.join(names) or 'none'}")
            camera = names.index(camera)
        c = _structs.EnfCamera(struct_size=ctypes.sizeof(_structs.EnfCamera))
        library().enf_scene_camera(self.handle, _index(camera, "camera"), ctypes.byref(c))
        return Camera.from_c(c)

    def locate(self, point: Any) -> np.ndarray:
        """uint32 (n,): the cells that hold a point (3,), metres; the exterior's cells when none does."""
        position = Flat(np.asarray(point, dtype=np.float64), "point", np.float64, 3)
        count = ctypes.c_uint32()
        cells = np.empty(16, dtype=np.uint32)
        while True:
            library().enf_scene_locate(
                self.handle, position.address, cells.ctypes.data, cells.size, ctypes.byref(count)
            )
            if count.value <= cells.size:
                return cells[: count.value].copy()
            cells = np.empty(count.value, dtype=np.uint32)
