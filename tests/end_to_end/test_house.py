# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample house from .blend to culled view, verified render and report, by the commands a user types."""

from __future__ import annotations

import csv
import json
import subprocess

import pytest
from conftest import ROOT, batch, run_blender

ROOMS = {"Living", "Hall", "Kitchen", "Study", "Gallery", "Bedroom west", "Bedroom east", "Bath"}


def test_detect_finds_every_room_and_joins_every_opening(house):
    assert house.answer["openings"] == house.answer["openings_joined"] == 29
    assert house.answer["problems"] == []
    scene = house.json
    names = {room["name"].removeprefix("Room ") for room in scene["rooms"] if room["kind"] == "interior"}
    assert names == ROOMS
    assert sum(room["kind"] == "exterior" for room in scene["rooms"]) == 1
    assert {camera["name"] for camera in scene["cameras"]} == {
        "Camera Living", "Camera Gallery", "Camera Garden", "Camera Walk"}


def test_the_committed_file_is_what_its_code_makes(house, tmp_path):
    made = tmp_path / "house.blend"
    done = run_blender("--python-exit-code", "3", "-P", ROOT / "sample_blends" / "make_samples.py", "--", "house", "--out", made)
    assert done.code == 0, done.out + done.err
    batch(made, "detect", "--scene-json", tmp_path / "made.enf.json")
    again, committed = json.loads((tmp_path / "made.enf.json").read_text()), house.json
    for key in ("rooms", "cells", "portals", "openings", "objects", "lights", "cameras"):
        assert again[key] == committed[key], f"{key}: make sample_blends/house.blend anew"


@pytest.mark.parametrize(("storeys", "rooms"), [(1, 8), (2, 20), (3, 33)])
def test_an_office_has_exactly_the_rooms_asked_for(storeys, rooms, tmp_path):
    made = tmp_path / "office.blend"
    done = run_blender("--python-exit-code", "3", "-P", ROOT / "sample_blends" / "make_samples.py", "--", "office",
                       "--storeys", storeys, "--rooms-per-storey", rooms, "--seed", 7, "--out", made)
    assert done.code == 0, done.out + done.err
    answer = batch(made, "detect").answer
    assert answer["rooms"] == storeys * rooms + 1
    assert answer["openings"] == answer["openings_joined"] and answer["problems"] == []


def test_rooms_with_corners_are_cut_into_convex_cells(house):
    scene = house.json
    cells = {room["name"].removeprefix("Room "): 0 for room in scene["rooms"]}
    for cell in scene["cells"]:
        if cell.get("room") is not None:
            cells[scene["rooms"][cell["room"]]["name"].removeprefix("Room ")] += 1
    assert cells["Living"] == 2 and cells["Gallery"] == 2, cells
    assert all(cells[name] == 1 for name in ROOMS - {"Living", "Gallery"}), cells


def test_the_tool_reads_what_blender_wrote(house):
    done = subprocess.run([str(ROOT / "build" / "bin" / "enfilade"), "info", str(house.scene), "--json"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    counts = json.loads(done.stdout)
    assert (counts["rooms"], counts["openings"]) == (9, 29)
    assert counts["cells"] == house.answer["cells"] and counts["portals"] == house.answer["portals"]


def test_a_camera_in_the_living_room_needs_neither_study_nor_upper_floor(house, tmp_path):
    answer = batch(house.blend, "cull", "--camera", "Camera Living", "--save", tmp_path / "culled.blend").answer
    (view,) = answer["views"]
    seen = {name.removeprefix("Room ") for name in view["rooms"]}
    assert "Living" in seen and not seen & {"Study", "Bath", "Gallery", "Bedroom west", "Bedroom east"}, seen
    assert answer["hidden"] > answer["objects"] / 2
    assert (tmp_path / "culled.blend").stat().st_size > 0


def test_the_culled_render_is_the_whole_one_pixel_for_pixel(house, tmp_path):
    for camera in ("Camera Living", "Camera Gallery", "Camera Garden"):
        answer = batch(house.blend, "render", "--camera", camera, "--out", tmp_path / camera, "--verify", "--samples", 1,
                       "--resolution", "96x54").answer
        assert answer["equal"] is True and answer["index_wrong"] == answer["depth_wrong"] == 0, answer
        assert list((tmp_path / camera).glob("*_compared.png"))


def test_the_report_opens_from_disk_alone(house, tmp_path):
    batch(house.blend, "report", "--out", tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name in ROOMS)
    for outside in ('src="http', "src='http", 'href="http', "@import", "url(http"):
        assert outside not in page, f"the report reaches out: {outside}"
    problems = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["problems"]
    tables = list(tmp_path.glob("**/*.csv"))
    assert tables
    for table in tables:
        with table.open(newline="", encoding="utf-8-sig") as file:
            rows = len(list(csv.reader(file))) - 1
            assert rows == len(problems) if table.name == "problems.csv" else rows > 0, table
    assert list(tmp_path.glob("**/*.png")) and list(tmp_path.glob("**/*.svg"))


def test_a_file_that_is_no_building_is_refused_with_a_reason(tmp_path):
    empty = tmp_path / "empty.blend"
    made = run_blender("--python-exit-code", "3", "--python-expr",
                       "import bpy; [bpy.data.objects.remove(o) for o in list(bpy.data.objects)]; "
                       f"bpy.ops.wm.save_as_mainfile(filepath={str(empty)!r})")
    assert made.code == 0
    done = run_blender(empty, "--python-exit-code", "3", "-P", ROOT / "plugin" / "batch.py", "--", "detect",
                       "--source", "annotated")
    assert done.code == 2, done.out + done.err
    assert "room" in (done.out + done.err).lower()
