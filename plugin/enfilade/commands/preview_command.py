# SPDX-License-Identifier: GPL-3.0-or-later
"""`preview`: what each camera sees, by the core's rays: pictures, an EXR with every layer, a contact sheet. No renderer, GPU or display.

`--verify` renders depth and object index with Cycles, in a process of its own on a copy of the file, and compares.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

from .. import native
from ..rules.names import Names
from ..rules.whole_file import whole_file
from ..scene import cameras
from ..scene.detect import DetectError
from ..scene.preview import EYES, Preview, Previewer, too_large
from . import INTERNAL, BadInput, log, progress
from .common import building_of, wanted_cameras
from .cull_command import put_back


def run(options: argparse.Namespace) -> dict:
    from ..report import file_name, images, preview_files, preview_passes

    scene = bpy.context.scene
    put_back(scene)
    try:
        building = building_of(options)
    except DetectError as error:
        if options.source != "auto" or options.ifc or options.cells:
            raise
        log(f"no rooms are known ({error}): everything is loaded, and nothing is told about openings")
        building = None
    options.all_cameras = not options.camera
    wanted = wanted_cameras(options)
    width, height = options.resolution or (cameras.raster_of(scene).width, cameras.raster_of(scene).height)
    if options.bounces > 16:
        raise BadInput("--bounces 0 to 16 are possible")
    if reason := too_large(width, height):
        raise BadInput(reason)
    if options.resolution:
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    out = Path(options.out).absolute()
    out.mkdir(parents=True, exist_ok=True)
    core = native.load()
    previewer = Previewer(core, scene, building, cells_only=options.cells, lit=not options.no_lights, threads=options.threads,
                          keep_soup=options.verify, options={"max_bounces": options.bounces})
    room_names = Names(building).rooms() if building else []
    title = Path(bpy.data.filepath or options.ifc or scene.name).stem
    rows, pictures, compared = [], [], []
    used: set[str] = set()
    try:
        looks = [(obj, eye) for obj in wanted for eye in (EYES if previewer.eyes(obj) else ("",))]
        for k, (obj, eye) in enumerate(looks):
            made = previewer.render(obj, width, height, lambda f, k=k, obj=obj: progress((k + f) / len(looks), f"rendering {obj.name}"), eye)
            rooms = previewer.room_of(made.layers)
            stem = file_name(made.camera, used)
            about = {"Software": f"Enfilade {core.version()}", "enfilade:camera": made.camera, "enfilade:file": title,
                     "enfilade:frame": scene.frame_current}
            drawn = []
            for name in options.passes:
                picture, legend = preview_passes.draw(name, made.layers, rooms, room_names, made.names)
                images.write_png(out / f"{stem}_{name}.png", picture,
                                 {**about, "ImageDescription": f"{preview_passes.TITLES[name]}, {made.camera}"})
                drawn.append((preview_passes.TITLES[name], picture, legend))
            if not options.no_exr and images.oiio is not None:
                preview_files.write_exr(out / f"{stem}.exr", made.layers, made.names, rooms, room_names, about)
            rows.append((made.camera, _figures(made, width, height), drawn))
            pictures.append(_row(made, stem))
            for note in made.notes:
                log(f"  {note}")
            log(f"{made.camera}: {rows[-1][1]}")
            if options.verify:
                compared.append({"camera": made.camera, **_verify(previewer, obj, eye, made, width, height, options.threads)})
        images.write_png(out / "contact_sheet.png", preview_files.contact_sheet(title, rows),
                         {"Software": f"Enfilade {core.version()}"})
    finally:
        previewer.close()
    result = {
        "out": str(out),
        "files": sorted(p.name for p in out.iterdir() if p.is_file()),
        "resolution": [width, height],
        "lights": len(previewer.lights),
        "light_sets_s": round(previewer.seconds["light_sets"], 4),
        "pictures": pictures,
    }
    if options.verify:
        result["verify"] = compared
        with whole_file(out / "verify.json") as partial:
            partial.write_text(json.dumps(compared, indent=1), encoding="utf-8")
        if not all(c["equal"] for c in compared):
            log("NOT EQUAL to Cycles: see verify.json")
            result["exit_code"] = INTERNAL
    return result


def _figures(made: Preview, width: int, height: int) -> str:
    seconds = made.seconds
    parts = [f"{width} x {height}"]
    if made.names:
        parts.append(f"{made.counts['objects']:,} objects, {made.counts['triangles']:,} triangles loaded in {seconds['load']:.2f} s")
    parts.append(f"rendered in {seconds['render']:.2f} s")
    return " · ".join(parts)


def _row(made: Preview, stem: str) -> dict:
    return {"camera": made.camera, "file": f"{stem}.exr", **{f"{k}_s": round(v, 4) for k, v in made.seconds.items()}, **made.counts}


# Cycles takes its sample anywhere in a hundredth of a pixel (its narrowest filter): rays through the corners of that square.
BESIDE = [(dx, dy) for dx in (-0.005, 0.005) for dy in (-0.005, 0.005)]


def _verify(previewer: Previewer, obj: bpy.types.Object, eye: str, made: Preview, width: int, height: int, threads: int) -> dict:
    """Cycles' depth and index passes of the same camera, against the preview's."""
    from ..rules import compare_images, compare_preview
    from .render_command import render_in_child

    begin = time.perf_counter()
    numbers = {o.name_full: i % 32767 + 1 for i, o in enumerate(sorted(bpy.data.objects, key=lambda o: o.name_full))}
    table = np.array([numbers.get(n, 0) for n in made.names] + [0], dtype=np.int64)
    mine = table[np.minimum(made.layers.object.astype(np.int64), len(table) - 1)]
    with tempfile.TemporaryDirectory(prefix="enfilade-verify-") as folder:
        copy = os.path.join(folder, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=copy, copy=True, relative_remap=True, check_existing=False)
        exr = os.path.join(folder, "cycles.exr")
        figures = render_in_child(folder, copy, {
            "camera": obj.name_full, "frame": bpy.context.scene.frame_current, "samples": 1, "resolution": [width, height],
            "threads": threads, "seed": 0, "out": exr, "simplify": False, "pixel_centres": True, "view": eye, "mode": "", "candidates": [],
            "hidden": [],
        })
        layers = compare_images.of_view(compare_images.read_layers(exr), eye)
    beside = [d for d in (previewer.depth_beside(made, at) for at in BESIDE) if d is not None]
    camera = made.seen_from

    def arbiter(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        if camera.type != "PERSP" or not made.soup:
            return np.full(len(rows), np.nan)
        m = camera.matrix_world
        x = (2.0 * (columns + 0.5) / width - 1.0 + 2.0 * camera.shift_x) * np.tan(0.5 * camera.angle_x)
        y = (1.0 - 2.0 * (rows + 0.5) / height + 2.0 * camera.shift_y) * np.tan(0.5 * camera.angle_y)
        ways = x[:, None] * m[:3, 0] + y[:, None] * m[:3, 1] - m[:3, 2]
        return compare_preview.nearest_of_all(np.broadcast_to(m[:3, 3], ways.shape), ways, np.concatenate(made.soup))

    found = compare_preview.compare(
        made.layers.depth, mine, compare_images.channel(layers, "Depth.Z"), np.rint(compare_images.index_channel(layers)).astype(np.int64), beside,
        arbiter,
    )
    log(f"{made.camera} against Cycles: depth agrees on {found.depth_share_raw:.4%} of pixels ({found.depth_different} differ, of these "
        f"{found.depth_within_sample} by less than Cycles' own spread of a hundredth of a pixel and {found.depth_settled} by Cycles' "
        f"rounding: double precision finds ours), objects differ on {found.objects_different} pixels, {found.objects_off_edges} off edges")
    return {**found.as_dict(), "cycles_s": figures["render_s"], "verify_s": round(time.perf_counter() - begin, 2)}
