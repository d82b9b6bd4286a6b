# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes made through the shim, for its tests."""

from __future__ import annotations

import enfilade_native as native
import numpy as np

BOX_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(x0: float, y0: float, z0: float, x1: float, y1: float, z1: float) -> np.ndarray:
    return np.array(
        [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0], [x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
        dtype=float,
    )


def camera_at(eye: tuple[float, float, float], towards: tuple[float, float, float], angle: float = 1.2) -> native.Camera:
    """A perspective camera at `eye` looking at `towards`, angle x angle radians."""
    matrix = np.eye(4)
    back = np.asarray(eye, float) - np.asarray(towards, float)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return native.Camera(matrix, angle_x=angle, angle_y=angle, clip=(0.01, 1000.0))


def suite(doors: list[tuple[float, float]]) -> native.Scene:
    """Rooms 4 m long in a row along x, 3 m wide, 2.5 m high; door i (y from, to; 2 m high) joins room i and i + 1.

    One object stands in the middle of each room. Committed.
    """
    scene = native.Scene()
    for i in range(len(doors) + 1):
        room = scene.add_room(f"Room {i}")
        scene.add_cell(room, box(4 * i, 0, 0, 4 * i + 4, 3, 2.5), BOX_FACES)
        scene.add_object(f"Thing {i}", [[4 * i + 1.8, 0.1, 0.1], [4 * i + 2.2, 2.9, 2.0]], mesh=i % 2)
    for i, (y0, y1) in enumerate(doors):
        x = 4.0 * (i + 1)
        door = scene.add_opening(f"Door {i}", "door")
        scene.add_portal(i, i + 1, [(x, y0, 0), (x, y1, 0), (x, y1, 2), (x, y0, 2)], door)
    scene.commit()
    return scene
