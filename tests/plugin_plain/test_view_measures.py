# SPDX-License-Identifier: GPL-3.0-or-later
"""View measures against rooms whose figures are known by arithmetic, and their maps and tables in the report."""

from __future__ import annotations

import contextlib
import csv
import math

import numpy as np
import pytest
from enfilade import native, reporting, view_measures
from enfilade.analysis import Analyser, Shot
from enfilade.report import view_maps, write_report
from enfilade.report.plan import Model, storey_plans
from enfilade.rules import building as b
from enfilade.rules.assemble import cells_of


def box(x0, y0, z0, x1, y1, z1):
    corners = np.array([(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)], dtype=np.float64)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, faces


def two_rooms(door: str = b.OPEN) -> b.Building:
    """4 x 4 x 3 m and 4 x 4 x 3 m, a door 1 m wide between them, a window 2 m wide in the first."""
    made = b.Building("annotated")
    for name, x in (("West", 0.0), ("East", 4.2)):
        vertices, faces = box(x, 0, 0, x + 4, 4, 3)
        made.rooms.append(b.Room(name, vertices=vertices, faces=faces))
    made.rooms.append(b.Room("Outside", b.EXTERIOR))
    body, _ = box(4.0, 1.5, 0, 4.2, 2.5, 2.1)
    ends = tuple(np.array([(x, 1.5, 0), (x, 2.5, 0), (x, 2.5, 2.1), (x, 1.5, 2.1)]) for x in (4.0, 4.2))
    made.openings.append(b.Opening("Door", b.DOOR, door, rooms=(0, 1), body=body, ends=ends))
    body, _ = box(-0.3, 1.0, 0.9, 0.0, 3.0, 2.1)
    ends = tuple(np.array([(x, 1, 0.9), (x, 3, 0.9), (x, 3, 2.1), (x, 1, 2.1)]) for x in (0.0, -0.3))
    made.openings.append(b.Opening("Window", b.WINDOW, b.GLASS, rooms=(0, 2), body=body, ends=ends))
    return made


@pytest.fixture(scope="module")
def core():
    try:
        return native.load()
    except native.NativeMissing as error:
        pytest.skip(str(error))


def at(core, building, point):
    analyser = Analyser(core, building)
    with view_measures.Surveyor(core, analyser) as rays:
        p = np.array([point], dtype=np.float64)
        cell = np.array([int(analyser.scene.locate(p[0])[0])], np.uint32)
        found = rays.measure(p, cell, 1440, 20000)
        floor = rays.floor_area(p[0], int(cell[0]), point[2])
    states = [analyser.scene.opening(i)[1] for i in range(2)]
    analyser.close()
    return {k: float(v[0]) for k, v in found.items()}, floor, states


def test_a_shut_room_is_seen_whole(core):
    found, floor, states = at(core, two_rooms(b.CLOSED), (6.2, 2.0, 1.2))
    assert found["area"] == pytest.approx(16, rel=1e-3)
    assert floor == pytest.approx(16, rel=0.02)
    assert found["volume"] == pytest.approx(48, rel=0.02)
    assert found["longest_view"] == pytest.approx(math.hypot(2, 2), rel=5e-3)
    assert found["occlusivity"] == 0
    assert found["sight_angle"] == 0 and found["outside"] == 0 and found["two_ways"] == 0
    assert states == ["closed", "glass"]  # as it was


def test_a_window_is_as_wide_as_it_looks(core):
    found, _, states = at(core, two_rooms(), (2.0, 2.0, 1.2))
    # the window through the wall's inner face: 2 m wide, 2 m away; the lines end on its plane
    assert found["sight_angle"] == pytest.approx(2 * math.degrees(math.atan2(1.0, 2.0)), abs=0.5)
    # a rectangle's solid angle from its middle line: (Omega) by the arctangent formula, in four quarters
    omega = sum(math.atan2(x * y, 2.0 * math.sqrt(x * x + y * y + 4.0)) for x in (1, 1) for y in (0.9, 0.3))
    assert found["outside"] == pytest.approx(100 * omega / (4 * math.pi), rel=0.05)
    assert states == ["open", "glass"]


