# SPDX-License-Identifier: GPL-3.0-or-later
"""All benchmarks by one command: tables on stdout, CSV and a picture of run time against error in --out.

    ./build.sh bench [--quick] [--scenes FILE ...] [--peer NAME=COMMAND] [--buildings] [--only region|scale|view|chains|rays|lights|buildings]

region: cell to cell, every method (sampling at several efforts) on portal files, offices and IFC models, against what is proven: a
        pair counts as proven when any of our methods has a witness for it; `missed` are proven pairs a method leaves out,
        `over` what it has beyond, in per cent; counters and CPU seconds of each stage beside them.
scale:  offices from 10^3 to 10^5 cells: CPU a cell and a visible pair, bytes a visible pair, `--from` one cell (mean of nine, spread
        evenly) against the whole bake, without and with reading the scene file, two threads.
view:   camera to cells and objects, by `enfilade bench view`.
chains: door chains, half of them degenerate, against an exact oracle, by stress_chains.
rays:   pictures and rays through cells beside Embree on the same walls, by `enfilade bench raycast`: ratios to its best mode.
lights: direct light with and without light sets, by `enfilade bench lights`.
buildings: the sample house and offices with their renders, by office_table.py (minutes). Previews: preview_table.py.
A peer is a shell command with {scene} (or {name}, the file's name alone) and {matrix} in it; it writes the matrix in our format (line i: the cells that cell i
sees) and is timed like ours, in the same run: --peer 'vis=./vis.sh {scene} {matrix}'. Without {matrix} only time is taken.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "build" / "bin" / "enfilade"
STRESS = ROOT / "build" / "release" / "bin" / "stress_chains"
# Name in tables and pictures, and options. Sampling is a lower bound: more effort, fewer pairs missed.
METHODS = (
    *((f"sample {effort:g}", ["--method", "sample", "--effort", f"{effort:g}"]) for effort in (0.25, 1, 4, 16, 64)),
    ("flow", ["--method", "flow"]),
    ("exact", ["--method", "exact"]),
)
QUICK = ("dm1.prt", "e1m7.prt")
OFFICES = ("office:46,objects=0", "office:300,objects=0", "office:430,windows=0,objects=0", "office:4300,windows=0,objects=0")
MODELS = ("Duplex_A.ifc", "AC20-FZK-Haus.ifc", "Office_A_20110811.ifc", "AC11-Institute-Var-2-IFC.ifc", "KIT-EDC_with_SB.ifc")
COUNTERS = ("might_pairs", "seed_lines", "seed_pairs", "chains", "clips", "targets_dropped", "line_tests", "line_hits",
            "cone_tests", "cone_hidden", "cone_visible", "exact_signs", "might_s", "seed_s", "search_s")

Pairs = np.ndarray  # int64, ascending: i << 32 | j


@dataclass
class Run:
    code: int
    wall_s: float
    cpu_s: float
    peak_mb: float
    log: str


def timed(command: list[str], limit: float) -> Run:
    """Runs a command through time(1), which tells its own CPU seconds and peak memory. Exit code 124: over the limit."""
    begin = time.perf_counter()
    process = subprocess.Popen(
        ["/usr/bin/time", "-f", "enf_time %U %S %M", *command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        out, _ = process.communicate(timeout=limit)
        code = process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # the session is ours: the shell and what it started
        out, _ = process.communicate()
        code = 124
    run = Run(code, time.perf_counter() - begin, 0.0, 0.0, out.decode("utf-8", "replace"))
    for line in reversed(run.log.splitlines()):
        if line.startswith("enf_time "):
            user, system, peak = line.split()[1:]
            run.cpu_s, run.peak_mb = float(user) + float(system), float(peak) / 1024
            break
    return run


def read_matrix(path: Path) -> Pairs:
    """Without the diagonal."""
    rows = [np.array(line.split(), dtype=np.int64) for line in path.read_text().splitlines()]
    keys = [row[row != i] | (i << 32) for i, row in enumerate(rows)]
    return np.sort(np.concatenate(keys)) if keys else np.zeros(0, dtype=np.int64)


def read_witnesses(path: Path) -> Pairs:
    ends = [line.split(maxsplit=2)[:2] for line in path.read_text().splitlines()]
    pairs = np.array(ends, dtype=np.int64).reshape(-1, 2)
    return np.unique(np.concatenate([pairs[:, 0] << 32 | pairs[:, 1], pairs[:, 1] << 32 | pairs[:, 0]]))


def building_scenes(data: Path, out: Path, quick: bool) -> list[Path]:
    """Offices, and IFC models as the add-on reads them, as scenes of their own; what can't be made is said and left out."""
    scenes = []
    for spec in OFFICES[: 1 if quick else None]:
        path = out / f"{spec.split(',')[0].replace(':', '-')}{'' if 'windows=0' in spec else '-windows'}.enf.json"
        if subprocess.run([str(TOOL), "generate", spec, str(path)]).returncode == 0:
            scenes.append(path)
    for name in MODELS[: 1 if quick else None]:
        path = out / f"{Path(name).stem}.enf.json"
        command = [sys.executable, str(Path(__file__).parent / "ifc_scene.py"), str(data / "ifc" / name), str(path)]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode == 0:
            scenes.append(path)
        else:
            print(f"{name}: left out ({(run.stderr.strip().splitlines() or ['?'])[-1]})", file=sys.stderr)
    return scenes


