# SPDX-License-Identifier: GPL-3.0-or-later
"""Run time against error, as a picture: reads the benchmark's CSV, writes SVG and PNG.

    python3 tests/bench/chart.py RESULTS.csv --out build/bench/accuracy [--title T]
            [--scene scene] [--method method] [--time cpu_s] [--error missed_pairs:"pairs missed" --error overestimate]

One row of the CSV is one run. One panel per error column, side by side: time on a logarithmic axis across, error on a
logarithmic axis up with a band of its own for *zero*, which a logarithm can't show and which is what matters here.
Runs of one method have one colour and one mark, and a row of their own in the band of zero. The runs of one scene at growing
budgets are joined by a thin line that ends in the scene's name. Runs that tell no error (a peer without a matrix) stand on the axis of time.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "plugin"))

from enfilade.report import drawing as d
from enfilade.report import images, raster, svg
from enfilade.report.drawing import Drawing

# Distinct for any colour vision and in print: hue and lightness both change, and each has its own mark.
COLOURS = ["#1f6f8b", "#e39a12", "#9a3412", "#6b7280", "#3f7d3a", "#7c5ba6", "#26282b", "#c46a9d"]
MARKS = ["disc", "square", "triangle", "diamond", "ring", "cross", "box", "down"]
PANEL_WIDTH, PANEL_HEIGHT, LEFT, TOP, GAP, FOOT = 430.0, 330.0, 78.0, 86.0, 92.0, 66.0
ZERO_ROW = 14.0  # page units below the logarithmic axis, for errors of exactly nothing: a row a method
MARGIN = 0.12  # decades beyond the fastest and the slowest run, the least and the largest error
GRID, AXIS = "#e4e4df", "#9aa0a8"


def number(text: str | None) -> float:
    """A figure of the CSV; NaN where there is none."""
    try:
        return float(text) if text not in (None, "") else math.nan
    except ValueError:
        return math.nan


def decades(values: list[float]) -> tuple[float, float]:
    """Exponents of ten that span positive values, a little beyond them; one decade at least, so that a tick is in it."""
    positive = [v for v in values if math.isfinite(v) and v > 0]
    if not positive:
        return 0.0, 1.0
    low, high = math.log10(min(positive)) - MARGIN, math.log10(max(positive)) + MARGIN
    short = max(0.0, 1.0 - (high - low))
    return low - 0.5 * short, high + 0.5 * short


def powers(span: tuple[float, float], most: int = 8) -> range:
    """The whole exponents in a span that get a tick."""
    low, high = math.ceil(span[0] - 1e-9), math.floor(span[1] + 1e-9)
    return range(low, high + 1, max(1, (high - low) // most))


def tick(power: int) -> str:
    """10^p as people write it, in letters that every font has."""
    return f"{10.0**power:g}" if -3 <= power <= 3 else f"1e{power}"


def mark(out: Drawing, kind: str, x: float, y: float, r: float, colour: str) -> None:
    """One run."""
    turn = [2 * math.pi * k / 20 for k in range(20)]
    circle = [(x + r * math.cos(t), y + r * math.sin(t)) for t in turn]
    shapes = {"square": [(-1, -1), (1, -1), (1, 1), (-1, 1)], "triangle": [(0, -1.25), (1.15, 0.85), (-1.15, 0.85)],
              "diamond": [(0, -1.35), (1.35, 0), (0, 1.35), (-1.35, 0)], "down": [(0, 1.25), (1.15, -0.85), (-1.15, -0.85)]}
    if kind in shapes:
        ring = [(x + r * 0.9 * p, y + r * 0.9 * q) for p, q in shapes[kind]]
        out.polygon(ring, colour, 0.9)
        out.line(ring, "#ffffff", 0.8, closed=True)
    elif kind == "disc":
        out.polygon(circle, colour, 0.9)
        out.line(circle, "#ffffff", 0.8, closed=True)
    elif kind == "ring":
        out.line(circle, colour, 1.8, closed=True)
    elif kind == "box":
        out.line([(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)], colour, 1.8, closed=True)
    else:
        out.line([(x - r, y - r), (x + r, y + r)], colour, 2.0)
        out.line([(x - r, y + r), (x + r, y - r)], colour, 2.0)


def chart(rows: list[dict[str, str]], title: str, scene: str, method: str, time: str, errors: list[tuple[str, str]],
          seconds: str = "CPU seconds") -> Drawing:
    """The picture of a table. errors: (column, label) each."""
    methods = list(dict.fromkeys(r.get(method, "") for r in rows))
    judged = {r.get(method, "") for r in rows if any(math.isfinite(number(r.get(column))) for column, _ in errors)}
    words = [d.shorten(m, 40) + ("" if m in judged else " (time alone)") for m in methods]
    width = LEFT + len(errors) * PANEL_WIDTH + (len(errors) - 1) * GAP + 30
    legend_rows = 1 + sum(d.text_width(m, 12) + 40 for m in words) // (width - LEFT - 30)
    band = 12 + ZERO_ROW * len(methods)
    out = Drawing(width, TOP + PANEL_HEIGHT + band + FOOT + 22 * legend_rows, title)
    out.text(LEFT, 30, title, 17, d.INK, "start", True)
    out.text(LEFT, 48, f"{len(rows)} runs on {len({r.get(scene, '') for r in rows})} scenes; down and left is better. "
             "Lines join one scene's runs at growing budgets", 11.5, d.FAINT_INK)
    span = decades([number(r.get(time)) for r in rows])
    for panel, (column, label) in enumerate(errors):
        left = LEFT + panel * (PANEL_WIDTH + GAP)
        _panel(out, rows, left, column, label, scene, method, time, seconds, methods, span, band)
    x, y = LEFT, TOP + PANEL_HEIGHT + band + FOOT
    for k, name in enumerate(words):
        w = d.text_width(name, 12) + 40
        if x + w > width - 20 and x > LEFT:
            x, y = LEFT, y + 22
        mark(out, MARKS[k % len(MARKS)], x + 6, y - 4, 5.0, COLOURS[k % len(COLOURS)])
        out.text(x + 18, y, name, 12)
        x += w
    return out


def _panel(out, rows, left, column, label, scene, method, time, seconds, methods, span, band) -> None:
    x_low, x_high = span
    y_span = y_low, y_high = decades([number(r.get(column)) for r in rows])
    right, bottom = left + PANEL_WIDTH, TOP + PANEL_HEIGHT
    def across(t: float) -> float:
        return left + 14 + (math.log10(t) - x_low) / (x_high - x_low) * (PANEL_WIDTH - 28)

    def up(e: float, name: str = "") -> float:
        if e <= 0:
            return bottom + 12 + ZERO_ROW * (methods.index(name) + 0.5)
        return bottom - 8 - (math.log10(e) - y_low) / (y_high - y_low) * (PANEL_HEIGHT - 20)

    out.polygon([(left, bottom + 6), (right, bottom + 6), (right, bottom + band), (left, bottom + band)], "#eef4f0")
    for p in powers(span):
        out.line([(across(10.0**p), TOP), (across(10.0**p), bottom + band)], GRID, 0.8)
        out.text(across(10.0**p), bottom + band + 16, tick(p), 10.5, d.INK, "middle")
    for p in powers(y_span):
        out.line([(left, up(10.0**p)), (right, up(10.0**p))], GRID, 0.8)
        out.text(left - 8, up(10.0**p) + 4, tick(p), 10.5, d.INK, "end")
    out.text(left - 8, bottom + 0.5 * band + 7, "0", 11, d.INK, "end", True)
    out.line([(left, TOP), (left, bottom + band), (right, bottom + band)], AXIS, 1.0)
    out.text(left, TOP - 6, label, 12, d.INK, "start", True)
    out.text(right, bottom + band + 34, seconds, 11, d.FAINT_INK, "end")
    series: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for r in rows:
        t, e = number(r.get(time)), number(r.get(column))
        if math.isfinite(t) and t > 0 and math.isnan(e):
            k = methods.index(r.get(method, ""))
            mark(out, MARKS[k % len(MARKS)], across(t), bottom + band, 4.2, COLOURS[k % len(COLOURS)])
        if math.isfinite(t) and t > 0 and math.isfinite(e) and e >= 0:
            series.setdefault((r.get(method, ""), r.get(scene, "")), []).append((t, e))
    ends: list[tuple[float, float, str]] = []
    for (name, where), points in series.items():
        points.sort()
        if len(points) > 1 and any(e > 0 for _, e in points):
            pale = COLOURS[methods.index(name) % len(COLOURS)]
            out.line([(across(t), up(e, name)) for t, e in points], pale, 0.6)
            ends.append((up(points[-1][1], name), across(points[-1][0]), where))
    lowest = -math.inf
    for y, x, where in sorted(ends):  # names keep off each other, downward
        lowest = max(y, lowest + 11)
        turn = x + d.text_width(where, 9) > right - 8  # curves fall: below and to the left of an end there is room
        out.text(x + (4 if turn else 8), lowest + (17 if turn else 3), d.shorten(where, 22), 9, d.FAINT_INK, "end" if turn else "start")
    for (name, _), points in series.items():
        k = methods.index(name)
        for t, e in points:
            mark(out, MARKS[k % len(MARKS)], across(t), up(e, name), 4.2, COLOURS[k % len(COLOURS)])
    if not series:
        out.text((left + right) / 2, (TOP + bottom) / 2, "no figures", 12, d.FAINT_INK, "middle")


def write_chart(source: Path, out: Path, title: str = "Run time against error", scene: str = "scene", method: str = "method",
                time: str = "cpu_s", errors: list[tuple[str, str]] | None = None, seconds: str = "CPU seconds") -> list[Path]:
    """Reads a CSV, writes OUT.svg and OUT.png; returns both. Lines that start with # are comments."""
    with open(source, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    if not rows:
        raise SystemExit(f"{source}: no rows")
    missing = [c for c in (scene, method, time, *(c for c, _ in errors or [])) if c not in rows[0]]
    if missing:
        raise SystemExit(f"{source}: no column {', '.join(missing)}; there are: {', '.join(rows[0])}")
    page = chart(rows, title, scene, method, time, errors or [("missed_pairs", "pairs missed")], seconds)
    out.parent.mkdir(parents=True, exist_ok=True)
    paths = [out.with_name(out.name + ".svg"), out.with_name(out.name + ".png")]
    svg.write(page, paths[0])
    images.write_png(paths[1], raster.paint(page, 2.0))
    return paths


def main() -> None:
    parser = argparse.ArgumentParser(description="run time against error, from a benchmark's CSV to SVG and PNG")
    parser.add_argument("csv", type=Path)
    parser.add_argument("--out", type=Path, required=True, metavar="PATH", help="without suffix; .svg and .png are added")
    parser.add_argument("--title", default="Run time against error")
    parser.add_argument("--scene", default="scene", metavar="COLUMN")
    parser.add_argument("--method", default="method", metavar="COLUMN")
    parser.add_argument("--time", default="cpu_s", metavar="COLUMN[:LABEL]")
    parser.add_argument("--error", action="append", default=[], metavar="COLUMN[:LABEL]", help="may be given more than once")
    options = parser.parse_args()
    errors = [(c, label or c.replace("_", " ")) for c, _, label in (e.partition(":") for e in options.error)]
    time, _, seconds = options.time.partition(":")
    for path in write_chart(options.csv, options.out, options.title, options.scene, options.method, time,
                            errors or None, seconds or "CPU seconds"):
        print(path)


if __name__ == "__main__":
    main()
