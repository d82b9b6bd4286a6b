# SPDX-License-Identifier: GPL-3.0-or-later
"""A file's previews: which objects, lights and lenses each camera's picture needs, rendered by the core's rays.

Only what a camera sees, or what may stand between that and a lamp, is read from the file: the cost follows the picture, not the building.
"""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ..analysis import Analyser, AnalysisError
from ..rules.building import Building, Camera
from . import cull, extract_drawn
from .cameras import raster_of, read_camera, read_eyes
from .shots import shot_of

EYES = ("left", "right")  # Blender's names of a stereo pair's views
MOST_BESIDE = 2000  # objects out of sight that are read for their shadows alone, and thrice what is seen: the largest, walls and roofs
MOST_SIDE = 16384  # pixels
BYTES_A_PIXEL = 420  # at the peak, with every pass and the EXR: measured


def free_bytes() -> int:
    """Memory that may be taken now; 0 where the system doesn't tell."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            return next((1024 * int(line.split()[1]) for line in file if line.startswith("MemAvailable:")), 0)
    except (OSError, ValueError):
        return 0


def too_large(width: int, height: int) -> str:
    """Why a picture of so many pixels can't be made; empty: it can."""
    if not (0 < width <= MOST_SIDE and 0 < height <= MOST_SIDE):
        return f"{width} x {height}: pictures of 1 to {MOST_SIDE} pixels a side are possible"
    need, free = BYTES_A_PIXEL * width * height, free_bytes()
    if free and need > free:
        return f"{width} x {height} pixels take {need / 2**30:.1f} GiB and {free / 2**30:.1f} are free: ask for a smaller picture"
    return ""


@dataclass
class Preview:
    camera: str
    seen_from: Camera
    layers: Any  # enfilade_native.Layers
    names: list[str]  # object number -> name; empty where the cells were drawn
    cells_only: bool
    seconds: dict[str, float] = field(default_factory=dict)  # by stage
    counts: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    triangles: Any = None  # what was loaded for it
    soup: list[np.ndarray] = field(default_factory=list)  # the same for who checks it, float64 (n, 3, 3) each


def largest_first(objects: np.ndarray, building: Building, most: int) -> tuple[np.ndarray, int, float]:
    """Of objects at most that many, the largest by the diagonal of their bounds; how many are left out, and the largest of these (metres)."""
    if len(objects) <= most:
        return objects, 0, 0.0
    bounds = np.array([building.objects[i].bounds for i in objects], dtype=np.float64)
    size = np.linalg.norm(bounds[:, 1] - bounds[:, 0], axis=1)
    order = np.argsort(-size, kind="stable")
    return objects[order[:most]], len(objects) - most, float(size[order[most]])


