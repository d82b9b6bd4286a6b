# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample buildings in figures: what a query costs, what it keeps, what rays say to it, and what a render gains.

    /usr/bin/python3 tests/bench/office_table.py [house office46 office1755 | FILE.blend ...] [--rays N] [--random N] [--render] [--region METHOD] [--out DIR]

Queries: per camera and method the best of --repeats, microseconds as the engine's own clock says. Rays: --rays in all per
building, split among its cameras (and frames of the walk); `hidden` counts objects that a ray meets and a method hides: it
must be 0, else the exit code is 1. --random adds cameras anywhere in rooms, doorways and outdoors, 30,000 rays each. Region:
rays from anywhere in cells against the matrix of `enfilade pvs`; `missing` must be 0. Render (--render): one interior camera by `batch.py render --verify --compare-simplify`,
each in a `blender -b` of its own. Writes CSV into --out.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "oracle"))
import oracle  # noqa: E402 - the path has to be set first

SAMPLES = {  # name: (file, how it is made, the camera that is rendered)
    "house": (ROOT / "sample_blends" / "house.blend", None, "Camera Living"),
    "office46": (ROOT / "build" / "samples" / "office_46.blend", ["office", "--rooms-per-storey", "46"], "Camera Office"),
    "office1755": (ROOT / "build" / "samples" / "office_1755.blend",
                   ["office", "--storeys", "13", "--rooms-per-storey", "135"], "Camera Office"),
}
WALK_FRAMES = [40, 80, 120, 160, 200, 240]


def blender(*arguments: object) -> str:
    done = subprocess.run([oracle.blender(), "-b", "--factory-startup", *map(str, arguments)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"blender {' '.join(map(str, arguments))}: exit code {done.returncode}\n"
                         f"{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def answer(output: str) -> dict:
    return json.loads([line for line in output.splitlines() if line.startswith("{")][-1])


def newer(target: Path, *sources: Path) -> bool:
    return target.exists() and all(target.stat().st_mtime > s.stat().st_mtime for s in sources)


def prepare(blend: Path, recipe: list[str] | None, out: Path) -> tuple[Path, Path, dict]:
    """Makes the file when it is missing or older than its makers, and detects it once; returns file, scene, what Detect said."""
    makers = sorted((ROOT / "sample_blends").glob("*.py"))
    if recipe and not newer(blend, *makers):
        print(f"making {blend.name}", file=sys.stderr)
        blender("--python-exit-code", "3", "-P", ROOT / "sample_blends" / "make_samples.py", "--", *recipe, "--out", blend)
    detected, scene, facts = out / blend.name, out / f"{blend.stem}.enf.json", out / f"{blend.stem}.detect.json"
    rules = list((ROOT / "plugin" / "enfilade").glob("**/*.py"))
    if not newer(facts, blend, *rules):
        print(f"detecting {blend.name}", file=sys.stderr)
        begin = time.perf_counter()
        said = answer(blender(blend, "--python-exit-code", "3", "-P", ROOT / "plugin" / "batch.py", "--", "detect", "--save",
                              detected, "--scene-json", scene))
        said["wall_s"] = round(time.perf_counter() - begin, 2)
        facts.write_text(json.dumps(said))
    return detected, scene, json.loads(facts.read_text())


def table(rows: list[dict]) -> None:
    if not rows:
        return
    keys = list(rows[0])
    text = [[f"{row[k]:.1f}" if isinstance(row[k], float) else str(row[k]) for k in keys] for row in rows]
    widths = [max(len(k), *(len(line[i]) for line in text)) for i, k in enumerate(keys)]
    print("  ".join(k.ljust(w) for k, w in zip(keys, widths, strict=True)))
    for line in text:
        print("  ".join(v.rjust(w) if v.replace(".", "").replace("-", "").isdigit() else v.ljust(w)
                        for v, w in zip(line, widths, strict=True)))
    print(flush=True)


def write_csv(path: Path, rows: list[dict]) -> None:
    if rows:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


def machine() -> str:
    def said(*command: str) -> str:
        try:
            return subprocess.run(command, capture_output=True, text=True, cwd=ROOT).stdout.strip()
        except OSError:
            return "?"

    cpu = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), platform.processor()) if os.path.exists("/proc/cpuinfo") else "?"
    return (f"commit {said('git', 'rev-parse', '--short', 'HEAD')}, {said('cc', '--version').splitlines()[0]}, "
            f"{os.cpu_count()} x {cpu}, load {os.getloadavg()[0]:.1f}, {time.strftime('%Y-%m-%d')}")


def region(name: str, blend: Path, scene_file: Path, method: str, rays: int, out: Path) -> dict:
    dump_file = out / f"{blend.stem}.dump"
    oracle.dump(blend, dump_file)
    proven = oracle.shoot_region(dump_file, json.loads(scene_file.read_text()), rays)
    dump_file.unlink()
    begin = time.perf_counter()
    rows = oracle.pvs_matrix(scene_file, method, out / f"{blend.stem}.{method}.txt")
    missing = oracle.judge_region(proven, rows)
    for pair in missing[:5]:
        print(pair, file=sys.stderr)
    return {"building": name, "method": method, "wall_s": time.perf_counter() - begin, "cells": len(rows),
            "pairs": sum(map(len, rows)), "proven by rays": len(proven["pairs"]), "rays": proven["rays"], "missing": len(missing)}


