# SPDX-License-Identifier: GPL-3.0-or-later
"""`render`: each shot with only what it needs in the scene. `--verify` renders the whole scene beside it and compares.

Verification works on a copy of the file in a temporary folder and in processes of their own: the open file is never
written, and time and peak memory are those of a `blender -b` that renders this one picture.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy

from .. import native
from ..analysis import Analyser
from ..rules import compare_images
from ..rules.whole_file import whole_file
from ..scene import apply_result, cull, sweep
from ..scene.shots import shot_of
from . import INTERNAL, BadInput, log, progress
from .common import building_of, followed, wanted_cameras
from .cull_command import describe, put_back

VERIFY_SAMPLES = 16
VERIFY_RESOLUTION = (320, 180)


def run(options: argparse.Namespace) -> dict:
    scene = bpy.context.scene
    put_back(scene)
    building = building_of(options)
    cameras = wanted_cameras(options)
    mode = cull.mode_for(options.mode, options.keep)
    if mode == apply_result.VIEWPORT:
        raise BadInput("--mode viewport hides nothing in a render: use safe or render")
    out = Path(options.out).absolute()
    out.mkdir(parents=True, exist_ok=True)
    if options.frames:
        shots = sweep.walk(scene, building, followed(options, cameras), *options.frames, progress)
    else:
        shots = {scene.frame_current: [shot_of(scene, c) for c in cameras]}
    analyser = Analyser(native.load(), building, options.occluders, options.distance)
    sky = cull.has_sky(scene)
    jobs = []
    for frame, group in sorted(shots.items()):
        for shot in group:
            begin = time.perf_counter()
            found = cull.cull(analyser, [shot], options.method, options.keep, sky, why=False)
            jobs.append((frame, shot, found, time.perf_counter() - begin))
    result = {
        "method": jobs[0][2].views[0].method,
        "keep": options.keep,
        "mode": mode,
        "hides": "camera rays only: light, shadows and reflections stay" if mode == apply_result.SAFE
        else "whole objects: what isn't kept casts no light or shadow",
        "objects": len(cull.candidates(building)),
        "out": str(out),
    }
    analyser.close()
    if options.verify or options.compare_simplify:
        return {**result, **_verify(options, building, jobs, mode, out)}
    return {**result, "pictures": _render(options, scene, building, jobs, mode, out)}


def _stem(shot, frame: int, many: bool) -> str:
    name = "".join(c if c.isalnum() or c in "-_" else "_" for c in shot.name)
    return f"{name}_{frame:04d}" if many else name


def _render(options, scene, building, jobs, mode, out: Path) -> list[dict]:
    """In this process, with the scene's own settings, one picture a shot. The scene is as it was afterwards."""
    render = scene.render
    if options.samples and hasattr(scene, "cycles"):
        scene.cycles.samples = options.samples
    if options.resolution:
        render.resolution_x, render.resolution_y = options.resolution
        render.resolution_percentage = 100
    if options.threads:
        render.threads_mode, render.threads = "FIXED", options.threads
    many = bool(options.frames)
    if mode == apply_result.SAFE and render.engine != "CYCLES":
        log(f"{render.engine} knows no camera visibility: nothing would be hidden by --mode safe; using --mode render")
        mode = apply_result.RENDER
    pictures = []
    all_names = cull.candidates(building)
    for n, (frame, shot, found, seconds) in enumerate(jobs):
        progress(n / len(jobs), f"rendering {shot.name} {frame}")
        scene.frame_set(frame)
        scene.camera = scene.objects[shot.camera.name]
        applied = apply_result.apply(scene, found.names, all_names, mode)
        render.filepath = str(out / _stem(shot, frame, many))
        begin = time.perf_counter()
        try:
            _still(scene)
        except RuntimeError as error:
            if "cannot save" not in str(error):
                raise
            Path(render.filepath + render.file_extension).unlink(missing_ok=True)  # half a picture at the most
            raise BadInput(str(error).strip()) from error
        pictures.append(
            {
                "file": render.filepath + render.file_extension,
                "camera": shot.name,
                "frame": frame,
                "kept": applied.kept,
                "hidden": applied.hidden,
                "cull_s": round(seconds + applied.seconds, 4),
                "render_s": round(time.perf_counter() - begin, 3),
            }
        )
    apply_result.restore()
    return pictures


