# SPDX-License-Identifier: GPL-3.0-or-later
"""View measures as maps on the storeys' plans, as tables and as a section of the page."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..rules.results import ViewMeasures
from . import plan_drawing, shapes2d, tables
from .drawing import Drawing
from .plan import Model, StoreyPlan

# Little to much, even steps of lightness, told apart in grey and by any colour vision.
STEPS = ("#f3f1e7", "#dbe5d0", "#b3d3c3", "#84bbb8", "#5a9cae", "#3d7a9c", "#2f5583", "#2a3462")
ANGLES = ((0.5, "#e9e6e0", "none"), (14.0, "#f3d9a4", "below 14°"), (28.0, "#bcd9c6", "14° minimum"), (54.0, "#6fb0b4", "28° medium"),
          (math.inf, "#2f6f94", "54° high"))  # upper bound, colour, class of EN 17037
ON_PAGE = ("area", "longest_view", "occlusivity", "sight_angle")  # the others lie beside the page as files


def nice_step(span: float, most: int) -> float:
    """The smallest of 1, 2, 2.5, 5 times a power of ten that spans `span` in at most `most` steps."""
    least = max(span / most, 1e-9)
    base = 10.0 ** math.floor(math.log10(least))
    return next(m * base for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * base >= least * (1 - 1e-9))


def classes(measures: ViewMeasures, key: str) -> tuple[list[float], list[str], list[str]]:
    """Upper bounds, colours and words of a measure's classes, over the whole building."""
    if key == "sight_angle":
        return [a[0] for a in ANGLES], [a[1] for a in ANGLES], [a[2] for a in ANGLES]
    known = measures.grid.values[key]
    unit = next(m.unit for m in measures.definitions if m.key == key).split(" ")[0]
    low, high = (float(v) for v in np.percentile(known, (0.0, 99.5))) if len(known) else (0.0, 1.0)
    step = nice_step(max(high - low, 1e-9), len(STEPS) - 1)
    first = math.floor(low / step) * step
    count = max(1, min(len(STEPS), math.ceil((high - first) / step - 1e-9)))
    bounds = [first + step * (k + 1) for k in range(count)]
    colours = [STEPS[round(k * (len(STEPS) - 1) / max(count - 1, 1))] for k in range(count)]
    words = [f"{bounds[k] - step:g} to {bounds[k]:g}" for k in range(count)]
    words[-1] = f"{words[-1]} {unit}" if high <= bounds[-1] * (1 + 1e-9) else f"over {bounds[-1] - step:g} {unit}"
    return [*bounds[:-1], math.inf], colours, words


def plan_map(model: Model, plan: StoreyPlan, measures: ViewMeasures, key: str) -> Drawing | None:
    """One storey, its floors coloured by a measure; None where no point of the grid lies on it."""
    bounds, colours, words = classes(measures, key)
    grid = measures.grid
    residents = {r.index for r in plan.rooms if r.resident}
    patches, used = [], set()
    for room in plan.rooms:
        own = np.nonzero(grid.rooms == room.index)[0] if room.index in residents else np.zeros(0, int)
        if not len(own):
            continue
        step = np.searchsorted(np.array(bounds), grid.values[key][own], side="right")
        for piece in room.pieces:
            for square, k in _squares(piece, grid.points[own, :2], step, grid.spacing):
                patches.append((square, colours[min(k, len(colours) - 1)]))
                used.add(min(k, len(colours) - 1))
    if not patches:
        return None
    patches.sort(key=lambda patch: colours.index(patch[1]))  # one path a colour
    measure = next(m for m in measures.definitions if m.key == key)
    legend = [(colours[k], words[k]) for k in range(len(colours)) if k in used or key != "sight_angle"]
    return plan_drawing.compose(model, plan, f"{plan.name} · {measure.label}, eye at {measures.eye:g} m", {r.index: "#ffffff" for r in plan.rooms}, legend,
                                {r.index for r in plan.rooms}, set(), [], None, patches=patches,
                                width=plan_drawing.NARROW)


