# SPDX-License-Identifier: GPL-3.0-or-later
"""How the search for rooms in bare triangles grows with what it is given: time a stage, memory, both beside what was told beforehand.

Usage: /usr/bin/python3 tests/bench/geometry_growth.py [SCENE ...] [--mode triangles classes] [--cancel] [--profile]
Scenes, made here: office:N (N storeys of rooms along a corridor, with furniture), offices:N (the same without), hall (an airport's, 400 x 120 m,
with columns and shops), town:N (N houses of two storeys). Each runs in a process of its own. Seconds are CPU of this process
and its threads. `told` is what was said before the grid was made. `slowest` is the longest time between two asks whether to go on,
which is how long a cancel takes at most. --profile: where the time goes.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import pstats
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
SCENES = ("office:1", "office:4", "office:16", "office:64", "offices:64", "hall", "town:50")
WALL = 0.2  # m
STOREY = 3.2  # m

BOX = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
BOX_FACES = np.array(
    [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
)


class Scene:
    """Boxes and balls, gathered by class."""

    def __init__(self) -> None:
        self.parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}

    def box(self, kind: str, low, high) -> None:
        low, high = np.array(low, dtype=float), np.array(high, dtype=float)
        self.parts.setdefault(kind, []).append((low + BOX * (high - low), BOX_FACES))

    def ball(self, kind: str, centre, radius: float, rings: int = 8) -> None:
        around = 2 * rings
        polar, turn = np.meshgrid(np.linspace(0.02, np.pi - 0.02, rings), np.arange(around) * 2 * np.pi / around, indexing="ij")
        points = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1).reshape(-1, 3)
        i, j = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
        a, b = i * around + j, i * around + (j + 1) % around
        faces = np.concatenate([np.stack([a, a + around, b], axis=-1), np.stack([b, a + around, b + around], axis=-1)]).reshape(-1, 3)
        self.parts.setdefault(kind, []).append((np.array(centre) + radius * points, faces))

    def wall(self, axis: int, at: float, start: float, end: float, z0: float, z1: float, holes=(), pane: str | None = None) -> None:
        """Along x (0) or y (1), with holes (start, end, low, high); pane: the class of a leaf in each."""

        def put(kind: str, a: float, b: float, low: float, high: float, thick: float = WALL) -> None:
            if b - a > 1e-6 and high - low > 1e-6:
                lo, hi = [a, at - 0.5 * thick], [b, at + 0.5 * thick]
                if axis:
                    lo, hi = lo[::-1], hi[::-1]
                self.box(kind, [*lo, low], [*hi, high])

        here = start
        for a, b, low, high in sorted(holes):
            put("shell", here, a, z0, z1)
            put("shell", a, b, z0, low)
            put("shell", a, b, high, z1)
            if pane:
                put(pane, a, b, low, high, 0.05)
            here = b
        put("shell", here, end, z0, z1)

    def elements(self, mode: str):
        from enfilade.rules import geometry
        from enfilade.rules.geometry_elements import Element

        made = []
        for kind, parts in self.parts.items():
            if kind in ("door", "window"):
                made += [Element(f"{kind} {i}", kind, v, f) for i, (v, f) in enumerate(parts)]
                continue
            first = np.cumsum([0] + [len(v) for v, _ in parts])
            made.append(Element(kind, kind, np.concatenate([v for v, _ in parts]), np.concatenate([f + n for (_, f), n in zip(parts, first, strict=False)])))
        return [geometry.soup(made)] if mode == geometry.TRIANGLES else made


def furnish(s: Scene, x: float, y: float, z: float) -> None:
    """A desk with what stands on and round it, a shelf, a lamp."""
    s.box("furniture", (x, y, z + 0.72), (x + 1.6, y + 0.8, z + 0.75))
    for dx in (0.0, 1.55):
        for dy in (0.0, 0.75):
            s.box("furniture", (x + dx, y + dy, z), (x + dx + 0.05, y + dy + 0.05, z + 0.72))
    s.box("furniture", (x + 0.5, y + 0.55, z + 0.8), (x + 1.1, y + 0.6, z + 1.15))
    s.ball("furniture", (x + 0.8, y - 0.4, z + 0.45), 0.25)
    s.box("furniture", (x + 0.6, y - 0.6, z + 0.42), (x + 1.0, y - 0.2, z + 0.47))
    s.box("furniture", (x, y + 1.0, z), (x + 0.8, y + 1.3, z + 1.1))
    s.ball("furniture", (x + 0.8, y + 0.4, z + 2.5), 0.15)


def office(storeys: int, furniture: bool = True) -> Scene:
    """Eighteen rooms along a corridor and a stairwell's hole, storey on storey."""
    s, rooms, room, deep, corridor = Scene(), 10, 4.0, 6.0, 2.4
    long, wide = rooms * room, 2 * deep + corridor
    for n in range(storeys):
        z, top = n * STOREY, (n + 1) * STOREY - 0.3
        hole = (long - room + 0.5, 1.0, long - 0.5, deep - 1.0) if n else None
        slab(s, (0.0, 0.0, long, wide), hole, z - 0.3, z)
        for y, pane in ((0.0, True), (deep, False), (deep + corridor, False), (wide, True)):
            low, high, left, right = (0.9, 2.2, 1.0, 3.0) if pane else (0.0, 2.1, 1.5, 2.4)
            holes = [(i * room + left, i * room + right, z + low, z + high) for i in range(rooms)]
            s.wall(0, y, -0.1, long + 0.1, z, top, holes, "window" if pane else "door")
        for i in range(rooms + 1):
            for y in (0.1, deep + corridor + 0.1):
                s.wall(1, i * room, y, y + deep - 0.2, z, top)
        for x in (0.0, long):
            s.wall(1, x, deep, deep + corridor, z, top)
        for i in range(rooms):
            for y in (2.0, deep + corridor + 3.0):
                if furniture and not (i == rooms - 1 and y < deep):
                    furnish(s, i * room + 0.6, y, z)
                    furnish(s, i * room + 2.3, y, z)
    slab(s, (0.0, 0.0, long, wide), None, storeys * STOREY - 0.3, storeys * STOREY)
    return s


