# SPDX-License-Identifier: GPL-3.0-or-later
"""A preview's depth and objects against a renderer's passes, pixel by pixel. Numpy, no bpy."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

SAME_DEPTH = 1e-4  # part of the distance
WANTED_DEPTH = 0.9999  # share of pixels that must agree so far
NOTHING_FARTHER = 1e9  # metres: the renderer writes 1e10 where nothing is


@dataclass
class PreviewComparison:
    pixels: int
    depth_different: int  # beyond SAME_DEPTH, or something in one picture alone
    depth_share: float  # of pixels whose depth agrees
    depth_off_edges: int  # of depth_different, with no edge within a pixel
    depth_worst_off_edges: float  # part of the distance
    objects_different: int
    edge_pixels: int  # with another object among the eight around, in either picture
    objects_off_edges: int  # differing though on no edge
    coinciding: int  # of these, at the same depth: two faces in one place, either may show

    @property
    def equal(self) -> bool:
        return self.depth_share >= WANTED_DEPTH and self.objects_off_edges == self.coinciding

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "equal": self.equal}


def _edges(numbers: np.ndarray) -> np.ndarray:
    """Pixels with another number among the eight around. bool (h, w)."""
    wide = np.pad(numbers, 1, mode="edge")
    h, w = numbers.shape
    out = np.zeros((h, w), dtype=bool)
    for dy in range(3):
        for dx in range(3):
            out |= wide[dy : dy + h, dx : dx + w] != numbers
    return out


def compare(depth: np.ndarray, objects: np.ndarray, reference_depth: np.ndarray, reference_objects: np.ndarray) -> PreviewComparison:
    """depths: float (h, w) metres, infinite or beyond NOTHING_FARTHER where nothing is. objects: numbers alike in both, 0: nothing."""
    mine, theirs = depth.astype(np.float64), reference_depth.astype(np.float64)
    some, other = mine < NOTHING_FARTHER, theirs < NOTHING_FARTHER
    both = some & other
    relative = np.zeros(mine.shape)
    relative[both] = np.abs(mine[both] - theirs[both]) / np.maximum(np.abs(theirs[both]), 1e-9)
    wrong = (some != other) | (relative > SAME_DEPTH)
    edge = _edges(objects) | _edges(reference_objects)
    differ = objects != reference_objects
    off = differ & ~edge
    return PreviewComparison(
        int(mine.size), int(wrong.sum()), 1.0 - float(wrong.mean()), int((wrong & ~edge).sum()),
        float(relative[~edge].max()) if (~edge).any() else 0.0, int(differ.sum()), int(edge.sum()), int(off.sum()),
        int((off & ~wrong).sum()),
    )
