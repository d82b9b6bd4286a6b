# SPDX-License-Identifier: GPL-3.0-or-later
"""What Detect found, as a picture a storey: rooms, the cells they were cut into, portals by state, problems numbered.

The same as the overlay in the 3D view, for those who work without a window.
"""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np

from ..rules import convex_polygons as cp
from ..rules.building import EXTERIOR, INFO, Building, Problem
from ..rules.results import Cells
from . import drawing as d
from . import images, raster

NONE = 0xFFFFFFFF
ROOMS = ("#e9e3d6", "#dfe7ea", "#e6e9dc", "#ece0e2", "#e2e0ee", "#efe8d0")
STATES = {"open": "#178a4c", "glass": d.GLASS, "closed": "#b3261e", "virtual": "#e39a12", "seam": "#9aa0a8"}
WORDS = {"open": "open", "glass": "glass", "closed": "closed", "virtual": "virtual (no wall)", "seam": "between cells of a room"}
TROUBLE = {"error": "#b3261e", "warning": "#d97706", "info": "#5b6470"}
PLAN, SIDE, EDGE, FOOT = 900.0, 380.0, 36.0, 70.0  # page units
MOST_LISTED = 16


def write(folder: Path, building: Building, cells: Cells, problems: list[Problem]) -> list[Path]:
    """PNG files `detected_<storey>.png` in `folder`, lowest storey first; their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    levels = _levels(building)
    for n, (name, members) in enumerate(levels):
        if not members:
            continue
        page = _draw(building, cells, problems, name, members, n, levels)
        path = folder / f"detected_{_file_name(name)}.png"
        images.write_png(path, raster.paint(page, 2.0))
        written.append(path)
    return written


def _levels(building: Building) -> list[tuple[str, list[int]]]:
    """Rooms by storey, from below."""
    rooms = [i for i, r in enumerate(building.rooms) if r.kind != EXTERIOR and r.vertices is not None and len(r.vertices)]
    heights: dict[str, float] = {}
    for i in rooms:
        room = building.rooms[i]
        heights[room.storey] = min(heights.get(room.storey, np.inf), float(room.vertices[:, 2].min()))
    return [(name or "Building", [i for i in rooms if building.rooms[i].storey == name]) for name in sorted(heights, key=heights.__getitem__)]


def _draw(building, cells, problems, name, members, n, levels) -> d.Drawing:
    mine = set(members)
    points = np.concatenate([building.rooms[i].vertices for i in members])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = min(PLAN / max(high[0] - low[0], 1e-3), 1.2 * PLAN / max(high[1] - low[1], 1e-3))
    width, height = scale * (high[0] - low[0]), scale * (high[1] - low[1])

    def place(p: np.ndarray) -> np.ndarray:
        p = np.asarray(p, dtype=np.float64)
        return np.stack([EDGE + scale * (p[..., 0] - low[0]), EDGE + scale * (high[1] - p[..., 1])], axis=-1)

    listed = [p for p in problems if p.severity != INFO and p.position is not None]
    listed = [p for p in listed if _level_of(p.position, building, levels) == n][:MOST_LISTED]
    side = SIDE if listed else 0.0
    page = d.Drawing(width + 2 * EDGE + side, max(height + 2 * EDGE + FOOT, 120.0 + 74.0 * len(listed)), f"{name}: as detected")
    outlines: dict[int, list[np.ndarray]] = {i: [] for i in members}
    for c, room in enumerate(cells.rooms):
        if int(room) in mine and len(cells.hulls[c]):
            outlines[int(room)].append(np.array(cp.hull((p[0], p[1]) for p in cells.hulls[c])))
    for i in members:
        for outline in outlines[i]:
            page.polygon(place(outline), ROOMS[i % len(ROOMS)], 1.0, i)
    for i in members:
        for outline in outlines[i]:
            page.line(place(outline), STATES["seam"], 0.7, closed=True)
    used = set()
    for polygon, (a, b), opening in zip(cells.portals, cells.portal_cells, cells.portal_openings, strict=True):
        if not {int(cells.rooms[int(a)]), int(cells.rooms[int(b)])} & mine or int(opening) == NONE:
            continue
        known = building.openings[int(opening)]
        state = "virtual" if known.kind == "virtual" else known.state
        used.add(state)
        flat = np.array(cp.hull((p[0], p[1]) for p in polygon))
        level = len(flat) > 2 and abs(cp.area(flat.tolist())) > 1e-3
        page.line(place(flat), STATES[state], 1.2 if level else 3.0, (4.0, 3.0) if level else (), closed=bool(level))
    for i in members:
        room = building.rooms[i]
        centre = place(room.vertices[:, :2].min(axis=0) * 0.5 + room.vertices[:, :2].max(axis=0) * 0.5)
        label = d.shorten(room.long_name or room.name, 18)
        if d.text_width(label, 10.0) < scale * np.ptp(room.vertices[:, 0]) + 8.0:
            page.text(centre[0], centre[1] + 3.0, label, 10.0, d.INK, "middle", halo=ROOMS[i % len(ROOMS)])
    for k, p in enumerate(listed, 1):
        x, y = place(np.array(p.position[:2]))
        _disc(page, x, y, k, p.severity)
    _legend(page, name, building, cells, members, used, height)
    for k, p in enumerate(listed, 1):
        x, y = width + 2 * EDGE + 12.0, 40.0 + 74.0 * (k - 1)
        _disc(page, x, y, k, p.severity)
        lines = textwrap.wrap(p.message, 52)[:3] + textwrap.wrap(p.remedy, 52)[:1]
        for j, line in enumerate(lines):
            page.text(x + 18.0, y + 4.0 + 14.0 * j, line, 11.0, d.FAINT_INK if p.remedy and j == len(lines) - 1 else d.INK)
    return page


def _legend(page: d.Drawing, name: str, building: Building, cells: Cells, members: list[int], used: set[str], height: float) -> None:
    y = height + 2 * EDGE + 8.0
    count = sum(int(r) in set(members) for r in cells.rooms)
    page.text(EDGE, y, f"{name}: {len(members)} rooms, {count} cells", 14.0, bold=True)
    x, y = EDGE, y + 24.0
    for state in [s for s in STATES if s in used or s == "seam"]:
        if x + 34.0 + d.text_width(WORDS[state], 11.0) > page.width - 8.0:
            x, y = EDGE, y + 16.0
        page.line([(x, y - 4.0), (x + 22.0, y - 4.0)], STATES[state], 3.0 if state != "seam" else 1.0)
        page.text(x + 28.0, y, WORDS[state], 11.0)
        x += 44.0 + d.text_width(WORDS[state], 11.0)


def _disc(page: d.Drawing, x: float, y: float, number: int, severity: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    page.polygon(np.column_stack([x + 9.0 * np.cos(angle), y + 9.0 * np.sin(angle)]), TROUBLE[severity])
    page.text(x, y + 4.0, str(number), 11.0, d.PAPER, "middle", bold=True)


def _level_of(position, building: Building, levels) -> int:
    """The storey that a place is on: the nearest in height, of those that have rooms."""
    def away(members: list[int]) -> float:
        low = min(float(building.rooms[i].vertices[:, 2].min()) for i in members)
        high = max(float(building.rooms[i].vertices[:, 2].max()) for i in members)
        return max(low - position[2], position[2] - high, 0.0)

    return min(range(len(levels)), key=lambda n: away(levels[n][1]))


def _file_name(name: str) -> str:
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name) or "storey"
