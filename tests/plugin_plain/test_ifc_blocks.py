# SPDX-License-Identifier: GPL-3.0-or-later
"""`read_ifc` on small models made for each case where a naive extractor fails."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import air_layer, building_io, ifc, ifc_library, ifc_rounds, ifc_shapes, opening_rules
from enfilade.rules import convex_polygons as cp
from enfilade.rules.building import CLOSED, DOOR, EXTERIOR, GLASS, HOLE, OPEN, VIRTUAL, WINDOW, Building
from enfilade.rules.ifc_states import DoorStates
from ifc_blocks import Blocks, two_rooms

pytestmark = pytest.mark.skipif(
    not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)"
)


def _names(building: Building) -> list[tuple[str, tuple[str, ...]]]:
    return sorted((o.kind, tuple(sorted(building.rooms[r].name for r in o.rooms))) for o in building.openings)


def _codes(building: Building) -> list[str]:
    return sorted(p.code for p in building.problems)


def _read(model: Blocks, folder: Path, **options) -> Building:
    return ifc.read_ifc(model.save(folder), objects=False, **options)


def test_closed_shell_has_no_openings(tmp_path: Path) -> None:
    model, _ = two_rooms()
    building = _read(model, tmp_path)
    assert [r.name for r in building.rooms] == ["A", "B", "Exterior"]
    assert building.rooms[2].kind == EXTERIOR and building.rooms[2].vertices is None
    assert building.openings == [] and building.problems == []
    room = building.rooms[0]
    assert len(room.vertices) == 8 and sorted(len(f) for f in room.faces) == [4] * 6
    assert room.storey == "Ground" and len(room.source_id) == 22


@pytest.mark.parametrize("unit", [1.0, 0.001])
@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4", "IFC4X3"])
@pytest.mark.parametrize("depth", [0.2, 1.4, 0.1])
def test_door_joins_the_rooms_at_their_faces(tmp_path: Path, unit: float, schema: str, depth: float) -> None:
    """A void as deep as the wall, one that overlaps both rooms (its thinnest side along the wall), one too shallow."""
    model, wall = two_rooms(unit=unit, schema=schema)
    entity = "IfcDoorStandardCase" if schema == "IFC4" else "IfcDoor"
    door = model.product("D1", entity, ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4.1 - depth / 2, 2, 0), (4.1 + depth / 2, 2.9, 2.1)), door)
    building = _read(model, tmp_path)
    assert _names(building) == [(DOOR, ("A", "B"))]
    opening = building.openings[0]
    assert opening.source_id == door.GlobalId and opening.state == OPEN
    a, b = opening.ends if building.rooms[opening.rooms[0]].name == "A" else opening.ends[::-1]
    assert np.allclose(a[:, 0], 4.0, atol=1e-6) and np.allclose(b[:, 0], 4.2, atol=1e-6)
    for end in (a, b):
        # Where the void ends 5 cm before the room, the end grows by as much; it never shrinks.
        spread = 0.05 + 1e-6 if depth == 0.1 else 1e-6
        assert 2 - spread <= end[:, 1].min() <= 2 + 1e-6 and 2.9 - 1e-6 <= end[:, 1].max() <= 2.9 + spread
        assert end[:, 2].max() >= 2.1 - 1e-6


def test_stars_for_what_has_no_value_cost_no_opening(tmp_path: Path) -> None:
    """Some tools write `*` (derived) where `$` belongs; the geometry kernel then makes no shape of the void, but cuts the wall."""
    model, wall = two_rooms()
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4, 2, 0), (4.2, 2.9, 2.1)), door).Name = None
    path = model.save(tmp_path)
    lines = path.read_text().splitlines()
    starred = [x.replace("$", "*") if "IFCOPENINGELEMENT(" in x else x for x in lines]
    assert starred != lines
    path.write_text("\n".join(starred))
    assert _names(ifc.read_ifc(path, objects=False)) == [(DOOR, ("A", "B"))]


def test_bounds_come_out_alike_from_both_kernels(tmp_path: Path) -> None:
    """The quick kernel is asked for flat shapes only; what has a circle in it goes to the exact one."""
    model, _ = two_rooms()
    f = model.f
    column = model.product("Round", "IfcColumn", ((1, 1, 0), (2, 2, 2.5)))
    solid = column.Representation.Representations[0].Items[0]
    solid.SweptArea = f.createIfcCircleProfileDef("AREA", None, f.createIfcAxis2Placement2D(f.createIfcCartesianPoint([0.5, 0.5]), None), 0.5)
    products = [p for p in f.by_type("IfcElement") if p.Representation]
    assert ifc_rounds.of(f) == {column.id()}
    made = [ifc_shapes.make(f, products, cut=False, offset=np.zeros(3), bounds=quick) for quick in (False, True)]
    assert made[0].keys() == made[1].keys() and len(made[0]) == len(products)
    for step, exact in made[0].items():
        quick = made[1][step]
        assert np.allclose(exact.world.min(axis=0), quick.world.min(axis=0), atol=1e-9)
        assert np.allclose(exact.world.max(axis=0), quick.world.max(axis=0), atol=1e-9)
    assert len(made[0][column.id()].world) == len(made[1][column.id()].world)


def test_far_away_and_turned_gives_the_same(tmp_path: Path) -> None:
    def make(**options) -> Building:
        model, wall = two_rooms(**options)
        door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
        model.void(wall, ((3.6, 2, 0), (4.6, 2.9, 2.1)), door)
        return ifc.read_ifc(model.save(tmp_path), objects=False)

    origin = np.array([5e5, 5e6, 100.0])
    here, there = make(), make(origin=tuple(origin), degrees=33.0)
    c, s = np.cos(np.radians(33)), np.sin(np.radians(33))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert _names(here) == _names(there)
    for r, q in zip(here.rooms[:2], there.rooms[:2], strict=True):
        assert np.abs(_sorted(r.vertices) - _sorted((q.vertices - origin) @ turn)).max() < 1e-6
    assert np.abs(_sorted(here.openings[0].body) - _sorted((there.openings[0].body - origin) @ turn)).max() < 1e-6


def _sorted(points: np.ndarray) -> np.ndarray:
    rounded = np.round(points, 4)
    return points[np.lexsort(rounded.T[::-1])]


def test_local_coordinates_tell_their_offset(tmp_path: Path) -> None:
    model, _ = two_rooms(origin=(5e5, 5e6, 100.0))
    building = _read(model, tmp_path, local=True)
    assert building.offset == (500_000.0, 5_000_000.0, 0.0)
    assert np.abs(building.rooms[0].vertices).max() < 1000


def test_sink_in_a_table_is_a_false_portal(tmp_path: Path) -> None:
    model, _ = two_rooms()
    table = model.product("Table", "IfcFurnishingElement", ((1, 1, 0.7), (2, 2, 0.8)))
    model.void(table, ((1.3, 1.3, 0.7), (1.6, 1.6, 0.8)))
    building = _read(model, tmp_path)
    assert building.openings == [] and _codes(building) == ["false-portal"]


def test_partition_inside_a_room_makes_no_portal(tmp_path: Path) -> None:
    model, _ = two_rooms()
    wall = model.product("Partition", "IfcWall", ((2, 0, 0), (2.05, 5, 2)))
    door = model.product("WC", "IfcDoor", ((2, 1, 0), (2.05, 1.7, 1.9)))
    model.void(wall, ((1.9, 1, 0), (2.15, 1.7, 1.9)), door)
    building = _read(model, tmp_path)
    assert building.openings == [] and _codes(building) == ["opening-inside-room"]


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4"])
@pytest.mark.parametrize("of", ["shape", "material", "name", None])
def test_what_is_drawn_transparent_is_glass(tmp_path: Path, schema: str, of: str | None) -> None:
    """By the style of its shape, by its material's, or by its type's name, though no word of its sets says so."""
    model, wall = two_rooms(schema=schema)
    f = model.f
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4.0, 2, 0), (4.2, 2.9, 2.1)), door)
    white = f.createIfcColourRgb(None, 1.0, 1.0, 1.0)
    rendering = f.create_entity("IfcSurfaceStyleRendering", SurfaceColour=white, Transparency=0.7, ReflectanceMethod="NOTDEFINED")
    style = f.createIfcSurfaceStyle("Leaf", "BOTH", [rendering])
    shown = [f.createIfcPresentationStyleAssignment([style])]
    if of == "shape":
        f.createIfcStyledItem(door.Representation.Representations[0].Items[0], shown, None)
    elif of == "material":
        material = f.create_entity("IfcMaterial", Name="M7")
        f.createIfcRelAssociatesMaterial(model.guid(), None, None, None, [door], material)
        styled = f.createIfcStyledRepresentation(model.context, "Style", "Material", [f.createIfcStyledItem(None, shown, None)])
        f.createIfcMaterialDefinitionRepresentation(None, None, [styled], material)
    elif of == "name":
        door.ObjectType = "Porta de vidre"
    opening = next(o for o in ifc.read_ifc(model.save(tmp_path), objects=False, door_states="closed").openings)
    assert opening.state == (CLOSED if of is None else GLASS)


def test_window_leads_outdoors_and_is_glass(tmp_path: Path) -> None:
    model, _ = two_rooms()
    east = next(w for w in model.f.by_type("IfcWall") if w.Name == "East")
    window = model.product("W", "IfcWindow", ((8.1, 1, 1), (8.2, 2, 2)))
    model.void(east, ((8, 1, 1), (8.3, 2, 2)), window)
    building = _read(model, tmp_path)
    assert _names(building) == [(WINDOW, ("B", "Exterior"))] and building.openings[0].state == GLASS


def test_window_across_two_rooms_joins_both(tmp_path: Path) -> None:
    model, _ = two_rooms()
    north = next(w for w in model.f.by_type("IfcWall") if w.Name == "North")
    window = model.product("W", "IfcWindow", ((3, 5.1, 1), (5.5, 5.2, 2)))
    model.void(north, ((3, 5, 1), (5.5, 5.3, 2)), window)
    building = _read(model, tmp_path)
    assert _names(building) == [(WINDOW, ("A", "Exterior")), (WINDOW, ("B", "Exterior"))]
    for opening in building.openings:
        side = next(k for k, r in enumerate(opening.rooms) if building.rooms[r].kind != EXTERIOR)
        x = opening.ends[side][:, 0]
        low, high = (3.0, 4.0) if building.rooms[opening.rooms[side]].name == "A" else (4.2, 5.5)
        assert x.min() == pytest.approx(low, abs=1e-6) and x.max() == pytest.approx(high, abs=1e-6)


def test_unfilled_slab_void_is_a_vertical_portal(tmp_path: Path) -> None:
    model = Blocks()
    model.product("Below", "IfcSpace", ((0, 0, 0), (4, 4, 2.5)))
    model.product("Above", "IfcSpace", ((0, 0, 2.8), (4, 4, 5.3)))
    slab = model.product("Slab", "IfcSlab", ((-1, -1, 2.5), (5, 5, 2.8)))
    model.void(slab, ((1, 1, 2.4), (2, 3, 2.9)))
    building = _read(model, tmp_path)
    holes = [o for o in building.openings if o.kind == HOLE]
    assert len(holes) == 1 and {building.rooms[r].name for r in holes[0].rooms} == {"Below", "Above"}
    heights = sorted(float(e[:, 2].mean()) for e in holes[0].ends)
    assert heights == pytest.approx([2.5, 2.8], abs=1e-6)


@pytest.mark.parametrize("face", [4.0, 3.8])
def test_a_door_of_rooms_that_overlap_joins_each_of_them(tmp_path: Path, face: float) -> None:
    """Their faces lie in one plane before the door, or one room ends before the other does."""
    model, wall = two_rooms()
    model.product("Loft", "IfcSpace", ((2, 0, 0), (face, 5, 4)))
    model.void(wall, ((4, 2, 0), (4.2, 2.9, 2.1)), model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1))))
    doors = [rooms for kind, rooms in _names(_read(model, tmp_path)) if kind == DOOR]
    assert sorted(doors) == [("A", "B"), ("B", "Loft")]


def test_a_slot_between_rooms_is_looked_through_to_where_it_ends(tmp_path: Path) -> None:
    """Over a low partition rooms touch but for 4 cm; the outer wall has a slot there. Each room sees out of it, past the other."""
    model = Blocks()
    model.product("A", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)))
    model.product("B", "IfcSpace", ((4.04, 0, 0), (8, 5, 2.5)))
    model.product("Partition", "IfcWall", ((4, 0, 0), (4.04, 5, 2)))
    for name, low, high in (("West", (-1, -1), (0, 6)), ("East", (8, -1), (9, 6)), ("North", (0, 5), (8, 6)),
                            ("South A", (0, -1), (4, 0)), ("South B", (4.04, -1), (8, 0))):  # fmt: skip
        model.product(name, "IfcWall", ((*low, 0), (*high, 2.5)))
    model.product("Floor", "IfcSlab", ((-1, -1, -0.3), (9, 6, 0)))
    model.product("Roof", "IfcSlab", ((-1, -1, 2.5), (9, 6, 2.8)))
    building = _read(model, tmp_path)
    assert {rooms for _, rooms in _names(building)} == {("A", "B"), ("A", "Exterior"), ("B", "Exterior")}
    out = [o.polygon for o in building.openings if EXTERIOR in {building.rooms[r].kind for r in o.rooms}]
    assert all(p[:, 2].min() >= 1.99 and p[:, 1].min() == pytest.approx(0.0, abs=1e-5) for p in out)


def test_rooms_that_overlap_without_a_slab_are_joined_where_one_ends_in_the_other(tmp_path: Path) -> None:
    """A hall reaches 20 cm up into the room above: nothing is drawn between, and neither leads outdoors there."""
    model = Blocks()
    model.product("Hall", "IfcSpace", ((0, 0, 0), (4, 4, 2.7)))
    model.product("Above", "IfcSpace", ((0, 0, 2.5), (4, 4, 5)))
    for name, low, high in (("West", (-1, -1), (0, 5)), ("East", (4, -1), (5, 5)), ("South", (0, -1), (4, 0)), ("North", (0, 4), (4, 5))):
        model.product(name, "IfcWall", ((*low, 0), (*high, 5)))
    model.product("Floor", "IfcSlab", ((-1, -1, -0.3), (5, 5, 0)))
    model.product("Roof", "IfcSlab", ((-1, -1, 5), (5, 5, 5.3)))
    building = _read(model, tmp_path)
    assert _names(building) == [(VIRTUAL, ("Above", "Hall"))] * 2
    assert sorted(float(o.polygon[:, 2].mean()) for o in building.openings) == pytest.approx([2.5, 2.7], abs=1e-5)


def test_rooms_that_touch_are_joined_where_no_wall_stands(tmp_path: Path) -> None:
    model = Blocks()
    model.product("Kitchen", "IfcSpace", ((0, 0, 0), (3, 4, 2.5)))
    model.product("Dining", "IfcSpace", ((3, 0, 0), (7, 4, 2.5)))
    model.product("Half", "IfcWall", ((2.9, 2, 0), (3.1, 4, 2.5)))  # the boundary runs in the middle of this wall
    building = _read(model, tmp_path)
    joined = [o for o in building.openings if {building.rooms[r].name for r in o.rooms} == {"Kitchen", "Dining"}]
    assert len(joined) == 1 and joined[0].kind == VIRTUAL
    y = joined[0].polygon[:, 1]
    assert y.min() == pytest.approx(0.0, abs=2e-3) and 2.0 - 1e-6 <= y.max() <= 2.002
    assert "rooms-touch" in _codes(building)


@pytest.mark.parametrize("width", [0.004, 0.03])
def test_a_narrow_gap_beside_a_wall_is_seen_through(tmp_path: Path, width: float) -> None:
    model = Blocks()
    model.product("Kitchen", "IfcSpace", ((0, 0, 0), (3, 4, 2.5)))
    model.product("Dining", "IfcSpace", ((3, 0, 0), (7, 4, 2.5)))
    model.product("Wall", "IfcWall", ((2.9, 0, 0), (3.1, 4 - width, 2.5)))
    building = _read(model, tmp_path)
    joined = [o for o in building.openings if {building.rooms[r].name for r in o.rooms} == {"Kitchen", "Dining"}]
    assert len(joined) == 1 and joined[0].kind == VIRTUAL
    y = joined[0].polygon[:, 1]
    assert 4 - width - 2e-3 <= y.min() <= 4 - width and y.max() >= 4 - 1e-6


def test_a_wall_that_stands_off_its_room_lets_looks_slip_in_beside_the_door(tmp_path: Path) -> None:
    model = Blocks()
    model.product("A", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)))
    model.product("B", "IfcSpace", ((4.2, 0, 0), (8, 5, 2.5)))
    wall = model.product("Wall", "IfcWall", ((4.004, -1, 0), (4.2, 6, 2.5)))
    model.void(wall, ((4.0, 2, 0), (4.2, 2.9, 2.1)), model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1))))
    building = _read(model, tmp_path)
    a, b = next(o.ends for o in building.openings if o.kind == DOOR)
    slip = 0.004 / 0.1  # of the void's size: a look 0.1 m deep in the void crosses it once
    assert a[:, 1].min() == pytest.approx(2.0 - 0.9 * slip, abs=1e-5) and a[:, 1].max() == pytest.approx(2.9 + 0.9 * slip, abs=1e-5)
    assert a[:, 2].min() == pytest.approx(0.0, abs=1e-5) and a[:, 2].max() == pytest.approx(2.1 + 2.1 * slip, abs=1e-5)
    assert np.allclose((b.min(axis=0), b.max(axis=0)), ((4.2, 2.0, 0.0), (4.2, 2.9, 2.1)), atol=1e-5)


def test_rooms_that_touch_over_a_corner_behind_finishes_are_joined(tmp_path: Path) -> None:
    """A ceiling board ends 1 cm before the upper room, 12 mm below the slab: air leads over the corner."""
    model = Blocks()
    model.product("Low", "IfcSpace", ((0, 0, 0), (3, 4, 2.5)))
    model.product("High", "IfcSpace", ((3, 0, 2.5), (7, 4, 5.0)))
    model.product("Board", "IfcCovering", ((-1, -1, 2.5), (2.99, 5, 2.512)))
    model.product("Roof", "IfcSlab", ((-1, -1, 2.512), (3, 5, 5.2)))
    model.product("Floor", "IfcSlab", ((3, -1, 2.0), (8, 5, 2.5)))
    building = _read(model, tmp_path)
    joined = [o for o in building.openings if {building.rooms[r].name for r in o.rooms} == {"Low", "High"}]
    assert {round(float(np.ptp(o.polygon[:, 2])), 2) == 0.0 for o in joined} == {True, False}


def test_every_piece_of_a_floor_over_joists_is_looked_past(tmp_path: Path) -> None:
    """Boards 12 mm below the floor end at the walls; joists below part the floor into many pieces. Where a wall doesn't reach down to
    the boards a look slips out, be it for 3 mm."""

    def ways_out(gap: tuple[float, float] | None) -> list[cp.Polygon]:
        model = Blocks()
        model.product("A", "IfcSpace", ((0, 0, 0), (9, 3, 2.5)))
        for n, (low, high) in enumerate((((-0.2, -0.2), (0, 3.2)), ((9, -0.2), (9.2, 3.2)), ((0, 3), (9, 3.2)))):
            model.product(f"Wall {n}", "IfcWall", ((*low, -0.3), (*high, 2.5)))
        x0, x1 = gap or (4.0, 4.1)
        model.product("Left", "IfcWall", ((0, -0.2, -0.3), (x0, 0, 2.5)))
        model.product("Short", "IfcWall", ((x0, -0.2, 0 if gap else -0.3), (x1, 0, 2.5)))
        model.product("Right", "IfcWall", ((x1, -0.2, -0.3), (9, 0, 2.5)))
        model.product("Roof", "IfcSlab", ((-0.3, -0.3, 2.5), (9.3, 3.3, 2.8)))
        model.product("Boards", "IfcSlab", ((0, 0, -0.04), (9, 3, -0.012)))
        for n in range(60):
            model.product(f"Joist {n}", "IfcBeam", ((0.1 + 0.14 * n, 0, -0.24), (0.17 + 0.14 * n, 3, -0.04)))
        return [cp.hull((p[0], p[1]) for p in o.polygon) for o in _read(model, tmp_path).openings if o.kind == VIRTUAL]

    assert ways_out(None) == []
    for gap in ((4.175, 4.235), (4.245, 4.305), (4.2, 4.203)):  # between joists, over one, a slit
        middle = (0.5 * sum(gap), 0.005)
        assert any(cp.contains(polygon, middle) for polygon in ways_out(gap)), gap


def test_voids_that_overlap_are_looked_through_together(tmp_path: Path) -> None:
    model, wall = two_rooms()
    for name, y in (("D1", 2.0), ("D2", 2.86), ("D3", 4.0)):
        model.void(wall, ((4.0, y, 0), (4.2, y + 0.9, 2.1)), model.product(name, "IfcDoor", ((4.05, y, 0), (4.1, y + 0.9, 2.1))))
    building = _read(model, tmp_path)
    assert [o.name for o in building.openings] == ["D1", "D2", "D3", "D1 + D2"]
    both = building.openings[3]
    assert both.members == (0, 1)
    for rules, state in (({"class:door": CLOSED}, CLOSED), ({"class:door": CLOSED, "D2": OPEN}, OPEN), ({"D1 + D2": CLOSED}, OPEN)):
        opening_rules.apply(building, rules)  # never more closed than what shares its air
        assert both.state == state
    building.rooms[0].top = 2.5
    again = building_io.from_json(building_io.to_json(building))
    assert again.openings[3].members == (0, 1)
    assert [r.top for r in again.rooms] == [r.top for r in building.rooms]
    assert both.kind == DOOR and {building.rooms[r].name for r in both.rooms} == {"A", "B"}
    for end in both.ends:
        assert end[:, 1].min() == pytest.approx(2.0) and end[:, 1].max() == pytest.approx(3.76)


def test_doubles_of_a_room_leave_the_net_one(tmp_path: Path) -> None:
    model, _ = two_rooms()
    model.product("A gross", "IfcSpace", ((-0.3, -0.3, 0), (4.1, 5.3, 2.5)))
    model.product("B again", "IfcSpace", ((4.2, 0, 0), (8, 5, 2.5)))
    building = _read(model, tmp_path)
    assert [r.name for r in building.rooms] == ["A", "B", "Exterior"]
    assert sorted(p.names[0] for p in building.problems if p.code == "room-double") == ["A gross", "B again"]


def test_a_space_drawn_as_its_footprint_is_left_out(tmp_path: Path) -> None:
    model, _ = two_rooms()
    model.sheet("Plan", "IfcSpace", [(0, 0, 0), (8, 0, 0), (8, 5, 0), (0, 5, 0)])
    building = _read(model, tmp_path)
    assert [r.name for r in building.rooms] == ["A", "B", "Exterior"]
    assert [p.names for p in building.problems if p.code == "room-empty"] == [["Plan"]]


def test_a_byte_order_mark_is_no_hindrance(tmp_path: Path) -> None:
    model, _ = two_rooms()
    path = model.save(tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert [r.name for r in ifc.read_ifc(path, objects=False).rooms] == ["A", "B", "Exterior"]


def test_sheets_of_several_products_are_no_wall_that_rooms_are_drawn_into(tmp_path: Path) -> None:
    """Two rooms meet within an opening; a sheet stands in either, both facing east: air lies between them, not a wall."""
    model = Blocks()
    model.product("A", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)))
    model.product("B", "IfcSpace", ((4, 0, 0), (8, 5, 2.5)))
    for name, x in (("Route", 3.85), ("Sign", 4.2)):
        model.sheet(name, "IfcBuildingElementProxy", [(x, 1, 1), (x, 2, 1), (x, 2, 2), (x, 1, 2)])
    found = [o for o in _read(model, tmp_path).openings if o.kind == VIRTUAL and 2 not in o.rooms]
    assert sum(cp.area(cp.hull((p[1], p[2]) for p in o.polygon)) for o in found) == pytest.approx(12.5, rel=1e-2)


def test_a_door_without_a_slab_below_lets_one_see_under_the_wall(tmp_path: Path) -> None:
    model, wall = two_rooms()
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4.0, 2, 0), (4.2, 2.9, 2.1)), door)
    assert "opening-open-beside" not in _codes(_read(model, tmp_path))
    for slab in model.f.by_type("IfcSlab"):
        if slab.Name == "Floor":
            model.f.remove(slab)
    building = _read(model, tmp_path)
    told = [p for p in building.problems if p.code == "opening-open-beside"]
    assert len(told) == 1 and told[0].names == ["D1"] and told[0].remedy and told[0].position[2] < 0.0
    ends = [o for o in building.openings if o.kind == VIRTUAL and abs(np.ptp(o.polygon[:, 1]) - 0.9) < 1e-6]
    assert {building.rooms[r].name for o in ends for r in o.rooms} == {"A", "B", "Exterior"}


def test_a_door_across_open_air_is_looked_out_of_sideways(tmp_path: Path) -> None:
    """Its void is far deeper than its wall and reaches the other room, which begins 0.6 m beyond: between them is outdoors."""
    model, wall = two_rooms()
    model.void(wall, ((4.0, 2, 0), (4.8, 2.9, 2.1)), model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1))))
    assert "opening-open-beside" not in _codes(_read(model, tmp_path))
    for space in model.f.by_type("IfcSpace"):
        if space.Name == "B":
            model.f.remove(space)
    model.product("B", "IfcSpace", ((4.8, 0, 0), (8, 5, 2.5)))
    building = _read(model, tmp_path)
    told = [p for p in building.problems if p.code == "opening-open-beside"]
    assert [p.names for p in told] == [["D1"]] and told[0].position[0] > 4.2
    ends = [o for o in building.openings if o.kind == VIRTUAL and np.ptp(o.polygon[:, 1]) < 1.5 and o.polygon[:, 0].max() < 4.81]
    assert {building.rooms[r].name for o in ends for r in o.rooms} == {"A", "B", "Exterior"}


@pytest.mark.parametrize("lean", [0.0, 1e-4, 0.01])
@pytest.mark.parametrize("most", [air_layer.MOST, 1])
def test_a_post_that_stands_off_in_a_notch_is_looked_past(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lean: float, most: int
) -> None:
    """Between A and C the post's front is 51 mm off A's face, straight or leaning: one looks past it from room to room; where too
    much would have to be followed, too."""
    monkeypatch.setattr(air_layer, "MOST", most)
    model = Blocks()
    model.product("A", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)))
    model.product("C", "IfcSpace", ((4, 0, 0), (4.15, 2, 2.5)))
    x = 4.051 + lean
    model.sheet("Post", "IfcColumn", [(4.051, 2, 0), (4.051, 2, 2.5), (x, 2.1, 2.5), (x, 2.1, 0)])
    model.product("Wall", "IfcWall", ((4, 2.1, 0), (4.15, 5, 2.5)))
    building = _read(model, tmp_path)
    joined = [o for o in building.openings if {building.rooms[r].name for r in o.rooms} == {"A", "C"}]
    assert max(o.polygon[:, 1].max() for o in joined) >= 2.1 - 2e-3
    assert ("room-crowded" in _codes(building)) == (most == 1)


def test_room_without_walls_is_open_to_the_exterior(tmp_path: Path) -> None:
    model = Blocks()
    model.product("Terrace", "IfcSpace", ((0, 0, 0), (3, 4, 2.5)))
    model.product("Floor", "IfcSlab", ((-1, -1, -0.3), (4, 5, 0)))
    building = _read(model, tmp_path)
    assert {o.kind for o in building.openings} == {VIRTUAL} and len(building.openings) == 5
    assert _codes(building) == ["room-open"]


def test_door_in_a_curtain_wall_without_a_void(tmp_path: Path) -> None:
    model, _ = two_rooms()
    east = next(w for w in model.f.by_type("IfcWall") if w.Name == "East")
    model.f.remove(east)
    wall = model.f.createIfcCurtainWall(model.guid(), None, "CW", None, None, model.world, None, None)
    parts = [
        model.product("Pane 1", "IfcPlate", ((8.1, 0, 0), (8.15, 2, 2.5))),
        model.product("Pane 2", "IfcPlate", ((8.1, 3, 0), (8.15, 5, 2.5))),
        model.product("Over", "IfcPlate", ((8.1, 2, 2.1), (8.15, 3, 2.5))),
        model.product("CW door", "IfcDoor", ((8.05, 2, 0), (8.2, 3, 2.1))),
    ]
    model.f.createIfcRelAggregates(model.guid(), None, None, None, wall, parts)
    building = _read(model, tmp_path)
    kinds = {(o.kind, building.rooms[o.rooms[0]].name, building.rooms[o.rooms[1]].name) for o in building.openings}
    assert {k for k, *_ in kinds} >= {DOOR, WINDOW}
    assert all({a, b} == {"B", "Exterior"} for _, a, b in kinds)
    door = next(o for o in building.openings if o.kind == DOOR)
    assert door.source_id == parts[3].GlobalId
    y = door.body[:, 1]
    assert 1.9 <= y.min() <= 2.0 + 1e-6 and 3.0 - 1e-6 <= y.max() <= 3.1


def test_a_void_beside_its_wall_takes_nothing_away(tmp_path: Path) -> None:
    model, wall = two_rooms()
    model.void(wall, ((4.2, 2, 0), (4.9, 2.9, 2.1)))
    building = _read(model, tmp_path)
    assert building.openings == [] and _codes(building) == ["void-beside-host"]


def test_gross_areas_and_doubles_are_left_out(tmp_path: Path) -> None:
    model, _ = two_rooms()
    model.product("Gross", "IfcSpace", ((0, 0, 0), (8, 5, 2.5)))
    model.product("A again", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)))
    building = _read(model, tmp_path)
    assert [r.name for r in building.rooms] == ["A", "B", "Exterior"]
    assert _codes(building) == ["room-double", "room-holds-rooms"] and building.openings == []


def test_states_err_to_open_and_can_be_overridden(tmp_path: Path) -> None:
    model, wall = two_rooms()
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4, 2, 0), (4.2, 2.9, 2.1)), door)
    path = model.save(tmp_path)

    def state(rules) -> str:
        return ifc.read_ifc(path, objects=False, door_states=rules).openings[0].state

    assert state(None) == OPEN and state("closed") == CLOSED
    assert state({door.GlobalId: "glass"}) == GLASS and state({"D1": "closed"}) == CLOSED
    assert state(DoorStates(storeys={"Ground": CLOSED})) == CLOSED
    assert state(DoorStates(classes={"IfcDoor": CLOSED}, openings={"D1": OPEN})) == OPEN
    with pytest.raises(ValueError, match="ajar"):
        state({"D1": "ajar"})


def test_a_door_that_is_said_to_be_fixed_and_to_open_stands_open(tmp_path: Path) -> None:
    """One set says a fixed, opaque panel: closed. Any other that contradicts it, of the door or of its type: open."""

    def state(*, swings: bool = False, glazing: tuple[float, ...] = (0.0,)) -> str:
        model, wall = two_rooms()
        f = model.f
        door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
        model.void(wall, ((4, 2, 0), (4.2, 2.9, 2.1)), door)

        def panel(operation: str):
            return f.create_entity("IfcDoorPanelProperties", model.guid(), PanelOperation=operation, PanelPosition="MIDDLE")

        kind = f.create_entity("IfcDoorType", model.guid(), Name="T", HasPropertySets=[panel("FIXEDPANEL")])
        f.create_entity("IfcRelDefinesByType", model.guid(), RelatedObjects=[door], RelatingType=kind)
        f.create_entity(
            "IfcRelAssociatesMaterial", model.guid(), RelatedObjects=[door], RelatingMaterial=f.createIfcMaterial("Oak")
        )
        sets = [panel("SWINGING")] if swings else []
        for fraction in glazing:
            single = f.createIfcPropertySingleValue("GlazingAreaFraction", None, f.createIfcPositiveRatioMeasure(fraction), None)
            sets.append(f.create_entity("IfcPropertySet", model.guid(), Name="Pset", HasProperties=[single]))
        for each in sets:
            f.create_entity(
                "IfcRelDefinesByProperties", model.guid(), RelatedObjects=[door], RelatingPropertyDefinition=each
            )
        return _read(model, tmp_path).openings[0].state

    assert state() == CLOSED
    assert state(swings=True) == OPEN
    assert state(glazing=(0.4, 0.0)) == OPEN and state(glazing=(0.0, 0.4)) == OPEN and state(glazing=()) == OPEN


def test_objects_have_bounds_and_identity(tmp_path: Path) -> None:
    model, _ = two_rooms(unit=0.001)
    chair = model.product("Chair", "IfcFurnishingElement", ((1, 1, 0), (1.5, 1.5, 0.9)))
    building = ifc.read_ifc(model.save(tmp_path))
    assert "IfcFurnishingElement/Chair" in [o.name for o in building.objects]
    thing = next(o for o in building.objects if o.source_id == chair.GlobalId)
    assert np.allclose(thing.bounds, [[1, 1, 0], [1.5, 1.5, 0.9]], atol=1e-6)
    assert not any(o.name.startswith(("IfcSpace", "IfcOpening")) for o in building.objects)


def test_bad_files_are_told_by_name(tmp_path: Path) -> None:
    with pytest.raises(ifc.IfcError, match="no such file"):
        ifc.read_ifc(tmp_path / "absent.ifc")
    junk = tmp_path / "junk.ifc"
    junk.write_bytes(b"\x00\x01 not a model")
    with pytest.raises(ifc.IfcError, match="junk.ifc"):
        ifc.read_ifc(junk)


def test_damaged_files_are_errors_or_problems_never_crashes(tmp_path: Path) -> None:
    model, wall = two_rooms()
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4, 2, 0), (4.2, 2.9, 2.1)), door)
    text = model.save(tmp_path).read_text()
    lines = text.splitlines()
    rows = [n for n, line in enumerate(lines) if line.startswith("#")]
    outcomes = set()
    for n in rows[:: max(1, len(rows) // 60)]:  # each time another line is missing
        path = tmp_path / "damaged.ifc"
        path.write_text("\n".join(lines[:n] + lines[n + 1 :]))
        try:
            outcomes.add(len(ifc.read_ifc(path).rooms))
        except ifc.IfcError as error:
            assert "damaged.ifc" in str(error)
            outcomes.add("error")
    assert 3 in outcomes
    path.write_text(text[: int(0.8 * len(text))].rsplit("\n", 1)[0] + "\n")
    try:
        assert "file-cut-short" in _codes(ifc.read_ifc(path))
    except ifc.IfcError:
        pass  # also an answer


def test_progress_can_cancel(tmp_path: Path) -> None:
    model, _ = two_rooms()
    with pytest.raises(ifc.Cancelled):
        ifc.read_ifc(model.save(tmp_path), progress=lambda fraction, label: False)


def test_shapes_come_in_the_order_they_are_asked_for() -> None:
    """Whatever the order in which the library's threads make them: the same file gives the same building."""
    model = Blocks()
    asked = [model.product(f"Block {k}", "IfcBuildingElementProxy", ((2.0 * k, 0, 0), (2.0 * k + 1, 1, 1 + k % 7))) for k in range(40)]
    for products in (asked, asked[::-1]):
        assert list(ifc_shapes.make(model.f, products, cut=True, offset=np.zeros(3))) == [p.id() for p in products]
