# SPDX-License-Identifier: GPL-3.0-or-later
"""Balconies, loggias and courtyards of IFC models, with terrain and without: what is seen in them, across them, past them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from enfilade import native
from enfilade.analysis import Analyser, Shot
from enfilade.rules import building as b
from enfilade.rules import ifc, ifc_library
from ifc_blocks import Blocks

pytestmark = pytest.mark.skipif(not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)")


def _seen(building: b.Building, eye, towards) -> tuple[set[str], set[str]]:
    """Names of rooms and objects that a camera sees."""
    forward = np.subtract(towards, eye) / np.linalg.norm(np.subtract(towards, eye))
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = right, np.cross(right, forward), -forward, eye
    analyser = Analyser(native.load(), building)
    view = analyser.look(Shot("eye", 1, [b.Camera("eye", pose, "PERSP", 0.9, 0.7, clip=(0.01, 1000.0))]), "portal")
    rooms, objects = {building.rooms[r].name for r in view.rooms}, {building.objects[o].name.partition("/")[2] for o in view.objects}
    analyser.close()
    return rooms, objects


def _read(model: Blocks, folder: Path, terrain: bool) -> b.Building:
    if terrain:
        model.product("Terrain", "IfcBuildingElementProxy", ((-30, -30, -1.0), (40, 40, -0.5)))
    return ifc.read_ifc(model.save(folder))


def _pairs(building: b.Building) -> set[tuple[str, frozenset[str]]]:
    return {(o.kind, frozenset(building.rooms[r].name for r in o.rooms)) for o in building.openings}


def _flat(model: Blocks, west: float, east: float, name: str, door_to_south: str = "IfcDoor") -> None:
    """A room between x = west and east, y = 0 .. 4, all round closed but for an opening of 1 m in its south wall."""
    model.product(name, "IfcSpace", ((west, 0, 0), (east, 4, 2.5)))
    middle = 0.5 * (west + east)
    south = model.product(f"South {name}", "IfcWall", ((west, -0.3, 0), (east, 0, 2.5)))
    filler = model.product(f"Way {name}", door_to_south, ((middle - 0.5, -0.2, 0), (middle + 0.5, -0.1, 2.1)))
    model.void(south, ((middle - 0.5, -0.3, 0), (middle + 0.5, 0, 2.1)), filler)
    model.product(f"North {name}", "IfcWall", ((west, 4, 0), (east, 4.3, 2.5)))
    for side, x in (("West", west - 0.3), ("East", east)):
        model.product(f"{side} {name}", "IfcWall", ((x, -0.3, 0), (x + 0.3, 4.3, 2.5)))
    model.product(f"Floor {name}", "IfcSlab", ((west - 0.3, -0.3, -0.3), (east + 0.3, 4.3, 0)))
    model.product(f"Roof {name}", "IfcSlab", ((west - 0.3, -0.3, 2.5), (east + 0.3, 4.3, 2.8)))


@pytest.mark.parametrize("terrain", [False, True])
def test_a_balcony_that_is_a_space_is_open_to_the_outdoors(tmp_path: Path, terrain: bool) -> None:
    model = Blocks()
    _flat(model, 0, 5, "Living")
    model.product("Balcony", "IfcSpace", ((1, -2.0, 0), (4, -0.3, 2.5)))
    model.product("Slab", "IfcSlab", ((1, -2.0, -0.2), (4, -0.3, 0)))
    model.product("Railing", "IfcRailing", ((1, -2.0, 0), (4, -1.95, 1.0)))
    model.product("Tree", "IfcBuildingElementProxy", ((2, -12, -0.5), (3, -11, 4)))
    model.product("Behind", "IfcBuildingElementProxy", ((2, 12, -0.5), (3, 13, 2)))
    building = _read(model, tmp_path, terrain)
    pairs = _pairs(building)
    assert (b.DOOR, frozenset({"Living", "Balcony"})) in pairs and (b.VIRTUAL, frozenset({"Balcony", "Exterior"})) in pairs
    assert not any(kind == b.VIRTUAL and "Living" in rooms for kind, rooms in pairs)
    rooms, objects = _seen(building, (2.5, 3.5, 1.5), (2.5, 0, 1.2))
    assert {"Living", "Balcony", "Exterior"} <= rooms and {"Railing", "Tree"} <= objects and "Behind" not in objects
    assert ("Terrain" in objects) == terrain
    rooms, objects = _seen(building, (2.5, -1.0, 1.6), (2.5, -10, 1.6))  # who stands on the balcony
    assert "Tree" in objects and "Behind" not in objects


@pytest.mark.parametrize("space", [False, True])
def test_a_loggia_is_looked_into_from_both_rooms_beside_it(tmp_path: Path, space: bool) -> None:
    """A recess between two rooms, roofed, open to the south: with a space of its own or nobody's."""
    model = Blocks()
    for name, west, east in (("Left", 0, 4), ("Right", 7, 11)):
        model.product(name, "IfcSpace", ((west, 0, 0), (east, 4, 2.5)))
        model.product(f"Floor {name}", "IfcSlab", ((west - 0.3, -0.3, -0.3), (east + 0.3, 4.3, 0)))
        model.product(f"South {name}", "IfcWall", ((west, -0.3, 0), (east, 0, 2.5)))
        model.product(f"North {name}", "IfcWall", ((west, 4, 0), (east, 4.3, 2.5)))
        for side, x in (("West", west - 0.3), ("East", east)):
            wall = model.product(f"{side} {name}", "IfcWall", ((x, -0.3, 0), (x + 0.3, 4.3, 2.5)))
            if (side == "East") == (name == "Left"):
                pane = model.product(f"Pane {name}", "IfcWindow", ((x + 0.1, 1.5, 1.0), (x + 0.2, 2.5, 2.0)))
                model.void(wall, ((x, 1.5, 1.0), (x + 0.3, 2.5, 2.0)), pane)
        model.product(f"Chair {name}", "IfcFurnishingElement", ((0.5 * (west + east) - 0.3, 1.7, 0), (0.5 * (west + east) + 0.3, 2.3, 1.4)))
    model.product("Back", "IfcWall", ((4.3, 3.0, 0), (6.7, 3.3, 2.5)))
    model.product("Floor", "IfcSlab", ((4.3, -0.3, -0.3), (6.7, 3.3, 0)))
    model.product("Roof", "IfcSlab", ((-0.3, -0.3, 2.5), (11.3, 4.3, 2.8)))
    if space:
        model.product("Loggia", "IfcSpace", ((4.3, -0.3, 0), (6.7, 3.0, 2.5)))
    building = _read(model, tmp_path, False)
    between = "Loggia" if space else "Exterior"
    assert {(b.WINDOW, frozenset({n, between})) for n in ("Left", "Right")} <= _pairs(building)
    assert ((b.VIRTUAL, frozenset({"Loggia", "Exterior"})) in _pairs(building)) == space
    rooms, objects = _seen(building, (0.5, 2.0, 1.5), (11, 2.0, 1.4))  # from one room into the other, across the recess
    assert {"Left", between, "Right"} <= rooms and "Chair Right" in objects


