# SPDX-License-Identifier: GPL-3.0-or-later
"""A preview's depth and objects against a renderer's passes, pixel by pixel. Numpy, no bpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

SAME_DEPTH = 1e-4  # part of the distance
WANTED_DEPTH = 0.9999  # share of pixels that must agree so far
NOTHING_FARTHER = 1e9  # metres: the renderer writes 1e10 where nothing is

MOST_ARBITRATED = 2000  # pixels: each is asked of every triangle
Arbiter = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass
class PreviewComparison:
    pixels: int
    depth_different: int  # beyond SAME_DEPTH, or something in one picture alone
    depth_within_sample: int  # of depth_different: the renderer's lies between ours and those of rays within its sample's spread
    depth_settled: int  # of the rest: double precision, asked triangle by triangle, finds our depth and not the renderer's
    depth_share_raw: float  # of pixels whose depth agrees, nothing allowed for
    depth_share: float  # both kinds counted as agreeing too
    depth_off_edges: int  # of depth_different, with no edge within a pixel
    depth_worst_off_edges: float  # part of the distance
    objects_different: int
    edge_pixels: int  # with another object among the eight around, in our picture
    objects_off_edges: int  # differing though on no edge
    coinciding: int  # of these, at the same depth: two faces in one place, either may show

    @property
    def equal(self) -> bool:
        return self.depth_share >= WANTED_DEPTH and self.objects_off_edges == self.coinciding

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "equal": self.equal}


def nearest_of_all(origins: np.ndarray, directions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distances along rays (n, 3) to the nearest of all triangles (m, 3, 3), each asked in turn in double precision: what any tree should
    find (T. Moeller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997). float64 (n,), infinite where none."""
    out = np.full(len(origins), np.inf)
    a = triangles[:, 0]
    ab, ac = triangles[:, 1] - a, triangles[:, 2] - a
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
            p = np.cross(d, ac)
            det = np.einsum("ij,ij->i", ab, p)
            s = o - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, ab)
            v = q @ d / det
            t = np.einsum("ij,ij->i", ac, q) / det
            met = t[(u >= -1e-12) & (v >= -1e-12) & (u + v <= 1 + 1e-12) & (t > 0)]
            out[i] = met.min() if met.size else np.inf
    return out


def _edges(numbers: np.ndarray) -> np.ndarray:
    """Pixels with another number among the eight around. bool (h, w)."""
    wide = np.pad(numbers, 1, mode="edge")
    h, w = numbers.shape
    out = np.zeros((h, w), dtype=bool)
    for dy in range(3):
        for dx in range(3):
            out |= wide[dy : dy + h, dx : dx + w] != numbers
    return out


def compare(depth: np.ndarray, objects: np.ndarray, reference_depth: np.ndarray, reference_objects: np.ndarray,
            beside: Sequence[np.ndarray] = (), arbiter: Arbiter | None = None) -> PreviewComparison:
    """depths: float (h, w) metres, infinite or beyond NOTHING_FARTHER where nothing is. objects: numbers alike in both, 0: nothing.
    beside: our depths again, of rays as far from the pixel's middle as the renderer's sample may be."""
    mine, theirs = depth.astype(np.float64), reference_depth.astype(np.float64)
    some, other = mine < NOTHING_FARTHER, theirs < NOTHING_FARTHER
    both = some & other
    relative = np.zeros(mine.shape)
    relative[both] = np.abs(mine[both] - theirs[both]) / np.maximum(np.abs(theirs[both]), 1e-9)
    wrong = (some != other) | (relative > SAME_DEPTH)
    low, high = np.minimum.reduce([mine, *beside]), np.maximum.reduce([mine, *beside])
    spread = wrong & (theirs >= low * (1 - SAME_DEPTH)) & ((theirs <= high * (1 + SAME_DEPTH)) | (high > NOTHING_FARTHER))
    rest = wrong & ~spread
    settled = 0
    rows, columns = np.nonzero(rest)
    if arbiter is not None and 0 < len(rows) <= MOST_ARBITRATED:
        truth, ours = arbiter(rows, columns), mine[rows, columns]
        with np.errstate(invalid="ignore"):
            settled = int(((np.abs(truth - ours) <= 1e-5 * np.abs(truth)) | (truth == ours)).sum())
    share = 1.0 - (len(rows) - settled) / mine.size
    edge = _edges(objects)  # of ours alone: where two faces coincide the renderer's picture may be nothing but edges
    differ = objects != reference_objects
    off = differ & ~edge
    return PreviewComparison(
        int(mine.size), int(wrong.sum()), int(spread.sum()), settled, 1.0 - float(wrong.mean()), share, int((wrong & ~edge).sum()),
        float(relative[~edge].max()) if (~edge).any() else 0.0, int(differ.sum()), int(edge.sum()), int(off.sum()),
        int((off & ~wrong).sum()),
    )
