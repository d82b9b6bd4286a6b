# SPDX-License-Identifier: GPL-3.0-or-later
"""Building to answers: what shots see, what to keep for light, which rooms see which. No bpy.

An `Analyser` holds the committed scene and makes engines when a question first needs them. Every fallback errs towards
visible and is counted in `statistics`.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from .rules.assemble import Assembled, assemble, cells_of
from .rules.building import EXTERIOR, Building, Camera
from .rules.results import Analysis, RoomMatrix, Sightline, View

NONE = 0xFFFFFFFF
VIEW_METHODS = {"portal": "clip", "clip": "clip", "box": "box", "frustum": "frustum"}
OCCLUDERS = ("off", "on", "auto")  # as the core numbers them
EXACTLY = 1  # how the core looks from outdoors: what is listed is drawn, which costs more than to know it
WALL = 0.6  # metres that a surface as drawn may lie behind the cell's face
# Sightlines listed in a matrix at most: beyond, a report would be unreadable; the matrix itself is always whole.
MOST_SIGHTLINES = 20_000

Progress = Callable[[float, str], Any]


class AnalysisError(RuntimeError):
    """The core refused a question; the message is its sentence."""


@dataclass
class Shot:
    """One picture: the camera, or its poses while the shutter is open, at one frame."""

    name: str
    frame: int
    poses: list[Camera]
    # The eye is anywhere this near the pose (metres): lens with depth of field, stereo pair. 0: a pinhole.
    eye_radius: float = 0.0
    # Both eyes of a stereo pair, one pose: these look, exactly, and `poses` holds the camera between them.
    eyes: list[Camera] = field(default_factory=list)

    @property
    def camera(self) -> Camera:
        return self.poses[len(self.poses) // 2]


@dataclass
class Keep:
    """What must stay in the scene for one or more shots."""

    objects: np.ndarray  # int64, ascending indices into Building.objects
    cells: np.ndarray  # uint32, ascending: where these are
    seen: int = 0  # of the objects, those that the camera sees itself
    notes: list[str] = field(default_factory=list)


class Analyser:
    def __init__(self, native: Any, building: Building, occluders: str = "off", distance: float = math.inf):
        """occluders: off, on or auto: whether marked objects hide what stands behind them, for single poses. distance: metres from
        the eye beyond which nothing counts as seen (fog)."""
        self.native = native
        self.occluders = occluders
        self.distance = distance
        self.building = building
        self.made: Assembled = assemble(native, building)
        self.scene = self.made.scene
        counts = self.scene.counts
        self.cell_rooms = np.array(self.scene.cell_rooms)
        self.cell_openings = np.array(self.scene.cell_openings)
        self.portal_openings = np.array(self.scene.portal_openings)
        self.portal_cells = np.array(self.scene.portal_cells)
        self.statistics: dict[str, float] = {
            "cells": counts.cells,
            "portals": counts.portals,
            "objects": counts.objects,
            "assemble_s": self.made.seconds,
        }
        self._view: Any = None
        self._rows: dict[int, np.ndarray] = {}  # PVS row by cell, as far as asked for
        self._region_works = True
        self._region: Any = None  # the last whole exact bake: what other door states are asked against
        self._object_cells: tuple[np.ndarray, np.ndarray] | None = None
        self._boxes: np.ndarray | None = None  # of cells
        self._bounds: np.ndarray | None = None  # of building objects

    def close(self) -> None:
        self._view = None
        self._region = None
        self.scene.close()

    @property
    def problems(self):
        return self.made.problems

    def set_state(self, opening: int, state: str) -> None:
        """Opens or closes one opening. What was known about regions is forgotten."""
        self.scene.set_opening_state(opening, state)
        self._rows.clear()

    # ---- what a shot sees ----

    def look(self, shot: Shot, method: str = "portal", why: bool = True) -> View:
        """The answer for one shot. method: portal (= clip), clip, box, frustum, pluecker."""
        if method == "pluecker":
            return self._look_from_region(shot)
        engine = VIEW_METHODS[method]
        try:
            if self._view is None:
                self._view = self.native.View(self.scene)
            result = self._query(shot, engine)
        except self.native.EnfError as error:
            raise AnalysisError(f"{shot.name}, frame {shot.frame}: {error}") from error
        return self.as_view(shot, engine, result, why)

    def _query(self, shot: Shot, engine: str) -> Any:
        view, options = self._view, {"method": engine, "distance_limit": self.distance, "outdoors": EXACTLY}
        if shot.eyes:
            return view.query_union(shot.eyes, occluders=OCCLUDERS.index(self.occluders), **options)
        if shot.eye_radius > 0.0:
            eyes = np.array([p.matrix_world[:3, 3] for p in shot.poses])
            bounds = np.stack([eyes.min(axis=0) - shot.eye_radius, eyes.max(axis=0) + shot.eye_radius])
            # moving and out of focus: whatever direction
            return view.query_region(bounds, look=shot.poses[0] if len(shot.poses) == 1 else None, **options)
        if len(shot.poses) > 1:
            return view.query_union(shot.poses[:16], swept=True, **options)
        return view.query(shot.poses[0], occluders=OCCLUDERS.index(self.occluders), **options)

    def as_view(self, shot: Shot, engine: str, result: Any, why: bool) -> View:
        """The core's answer in indices of the building. why: also through which openings."""
        openings = self._openings_by_step(result) if why else {}
        rooms: dict[int, list[int]] = {}
        for room, step in zip(self.cell_rooms[result.cells].tolist(), result.cell_step.tolist(), strict=True):
            if room != NONE and room not in rooms:
                rooms[room] = openings.get(step, [])
        seen = self.made.building_objects[result.objects].tolist()
        reasons = {o: openings.get(s, []) for o, s in zip(seen, result.object_step.tolist(), strict=True)} if why else {}
        starts = result.step_cell[result.step_parent == NONE].tolist()
        stats = {k: int(v) for k, v in result.stats.items() if isinstance(v, int)}
        return View(
            camera=shot.camera,
            frame=shot.frame,
            method=engine,
            camera_cells=sorted(set(starts)),
            cells=sorted(result.cells.tolist()),
            rooms=sorted(rooms),
            objects=sorted({*seen, *self.made.left_out}),
            why=reasons,
            room_why=rooms if why else {},
            openings=self._openings_passed(result) if why else [],
            microseconds=float(result.stats.get("microseconds", 0.0)),
            counters=stats,
        )

    def _openings_passed(self, result: Any) -> list[int]:
        """The openings that some step leads out of: who only looks into a door's recess doesn't look through the door."""
        crossed = result.step_portal != NONE
        openings = self.portal_openings[result.step_portal[crossed]].tolist()
        into = self.cell_openings[result.step_cell[crossed]].tolist()
        return sorted({o for o, recess in zip(openings, into, strict=True) if o not in (NONE, recess)})

    def _openings_by_step(self, result: Any) -> dict[int, list[int]]:
        """Openings from the camera to each step, seams left out, one opening's two portals counted once."""
        known: dict[int, list[int]] = {NONE: []}
        parents, portals = result.step_parent.tolist(), result.step_portal.tolist()
        for step in range(len(parents)):
            chain = [step]
            while parents[chain[-1]] not in known:
                chain.append(parents[chain[-1]])
            for s in reversed(chain):
                way = known[parents[s]]
                opening = NONE if portals[s] == NONE else int(self.portal_openings[portals[s]])
                known[s] = way + [opening] if opening != NONE and (not way or way[-1] != opening) else way
        return known

    def _look_from_region(self, shot: Shot) -> View:
        begin = time.perf_counter()
        starts: set[int] = set()
        for pose in shot.eyes or shot.poses:
            starts.update(int(c) for c in self.scene.locate(pose.matrix_world[:3, 3]))
        if shot.eye_radius > 0.0 or len(shot.poses) > 1 or not starts:
            # the eye is no single point: start from every cell that the from-point engine starts from
            begin_view = self.look(replace(shot, name=shot.name), "clip", why=False)
            starts.update(begin_view.camera_cells)
        return self._seen_from_cells(shot, starts, begin)

    def _seen_from_cells(self, shot: Shot, starts: set[int], begin: float) -> View:
        cells = self.pvs(starts)
        return View(
            camera=shot.camera,
            frame=shot.frame,
            method="pluecker",
            camera_cells=sorted(starts),
            cells=[int(c) for c in cells],
            rooms=sorted({int(r) for r in self.cell_rooms[cells] if r != NONE}),
            objects=[int(o) for o in self.objects_in(cells)],
            microseconds=1e6 * (time.perf_counter() - begin),
        )

    def look_from_room(self, shot: Shot) -> View:
        """What is seen from anywhere in the rooms where the shot's eyes are: of every cell of these rooms."""
        begin = time.perf_counter()
        here = {int(c) for pose in shot.eyes or shot.poses for c in self.scene.locate(pose.matrix_world[:3, 3])}
        rooms = {int(self.cell_rooms[c]) for c in here} - {NONE}
        starts = here | {int(c) for c in np.nonzero(np.isin(self.cell_rooms, list(rooms)))[0]}
        if not starts:
            raise AnalysisError(f"{shot.name} is in no room")
        return self._seen_from_cells(shot, starts, begin)

    # ---- regions ----

    def pvs(self, cells: Iterable[int], time_limit: float = 0.0) -> np.ndarray:
        """Cells seen from anywhere in `cells` (themselves among them), ascending uint32. Without a region engine:
        whatever is connected by open portals, which contains it (counted as `pvs_by_connection`)."""
        wanted = sorted({int(c) for c in cells})
        missing = [c for c in wanted if c not in self._rows]
        if missing and self._region_works:
            try:
                found = self.native.region.run(self.scene, method="exact", from_cells=missing, time_limit=time_limit)
                for cell in missing:
                    self._rows[cell] = np.array(found.row(cell))
                stats = found.stats
                self.statistics["pvs_s"] = self.statistics.get("pvs_s", 0.0) + float(stats.get("wall_s", 0.0))
                self.statistics["pvs_undecided"] = self.statistics.get("pvs_undecided", 0) + float(
                    stats.get("undecided_pairs", 0)
                )
                missing = []
            except self.native.EnfError:
                self._region_works = False
                self.statistics["pvs_by_connection"] = 1
        if missing:
            return self._connected(wanted)
        rows = [self._rows[c] for c in wanted]
        return np.unique(np.concatenate(rows)) if rows else np.zeros(0, dtype=np.uint32)

    def _connected(self, cells: list[int]) -> np.ndarray:
        count = len(self.cell_rooms)
        passes = np.ones(len(self.portal_cells), dtype=bool)
        for i, opening in enumerate(self.portal_openings.tolist()):
            if opening != NONE and self.scene.opening(opening)[1] == "closed":
                passes[i] = False
        pairs = self.portal_cells[passes].astype(np.int64)
        seen = np.zeros(count, dtype=bool)
        seen[cells] = True
        while True:
            before = int(seen.sum())
            seen[pairs[seen[pairs[:, 0]], 1]] = True
            seen[pairs[seen[pairs[:, 1]], 0]] = True
            if int(seen.sum()) == before:
                return np.nonzero(seen)[0].astype(np.uint32)

    def objects_in(self, cells: np.ndarray) -> np.ndarray:
        """Building objects drawn in any of the cells, with those that are in no cell at all (always kept)."""
        if self._object_cells is None:
            owners, where = [], []
            for i in range(int(self.scene.counts.objects)):
                found = self.scene.object_cells(i)
                owners += [i] * len(found)
                where += [int(c) for c in found]
            self._object_cells = np.array(owners, dtype=np.int64), np.array(where, dtype=np.int64)
        owners, where = self._object_cells
        mask = np.zeros(len(self.cell_rooms), dtype=bool)
        mask[np.asarray(cells, dtype=np.int64)] = True
        inside = np.unique(owners[mask[where]]) if len(where) else np.zeros(0, dtype=np.int64)
        placed = np.zeros(len(self.made.building_objects), dtype=bool)
        placed[owners] = True
        chosen = np.concatenate([inside, np.nonzero(~placed)[0]])
        return np.unique(np.concatenate([self.made.building_objects[chosen], np.array(self.made.left_out, dtype=np.int64)]))

    # ---- light ----

    def keep(self, views: list[View], what: str = "camera", sky: bool = True) -> Keep:
        """What must stay for these views. what: camera, shadow, bounces=N.

        sky: whether light comes from outdoors (a sun, a world that isn't black).
        shadow: also what may stand between a light and a visible cell that it reaches (`_shadowing`); a sky's light comes through
        the cells that the visible ones see, so all of those stay.
        bounces=N: the cells seen N times over from the visible ones, and the shadows cast into them: every path of N bounces
        runs in them, since each leg of a path lies between two cells that see each other.
        """
        seen_objects = np.unique(np.array([o for v in views for o in v.objects], dtype=np.int64))
        cells = np.unique(np.array([c for v in views for c in v.cells], dtype=np.uint32))
        out = Keep(seen_objects, cells, seen=len(seen_objects))
        if what == "camera" or not len(cells):
            return out
        if what.startswith("bounces="):
            for _ in range(int(what[8:])):
                wider = self._bounced(cells)
                if len(wider) == len(cells):
                    break
                cells = wider
        objects = [seen_objects, self.objects_in(cells) if what != "shadow" else seen_objects]
        extra: list[np.ndarray] = []
        # A sky lights from every side: whatever the visible cells see may stand in its way. A sun alone shines along one direction.
        lights = [light for light in self.building.lights if light.kind != "SUN" or not sky]
        for lit_cells, lit_objects in self._shadowing(cells.astype(np.int64), seen_objects, [_native_light(self.native, light) for light in lights]):
            objects.append(lit_objects)
            extra.append(lit_cells)
        if sky:
            around = self._bounced(cells)
            exterior = [i for i, r in enumerate(self.building.rooms) if r.kind == EXTERIOR]
            if np.isin(self.cell_rooms[around], exterior).any():
                objects.append(self.objects_in(around))
                extra.append(around)
        out.objects = np.unique(np.concatenate(objects))
        out.cells = np.unique(np.concatenate([cells, *extra])).astype(np.uint32)
        if self.statistics.get("pvs_by_connection"):
            out.notes.append("no from-region engine: whatever is connected by open doors counts as seen")
        return out

    def _bounced(self, cells: np.ndarray) -> np.ndarray:
        """What is seen from anywhere in the cells, as far as light gets from there. The recess of a shut door is one cell, seen from both
        sides, and so sees both: what only lies beyond the leaf is left out."""
        shut = np.zeros(len(self.cell_rooms), dtype=bool)
        for i, opening in enumerate(self.cell_openings.tolist()):
            shut[i] = opening != NONE and self.scene.opening(opening)[1] == "closed"
        wider = self.pvs(cells.tolist())
        if not shut[cells].any() or shut[cells].all():
            return wider
        near = np.zeros(len(self.cell_rooms), dtype=bool)
        near[self._connected(cells[~shut[cells]].tolist())] = True
        return wider[near[wider] | shut[wider]]

    def keep_lit(self, views: list[View], lights: Any, light_sets: Any) -> np.ndarray:
        """What the views see, and what may stand between that and the lamps that reach it: ascending building objects."""
        seen = np.unique(np.array([o for v in views for o in v.objects], dtype=np.int64))
        cells = np.unique(np.array([c for v in views for c in v.cells], dtype=np.int64))
        return np.unique(np.concatenate([seen, *(o for _, o in self._shadowing(cells, seen, lights, light_sets))]))

    def _shadowing(self, cells: np.ndarray, seen: np.ndarray, lights: list[Any], light_sets: Any = None):
        """For each light (enfilade_native.Light) that may reach any of the cells: the cells it may reach at all, and the objects that may
        stand between it and those asked about.

        A body that shades a point of such a cell lies in a cell that the light reaches too, since the way from the light to it is free;
        and in the hull of the light and the cell: outside the box round both it shades nothing. Walls as drawn may stand in the thickness
        of a cell's wall: cells count as that much larger. Outdoors, where the cell has no shape, what is lit are the objects seen.
        """
        if not len(cells) or not lights:
            return
        if light_sets is None:
            light_sets = self.native.LightSets(self.scene, lights)
        mask = np.zeros(len(self.cell_rooms), dtype=bool)
        mask[cells] = True
        boxes, bounds = self._cell_boxes(), self._object_bounds()
        shaped = np.isfinite(boxes).all(axis=(1, 2))
        for i, light in enumerate(lights):
            reached = light_sets.cells_of(i)
            lit = reached[mask[reached]]
            if len(lit):
                objects = self.objects_in(reached.astype(np.uint32))
                targets = boxes[lit[shaped[lit]]] + np.array([[-WALL], [WALL]])
                if not shaped[lit].all():
                    targets = np.concatenate([targets, bounds[seen]])
                yield reached, objects[self._between(objects, light, _fewer(targets))]

    def _object_bounds(self) -> np.ndarray:
        """float64 (objects of the building, 2, 3)."""
        if self._bounds is None:
            self._bounds = np.array([o.bounds for o in self.building.objects], dtype=np.float64).reshape(-1, 2, 3)
        return self._bounds

    def _cell_boxes(self) -> np.ndarray:
        """float64 (cells, 2, 3); cells without a shape reach everywhere."""
        if self._boxes is None:
            self._boxes = np.empty((len(self.cell_rooms), 2, 3))
            self._boxes[:, 0], self._boxes[:, 1] = -np.inf, np.inf
            first, vertices = np.array(self.scene.cell_vertex_first).astype(np.int64), np.array(self.scene.cell_vertices)
            for c in range(len(self.cell_rooms)):
                if first[c + 1] > first[c]:
                    own = vertices[first[c] : first[c + 1]]
                    self._boxes[c] = own.min(axis=0), own.max(axis=0)
        return self._boxes

    def _between(self, objects: np.ndarray, light: Any, targets: np.ndarray) -> np.ndarray:
        """Whether each object's bounds may lie between the light and any of the boxes (m, 2, 3). bool (objects,)."""
        bounds = self._object_bounds()[objects]
        found = ~np.isfinite(bounds).all(axis=(1, 2))
        if light.kind == "SUN":
            for target in targets:
                found |= _sun_sweeps(bounds, target, light)
            return found
        reach = np.abs(np.array(light.sides)).sum(axis=0) + light.radius
        low = np.minimum(np.array(light.position) - reach, targets[:, 0])
        high = np.maximum(np.array(light.position) + reach, targets[:, 1])
        for a, b in zip(low, high, strict=True):
            found |= ((bounds[:, 0] <= b) & (bounds[:, 1] >= a)).all(axis=1)
        return found

    # ---- rooms ----

    def room_matrix(self, method: str = "exact", time_limit: float = 0.0, progress: Progress | None = None) -> RoomMatrix:
        """Which room sees which from anywhere. method: sample, flow, exact. Progress may return False to cancel: then what
        isn't decided counts as seen."""

        def tell(p: Any) -> Any:
            return True if progress is None else progress(p.fraction, p.phase or "who sees whom")

        try:
            result = self.native.region.run(self.scene, progress=tell, **self._bake_options(method, time_limit))
        except self.native.EnfError as error:
            raise AnalysisError(f"who sees whom: {error}") from error
        return self.matrix_of(result, method)

    def _bake_options(self, method: str, time_limit: float) -> dict[str, Any]:
        """With a bake of other door states at hand only what the doors can change is asked again."""
        options: dict[str, Any] = {"method": method, "time_limit": time_limit}
        if method == "exact" and self._region is not None:
            options["variant_of"] = self._region
        return options

    def kept_rows(self) -> bytes | None:
        """The last whole exact bake as the bytes of a state file, to be kept with the scene."""
        if self._region is None:
            return None
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rows.state"
            self._region.save(path)
            return path.read_bytes()

    def take_rows(self, state: bytes) -> RoomMatrix | None:
        """The matrix out of kept_rows() of the same building, brought up to date where doors have changed since. None: it belongs
        to another building."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rows.state"
            path.write_bytes(state)
            try:
                self._region = self.native.region.load(self.scene, path)
                return self.room_matrix("exact")
            except (AnalysisError, self.native.EnfError):
                self._region = None
                return None

    def start_matrix(self, method: str = "exact", time_limit: float = 0.0) -> Any:
        """The same in the background: a job to poll, cancel and take from; its result goes to `matrix_of`."""
        try:
            return self.native.region.start(self.scene, **self._bake_options(method, time_limit))
        except self.native.EnfError as error:
            raise AnalysisError(f"who sees whom: {error}") from error

    def matrix_of(self, result: Any, method: str) -> RoomMatrix:
        """The rooms' matrix of a finished (or cancelled) bake of this scene."""
        rooms = len(self.building.rooms)
        visible = np.zeros((rooms, rooms), dtype=bool)
        proven = np.zeros((rooms, rooms), dtype=bool)
        first = np.array(result.row_first).astype(np.int64)
        source = np.repeat(np.arange(len(first) - 1), np.diff(first))
        target = np.array(result.row_cells).astype(np.int64)
        status = np.array(result.row_status)
        stopped = bool(result.stats["interrupted"])
        for cell in range(len(first) - 1):
            if stopped and cell in self._rows:
                continue  # a whole row is known already
            self._rows[cell] = target[first[cell] : first[cell + 1]].astype(np.uint32)
        if method == "exact" and not stopped:
            self._region = result
        if method == "sample":
            self._rows.clear()  # a lower bound must never be used to hide
        a, b = self.cell_rooms[source], self.cell_rooms[target]
        real = (a != NONE) & (b != NONE)
        visible[a[real], b[real]] = True
        sure = real & (status == 1)
        proven[a[sure], b[sure]] = True
        grazing = np.zeros((rooms, rooms), dtype=bool)  # where no pair of their cells is seen clear of every edge
        touching = real & (status == 2)
        grazing[a[touching], b[touching]] = True
        grazing &= ~proven
        shown: dict[tuple[int, int], tuple[int, int]] = {}
        for i in np.nonzero(real & ((status == 1) | (status == 2)))[0]:
            pair = int(a[i]), int(b[i])
            if pair[0] < pair[1] and pair not in shown and len(shown) < MOST_SIGHTLINES:
                shown[pair] = int(source[i]), int(target[i])
        sightlines = []
        for pair, ends in sorted(shown.items()):
            witness = result.witness(*ends)
            if witness is None:
                continue
            way: list[int] = []
            for portal in witness.portals:
                opening = int(self.portal_openings[portal])
                if opening != NONE and (not way or way[-1] != opening):
                    way.append(opening)
            sightlines.append(
                Sightline(pair, tuple(float(x) for x in witness.start), tuple(float(x) for x in witness.end), way)
            )
        stats = {k: float(v) for k, v in result.stats.items()}
        clear = proven | proven.T
        return RoomMatrix(method, visible | visible.T, clear, sightlines, stats, (grazing | grazing.T) & ~clear)

    def analysis(self, views: list[View], matrix: RoomMatrix | None = None, title: str = "") -> Analysis:
        self.building.problems = list(self.made.problems)
        return Analysis(self.building, cells_of(self.made), views, matrix, title, statistics=dict(self.statistics))


