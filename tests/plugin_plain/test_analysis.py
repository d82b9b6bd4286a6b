# SPDX-License-Identifier: GPL-3.0-or-later
"""Building to answers through the core: who is seen, why, what must stay for light, which rooms see which."""

from __future__ import annotations

import json

import numpy as np
import pytest
from enfilade import native
from enfilade.analysis import Analyser, Shot, widened
from enfilade.rules import annotated
from enfilade.rules import building as b
from enfilade.rules.annotated import Shape
from enfilade.rules.building_io import from_json, to_json
from enfilade.rules.viewpoints import suggest


def box(low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    v = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)], dtype=float)
    f = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return v, f


def shape(name, role, low, high, **more):
    v, f = box(low, high)
    return Shape(name, role, v, f, **more)


def chain(states=("open", "open"), shift=0.0):
    """Three rooms in a row, A B C; the doors AB and BC are in line; a ball in each; a window from C outdoors."""
    shapes = [
        shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)),
        shape("Room_B", "room", (4.2, 0, 0), (8.2, 4, 2.5)),
        shape("Room_C", "room", (8.4, 0, 0), (12.4, 4, 2.5)),
        shape("Door_AB", "door", (4, 1.5, 0), (4.2, 2.5, 2), state=states[0]),
        shape("Door_BC", "door", (8.2, 1.5, 0), (8.4, 2.5, 2), state=states[1]),
        shape("Window_C", "window", (12.4, 1.5, 1), (12.7, 2.5, 2)),
    ]
    out = annotated.build(shapes)
    for name, x in (("ball A", 2.0), ("ball B", 6.0), ("ball C", 10.0), ("tree", 20.0)):
        centre = np.array([x, 2.0, 1.2])
        out.objects.append(b.Object(name, np.stack([centre - 0.1, centre + 0.1]), source_id=name))
    return out


def looking(eye, forward):
    forward = np.array(forward, float) / np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = right, np.cross(right, forward), -forward, eye
    return b.Camera("eye", m, "PERSP", 1.0, 0.7, clip=(0.01, 1000.0))


def analyser(building):
    return Analyser(native.load(), building)


def names(a, objects):
    return {a.building.objects[int(i)].name for i in objects}


AHEAD = Shot("eye", 1, [looking((0.5, 2, 1.2), (1, 0, 0))])


@pytest.mark.parametrize("method", ["portal", "box", "clip"])
def test_doors_in_line_show_everything_behind_and_the_reason(method):
    with_view = analyser(chain())
    view = with_view.look(AHEAD, method)
    assert names(with_view, view.objects) == {"ball A", "ball B", "ball C", "tree"}
    why = {with_view.building.objects[o].name: [with_view.building.openings[i].name for i in w] for o, w in view.why.items()}
    assert why["ball A"] == [] and why["ball C"] == ["AB", "BC"] and why["tree"] == ["AB", "BC", "C"]
    assert [with_view.building.rooms[r].name for r in view.rooms] == ["A", "B", "C", "Exterior"]
    assert [with_view.building.openings[o].name for o in view.openings] == ["AB", "BC", "C"]


def test_a_window_that_shows_nothing_new_is_looked_through_and_a_recess_is_not():
    """Two windows onto the same outdoors: whatever is there is seen first through one, both are looked through. Of the door beside the
    eye only the recess is seen."""
    shapes = [shape("Room_A", "room", (0, 0, 0), (4, 4, 2.5)), shape("Room_B", "room", (0, 4.2, 0), (4, 8, 2.5)),
              shape("Door_AB", "door", (3, 4, 0), (3.3, 4.2, 2)),
              shape("Window_1", "window", (4, 0.5, 1), (4.3, 1.5, 2)), shape("Window_2", "window", (4, 2.5, 1), (4.3, 3.5, 2))]
    a = analyser(annotated.build(shapes))
    view = a.look(Shot("eye", 1, [looking((0.3, 3.95, 1.2), (1, -0.3, 0))]))
    looked = {a.building.openings[o].name for o in view.openings}
    assert looked == {"1", "2"} and {o for w in view.room_why.values() for o in w} < set(view.openings)


def test_a_closed_door_ends_the_view_and_can_be_opened_without_a_new_scene():
    a = analyser(chain(("open", "closed")))
    assert names(a, a.look(AHEAD).objects) == {"ball A", "ball B"}
    a.set_state(1, "open")
    assert "ball C" in names(a, a.look(AHEAD).objects)
    a.set_state(0, "closed")
    assert names(a, a.look(AHEAD).objects) == {"ball A"}


