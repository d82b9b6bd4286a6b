# SPDX-License-Identifier: GPL-3.0-or-later
"""Independent oracle: rays through the drawn triangles may leave a room only where a portal lets them.

Usage: /usr/bin/python3 tests/bench/ifc_oracle.py [--rays N] [--libs FOLDER] [--list K] [FILE.ifc ...]
Needs the Python packages embreex and trimesh (in --libs, or ENFILADE_ORACLE_LIBS); says so and ends with 0 without them.

Shares no code with the extraction: shapes come straight from IfcOpenShell, rays from Embree. A ray starts inside a
space and flies to the first drawn triangle (walls, slabs, roofs, ceilings, panels, with their holes; doors, windows and
furniture aren't there). Where it leaves a space without meeting a portal of that room it is a violation: `room` when
it goes on into another space, `outside` when it flies on for more than 0.1 m square to the space's face (less is a
wall that stands a little off the space), `chain` when the portals it leaves and enters by belong to no common opening.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter, defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "plugin"))

DRAWN = (
    "IfcWall", "IfcSlab", "IfcRoof", "IfcCurtainWall", "IfcPlate", "IfcMember", "IfcCovering", "IfcColumn", "IfcBeam",
    "IfcFooting", "IfcBuildingElementProxy",
)  # fmt: skip
STAND_OFF = 0.1  # m
FAR = 80.0  # m that a ray flies
SLIT = 1.1e-3  # m: a wall that stands this near to a space's face closes it; looks within such a slit see nothing but the wall
TOLERANCE = 3e-3  # m: single-precision rays, and models drawn to the millimetre


def _triangles(ifc, np, model, products, cut):
    settings = ifc.geom.settings()
    settings.set("use-world-coords", True)
    settings.set("disable-opening-subtractions", not cut)
    iterator = ifc.geom.iterator(settings, model, os.cpu_count() or 1, include=products)
    vertices, faces, owner, count = [], [], [], 0
    if products and iterator.initialize():
        while True:
            shape = iterator.get()
            v = np.array(shape.geometry.verts).reshape(-1, 3)
            f = np.array(shape.geometry.faces).reshape(-1, 3)
            vertices.append(v)
            faces.append(f + count)
            owner.append(np.full(len(f), shape.id))
            count += len(v)
            if not iterator.next():
                break
    if not vertices:
        return np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros(0, int)
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(owner)


def _hits(np, origin, direction, triangles) -> tuple:
    """Triangles that a ray meets, nearest first, edges included: indices, distances, whether seen from behind. In double
    precision: Embree's single precision passes between two triangles now and then."""
    e1, e2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(direction, e2)
    determinant = np.einsum("ij,ij->i", e1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - triangles[:, 0]
        u = np.einsum("ij,ij->i", s, p) / determinant
        q = np.cross(s, e1)
        v = q @ direction / determinant
        t = np.einsum("ij,ij->i", e2, q) / determinant
    edge = -1e-6  # of a triangle's side
    hit = np.nonzero((u >= edge) & (v >= edge) & (u + v <= 1 - edge) & (t > 0) & (np.abs(determinant) > 1e-14))[0]
    hit = hit[np.argsort(t[hit])]
    return hit, t[hit], determinant[hit] < 0.0


def _is_seen(np, origin, direction, triangles, owner, until: float) -> bool:
    """Whether a look as far as `until` is one: nothing drawn stands before, and it doesn't begin inside a drawn product
    (the first face that it meets of some product is seen from behind; the nearest of all isn't enough: where two
    products touch, their faces coincide and either may come first)."""
    hit, t, behind = _hits(np, origin, direction, triangles)
    first = {}
    for k, b in zip(hit, behind, strict=True):
        first.setdefault(int(owner[k]), b)
    return not any(first.values()) and not (t < until).any()


def _outward(np, vertices, faces):
    """The faces of one space, turned to look out of it, and which of them bound it: some models wind them at random, some draw faces
    across a space. By parity: a ray from just beside a face meets the others an odd number of times when it starts inside."""
    triangles = vertices[faces]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    turned, bounds = faces.copy(), np.ones(len(faces), dtype=bool)
    weights = np.array([0.37, 0.34, 0.29])  # not the middle: rays through edges count twice

    def inside(k, normal) -> bool:
        skew = normal + 0.1 * np.roll(normal, 1) + 0.01
        hit, t, _ = _hits(np, weights @ triangles[k] + 1e-5 * normal, skew / np.linalg.norm(skew), triangles)
        return int((np.diff(t, prepend=-1.0) > 1e-7).sum()) % 2 == 1 and len(hit) > 0

    for k in np.nonzero(length > 1e-12)[0]:
        normal = normals[k] / length[k]
        if inside(k, normal):
            turned[k] = faces[k][::-1]
            bounds[k] = not inside(k, -normal)
    return turned, bounds


@dataclass
class _Scene:
    """One model's spaces and walls as meshes about `centre`, and what the extraction made of it."""

    building: Any
    centre: Any
    spaces: Any  # trimesh
    room_of: Any  # per face of `spaces`
    walls: Any  # trimesh
    owner: Any  # product per face of `walls`
    wall_rays: Any
    polygons: dict  # room -> [(opening index, polygon)]


def _load(path: Path, np) -> _Scene | str:
    """The scene, or why there is none to judge."""
    import trimesh
    from enfilade.rules import ifc as reader
    from enfilade.rules import ifc_library
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    ifc = ifc_library.load()
    try:
        model = reader.open_model(path)
    except reader.IfcError as error:
        return str(error)
    building = reader.read_ifc(path, model=model, objects=False)
    number = {r.source_id: i for i, r in enumerate(building.rooms) if r.source_id}
    spaces = [s for s in model.by_type("IfcSpace") if s.GlobalId in number]
    if not spaces:
        return "no spaces"
    sv, sf, so = _triangles(ifc, np, model, spaces, False)
    bounds = np.ones(len(sf), dtype=bool)
    for space in np.unique(so):
        sf[so == space], bounds[so == space] = _outward(np, sv, sf[so == space])
    sf, so = sf[bounds], so[bounds]
    drawn = []
    for name in DRAWN:
        try:
            drawn += [e for e in model.by_type(name) if e.Representation is not None]
        except RuntimeError:
            pass
    wv, wf, wo = _triangles(ifc, np, model, drawn, True)
    if not len(wf):
        return "spaces, but nothing drawn"
    centre = 0.5 * (sv.min(axis=0) + sv.max(axis=0))
    walls = trimesh.Trimesh(wv - centre, wf, process=False)
    polygons = defaultdict(list)
    for n, o in enumerate(building.openings):
        for side, r in enumerate(o.rooms):
            polygons[r].append((n, (o.ends[side] if o.ends is not None else o.polygon) - centre))
    return _Scene(
        building, centre, trimesh.Trimesh(sv - centre, sf, process=False),
        np.array([number[model.by_id(int(i)).GlobalId] for i in so]), walls, wo,
        RayMeshIntersector(walls, scale_to_box=False), polygons,
    )  # fmt: skip


def _starts(scene: _Scene, rays: int, seed: int, np) -> tuple:
    """Where rays start, a little inside the spaces' faces, and where to: float64 (rays, 3) each."""
    rng = np.random.default_rng(seed)
    mesh = scene.spaces
    k = rng.choice(len(mesh.faces), rays, p=mesh.area_faces / mesh.area_faces.sum())
    u = rng.random((rays, 2))
    u = np.where(u.sum(axis=1, keepdims=True) > 1, 1 - u, u)
    tri = mesh.vertices[mesh.faces[k]]
    point = tri[:, 0] + u[:, :1] * (tri[:, 1] - tri[:, 0]) + u[:, 1:] * (tri[:, 2] - tri[:, 0])
    start = point - mesh.face_normals[k] * np.minimum(0.02 + rng.random((rays, 1)) * 1.5, 1.0) * 0.5
    direction = rng.normal(size=(rays, 3))
    direction[::2, 2] *= 0.15
    return start, direction / np.linalg.norm(direction, axis=1)[:, None]


def _reach(scene: _Scene, start, direction, np):
    """How far each ray gets before it meets something drawn: float64 (rays,). 0 where it begins inside a wall that its space
    overlaps (its first hit is a face seen from behind): nobody looks there."""
    hit_wall = np.full(len(start), FAR)
    face, ray, where = scene.wall_rays.intersects_id(start, direction, multiple_hits=False, return_locations=True)
    buried = ray[np.einsum("ij,ij->i", scene.walls.face_normals[face], direction[ray]) > 0.0]
    hit_wall[buried] = 0.0
    kept = ~np.isin(ray, buried)
    ray, where = ray[kept], where[kept]
    hit_wall[ray] = np.minimum(np.einsum("ij,ij->i", where - start[ray], direction[ray]), FAR)
    return hit_wall


def _crossings(scene: _Scene, start, direction, hit_wall, np) -> tuple:
    """Where rays cross the spaces' faces before they meet a wall, ray by ray, nearest first: faces, rays, distances."""
    from trimesh import Trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    found = []
    with np.errstate(divide="ignore"):
        inverse = 1.0 / direction
    # Room by room: where two rooms touch, one multi-hit query would see only one of the two faces.
    for r in np.unique(scene.room_of):
        mine = np.nonzero(scene.room_of == r)[0]
        one = Trimesh(scene.spaces.vertices, scene.spaces.faces[mine], process=False)
        low, high = (f(one.triangles.reshape(-1, 3), axis=0) for f in (np.min, np.max))
        t0, t1 = (low - 1e-3 - start) * inverse, (high + 1e-3 - start) * inverse
        near = np.minimum(t0, t1).max(axis=1)
        close = np.nonzero((near < hit_wall) & (np.maximum(t0, t1).min(axis=1) >= np.maximum(near, 0.0)))[0]
        if len(close):
            f, q, x = RayMeshIntersector(one, scale_to_box=False).intersects_id(
                start[close], direction[close], multiple_hits=True, max_hits=60, return_locations=True
            )
            found.append((mine[f], close[q], x))
    face, ray, where = (np.concatenate(part) for part in zip(*found, strict=False))
    t = np.einsum("ij,ij->i", where - start[ray], direction[ray])
    order = np.lexsort((t, ray))
    face, ray, t = face[order], ray[order], t[order]
    going_out = np.einsum("ij,ij->i", scene.spaces.face_normals[face], direction[ray]) > 0
    for _ in range(3):  # where rooms touch, leaving one and entering the next happen at one place: leaving comes first
        swap = np.nonzero((ray[1:] == ray[:-1]) & ~going_out[:-1] & going_out[1:] & (t[1:] - t[:-1] < 5e-3))[0]
        swap = swap[np.concatenate([[True], np.diff(swap) > 1])] if len(swap) else swap
        for values in (face, t, going_out):
            values[swap], values[swap + 1] = values[swap + 1].copy(), values[swap].copy()
    keep = t < hit_wall[ray] - 0.01
    return face[keep], ray[keep], t[keep]


def _passed(scene: _Scene, start, direction, ray, t, room, np) -> list[set[int]]:
    """Which openings each crossing of a room's boundary passes."""
    passed: list[set[int]] = [set() for _ in t]
    for r in np.unique(room):
        mine = np.nonzero(room == r)[0]
        o, d = start[ray[mine]], direction[ray[mine]]
        for n, polygon in scene.polygons[int(r)]:
            p0 = polygon[0]
            normal = sum(np.cross(polygon[i] - p0, polygon[i + 1] - p0) for i in range(1, len(polygon) - 1))
            normal = normal / np.linalg.norm(normal)
            with np.errstate(divide="ignore", invalid="ignore"):
                tp = ((p0 - o) @ normal) / (d @ normal)
            x = o + tp[:, None] * d
            inside = np.abs(tp - t[mine]) < 0.9
            for i in range(len(polygon)):
                a, b = polygon[i], polygon[(i + 1) % len(polygon)]
                outward = np.cross(b - a, normal)
                inside &= (x - a) @ (outward / np.linalg.norm(outward)) < TOLERANCE
            for m in mine[np.nonzero(inside)[0]]:
                passed[m].add(n)
    return passed


@dataclass
class _Flight:
    """All crossings of all rays, and what each of them passed."""

    scene: _Scene
    np: Any
    start: Any
    direction: Any
    hit_wall: Any
    face: Any
    ray: Any
    t: Any
    leaving: Any
    room: Any
    passed: list

    def square(self, m: int) -> float:
        """Cosine between a crossing's ray and its face."""
        return abs(float(self.scene.spaces.face_normals[self.face[m]] @ self.direction[self.ray[m]]))

    def place(self, m: int):
        where = self.start[self.ray[m]] + self.t[m] * self.direction[self.ray[m]] + self.scene.centre
        return where.round(3), self.direction[self.ray[m]].round(3)

    def until(self, m: int, end: int) -> float:
        """Where the ray meets the next face or the wall."""
        return float(self.t[m + 1] if m + 1 < end else self.hit_wall[self.ray[m]])

    def deep(self, m: int, end: int) -> bool:
        """Whether the ray gets farther into a room than a slit."""
        return (self.until(m, end) - self.t[m]) * self.square(m) > SLIT

    def counts(self, m: int) -> bool:
        scene, r = self.scene, self.ray[m]
        return _is_seen(self.np, self.start[r], self.direction[r], scene.walls.triangles, scene.owner, self.t[m])

    def judge(self, first: int, end: int) -> tuple[int, tuple | None]:
        """Of one ray's crossings: how many were tested, and its violation: kind, from, to, crossing, free flight."""
        rooms, openings = self.scene.building.rooms, self.scene.building.openings
        tested, out = 0, None
        entered: set[int] = set()  # and not left
        for m in range(first, end):
            here = int(self.room[m])
            if self.leaving[m]:
                entered.discard(here)
                if m == first and self.t[m] * self.square(m) < SLIT:
                    break  # begins in a slit
                tested += 1
                enters = next((q for q in range(m + 1, end) if not self.leaving[q] and self.room[q] != here), None)
                out = (here, self.passed[m])
                if self.passed[m]:
                    continue
                flight = (self.hit_wall[self.ray[m]] - self.t[m]) * self.square(m)
                # Within the overlap of two spaces the ray is in the other already: its own exit counts.
                if enters is not None and flight > TOLERANCE and self.deep(enters, end):
                    kind, target, proof = "room", rooms[int(self.room[enters])].name, enters
                elif flight > STAND_OFF + TOLERANCE:
                    kind, target, proof = "outside", "-", m
                else:
                    continue
                if not self.counts(proof):
                    break
                return tested, (kind, rooms[here].name, target, m, round(self.until(m, end) - float(self.t[m]), 3))
            from_there = any(r in openings[n].rooms for n in self.passed[m] for r in entered)  # spaces that overlap
            entered.add(here)
            if out is not None and here != out[0] and not from_there:
                a, b = out[1], self.passed[m]
                to_outside = [any(len(rooms) - 1 in openings[n].rooms for n in s) for s in (a, b)]
                if not (a & b) and not all(to_outside) and self.deep(m, end) and self.counts(m):
                    return tested, ("chain", rooms[out[0]].name, rooms[here].name, m, 0.0)
        return tested, None


def check(path: Path, rays: int, listed: int, seed: int) -> int:
    import numpy as np

    scene = _load(path, np)
    if isinstance(scene, str):
        print(f"{path.name:34s} {scene}")
        return 0
    start, direction = _starts(scene, rays, seed, np)
    hit_wall = _reach(scene, start, direction, np)
    face, ray, t = _crossings(scene, start, direction, hit_wall, np)
    leaving = np.einsum("ij,ij->i", scene.spaces.face_normals[face], direction[ray]) > 0
    room = scene.room_of[face]
    passed = _passed(scene, start, direction, ray, t, room, np)
    flight = _Flight(scene, np, start, direction, hit_wall, face, ray, t, leaving, room, passed)

    kinds, pairs, examples, tested = Counter(), defaultdict(Counter), {}, 0
    first = np.nonzero(np.concatenate([[True], ray[1:] != ray[:-1]]))[0] if len(ray) else []
    last = np.concatenate([first[1:], [len(ray)]]) if len(ray) else []
    for begin, end in zip(first, last, strict=False):
        more, violation = flight.judge(int(begin), int(end))
        tested += more
        if violation is not None:
            kind, *key, m, free = violation
            kinds[kind] += 1
            pairs[kind][tuple(key)] += 1
            examples.setdefault((kind, tuple(key)), (*flight.place(m), free))
    print(
        f"{path.name[:34]:34s} rays {rays:8d} crossings {tested:8d}  room {kinds['room']:5d}  chain {kinds['chain']:5d}"
        f"  outside {kinds['outside']:5d}"
    )
    for kind in ("room", "chain", "outside"):
        for key, n in pairs[kind].most_common(listed):
            where, d, free = examples[(kind, key)]
            print(f"    {kind:8s} {n:6d}  {key[0]} -> {key[1]}  at {where.tolist()} towards {d.tolist()} free {free}")
    return sum(kinds.values())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--libs", default=os.environ.get("ENFILADE_ORACLE_LIBS", ""))
    parser.add_argument("--list", type=int, default=6, help="violations to name per model and kind")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.libs:
        sys.path.insert(0, options.libs)
    try:
        import embreex  # noqa: F401
        import trimesh  # noqa: F401
    except ImportError as error:
        print(f"skipped: the oracle needs embreex and trimesh ({error}); install them into a folder and name it by --libs")
        return 0
    data = Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))
    files = [Path(f) for f in options.files] or sorted((data / "ifc").glob("*.ifc"))
    total = sum(check(f, options.rays, options.list, options.seed) for f in files)
    print(f"{total} violations")
    return 1 if total else 0


if __name__ == "__main__":
    sys.exit(main())