MOST_TARGETS = 48  # boxes that a light's way is looked at to: more are joined


def _fewer(boxes: np.ndarray) -> np.ndarray:
    """At most MOST_TARGETS boxes that cover all of these (m, 2, 3): neighbours along the longest side joined."""
    if len(boxes) <= MOST_TARGETS:
        return boxes
    middle = boxes.mean(axis=1)
    order = np.argsort(middle[:, int(np.argmax(np.ptp(middle, axis=0)))], kind="stable")
    parts = np.array_split(boxes[order], MOST_TARGETS)
    return np.stack([np.stack([p[:, 0].min(axis=0), p[:, 1].max(axis=0)]) for p in parts])


def _native_light(native: Any, light: Any) -> Any:
    """The core's light of a building's. What it gives doesn't matter here; one whose form isn't known is a bulb that shines everywhere."""
    if light.form:
        return native.Light(**{**light.form, "intensity": (1.0, 1.0, 1.0)})
    return native.Light("POINT", tuple(np.asarray(light.position, dtype=np.float64).tolist()), radius=1e-3)


def _sun_sweeps(bounds: np.ndarray, target: np.ndarray, light: Any) -> np.ndarray:
    """Whether boxes (n, 2, 3) meet the target (2, 3) swept towards the sun: a ray among the differences of both. bool (n,)."""
    towards = -np.array(light.direction, dtype=np.float64)
    towards /= np.linalg.norm(towards)
    low, high = bounds[:, 0] - target[1], bounds[:, 1] - target[0]
    if not np.isfinite(target).all():
        return np.ones(len(bounds), dtype=bool)
    # A sun with a size: the farther, the wider. Boxes grow by as much as the ray may have turned when it reaches them.
    spread = math.tan(light.radius) * np.linalg.norm(np.maximum(np.abs(low), np.abs(high)), axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - spread) / towards, (high + spread) / towards
    inside = (low - spread <= 0) & (high + spread >= 0)
    flat = np.broadcast_to(towards == 0.0, low.shape)
    enter = np.where(flat, np.where(inside, -np.inf, np.inf), np.minimum(a, b)).max(axis=1)
    leave = np.where(flat, np.where(inside, np.inf, -np.inf), np.maximum(a, b)).min(axis=1)
    return leave >= np.maximum(enter, 0.0)


def widened(camera: Camera, slope: float) -> Camera:
    """The camera with a field wider by `slope` (tangent) on every side: what an eye beside it still looks at."""
    if slope <= 0.0 or camera.type != "PERSP":
        return camera
    wide_x = math.tan(0.5 * camera.angle_x)
    wide_y = math.tan(0.5 * camera.angle_y)
    new_x, new_y = wide_x + slope, wide_y + slope
    return replace(
        camera,
        angle_x=2.0 * math.atan(new_x),
        angle_y=2.0 * math.atan(new_y),
        # the shift is a fraction of the view's width, which has grown
        shift_x=camera.shift_x * wide_x / new_x,
        shift_y=camera.shift_y * wide_y / new_y,
    )
