# SPDX-License-Identifier: GPL-3.0-or-later
"""Style that tools decide, and what must not be in the tree."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def tracked() -> list[Path]:
    git = shutil.which("git")
    if git is None or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    # The folder may belong to another user (a container's mount): git must read it all the same.
    command = [git, "-c", f"safe.directory={ROOT}", "-C", str(ROOT), "ls-files", "-z"]
    listed = subprocess.run(command, check=True, capture_output=True).stdout.decode().split("\0")
    return [ROOT / name for name in listed if name and (ROOT / name).is_file()]


def sources() -> list[Path]:
    return [p for p in tracked() if p.suffix in {".c", ".h", ".py", ".sh"} or p.name == "run"]


def test_ruff_finds_nothing():
    ruff = ROOT / "build" / "tools" / "bin" / "ruff"
    found = str(ruff) if ruff.exists() else shutil.which("ruff")
    if found is None:
        pytest.skip("ruff is not at hand (./build.sh deps brings it from PyPI)")
    done = subprocess.run([found, "check", "--no-cache", str(ROOT)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_c_is_laid_out_by_clang_format():
    tool = shutil.which("clang-format-14") or shutil.which("clang-format")
    if tool is None or "version 14." not in subprocess.run([tool, "--version"], capture_output=True, text=True).stdout:
        pytest.skip("no clang-format 14 (others lay out a little differently)")
    files = [str(p) for p in sources() if p.suffix in {".c", ".h"}]
    done = subprocess.run([tool, "--dry-run", "-Werror", *files], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]


def test_every_source_names_its_licence_at_the_top():
    missing = [
        str(p.relative_to(ROOT))
        for p in sources()
        if p.stat().st_size and "SPDX-License-Identifier: GPL-3.0-or-later" not in "".join(p.open().readlines()[:3])
    ]
    assert missing == []


def test_no_source_file_is_longer_than_800_lines():
    assert {str(p.relative_to(ROOT)): n for p in sources() if (n := len(p.read_text().splitlines())) > 800} == {}


def test_no_tracked_file_is_larger_than_2_mib():
    assert [str(p.relative_to(ROOT)) for p in tracked() if p.stat().st_size > 2 * 1024 * 1024] == []


def test_no_path_of_one_machine_is_in_the_tree():
    paths = re.compile(rb"(?<![\w.$/~-])/(?:work|home/\w+|root)/\w")
    found = []
    for path in tracked():
        data = path.read_bytes()
        if b"\0" not in data[:1000] and paths.search(data):
            found.append(str(path.relative_to(ROOT)))
    assert found == []


def test_scripts_can_be_run():
    for name in ("build.sh", ".ci/run"):
        assert os.access(ROOT / name, os.X_OK), name


def test_what_the_readmes_link_to_is_there():
    missing = []
    for page in (p for p in tracked() if p.suffix == ".md"):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            if "://" not in target and not (page.parent / target).exists():
                missing.append(f"{page.relative_to(ROOT)}: {target}")
    assert missing == []
