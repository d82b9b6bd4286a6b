# SPDX-License-Identifier: GPL-3.0-or-later
"""Views and keep sets to what is hidden in the scene: the step between `analysis` and `apply_result`."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from ..analysis import Analyser, Keep, Shot
from ..compat import world_nodes
from ..rules.building import Building
from ..rules.results import View, unculled
from . import apply_result, collections, frame_table


@dataclass
class Culled:
    views: list[View]
    keep: Keep
    names: set[str] = field(default_factory=set)  # objects in the file that stay

    @property
    def notes(self) -> list[str]:
        """What people should know of it."""
        return [*self.keep.notes, *unculled(self.views)]


def mode_for(mode: str, keep: str) -> str:
    """auto: safe for `camera` (light stays as it is), else render (what stays makes the same light)."""
    return mode if mode != "auto" else (apply_result.SAFE if keep == "camera" else apply_result.RENDER)


def has_sky(scene: bpy.types.Scene) -> bool:
    """Whether light may come from outdoors without a lamp. Only a plain black world surely gives none."""
    world = scene.world
    if world is None:
        return False
    tree = world_nodes(world)
    if tree is not None:
        background = [n for n in tree.nodes if n.type == "BACKGROUND"]
        if len(tree.nodes) <= 2 and len(background) == 1:
            strength, colour = background[0].inputs["Strength"], background[0].inputs["Color"]
            if not strength.is_linked and not colour.is_linked:
                return float(strength.default_value) > 0.0 and max(colour.default_value[:3]) > 0.0
        return True
    return max(world.color) > 0.0


def candidates(building: Building) -> set[str]:
    return {o.source_id for o in building.objects}


def names_of(building: Building, objects: np.ndarray) -> set[str]:
    """Objects in the file: an instancer stays when any of its instances does."""
    return {building.objects[int(i)].source_id for i in objects}


def cull(analyser: Analyser, shots: list[Shot], method: str, keep: str, sky: bool, why: bool = True) -> Culled:
    views = [analyser.look(shot, method, why) for shot in shots]
    kept = analyser.keep(views, keep, sky)
    return Culled(views, kept, names_of(analyser.building, kept.objects))


def write(scene: bpy.types.Scene, building: Building, culled: Culled, mode: str, note: dict | None = None, lists: bool = True):
    """Hides, and lists what is visible and hidden in the `Enfilade` collections."""
    all_names = candidates(building)
    applied = apply_result.apply(scene, culled.names, all_names, mode, note)
    if lists:
        hidden = set(applied.names)
        objects = {o.name_full: o for o in scene.objects}
        collections.list_objects(
            scene,
            [objects[n] for n in sorted(all_names & culled.names) if n in objects],
            [objects[n] for n in sorted(hidden) if n in objects],
        )
    return applied


def table(building: Building, by_frame: dict[int, set[str]], mode: str) -> frame_table.FrameTable:
    """by_frame: the names that stay, by frame."""
    names = sorted(candidates(building))
    out = frame_table.FrameTable(mode, names)
    for frame, stay in by_frame.items():
        out.frames[frame] = np.array([n not in stay for n in names], dtype=bool)
    return out


def keyframe(scene: bpy.types.Scene, table_: frame_table.FrameTable) -> int:
    """Keyframes instead of a table: the file then renders anywhere, without this add-on. Returns the keys set.

    Only for objects without an animation of that flag; they get our mark too, and `restore` removes the keys.
    """
    attribute = {"safe": "visible_camera", "render": "hide_render", "viewport": "hide_viewport"}[table_.mode]
    hidden_value = attribute != "visible_camera"
    frames = sorted(table_.frames)
    rows = np.array([table_.frames[f] for f in frames])
    objects = {o.name_full: o for o in scene.objects}
    count = 0
    for i, name in enumerate(table_.names):
        obj = objects.get(name)
        if obj is None or not apply_result.is_writable(obj) or not rows[:, i].any():
            continue
        if bool(getattr(obj, attribute)) == hidden_value:
            continue  # hidden by the user
        last = None
        for frame, hidden in zip(frames, rows[:, i].tolist(), strict=True):
            if hidden == last:
                continue
            setattr(obj, attribute, hidden_value if hidden else not hidden_value)
            obj.keyframe_insert(attribute, frame=frame)
            last, count = hidden, count + 1
        if last:  # beyond the range everything shows
            setattr(obj, attribute, not hidden_value)
            obj.keyframe_insert(attribute, frame=frames[-1] + 1)
            count += 1
        obj[apply_result.KEYED_KEY] = attribute
    scene.frame_set(scene.frame_current)
    return count


def unkey(scene: bpy.types.Scene) -> int:
    """Takes our keyframes away and shows the objects again."""
    count = 0
    for obj in bpy.data.objects:
        attribute = obj.get(apply_result.KEYED_KEY)
        if not attribute:
            continue
        obj.driver_remove(attribute)
        if obj.animation_data and obj.animation_data.action:
            _drop_curve(obj, attribute)
        setattr(obj, attribute, attribute == "visible_camera")
        del obj[apply_result.KEYED_KEY]
        count += 1
    return count


def _drop_curve(obj: bpy.types.Object, attribute: str) -> None:
    from ..compat import fcurves_of

    curves = fcurves_of(obj)
    if curves is None:
        return
    curve = curves.find(attribute)
    if curve is not None:
        curves.remove(curve)
    if len(curves) == 0:
        action = obj.animation_data.action
        obj.animation_data.action = None
        if action.users == 0:
            bpy.data.actions.remove(action)
        if not obj.animation_data.drivers and not obj.animation_data.nla_tracks:
            obj.animation_data_clear()
