# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on knows about each open scene between clicks: the analyser, the last answers, the live view.

Holds names and numbers, never Blender objects: those die on undo and reload.
"""

from __future__ import annotations

import time
import uuid
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import native
from .analysis import Analyser, Shot
from .rules.building import Building, Problem
from .rules.results import Cells, RoomMatrix, View
from .scene import apply_result, cull, detect, kept_rows
from .scene.cameras import view_camera
from .scene.live import Live
from .scene.shots import shot_at_rest


@dataclass
class Session:
    building: Building
    analyser: Analyser
    cells: Cells
    seconds: float = 0.0
    views: list[View] = field(default_factory=list)
    matrix: RoomMatrix | None = None
    live: Live | None = None  # while the culled view is on
    live_key: bytes = b""  # cameras, matrices and lenses that it shows
    moved: set[str] = field(default_factory=set)  # objects the user moved since detecting: never hidden
    stale: bool = False  # rooms or openings changed since detecting
    marks: set[str] = field(default_factory=set)  # objects that are rooms or openings
    candidates: set[str] = field(default_factory=set)
    boxes: dict[str, np.ndarray] = field(default_factory=dict)  # world bounds at detection, of objects drawn once
    matrices: dict[str, bytes] = field(default_factory=dict)  # of instancers
    stamp: str = ""  # of the Detect that it comes from, as the scene has it

    def occluder_moved(self) -> bool:
        """Whether an object that blocks sight isn't where it was detected: then none may."""
        return any(o.occluder is not None and o.source_id in self.moved for o in self.building.objects)

    @property
    def problems(self) -> list[Problem]:
        return self.analyser.problems


_sessions: dict[str, Session] = {}
# Panel data and overlays compare these: what is known of a scene, and what is seen, have changed when they grew.
revision = 0
looked = 0  # with every look of the live view, which changes nothing else


def touch() -> None:
    global revision
    revision += 1


def get(scene: bpy.types.Scene) -> Session | None:
    """None also where a scene has taken over another's name."""
    found = _sessions.get(scene.name_full)
    return found if found is not None and found.stamp == scene.get(detect.STAMP_KEY, "") else None


def drop(scene_name: str | None = None) -> None:
    """Forgets one scene or all; frees the core's memory."""
    for name in [scene_name] if scene_name else list(_sessions):
        old = _sessions.pop(name, None)
        if old is not None:
            old.analyser.close()
    touch()


def make(context: bpy.types.Context, source: str = "auto", ifc: str | None = None, progress=None) -> Session:
    """Detects anew. DetectError, AssemblyError, NativeMissing with a sentence each."""
    native.load()
    begin = time.perf_counter()
    search = detect.Search(context.scene, context.view_layer, source, ifc)
    search.run(progress)
    return take(context.scene, context.view_layer, search, begin)


def take(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, search: detect.Search, begin: float) -> Session:
    """Puts what was found into the scene, in place of what was known. begin: when (perf_counter) the search was asked for."""
    core = native.load()
    drop(scene.name_full)
    cull.unkey(scene)
    building = search.apply(scene, view_layer)
    made = _adopt(scene, core, building, begin)
    detect.note_counts(scene, building, made.problems)
    made.stamp = scene[detect.STAMP_KEY] = uuid.uuid4().hex
    return made


def ensure(context: bpy.types.Context) -> Session:
    """The session of the scene; when there is none (a file just opened) from what the file remembers."""
    found = get(context.scene)
    if found is not None:
        return found
    begin = time.perf_counter()
    core = native.load()
    scene = context.scene
    with apply_result.all_shown(context.view_layer):
        building = detect.current(scene, context.view_layer)
    return _adopt(scene, core, building, begin)


def _adopt(scene, core, building, begin) -> Session:
    from .rules.assemble import cells_of

    analyser = Analyser(core, building)
    made = Session(building, analyser, cells_of(analyser.made), time.perf_counter() - begin, stamp=str(scene.get(detect.STAMP_KEY, "")))
    made.candidates = cull.candidates(building)
    made.marks = detect.marked_objects(scene, building)
    entries: dict[str, int] = {}
    for o in building.objects:
        entries[o.source_id] = entries.get(o.source_id, 0) + 1
        made.boxes[o.source_id] = o.bounds
    for obj in scene.objects:
        name = obj.name_full
        if name in entries and (obj.type == "EMPTY" or entries[name] > 1):
            made.boxes.pop(name, None)
            made.matrices[name] = np.array(obj.matrix_world, dtype=np.float32).tobytes()
    rows = kept_rows.load(scene)
    if rows is not None:
        made.matrix = analyser.take_rows(rows)
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


def note_deleted(scene: bpy.types.Scene, session: Session) -> None:
    """Rooms and openings that were deleted (or unlinked, or renamed) ask for a new detection."""
    if not session.stale and not session.marks <= {o.name_full for o in scene.objects}:
        session.stale = True
        touch()


def live_shots(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> list[Shot]:
    """What the culled view follows: the scene's camera, or every 3D view that shows the scene (through the camera, too)."""
    shots = []
    through_camera = scene.enfilade.follow == "camera"
    if not through_camera:
        for space, region in _views_of(scene):
            if region.view_perspective == "CAMERA":
                through_camera = True
            else:
                shots.append(Shot("3D view", scene.frame_current, [view_camera(scene, region, space)]))
    if through_camera and scene.camera is not None and scene.camera.type == "CAMERA":
        shots.insert(0, shot_at_rest(scene, scene.camera, depsgraph or bpy.context.evaluated_depsgraph_get()))
    return shots


def _views_of(scene: bpy.types.Scene):
    for window in bpy.context.window_manager.windows:
        if window.scene != scene:
            continue
        for area in window.screen.areas:
            if area.type != "VIEW_3D":
                continue
            space = area.spaces.active
            quads = space.region_quadviews
            for region in quads if len(quads) else [space.region_3d]:
                if region is not None:
                    yield space, region


def _key(shots: list[Shot]) -> bytes:
    out = []
    for shot in shots:
        for c in [shot.camera, *shot.eyes]:
            numbers = [c.angle_x, c.angle_y, c.shift_x, c.shift_y, c.ortho_width, c.ortho_height, *c.clip, shot.eye_radius]
            out.append(c.name.encode() + c.matrix_world.tobytes() + np.array(numbers).tobytes())
    return b"".join(out)


def start_live(scene: bpy.types.Scene, session: Session) -> None:
    session.live, session.live_key = Live(session.analyser, session.candidates), b""
    touch()
    update_live(scene, force=True)


def stop_live(scene: bpy.types.Scene, session: Session) -> int:
    """Shows everything again. Returns how many objects were put back."""
    session.live, session.live_key = None, b""
    count = apply_result.restore(scene)
    touch()
    return count


def update_live(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None, force: bool = False) -> bool:
    """Hides and shows what changed since the cameras moved. True when something was looked up."""
    global looked
    session = get(scene)
    if session is None or session.live is None:
        return False
    begin = time.perf_counter()
    shots = live_shots(scene, depsgraph)
    key = _key(shots)
    if not shots or (key == session.live_key and not force):
        return False
    session.live_key = key
    session.views = session.live.look(scene, shots, session.moved, begin)
    looked += 1
    return True


def forget_objects() -> None:
    """After undo and redo: objects may be other ones, and flags as they were before. What a Detect found goes when that was undone."""
    for name, session in list(_sessions.items()):
        scene = bpy.data.scenes.get(name)
        if scene is None or scene.get(detect.STAMP_KEY, "") != session.stamp:
            drop(name)
            continue
        if session.live is not None:
            session.live.forget_objects()
            session.live_key = b""
