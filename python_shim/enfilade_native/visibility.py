# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera sees through the openings, and why (csrc/include/enfilade/portal_vis.h).

A View belongs to one committed scene and one thread; `shared()` gives another thread its own.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _structs
from ._library import library
from ._signatures import ViewHandle
from .buffers import Flat
from .errors import InvalidArgumentError
from .handles import Owned, Owner
from .scene import NONE, Camera, Scene, _index, _number_of

METHODS = ("frustum", "box", "clip")
_OPTIONS = {name for name, _ in _structs.EnfViewDef._fields_} - {"struct_size", "method", "want_objects", "reserved"}
_STATS = [name for name, _ in _structs.EnfViewStats._fields_ if name not in ("struct_size", "reserved")]


@dataclass(frozen=True)
class ViewResult:
    """One answer. All arrays uint32 and the caller's own (copied: the view's next query overwrites its memory)."""

    cells: np.ndarray  # (cells,) visible cells, in the order in which sight reached them
    cell_step: np.ndarray  # (cells,) the step by which each was reached first
    objects: np.ndarray  # (objects,) visible objects, each once
    object_step: np.ndarray  # (objects,) the step through which each is seen; NONE: unplaced, or method frustum
    step_cell: np.ndarray  # (steps,) a step leads through step_portal into step_cell, from step_parent
    step_portal: np.ndarray  # (steps,) NONE: the eye is there
    step_parent: np.ndarray  # (steps,) NONE for start cells
    cells_entered: np.ndarray  # what changed since the view's answer before, ascending
    cells_left: np.ndarray
    objects_entered: np.ndarray
    objects_left: np.ndarray
    stats: dict[str, float]  # counters and microseconds, by the names of EnfViewStats

    def why(self, step: int) -> list[int]:
        """The portals from the camera to where `step` leads, nearest first; [] where the eye is."""
        portals: list[int] = []
        while step != NONE:
            if self.step_portal[step] != NONE:
                portals.append(int(self.step_portal[step]))
            step = int(self.step_parent[step])
        return portals[::-1]


def _copied(pointer: Any, count: int) -> np.ndarray:
    return np.frombuffer(ctypes.string_at(pointer, 4 * count), dtype=np.uint32) if count else _EMPTY


_EMPTY = np.zeros(0, dtype=np.uint32)


