# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip, built, validated, installed into an empty Blender user folder, and tested as installed."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
DETECT = ["detect", "--scene-json", "by_expression.json"]
HOUSE = ROOT / "sample_blends" / "house.blend"


@pytest.fixture(scope="session")
def zip_path() -> Path:
    library = ROOT / "build" / "lib" / "libenfilade.so"
    if not library.exists():
        pytest.fail("build/lib/libenfilade.so is missing: ./build.sh build")
    out = ROOT / "build" / "package"
    command = [sys.executable, str(ROOT / "plugin" / "package.py"), "--library", str(library), "--out", str(out)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return Path(printed.rsplit(" (", 1)[0])


def names(path: Path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        return archive.namelist()


def test_zip_holds_the_addon_the_shim_and_the_library_and_nothing_else(zip_path):
    found = names(zip_path)
    assert "enfilade/__init__.py" in found
    assert "enfilade/blender_manifest.toml" in found
    assert "enfilade/LICENSE" in found
    assert "enfilade/enfilade_native/__init__.py" in found
    # Embree, for triangles, and its tasks, with their licences.
    packages = ("libembree3-3", "libtbb12", "libgmp-dev", "libjansson-dev")
    bundled = {"libenfilade.so", "libembree3.so.3", "libtbb.so.12"} | {f"{package}.copyright" for package in packages}
    assert {n.rsplit("/", 1)[1] for n in found if n.startswith("enfilade/enfilade_native/lib/")} == bundled
    assert {n.split("/")[0] for n in found} == {"enfilade"}
    assert not [n for n in found if "__pycache__" in n or n.endswith((".pyc", ".blend", ".c", ".h"))]


def test_the_same_input_gives_the_same_bytes(zip_path, tmp_path):
    library = ROOT / "build" / "lib" / "libenfilade.so"
    command = [sys.executable, str(ROOT / "plugin" / "package.py"), "--library", str(library), "--out", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / zip_path.name).read_bytes() == zip_path.read_bytes()


def test_the_library_needs_nothing_but_the_c_library(zip_path, tmp_path):
    if shutil.which("objdump") is None:
        pytest.skip("no objdump")
    with zipfile.ZipFile(zip_path) as archive:
        library = archive.extract("enfilade/enfilade_native/lib/libenfilade.so", tmp_path)
    dump = subprocess.run(["objdump", "-p", library], check=True, capture_output=True, text=True).stdout
    needed = set(re.findall(r"NEEDED\s+(\S+)", dump))
    assert needed <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2"}, needed


def test_the_library_exports_our_names_only(zip_path, tmp_path):
    if shutil.which("nm") is None:
        pytest.skip("no nm")
    with zipfile.ZipFile(zip_path) as archive:
        library = archive.extract("enfilade/enfilade_native/lib/libenfilade.so", tmp_path)
    listed = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    symbols = {line.split()[-1] for line in listed.splitlines()}
    assert symbols and all(s.startswith("enf_") for s in symbols), sorted(s for s in symbols if not s.startswith("enf_"))[:10]


def run(blender: str, user: Path, *arguments: str, expect: int = 0) -> str:
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("ENFILADE_", "PYTHON", "BLENDER_"))}
    # An empty user of its own: nothing of this machine's settings, and nothing of the source tree.
    for name in ("CONFIG", "SCRIPTS", "DATAFILES", "EXTENSIONS"):
        environment[f"BLENDER_USER_{name}"] = str(user / name.lower())
        (user / name.lower()).mkdir(parents=True, exist_ok=True)
    environment["HOME"] = str(user)
    done = subprocess.run(
        [blender, *arguments],
        cwd=user,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=1800,
    )
    output = done.stdout + done.stderr
    assert done.returncode == expect, f"exit code {done.returncode}\n{output[-6000:]}"
    return output


def version_of(blender: str) -> tuple[int, ...]:
    out = subprocess.run([blender, "--version"], capture_output=True, text=True, stdin=subprocess.DEVNULL).stdout
    return tuple(int(n) for n in re.search(r"Blender (\d+)\.(\d+)", out).groups())


def check_installed(blender: str, zip_path: Path, user: Path) -> None:
    installed = "import bpy; "
    if version_of(blender) >= (4, 2):
        module = "bl_ext.user_default.enfilade"
        assert "error" not in run(blender, user, "--command", "extension", "validate", str(zip_path)).lower()
        run(blender, user, "--command", "extension", "install-file", "-r", "user_default", "--enable", str(zip_path))
    else:
        module = "enfilade"
        installed += f"bpy.ops.preferences.addon_install(filepath={str(zip_path)!r}); "
        installed += "bpy.ops.preferences.addon_enable(module='enfilade'); bpy.ops.wm.save_userpref()"
        run(blender, user, "-b", "--python-exit-code", "3", "--python-expr", installed)
    # A second, fresh process: what a user has the next morning.
    check = [str(HERE / "in_blender_check.py"), "--", module, str(user), str(user / "house.enf.json")]
    house = user / "house.blend"
    shutil.copy(HOUSE, house)
    output = run(blender, user, "-b", str(house), "--python-exit-code", "3", "-P", *check)
    assert "package check passed" in output, output[-4000:]
    assert "Traceback" not in output, output[-6000:]
    if version_of(blender) >= (4, 2):  # the command line that newer versions let an add-on offer
        run(blender, user, "-b", str(house), "-c", "enfilade", "detect", "--scene-json", str(user / "by_command.json"))
        assert (user / "by_command.json").stat().st_size > 1000
    # What a user without a source tree types in any version.
    code = f"import sys, importlib; sys.exit(importlib.import_module({module + '.commands'!r}).run({DETECT!r}))"
    run(blender, user, "-b", str(house), "--python-exit-code", "3", "--python-expr", code)
    assert (user / "by_expression.json").stat().st_size > 1000


def test_installed_in_an_empty_blender(zip_path, tmp_path):
    blender = os.environ.get("ENFILADE_BLENDER") or shutil.which("blender")
    if not blender:
        pytest.skip("no Blender")
    check_installed(blender, zip_path, tmp_path)


def test_installed_in_a_newer_blender(zip_path, tmp_path):
    blender = os.environ.get("ENFILADE_NEW_BLENDER")
    if not blender:
        pytest.skip("ENFILADE_NEW_BLENDER names no newer Blender")
    check_installed(blender, zip_path, tmp_path)
