# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls that are askew to the building's main direction: rooms end on them, and their doors and windows join what they should."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules.geometry_elements import DOOR, SHELL, Element
from test_geometry import box, summary
from test_geometry_scenes import found, wedge

HALL = [box((-0.2, -0.2, -0.3), (9.2, 5.2, 0)), box((-0.2, -0.2, 2.6), (9.2, 5.2, 2.9)), box((-0.2, -0.2, 0), (0, 5.2, 2.6)),
        box((9, -0.2, 0), (9.2, 5.2, 2.6)), box((0, -0.2, 0), (9, 0, 2.6)), box((0, 5, 0), (9, 5.2, 2.6))]  # fmt: skip


def slab(start, end, thick, low, high, kind=SHELL) -> Element:
    """An upright box along the line from start to end."""
    a, b = np.array(start, float), np.array(end, float)
    across = np.array([-(b - a)[1], (b - a)[0]]) * 0.5 * thick / np.linalg.norm(b - a)
    ring = [a - across, b - across, a + across, b + across]
    return wedge([(x, y, z) for z in (low, high) for x, y in ring], kind)


def partition(x: float, degrees: float, thick: float, leaf: bool) -> list[Element]:
    """Across the hall, with a door from y = 2 to 3."""

    def at(y: float) -> tuple[float, float]:
        return x + (y - 2.5) * np.tan(np.radians(degrees)), y

    parts = [slab(at(-0.05), at(2), thick, 0, 2.6), slab(at(3), at(5.05), thick, 0, 2.6), slab(at(2), at(3), thick, 2.1, 2.6)]
    return [*parts, slab(at(2), at(3), 0.04, 0, 2.1, DOOR)] if leaf else parts


@pytest.mark.parametrize("degrees", [8.0, 20.0, 45.0])
@pytest.mark.parametrize("thick", [0.1, 0.2])
def test_doors_in_walls_that_are_askew(degrees, thick):
    made = found([*HALL, *partition(3.0, degrees, thick, True), *partition(6.0, degrees, thick, True)], "classes")
    assert summary(made) == (3, [("in", "in")] * 2)
    along = np.array([np.sin(np.radians(degrees)), np.cos(np.radians(degrees))])
    west = next(r.vertices for r in made.rooms if r.vertices is not None and r.vertices[:, 0].min() < 0.1)
    off = (west[:, :2] - (3.0, 2.5)) @ (along[1], -along[0])
    assert abs(off.max() + 0.5 * thick) < 0.01  # the room ends at its side of the wall


@pytest.mark.parametrize("degrees", [8.0, 20.0, 45.0])
@pytest.mark.parametrize("thick", [0.1, 0.2])
@pytest.mark.parametrize("leaf", [True, False])
def test_doors_of_a_soup_in_walls_that_are_askew(degrees, thick, leaf):
    made = found([*HALL, *partition(3.0, degrees, thick, leaf), *partition(6.0, degrees, thick, leaf)], "triangles")
    assert summary(made) == (3, [("in", "in")] * 2)
