# SPDX-License-Identifier: GPL-3.0-or-later
"""What several commands share: the building of the open file, which views are wanted, saving."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import bpy

from ..rules import ifc, opening_rules
from ..rules.building import Building
from ..scene import cameras, detect, import_ifc
from . import BadInput, UsageError, log, progress


def building_of(options: argparse.Namespace) -> Building:
    """Detects when a source is named or nothing was detected before; adds cameras when asked and there is none."""
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    if options.ifc and not bpy.data.filepath:
        drop_startup_objects(scene)
    if options.state:
        try:
            rules = detect.rules_of(scene) | opening_rules.parse(options.state)
        except ValueError as error:
            raise UsageError(f"--state: {error}") from error
        detect.set_rules(scene, rules)
    if options.command == "detect" or options.ifc or options.source != "auto":
        draw = getattr(options, "draw", "all")
        building = detect.detect(
            scene, view_layer, options.source, options.ifc, progress, options.geometry,
            draw=draw, bounds=draw == "nothing" and bool(options.scene_json),
        )  # fmt: skip
    else:
        _complete(scene)
        building = detect.current(scene, view_layer)
    if options.add_cameras:
        cameras.add_suggested(scene, building, options.add_cameras)
    return building


def _complete(scene: bpy.types.Scene) -> None:
    """Furniture that detect left in the IFC file comes in as soon as a picture needs it."""
    try:
        made = import_ifc.complete(scene, progress)
    except (ifc.IfcError, ImportError) as error:
        raise BadInput(f"furniture was left in the IFC file, and can't be read now: {error}") from error
    if made:
        log(f"{len(made)} objects that were left in the IFC file were brought in")


def drop_startup_objects(scene: bpy.types.Scene) -> None:
    """Without a file Blender opens its cube: that is nobody's building."""
    found = {o.name: o for o in scene.objects}
    if set(found) == {"Camera", "Cube", "Light"}:
        log("no file is open: Blender's own cube, camera and light are removed before the building comes in")
        for obj in found.values():
            bpy.data.objects.remove(obj)


def wanted_cameras(options: argparse.Namespace) -> list[bpy.types.Object]:
    """The cameras the command is about; BadInput names those that exist when one isn't there."""
    scene = bpy.context.scene
    found = cameras.scene_cameras(scene)
    if not found:
        raise BadInput("the scene has no camera (detect --add-cameras N puts some into the largest rooms)")
    if options.all_cameras:
        return found
    if options.camera:
        match = [o for o in found if o.name == options.camera or o.name_full == options.camera]
        if not match:
            raise BadInput(f"no camera '{options.camera}'; there are: {', '.join(o.name for o in found)}")
        return match[:1]
    if scene.camera is not None and scene.camera.type == "CAMERA":
        return [scene.camera]
    return found[:1]


def followed(options: argparse.Namespace, cameras: list[bpy.types.Object]) -> list[bpy.types.Object] | None:
    """For a frame range: the cameras named, or None to follow whichever is active at each frame (markers may switch it)."""
    named = options.camera or options.all_cameras
    switched = any(m.camera is not None for m in bpy.context.scene.timeline_markers)
    return cameras if named or not switched else None


def save(path: str) -> str:
    """Writes the open file to `path` (a copy: the open file keeps its name). Paths inside stay right."""
    target = Path(path).absolute()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(target), copy=True, relative_remap=True, check_existing=False)
    except (OSError, RuntimeError) as error:
        raise BadInput(f"{target} can't be written: {error}") from error
    if not os.path.isfile(target):
        raise BadInput(f"{target} was not written")
    log(f"wrote {target}")
    return str(target)


def problem_lines(problems) -> list[dict]:
    return [
        {"severity": p.severity, "code": p.code, "message": p.message, "names": list(p.names)[:5], "remedy": p.remedy,
         "position": None if p.position is None else [round(float(x), 3) for x in p.position]}
        for p in problems
    ]


def log_problems(problems, most: int = 20) -> None:
    order = {"error": 0, "warning": 1, "info": 2}
    for p in sorted(problems, key=lambda p: order.get(p.severity, 3))[:most]:
        log(f"  {p.severity}: {p.message}" + (f" -> {p.remedy}" if p.remedy else ""))
    if len(problems) > most:
        log(f"  ... and {len(problems) - most} more")