def test_behind_a_door_lies_what_the_wedge_through_it_shows(core):
    found, _, _ = at(core, two_rooms(), (2.0, 2.0, 1.2))
    # through a door of 1 m in a wall of 0.2 m, 2 m away: the jambs at 2 m and at 2.2 m bound the wedge
    slope = 0.5 / 2.2
    beyond = 0.5 * slope * 2 * (6.2**2 - 2.2**2)
    passage = 0.5 * slope * 2 * (2.2**2 - 2.0**2)
    assert found["area"] == pytest.approx(16 + beyond + passage, rel=0.01)
    assert found["occlusivity"] == pytest.approx(2 * math.hypot(4.0, 4.0 * slope), rel=0.03)
    assert found["longest_view"] == pytest.approx(6.2 * math.hypot(1, slope), rel=0.01)


def test_rays_all_around_and_the_plan_cut_exactly_agree(core):
    """The isovist area of the measures and the polygon that camera plans draw: two ways to one thing."""
    from enfilade.report import isovist

    with contextlib.closing(Analyser(core, two_rooms())) as analyser:
        eye, height = np.array([1.5, 1.0]), 1.2
        cell = int(analyser.scene.locate([*eye, height])[0])
        cells = cells_of(analyser.made)
        section = isovist.Section(cells, set(), height, set(np.nonzero(cells.rooms == 2)[0].tolist()),
                                  np.nonzero(cells.openings == 1)[0].tolist())
        exact = isovist.trace(section, eye, [cell], 0.0, math.pi, height).area
        with view_measures.Surveyor(core, analyser) as rays:
            found = rays.measure(np.array([[*eye, height]]), np.array([cell], np.uint32), 1440, 64)["area"][0]
    assert exact > 16.0 and found == pytest.approx(exact, rel=5e-3)


def test_measures_reach_the_report(core, tmp_path):
    building = two_rooms()
    analyser = Analyser(core, building)
    m = np.eye(4)
    m[:3, :3] = [[0, 0, -1], [-1, 0, 0], [0, 1, 0]]
    m[:3, 3] = (2, 2, 1.5)
    view = analyser.look(Shot("Cam", 1, [b.Camera("Cam", m, angle_x=1.0, angle_y=0.7)]))
    measures = view_measures.survey(core, analyser, [view], 0.5)
    assert measures.grid.spacing == 0.5 and 100 < len(measures.grid.points) < 140 and not measures.cut_short
    assert measures.cameras[0]["camera"] == "Cam" and measures.cameras[0]["room"] == 0
    assert view_maps.building_shares(measures)["sees_out"] > 60
    analysis = analyser.analysis([view], None, "two rooms")
    analysis.measures = measures
    names = {p.name for p in write_report(analysis, tmp_path)}
    assert {"view_points.csv", "view_measures.csv", "view_cameras.csv"} <= names
    assert any(n.startswith("view_sight_angle_") and n.endswith(".svg") for n in names)
    with open(tmp_path / "view_measures.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [r["room"] for r in rows] == ["West", "East"] and float(rows[0]["area_m2"]) > 16
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Isovist area" in page and "EN 17037" in page
    analyser.close()


def test_a_cancelled_survey_keeps_what_it_has(core):
    analyser = Analyser(core, two_rooms())
    measures = view_measures.survey(core, analyser, [], 0.1, lambda *_: False)
    assert measures.cut_short and len(measures.grid.points) == 256
    assert analyser.scene.opening(1)[1] == "glass"
    analyser.close()


@pytest.mark.parametrize("patience", [0.1, 0.4, 0.7])
def test_a_stopped_report_says_so_and_leaves_no_page(core, tmp_path, patience):
    made = reporting.make(core, two_rooms(), [], tmp_path, reporting.Wanted(), lambda fraction, _: fraction < patience)
    assert made.stopped and not (tmp_path / "report.html").exists() and not list(tmp_path.glob("*.part*"))


def test_classes_are_round_and_cover_everything(core):
    analyser = Analyser(core, two_rooms())
    measures = view_measures.survey(core, analyser, [], 0.5)
    model = Model(analyser.analysis([], None))
    for measure in measures.definitions:
        bounds, colours, words = view_maps.classes(measures, measure.key)
        assert len(bounds) == len(colours) == len(words) <= 8 and bounds[-1] == math.inf and sorted(bounds) == bounds
        assert view_maps.plan_map(model, storey_plans(model)[0], measures, measure.key) is not None
    assert view_maps.nice_step(7, 7) == 1 and view_maps.nice_step(30, 7) == 5
    analyser.close()
