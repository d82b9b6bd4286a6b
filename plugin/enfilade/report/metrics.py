# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures per room, each with a definition, a unit and a source.

The graph measures stand on the *room graph of visibility*: one node a room indoors, an edge where two rooms see each
other (DESIGN.md section 6). They follow B. Hillier, J. Hanson, "The Social Logic of Space" (1984), ch. 3, which
A. Turner et al., "From isovists to visibility graphs" (2001), carried over to visibility.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from . import shapes2d
from .plan import NONE, Model

MOST_ROOMS = 6000  # graph measures cost rooms^2 words and rooms^3 / 64 steps; beyond, they are left out and said so
BITS = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1).sum(axis=1, dtype=np.uint16)  # set in a byte
FLOOR_SLICE = 0.10  # metres above a room's lowest point: over thresholds and skirtings, under sloped ceilings


@dataclass(frozen=True)
class Definition:
    key: str
    label: str
    unit: str
    text: str
    source: str = ""


HH = "Hillier & Hanson 1984"
DEFINITIONS = [
    Definition("area_m2", "Area", "m²", "Floor area: horizontal section 0.10 m above the room's lowest point."),
    Definition("volume_m3", "Volume", "m³", "Sum of the volumes of the room's convex cells."),
    Definition("seen_by", "Seen by", "cameras", "Cameras that see into the room in at least one frame."),
    Definition("sees_outdoors", "Outdoors", "", "Whether a line of sight leads from somewhere in the room to the outdoors, "
               "through whatever openings; without a room matrix: whether the room has a glazed or open opening to it."),
    Definition("glazed_openings", "Glazed", "count", "Openings of the room with glass."),
    Definition("openings", "Openings", "count", "Doors, windows, holes and virtual boundaries of the room."),
    Definition("rooms_seen", "Rooms seen", "count", "Rooms indoors, other than itself, that can be seen from somewhere in the "
               "room (visual connectivity: the node's degree in the room graph of visibility).", "Turner et al. 2001"),
    Definition("visual_mean_depth", "Mean depth", "steps", "Mean number of visual steps (looks round a corner, the first look "
               "included) to every room that can be reached by looking.", HH),
    Definition("visual_integration", "Integration", "ratio", "1 / RRA, where RA = 2 (MD - 1) / (k - 2) over the k rooms of the "
               "connected part and RRA = RA / D(k), D(k) = 2 (k (log2((k + 2) / 3) - 1) + 1) / ((k - 1)(k - 2)). High: "
               "few looks away from everything. Empty for k < 3; infinite where every room is seen directly (written inf).", HH),
    Definition("control", "Control", "sum", "Sum over the rooms seen of 1 / (rooms that these see): above 1 the room overlooks "
               "its surroundings more than it is overlooked.", HH),
    Definition("clustering", "Clustering", "0..1", "Share of the pairs of rooms seen that see each other: near 1 the room looks "
               "into one visual space, low values join several. Empty below two rooms seen.", "Watts & Strogatz 1998"),
    Definition("entrance_depth", "Depth", "openings", "Openings to pass from outdoors (open or closed, windows not counted)."),
    Definition("picture_area_m2", "Floor in the picture", "m²", "Part of the isovist within the camera's angle of view: the area "
               "drawn on its plan, cut exactly from the cells at its eye height. The isovist itself, all around and by rays, is "
               "under Isovist area. Furniture doesn't count in either.", "Benedikt 1979"),
]


@dataclass
class RoomFigures:
    """Arrays over Building.rooms; NaN or -1 where a figure doesn't apply."""

    area: np.ndarray
    volume: np.ndarray
    seen_by: list[list[str]]
    sees_outdoors: list[bool | None]
    glazed: list[list[int]]
    openings: list[list[int]]
    rooms_seen: np.ndarray
    mean_depth: np.ndarray
    integration: np.ndarray
    control: np.ndarray
    clustering: np.ndarray
    entrance_depth: np.ndarray
    note: str = ""


# Status of a pair of rooms
HIDDEN, SEEN, GRAZING, UNPROVEN = 0, 1, 2, 3
STATUS_WORDS = {HIDDEN: "hidden", SEEN: "visible", GRAZING: "grazing", UNPROVEN: "not proven"}