def test_every_method_keeps_what_the_tighter_one_keeps():
    a = analyser(chain())
    rng = np.random.default_rng(4)
    for _ in range(60):
        eye = rng.uniform((0.1, 0.1, 0.2), (12.2, 3.9, 2.4))
        shot = Shot("eye", 1, [looking(eye, rng.normal(size=3) * (1, 1, 0.3))])
        clip, box_, frustum, region = (a.look(shot, m, why=False) for m in ("clip", "box", "frustum", "pluecker"))
        assert set(clip.objects) <= set(box_.objects) <= set(frustum.objects)
        if len(a.scene.locate(eye)):
            assert set(clip.cells) <= set(region.cells)


@pytest.mark.parametrize("method", ["clip", "pluecker"])
def test_an_eye_in_the_recess_of_a_shut_door_sees_the_room_before_it(method):
    a = analyser(chain(("closed", "open")))
    seen = a.look(Shot("eye", 1, [looking((4.05, 2, 1.2), (-1, 0, 0))]), method, why=False)
    assert "ball A" in names(a, seen.objects)


def test_a_shutter_and_a_thick_lens_see_at_least_what_each_pose_sees():
    a = analyser(chain())
    poses = [looking((0.5, 0.5 + 0.5 * t, 1.2), (1, 0.1 * t, 0)) for t in range(4)]
    single = [set(a.look(Shot("eye", 1, [p])).cells) for p in poses]
    assert set().union(*single) <= set(a.look(Shot("eye", 1, poses)).cells)
    assert single[0] <= set(a.look(Shot("eye", 1, [widened(poses[0], 0.05)], eye_radius=0.2)).cells)


def test_keep_sets_are_ordered_and_light_needs_what_it_passes():
    building = chain(("open", "open"))
    building.lights.append(b.Light("lamp", np.array([10.0, 2.0, 1.5]), "POINT"))
    a = analyser(building)
    back = Shot("eye", 1, [looking((3.5, 2, 1.2), (-1, 0, 0))])  # looks away from everything else
    views = [a.look(back)]
    camera = set(a.keep(views, "camera").objects)
    shadow = set(a.keep(views, "shadow", sky=False).objects)
    zero = set(a.keep(views, "bounces=0", sky=False).objects)
    two = set(a.keep(views, "bounces=2", sky=False).objects)
    assert names(a, camera) == {"ball A"}
    assert {"ball A", "ball B", "ball C"} <= names(a, shadow)  # the lamp in C shines through both doors
    assert camera <= shadow <= zero | shadow and shadow <= two and zero <= two
    dark = analyser(chain(("closed", "open")))
    assert names(dark, dark.keep([dark.look(back)], "bounces=4").objects) == {"ball A"}


def test_the_room_matrix_is_symmetric_proven_and_has_sightlines():
    a = analyser(chain())
    matrix = a.room_matrix("exact")
    rooms = [r.name for r in a.building.rooms]
    assert (matrix.visible == matrix.visible.T).all() and matrix.visible.diagonal().all()
    assert matrix.visible[rooms.index("A"), rooms.index("C")]
    assert (matrix.proven <= matrix.visible).all()
    line = next(s for s in matrix.sightlines if {rooms[i] for i in s.rooms} == {"A", "C"})
    assert [a.building.openings[o].name for o in line.openings] in (["AB", "BC"], ["BC", "AB"])
    closed = analyser(chain(("closed", "open"))).room_matrix("exact")
    assert not closed.visible[rooms.index("A"), rooms.index("C")] and (closed.visible <= matrix.visible).all()


def test_objects_without_bounds_are_always_kept():
    building = chain(("closed", "closed"))
    building.objects.append(b.Object("fog", np.full((2, 3), np.nan), source_id="fog"))
    a = analyser(building)
    assert "fog" in names(a, a.look(AHEAD).objects)
    assert "fog" in names(a, a.objects_in(np.array([0])))
    assert "object-without-bounds" in [p.code for p in a.problems]


