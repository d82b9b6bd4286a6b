# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of the batch commands, checked before any work begins."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable

from ..report.preview_passes import TITLES
from ..rules.repair import KINDS
from . import UsageError

Options = Callable[[argparse.ArgumentParser], None]  # adds some


class _Parser(argparse.ArgumentParser):
    def error(self, message: str):
        raise UsageError(f"{self.format_usage()}{self.prog}: {message}")


def parser() -> argparse.ArgumentParser:
    top = _Parser(
        prog="enfilade",
        description="What can be seen through the doors and windows of a building.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    commands = top.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)
    commands.required = True

    def add(name: str, text: str, options: Options, *shared: Options) -> None:
        command = commands.add_parser(name, help=text, description=text, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
        for part in (*shared, options):
            part(command)

    add("detect", "find rooms, doors and windows", _detect_options, _source_options)
    add("import", "bring cells and portals of a scene file or IndoorGML in as marked rooms and openings", _import_options)
    add("cull", "hide what the camera doesn't need", _cull_options, _source_options, _view_options)
    add("restore", "show again whatever was hidden, exactly as it was", _restore_options)
    add("render", "render what the camera needs", _render_options, _source_options, _view_options)
    add("preview", "pictures by rays through the rooms, without a renderer: shaded, rooms, objects, depth, openings, lights", _preview_options, _source_options)
    add("report", "who sees what, through which openings: HTML, JSON, CSV, pictures", _report_options, _source_options, _view_options)
    return top


def _source_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--source", choices=("auto", "ifc", "annotated", "geometry"), default="auto",
                         help="where rooms come from")
    command.add_argument("--ifc", metavar="FILE.ifc", help="the IFC model; its geometry is imported if the scene has none")
    command.add_argument("--geometry", choices=("auto", "classes", "triangles"), default="auto",
                         help="what --source geometry goes by: classes of walls, doors, windows (IFC or names), or triangles alone")
    command.add_argument("--state", action="append", default=[], metavar="KEY=STATE",
                         help="open, closed or glass for an opening (name or GlobalId), storey:NAME, class:door|window|hole, or "
                         "doors (those without a say of their own); repeatable, kept in the scene")
    command.add_argument("--add-cameras", type=count, default=0, metavar="N",
                         help="put N cameras into the largest rooms")


def _view_options(command: argparse.ArgumentParser) -> None:
    which = command.add_mutually_exclusive_group()
    which.add_argument("--camera", metavar="NAME", help="this camera [default: the scene's active one]")
    which.add_argument("--all-cameras", action="store_true", help="every camera of the scene; cull keeps the union")
    command.add_argument("--frames", type=frames, metavar="A-B", help="a frame range (or one frame); makes a table by frame")
    command.add_argument("--method", choices=("portal", "box", "clip", "frustum", "pluecker"), default="portal",
                         help="portal = clip; pluecker = seen from anywhere in the camera's cell")
    command.add_argument("--keep", type=keep, default="camera", metavar="camera|shadow|bounces=N",
                         help="camera: what is seen; shadow: also what may stand between it and lights; "
                         "bounces=N: also what N bounces of light may meet")
    command.add_argument("--mode", choices=("auto", "safe", "render", "viewport"), default="auto",
                         help="safe: hidden from camera rays only (Cycles; light stays); render: not rendered at all (saves "
                         "time and memory); viewport: hidden in the 3D view; auto: safe for --keep camera, else render")
    command.add_argument("--occluders", choices=("off", "on", "auto"), default="off",
                         help='whether objects with the custom property "enfilade_occluder" hide what stands behind them')
    command.add_argument("--distance", type=metres, default=math.inf, metavar="M",
                         help="nothing farther than this from the eye is kept, seen or not: for fog [metres, default: no limit]")


def _detect_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--save", type=blend, metavar="FILE.blend", help="write the scene with what was found")
    command.add_argument("--draw", choices=("auto", "all", "built", "nothing"), default="auto",
                         help="what of the IFC model is brought in: all; built, which is all but furniture (that comes when cull, "
                         "render, preview or report need it); nothing; auto: all with --save, else nothing")
    command.add_argument("--scene-json", metavar="FILE", help="write the scene for the command line tool (*.enf.json)")
    command.add_argument("--write-ifc", metavar="OUT.ifc",
                         help="a copy of the IFC model with the rooms and 2nd-level space boundaries that it lacks")
    command.add_argument("--write-indoorgml", metavar="OUT.gml", help="cells and transitions as IndoorGML")
    command.add_argument("--check", action="store_true", help="list what can be mended in the meshes of marked rooms and openings")
    command.add_argument("--mend", type=mendings, default=[], metavar="A,B,...",
                         help="mend marked meshes first: all, or of snap, fill, flip, planarize, split")
    command.add_argument("--tolerance", type=spacing, default=0.005, metavar="M", help="metres that mending may move a corner")
    command.add_argument("--markers", action="store_true", help="add an empty at each problem, named after it")
    command.add_argument("--picture", type=folder, metavar="DIR", help="draw rooms, cells, portals and problems as PNG, a plan a storey")
    command.add_argument("--draw-cells", action="store_true", help="add cells and portals as objects to look at")


def _import_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", metavar="FILE", help="*.enf.json or IndoorGML")
    command.add_argument("--save", type=blend, metavar="FILE.blend", help="write the scene with them")


def _cull_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--save", type=blend, metavar="FILE.blend", help="write the culled scene; without it only the figures are given")
    command.add_argument("--keyframes", action="store_true",
                         help="with --frames: keyframe the flags, so that the file renders without this add-on")


def _restore_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--save", type=blend, metavar="FILE.blend", help="where to write [default: the file itself]")


def _render_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", required=True, type=folder, metavar="DIR", help="folder for the pictures")
    command.add_argument("--verify", action="store_true",
                         help="render unculled too and compare: index and depth must agree pixel for pixel")
    command.add_argument("--compare-simplify", action="store_true", help="render with Cycles' own camera culling as well")
    command.add_argument("--samples", type=count, metavar="N", help="Cycles samples [default: the scene's; verify: 16]")
    command.add_argument("--resolution", type=resolution, metavar="WxH", help="[default: the scene's; verify: 320x180]")
    command.add_argument("--threads", type=count, default=0, metavar="N", help="render threads, 0: all")


def _preview_options(command: argparse.ArgumentParser) -> None:
    which = command.add_mutually_exclusive_group()
    which.add_argument("--camera", metavar="NAME", help="this camera [default: every camera of the scene]")
    which.add_argument("--all-cameras", action="store_true", help="every camera of the scene (the default)")
    command.add_argument("--out", required=True, type=folder, metavar="DIR", help="folder for the pictures")
    command.add_argument("--passes", type=passes, default=list(TITLES), metavar="A,B,...",
                         help=f"which of {', '.join(TITLES)}")
    command.add_argument("--resolution", type=resolution, metavar="WxH", help="[default: the scene's]")
    command.add_argument("--cells", action="store_true", help="draw the rooms' cells alone: no mesh of the scene is read")
    command.add_argument("--no-lights", action="store_true", help="soft light from all around, no lamps")
    command.add_argument("--bounces", type=count, default=4, metavar="N", help="at mirrors and glass, 0 to 16")
    command.add_argument("--no-exr", action="store_true", help="PNG only")
    command.add_argument("--threads", type=count, default=0, metavar="N", help="0: all")
    command.add_argument("--verify", action="store_true", help="render depth and object index with Cycles and compare")


def _report_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", required=True, type=folder, metavar="DIR", help="folder for the report")
    command.add_argument("--matrix", choices=("none", "sample", "flow", "exact"), default="exact",
                         help="how the room-to-room matrix is made")
    command.add_argument("--time-limit", type=seconds, default=0.0, metavar="S",
                         help="seconds for the matrix, 0: none; what isn't decided by then counts as seen")
    command.add_argument("--view-measures", choices=("all", "none"), default="all", help="isovist and view measures on a grid, by room, by camera")
    command.add_argument("--grid", type=spacing, default=0.0, metavar="M",
                         help="metres between the places they are measured at [default: 0.25 to 2, by the building's size]")


def mendings(text: str) -> list[str]:
    chosen = [part.strip() for part in text.split(",") if part.strip()]
    chosen = list(KINDS) if chosen == ["all"] else chosen
    unknown = [c for c in chosen if c not in KINDS]
    if unknown or not chosen:
        raise argparse.ArgumentTypeError(f"'{text}': wanted all, or some of {', '.join(KINDS)}")
    return chosen


def count(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return value


def frames(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?", text.strip())
    if not match:
        raise argparse.ArgumentTypeError(f"'{text}' is no frame range (wanted A-B)")
    first = int(match.group(1))
    last = int(match.group(2)) if match.group(2) is not None else first
    if last < first:
        raise argparse.ArgumentTypeError(f"'{text}' runs backwards")
    return first, last


def keep(text: str) -> str:
    if text in ("camera", "shadow"):
        return text
    if text.startswith("bounces=") and text[8:].isdigit():
        return text
    raise argparse.ArgumentTypeError(f"'{text}' is none of camera, shadow, bounces=N")


def spacing(text: str) -> float:
    value = float(text)
    if not 0.02 <= value <= 100.0:
        raise argparse.ArgumentTypeError(f"{text}: 0.02 to 100 metres are possible")
    return value


def seconds(text: str) -> float:
    value = float(text)
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return value


def blend(text: str) -> str:
    """Checked before the work: Blender would put its file in the place of a folder, and take any name."""
    if os.path.isdir(text) or not text.lower().endswith(".blend"):
        raise argparse.ArgumentTypeError(f"'{text}': the name of a .blend file is wanted")
    return text


def folder(text: str) -> str:
    if os.path.exists(text) and not os.path.isdir(text):
        raise argparse.ArgumentTypeError(f"'{text}' is a file: a folder is wanted")
    return text


def metres(text: str) -> float:
    value = float(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text}: a distance above 0 is wanted")
    return value


def passes(text: str) -> list[str]:
    names = [t.strip() for t in text.split(",") if t.strip()]
    unknown = [n for n in names if n not in TITLES]
    if unknown or not names:
        raise argparse.ArgumentTypeError(f"'{text}': wanted some of {', '.join(TITLES)}")
    return names


def resolution(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(p.isdigit() and int(p) > 0 for p in parts):
        raise argparse.ArgumentTypeError(f"'{text}' is no resolution (wanted WxH)")
    return int(parts[0]), int(parts[1])