def _squares(piece: np.ndarray, points: np.ndarray, step: np.ndarray, spacing: float):
    """A convex floor cut into rectangles of one class: squares of the grid, each with the class of the nearest point, neighbours in a row
    joined. Yields (polygon, class)."""
    low, high = np.floor(piece.min(axis=0) / spacing).astype(int), np.ceil(piece.max(axis=0) / spacing).astype(int)
    known = {(int(i), int(j)): int(s) for (i, j), s in zip(np.floor(points / spacing).astype(int).tolist(), step, strict=True)}
    for j in range(low[1], high[1]):
        run, kind = low[0], -1
        for i in range(low[0], high[0] + 1):
            k = -2
            if i < high[0]:
                found = known.get((i, j))
                if found is None:
                    away = ((points - (np.array([i, j]) + 0.5) * spacing) ** 2).sum(axis=1)
                    found = int(step[int(np.argmin(away))])
                k = found
            if k != kind:
                if kind >= 0:
                    # a little larger than it is, so that neighbours leave no seam
                    more = 0.08 * spacing
                    x0, x1, y0, y1 = run * spacing - more, i * spacing + more, j * spacing - more, (j + 1) * spacing + more
                    cut = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
                    for a, b in zip(piece, shapes2d.following(piece), strict=True):
                        cut = shapes2d.clip(cut, a, np.array([a[1] - b[1], b[0] - a[0]]))
                        if len(cut) < 3:
                            break
                    if len(cut) >= 3:
                        yield cut, kind
                run, kind = i, k


# ---- Tables ---------------------------------------------------------------------------------------------------


def write_tables(model: Model, measures: ViewMeasures, out: Path) -> list[Path]:
    """view_points.csv, view_rooms_measures.csv, view_cameras.csv; units in the headings."""
    keys = [m.key for m in measures.definitions]
    heads = [_column(m) for m in measures.definitions]
    grid = measures.grid
    points = ([model.building.rooms[int(r)].name, *map(float, p), *(float(grid.values[k][i]) for k in keys), bool(grid.values["two_ways"][i])]
              for i, (r, p) in enumerate(zip(grid.rooms, grid.points, strict=True)))
    rooms = [[r.name, r.long_name, model.storey_name(i), int(measures.rooms["points"][i]), *(float(measures.rooms[k][i]) for k in keys),
              *(float(v) for v in _shares(measures, i))]
             for i, r in enumerate(model.building.rooms) if math.isfinite(measures.rooms["points"][i])]
    cameras = [[c["camera"], c["frame"], model.building.rooms[c["room"]].name, *(c[k] for k in keys), c["floor_area"]] for c in measures.cameras]
    return [
        tables.write_csv(out / "view_points.csv", ["room", "x_m", "y_m", "z_m", *heads, "two_ways_out"], points),
        tables.write_csv(out / "view_measures.csv", ["room", "long_name", "storey", "points", *heads, "floor_with_view_percent",
                                                     "floor_en17037_minimum_percent", "floor_two_ways_percent"], rooms),
        tables.write_csv(out / "view_cameras.csv", ["camera", "frame", "room", *heads, "floor_area_m2"], cameras),
    ]


UNITS = {"m²": "m2", "m³": "m3", "m": "m", "°": "degrees"}


def _column(measure) -> str:
    return f"{measure.key}_{UNITS.get(measure.unit, 'percent')}"


def _shares(measures: ViewMeasures, room: int) -> tuple[float, float, float]:
    return measures.rooms["with_view"][room], measures.rooms["en17037"][room], 100.0 * measures.rooms["two_ways"][room]


def as_dict(model: Model, measures: ViewMeasures) -> dict:
    """For report.json."""
    return {
        "eye_m": measures.eye, "spacing_m": measures.grid.spacing, "points": len(measures.grid.points), "cut_short": measures.cut_short,
        "definitions": {m.key: {"unit": m.unit, "text": m.text, "source": m.source} for m in measures.definitions},
        "building": building_shares(measures),
        "rooms": {k: list(v) for k, v in measures.rooms.items()}, "cameras": measures.cameras,
    }


def building_shares(measures: ViewMeasures) -> dict[str, float]:
    """Percent of the floor (every point stands for the same area) by what is seen from it."""
    angle = measures.grid.values["sight_angle"]
    if not len(angle):
        return {}
    return {"sees_out": 100.0 * float((angle > 0).mean()), "minimum": 100.0 * float((angle >= 14).mean()),
            "medium": 100.0 * float((angle >= 28).mean()), "high": 100.0 * float((angle >= 54).mean()),
            "two_ways": 100.0 * float((measures.grid.values["two_ways"] > 0).mean())}
