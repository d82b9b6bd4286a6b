# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds IfcOpenShell, which is optional at run time: everything else of Enfilade works without it.

Searched in order: what Python already sees (Bonsai brings its own), the folders of the environment variable
ENFILADE_PYTHON_LIBS, folders given by the add-on's preferences, the folder of the user's that `install_command` fills, `build/python` of a
source tree.
"""

from __future__ import annotations

import importlib
import importlib.machinery
import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

# Set by the add-on's preferences at registration; searched before the source tree.
extra_folders: list[str] = []
own_folder = ""  # of this user and this Python; needn't exist


class IfcLibraryMissing(ImportError):
    """IfcOpenShell was not found; the message says where it was looked for and what to do."""


def folders() -> list[str]:
    """The folders that are searched, in order, existing or not."""
    found = [p for p in os.environ.get("ENFILADE_PYTHON_LIBS", "").split(os.pathsep) if p]
    found += [str(p) for p in [*extra_folders, own_folder] if p]
    tree = _source_tree()
    return found if tree is None else [*found, str(tree / "build" / "python")]


def _source_tree() -> Path | None:
    """None: this is an installed add-on."""
    return next((parent for parent in Path(__file__).resolve().parents if (parent / "csrc").is_dir()), None)


def install_command() -> str:
    """What to paste into a terminal. Any Python with pip will do, for it is told which version to install for; Blender's own where it
    has pip, since not everyone has another."""
    own = Path(sys.executable or "")
    has_own = own.is_file() and Path(sys.prefix) in own.parents and Path(sys.prefix) != Path("/usr")
    python = f'"{own}"' if has_own else "py" if sys.platform == "win32" else "python3"
    pip = f'{python} -m pip install --target "{own_folder or "FOLDER"}" --only-binary=:all: --python-version {python_version()} ifcopenshell'
    return f"{python} -m ensurepip && {pip}" if has_own and importlib.util.find_spec("pip") is None else pip


def python_version() -> str:
    """Compiled modules are good for one of them."""
    return f"{sys.version_info[0]}.{sys.version_info[1]}"


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
    ways = ["install the add-on Bonsai, which brings it (Preferences, Get Extensions)"]
    if _source_tree() is not None:
        ways.append("run './build.sh deps' (for Debian's Blender)")
    ways.append(f"paste this into a terminal: {install_command()}")
    if not own_folder:
        ways[-1] += " and name FOLDER in ENFILADE_PYTHON_LIBS"
    raise IfcLibraryMissing(
        f"IFC files can't be read: IfcOpenShell wasn't found for this Python, {python_version()}. Either {', or '.join(ways)}; then try again "
        f"(searched: {searched}; {reason})"
    )


def seems_there() -> bool:
    """Without importing it: quick enough for a panel."""
    spec = importlib.util.find_spec("ifcopenshell")
    found = [os.path.dirname(spec.origin)] if spec is not None and spec.origin else []
    return any(_is_for_this_python(f) for f in [*found, *(os.path.join(f, "ifcopenshell") for f in folders())])


def _is_for_this_python(package: str) -> bool:
    """Whether the compiled part of a package lies there, and isn't another Python's."""
    return any(os.path.isfile(os.path.join(package, "_ifcopenshell_wrapper" + end)) for end in importlib.machinery.EXTENSION_SUFFIXES)


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
