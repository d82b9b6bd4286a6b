# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds `enfilade_native`: inside the package (as installed) or in the source tree beside it. No bpy.

Nothing is loaded on import. `load()` gives the module or raises NativeMissing with a sentence a user can act on.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

_HERE = Path(__file__).resolve().parent
_module: ModuleType | None = None


class NativeMissing(RuntimeError):
    """The C core can't be used; the message says what to do."""


def load() -> ModuleType:
    """The shim with its library loaded and checked. Cheap after the first time."""
    global _module
    if _module is not None:
        return _module
    packaged = _HERE / "enfilade_native"
    source = _HERE.parent.parent / "python_shim"
    try:
        if packaged.is_dir():
            module = importlib.import_module(f"{__package__}.enfilade_native")
        elif (source / "enfilade_native").is_dir():
            if str(source) not in sys.path:
                sys.path.append(str(source))
            module = importlib.import_module("enfilade_native")
        else:
            raise NativeMissing(f"This copy of Enfilade is incomplete: {packaged} is missing. Install the add-on's zip again.")
        module.library()
    except Exception as error:
        if isinstance(error, NativeMissing):
            raise
        built = "Run ./build.sh build." if source.is_dir() else "Install the add-on's zip made for this system again."
        raise NativeMissing(f"Enfilade's core can't be loaded: {error}. {built}") from error
    _module = module
    return module


def status() -> tuple[bool, str]:
    """(usable, a line for the panel and the diagnostics)."""
    try:
        module = load()
    except NativeMissing as error:
        return False, str(error)
    return True, f"core {module.version()} from {module.library_path()}"


def forget() -> None:
    """Drops the module reference (on unregister). The library itself stays loaded until Blender ends."""
    global _module
    _module = None
