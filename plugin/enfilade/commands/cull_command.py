# SPDX-License-Identifier: GPL-3.0-or-later
"""`cull`: hides what one camera, all cameras together, or each frame of a range doesn't need."""

from __future__ import annotations

import argparse
import time

import bpy

from .. import native
from ..analysis import Analyser
from ..rules.results import View
from ..scene import apply_result, cull, frame_table, sweep
from ..scene.shots import shot_of
from . import UsageError, log, progress
from .common import building_of, followed, log_problems, save, wanted_cameras


def run(options: argparse.Namespace) -> dict:
    if options.keyframes and not options.frames:
        raise UsageError("--keyframes needs --frames A-B")
    scene = bpy.context.scene
    put_back(scene)
    building = building_of(options)
    cameras = wanted_cameras(options)
    mode = cull.mode_for(options.mode, options.keep)
    begin = time.perf_counter()
    if options.frames:
        shots = sweep.walk(scene, building, followed(options, cameras), *options.frames, progress)
    else:
        shots = {scene.frame_current: [shot_of(scene, c) for c in cameras]}
    walked = time.perf_counter() - begin
    analyser = Analyser(native.load(), building, options.occluders, options.distance)
    sky = cull.has_sky(scene)
    stay: dict[int, set[str]] = {}
    views: list[View] = []
    begin = time.perf_counter()
    for n, (frame, group) in enumerate(sorted(shots.items())):
        progress(n / len(shots), "looking")
        result = cull.cull(analyser, group, options.method, options.keep, sky, why=False)
        stay[frame] = result.names
        views += result.views
    looked = time.perf_counter() - begin
    out = {
        "method": views[0].method,
        "keep": options.keep,
        "mode": mode,
        "objects": len(cull.candidates(building)),
        "cameras": [c.name for c in cameras],
        "walk_s": round(walked, 4),
        "look_s": round(looked, 4),
        "statistics": analyser.statistics,
    }
    if options.frames:
        table = cull.table(building, stay, mode)
        counts = [len(names & cull.candidates(building)) for names in stay.values()]
        out["frames"] = {"first": options.frames[0], "last": options.frames[1], "kept_least": min(counts),
                         "kept_most": max(counts), "kept_mean": round(sum(counts) / len(counts), 2)}
        out["frames"]["table"] = by_frame(stay, views)
        out["microseconds_mean"] = round(sum(v.microseconds for v in views) / len(views), 2)
        if options.keyframes:
            out["keys"] = cull.keyframe(scene, table)
        else:
            frame_table.store(scene, table)
            frame_table.apply_frame(scene, scene.frame_current)
        out["hidden_now"] = len(apply_result.hidden_objects(mode))
    else:
        result = cull.Culled(views, analyser.keep(views, options.keep, sky), stay[scene.frame_current])
        begin = time.perf_counter()
        note = {"cameras": out["cameras"], "keep": options.keep, "method": options.method}
        # the lists are for who opens the file: without one they would only cost time
        applied = cull.write(scene, building, result, mode, note, lists=bool(options.save))
        bpy.context.view_layer.update()
        out.update(
            kept=applied.kept,
            hidden=applied.hidden,
            already_hidden=applied.already,
            linked=applied.linked,
            seen=len(cull.names_of(building, result.views and _seen(result.views))),
            write_s=round(time.perf_counter() - begin, 4),
            views=[describe(building, v) for v in views],
            notes=result.notes,
        )
        for line in result.notes:
            log(line)
        log(f"{applied.kept} of {out['objects']} objects stay, {applied.hidden} hidden ({mode}, keep {options.keep})")
    log_problems(analyser.problems, 5)
    if options.save:
        out["saved"] = save(options.save)
    analyser.close()
    return out


def by_frame(stay: dict[int, set[str]], views: list[View]) -> list[dict]:
    """What each frame keeps, what entered and left since the one before, and what its looks took."""
    rows, before = [], None
    cost: dict[int, float] = {}
    for v in views:
        cost[v.frame] = cost.get(v.frame, 0.0) + v.microseconds
    for frame in sorted(stay):
        now = stay[frame]
        rows.append({"frame": frame, "kept": len(now), "entered": len(now - before) if before is not None else len(now),
                     "left": len(before - now) if before is not None else 0, "microseconds": round(cost.get(frame, 0.0), 2)})
        before = now
    return rows


def _seen(views: list[View]):
    return sorted({o for v in views for o in v.objects})


def put_back(scene: bpy.types.Scene) -> None:
    """The scene as its author left it: what was culled before must not shape what is found now."""
    cull.unkey(scene)
    apply_result.restore()
    frame_table.remove(scene)
    bpy.context.view_layer.update()


def describe(building, view: View) -> dict:
    return {
        "camera": view.camera.name,
        "frame": view.frame,
        "rooms": [building.rooms[r].name for r in view.rooms],
        "cells": len(view.cells),
        "objects": len({building.objects[o].source_id for o in view.objects}),
        "meshes": len({building.objects[o].mesh or o for o in view.objects}),  # what instances share is drawn once, many times
        "microseconds": round(view.microseconds, 2),
        "budget_hit": view.counters.get("budget_hit", 0),
    }
