# SPDX-License-Identifier: GPL-3.0-or-later
"""Chains of portals asked directly."""

from __future__ import annotations

import enfilade_native as native
import numpy as np
import pytest
from enfilade_native import chain


def door(x: float, y0: float, y1: float, z0: float = 0.0, z1: float = 2.0) -> np.ndarray:
    """Upright, across x; its normal points along +x."""
    return np.array([[x, y0, z0], [x, y1, z0], [x, y1, z1], [x, y0, z1]])


def test_doors_in_line_are_seen_through():
    answer = chain.query([door(0, 1, 2), door(4, 1, 2), door(8, 1, 2)])
    assert answer.status == "visible" and answer.shown_by == "line"
    start, end = answer.segment
    for x in (0.0, 4.0, 8.0):
        _, y, z = start + (x - start[0]) / (end[0] - start[0]) * (end - start)
        assert 1 < y < 2 and 0 < z < 2
    assert answer.clearance >= answer.delta > 0


def test_doors_aside_hide():
    answer = chain.query([door(0, 0, 0.2), door(4, 2.8, 3.0), door(8, 0, 0.2)])
    assert answer.status == "hidden" and answer.shown_by in ("windows", "cone") and answer.segment is None


def test_a_chain_backward_is_hidden_and_reversed_is_seen():
    doors = [door(0, 1, 2), door(4, 1, 2)]
    assert chain.query(doors[::-1]).status == "hidden"
    assert chain.query([d[::-1] for d in doors[::-1]]).status == "visible"


def test_the_answer_is_the_bakes():
    rng = np.random.default_rng(3)
    from rooms import suite

    for _ in range(20):
        sides = [(a, a + 0.3) for a in rng.uniform(0, 2.6, 3)]
        with suite(sides) as scene, native.region.run(scene) as baked:
            asked = chain.query([door(4.0 * (i + 1), y0, y1) for i, (y0, y1) in enumerate(sides)])
            assert asked.status == baked.pair(0, 3)


def test_wrong_portals_are_named():
    for portals, word in [
        ([], "0 portals"),
        ([door(0, 1, 1)], "portal 0 has no area"),
        ([door(0, 1, 2), door(1, 1, float("nan"))], "portal 1"),
        ([door(0, 1, 2)[:2]], "2 corners"),
        ([[1, 2, 3]], "shape"),
    ]:
        with pytest.raises(native.InvalidArgumentError, match=word):
            chain.query(portals)
