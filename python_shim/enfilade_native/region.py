# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen from anywhere in a cell: a bake as a job, its rows, rooms and witnesses (region_vis.h, job.h).

    with region.start(scene, method="exact") as job:
        while not job.wait(0.1):
            print(job.progress.fraction)
        result = job.take()

The work runs in the library's own threads and never calls back; any Python thread may poll or cancel.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._library import library
from ._signatures import JobHandle, ObjectVisHandle, RegionVisHandle
from .buffers import Flat, View, address_of
from .errors import CancelledError, InvalidArgumentError, StateError
from .handles import Owned, Owner
from .scene import NONE, Scene, _index, _number_of

METHODS = ("sample", "flow", "exact")
STATUSES = ("hidden", "visible", "grazing", "undecided")


@dataclass(frozen=True)
class Progress:
    done: bool
    fraction: float  # 0 .. 1
    elapsed_s: float
    phase: str


@dataclass(frozen=True)
class Witness:
    """A sightline from one cell to another."""

    start: np.ndarray  # float64 (3,), metres
    end: np.ndarray
    portals: list[int]  # in order
    clearance: float  # metres; below the result's clearance when grazing (the best there is), negative when a portal isn't flat


@dataclass(frozen=True)
class ObjectSeen:
    """An object seen from a cell, and the sightline that ends on its bounds."""

    object: int
    status: str  # visible, grazing or undecided
    cell: int | None  # of the object's cells the one that shows it
    start: np.ndarray | None  # float64 (3,), metres; None when undecided
    end: np.ndarray | None
    portals: list[int]  # in order; empty: the object is drawn in the cell asked for


class Job:
    """A bake under way. Context manager: leaving it cancels what still runs. Any thread may poll and cancel."""

    def __init__(self, handle: JobHandle, scene: Scene, keep: tuple[object, ...] = ()) -> None:
        self._handle: JobHandle | None = handle
        self._scene = scene
        self._scene_owner = scene.owner
        self._keep = keep
        scene._jobs.add(self)

    @property
    def handle(self) -> JobHandle:
        if self._handle is None:
            raise StateError("this job is closed")
        return self._handle

    @property
    def running(self) -> bool:
        return self._handle is not None and not self.progress.done

    @property
    def progress(self) -> Progress:
        c = library().enf_default_job_progress()
        library().enf_job_progress(self.handle, ctypes.byref(c))
        return Progress(bool(c.done), c.fraction, c.elapsed_s, c.phase.decode("utf-8", "replace"))

    def cancel(self) -> None:
        """Asks it to stop soon; take() then gives what it has."""
        library().enf_job_cancel(self.handle)

    def wait(self, seconds: float | None = None) -> bool:
        """True when ended (also when cancelled); raises what the work failed with."""
        done = ctypes.c_uint32()
        try:
            library().enf_job_wait(self.handle, -1.0 if seconds is None else seconds, ctypes.byref(done))
        except CancelledError:
            return True
        return bool(done.value)

    def take(self) -> RegionVis:
        """The result of an ended job, once. After a cancel: what it had not decided is undecided."""
        out = RegionVisHandle()
        library().enf_region_vis_take(self.handle, ctypes.byref(out))
        return RegionVis(out, self._scene)

    def close(self) -> None:
        """Cancels, waits and frees."""
        handle, self._handle = self._handle, None
        if handle:
            library().enf_job_destroy(handle)

    def __enter__(self) -> Job:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self.close()


