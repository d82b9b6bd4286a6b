# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms cut into cells, in figures: cells a room, what they hold of other rooms, and faces that a ray crosses.

Usage: /usr/bin/python3 tests/bench/decomposition_table.py [--rays N] [FILE.ifc ...]
Without files: Office_A of the data folder and a building with curved walls made here (a ring corridor round a core, rooms
between arcs, a hall with round columns; 32 facets a turn). `foreign` is the share of the cells that lies in other rooms,
`beyond` what they hold beyond their room (facets of walls that bulge in are taken together). `crossed` is the mean number of faces that a level ray
crosses on its way through its room, the last one included; `triangles` the same through a constrained triangulation of
the floor (shapely's), `ratio` how many times more. Needs shapely for the comparison; says so without.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
sys.path.append(str(ROOT / "build" / "python"))

from enfilade.rules import assemble, ifc, indoorgml, polyhedra  # noqa: E402 - the path has to be set first
from enfilade.rules.building import Building, Room  # noqa: E402

FACETS = 32


def prism(name: str, outline: list[tuple[float, float]], holes: list[list[tuple[float, float]]] = (), height: float = 3.0) -> Room:
    """A room over a plan with holes, floor and ceiling triangulated."""
    import shapely

    plan = shapely.Polygon(outline, holes)
    rings = [list(plan.exterior.coords)[:-1], *(list(r.coords)[:-1] for r in plan.interiors)]
    points: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []

    def corner(x: float, y: float, z: float) -> int:
        points.append((x, y, z))
        return len(points) - 1

    for triangle in shapely.constrained_delaunay_triangles(plan).geoms:
        ring = list(shapely.geometry.polygon.orient(triangle).exterior.coords)[:3]
        faces.append(tuple(corner(x, y, height) for x, y in ring))
        faces.append(tuple(corner(x, y, 0.0) for x, y in ring[::-1]))
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True):
            a, b, c, d = (corner(*p) for p in ((ax, ay, 0.0), (bx, by, 0.0), (bx, by, height), (ax, ay, height)))
            faces += [(a, b, c), (a, c, d)]
    solid = polyhedra.build(np.array(points), np.array(faces))
    return Room(name, vertices=solid.vertices, faces=[list(loop) for loop in solid.loops])


def arc(radius: float, start: float, end: float) -> list[tuple[float, float]]:
    steps = max(1, round(FACETS * abs(end - start) / (2 * math.pi)))
    return [(radius * math.cos(t), radius * math.sin(t)) for t in np.linspace(start, end, steps + 1)]


def curved_building() -> Building:
    rooms = [prism("Core", arc(4.0, 0.0, 2 * math.pi)[:-1])]
    rooms.append(prism("Ring", arc(7.0, 0.0, 2 * math.pi)[:-1], [arc(4.3, 0.0, 2 * math.pi)[:-1]]))
    for k in range(8):
        a, b = 2 * math.pi * k / 8 + 0.02, 2 * math.pi * (k + 1) / 8 - 0.02
        rooms.append(prism(f"Room {k}", [*arc(12.0, a, b), *arc(7.2, b, a)]))
    columns = [[(x + 20.0, y) for x, y in [(cx + p, cy + q) for p, q in arc(0.3, 0.0, 2 * math.pi)[:-1]]] for cx in (4, 8) for cy in (-4, 0, 4)]
    rooms.append(prism("Hall", [(20.0, -8.0), (32.0, -8.0), (32.0, 8.0), (20.0, 8.0)], columns))
    return Building("made", rooms=rooms)


def table(name: str, building: Building, rays: int) -> None:
    import enfilade_native as native

    made = assemble.assemble(native, building)
    cells = assemble.cells_of(made)
    rng = np.random.default_rng(1)
    rooms = [i for i, r in enumerate(building.rooms) if r.vertices is not None and len(r.vertices) and r.faces]
    solids = {i: polyhedra.build(building.rooms[i].vertices, _fans(building.rooms[i].faces)) for i in rooms}
    count = {i: 0 for i in rooms}
    planes: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {i: [] for i in rooms}
    foreign = volume = 0.0
    for c, room in enumerate(cells.rooms):
        if int(room) not in count or not len(cells.hulls[c]):
            continue
        count[int(room)] += 1
        hull = cells.hulls[c]
        normals, offsets = _planes(hull)
        planes[int(room)].append((normals, offsets))
        low, high = hull.min(axis=0), hull.max(axis=0)
        points = low + rng.random((400, 3)) * (high - low)
        inside = (points @ normals.T <= offsets + 1e-9).all(axis=1)
        size = _volume(hull)
        volume += size
        if inside.any():
            other = np.zeros(int(inside.sum()), dtype=bool)
            for j in rooms:
                if j != int(room) and (solids[j].low < high).all() and (solids[j].high > low).all():
                    other |= polyhedra.inside(points[inside], solids[j]) & ~polyhedra.inside(points[inside], solids[int(room)])
            foreign += size * other.mean()
    crossed, triangles = _crossings(building, solids, planes, rays, rng)
    per_room = np.array(list(count.values()))
    text = f"{name[:34]:34s} {len(rooms):5d} {per_room.sum():6d} {per_room.mean():9.2f} {np.median(per_room):6.0f} {per_room.max():5d}"
    beyond = volume / max(sum(abs(s.volume) for s in solids.values()), 1e-9) - 1.0
    text += f" {100 * foreign / max(volume, 1e-9):8.2f} % {100 * beyond:7.2f} % {crossed:8.2f}"
    print(text + (f" {triangles:9.2f} {triangles / crossed:6.2f}" if triangles else "         -      -"))
    made.scene.close()


