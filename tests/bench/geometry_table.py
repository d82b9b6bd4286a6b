# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges rooms and openings found from geometry alone against the spaces that were withheld.

Usage: /usr/bin/python3 tests/bench/geometry_table.py [FILE.ifc ...] [--mode S G] [--turn 0 17] [--gap M] [--json FILE] [--verbose]
Each model, mode and turn runs in a process of its own, so that peak memory is its own too.

Truth: the file's spaces, and the openings that `--source ifc` finds between them. Spaces that touch openly (more than
0.5 m2 without a wall) are one group; so are found rooms joined by virtual openings. Columns:
  groups   ref groups above 3 m2 whose plan, cut 1.2 m above each of their floors, overlaps one found group's by >= 0.8 (IoU)
  strict   the same, space by space against room by room
  doors    doors between two different groups (or a group and outdoors) that join the found rooms of just those two
  false    found doors, windows and holes that lie nowhere near a void, door or window of the file and whose middle is
           blocked by a drawn wall / of all found
  holes    voids that lie wholly inside found openings wherever one can look straight through them (9 x 9 samples), of those with
           two different found rooms beside them
Nothing here uses the detector's own grids: plans are cut from the rooms' faces, positions from the openings' corners.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
MODELS = ("Office_A_20110811", "AC11-Institute-Var-2-IFC", "231110AC-11-Smiley-West-04-07-2007", "Duplex_A", "AC20-FZK-Haus")
STEP = 0.1  # m, raster of the plans that are compared
CUT = 1.2  # m above a floor
SAME_FLOOR = 0.6  # m
LEAST = 3.0  # m2
OPEN_CONTACT = 0.5  # m2
OVERLAP = 0.8


def data_folder() -> Path:
    return Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))