def test_a_room_that_the_core_refuses_is_named_and_hides_nothing():
    building = chain()
    building.rooms[1].faces = None
    building.rooms[1].vertices = building.rooms[1].vertices * np.array([1, 1, 0])  # squashed flat
    a = analyser(building)
    said = [p for p in a.problems if p.code == "shape-refused"]
    assert said and said[0].names == ["Room_B"] and said[0].severity == b.ERROR
    # B now counts as outdoors: what is seen through the doors into it stays seen
    assert {"ball A", "ball B", "ball C", "tree"} <= names(a, a.look(AHEAD).objects)
    assert len(a.building.rooms) == 4


def test_an_opening_that_the_core_refuses_stays_open():
    building = chain()
    building.openings[0].body = building.openings[0].body * np.array([0, 1, 1]) + np.array([4, 0, 0])  # no thickness left
    a = analyser(building)
    assert {"ball A", "ball B", "ball C", "tree"} <= names(a, a.look(AHEAD).objects)


def test_a_building_survives_json():
    building = chain()
    again = from_json(to_json(building))
    assert to_json(again) == to_json(building)
    assert np.array_equal(again.openings[0].ends[0], building.openings[0].ends[0])
    dangling = json.loads(to_json(building))
    dangling["openings"][0]["rooms"] = [0, 99]
    for broken in ("", "{}", "[1]", to_json(building)[:-9], json.dumps(dangling)):
        with pytest.raises(ValueError):
            from_json(broken)


def test_suggested_cameras_stand_in_rooms():
    building = chain()
    found = suggest(building, 3)
    assert [name for name, _ in found] and len(found) == 3
    a = analyser(building)
    for _, matrix in found:
        assert len(a.scene.locate(matrix[:3, 3])) >= 1
        assert np.allclose(matrix[:3, :3].T @ matrix[:3, :3], np.eye(3))


@pytest.mark.parametrize("kind", ["POINT", "AREA", "SUN"])
def test_whatever_shades_what_is_seen_is_kept(kind):
    """Lines from points of a lamp to points that the camera sees, free of walls: what they pass must be in the keep set."""
    dice = np.random.default_rng(5)
    building = chain(("open", "open"))
    for i in range(150):
        at = dice.uniform((-3, -3, 0), (20, 7, 3.5))
        building.objects.append(b.Object(f"box {i}", np.stack([at, at + dice.uniform(0.05, 0.5, 3)])))
    form = {"kind": kind, "position": (10.0, 2.0, 2.2), "direction": (-1.0, 0.05, -0.12)}
    if kind == "AREA":
        form["sides"] = ((0.4, 0.0, 0.0), (0.0, 0.3, 0.0))
    if kind == "SUN":
        form["radius"] = 0.01
    building.lights.append(b.Light("lamp", np.array(form["position"]), kind, form))
    a = analyser(building)
    views = [a.look(Shot("eye", 1, [looking((0.6, 2, 1.4), (1, 0.1, -0.1))]))]
    kept = set(a.keep(views, "shadow", sky=False).objects.tolist())
    cells = np.array(views[0].cells)
    first, corners = np.array(a.scene.cell_vertex_first).astype(int), np.array(a.scene.cell_vertices)
    points, lamps = [], []
    for c in cells[[first[c + 1] > first[c] for c in cells]]:
        own = corners[first[c] : first[c + 1]]
        points.append(own.T @ dice.dirichlet(np.ones(len(own)), 400).T)
    points = np.concatenate([p.T for p in points])
    if kind == "SUN":
        lamps = points - 60.0 * np.array(form["direction"]) / np.linalg.norm(form["direction"])
    else:
        spread = np.array(form.get("sides", np.zeros((2, 3))))
        lamps = np.array(form["position"]) + dice.uniform(-1, 1, (len(points), 2)) @ spread
    with a.native.Raycaster(a.scene) as rays:
        hits = rays.shoot(points, lamps - points, max_distance=1.0)
    free = (hits["surface"] == a.native.NONE) & (hits["cell"] != a.native.NONE)
    assert free.sum() > 100
    shading = set()
    for i, o in enumerate(building.objects):
        low, high = o.bounds
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([(low - points) / (lamps - points), (high - points) / (lamps - points)])
        if (free & (np.maximum(t.min(axis=0).max(axis=1), 1e-3) <= np.minimum(t.max(axis=0).min(axis=1), 1.0))).any():
            shading.add(i)
    assert len(shading) > 3 and shading <= kept, sorted(shading - kept)
    assert len(kept) < len(building.objects)
