# SPDX-License-Identifier: GPL-3.0-or-later
"""Brings what older versions stored in a .blend up to date: one function a step, run on load."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from .props import VERSION


def _from_0(scene: bpy.types.Scene) -> None:
    """0: nothing of ours was stored before version 1, or the scene is new."""


STEPS: tuple[Callable[[bpy.types.Scene], None], ...] = (_from_0,)


def run() -> list[str]:
    """Migrates every scene. Returns what a person should know (a file from a newer version)."""
    notes = []
    for scene in bpy.data.scenes:
        settings = getattr(scene, "enfilade", None)
        if settings is None or scene.library is not None:
            continue
        if settings.version > VERSION:
            notes.append(f"{scene.name} was saved by a newer Enfilade: its settings may not all be understood.")
            continue
        for step in STEPS[settings.version :]:
            step(scene)
        if settings.version != VERSION:
            settings.version = VERSION
    return notes
