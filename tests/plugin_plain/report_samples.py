# SPDX-License-Identifier: GPL-3.0-or-later
"""Analyses made by hand for the report's tests: a small house, an office of any size, nothing at all."""

from __future__ import annotations

import math

import numpy as np
from enfilade.rules import building as b
from enfilade.rules.results import Analysis, Cells, RoomMatrix, Sightline, View

NONE = 0xFFFFFFFF


def box(x0, y0, z0, x1, y1, z1) -> np.ndarray:
    return np.array([(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)], dtype=np.float64)


def side(corners: np.ndarray, axis: int, high: bool) -> np.ndarray:
    """One face of a box as a polygon (4, 3)."""
    low, top = corners.min(axis=0), corners.max(axis=0)
    u, v = (k for k in range(3) if k != axis)
    ring = []
    for p, q in ((low[u], low[v]), (top[u], low[v]), (top[u], top[v]), (low[u], top[v])):
        point = np.zeros(3)
        point[axis], point[u], point[v] = (top if high else low)[axis], p, q
        ring.append(point)
    return np.array(ring)


class Maker:
    """Rooms as boxes, openings as boxes in the walls between."""

    def __init__(self, source: str = "annotated"):
        self.building = b.Building(source)
        self.cells: list[tuple[int, int, np.ndarray]] = []
        self.portals: list[tuple[int, int, np.ndarray, int]] = []
        self.of_room: dict[int, list[int]] = {}

    def room(self, name, *boxes, storey="", kind=b.INTERIOR, long_name="") -> int:
        self.building.rooms.append(b.Room(name, kind, storey, f"id-{len(self.building.rooms)}", long_name=long_name))
        index = len(self.building.rooms) - 1
        self.of_room[index] = []
        for shape in boxes:
            self.of_room[index].append(len(self.cells))
            self.cells.append((index, NONE, box(*shape) if shape else np.zeros((0, 3))))
        return index

    def seam(self, cell_a, cell_b, polygon) -> None:
        self.portals.append((cell_a, cell_b, np.asarray(polygon, dtype=np.float64), NONE))

    def opening(self, name, kind, state, shape, axis, low_room, high_room) -> int:
        body = box(*shape)
        ends = (side(body, axis, False), side(body, axis, True))
        self.building.openings.append(b.Opening(name, kind, state, f"o-{name}", (low_room, high_room), body, ends))
        index = len(self.building.openings) - 1
        cell = len(self.cells)
        self.cells.append((NONE, index, body))
        for room, end in ((low_room, ends[0]), (high_room, ends[1])):
            middle = end.mean(axis=0)
            near = min(self.of_room[room], key=lambda c: self._distance(c, middle))
            self.portals.append((near, cell, end, index))
        return index

    def _distance(self, cell, point) -> float:
        corners = self.cells[cell][2]
        if not len(corners):
            return 1e9
        return float(np.linalg.norm(np.maximum(np.maximum(corners.min(axis=0) - point, point - corners.max(axis=0)), 0)))

    def analysis(self, **more) -> Analysis:
        cells = Cells(
            np.array([c[0] for c in self.cells], dtype=np.uint32), np.array([c[1] for c in self.cells], dtype=np.uint32),
            [c[2] for c in self.cells], [p[2] for p in self.portals],
            np.array([p[:2] for p in self.portals], dtype=np.uint32).reshape(-1, 2),
            np.array([p[3] for p in self.portals], dtype=np.uint32))
        return Analysis(self.building, cells, **more)


def camera(name, x, y, z, degrees, field=70.0, kind="PERSP") -> b.Camera:
    t = math.radians(degrees)
    look, up = np.array([math.cos(t), math.sin(t), 0.0]), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = np.cross(look, up), up, -look, (x, y, z)
    return b.Camera(name, matrix, kind, math.radians(field), math.radians(field * 0.6))


