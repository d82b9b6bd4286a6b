# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample house: eight rooms on two storeys, an enfilade from the entrance to the garden, an annotated walk.

Plan by centre lines, metres, y north; the entrance is in the south:

   ground floor                              first floor
   +---------------+-------------+ 8.0       +---------+------+------------+ 8.0
   |  Living   (garden doors)    |           | Bedroom | Bath |  Bedroom   |
   |  dining          | Kitchen  |           | west    +------+ 5.8 east   |
   |         +--------+ 5.0      |           |         |stair |            |
   |         |  Hall  +----------+ 3.6       +---------+      +------------+ 2.4
   |         | stair  |  Study   |           |           Gallery           |
   +---------+--------+----------+ 0         +-----------------------------+ 0
   0        3.9      6.4       10            0        3.9    6.4          10
"""

from __future__ import annotations

import math

import bpy
import furniture as f
from building_kit import FACADE, Kit, Room, Storey
from mesh_kit import MeshBuilder, Vec3
from scene_kit import catmull_rom, look_at, point_light, set_up_scene, sun

FACING = {"N": 0.0, "W": math.pi / 2, "S": math.pi, "E": -math.pi / 2}
WIDTH, DEPTH = 10.0, 8.0
STAIR_X0, STAIR_X1, STAIR_Y0, RISERS, GOING = 3.975, 4.925, 1.0, 16, 0.25
LAWN = -0.17


def build() -> None:
    kit = Kit([Storey("Ground floor", 0.0, 2.6), Storey("First floor", 2.9, 5.4)])
    _rooms(kit)
    _openings(kit)
    for room in kit.rooms:
        kit.build_room(room)
    outline = [(0.0, 0.0), (3.9, 0.0), (6.4, 0.0), (WIDTH, 0.0), (WIDTH, 3.6), (WIDTH, DEPTH), (6.4, DEPTH),
               (3.9, DEPTH), (0.0, DEPTH), (0.0, 3.6)]
    kit.facade(outline, 0, "plinth", -0.40, 0.0, "Plinth")
    kit.facade(outline, 0, "render", 0.0, 2.75)
    kit.facade(outline, 1, "larch", 2.75, 5.55)
    kit.annotate_openings()
    kit.exterior()
    _stair(kit)
    _roof(kit)
    _site(kit)
    _furnish_ground(kit)
    _furnish_first(kit)
    _lights(kit)
    cameras = _cameras(kit)
    kit.finish()
    set_up_scene(cameras[0], frames=300)


def _rooms(kit: Kit) -> None:
    kit.rooms += [
        Room("Living", [(0, 0), (3.9, 0), (3.9, 5.0), (6.4, 5.0), (6.4, 8.0), (0, 8.0)], 0),
        Room("Hall", [(3.9, 0), (6.4, 0), (6.4, 5.0), (3.9, 5.0)], 0, floor="tile_floor"),
        Room("Kitchen", [(6.4, 3.6), (10, 3.6), (10, 8), (6.4, 8)], 0, wall="plaster_white", floor="tile_floor"),
        Room("Study", [(6.4, 0), (10, 0), (10, 3.6), (6.4, 3.6)], 0, wall="plaster_sage"),
        Room("Gallery", [(0, 0), (10, 0), (10, 2.4), (6.4, 2.4), (6.4, 5.8), (3.9, 5.8), (3.9, 2.4), (0, 2.4)], 1,
             wall="plaster_white"),
        Room("Bedroom west", [(0, 2.4), (3.9, 2.4), (3.9, 8), (0, 8)], 1, wall="plaster_blue"),
        Room("Bedroom east", [(6.4, 2.4), (10, 2.4), (10, 8), (6.4, 8)], 1, wall="plaster_clay"),
        Room("Bath", [(3.9, 5.8), (6.4, 5.8), (6.4, 8), (3.9, 8)], 1, wall="tile_wall", floor="tile_floor"),
    ]


def _openings(kit: Kit) -> None:
    door = (0.0, 2.08)
    entrance = kit.wall_opening("Entrance", "door", "closed", 1, 0.0, (5.1, 6.1), (0.0, 2.15), 0, -1)
    garden = kit.wall_opening("Garden doors", "window", "glass", 1, DEPTH, (4.5, 6.1), (0.0, 2.25), 0, 1)
    hall_living = kit.wall_opening("Hall-Living", "door", "open", 1, 5.0, (5.1, 6.1), (0.0, 2.25), 0)
    hall_kitchen = kit.wall_opening("Hall-Kitchen", "door", "open", 0, 6.4, (3.85, 4.75), door, 0)
    hall_study = kit.wall_opening("Hall-Study", "door", "closed", 0, 6.4, (1.3, 2.2), door, 0)
    kit.wall_opening("Living-Kitchen", "hole", "open", 0, 6.4, (5.5, 7.2), (0.0, 2.3), 0)
    bed_west = kit.wall_opening("Gallery-Bedroom west", "door", "open", 1, 2.4, (2.75, 3.65), door, 1)
    bed_east = kit.wall_opening("Gallery-Bedroom east", "door", "open", 0, 6.4, (4.6, 5.5), door, 1)
    bath = kit.wall_opening("Gallery-Bath", "door", "closed", 1, 5.8, (5.3, 6.15), door, 1)
    kit.slab_opening("Stair", (STAIR_X0, 1.7), (STAIR_X1, STAIR_Y0 + GOING * (RISERS - 1)), 0)
    kit.door(entrance, style="frame_dark")
    kit.door(hall_living, leaf=False)
    kit.door(hall_kitchen, hinge="right", angle=86, into=1)
    kit.door(hall_study)
    kit.door(bed_west, hinge="right", angle=78, into=1)
    kit.door(bed_east, hinge="left", angle=64, into=1)
    kit.door(bath, into=1)
    kit.window(garden, 2, sill=False)

    def window(name: str, axis: int, at: float, span: tuple[float, float], heights: tuple[float, float],
               storey: int) -> None:
        outward = 1 if at > 0.0 else -1
        kit.window(kit.wall_opening(name, "window", "glass", axis, at, span, heights, storey, outward))

    window("Living S", 1, 0.0, (1.0, 2.9), (0.45, 2.25), 0)
    window("Living W1", 0, 0.0, (1.9, 3.9), (0.9, 2.25), 0)
    window("Living W2", 0, 0.0, (5.6, 7.2), (0.45, 2.25), 0)
    window("Living N", 1, DEPTH, (0.9, 2.9), (0.45, 2.25), 0)
    window("Hall S", 1, 0.0, (4.15, 4.65), (0.9, 2.15), 0)
    window("Kitchen E", 0, WIDTH, (6.2, 7.7), (1.05, 2.25), 0)
    window("Kitchen N", 1, DEPTH, (7.2, 8.8), (0.45, 2.25), 0)
    window("Study S", 1, 0.0, (7.4, 9.0), (0.75, 2.25), 0)
    window("Study E", 0, WIDTH, (1.1, 2.5), (0.75, 2.25), 0)
    window("Gallery S1", 1, 0.0, (1.0, 2.9), (0.75, 2.15), 1)
    window("Gallery S2", 1, 0.0, (4.4, 6.1), (0.75, 2.15), 1)
    window("Gallery S3", 1, 0.0, (7.4, 9.0), (0.75, 2.15), 1)
    window("Gallery W", 0, 0.0, (0.7, 1.7), (0.75, 2.15), 1)
    window("Gallery E", 0, WIDTH, (0.7, 1.7), (0.75, 2.15), 1)
    window("Bedroom west W", 0, 0.0, (6.1, 7.5), (0.75, 2.15), 1)
    window("Bedroom west N", 1, DEPTH, (1.1, 2.7), (0.45, 2.15), 1)
    window("Bedroom east E", 0, WIDTH, (4.6, 6.2), (0.75, 2.15), 1)
    window("Bedroom east N", 1, DEPTH, (7.4, 9.0), (0.45, 2.15), 1)
    window("Bath N", 1, DEPTH, (4.5, 5.5), (1.2, 2.1), 1)


def _stair(kit: Kit) -> None:
    p = kit.palette
    rise = kit.storeys[1].floor / RISERS
    x0, x1 = STAIR_X0 + 0.005, STAIR_X1
    slope = rise / GOING
    top_y = STAIR_Y0 + GOING * (RISERS - 1)

    def beam(b: MeshBuilder, a0: float, a1: float, y0: float, z0: float, y1: float, z1: float, tall: float, m) -> None:
        """A board with vertical ends that rises from (y0, z0) to (y1, z1)."""
        b.add([(a0, y0, z0), (a1, y0, z0), (a1, y1, z1), (a0, y1, z1),
               (a0, y0, z0 + tall), (a1, y0, z0 + tall), (a1, y1, z1 + tall), (a0, y1, z1 + tall)],
              [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], m)

    def fill(b: MeshBuilder) -> None:
        for i in range(RISERS - 1):
            y, z = STAIR_Y0 + GOING * i, rise * (i + 1)
            b.box((x0 + 0.035, y - 0.02, z - 0.04), (x1 - 0.035, y + GOING, z), p.oak, 0.004)
            b.box((x0 + 0.035, y, z - rise), (x1 - 0.035, y + 0.015, z - 0.04), p.white_paint)
        b.box((x0 + 0.035, top_y - 0.015, kit.storeys[1].floor - rise), (x1 - 0.035, top_y, kit.storeys[1].floor - 0.001),
              p.white_paint)
        for a in (x0, x1 - 0.035):
            beam(b, a, a + 0.035, STAIR_Y0 - 0.02, -0.0, top_y, slope * (top_y - STAIR_Y0 + 0.02), 0.20, p.white_paint)

    where = kit.storey_collection(0, "stair")
    kit.add("Stair", kit.mesh(("stair",), "Stair", fill), where)

    def fill_rail(b: MeshBuilder) -> None:
        x = x1 - 0.018
        b.box((x - 0.03, STAIR_Y0 - 0.08, 0.0), (x + 0.03, STAIR_Y0 - 0.02, 1.12), p.oak, 0.006)
        beam(b, x - 0.022, x + 0.022, STAIR_Y0 - 0.05, 0.98, 4.0, 0.98 + slope * (4.05 - STAIR_Y0), 0.045, p.oak)
        for i in range(24):
            y = STAIR_Y0 + 0.06 + i * 0.125
            z = slope * (y - STAIR_Y0)
            if y < 3.98:
                b.box((x - 0.008, y - 0.008, z + 0.18), (x + 0.008, y + 0.008, z + 1.03), p.black)

    kit.add("Stair handrail", kit.mesh(("stair rail",), "Stair rail", fill_rail), where)

    def fill_guard(b: MeshBuilder) -> None:
        z = kit.storeys[1].floor
        x, y = STAIR_X1 + 0.03, 1.67
        for low, high in (((STAIR_X0 + 0.01, y - 0.022, z + 0.98), (x + 0.022, y + 0.022, z + 1.02)),
                          ((x - 0.022, y + 0.022, z + 0.98), (x + 0.022, top_y, z + 1.02))):
            b.box(low, high, p.oak, 0.006)
        count = 8
        for i in range(count):
            a = STAIR_X0 + 0.06 + (x - STAIR_X0 - 0.08) * i / count
            b.box((a - 0.008, y - 0.008, z), (a + 0.008, y + 0.008, z + 0.98), p.black)
        count = 26
        for i in range(count + 1):
            a = y + (top_y - 0.03 - y) * i / count
            b.box((x - 0.008, a - 0.008, z), (x + 0.008, a + 0.008, z + 0.98), p.black)

    kit.add("Gallery guard", kit.mesh(("guard",), "Guard rail", fill_guard), kit.storey_collection(1, "stair"))


def _roof(kit: Kit) -> None:
    p = kit.palette
    where = kit.collection("Roof")
    base, slope, thick = 5.55, math.tan(math.radians(36)), 0.22
    eave, verge = 0.50, 0.30
    y_mid, half = DEPTH / 2, DEPTH / 2 + FACADE
    ridge = base + slope * half
    a, c = -FACADE - verge, WIDTH + FACADE + verge

    def slab(side: int) -> None:
        def fill(b: MeshBuilder) -> None:
            y_low = y_mid + side * (half + eave)
            z_low = base - slope * eave
            ring = [(y_low, z_low), (y_mid, ridge), (y_mid, ridge + thick), (y_low, z_low + thick)]
            vertices: list[Vec3] = [(x, y, z) for x in (a, c) for y, z in ring]
            faces = [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
            if side < 0:
                faces = [tuple(reversed(face)) for face in faces]
            b.add(vertices, faces, p.roof)
            seam = 0.55  # standing seams of the metal roof
            n = round((c - a) / seam)
            for i in range(n + 1):
                x = min(max(a + (c - a) * i / n, a + 0.012), c - 0.012)
                y1, z1 = y_mid, ridge + thick
                y0, z0 = y_low, z_low + thick
                b.add([(x - 0.012, y0, z0), (x + 0.012, y0, z0), (x + 0.012, y1, z1), (x - 0.012, y1, z1),
                       (x - 0.012, y0, z0 + 0.035), (x + 0.012, y0, z0 + 0.035), (x + 0.012, y1, z1 + 0.035),
                       (x - 0.012, y1, z1 + 0.035)],
                      [q if side < 0 else tuple(reversed(q))
                       for q in ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))],
                      p.roof)

        kit.add(f"Roof {'S' if side < 0 else 'N'}", kit.mesh(("roof", side), "Roof", fill), where)

    slab(-1)
    slab(1)
    for label, x0, x1 in (("W", -FACADE, 0.0), ("E", WIDTH, WIDTH + FACADE)):
        def fill_gable(b: MeshBuilder, x0: float = x0, x1: float = x1) -> None:
            ring = [(y_mid - half, base), (y_mid + half, base), (y_mid, ridge)]
            b.add([(x, y, z) for x in (x0, x1) for y, z in ring],
                  [(2, 1, 0), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)], p.larch)

        kit.add(f"Gable {label}", kit.mesh(("gable", label), "Gable", fill_gable), where)

    def fill_chimney(b: MeshBuilder) -> None:
        b.box((1.9, 5.2, 6.9), (2.5, 5.8, 9.35), p.render)
        b.box((1.85, 5.15, 9.35), (2.55, 5.85, 9.43), p.concrete, 0.01)
        b.box((2.0, 5.3, 9.43), (2.4, 5.7, 9.47), p.black)

    kit.add("Chimney", kit.mesh(("chimney",), "Chimney", fill_chimney), where)

    def fill_gutter(b: MeshBuilder) -> None:
        for side in (-1, 1):
            y = y_mid + side * (half + eave)
            z = base - slope * eave
            y0, y1 = sorted((y, y + side * 0.11))
            b.box((a, y0, z + 0.04), (c, y1, z + 0.15), p.frame_dark, 0.02)
        for x in (-FACADE - 0.05, WIDTH + FACADE + 0.05):
            b.cylinder((x, -FACADE - 0.06, LAWN), 0.04, base - LAWN - 0.02, p.frame_dark, 10)

    kit.add("Gutters", kit.mesh(("gutter",), "Gutters", fill_gutter), where)


def _site(kit: Kit) -> None:
    p = kit.palette
    where = kit.collection("Site")

    def lawn(b: MeshBuilder) -> None:
        b.add([(-40, -40, LAWN), (50, -40, LAWN), (50, 48, LAWN), (-40, 48, LAWN)], [(0, 1, 2, 3)], p.lawn)

    kit.add("Lawn", kit.mesh(("lawn",), "Lawn", lawn), where)

    def paths(b: MeshBuilder) -> None:
        b.box((4.7, -9.0, LAWN), (6.5, -1.15, LAWN + 0.03), p.paving)
        b.box((-9.5, -10.8, LAWN), (21.0, -9.0, LAWN + 0.02), p.gravel)

    kit.add("Path", kit.mesh(("path",), "Path", paths), where)

    def terrace(b: MeshBuilder) -> None:
        b.box((2.4, DEPTH + FACADE, LAWN), (8.6, DEPTH + FACADE + 3.2, -0.03), p.paving, 0.01)

    kit.add("Terrace", kit.mesh(("terrace",), "Terrace", terrace), where)

    def porch(b: MeshBuilder) -> None:
        b.box((4.7, -1.15, LAWN), (6.5, -FACADE, -0.02), p.concrete, 0.01)
        b.box((4.5, -1.35, 2.42), (6.7, -FACADE, 2.54), p.frame_dark, 0.01)
        for x in (4.62, 6.54):
            b.box((x, -1.28, -0.05), (x + 0.07, -1.21, 2.42), p.frame_dark)

    kit.add("Porch", kit.mesh(("porch",), "Porch", porch), where)
    for i, (x, y, height, seed) in enumerate([(-5.5, 10.5, 6.5, 1), (14.5, 11.5, 7.5, 2), (15.5, 1.0, 5.5, 3),
                                              (-8.0, 1.5, 6.0, 1), (4.0, 19.0, 8.0, 2), (10.5, 17.0, 6.0, 3),
                                              (-3.5, -15.0, 6.5, 2), (14.0, -15.5, 7.0, 1), (-13.0, -4.0, 8.0, 3)]):
        kit.add(f"Tree {i}", f.tree(kit, 6.5, seed), where, (x, y, LAWN), i * 1.3).scale = height / 6.5
    for i in range(6):
        kit.add(f"Hedge N{i}", f.hedge(kit, 3.6), where, (-4.6 + i * 3.65, 15.0, LAWN))
    for i in range(4):
        kit.add(f"Hedge E{i}", f.hedge(kit, 3.6), where, (17.2, 0.6 + i * 3.65, LAWN), math.pi / 2)
    kit.add("Terrace table", f.dining_table(kit, 1.9), where, (3.9, 9.9, -0.03))
    for i, (x, y, turn) in enumerate([(3.4, 9.2, "N"), (4.4, 9.2, "N"), (3.4, 10.6, "S"), (4.4, 10.6, "S")]):
        kit.add(f"Terrace chair {i}", f.chair(kit), where, (x, y, -0.03), FACING[turn])
    kit.add("Terrace plant", f.plant(kit, 1.1, 2), where, (8.1, 8.7, -0.03))
    kit.add("Porch plant", f.plant(kit, 0.9, 3), where, (6.3, -0.65, -0.02))
    kit.add("Garden bench", f.bench(kit), where, (-3.2, 4.5, LAWN), FACING["W"])


def _place(kit: Kit, storey: int):
    where = kit.storey_collection(storey, "furniture")
    floor = kit.storeys[storey].floor
    count: dict[str, int] = {}

    def place(mesh: bpy.types.Mesh, x: float, y: float, facing: str | float = "N", z: float = 0.0,
              name: str = "") -> None:
        title = name or mesh.name.split(".")[0].rstrip("0123456789x ")
        count[title] = count.get(title, 0) + 1
        turn = FACING[facing] if isinstance(facing, str) else math.radians(facing)
        kit.add(f"{title} {storey}.{count[title]:02d}", mesh, where, (x, y, floor + z), turn)

    return place


def _furnish_ground(kit: Kit) -> None:
    place = _place(kit, 0)
    # Living: the sitting end in the south, the table in the north, the way from hall to garden free.
    place(f.rug(kit, 2.0, 2.9), 2.0, 2.9)
    place(f.sofa(kit), 0.09, 2.9, "E")
    place(f.coffee_table(kit), 1.95, 2.9, 90, 0.012)
    place(f.armchair(kit), 2.75, 4.35, 145)
    place(f.armchair(kit), 1.35, 1.15, -30)
    place(f.sideboard(kit), 3.815, 2.9, "W")
    place(f.television(kit), 3.815, 2.9, "W")
    place(f.plant(kit, 1.5, 0), 0.5, 0.55)
    place(f.picture(kit, 0.7, 0.9, 0), 0.085, 4.75, "E")
    place(f.dining_table(kit, 2.1), 1.9, 6.45, 90)
    for x, y, turn in ((1.25, 5.85, "E"), (1.25, 6.45, "E"), (1.25, 7.05, "E"), (2.55, 5.85, "W"), (2.55, 6.45, "W"),
                       (2.55, 7.05, "W")):
        place(f.chair(kit), x, y, turn)
    for y in (5.95, 6.95):
        place(f.pendant(kit, 1.0), 1.9, y, z=2.6)
    place(f.bookshelf(kit, 0.9, 2.0, 3), 4.45, 5.085, "N")
    place(f.plant(kit, 1.2, 1), 4.15, 7.55)
    # Hall
    place(f.sideboard(kit, 1.2), 6.315, 2.95, "W")
    place(f.picture(kit, 0.9, 0.6, 1), 6.32, 2.95, "W", 0.05)
    place(f.pendant(kit, 0.6), 5.6, 2.5, z=2.6)
    place(f.rug(kit, 1.0, 2.6), 5.6, 2.4)
    # Kitchen
    place(f.kitchen_run(kit, 1.8, True), 9.915, 5.2, "W")
    place(f.kitchen_run(kit, 1.8, False), 9.915, 7.0, "W")
    place(f.wall_cabinets(kit, 1.8), 9.92, 5.2, "W")
    for x in (8.0, 8.6, 9.2):
        place(f.tall_unit(kit), x, 3.685, "N")
    place(f.island(kit), 8.15, 6.0, 90)
    for y in (5.65, 6.4):
        place(f.pendant(kit, 0.9), 8.15, y, z=2.6)
    for y in (5.6, 6.4):
        place(f.chair(kit), 7.42, y, "E")
    # Study, behind a closed door
    place(f.desk(kit, 1.6, 0.8, True), 9.2, 1.8, "W")
    place(f.office_chair(kit), 8.45, 1.8, "E")
    place(f.monitor(kit), 9.45, 1.8, "W", 0.735)
    place(f.keyboard(kit), 9.05, 1.8, "W", 0.735)
    place(f.desk_lamp(kit), 9.4, 1.2, "W", 0.735)
    for i, x in enumerate((7.2, 8.1, 9.0)):
        place(f.bookshelf(kit, 0.9, 2.2, 4 + i), x, 3.515, "S")
    place(f.armchair(kit), 7.1, 0.75, -40)
    place(f.rug(kit, 2.2, 1.6), 8.1, 1.8)


def _furnish_first(kit: Kit) -> None:
    place = _place(kit, 1)
    # Gallery: books along the inner wall, a place to read in the west, a desk in the east.
    for i, x in enumerate((0.7, 1.6)):
        place(f.bookshelf(kit, 0.9, 2.2, 1 + i), x, 2.315, "S")
    for i, x in enumerate((7.0, 7.9)):
        place(f.bookshelf(kit, 0.9, 2.2, 4 + i), x, 2.315, "S")
    place(f.armchair(kit), 0.65, 1.2, -90)
    place(f.rug(kit, 1.8, 1.4), 1.2, 1.2)
    place(f.desk(kit, 1.4, 0.7, True), 8.2, 0.46, "N")
    place(f.office_chair(kit), 8.2, 0.9, "S")
    place(f.desk_lamp(kit), 8.7, 0.4, "N", 0.735)
    place(f.plant(kit, 1.2, 1), 9.5, 0.5)
    place(f.picture(kit, 0.7, 0.9, 2), 6.315, 3.5, "W")
    place(f.picture(kit, 0.9, 0.6, 1), 9.1, 2.315, "S")
    # Bedroom west
    place(f.bed(kit, 1.8), 0.085, 4.5, "E")
    place(f.nightstand(kit), 0.085, 3.2, "E")
    place(f.nightstand(kit), 0.085, 5.75, "E")
    place(f.rug(kit, 2.2, 3.0), 1.7, 4.5)
    place(f.wardrobe(kit, 2.0), 3.815, 6.6, "W")
    place(f.picture(kit, 0.9, 0.6, 3), 3.82, 4.4, "W")
    place(f.armchair(kit), 0.75, 7.3, 200)
    # Bedroom east
    place(f.bed(kit, 1.4), 8.6, 2.485, "N")
    place(f.nightstand(kit), 7.5, 2.485, "N")
    place(f.nightstand(kit), 9.68, 2.485, "N")
    place(f.wardrobe(kit, 1.6), 6.485, 6.9, "E")
    place(f.desk(kit, 1.4, 0.7), 8.6, 7.5, "S")
    place(f.office_chair(kit), 8.6, 6.9, "N")
    place(f.rug(kit, 2.0, 1.4), 8.4, 5.4)
    # Bath, behind a closed door
    place(f.bathtub(kit), 4.85, 7.915, "S")
    place(f.washbasin(kit), 3.985, 6.55, "E")
    place(f.toilet(kit), 6.315, 7.35, "W")


def _lights(kit: Kit) -> None:
    where = kit.collection("Lights")
    sun("Sun", (52.0, 0.0, 38.0), 3.2, where)
    for name, place, watts in (("Dining", (1.9, 6.45, 1.5), 28), ("Sitting", (2.2, 2.6, 2.3), 30),
                               ("Hall", (5.6, 2.5, 1.9), 25), ("Kitchen", (8.15, 6.0, 1.6), 30),
                               ("Study", (8.2, 1.9, 2.3), 25), ("Gallery", (5.6, 1.2, 4.9), 25),
                               ("Bedroom west", (1.9, 5.0, 4.9), 25), ("Bedroom east", (8.2, 5.2, 4.9), 25),
                               ("Bath", (5.2, 6.8, 4.9), 18)):
        point_light(f"Lamp {name}", place, watts, where)


def _cameras(kit: Kit) -> list[bpy.types.Object]:
    where = kit.collection("Cameras")
    first = kit.storeys[1].floor
    cameras = [look_at("Camera Living", (3.4, 0.3, 1.45), (1.9, 6.0, 1.1), 19, where),
               look_at("Camera Gallery", (9.7, 1.6, first + 1.6), (1.0, 1.0, first + 1.05), 20, where),
               look_at("Camera Garden", (-7.2, -10.4, 1.9), (4.6, 1.8, 2.75), 28, where)]
    walk = look_at("Camera Walk", (5.6, 0.6, 1.6), (5.6, 4.0, 1.6), 21, where)
    stair_top = STAIR_Y0 + GOING * (RISERS - 1)
    ground: list[Vec3] = [(5.6, 0.5, 0), (5.6, 2.4, 0), (5.6, 4.2, 0), (5.55, 5.5, 0), (4.8, 6.2, 0), (3.5, 5.4, 0),
                          (3.15, 4.0, 0), (3.1, 2.4, 0), (2.95, 1.3, 0), (2.6, 1.05, 0), (2.75, 1.9, 0), (3.1, 3.4, 0),
                          (3.4, 4.9, 0), (4.4, 5.9, 0), (5.4, 5.8, 0), (5.6, 4.6, 0), (5.55, 2.6, 0), (5.35, 1.1, 0),
                          (4.75, 0.5, 0), (4.45, 0.9, 0.05)]
    flight: list[Vec3] = [(4.45, 1.6, 0.6), (4.45, 3.0, 1.62), (4.45, 4.4, 2.62), (4.5, stair_top + 0.2, first)]
    upper: list[Vec3] = [(5.0, 5.3, first), (5.6, 4.7, first), (5.65, 3.2, first), (5.4, 1.7, first),
                         (4.4, 1.2, first), (3.5, 1.5, first), (3.2, 2.2, first), (3.1, 3.1, first), (2.6, 3.4, first),
                         (2.3, 3.45, first)]
    path = catmull_rom([(x, y, z + 1.6) for x, y, z in ground + flight + upper])
    path.animate(walk, frames=300, every=5, ahead=1.3)
    return [*cameras, walk]
