# SPDX-License-Identifier: GPL-3.0-or-later
"""Independent oracle for rooms from geometry alone: no ray in free air may end at a face of the scene before it meets what is drawn.

Usage: /usr/bin/python3 tests/bench/geometry_oracle.py FILE.ifc ... [--mode S G] [--turn DEGREES] [--rays N] [--list K] [--seed N]

Drawn is all but doors, windows, furniture and terrain, voids cut out. Rays start anywhere in free air, in the building or up to 2 m round it,
and fly to the first drawn triangle (by Embree). Then the same ray walks through the cells that were made of what was found. `short`: it ends at a
wall of the cells, and flies on for more than SLACK in front of that wall: what it meets there may be hidden though it is seen. `nowhere` starts
lie in no cell: a camera there is given all.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
SLACK = 0.12  # m square to the face: what is drawn that near to a room counts as in it
FAR = 60.0  # m that a ray flies
PER_START = 50  # rays
NONE = 0xFFFFFFFF
AXES = np.concatenate([np.eye(3), -np.eye(3)])


def drawn_mesh(elements) -> tuple[np.ndarray, np.ndarray]:
    """All that blocks sight for certain: float64 (n, 3), int64 (m, 3)."""
    from enfilade.rules import geometry_elements as kinds

    solid = [e for e in elements if e.kind in (kinds.SHELL, kinds.STAIR, kinds.UNKNOWN) and len(e.triangles)]
    first = np.cumsum([0] + [len(e.vertices) for e in solid])
    return np.concatenate([e.vertices for e in solid]), np.concatenate([e.triangles + n for e, n in zip(solid, first, strict=False)])


def free_starts(native, mesh, vertices, count: int, random) -> np.ndarray:
    """Points in free air, float64 (count, 3): along the axes nothing is met from behind, and nothing within 5 cm."""
    low, high = vertices.min(axis=0) - (2.0, 2.0, 0.0), vertices.max(axis=0) + (2.0, 2.0, 1.0)
    found: list[np.ndarray] = []
    while sum(map(len, found)) < count:
        points = random.uniform(low, high, (4 * count, 3))
        fine = np.ones(len(points), dtype=bool)
        for axis in AXES:
            way = np.broadcast_to(axis, points.shape)
            hit = mesh.hit(points, way)
            met = np.isfinite(hit["distance"])
            fine &= ~met | ((np.einsum("ij,ij->i", hit["normal"], way) < 0.0) & (hit["distance"] > 0.05))
        found.append(points[fine])
    return np.concatenate(found)[:count]


def farthest(scene, caster, start: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The walk that gets farthest, from any of the cells that hold a ray's start: a camera there looks from all of them."""
    best = caster.shoot(start, way, FAR)
    held = [scene.locate(p) for p in start[::PER_START]]
    for k in range(1, max(map(len, held))):
        cells = np.array([c[k] if k < len(c) else NONE for c in held]).repeat(PER_START)
        mine = np.nonzero(cells != NONE)[0]
        first = np.array([c[0] for c in held]).repeat(PER_START)[mine]
        for these in (first, cells[mine]) if k == 1 else (cells[mine],):
            hit = caster.shoot(start[mine], way[mine], FAR, these)
            better = hit["distance"] > best["distance"][mine]
            best[mine[better]] = hit[better]
    return onward(scene, caster, start, way, best)


def onward(scene, caster, start: np.ndarray, way: np.ndarray, hit: np.ndarray) -> np.ndarray:
    """Where a walk ends in one of several openings that lie over each other, it goes on in the others: a view passes through all of them."""
    passage = np.array(scene.cell_openings) != NONE
    for _ in range(4):
        ended = np.nonzero((hit["surface"] < caster.face_count) & (hit["cell"] != NONE))[0]
        ended = ended[passage[hit["cell"][ended]]]
        for k in ended.tolist():
            at = start[k] + (hit["distance"][k] - 1e-4) * way[k]
            for cell in scene.locate(at).tolist():
                if passage[cell] and cell != hit["cell"][k]:
                    further = caster.shoot(at[None], way[k][None], FAR, np.array([cell]))[0]
                    if further["distance"] > 2e-4:
                        further["distance"] += hit["distance"][k] - 1e-4
                        hit[k] = further if further["distance"] > hit["distance"][k] else hit[k]
    return hit


def check(path: str, mode: str, turn: float, rays: int, listed: int, seed: int) -> int:
    import enfilade_native as native
    from enfilade.rules import assemble, geometry, geometry_frame

    drawn = geometry.elements_of_ifc(path, mode=geometry.TRIANGLES)
    given = geometry.elements_of_ifc(path) if mode == "S" else [geometry.soup(drawn)]
    rotation = geometry_frame.rotation(turn)
    building = geometry.detect([e.moved(rotation, np.zeros(3)) for e in given], mode=geometry.CLASSES if mode == "S" else geometry.TRIANGLES)
    made = assemble.assemble(native, building)
    vertices, triangles = drawn_mesh([e.moved(rotation, np.zeros(3)) for e in drawn])
    mesh = native.Triangles(vertices.mean(axis=0))
    mesh.add_material(native.Material())
    mesh.add_mesh(0, vertices, triangles)
    mesh.commit()
    random = np.random.default_rng(seed)
    start = free_starts(native, mesh, vertices, max(1, rays // PER_START), random).repeat(PER_START, axis=0)
    way = random.normal(size=start.shape)
    way /= np.linalg.norm(way, axis=1)[:, None]
    free = mesh.hit(start, way, np.full(len(start), FAR))["distance"]
    caster = native.Raycaster(made.scene)
    hit = farthest(made.scene, caster, start, way)
    nowhere = hit["cell"] == NONE
    wall = (hit["surface"] < caster.face_count) & ~nowhere
    early = wall & (np.minimum(free, FAR) - hit["distance"] > SLACK)
    normal = np.zeros_like(way)
    normal[early] = caster.normals(hit["surface"][early])
    square = np.abs(np.einsum("ij,ij->i", normal, way)) * (np.minimum(free, FAR) - hit["distance"])
    early &= square > SLACK
    print(f"{Path(path).stem[:34]:34s} {mode} {turn:4.0f}  rays {len(start):7d}  short {early.sum():6d}  nowhere {nowhere.sum():6d}", flush=True)
    name = np.array([r.name for r in building.rooms] + ["opening"], dtype=object)
    room = np.minimum(np.array(made.scene.cell_rooms), len(building.rooms))
    where = start + hit["distance"][:, None] * way
    kinds = Counter(zip(name[room[hit["cell"][early]]], map(tuple, normal[early].round(1)), strict=True))
    for (cell, n), times in kinds.most_common(listed):
        mine = np.nonzero(early & (name[np.where(nowhere, -1, room[np.minimum(hit["cell"], len(room) - 1)])] == cell) & (normal.round(1) == n).all(axis=1))[0]
        k = mine[np.argmax(square[mine])]
        print(f"    {times:6d}  {cell} faces {n}: from {start[k].round(2).tolist()} ends {where[k].round(2).tolist()}, {square[k]:.2f} m before a drawn face")
    return int(early.sum())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--mode", nargs="+", default=["S", "G"], choices=["S", "G"])
    parser.add_argument("--turn", type=float, default=0.0)
    parser.add_argument("--rays", type=int, default=100_000)
    parser.add_argument("--list", type=int, default=6, help="kinds of short rays to name")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    short = 0
    for path in options.files:
        for mode in options.mode:
            short += check(path, mode, options.turn, options.rays, options.list, options.seed)
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
