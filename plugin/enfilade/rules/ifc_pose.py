# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a scene that another add-on loaded stands to its IFC file: Bonsai moves models on a national grid to the origin and turns those
whose site is turned. Found from the placements of what both have, whatever the add-on and its version note."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import ifc
from .building import Building
from .ifc_placement import Frame, absolute_placement
from .ifc_units import length_unit

SAME_PLACE = 5e-3  # m between where a scene has a product and where its file has it
LEAST = 3  # products that must agree
MOST = 500  # products that are asked


@dataclass
class Pose:
    """scene = turn @ (file - pivot) + at; metres. The pivot lies in the model, so that national-grid coordinates cost no digits."""

    turn: np.ndarray  # float64 (3, 3), about the vertical
    pivot: np.ndarray  # float64 (3,), in the file
    at: np.ndarray  # float64 (3,), in the scene

    def to_scene(self, building: Building) -> None:
        """From the file's coordinates less `Building.offset`."""
        origin = self.at - self.turn @ (self.pivot - np.asarray(building.offset))
        ifc.move(building, Frame(origin, self.turn.T), np.zeros(3))
        building.offset = tuple(float(x) for x in self.pivot - self.at)

    def to_file(self, building: Building) -> np.ndarray:
        """Back; gives the offset that its coordinates then want."""
        ifc.move(building, Frame(-self.turn.T @ self.at, self.turn), np.zeros(3))
        return self.pivot

    def numbers(self) -> list[float]:
        """To be kept with a scene."""
        return [float(x) for x in (self.turn[0, 0], self.turn[1, 0], *self.pivot, *self.at)]

    @staticmethod
    def of_numbers(kept: Sequence[float]) -> Pose:
        c, s, *places = kept
        return Pose(_turn(c, s), np.array(places[:3], dtype=np.float64), np.array(places[3:], dtype=np.float64))


def find(model: Any, drawn: Mapping[str, np.ndarray]) -> Pose | None:
    """drawn: the scene's matrices float64 (4, 4) by name `IfcClass/Name`. None: the scene doesn't show this file's products, or shows
    each in another place."""
    unit = length_unit(model)
    products = [p for p in model.by_type("IfcElement") if p.ObjectPlacement and p.Representation]
    known = Counter(f"{p.is_a()}/{p.Name}" for p in products)
    both = [(p, drawn[n]) for p in products if (n := f"{p.is_a()}/{p.Name}") in drawn and known[n] == 1][:MOST]
    if len(both) < LEAST:
        return None
    files = np.array([absolute_placement(p.ObjectPlacement) for p, _ in both])
    files[:, :3, 3] *= unit
    scenes = np.array([m for _, m in both])
    turns = scenes[:, :3, :3] @ files[:, :3, :3].transpose(0, 2, 1)
    pivot = np.median(files[:, :3, 3], axis=0)
    # A first turn from the axes, good to single precision; then the one under which most places fit, from the places themselves.
    first = np.median(turns[:, 0, 0]), np.median(turns[:, 1, 0])
    turn, good = _turn(*first), np.ones(len(both), dtype=bool)
    for _ in range(3):
        shifted = (files[:, :3, 3] - pivot) @ turn.T
        at = np.median((scenes[:, :3, 3] - shifted)[good], axis=0)
        good = np.linalg.norm(scenes[:, :3, 3] - shifted - at, axis=1) < SAME_PLACE
        if good.sum() < LEAST or good.sum() < 0.5 * len(both):
            return None
        a, b = (files[good, :2, 3] - pivot[:2]), (scenes[good, :2, 3] - at[:2])
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        c, s = float((a * b).sum()), float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
        if np.hypot(c, s) > 1.0:
            turn = _turn(c, s)
    return Pose(turn, pivot, pivot + np.round(at - pivot, 6))  # not moved: no single-precision rounding is to look like it


def _turn(c: float, s: float) -> np.ndarray:
    length = float(np.hypot(c, s)) or 1.0
    c, s = c / length, s / length
    if abs(s) < 1e-6 and c > 0.0:
        c, s = 1.0, 0.0  # not turned: no rounding is to look like it
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
