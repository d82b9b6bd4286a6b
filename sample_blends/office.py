# SPDX-License-Identifier: GPL-3.0-or-later
"""The parametric office: a comb of double-loaded wings with courtyards between, a spine with stair cores, any size.

   +----+--+--------------------------------+
   |    |  | office | office | office | ... |        one storey, two wings;
   |core|s |--------------------------------|        y north, x east
   |    |p | corridor of wing 1             |
   |    |i |--------------------------------|
   |meet|n | office | office | office | ... |
   |    |e +--------------------------------+
   |    |  |   courtyard (outside)
   |core|  +--------------------------------+
   |    |  | office ...                     |
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

import bpy
import furniture as f
from building_kit import FACADE, HALF_WALL, Kit, Opening, Point, Room, Storey, offset_polygon
from mesh_kit import MeshBuilder, Vec3
from scene_kit import catmull_rom, look_at, set_up_scene, sun

DEPTH = 5.0  # of a room, between centre lines, metres
CORRIDOR = 2.1
SPINE = 2.4
COURT = 9.0
BAY = 3.6  # mean width of an office
CLEAR, SLAB = 2.8, 0.4
STAIR_LENGTH, STAIR_WIDTH = 3.6, 2.4
RISERS = 20
WING = 2 * DEPTH + CORRIDOR
MIN_ROOMS = 8


@dataclass
class Bay:
    """A room in a row: its place along the row and what it is for."""

    low: float
    high: float
    use: str  # "office", "single", "meeting", "core", "service"


@dataclass
class Plan:
    """One storey; all storeys are alike, so their walls share meshes."""

    wings: int
    spine: list[Bay]
    rows: list[tuple[list[Bay], list[Bay]]]  # per wing: south row, north row

    @property
    def length(self) -> float:
        """Of a wing, metres."""
        return self.rows[0][0][-1].high - SPINE

    @property
    def height(self) -> float:
        """Of the spine, metres along y."""
        return self.wings * WING + (self.wings - 1) * COURT

    def wing_y(self, wing: int) -> float:
        return wing * (WING + COURT)


def make_plan(rooms: int, seed: int) -> Plan:
    """A storey with exactly `rooms` rooms: the spine's corridor, one corridor a wing, offices, and the spine's rooms."""
    if rooms < MIN_ROOMS:
        raise SystemExit(f"office: at least {MIN_ROOMS} rooms per storey are needed, not {rooms}")
    rng = random.Random(seed)
    wings = max(1, round(math.sqrt(rooms) / 3.0))
    per_row = max(1, (rooms - 1 - wings - 3) // (2 * wings))
    at_spine = rooms - 1 - wings - 2 * wings * per_row
    rows = []
    for _ in range(wings):
        pair = []
        for _ in range(2):
            widths = [BAY] * per_row
            for i in range(0, per_row - 1, 2):
                shift = rng.choice([-0.6, 0.0, 0.6])
                widths[i] += shift
                widths[i + 1] -= shift
            x, bays = SPINE, []
            for width in widths:
                use = "single" if width < 3.5 else "meeting" if width > 4.0 and rng.random() < 0.6 else "office"
                bays.append(Bay(round(x, 3), round(x + width, 3), use))
                x += width
            pair.append(bays)
        rows.append((pair[0], pair[1]))
    height = wings * WING + (wings - 1) * COURT
    cores = 2 if at_spine >= 4 else 1
    lengths = [height / at_spine] * at_spine
    uses = ["meeting" if i % 3 == 1 else "office" if i % 3 == 2 else "service" for i in range(at_spine)]
    for i in {0, at_spine - 1} if cores == 2 else {0}:
        uses[i] = "core"
    y, spine = 0.0, []
    for length, use in zip(lengths, uses, strict=True):
        spine.append(Bay(round(y, 3), round(y + length, 3), use))
        y += length
    return Plan(wings, spine, rows)


def build(storeys: int, rooms_per_storey: int, seed: int) -> None:
    if storeys < 1:
        raise SystemExit(f"office: at least one storey is needed, not {storeys}")
    plan = make_plan(rooms_per_storey, seed)
    levels = [Storey("Ground floor" if i == 0 else f"Floor {i}", i * (CLEAR + SLAB), i * (CLEAR + SLAB) + CLEAR, SLAB)
              for i in range(storeys)]
    kit = Kit(levels)
    rng = random.Random(seed + 1)
    doors: list[tuple[Opening, dict]] = []
    windows: list[tuple[Opening, int]] = []
    furnish: list[tuple[int, str, Vec3, float, float]] = []
    for storey in range(storeys):
        _storey(kit, plan, storey, storeys, rng, doors, windows, furnish)
    for room in kit.rooms:
        kit.build_room(room)
    for opening, how in doors:
        kit.door(opening, **how)
    for opening, lights in windows:
        kit.window(opening, lights)
    outline = _outline(plan)
    for storey, level in enumerate(levels):
        low = -0.5 if storey == 0 else level.floor - SLAB / 2
        kit.facade(outline, storey, "render" if storey else "concrete", low, level.ceiling + SLAB / 2)
    kit.annotate_openings()
    kit.exterior()
    _stairs(kit, plan)
    _roof(kit, plan)
    _site(kit, plan, seed)
    _furnish(kit, furnish, rng)
    sun("Sun", (50.0, 0.0, 32.0), 3.0, kit.collection("Lights"))
    cameras = _cameras(kit, plan)
    kit.finish()
    set_up_scene(cameras[0], frames=240, ambient=0.24)


# ---- plan to rooms and openings --------------------------------------------------------------------------------------
def _storey(kit: Kit, plan: Plan, storey: int, storeys: int, rng: random.Random, doors: list, windows: list,
            furnish: list) -> None:
    mark = f"{storey}"
    top, east = plan.height, SPINE + plan.length
    door, glazing = (0.0, 2.1), (0.85, 2.6)
    kit.rooms.append(Room(f"{mark}.Spine", [(0, 0), (SPINE, 0), (SPINE, top), (0, top)], storey, floor="carpet"))
    kit_door = kit.wall_opening

    def room_door(name: str, axis: int, at: float, middle: float, into: int, shut: float) -> None:
        closed = rng.random() < shut
        made = kit_door(name, "door", "closed" if closed else "open", axis, at, (middle - 0.45, middle + 0.45), door, storey)
        angle = 0.0 if closed else rng.choice([60.0, 75.0, 85.0, 90.0])
        doors.append((made, {"hinge": rng.choice(["left", "right"]), "angle": angle, "into": into, "style": "oak"}))

    def glass(name: str, axis: int, at: float, low: float, high: float, outward: int,
              heights: tuple[float, float] = glazing) -> None:
        windows.append((kit_door(name, "window", "glass", axis, at, (low, high), heights, storey, outward), 0))

    # Both ends of the spine: the entrance below, windows above.
    if storey == 0:
        made = kit_door("0.Entrance", "door", "glass", 1, 0.0, (0.4, 2.0), (0.0, 2.4), 0, -1)
        windows.append((made, 2))
    else:
        glass(f"{mark}.Spine S", 1, 0.0, 0.4, 2.0, -1)
    glass(f"{mark}.Spine N", 1, top, 0.4, 2.0, 1)
    for wing in range(plan.wings - 1):  # the spine looks into the courtyards
        for i in range(3):
            middle = plan.wing_y(wing) + WING + COURT * (i + 0.5) / 3
            glass(f"{mark}.Spine E{wing}{i}", 0, SPINE, middle - 1.1, middle + 1.1, 1, (0.45, 2.6))
    panels = max(2, round(top / 5.0))
    for i in range(panels):
        furnish.append((storey, "panel", (SPINE / 2, top * (i + 0.5) / panels, 0.0), 0.0, 90.0))
    for i, bay in enumerate(plan.spine):
        name = f"{mark}.{'Core' if bay.use == 'core' else 'West'} {i:02d}"
        kit.rooms.append(Room(name, [(-DEPTH, bay.low), (0, bay.low), (0, bay.high), (-DEPTH, bay.high)], storey,
                              wall="plaster_white", floor="tile_floor" if bay.use in ("core", "service") else "oak_floor"))
        middle = (bay.low + bay.high) / 2
        if bay.use == "core":
            half = STAIR_WIDTH / 2
            room_door(f"{name} door", 0, 0.0, middle, -1, 0.3)
            if storey + 1 < storeys:
                kit.slab_opening(f"{name} stair", (-DEPTH + HALF_WALL, middle - half),
                                 (-DEPTH + HALF_WALL + STAIR_LENGTH, middle + half), storey)
        else:
            room_door(f"{name} door", 0, 0.0, bay.low + 0.9, -1, 0.4)
            furnish.append((storey, bay.use, (-HALF_WALL, bay.low + HALF_WALL, 0.0), bay.high - bay.low - 0.15, 90.0))
        glass(f"{name} W", 0, -DEPTH, middle - 0.9, middle + 0.9, -1)
    for wing, (south, north) in enumerate(plan.rows):
        y0 = plan.wing_y(wing)
        c0, c1 = y0 + DEPTH, y0 + DEPTH + CORRIDOR
        label = f"{mark}.{chr(65 + wing % 26)}"
        kit.rooms.append(Room(f"{label} corridor", [(SPINE, c0), (east, c0), (east, c1), (SPINE, c1)], storey,
                              wall="plaster_white", floor="carpet"))
        kit_door(f"{label} corridor mouth", "hole", "open", 0, SPINE, (c0 + 0.2, c1 - 0.2), (0.0, 2.5), storey)
        panels = max(2, round(plan.length / 5.0))
        for i in range(panels):
            furnish.append((storey, "panel", (SPINE + plan.length * (i + 0.5) / panels, (c0 + c1) / 2, 0.0), 0.0, 0.0))
        glass(f"{label} corridor E", 0, east, c0 + 0.35, c1 - 0.35, 1)
        for row, (bays, wall, facade_y, into) in enumerate(((south, c0, y0, -1), (north, c1, y0 + WING, 1))):
            for i, bay in enumerate(bays):
                number = f"{label}{2 * i + row + 1:02d}"
                low_y, high_y = sorted((wall, facade_y))
                kit.rooms.append(Room(number, [(bay.low, low_y), (bay.high, low_y), (bay.high, high_y), (bay.low, high_y)],
                                      storey, wall=("plaster", "plaster_white", "plaster_sage")[i % 3],
                                      floor="oak_floor" if bay.use == "meeting" else "carpet"))
                from_west = bay.low + 0.9 if row == 1 else bay.high - 0.9
                room_door(f"{number} door", 1, wall, from_west, into, 0.35)
                if bay.use == "meeting":  # meeting rooms show themselves to the corridor
                    a, b = (bay.low + 1.7, bay.high - 0.4) if row == 1 else (bay.low + 0.4, bay.high - 1.7)
                    glass(f"{number} screen", 1, wall, a, b, 0, (0.9, 2.1))
                glass(f"{number} window", 1, facade_y, bay.low + 0.6, bay.high - 0.6, into)
                # Furniture is laid out with u along the corridor's wall and v into the room.
                origin = (bay.low + HALF_WALL, wall + HALF_WALL, 0.0) if row else (bay.high - HALF_WALL, wall - HALF_WALL, 0.0)
                furnish.append((storey, bay.use, origin, bay.high - bay.low - 0.15, 0.0 if row else 180.0))


def _outline(plan: Plan) -> list[Point]:
    """The comb, counter-clockwise, with a corner wherever a room ends: one piece of facade per room."""
    east, top = SPINE + plan.length, plan.height
    points: list[Point] = [(-DEPTH, 0.0), (0.0, 0.0), (SPINE, 0.0)]
    for wing, (south, north) in enumerate(plan.rows):
        y0 = plan.wing_y(wing)
        if wing:
            points.append((SPINE, y0))
        points += [(bay.high, y0) for bay in south[:-1]]
        points += [(east, y0), (east, y0 + DEPTH), (east, y0 + DEPTH + CORRIDOR), (east, y0 + WING)]
        points += [(bay.low, y0 + WING) for bay in reversed(north[1:])]
        points.append((SPINE, y0 + WING))
    points += [(0.0, top), (-DEPTH, top)]
    points += [(-DEPTH, bay.low) for bay in reversed(plan.spine[1:])]
    return points


def _corners(points: list[Point]) -> list[Point]:
    """The outline without corners in a straight line."""
    n = len(points)
    return [p for i, p in enumerate(points)
            if not ((points[i - 1][0] == p[0] == points[(i + 1) % n][0])
                    or (points[i - 1][1] == p[1] == points[(i + 1) % n][1]))]


# ---- what is built once ------------------------------------------------------------------------------------------------
def _stairs(kit: Kit, plan: Plan) -> None:
    p = kit.palette
    rise, going, landing = (CLEAR + SLAB) / RISERS, 0.28, 1.08

    def fill(b: MeshBuilder) -> None:
        """Origin: the west wall at the middle of the core. Up westwards on the south side, back on the north side."""
        half = STAIR_WIDTH / 2
        steps = RISERS // 2
        x = STAIR_LENGTH - 0.02
        for i in range(steps - 1):
            z = rise * (i + 1)
            b.box((x - going * (i + 1), -half + 0.02, max(0.0, z - 0.28)), (x - going * i, -0.06, z), p.concrete)
        z = rise * steps
        b.box((0.02, -half + 0.02, z - 0.18), (landing, half - 0.02, z), p.concrete)
        for i in range(steps - 1):
            z = rise * (steps + i + 1)
            b.box((landing + going * i, 0.06, z - 0.28), (landing + going * (i + 1), half - 0.02, z), p.concrete)
        for side, from_x, to_x, z0, z1 in ((-0.05, x, landing, 0.0, rise * steps),
                                           (0.05, landing, x, rise * steps, rise * RISERS)):
            for z, tall in ((0.98, 0.05), (0.12, 0.03)):
                y0, y1 = side - 0.015, side + 0.015
                b.add([(from_x, y0, z0 + z), (to_x, y0, z1 + z), (to_x, y1, z1 + z), (from_x, y1, z0 + z),
                       (from_x, y0, z0 + z + tall), (to_x, y0, z1 + z + tall), (to_x, y1, z1 + z + tall),
                       (from_x, y1, z0 + z + tall)],
                      [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], p.steel)

    for storey in range(len(kit.storeys) - 1):
        for i, bay in enumerate(plan.spine):
            if bay.use == "core":
                kit.add(f"Stair {storey}.{i:02d}", kit.mesh(("office stair",), "Stair", fill),
                        kit.storey_collection(storey, "stairs"),
                        (-DEPTH + HALF_WALL, (bay.low + bay.high) / 2, kit.storeys[storey].floor))


def _roof(kit: Kit, plan: Plan) -> None:
    p = kit.palette
    where = kit.collection("Roof")
    base = kit.storeys[-1].ceiling + SLAB / 2
    outline = _corners(_outline(plan))
    kit.slab_piece("Roof", offset_polygon(outline, FACADE - 0.15), base, base + 0.25, "gravel", where)
    # The parapet stands on the facade.
    last = len(kit.storeys) - 1
    kit.facade(outline, last, "render", base, base + 0.7, "Parapet")
    for i, y in enumerate((plan.height * 0.3, plan.height * 0.7)):
        kit.add(f"Air handler {i}", kit.mesh(("air handler",), "Air handler", lambda b: (
            b.box((-1.2, -2.0, 0.0), (1.2, 2.0, 1.5), p.steel, 0.03))), where, (-DEPTH / 2, y, base + 0.25))


def _site(kit: Kit, plan: Plan, seed: int) -> None:
    p = kit.palette
    where = kit.collection("Site")
    rng = random.Random(seed + 2)
    x1, y1 = SPINE + plan.length + 40.0, plan.height + 40.0

    def lawn(b: MeshBuilder) -> None:
        b.add([(-50, -45, -0.1), (x1, -45, -0.1), (x1, y1, -0.1), (-50, y1, -0.1)], [(0, 1, 2, 3)], p.lawn)

    kit.add("Lawn", kit.mesh(("lawn",), "Lawn", lawn), where)

    def path(b: MeshBuilder) -> None:
        b.box((-0.6, -30.0, -0.1), (SPINE + 0.6, -FACADE, -0.02), p.paving)

    kit.add("Path", kit.mesh(("path",), "Path", path), where)
    places = [(SPINE + 6 + 11.0 * i, plan.wing_y(w) + WING + COURT / 2)
              for w in range(plan.wings - 1) for i in range(max(1, int(plan.length // 11)))]
    places += [(-14.0 - 3 * rng.random(), 4 + 11.0 * i) for i in range(max(1, int(plan.height // 11)))]
    places += [(8.0 + 12.0 * i, -10.0 - 4 * rng.random()) for i in range(max(1, int(plan.length // 12)))]
    for i, (x, y) in enumerate(places):
        size = rng.uniform(0.8, 1.2)
        kit.add(f"Tree {i}", f.tree(kit, 6.5, 1 + i % 3), where, (x, y, -0.1), rng.uniform(0, 6)).scale = size
    for w in range(plan.wings - 1):
        for i in range(2):
            kit.add(f"Court bench {w}.{i}", f.bench(kit), where,
                    (SPINE + 5.0 + 6.0 * i, plan.wing_y(w) + WING + 2.5, -0.1))


# ---- furniture -----------------------------------------------------------------------------------------------------------
def _furnish(kit: Kit, rooms: list[tuple[int, str, Vec3, float, float]], rng: random.Random) -> None:
    depth = DEPTH - 2 * HALF_WALL
    count = 0

    for number, (storey, use, origin, width, turn) in enumerate(rooms):
        where = kit.storey_collection(storey, "furniture")
        floor = kit.storeys[storey].floor
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        serial = 0

        def place(mesh: bpy.types.Mesh, u: float, v: float, facing: float = 0.0, z: float = 0.0, *, where=where,
                  floor=floor, c=c, s=s, origin=origin, turn=turn, number=number) -> None:
            nonlocal serial, count
            serial += 1
            count += 1
            title = mesh.name.split(".")[0].rstrip("0123456789x ")
            kit.add(f"{title} {number:04d}-{serial:02d}", mesh, where,
                    (origin[0] + c * u - s * v, origin[1] + s * u + c * v, floor + z), math.radians(turn + facing))

        if use == "panel":
            place(f.ceiling_panel(kit), 0.0, 0.0, 0, CLEAR)
            continue
        for v in (1.5, 3.5):
            place(f.ceiling_panel(kit), width / 2, v, 0, CLEAR)
        if use == "meeting":
            length = min(2.8, width - 1.6)
            middle = (width / 2 + 0.1, 2.8)
            place(f.meeting_table(kit, round(length, 1)), *middle)
            n = 3 if length > 2.2 else 2
            for i in range(n):
                u = middle[0] + length * ((i + 0.5) / n - 0.5)
                place(f.chair(kit), u, middle[1] - 0.75, rng.uniform(-8, 8))
                place(f.chair(kit), u, middle[1] + 0.75, 180 + rng.uniform(-8, 8))
            place(f.whiteboard(kit), width - 0.01, 2.6, 90)
            place(f.plant(kit, 1.4, number % 2), 0.4, depth - 0.45)
        elif use == "service":
            place(f.kitchen_run(kit, 1.8, False), 0.01, 2.6, -90)
            place(f.tall_unit(kit), 0.01, 4.0, -90)
            place(f.dining_table(kit, 1.6), width - 1.3, 2.6, 90)
            for v in (2.1, 3.1):
                place(f.chair(kit), width - 0.6, v, 90)
                place(f.chair(kit), width - 2.0, v, -90)
        else:
            seats = [(width - 0.42, 1.75, 90.0)] if use == "single" else [(width - 0.42, 3.6, 90.0), (0.42, 3.6, -90.0)]
            for u, v, facing in seats:
                inwards = -1.0 if facing > 0 else 1.0
                place(f.desk(kit, 1.6, 0.8), u, v, facing)
                place(f.office_chair(kit), u + inwards * (0.75 + rng.uniform(0, 0.25)), v + rng.uniform(-0.2, 0.2),
                      facing + 180 + rng.uniform(-35, 35))
                place(f.monitor(kit), u - inwards * 0.2, v, facing, 0.735)
                place(f.keyboard(kit), u + inwards * 0.18, v, facing, 0.735)
            place(f.cabinet(kit), width - 0.5 if use != "single" else 0.6, depth - 0.01 if use == "single" else 0.01,
                  180 if use == "single" else 0)
            if number % 2:
                place(f.bookshelf(kit, 0.9, 2.0, 1 + number % 4), width - 0.01, 1.2 if use != "single" else 3.6, 90)
            if number % 3 == 0:
                place(f.plant(kit, 1.2, number % 2), 0.4, depth - 0.4)
            if number % 3 == 1:
                place(f.waste_bin(kit), width - 0.25, 2.6 if use != "single" else 0.7)


# ---- cameras ---------------------------------------------------------------------------------------------------------------
def _cameras(kit: Kit, plan: Plan) -> list[bpy.types.Object]:
    where = kit.collection("Cameras")
    east, middle = SPINE + plan.length, len(kit.storeys) // 2
    z = kit.storeys[middle].floor
    wing = plan.wings // 2
    c = plan.wing_y(wing) + DEPTH + CORRIDOR / 2
    # An office whose door stands open, so that there is something to look out to.
    ajar = {o.name for o in kit.openings if o.state == "open"}
    row = plan.rows[wing][1]
    number = f"{middle}.{chr(65 + wing % 26)}"
    bay = next((b for i, b in enumerate(row) if b.use == "office" and f"{number}{2 * i + 2:02d} door" in ajar), row[0])
    y = plan.wing_y(wing) + DEPTH + CORRIDOR
    cameras = [
        look_at("Camera Office", ((bay.low + bay.high) / 2, y + DEPTH - 0.3, z + 1.6), (bay.low + 1.3, y, z + 0.95), 17, where),
        look_at("Camera Corridor", (SPINE + 0.6, c - 0.2, z + 1.6), (east, c, z + 1.3), 20, where),
        look_at("Camera Spine", (SPINE / 2, 0.6, 1.6), (SPINE / 2 + 0.2, plan.height, 1.2), 20, where),
        look_at("Camera Court", (east + 10.0, -14.0, 2.2), (SPINE + plan.length * 0.4, 4.0, 1.8 + z * 0.6), 24, where)]
    walk = look_at("Camera Walk", (SPINE / 2, 0.8, z + 1.6), (SPINE / 2, 9.0, z + 1.6), 20, where)
    door_x = bay.low + 0.9
    path = catmull_rom([(x, y_, z + 1.6) for x, y_ in (
        (SPINE / 2, 0.8), (SPINE / 2, c * 0.5), (SPINE / 2, max(c - 1.5, c * 0.75)), (SPINE + 0.6, c),
        (max(door_x - 2.0, SPINE + 1.2), c), (door_x + 0.1, c + 0.3), (door_x, y + 0.2), (door_x + 0.1, y + 1.2),
        ((bay.low + bay.high) / 2, y + 2.4))])
    path.animate(walk, frames=240, every=5, ahead=1.2)
    return [*cameras, walk]