def queries(name: str, blend: Path, scene: Path, facts: dict, rays: int, random: int, repeats: int,
            out: Path) -> tuple[list[dict], int]:
    dump_file = out / f"{blend.stem}.dump"
    header = oracle.dump(blend, dump_file, WALK_FRAMES)
    cameras = header["cameras"]
    # Half of the aimed rays miss the picture, hence the factor: `rays` is what is really shot.
    verdicts = oracle.check_views(dump_file, header, scene, int(rays / len(cameras) * 1.65), repeats=repeats)
    if random:
        header["cameras"] = oracle.random_cameras(json.loads(scene.read_text()), random)
        verdicts += oracle.check_views(dump_file, header, scene, 30_000)
    dump_file.unlink()
    rows = []
    for v in verdicts:
        rows.append({"building": name, "camera": v.camera, "frame": v.frame, "method": v.method, "us": v.microseconds,
                     "objects": facts["objects"], "kept": v.kept, "proven": v.proven, "rays": v.rays,
                     "hidden": len(v.hidden), "unknown": len(v.unknown)})
        if v.hidden:
            print(v.describe(), file=sys.stderr)
    return rows, sum(row["hidden"] + row["unknown"] for row in rows)


def summary(rows: list[dict]) -> list[dict]:
    result = []
    for method in oracle.METHODS:
        mine = [row for row in rows if row["method"] == method]
        result.append({"building": mine[0]["building"], "method": method, "views": len(mine),
                       "us median": statistics.median(row["us"] for row in mine), "us worst": max(row["us"] for row in mine),
                       "objects": mine[0]["objects"], "kept median": statistics.median_low(row["kept"] for row in mine),
                       "proven median": statistics.median_low(row["proven"] for row in mine),
                       "rays": sum(row["rays"] for row in mine), "hidden": sum(row["hidden"] for row in mine)})
    return result


def renders(name: str, blend: Path, camera: str, out: Path, keep: str) -> list[dict]:
    folder = out / f"render_{blend.stem}"
    said = answer(blender(blend, "--python-exit-code", "3", "-P", ROOT / "plugin" / "batch.py", "--", "render", "--camera",
                          camera, "--out", folder, "--verify", "--compare-simplify", "--mode", "render", "--keep", keep,
                          "--threads", os.cpu_count() or 1))
    rows = []
    for shot in said["shots"]:
        for label, measured in shot["renders"].items():
            compared = {"whole": {}, "culled": shot["comparison"], "simplify": shot.get("simplify_comparison", {})}[label]
            rows.append({"building": name, "camera": camera, "variant": label,
                         "objects": shot["kept"] if label == "culled" else said["objects"] if label == "whole" else "-",
                         "render_s": float(measured["render_s"]), "wall_s": float(measured["wall_s"]),
                         "peak_mib": float(measured["peak_bytes"] / 2**20),
                         "index wrong": compared.get("index_different", 0), "depth wrong": compared.get("depth_different", 0)})
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("buildings", nargs="*", default=list(SAMPLES), help="house, office46, office1755 or .blend files")
    parser.add_argument("--rays", type=int, default=10_000_000, help="per building (default 10,000,000)")
    parser.add_argument("--repeats", type=int, default=30, help="queries per camera and method, the best counts")
    parser.add_argument("--random", type=int, default=0, metavar="N", help="also N random cameras")
    parser.add_argument("--region", default="", metavar="METHOD", help="also judge pvs --method METHOD by 2,000,000 rays")
    parser.add_argument("--render", action="store_true", help="also render one interior camera three ways")
    parser.add_argument("--camera", default="", help="the camera to render (default: the sample's own)")
    parser.add_argument("--keep", default="camera", help="what `render` keeps: camera, shadow, bounces=N (default camera)")
    parser.add_argument("--details", action="store_true", help="a row per camera, not only per method")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "bench" / "office")
    given = parser.parse_args()
    out = given.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    print(machine(), flush=True)
    wrong, every, sums, regions, rendered, facts_rows = 0, [], [], [], [], []
    for name in given.buildings:
        blend, recipe, camera = SAMPLES.get(name, (Path(name), None, given.camera))
        if not recipe and not blend.exists():
            parser.error(f"no such building or file: {name}")
        detected, scene, facts = prepare(blend, recipe, out)
        facts_rows.append({"building": name, "rooms": facts["rooms"] - 1, "cells": facts["cells"], "portals": facts["portals"],
                           "openings": facts["openings"], "joined": facts["openings_joined"], "objects": facts["objects"],
                           "detect_s": float(facts["detect_s"])})
        table(facts_rows[-1:])
        if given.rays:
            rows, bad = queries(name, detected, scene, facts, given.rays, given.random, given.repeats, out)
            wrong += bad
            every += rows
            sums += summary(rows)
            table(rows if given.details else summary(rows))
        if given.region:
            regions.append(region(name, detected, scene, given.region, 2_000_000, out))
            wrong += regions[-1]["missing"]
            table(regions[-1:])
        if given.render and (given.camera or camera):
            rows = renders(name, detected, given.camera or camera, out, given.keep)
            wrong += sum(row["index wrong"] for row in rows if row["variant"] == "culled")
            rendered += rows
            table(rows)
    for label, rows in (("buildings", facts_rows), ("views", every), ("methods", sums), ("regions", regions), ("renders", rendered)):
        write_csv(out / f"{label}.csv", rows)
    print(f"tables: {os.path.relpath(out)}; {'nothing visible was hidden' if not wrong else f'{wrong} WRONG'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
