# SPDX-License-Identifier: GPL-3.0-or-later
"""The geometry of a floor plan per storey, in metres: rooms cut at eye height, walls, openings, voids, cameras.

Drawing (sizes, colours, labels) happens in plan_drawing.py; DXF reads the same geometry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ..rules.building import CLOSED, EXTERIOR
from ..rules.names import Names
from ..rules.results import Analysis, View
from . import isovist, shapes2d

NONE = isovist.NONE
EYE = 1.5  # metres above the storey's floor: through door leaves and all but high windows
LEVEL_TOLERANCE = 0.6  # metres: floors nearer than this belong to one storey (steps, raised floors)
MOST_OUTLINED = 60  # cells of a room: the cost of finding shared edges grows with their square
NEARBY = 0.15  # of the building's longer side: cameras this near outside get room on the sheet
WALL_DEFAULT, WALL_LEAST, WALL_MOST = 0.30, 0.08, 0.60  # metres of wall drawn round rooms


@dataclass
class PlanRoom:
    index: int
    pieces: list[np.ndarray]  # convex polygons (k, 2), counter-clockwise
    outline: list[np.ndarray]  # segments (2, 2)
    resident: bool  # False: of another storey, passing through (a stair space)
    floor_outline: list[np.ndarray] = field(default_factory=list)  # where the floor differs from the cut (under slopes)


@dataclass
class PlanOpening:
    index: int
    footprint: np.ndarray  # (k, 2); k = 2 for a thin opening
    ends: list[np.ndarray]  # segments (2, 2) where it meets its rooms; thin: one
    level: str  # "cut", "above" (sill over the cut), "below", "void" (hole in this floor), "void-above" (in the ceiling)


@dataclass
class CameraViews:
    """All frames of one camera."""

    name: str
    views: list[View]
    rooms: set[int] = field(default_factory=set)
    objects: set[int] = field(default_factory=set)
    openings: set[int] = field(default_factory=set)  # looked through: as the core says, and as the plans' isovists show

    @property
    def first(self) -> View:
        return self.views[0]


@dataclass
class PlanCamera:
    group: int  # index into the list of CameraViews
    position: np.ndarray  # (2,)
    height: float
    heading: float | None
    half: float
    isovists: list[isovist.Isovist]
    path: np.ndarray  # (frames, 2)
    frames: list[int]  # of the isovists


@dataclass
class StoreyPlan:
    name: str
    elevation: float
    cut: float
    rooms: list[PlanRoom]
    openings: list[PlanOpening]
    cameras: list[PlanCamera]
    wall: float  # metres drawn round rooms
    bounds: tuple[float, float, float, float]  # x0, y0, x1, y1 with walls


def level_text(height: float) -> str:
    """A height [metres] as section and plan write it."""
    text = f"{height:+.2f} m"
    return text.replace("+", "±").replace("-", "±") if float(text[:-2]) == 0.0 else text


def group_views(analysis: Analysis) -> list[CameraViews]:
    """Views by camera, in order of appearance; frames ascending."""
    groups: dict[str, CameraViews] = {}
    for view in analysis.views:
        group = groups.setdefault(view.camera.name, CameraViews(view.camera.name, []))
        group.views.append(view)
        group.rooms.update(view.rooms)
        group.objects.update(view.objects)
        group.openings.update(view.openings)
    for group in groups.values():
        group.views.sort(key=lambda v: v.frame)
    return list(groups.values())


class Model:
    """The analysis with what every part of the report needs, worked out once."""

    def __init__(self, analysis: Analysis):
        self.analysis = analysis
        self.building = analysis.building
        rooms, cells = self.building.rooms, analysis.cells
        self.room_cells: list[list[int]] = [[] for _ in rooms]
        self.hulls = [np.asarray(h, dtype=np.float64).reshape(-1, 3) for h in cells.hulls]
        self.hulls = [h if np.isfinite(h).all() else h[np.isfinite(h).all(axis=1)] for h in self.hulls]
        for cell, room in enumerate(np.asarray(cells.rooms).tolist()):
            if room < len(rooms):
                self.room_cells[room].append(cell)
        self.room_hulls: list[list[np.ndarray]] = []
        for index, room in enumerate(rooms):
            hulls = [self.hulls[c] for c in self.room_cells[index] if len(self.hulls[c]) >= 4]
            if not hulls and room.vertices is not None:  # no cells came with the analysis: at least its convex hull
                v = np.asarray(room.vertices, dtype=np.float64).reshape(-1, 3)
                hulls = [v[np.isfinite(v).all(axis=1)]] if np.isfinite(v).all(axis=1).sum() >= 4 else []
            self.room_hulls.append(hulls)
        self.exterior = {i for i, r in enumerate(rooms) if r.kind == EXTERIOR}
        self.outdoor_cells = {c for r in self.exterior for c in self.room_cells[r]}
        leads_out = {i for i, o in enumerate(self.building.openings) if o.rooms is not None and set(o.rooms) & self.exterior}
        self.reveals = [c for c, o in enumerate(np.asarray(cells.openings).tolist()) if o in leads_out]
        self.closed = {i for i, o in enumerate(self.building.openings) if o.state == CLOSED}
        self.floor = [min((float(h[:, 2].min()) for h in hs), default=math.nan) for hs in self.room_hulls]
        self.top = [max((float(h[:, 2].max()) for h in hs), default=math.nan) for hs in self.room_hulls]
        self.names = Names(self.building)
        self.cameras = group_views(analysis)
        self.storeys = self._storeys()
        self.room_storey = self._room_storeys()
        self._sections: dict[float, isovist.Section] = {}

    # -- storeys ------------------------------------------------------------------------------------------
    def _storeys(self) -> list[tuple[str, float]]:
        """(name, floor height), ascending: as named by the model where rooms say so, else by clustering floors."""
        inside = [i for i in range(len(self.floor)) if i not in self.exterior and math.isfinite(self.floor[i])]
        named: dict[str, list[float]] = {}
        for i in inside:
            if self.building.rooms[i].storey:
                named.setdefault(self.building.rooms[i].storey, []).append(self.floor[i])
        storeys = [(name, float(np.median(floors))) for name, floors in named.items()]
        rest = sorted(self.floor[i] for i in inside if not self.building.rooms[i].storey)
        given = [(n, float(e)) for n, e in self.building.storeys if math.isfinite(e)]
        group: list[float] = []
        for z in [*rest, math.inf]:
            if group and z - group[0] > LEVEL_TOLERANCE:
                level = group[0]
                if not any(abs(level - e) <= LEVEL_TOLERANCE for _, e in storeys):
                    name = next((n for n, e in given if abs(e - level) <= LEVEL_TOLERANCE and n not in named),
                                f"Level {level_text(level)}")
                    storeys.append((name, level))
                group = []
            group.append(z)
        return sorted(storeys, key=lambda s: (s[1], s[0]))

    def _room_storeys(self) -> list[int]:
        """Index into `storeys` per room; -1 for outdoors and rooms without geometry."""
        found = []
        names = {name: i for i, (name, _) in enumerate(self.storeys)}
        for i, room in enumerate(self.building.rooms):
            if i in self.exterior:
                found.append(-1)
            elif room.storey in names:
                found.append(names[room.storey])
            elif math.isfinite(self.floor[i]) and self.storeys:
                found.append(int(np.argmin([abs(e - self.floor[i]) for _, e in self.storeys])))
            else:
                found.append(-1)
        return found

    def storey_name(self, room: int) -> str:
        s = self.room_storey[room]
        return self.storeys[s][0] if s >= 0 else self.building.rooms[room].storey

    def level(self, rooms: Iterable[int]) -> float:
        """The floor of the storey of the lowest of some rooms [metres]; nan when none has one."""
        return min((self.storeys[self.room_storey[r]][1] for r in rooms if 0 <= r < len(self.room_storey) and self.room_storey[r] >= 0), default=math.nan)

    def storey_of_height(self, z: float) -> int:
        """The storey whose floor lies nearest below z; the lowest for points below all; -1 without storeys."""
        below = [i for i, (_, e) in enumerate(self.storeys) if e <= z + 0.2]
        return (below[-1] if below else 0) if self.storeys else -1

    def section(self, height: float) -> isovist.Section:
        key = round(height, 4)
        if key not in self._sections:
            if len(self._sections) > 8:  # walks with moving eye heights: keep memory bounded
                self._sections.clear()
            self._sections[key] = isovist.Section(self.analysis.cells, self.closed, height, self.outdoor_cells, self.reveals)
        return self._sections[key]


def storey_plans(model: Model, max_isovists: int = 64) -> list[StoreyPlan]:
    """One plan per storey with rooms, ascending."""
    plans = [_storey_plan(model, s, max_isovists) for s in range(len(model.storeys))]
    drawn = [p.bounds for p in plans if p.rooms]
    around = [c.position for p in plans for c in p.cameras]
    if drawn:  # one scale and one place on the sheet for all storeys, so that they can be laid over each other
        low, high = np.min(drawn, axis=0)[:2], np.max(drawn, axis=0)[2:]
        reach = NEARBY * float((high - low).max())
        near = [q for q in around if ((q > low - reach) & (q < high + reach)).all()]
        low, high = np.min([low, *(q - 0.8 for q in near)], axis=0), np.max([high, *(q + 0.8 for q in near)], axis=0)
        for plan in plans:
            plan.bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    return plans


def _storey_plan(model: Model, s: int, max_isovists: int) -> StoreyPlan:
    name, elevation = model.storeys[s]
    above = [e for _, e in model.storeys if e > elevation + LEVEL_TOLERANCE]
    height = (min(above) - elevation) if above else math.inf
    cut = elevation + min(EYE, max(height * 0.6, 0.3))
    rooms = []
    for i, hulls in enumerate(model.room_hulls):
        if i in model.exterior or not hulls:
            continue
        resident = model.room_storey[i] == s
        if resident:
            z = cut if model.floor[i] < cut < model.top[i] else \
                model.floor[i] + min(EYE, 0.5 * (model.top[i] - model.floor[i]))
        elif model.floor[i] < elevation - 0.3 and model.top[i] > cut + 0.3:
            z = cut
        else:
            continue
        pieces = [p for p in (shapes2d.section(h, z) for h in hulls) if abs(shapes2d.area(p)) > 1e-4]
        if pieces:
            rooms.append(PlanRoom(i, pieces, shapes2d.outline(pieces) if len(pieces) <= MOST_OUTLINED else [], resident,
                                  _floor_outline(model, i, pieces) if resident else []))
    wall = _wall_thickness(model, {r.index for r in rooms})
    corners = [p for r in rooms for p in [*r.pieces, *r.floor_outline]]
    openings = _plan_openings(model, {r.index for r in rooms if r.resident}, {r.index for r in rooms}, elevation, cut)
    corners += [o.footprint for o in openings if o.level == "cut"]
    if corners:
        every = np.concatenate(corners)
        (x0, y0), (x1, y1) = every.min(axis=0) - wall, every.max(axis=0) + wall
    else:
        x0 = y0 = 0.0
        x1 = y1 = 1.0
    plan = StoreyPlan(name, elevation, cut, rooms, openings, [], wall, (float(x0), float(y0), float(x1), float(y1)))
    for g, group in enumerate(model.cameras):
        camera = _plan_camera(model, g, group, s, max_isovists)
        if camera is not None:
            plan.cameras.append(camera)
    return plan


def _floor_outline(model: Model, room: int, pieces: list[np.ndarray]) -> list[np.ndarray]:
    """The room's outline on its floor, where that is clearly larger than the cut: attics, slanted walls."""
    z = model.floor[room] + 0.05
    floor = [p for p in (shapes2d.section(h, z) for h in model.room_hulls[room]) if abs(shapes2d.area(p)) > 1e-4]
    grown = sum(abs(shapes2d.area(p)) for p in floor) > 1.05 * sum(abs(shapes2d.area(p)) for p in pieces)
    return shapes2d.outline(floor) if grown and len(floor) <= MOST_OUTLINED else []