def slab(s: Scene, plan, hole, z0: float, z1: float) -> None:
    (x0, y0, x1, y1) = plan
    if hole is None:
        s.box("shell", (x0 - 0.1, y0 - 0.1, z0), (x1 + 0.1, y1 + 0.1, z1))
        return
    a, b, c, d = hole
    for low, high in (((x0 - 0.1, y0 - 0.1), (a, y1 + 0.1)), ((c, y0 - 0.1), (x1 + 0.1, y1 + 0.1)), ((a, y0 - 0.1), (c, b)), ((a, d), (c, y1 + 0.1))):
        s.box("shell", (*low, z0), (*high, z1))


def hall(long: float = 400.0, wide: float = 120.0, high: float = 14.0) -> Scene:
    """One large hall, columns 16 m apart, shops along both long sides, seats."""
    s, shop, deep = Scene(), 8.0, 10.0
    slab(s, (0.0, 0.0, long, wide), None, -0.4, 0.0)
    slab(s, (0.0, 0.0, long, wide), None, high, high + 0.4)
    count = int(long / shop)
    for y in (0.0, wide):
        holes = [(i * shop + 3.0, i * shop + 5.0, 0.0, 2.4) for i in range(0, count, 10)]
        s.wall(0, y, -0.1, long + 0.1, 0.0, high, holes, "door")
    for x in (0.0, long):
        s.wall(1, x, 0.1, wide - 0.1, 0.0, high)
    for y, inner in ((0.0, deep), (wide, wide - deep)):
        slab(s, (0.0, min(y, inner), long, max(y, inner)), None, 4.0, 4.2)
        s.wall(0, inner, 0.1, long - 0.1, 0.0, 4.0, [(i * shop + 3.0, i * shop + 5.0, 0.0, 2.4) for i in range(count)], "door")
        for i in range(1, count):
            s.wall(1, i * shop, min(y, inner) + 0.1, max(y, inner) - 0.1, 0.0, 4.0)
    for x in np.arange(16.0, long - 1.0, 16.0):
        for y in np.arange(28.0, wide - 12.0, 16.0):
            s.box("shell", (x - 0.4, y - 0.4, 0.0), (x + 0.4, y + 0.4, high))
            for k in range(8):
                furnish(s, x + 1.5, y - 6.0 + 1.5 * k, 0.0)
    return s


