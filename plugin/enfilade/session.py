# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on knows about each open scene between clicks: the analyser, the last answers, the live view.

Holds names and numbers, never Blender objects: those die on undo and reload.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import native
from .analysis import Analyser
from .rules.building import Building, Problem
from .rules.results import Cells, RoomMatrix, View
from .scene import apply_result, cull, detect
from .scene.shots import shot_of


@dataclass
class Session:
    building: Building
    analyser: Analyser
    cells: Cells
    seconds: float = 0.0
    views: list[View] = field(default_factory=list)
    matrix: RoomMatrix | None = None
    live: bool = False
    live_key: bytes = b""  # camera, matrix and lens that the live view shows
    live_figures: dict[str, float] = field(default_factory=dict)
    moved: set[str] = field(default_factory=set)  # objects the user moved since detecting: never hidden
    stale: bool = False  # rooms or openings changed since detecting
    candidates: set[str] = field(default_factory=set)
    boxes: dict[str, np.ndarray] = field(default_factory=dict)  # world bounds at detection, of objects drawn once
    matrices: dict[str, bytes] = field(default_factory=dict)  # of instancers

    @property
    def problems(self) -> list[Problem]:
        return self.analyser.problems


_sessions: dict[str, Session] = {}
revision = 0  # grows with every change: panel data and overlays compare it


def touch() -> None:
    global revision
    revision += 1


def get(scene: bpy.types.Scene) -> Session | None:
    return _sessions.get(scene.name_full)


def drop(scene_name: str | None = None) -> None:
    """Forgets one scene or all; frees the core's memory."""
    for name in [scene_name] if scene_name else list(_sessions):
        old = _sessions.pop(name, None)
        if old is not None:
            old.analyser.close()
    touch()


def make(context: bpy.types.Context, source: str = "auto", ifc: str | None = None, progress=None) -> Session:
    """Detects anew. DetectError, AssemblyError, NativeMissing with a sentence each."""
    scene = context.scene
    begin = time.perf_counter()
    core = native.load()
    drop(scene.name_full)
    cull.unkey(scene)
    building = detect.detect(scene, context.view_layer, source, ifc, progress)
    return _adopt(scene, core, building, begin)


def ensure(context: bpy.types.Context) -> Session:
    """The session of the scene; when there is none (a file just opened) from what the file remembers."""
    found = get(context.scene)
    if found is not None:
        return found
    begin = time.perf_counter()
    core = native.load()
    scene = context.scene
    state = apply_result.state_of(scene)
    hidden = {m: [o.name_full for o in apply_result.hidden_objects(m)] for m in apply_result.MODES}
    try:
        if any(hidden.values()):
            apply_result.restore(scene)  # what is hidden isn't evaluated, and would be missing
            context.view_layer.update()
        building = detect.current(scene, context.view_layer)
    finally:
        for mode, names in hidden.items():
            if names:  # and back, as it was found
                apply_result.apply(scene, set(), names, mode, state)
    return _adopt(scene, core, building, begin)


def _adopt(scene, core, building, begin) -> Session:
    from .rules.assemble import cells_of

    analyser = Analyser(core, building)
    made = Session(building, analyser, cells_of(analyser.made), time.perf_counter() - begin)
    made.candidates = cull.candidates(building)
    entries: dict[str, int] = {}
    for o in building.objects:
        entries[o.source_id] = entries.get(o.source_id, 0) + 1
        made.boxes[o.source_id] = o.bounds
    for obj in scene.objects:
        name = obj.name_full
        if name in entries and (obj.type == "EMPTY" or entries[name] > 1):
            made.boxes.pop(name, None)
            made.matrices[name] = np.array(obj.matrix_world, dtype=np.float32).tobytes()
    _sessions[scene.name_full] = made
    touch()
    return made


def is_elsewhere(session: Session, evaluated: bpy.types.Object) -> bool:
    """Whether an object isn't where it was when the building was detected (1 mm, as far as bounds are good for)."""
    name = evaluated.original.name_full
    if name in session.matrices:
        return np.array(evaluated.matrix_world, dtype=np.float32).tobytes() != session.matrices[name]
    box = session.boxes.get(name)
    if box is None:
        return True
    corners = np.array(evaluated.bound_box, dtype=np.float64)
    matrix = np.array(evaluated.matrix_world, dtype=np.float64)
    world = corners @ matrix[:3, :3].T + matrix[:3, 3]
    return bool(np.abs(np.stack([world.min(axis=0), world.max(axis=0)]) - box).max() > 1e-3)


def camera_key(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> bytes:
    """Changes when the active camera's view does."""
    from .scene.cameras import read_camera

    if scene.camera is None or scene.camera.type != "CAMERA":
        return b""
    c = read_camera(scene, scene.camera, depsgraph)
    numbers = [c.angle_x, c.angle_y, c.shift_x, c.shift_y, c.ortho_width, c.ortho_height, *c.clip]
    return c.name.encode() + c.matrix_world.tobytes() + np.array(numbers).tobytes()


def update_live(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None, force: bool = False) -> bool:
    """Hides and shows what changed since the camera moved. True when something was looked up."""
    session = get(scene)
    if session is None or not session.live or scene.camera is None:
        return False
    key = camera_key(scene, depsgraph)
    if not key or (key == session.live_key and not force):
        return False
    begin = time.perf_counter()
    session.live_key = key
    settings = scene.enfilade
    from .analysis import Shot
    from .scene.cameras import read_camera

    if depsgraph is not None:
        shot = Shot(scene.camera.name, scene.frame_current, [read_camera(scene, scene.camera, depsgraph)])
    else:
        shot = shot_of(scene, scene.camera)
    result = cull.cull(session.analyser, [shot], settings.method, settings.keep_text, cull.has_sky(scene))
    session.views = result.views
    looked = time.perf_counter()
    keep = result.names | session.moved
    applied = apply_result.apply(scene, keep, session.candidates, apply_result.VIEWPORT, {"live": True})
    done = time.perf_counter()
    session.live_figures = {
        "kept": applied.kept,
        "hidden": applied.hidden,
        "changed": applied.changed,
        "query_us": result.views[0].microseconds,
        "look_ms": 1e3 * (looked - begin),
        "write_ms": 1e3 * (done - looked),
    }
    touch()
    return True
