# SPDX-License-Identifier: GPL-3.0-or-later
"""`read_ifc` on public models: rooms, doors joined to two rooms, false portals. Skips where the data isn't there."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import ifc, ifc_library, ifc_placement
from enfilade.rules.building import DOOR, EXTERIOR, INTERIOR, VIRTUAL

DATA = Path(os.environ.get("ENFILADE_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
INDEX = DATA / "INDEX.tsv"

pytestmark = [
    pytest.mark.skipif(not INDEX.is_file(), reason=f"no data folder at {DATA}"),
    pytest.mark.skipif(not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)"),
]


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


@pytest.mark.parametrize("name", ["AC20-FZK-Haus.ifc", "Duplex_A.ifc"])
def test_moved_to_a_national_grid_and_turned_gives_the_same(name: str, tmp_path: Path) -> None:
    """Every placement that hangs in the air is moved by (5e5, 5e6, 100) m and turned by 33 degrees."""
    path = DATA / "ifc" / name
    if not path.is_file():
        pytest.skip(f"{name} isn't in the data folder")
    library = ifc_library.load()
    model = library.open(str(path))
    angle, origin = np.radians(33.0), np.array([5e5, 5e6, 100.0])  # both models are in metres
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    for placement in model.by_type("IfcLocalPlacement"):
        if placement.PlacementRelTo is not None:
            continue
        old = ifc_placement.axis_placement(placement.RelativePlacement)
        at, axes = origin + turn @ old[:3, 3], turn @ old[:3, :3]
        placement.RelativePlacement = model.createIfcAxis2Placement3D(
            model.createIfcCartesianPoint(at.tolist()),
            model.createIfcDirection(axes[:, 2].tolist()),
            model.createIfcDirection(axes[:, 0].tolist()),
        )
    here = ifc.read_ifc(path, objects=False)
    model.write(str(tmp_path / name))
    there = ifc.read_ifc(tmp_path / name, objects=False)
    assert [r.name for r in here.rooms] == [r.name for r in there.rooms]
    for r, q in zip(here.rooms, there.rooms, strict=True):
        if r.vertices is not None:
            assert _apart(r.vertices, (q.vertices - origin) @ turn) < 1e-5
    assert [(o.name, o.kind, o.rooms) for o in here.openings] == [(o.name, o.kind, o.rooms) for o in there.openings]
    for o, p in zip(here.openings, there.openings, strict=True):
        # What is cut out by what is drawn near it may differ by how the library cuts meshes up; all others by a rounding.
        mine = o.body if o.body is not None else o.polygon
        theirs = p.body if p.body is not None else p.polygon
        allowed = 1e-5 if o.kind != VIRTUAL else 0.002
        assert _apart(mine, (theirs - origin) @ turn) < allowed, o.name


def _apart(a: np.ndarray, b: np.ndarray) -> float:
    """The largest distance from a corner of one set to the nearest of the other."""
    d = np.linalg.norm(a[:, None] - b[None], axis=2)
    return float(max(d.min(axis=0).max(), d.min(axis=1).max()))
