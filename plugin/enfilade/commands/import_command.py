# SPDX-License-Identifier: GPL-3.0-or-later
"""`import`: cells and portals of another tool's file into the open file, as marked rooms and openings that `detect` finds."""

from __future__ import annotations

import argparse
import os

import bpy

from ..rules.building import INTERIOR
from ..scene import exchange
from . import BadInput, log
from .common import drop_startup_objects, log_problems, problem_lines, save


def run(options: argparse.Namespace) -> dict:
    try:
        building = exchange.read(os.path.abspath(options.file))
    except exchange.ExchangeError as error:
        raise BadInput(str(error)) from error
    scene = bpy.context.scene
    if not bpy.data.filepath:
        drop_startup_objects(scene)
    made = exchange.add_marked(scene, building, os.path.basename(options.file))
    joined = sum(o.rooms is not None for o in building.openings)
    log_problems(building.problems)
    log(f"{len(made)} marked objects")
    result = {
        "marked": len(made),
        "rooms": sum(r.kind == INTERIOR for r in building.rooms),
        "openings": len(building.openings),
        "openings_joined": joined,
        "problems": problem_lines(building.problems),
    }
    if options.save:
        result["saved"] = save(options.save)
    return result