class View(Owned):
    """Scratch memory and the last answer for one scene. One per thread. Context manager, or close()."""

    closed_message = "this view is closed"

    def __init__(self, scene: Scene) -> None:
        handle = ViewHandle()
        library().enf_view_create(scene.handle, ctypes.byref(handle))
        self._owner = Owner(handle, "enf_view_destroy", scene.owner)

    def shared(self) -> View:
        """A view of the same scene that shares the packed arrays, for another thread."""
        handle = ViewHandle()
        library().enf_view_create_shared(self.handle, ctypes.byref(handle))
        other = View.__new__(View)
        other._owner = Owner(handle, "enf_view_destroy", self.owner.keeps)
        return other

    @staticmethod
    def _def(method: str, objects: bool, options: dict[str, Any]) -> _structs.EnfViewDef:
        out = library().enf_default_view_def()
        out.method = _number_of(method, METHODS, "method")
        out.want_objects = 1 if objects else 0
        for name, value in options.items():
            if name not in _OPTIONS:
                raise InvalidArgumentError(f"no view option '{name}'; there are: {', '.join(sorted(_OPTIONS))}")
            try:
                setattr(out, name, value)
            except TypeError as error:
                raise InvalidArgumentError(f"view option {name}: {error}") from None
        return out

    def query(self, camera: Any, method: str = "clip", objects: bool = True, **options: Any) -> ViewResult:
        """What `camera` (a Camera, or anything with its attributes) sees now. method: "frustum", "box" or "clip".

        options: fields of EnfViewDef, e.g. distance_limit=30.0 (metres), max_apertures=4, use_simd=0."""
        definition = self._def(method, objects, options)
        library().enf_view_query(self.handle, ctypes.byref(Camera.of(camera).to_c()), ctypes.byref(definition))
        return self.result()

    def query_union(
        self, cameras: Sequence[Any], swept: bool = False, method: str = "clip", objects: bool = True, **options: Any
    ) -> ViewResult:
        """What any of 1..16 cameras sees: exactly the union (a stereo pair, any mix of types); swept: a shutter interval, one type."""
        definition = self._def(method, objects, options)
        array = (_structs.EnfCamera * max(len(cameras), 1))(*(Camera.of(camera).to_c() for camera in cameras))
        library().enf_view_query_union(
            self.handle, array, len(cameras), 1 if swept else 0, ctypes.byref(definition)
        )
        return self.result()

    def query_region(
        self, bounds: Any, look: Any = None, method: str = "clip", objects: bool = True, **options: Any
    ) -> ViewResult:
        """What is seen from anywhere in a box (2, 3), metres, looking anywhere or as the camera `look` does."""
        definition = self._def(method, objects, options)
        box = Flat(np.asarray(bounds, dtype=np.float64), "bounds", np.float64, 6)
        camera = ctypes.byref(Camera.of(look).to_c()) if look is not None else None
        library().enf_view_query_region(self.handle, box.address, camera, ctypes.byref(definition))
        return self.result()

    def stats(self) -> dict[str, float]:
        c = library().enf_default_view_stats()
        library().enf_view_stats(self.handle, ctypes.byref(c))
        return {name: getattr(c, name) for name in _STATS}

    def result(self) -> ViewResult:
        """The last answer. StateError before the first."""
        c = library().enf_default_view_result()
        library().enf_view_result(self.handle, ctypes.byref(c))
        return ViewResult(
            _copied(c.cells, c.cell_count),
            _copied(c.cell_step, c.cell_count),
            _copied(c.objects, c.object_count),
            _copied(c.object_step, c.object_count),
            _copied(c.step_cell, c.step_count),
            _copied(c.step_portal, c.step_count),
            _copied(c.step_parent, c.step_count),
            _copied(c.cells_entered, c.cells_entered_count),
            _copied(c.cells_left, c.cells_left_count),
            _copied(c.objects_entered, c.objects_entered_count),
            _copied(c.objects_left, c.objects_left_count),
            self.stats(),
        )

    def _why(self, getter: str, index: int) -> list[int]:
        count = ctypes.c_uint32()
        portals = np.empty(64, dtype=np.uint32)
        while True:
            getattr(library(), getter)(
                self.handle, _index(index), portals.ctypes.data, portals.size, ctypes.byref(count)
            )
            if count.value <= portals.size:
                return portals[: count.value].tolist()
            portals = np.empty(count.value, dtype=np.uint32)

    def why_cell(self, cell: int) -> list[int]:
        """Portals from the camera to a visible cell, nearest first."""
        return self._why("enf_view_why_cell", cell)

    def why_object(self, index: int) -> list[int]:
        """Portals from the camera to a visible object, nearest first."""
        return self._why("enf_view_why_object", index)

    def groups(self) -> list[tuple[int | None, np.ndarray]]:
        """Visible objects by the mesh they share: (mesh number or None, object indices)."""
        pointer = ctypes.POINTER(ctypes.c_uint32)
        count, meshes, first, objects = ctypes.c_uint32(), pointer(), pointer(), pointer()
        library().enf_view_groups(
            self.handle, ctypes.byref(count), ctypes.byref(meshes), ctypes.byref(first), ctypes.byref(objects)
        )
        if not count.value:
            return []
        starts = _copied(first, count.value + 1).tolist()
        every = _copied(objects, starts[-1])
        return [
            (None if meshes[i] == NONE else int(meshes[i]), every[starts[i] : starts[i + 1]])
            for i in range(count.value)
        ]
