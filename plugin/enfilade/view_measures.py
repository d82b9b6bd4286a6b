# SPDX-License-Identifier: GPL-3.0-or-later
"""Isovist and view measures by rays through the cells: on a grid of points, per room, per camera. No bpy.

A point sends rays all around at eye height and over the whole sphere; each walks from cell to cell until a wall, or until it leaves
through an opening to the outdoors. What is counted ends there: areas and volumes are indoor ones.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .report import shapes2d
from .rules.building import CLOSED, EXTERIOR
from .rules.results import Measure, ViewMeasures, ViewPoints

NONE = 0xFFFFFFFF
EYE = 1.2  # metres above the floor: a seated person's, as EN 17037 has it for the view out
AROUND = 360  # rays at eye height, a degree apart: the least sight angle that EN 17037 asks for is 14
SPHERE = 256  # rays over the sphere for a point of the grid
AROUND_CAMERA, SPHERE_CAMERA = 1440, 8192
MOST_POINTS = 6000  # of a grid
GRIDS = (0.25, 0.5, 1.0, 2.0)  # metres between points: the finest that stays below MOST_POINTS
FLOOR_RINGS = 24  # radii at which floor is looked for, a camera's direction
SHALLOW = 0.1  # metres: steps that hide less aren't space
UPWARD = 0.7  # a face whose normal rises by more than this is floor

MEASURES = [
    Measure("area", "Isovist area", "m²", "Indoor area in view at eye height, all around.", "Benedikt 1979"),
    Measure("mean_view", "Mean view", "m", "Mean length of the lines of sight at eye height, each as far as the wall or the opening to "
            "the outdoors where it ends.", "Batty 2001 (mean radial)"),
    Measure("longest_view", "Longest view", "m", "The longest of these lines.", "Batty 2001 (maximum radial)"),
    Measure("occlusivity", "Occlusivity", "m", "Length of the isovist's boundary that isn't wall: edges behind which more space is hidden.",
            "Benedikt 1979"),
    Measure("volume", "Volume", "m³", "Indoor volume in view, in all directions.", "Benedikt 1979, in three dimensions"),
    Measure("sight_angle", "Sight angle", "°", "Sum of the horizontal directions at eye height that lead outdoors through glass or an open "
            "door. EN 17037 asks for 14° (minimum), 28° (medium), 54° (high).", "EN 17037:2018, view out"),
    Measure("outside", "Outside", "%", "Share of all directions, of the whole sphere, that leads outdoors.", "Ladybug: view percent"),
]
SIGHT_ANGLES = ((14.0, "minimum"), (28.0, "medium"), (54.0, "high"))  # degrees, EN 17037

Progress = Callable[[float, str], Any]


def sphere(count: int) -> np.ndarray:
    """Directions of equal shares of the sphere, float64 (count, 3) (Fibonacci lattice; A. Gonzalez 2010)."""
    i = np.arange(count) + 0.5
    z = 1.0 - 2.0 * i / count
    turn = math.pi * (1.0 + math.sqrt(5.0)) * i
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def ring(count: int) -> np.ndarray:
    """Level directions, float64 (count, 3). None along an axis, where walls run."""
    t = 2.0 * math.pi * (np.arange(count) + 0.5) / count
    return np.stack([np.cos(t), np.sin(t), np.zeros(count)], axis=1)


@dataclass
class _Rays:
    """Where rays end: distance indoors, and whether they leave to the outdoors."""

    distance: np.ndarray  # float64 (points, directions)
    outdoors: np.ndarray  # bool
    surface: np.ndarray  # uint32


@dataclass
class Surveyor:
    """Rays of one analyser's scene. While it works, openings that lead outdoors stand shut in the scene: a ray that meets such a leaf has
    left through it."""

    native: Any
    analyser: Any
    raycaster: Any = None
    leads_out: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))  # by portal
    shut: list[tuple[int, str]] = field(default_factory=list)

    def __enter__(self) -> Surveyor:
        analyser, building = self.analyser, self.analyser.building
        outdoors = {i for i, r in enumerate(building.rooms) if r.kind == EXTERIOR}
        ways = {i for i, o in enumerate(building.openings) if o.rooms is not None and set(o.rooms) & outdoors
                and analyser.scene.opening(i)[1] != CLOSED}
        self.leads_out = np.isin(analyser.portal_openings, list(ways))
        self.raycaster = self.native.Raycaster(analyser.scene)
        for i in sorted(ways):
            self.shut.append((i, analyser.scene.opening(i)[1]))
            analyser.scene.set_opening_state(i, CLOSED)
        return self

    def __exit__(self, *_: object) -> None:
        for i, state in self.shut:
            self.analyser.scene.set_opening_state(i, state)
        self.raycaster.close()

    def shoot(self, points: np.ndarray, cells: np.ndarray, directions: np.ndarray) -> _Rays:
        """points: (n, 3) in `cells` (n,). directions: (m, 3) for every point, or (n, m, 3)."""
        n, m = len(points), directions.shape[-2]
        ways = np.broadcast_to(directions, (n, m, 3)).reshape(-1, 3)
        hits = self.raycaster.shoot(np.repeat(points, m, axis=0), ways, cells=np.repeat(cells, m))
        surface, distance = hits["surface"], hits["distance"].copy()
        portal = surface.astype(np.int64) - self.raycaster.face_count
        leaf = (surface != NONE) & (portal >= 0) & (portal < len(self.leads_out))
        out = np.zeros(len(surface), dtype=bool)
        out[leaf] = self.leads_out[portal[leaf]]
        # What meets nothing left through a portal that is no opening, straight to the outdoors: as far as is known, nothing of it is indoors.
        nothing = ~np.isfinite(distance)
        distance[nothing] = 0.0
        return _Rays(distance.reshape(n, m), (out | nothing).reshape(n, m), surface.reshape(n, m))

    # -- measures -------------------------------------------------------------------------------------------

    def measure(self, points: np.ndarray, cells: np.ndarray, around: int = AROUND, over: int = SPHERE) -> dict[str, np.ndarray]:
        """Every measure of MEASURES at points (n, 3), float64 (n,) each; and `two_ways`: lines out at least 90 degrees apart."""
        level = self.shoot(points, cells, ring(around))
        whole = self.shoot(points, cells, sphere(over))
        step = 2.0 * math.pi / around
        r = level.distance
        following = np.roll(r, -1, axis=1)
        # An occluding edge: the farther ray goes on behind the plane that the nearer one met. In a corner it ends before that plane.
        ways = ring(around)
        normals = self.raycaster.normals(level.surface.reshape(-1)).reshape(*r.shape, 3)
        edge = _behind(r, following, normals, ways, np.roll(ways, -1, axis=0))
        edge |= _behind(following, r, np.roll(normals, -1, axis=1), np.roll(ways, -1, axis=0), ways)
        gap = np.abs(following - r)
        out = level.outdoors
        quarter = max(1, around // 4)
        apart = np.zeros(len(points), dtype=bool)
        for turn in range(quarter, around // 2 + 1):
            apart |= (out & np.roll(out, turn, axis=1)).any(axis=1)
        return {
            "area": 0.5 * step * (r**2).sum(axis=1),
            "mean_view": r.mean(axis=1),
            "longest_view": r.max(axis=1),
            "occlusivity": np.where(edge, gap, 0.0).sum(axis=1),
            "volume": 4.0 * math.pi / over / 3.0 * (whole.distance**3).sum(axis=1),
            "sight_angle": 360.0 / around * out.sum(axis=1),
            "outside": 100.0 * whole.outdoors.mean(axis=1),
            "two_ways": apart.astype(np.float64),
        }

    def floor_area(self, point: np.ndarray, cell: int, height: float, around: int = 360) -> float:
        """Square metres of floor in view from a point `height` above it: rings on the floor, looked for along each direction."""
        level = self.shoot(point[None], np.array([cell], np.uint32), ring(around))
        reach = level.distance[0]
        radius = (np.arange(FLOOR_RINGS) + 0.5) / FLOOR_RINGS * reach[:, None]
        flat = ring(around)[:, None, :2] * radius[..., None]
        ways = np.concatenate([flat, np.full((*radius.shape, 1), -height)], axis=2).reshape(1, -1, 3)
        found = self.shoot(point[None], np.array([cell], np.uint32), ways)
        floor = ((self.raycaster.normals(found.surface[0])[:, 2] > UPWARD) & (found.surface[0] < self.raycaster.face_count)).reshape(radius.shape)
        return float((floor * radius * (reach[:, None] / FLOOR_RINGS)).sum() * 2.0 * math.pi / around)


def _behind(near: np.ndarray, far: np.ndarray, normals: np.ndarray, near_ways: np.ndarray, far_ways: np.ndarray) -> np.ndarray:
    """Whether rays (n, m) end farther along far_ways (m, 3) than the planes that their neighbours met at `near`. bool (n, m)."""
    along = near * np.einsum("nmk,mk->nm", normals, near_ways)
    speed = np.einsum("nmk,mk->nm", normals, far_ways)
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = along / speed
    return (far > near) & (speed != 0.0) & (plane > 0.0) & (far > plane + SHALLOW)


def _grid(analyser: Any, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points at eye height over the floors of the rooms, with their cells and rooms: (n, 3), (n,), (n,). Every room has one at least."""
    from .rules.assemble import cells_of

    hulls = cells_of(analyser.made).hulls
    points, cells, rooms = [], [], []
    for room, own in enumerate(analyser.made.room_cells):
        if analyser.building.rooms[room].kind == EXTERIOR:
            continue
        shapes = [(c, hulls[c]) for c in own if len(hulls[c]) >= 4]
        if not shapes:
            continue
        floor, top = min(h[:, 2].min() for _, h in shapes), max(h[:, 2].max() for _, h in shapes)
        z = floor + min(EYE, 0.5 * (top - floor))
        before = len(points)
        cut = [(c, shapes2d.section(h, z)) for c, h in shapes]
        cut = [(c, p) for c, p in cut if len(p) >= 3 and abs(shapes2d.area(p)) > 1e-3]
        for c, polygon in cut:
            low, high = np.floor(polygon.min(axis=0) / spacing), np.ceil(polygon.max(axis=0) / spacing)
            x, y = (np.arange(low[k], high[k]) * spacing + 0.5 * spacing for k in (0, 1))
            mesh = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
            for q in mesh[shapes2d.contains(polygon, mesh, 0.05)]:  # metres off the walls: nobody's eye is nearer
                points.append((q[0], q[1], z))
                cells.append(c)
                rooms.append(room)
        if len(points) == before and cut:
            c, polygon = max(cut, key=lambda p: abs(shapes2d.area(p[1])))
            points.append((*shapes2d.centroid(polygon), z))
            cells.append(c)
            rooms.append(room)
    return np.array(points, np.float64).reshape(-1, 3), np.array(cells, np.uint32), np.array(rooms, np.int64)


