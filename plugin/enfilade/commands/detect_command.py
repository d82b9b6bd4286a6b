# SPDX-License-Identifier: GPL-3.0-or-later
"""`detect`: rooms, openings, cells and portals of the open file, their problems, and the scene for the core's own tool."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import bpy

from .. import native
from ..rules.assemble import assemble, cells_of
from ..scene import collections
from . import log
from .common import building_of, log_problems, problem_lines, save


def run(options: argparse.Namespace) -> dict:
    begin = time.perf_counter()
    building = building_of(options)
    detected = time.perf_counter() - begin
    made = assemble(native.load(), building)
    counts = made.scene.counts
    joined = [o for o in building.openings if o.rooms is not None]
    interior = {i for i, r in enumerate(building.rooms) if r.kind == "interior"}
    doors = [o for o in joined if o.kind == "door"]
    result = {
        "source": building.source,
        "rooms": counts.rooms,
        "cells": counts.cells,
        "portals": counts.portals,
        "seams": counts.seams,
        "openings": counts.openings,
        "openings_joined": len(joined),
        "doors": sum(1 for o in building.openings if o.kind == "door"),
        "doors_two_rooms": sum(1 for o in doors if set(o.rooms) <= interior and o.rooms[0] != o.rooms[1]),
        "objects": len({o.source_id for o in building.objects}),
        "lights": len(building.lights),
        "cameras": [c.name for c in building.cameras],
        "storeys": [name for name, _ in building.storeys],
        "detect_s": round(detected, 3),
        "assemble_s": round(made.seconds, 3),
        "problems": problem_lines(made.problems),
    }
    log_problems(made.problems)
    log(
        f"{result['rooms']} rooms, {result['cells']} cells, {result['portals']} portals, {result['openings']} openings "
        f"({len(joined)} joined), {result['objects']} objects in {detected + made.seconds:.2f} s"
    )
    if options.scene_json:
        target = Path(options.scene_json).absolute()
        target.parent.mkdir(parents=True, exist_ok=True)
        made.scene.save(os.fspath(target))
        result["scene_json"] = str(target)
    if options.draw_cells:
        collections.draw_cells(
            bpy.context.scene, cells_of(made), [r.name for r in building.rooms], [o.state for o in building.openings]
        )
    if options.save:
        result["saved"] = save(options.save)
    made.scene.close()
    return result
