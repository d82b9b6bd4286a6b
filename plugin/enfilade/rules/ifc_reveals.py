# SPDX-License-Identifier: GPL-3.0-or-later
"""Reveals of passages that nothing closes: a door whose wall ends at the floor's height where no slab is drawn.

Through such a reveal one looks out of the passage sideways, under the wall or above it; and where a room begins only
beyond the wall, through the air between. The rooms at its ends then see what lies there, so each gets a virtual portal the
size of the passage's end: larger than what is seen, never smaller.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import convex_polygons as cp
from . import polyhedra, trapezoids
from .blockers import Blockers
from .face_view import BACKING, SLIT, FaceView
from .polyhedra import Face, Polyhedron
from .probing import Passage

BESIDE = 5e-3  # m outside the reveal at which the wall must stand
LEAST = 1e-3  # m2 of open reveal from which on it counts: less is rounding along an edge


@dataclass
class Leak:
    """An opening's reveal that is open to a room, or to the exterior (-1)."""

    room: int
    area: float  # m2
    position: np.ndarray  # float64 (3,)


def leaks(
    passage: Passage, depths: tuple[float, float], solids: list[Polyhedron], near: list[int], blockers: Blockers
) -> list[Leak]:
    """depths: between which t along the passage's axis it is used. near: rooms that may lie beside it."""
    if passage.wall is None:
        return []
    found: dict[int, Leak] = {}
    within = (max(depths[0], passage.host[0]), min(depths[1], passage.host[1]))
    if within[1] - within[0] >= 0.01:
        _add_leaks(found, passage, within, solids, near, blockers)
    # Air between wall and room: nearer than BACKING the room's face counts as the wall's.
    for begin, end in ((depths[0], min(depths[1], passage.host[0])), (max(depths[0], passage.host[1]), depths[1])):
        if end - begin > BACKING:
            _add_leaks(found, passage, (begin, end), solids, near, blockers)
    return [leak for leak in found.values() if leak.area > LEAST]


def _add_leaks(
    found: dict[int, Leak], passage: Passage, depths: tuple[float, float], solids: list[Polyhedron], near: list[int],
    blockers: Blockers,
) -> None:
    """Those between two depths, added to what is found already, by room."""
    low, high = depths
    section = passage.section
    for k in range(len(section)):
        a, b = section[k - 1], section[k]
        length = float(np.hypot(b[0] - a[0], b[1] - a[1]))
        if length < 0.02:
            continue
        outward = np.array([(b[1] - a[1]) / length, -(b[0] - a[0]) / length, 0.0])
        samples = np.array(
            [
                (a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), low + t * (high - low))
                for s in (0.02, 0.26, 0.5, 0.74, 0.98)
                for t in (0.1, 0.5, 0.9)
            ]
        )
        if _in_wall(passage, samples + BESIDE * outward).all():
            continue
        quad = np.array([(*a, low), (*b, low), (*b, high), (*a, high)])
        view, pieces = _open_pieces(passage, quad, outward, blockers)
        pieces = [p for p in pieces if cp.width(p) > SLIT]
        if not pieces:
            continue
        points = np.array([view.frame.world(np.array([[*np.mean(p, axis=0), 2 * BESIDE]]))[0] for p in pieces])
        within = np.full(len(points), -1)
        for room in near:
            within[polyhedra.inside(points, solids[room])] = room
        for room, piece, point in zip(within.tolist(), pieces, points, strict=True):
            leak = found.setdefault(room, Leak(room, 0.0, point))
            leak.area += cp.area(piece)


def _open_pieces(
    passage: Passage, quad: np.ndarray, outward: np.ndarray, blockers: Blockers
) -> tuple[FaceView, list[cp.Polygon]]:
    """The parts of one reveal that neither its own wall nor anything near it closes."""
    corners = passage.frame.world(quad)
    normal = passage.frame.world(outward[None])[0] - passage.frame.origin
    face = Face(normal, float(normal @ corners[0]), np.array([[0, 1, 2], [0, 2, 3]]))
    view = FaceView(corners, face, blockers)
    if view.is_empty:
        return view, []
    seen = view.look([])
    free = ~(seen.ahead <= BACKING)
    if free.any():
        points = view.frame.world(np.column_stack([seen.points, np.full(len(seen.points), BESIDE)]))
        free &= ~_in_wall(passage, passage.frame.local(points))
    return view, trapezoids.join(seen.pieces[free])


def _in_wall(passage: Passage, local: np.ndarray) -> np.ndarray:
    wall = passage.wall
    points = passage.frame.world(local)
    return np.abs(polyhedra.winding_number(points, wall.world, wall.triangles)) > 0.5
