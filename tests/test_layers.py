# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrows point one way: plugin -> python_shim -> csrc; and the version is the same wherever it stands."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CSRC, SHIM, PLUGIN = ROOT / "csrc", ROOT / "python_shim", ROOT / "plugin"
STANDARD_HEADERS = re.compile(
    r"^(assert|complex|ctype|errno|fenv|float|inttypes|limits|locale|math|setjmp|signal|stdalign|stdarg|stdatomic|stdbool"
    r"|stddef|stdint|stdio|stdlib|string|tgmath|threads|time|wchar)\.h$"
)
# What the core stands on, besides C17; SIMD headers only behind run-time dispatch.
LIBRARIES = re.compile(r"^(jansson|gmp|embree3/rtcore|immintrin|cpuid|xmmintrin|emmintrin|x86intrin|intrin|arm_neon)\.h$")
# POSIX and Windows headers stay in base/, which is what makes the rest portable.
SYSTEM = re.compile(r"^(windows|process|io|direct|dlfcn|fcntl|pthread|sched|unistd|psapi|share|sys/\w+)\.h$")


def c_files() -> list[Path]:
    return sorted([*CSRC.rglob("*.c"), *CSRC.rglob("*.h")])


def modules(folder: Path) -> list[Path]:
    return sorted(p for p in folder.rglob("*.py") if "__pycache__" not in p.parts)


def imports(path: Path) -> set[str]:
    """Top-level names of every absolute import of a module, at any depth of it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.split(".")[0])
    return names


def test_the_core_includes_itself_c17_and_named_libraries_only():
    wrong = []
    for path in c_files():
        for header in re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', path.read_text(encoding="utf-8"), re.M):
            own = (CSRC / header).is_file() or (CSRC / "include" / header).is_file()
            # The tool's generate and bench share their scenes with the tests.
            shared = [ROOT / "tests" / folder / header for folder in ("bench", "stress")]
            own |= path.is_relative_to(CSRC / "tools") and any(p.is_file() for p in shared)
            base = path.is_relative_to(CSRC / "base")
            if own or STANDARD_HEADERS.match(header) or LIBRARIES.match(header) or (base and SYSTEM.match(header)):
                continue
            wrong.append(f"{path.relative_to(ROOT)}: {header}")
    assert wrong == []


def test_the_core_knows_nothing_of_python_or_blender():
    words = re.compile(r"\bPython\.h\b|\bPy_\w+|\bbpy\b|\bDNA_\w+")
    assert [str(p.relative_to(ROOT)) for p in c_files() if words.search(p.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(("compiler", "standard"), [("gcc", "c17"), ("g++", "c++17"), ("clang", "c17")])
def test_each_public_header_compiles_by_itself(compiler, standard, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    for header in sorted((CSRC / "include" / "enfilade").glob("*.h")):
        source = tmp_path / ("only.cpp" if "++" in standard else "only.c")
        source.write_text(f'#include "enfilade/{header.name}"\nint main(void) {{ return 0; }}\n')
        flags = [f"-std={standard}", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{CSRC / 'include'}"]
        done = subprocess.run([compiler, *flags, str(source)], capture_output=True, text=True)
        assert done.returncode == 0, f"{header.name}: {done.stderr}"


def test_the_shim_imports_numpy_and_the_standard_library_only():
    allowed = set(sys.stdlib_module_names) | {"numpy"}
    assert {str(p.name): imports(p) - allowed for p in modules(SHIM) if imports(p) - allowed} == {}


def test_the_shim_imports_without_blender_and_without_loading_the_library():
    code = "import sys, enfilade_native; assert 'bpy' not in sys.modules; assert enfilade_native._library._loaded is None"
    environment = {"PYTHONPATH": str(SHIM), "ENFILADE_LIBRARY": "nowhere", "PATH": "/usr/bin:/bin"}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


@pytest.mark.parametrize("part", ["rules", "report", "analysis.py", "native.py"])
def test_the_half_without_blender_stays_without_it(part):
    place = PLUGIN / "enfilade" / part
    found = [place] if place.suffix else modules(place)
    assert found
    for path in found:
        assert not imports(path) & {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "blf"}, path.name


def test_the_shim_does_not_import_the_plugin():
    for path in modules(SHIM):
        assert "enfilade" not in imports(path), path.name


def test_the_plugin_imports_itself_relatively():
    """From Blender 4.2 the package is named bl_ext.<repository>.enfilade: an absolute name would fail there."""
    wrong = [str(p.relative_to(ROOT)) for p in modules(PLUGIN / "enfilade") if "enfilade" in imports(p)]
    assert wrong == []


def version() -> str:
    return (ROOT / "VERSION").read_text().strip()


def test_changelog_begins_with_this_version():
    heads = re.findall(r"^## \[(\d+\.\d+\.\d+)\]", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert heads[:1] == [version()]


def test_bl_info_has_this_version():
    source = PLUGIN / "enfilade" / "__init__.py"
    match = re.search(r'"version"\s*:\s*\((\d+),\s*(\d+),\s*(\d+)\)', source.read_text() if source.exists() else "")
    if match is None:
        pytest.skip("plugin/enfilade/__init__.py has no bl_info version")
    assert ".".join(match.groups()) == version()


def test_extension_manifest_has_this_version():
    source = PLUGIN / "enfilade" / "blender_manifest.toml"
    if not source.exists():
        pytest.skip("no blender_manifest.toml")
    assert re.search(r'^version\s*=\s*"([^"]+)"', source.read_text(), re.M).group(1) == version()


def test_library_has_this_version():
    native = pytest.importorskip("enfilade_native")
    try:
        assert native.version() == version()
    except native.LibraryError as error:
        pytest.fail(f"build the library first (./build.sh build): {error}")
