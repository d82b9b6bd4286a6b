# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers in two steps: preferences and diagnostics always, everything else only when the core loads.

Errors propagate; a half-registered add-on is never left behind.
"""

from __future__ import annotations

from . import cli, handlers, native, prefs, props, session
from .ops import add_cameras, analyse, bake, cull, diagnose, exchange, export, mark, openings, repair, stop
from .ops import preview as preview_op
from .ops import report as report_op
from .scene import collections as _collections  # noqa: F401 - imported here so that a broken install shows at once
from .ui import overlay, panels

_ALWAYS = (prefs, diagnose)
_WITH_CORE = (props, analyse, add_cameras, cull, bake, preview_op, report_op, export, exchange, mark, openings, repair, stop, panels, handlers, overlay,
              cli)
_registered: list = []


def register() -> None:
    try:
        for module in _ALWAYS:
            module.register()
            _registered.append(module)
        usable, line = native.status()
        if not usable:
            print(f"Enfilade: {line}")
            panels.register_missing()
            return
        for module in _WITH_CORE:
            module.register()
            _registered.append(module)
    except Exception:
        unregister()
        raise


def unregister() -> None:
    session.drop()
    panels.unregister_missing()
    while _registered:
        _registered.pop().unregister()
    native.forget()
