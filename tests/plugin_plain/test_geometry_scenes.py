# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms from geometry alone, one small building a phenomenon: gaps, curved and leaning walls, storeys, stairs, low attics, open doors."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import geometry, geometry_pace, geometry_soup, polyhedra
from enfilade.rules.building import EXTERIOR
from enfilade.rules.geometry_elements import DOOR, SHELL, UNKNOWN, WINDOW, Element
from test_geometry import QUADS, box, doors, summary, turned, two_rooms

MODES = ("classes", "triangles")


def found(parts, mode):
    """By classes as they are, by triangles as one soup."""
    return geometry.detect(parts if mode == "classes" else [geometry.soup(parts)], mode=mode)


def wedge(corners, kind=SHELL) -> Element:
    """A solid of eight corners, ordered as those of a box."""
    return Element(kind, kind, np.array(corners, float), np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]))


def leaks(building):
    return [p for p in building.problems if p.code == "rooms-leak"]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("gap", [0.15, 0.25])
@pytest.mark.parametrize("degrees", [0.0, 17.0])
def test_rooms_with_gaps_between_their_walls_stay_two(mode, gap, degrees):
    parts = turned([*two_rooms(gap), *doors()], degrees)
    made = found(parts, mode)
    assert summary(made)[0] == 2
    place = turned([box((3.0, 4.0 - gap, 1.0), (3.1, 4.0, 1.5))], degrees)[0].vertices[:, :2].mean(axis=0)
    crossing = [o.body.mean(axis=0)[:2] for o in made.openings if o.kind == "virtual"]
    assert any(np.linalg.norm(c - place) < 0.4 for c in crossing)  # and one looks through the gap


@pytest.mark.parametrize("mode", MODES)
def test_a_gap_that_joins_two_rooms_is_shown_where_it_is(mode):
    made = found([*two_rooms(0.55), *doors()], mode)
    assert summary(made)[0] == 1
    (leak,) = leaks(made)
    assert "two rooms" in leak.message and np.linalg.norm(np.array(leak.position)[:2] - (3.05, 3.72)) < 0.3


@pytest.mark.parametrize("mode", MODES)
def test_a_room_that_runs_out_into_the_open_is_shown_too(mode):
    parts = [e for e in two_rooms() if not (e.vertices[:, 0].min() == 6.0 and e.vertices[:, 2].max() == 2.6)]
    made = found([*parts, box((6, 0, 0), (6.2, 3.4, 2.6)), *doors()], mode)
    assert summary(made)[0] == 1
    assert any("into the open" in p.message and np.linalg.norm(np.array(p.position)[:2] - (6.1, 3.7)) < 0.5 for p in leaks(made))


@pytest.mark.parametrize("mode", MODES)
def test_a_round_room_beside_a_square_one(mode):
    """A tower of 4 m radius: 24 straight pieces of wall, a door as wide as one of them to the room east of it."""
    parts = [box((-4.5, -4.5, -0.3), (8.2, 4.5, 0)), box((-4.5, -4.5, 2.6), (8.2, 4.5, 2.9))]
    for i in range(24):
        a, b = 2 * np.pi * (i - 0.5) / 24, 2 * np.pi * (i + 0.5) / 24
        low, high = (2.1 if i == 0 else 0.0), 2.6
        ring = [(r * np.cos(t), r * np.sin(t)) for t in (a, b) for r in (4.0, 4.2)]
        parts.append(wedge([(x, y, z) for z in (low, high) for x, y in ring]))
    parts += [box((3.4, 2, 0), (8.2, 2.2, 2.6)), box((3.4, -2.2, 0), (8.2, -2, 2.6)), box((8, -2, 0), (8.2, 2, 2.6))]
    parts.append(box((4.02, -0.5, 0), (4.06, 0.5, 2.1), DOOR, "Door"))
    made = found(parts, mode)
    rooms, joins = summary(made)
    assert rooms == 2 and joins.count(("in", "in")) == 1
    tower = next(r for r in made.rooms if r.vertices is not None and r.vertices[:, 0].min() < -3)
    assert len(tower.vertices) <= 96  # straight pieces, not the steps of voxels
    far = np.hypot(*tower.vertices[:, :2].T)
    assert (far > 3.95).all() and (far < 4.35).all()  # holds all of its air, and little of its wall


