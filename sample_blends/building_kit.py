# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls with real openings, floors, ceilings, doors and windows, with the annotation Enfilade reads.

A plan is drawn by its centre lines: rectilinear room polygons that tile the storey. Every room gets its own wall leaves,
floor and ceiling, `HALF_WALL` thick up to the centre line; the facade is one more leaf outside. Leaves of two rooms meet
on the centre line and at corners, so the building is sealed except where an opening is cut:

      room A   |leaf A|leaf B|   room B           room   |leaf|  facade  |   outside
                      centre line                             centre line

The annotation (custom properties on objects, see README.md of this folder):
  enfilade          "room" | "exterior" | "door" | "window" | "hole" | "virtual" | "ignore"
  enfilade_state    "open" | "closed" | "glass"        (openings)
  enfilade_storey   name of the storey                 (rooms)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import bpy
from mesh_kit import Box, MeshBuilder, MeshCache, Vec3, box_minus, grid_solid
from palette import Palette

HALF_WALL = 0.075  # metres; an inner wall is two leaves
BURIED = 0.02  # metres that wall leaves reach into each other, floor and ceiling, so that no sight slips along the joint
FACADE = 0.275  # metres outside the centre line; an outer wall is HALF_WALL + FACADE thick

Point = tuple[float, float]


@dataclass
class Storey:
    name: str
    floor: float  # metres, finished floor
    ceiling: float
    slab: float = 0.30  # between a ceiling and the floor above


@dataclass
class Opening:
    """A passage through a wall (axis 0 or 1: the wall's normal) or through a slab (axis 2)."""

    name: str
    kind: str  # "door", "window", "hole"
    state: str  # "open", "closed", "glass"
    body: Box  # from room face to room face (or facade face)
    axis: int
    storey: int
    outward: int = 0  # +1 / -1: the side of the outside along the axis; 0: between two rooms

    @property
    def size(self) -> Vec3:
        return tuple(self.body[1][i] - self.body[0][i] for i in range(3))  # type: ignore[return-value]


@dataclass
class Piece:
    """An object to be: Blender keeps its objects sorted by name, so forty thousand are made fast only in that order."""

    name: str
    data: bpy.types.ID | None  # None: an empty
    where: bpy.types.Collection
    location: Vec3
    turn: float = 0.0  # about z, radians
    scale: float = 1.0
    properties: dict[str, str] = field(default_factory=dict)
    wire: bool = False  # drawn as wires, not rendered

    def make(self) -> bpy.types.Object:
        made = bpy.data.objects.new(self.name, self.data)
        made.location = self.location
        if self.turn:
            made.rotation_euler = (0.0, 0.0, self.turn)
        if self.scale != 1.0:
            made.scale = (self.scale, self.scale, self.scale)
        for key, value in self.properties.items():
            made[key] = value
        if self.wire:
            made.display_type = "WIRE"
            made.hide_render = True
        if self.data is None:
            made.empty_display_size = 0.5
        self.where.objects.link(made)
        return made


@dataclass
class Room:
    name: str
    outline: list[Point]  # counter-clockwise, centre lines
    storey: int
    wall: str = "plaster"
    floor: str = "oak_floor"
    ceiling: str = "ceiling"

    @property
    def faces(self) -> list[Point]:
        """The outline of the room's air: its wall faces."""
        return offset_polygon(self.outline, -HALF_WALL)


def offset_polygon(polygon: Sequence[Point], distance: float) -> list[Point]:
    """A rectilinear counter-clockwise polygon moved outward by `distance` (negative: inward)."""
    result = []
    n = len(polygon)
    for i, (x, y) in enumerate(polygon):
        before, after = polygon[i - 1], polygon[(i + 1) % n]
        dx = dy = 0.0
        for a, b in ((before, (x, y)), ((x, y), after)):
            if abs(b[0] - a[0]) > abs(b[1] - a[1]):
                dy = -distance if b[0] > a[0] else distance
            else:
                dx = distance if b[1] > a[1] else -distance
        result.append((x + dx, y + dy))
    return result