def start(
    scene: Scene,
    method: str = "exact",
    threads: int = 0,
    from_cells: Any = None,
    time_limit: float = 0.0,
    state_path: str | os.PathLike[str] | None = None,
    variant_of: RegionVis | None = None,
    **options: Any,
) -> Job:
    """Starts a bake of a committed scene in the background.

    from_cells: rows wanted, None for all. time_limit: wall seconds, 0 for none. state_path: finished blocks are kept there,
    and a bake that finds the file goes on from it. variant_of: the whole result of other door states of the scene: only
    what the changed doors can change is asked again.
    options: further fields of EnfRegionVisDef (clearance in metres, shard_index, shard_count, block_cells, seed, ...)."""
    c = library().enf_default_region_vis_def()
    c.method = _number_of(method, METHODS, "method")
    c.threads = threads
    c.time_limit = time_limit
    keep: list[object] = []
    if from_cells is not None:
        cells = Flat(from_cells, "from_cells", np.uint32)
        if not cells.count:
            raise InvalidArgumentError("from_cells is empty: no row would be computed")
        keep.append(cells)
        c.from_count = cells.count
        c.from_cells = ctypes.cast(cells.address, ctypes.POINTER(ctypes.c_uint32))
    if state_path is not None:
        path = _encoded(state_path)
        keep.append(path)
        c.state_path = path
    if variant_of is not None:
        keep.append(variant_of)
        c.variant_of = variant_of.handle
    special = {"struct_size", "from_cells", "from_count", "state_path", "variant_of", "reserved"}
    known = {name for name, _ in c._fields_} - special
    for name, value in options.items():
        if name not in known:
            raise InvalidArgumentError(f"no bake option '{name}'; there are: {', '.join(sorted(known))}")
        setattr(c, name, value)
    out = JobHandle()
    library().enf_region_vis_start(scene.handle, ctypes.byref(c), ctypes.byref(out))
    return Job(out, scene, tuple(keep))


def run(
    scene: Scene, progress: Callable[[Progress], object] | None = None, interval: float = 0.1, **options: Any
) -> RegionVis:
    """Start, wait, take. `progress` is called in this thread every `interval` seconds; returning False cancels."""
    with start(scene, **options) as job:
        while not job.wait(interval):
            if progress is not None and progress(job.progress) is False:
                job.cancel()
        return job.take()


def load(scene: Scene, *state_paths: str | os.PathLike[str]) -> RegionVis:
    """The result out of state files: one whole one, or all the shards of a bake. The door states are those baked."""
    paths = (ctypes.c_char_p * len(state_paths))(*(_encoded(path) for path in state_paths))
    out = RegionVisHandle()
    library().enf_region_vis_load(scene.handle, paths, len(paths), ctypes.byref(out))
    return RegionVis(out, scene)


def _encoded(path: str | os.PathLike[str]) -> bytes:
    return os.fspath(path).encode("utf-8", "surrogateescape")


