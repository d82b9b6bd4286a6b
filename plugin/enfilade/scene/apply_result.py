# SPDX-License-Identifier: GPL-3.0-or-later
"""Hides what a view doesn't need, and puts everything back exactly.

One rule makes the restore exact: we only ever turn *visible* into *hidden*, and every object we touch carries the
custom property `enfilade_hidden` with the flags we turned (bits below). So restoring needs no list that could be lost, and survives
saving, a crash and reload, renaming, undo, and whatever the user changes in between: flags without our bit are never
written.

Which flag, and how it is written, follows measurements (tests/blender/measure_toggle.py prints them):
  SAFE      visible_camera, one by one: linear, light and reflections stay the same (Cycles).
  RENDER    hide_render: foreach_set over the collections of the changed objects, then update_tag on these. One by one each write
            costs time linear in the scene; foreach_set without the tag leaves the evaluated scene as it was, and a render then
            shows the set of the view before.
  VIEWPORT  hide_viewport: the same with the transform's tag alone, then a layer collection's flag written as it is, which syncs
            the layers: half the update's cost, whatever the number of objects changed.
Collections can't do it: an object stays visible as long as any of its collections is, so hiding through them would
mean taking objects out of the user's own. `Enfilade Visible` and `Enfilade Hidden` are lists to look at and select by;
both are switched off themselves and so add no visibility to anything.
"""

from __future__ import annotations

import json
import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ..compat import fcurves_of

SAFE, VIEWPORT, RENDER = "safe", "viewport", "render"
MODES = (SAFE, VIEWPORT, RENDER)
HIDDEN_KEY = "enfilade_hidden"  # on objects: bits of the flags we turned
KEYED_KEY = "enfilade_keyed"  # on objects: the flag that we set keys of
STATE_KEY = "enfilade_state"  # on scenes: JSON, what is applied
_BIT = {SAFE: 1, VIEWPORT: 2, RENDER: 4}
_ATTRIBUTE = {SAFE: "visible_camera", VIEWPORT: "hide_viewport", RENDER: "hide_render"}


@dataclass
class Applied:
    """What one write did."""

    mode: str
    hidden: int = 0  # objects hidden by us now
    kept: int = 0  # candidates left visible
    changed: int = 0  # flags written this time
    already: int = 0  # to be hidden, but the user had hidden them before: not ours
    linked: int = 0  # a library's, can't be written: left visible
    seconds: float = 0.0
    names: list[str] = field(default_factory=list)  # objects hidden by us now


def hidden_objects(mode: str | None = None) -> list[bpy.types.Object]:
    """Objects that carry our mark (for one mode or any)."""
    want = 7 if mode is None else _BIT[mode]
    out = []
    for obj in bpy.data.objects:
        bits = obj.get(HIDDEN_KEY)
        if bits is not None and int(bits) & want:
            out.append(obj)
    return out


def state_of(scene: bpy.types.Scene) -> dict:
    """What is applied, {} for nothing. Damaged text counts as nothing; the objects' marks are the truth."""
    try:
        value = json.loads(scene.get(STATE_KEY, "{}"))
    except (TypeError, ValueError):
        return {}
    return value if isinstance(value, dict) else {}


def apply(
    scene: bpy.types.Scene,
    keep: Collection[str],
    candidates: Iterable[str],
    mode: str,
    note: dict | None = None,
) -> Applied:
    """Hides the candidates that aren't in `keep` (full object names), shows again those of ours that are.

    Only the difference to what is applied is written. Objects of the scene that are no candidates are never touched.
    """
    begin = time.perf_counter()
    bit = _BIT[mode]
    out = Applied(mode)
    wanted = set(candidates)
    keep = set(keep)
    to_hide: list[bpy.types.Object] = []
    to_show: list[bpy.types.Object] = []
    attribute = _ATTRIBUTE[mode]
    for obj in scene.objects:
        name = obj.name_full
        bits = int(obj.get(HIDDEN_KEY, 0))
        ours = bool(bits & bit)
        if name in wanted and name not in keep:
            if not is_writable(obj):
                out.linked += 1
            elif ours:
                out.names.append(name)
            elif _is_hidden(obj, attribute):
                out.already += 1
            else:
                to_hide.append(obj)
                out.names.append(name)
        else:
            if name in wanted:
                out.kept += 1
            if ours:
                to_show.append(obj)
    _write(mode, to_hide, to_show)
    out.hidden = len(out.names)
    out.changed = len(to_hide) + len(to_show)
    note_state(scene, mode, out.hidden, note)
    out.seconds = time.perf_counter() - begin
    return out