def inside_polygon(point: Point, polygon: Sequence[Point]) -> bool:
    x, y = point
    odd = False
    for i, (x0, y0) in enumerate(polygon):
        x1, y1 = polygon[(i + 1) % len(polygon)]
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            odd = not odd
    return odd


def wall_leaves(polygon: Sequence[Point], thickness: float, buried: float = 0.0) -> list[tuple[int, str, tuple[Point, Point]]]:
    """Plan boxes of the leaves outside each edge: (edge, compass letter, (low, high)).

    Leaves along x own the corner squares, leaves along y reach `buried` metres into them. At reflex corners they only
    touch: an overlap would show there as two faces in one plane. Edges that go on straight (a facade divided into
    pieces) have no corner between them.
    """
    n = len(polygon)

    def turn(i: int) -> float:
        (ax, ay), (bx, by), (cx, cy) = polygon[i - 1], polygon[i], polygon[(i + 1) % n]
        return (bx - ax) * (cy - by) - (by - ay) * (cx - bx)

    leaves = []
    for i in range(n):
        (x0, y0), (x1, y1) = polygon[i], polygon[(i + 1) % n]
        start, end = turn(i), turn((i + 1) % n)
        if abs(x1 - x0) > abs(y1 - y0):  # along x; owns convex corners
            d = 1.0 if x1 > x0 else -1.0
            a = x0 - (d * thickness if start > 0 else 0.0)
            b = x1 + (d * thickness if end > 0 else 0.0)
            low_y, high_y = (y0 - thickness, y0) if d > 0 else (y0, y0 + thickness)
            leaves.append((i, "S" if d > 0 else "N", ((min(a, b), low_y), (max(a, b), high_y))))
        else:  # along y; gives way at reflex corners, where the leaf along x runs past
            d = 1.0 if y1 > y0 else -1.0
            a = y0 + d * (thickness if start < 0 else -buried if start > 0 else 0.0)
            b = y1 - d * (thickness if end < 0 else -buried if end > 0 else 0.0)
            low_x, high_x = (x0, x0 + thickness) if d > 0 else (x0 - thickness, x0)
            leaves.append((i, "E" if d > 0 else "W", ((low_x, min(a, b)), (high_x, max(a, b)))))
    return leaves