def town(houses: int) -> Scene:
    """Houses of two storeys and four rooms each on lots of 24 x 20 m."""
    s, across = Scene(), max(1, int(round((houses * 0.5) ** 0.5 * 2 ** 0.5)))
    for n in range(houses):
        x, y = 24.0 * (n % across), 20.0 * (n // across)
        for level in range(2):
            z, top = level * STOREY, (level + 1) * STOREY - 0.3
            slab(s, (x, y, x + 12.0, y + 8.0), (x + 1.0, y + 1.0, x + 3.0, y + 3.0) if level else None, z - 0.3, z)
            for v, outer in ((0.0, True), (4.0, False), (8.0, True)):
                low, high = (z + 0.9, z + 2.2) if outer else (z, z + 2.1)
                holes = [(x + u, x + u + (1.5 if outer else 0.9), low, high) for u in (2.0, 8.0)]
                if outer and not v and not level:
                    holes.append((x + 4.5, x + 5.4, z, z + 2.1))
                s.wall(0, y + v, x - 0.1, x + 12.1, z, top, holes, "window" if outer else "door")
            for u in (0.0, 6.0, 12.0):
                for v in (0.1, 4.1):
                    holes = [(y + v + 1.0, y + v + 1.9, z, z + 2.1)] if u == 6.0 else []
                    s.wall(1, x + u, y + v, y + v + 3.8, z, top, holes, "door")
            for u in (0.8, 3.6, 7.0, 9.8):
                furnish(s, x + u, y + 5.0, z)
        slab(s, (x, y, x + 12.0, y + 8.0), None, 2 * STOREY - 0.3, 2 * STOREY)
    return s


def scene(name: str) -> Scene:
    what, _, size = name.partition(":")
    if what in ("office", "offices"):
        return office(int(size or 1), what == "office")
    return hall() if what == "hall" else town(int(size or 50))


def cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def measure(name: str, mode: str, profile: bool) -> dict:
    from enfilade.rules import geometry

    elements = scene(name).elements(mode)
    triangles = sum(len(e.triangles) for e in elements)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    steps: list[tuple[float, float, float, str]] = []

    def progress(fraction: float, label: str) -> bool:
        steps.append((time.perf_counter(), cpu(), fraction, label))
        return True

    profiler = cProfile.Profile()
    progress(0.0, "start")
    if profile:
        profiler.enable()
    found = geometry.detect(elements, mode=mode, progress=progress)
    profiler.disable()
    if profile:
        pstats.Stats(profiler, stream=sys.stderr).sort_stats("cumulative").print_stats(45)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    gaps = [(b[1] - a[1], f"{a[3]}..{b[3]}") for a, b in zip(steps, steps[1:], strict=False)]
    return {"triangles": triangles, "rooms": len(found.rooms) - 1, "openings": len(found.openings), "seconds": steps[-1][1] - steps[0][1],
            "mib": peak, "before": before, "slowest": max(gaps), "stages": found.statistics,
            "steps": [(round(t - steps[0][0], 2), round(f, 3), label) for t, _, f, label in steps],
            "problems": [str(p.message) for p in found.problems[:3]]}  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--mode", nargs="+", default=["triangles"], choices=["triangles", "classes"])
    parser.add_argument("--profile", action="store_true")
    parser.add_argument("--verbose", action="store_true", help="every stage and step")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.scenes[0], options.mode[0], options.profile)))
        return 0
    sys.stdout.reconfigure(line_buffering=True)
    print("scene      mode       triangles  voxels   step rooms openings  CPU s (told)     MiB (told)    s/Mvoxel  s/Mtriangle  slowest step")
    for mode in options.mode:
        for name in options.scenes:
            command = [sys.executable, __file__, "--one", name, "--mode", mode] + ["--profile"] * options.profile
            run = subprocess.run(command, capture_output=True, text=True)
            if run.returncode:
                print(f"{name:10s} {mode:9s} failed: {run.stderr.strip()[-400:]}")
                continue
            m = json.loads(run.stdout.splitlines()[-1])
            st = m["stages"]
            print(f"{name:10s} {mode:9s} {m['triangles']:10,d} {st['voxels'] / 1e6:6.1f}M {st['step m']:5.2f} {m['rooms']:6d} {m['openings']:6d} "
                  f"{m['seconds']:7.1f} ({st.get('told s', 0):4.0f}) {m['mib']:8.0f} ({st.get('told MiB', 0):5.0f}) "
                  f"{m['seconds'] / st['voxels'] * 1e6:9.2f} {m['seconds'] / m['triangles'] * 1e6:9.1f}     {m['slowest'][0]:.1f} s in {m['slowest'][1]}")
            if options.profile or options.verbose:
                print("  ", {k: round(v, 2) for k, v in st.items()}, "\n  ", m["steps"], m["problems"], "\n", run.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
