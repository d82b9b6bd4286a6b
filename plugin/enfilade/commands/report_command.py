# SPDX-License-Identifier: GPL-3.0-or-later
"""`report`: rooms, openings, what each camera sees and through which openings, who sees whom; pictures first."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import bpy

from .. import native, view_measures
from ..analysis import Analyser, AnalysisError
from ..rules.building import WARNING, Problem
from ..scene.cameras import scene_cameras
from ..scene.shots import shot_of
from . import BadInput, log, progress
from .common import building_of, wanted_cameras
from .cull_command import describe, put_back


def run(options: argparse.Namespace) -> dict:
    from ..report import write_report
    from ..report.images import ImageError

    scene = bpy.context.scene
    put_back(scene)
    building = building_of(options)
    chosen = wanted_cameras(options) if options.camera else scene_cameras(scene)
    analyser = Analyser(native.load(), building)
    frames = range(options.frames[0], options.frames[1] + 1) if options.frames else [None]
    views = []
    for frame in frames:
        for camera in chosen:
            views.append(analyser.look(shot_of(scene, camera, frame), options.method))
    matrix = None
    begin = time.perf_counter()
    if options.matrix != "none":
        try:
            matrix = analyser.room_matrix(options.matrix, options.time_limit, progress)
        except AnalysisError as error:
            log(f"no room matrix: {error}")
            analyser.problems.append(
                Problem(WARNING, "no-matrix", f"The room-to-room matrix could not be made: {error}")
            )
    seconds = time.perf_counter() - begin
    title = Path(bpy.data.filepath or options.ifc or scene.name).stem
    analysis = analyser.analysis(views, matrix, title)
    if options.view_measures != "none":
        try:
            analysis.measures = view_measures.survey(native.load(), analyser, views, options.grid, progress)
        except native.load().EnfError as error:
            log(f"no view measures: {error}")
    target = Path(options.out).absolute()
    try:
        target.mkdir(parents=True, exist_ok=True)
        write_report(analysis, os.fspath(target), progress)
    except (OSError, ImageError) as error:
        raise BadInput(f"{target} can't be written: {error}") from error
    written = sorted(p.name for p in target.iterdir() if p.is_file())
    log(f"report in {target}: {', '.join(written)}")
    out = {
        "out": str(target),
        "files": written,
        "rooms": len(building.rooms),
        "openings": len(building.openings),
        "views": [describe(building, v) for v in views],
        "matrix": None,
    }
    if matrix is not None:
        out["matrix"] = {
            "method": matrix.method,
            "visible_pairs": int(matrix.visible.sum()),
            "proven_pairs": int(matrix.proven.sum()),
            "sightlines": len(matrix.sightlines),
            "seconds": round(seconds, 3),
        }
    analyser.close()
    return out
