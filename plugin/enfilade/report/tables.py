# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's figures as CSV files and one JSON file, to compute with.

CSV: UTF-8, comma separated, one header line, decimal points, empty where a figure doesn't apply. Rooms, openings and
objects carry their number from 1 as in the report, their name and `source_id`, which joins them with the model.
"""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np

from ..rules.whole_file import whole_file
from . import metrics, shapes2d
from .metrics import STATUS_WORDS, RoomFigures
from .plan import Model

FORMAT, VERSION = "enfilade-report", 1
MOST_DENSE = 2048  # rooms: a larger dense matrix.csv opens in no spreadsheet; pairs.csv holds every pair at any size


def value(x):
    """A cell of a table: figures short, NaN and "doesn't apply" empty."""
    if type(x) is int:  # most cells
        return x
    if x is None:
        return ""
    if isinstance(x, bool | np.bool_):
        return "yes" if x else "no"
    if isinstance(x, float | np.floating):
        if math.isnan(x):
            return ""
        return "inf" if math.isinf(x) else f"{float(x):.6g}"
    if isinstance(x, str):
        # Spreadsheets run cells that start like a formula; a room's name must stay a name.
        text = x.replace("\x00", " ")
        return "'" + text if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text
    return x


def write_csv(path: Path, header: list[str], rows) -> Path:
    with whole_file(path) as partial, open(partial, "w", encoding="utf-8", newline="", errors="replace") as file:
        out = csv.writer(file)
        out.writerow(header)
        out.writerows([value(x) for x in row] for row in rows)
    return path


def _way(model: Model, openings) -> str:
    """Opening names in order, nearest first."""
    known = model.building.openings
    return " > ".join(known[o].name if 0 <= o < len(known) else f"#{o}" for o in openings)


def rooms_table(model: Model, f: RoomFigures):
    header = ["number", "name", "long_name", "storey", "kind", "area_m2", "volume_m3", "floor_m", "openings", "glazed_openings",
              "seen_by_cameras", "seen_by", "sees_outdoors", "rooms_seen", "visual_mean_depth", "visual_integration", "control",
              "clustering", "entrance_depth", "cells", "source_id"]
    rows = []
    for i, r in enumerate(model.building.rooms):
        inside = i not in model.exterior
        rows.append([i + 1, r.name, r.long_name, model.storey_name(i), r.kind, f.area[i], f.volume[i], model.floor[i],
                     len(f.openings[i]), len(f.glazed[i]), len(f.seen_by[i]), "; ".join(f.seen_by[i]),
                     f.sees_outdoors[i] if inside else None, f.rooms_seen[i] if f.rooms_seen[i] >= 0 else None,
                     f.mean_depth[i], f.integration[i], f.control[i], f.clustering[i],
                     f.entrance_depth[i] if f.entrance_depth[i] >= 0 else None, len(model.room_cells[i]), r.source_id])
    return header, rows


def opening_size(o) -> tuple[float, float, float, float]:
    """(width, height, sill height, depth) [metres]: of the end towards the first room; NaN when not known."""
    polygon = o.ends[0] if o.ends is not None else o.polygon if o.polygon is not None else o.body
    if polygon is None or len(polygon) == 0:
        return (math.nan,) * 4
    p = np.asarray(polygon, dtype=np.float64).reshape(-1, 3)
    d = p[:, None, :2] - p[None, :, :2]
    depth = float(np.linalg.norm(np.mean(o.ends[0], axis=0) - np.mean(o.ends[1], axis=0))) if o.ends is not None else math.nan
    if np.ptp(p[:, 2]) < 0.3 * np.ptp(p[:, :2], axis=0).max():  # lies flat (a hole in a slab): longest side by the other
        ring = shapes2d.hull(p[:, :2])
        sides = np.hypot(*(shapes2d.following(ring) - ring).T) if len(ring) > 2 else np.zeros(1)
        width = float(sides.max())
        return width, abs(shapes2d.area(ring)) / width if width > 0 else math.nan, float(p[:, 2].min()), depth
    return float(np.sqrt((d**2).sum(axis=2)).max()), float(np.ptp(p[:, 2])), float(p[:, 2].min()), depth


def looking_through(model: Model) -> dict[int, list[str]]:
    """opening -> cameras whose look passes it."""
    found: dict[int, list[str]] = {}
    for group in model.cameras:
        for o in group.openings:
            found.setdefault(o, []).append(group.name)
    return found


def openings_table(model: Model):
    header = ["number", "name", "kind", "state", "room_a", "room_b", "width_m", "height_m", "sill_z_m", "depth_m",
              "looked_through_by", "source_id"]
    looking = looking_through(model)
    rooms = model.building.rooms
    rows = []
    for i, o in enumerate(model.building.openings):
        a, b = (rooms[r].name if 0 <= r < len(rooms) else "" for r in (o.rooms or (-1, -1)))
        rows.append([i + 1, o.name, o.kind, o.state, a, b, *opening_size(o),
                     "; ".join(looking.get(i, ())), o.source_id])
    return header, rows


def views_table(model: Model, picture_areas: dict[str, float]):
    header = ["camera", "frame", "method", "x_m", "y_m", "z_m", "rooms", "objects", "cells", "microseconds", "picture_area_m2"]
    rows = []
    for v in model.analysis.views:
        m = np.asarray(v.camera.matrix_world, dtype=np.float64)
        position = m[:3, 3] if m.shape == (4, 4) else (math.nan,) * 3
        rows.append([v.camera.name, v.frame, v.method, *(float(x) for x in position), len(v.rooms), len(v.objects), len(v.cells),
                     v.microseconds, picture_areas.get((v.camera.name, v.frame))])
    return header, rows


def view_rooms_table(model: Model):
    rooms = model.building.rooms
    for v in model.analysis.views:
        for r in v.rooms:
            if 0 <= r < len(rooms):
                yield [v.camera.name, v.frame, r + 1, rooms[r].name, model.storey_name(r), _way(model, v.room_why.get(r, ()))]


VIEW_ROOMS = ["camera", "frame", "room_number", "room", "storey", "through"]
VIEW_OBJECTS = ["camera", "frame", "object_number", "object", "through", "source_id"]
PAIRS = ["room_a_number", "room_a", "room_b_number", "room_b", "status", "through"]
SIGHTLINES = ["room_a", "room_b", "start_x_m", "start_y_m", "start_z_m", "end_x_m", "end_y_m", "end_z_m", "length_m", "through"]


def view_objects_rows(model: Model):
    objects = model.building.objects
    for v in model.analysis.views:
        for o in v.objects:
            if 0 <= o < len(objects):
                yield [v.camera.name, v.frame, o + 1, objects[o].name, _way(model, v.why.get(o, ())), objects[o].source_id]


def pairs_rows(model: Model, status: np.ndarray, lines: dict):
    rooms = model.building.rooms
    for i, j in zip(*np.nonzero(np.triu(status, 1)), strict=False):
        i, j = int(i), int(j)
        recorded = lines.get((i, j))
        way = _way(model, model.analysis.matrix.sightlines[recorded[0]].openings) if recorded else ""
        yield [i + 1, rooms[i].name, j + 1, rooms[j].name, STATUS_WORDS[int(status[i, j])], way]


def sightline_rows(model: Model):
    rooms = model.building.rooms
    for s in model.analysis.matrix.sightlines if model.analysis.matrix else ():
        a, b = (rooms[r].name if 0 <= r < len(rooms) else "" for r in s.rooms)
        yield [a, b, *map(float, s.start), *map(float, s.end), math.dist(s.start, s.end), _way(model, s.openings)]


PROBLEMS = ["severity", "code", "message", "remedy", "names", "x_m", "y_m", "z_m"]


def problem_rows(model: Model):
    for p in model.building.problems:
        yield [p.severity, p.code, p.message, p.remedy, "; ".join(p.names), *(map(float, p.position) if p.position is not None else ("",) * 3)]


def write_tables(model: Model, f: RoomFigures, out: Path, picture_areas: dict) -> list[Path]:
    """All CSV files; returns their paths."""
    paths = [
        write_csv(out / "rooms.csv", *rooms_table(model, f)),
        write_csv(out / "openings.csv", *openings_table(model)),
        write_csv(out / "views.csv", *views_table(model, picture_areas)),
        write_csv(out / "view_rooms.csv", VIEW_ROOMS, view_rooms_table(model)),
        write_csv(out / "view_objects.csv", VIEW_OBJECTS, view_objects_rows(model)),
        write_csv(out / "sightlines.csv", SIGHTLINES, sightline_rows(model)),
        write_csv(out / "problems.csv", PROBLEMS, problem_rows(model)),
    ]
    status = metrics.pair_status(model)
    if status is not None:
        lines = metrics.sightlines_by_pair(model)
        paths.append(write_csv(out / "pairs.csv", PAIRS, pairs_rows(model, status, lines)))
        if len(status) <= MOST_DENSE:
            names = [r.name for r in model.building.rooms]
            rows = ([name, *row] for name, row in zip(names, status.tolist(), strict=False))
            paths.append(write_csv(out / "matrix.csv", ["room", *(value(n) for n in names)], rows))
    return paths


def plain(x):
    """What JSON can hold: NaN as null, infinity as a word, numpy as lists."""
    if isinstance(x, dict):
        return {str(k): plain(v) for k, v in x.items()}
    if isinstance(x, list | tuple | set):
        return [plain(v) for v in (sorted(x) if isinstance(x, set) else x)]
    if isinstance(x, np.ndarray):
        return x.tolist() if x.dtype.kind in "iub" else plain(x.tolist())
    if isinstance(x, bool | np.bool_):
        return bool(x)
    if isinstance(x, int | np.integer):
        return int(x)
    if isinstance(x, float | np.floating):
        return None if math.isnan(x) else ("inf" if x > 0 else "-inf") if math.isinf(x) else float(x)
    return x if x is None or isinstance(x, str) else str(x)


def report_dict(model: Model, f: RoomFigures, picture_areas: dict) -> dict:
    """The whole report as one object; indices are from 0, into `rooms`, `openings`, `objects`."""
    from . import view_maps

    b, a = model.building, model.analysis
    status = metrics.pair_status(model)
    rooms = [{
        "name": r.name, "long_name": r.long_name, "kind": r.kind, "storey": model.storey_name(i), "source_id": r.source_id,
        "area_m2": f.area[i], "volume_m3": f.volume[i], "openings": f.openings[i], "glazed_openings": f.glazed[i],
        "seen_by": f.seen_by[i], "sees_outdoors": f.sees_outdoors[i], "rooms_seen": f.rooms_seen[i] if f.rooms_seen[i] >= 0 else None,
        "visual_mean_depth": f.mean_depth[i], "visual_integration": f.integration[i], "control": f.control[i],
        "clustering": f.clustering[i], "entrance_depth": f.entrance_depth[i] if f.entrance_depth[i] >= 0 else None,
    } for i, r in enumerate(b.rooms)]
    openings = []
    for o in b.openings:
        width, height, sill, depth = opening_size(o)
        openings.append({"name": o.name, "kind": o.kind, "state": o.state, "rooms": list(o.rooms) if o.rooms else None,
                         "width_m": width, "height_m": height, "sill_z_m": sill, "depth_m": depth, "source_id": o.source_id})
    views = [{
        "camera": v.camera.name, "frame": v.frame, "method": v.method, "rooms": v.rooms, "objects": v.objects,
        "openings": v.openings, "room_why": v.room_why, "why": v.why, "microseconds": v.microseconds, "counters": v.counters,
        "picture_area_m2": picture_areas.get((v.camera.name, v.frame)),
    } for v in a.views]
    matrix = None
    if status is not None:
        matrix = {
            "method": a.matrix.method, "meaning": metrics.HONESTY.get(a.matrix.method, ""),
            "pairs": {word: np.argwhere(np.triu(status == code, 1)) for code, word in STATUS_WORDS.items() if code},
            "statistics": a.matrix.statistics,
            "sightlines": [{"rooms": s.rooms, "start": s.start, "end": s.end, "openings": s.openings}
                           for s in a.matrix.sightlines],
        }
    return plain({
        "format": FORMAT, "version": VERSION, "title": a.title, "source": b.source, "detected": a.detected,
        "definitions": {d.key: {"unit": d.unit, "text": d.text, "source": d.source} for d in metrics.DEFINITIONS},
        "storeys": [{"name": n, "floor_z_m": z} for n, z in model.storeys],
        "rooms": rooms, "openings": openings,
        "objects": [{"name": o.name, "mesh": o.mesh, "source_id": o.source_id} for o in b.objects],
        "cameras": [g.name for g in model.cameras], "views": views, "matrix": matrix,
        "views_from_everywhere": None if a.measures is None else view_maps.as_dict(model, a.measures),
        "overlooked": [vars(o) for o in metrics.overlooked(model)],
        "problems": [{"severity": p.severity, "code": p.code, "message": p.message, "names": p.names, "position": p.position,
                      "remedy": p.remedy} for p in b.problems],
        "statistics": {**a.statistics, **{f"extract_{k}" if k in a.statistics else k: v
                                          for k, v in getattr(b, "statistics", {}).items()}},
    })


def write_json(model: Model, f: RoomFigures, out: Path, picture_areas: dict) -> Path:
    path = out / "report.json"
    text = json.dumps(report_dict(model, f, picture_areas), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
    return path
