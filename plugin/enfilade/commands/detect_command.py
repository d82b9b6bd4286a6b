# SPDX-License-Identifier: GPL-3.0-or-later
"""`detect`: rooms, openings, cells and portals of the open file, their problems, and the scene for the core's own tool."""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import asdict
from pathlib import Path

import bpy

from .. import native
from ..rules.assemble import assemble, cells_of
from ..scene import collections, detect, exchange, markers, repair
from . import BadInput, log
from .common import building_of, log_problems, problem_lines, save


def run(options: argparse.Namespace) -> dict:
    mended = _mend(options)
    begin = time.perf_counter()
    if options.draw == "auto":
        options.draw = "all" if options.save else "nothing"
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
    change = detect.note_counts(bpy.context.scene, building, made.problems)
    result["before"] = asdict(change.before)
    log_problems(made.problems)
    log(change.sentence())
    log(
        f"{result['rooms']} rooms, {result['cells']} cells, {result['portals']} portals, {result['openings']} openings "
        f"({len(joined)} joined), {result['objects']} objects in {detected + made.seconds:.2f} s"
    )
    if options.scene_json:
        target = Path(options.scene_json).absolute()
        target.parent.mkdir(parents=True, exist_ok=True)
        made.scene.save(os.fspath(target))
        result["scene_json"] = str(target)
    if mended is not None:
        result["mending"] = mended
    if options.write_ifc or options.write_indoorgml:
        result |= _exchange(options, building)
    if options.markers:
        result["markers"] = markers.draw(bpy.context.scene, made.problems)
    if options.picture:
        result["pictures"] = _pictures(options.picture, building, cells_of(made), made.problems)
    if options.draw_cells:
        collections.draw_cells(
            bpy.context.scene, cells_of(made), building.rooms, [o.state for o in building.openings]
        )
    if options.save:
        result["saved"] = save(options.save)
    made.scene.close()
    return result


def _mend(options: argparse.Namespace) -> dict | None:
    """Checks and mends marked meshes before rooms are looked for; None when neither was asked for."""
    if not options.check and not options.mend:
        return None
    scene = bpy.context.scene
    before = len(repair.offers(scene, options.tolerance))
    done, refused = repair.apply_all(scene, set(options.mend), options.tolerance) if options.mend else ([], [])
    if done:
        bpy.context.view_layer.update()
    left = repair.offers(scene, options.tolerance)
    for verb, fixes in (("mended", done), ("to mend", left)):
        for fix in fixes:
            log(f"  {verb}: {fix.reason} {fix.remedy}")
    for name, reason in refused:
        log(f"  {name} was left alone: {reason}")
    log(f"to mend {len(left)} (was {before})" if options.mend else f"to mend {len(left)}")
    return {
        "before": before,
        "done": [{"object": f.name, "kind": f.kind, "reason": f.reason} for f in done],
        "refused": [{"object": name, "reason": reason} for name, reason in refused],
        "offered": [
            {"object": f.name, "kind": f.kind, "reason": f.reason, "remedy": f.remedy, "position": [round(x, 4) for x in f.position]}
            for f in left
        ],
    }


def _exchange(options: argparse.Namespace, building) -> dict:
    try:
        written = {}
        if options.write_ifc:
            written["ifc"] = exchange.write_ifc(bpy.context.scene, building, options.write_ifc, options.ifc)
            log(f"wrote {options.write_ifc}")
        if options.write_indoorgml:
            cells, transitions = exchange.write_indoorgml(building, options.write_indoorgml)
            written["indoorgml"] = {"cells": cells, "transitions": transitions}
            log(f"wrote {options.write_indoorgml}")
    except exchange.ExchangeError as error:
        raise BadInput(str(error)) from error
    return {"written": written}


def _pictures(folder: str, building, cells, problems) -> list[str]:
    from ..report import detection_picture

    return [os.fspath(p) for p in detection_picture.write(Path(folder).absolute(), building, cells, problems)]
