# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels show, worked out once a change and not once a redraw."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import bpy
import numpy as np

from .. import session
from ..rules.names import Names, sentence
from ..rules.results import unculled
from ..rules.tally import Change, Tally
from ..scene import apply_result, detect, frame_table
from ..scene.import_ifc import GLOBAL_ID


@dataclass
class Row:
    index: int
    icon: str
    message: str
    remedy: str
    code: str = ""
    placed: bool = False  # any of them has a place
    count: int = 1


@dataclass
class PanelData:
    detected: bool = False
    live: bool = False
    baked: bool = False  # who sees whom
    sightlines_of: str = ""  # the room whose sightlines are drawn, of too many; "": all are
    applied: str = ""  # what is hidden now, in words
    stale: bool = False
    moved: int = 0  # objects, since the last Detect
    figures: list[tuple[str, str]] = field(default_factory=list)
    seen: list[tuple[str, str]] = field(default_factory=list)  # room, through which openings
    seen_from: str = ""  # "From Camera Living"
    seen_figures: list[tuple[str, str]] = field(default_factory=list)
    seen_whole: str = ""  # why walls hide nothing there, as a sentence
    problems: list[Row] = field(default_factory=list)
    storeys: list[str] = field(default_factory=list)
    rules: list[tuple[str, str]] = field(default_factory=list)  # what the user says of openings
    opening_of: dict[str, str] = field(default_factory=dict)  # object -> the name that rules know its opening by
    problems_left: int = 0  # kinds that aren't in `problems`
    problem_counts: tuple[int, int, int] = (0, 0, 0)  # errors, warnings, infos


_ICONS = {"error": "CANCEL", "warning": "ERROR", "info": "INFO"}
_MODES = {"safe": "camera rays", "render": "renders", "viewport": "3D view"}
_known: dict[str, tuple[tuple, PanelData]] = {}  # scene -> without what is seen, which changes with every look of the live view
_cache: dict[str, tuple[tuple, PanelData]] = {}
MOST_PROBLEMS = 12
MOST_ROOMS = 10
MOST_SIGHTLINES = 300  # that can be told apart in a view


def of(scene: bpy.types.Scene) -> PanelData:
    key = (session.revision, scene.get(detect.RULES_KEY, ""))
    known = _kept(_known, scene, key, _of_building)
    key += (session.looked, *(s.get(apply_result.STATE_KEY, "") for s in bpy.data.scenes), scene.get(frame_table.TEXT_KEY, ""))
    return _kept(_cache, scene, key, lambda s: _with_view(s, replace(known)))


def _kept(cache: dict, scene: bpy.types.Scene, key: tuple, make: Callable[[bpy.types.Scene], PanelData]) -> PanelData:
    cached = cache.get(scene.name_full)
    if cached is None or cached[0] != key:
        cached = cache[scene.name_full] = (key, make(scene))
    return cached[1]


def forget() -> None:
    _known.clear()
    _cache.clear()


def _time(microseconds: float) -> str:
    return f"{microseconds:.0f} \u00b5s" if microseconds < 1000.0 else f"{microseconds / 1000.0:.1f} ms"