def test_a_straight_door_in_a_bent_wall_leads_to_the_room_behind():
    """2 m wide in a wall of 2.5 m radius: the room behind begins where the wall bends away."""
    parts = [box((-3, -3, -0.3), (6.2, 3, 0)), box((-3, -3, 2.6), (6.2, 3, 2.9))]
    for i in range(24):
        a, b = 2 * np.pi * (i - 0.5) / 24, 2 * np.pi * (i + 0.5) / 24
        ring = [(r * np.cos(t), r * np.sin(t)) for t in (a, b) for r in (2.5, 2.7)]
        parts.append(wedge([(x, y, z) for z in (2.1 if i in (0, 1, 23) else 0.0, 2.6) for x, y in ring]))
    parts += [box((1.9, 2, 0), (6.2, 2.2, 2.6)), box((1.9, -2.2, 0), (6.2, -2, 2.6)), box((6, -2, 0), (6.2, 2, 2.6))]
    made = found([*parts, box((2.45, -1.0, 0), (2.5, 1.0, 2.1), DOOR, "Door")], "classes")
    rooms, joins = summary(made)
    assert rooms == 2 and ("in", "in") in joins


@pytest.mark.parametrize("mode", MODES)
def test_a_leaning_wall_parts_rooms(mode):
    """The partition leans 0.8 m over its height of 2.6 m."""
    parts = [e for e in two_rooms() if not 2.9 < e.vertices[:, 0].min() < 3.2]
    lean = wedge([(x + (0.8 if z else 0), y, z) for z in (0, 2.6) for y in (0, 4) for x in (2.6, 2.8)])
    made = found([*parts, lean, doors()[0]], mode)
    assert summary(made) == (2, [("in", "out")])


@pytest.mark.parametrize("mode", MODES)
def test_half_height_partitions_and_counters_part_nothing(mode):
    parts = [e for e in two_rooms() if not 2.9 < e.vertices[:, 0].min() < 3.2]
    made = found([*parts, doors()[0], box((3, 0, 0), (3.1, 4, 1.3)), box((4, 1, 0), (4.6, 4, 1.1))], mode)
    assert summary(made) == (1, [("in", "out")])


def storeys(count: int) -> list[Element]:
    """Halls of 6 x 5 m, 3 m a storey, a stairwell of 2 x 4 m through all floors."""
    top = 3.0 * count
    parts = [box((-0.2, -0.2, 0), (0, 5.2, top)), box((6, -0.2, 0), (6.2, 5.2, top)),
             box((0, -0.2, 0), (6, 0, top)), box((0, 5, 0), (6, 5.2, top)), box((-0.2, -0.2, -0.3), (6.2, 5.2, 0))]  # fmt: skip
    for s in range(1, count):
        z = 3.0 * s
        parts += [box((0, 0, z - 0.25), (4, 5, z)), box((4, 0, z - 0.25), (6, 1, z))]
    return [*parts, box((-0.2, -0.2, top), (6.2, 5.2, top + 0.3)), box((1, -0.12, 0), (2, -0.08, 2.1), WINDOW)]


