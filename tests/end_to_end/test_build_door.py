# SPDX-License-Identifier: GPL-3.0-or-later
"""README's two commands, as a newcomer types them: from another folder, without a terminal."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOOR = str(ROOT / "build.sh")


def run(*arguments: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [DOOR, *arguments],
        cwd=cwd,
        # What is to be installed was installed by whoever runs these tests.
        env={**os.environ, "ENFILADE_NO_DEPS": "1", **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=1800,
    )


def test_help_names_both_commands_of_the_readme(tmp_path):
    done = run(cwd=tmp_path)
    assert done.returncode == 0
    readme = (ROOT / "README.md").read_text()
    for command in ("./build.sh demo", "./build.sh test"):
        assert command in done.stdout and command in readme


def test_ci_runs_the_readme_s_test_command():
    assert "build.sh\" test" in (ROOT / ".ci" / "run").read_text()


def test_an_unknown_command_fails_and_says_so(tmp_path):
    for arguments in (["nonsense"], ["test", "nonsense"]):
        done = run(*arguments, cwd=tmp_path, ENFILADE_RESULTS=str(tmp_path / "results"))
        assert done.returncode != 0
        assert "nonsense" in done.stderr


def test_one_part_of_the_tests_ends_with_its_sum(tmp_path):
    done = run("test", "lint", cwd=tmp_path, ENFILADE_RESULTS=str(tmp_path / "results"))
    last = done.stdout.strip().splitlines()[-1]
    assert last.split()[1::2] == ["passed,", "failed,", "skipped"], done.stdout + done.stderr
    assert int(last.split()[0]) > 0


def tally(folder: Path, *broken: str) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "tally.py"), str(folder), *broken], capture_output=True, text=True
    )
    return done.returncode, done.stdout.strip().splitlines()[-1]


CTEST = """<testsuite><testcase name="test_a" status="{status}"><system-out>
[==========] Running 3 test(s).
[ RUN      ] one
[       OK ] one
[ RUN      ] two
{line} two
[ RUN      ] three
[  SKIPPED ] three
[  FAILED  ] 1 test(s), listed below:
</system-out></testcase></testsuite>"""


def test_the_sum_counts_cmocka_s_cases(tmp_path):
    (tmp_path / "c.ctest.xml").write_text(CTEST.format(status="run", line="[       OK ]"))
    assert tally(tmp_path) == (0, "2 passed, 0 failed, 1 skipped")
    (tmp_path / "c.ctest.xml").write_text(CTEST.format(status="fail", line="[  FAILED  ]"))
    assert tally(tmp_path) == (1, "1 passed, 1 failed, 1 skipped")


def test_the_sum_counts_a_crash_and_a_suite_that_never_reported(tmp_path):
    (tmp_path / "c.ctest.xml").write_text('<testsuite><testcase name="a" status="fail"><failure/></testcase></testsuite>')
    assert tally(tmp_path) == (1, "0 passed, 1 failed, 0 skipped")
    (tmp_path / "c.ctest.xml").unlink()
    (tmp_path / "fuzz.lines").write_text("fuzz_a passed\nno wine here skipped\n")
    assert tally(tmp_path) == (0, "1 passed, 0 failed, 1 skipped")
    assert tally(tmp_path, "Inside Blender") == (1, "1 passed, 1 failed, 1 skipped")


# ---- demo --------------------------------------------------------------------------------------------------

DEMO = ROOT / "build" / "demo"


@pytest.fixture(scope="module")
def demo(tmp_path_factory) -> subprocess.CompletedProcess[str]:
    done = run("demo", cwd=tmp_path_factory.mktemp("elsewhere"))
    assert done.returncode == 0, f"{done.stdout[-3000:]}\n{done.stderr[-6000:]}"
    return done


def test_demo_says_what_to_open_and_it_is_there(demo):
    for name in ("report/report.html", "house_culled.blend", "house.enf.json", "render"):
        assert (DEMO / name).exists(), name
    assert "build/demo/report/report.html" in demo.stderr


def test_demo_finds_the_house(demo):
    scene = json.loads((DEMO / "house.enf.json").read_text())
    assert len([r for r in scene["rooms"] if r.get("kind", "interior") == "interior"]) == 8
    assert len(scene["cameras"]) >= 3
    assert len(scene["objects"]) > 100
    info = subprocess.run(
        [str(ROOT / "build/bin/enfilade"), "info", str(DEMO / "house.enf.json"), "--json"], capture_output=True, text=True
    )
    assert info.returncode == 0, info.stderr
    assert json.loads(info.stdout)["cells"] >= 8


class Links(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.outside: list[str] = []
        self.images = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("src", "href") and value and value.split(":")[0] in ("http", "https", "file") and tag != "a":
                self.outside.append(value)
        self.images += tag in ("img", "svg")


def test_the_report_opens_from_disk_with_pictures_first(demo):
    page = (DEMO / "report" / "report.html").read_text(encoding="utf-8")
    links = Links()
    links.feed(page)
    assert links.outside == []
    assert links.images >= 2
    json.loads((DEMO / "report" / "report.json").read_text())
    tables = list((DEMO / "report").glob("*.csv"))
    assert tables
    for table in tables:
        with table.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        assert len({len(row) for row in rows}) == 1, f"{table.name} has ragged rows"
    pictures = [p for p in (DEMO / "report").glob("*.png") if p.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"]
    assert len(pictures) >= 2  # a plan per storey


def test_the_culled_picture_shows_the_same(demo):
    """render --verify fails by itself on a wrong pixel; here: it compared something."""
    results = list((DEMO / "render").rglob("*.json"))
    assert results, "render --verify left no figures"
    text = "\n".join(path.read_text() for path in results)
    assert "wrong" in text or "differ" in text