def survey(native: Any, analyser: Any, views: list[Any] = (), spacing: float = 0.0, progress: Progress | None = None) -> ViewMeasures:
    """All measures of a building. spacing: metres between points, 0: the finest of GRIDS that isn't too many points. progress may
    return False: what is measured by then stays."""
    begin = time.perf_counter()
    for wanted in (spacing,) if spacing > 0.0 else GRIDS:
        points, cells, rooms = _grid(analyser, wanted)
        if len(points) <= MOST_POINTS:
            break
    names = [m.key for m in MEASURES] + ["two_ways"]
    values: dict[str, list[np.ndarray]] = {n: [] for n in names}
    done = 0
    cameras: list[dict[str, Any]] = []
    with Surveyor(native, analyser) as rays:
        for first in range(0, len(points), 256):
            part = slice(first, first + 256)
            found = rays.measure(points[part], cells[part])
            for n in names:
                values[n].append(found[n])
            done = min(first + 256, len(points))
            if progress is not None and progress(done / len(points), "measuring views") is False:
                break
        for view in views:
            row = _camera(rays, view)
            if row is not None:
                cameras.append(row)
    grid = ViewPoints(points[:done], rooms[:done],
                      {n: np.concatenate(values[n]) if values[n] else np.zeros(0) for n in names}, wanted)
    return ViewMeasures(MEASURES, grid, _rooms(grid, len(analyser.building.rooms)), cameras, EYE, time.perf_counter() - begin,
                        done < len(points))