def pair_status(model: Model) -> np.ndarray | None:
    """uint8 (rooms, rooms): HIDDEN, SEEN (a sightline proves it), GRAZING, UNPROVEN (counts as visible); None: no matrix."""
    matrix = model.analysis.matrix
    if matrix is None:
        return None
    n = len(model.building.rooms)
    visible = np.asarray(matrix.visible, dtype=bool)
    if visible.shape != (n, n):
        return None
    status = np.where(visible, UNPROVEN, HIDDEN).astype(np.uint8)
    proven = np.asarray(matrix.proven, dtype=bool)
    if proven.shape == (n, n):
        status[visible & proven] = SEEN
    grazing = getattr(matrix, "grazing", None)
    if grazing is not None and np.shape(grazing) == (n, n):
        status[visible & np.asarray(grazing, dtype=bool)] = GRAZING
    np.fill_diagonal(status, SEEN)
    return status


HONESTY = {
    "sample": "A lower bound: every pair marked is proven by a sightline that was found; pairs not marked may see each other too.",
    "flow": "Conservative: no pair that sees each other is missing; some of those not proven may in truth be hidden.",
    "exact": "Exact: pairs marked visible have a sightline, pairs not marked are certified hidden; grazing and undecided pairs "
             "count as visible and are marked as such.",
}


def room_figures(model: Model) -> RoomFigures:
    """Everything the rooms table shows. Linear but for the graph measures."""
    rooms = model.building.rooms
    n = len(rooms)
    area, volume = np.full(n, np.nan), np.full(n, np.nan)
    for i, hulls in enumerate(model.room_hulls):
        if i in model.exterior or not hulls:
            continue
        z = model.floor[i] + min(FLOOR_SLICE, 0.5 * (model.top[i] - model.floor[i]))
        area[i] = sum(abs(shapes2d.area(shapes2d.section(h, z))) for h in hulls)
        volume[i] = sum(shapes2d.hull_volume(h) for h in hulls)
    openings: list[list[int]] = [[] for _ in range(n)]
    glazed: list[list[int]] = [[] for _ in range(n)]
    direct: list[bool] = [False] * n
    for k, o in enumerate(model.building.openings):
        for r in set(o.rooms or ()):
            if 0 <= r < n:
                openings[r].append(k)
                if o.state == "glass":
                    glazed[r].append(k)
                if o.state != "closed" and any(s in model.exterior for s in o.rooms or ()):
                    direct[r] = True
    seen_by = [[g.name for g in model.cameras if i in g.rooms] for i in range(n)]
    status = pair_status(model)
    outside = sorted(model.exterior)
    if status is not None and outside:
        sees: list[bool | None] = [bool((status[i, outside] > 0).any()) for i in range(n)]
    else:
        sees = list(direct)
    figures = RoomFigures(area, volume, seen_by, sees, glazed, openings, np.full(n, -1), *(np.full(n, np.nan) for _ in range(4)),
                          _entrance_depth(model))
    if status is not None:
        _graph_measures(model, status, figures)
    return figures


def _graph_measures(model: Model, status: np.ndarray, out: RoomFigures) -> None:
    inside = np.array([i for i in range(len(model.building.rooms)) if i not in model.exterior], dtype=int)
    k = len(inside)
    if k == 0:
        return
    near = status[np.ix_(inside, inside)] > 0
    np.fill_diagonal(near, False)
    degree = near.sum(axis=1)
    out.rooms_seen[inside] = degree
    share = np.divide(1.0, degree, out=np.zeros(k), where=degree > 0)
    out.control[inside] = near @ share
    if k > MOST_ROOMS:
        out.note = f"Depth, integration and clustering are left out above {MOST_ROOMS} rooms."
        return
    packed = np.packbits(near, axis=1)
    common = [int(BITS[packed[near[i]] & packed[i]].sum()) for i in range(k)]  # neighbours that its neighbours share with it
    out.clustering[inside] = np.where(degree > 1, common / np.maximum(degree * (degree - 1.0), 1), np.nan)
    for i in range(k):
        reached = np.zeros(k, dtype=bool)
        reached[i] = True
        front, depth, total = np.array([i]), 0, 0
        while len(front):
            row = np.unpackbits(np.bitwise_or.reduce(packed[front], axis=0), count=k).astype(bool) & ~reached
            front, depth = np.nonzero(row)[0], depth + 1
            reached |= row
            total += depth * len(front)
        size = int(reached.sum())
        if size < 2:
            continue
        mean = total / (size - 1)
        out.mean_depth[inside[i]] = mean
        if size > 2:
            ra = 2 * (mean - 1) / (size - 2)
            d = 2 * (size * (math.log2((size + 2) / 3) - 1) + 1) / ((size - 1) * (size - 2))
            out.integration[inside[i]] = math.inf if ra <= 1e-12 else d / ra