def _crossings(building, solids, planes, rays: int, rng) -> tuple[float, float]:
    """Mean faces crossed by level rays from inside the rooms, through cells and through triangles of the floor plan."""
    try:
        import shapely
    except ImportError as error:
        print(f"no comparison with triangles: {error}", file=sys.stderr)
        shapely = None
    ours = theirs = total = 0
    volumes = np.array([abs(solids[i].volume) for i in solids])
    for i, share in zip(solids, volumes / volumes.sum(), strict=True):
        solid = solids[i]
        wanted = max(4, round(rays * share))
        points = solid.low + rng.random((20 * wanted, 3)) * (solid.high - solid.low)
        points[:, 2] = solid.low[2] + 0.5 * min(solid.high[2] - solid.low[2], 2.4)
        points = points[polyhedra.inside(points, solid)][:wanted]
        if not len(points):
            continue
        angle = rng.random(len(points)) * 2 * np.pi
        pieces = _triangles(shapely, building.rooms[i], solid, float(points[0, 2])) if shapely else []
        for p, t in zip(points, angle, strict=True):
            d = np.array([math.cos(t), math.sin(t), 0.0])
            spans = [s for n, o in planes[i] if (s := _span(p, d, n, o)) is not None]
            spans.sort()
            reach, faces = 0.0, 0
            for begin, end in spans:  # on through the cells until a wall
                if end <= reach + 1e-6:
                    continue
                if begin > reach + 1e-3:
                    break
                reach, faces = end, faces + 1
            ours += faces
            total += 1
            if shapely:
                line = [s for n, o in pieces if (s := _span(p[:2], d[:2], n, o)) is not None and s[1] > 1e-6 and s[0] < reach - 1e-6]
                theirs += len(line)
    return ours / max(total, 1), theirs / max(total, 1)


def _triangles(shapely, room: Room, solid, height: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The room's section at a height, triangulated within its outline: half-planes a triangle."""
    segments = []
    for tri in solid.vertices[solid.triangles]:
        side = tri[:, 2] - height
        cut = [tri[k] + (side[k] / (side[k] - side[(k + 1) % 3])) * (tri[(k + 1) % 3] - tri[k]) for k in range(3) if (side[k] < 0) != (side[(k + 1) % 3] < 0)]
        if len(cut) == 2:
            segments.append([tuple(np.round(c[:2], 5)) for c in cut])
    areas = list(shapely.polygonize([shapely.LineString(s) for s in segments if s[0] != s[1]]).geoms)
    plan = shapely.union_all([a for a in areas if polyhedra.inside(np.array([[*a.representative_point().coords[0], height]]), solid)[0]])
    found = []
    for triangle in shapely.constrained_delaunay_triangles(plan.simplify(1e-4)).geoms:
        ring = np.array(shapely.geometry.polygon.orient(triangle).exterior.coords)[:3]
        edges = np.roll(ring, -1, axis=0) - ring
        normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
        found.append((normals, np.einsum("ij,ij->i", normals, ring)))
    return found


def _span(p, d, normals, offsets) -> tuple[float, float] | None:
    """Between which t >= 0 the ray lies in the convex set."""
    slope, room = normals @ d, offsets - normals @ p
    if (room[np.abs(slope) < 1e-12] < -1e-7).any():
        return None
    begin = max((r / s for r, s in zip(room, slope, strict=True) if s < -1e-12), default=0.0)
    end = min((r / s for r, s in zip(room, slope, strict=True) if s > 1e-12), default=math.inf)
    begin = max(begin, 0.0)
    return (float(begin), float(end)) if end > begin + 1e-9 else None


def _volume(hull: np.ndarray) -> float:
    return abs(polyhedra.signed_volume(hull, _fans(indoorgml.hull_faces(hull))))


def _planes(hull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    normals = []
    for face in indoorgml.hull_faces(hull):
        a = hull[face] - hull[face].mean(axis=0)
        n = np.cross(a, np.roll(a, -1, axis=0)).sum(axis=0)
        normals.append(n / np.linalg.norm(n))
    found = np.array(normals)
    return found, (hull @ found.T).max(axis=0)


def _fans(faces) -> np.ndarray:
    return np.array([(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)], dtype=np.int64).reshape(-1, 3)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--rays", type=int, default=3000)
    options = parser.parse_args()
    data = Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))
    print(f"{'building':34s} rooms  cells cells/room median  most   foreign    beyond  crossed triangles  ratio")
    files = [Path(f) for f in options.files] or [f for f in (data / "ifc").glob("Office_A*.ifc")]
    for path in files:
        table(path.name, ifc.read_ifc(path, objects=False, local=True), options.rays)
    if not options.files:
        try:
            table("curved walls", curved_building(), options.rays)
        except ImportError as error:
            print(f"the building with curved walls needs shapely: {error}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
