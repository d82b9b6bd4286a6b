# SPDX-License-Identifier: GPL-3.0-or-later
"""IndoorGML out and in: the same cells and the same graph; a public file read whole."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import indoorgml, polyhedra
from enfilade.rules.building import DOOR, EXTERIOR, VIRTUAL, Building, Opening, Room

DATA = Path(os.environ.get("ENFILADE_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
DRAWN = DATA / "indoorgml" / "FZK-Haus_full.gml"


def _box(low, high) -> np.ndarray:
    return np.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])], float)


def _building() -> Building:
    """A and B with a wall and a door between; B and C touch; a window leads out."""
    building = Building(source="annotated")
    for name, low, high in (("A", (0, 0, 0), (4, 5, 2.5)), ("B", (4.2, 0, 0), (8, 5, 2.5)), ("C", (8, 0, 0), (9, 5, 2.5))):
        points = _box(low, high)
        building.rooms.append(Room(name, vertices=points, faces=indoorgml.hull_faces(points)))
    building.rooms.append(Room("Exterior", EXTERIOR))
    ends = [np.array([[x, 2, 0], [x, 3, 0], [x, 3, 2], [x, 2, 2]], float) for x in (4.0, 4.2)]
    building.openings.append(Opening("Door", DOOR, rooms=(0, 1), ends=tuple(ends), body=np.concatenate(ends)))
    seam = np.array([[8, 0, 0], [8, 5, 0], [8, 5, 2.5], [8, 0, 2.5]], float)
    building.openings.append(Opening("B | C", VIRTUAL, rooms=(1, 2), polygon=seam))
    return building


def test_a_hull_has_closed_outward_faces() -> None:
    points = _box((0, 0, 0), (1, 2, 3))
    faces = indoorgml.hull_faces(points)
    assert sorted(len(f) for f in faces) == [4] * 6
    triangles = np.array([(f[0], f[k], f[k + 1]) for f in faces for k in range(1, 3)])
    assert polyhedra.is_closed(triangles) and polyhedra.signed_volume(points, triangles) == pytest.approx(6.0)


def test_round_trip(tmp_path: Path) -> None:
    path = tmp_path / "house.gml"
    assert indoorgml.write(_building(), path) == (4, 3)
    back = indoorgml.read(path)
    assert [r.name for r in back.rooms] == ["A", "B", "C", "Door", "Exterior"]
    pairs = {tuple(sorted(back.rooms[r].name for r in o.rooms)) for o in back.openings}
    assert pairs == {("A", "Door"), ("B", "Door"), ("B", "C")} and not back.problems
    door = next(o for o in back.openings if {back.rooms[r].name for r in o.rooms} == {"A", "Door"})
    assert np.allclose(door.polygon.min(axis=0), [4, 2, 0]) and np.allclose(door.polygon.max(axis=0), [4, 3, 2])
    volume = {r.name: polyhedra.build(*_mesh(r)).volume for r in back.rooms[:4]}
    assert volume == pytest.approx({"A": 50.0, "B": 47.5, "C": 12.5, "Door": 0.4})


def test_every_portal_comes_back_as_it_was_written(tmp_path: Path) -> None:
    """Two portals between the same rooms, parts of their common face, in coordinates that no short decimal has."""
    building = _building()
    seam = building.openings.pop().polygon
    third = seam + (seam.mean(axis=0) - seam) / 3.0
    building.openings += [Opening(f"B | C {n}", VIRTUAL, rooms=(1, 2), polygon=third + [0, n / 7, 0]) for n in range(2)]
    path = tmp_path / "house.gml"
    assert indoorgml.write(building, path) == (4, 4)
    back = indoorgml.read(path)
    assert len(back.openings) == 4 and not back.problems
    portals = [o.polygon for o in back.openings if {back.rooms[r].name for r in o.rooms} == {"B", "C"}]
    assert [p.tolist() for p in portals] == [o.polygon.tolist() for o in building.openings[-2:]]


def test_a_boundary_that_is_no_portal_gives_way_to_the_shared_face_once(tmp_path: Path) -> None:
    path = tmp_path / "house.gml"
    building = _building()
    building.openings.append(building.openings[-1])
    indoorgml.write(building, path)
    bent = path.read_text().replace('<core:duality xlink:href="#B', '<core:duality xlink:href="#gone')
    assert "#gone" in bent
    path.write_text(bent)
    back = indoorgml.read(path)
    pairs = sorted(tuple(sorted(back.rooms[r].name for r in o.rooms)) for o in back.openings)
    assert pairs == [("A", "Door"), ("B", "C"), ("B", "Door")] and not back.problems


def _mesh(room: Room) -> tuple[np.ndarray, np.ndarray]:
    return room.vertices, np.array([(f[0], f[k], f[k + 1]) for f in room.faces for k in range(1, len(f) - 1)])


def test_bad_files_are_told(tmp_path: Path) -> None:
    with pytest.raises(indoorgml.IndoorGmlError, match="can't be read"):
        indoorgml.read(tmp_path / "absent.gml")
    (tmp_path / "other.gml").write_text("<a/>")
    with pytest.raises(indoorgml.IndoorGmlError, match="no CellSpace"):
        indoorgml.read(tmp_path / "other.gml")


@pytest.mark.skipif(not DRAWN.is_file(), reason=f"no {DRAWN}")
def test_a_public_file_reads_whole() -> None:
    building = indoorgml.read(DRAWN)
    assert len(building.rooms) == 25
    assert len({o.source_id for o in building.openings}) + sum("transition" in p.code for p in building.problems) == 24
    assert sum(p.code == "transition-without-face" for p in building.problems) == 0
