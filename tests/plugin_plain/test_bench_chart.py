# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's picture: every run lands on it, zero errors in their own band, wrong tables are refused by name."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from enfilade.report import drawing, images

SCRIPT = Path(__file__).resolve().parents[1] / "bench" / "chart.py"
ROWS = """# a comment
scene,method,cpu_s,missed_pairs
a,sample,0.1,900
a,sample,1,0
b,exact,0.5,0
b,peer,9,3
b,clock,3,
b,broken,,
"""


def run(source, out, *options):
    return subprocess.run([sys.executable, str(SCRIPT), str(source), "--out", str(out), *options], capture_output=True,
                          text=True, check=False)


@pytest.mark.skipif(images.oiio is None, reason="OpenImageIO's Python module is absent")
def test_a_chart_of_a_table(tmp_path):
    (tmp_path / "r.csv").write_text(ROWS)
    done = run(tmp_path / "r.csv", tmp_path / "chart", "--error", "missed_pairs:Pairs <missed>")
    assert done.returncode == 0, done.stderr
    root = ET.parse(tmp_path / "chart.svg").getroot()
    words = [t.text for t in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"Pairs <missed>", "sample", "exact", "peer", "clock (time alone)", "0", "0.1", "10", "1000"} <= set(words)
    pixels = images.read_image(tmp_path / "chart.png").pixels[..., :3]
    for colour in ("#1f6f8b", "#e39a12", "#9a3412"):
        tone = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255 * 0.9 + 0.1
        assert (np.abs(pixels - tone).max(axis=2) < 0.03).sum() > 30, colour


def test_a_table_without_the_column_is_refused_by_name(tmp_path):
    (tmp_path / "r.csv").write_text(ROWS)
    done = run(tmp_path / "r.csv", tmp_path / "chart", "--error", "nonsense")
    assert done.returncode != 0 and "nonsense" in done.stderr and "missed_pairs" in done.stderr
    (tmp_path / "e.csv").write_text("scene,method,cpu_s\n")
    assert "no rows" in run(tmp_path / "e.csv", tmp_path / "chart").stderr


def test_marks_and_colours_go_together():
    sys.path.insert(0, str(SCRIPT.parent))
    import chart

    assert len(chart.COLOURS) == len(chart.MARKS) == len(set(chart.MARKS)) == len(set(chart.COLOURS))
    page = drawing.Drawing(10, 10, "")
    for kind in chart.MARKS:
        chart.mark(page, kind, 5, 5, 2, "#000000")
    low, high = chart.decades([0, float("nan"), 3.0])
    assert low < np.log10(3) < high and high - low == pytest.approx(1) and len(chart.powers((low, high))) >= 1
    assert list(chart.powers(chart.decades([0.01, 100]))) == [-2, -1, 0, 1, 2]