class Previewer:
    """Everything that several pictures of one file share. building None: no rooms are known; then all that is drawn is loaded."""

    def __init__(self, native: Any, scene: bpy.types.Scene, building: Building | None, *, cells_only: bool = False, lit: bool = True,
                 threads: int = 0, keep_soup: bool = False, options: dict[str, Any] | None = None):
        self.native, self.scene, self.building = native, scene, building
        self.keep_soup = keep_soup
        self.cells_only, self.threads, self.options = cells_only and building is not None, threads, dict(options or {})
        self.analyser = Analyser(native, building) if building is not None else None
        self.raycaster = native.Raycaster(self.analyser.scene) if self.analyser else None
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.lights = extract_drawn.lights(native, depsgraph) if lit else []
        begin = time.perf_counter()
        self.light_sets = native.LightSets(self.analyser.scene, self.lights) if self.analyser and self.lights else None
        self.seconds = {"light_sets": time.perf_counter() - begin}
        self.notes: list[str] = []
        self._cache: dict = {}

    def close(self) -> None:
        if self.analyser is not None:
            self.raycaster.close()
            self.analyser.close()

    def wanted(self, shot: Any) -> tuple[set[str] | None, np.ndarray]:
        """Names of the objects that the shot's picture needs (None: all), and the middle of what it sees."""
        eye = np.asarray(shot.camera.matrix_world, dtype=np.float64)[:3, 3]
        if self.analyser is None:
            return None, np.round(eye)
        view = self.analyser.look(shot, why=False)
        keep = np.array(view.objects, dtype=np.int64)
        if self.lights:
            whole = self.analyser.keep_lit([view], self.lights, self.light_sets)
            beside, left, most = largest_first(np.setdiff1d(whole, keep), self.building, MOST_BESIDE + 3 * len(keep))
            if left:  # a sun over a large building
                self.notes.append(f"{shot.name}: shadows of {left:,} objects out of sight are left out, none of which measures more "
                                  f"than {most:.2g} m")
            keep = np.union1d(keep, beside)
        return cull.names_of(self.building, keep) | {o.name_full for o in self.scene.objects if o.name_full not in self._known()}, np.round(eye)

    def _known(self) -> set[str]:
        """Objects that detection could place: the others (unsure bounds, hidden in the viewport) are always loaded."""
        if "known" not in self._cache:
            self._cache["known"] = {o.source_id for o in self.building.objects}
        return self._cache["known"]

    def prepare(self, obj: bpy.types.Object, width: int, height: int, eye: str = "") -> Callable[..., Preview]:
        """Reads what the camera's picture needs, as it all stands in the current frame, the lens a pinhole. eye: one of EYES, of a camera
        that has such (`eyes`); else the camera between them. AnalysisError: the picture is too large. What comes back renders it:
        run(progress) touches no Blender data and may run in a thread; progress(fraction) returning False stops it, keeping what there is."""
        if reason := too_large(width, height):
            raise AnalysisError(reason)
        begin = time.perf_counter()
        seconds: dict[str, float] = {}
        self.notes = []
        shot = shot_of(self.scene, obj)
        panorama, name = self.panorama(obj), f"{obj.name} {eye}" if eye else obj.name
        camera = self.eyes(obj)[EYES.index(eye)] if eye else self.read(obj)
        drawn = None
        if not self.cells_only:
            wanted, origin = self.wanted(shot)
            seconds["look"] = time.perf_counter() - begin
            drawn = extract_drawn.extract(self.native, bpy.context.evaluated_depsgraph_get(), wanted, origin,
                                          self._cache.setdefault("ignored", extract_drawn.helpers(self.scene)), keep=self.keep_soup)
            seconds["load"] = drawn.seconds

        notes = list(self.notes)

        def run(progress: Callable[[float], Any] | None = None) -> Preview:
            start = time.perf_counter()
            triangles = drawn.triangles if drawn is not None else None
            picture = self.native.Picture(self.raycaster, triangles, self.lights, self.light_sets, self.threads, **self.options)
            layers = picture.render(camera, width, height, panorama, progress=progress)
            seconds["render"] = time.perf_counter() - start
            if drawn is None:
                return Preview(name, camera, layers, [], True, seconds, dict(layers.counts))
            counts = {**layers.counts, "objects": len(drawn.names), **{k: triangles.counts[k] for k in ("triangles", "bytes")}}
            return Preview(name, camera, layers, drawn.names, False, seconds, counts, [*notes, *drawn.notes], triangles, drawn.soup)

        return run

    def render(self, obj: bpy.types.Object, width: int, height: int, progress: Callable[[float], Any] | None = None,
               eye: str = "") -> Preview:
        return self.prepare(obj, width, height, eye)(progress)

    def depth_beside(self, made: Preview, pixels: tuple[float, float]) -> np.ndarray | None:
        """The depth layer of a picture again, its rays that many pixels right and up; None for panoramas, which can't be shifted."""
        camera = copy.copy(made.seen_from)
        if camera.type == "PANO":
            return None
        h, w = made.layers.depth.shape
        camera.shift_x += pixels[0] / w
        camera.shift_y += pixels[1] / h
        picture = self.native.Picture(self.raycaster if self.cells_only else None, made.triangles, threads=self.threads,
                                      ambient_samples=0, max_bounces=0)
        return picture.render(camera, w, h, edges=False).depth

    def read(self, obj: bpy.types.Object) -> Camera:
        return read_camera(self.scene, obj, bpy.context.evaluated_depsgraph_get())

    def eyes(self, obj: bpy.types.Object) -> list[Camera]:
        """Those of a stereo camera, as EYES names them; none where the scene isn't rendered in stereo, or the camera can't be told apart."""
        return [] if obj.data.type == "PANO" else read_eyes(self.scene, obj, bpy.context.evaluated_depsgraph_get())

    def panorama(self, obj: bpy.types.Object) -> Any:
        """The panorama's own settings; None for cameras that have none."""
        data = obj.data
        if data.type != "PANO":
            return None
        s = data if hasattr(data, "panorama_type") else data.cycles  # moved out of Cycles' settings in 5.0
        kind = s.panorama_type
        wide, tall = (s.longitude_min, s.longitude_max), (s.latitude_min, s.latitude_max)
        if kind == "CENTRAL_CYLINDRICAL":  # from 4.3
            wide = (s.central_cylindrical_range_u_min, s.central_cylindrical_range_u_max)
            radius = max(1e-9, s.central_cylindrical_radius)
            tall = (s.central_cylindrical_range_v_min / radius, s.central_cylindrical_range_v_max / radius)
        elif kind not in self.native.preview.PANORAMAS:
            self.notes.append(f"{obj.name}: panoramas of type {kind} aren't known; drawn all around, as equirectangular")
            kind = "EQUIRECTANGULAR"
        return self.native.Panorama(
            kind,
            tuple(float(v) for v in wide),
            tuple(float(v) for v in tall),
            float(s.fisheye_fov) if math.isfinite(s.fisheye_fov) else math.pi,
            float(s.fisheye_lens),
            self._sensor(data),
            tuple(float(getattr(s, f"fisheye_polynomial_k{k}")) for k in range(5)),
        )

    def _sensor(self, data: bpy.types.Camera) -> tuple[float, float]:
        """The sensor as the picture's shape cuts it: the fitted side as it is, the other by the picture's proportions. Millimetres."""
        raster = raster_of(self.scene)
        x, y = raster.width * raster.aspect_x, raster.height * raster.aspect_y
        level = x > y if data.sensor_fit == "AUTO" else data.sensor_fit == "HORIZONTAL"
        size = float(data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width)
        return (size, size * y / x) if level else (size * x / y, size)

    def room_of(self, layers: Any) -> np.ndarray:
        """The room of each pixel, int64 (h, w); -1: outdoors without a cell, openings' own thickness, nothing."""
        if self.analyser is None:
            return np.full(layers.cell.shape, -1, dtype=np.int64)
        rooms = np.append(self.analyser.cell_rooms.astype(np.int64), -1)
        rooms[rooms == 0xFFFFFFFF] = -1
        return rooms[np.minimum(layers.cell.astype(np.int64), len(rooms) - 1)]