@pytest.mark.parametrize("terrain", [False, True])
def test_one_sees_across_a_courtyard_and_not_through_its_house(tmp_path: Path, terrain: bool) -> None:
    """Two wings face each other over a court that two further wings close; the court is nobody's space."""
    model = Blocks()
    _flat(model, 0, 6, "North wing")
    for name, low, high in (
        ("South wing", (0, -12, 0), (6, -8.3, 2.5)), ("West wing", (-4.6, -12, 0), (-0.6, 4, 2.5)), ("East wing", (6.6, -12, 0), (10.6, 4, 2.5)),
    ):  # fmt: skip
        model.product(name, "IfcSpace", (low, high))
        for k in range(2):
            for end in (low[k] - 0.3, high[k]):
                a, c = [low[0] - 0.3, low[1] - 0.3, 0.0], [high[0] + 0.3, high[1] + 0.3, 2.5]
                a[k], c[k] = end, end + 0.3
                wall = model.product(f"Wall {name} {k} {end}", "IfcWall", (tuple(a), tuple(c)))
                if name == "South wing" and k == 1 and end == high[1]:
                    model.void(wall, ((2.5, end, 0), (3.5, end + 0.3, 2.1)))
        for z in (-0.3, 2.5):
            model.product(f"Slab {name} {z}", "IfcSlab", ((low[0] - 0.3, low[1] - 0.3, z), (high[0] + 0.3, high[1] + 0.3, z + 0.3)))
    model.product("Bench", "IfcFurnishingElement", ((2.8, -10.5, 0), (3.2, -10.2, 1)))
    model.product("Far", "IfcBuildingElementProxy", ((2.8, -30, 0), (3.2, -29, 2)))
    building = _read(model, tmp_path, terrain)
    pairs = _pairs(building)
    assert (b.DOOR, frozenset({"North wing", "Exterior"})) in pairs and (b.HOLE, frozenset({"South wing", "Exterior"})) in pairs
    rooms, objects = _seen(building, (3.0, 3.0, 1.2), (3.0, -10, 1.0))
    assert {"North wing", "Exterior", "South wing"} <= rooms and "Bench" in objects
    assert not rooms & {"West wing", "East wing"} and "Far" not in objects