def _still(scene) -> None:
    """Renders and writes. A Blender built without the denoiser that the scene asks for renders without it."""
    try:
        done = bpy.ops.render.render(write_still=True)
    except RuntimeError as error:
        if "enois" not in str(error) or not getattr(getattr(scene, "cycles", None), "use_denoising", False):
            raise
        log(f"{str(error).strip()}: rendering without denoising")
        scene.cycles.use_denoising = False
        done = bpy.ops.render.render(write_still=True)
    if "CANCELLED" in done:  # Blender heard Ctrl-C
        raise KeyboardInterrupt


def _verify(options, building, jobs, mode, out: Path) -> dict:
    candidates = cull.candidates(building)
    many = bool(options.frames)
    shots = []
    with tempfile.TemporaryDirectory(prefix="enfilade-verify-") as folder:
        copy = os.path.join(folder, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=copy, copy=True, relative_remap=True, check_existing=False)
        for n, (frame, shot, found, seconds) in enumerate(jobs):
            progress(n / len(jobs), f"verifying {shot.name} {frame}")
            pair = _Pair(options, folder, copy, shot, frame, mode, sorted(candidates), found.names)
            row = {
                **describe(building, found.views[0]),
                "kept": len(found.names & candidates),
                "hidden": len(pair.hidden),
                "cull_s": round(seconds, 4),
                **pair.compare(out, _stem(shot, frame, many)),
            }
            shots.append(row)
            log(f"{shot.name} {frame}: {_told(row)}")
    equal = all(s["comparison"]["equal"] for s in shots)
    out_rows = {
        "equal": equal,
        "index_wrong": sum(s["comparison"]["index_wrong"] for s in shots),
        "depth_wrong": sum(s["comparison"]["depth_wrong"] for s in shots),
        "samples": options.samples or VERIFY_SAMPLES,
        "resolution": list(options.resolution or VERIFY_RESOLUTION),
        "shots": shots,
    }
    with whole_file(out / "verify.json") as partial:
        partial.write_text(json.dumps(out_rows, indent=1), encoding="utf-8")
    if not equal:
        log("NOT EQUAL: something visible was hidden. Please report this with the scene (detect --scene-json).")
        out_rows["exit_code"] = INTERNAL
    return out_rows


def _told(row: dict) -> str:
    compared = row["comparison"]
    return (
        f"index {compared['index_wrong']}, depth {compared['depth_wrong']} pixels wrong"
        + (f" ({compared['ties']} where faces coincide)" if compared["ties"] else "")
        + f"; picture rms {compared['beauty_rms']:.2e}, max {compared['beauty_max']:.2e}; "
        + ", ".join(f"{k} {v['render_s']:.2f} s {v['peak_bytes'] / 2**20:.0f} MiB" for k, v in row["renders"].items())
    )