@dataclass
class Kit:
    """Adds a building's objects to the scene, sharing meshes wherever two pieces are equal."""

    storeys: list[Storey]
    palette: Palette = field(default_factory=Palette)
    cache: MeshCache = field(default_factory=MeshCache)
    rooms: list[Room] = field(default_factory=list)
    openings: list[Opening] = field(default_factory=list)
    collections: dict[str, bpy.types.Collection] = field(default_factory=dict)
    tops: list[bpy.types.Collection] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    _buckets: dict[tuple[int, int, int], list[Opening]] | None = None

    # ---- collections and objects ------------------------------------------------------------------------------
    def collection(self, name: str, parent: str = "") -> bpy.types.Collection:
        """Collections hang in the scene only after `finish`: linking into detached ones is fast."""
        if name not in self.collections:
            made = self.collections[name] = bpy.data.collections.new(name)
            if parent:
                self.collection(parent).children.link(made)
            else:
                self.tops.append(made)
        return self.collections[name]

    def storey_collection(self, storey: int, what: str) -> bpy.types.Collection:
        name = self.storeys[storey].name
        return self.collection(f"{name} {what}", name)

    def add(self, name: str, data: bpy.types.ID | None, where: bpy.types.Collection,
            location: Vec3 = (0.0, 0.0, 0.0), turn: float = 0.0) -> Piece:
        self.pieces.append(Piece(name, data, where, location, turn))
        return self.pieces[-1]

    def finish(self) -> None:
        """Makes the objects and hangs their collections in the scene."""
        for piece in sorted(self.pieces, key=lambda piece: piece.name.lower()):
            piece.make()
        self.pieces.clear()
        for made in self.tops:
            bpy.context.scene.collection.children.link(made)

    def mesh(self, key: tuple, name: str, fill: Callable[[MeshBuilder], None]) -> bpy.types.Mesh:
        def make() -> bpy.types.Mesh:
            builder = MeshBuilder()
            fill(builder)
            return builder.build(name)

        return self.cache.get(key, make)

    # ---- openings -----------------------------------------------------------------------------------------------
    def wall_opening(self, name: str, kind: str, state: str, axis: int, at: float, span: tuple[float, float],
                     heights: tuple[float, float], storey: int, outward: int = 0) -> Opening:
        """An opening in the wall on the centre line `at`.

        axis: the wall's normal, 0 = x, 1 = y. span: from, to along the wall, metres. heights: above the storey's floor.
        outward: +1 / -1 when the facade lies on that side, 0 for an inner wall.
        """
        low, high = at - HALF_WALL, at + HALF_WALL
        if outward > 0:
            high = at + FACADE
        elif outward < 0:
            low = at - FACADE
        z = self.storeys[storey].floor
        z0, z1 = z + heights[0], z + heights[1]
        if axis == 0:
            body: Box = ((low, span[0], z0), (high, span[1], z1))
        else:
            body = ((span[0], low, z0), (span[1], high, z1))
        made = Opening(name, kind, state, body, axis, storey, outward)
        self.openings.append(made)
        return made

    def slab_opening(self, name: str, low: Point, high: Point, storey: int) -> Opening:
        """A hole in the slab above `storey`, from its ceiling to the floor above."""
        body: Box = ((*low, self.storeys[storey].ceiling), (*high, self.storeys[storey + 1].floor))
        made = Opening(name, "hole", "open", body, 2, storey)
        self.openings.append(made)
        return made

    def annotate_openings(self) -> None:
        where = self.collection("Openings")
        for opening in self.openings:
            size = tuple(round(v, 6) for v in opening.size)
            mesh = self.mesh(("opening", size), "Opening",
                             lambda b, s=opening.size: b.box((0, 0, 0), s, self.palette.white_paint))
            made = self.add(f"Opening {opening.name}", mesh, where, opening.body[0])
            made.properties = {"enfilade": opening.kind, "enfilade_state": opening.state,
                               "enfilade_storey": self.storeys[opening.storey].name}
            made.wire = True

    def _cuts(self, low: Vec3, high: Vec3, buried: float = 0.0) -> list[Box]:
        """The openings that go through a box, relative to its low corner.

        buried: an opening that ends this near the box's bottom or top goes right through it.
        """
        cuts = []
        for opening in self._near(low, high):
            a, b = opening.body
            if all(a[i] < high[i] - 1e-6 and b[i] > low[i] + 1e-6 for i in range(3)):
                # Clamped to the box and pushed out beyond it, so that the cut has no skin left.
                cut_low, cut_high = [], []
                for i in range(3):
                    skin = 1e-6 + (buried if i == 2 else 0.0)
                    cut_low.append(a[i] - low[i] if a[i] > low[i] + skin else -1.0)
                    cut_high.append(b[i] - low[i] if b[i] < high[i] - skin else high[i] - low[i] + 1.0)
                cuts.append((tuple(round(v, 6) for v in cut_low), tuple(round(v, 6) for v in cut_high)))
        return sorted(cuts)  # type: ignore[return-value]

    def _near(self, low: Vec3, high: Vec3) -> Iterable[Opening]:
        """Openings whose bucket of 8 m touches the box; buckets are made at the first call, after the last opening."""
        if self._buckets is None:
            self._buckets = {}
            for opening in self.openings:
                for key in self._bucket_keys(*opening.body):
                    self._buckets.setdefault(key, []).append(opening)
        seen: dict[int, Opening] = {}
        for key in self._bucket_keys(low, high):
            for opening in self._buckets.get(key, ()):
                seen[id(opening)] = opening
        return seen.values()

    @staticmethod
    def _bucket_keys(low: Vec3, high: Vec3) -> Iterable[tuple[int, int, int]]:
        a = [math.floor(v / 8.0 - 1e-6) for v in low]
        b = [math.floor(v / 8.0 + 1e-6) for v in high]
        return ((i, j, k) for i in range(a[0], b[0] + 1) for j in range(a[1], b[1] + 1) for k in range(a[2], b[2] + 1))

    # ---- walls, floors, ceilings ----------------------------------------------------------------------------------
    def plate(self, name: str, low: Vec3, high: Vec3, material: str, where: bpy.types.Collection,
              buried: float = 0.0) -> Piece:
        """A box with the openings that cross it cut out; it reaches `buried` metres further down and up."""
        low, high = (low[0], low[1], low[2] - buried), (high[0], high[1], high[2] + buried)
        cuts = self._cuts(low, high, buried)
        size = tuple(round(high[i] - low[i], 6) for i in range(3))

        def fill(builder: MeshBuilder) -> None:
            vertices, faces = box_minus(((0.0, 0.0, 0.0), size), cuts)
            builder.add(vertices, faces, getattr(self.palette, material))

        mesh = self.mesh(("plate", material, size, tuple(cuts)), name.split(" ")[0], fill)
        return self.add(name, mesh, where, low)

    def slab_piece(self, name: str, outline: Sequence[Point], z0: float, z1: float, material: str,
                   where: bpy.types.Collection) -> Piece:
        """A rectilinear slab with the openings that cross it cut out."""
        ox, oy = min(p[0] for p in outline), min(p[1] for p in outline)
        mx, my = max(p[0] for p in outline), max(p[1] for p in outline)
        local = [(round(p[0] - ox, 6), round(p[1] - oy, 6)) for p in outline]
        cuts = self._cuts((ox, oy, z0), (mx, my, z1))
        height = round(z1 - z0, 6)

        def fill(builder: MeshBuilder) -> None:
            lines = [sorted({p[axis] for p in local}
                            | {v for cut in cuts for v in (cut[0][axis], cut[1][axis])
                               if 0.0 < v < max(p[axis] for p in local)}) for axis in (0, 1)]
            vertices, faces = grid_solid(
                [*lines, [0.0, height]],
                lambda p: inside_polygon((p[0], p[1]), local)
                and not any(all(c[0][a] < p[a] < c[1][a] for a in range(3)) for c in cuts))
            builder.add(vertices, faces, getattr(self.palette, material))

        mesh = self.mesh(("slab", material, tuple(local), height, tuple(cuts)), name.split(" ")[0], fill)
        return self.add(name, mesh, where, (ox, oy, z0))

    def build_room(self, room: Room) -> None:
        """Wall leaves, floor and ceiling of one room, and the annotated volume of its air."""
        storey = self.storeys[room.storey]
        walls = self.storey_collection(room.storey, "walls")
        slabs = self.storey_collection(room.storey, "slabs")
        faces = room.faces
        for edge, side, ((x0, y0), (x1, y1)) in wall_leaves(faces, HALF_WALL, BURIED):
            name = f"Wall {room.name} {side}{edge}"
            self.plate(name, (x0, y0, storey.floor), (x1, y1, storey.ceiling), room.wall, walls, BURIED)
        half = storey.slab / 2.0
        self.slab_piece(f"Floor {room.name}", room.outline, storey.floor - half, storey.floor, room.floor, slabs)
        self.slab_piece(f"Ceiling {room.name}", room.outline, storey.ceiling, storey.ceiling + half, room.ceiling,
                        slabs)
        ox, oy = min(p[0] for p in faces), min(p[1] for p in faces)
        local = tuple((round(p[0] - ox, 6), round(p[1] - oy, 6)) for p in faces)
        height = round(storey.ceiling - storey.floor, 6)

        def fill(builder: MeshBuilder) -> None:
            n = len(local)
            builder.add([(x, y, 0.0) for x, y in local] + [(x, y, height) for x, y in local],
                        [tuple(reversed(range(n))), tuple(range(n, 2 * n)),
                         *((i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n))], self.palette.white_paint)

        made = self.add(f"Room {room.name}", self.mesh(("room", local, height), "Room", fill),
                        self.collection("Rooms"), (ox, oy, storey.floor))
        made.properties = {"enfilade": "room", "enfilade_storey": storey.name}
        made.wire = True

    def facade(self, outline: Sequence[Point], storey: int, material: str, z0: float, z1: float,
               label: str = "Facade") -> None:
        """The outer leaf along a counter-clockwise outline of centre lines; corners in a straight line divide it."""
        where = self.storey_collection(storey, "facade")
        for edge, side, ((x0, y0), (x1, y1)) in wall_leaves(outline, FACADE):
            self.plate(f"{label} {self.storeys[storey].name} {side}{edge}", (x0, y0, z0), (x1, y1, z1), material, where)

    # ---- doors and windows ------------------------------------------------------------------------------------------
    def _axes(self, opening: Opening, inside: int = 0) -> tuple[float, float, float, float, Vec3]:
        """Width, height, depth, turn about z, and place of an opening: local x runs along the wall, local -y inside.

        inside: +1 / -1, the side of the wall along its normal that local -y points to; 0: away from the facade.
        """
        outward = -inside if inside else opening.outward
        low, high = opening.body
        along = 1 - opening.axis
        width, height, depth = (high[along] - low[along], high[2] - low[2],
                                high[opening.axis] - low[opening.axis])
        if opening.axis == 1:
            turn = 0.0 if outward >= 0 else math.pi
            place = low if turn == 0.0 else (high[0], high[1], low[2])
        else:
            turn = -math.pi / 2 if outward >= 0 else math.pi / 2
            place = (low[0], high[1], low[2]) if turn < 0 else (high[0], low[1], low[2])
        return width, height, depth, turn, place

    def _local(self, place: Vec3, turn: float, x: float, y: float) -> Vec3:
        c, s = math.cos(turn), math.sin(turn)
        return (place[0] + c * x - s * y, place[1] + s * x + c * y, place[2])

    def door(self, opening: Opening, hinge: str = "left", angle: float = 0.0, style: str = "white_paint",
             into: int = 0, leaf: bool = True) -> None:
        """Lining, architraves and a leaf, `angle` degrees open.

        into: +1 / -1, the side along the wall's normal to which the leaf opens; 0: into the building.
        hinge: "left" or "right" seen from outside that side, looking in. leaf: False for a cased opening.
        """
        p = self.palette
        width, height, depth, turn, place = self._axes(opening, into)
        where = self.storey_collection(opening.storey, "doors and windows")
        lining, trim, proud = 0.03, 0.07, 0.014

        def fill_frame(b: MeshBuilder) -> None:
            m = getattr(p, style)
            b.box((0, -0.002, 0), (lining, depth + 0.002, height), m)
            b.box((width - lining, -0.002, 0), (width, depth + 0.002, height), m)
            b.box((lining, -0.002, height - lining), (width - lining, depth + 0.002, height), m)
            if leaf:  # the stop behind the leaf and a threshold: no ray slips past a closed door
                y0, y1, in_x = 0.0465, 0.066, lining + 0.016
                b.box((lining, y0, 0), (in_x, y1, height - lining), m)
                b.box((width - in_x, y0, 0), (width - lining, y1, height - lining), m)
                b.box((in_x, y0, height - lining - 0.02), (width - in_x, y1, height - lining), m)
                b.box((in_x, y0, 0), (width - in_x, y1, 0.008), m)
            for y0, y1 in ((-proud, 0.0), (depth, depth + proud)):
                b.box((-trim, y0, 0), (0.006, y1, height + trim), m, 0.004)
                b.box((width - 0.006, y0, 0), (width + trim, y1, height + trim), m, 0.004)
                b.box((0.006, y0, height - 0.006), (width - 0.006, y1, height + trim), m, 0.004)

        size = (round(width, 6), round(height, 6), round(depth, 6))
        self.add(f"Frame {opening.name}", self.mesh(("door frame", style, size, leaf), "Door frame", fill_frame), where,
                 place, turn)
        if not leaf:
            return
        leaf_width, leaf_height, thick = width - 2 * lining - 0.006, height - lining - 0.008, 0.042
        mirrored = hinge == "right"

        def fill_leaf(b: MeshBuilder) -> None:
            m = getattr(p, style)
            s = -1.0 if mirrored else 1.0

            def span(a: float, c: float) -> tuple[float, float]:
                return (min(s * a, s * c), max(s * a, s * c))

            x0, x1 = span(0.0, leaf_width)
            b.box((x0, 0, 0.004), (x1, thick, leaf_height), m, 0.003)
            for z0, z1 in ((0.16, 0.92), (1.04, leaf_height - 0.14)):  # raised panels on both faces
                x0, x1 = span(0.13, leaf_width - 0.13)
                b.box((x0, -0.006, z0), (x1, 0.0, z1), m, 0.005)
                b.box((x0, thick, z0), (x1, thick + 0.006, z1), m, 0.005)
            for y0, y1, y2 in ((-0.05, -0.035, 0.0), (thick, thick + 0.035, thick + 0.05)):
                x0, x1 = span(leaf_width - 0.075, leaf_width - 0.055)
                b.box((x0, min(y0, y2), 0.99), (x1, max(y0, y2), 1.01), p.steel)
                x0, x1 = span(leaf_width - 0.18, leaf_width - 0.055)
                lever = (y0, y1) if y0 < 0 else (y1, y2)
                b.box((x0, lever[0], 0.99), (x1, lever[1], 1.01), p.steel, 0.003)

        leaf_mesh = self.mesh(("door leaf", style, size[:2], mirrored), "Door leaf", fill_leaf)
        hinge_x = width - lining - 0.003 if mirrored else lining + 0.003
        swing = math.radians(angle) * (1.0 if mirrored else -1.0)
        self.add(f"Leaf {opening.name}", leaf_mesh, where, self._local(place, turn, hinge_x, 0.004), turn + swing)

    def window(self, opening: Opening, lights: int = 0, style: str = "frame_dark", sill: bool = True) -> None:
        """A frame with `lights` panes side by side (0: as many as look right), glass, and sills."""
        p = self.palette
        width, height, depth, turn, place = self._axes(opening)
        where = self.storey_collection(opening.storey, "doors and windows")
        count = lights or max(1, round(width / 0.95))
        bar, thick = 0.055, 0.07
        y0 = depth - 0.16 if opening.outward else depth / 2 - thick / 2
        y1 = y0 + thick
        size = (round(width, 6), round(height, 6), round(depth, 6))

        def fill(b: MeshBuilder) -> None:
            m = getattr(p, style)
            b.box((0, y0, 0), (width, y1, bar), m, 0.004)
            b.box((0, y0, height - bar), (width, y1, height), m, 0.004)
            b.box((0, y0, bar), (bar, y1, height - bar), m, 0.004)
            b.box((width - bar, y0, bar), (width, y1, height - bar), m, 0.004)
            for i in range(1, count):
                x = width * i / count
                b.box((x - bar / 2, y0, bar), (x + bar / 2, y1, height - bar), m, 0.004)
            if sill and opening.outward:
                b.box((-0.04, -0.04, -0.028), (width + 0.04, 0.0, 0.0), p.white_paint, 0.004)
                b.box((0.0, 0.0, 0.0), (width, y0, 0.004), p.white_paint)
                b.box((-0.03, depth, -0.03), (width + 0.03, depth + 0.045, 0.0), m, 0.003)
                b.box((0.0, y1, 0.0), (width, depth, 0.004), m)

        def fill_pane(b: MeshBuilder) -> None:
            y = (y0 + y1) / 2
            b.add([(bar / 2, y, bar / 2), (width - bar / 2, y, bar / 2), (width - bar / 2, y, height - bar / 2),
                   (bar / 2, y, height - bar / 2)], [(0, 1, 2, 3)], p.glass)

        self.add(f"Frame {opening.name}",
                 self.mesh(("window frame", style, size, count, sill, opening.outward != 0), "Window frame", fill),
                 where, place, turn)
        self.add(f"Pane {opening.name}", self.mesh(("pane", size, opening.outward != 0), "Pane", fill_pane), where,
                 place, turn)

    # ---- what remains -------------------------------------------------------------------------------------------------
    def exterior(self) -> None:
        """The outside as a room of its own: an empty marked "exterior", everything that is in no other room."""
        made = self.add("Exterior", None, self.collection("Rooms"), (0.0, 0.0, -3.0))
        made.properties = {"enfilade": "exterior"}
        made.wire = True