def note_state(scene: bpy.types.Scene, mode: str, hidden: int, note: dict | None = None) -> None:
    state = dict(note or {})
    state.update(mode=mode, hidden=hidden)
    scene[STATE_KEY] = json.dumps(state, sort_keys=True)


def apply_difference(
    mode: str, to_hide: Iterable[bpy.types.Object], to_show: Iterable[bpy.types.Object]
) -> tuple[int, int]:
    """The inner write for live views and frame tables, which know what changed. Returns how many were hidden, and shown."""
    attribute, bit = _ATTRIBUTE[mode], _BIT[mode]
    hide = [o for o in to_hide if is_writable(o) and not _is_hidden(o, attribute)]
    show = [o for o in to_show if int(o.get(HIDDEN_KEY, 0)) & bit]
    _write(mode, hide, show)
    return len(hide), len(show)


def restore(_scene: bpy.types.Scene | None = None) -> int:
    """Shows again whatever we hid, in every mode and every scene of the file, and removes all our traces but the cells and
    portals drawn for looking at. Returns how many objects were put back."""
    count = 0
    for mode in MODES:
        ours = hidden_objects(mode)
        _write(mode, [], ours)
        count += len(ours)
    for obj in bpy.data.objects:
        if HIDDEN_KEY in obj:
            del obj[HIDDEN_KEY]
    for item in bpy.data.scenes:  # flags are the objects', whichever scene they were hidden for
        if item.library is None and STATE_KEY in item:
            del item[STATE_KEY]
    return count


@contextmanager
def all_shown(view_layer: bpy.types.ViewLayer) -> Iterator[None]:
    """Shows what we hid, for whichever scene and by keys too, while something reads one, then hides it as it was: what is hidden isn't
    evaluated, and would be missing."""
    states = {s.name_full: s[STATE_KEY] for s in bpy.data.scenes if STATE_KEY in s}
    hidden = {mode: {o.name_full for o in hidden_objects(mode)} for mode in MODES}
    keyed = list(_keyed())
    try:
        for obj, attribute, curve, _ in keyed:
            curve.mute = True
            setattr(obj, attribute, attribute == "visible_camera")
        if any(hidden.values()):
            restore()
        if keyed or any(hidden.values()):
            view_layer.update()
        yield
    finally:
        for obj, attribute, curve, value in keyed:
            curve.mute = False
            setattr(obj, attribute, value)
        for mode, names in hidden.items():
            apply_difference(mode, [o for o in bpy.data.objects if o.name_full in names], [])
        for scene in bpy.data.scenes:
            if scene.name_full in states:
                scene[STATE_KEY] = states[scene.name_full]


def _keyed() -> Iterator[tuple[bpy.types.Object, str, bpy.types.FCurve, bool]]:
    """Objects with keys of ours: which flag, its curve, and what it is now."""
    for obj in bpy.data.objects:
        attribute = obj.get(KEYED_KEY)
        curves = fcurves_of(obj) if attribute else None
        curve = curves.find(attribute) if curves is not None else None
        if curve is not None and not curve.mute:
            yield obj, attribute, curve, getattr(obj, attribute)


def _is_hidden(obj: bpy.types.Object, attribute: str) -> bool:
    value = bool(getattr(obj, attribute))
    return not value if attribute == "visible_camera" else value


def _not_evaluated(objects: list[bpy.types.Object]) -> bpy.types.Object | None:
    """The first object that the active view layer's graph doesn't know."""
    depsgraph = bpy.context.view_layer.depsgraph if bpy.context.view_layer else None
    for obj in objects:
        if depsgraph is None or not obj.evaluated_get(depsgraph).is_evaluated:
            return obj
    return None


# Where objects stand: address -> the smallest collection that holds it ("": none, but the file), and its place there. Finding
# out costs the whole file, so it is kept, and a write that goes by it is checked before anybody sees what it did.
_homes: dict[int, tuple[str, int]] = {}
# Of each of these lists the places in the order in which foreach_set takes values: it passes over objects that can't be written,
# which come last here.
_orders: dict[str, np.ndarray] = {}


def is_writable(obj: bpy.types.Object) -> bool:
    """Not those of linked files, nor their copies here that Blender lets nobody edit."""
    override = obj.override_library
    return obj.library is None and (override is None or not override.is_system_override)


def _find_homes() -> None:
    _homes.clear()
    _orders.clear()
    own = {c.name: c for c in bpy.data.collections if c.library is None}
    lists = {"": list(bpy.data.objects), **{name: list(c.objects) for name, c in own.items() if bpy.data.collections[name] == c}}
    for home, objects in sorted(lists.items(), key=lambda item: len(item[1]), reverse=True):
        _orders[home] = np.argsort([not is_writable(obj) for obj in objects], kind="stable")
        _homes.update((obj.as_pointer(), (home, i)) for i, obj in enumerate(objects))


