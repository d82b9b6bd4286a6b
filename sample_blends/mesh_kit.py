# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes from boxes, cylinders and rectilinear solids, and materials: what the sample buildings are made of.

No operators (`bpy.ops`), only data calls that are the same from Blender 3.4 to 5.x. Meshes are cached by a key, so that
equal pieces (forty thousand of them in the large office) become instances of few meshes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence

import bpy

Vec3 = tuple[float, float, float]
Box = tuple[Vec3, Vec3]  # min corner, max corner


class MeshBuilder:
    """Collects polygons with material slots, then makes one mesh of them."""

    def __init__(self) -> None:
        self.vertices: list[Vec3] = []
        self.faces: list[tuple[int, ...]] = []
        self.slots: list[int] = []
        self.smooth: list[bool] = []
        self.materials: list[bpy.types.Material] = []

    def slot(self, material: bpy.types.Material) -> int:
        if material not in self.materials:
            self.materials.append(material)
        return self.materials.index(material)

    def add(self, vertices: Sequence[Vec3], faces: Sequence[Sequence[int]], material: bpy.types.Material,
            smooth: bool = False) -> None:
        """Polygons with indices relative to `vertices`, counter-clockwise seen from outside."""
        base = len(self.vertices)
        slot = self.slot(material)
        self.vertices.extend(vertices)
        self.faces.extend(tuple(base + i for i in face) for face in faces)
        self.slots.extend([slot] * len(faces))
        self.smooth.extend([smooth] * len(faces))

    def box(self, low: Vec3, high: Vec3, material: bpy.types.Material, chamfer: float = 0.0) -> None:
        """An axis-aligned box; `chamfer` metres off every edge, which is what catches the light on furniture."""
        chamfer = min(chamfer, *((high[i] - low[i]) * 0.45 for i in range(3)))
        if chamfer <= 0.0:
            x0, y0, z0 = low
            x1, y1, z1 = high
            self.add(
                [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0),
                 (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
                [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], material)
            return
        # Each corner (sx, sy, sz) has three points, one on each face that meets there.
        vertices: list[Vec3] = []
        index: dict[tuple[int, int, int, int], int] = {}
        for sx in (0, 1):
            for sy in (0, 1):
                for sz in (0, 1):
                    s = (sx, sy, sz)
                    for axis in range(3):
                        p = [(high[i] - chamfer if s[i] else low[i] + chamfer) for i in range(3)]
                        p[axis] = high[axis] if s[axis] else low[axis]
                        index[(*s, axis)] = len(vertices)
                        vertices.append((p[0], p[1], p[2]))
        faces: list[list[int]] = []
        for axis in range(3):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            for side in (0, 1):
                ring = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    s = [0, 0, 0]
                    s[axis], s[a], s[b] = side, u, v
                    ring.append(index[(s[0], s[1], s[2], axis)])
                faces.append(ring if side else ring[::-1])
            for u in (0, 1):  # the edges that run along `axis`
                for v in (0, 1):
                    low_s, high_s = [0, 0, 0], [0, 0, 0]
                    low_s[a] = high_s[a] = u
                    low_s[b] = high_s[b] = v
                    high_s[axis] = 1
                    ring = [index[(*low_s, a)], index[(*high_s, a)], index[(*high_s, b)], index[(*low_s, b)]]
                    faces.append(ring[::-1] if u == v else ring)
        for sx in (0, 1):
            for sy in (0, 1):
                for sz in (0, 1):
                    ring = [index[(sx, sy, sz, axis)] for axis in range(3)]
                    faces.append(ring if (sx + sy + sz) % 2 else ring[::-1])
        self.add(vertices, faces, material)

    def cylinder(self, centre: Vec3, radius: float, height: float, material: bpy.types.Material, segments: int = 20,
                 top_radius: float | None = None, axis: int = 2, caps: bool = True) -> None:
        """A (truncated) cone that stands on `centre` along `axis`; the caps have their own vertices, so they stay flat."""
        top = radius if top_radius is None else top_radius

        def at(angle: float, r: float, h: float) -> Vec3:
            p = (r * math.cos(angle), r * math.sin(angle), h)
            p = (p[2], p[0], p[1]) if axis == 0 else (p[1], p[2], p[0]) if axis == 1 else p
            return (centre[0] + p[0], centre[1] + p[1], centre[2] + p[2])

        angles = [2.0 * math.pi * i / segments for i in range(segments)]
        low = [at(a, radius, 0.0) for a in angles]
        high = [at(a, top, height) for a in angles]
        n = segments
        self.add(low + high, [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)], material, smooth=True)
        if caps:
            self.add(low, [tuple(reversed(range(n)))], material)
            self.add(high, [tuple(range(n))], material)

    def ball(self, centre: Vec3, radius: Vec3, material: bpy.types.Material, rings: int = 8, segments: int = 12,
             bump: Callable[[float, float], float] | None = None) -> None:
        """An ellipsoid; `bump(u, v)` scales the radius (leaves, cushions)."""
        vertices: list[Vec3] = []
        for j in range(1, rings):
            v = math.pi * j / rings
            for i in range(segments):
                u = 2.0 * math.pi * i / segments
                k = bump(u, v) if bump else 1.0
                vertices.append((centre[0] + k * radius[0] * math.sin(v) * math.cos(u),
                                 centre[1] + k * radius[1] * math.sin(v) * math.sin(u),
                                 centre[2] + k * radius[2] * math.cos(v)))
        top, bottom = len(vertices), len(vertices) + 1
        vertices += [(centre[0], centre[1], centre[2] + radius[2]), (centre[0], centre[1], centre[2] - radius[2])]
        faces: list[tuple[int, ...]] = []
        for i in range(segments):
            k = (i + 1) % segments
            faces.append((top, i, k))
            for j in range(rings - 2):
                a, b = j * segments, (j + 1) * segments
                faces.append((a + i, b + i, b + k, a + k))
            last = (rings - 2) * segments
            faces.append((bottom, last + k, last + i))
        self.add(vertices, faces, material, smooth=True)

    def build(self, name: str) -> bpy.types.Mesh:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(self.vertices, [], self.faces)
        for material in self.materials:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", self.slots)
        mesh.polygons.foreach_set("use_smooth", self.smooth)
        mesh.update()
        return mesh


