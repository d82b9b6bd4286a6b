# SPDX-License-Identifier: GPL-3.0-or-later
"""What the end-to-end tests share: the sample scenes, detected once."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "oracle"))


@dataclass
class Done:
    code: int
    out: str
    err: str

    @property
    def answer(self) -> dict:
        """The command's result: one line of JSON among what Blender says."""
        for line in reversed(self.out.splitlines()):
            if line.startswith("{"):
                return json.loads(line)
        raise AssertionError(f"no JSON in the output:\n{self.out[-3000:]}\n{self.err[-3000:]}")


def run_blender(*arguments: object) -> Done:
    program = os.environ.get("ENFILADE_BLENDER") or shutil.which("blender")
    if not program:
        pytest.skip("no Blender")
    done = subprocess.run([program, "-b", "--factory-startup", *map(str, arguments)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=1800)
    return Done(done.returncode, done.stdout, done.stderr)


def batch(blend: Path, *arguments: object) -> Done:
    """`blender -b FILE -P plugin/batch.py -- ...`; must succeed."""
    done = run_blender(blend, "--python-exit-code", "3", "-P", ROOT / "plugin" / "batch.py", "--", *arguments)
    assert done.code == 0, done.out[-4000:] + done.err[-4000:]
    return done


@dataclass
class Sample:
    blend: Path  # with what Detect found saved in it
    scene: Path  # *.enf.json
    answer: dict

    @property
    def json(self) -> dict:
        return json.loads(self.scene.read_text())


def _detect(blend: Path, folder: Path) -> Sample:
    sample = Sample(folder / blend.name, folder / f"{blend.stem}.enf.json", {})
    sample.answer = batch(blend, "detect", "--save", sample.blend, "--scene-json", sample.scene).answer
    return sample


@pytest.fixture(scope="session")
def house(tmp_path_factory) -> Sample:
    return _detect(ROOT / "sample_blends" / "house.blend", tmp_path_factory.mktemp("house"))


@pytest.fixture(scope="session")
def office(tmp_path_factory) -> Sample:
    """46 rooms on one floor, made anew."""
    folder = tmp_path_factory.mktemp("office")
    blend = folder / "made" / "office_46.blend"
    done = run_blender("--python-exit-code", "3", "-P", ROOT / "sample_blends" / "make_samples.py", "--", "office",
                       "--rooms-per-storey", 46, "--out", blend)
    assert done.code == 0, done.out + done.err
    return _detect(blend, folder)
