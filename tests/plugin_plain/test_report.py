# SPDX-License-Identifier: GPL-3.0-or-later
"""The report as a whole: files, structure, hostile names, large buildings, empty cases."""

from __future__ import annotations

import csv
import json
import math
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from urllib.parse import unquote

import numpy as np
import pytest
import report_samples as samples
from enfilade.report import drawing, file_name, plan, plan_drawing, write_report
from enfilade.rules import building as b
from enfilade.rules.results import RoomMatrix

TABLES = ["rooms.csv", "openings.csv", "views.csv", "view_rooms.csv", "view_objects.csv", "matrix.csv", "pairs.csv", "sightlines.csv", "problems.csv"]
VOID = {"meta", "img", "br", "hr", "input", "link"}
# 1,755 rooms with their plans, tables and matrix: the page must stay something a browser opens at once.
MOST_PAGE_BYTES = 12_000_000


class Reader(HTMLParser):
    """Collects tags, attributes and text, and notes tags that don't close."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.tags, self.attributes, self.words = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, k, v) for k, v in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, k, v) for k, v in attrs]

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        self.words.append(data)


def read_page(path) -> tuple[str, Reader]:
    text = path.read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert reader.wrong == [] and reader.open == []
    return text, reader


def rows_of(path) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def house_report(tmp_path_factory):
    out = tmp_path_factory.mktemp("house")
    return out, write_report(samples.house(walk=5), out)


def test_every_file_returned_exists_and_the_page_comes_first(house_report):
    out, paths = house_report
    assert paths[0] == out / "report.html"
    assert all(p.is_file() and p.stat().st_size > 0 for p in paths)
    assert {p.name for p in out.iterdir()} == {p.name for p in paths}, "nothing half-written left behind"
    assert {*TABLES, "report.json", "preview.png", "matrix.png", "matrix.svg", "sightlines_Ground-floor.svg",
            "rooms_seen_Upper-floor.png"} <= {p.name for p in paths}
    assert {"plan_Ground-floor.png", "plan_Ground-floor_Cam-living.svg", "plan_Upper-floor_Cam-bed.png", "plan_Upper-floor.dxf"} \
        <= {p.name for p in paths}


def test_the_page_holds_pictures_first_then_tables(house_report):
    text, reader = read_page(house_report[1][0])
    order = [text.index(f'id="{name}"') for name in ("plans", "cameras", "matrix", "rooms", "openings", "privacy", "sightlines",
                                                     "problems", "definitions", "files", "statistics")]
    assert order == sorted(order)
    assert reader.tags.count("svg") >= 2 + 5 + 1
    words = " ".join(reader.words)
    for name in ("Living", "Bedroom", "Cam hall", "W9", "Exact", "grazing", "mark the opening as leading outdoors"):
        assert name in words


def test_the_page_asks_nothing_of_the_network(house_report):
    _, reader = read_page(house_report[1][0])
    loaded = [v for _, k, v in reader.attributes if k in ("src", "action", "srcset", "data", "poster")]
    assert all(v.startswith("data:") for v in loaded)
    links = [v for _, k, v in reader.attributes if k == "href"]
    assert links and all(v.startswith("#") or (house_report[0] / unquote(v)).is_file() for v in links)
    assert any(k == "content" and "default-src 'none'" in v for _, k, v in reader.attributes)


def test_csv_files_parse_back(house_report):
    out = house_report[0]
    rooms = rows_of(out / "rooms.csv")
    assert [r["name"] for r in rooms][:3] == ["Living", "Kitchen", "Hall"]
    living = rooms[0]
    assert float(living["area_m2"]) == pytest.approx(5 * 4 + 3 * 3)  # the L: both pieces, nothing twice
    assert float(living["volume_m3"]) == pytest.approx(29 * 2.6, rel=1e-6)
    assert living["seen_by"] == "Cam living; Cam hall; Walk" and living["sees_outdoors"] == "yes"
    openings = rows_of(out / "openings.csv")
    assert (openings[0]["width_m"], openings[0]["height_m"], openings[0]["depth_m"]) == ("0.9", "2.1", "0.2")
    through = {(r["camera"], r["room"]): r["through"] for r in rows_of(out / "view_rooms.csv")}
    assert through["Cam living", "Study"] == "D1 > D3" and through["Cam hall", "Landing"] == "Stair"
    assert {r["object"] for r in rows_of(out / "view_objects.csv") if r["camera"] == "Cam bed"} == {"Chair.006"}
    status = {(r["room_a"], r["room_b"]): r["status"] for r in rows_of(out / "pairs.csv")}
    assert status["Living", "Hall"] == "visible" and status["Living", "Landing"] == "grazing"
    assert status["Hall", "Outdoors"] == "not proven" and ("Living", "WC") not in status
    with open(out / "matrix.csv", encoding="utf-8", newline="") as file:
        table = list(csv.reader(file))
    assert table[0][1:] == [r["name"] for r in rooms] and len(table) == 10
    assert table[1][3] == "1" and table[1][6] == "2" and table[1][5] == "0"


def test_json_has_a_version_and_plain_numbers(house_report):
    data = json.loads((house_report[0] / "report.json").read_text(encoding="utf-8"))
    assert (data["format"], data["version"]) == ("enfilade-report", 1)
    assert len(data["rooms"]) == 9 and data["matrix"]["method"] == "exact"
    assert [0, 2] in data["matrix"]["pairs"]["visible"] and data["matrix"]["pairs"]["grazing"] == [[0, 5]]
    assert all(d["text"] and d["unit"] is not None for d in data["definitions"].values())


def test_svg_files_are_well_formed_and_show_every_room(house_report):
    drawn = [p for p in house_report[1] if p.suffix == ".svg"]
    assert drawn
    for path in drawn:
        root = ET.parse(path).getroot()
        assert root.tag.endswith("svg")
    text = (house_report[0] / "plan_Ground-floor.svg").read_text(encoding="utf-8")
    for name in ("Living", "Kitchen", "Hall", "Study", "WC"):
        assert f">{name}</text>" in text


def test_the_same_analysis_gives_the_same_bytes(tmp_path):
    first = {p.name: p.read_bytes() for p in write_report(samples.house(), tmp_path / "a") if p.suffix != ".png"}
    second = {p.name: p.read_bytes() for p in write_report(samples.house(), tmp_path / "b") if p.suffix != ".png"}
    assert first == second


HOSTILE = ["<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "it's \"quoted\" & sold", "line\nbreak\ttab\x00\x07\x1b",
           "Küche – 台所 – кухня – غرفة", "x" * 500, "=1+1", "]]><!--", "\ud800 lone \ufffe"]


def test_hostile_names_stay_text(tmp_path):
    analysis = samples.house()
    for i, name in enumerate(HOSTILE):
        analysis.building.rooms[i % 9].name = name
        analysis.building.openings[i].name = name
        analysis.building.objects[i].name = name
    for i, view in enumerate(analysis.views):
        view.camera.name = HOSTILE[i]
    analysis.building.rooms[2].storey = analysis.building.rooms[0].storey = "../<b>up</b>"
    analysis.building.problems.append(b.Problem(b.ERROR, "x", HOSTILE[0], [HOSTILE[1]], None, HOSTILE[2]))
    analysis.title = HOSTILE[0]
    analysis.statistics[HOSTILE[1]] = HOSTILE[0]
    paths = write_report(analysis, tmp_path)
    text, reader = read_page(paths[0])
    assert reader.tags.count("script") == 1 and "onerror" not in [k for _, k, _ in reader.attributes]
    assert not any(t in reader.tags for t in ("img", "b0", "iframe"))
    assert "x" * 200 not in text
    for path in paths:
        assert path.parent == tmp_path
        if path.suffix == ".svg":
            ET.parse(path)
    assert rows_of(tmp_path / "rooms.csv")[0]["name"] == HOSTILE[0]
    assert rows_of(tmp_path / "rooms.csv")[6]["name"] == "'=1+1"
    json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))


def test_file_names_suit_every_file_system_and_never_collide():
    used: set[str] = set()
    names = [file_name(n, used) for n in ["Level 1", "level 1", "Level/1", "../../etc", "", "台所", "CON:", "x" * 500]]
    assert len({n.lower() for n in names}) == len(names)
    assert all(n and set(n) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-.") for n in names)


def test_a_building_of_1755_rooms_stays_readable(tmp_path):
    analysis = samples.office(13, 67, cameras=1)
    assert len(analysis.building.rooms) == 1755
    seen = []
    paths = write_report(analysis, tmp_path, lambda fraction, text: seen.append(fraction))
    assert paths[0].stat().st_size < MOST_PAGE_BYTES
    text, reader = read_page(paths[0])
    assert reader.tags.count("img") == 1 and "data:image/png;base64" in text
    assert "sightlines.csv" in text
    assert seen == sorted(seen) and seen[-1] == 1.0
    assert len(rows_of(tmp_path / "rooms.csv")) == 1755


def test_tables_and_plans_tell_the_same_openings_as_looked_through(tmp_path):
    analysis = samples.house()
    names = [o.name for o in analysis.building.openings]
    view = analysis.views[0]
    view.openings = sorted({*view.openings, names.index("W1")})  # nothing is seen first through it
    model = plan.Model(analysis)
    storey = plan.storey_plans(model)[0]
    marked = {tuple(i.points.mean(axis=0)) for i in plan_drawing.camera_plan(model, storey, 0).items
              if isinstance(i, drawing.Line) and (i.stroke, i.width) == (drawing.CAMERA, plan_drawing.HEAVY)}
    write_report(analysis, tmp_path)
    table = {r["name"] for r in rows_of(tmp_path / "openings.csv") if "Cam living" in r["looked_through_by"]}
    assert table == {"D1", "D3", "W1", "W3"} == {names[o] for o in model.cameras[0].openings} and len(marked) == 4 + 1  # and the legend


def test_sheets_that_stand_two_in_a_row_have_letters_as_large_as_those_alone(tmp_path):
    """A storey of 41 rooms, 64 m long: each is named on its sheet, in letters of at least seven pixels where two sheets share a row of 1,240."""
    model = plan.Model(samples.office(4, 20, cameras=0))
    storey = plan.storey_plans(model)[0]
    page = plan_drawing.overview(model, storey, plan_drawing.sheet_width(4))
    pixels = 560 / page.width
    texts = [i for i in page.items if isinstance(i, drawing.Text)]
    assert min(i.size for i in texts) * pixels >= 7.0
    shown = {i.text for i in texts}
    assert {r.name for i, r in enumerate(model.building.rooms) if model.room_storey[i] == 0 and "." in r.name} <= {t.split()[0] for t in shown}
    assert plan_drawing.sheet_width(3) == plan_drawing.WIDE > page.width


def test_plans_that_the_page_has_no_room_for_are_named(tmp_path, monkeypatch):
    monkeypatch.setattr("enfilade.report.MOST_PAGE_SVG", 1)
    text, reader = read_page(write_report(samples.house(), tmp_path)[0])
    assert "plan_Ground-floor.svg" in text.split("</section>")[0] and reader.tags.count("figure") == 1  # the matrix


def test_problems_alike_are_one_row(tmp_path):
    analysis = samples.house()
    analysis.building.problems = [b.Problem(b.WARNING, "room-open", f"room {n} is open", [f"R{n}"], (n, 0.0, 0.0), "draw it") for n in range(9)]
    text, _ = read_page(write_report(analysis, tmp_path)[0])
    section = text.split('id="problems"')[1].split("</section>")[0]
    assert section.count("<tr>") == 2 and "Room 0 is open" in section and "and 8 more alike" in section and "Room 8 is open" in section
    assert [r["names"] for r in rows_of(tmp_path / "problems.csv")] == [f"R{n}" for n in range(9)]


def test_nothing_at_all_is_a_report_too(tmp_path):
    paths = write_report(samples.empty(), tmp_path)
    text, _ = read_page(paths[0])
    assert "No rooms were found" in text and "holds no cameras" in text
    assert rows_of(tmp_path / "rooms.csv") == []


def test_no_cameras_no_matrix_no_storeys(tmp_path):
    analysis = samples.house()
    analysis.views, analysis.matrix, analysis.building.storeys = [], None, []
    for room in analysis.building.rooms:
        room.storey = ""
    paths = write_report(analysis, tmp_path)
    text, _ = read_page(paths[0])
    assert "matrix was not computed" in text
    assert len([p for p in paths if p.suffix == ".svg"]) == 2, "storeys found from floor heights"
    outdoors = {r["name"]: r["sees_outdoors"] for r in rows_of(tmp_path / "rooms.csv")}
    assert outdoors["Kitchen"] == "yes" and outdoors["WC"] == "no"


def test_broken_numbers_do_not_break_the_report(tmp_path):
    analysis = samples.house()
    analysis.views[0].camera.matrix_world[:] = np.nan
    analysis.views[1].microseconds = math.nan
    analysis.cells.hulls[3][0, 0] = np.inf
    analysis.building.openings[0].ends = (analysis.building.openings[0].ends[0] * np.nan,) * 2
    analysis.building.openings[1].rooms = None
    analysis.building.openings[2].rooms = (99, 0)
    analysis.building.problems[0].position = (math.nan, 0.0, math.inf)
    analysis.statistics["odd"] = math.inf
    analysis.building.rooms[0].storey = ""
    analysis.views[2].why[6] = [999]
    paths = write_report(analysis, tmp_path)
    json.loads((tmp_path / "report.json").read_text(encoding="utf-8"), parse_constant=lambda x: pytest.fail(x))
    for path in paths:
        if path.suffix == ".svg":
            assert "nan" not in path.read_text(encoding="utf-8").lower()
            ET.parse(path)


def test_a_matrix_of_another_shape_is_left_out(tmp_path):
    analysis = samples.house()
    analysis.matrix = RoomMatrix("sample", np.eye(3, dtype=bool), np.eye(3, dtype=bool))
    text, _ = read_page(write_report(analysis, tmp_path)[0])
    assert "matrix was not computed" in text


def test_stopping_keeps_whole_files_only(tmp_path):
    write_report(samples.house(), tmp_path, lambda fraction, text: fraction < 0.3)
    assert (tmp_path / "rooms.csv").is_file() and not (tmp_path / "report.html").exists()
    assert not [p for p in tmp_path.iterdir() if ".part" in p.name]
