# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms from geometry alone, on small buildings made of boxes: what is joined, where, and that nothing connected is lost."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import geometry, geometry_grid, geometry_pace
from enfilade.rules.building import EXTERIOR
from enfilade.rules.geometry_elements import DOOR, SHELL, UNKNOWN, WINDOW, Element, kind_of

QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def box(low, high, kind=SHELL, name="") -> Element:
    corners = np.array([(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])], float)
    triangles = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
    return Element(name or kind, kind, corners, triangles)


def two_rooms(gap: float = 0.0) -> list[Element]:
    """6 x 4 m in two rooms with a door in the partition and one outdoors. gap: a slit in the partition, m."""
    wall = 0.2
    parts = [
        box((-wall, -wall, -0.3), (6 + wall, 4 + wall, 0)),
        box((-wall, -wall, 2.6), (6 + wall, 4 + wall, 2.9)),
        box((-wall, 4, 0), (6 + wall, 4 + wall, 2.6)),
        box((-wall, 0, 0), (0, 4, 2.6)),
        box((6, 0, 0), (6 + wall, 4, 2.6)),
        # south wall with a door hole from x = 1 to 2
        box((-wall, -wall, 0), (1, 0, 2.6)),
        box((2, -wall, 0), (6 + wall, 0, 2.6)),
        box((1, -wall, 2.1), (2, 0, 2.6)),
        # partition at x = 3 with a door hole from y = 1 to 2
        box((3, 0, 0), (3.1, 1, 2.6)),
        box((3, 2, 0), (3.1, 4 - gap, 2.6)),
        box((3, 1, 2.1), (3.1, 2, 2.6)),
    ]
    return parts


def doors() -> list[Element]:
    return [box((1, -0.12, 0), (2, -0.08, 2.1), DOOR, "Front"), box((3.03, 1, 0), (3.07, 2, 2.1), DOOR, "Inner")]


def turned(elements, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return [e.moved(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]), np.array([13.0, -7.0, 2.0])) for e in elements]


def summary(building) -> tuple[int, list[tuple[str, ...]]]:
    """Rooms, and for each opening what it joins ("in", "out")."""
    kinds = ["out" if r.kind == EXTERIOR else "in" for r in building.rooms]
    return kinds.count("in"), sorted(tuple(sorted(kinds[r] for r in o.rooms)) for o in building.openings if o.rooms)


@pytest.mark.parametrize("degrees", [0.0, 17.0, 40.0])
def test_two_rooms_by_classes(degrees):
    made = geometry.detect(turned([*two_rooms(), *doors()], degrees))
    assert "classes" in made.problems[0].message
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