def house(walk: int = 0) -> Analysis:
    """8 rooms on two storeys, an L-shaped one, doors, windows, a stair hole, outdoors, 3 cameras."""
    m = Maker()
    g, u = "Ground floor", "Upper floor"
    m.building.storeys = [(g, 0.0), (u, 2.9)]
    living = m.room("Living", (0, 0, 0, 5, 4, 2.6), (0, 4, 0, 3, 7, 2.6), storey=g)
    m.seam(0, 1, [(0, 4, 0), (3, 4, 0), (3, 4, 2.6), (0, 4, 2.6)])
    kitchen = m.room("Kitchen", (3.2, 4.2, 0, 5, 7, 2.6), storey=g)
    hall = m.room("Hall", (5.2, 0, 0, 7.2, 7, 2.6), storey=g)
    study = m.room("Study", (7.4, 0, 0, 10, 3.4, 2.6), storey=g)
    wc = m.room("WC", (7.4, 3.6, 0, 10, 7, 2.6), storey=g)
    landing = m.room("Landing", (5.2, 0, 2.9, 7.2, 7, 5.4), storey=u)
    bedroom = m.room("Bedroom", (0, 0, 2.9, 5, 7, 5.4), storey=u)
    bath = m.room("Bathroom", (7.4, 0, 2.9, 10, 7, 5.4), storey=u)
    outside = m.room("Outdoors", (), kind=b.EXTERIOR)
    door, window, hole = b.DOOR, b.WINDOW, b.HOLE
    d1 = m.opening("D1", door, b.OPEN, (5, 1, 0, 5.2, 1.9, 2.1), 0, living, hall)
    d2 = m.opening("D2", door, b.OPEN, (3, 5, 0, 3.2, 5.9, 2.1), 0, living, kitchen)
    d3 = m.opening("D3", door, b.OPEN, (7.2, 1.1, 0, 7.4, 2.0, 2.1), 0, hall, study)
    m.opening("D4", door, b.CLOSED, (7.2, 4.4, 0, 7.4, 5.3, 2.1), 0, hall, wc)
    m.opening("D5", door, b.CLOSED, (5.8, -0.36, 0, 6.8, 0, 2.1), 1, outside, hall)
    d6 = m.opening("D6", door, b.OPEN, (5, 3, 2.9, 5.2, 3.9, 5.0), 0, bedroom, landing)
    m.opening("D7", door, b.OPEN, (7.2, 3, 2.9, 7.4, 3.9, 5.0), 0, landing, bath)
    w1 = m.opening("W1", window, b.GLASS, (1.2, -0.36, 0.9, 3.0, 0, 2.2), 1, outside, living)
    m.opening("W2", window, b.GLASS, (3.6, 7, 0.9, 4.6, 7.36, 2.2), 1, kitchen, outside)
    w3 = m.opening("W3", window, b.GLASS, (10, 1, 0.9, 10.36, 2.6, 2.2), 0, study, outside)
    w4 = m.opening("W4", window, b.GLASS, (-0.36, 2, 3.8, 0, 4, 5.1), 0, outside, bedroom)
    m.opening("W5", window, b.GLASS, (8.4, 7, 4.6, 9.2, 7.36, 5.1), 1, bath, outside)
    stair = m.opening("Stair", hole, b.OPEN, (5.4, 4.5, 2.6, 6.6, 6.8, 2.9), 2, hall, landing)
    for i in range(12):
        room = i % 8
        corner = m.cells[m.of_room[room][0]][2].min(axis=0) + 0.4
        m.building.objects.append(b.Object(f"Chair.{i:03d}", np.array([corner, corner + 0.5]), mesh="Chair", rooms=[room]))
    m.building.lights.append(b.Light("Lamp", np.array([2.0, 2.0, 2.4])))
    m.building.problems.append(b.Problem(b.WARNING, "opening-one-room", "Opening W9 leads to one room only: Study.", ["W9"],
                                         (10.0, 2.0, 1.0), "Draw the room behind it, or mark the opening as leading outdoors."))

    def view(cam, cell, frame, rooms, objects, room_why, why) -> View:
        m.building.cameras.append(cam)
        ways = {o for way in (*why.values(), *room_why.values()) for o in way}
        return View(cam, frame, "clip", [cell], [], sorted(rooms), sorted(objects), why, room_why, 2.4, {"clips": 31}, sorted(ways))

    views = [
        view(camera("Cam living", 0.6, 1.5, 1.6, 0), 0, 1, [living, hall, study, outside], [0, 8, 2, 3],
             {living: [], hall: [d1], study: [d1, d3], outside: [d1, d3, w3]}, {0: [], 8: [], 2: [d1], 3: [d1, d3]}),
        view(camera("Cam hall", 6.2, 0.6, 1.6, 90, 60), m.of_room[hall][0], 1, [hall, landing, living], [2, 5, 10],
             {hall: [], landing: [stair], living: [d1]}, {2: [], 10: [], 5: [stair]}),
        view(camera("Cam bed", 4.5, 3.4, 4.5, 175, 80), m.of_room[bedroom][0], 1, [bedroom, outside], [6],
             {bedroom: [], outside: [w4]}, {6: []}),
    ]
    for f in range(walk):
        views.append(View(camera("Walk", 1 + f * 3.2 / walk, 1.5, 1.6, f * 100 / walk), f + 1, "clip", [0], [],
                          [living, hall], [0, 2, 8], {0: [], 8: [], 2: [d1]}, {living: [], hall: [d1]}, 2.0 + f % 3))
    n = len(m.building.rooms)
    visible, grazing = np.eye(n, dtype=bool), np.zeros((n, n), dtype=bool)
    pairs = [(living, hall), (living, kitchen), (living, study), (hall, study), (hall, landing), (bedroom, landing),
             (landing, bath), (bedroom, bath), (living, outside), (kitchen, outside), (study, outside), (bedroom, outside),
             (bath, outside), (hall, outside), (living, landing)]
    for i, j in pairs:
        visible[i, j] = visible[j, i] = True
    grazing[living, landing] = grazing[landing, living] = True
    proven = visible.copy()
    proven[hall, outside] = proven[outside, hall] = False
    matrix = RoomMatrix("exact", visible, proven, [
        Sightline((living, hall), (1, 1.5, 1.2), (6, 1.4, 1.2), [d1]),
        Sightline((living, study), (1, 1.5, 1.2), (9, 1.6, 1.2), [d1, d3]),
        Sightline((hall, landing), (6, 3, 1.0), (6, 6.5, 4.0), [stair]),
        Sightline((bedroom, landing), (2, 3.4, 4), (6, 3.5, 4), [d6]),
        Sightline((living, kitchen), (1, 5.5, 1), (4, 5.4, 1), [d2]),
        Sightline((living, outside), (2, 2, 1.2), (2, -2, 1.2), [w1]),
    ], {"wall_s": 0.0123, "undecided_pairs": 0})
    matrix.grazing = grazing
    return m.analysis(views=views, matrix=matrix, title="House",
                      statistics={"extract_s": 0.12, "commit_s": 0.004, "objects_not_read": 31})


