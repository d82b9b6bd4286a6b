# SPDX-License-Identifier: GPL-3.0-or-later
"""The building as an extractor hands it over: rooms, openings, objects, before the core cuts rooms into cells.

Plain Python and numpy, no bpy. Every source (annotated scene, IFC, bare geometry) produces a `Building`; `assemble`
turns it into a native scene. All coordinates are float64 world metres, z up.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

INTERIOR, EXTERIOR = "interior", "exterior"
DOOR, WINDOW, HOLE, VIRTUAL = "door", "window", "hole", "virtual"
OPEN, CLOSED, GLASS = "open", "closed", "glass"
INFO, WARNING, ERROR = "info", "warning", "error"


@dataclass
class Problem:
    """Something a person should know or can mend."""

    severity: str  # INFO, WARNING, ERROR
    code: str  # stable, kebab-case: "room-not-closed", "false-portal", "opening-one-room" ...
    message: str  # one sentence with names and values
    names: list[str] = field(default_factory=list)  # objects concerned
    position: tuple[float, float, float] | None = None
    remedy: str = ""  # what the user can do


@dataclass
class Room:
    name: str
    kind: str = INTERIOR
    storey: str = ""
    source_id: str = ""  # IFC GlobalId or Blender object/collection name: joins a report with the model
    # A polyhedron, faces counter-clockwise from outside, corners as indices; not necessarily convex.
    # vertices None: a room without geometry (the exterior: everything that is in no other room).
    vertices: np.ndarray | None = None  # float64 (n, 3)
    faces: list[list[int]] | None = None  # None: the convex hull of the vertices
    long_name: str = ""
    # m: from there on up the shape may hold outdoor air too (it stands out of its roof): the outdoors aren't cut round that part.
    top: float = float("inf")


@dataclass
class Opening:
    name: str
    kind: str = HOLE  # DOOR, WINDOW, HOLE, VIRTUAL
    state: str = OPEN  # OPEN, CLOSED, GLASS
    source_id: str = ""
    rooms: tuple[int, int] | None = None  # indices into Building.rooms; None: leads nowhere (a Problem says why)
    # A thick opening is a convex body between two end polygons; it becomes a cell with two portals.
    body: np.ndarray | None = None  # float64 (n, 3) whose convex hull is the passage through the wall
    # End polygons where the body meets rooms[0] and rooms[1], float64 (k, 3) each, convex and planar.
    ends: tuple[np.ndarray, np.ndarray] | None = None
    # A thin opening (seam between touching rooms, plane drawn by the user) is one polygon and no body.
    polygon: np.ndarray | None = None  # float64 (k, 3)
    # Indices into Building.openings: of which openings this one is the air they share; it is as open as the most open of them.
    members: tuple[int, ...] = ()


@dataclass
class Object:
    """Something drawn. Several objects may share one mesh."""

    name: str
    bounds: np.ndarray  # float64 (2, 3): min, max, world
    source_id: str = ""
    mesh: str = ""  # name shared by instances
    rooms: list[int] | None = None  # None: placed by the core from its bounds
    # What of it surely blocks sight: convex polygons, float64 (n, 3) each, world; "box": all within its bounds; None: nothing known
    occluder: list[np.ndarray] | str | None = None


@dataclass
class Light:
    name: str
    position: np.ndarray  # float64 (3,)
    kind: str = "POINT"  # POINT, SPOT, AREA, SUN
    # The arguments of enfilade_native.Light (direction, radius, sides, cone ...); empty: not known, it may shine everywhere.
    form: dict[str, Any] = field(default_factory=dict)


@dataclass
class Camera:
    name: str
    matrix_world: np.ndarray  # float64 (4, 4)
    type: str = "PERSP"  # PERSP, ORTHO, PANO
    angle_x: float = 0.0  # full field of view, radians, after sensor fit
    angle_y: float = 0.0
    shift_x: float = 0.0  # fraction of the view's width / height
    shift_y: float = 0.0
    ortho_width: float = 0.0  # metres
    ortho_height: float = 0.0
    clip: tuple[float, float] = (0.1, 1000.0)


@dataclass
class Building:
    source: str  # "annotated", "ifc", "geometry"
    rooms: list[Room] = field(default_factory=list)
    openings: list[Opening] = field(default_factory=list)
    objects: list[Object] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    storeys: list[tuple[str, float]] = field(default_factory=list)  # name, elevation in metres, ascending
    problems: list[Problem] = field(default_factory=list)
    # World coordinates = the coordinates here + offset: non-zero where a model on a national grid was brought near the
    # origin so that it can be drawn in 32 bits.
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    statistics: dict[str, float] = field(default_factory=dict)  # seconds by stage of the extraction, counts
