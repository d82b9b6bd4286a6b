# SPDX-License-Identifier: GPL-3.0-or-later
"""Marked shapes become rooms and openings: who is joined, where the ends lie, what is reported."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import annotated
from enfilade.rules import building as b
from enfilade.rules.annotated import Shape, role_of
from enfilade.rules.shapes import polygon_area


def box(low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    v = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)], dtype=float)
    f = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return v, f


def shape(name, role, low, high, **more):
    v, f = box(low, high)
    return Shape(name, role, v, f, **more)


def two_rooms():
    return [
        shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)),
        shape("Room_B", "room", (4.2, 0, 0), (8, 4, 2.5)),
    ]


def join(building, i):
    rooms = building.openings[i].rooms
    return None if rooms is None else {building.rooms[r].name for r in rooms}


def codes(building):
    return [p.code for p in building.problems]


def test_names_and_properties_give_roles():
    assert role_of("Room_Hall") == "room"
    assert role_of("Room.001") == "room"
    assert role_of("door/D1") == "door"
    assert role_of("Roomy chair") == ""
    assert role_of("Chair", "hole") == "hole"
    assert role_of("Room_Hall", "ignore") == "ignore"
    assert role_of("Room_Hall", "nonsense") == ""


def test_a_flush_door_joins_the_rooms_on_both_sides():
    out = annotated.build(two_rooms() + [shape("Door_1", "door", (4, 1, 0), (4.2, 2, 2))])
    assert join(out, 0) == {"A", "B"}
    opening = out.openings[0]
    assert opening.state == b.OPEN and opening.body is not None
    assert [polygon_area(e) for e in opening.ends] == pytest.approx([2.0, 2.0])
    first = out.rooms[opening.rooms[0]]
    assert np.allclose(opening.ends[0][:, 0], first.vertices[:, 0].max() if first.name == "A" else 4.2)
    assert not codes(out)


def test_a_void_deeper_than_wide_is_cut_to_the_rooms_faces():
    out = annotated.build(two_rooms() + [shape("Door_1", "door", (3.4, 1, 0), (4.8, 1.9, 2))])
    assert join(out, 0) == {"A", "B"}
    xs = sorted(float(e[:, 0].mean()) for e in out.openings[0].ends)
    assert xs == pytest.approx([4.0, 4.2])


def test_a_short_body_is_lengthened_to_the_rooms():
    out = annotated.build(two_rooms() + [shape("Door_1", "door", (4.05, 1, 0), (4.15, 1.9, 2))])
    xs = sorted(float(e[:, 0].mean()) for e in out.openings[0].ends)
    assert xs == pytest.approx([4.0, 4.2])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("x", [3.9, 3.97, 4.0, 4.1, 4.23, 4.3])
def test_a_plane_beside_its_wall_is_taken_through_it(x, turned):
    corners = np.array([(x, 1, 0), (x, 2, 0), (x, 2, 2), (x, 1, 2)], dtype=float)
    out = annotated.build([*two_rooms(), Shape("Door_1", "door", corners[::-1] if turned else corners, [[0, 1, 2, 3]])])
    assert join(out, 0) == {"A", "B"}
    off = x < 4.0 or x > 4.2
    assert codes(out) == (["opening-beside-wall"] if off else [])
    if off:
        assert sorted(float(e[:, 0].mean()) for e in out.openings[0].ends) == pytest.approx([4.0, 4.2])
        assert out.problems[0].names == ["Door_1"] and out.problems[0].position == pytest.approx((x, 1.5, 1.0))


def test_a_bent_plane_is_taken_flat():
    corners = np.array([(4.05, 1, 0), (4.09, 2, 0), (4.05, 2, 2), (4.09, 1, 2)], dtype=float)
    out = annotated.build([*two_rooms(), Shape("Door_1", "door", corners, [[0, 1, 2], [0, 2, 3]])])
    assert join(out, 0) == {"A", "B"} and codes(out) == ["opening-bent"]
    assert [polygon_area(e) for e in out.openings[0].ends] == pytest.approx([2.0, 2.0], rel=0.02)


def test_a_plane_inside_a_room_stays_a_partition():
    corners = np.array([(3.0, 1, 0), (3.0, 2, 0), (3.0, 2, 2), (3.0, 1, 2)], dtype=float)
    out = annotated.build([*two_rooms(), Shape("Door_1", "door", corners, [[0, 1, 2, 3]])])
    assert join(out, 0) is None and codes(out) == ["opening-same-room"]


def test_what_has_no_shape_is_told_where_it_stands():
    out = annotated.build([*two_rooms(), Shape("Door_1", "door", np.zeros((0, 3)), place=(1.0, 2.0, 3.0))])
    assert out.problems[0].position == (1.0, 2.0, 3.0) and "cube" in out.problems[0].remedy


def test_a_void_that_reaches_through_a_corridor_joins_the_rooms_beside_its_own_wall():
    shapes = [
        shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)),
        shape("Room_Corridor", "room", (4.2, 0, 0), (5.2, 4, 2.5)),
        shape("Room_C", "room", (5.4, 0, 0), (8, 4, 2.5)),
        shape("Door_1", "door", (3.5, 1, 0), (4.7, 1.9, 2)),
    ]
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "Corridor"}


def test_a_window_outdoors_makes_the_exterior():
    out = annotated.build(two_rooms() + [shape("Window_1", "window", (1, -0.3, 1), (2, 0, 2))])
    assert join(out, 0) == {"A", "Exterior"}
    assert out.rooms[-1].kind == b.EXTERIOR and out.rooms[-1].vertices is None
    assert out.openings[0].state == b.GLASS


def test_a_full_height_window_beside_a_stacked_room_still_leads_outdoors():
    shapes = two_rooms() + [
        shape("Room_Above", "room", (0, 0, 2.7), (4, 4, 5)),
        shape("Window_1", "window", (1, -0.3, 0), (2, 0, 2.5)),
    ]
    assert join(annotated.build(shapes), 0) == {"A", "Exterior"}


def test_a_slab_hole_joins_storeys_and_storeys_are_named_from_below():
    shapes = two_rooms() + [
        shape("Room_Above", "room", (0, 0, 2.8), (4, 4, 5)),
        shape("Hole_Stair", "hole", (1, 1, 2.5), (2, 3.5, 2.8)),
    ]
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "Above"}
    assert [s[0] for s in out.storeys] == ["Level 0", "Level 1"]
    assert out.rooms[2].storey == "Level 1"


def test_a_flat_portal_between_touching_rooms():
    shapes = [
        shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)),
        shape("Room_B", "room", (4, 0, 0), (8, 4, 2.5)),
        Shape("Portal_1", "portal", np.array([(4, 1, 0), (4, 3, 0), (4, 3, 2), (4, 1, 2)], float), [[0, 1, 2, 3]]),
    ]
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "B"}
    assert polygon_area(out.openings[0].polygon) == pytest.approx(4.0)


def test_a_thick_opening_between_touching_rooms_becomes_a_plane():
    shapes = [
        shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)),
        shape("Room_B", "room", (4, 0, 0), (8, 4, 2.5)),
        shape("Door_1", "door", (3.9, 1, 0), (4.1, 2, 2)),
    ]
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "B"}
    polygon = out.openings[0].polygon
    assert polygon_area(polygon) == pytest.approx(2.0)
    assert np.allclose(polygon[:, 0], 4.0)


def test_rooms_may_be_inside_out_non_convex_and_open():
    v, f = box((0, 0, 0), (4, 4, 2.5))
    mirrored = Shape("Room_A", "room", v, [x[::-1] for x in f])
    out = annotated.build([mirrored])
    from enfilade.rules.shapes import signed_volume

    assert signed_volume(out.rooms[0].vertices, out.rooms[0].faces) == pytest.approx(40.0)
    out = annotated.build([Shape("Room_A", "room", v, f[:-1])])
    assert "room-not-closed" in codes(out)


def test_openings_that_lead_nowhere_say_so():
    out = annotated.build(two_rooms() + [shape("Door_far", "door", (100, 0, 0), (101, 0.2, 2))])
    assert join(out, 0) is None and "opening-no-room" in codes(out)
    out = annotated.build(two_rooms() + [shape("Door_in", "door", (1, 1, 0), (2, 1.1, 2))])
    assert join(out, 0) is None and "opening-same-room" in codes(out)


def test_enfilade_rooms_fixes_what_is_joined():
    shapes = two_rooms() + [shape("Door_1", "door", (4, 1, 0), (4.2, 2, 2), rooms=["A", "exterior"])]
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "Exterior"}
    out = annotated.build(two_rooms() + [shape("Door_1", "door", (4, 1, 0), (4.2, 2, 2), rooms=["A", "Cellar"])])
    assert "unknown-room" in codes(out)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1])
@pytest.mark.parametrize("shift", [0.0, 5e5])
def test_the_answer_moves_with_the_building(angle, shift):
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    shapes = two_rooms() + [
        shape("Door_1", "door", (3.4, 1, 0), (4.8, 1.9, 2)),
        shape("Window_1", "window", (1, -0.3, 1), (2, 0, 2)),
    ]
    for item in shapes:
        item.vertices = item.vertices @ turn.T + shift
    out = annotated.build(shapes)
    assert join(out, 0) == {"A", "B"} and join(out, 1) == {"A", "Exterior"}
    assert [polygon_area(e) for e in out.openings[0].ends] == pytest.approx([1.8, 1.8], rel=1e-3)