def _rooms(grid: ViewPoints, count: int) -> dict[str, np.ndarray]:
    """Means of a room's points; `with_view`: share of its floor from which somebody sees out, `en17037`: that reaches the minimum angle."""
    out = {n: np.full(count, np.nan) for n in (*grid.values, "with_view", "en17037", "points")}
    for room in np.unique(grid.rooms).tolist():
        own = grid.rooms == room
        for n, v in grid.values.items():
            out[n][room] = v[own].max() if n == "longest_view" else v[own].mean()
        out["with_view"][room] = 100.0 * (grid.values["sight_angle"][own] > 0).mean()
        out["en17037"][room] = 100.0 * (grid.values["sight_angle"][own] >= SIGHT_ANGLES[0][0]).mean()
        out["points"][room] = own.sum()
    return out


def _camera(rays: Surveyor, view: Any) -> dict[str, Any] | None:
    """A camera's own figures: all around its eye, whatever it looks at; None where no room holds it."""
    eye = np.asarray(view.camera.matrix_world, dtype=np.float64)[:3, 3]
    if not np.isfinite(eye).all():
        return None
    inside = [c for c in rays.analyser.scene.locate(eye) if rays.analyser.cell_rooms[c] != NONE
              and rays.analyser.building.rooms[int(rays.analyser.cell_rooms[c])].kind != EXTERIOR]
    if not inside:
        return None
    cell = int(inside[0])
    found = rays.measure(eye[None], np.array([cell], np.uint32), AROUND_CAMERA, SPHERE_CAMERA)
    down = rays.shoot(eye[None], np.array([cell], np.uint32), np.array([[0.0, 0.0, -1.0]]))
    return {"camera": view.camera.name, "frame": view.frame, "room": int(rays.analyser.cell_rooms[cell]),
            **{k: float(v[0]) for k, v in found.items()},
            "floor_area": rays.floor_area(eye, cell, max(float(down.distance[0, 0]), 0.05))}