@pytest.mark.parametrize("degrees", [0.0, 17.0])
def test_two_rooms_by_triangles_without_leaves(degrees):
    soup = geometry.soup(turned(two_rooms(), degrees))
    made = geometry.detect([soup])
    assert "triangles" in made.problems[0].message
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_two_rooms_by_triangles_with_leaves_and_furniture():
    things = [box((0.5, 2.5, 0), (1.5, 3.5, 0.75), UNKNOWN), box((5, 0.5, 0), (5.9, 1.0, 1.2), UNKNOWN)]
    made = geometry.detect([geometry.soup([*two_rooms(), *doors(), *things])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_rooms_end_at_the_walls():
    made = geometry.detect([*two_rooms(), *doors()])
    bounds = sorted((r.vertices.min(axis=0).round(3).tolist(), r.vertices.max(axis=0).round(3).tolist())
                    for r in made.rooms if r.vertices is not None)
    assert bounds == [([0, 0, 0], [3, 4, 2.6]), ([3.1, 0, 0], [6, 4, 2.6])]


def test_the_openings_cover_their_holes():
    made = geometry.detect([geometry.soup(two_rooms())])
    for low, high in (((1, -0.2, 0), (2, 0, 2.1)), ((3, 1, 0), (3.1, 2, 2.1))):
        assert any(
            o.body is not None and (o.body.min(axis=0) <= np.array(low) + 0.011).all() and (o.body.max(axis=0) >= np.array(high) - 0.011).all()
            for o in made.openings
        )


def test_a_slit_is_told_where_it_is():
    made = geometry.detect([*two_rooms(gap=0.15), *doors()])
    assert summary(made)[0] == 2
    leaks = [p for p in made.problems if p.code == "rooms-leak"]
    for p in leaks:
        assert np.linalg.norm(np.array(p.position)[:2] - (3.05, 3.93)) < 0.5
    assert leaks


def test_a_wall_that_ends_half_way_up_parts_nothing():
    low = [e for e in two_rooms() if not (e.vertices[:, 0].min() == 3.0)]
    made = geometry.detect([*low, box((3, 0, 0), (3.1, 4, 1.2)), doors()[0]])
    assert summary(made)[0] == 1


def test_a_column_stays_in_its_room():
    made = geometry.detect([*two_rooms(), *doors(), box((1.4, 2, 0), (1.7, 2.3, 2.6))])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_storeys_meet_through_the_hole_of_a_stair():
    """Two storeys of one room each, a hole of 1 x 2 m in the floor between."""
    parts = [
        box((-0.2, -0.2, -0.3), (5.2, 4.2, 0)), box((-0.2, -0.2, 5.5), (5.2, 4.2, 5.8)),
        box((-0.2, -0.2, 0), (0, 4.2, 5.5)), box((5, -0.2, 0), (5.2, 4.2, 5.5)),
        box((0, -0.2, 0), (5, 0, 5.5)), box((0, 4, 0), (5, 4.2, 5.5)),
        box((0, 0, 2.6), (5, 2, 2.9)), box((0, 2, 2.6), (4, 4, 2.9)),
        box((1, -0.12, 0), (2, -0.08, 2.1), WINDOW),
    ]  # fmt: skip
    made = geometry.detect(parts)
    assert summary(made)[0] == 2
    between = [o for o in made.openings if o.rooms and all(made.rooms[r].kind != EXTERIOR for r in o.rooms)]
    assert len(between) == 1 and between[0].kind == "hole"
    assert np.ptp(between[0].polygon[:, 0]) >= 1.0 and np.ptp(between[0].polygon[:, 1]) >= 2.0


def test_a_sloped_roof_cuts_the_room():
    """An attic under two slopes: its shape must not reach above them."""
    def slope(y0, y1, z0, z1):
        c = np.array([(x, y, z + d) for d in (0, 0.25) for (y, z) in ((y0, z0), (y1, z1)) for x in (-0.3, 6.3)], float)
        return Element("roof", SHELL, c, np.array([t for a, b, cc, d in QUADS for t in ((a, b, cc), (a, cc, d))]))

    gables = []
    for x in (-0.2, 6.0):
        c = np.array([(x + dx, y, z) for dx in (0, 0.2) for y, z in ((0, 0), (6, 0), (6, 0.5), (3, 3.5), (0, 0.5))], float)
        f = [(0, 1, 2), (0, 2, 3), (0, 3, 4)]
        sides = [(i, (i + 1) % 5, i + 5) for i in range(5)] + [((i + 1) % 5, (i + 1) % 5 + 5, i + 5) for i in range(5)]
        gables.append(Element("wall", SHELL, c, np.array([*f, *[(a + 5, b + 5, d + 5) for a, b, d in f], *sides])))
    parts = [box((-0.2, -0.2, -0.3), (6.2, 6.2, 0)), slope(-0.3, 3, 0.2, 3.5), slope(3, 6.3, 3.5, 0.2), *gables,
             box((-0.2, -0.2, 0), (6.2, 0, 0.5)), box((-0.2, 6, 0), (6.2, 6.2, 0.5)), box((2, 2, -0.3), (3, 3, -0.05), WINDOW)]
    made = geometry.detect(parts, mode="classes")
    room = next(r for r in made.rooms if r.vertices is not None)
    v = room.vertices
    assert (v[:, 2] <= 3.5 - np.abs(v[:, 1] - 3) + 0.25).all()
    assert v[:, 2].max() > 3.2


def test_names_tell_classes():
    wanted = {"IfcWallStandardCase/W1": "shell", "Door_012": "door", "Fenster 3": "window", "wall cabinet": "furniture",
              "IfcCurtainWall/x": "shell", "StairFlight": "stair", "Cube.001": "unknown", "IfcSite/Terrain": "site"}
    assert {name: kind_of(name) for name in wanted} == wanted


def test_nothing_to_find_is_told():
    with pytest.raises(geometry.GeometryError, match="no walls"):
        geometry.detect([])
    with pytest.raises(geometry.GeometryError, match="finite"):
        bad = box((0, 0, 0), (1, 1, 1))
        bad.vertices[0, 0] = np.nan
        geometry.detect([bad])
    open_air = geometry.detect([box((0, 0, 0), (4, 4, 0.2))], mode="classes")
    assert any(p.code == "no-rooms" for p in open_air.problems)


@pytest.mark.parametrize("feet", [1.0, 1.0 / 0.3048])
def test_rooms_as_high_as_halls_are_told_as_a_matter_of_units(feet):
    made = geometry.detect([e.moved(feet * np.eye(3), np.zeros(3)) for e in [*two_rooms(), *doors()]], mode="classes")
    assert summary(made)[0] > 0
    assert any(p.code == "odd-scale" for p in made.problems) == (feet > 1.0)


def test_memory_is_said_and_bounded():
    with pytest.raises(geometry.GeometryError, match="GB"):
        geometry.detect([box((0, 0, 0), (3000, 3000, 100))], mode="classes")
    step, shape = geometry_grid.plan(np.zeros(3), np.array([100.0, 100.0, 80.0]))
    assert geometry_grid.STEP < step <= geometry_grid.COARSEST and len(shape) == 3
    assert geometry_pace.Estimate.of(float(np.prod(shape)), 5e5).bytes < 2e9
    first: list[str] = []
    geometry.detect(two_rooms(), mode="classes", progress=lambda fraction, label: first.append(label) is None)
    assert "a grid of 0.10 m" in first[0] and geometry_pace.Estimate.of(6e7, 1e6).words.startswith("about ")


@pytest.mark.parametrize("stage", geometry_pace.STAGES)
def test_it_can_be_cancelled_in_each_stage(stage):
    with pytest.raises(geometry.Cancelled, match=stage):
        geometry.detect([*two_rooms(), *doors()], progress=lambda fraction, label: not label.startswith(stage))
