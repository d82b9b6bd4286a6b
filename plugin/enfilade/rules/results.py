# SPDX-License-Identifier: GPL-3.0-or-later
"""What an analysis found, in names and indices of its `Building`: the input of the report and of the write-back.

Plain Python, no bpy. Produced by `plugin/enfilade/analysis.py`, read by `report/` and `scene/apply_result.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .building import Building, Camera


@dataclass
class View:
    """One camera at one frame."""

    camera: Camera
    frame: int
    method: str  # "box", "clip", "frustum", "pluecker"
    camera_cells: list[int]
    cells: list[int]  # ascending
    rooms: list[int]  # ascending indices into Building.rooms
    objects: list[int]  # ascending indices into Building.objects
    # why[object] = the openings (indices into Building.openings) through which it was first seen, nearest first;
    # [] = seen in the camera's own room
    why: dict[int, list[int]] = field(default_factory=dict)
    room_why: dict[int, list[int]] = field(default_factory=dict)  # same for rooms
    microseconds: float = 0.0
    counters: dict[str, int] = field(default_factory=dict)
    openings: list[int] = field(default_factory=list)  # ascending: all that the look passes, also where it sees nothing first

    @property
    def unculled(self) -> str:
        """Why walls hide nothing in this view, though its method knows them; else ""."""
        for counter, reason in UNCULLED.items():
            if self.method != "frustum" and self.counters.get(counter):
                return reason
        return ""


# The core's counters of answers that are all the view volume holds, and the reasons as people read them.
UNCULLED = {
    "eye_outside": "stands in a wall, or outside of everything known: nothing in its view is hidden. Move it into a room",
    "near_in_wall": "is so near a wall that its clipping start reaches into it: nothing in its view is hidden. Lower Clip Start, or step back",
    "budget_hit": "sees more than can be told apart in good time: nothing in its view is hidden",
}


def unculled(views: list[View]) -> list[str]:
    """A sentence for each camera of which some view couldn't be culled."""
    frames: dict[tuple[str, str], int] = {}
    for view in views:
        if view.unculled:
            key = (view.camera.name, view.unculled)
            frames[key] = frames.get(key, 0) + 1
    return [f"{name} {reason}" + (f" ({count} frames)" if count > 1 else "") for (name, reason), count in frames.items()]


@dataclass
class Sightline:
    """A witness: a segment from one room to another through openings only."""

    rooms: tuple[int, int]
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    openings: list[int]  # in order along the segment


@dataclass
class RoomMatrix:
    method: str  # "sample" (a lower bound), "flow", "exact"
    visible: np.ndarray  # bool (rooms, rooms), symmetric
    proven: np.ndarray  # bool (rooms, rooms): with a witness
    sightlines: list[Sightline] = field(default_factory=list)
    statistics: dict[str, float] = field(default_factory=dict)
    # bool (rooms, rooms): visible, but no line clears every edge by the stated clearance; None: not told apart
    grazing: np.ndarray | None = None


@dataclass
class Cells:
    """The core's cells and portals, for drawing."""

    rooms: np.ndarray  # uint32 (cells,), 0xFFFFFFFF for the cell of an opening
    openings: np.ndarray  # uint32 (cells,)
    hulls: list[np.ndarray]  # float64 (n, 3) vertices per cell
    portals: list[np.ndarray]  # float64 (k, 3) polygon per portal
    portal_cells: np.ndarray  # uint32 (portals, 2)
    portal_openings: np.ndarray  # uint32 (portals,)


@dataclass(frozen=True)
class Measure:
    """A figure of a view, with what it means."""

    key: str
    label: str
    unit: str
    text: str
    source: str


@dataclass
class ViewPoints:
    """Measures on a grid of points at eye height."""

    points: np.ndarray  # float64 (n, 3)
    rooms: np.ndarray  # int64 (n,) into Building.rooms
    values: dict[str, np.ndarray]  # float64 (n,) by Measure.key
    spacing: float  # metres


@dataclass
class ViewMeasures:
    """What can be seen from where (view_measures.py makes them)."""

    definitions: list[Measure]
    grid: ViewPoints
    rooms: dict[str, np.ndarray]  # float64 (rooms,) by Measure.key, nan outdoors; with_view, en17037: percent of the floor
    cameras: list[dict[str, Any]]  # camera, frame, room, and a figure by Measure.key
    eye: float  # metres above the floor
    seconds: float = 0.0
    cut_short: bool = False


@dataclass
class Analysis:
    building: Building
    cells: Cells
    views: list[View] = field(default_factory=list)
    matrix: RoomMatrix | None = None
    title: str = ""
    detected: str = ""  # what Detect found, and what it had found before, as a sentence
    statistics: dict[str, float] = field(default_factory=dict)  # seconds by stage, counts, what was skipped
    measures: ViewMeasures | None = None