def flight(z: float) -> list[Element]:
    """Steps one by one up along the well's west half and back along its east half, with a landing and a balustrade: one above the other in every storey."""
    steps = [box((4.0, 1 + 0.3 * i, z + 0.17 * (i + 1) - 0.06), (4.95, 1.32 + 0.3 * i, z + 0.17 * (i + 1)), UNKNOWN) for i in range(8)]
    steps += [box((5.05, 1 + 0.3 * i, z + 2.89 - 0.17 * i - 0.06), (6.0, 1.32 + 0.3 * i, z + 2.89 - 0.17 * i), UNKNOWN) for i in range(8)]
    rail = [wedge([(x, y, z + (0.1 if y == 1 else 1.5) + up) for up in (0, 1.0) for y in (1, 3.4) for x in (4.97, 5.0)], UNKNOWN)]
    return [*steps, box((4.0, 3.4, z + 1.4), (6.0, 5.0, z + 1.53), UNKNOWN), *rail]


@pytest.mark.parametrize("mode", MODES)
def test_flights_over_flights_leave_the_storeys_apart(mode):
    parts = storeys(3)
    made = found([*parts, *(e for s in range(2) for e in flight(3.0 * s))] if mode == "triangles" else parts, mode)
    halls = [r for r in made.rooms if r.kind != EXTERIOR]
    assert len(halls) == 3
    joined = {tuple(sorted(o.rooms)) for o in made.openings if o.kind == "hole" and o.rooms}
    assert joined == {(0, 1), (1, 2)}
    for o in made.openings:
        if o.kind == "hole":  # covers the well
            assert (o.polygon.min(axis=0)[:2] <= (4.01, 1.11)).all() and (o.polygon.max(axis=0)[:2] >= (5.99, 4.99)).all()
            assert min(abs(o.polygon[0, 2] - z) for z in (3.0, 6.0)) < 1e-6  # where the floor is drawn


@pytest.mark.parametrize("mode", MODES)
def test_a_low_attic_is_a_room(mode):
    """1.2 m high over the ceiling, shut on all sides."""
    made = found([*two_rooms(), *doors(), box((-0.2, -0.2, 2.9), (6.2, 0, 4.1)), box((-0.2, 4, 2.9), (6.2, 4.2, 4.1)),
                  box((-0.2, 0, 2.9), (0, 4, 4.1)), box((6, 0, 2.9), (6.2, 4, 4.1)), box((-0.2, -0.2, 4.1), (6.2, 4.2, 4.3))], mode)  # fmt: skip
    assert summary(made)[0] == 3


