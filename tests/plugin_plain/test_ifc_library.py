# SPDX-License-Identifier: GPL-3.0-or-later
"""What somebody without IfcOpenShell is told: ways that are open to them, and a command that fits their Python."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest
from enfilade.rules import ifc_library

VERSION = f"{sys.version_info[0]}.{sys.version_info[1]}"


@pytest.fixture
def missing(monkeypatch, tmp_path):
    def fails():
        raise ImportError("No module named 'ifcopenshell'")

    monkeypatch.setattr(ifc_library, "_import", fails)
    monkeypatch.setattr(ifc_library, "own_folder", str(tmp_path / "my libs"))
    monkeypatch.setenv("ENFILADE_PYTHON_LIBS", "")
    return tmp_path


def told() -> str:
    with pytest.raises(ifc_library.IfcLibraryMissing) as error:
        ifc_library.load()
    return str(error.value)


def test_an_installed_add_on_names_no_file_of_the_source_tree(missing, monkeypatch):
    monkeypatch.setattr(ifc_library, "_source_tree", lambda: None)
    text = told()
    assert "Bonsai" in text and ifc_library.install_command() in text and "build.sh" not in text and str(missing / "my libs") in text


def test_a_source_tree_names_its_own_way_too(missing):
    assert "./build.sh deps" in told()


def test_the_command_can_be_pasted(missing):
    words = shlex.split(ifc_library.install_command())
    assert words[1:4] == ["-m", "pip", "install"] and words[-1] == "ifcopenshell"
    assert words[words.index("--target") + 1] == str(missing / "my libs")
    assert words[words.index("--python-version") + 1] == VERSION


@pytest.mark.parametrize("has_pip", [True, False])
def test_a_blender_with_its_own_python_is_told_to_use_that(missing, monkeypatch, has_pip):
    own = missing / "Blender 5" / "python" / "bin" / "python3"
    own.parent.mkdir(parents=True)
    own.touch()
    monkeypatch.setattr(sys, "executable", str(own))
    monkeypatch.setattr(sys, "prefix", str(own.parent.parent))
    monkeypatch.setattr(ifc_library.importlib.util, "find_spec", lambda name: object() if has_pip else None)
    first, _, rest = ifc_library.install_command().partition(" && ")
    assert shlex.split(first)[0] == str(own)
    assert (rest == "") == has_pip
    if not has_pip:
        assert shlex.split(first)[1:] == ["-m", "ensurepip"] and shlex.split(rest)[0] == str(own)


def test_what_the_command_fills_is_found_without_a_preference(missing, monkeypatch):
    folder = Path(ifc_library.own_folder)
    (folder / "ifcopenshell").mkdir(parents=True)
    tried = []

    def once():
        tried.append(list(sys.path))
        if str(folder) not in sys.path:
            raise ImportError("not yet")
        return sys

    monkeypatch.setattr(ifc_library, "_import", once)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert ifc_library.load() is sys and len(tried) == 2


def test_another_pythons_library_is_none(missing, monkeypatch):
    monkeypatch.setattr(ifc_library, "_source_tree", lambda: None)
    monkeypatch.setattr(ifc_library.importlib.util, "find_spec", lambda name: None)
    package = Path(ifc_library.own_folder) / "ifcopenshell"
    package.mkdir(parents=True)
    (package / "_ifcopenshell_wrapper.cpython-31-nowhere.so").touch()
    assert not ifc_library.seems_there()
    (package / f"_ifcopenshell_wrapper{ifc_library.importlib.machinery.EXTENSION_SUFFIXES[0]}").touch()
    assert ifc_library.seems_there()
