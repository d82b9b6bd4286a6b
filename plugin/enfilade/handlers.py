# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's callbacks: the live view follows the camera, the frame table is applied, loading a file starts afresh.

During an animation render handlers run in the render thread and the original camera stays where it was: there only the
frame table is applied (keyed by frame_current), and the live view rests.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import migrate, session
from .scene import frame_table
from .ui import error_log

_rendering = False
_busy = False  # our own writes trigger depsgraph updates: don't answer those


@persistent
def on_load(*_args) -> None:
    global _rendering, _busy
    _rendering = _busy = False
    session.drop()
    for note in migrate.run():
        error_log.add("file", note)
    from .ui import overlay

    overlay.forget()


@persistent
def on_frame_change_pre(scene, *_args) -> None:
    """The right place: changes made here are evaluated with the frame, in the window and in renders, with and without
    persistent data."""
    global _busy
    if _busy or frame_table.TEXT_KEY not in scene:
        return
    _busy = True
    try:
        frame_table.apply_frame(scene, scene.frame_current)
    except ValueError as error:
        error_log.add("frames", str(error))
    finally:
        _busy = False


@persistent
def on_depsgraph_update(scene, depsgraph=None) -> None:
    global _busy
    if _busy or _rendering or depsgraph is None or depsgraph.mode != "VIEWPORT":
        return
    found = session.get(scene)
    if found is None:
        return
    _busy = True
    try:
        _note_changes(found, depsgraph)
        if depsgraph.id_type_updated("COLLECTION"):  # so it is when an object was deleted, and never while a camera moves
            session.note_deleted(scene, found)
        if found.live is not None:
            session.update_live(scene, depsgraph)
    except Exception as error:  # a handler that raises prints at every redraw: say it once, in the panel
        _give_up(found, error)
    finally:
        _busy = False


def _give_up(found: session.Session, error: Exception) -> None:
    found.live = None
    error_log.add("live view", f"The culled view was switched off: {error}")
    session.touch()


def follow_views() -> float | None:
    """A timer: turning a 3D view changes nothing that Blender would tell handlers about."""
    global _busy
    scene = bpy.context.scene
    found = session.get(scene) if scene is not None else None
    if found is None or found.live is None:
        return 0.5
    if _busy or _rendering or scene.enfilade.follow != "view":
        return 0.1
    _busy = True
    try:
        session.update_live(scene)
    except Exception as error:
        _give_up(found, error)
    finally:
        _busy = False
    return 0.04


@persistent
def on_undo(*_args) -> None:
    session.forget_objects()


def _note_changes(found: session.Session, depsgraph) -> None:
    """Objects moved or edited since detecting are never hidden; edited rooms or openings ask for a new detection."""
    for update in depsgraph.updates:
        ident = update.id
        if not isinstance(ident, bpy.types.Object) or not (update.is_updated_transform or update.is_updated_geometry):
            continue
        name = ident.original.name_full
        if ident.type == "CAMERA" or ident.original.get("enfilade_hidden") is not None:
            continue
        if name in found.candidates:
            # showing an object again updates it too: only one that is elsewhere now counts
            if name not in found.moved and session.is_elsewhere(found, ident):
                found.moved.add(name)
                found.live_key = b""  # it shows from now on, and what it may have hidden, too
                session.touch()
        elif not found.stale and (name in found.marks or ident.original.get("enfilade") not in (None, "ignore")):
            found.stale = True
            session.touch()


@persistent
def on_render_start(*_args) -> None:
    global _rendering
    _rendering = True


@persistent
def on_render_end(*_args) -> None:
    global _rendering
    _rendering = False


_HOOKS = (
    ("load_post", on_load),
    ("frame_change_pre", on_frame_change_pre),
    ("depsgraph_update_post", on_depsgraph_update),
    ("render_init", on_render_start),
    ("render_complete", on_render_end),
    ("render_cancel", on_render_end),
    ("undo_post", on_undo),
    ("redo_post", on_undo),
)


def register() -> None:
    for group, hook in _HOOKS:
        hooks = getattr(bpy.app.handlers, group)
        if hook not in hooks:
            hooks.append(hook)
    if not bpy.app.background and not bpy.app.timers.is_registered(follow_views):
        bpy.app.timers.register(follow_views, first_interval=0.5, persistent=True)


def unregister() -> None:
    for group, hook in _HOOKS:
        hooks = getattr(bpy.app.handlers, group)
        if hook in hooks:
            hooks.remove(hook)
    if bpy.app.timers.is_registered(follow_views):
        bpy.app.timers.unregister(follow_views)
