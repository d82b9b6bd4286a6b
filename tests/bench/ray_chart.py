# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through cells beside a general ray tracer, as a picture: reads the benchmark's CSV, writes SVG and PNG.

    python3 tests/bench/ray_chart.py build/bench/raycast.csv --out build/bench/raycast

One panel a kind of rays, side by side; one row a scene; each mark a method, at how many times the tracer's best mode (the vertical line
at 1) it does, on a logarithmic axis.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from pathlib import Path

import chart
from enfilade.report import drawing as d
from enfilade.report import images, raster, svg
from enfilade.report.drawing import Drawing

KINDS = {
    "primary": ["single", "packets of 16", "picture by packets", "picture by tiles", "picture by spans", "picture by spans with normal and uv"],
    "facade": ["single", "packets of 16", "picture by packets", "picture by tiles", "picture by spans", "picture by spans with normal and uv"],
    "random": ["single", "waves"],
    "bounce": ["single", "packets of 16", "waves"],
    "shadow": ["single", "packets of 16", "waves"],
}
WIDTH, ROW, LEFT, TOP, GAP, FOOT = 300.0, 26.0, 250.0, 96.0, 34.0, 60.0


def picture(rows: list[dict[str, str]]) -> Drawing:
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    methods = list(dict.fromkeys(m for kind in KINDS.values() for m in kind))
    look = {m: (chart.COLOURS[i % len(chart.COLOURS)], chart.MARKS[i % len(chart.MARKS)]) for i, m in enumerate(methods)}
    height = TOP + ROW * len(scenes) + FOOT
    out = Drawing(LEFT + len(KINDS) * (WIDTH + GAP), height + 22 * math.ceil(len(methods) / 4), "Rays through cells")
    out.text(20, 30, "Times a general ray tracer's best mode, one thread", 17, d.INK, "start", True)
    out.text(20, 52, "walls only, equal output checked; further right is faster; the line marks the tracer's best mode", 11.5, d.FAINT_INK)
    for column, (kind, shown) in enumerate(KINDS.items()):
        left = LEFT + column * (WIDTH + GAP)
        figures = {(row["scene"], row["method"]): chart.number(row["times_best"]) for row in rows if row["rays"] == kind}
        low, high = chart.decades([v for (_, m), v in figures.items() if m in shown] + [1.0])

        def across(value: float, left: float = left, low: float = low, high: float = high) -> float:
            return left + WIDTH * (math.log10(value) - low) / (high - low)

        out.text(left + WIDTH / 2, TOP - 18, kind, 13, d.INK, "middle", True)
        for power in chart.powers((low, high)):
            x = across(10.0**power)
            out.line([(x, TOP), (x, TOP + ROW * len(scenes))], chart.AXIS if power == 0 else chart.GRID, 1.6 if power == 0 else 1.0)
            out.text(x, TOP + ROW * len(scenes) + 18, chart.tick(power), 10.5, d.FAINT_INK, "middle")
        for line, scene in enumerate(scenes):
            y = TOP + ROW * (line + 0.5)
            if column == 0:
                out.text(LEFT - 12, y + 4, scene.replace(" windows=0 objects=0", ""), 11.5, d.INK, "end")
            for method in shown:
                value = figures.get((scene, method), math.nan)
                if value > 0:
                    chart.mark(out, look[method][1], across(value), y, 5.0, look[method][0])
    for i, method in enumerate(methods):
        x, y = LEFT + (i % 4) * 290, height + 22 * (i // 4)
        chart.mark(out, look[method][1], x, y - 4, 5.0, look[method][0])
        out.text(x + 12, y, method, 11.5, d.INK)
    return out


def write_chart(source: Path, out: Path) -> list[Path]:
    with open(source, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    page = picture(rows)
    paths = [out.with_name(out.name + ".svg"), out.with_name(out.name + ".png")]
    svg.write(page, paths[0])
    images.write_png(paths[1], raster.paint(page, 2.0))
    return paths


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    for path in write_chart(options.source, options.out):
        print(f"wrote {path}")


if __name__ == "__main__":
    sys.exit(main())