def test_a_door_as_high_as_the_room_and_one_drawn_open():
    """No lintel over the first, only jambs; the leaf of the second stands at a right angle to its wall, in one piece with its frame."""
    parts = [e for e in two_rooms() if not (2.9 < e.vertices[:, 0].min() < 3.2 and e.vertices[:, 2].min() > 2)]
    inner = box((3.02, 1, 0), (3.07, 2, 2.6), UNKNOWN)
    made = geometry.detect([geometry.soup([*parts, inner, doors()[0]])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])
    leaf = box((2.1, 1.02, 0), (3.07, 1.06, 2.05), UNKNOWN)
    sill = box((3.02, 1.0, 2.05), (3.08, 2.0, 2.1), UNKNOWN)
    made = geometry.detect([geometry.soup([*two_rooms(), leaf, sill, doors()[0]])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_pictures_on_walls_are_no_windows():
    things = [box((0.0, 1, 1), (0.03, 2.5, 2), UNKNOWN), box((2.97, 2.5, 1.2), (3.0, 3.5, 1.9), UNKNOWN)]
    made = geometry.detect([geometry.soup([*two_rooms(), *doors(), *things])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_a_thin_wall_with_a_door_is_a_wall():
    """8 cm, most of it door: not taken for a balustrade, nor for a pane."""
    parts = [e for e in two_rooms() if not 2.9 < e.vertices[:, 0].min() < 3.2]
    u = [(0, 0), (1.3, 0), (1.3, 2.1), (2.3, 2.1), (2.3, 0), (4, 0), (4, 2.6), (0, 2.6)]  # its outline
    flat = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]
    corners = np.array([(x, y, z) for x in (3.0, 3.08) for y, z in u])
    rim = [t for i in range(8) for j in [(i + 1) % 8] for t in ((i, j, j + 8), (i, j + 8, i + 8))]
    wall = Element("wall", SHELL, corners, np.array([(a, c, b) for a, b, c in flat] + [(a + 8, b + 8, c + 8) for a, b, c in flat] + rim))
    made = geometry.detect([geometry.soup([*parts, wall, doors()[0]])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_doors_drawn_as_one_object_are_told_apart():
    frames = geometry.soup([*doors(), box((5.3, -0.12, 0), (5.9, -0.08, 2.1), UNKNOWN)])
    frames.kind, frames.name = DOOR, "Doors"
    parts = [e for e in two_rooms() if e.vertices[:, 0].min() != 2.0 or e.vertices[:, 1].max() != 0.0]
    parts += [box((2, -0.2, 0), (5.3, 0, 2.6)), box((5.9, -0.2, 0), (6.2, 0, 2.6)), box((5.3, -0.2, 2.1), (5.9, 0, 2.6))]
    made = geometry.detect([*parts, frames], mode="classes")
    assert summary(made) == (2, [("in", "in"), ("in", "out"), ("in", "out")])


def test_solids_that_share_corners_are_pieces_of_their_own():
    wall, leaf = box((0, 0, 0), (4, 0.1, 2.6)), box((1, 0, 0), (2, 0.1, 2.1))
    right = box((4, 0, 0), (8, 0.1, 2.6))
    one = geometry.soup([wall, right, leaf])
    piece, closed = geometry_soup.pieces(one.vertices, one.triangles)
    assert len(set(piece)) == 3 and closed.all()
    assert [len(set(piece[12 * i : 12 * i + 12])) for i in range(3)] == [1, 1, 1]


def test_progress_goes_up_and_names_each_stage():
    seen = []
    geometry.detect([*two_rooms(), *doors()], progress=lambda fraction, label: seen.append((fraction, label)) is None)
    assert [f for f, _ in seen] == sorted(f for f, _ in seen) and seen[-1] == (1.0, "done")
    assert list(dict.fromkeys(name.partition(":")[0] for _, name in seen)) == [*geometry_pace.STAGES, "done"]


@pytest.mark.parametrize("inside_out", ["", "box", "wall", "both"])
def test_solid_boxes_with_a_wall_round_them_are_doors(inside_out):
    """A wall with a hole in one piece, and a box as thick as the wall in it, whichever way their faces look; a pier between two walls stays a wall."""
    parts = [e for e in two_rooms() if not 2.9 < e.vertices[:, 0].min() < 3.2]
    outline = [(0, 0), (1, 0), (1, 2.1), (2, 2.1), (2, 0), (4, 0), (4, 2.6), (0, 2.6)]
    flat = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]
    corners = np.array([(x, y, z) for x in (3.0, 3.2) for y, z in outline])
    rim = [t for i in range(8) for j in [(i + 1) % 8] for t in ((i, j, j + 8), (i, j + 8, i + 8))]
    wall = Element("wall", SHELL, corners, np.array([(a, c, b) for a, b, c in flat] + [(a + 8, b + 8, c + 8) for a, b, c in flat] + rim))
    plug = box((3, 1, 0), (3.2, 2, 2.1), UNKNOWN)
    for e, which in ((plug, ("box", "both")), (wall, ("wall", "both"))):
        e.triangles = np.asarray(e.triangles)[:, :: -1 if inside_out in which else 1]
    made = geometry.detect([geometry.soup([*parts, wall, plug, doors()[0]])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])
    piers = [box((3, y, 0), (3.2, y + 1.0, 2.6), UNKNOWN) for y in (0.0, 1.0, 2.0, 3.0)]
    made = geometry.detect([geometry.soup([*parts, *piers, doors()[0]])])
    assert summary(made) == (2, [("in", "out")])


def frame_with_sashes(x: float, z: float) -> list[Element]:
    """1 m wide, 1.5 m high, in the plane y = -0.1: jambs, sill, head and a bar of 7 cm, a large pane below the bar and a small one over it."""
    bars = [box((x, -0.13, z), (x + 0.07, -0.08, z + 1.5)), box((x + 0.93, -0.13, z), (x + 1, -0.08, z + 1.5))]
    bars += [box((x, -0.13, z + up), (x + 1, -0.08, z + up + 0.07)) for up in (0.0, 1.0, 1.43)]
    return [*bars, box((x + 0.1, -0.11, z + 0.15), (x + 0.9, -0.1, z + 0.93)), box((x + 0.1, -0.11, z + 1.17), (x + 0.9, -0.1, z + 1.35))]


def test_a_window_of_two_sashes_is_as_high_as_its_frame():
    """The lintel is over the upper pane only, which is too low for a pane by itself."""
    parts = [e for e in two_rooms() if not (e.vertices[:, 0].min() == 2.0 and e.vertices[:, 1].max() == 0.0)]
    parts += [box((2, -0.2, 0), (4, 0, 2.6)), box((5, -0.2, 0), (6.2, 0, 2.6)), box((4, -0.2, 0), (5, 0, 0.8)), box((4, -0.2, 2.3), (5, 0, 2.6))]
    made = geometry.detect([geometry.soup([*parts, *doors(), *frame_with_sashes(4.0, 0.8)])])
    assert summary(made) == (2, [("in", "in"), ("in", "out"), ("in", "out")])
    (window,) = (o for o in made.openings if o.kind == WINDOW)
    assert (window.body.min(axis=0)[[0, 2]] <= (4.0, 0.8)).all() and (window.body.max(axis=0)[[0, 2]] >= (5.0, 2.3)).all()


def test_air_below_a_sill_that_sticks_out_of_a_facade_is_no_opening():
    """Two ledges one above the other, outdoors: columns of air under something thin, without jambs."""
    ledges = [box((3.5, -0.35, z), (5.5, -0.2, z + 0.05)) for z in (0.3, 2.0)]
    made = geometry.detect([geometry.soup([*two_rooms(), *doors(), *ledges])])
    assert summary(made) == (2, [("in", "in"), ("in", "out")])


def test_a_wall_between_two_flights_parts_no_hole():
    """A hole of 2 x 3 m in the floor between two storeys, a wall of 20 cm through its middle."""
    parts = [box((-0.2, -0.2, 0), (0, 5.2, 6)), box((6, -0.2, 0), (6.2, 5.2, 6)), box((0, -0.2, 0), (6, 0, 6)), box((0, 5, 0), (6, 5.2, 6)),
             box((-0.2, -0.2, -0.3), (6.2, 5.2, 0)), box((-0.2, -0.2, 6), (6.2, 5.2, 6.3)), box((0, 0, 2.75), (4, 5, 3)), box((4, 0, 2.75), (6, 1, 3)),
             box((4, 4, 2.75), (6, 5, 3)), box((4.9, 1.5, 0), (5.1, 4.5, 3.5))]  # fmt: skip
    made = found(parts, "classes")
    (hole,) = (o for o in made.openings if o.kind == "hole")
    assert (hole.polygon.min(axis=0)[:2] <= (4.0, 1.0)).all() and (hole.polygon.max(axis=0)[:2] >= (6.0, 4.0)).all()


@pytest.mark.parametrize("mode", MODES)
def test_a_hollow_over_a_ceiling_is_a_void_and_no_storey(mode):
    """Walls of two storeys, 3.9 m each, no slab between them; thin ceilings hang at 2.2 m in one room of the lower storey."""
    parts = [box((-0.2, -0.2, -0.3), (8.2, 5.2, 0)), box((-0.2, -0.2, 7.8), (8.2, 5.2, 8.1))]
    for z in (0.0, 3.9):
        parts += [box((-0.2, -0.2, z), (0, 5.2, z + 3.8)), box((8, -0.2, z), (8.2, 5.2, z + 3.8)), box((4, 0, z), (4.1, 5, z + 3.8)),
                  box((-0.2, -0.2, z), (8.2, 0, z + 3.8)), box((-0.2, 5, z), (8.2, 5.2, z + 3.8))]  # fmt: skip
    made = found([*parts, box((0, 0, 2.2), (4, 5, 2.25)), box((1, -0.15, 0), (2, -0.1, 2), DOOR)], mode)
    voids = [r.name for r in made.rooms if r.name.startswith("Void")]
    assert len(voids) == 1 and summary(made)[0] == 5 and made.statistics["voids"] == 1
    (told,) = (p for p in made.problems if p.code == "voids")
    assert told.names == voids and "4 rooms" in made.problems[0].message


def test_units_other_than_metres_are_told():
    for scale, words in ((1000.0, "millimetre"), (0.02, "a unit is a metre")):
        parts = [e.moved(scale * np.eye(3), np.zeros(3)) for e in two_rooms()]
        with pytest.raises(geometry.GeometryError, match=words):
            geometry.detect([geometry.soup(parts)])


@pytest.mark.parametrize("mode", MODES)
def test_rooms_under_a_gable_roof_end_at_its_planes(mode):
    """Two slabs that rise 2.2 m to a ridge over the partition, as high as wardrobes are: no furniture."""
    parts = [e for e in two_rooms() if e.vertices[:, 2].min() < 2.5]
    for x0, z0, x1, z1 in ((-0.5, 2.4, 3.05, 4.6), (3.05, 4.6, 6.6, 2.4)):
        parts.append(wedge([(x, y, z + up) for up in (0, 0.2) for y in (-0.5, 4.5) for x, z in ((x0, z0), (x1, z1))]))
    for y in (-0.2, 4.0):
        parts.append(wedge([(x, y + t, z) for z, xs in ((2.55, (-0.2, 6.2)), (4.55, (3.0, 3.1))) for t in (0, 0.2) for x in xs]))
    made = found([*parts, box((3, 0, 2.6), (3.1, 4, 4.6)), *doors()], mode)
    assert summary(made) == (2, [("in", "in"), ("in", "out")]) and made.statistics["voids"] == 0


def test_a_room_without_a_floor_beside_one_that_has_it():
    parts = [e for e in two_rooms() if e.vertices[:, 2].max() > 0.0]
    made = found([*parts, box((-0.2, -0.2, -0.3), (3.05, 4.2, 0)), *doors()], "classes")
    rooms, joins = summary(made)
    assert rooms == 2 and ("in", "in") in joins
    assert all(abs(r.vertices[:, 2].min()) < 0.11 for r in made.rooms if r.vertices is not None)


def door_with_side_light() -> list[Element]:
    """Door and window side by side in one hole of the south wall, between them nothing."""
    parts = [e for e in two_rooms() if e.vertices[:, 1].max() > 0.0]
    parts += [box((-0.2, -0.2, 0), (1, 0, 2.6)), box((2.8, -0.2, 0), (6.2, 0, 2.6)), box((1, -0.2, 2.1), (2.8, 0, 2.6)),
              box((2, -0.2, 0), (2.8, 0, 0.9))]  # fmt: skip
    return [*parts, box((1, -0.12, 0), (2, -0.08, 2.1), DOOR, "Front"), box((2, -0.12, 0.9), (2.8, -0.08, 2.1), WINDOW, "Side"), doors()[1]]


def test_one_looks_in_by_a_door_and_out_by_the_window_beside_it():
    made = found(door_with_side_light(), "classes")
    joint = [o for o in made.openings if o.members]
    assert len(joint) == 1 and {made.openings[i].name for i in joint[0].members} == {"Front", "Side"}
    assert (joint[0].body[:, 0].min(), joint[0].body[:, 0].max()) <= (1.0, 2.8) and joint[0].body[:, 0].max() >= 2.8


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("degrees", [0.0, 17.0])
def test_openings_end_at_the_facade(mode, degrees):
    """A window whose sill sticks out on both sides, and a hole that voxels make deeper than its wall."""
    parts = [e for e in two_rooms() if e.vertices[:, 1].max() > 0.0]
    parts += [box((-0.2, -0.23, 0), (1, 0, 2.6)), box((2, -0.23, 0), (4, 0, 2.6)), box((5, -0.23, 0), (6.2, 0, 2.6)),
              *(box((x, -0.23, 2.1), (x + 1, 0, 2.6)) for x in (1, 4)), box((4, -0.23, 0), (5, 0, 0.9))]  # fmt: skip
    parts += [box((4, -0.12, 0.9), (5, -0.08, 2.1), WINDOW), doors()[1]]
    made = found(turned(parts, degrees), mode)
    facade = turned([box((-0.2, -0.23, 0), (6.2, -0.23, 2.6))], degrees)[0].vertices
    out = np.cross(facade[1] - facade[0], facade[4] - facade[0])
    out /= np.linalg.norm(out)
    outer = next(i for i, r in enumerate(made.rooms) if r.kind == EXTERIOR)
    reach = [float(((o.body - facade[0]) @ out).max()) for o in made.openings if o.rooms and outer in o.rooms]
    assert reach and max(reach) <= 1e-6


def slope(x: float) -> float:
    return 5.0 - 0.4 * x


def house_with_dormer() -> list[Element]:
    """One room under a roof that slopes along x, its underside at slope(x), 0.2 m thick, with a flat dormer between y = 0.9 and 3.1."""
    parts = [e for e in two_rooms() if e.vertices[:, 2].max() < 2.8 and not 3.0 == e.vertices[:, 0].min() < e.vertices[:, 0].max() < 3.2]

    def strip(x0, x1, y0, y1, bottom, top) -> Element:
        return wedge([(x, y, height(x)) for height in (bottom, top) for y in (y0, y1) for x in (x0, x1)])

    for x1, y0, y1 in ((6.2, -0.2, 1.0), (6.2, 3.0, 4.2), (1.0, 1.0, 3.0)):
        parts.append(strip(-0.2, x1, y0, y1, slope, lambda x: slope(x) + 0.2))
    parts += [box((1.0, 0.9, 4.6), (6.2, 3.1, 4.8)), box((6, 0.9, 2.6), (6.2, 3.1, 4.6)), box((-0.2, -0.2, 2.6), (0, 4.2, 5.1))]
    parts += [strip(1.0, 6.0, y, y + 0.1, slope, lambda x: 4.6) for y in (0.9, 3.0)]
    parts += [strip(-0.2, 6.2, y, y + 0.2, lambda x: 2.6, slope) for y in (-0.2, 4.0)]
    return [*parts, doors()[0]]


@pytest.mark.parametrize("mode", MODES)
def test_a_room_that_stands_out_of_its_roof_tells_from_where_on(mode):
    random, outdoors = np.random.default_rng(1), 0
    for room in found(house_with_dormer(), mode).rooms[:-1]:
        triangles = np.array([(f[0], f[i], f[i + 1]) for f in room.faces for i in range(1, len(f) - 1)])
        points = random.uniform(room.vertices.min(axis=0), room.vertices.max(axis=0), (1000, 3))
        points = points[polyhedra.inside(points, polyhedra.build(room.vertices, triangles))]
        x, y, z = points.T
        sky = (z > slope(x) + 0.2) & ((y < 0.9) | (y > 3.1))
        outdoors += int(sky.sum())
        assert not (sky & (z < room.top)).any()
    assert outdoors > 20