class RegionVis(Owned):
    """The answer of a bake: read-only, for any thread. Its arrays are views that keep it alive."""

    closed_message = "this result is closed"

    def __init__(self, handle: RegionVisHandle, scene: Scene) -> None:
        self._owner = Owner(handle, "enf_region_vis_destroy", scene.owner)
        self._room_count = scene.counts.rooms

    @property
    def cell_count(self) -> int:
        return library().enf_region_vis_cell_count(self.handle)

    def _array(self, getter: str, count: int, dtype: Any) -> np.ndarray:
        address = address_of(getattr(library(), getter)(self.handle))
        if not address or not count:
            return np.zeros(count, dtype=dtype)
        return np.asarray(View(self._owner, address, (count,), dtype))

    @property
    def row_first(self) -> np.ndarray:
        """uint64 (cells + 1,) into row_cells and row_status."""
        return self._array("enf_region_vis_row_first", self.cell_count + 1, np.uint64)

    @property
    def row_cells(self) -> np.ndarray:
        """uint32: the cells each cell sees, ascending, itself among them, row after row."""
        return self._array("enf_region_vis_row_cells", int(self.row_first[-1]), np.uint32)

    @property
    def row_status(self) -> np.ndarray:
        """uint8 beside row_cells: index into STATUSES."""
        return self._array("enf_region_vis_row_status", int(self.row_first[-1]), np.uint8)

    def row(self, cell: int) -> np.ndarray:
        """The cells that `cell` sees, ascending."""
        if not 0 <= cell < self.cell_count:
            raise InvalidArgumentError(f"cell {cell} is not in 0..{self.cell_count - 1}")
        first = self.row_first
        return self.row_cells[int(first[cell]) : int(first[cell + 1])]

    def pair(self, a: int, b: int) -> str:
        """Status of a pair of cells, one of STATUSES."""
        out = ctypes.c_uint32()
        library().enf_region_vis_pair(self.handle, _index(a, "cell"), _index(b, "cell"), ctypes.byref(out))
        return STATUSES[out.value]

    def witness(self, a: int, b: int) -> Witness | None:
        """The sightline of a pair of cells; None when it has none (hidden or undecided)."""
        segment = np.empty(6)
        portals = np.empty(64, dtype=np.uint32)
        count, clearance = ctypes.c_uint32(), ctypes.c_double()
        while True:
            if self.pair(a, b) not in ("visible", "grazing"):
                return None
            library().enf_region_vis_witness(
                self.handle,
                a,
                b,
                segment.ctypes.data,
                portals.ctypes.data,
                portals.size,
                ctypes.byref(count),
                ctypes.byref(clearance),
            )
            if count.value <= portals.size:
                return Witness(segment[:3], segment[3:], portals[: count.value].tolist(), clearance.value)
            portals = np.empty(count.value, dtype=np.uint32)

    def rooms(self, a: int, b: int) -> tuple[str, tuple[int, int] | None]:
        """Whether room a sees room b: the status and the pair of cells that shows it."""
        status, start_cell, end_cell = ctypes.c_uint32(), ctypes.c_uint32(), ctypes.c_uint32()
        library().enf_region_vis_rooms(
            self.handle,
            _index(a, "room"),
            _index(b, "room"),
            ctypes.byref(status),
            ctypes.byref(start_cell),
            ctypes.byref(end_cell),
        )
        shown = None if start_cell.value == NONE else (start_cell.value, end_cell.value)
        return STATUSES[status.value], shown

    def room_matrix(self) -> np.ndarray:
        """uint8 (rooms, rooms): index into STATUSES."""
        out = np.zeros((self._room_count, self._room_count), dtype=np.uint8)
        for a in range(self._room_count):
            for b in range(self._room_count):
                out[a, b] = STATUSES.index(self.rooms(a, b)[0])
        return out

    def objects(self, from_cells: Any = None, objects: Any = None, threads: int = 0) -> list[list[ObjectSeen]]:
        """The objects whose bounds are seen from each cell asked for (None: all), decided with the guarantees of cells. objects:
        indices, None for all. One list a cell, objects ascending; what isn't listed is certified hidden."""
        cells = None if from_cells is None else Flat(from_cells, "from_cells", np.uint32)
        wanted = None if objects is None else Flat(objects, "objects", np.uint32)
        if (cells is not None and not cells.count) or (wanted is not None and not wanted.count):
            raise InvalidArgumentError("from_cells or objects is empty: nothing is asked")
        handle = ObjectVisHandle()
        library().enf_object_vis_run(
            self.handle,
            cells.address if cells else None,
            cells.count if cells else 0,
            wanted.address if wanted else None,
            wanted.count if wanted else 0,
            threads,
            ctypes.byref(handle),
        )
        try:
            rows = library().enf_object_vis_row_count(handle)
            first = library().enf_object_vis_row_first(handle)
            return [[self._object_seen(handle, e) for e in range(first[k], first[k + 1])] for k in range(rows)]
        finally:
            library().enf_object_vis_destroy(handle)

    def _object_seen(self, handle: ObjectVisHandle, entry: int) -> ObjectSeen:
        lib = library()
        cell = lib.enf_object_vis_row_cells(handle)[entry]
        status = STATUSES[lib.enf_object_vis_row_status(handle)[entry]]
        seen = lib.enf_object_vis_row_objects(handle)[entry]
        if status == "undecided":
            return ObjectSeen(seen, status, None if cell == NONE else cell, None, None, [])
        segment, portals, count = np.empty(6), np.empty(256, dtype=np.uint32), ctypes.c_uint32()
        lib.enf_object_vis_witness(
            handle, entry, segment.ctypes.data, portals.ctypes.data, portals.size, ctypes.byref(count)
        )
        return ObjectSeen(seen, status, cell, segment[:3], segment[3:], portals[: count.value].tolist())

    @property
    def stats(self) -> dict[str, float]:
        """Counters and seconds, by the names of EnfRegionVisStats."""
        c = library().enf_default_region_vis_stats()
        library().enf_region_vis_stats(self.handle, ctypes.byref(c))
        return {name: getattr(c, name) for name, _ in c._fields_ if name not in ("struct_size", "reserved")}

    def write_matrix(self, path: str | os.PathLike[str]) -> None:
        library().enf_region_vis_write_matrix(self.handle, _encoded(path))

    def write_witnesses(self, path: str | os.PathLike[str]) -> None:
        library().enf_region_vis_write_witnesses(self.handle, _encoded(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a whole result, to be read by `load`."""
        library().enf_region_vis_save(self.handle, _encoded(path))
