# SPDX-License-Identifier: GPL-3.0-or-later
"""FZK-Haus against the IndoorGML that others drew of it: 24 cells, 24 transitions, the same graph.

Cells are matched by where they lie: each drawn cell's centre falls into one of our rooms or openings, one to one; then the
edges must be the same set. In the drawing an opening is a cell, and a transition joins two cells that share a face.
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import ifc, ifc_library
from enfilade.rules.building import EXTERIOR

DATA = Path(os.environ.get("ENFILADE_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
MODEL, DRAWN = DATA / "ifc" / "AC20-FZK-Haus.ifc", DATA / "indoorgml" / "FZK-Haus_full.gml"

pytestmark = [
    pytest.mark.skipif(not (MODEL.is_file() and DRAWN.is_file()), reason=f"no FZK-Haus in {DATA}"),
    pytest.mark.skipif(not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)"),
]


def _drawn() -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], set[frozenset[str]]]:
    """Bounds (low, high) of each cell, and the transitions as pairs of cells; read with nothing of ours."""
    cells, edges = {}, set()
    for element in ElementTree.parse(DRAWN).getroot().iter():
        tag = element.tag.split("}")[1]
        if tag == "CellSpace":
            name = next(v for k, v in element.attrib.items() if k.endswith("id"))
            numbers = " ".join(e.text for e in element.iter() if e.tag.endswith("}posList"))
            points = np.array([float(x) for x in numbers.split()]).reshape(-1, 3)
            cells[name] = (points.min(axis=0), points.max(axis=0))
        elif tag == "Transition":
            ends = [
                v.lstrip("#")
                for e in element.iter()
                if e.tag.endswith("}connects")
                for k, v in e.attrib.items()
                if k.endswith("href")
            ]
            edges.add(frozenset(ends))
    return cells, edges


def test_same_cells_and_transitions() -> None:
    drawn, transitions = _drawn()
    assert (len(drawn), len(transitions)) == (24, 24)
    building = ifc.read_ifc(MODEL, objects=False)
    ours: dict[str, np.ndarray] = {}
    edges = set()
    for i, room in enumerate(building.rooms):
        if room.kind != EXTERIOR:
            ours[f"room {i}"] = room.vertices
    for n, opening in enumerate(building.openings):
        inside = [r for r in opening.rooms if building.rooms[r].kind != EXTERIOR]
        if opening.body is not None:
            ours[f"opening {n}"] = opening.body
            edges |= {frozenset((f"opening {n}", f"room {r}")) for r in inside}
        else:
            edges.add(frozenset(f"room {r}" for r in inside))
    assert (len(ours), len(edges)) == (24, 24)
    match: dict[str, str] = {}
    for name, (low, high) in drawn.items():
        # The cell of ours whose bounds are nearest: rooms exactly, openings to the depth of their voids.
        distance = {
            k: np.abs(np.concatenate([v.min(axis=0) - low, v.max(axis=0) - high])).max() for k, v in ours.items()
        }
        match[name] = min(distance, key=distance.__getitem__)
        assert distance[match[name]] < 0.35, (name, match[name], distance[match[name]])
    assert len(set(match.values())) == 24
    assert {frozenset(match[c] for c in edge) for edge in transitions} == edges