def office(storeys: int, bays: int, cameras: int = 2, seed: int = 1) -> Analysis:
    """Corridors with rooms on both sides: storeys x (2 x bays + 1) rooms, a matrix that knows rooms on one corridor."""
    random = np.random.default_rng(seed)
    m = Maker()
    for s in range(storeys):
        z, name = s * 3.5, f"Level {s:02d}"
        m.building.storeys.append((name, z))
        corridor = m.room(f"C{s:02d}", (0, 5.2, z, bays * 3.2 - 0.2, 7.2, z + 2.8), storey=name, long_name=f"Corridor {s}")
        for k in range(bays):
            x = k * 3.2
            for part, (y0, y1, wall0, axis_low) in enumerate(((0, 5, 5.0, True), (7.4, 12.4, 7.2, False))):
                room = m.room(f"{s:02d}.{2 * k + part:03d}", (x, y0, z, x + 3.0, y1, z + 2.8), storey=name, long_name="Office")
                m.opening(f"D{s}-{k}-{part}", b.DOOR, b.OPEN, (x + 1, wall0, z, x + 1.9, wall0 + 0.2, z + 2.1), 1,
                          *((room, corridor) if axis_low else (corridor, room)))
    n = len(m.building.rooms)
    visible = np.eye(n, dtype=bool)
    per = 2 * bays + 1
    for s in range(storeys):
        c = s * per
        visible[c, c : c + per] = visible[c : c + per, c] = True
        block = random.random((per, per)) < 0.3
        visible[c : c + per, c : c + per] |= block | block.T
    views = []
    for k in range(cameras):
        cam = camera(f"Cam {k}", 1.0 + k * 2, 6.2, (k % storeys) * 3.5 + 1.6, 0 if k % 2 == 0 else 120)
        m.building.cameras.append(cam)
        c = (k % storeys) * per
        views.append(View(cam, 1, "clip", [m.of_room[c][0]], [], [c, c + 1, c + 2], [], {}, {c: [], c + 1: [0], c + 2: [1]}, 2.0))
    lines = [Sightline((int(i), int(j)), (0, 0, 1), (1, 1, 1), [0]) for i, j in zip(*np.nonzero(np.triu(visible, 1)), strict=False)]
    return m.analysis(views=views, matrix=RoomMatrix("exact", visible, visible.copy(), lines, {}), title="Office")


def empty() -> Analysis:
    return Maker().analysis()