def asked(scene: str, *options: str) -> dict[str, float]:
    """The statistics of a bake."""
    command = [str(TOOL), "pvs", scene, "--quiet", "--json", "-", *options]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def scale(out: Path, quick: bool) -> None:
    """Offices of storeys alike (10 wings of 80 rooms, and 3 of 44), from 10^3 to 10^5 cells."""
    rows: list[dict] = []
    for shape in ("side=40,wings=10", "side=22,wings=3"):
        for rooms in (811, 8110, 43800)[: 2 if quick or "wings=3" in shape else None]:
            path = out / "scale.enf.json"
            subprocess.run([str(TOOL), "generate", f"office:{rooms},windows=0,objects=0,{shape}", str(path)], check=True)
            one, two = asked(str(path), "--threads", "1"), asked(str(path), "--threads", "2")
            rooms = [asked(str(path), "--threads", "1", "--from", str(int(one["cells"]) * k // 10)) for k in range(1, 10)]
            room_s = sum(room["cpu_s"] for room in rooms) / len(rooms)
            read_s = one["read_s"]
            rows.append(
                {
                    "family": shape,
                    "cells": int(one["cells"]),
                    "visible_pairs": int(one["visible_pairs"]),
                    "undecided": int(one["undecided_pairs"]),
                    "cpu_s": f"{one['cpu_s']:.3f}",
                    "us_a_cell": f"{1e6 * one['cpu_s'] / one['cells']:.2f}",
                    "us_a_pair": f"{1e6 * one['cpu_s'] / one['visible_pairs']:.3f}",
                    "bytes_a_pair": f"{one['peak_bytes'] / one['visible_pairs']:.1f}",
                    "one_row_percent": f"{100 * room_s / one['cpu_s']:.2f}",
                    "with_reading_percent": f"{100 * (read_s + room_s) / (read_s + one['cpu_s']):.2f}",
                    "two_threads": f"{one['wall_s'] / two['wall_s']:.2f}",
                }
            )
            print("  ".join(f"{k} {v}" for k, v in rows[-1].items()), flush=True)
            path.unlink()
    write_csv(out / "scale.csv", rows)


def facts() -> list[str]:
    """What a figure means nothing without."""

    def said(*command: str) -> str:
        try:
            return subprocess.run(command, capture_output=True, text=True, cwd=ROOT).stdout.strip().splitlines()[0]
        except (OSError, IndexError):
            return "unknown"

    commit = said("git", "-c", f"safe.directory={ROOT}", "rev-parse", "--short", "HEAD")
    governor = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    model = next((x.split(":")[1].strip() for x in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in x), "?")
    return [
        f"commit {commit}; {said(str(TOOL), '--version')}; {said('gcc', '--version')}; RelWithDebInfo -O2",
        f"{model}, {os.cpu_count()} processors, governor {governor.read_text().strip() if governor.exists() else 'unknown'}, "
        f"load {os.getloadavg()[0]:.1f}; {platform.platform()}; {time.strftime('%Y-%m-%d %H:%M')}",
    ]


def write_csv(path: Path, rows: list[dict]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        for fact in facts():
            file.write(f"# {fact}\n")
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    print(f"wrote {path}")


def region(scenes: list[Path], peers: dict[str, str], out: Path, limit: float, threads: int) -> int:
    rows: list[dict] = []
    missed_by_us = 0
    for scene in scenes:
        answers: list[tuple[str, Run, Pairs | None, dict[str, float]]] = []
        proven: Pairs = np.zeros(0, dtype=np.int64)
        matrix, witnesses, counts = out / "matrix.txt", out / "witnesses.txt", out / "counts.json"
        for method, options in METHODS:
            files = ["--matrix", str(matrix), "--witnesses", str(witnesses), "--json", str(counts)]
            common = ["--threads", str(threads), "--time-limit", str(limit), "--quiet"]
            run = timed([str(TOOL), "pvs", str(scene), *options, *common, *files], 2 * limit + 60)
            if run.code:
                print(f"{scene.name} {method}: exit code {run.code}\n{run.log[-500:]}", file=sys.stderr)
                answers.append((method, run, None, {}))
                continue
            answers.append((method, run, read_matrix(matrix), json.loads(counts.read_text())))
            proven = np.union1d(proven, read_witnesses(witnesses))
        for name, template in peers.items():
            if scene.suffix != ".prt":
                continue  # a peer reads what everybody reads
            matrix.unlink(missing_ok=True)
            command = template.replace("{scene}", shlex.quote(str(scene))).replace("{matrix}", shlex.quote(str(matrix)))
            command = command.replace("{name}", shlex.quote(scene.stem))
            run = timed(["sh", "-c", command], 10 * limit)
            answers.append((name, run, read_matrix(matrix) if run.code == 0 and matrix.exists() else None, {}))
        for method, run, seen, stats in answers:
            missed = "" if seen is None else len(np.setdiff1d(proven, seen, assume_unique=True))
            # The sample method is a lower bound: what it leaves out is its nature, not a fault.
            missed_by_us += missed if method in ("flow", "exact") and missed else 0
            over = "" if seen is None or not len(proven) else 100 * len(np.setdiff1d(seen, proven, assume_unique=True)) / len(proven)
            # Reading and writing files apart: the engine's own seconds; a peer's are all it took.
            row = {
                "scene": scene.name.split(".")[0],
                "method": method.split()[0],
                "effort": method.split()[1] if " " in method else "",
                "cpu_s": f"{stats.get('cpu_s', run.cpu_s):.5f}",
                "wall_s": f"{stats.get('wall_s', run.wall_s):.5f}",
                "peak_mb": f"{run.peak_mb:.1f}",
                "pairs": "" if seen is None else len(seen),
                "proven_pairs": len(proven),
                "missed_pairs": missed,
                "overestimate_percent": "" if over == "" else f"{over:.4f}",
                "undecided_pairs": int(stats["undecided_pairs"]) if stats else "",
                "exit_code": run.code,
            }
            print("  ".join(f"{k} {v}" for k, v in row.items() if k != "exit_code" and v != ""), flush=True)
            rows.append(row | {name: stats.get(name, "") for name in COUNTERS})
        for path in (matrix, witnesses, counts):
            path.unlink(missing_ok=True)
    if rows:
        write_csv(out / "region.csv", rows)
        draw(out / "region.csv", out / "region", "Cell to cell: run time against error")
    return missed_by_us


def draw(source: Path, target: Path, title: str) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    try:
        import chart

        errors = [("missed_pairs", "proven pairs missed"), ("overestimate_percent", "pairs beyond the proven, per cent of these")]
        for path in chart.write_chart(source, target, title, errors=errors):
            print(f"wrote {path}")
    except ImportError as error:  # no OpenImageIO: the table stands without its picture
        print(f"no picture: {error}", file=sys.stderr)


def view(scenes: list[Path], out: Path, queries: int) -> int:
    families = ["grid:10", "columns:10", "ring:24", "office:46", "office:500"]
    command = [str(TOOL), "bench", "view", *families, *map(str, scenes), "--queries", str(queries), "--csv", str(out / "view.csv")]
    print(" ".join(command[:3]), flush=True)
    return subprocess.run(command, stdin=subprocess.DEVNULL).returncode


def chains(out: Path, count: int, peers: list[str]) -> int:
    """Microseconds a chain asked directly, then right and wrong against the oracle."""
    times = [str(TOOL), "bench", "chains", "--count", str(count), "--csv", str(out / "chain_times.csv")]
    for peer in peers[:1]:
        times += ["--peer", peer]
    subprocess.run(times, stdin=subprocess.DEVNULL)
    if not STRESS.exists():
        print(f"door chains: skipped, {STRESS.name} wasn't built (it needs cddlib)", file=sys.stderr)
        return 0
    return subprocess.run([str(STRESS), "--count", str(count), "--csv", str(out / "chains.csv")], stdin=subprocess.DEVNULL).returncode


def rays(scenes: list[Path], out: Path, quick: bool) -> int:
    families = ["office:46,windows=0,objects=0", "office:46,objects=0"]
    if not quick:
        families += ["office:135,windows=0,objects=0", "office:1755,windows=0,objects=0", "office:1755,objects=0", "columns:20", "ring:60", "facade:6"]
    size = ["--size", "256", "--cameras", "2", "--repeats", "2"] if quick else []
    table = out / "raycast.csv"
    command = [str(TOOL), "bench", "raycast", *families, *map(str, scenes), *size, "--csv", str(table)]
    print(" ".join(command[:3]), flush=True)
    code = subprocess.run(command, stdin=subprocess.DEVNULL).returncode
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    try:
        import ray_chart

        for path in ray_chart.write_chart(table, out / "raycast"):
            print(f"wrote {path}")
    except ImportError as error:  # no OpenImageIO: the table stands without its picture
        print(f"no picture: {error}", file=sys.stderr)
    return code


def main() -> int:
    parser = argparse.ArgumentParser(description="all benchmarks by one command")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "bench")
    parser.add_argument("--quick", action="store_true", help="two portal files and few queries")
    parser.add_argument("--scenes", type=Path, nargs="*", help="*.prt and *.enf.json (default: the portal files of the data)")
    parser.add_argument("--peer", action="append", default=[], metavar="NAME=COMMAND")
    parser.add_argument("--chains-peer", action="append", default=[], metavar="NAME=COMMAND", help="see enfilade bench chains")
    parser.add_argument("--time-limit", type=float, default=120.0, help="seconds a method may take (default 120)")
    parser.add_argument("--threads", type=int, default=1, help="for cell to cell (default 1: what a peer has)")
    parser.add_argument("--buildings", action="store_true", help="also house and offices, with renders: takes minutes")
    parser.add_argument("--only", choices=["region", "scale", "view", "chains", "rays", "lights", "buildings"])
    options = parser.parse_args()
    if not TOOL.exists():
        sys.exit("build/bin/enfilade is missing: ./build.sh build")
    options.out.mkdir(parents=True, exist_ok=True)
    peers = dict(peer.split("=", 1) for peer in options.peer)
    data = Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))
    scenes = options.scenes
    if scenes is None:
        scenes = sorted((data / "prt").glob("*.prt"))
        if options.quick:
            scenes = [s for s in scenes if s.name in QUICK]
        scenes += [s for s in (ROOT / "build" / "demo" / "house.enf.json",) if s.exists()]
        if options.only in (None, "region"):
            scenes += building_scenes(data, options.out, options.quick)
        if not scenes:
            print(f"no portal files in {data / 'prt'} (ENFILADE_DATA names another place)", file=sys.stderr)
    for fact in facts():
        print(f"# {fact}")
    code = 0
    if options.only in (None, "region") and scenes:
        missed = region(scenes, peers, options.out, options.time_limit, options.threads)
        if missed:
            print(f"{missed} proven pairs are missing from a conservative answer: a bug", file=sys.stderr)
            code = 1
    if options.only in (None, "scale"):
        scale(options.out, options.quick)
    if options.only in (None, "view"):
        code |= view([s for s in scenes if s.suffix == ".json"], options.out, 200 if options.quick else 2000)
    if options.only in (None, "chains"):
        code |= chains(options.out, 10 if options.quick else 200, options.chains_peer)
    if options.only in (None, "rays"):
        code |= rays([s for s in scenes if s.suffix == ".json"], options.out, options.quick)
    if options.only in (None, "lights"):
        sizes = ["--size", "64", "--pictures", "2"] if options.quick else []
        code |= subprocess.run([str(TOOL), "bench", "lights", *sizes, "--csv", str(options.out / "lights.csv")], stdin=subprocess.DEVNULL).returncode
    if options.only == "buildings" or options.buildings:
        table = [sys.executable, str(Path(__file__).parent / "office_table.py"), "--render", "--out", str(options.out)]
        code |= subprocess.run(table, stdin=subprocess.DEVNULL).returncode
    return code


if __name__ == "__main__":
    sys.exit(main())
