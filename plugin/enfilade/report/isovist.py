# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera sees at its own eye height, as areas of the plan: the exact horizontal section of the view.

A wedge is carried from cell to cell through the portals' sections, narrowed at each (M. Benedikt, "To take hold of
space: isovists and isovist fields", 1979, for the measure; the from-point traversal of DESIGN.md section 5 in two
dimensions for the way). Cells are convex, so inside a cell the seen area is cell and wedge, no more. Furniture and
what lies above or below eye height don't enter. It draws; the sets of visible rooms come from the core.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from . import shapes2d

NONE = 0xFFFFFFFF
OUTDOOR_REACH = 12.0  # metres drawn beyond an opening to the outdoors, where no wall ends the view
MAX_PIECES = 20_000  # a drawing with more pieces is unreadable anyway; the isovist then says `cut_short`
THINNEST = 1e-4  # radians: thinner wedges vanish on paper


@dataclass
class Isovist:
    eye: np.ndarray  # (2,)
    height: float  # metres
    pieces: list[tuple[int, np.ndarray]] = field(default_factory=list)  # cell, convex polygon (k, 2)
    openings: set[int] = field(default_factory=set)  # seen through, out of their thickness
    area: float = 0.0  # m2, indoors only, overlaps of pieces impossible for one eye
    cut_short: bool = False


def heading(matrix: np.ndarray) -> float | None:
    """Direction of view in plan [radians from +x]; None for a camera that looks straight up or down."""
    look = -np.asarray(matrix, dtype=np.float64)[:3, 2]
    if not np.isfinite(look).all() or math.hypot(look[0], look[1]) < 0.05 * max(abs(look[2]), 1e-9):
        return None
    return math.atan2(look[1], look[0])


def half_angle(camera) -> float:
    """Half of the horizontal field of view in plan [radians], at most pi."""
    if camera.type == "PANO":
        return math.pi
    angle = camera.angle_x if np.isfinite(camera.angle_x) and camera.angle_x > 0 else math.radians(50)
    return min(angle / 2, math.pi)


class Section:
    """All cells and passable portals cut at one height; reused by cameras of equal height."""

    def __init__(self, cells, closed: set[int], height: float, outdoors: set[int], reveals: Iterable[int] = ()):
        """reveals: cells of openings that lead outdoors, whose thickness is drawn but isn't anybody's floor."""
        self.polygons: list[np.ndarray] = [shapes2d.section(h, height) for h in cells.hulls]
        self.empty = [len(h) == 0 for h in cells.hulls]
        self.outdoors = outdoors
        self.cell_openings = np.asarray(cells.openings).tolist()
        self.uncounted = outdoors | set(reveals)
        self.exits: dict[int, list[tuple[int, np.ndarray, int]]] = {}
        for k, polygon in enumerate(cells.portals):
            opening = int(cells.portal_openings[k])
            if opening in closed:
                continue
            cut = shapes2d.polygon_section(polygon, height)
            if cut is None:
                continue
            a, b = (int(c) for c in cells.portal_cells[k])
            self.exits.setdefault(a, []).append((b, cut, opening))
            self.exits.setdefault(b, []).append((a, cut, opening))


def trace(section: Section, eye: np.ndarray, start_cells: list[int], direction: float, half: float,
          height: float) -> Isovist:
    """The isovist of a camera at `eye` (2,) that looks along `direction` with `half` an angle to each side."""
    result = Isovist(np.asarray(eye, dtype=np.float64), height)
    wedges: list[tuple[float, float]] = []
    parts = max(1, math.ceil(half / (math.pi / 3)))  # narrower than a half turn each: half-plane tests stay valid
    for i in range(parts):
        wedges.append((direction - half + 2 * half * i / parts, direction - half + 2 * half * (i + 1) / parts))
    starts = [c for c in start_cells if c < len(section.polygons)
              and shapes2d.contains(section.polygons[c], result.eye, -1e-3).any()]
    if not starts:
        starts = [c for c, p in enumerate(section.polygons)
                  if len(p) and shapes2d.contains(p, result.eye, -1e-3).any()][:1]
    if not starts:
        return result
    stack = [(starts[0], -1, a, b) for a, b in wedges]
    while stack:
        cell, came_from, a, b = stack.pop()
        if len(result.pieces) >= MAX_PIECES:
            result.cut_short = True
            break
        left, right = np.array([math.cos(b), math.sin(b)]), np.array([math.cos(a), math.sin(a)])
        bounds = section.polygons[cell]
        if section.empty[cell] or (cell in section.outdoors and len(bounds) == 0):
            continue
        piece = bounds
        if cell in section.outdoors:  # drawn to a finite reach
            r = OUTDOOR_REACH
            ring = [eye + r * np.array([math.cos(t), math.sin(t)]) for t in np.linspace(a, b, 9)]
            fan = np.array([eye, *ring])
            piece = _clip_to(fan, bounds) if len(bounds) else fan
        else:
            piece = shapes2d.clip(piece, result.eye, np.array([-right[1], right[0]]))
            piece = shapes2d.clip(piece, result.eye, np.array([left[1], -left[0]]))
        if len(piece) >= 3:
            result.pieces.append((cell, piece))
            if cell not in section.uncounted:
                result.area += abs(shapes2d.area(piece))
        middle = (a + b) / 2
        for target, cut, opening in section.exits.get(cell, ()):
            if target == came_from:
                continue
            rel = cut - result.eye
            if min(math.hypot(*rel[0]), math.hypot(*rel[1])) < 1e-6:
                continue
            turn = [(math.atan2(v[1], v[0]) - middle + math.pi) % (2 * math.pi) - math.pi for v in rel]
            low, high = min(turn), max(turn)
            if high - low > math.pi:  # the segment passes behind the eye
                continue
            low, high = max(low, a - middle), min(high, b - middle)
            if high - low < THINNEST:
                continue
            if opening != NONE and section.cell_openings[target] != opening:
                result.openings.add(opening)
            if section.empty[target]:
                _open_end(result, target, cut, middle + low, middle + high)
                continue
            stack.append((target, cell, middle + low, middle + high))
    return result


def _clip_to(polygon: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    for i in range(len(bounds)):
        p, d = bounds[i], bounds[(i + 1) % len(bounds)] - bounds[i]
        polygon = shapes2d.clip(polygon, p, np.array([-d[1], d[0]]))
    return polygon


def _open_end(result: Isovist, cell: int, cut: np.ndarray, a: float, b: float) -> None:
    """Beyond an opening into a cell without geometry (outdoors): the wedge from the opening to the reach."""
    eye = result.eye
    d = cut[1] - cut[0]
    normal = np.array([-d[1], d[0]])
    if (cut[0] - eye) @ normal < 0:
        normal = -normal
    ring = [eye + OUTDOOR_REACH * np.array([math.cos(t), math.sin(t)]) for t in np.linspace(a, b, 7)]
    fan = shapes2d.clip(np.array([eye, *ring]), cut[0], normal)
    if len(fan) >= 3:
        result.pieces.append((cell, fan))
