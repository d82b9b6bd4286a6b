# SPDX-License-Identifier: GPL-3.0-or-later
"""The two eyes of a stereo camera, as Blender places, turns and shifts them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .camera_frame import Lens


@dataclass(frozen=True)
class Stereo:
    """A camera's stereo settings, in Blender's words."""

    mode: str  # OFFAXIS, PARALLEL, TOE
    pivot: str  # LEFT, RIGHT: this eye is the camera itself; CENTER: it is in the middle
    interocular: float  # metres from eye to eye
    convergence: float  # metres to where the eyes look at the same


def eyes(matrix: np.ndarray, lens: Lens, stereo: Stereo) -> list[tuple[np.ndarray, Lens]]:
    """Left and right eye of the camera whose matrix (4, 4) is given: matrix (4, 4) without scale, and lens, of each."""
    camera = np.array(matrix, dtype=np.float64)
    camera[:3, :3] /= np.linalg.norm(camera[:3, :3], axis=0)
    away = max(stereo.convergence, 1e-6)
    share = 0.5 if stereo.pivot == "CENTER" else 1.0
    pair = []
    for side, pivot in ((-1.0, "LEFT"), (1.0, "RIGHT")):
        if stereo.pivot == pivot:
            pair.append((camera, lens))
            continue
        aside, half_turn = np.eye(4), np.eye(4)
        aside[0, 3] = side * share * stereo.interocular
        shift = 0.0
        if stereo.mode == "TOE":
            angle = side * math.atan(0.5 * stereo.interocular / away)
            half_turn[0, 0] = half_turn[2, 2] = math.cos(angle)
            half_turn[0, 2], half_turn[2, 0] = math.sin(angle), -math.sin(angle)
        elif stereo.mode == "OFFAXIS":
            shift = -side * share * stereo.interocular / lens.sensor_width * lens.lens / away
        # round one eye the other goes half a turn before it moves aside and half a turn after
        before = np.eye(4) if stereo.pivot == "CENTER" else half_turn
        pair.append((camera @ before @ aside @ half_turn, replace(lens, shift_x=lens.shift_x + shift)))
    return pair
