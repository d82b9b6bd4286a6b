# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the C library, loads it once, checks that it fits this package, and binds the table of signatures."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from pathlib import Path

from . import _signatures as signatures
from ._structs import STRUCTS
from .errors import LibraryError, error_for

_HERE = Path(__file__).resolve().parent
_lock = threading.Lock()
_loaded: ctypes.CDLL | None = None
_path: Path | None = None


def default_library_names() -> tuple[str, ...]:
    """File names of the library on this platform, the likeliest first."""
    if sys.platform == "win32":
        return ("libenfilade.dll", "enfilade.dll")
    if sys.platform == "darwin":
        return ("libenfilade.dylib",)
    return ("libenfilade.so",)


def _candidates() -> list[Path]:
    # A path the user names is the only one tried: a typo must not fall back to another library in silence.
    named = os.environ.get("ENFILADE_LIBRARY")
    if named:
        return [Path(named)]
    folders = [_HERE / "lib", _HERE]  # as packaged
    if (_HERE.parent.parent / "csrc").is_dir():  # the source tree
        folders.append(_HERE.parent.parent / "build" / "lib")
    return [folder / name for folder in folders for name in default_library_names()]


def _check_status(status: int, function: object, arguments: object) -> None:
    if status != 0:
        # enf_last_error is this thread's own, and errcheck runs in the thread that called: no race.
        sentence = _loaded.enf_last_error().decode("utf-8", "replace") if _loaded else ""
        raise error_for(status, sentence or f"{getattr(function, '__name__', 'call')} failed with status {status}")


def _bind(library: ctypes.CDLL, path: Path) -> None:
    missing = [name for name, _, _ in signatures.FUNCTIONS if not hasattr(library, name)]
    if missing:
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        raise LibraryError(
            f"{path} and this enfilade_native do not match: the library lacks {', '.join(missing[:5])}{more}"
        )
    for name, result, arguments in signatures.FUNCTIONS:
        function = getattr(library, name)
        function.argtypes = [ctypes.c_int32 if a is signatures.Status else a for a in arguments]
        if result is signatures.Status:
            function.restype = ctypes.c_int32
            function.errcheck = _check_status
        else:
            function.restype = result


def _handshake(library: ctypes.CDLL, path: Path) -> None:
    """Same ABI number and same struct sizes on both sides, or LibraryError naming both."""
    if not hasattr(library, "enf_abi_version"):
        raise LibraryError(f"{path} is not an Enfilade library: it has no enf_abi_version")
    library.enf_abi_version.restype = ctypes.c_uint32
    found = library.enf_abi_version()
    if found != signatures.ABI_VERSION:
        raise LibraryError(
            f"{path} has ABI {found}, this enfilade_native ({_HERE}) needs {signatures.ABI_VERSION}: "
            "install both from one release"
        )
    _bind(library, path)
    for struct in STRUCTS:
        theirs, ours = library.enf_struct_size(struct.__name__.encode()), ctypes.sizeof(struct)
        if theirs != ours:
            raise LibraryError(
                f"{path}: {struct.__name__} has {theirs} bytes there and {ours} in this enfilade_native ({_HERE}): "
                "install both from one release"
            )


def library() -> ctypes.CDLL:
    """The loaded library. Loads it at the first call; LibraryError says what was tried and what to do. Thread-safe."""
    global _loaded, _path
    if _loaded is not None:
        return _loaded
    with _lock:
        if _loaded is not None:
            return _loaded
        tried: list[str] = []
        for path in _candidates():
            if not path.is_file():
                tried.append(f"{path}: not there")
                continue
            try:
                found = ctypes.CDLL(str(path))
            except OSError as error:
                tried.append(f"{path}: {error}")
                continue
            _handshake(found, path)
            _loaded, _path = found, path
            return found
    raise LibraryError(
        "Enfilade's C library could not be loaded. Build it (./build.sh build) or install the add-on's zip for this "
        "platform; ENFILADE_LIBRARY may name the file. Tried: " + "; ".join(tried)
    )


def library_path() -> Path:
    """Where the loaded library lies."""
    library()
    assert _path is not None
    return _path


def version() -> str:
    """The library's version, MAJOR.MINOR.PATCH."""
    return library().enf_version().decode()
