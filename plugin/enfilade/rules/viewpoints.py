# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras for a building that has none: eye height in the rooms with most floor that have a door, looking to the farthest door.

Plain numpy. Used for IFC files, which bring no cameras, so that every command has something to look through.
"""

from __future__ import annotations

import math

import numpy as np

from .building import DOOR, INTERIOR, Building
from .shapes import Solid

EYE_HEIGHT = 1.6  # metres above the room's floor
HEADINGS = 24


def suggest(building: Building, count: int) -> list[tuple[str, np.ndarray]]:
    """Up to `count` (name, matrix_world float64 (4, 4)); fewer when there are fewer rooms with a volume."""
    found: list[tuple[bool, float, str, np.ndarray]] = []
    doors: dict[int, list[np.ndarray]] = {}
    entered: set[int] = set()  # rooms with a door come first: a roof space may be the largest, and nobody looks into it
    for opening in building.openings:
        if opening.rooms is None:
            continue
        shape = opening.polygon if opening.body is None else opening.body
        if shape is not None:
            for room in opening.rooms:
                doors.setdefault(room, []).append(shape.mean(axis=0))
                if opening.kind == DOOR:
                    entered.add(room)
    for i, room in enumerate(building.rooms):
        if room.kind != INTERIOR or room.vertices is None or not room.faces:
            continue
        solid = Solid(room.vertices, room.faces)
        low, high = solid.low, solid.high
        z = low[2] + min(EYE_HEIGHT, 0.6 * (high[2] - low[2]))
        xs = np.linspace(low[0], high[0], 9)[1:-1]
        ys = np.linspace(low[1], high[1], 9)[1:-1]
        grid = np.array([(x, y, z) for x in xs for y in ys])
        inside = grid[solid.contains(grid)]
        if not len(inside):
            continue
        size = float(np.prod((high - low)[:2])) * len(inside) / len(grid)
        middle = inside.mean(axis=0)
        eye = inside[int(np.argmin(np.linalg.norm(inside - middle, axis=1)))]
        goals = [g for g in doors.get(i, []) if abs(g[2] - eye[2]) < 1.5]
        if goals:
            # towards the farthest door: most of the room and what lies behind it
            goal = max(goals, key=lambda g, e=eye: float(np.linalg.norm(g[:2] - e[:2])))
            heading = math.atan2(goal[1] - eye[1], goal[0] - eye[0])
        else:
            heading = max(
                (2.0 * math.pi * k / HEADINGS for k in range(HEADINGS)),
                key=lambda a, e=eye, s=solid: _free(s, e, a),
            )
        found.append((i not in entered, -size, f"Camera {room.name}", _looking(eye, heading)))
    found.sort(key=lambda item: item[:3])
    return [(name, matrix) for _, _, name, matrix in found[:count]]


def _free(solid: Solid, eye: np.ndarray, heading: float) -> float:
    hits = [t for t, _ in solid.ray_hits(eye, np.array([math.cos(heading), math.sin(heading), 0.0])) if t > 0.0]
    return min(hits, default=0.0)


def _looking(eye: np.ndarray, heading: float) -> np.ndarray:
    forward = np.array([math.cos(heading), math.sin(heading), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    out = np.eye(4)
    out[:3, 0] = np.cross(forward, up)
    out[:3, 1] = up
    out[:3, 2] = -forward
    out[:3, 3] = eye
    return out
