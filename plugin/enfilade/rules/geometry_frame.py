# SPDX-License-Identifier: GPL-3.0-or-later
"""The main direction of a building's walls, so that work is done in a frame where most of them run along x and y."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

BIN = 0.25  # degrees: finer than models are drawn askew, coarser than rounding
STRAIGHT = 1.0  # degrees: what is less askew is taken along the grid
MOST_WALLS = 0.1  # sine: a face that leans less than 6 degrees is a wall's


def upright(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (degrees, 0..90) and areas (m2) of the upright triangles."""
    t = vertices[triangles]
    cross = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    size = np.linalg.norm(cross, axis=1)
    wall = (size > 1e-9) & (np.abs(cross[:, 2]) < MOST_WALLS * size)
    angle = np.degrees(np.arctan2(cross[wall, 1], cross[wall, 0])) % 90.0
    return angle, 0.5 * size[wall]


def main_direction(meshes: Iterable[tuple[np.ndarray, np.ndarray]]) -> float:
    """The turn in degrees (-45..45) from x to the direction that most wall area runs along or across."""
    angles, areas = [np.zeros(0)], [np.zeros(0)]
    for vertices, triangles in meshes:
        a, s = upright(vertices, triangles)
        angles.append(a)
        areas.append(s)
    angle, area = np.concatenate(angles), np.concatenate(areas)
    if not area.sum() > 0.0:
        return 0.0
    bins = int(round(90.0 / BIN))
    histogram = np.bincount((angle / BIN).astype(int) % bins, area, bins)
    smooth = histogram + np.roll(histogram, 1) + np.roll(histogram, -1)
    peak = (int(np.argmax(smooth)) + 0.5) * BIN
    off = (angle - peak + 45.0) % 90.0 - 45.0
    near = np.abs(off) < 1.0
    turn = peak + float(np.average(off[near], weights=area[near]))
    return (turn + 45.0) % 90.0 - 45.0


def own_directions(corners: np.ndarray, owner: np.ndarray, count: int) -> np.ndarray:
    """The turn in radians (-pi/4..pi/4) from x to the direction that the upright faces of each of `count` owners run along or across, on the average; 0 for
    what is round or within STRAIGHT of the axes. corners: float64 (n, 3, 3), of triangles; owner: int (n,)."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weight = np.hypot(cross[:, 0], cross[:, 1])
    angle = 4.0 * np.arctan2(cross[:, 1], cross[:, 0])  # a quarter turn is none
    across, along = (np.bincount(owner, weight * part(angle), count) for part in (np.sin, np.cos))
    turn = 0.25 * np.arctan2(across, along)
    none = (np.abs(turn) < np.radians(STRAIGHT)) | (np.hypot(across, along) < 0.5 * np.bincount(owner, weight, count))
    return np.where(none, 0.0, turn)


def rotation(degrees: float) -> np.ndarray:
    """Turns about z; float64 (3, 3), to be multiplied from the left."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