def _wall_thickness(model: Model, shown: set[int]) -> float:
    """Metres of wall to draw round rooms: the median depth of the openings that lead outdoors, else of all."""
    outer, every = [], []
    for o in model.building.openings:
        if o.ends is None or o.rooms is None or not shown & set(o.rooms):
            continue
        a, b = (np.asarray(e, dtype=np.float64) for e in o.ends)
        d = float(np.linalg.norm(a.mean(axis=0) - b.mean(axis=0)))
        if math.isfinite(d) and abs(a[:, 2].mean() - b[:, 2].mean()) < 0.5 * max(d, 1e-9):
            every.append(d)
            if set(o.rooms) & model.exterior:
                outer.append(d)
    depth = outer or every
    return float(np.clip(np.median(depth), WALL_LEAST, WALL_MOST)) if depth else WALL_DEFAULT


def _plan_openings(model: Model, residents: set[int], shown: set[int], elevation: float, cut: float):
    found = []
    for i, o in enumerate(model.building.openings):
        polygons = [np.asarray(p, dtype=np.float64).reshape(-1, 3)
                    for p in (list(o.ends) if o.ends is not None else [o.polygon] if o.polygon is not None else [])]
        body = np.asarray(o.body, dtype=np.float64).reshape(-1, 3) if o.body is not None else None
        points = np.concatenate([*polygons, *([body] if body is not None else [])]) if polygons or body is not None else None
        if points is None or len(points) < 3 or not np.isfinite(points).all():
            continue
        sides = set(o.rooms or ())
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        flat = bool(polygons) and np.ptp(polygons[0][:, 2]) < 0.3 * max(float(np.ptp(polygons[0][:, :2], axis=0).max()), 1e-6)
        if flat:  # a hole in a slab
            if not (sides & shown) or not polygons:
                continue
            footprint = shapes2d.hull(points[:, :2])
            if abs((low + high) / 2 - elevation) < 1.0:
                found.append(PlanOpening(i, footprint, [], "void"))
            elif cut < low < cut + 4.0 and sides & residents:
                found.append(PlanOpening(i, footprint, [], "void-above"))
            continue
        if sides and not (sides & shown):
            continue
        if high < elevation - 0.3 or low > elevation + 4.0:
            continue
        if not sides & residents and not low <= cut <= high:
            continue
        level = "cut" if low <= cut <= high else "above" if low > cut else "below"
        ends = []
        for p in polygons:
            at = shapes2d.polygon_section(p, min(max(cut, float(p[:, 2].min()) + 1e-6), float(p[:, 2].max()) - 1e-6))
            if at is not None:
                ends.append(at)
        solid = body if body is not None else points
        footprint = shapes2d.section(solid, cut) if level == "cut" else shapes2d.hull(solid[:, :2])
        if len(footprint) < 2 and ends:
            footprint = ends[0]
        if len(footprint) >= 2:
            found.append(PlanOpening(i, footprint, ends, level))
    return found


def _plan_camera(model: Model, g: int, group: CameraViews, s: int, max_isovists: int) -> PlanCamera | None:
    here = []
    for view in group.views:
        m = np.asarray(view.camera.matrix_world, dtype=np.float64)
        if m.shape == (4, 4) and np.isfinite(m).all() and model.storey_of_height(float(m[2, 3])) == s:
            here.append((view, m))
    if not here:
        return None
    step = max(1, math.ceil(len(here) / max_isovists))
    views = []
    for view, m in here[::step]:
        eye, z, direction = m[:2, 3], float(m[2, 3]), isovist.heading(m)
        if direction is None or view.camera.type == "ORTHO":
            views.append(isovist.Isovist(eye, z))
            continue
        views.append(isovist.trace(model.section(z), eye, list(view.camera_cells), direction,
                                   isovist.half_angle(view.camera), z))
        group.openings |= views[-1].openings
    view, m = here[0]
    return PlanCamera(g, m[:2, 3], float(m[2, 3]), isovist.heading(m), isovist.half_angle(view.camera), views,
                      np.array([k[:2, 3] for _, k in here]), [v.frame for v, _ in here[::step]])
