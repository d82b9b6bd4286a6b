# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether what is drawn is still what the last Detect read. Rooms and openings found in an IFC file or in bare geometry are remembered
with the file; objects are read anew each time.

A number for each object stands in the scene: where it is, how large, of how many vertices and faces. Names don't count, nor what
is animated, nor what was added (it can only hide more).
"""

from __future__ import annotations

import zlib
from collections import Counter

import bpy
import numpy as np

from ..rules.building import WARNING, Building, Problem

KEY = "enfilade_scenery"  # on the scene: the numbers
CODE = "scene-changed"
GRID = 1e-4  # metres: less is no change
MOST_NAMES = 5


def note(scene: bpy.types.Scene, building: Building) -> None:
    numbers = list(_numbers(scene, building).values())
    if numbers:
        scene[KEY] = numbers
    else:
        forget(scene)


def forget(scene: bpy.types.Scene) -> None:
    if KEY in scene:
        del scene[KEY]


def problem(scene: bpy.types.Scene, building: Building) -> Problem | None:
    """What a user should know before he relies on rooms found earlier; None: all is as it was."""
    known = Counter(scene.get(KEY, ()))
    strange = []
    for name, number in _numbers(scene, building).items():
        if known[number] > 0:
            known[number] -= 1
        else:
            strange.append(name)
    count = sum(known.values())
    if not count:
        return None
    what = "1 object was" if count == 1 else f"{count} objects were"
    return Problem(
        WARNING, CODE, f"{what} moved, edited, hidden or deleted since the last Detect: rooms and openings are as they were found then",
        sorted(strange)[:MOST_NAMES], remedy="Detect again if that is part of the building.",
    )  # fmt: skip


def _numbers(scene: bpy.types.Scene, building: Building) -> dict[str, int]:
    """By object's full name."""
    out: dict[str, int] = {}
    for o in building.objects:  # several where an object draws others
        box = np.round(np.nan_to_num(o.bounds) / GRID).astype(np.int64)
        out[o.source_id] = out.get(o.source_id, 0) + zlib.crc32(box.tobytes())
    numbers = {}
    for obj in scene.objects:
        if obj.name_full in out and not _is_animated(obj):
            parts = (len(obj.data.vertices), len(obj.data.polygons)) if obj.type == "MESH" else ()
            numbers[obj.name_full] = zlib.crc32(repr((out[obj.name_full], parts, len(obj.modifiers))).encode()) & 0x7FFFFFFF
    return numbers


def _is_animated(obj: bpy.types.Object | None) -> bool:
    while obj is not None:
        if obj.animation_data is not None or len(obj.constraints):
            return True
        obj = obj.parent
    return False
