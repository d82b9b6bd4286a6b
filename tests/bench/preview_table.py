# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews in figures: equal to Cycles on which buildings, milliseconds at 1920 x 1080 and memory on which; light sets.

    /usr/bin/python3 tests/bench/preview_table.py [--out DIR] [--large] [--only lights|verify|speed] [--resolution WxH]

lights: shadow rays with and without light sets (`enfilade bench lights`). verify: depth and objects of each camera against Cycles at
640 x 360, for the sample house, an office of 46 rooms and two IFC models. speed: milliseconds of the rooms' spans and of the shaded
picture with all its furniture, best of three; --large adds the office of 1,755 rooms (a minute to make, another to read).
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL, BATCH = ROOT / "build" / "bin" / "enfilade", ROOT / "plugin" / "batch.py"
DATA = Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))
BLENDER = os.environ.get("ENFILADE_BLENDER", "blender")
SAMPLES = ROOT / "build" / "samples"
IFC = ("Duplex_A.ifc", "AC20-FZK-Haus.ifc")


def blender(arguments: list[str]) -> list[str]:
    """Runs Blender; the lines of its stdout that are JSON objects."""
    run = subprocess.run([BLENDER, "-b", *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return [line for line in run.stdout.splitlines() if line.startswith("{")]


def office(storeys: int, rooms: int) -> Path:
    path = SAMPLES / f"office_{storeys * rooms}.blend"
    if not path.exists():
        SAMPLES.mkdir(parents=True, exist_ok=True)
        blender(["--factory-startup", "--python-exit-code", "3", "-P", str(ROOT / "sample_blends" / "make_samples.py"), "--", "office",
                 "--storeys", str(storeys), "--rooms-per-storey", str(rooms), "--out", str(path)])
    return path


def verify(out: Path) -> int:
    house = ROOT / "sample_blends" / "house.blend"
    jobs = [("house", [str(house)], []), ("office 46", [str(office(1, 46))], [])]
    jobs += [(n, ["--factory-startup"], ["--ifc", str(DATA / "ifc" / n), "--add-cameras", "7"]) for n in IFC if (DATA / "ifc" / n).exists()]
    rows, bad = [], 0
    print(f"{'building':18} {'camera':18} {'depth equal':>12} {'allowed for':>12} {'differ':>7} {'in spread':>9} {'settled':>8} {'objects off edges':>18}")
    for name, source, options in jobs:
        with tempfile.TemporaryDirectory() as folder:
            lines = blender([*source, "--python-exit-code", "3", "-P", str(BATCH), "--", "preview", *options, "--out", folder, "--resolution",
                             "640x360", "--verify", "--passes", "shaded", "--no-exr", "--no-lights"])
        if not lines:
            print(f"{name:18} failed")
            bad = 1
            continue
        for v in json.loads(lines[-1])["verify"]:
            print(f"{name:18} {v['camera']:18} {v['depth_share_raw']:12.4%} {v['depth_share']:12.4%} {v['depth_different']:7} {v['depth_within_sample']:9} "
                  f"{v['depth_settled']:8} {v['objects_off_edges']:8} ({v['coinciding']} coincide)", flush=True)
            rows.append({"building": name, **v})
            bad |= not v["equal"] or v["depth_share_raw"] < 0.9999  # here nothing is allowed for
    write(out / "preview_verify.csv", rows)
    return int(bad)


def speed(out: Path, large: bool, resolution: str) -> int:
    rows = []
    print(f"{'building':18} {'camera':18} {'spans ms':>9} {'look ms':>8} {'load ms':>8} {'shaded ms':>10} {'objects':>8} {'triangles':>10} {'core MiB':>9}")
    for name, path in [("house", ROOT / "sample_blends" / "house.blend"), ("office 46", office(1, 46)),
                       *([("office 1755", office(13, 135))] if large else [])]:
        for line in blender([str(path), "--python-exit-code", "3", "-P", __file__, "--", resolution]):
            row = json.loads(line)
            print(f"{name:18} {row['camera']:18} {row['spans_ms']:9.1f} {row['look_ms']:8.1f} {row['load_ms']:8.1f} {row['shaded_ms']:10.0f} "
                  f"{row['objects']:8} {row['triangles']:10} {row['core_mib']:9.1f}", flush=True)
            rows.append({"building": name, **row})
    write(out / "preview_speed.csv", rows)
    return 0 if rows else 1


def write(path: Path, rows: list[dict]) -> None:
    if rows:
        with open(path, "w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, list(rows[0]))
            table.writeheader()
            table.writerows(rows)
        print(f"wrote {path}")


def inside() -> None:
    """In Blender: every camera of the open file, a line each."""
    sys.path.insert(0, str(ROOT / "plugin"))
    import bpy
    from enfilade import native
    from enfilade.scene import cameras, detect, preview

    core, scene = native.load(), bpy.context.scene
    width, height = (int(v) for v in sys.argv[-1].split("x"))
    previewer = preview.Previewer(core, scene, detect.current(scene, bpy.context.view_layer))
    for obj in cameras.scene_cameras(scene):
        camera = previewer.read(obj)
        spans, shaded = [], []
        for _ in range(5):
            begin = time.perf_counter()
            previewer.raycaster.image(camera, width, height)
            spans.append(time.perf_counter() - begin)
        for _ in range(3):
            made = previewer.render(obj, width, height)
            shaded.append(made.seconds["render"])
        print("\n" + json.dumps({
            "camera": obj.name, "spans_ms": round(1e3 * min(spans), 2), "look_ms": round(1e3 * made.seconds["look"], 1),
            "load_ms": round(1e3 * made.seconds["load"], 1), "shaded_ms": round(1e3 * min(shaded), 1), "objects": made.counts["objects"],
            "triangles": made.counts["triangles"], "triangle_mib": round(made.counts["bytes"] / 2**20, 2),
            "shadow_rays": made.counts["shadow_rays"], "core_mib": round(core.library().enf_live_bytes() / 2**20, 1)}), flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description="previews in figures")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "bench")
    parser.add_argument("--large", action="store_true", help="also the office of 1,755 rooms")
    parser.add_argument("--only", choices=["lights", "verify", "speed"])
    parser.add_argument("--resolution", default="1920x1080", help="of speed (default 1920x1080)")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    code = 0
    if options.only in (None, "lights"):
        code |= subprocess.run([str(TOOL), "bench", "lights", "--csv", str(options.out / "lights.csv")], stdin=subprocess.DEVNULL).returncode
    if options.only in (None, "verify"):
        code |= verify(options.out)
    if options.only in (None, "speed"):
        code |= speed(options.out, options.large, options.resolution)
    return code


if __name__ == "__main__":
    if "bpy" in sys.modules:
        inside()
    else:
        sys.exit(main())
