# SPDX-License-Identifier: GPL-3.0-or-later
"""`enfilade view` and `enfilade bench view` from the command line."""

import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "build" / "bin" / "enfilade"


def run(*arguments, expect=0):
    done = subprocess.run([TOOL, *map(str, arguments)], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.returncode == expect, done.stderr
    return done


def test_occluders_hide_what_stands_behind_houses(tmp_path):
    town = tmp_path / "town.enf.json"
    run("generate", "city:6", town)
    assert '"occluder": "bounds"' in town.read_text()
    eye = ("--eye", "-6,-6,1.7", "--look", "100,-6,1.7", "--fov", "90", "--json", "-")
    off, on, auto = (json.loads(run("view", town, *eye, "--occluders", use).stdout) for use in ("off", "on", "auto"))
    assert set(on["objects"]) < set(off["objects"]) and len(on["objects"]) < 0.6 * len(off["objects"])
    assert auto["objects"] == on["objects"]
    assert on["counters"]["occluder_polygons"] > 0 == off["counters"]["occluder_polygons"]
    assert "can't be" in run("view", town, *eye, "--occluders", "maybe", expect=1).stderr


def test_the_sweep_keeps_what_is_seen_exactly_and_the_exact_way_less(tmp_path):
    town = tmp_path / "town.enf.json"
    run("generate", "town:6", town)
    eye = ("--eye", "-40,-30,15", "--look", "40,30,0", "--fov", "60", "--json", "-")
    ways = {way: json.loads(run("view", town, *eye, "--outdoors", way).stdout) for way in ("exact", "sweep", "auto")}
    assert set(ways["exact"]["objects"]) < set(ways["sweep"]["objects"])
    assert ways["auto"]["cells"] == ways["sweep"]["cells"]
    assert ways["sweep"]["counters"]["swept"] == 1 and ways["sweep"]["counters"]["windows"] > 10
    assert ways["exact"]["counters"]["swept"] == 0
    near = ("--eye", "-2,-2,1.6", "--look", "40,30,0", "--fov", "60", "--json", "-")  # before the first houses: exactly
    assert json.loads(run("view", town, *near).stdout)["counters"]["swept"] == 0
    assert "can't be" in run("view", town, *eye, "--outdoors", "maybe", expect=1).stderr


def test_the_benchmark_counts_what_is_missed():
    out = run("bench", "view", "city:3", "office:46,windows=0", "--queries", "20", "--truths", "10").stdout
    rows = [line for line in out.splitlines() if " clip " in line]
    assert len(rows) == 2 and all(row.split()[13] == "0" for row in rows), out
    assert out.count("missed 0 of") == 3 and "stereo:" in out and "walk:" in out
