# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: a full disk, a crash or an interruption leaves what was there before. No bpy."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Where to write, beside `path` and with its ending (writers go by it); it takes the place of `path` when all went well."""
    target = Path(path)
    partial = target.with_name(f"{target.stem}.part{target.suffix}")
    try:
        yield partial
        os.replace(partial, target)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise
