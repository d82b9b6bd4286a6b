# SPDX-License-Identifier: GPL-3.0-or-later
"""`report`: rooms, openings, what each camera sees and through which openings, who sees whom; pictures first."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import bpy

from .. import native, reporting
from ..scene.cameras import scene_cameras
from ..scene.detect import counts_of
from ..scene.shots import shot_of
from . import BadInput, log, progress
from .common import building_of, wanted_cameras
from .cull_command import describe, put_back


def run(options: argparse.Namespace) -> dict:
    scene = bpy.context.scene
    put_back(scene)
    building = building_of(options)
    chosen = wanted_cameras(options) if options.camera else scene_cameras(scene)
    frames = range(options.frames[0], options.frames[1] + 1) if options.frames else [None]
    shots = [shot_of(scene, camera, frame) for frame in frames for camera in chosen]
    wanted = reporting.Wanted(
        title=Path(bpy.data.filepath or options.ifc or scene.name).stem,
        detected=counts_of(scene).sentence(),
        method=options.method,
        matrix=options.matrix,
        time_limit=options.time_limit,
        measures=options.view_measures != "none",
        grid=options.grid,
        occluders=options.occluders,
        distance=options.distance,
    )
    target = Path(options.out).absolute()
    try:
        made = reporting.make(native.load(), building, shots, os.fspath(target), wanted, progress)
    except OSError as error:
        raise BadInput(f"{target} can't be written: {error}") from error
    for note in made.notes:
        log(note)
    written = sorted(p.name for p in made.paths)
    log(f"{target / 'report.html'}, and {len(written) - 1} files beside it")
    out = {
        "out": str(target),
        "files": written,
        "rooms": len(building.rooms),
        "openings": len(building.openings),
        "views": [describe(building, v) for v in made.views],
        "matrix": None,
    }
    if made.matrix is not None:
        out["matrix"] = {
            "method": made.matrix.method,
            "visible_pairs": int(made.matrix.visible.sum()),
            "proven_pairs": int(made.matrix.proven.sum()),
            "sightlines": len(made.matrix.sightlines),
            "seconds": round(made.matrix_seconds, 3),
        }
    return out
