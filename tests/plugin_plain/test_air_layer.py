# SPDX-License-Identifier: GPL-3.0-or-later
"""Which trapezoids of a decomposition lie beside each other, against all pairs, and in how much memory."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from enfilade.rules import air_layer, trapezoids


def _all_pairs(pieces: np.ndarray) -> set[tuple[int, int]]:
    """By each two upright sides that lie on one line, and each two level ones."""
    found = set()
    for i, (_, right, _, b, _, t) in enumerate(pieces.tolist()):
        for j, (left, _, low, _, high, _) in enumerate(pieces.tolist()):
            if abs(right - left) < air_layer.SEAM and min(t, high) - max(b, low) > air_layer.STEP:
                found.add((i, j))
    for i, (x0, x1, _, _, t0, t1) in enumerate(pieces.tolist()):
        for j, (y0, y1, b0, b1, _, _) in enumerate(pieces.tolist()):
            level = abs(t0 - t1) < air_layer.SEAM and abs(b0 - b1) < air_layer.SEAM and abs(t0 - b0) < air_layer.SEAM
            one_strip = (x0, x1) == (y0, y1) and abs(t0 - b0) < air_layer.SEAM and abs(t1 - b1) < air_layer.SEAM
            if i != j and ((level and min(x1, y1) - max(x0, y0) > air_layer.STEP) or one_strip):
                found.add((i, j))
    return found


@pytest.mark.parametrize("seed", range(4))
def test_neighbours_are_those_of_all_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, along = rng.random((40, 2)) * 4.0, rng.normal(size=(40, 2)) * 0.7
    kind = rng.integers(0, 3, 40)
    along[kind == 0, 0], along[kind == 1, 1] = 0.0, 0.0
    pieces = trapezoids.decompose(np.column_stack([start, start + along]), np.zeros(2), np.full(2, 4.0))
    i, j = air_layer._neighbours(pieces)
    assert len(pieces) > 100 and set(zip(i.tolist(), j.tolist(), strict=True)) == _all_pairs(pieces)


def test_a_long_line_costs_no_more_than_what_stands_on_it() -> None:
    """Pairs of all that stands on one line would take gigabytes here."""
    bottom = np.repeat(np.arange(20_000) * 0.01, 2)
    left = np.tile([0.0, 1.0], 20_000)
    pieces = np.column_stack([left, left + 1.0, bottom, bottom, bottom + 0.01, bottom + 0.01])
    tracemalloc.start()
    i, j = air_layer._neighbours(pieces)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    beside = left[i] != left[j]
    assert (bottom[i] == bottom[j])[beside].all() and beside.sum() == 20_000
    assert peak < 1_000 * len(pieces)  # bytes