def _entrance_depth(model: Model) -> np.ndarray:
    """Openings between outdoors and each room, windows not walked through; -1 unreachable."""
    n = len(model.building.rooms)
    depth = np.full(n, -1)
    links: dict[int, list[int]] = {}
    for o in model.building.openings:
        if o.rooms and o.kind != "window" and all(0 <= r < n for r in o.rooms):
            a, b = o.rooms
            links.setdefault(a, []).append(b)
            links.setdefault(b, []).append(a)
    front = sorted(model.exterior)
    depth[front] = 0
    while front:
        step = sorted({b for a in front for b in links.get(a, ()) if depth[b] < 0})
        for b in step:
            depth[b] = depth[front[0]] + 1
        front = step
    return depth


def sightlines_by_pair(model: Model) -> dict[tuple[int, int], list[int]]:
    """(low room, high room) -> indices into matrix.sightlines."""
    found: dict[tuple[int, int], list[int]] = {}
    if model.analysis.matrix is not None:
        for k, s in enumerate(model.analysis.matrix.sightlines):
            a, b = sorted(int(r) for r in s.rooms)
            found.setdefault((a, b), []).append(k)
    return found


@dataclass
class Overlook:
    """A private room and someone who can look into it."""

    room: int
    from_room: int
    from_name: str
    openings: list[int]
    status: str
    advice: str


PRIVATE = ("bed", "bath", "wc", "toilet", "shower", "restroom", "changing", "dressing", "schlaf", "bad", "dusche", "umkleide",
           "chambre", "bain", "baño", "dormitorio", "sanitär", "lavatory", "ward", "treatment", "examination")


def is_private(name: str) -> bool:
    """A room people expect not to be looked into, by its name. Words are matched from their start ("bad" not in "Abbad")."""
    words = "".join(c.lower() if c.isalnum() else " " for c in name).split()
    return any(w.startswith(p) and (len(p) > 3 or len(w) <= len(p) + 6) for w in words for p in PRIVATE)


def overlooked(model: Model, most: int = 500) -> list[Overlook]:
    """Who can see into private rooms and through which openings; what closing them would change."""
    status = pair_status(model)
    lines = sightlines_by_pair(model)
    found = []
    for i, room in enumerate(model.building.rooms):
        if i in model.exterior or not (is_private(room.long_name) or is_private(room.name)):
            continue
        if status is None:
            for group in model.cameras:
                if i in group.rooms:
                    way = next((v.room_why[i] for v in group.views if i in v.room_why), [])
                    found.append(Overlook(i, -1, f"camera {group.name}", list(way), "visible", _advice(model, way)))
            continue
        for j in np.nonzero(status[i])[0].tolist():
            if j == i or len(found) >= most:
                continue
            recorded = lines.get((min(i, j), max(i, j)), [])
            way = list(model.analysis.matrix.sightlines[recorded[0]].openings) if recorded else []
            found.append(Overlook(i, j, model.names.room(j), way, STATUS_WORDS[int(status[i, j])], _advice(model, way)))
    return found


def _advice(model: Model, way) -> str:
    openings = model.building.openings
    doors = [model.names.opening(o) for o in way if o < len(openings) and openings[o].kind == "door"]
    glass = [model.names.opening(o) for o in way if o < len(openings) and openings[o].kind == "window"]
    if doors:
        return f"Shutting {doors[0]} closes this line"
    if glass:
        return f"A blind or obscured glass at {glass[0]} closes this line"
    return "No door or window on the way to shut" if way else ""


def own_rooms(model: Model, view) -> set[int]:
    """The rooms a view's camera stands in."""
    rooms = np.asarray(model.analysis.cells.rooms)
    return {int(rooms[c]) for c in view.camera_cells if c < len(rooms) and int(rooms[c]) != NONE}