def _set_flags(attribute: str, hide: list[bpy.types.Object], show: list[bpy.types.Object]) -> None:
    """Sets a flag in bulk: without the update that each single write brings."""
    turned = [(o, True) for o in hide if not getattr(o, attribute)] + [(o, False) for o in show if getattr(o, attribute)]
    if not _set_where_they_stood(attribute, turned):
        _find_homes()
        if not _set_where_they_stood(attribute, turned):
            for obj, value in turned:  # slow, but sure
                setattr(obj, attribute, value)


def _set_where_they_stood(attribute: str, turned: list[tuple[bpy.types.Object, bool]]) -> bool:
    """False where one of them stands elsewhere by now; then nothing is changed."""
    changes: dict[str, list[tuple[int, bool]]] = {}
    for obj, value in turned:
        home, place = _homes.get(obj.as_pointer(), ("", -1))
        if place < 0:
            return False
        changes.setdefault(home, []).append((place, value))
    before: list[tuple[Any, np.ndarray]] = []
    fits = all(_set_in(home, attribute, places, before) for home, places in changes.items())
    # Each of them had to turn, and no more flags than these were written: when all have, no other object's was.
    fits = fits and all(bool(getattr(obj, attribute)) == value for obj, value in turned)
    if not fits:
        for objects, flags in reversed(before):
            for obj, value in zip(objects, flags.tolist(), strict=True):
                if bool(getattr(obj, attribute)) != value:
                    setattr(obj, attribute, value)
    return fits


def _set_in(home: str, attribute: str, places: list[tuple[int, bool]], before: list[tuple[Any, np.ndarray]]) -> bool:
    """Writes flags into one list, by place; adds to `before` what they were. False when it isn't the list that it was."""
    collection = bpy.data.collections.get(home) if home else bpy.data
    if collection is None:
        return False
    objects = collection.objects
    flags = _flags(objects, attribute)
    if len(flags) != len(_orders[home]):
        return False
    before.append((objects, flags.copy()))
    for place, value in places:
        flags[place] = value
    objects.foreach_set(attribute, flags[_orders[home]])
    # with libraries, what can be written may have changed since: then flags went astray
    return not bpy.data.libraries or np.array_equal(_flags(objects, attribute), flags)


def _flags(objects: Any, attribute: str) -> np.ndarray:
    """One an object. The length must be right: Blender writes beyond an array that is too short by one."""
    out = np.empty(len(objects), dtype=bool)
    objects.foreach_get(attribute, out)
    return out


def _sync_layers() -> None:
    """Makes the view layers take over the objects' flags: a layer collection's flag written with the value it has costs a
    sync of the layer and no rebuild of relations."""
    for scene in bpy.data.scenes:
        for layer in scene.view_layers if scene.library is None else ():
            root = layer.layer_collection
            root.holdout = root.holdout


def _write(mode: str, hide: list[bpy.types.Object], show: list[bpy.types.Object]) -> None:
    bit, attribute = _BIT[mode], _ATTRIBUTE[mode]
    # The marks come first: a crash between the two leaves a mark on a visible object, which restoring ignores in effect;
    # the other way round an object would stay hidden for good.
    for obj in hide:
        obj[HIDDEN_KEY] = int(obj.get(HIDDEN_KEY, 0)) | bit
    if mode == SAFE:
        for obj in hide:
            obj.visible_camera = False
        for obj in show:
            obj.visible_camera = True
    elif hide or show:
        _set_flags(attribute, hide, show)
        for obj in hide + show:
            if mode == VIEWPORT:  # transform is the least that carries the flag over; a full tag rebuilds meshes
                obj.update_tag(refresh={"OBJECT"})
            else:
                obj.update_tag()
        if mode == VIEWPORT:
            _sync_layers()
        if mode == VIEWPORT:
            stranger = _not_evaluated(show)
            if stranger is not None:
                # Hidden since the file was loaded, an object isn't in the dependency graph and no tag reaches it: one write
                # through RNA builds the graph anew, for all of them.
                stranger.hide_viewport = True
                stranger.hide_viewport = False
    for obj in show:
        bits = int(obj.get(HIDDEN_KEY, 0)) & ~bit
        if bits:
            obj[HIDDEN_KEY] = bits
        elif HIDDEN_KEY in obj:
            del obj[HIDDEN_KEY]
