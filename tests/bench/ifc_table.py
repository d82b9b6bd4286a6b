# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints, for each IFC model of the data folder, what `read_ifc` made of it.

Usage: /usr/bin/python3 tests/bench/ifc_table.py [--moved] [--verbose] [FILE.ifc ...]
Each model is read in a process of its own, so that peak memory is its own too. `doors` = doors joined to two rooms /
what INDEX.tsv counted by careful probing (doors_two_spaces). --moved: each model beside itself moved by (5e5, 5e6, 100) m
and turned by 33 degrees: rooms and openings of either, how many aren't the same (name, rooms, count and place of corners), and
the farthest that a corner of the others is off after moving back.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]


def data_folder() -> Path:
    return Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))


def measure(path: str, objects: bool) -> dict:
    """One model, in this process."""
    from enfilade.rules import building as b
    from enfilade.rules import ifc

    start = time.perf_counter()
    building, outcomes = ifc.read_with_outcomes(path, objects=objects)
    seconds = time.perf_counter() - start
    cells, refused = cut_into_cells(building)
    interior = {i for i, r in enumerate(building.rooms) if r.kind == b.INTERIOR}
    doors = [o for o in outcomes if o.kind == b.DOOR]
    fates = Counter((o.kind, o.fate) for o in outcomes)
    pairs = {tuple(sorted(o.rooms)) for o in building.openings if o.rooms}
    return {
        "rooms": len(interior),
        "cells": cells,
        "refused": refused,
        "openings": len({o.source_id for o in building.openings if o.kind != b.VIRTUAL})
        + sum(o.kind == b.VIRTUAL for o in building.openings),
        "passages": len(building.openings),
        "portals": sum(1 if o.polygon is not None else 2 for o in building.openings),
        "virtual": sum(o.kind == b.VIRTUAL for o in building.openings),
        "pairs": len(pairs),
        "doors": len(doors),
        "joined": len({o.source_id for o in doors if o.fate == "joined"}),
        "same": len({o.source_id for o in doors if o.fate == "same-room"}),
        "outside": len({o.source_id for o in doors if o.fate in ("exterior", "no-room")}),
        "false": sum(o.fate == "false-portal" for o in outcomes),
        "objects": len(building.objects),
        "problems": dict(Counter(p.code for p in building.problems)),
        "fates": {f"{k} {f}": n for (k, f), n in sorted(fates.items())},
        "seconds": seconds,
        "stages": building.statistics,
        "mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


MOVE, DEGREES = (5e5, 5e6, 100.0), 33.0
SAME = 1e-5  # m: a corner that far off, at coordinates of 5e6 m, is rounding


def move(model) -> None:
    """Moves and turns an opened model by its outermost placements."""
    import numpy as np
    from enfilade.rules import geometry_frame, ifc_placement, ifc_units

    turn, by = geometry_frame.rotation(DEGREES), np.array(MOVE) / ifc_units.length_unit(model)
    for placement in model.by_type("IfcLocalPlacement"):
        if placement.PlacementRelTo is not None:
            continue
        old = ifc_placement.axis_placement(placement.RelativePlacement)
        at, axes = by + turn @ old[:3, 3], turn @ old[:3, :3]
        placement.RelativePlacement = model.createIfcAxis2Placement3D(
            model.createIfcCartesianPoint(at.tolist()),
            model.createIfcDirection(axes[:, 2].tolist()),
            model.createIfcDirection(axes[:, 0].tolist()),
        )


def compare_moved(path: str) -> dict:
    """One model beside itself moved, in this process."""
    import numpy as np
    from enfilade.rules import geometry_frame, ifc

    model = ifc.open_model(path)
    here = ifc.read_ifc(path, model=model, objects=False)
    move(model)
    there = ifc.read_ifc(path, model=model, objects=False)
    turn = geometry_frame.rotation(DEGREES)
    farthest = 0.0

    def differ(a, b) -> bool:
        nonlocal farthest
        if a is None or b is None:
            return (a is None) != (b is None)
        if a.shape != b.shape:
            return True
        off = float(np.abs(a - (b - np.array(MOVE)) @ turn).max())
        if off < SAME:
            farthest = max(farthest, off)
        return off >= SAME

    def count(mine, theirs, shape) -> int:
        pairs = list(zip(mine, theirs, strict=False))
        return max(len(mine), len(theirs)) - len(pairs) + sum(
            a.name != b.name or getattr(a, "rooms", 0) != getattr(b, "rooms", 0) or differ(shape(a), shape(b)) for a, b in pairs
        )

    return {
        "rooms": (len(here.rooms), len(there.rooms), count(here.rooms, there.rooms, lambda r: r.vertices)),
        "openings": (
            len(here.openings), len(there.openings),
            count(here.openings, there.openings, lambda o: o.body if o.body is not None else o.polygon),
        ),
        "farthest": farthest,
    }  # fmt: skip


def print_moved(files: list[Path]) -> int:
    print(f"{'model':34s} rooms moved differ  openings moved differ  farthest m")
    bad = 0
    for path in files:
        run = subprocess.run([sys.executable, __file__, "--moved", "--one", str(path)], capture_output=True, text=True)
        if run.returncode:
            print(f"{path.name[:34]:34s} failed: {run.stderr.strip().splitlines()[-1] if run.stderr else '?'}")
            bad += 1
            continue
        m = json.loads(run.stdout.splitlines()[-1])
        (r, rm, rd), (o, om, od) = m["rooms"], m["openings"]
        bad += rd + od
        print(f"{path.name[:34]:34s} {r:5d} {rm:5d} {rd:6d}  {o:8d} {om:5d} {od:6d}  {m['farthest']:10.1e}")
    return 1 if bad else 0


def cut_into_cells(building) -> tuple[int | None, int]:
    """Cells the core makes of it, and what it refused; None without the native library (./build.sh build)."""
    from enfilade.rules import assemble

    try:
        import enfilade_native as native

        made = assemble.assemble(native, building)
    except (ImportError, OSError, native.LibraryError):
        return None, 0
    with made.scene:
        return made.scene.counts.cells, sum(p.code == "shape-refused" for p in made.problems)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--verbose", action="store_true", help="problems, fates and stages too")
    parser.add_argument("--no-objects", action="store_true")
    parser.add_argument("--moved", action="store_true", help="compare each model with itself far away and turned")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(compare_moved(options.one) if options.moved else measure(options.one, not options.no_objects)))
        return 0
    known: dict[str, dict[str, str]] = {}
    index = data_folder() / "INDEX.tsv"
    if index.is_file():
        with index.open(encoding="utf-8") as file:
            known = {Path(r["file"]).name: r for r in csv.DictReader(file, delimiter="\t")}
    files = [Path(f) for f in options.files] or sorted((data_folder() / "ifc").glob("*.ifc"))
    if not files:
        print(f"no IFC files in {data_folder() / 'ifc'}", file=sys.stderr)
        return 2
    if options.moved:
        return print_moved(files)
    print(
        f"{'model':34s} rooms cells openings portals virtual  doors joined/INDEX same/INDEX out/INDEX false refused "
        "objects seconds  MiB"
    )
    for path in files:
        command = [sys.executable, __file__, "--one", str(path)] + (["--no-objects"] if options.no_objects else [])
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            print(f"{path.name[:34]:34s} failed: {run.stderr.strip().splitlines()[-1] if run.stderr else '?'}")
            continue
        m = json.loads(run.stdout.splitlines()[-1])
        row = known.get(path.name, {})
        want = [row.get(k, "-") for k in ("doors_two_spaces", "doors_same_space", "doors_one_or_none")]
        print(
            f"{path.name[:34]:34s} {m['rooms']:5d} {m['cells'] or '-':>5} {m['openings']:8d} {m['portals']:7d} {m['virtual']:7d} {m['doors']:6d} "
            f"{m['joined']:6d}/{want[0]:5s} {m['same']:4d}/{want[1]:5s} {m['outside']:3d}/{want[2]:5s} {m['false']:5d} {m['refused']:7d} "
            f"{m['objects']:7d} {m['seconds']:7.2f} {m['mib']:4.0f}"
        )
        if options.verbose:
            for key in ("problems", "fates", "stages"):
                shown = {k: round(v, 2) if isinstance(v, float) else v for k, v in m[key].items()}
                print(f"    {key}: {shown}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