# ---- plans ---------------------------------------------------------------------------------------------------
def cut_segments(vertices: np.ndarray, faces: list[list[int]] | None, z: float) -> np.ndarray:
    """The outline of a solid at height z as segments (n, 2, 2), by its faces' crossings."""
    if faces is None:
        return _hull_segments(vertices, z)
    out = []
    for face in faces:
        p = vertices[list(face)]
        q = np.roll(p, -1, axis=0)
        up = (p[:, 2] > z) != (q[:, 2] > z)
        if not up.any():
            continue
        a, b = p[up], q[up]
        t = ((z - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None]
        points = a[:, :2] + t * (b[:, :2] - a[:, :2])
        spread = np.ptp(points, axis=0)
        points = points[np.argsort(points[:, int(np.argmax(spread))], kind="stable")]
        out += [points[k : k + 2] for k in range(0, len(points) - 1, 2)]
    return np.array(out).reshape(-1, 2, 2)


def _hull_segments(vertices: np.ndarray, z: float) -> np.ndarray:
    from enfilade.rules import convex_polygons as cp

    up, down = vertices[vertices[:, 2] > z], vertices[vertices[:, 2] <= z]
    points = [a[:2] + (z - a[2]) / (b[2] - a[2]) * (b[:2] - a[:2]) for a in down for b in up]
    hull = cp.hull(points)
    return np.array([(hull[i - 1], hull[i]) for i in range(len(hull))]).reshape(-1, 2, 2)


class Plan:
    """A raster: cell centres at origin + (i + 0.5) * STEP."""

    def __init__(self, low: np.ndarray, high: np.ndarray) -> None:
        self.origin = low[:2] - 1.0
        self.shape = tuple(np.ceil((high[:2] - low[:2] + 2.0) / STEP).astype(int)[::-1])

    def fill(self, segments: np.ndarray) -> np.ndarray:
        """Even-odd along rows."""
        mask = np.zeros(self.shape, dtype=bool)
        if not len(segments):
            return mask
        s = (segments - self.origin) / STEP - 0.5
        rows: dict[int, list[float]] = {}
        for (x0, y0), (x1, y1) in s:
            if y0 == y1:
                continue
            lo, hi = (y0, y1) if y0 < y1 else (y1, y0)
            for r in range(max(0, int(np.ceil(lo))), min(self.shape[0] - 1, int(np.ceil(hi)) - 1) + 1):
                rows.setdefault(r, []).append(x0 + (r - y0) / (y1 - y0) * (x1 - x0))
        for r, xs in rows.items():
            xs.sort()
            for a, b in zip(xs[::2], xs[1::2], strict=False):
                mask[r, max(0, int(np.ceil(a))) : max(0, int(np.floor(b)) + 1)] = True
        return mask


# ---- truth ---------------------------------------------------------------------------------------------------
def turned(points: np.ndarray | None, angle: float) -> np.ndarray | None:
    if points is None or angle == 0.0:
        return points
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T


def truth_of(path: str, turn: float):
    from enfilade.rules import ifc

    building, outcomes = ifc.read_with_outcomes(path, objects=False, local=True)
    for room in building.rooms:
        room.vertices = turned(room.vertices, turn)
    for o in building.openings:
        o.body, o.polygon = turned(o.body, turn), turned(o.polygon, turn)
        o.ends = tuple(turned(e, turn) for e in o.ends) if o.ends else None
    return building, outcomes


def groups_of(building, vertical_too: bool = True) -> list[int]:
    """The group of each room: joined by virtual openings above OPEN_CONTACT; the exterior stays alone."""
    parent = list(range(len(building.rooms)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    areas: dict[tuple[int, int], float] = {}
    for o in building.openings:
        polygon = o.polygon if o.polygon is not None else o.ends[0] if o.ends is not None else None
        if o.kind != "virtual" or o.rooms is None or polygon is None:
            continue
        if any(building.rooms[r].kind == "exterior" for r in o.rooms):
            continue
        normal = np.cross(polygon - polygon[0], np.roll(polygon, -1, axis=0) - polygon[0]).sum(axis=0)
        key = tuple(sorted(o.rooms))
        areas[key] = areas.get(key, 0.0) + 0.5 * float(np.linalg.norm(normal))
    for (a, b), size in areas.items():
        if size > OPEN_CONTACT:
            parent[root(a)] = root(b)
    return [root(i) for i in range(len(parent))]


def plans(building, plan: Plan, z: float) -> np.ndarray:
    """Room index per raster cell at height z, -1: none. Where rooms overlap the first one counts."""
    labels = np.full(plan.shape, -1)
    for i, room in enumerate(building.rooms):
        if room.vertices is None or room.kind == "exterior" or not len(room.vertices):
            continue
        if room.vertices[:, 2].min() < z < room.vertices[:, 2].max():
            mask = plan.fill(cut_segments(np.asarray(room.vertices), room.faces, z))
            labels[mask & (labels < 0)] = i
    return labels


def compare(truth, found, verbose: bool) -> dict:
    interior = [i for i, r in enumerate(truth.rooms) if r.kind != "exterior" and r.vertices is not None]
    corners = np.concatenate([truth.rooms[i].vertices for i in interior] +
                             [r.vertices for r in found.rooms if r.vertices is not None and len(r.vertices)])
    plan = Plan(corners.min(axis=0), corners.max(axis=0))
    truth_group, found_group = np.array(groups_of(truth)), np.array(groups_of(found))
    floors = sorted((float(truth.rooms[i].vertices[:, 2].min()), i) for i in interior)
    cache: dict[float, tuple[np.ndarray, np.ndarray]] = {}

    def cut(z: float) -> tuple[np.ndarray, np.ndarray]:
        key = round(z, 2)
        if key not in cache:
            cache[key] = plans(truth, plan, key), plans(found, plan, key)
        return cache[key]

    def best(mask: np.ndarray, labels: np.ndarray) -> tuple[int, float]:
        inside, counts = np.unique(labels[mask], return_counts=True)
        result = (-1, 0.0)
        for label, common in zip(inside, counts, strict=True):
            if label >= 0:
                share = common / (mask.sum() + (labels == label).sum() - common)
                result = max(result, (int(label), float(share)), key=lambda x: x[1])
        return result

    parts: dict[int, list[tuple[float, float]]] = {}  # group -> (area, overlap) by floor
    strict, spaces, misses = 0, 0, []
    home: dict[int, dict[int, float]] = {}  # found group -> area by truth group
    done: set[tuple[int, float]] = set()
    for floor, i in floors:
        t, f = cut(floor + CUT)
        mask = t == i
        area = mask.sum() * STEP**2
        if area >= LEAST:
            spaces += 1
            strict += best(mask, f)[1] >= OVERLAP
        g = truth_group[i]
        level = next((z for k, z in done if k == g and abs(z - floor) < SAME_FLOOR), None)
        if level is None:
            done.add((g, floor))
            tg = np.where(t >= 0, truth_group[t], -1)
            fg = np.where(f >= 0, found_group[f], -1)
            mask = tg == g
            label, share = best(mask, fg)
            parts.setdefault(int(g), []).append((mask.sum() * STEP**2, share))
            for other in np.unique(fg[mask]):
                home.setdefault(int(other), {}).setdefault(int(g), 0.0)
                home[int(other)][int(g)] += float((mask & (fg == other)).sum())
            if share < OVERLAP and mask.sum() * STEP**2 >= LEAST:
                misses.append((truth.rooms[i].name, round(floor, 2), round(mask.sum() * STEP**2, 1), round(share, 2)))
    judged = {g: p for g, p in parts.items() if sum(a for a, _ in p) >= LEAST}
    good = sum(all(share >= OVERLAP for area, share in p if area >= LEAST) for p in judged.values())
    where = {k: max(v, key=lambda g: v[g]) for k, v in home.items() if k >= 0}
    if verbose:
        print("  groups missed (first room, floor, m2, overlap):", misses, file=sys.stderr)
    return {"groups": len(judged), "groups_good": good, "spaces": spaces, "strict": strict, "where": where,
            "found_group": found_group, "truth_group": truth_group}


# ---- doors and holes -------------------------------------------------------------------------------------------
def corners_of(o) -> np.ndarray:
    return np.concatenate([x for x in (o.body, o.polygon) if x is not None] + (list(o.ends) if o.ends else []))


class Found:
    """The found openings by where they are."""

    def __init__(self, building) -> None:
        self.building = building
        self.boxes = [(k, corners_of(o)) for k, o in enumerate(building.openings) if o.rooms is not None]
        self.lows = np.array([b.min(axis=0) for _, b in self.boxes]).reshape(-1, 3)
        self.highs = np.array([b.max(axis=0) for _, b in self.boxes]).reshape(-1, 3)

    def near(self, low: np.ndarray, high: np.ndarray, reach: float) -> list[int]:
        hit = (self.lows <= high + reach).all(axis=1) & (self.highs >= low - reach).all(axis=1)
        return [self.boxes[k][0] for k in np.nonzero(hit)[0]]


def judge_openings(truth, outcomes, found, c: dict, verbose: bool, blockers) -> dict:
    there = Found(found)
    drawn: dict[str, list] = {}
    for o in truth.openings:
        if o.rooms is not None and o.kind != "virtual":
            drawn.setdefault(o.source_id, []).append(o)
    doors, wrong = judge_doors(truth, outcomes, there, c, drawn)
    holes, gaps = judge_holes(truth, there)
    places = [corners_of(o) for openings in drawn.values() for o in openings]
    count, odd, lies = judge_found(found, places, blockers)
    if verbose:
        for title, lines in (("doors wrong (name, wanted, got, where)", wrong),
                             ("holes not covered (name, where, share, rooms beside)", gaps),
                             ("false portals (name, where, size)", lies)):
            print(f"  {title}:", *lines[:12], "..." if len(lines) > 12 else "", sep="\n    ", file=sys.stderr)
    return {"doors": doors, "doors_good": doors - len(wrong), "holes": holes, "covered": holes - len(gaps), "found": count, "false": len(lies),
            "elsewhere": odd}


def judge_doors(truth, outcomes, there: Found, c: dict, drawn: dict[str, list]) -> tuple[int, list]:
    """How many there are, and those that don't join what they should."""
    exterior = {i for i, r in enumerate(truth.rooms) if r.kind == "exterior"}
    found_out = {i for i, r in enumerate(there.building.rooms) if r.kind == "exterior"}

    def side(room: int) -> int:
        return -1 if room in found_out else c["where"].get(int(c["found_group"][room]), -2)

    doors, wrong = 0, []
    for outcome in outcomes:
        if outcome.kind != "door" or outcome.source_id not in drawn:
            continue
        doors += 1
        openings = drawn[outcome.source_id]
        pairs = {tuple(sorted(-1 if r in exterior else int(c["truth_group"][r]) for r in o.rooms)) for o in openings}
        points = np.concatenate([corners_of(o) for o in openings])
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        got = {tuple(sorted(side(r) for r in there.building.openings[k].rooms)) for k in there.near(middle, middle, 0.1)}
        if not (pairs & got) and (got or any(a != b for a, b in pairs)):
            wrong.append((outcome.product, [tuple(truth.rooms[r].name if r >= 0 else "out" for r in p) for p in pairs],
                          [tuple(truth.rooms[r].name if r >= 0 else "out" if r == -1 else "?" for r in p) for p in got],
                          middle.round(1).tolist()))
    return doors, wrong


def judge_holes(truth, there: Found) -> tuple[int, list]:
    """How many voids have different found rooms beside them, and those that aren't covered."""
    holes, gaps = 0, []
    for o in truth.openings:
        if o.kind == "virtual" or o.ends is None:
            continue
        a, _ = o.ends
        axis = np.cross(a - a[0], np.roll(a, -1, axis=0) - a[0]).sum(axis=0)
        axis /= np.linalg.norm(axis)
        corners = corners_of(o)
        middle = corners.mean(axis=0)
        reach = 0.5 * float(np.ptp(corners @ axis)) + 0.25
        sides = [room_at(there.building, middle + s * reach * axis) for s in (-1.0, 1.0)]
        if sides[0] == sides[1]:
            continue  # one room on both sides: nothing to cover
        holes += 1
        inside = covered(o, axis, there)
        if not inside.all():
            gaps.append((o.name, middle.round(2).tolist(), round(float(inside.mean()), 2), sides))
    return holes, gaps


def covered(o, axis: np.ndarray, there: Found) -> np.ndarray:
    """Which samples of what one can look straight through lie in a found opening: what lies in both ends (a gap between hole and space widens one of
    them)."""
    hint = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    u = np.cross(hint, axis)
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    both = [np.column_stack([end @ u, end @ v]) for end in o.ends]
    low, high = np.max([e.min(axis=0) for e in both], axis=0), np.min([e.max(axis=0) for e in both], axis=0)
    grid = np.array([(low[0] + s * (high[0] - low[0]), low[1] + t * (high[1] - low[1]))
                     for s in np.linspace(0.01, 0.99, 9) for t in np.linspace(0.01, 0.99, 9)])
    grid = grid[in_hull(grid, both[0], 0.0) & in_hull(grid, both[1], 0.0)]
    inside = np.zeros(len(grid), dtype=bool)
    for k in there.near(corners_of(o).min(axis=0), corners_of(o).max(axis=0), 0.05):
        points = corners_of(there.building.openings[k])
        inside |= in_hull(grid, np.column_stack([points @ u, points @ v]), 2e-3)
    return inside


def judge_found(found, places: list[np.ndarray], blockers) -> tuple[int, int, list]:
    """How many openings were found, how many of them where none is drawn, and those of these that a wall blocks."""
    low = np.array([p.min(axis=0) for p in places]).reshape(-1, 3) - 0.3
    high = np.array([p.max(axis=0) for p in places]).reshape(-1, 3) + 0.3
    count, odd, lies = 0, 0, []
    for o in found.openings:
        if o.rooms is None or o.kind == "virtual":
            continue
        count += 1
        points = corners_of(o)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        if ((low <= middle) & (high >= middle)).all(axis=1).any():
            continue
        odd += 1
        ends = o.ends if o.ends is not None else (o.polygon, o.polygon)
        a, b = ends[0].mean(axis=0), ends[1].mean(axis=0)
        n = b - a
        if np.linalg.norm(n) < 1e-6:
            n = np.cross(o.polygon[1] - o.polygon[0], o.polygon[2] - o.polygon[0])
        n = n / np.linalg.norm(n)
        if blockers.first_hit((a - 0.02 * n)[None], (b + 0.02 * n)[None])[0] <= 1.0:
            lies.append((o.name, middle.round(2).tolist(), np.ptp(points, axis=0).round(2).tolist()))
    return count, odd, lies


def in_hull(points: np.ndarray, corners: np.ndarray, margin: float) -> np.ndarray:
    from enfilade.rules import convex_polygons as cp

    hull = cp.hull(corners)
    if len(hull) < 3:
        return np.zeros(len(points), dtype=bool)
    return np.array([cp.contains(hull, tuple(p), margin) for p in points])


def room_at(building, point: np.ndarray) -> int:
    """The room that holds a point, by parity of crossings in the plan at its height; -1: none."""
    for i, room in enumerate(building.rooms):
        if room.vertices is None or room.kind == "exterior" or not len(room.vertices):
            continue
        if (room.vertices.min(axis=0) > point).any() or (room.vertices.max(axis=0) < point).any():
            continue
        s = cut_segments(np.asarray(room.vertices), room.faces, float(point[2]))
        a, b = s[:, 0], s[:, 1]
        cross = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
        x = a[cross, 0] + (point[1] - a[cross, 1]) / (b[cross, 1] - a[cross, 1]) * (b[cross, 0] - a[cross, 0])
        if (x > point[0]).sum() % 2:
            return i
    return -1


# ---- one run -------------------------------------------------------------------------------------------------
def shortened(element, gap: float):
    """An upright wall that ends `gap` m before its neighbours; anything else as it is."""
    size = np.ptp(element.vertices, axis=0)
    along = int(size[1] > size[0])
    if element.kind != "shell" or element.passage is not None or size[1 - along] > 0.5 or size[2] < 1.5 or size[along] < 1.0:
        return element
    vertices = element.vertices.copy()
    middle = 0.5 * (vertices[:, along].min() + vertices[:, along].max())
    vertices[:, along] = middle + (vertices[:, along] - middle) * (1.0 - 2.0 * gap / size[along])
    return replace(element, vertices=vertices)


def measure(path: str, mode: str, turn: float, verbose: bool, furniture: bool, gap: float) -> dict:
    from enfilade.rules import blockers as rules_blockers
    from enfilade.rules import geometry, ifc
    from enfilade.rules.ifc_placement import model_offset
    from enfilade.rules.ifc_units import length_unit

    start = time.perf_counter()
    how = geometry.CLASSES if mode == "S" else geometry.TRIANGLES
    elements = geometry.elements_of_ifc(path, furniture, how)
    read = time.perf_counter() - start
    if gap:
        elements = [shortened(e, gap) for e in elements]
    matrix = turned(np.eye(3), turn).T
    elements = [e.moved(matrix, np.zeros(3)) for e in elements]
    if mode == "G":
        elements = [geometry.soup(elements)]
    begin = time.perf_counter()
    found = geometry.detect(elements)
    seconds = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    truth, outcomes = truth_of(path, turn)
    if not any(r.kind != "exterior" for r in truth.rooms):
        return {"read_s": read, "seconds": seconds, "mib": peak, "rooms": len(found.rooms) - 1, "found": len(found.openings)}
    c = compare(truth, found, verbose)
    model = ifc.open_model(path)
    shapes = [s for s in ifc.ifc_elements.shapes(model, model_offset(model, length_unit(model)))
              if any(s.product.is_a(k) for k in ("IfcWall", "IfcSlab", "IfcRoof", "IfcColumn"))]
    for s in shapes:
        s._world = turned(s.world, turn)
    o = judge_openings(truth, outcomes, found, c, verbose, rules_blockers.Blockers(shapes))
    for key in ("where", "found_group", "truth_group"):
        c.pop(key)
    return {**c, **o, "rooms": len(found.rooms) - 1, "voids": int(found.statistics["voids"]), "read_s": read, "seconds": seconds,
            "mib": peak, "virtual": sum(x.kind == "virtual" for x in found.openings), "mode": found.statistics.get("mode", 0),
            "cells": cells_of(found), "stages": found.statistics}


def cells_of(found) -> list[int] | None:
    """Cells of all rooms, and rooms the core refused."""
    from enfilade.rules import assemble

    try:
        import enfilade_native as native

        made = assemble.assemble(native, found)
    except (ImportError, OSError, RuntimeError) as error:
        print(f"  cells: {error}", file=sys.stderr)
        return None
    return [sum(len(c) for c in made.room_cells), sum(p.code == "shape-refused" for p in made.problems)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--mode", nargs="+", default=["S", "G"], choices=["S", "G"])
    parser.add_argument("--turn", nargs="+", type=float, default=[0.0, 17.0])
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("--furniture", action="store_true", help="furniture in the soup too")
    parser.add_argument("--gap", type=float, default=0.0, help="metres by which walls end before their neighbours: see the column strict")
    parser.add_argument("--json", help="write the figures there")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.files[0], options.mode[0], options.turn[0], options.verbose, options.furniture, options.gap)))
        return 0
    sys.stdout.reconfigure(line_buffering=True)
    files = [Path(f) for f in options.files] or [data_folder() / "ifc" / f"{m}.ifc" for m in MODELS]
    rows, total = [], {}
    print(f"{'model':26s} mode turn  groups   strict   doors    holes    false  elsewhere virtual rooms+voids cells(refused) seconds(read)  MiB")
    for mode in options.mode:
        for turn in options.turn:
            for path in files:
                command = [sys.executable, __file__, "--one", str(path), "--mode", mode, "--turn", str(turn)]
                command += ["--verbose"] * options.verbose + ["--furniture"] * options.furniture + ["--gap", str(options.gap)]
                run = subprocess.run(command, capture_output=True, text=True)
                head = f"{path.stem[:26]:26s} {mode:4s} {turn:4.0f}"
                if run.returncode:
                    print(head, "failed:", run.stderr.strip()[-600:] if options.verbose else run.stderr.strip().splitlines()[-1:])
                    continue
                m = json.loads(run.stdout.splitlines()[-1])
                rows.append({"model": path.stem, "mode": mode, "turn": turn, **m})
                if "groups" in m:
                    for key in ("groups", "groups_good", "spaces", "strict", "doors", "doors_good", "holes", "covered", "found", "false"):
                        total.setdefault((mode, turn), {}).setdefault(key, 0)
                        total[mode, turn][key] += m[key]
                    cells = "-" if m["cells"] is None else f"{m['cells'][0]} ({m['cells'][1]})"
                    print(f"{head} {m['groups_good']:3d}/{m['groups']:<3d}  {m['strict']:3d}/{m['spaces']:<3d}  {m['doors_good']:3d}/{m['doors']:<3d}  "
                          f"{m['covered']:3d}/{m['holes']:<3d}  {m['false']:2d}/{m['found']:<3d} {m['elsewhere']:4d}      {m['virtual']:4d}   {m['rooms'] - m['voids']:4d}+{m['voids']:<3d}  "
                          f"{cells:>10s}   {m['seconds']:6.1f} ({m['read_s']:4.1f}) {m['mib']:5.0f}")
                else:
                    print(head, m)
                if options.verbose:
                    print(run.stderr)
                    print("  stages:", {k: round(v, 2) for k, v in m.get("stages", {}).items()})
    for (mode, turn), t in total.items():
        print(f"all, mode {mode}, turned {turn:g}: groups {t['groups_good']}/{t['groups']} = {t['groups_good'] / t['groups']:.3f}, "
              f"strict {t['strict']}/{t['spaces']}, doors {t['doors_good']}/{t['doors']} = {t['doors_good'] / t['doors']:.3f}, "
              f"holes {t['covered']}/{t['holes']}, false {t['false']}/{t['found']}")
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