def grid_solid(lines: Sequence[Sequence[float]], inside: Callable[[Vec3], bool]
               ) -> tuple[list[Vec3], list[tuple[int, int, int, int]]]:
    """The closed surface of a union of grid cells.

    lines: the grid's ascending coordinates along x, y, z. inside: asked once per cell, at its centre. Neighbouring
    quads share their vertices, so the surface has no cracks.
    """
    xs, ys, zs = (list(axis) for axis in lines)
    shape = (len(xs) - 1, len(ys) - 1, len(zs) - 1)
    filled = {(i, j, k)
              for i in range(shape[0]) for j in range(shape[1]) for k in range(shape[2])
              if inside(((xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2, (zs[k] + zs[k + 1]) / 2))}
    corner_index: dict[tuple[int, int, int], int] = {}
    vertices: list[Vec3] = []

    def corner(i: int, j: int, k: int) -> int:
        key = (i, j, k)
        if key not in corner_index:
            corner_index[key] = len(vertices)
            vertices.append((xs[i], ys[j], zs[k]))
        return corner_index[key]

    # For each of the six sides: the step to the neighbour and the side's four corners, counter-clockwise from outside.
    sides = (((-1, 0, 0), ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0))),
             ((1, 0, 0), ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1))),
             ((0, -1, 0), ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1))),
             ((0, 1, 0), ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0))),
             ((0, 0, -1), ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0))),
             ((0, 0, 1), ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))))
    faces = []
    for i, j, k in sorted(filled):
        for (di, dj, dk), corners in sides:
            if (i + di, j + dj, k + dk) not in filled:
                a, b, c, d = (corner(i + u, j + v, k + w) for u, v, w in corners)
                faces.append((a, b, c, d))
    return vertices, faces


def box_minus(box: Box, cuts: Sequence[Box]) -> tuple[list[Vec3], list[tuple[int, int, int, int]]]:
    """The closed surface of a box with boxes cut out of it."""
    lines = []
    for axis in range(3):
        low, high = box[0][axis], box[1][axis]
        values = {low, high}
        for cut in cuts:
            values.update(v for v in (cut[0][axis], cut[1][axis]) if low < v < high)
        lines.append(sorted(values))

    def solid(p: Vec3) -> bool:
        return not any(all(cut[0][a] < p[a] < cut[1][a] for a in range(3)) for cut in cuts)

    return grid_solid(lines, solid)


class MeshCache:
    """Meshes by key: the same key gives the same mesh, so objects share it."""

    def __init__(self) -> None:
        self.meshes: dict[Hashable, bpy.types.Mesh] = {}

    def get(self, key: Hashable, make: Callable[[], bpy.types.Mesh]) -> bpy.types.Mesh:
        mesh = self.meshes.get(key)
        if mesh is None:
            mesh = self.meshes[key] = make()
        return mesh
