# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds IfcOpenShell, which is optional at run time: everything else of Enfilade works without it.

Searched in order: what Python already sees (Bonsai brings its own), the folders of the environment variable
ENFILADE_PYTHON_LIBS, folders given by the add-on's preferences, `build/python` of a source tree.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from types import ModuleType

# Set by the add-on's preferences at registration; searched before the source tree.
extra_folders: list[str] = []


class IfcLibraryMissing(ImportError):
    """IfcOpenShell was not found; the message says where it was looked for and what to do."""


def folders() -> list[str]:
    """The folders that are searched, in order, existing or not."""
    found = [p for p in os.environ.get("ENFILADE_PYTHON_LIBS", "").split(os.pathsep) if p]
    found += [str(p) for p in extra_folders if p]
    for parent in Path(__file__).resolve().parents:
        if (parent / "csrc").is_dir():  # a source tree, not an installed add-on
            found.append(str(parent / "build" / "python"))
            break
    return found


def load() -> ModuleType:
    """`ifcopenshell` with its geometry module loaded.

    Folders are appended to the end of sys.path, never put first: they may hold another numpy than the one Blender runs
    with, and two numpys in one process crash.
    """
    try:
        return _import()
    except ImportError as first:
        reason = str(first)
    for folder in folders():
        if os.path.isdir(os.path.join(folder, "ifcopenshell")):
            if folder not in sys.path:
                sys.path.append(folder)
            importlib.invalidate_caches()
            try:
                return _import()
            except ImportError as error:  # the wheel of another Python version, most often
                reason = f"{folder}: {error}"
    searched = ", ".join(folders()) or "no folder"
    raise IfcLibraryMissing(
        "IfcOpenShell was not found, so IFC files can't be read. Run './build.sh deps', or install it with "
        "'python3 -m pip install --target FOLDER ifcopenshell' and name FOLDER in the add-on's preferences or in "
        f"ENFILADE_PYTHON_LIBS (searched: {searched}; Python {sys.version.split()[0]}; {reason})"
    )


def available() -> bool:
    try:
        load()
    except IfcLibraryMissing:
        return False
    return True


def _import() -> ModuleType:
    library = importlib.import_module("ifcopenshell")
    importlib.import_module("ifcopenshell.geom")
    return library