def _of_building(scene: bpy.types.Scene) -> PanelData:
    out = PanelData()
    found = session.get(scene)
    if found is None:
        return out
    out.detected, out.live, out.stale, out.moved = True, found.live is not None, found.stale, len(found.moved)
    building = found.building
    found_now = Change(Tally.of(building, found.problems), detect.counts_of(scene).before).figures()
    states = [o.state for o in building.openings]
    out.figures = [
        ("Rooms", found_now["Rooms"]),
        ("Storeys", str(len(building.storeys))),
        ("Openings", found_now["Openings"]),
        ("Problems", found_now["Problems"]),
        ("Closed", str(states.count("closed"))),
        ("Cells, portals", f"{len(found.cells.rooms)}, {len(found.cells.portals)}"),
        ("Objects", f"{len(found.candidates)}"),
    ]
    out.baked = found.matrix is not None
    if out.baked:
        inside = [i for i, r in enumerate(building.rooms) if r.kind == "interior"]
        pairs = (int(found.matrix.visible[np.ix_(inside, inside)].sum()) - len(inside)) // 2
        out.figures.append(("Pairs in sight", f"{pairs:,} of {len(inside) * (len(inside) - 1) // 2:,}"))
    out.storeys = [name for name, _ in building.storeys]
    out.rules = sorted(detect.rules_of(scene).items())
    keys = {k for o in building.openings for k in (o.source_id, o.name) if k}
    for obj in scene.objects:
        key = next((k for k in (obj.get(GLOBAL_ID, ""), obj.name_full, obj.name.partition("/")[2]) if k in keys), "")
        if key:
            out.opening_of[obj.name_full] = key
    _add_problems(out, found)
    return out


def _add_problems(out: PanelData, found: session.Session) -> None:
    """The gravest first, those alike in one row."""
    grouped: dict[tuple[str, str], Row] = {}
    counts = {"error": 0, "warning": 0, "info": 0}
    order = {"error": 0, "warning": 1, "info": 2}
    for i, p in sorted(enumerate(found.problems), key=lambda item: order.get(item[1].severity, 3)):
        counts[p.severity] = counts.get(p.severity, 0) + 1
        key = (p.code, p.message if p.severity == "error" else "")
        if key in grouped:
            grouped[key].count += 1
        else:
            grouped[key] = Row(i, _ICONS.get(p.severity, "DOT"), sentence(p.message), sentence(p.remedy), p.code)
        grouped[key].placed |= p.position is not None
    out.problems = list(grouped.values())[:MOST_PROBLEMS]
    out.problems_left = max(0, len(grouped) - MOST_PROBLEMS)
    out.problem_counts = counts["error"], counts["warning"], counts["info"]


def _with_view(scene: bpy.types.Scene, out: PanelData) -> PanelData:
    """What is hidden, and what is seen. out: a copy, whose lists are others'."""
    applied = next(((s, state) for s in (scene, *bpy.data.scenes) if (state := apply_result.state_of(s))), None)
    if applied is not None:  # objects are the file's: hidden for another scene they are hidden in this one
        where, state = applied
        other = "" if where == scene else f", for {where.name}"
        out.applied = f"{state.get('hidden', 0)} hidden ({_MODES.get(state.get('mode', ''), '')}{other})"
    elif frame_table.TEXT_KEY in scene:
        out.applied = "Culled by frame"
    found = session.get(scene)
    if found is None or not found.views:
        return out
    building, view = found.building, found.views[-1]
    names = Names(building)
    out.seen_from = {"Here": "From here", "3D view": "From the 3D view"}.get(view.camera.name, f"From {view.camera.name}")
    drawn = {building.objects[o].source_id for o in view.objects}
    out.seen_figures = [("Objects", f"{len(drawn)} of {len(found.candidates)}"), ("Looked up in", _time(view.microseconds))]
    out.seen_whole = next(iter(unculled([view])), "")
    if found.live is not None and found.live.looks:
        look = found.live.looks[-1]
        out.seen_figures.append(("Entered, left", f"{look.entered}, {look.left}"))
        out.seen_figures.append(("Written in", _time(1000.0 * (look.look_ms + look.write_ms))))
    out.seen = [(names.room(room), names.way(view.room_why.get(room, []))) for room in view.rooms[:MOST_ROOMS]]
    if len(view.rooms) > MOST_ROOMS:
        out.seen.append((f"and {len(view.rooms) - MOST_ROOMS} more", ""))
    if out.seen and out.baked and len(found.matrix.sightlines) > MOST_SIGHTLINES:
        out.sightlines_of = building.rooms[view.rooms[0]].name
    return out
