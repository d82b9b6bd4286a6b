# SPDX-License-Identifier: GPL-3.0-or-later
"""All benchmarks by one command: tables on stdout, CSV and a picture of run time against error in --out.

    ./build.sh bench [--quick] [--scenes FILE ...] [--peer NAME=COMMAND] [--buildings] [--only region|view|chains|rays|buildings]

region: cell to cell, every method on portal files and scenes, against what is proven: a pair counts as proven when any of our
        methods has a witness for it; `missed` are proven pairs a method leaves out, `over` what it has beyond, in per cent.
view:   camera to cells and objects, by `enfilade bench view`.
chains: door chains, half of them degenerate, against an exact oracle, by stress_chains.
rays:   pictures and rays through cells beside Embree on the same walls, by `enfilade bench raycast`: ratios to its best mode.
buildings: the sample house and offices with their renders, by office_table.py (minutes).
A peer is a shell command with {scene} and {matrix} in it; it writes the matrix in our format (line i: the cells that cell i
sees) and is timed like ours, in the same run: --peer 'vis=./vis.sh {scene} {matrix}'. Without {matrix} only time is taken.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "build" / "bin" / "enfilade"
STRESS = ROOT / "build" / "release" / "bin" / "stress_chains"
METHODS = ("sample", "flow", "exact")
QUICK = ("dm1.prt", "e1m7.prt")

Pairs = set[tuple[int, int]]


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
    return {(i, int(j)) for i, line in enumerate(path.read_text().splitlines()) for j in line.split()}


def read_witnesses(path: Path) -> Pairs:
    pairs = (tuple(map(int, line.split()[:2])) for line in path.read_text().splitlines())
    return {p for i, j in pairs for p in ((i, j), (j, i))}


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
        answers: list[tuple[str, Run, Pairs | None]] = []
        proven: Pairs = set()
        for method in METHODS:
            matrix, witnesses = out / "matrix.txt", out / "witnesses.txt"
            files = ["--matrix", str(matrix), "--witnesses", str(witnesses)]
            options = ["--method", method, "--threads", str(threads), "--time-limit", str(limit), "--quiet"]
            run = timed([str(TOOL), "pvs", str(scene), *options, *files], 2 * limit + 60)
            if run.code:
                print(f"{scene.name} {method}: exit code {run.code}\n{run.log[-500:]}", file=sys.stderr)
                answers.append((method, run, None))
                continue
            answers.append((method, run, read_matrix(matrix)))
            proven |= read_witnesses(witnesses)
        for name, template in peers.items():
            matrix = out / "peer.txt"
            matrix.unlink(missing_ok=True)
            command = template.replace("{scene}", shlex.quote(str(scene))).replace("{matrix}", shlex.quote(str(matrix)))
            run = timed(["sh", "-c", command], 10 * limit)
            answers.append((name, run, read_matrix(matrix) if run.code == 0 and matrix.exists() else None))
        proven = {(i, j) for i, j in proven if i != j}
        for method, run, found in answers:
            seen = {(i, j) for i, j in found if i != j} if found is not None else None
            missed = "" if seen is None else len(proven - seen)
            # The sample method is a lower bound: what it leaves out is its nature, not a fault.
            missed_by_us += missed if method in ("flow", "exact") and missed else 0
            rows.append(
                {
                    "scene": scene.name.split(".")[0],
                    "method": method,
                    "cpu_s": f"{run.cpu_s:.3f}",
                    "wall_s": f"{run.wall_s:.3f}",
                    "peak_mb": f"{run.peak_mb:.1f}",
                    "pairs": "" if seen is None else len(seen),
                    "proven_pairs": len(proven),
                    "missed_pairs": missed,
                    "overestimate_percent": ""
                    if seen is None or not proven
                    else f"{100 * (len(seen - proven)) / len(proven):.3f}",
                    "exit_code": run.code,
                }
            )
            print("  ".join(f"{k} {v}" for k, v in rows[-1].items() if k != "exit_code"), flush=True)
        for name in ("matrix.txt", "witnesses.txt", "peer.txt"):
            (out / name).unlink(missing_ok=True)
    if rows:
        write_csv(out / "region.csv", rows)
        draw(out / "region.csv", out / "region", "Cell to cell: run time against error")
    return missed_by_us


def draw(source: Path, target: Path, title: str) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    try:
        import chart

        errors = [("missed_pairs", "proven pairs missed"), ("overestimate_percent", "overestimate, per cent")]
        for path in chart.write_chart(source, target, title, errors=errors):
            print(f"wrote {path}")
    except ImportError as error:  # no OpenImageIO: the table stands without its picture
        print(f"no picture: {error}", file=sys.stderr)


def view(scenes: list[Path], out: Path, queries: int) -> int:
    families = ["grid:10", "columns:10", "ring:24", "office:46", "office:500"]
    command = [str(TOOL), "bench", "view", *families, *map(str, scenes), "--queries", str(queries), "--csv", str(out / "view.csv")]
    print(" ".join(command[:3]), flush=True)
    return subprocess.run(command, stdin=subprocess.DEVNULL).returncode


def chains(out: Path, count: int) -> int:
    if not STRESS.exists():
        print(f"door chains: skipped, {STRESS.name} wasn't built (it needs cddlib)", file=sys.stderr)
        return 0
    return subprocess.run([str(STRESS), "--count", str(count), "--csv", str(out / "chains.csv")], stdin=subprocess.DEVNULL).returncode


def rays(scenes: list[Path], out: Path, quick: bool) -> int:
    families = ["office:46,windows=0,objects=0"]
    if not quick:
        families += ["office:135,windows=0,objects=0", "office:1755,windows=0,objects=0", "columns:20", "ring:60", "facade:6"]
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
    parser.add_argument("--time-limit", type=float, default=120.0, help="seconds a method may take (default 120)")
    parser.add_argument("--threads", type=int, default=1, help="for cell to cell (default 1: what a peer has)")
    parser.add_argument("--buildings", action="store_true", help="also house and offices, with renders: takes minutes")
    parser.add_argument("--only", choices=["region", "view", "chains", "rays", "buildings"])
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
    if options.only in (None, "view"):
        code |= view([s for s in scenes if s.suffix == ".json"], options.out, 200 if options.quick else 2000)
    if options.only in (None, "chains"):
        code |= chains(options.out, 10 if options.quick else 200)
    if options.only in (None, "rays"):
        code |= rays([s for s in scenes if s.suffix == ".json"], options.out, options.quick)
    if options.only == "buildings" or options.buildings:
        table = [sys.executable, str(Path(__file__).parent / "office_table.py"), "--render", "--out", str(options.out)]
        code |= subprocess.run(table, stdin=subprocess.DEVNULL).returncode
    return code


if __name__ == "__main__":
    sys.exit(main())
