# SPDX-License-Identifier: GPL-3.0-or-later
"""Polygon soups as other programs write them: single sheets, walls without caps, faces doubled or turned over, panes without thickness, lids on roofs."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import geometry
from enfilade.rules.geometry_elements import DOOR, SHELL, UNKNOWN, WINDOW, Element
from test_geometry import box, doors, summary, turned, two_rooms
from test_geometry_scenes import MODES, found


def soup_of(vertices, triangles) -> list[Element]:
    return [Element("soup", UNKNOWN, np.asarray(vertices, float), np.asarray(triangles))]


def joined(parts) -> tuple[np.ndarray, np.ndarray]:
    whole = geometry.soup(parts)
    return whole.vertices, whole.triangles


def sheet(*corners) -> Element:
    return Element("sheet", SHELL, np.array(corners, float), np.array([(0, 1, 2), (0, 2, 3)]))


def upright(start, end, top, hole=None) -> list[Element]:
    """A wall without thickness; hole: first and last metre along it, sill and lintel."""
    a, b = np.array(start, float), np.array(end, float)
    length = float(np.linalg.norm(b - a))

    def part(s0, s1, z0, z1) -> Element:
        return sheet(*[(*(a + (b - a) * s / length), z) for s, z in ((s0, z0), (s1, z0), (s1, z1), (s0, z1))])

    if hole is None:
        return [part(0, length, 0, top)]
    s0, s1, sill, lintel = hole
    parts = [part(0, s0, 0, top), part(s1, length, 0, top), part(s0, s1, lintel, top)]
    return parts + ([part(s0, s1, 0, sill)] if sill > 0 else [])


def house_of_sheets() -> list[Element]:
    """Two rooms of 3 x 4 m: doors between and outdoors, a window."""
    door, top = (1.5, 2.5, 0, 2.05), 2.6
    walls = [*upright((0, 0), (6, 0), top), *upright((6, 0), (6, 4), top), *upright((6, 4), (0, 4), top, (4.0, 5.2, 0.9, 2.1)),
             *upright((0, 4), (0, 0), top, door), *upright((3, 0), (3, 4), top, door)]  # fmt: skip
    return walls + [sheet((0, 0, z), (6, 0, z), (6, 4, z), (0, 4, z)) for z in (0, top)]


@pytest.mark.parametrize("degrees", [0.0, 17.0])
def test_walls_that_are_single_sheets(degrees):
    assert summary(found(turned(house_of_sheets(), degrees), "triangles")) == (2, [("in", "in"), ("in", "out"), ("in", "out")])


def doubled(v, t):
    return v, np.concatenate([t, t])


def doubled_and_turned_over(v, t):
    return v, np.concatenate([t, t[:, ::-1]])


def half_turned_over(v, t):
    return v, np.where((np.arange(len(t)) % 2 == 0)[:, None], t, t[:, ::-1])


def unwelded(v, t):
    return v[t].reshape(-1, 3), np.arange(3 * len(t)).reshape(-1, 3)


def torn(v, t):
    """Corners that should be one, up to 2 mm apart."""
    v, t = unwelded(v, t)
    return v + np.random.default_rng(1).uniform(-1e-3, 1e-3, v.shape), t


@pytest.mark.parametrize("spoil", [doubled, doubled_and_turned_over, half_turned_over, unwelded, torn])
def test_faces_that_are_doubled_or_turned_over_or_torn(spoil):
    made = found(soup_of(*spoil(*joined([*two_rooms(), *doors()]))), "triangles")
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


@pytest.mark.parametrize("mode", MODES)
def test_walls_without_caps(mode):
    def open_box(e: Element) -> Element:
        faces = e.vertices[e.triangles]
        level = np.ptp(faces[:, :, 2], axis=1) == 0.0
        return e if np.ptp(e.vertices[:, 2]) < 1.0 else Element(e.name, e.kind, e.vertices, e.triangles[~level])

    made = found([*map(open_box, two_rooms()), *doors()], mode)
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def ring(low, high, bar) -> Element:
    """A frame along the x axis, its bars `bar` wide, in one closed piece."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    corners = [(x, y, z) for y in (y0, y1) for x, z in ((x0, z0), (x1, z0), (x1, z1), (x0, z1),
               (x0 + bar, z0 + bar), (x1 - bar, z0 + bar), (x1 - bar, z1 - bar), (x0 + bar, z1 - bar))]  # fmt: skip
    quads = []
    for i in range(4):
        j = (i + 1) % 4
        quads += [(i, j, j + 4, i + 4), (j + 8, i + 8, i + 12, j + 12), (j, i, i + 8, j + 8), (i + 4, j + 4, j + 12, i + 12)]
    return Element("frame", SHELL, np.array(corners), np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def test_a_pane_without_thickness_in_a_frame():
    frame = ring((1, -0.13, 0), (2, -0.07, 2.1), 0.06)
    pane = sheet((1.06, -0.1, 0.06), (1.94, -0.1, 0.06), (1.94, -0.1, 2.04), (1.06, -0.1, 2.04))
    assert summary(found([*two_rooms(), frame, pane, doors()[1]], "triangles")) == (2, [("in", "in"), ("in", "out")])


def test_a_window_deeper_than_its_wall():
    """One solid with its sills, 0.64 m deep in a wall of 0.2 m."""
    parts = [e for e in two_rooms() if e.vertices[:, 1].max() > 0.0]
    parts += [box((-0.2, -0.2, 0), (1, 0, 2.6)), box((2, -0.2, 0), (6.2, 0, 2.6)), box((1, -0.2, 2.3), (2, 0, 2.6))]
    made = found([*parts, box((1, -0.42, 0), (2, 0.22, 2.3), WINDOW), doors()[1]], "triangles")
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_a_cupboard_in_a_niche_is_no_window():
    parts = [*two_rooms(), *doors(), box((4, 0, 2.2), (5, 0.6, 2.6)), box((3.9, 0, 0), (4, 0.6, 2.6)), box((5, 0, 0), (5.1, 0.6, 2.6))]
    made = found([*parts, box((4, 0, 0), (5, 0.6, 2.2), UNKNOWN)], "triangles")
    assert summary(made)[1] == [("in", "in"), ("in", "out")]


@pytest.mark.parametrize("lid", [True, False])
def test_a_roof_light(lid):
    """A hole of 1.2 m in the roof, with a pane in its frame on top, or open."""
    parts = [e for e in two_rooms() if e.vertices[:, 2].max() < 2.8]
    parts += [box((-0.2, -0.2, 2.6), (1, 4.2, 2.9)), box((2.2, -0.2, 2.6), (6.2, 4.2, 2.9)),
              box((1, -0.2, 2.6), (2.2, 1.4, 2.9)), box((1, 2.6, 2.6), (2.2, 4.2, 2.9))]  # fmt: skip
    pane = [box((0.95, 1.35, 2.9), (2.25, 2.65, 2.96), WINDOW)] if lid else []
    made = found([*parts, *doors(), *pane], "triangles")
    assert sum(not r.name.startswith("Void") for r in made.rooms[:-1]) == 2
    ends = [o.ends[0] if o.polygon is None else o.polygon for o in made.openings]
    level = [end for end in ends if np.ptp(end[:, 2]) < 0.01]
    assert len(level) == 1 and (level[0].min(axis=0) < (1.01, 1.41, 2.61)).all() and (level[0].max(axis=0) > (2.19, 2.59, 2.59)).all()


@pytest.mark.parametrize("units", [1000.0, 100.0])
def test_other_units_are_told_by_the_extent(units):
    parts = [Element(e.name, e.kind, units * e.vertices, e.triangles) for e in [*two_rooms(), *doors()]]
    with pytest.raises(geometry.GeometryError, match="millimetre or a centimetre"):
        found(parts, "classes")


def test_a_leaf_drawn_with_the_corners_of_its_wall_over_a_floor_that_runs_through():
    """It stands in the floor's finish: three solids overlap at its foot."""
    floor = box((0, 0, 0), (6, 4, 0.02))
    made = found([*two_rooms(), floor, doors()[0], box((3.0, 1, 0), (3.05, 2, 2.1), DOOR)], "triangles")
    assert summary(made) == (2, [("in", "in"), ("in", "out")])
