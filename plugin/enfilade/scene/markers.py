# SPDX-License-Identifier: GPL-3.0-or-later
"""A marker at each problem: an empty in the collection `Enfilade Problems`, named after the problem, that tells what to do.

The message and the remedy are its custom properties, so that they can be read without the add-on.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import bpy

from ..rules.building import INFO, Problem
from . import collections

SHAPES = {"error": "CUBE", "warning": "SPHERE", "info": "PLAIN_AXES"}
SIZE = 0.25  # m
MOST_NAMED = 12  # names of more cover each other and the building


def draw(scene: bpy.types.Scene, problems: Sequence[Problem], infos: bool = False, muted: Collection[str] = ()) -> int:
    """Replaces the markers by those of these problems; returns how many. infos: notes too, not only what should be mended.
    muted: codes of problems that get none."""
    remove(scene)
    wanted = [(i, p) for i, p in enumerate(problems) if p.position is not None and (infos or p.severity != INFO) and p.code not in muted]
    if not wanted:
        return 0
    shelf = collections.ensure_child(scene, collections.PROBLEMS)
    for index, problem in wanted:
        marker = bpy.data.objects.new(f"{index + 1} {problem.code.removeprefix('core-')}"[:60], None)
        marker.empty_display_type = SHAPES.get(problem.severity, "PLAIN_AXES")
        marker.empty_display_size = SIZE
        marker.location = problem.position
        marker.show_name = len(wanted) <= MOST_NAMED
        marker.show_in_front = True
        marker["enfilade"] = "ignore"
        marker["enfilade_problem"] = index
        marker["message"] = problem.message
        marker["remedy"] = problem.remedy
        marker["objects"] = ", ".join(problem.names)
        shelf.objects.link(marker)
    return len(wanted)


def remove(scene: bpy.types.Scene) -> None:
    collections.remove_child(scene, collections.PROBLEMS)


def at(scene: bpy.types.Scene, index: int) -> bpy.types.Object | None:
    """The marker of a problem, None when there is none."""
    shelf = collections.child(scene, collections.PROBLEMS)
    return None if shelf is None else next((o for o in shelf.objects if o.get("enfilade_problem") == index), None)
