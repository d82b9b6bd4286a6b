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
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "plugin"))

DRAWN = (
    "IfcWall", "IfcSlab", "IfcRoof", "IfcCurtainWall", "IfcPlate", "IfcMember", "IfcCovering", "IfcColumn", "IfcBeam",
    "IfcFooting", "IfcBuildingElementProxy",
)  # fmt: skip
STAND_OFF = 0.1  # m
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


def check(path: Path, rays: int, listed: int, seed: int) -> int:
    import numpy as np
    import trimesh
    from enfilade.rules import ifc as reader
    from enfilade.rules import ifc_library
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    ifc = ifc_library.load()
    try:
        model = reader.open_model(path)
    except reader.IfcError as error:
        print(f"{path.name:34s} {error}")
        return 0
    building = reader.read_ifc(path, model=model, objects=False)
    number = {r.source_id: i for i, r in enumerate(building.rooms) if r.source_id}
    spaces = [s for s in model.by_type("IfcSpace") if s.GlobalId in number]
    if not spaces:
        print(f"{path.name:34s} no spaces")
        return 0
    sv, sf, so = _triangles(ifc, np, model, spaces, False)
    room_of = np.array([number[model.by_id(int(i)).GlobalId] for i in so])
    drawn = []
    for name in DRAWN:
        try:
            drawn += [e for e in model.by_type(name) if e.Representation is not None]
        except RuntimeError:
            pass
    wv, wf, wo = _triangles(ifc, np, model, drawn, True)
    centre = 0.5 * (sv.min(axis=0) + sv.max(axis=0))
    space_mesh = trimesh.Trimesh(sv - centre, sf, process=False)
    wall_mesh = trimesh.Trimesh(wv - centre, wf, process=False)
    wall_rays = RayMeshIntersector(wall_mesh, scale_to_box=False)

    polygons = defaultdict(list)  # room -> (opening index, polygon)
    for n, o in enumerate(building.openings):
        for side, r in enumerate(o.rooms):
            polygons[r].append((n, (o.ends[side] if o.ends is not None else o.polygon) - centre))

    rng = np.random.default_rng(seed)
    area = space_mesh.area_faces
    k = rng.choice(len(sf), rays, p=area / area.sum())
    u = rng.random((rays, 2))
    u = np.where(u.sum(axis=1, keepdims=True) > 1, 1 - u, u)
    tri = space_mesh.vertices[space_mesh.faces[k]]
    point = tri[:, 0] + u[:, :1] * (tri[:, 1] - tri[:, 0]) + u[:, 1:] * (tri[:, 2] - tri[:, 0])
    inward = -space_mesh.face_normals[k]
    start = point + inward * np.minimum(0.02 + rng.random((rays, 1)) * 1.5, 1.0) * 0.5
    direction = rng.normal(size=(rays, 3))
    direction[::2, 2] *= 0.15
    direction /= np.linalg.norm(direction, axis=1)[:, None]

    far = 80.0
    hit_wall = np.full(rays, far)
    face, ray, where = wall_rays.intersects_id(start, direction, multiple_hits=False, return_locations=True)
    # A ray whose first hit is a face seen from behind began inside a wall that its space overlaps: nobody looks there.
    buried = ray[np.einsum("ij,ij->i", wall_mesh.face_normals[face], direction[ray]) > 0.0]
    hit_wall[buried] = 0.0
    kept = ~np.isin(ray, buried)
    ray, where = ray[kept], where[kept]
    hit_wall[ray] = np.minimum(np.einsum("ij,ij->i", where - start[ray], direction[ray]), far)
    # Room by room: where two rooms touch, one multi-hit query would see only one of the two faces.
    found = []
    with np.errstate(divide="ignore"):
        inverse = 1.0 / direction
    for r in np.unique(room_of):
        mine = np.nonzero(room_of == r)[0]
        one = trimesh.Trimesh(space_mesh.vertices, space_mesh.faces[mine], process=False)
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
    going_out = np.einsum("ij,ij->i", space_mesh.face_normals[face], direction[ray]) > 0
    for _ in range(3):  # where rooms touch, leaving one and entering the next happen at one place: leaving comes first
        swap = np.nonzero((ray[1:] == ray[:-1]) & ~going_out[:-1] & going_out[1:] & (t[1:] - t[:-1] < 5e-3))[0]
        swap = swap[np.concatenate([[True], np.diff(swap) > 1])] if len(swap) else swap
        for values in (face, t, going_out):
            values[swap], values[swap + 1] = values[swap + 1].copy(), values[swap].copy()
    keep = t < hit_wall[ray] - 0.01
    face, ray, t = face[keep], ray[keep], t[keep]
    leaving = np.einsum("ij,ij->i", space_mesh.face_normals[face], direction[ray]) > 0
    room = room_of[face]

    # Which openings a crossing of a room's boundary passes.
    passed: list[set[int]] = [set() for _ in t]
    for r in np.unique(room):
        mine = np.nonzero(room == r)[0]
        o, d = start[ray[mine]], direction[ray[mine]]
        for n, polygon in polygons[int(r)]:
            normal = np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0)
            p0 = polygon[0]
            normal = sum(np.cross(polygon[i] - p0, polygon[i + 1] - p0) for i in range(1, len(polygon) - 1))
            normal = normal / np.linalg.norm(normal)
            slope = d @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                tp = ((p0 - o) @ normal) / slope
            x = o + tp[:, None] * d
            inside = np.abs(tp - t[mine]) < 0.9
            for i in range(len(polygon)):
                a, b = polygon[i], polygon[(i + 1) % len(polygon)]
                outward = np.cross(b - a, normal)
                outward = outward / np.linalg.norm(outward)
                inside &= (x - a) @ outward < TOLERANCE
            for m in mine[np.nonzero(inside)[0]]:
                passed[m].add(n)

    kinds, pairs, examples = Counter(), defaultdict(Counter), {}
    first = np.nonzero(np.concatenate([[True], ray[1:] != ray[:-1]]))[0] if len(ray) else []
    last = np.concatenate([first[1:], [len(ray)]]) if len(ray) else []
    tested = 0
    for f, e in zip(first, last, strict=False):

        def counts(m: int) -> bool:
            return _is_seen(np, start[ray[m]], direction[ray[m]], wall_mesh.triangles, wo, t[m])

        def deep(q: int, end: int) -> bool:
            """Whether the ray gets farther into a room than a slit."""
            leaves = t[q + 1] if q + 1 < end else hit_wall[ray[q]]
            return (leaves - t[q]) * abs(float(space_mesh.face_normals[face[q]] @ direction[ray[q]])) > SLIT

        out: tuple[int, set[int]] | None = None
        for m in range(f, e):
            if leaving[m]:
                if m == f and t[m] * abs(float(space_mesh.face_normals[face[m]] @ direction[ray[m]])) < SLIT:
                    break  # begins in a slit
                tested += 1
                nxt = t[m + 1] if m + 1 < e else hit_wall[ray[m]]
                normal = space_mesh.face_normals[face[m]]
                flight = (hit_wall[ray[m]] - t[m]) * float(normal @ direction[ray[m]])
                enters = next((q for q in range(m + 1, e) if not leaving[q] and room[q] != room[m]), None)
                out = (int(room[m]), passed[m])
                if not passed[m]:
                    # Within the overlap of two spaces the ray is in the other already: its own exit counts.
                    if enters is not None and flight > TOLERANCE and deep(enters, e):
                        kind = "room"
                        target = building.rooms[int(room[enters])].name
                    elif flight > STAND_OFF + TOLERANCE:
                        kind, target = "outside", "-"
                    else:
                        continue
                    if not counts(m if kind == "outside" else enters):
                        break
                    key = (building.rooms[int(room[m])].name, target)
                    kinds[kind] += 1
                    pairs[kind][key] += 1
                    where = start[ray[m]] + t[m] * direction[ray[m]] + centre
                    examples.setdefault((kind, key), (where.round(3), direction[ray[m]].round(3), round(float(nxt - t[m]), 3)))
                    break
            elif out is not None and room[m] != out[0]:
                a, b = out[1], passed[m]
                ext = len(building.rooms) - 1
                to_outside = [any(ext in building.openings[n].rooms for n in s) for s in (a, b)]
                if not (a & b) and not all(to_outside) and deep(m, e) and counts(m):
                    key = (building.rooms[out[0]].name, building.rooms[int(room[m])].name)
                    kinds["chain"] += 1
                    pairs["chain"][key] += 1
                    where = start[ray[m]] + t[m] * direction[ray[m]] + centre
                    examples.setdefault(("chain", key), (where.round(3), direction[ray[m]].round(3), 0.0))
                    break
    print(
        f"{path.name[:34]:34s} rays {rays:8d} crossings {tested:8d}  room {kinds['room']:5d}  chain {kinds['chain']:5d}"
        f"  outside {kinds['outside']:5d}"
    )
    for kind in ("room", "chain", "outside"):
        for key, n in pairs[kind].most_common(listed):
            where, d, flight = examples[(kind, key)]
            print(f"    {kind:8s} {n:6d}  {key[0]} -> {key[1]}  at {where.tolist()} towards {d.tolist()} free {flight}")
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
