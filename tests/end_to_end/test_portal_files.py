# SPDX-License-Identifier: GPL-3.0-or-later
"""Real portal graphs: the matrix and the witnesses of the from-region engine, judged by sightlines of independent code."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "build" / "bin" / "enfilade"
SAMPLER = ROOT / "build" / "release" / "bin" / "portal_sampler"
MAPS = Path(os.environ.get("ENFILADE_DATA") or ROOT.parent / "shared" / "data") / "prt"


@pytest.mark.parametrize("name", ["dm1", "dm4", "e1m7"])
@pytest.mark.parametrize("method", ["flow", "exact"])
def test_no_sightline_is_missing_and_every_witness_holds(tmp_path, name, method):
    portals = MAPS / f"{name}.prt"
    if not portals.exists():
        pytest.skip(f"{portals} isn't there")
    matrix, witnesses = tmp_path / "matrix", tmp_path / "witnesses"
    bake = [TOOL, "pvs", portals, "--method", method, "--matrix", matrix, "--witnesses", witnesses]
    subprocess.run(bake, check=True, stdin=subprocess.DEVNULL)
    judge = [SAMPLER, portals, matrix, "--lines", "3000000", "--witnesses", witnesses]
    judged = subprocess.run(judge, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert judged.returncode == 0, judged.stdout
    assert "missing 0; one-way pairs 0;" in judged.stdout


def test_the_judge_notices_a_missing_pair(tmp_path):
    portals = MAPS / "e1m7.prt"
    if not portals.exists():
        pytest.skip(f"{portals} isn't there")
    matrix = tmp_path / "matrix"
    subprocess.run([TOOL, "pvs", portals, "--matrix", matrix], check=True, stdin=subprocess.DEVNULL)
    rows = [line.split() for line in matrix.read_text().splitlines()]
    cell = max(range(len(rows)), key=lambda i: len(rows[i]))
    rows[cell] = [str(cell)]  # as if it saw nothing but itself
    matrix.write_text("".join(" ".join(row) + "\n" for row in rows))
    judged = subprocess.run([SAMPLER, portals, matrix, "--lines", "500000"], capture_output=True, text=True)
    assert judged.returncode == 1
    assert f"MISSING {cell} " in judged.stdout
