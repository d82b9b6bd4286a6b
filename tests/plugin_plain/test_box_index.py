# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies near a box, against looking at every box."""

import numpy as np
import pytest
from enfilade.rules.box_index import BoxIndex


@pytest.mark.parametrize("far", [0.0, 1e7, 1e12])
def test_near_is_what_looking_at_every_box_gives(far):
    rng = np.random.default_rng(7)
    low = rng.uniform(-60.0, 60.0, (400, 3))
    high = low + rng.exponential(3.0, (400, 3)) * rng.choice([0.0, 1.0, 20.0], (400, 1))
    low[5] = np.inf  # has no place
    high[6] += far  # reaches, or lies, far off
    low[7] += far
    high[7] += far
    index = BoxIndex(low, high)
    for _ in range(300):
        a = rng.uniform(-80.0, 80.0, 3)
        b = a + rng.exponential(2.0, 3) * rng.choice([0.0, 1.0, 50.0])
        expected = np.nonzero((low <= b).all(axis=1) & (high >= a).all(axis=1))[0]
        assert index.near(a, b).tolist() == expected.tolist()
    assert index.near(low[7], high[7]).tolist() == np.nonzero((low <= high[7]).all(axis=1) & (high >= low[7]).all(axis=1))[0].tolist()


def test_nothing_is_near_in_an_empty_index():
    assert BoxIndex(np.zeros((0, 3)), np.zeros((0, 3))).near(np.zeros(3), np.ones(3)).tolist() == []
