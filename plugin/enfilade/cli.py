# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender -b FILE -c enfilade COMMAND ...`, where Blender has commands (4.2 and newer): the same as plugin/batch.py."""

from __future__ import annotations

import bpy

from . import compat

_handle = None


def _execute(arguments: list[str]) -> int:
    from .commands import run_clean

    return run_clean(arguments)


def register() -> None:
    global _handle
    if compat.has_cli_commands():
        _handle = bpy.utils.register_cli_command("enfilade", _execute)


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.utils.unregister_cli_command(_handle)
        _handle = None