class _Pair:
    """One shot, to be rendered whole and culled, each in a process of its own on a copy of the file."""

    def __init__(self, options, folder: str, copy: str, shot, frame: int, mode: str, candidates: list[str], kept: set[str]) -> None:
        self.hidden = sorted(set(candidates) - kept)
        self._simplify, self._mode = options.compare_simplify, mode
        self._folder, self._copy = folder, copy
        self._candidates = candidates
        self._views = _views(bpy.context.scene.render)
        self._job = {
            "camera": shot.camera.name,
            "frame": frame,
            "samples": options.samples or VERIFY_SAMPLES,
            "resolution": list(options.resolution or VERIFY_RESOLUTION),
            "threads": options.threads,
            "seed": 0,
        }

    def _render(self, exr: Path, mode: str = "", simplify: bool = False, pin_instances: bool = False) -> tuple[dict, dict]:
        """(what it measured, its layers). mode: of hiding, "" for the whole scene."""
        hiding = {"mode": mode, "candidates": self._candidates if mode else [], "hidden": self.hidden if mode else []}
        figures = render_in_child(self._folder, self._copy,
                                  {**self._job, **hiding, "out": str(exr), "simplify": simplify, "pin_instances": pin_instances})
        return figures, compare_images.beside(compare_images.read_layers(str(exr)), self._views)

    def compare(self, out: Path, stem: str) -> dict:
        """Renders and compares; pictures go to `out`."""
        measured, layers = {}, {}
        variants = [("whole", "", False), ("culled", self._mode, False), ("simplify", "", True)]
        for label, mode, simplify in variants if self._simplify else variants[:2]:
            measured[label], layers[label] = self._render(out / f"{stem}_{label}.exr", mode, simplify)
        whole, culled = layers["whole"], layers["culled"]
        present = _present(set(self.hidden))
        compared = compare_images.compare(whole, culled, present)
        rounding = None
        if compared.depth_different or compared.index_different:
            # Only rounding, or more? Again, with what rounds otherwise switched off (see render_child): now every bit counts.
            rounding = {key: getattr(compared, key) for key in ("index_different", "depth_different", "depth_worst")}
            again = []
            for mode in ("", self._mode):
                exr = Path(self._folder) / "exact.exr"
                again.append(self._render(exr, mode, pin_instances=True)[1])
            compared = compare_images.compare(*again, present)
        compare_images.write_png(str(out / f"{stem}_whole.png"), compare_images.beauty(whole))
        compare_images.write_png(str(out / f"{stem}_culled.png"), compare_images.beauty(culled))
        compare_images.write_png(str(out / f"{stem}_compared.png"), compare_images.side_by_side(whole, culled))
        row = {"comparison": compared.as_dict(), "instance_rounding": rounding, "renders": measured}
        if self._simplify:
            row["simplify_comparison"] = compare_images.compare(whole, layers["simplify"]).as_dict()
        return row


def _views(render) -> list[str]:
    """Names of the eyes that a render draws; [] for one alone."""
    if not render.use_multiview:
        return []
    return ["left", "right"] if render.views_format == "STEREO_3D" else [v.name for v in render.views if v.use]


def _present(hidden: set[str]) -> set[int]:
    """Index values (as render_child gives them) of objects drawn as themselves in both renders: neither hidden nor known
    through an instancer alone, and no number shared."""
    ordered = sorted(bpy.data.objects, key=lambda o: o.name_full)
    if len(ordered) > 32767:
        return set()
    mine = set(bpy.context.view_layer.objects)
    return {i + 1 for i, o in enumerate(ordered) if o.library is None and o in mine and o.name_full not in hidden}


def render_in_child(folder: str, blend: str, job: dict) -> dict:
    """One render in a process of its own (render_child.py says what a job holds); what it measured."""
    result = os.path.join(folder, "result.json")
    with contextlib.suppress(FileNotFoundError):
        os.remove(result)
    job = {**job, "blend": blend, "result": result}
    path = os.path.join(folder, "job.json")
    Path(path).write_text(json.dumps(job), encoding="utf-8")
    script = str(Path(__file__).with_name("render_child.py"))
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "--factory-startup", blend, "--python-exit-code", "3", "-P", script, "--", path]
    else:  # bpy as a Python module
        command = [sys.executable, script, "--", path]
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    output = process.communicate()[0]
    wall = time.perf_counter() - begin
    if process.returncode != 0 or not os.path.isfile(result):
        tail = output.decode("utf-8", "replace").strip().splitlines()[-15:]
        raise RuntimeError(f"a render process ended with code {process.returncode}:\n" + "\n".join(tail))
    measured = json.loads(Path(result).read_text(encoding="utf-8"))
    measured["wall_s"] = round(wall, 3)
    return measured
