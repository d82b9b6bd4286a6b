# SPDX-License-Identifier: GPL-3.0-or-later
"""enfilade pvs as people run it on something large: shares, a kill midway, door states, objects; all by files."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
from pathlib import Path

import pytest

TOOL = Path(__file__).resolve().parents[2] / "build" / "bin" / "enfilade"


def pvs(*arguments: object, code: int = 0) -> dict:
    done = subprocess.run([TOOL, "pvs", *map(str, arguments), "--quiet", "--json", "-"], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout) if code == 0 else {"said": done.stderr}


@pytest.fixture(scope="module")
def office(tmp_path_factory):
    path = tmp_path_factory.mktemp("office") / "office.enf.json"
    subprocess.run([TOOL, "generate", "office:200,windows=0,objects=2", path], check=True)
    return path


def test_shares_merge_to_the_bytes_of_one_bake(office, tmp_path):
    whole = ["--block", 32, "--matrix", tmp_path / "whole", "--witnesses", tmp_path / "whole.lines"]
    pvs(office, *whole)
    parts = [tmp_path / f"{k}.state" for k in (1, 2, 3)]
    for k, part in enumerate(parts, 1):
        assert pvs(office, "--block", 32, "--shard", f"{k}/3", "--state", part, "--threads", k)["partial"] == 1
    merged = ",".join(map(str, parts))
    pvs(office, "--merge", merged, "--matrix", tmp_path / "merged", "--witnesses", tmp_path / "merged.lines")
    for end in ("", ".lines"):
        assert (tmp_path / f"merged{end}").read_bytes() == (tmp_path / f"whole{end}").read_bytes()
    assert "missing" in pvs(office, "--merge", f"{parts[0]},{parts[1]}", code=3)["said"]
    assert "--state" in pvs(office, "--shard", "1/2", code=1)["said"]


def test_a_killed_bake_goes_on(office, tmp_path):
    state = tmp_path / "state"
    command = [str(TOOL), "pvs", str(office), "--quiet", "--threads", "1", "--block", "8", "--state", str(state)]

    def first_bytes_only() -> None:  # at the next one the system kills it: always at the same place, midway through a record
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    bake = subprocess.run(command, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL, preexec_fn=first_bytes_only)
    assert bake.returncode == -signal.SIGXFSZ and state.stat().st_size == 20000
    resumed = pvs(office, "--block", 8, "--state", state, "--matrix", tmp_path / "resumed", "--witnesses", tmp_path / "resumed.lines")
    assert 0 < resumed["blocks_loaded"] < resumed["blocks"]
    pvs(office, "--block", 8, "--matrix", tmp_path / "whole", "--witnesses", tmp_path / "whole.lines")
    for end in ("", ".lines"):
        assert (tmp_path / f"resumed{end}").read_bytes() == (tmp_path / f"whole{end}").read_bytes()


def test_other_door_states_ask_little_again(office, tmp_path):
    state, varied = tmp_path / "open.state", tmp_path / "shut.state"
    pvs(office, "--state", state)
    (tmp_path / "doors").write_text("# two doors\nclosed D5\nclosed D7\n")
    shut = ["--states", tmp_path / "doors"]
    variant = pvs(office, *shut, "--variant-of", state, "--state", varied, "--matrix", tmp_path / "variant")
    pvs(office, *shut, "--matrix", tmp_path / "fresh")
    assert (tmp_path / "variant").read_bytes() == (tmp_path / "fresh").read_bytes()
    assert variant["pairs_kept"] > 50 * variant["pairs_reopened"] > 0
    again = pvs(office, "--close", "D5", "--variant-of", varied, "--matrix", tmp_path / "again")  # D7 is open again
    pvs(office, "--close", "D5", "--matrix", tmp_path / "fresh")
    assert (tmp_path / "again").read_bytes() == (tmp_path / "fresh").read_bytes() and again["pairs_kept"] > 0
    assert "no opening" in pvs(office, "--close", "Nowhere", code=2)["said"]


def test_objects_are_listed_with_what_shows_them(office, tmp_path):
    pvs(office, "--from", "0,7", "--objects", tmp_path / "objects")
    rows = [line.split() for line in (tmp_path / "objects").read_text().splitlines()]
    assert {row[0] for row in rows} == {"0", "7"} and {row[2] for row in rows} == {"visible"}
    assert all(len(row) == 10 for row in rows)
    assert "no object" in pvs(office, "--objects", tmp_path / "objects", "--object", "Piano", code=2)["said"]
