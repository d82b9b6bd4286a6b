# SPDX-License-Identifier: GPL-3.0-or-later
"""`read_ifc` on public models: rooms, doors joined to two rooms, false portals. Skips where the data isn't there."""

from __future__ import annotations

import csv
import importlib.util
import os
from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import ifc, ifc_library
from enfilade.rules.building import DOOR, EXTERIOR, INTERIOR

DATA = Path(os.environ.get("ENFILADE_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
INDEX = DATA / "INDEX.tsv"

pytestmark = [
    pytest.mark.skipif(not INDEX.is_file(), reason=f"no data folder at {DATA}"),
    pytest.mark.skipif(not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)"),
]

_spec = importlib.util.spec_from_file_location("ifc_table", Path(__file__).resolve().parents[1] / "bench" / "ifc_table.py")
ifc_table = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ifc_table)


def _rows() -> list[dict[str, str]]:
    if not INDEX.is_file():
        return []
    with INDEX.open(encoding="utf-8") as file:
        return [r for r in csv.DictReader(file, delimiter="\t") if r["file"].endswith(".ifc")]


@pytest.mark.parametrize("row", _rows(), ids=lambda r: Path(r["file"]).stem)
def test_rooms_and_doors_match_careful_probing(row: dict[str, str]) -> None:
    building, outcomes = ifc.read_with_outcomes(DATA / row["file"], objects=False)
    interior = [r for r in building.rooms if r.kind == INTERIOR]
    assert len(interior) == int(row["spaces"])
    assert sum(r.kind == EXTERIOR for r in building.rooms) == 1
    joined = {o.source_id for o in outcomes if o.kind == DOOR and o.fate == "joined"}
    assert len(joined) >= int(row["doors_two_spaces"])
    same = {o.source_id for o in outcomes if o.kind == DOOR and o.fate == "same-room"}
    assert len(same) == int(row["doors_same_space"])
    for room in interior:
        assert room.vertices is not None and np.isfinite(room.vertices).all()
        assert room.source_id and room.storey


def test_sinks_are_reported_as_false_portals() -> None:
    path = DATA / "ifc" / "Duplex_A.ifc"
    if not path.is_file():
        pytest.skip("Duplex_A.ifc isn't in the data folder")
    building = ifc.read_ifc(path, objects=False)
    reported = [p for p in building.problems if p.code == "false-portal"]
    assert len(reported) == 10
    assert all(p.names and p.position is not None for p in reported)


@pytest.mark.parametrize("name", ["AC20-FZK-Haus.ifc", "Duplex_A.ifc", "demo2.ifc"])
def test_moved_to_a_national_grid_and_turned_gives_the_same(name: str) -> None:
    """Every placement that hangs in the air is moved by (5e5, 5e6, 100) m and turned by 33 degrees."""
    path = DATA / "ifc" / name
    if not path.is_file():
        pytest.skip(f"{name} isn't in the data folder")
    found = ifc_table.compare_moved(str(path))
    for what in ("rooms", "openings"):
        here, there, different = found[what]
        assert here == there > 0 and different == 0, what
    assert found["farthest"] < 2e-6
