# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene files read back as rooms and openings; damaged ones are told by name."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from enfilade.rules import scene_file
from enfilade.rules.building import EXTERIOR
from enfilade.rules.shapes import signed_volume

SCENES = Path(__file__).resolve().parents[1] / "scenes"


def test_a_thick_opening_is_one_opening_with_a_body() -> None:
    building = scene_file.read(SCENES / "thick_opening.enf.json")
    assert len(building.openings) == 1
    opening = building.openings[0]
    assert opening.body is not None and len(opening.ends) == 2 and len(set(opening.rooms)) == 2


def test_rooms_drawn_as_a_prism_keep_their_shape() -> None:
    building = scene_file.read(SCENES / "l_room_with_a_seam.enf.json")
    room = building.rooms[0]
    assert len(building.rooms) == 1 and len(room.vertices) == 12 and signed_volume(room.vertices, room.faces) == pytest.approx(18 * 2.5)


def test_cells_of_one_room_are_numbered_and_joined_by_their_seam() -> None:
    building = scene_file.read(SCENES / "ring_round_a_column.enf.json")
    names = [r.name for r in building.rooms]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.enf.json")), ids=lambda p: p.name)
def test_every_scene_with_shapes_can_be_read(path: Path) -> None:
    try:
        building = scene_file.read(path)
    except scene_file.SceneFileError as error:
        assert "no cells with a shape" in str(error)
        return
    for opening in building.openings:
        assert all(0 <= r < len(building.rooms) for r in opening.rooms)


def test_a_window_leads_to_the_exterior() -> None:
    building = scene_file.read(SCENES / "window_to_the_exterior.enf.json")
    outside = [i for i, r in enumerate(building.rooms) if r.kind == EXTERIOR]
    assert len(outside) == 1 and any(outside[0] in o.rooms for o in building.openings)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "enfilade-scene", "version": 2}',
                                  '{"format": "enfilade-scene", "version": 1}',
                                  json.dumps({"format": "enfilade-scene", "version": 1, "rooms": [{"name": "A"}],
                                              "cells": [{"room": 0, "vertices": [[0, 0, 0]] * 4}], "portals": [{"cells": [0, 7]}]})])
def test_what_is_no_scene_is_told_by_name(tmp_path: Path, text: str) -> None:
    path = tmp_path / "odd.enf.json"
    path.write_text(text)
    with pytest.raises(scene_file.SceneFileError, match="odd.enf.json"):
        scene_file.read(path)
