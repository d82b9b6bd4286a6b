# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that differs between Blender 3.4 and 5.x, feature-tested where possible."""

from __future__ import annotations

from typing import Any

import bpy


def fcurves_of(obj: bpy.types.ID) -> Any:
    """The animation curves of an ID's action, or None. Actions have slots from 4.4, and no `fcurves` from 5.0."""
    data = obj.animation_data
    if data is None or data.action is None:
        return None
    action = data.action
    slot = getattr(data, "action_slot", None)
    if slot is not None:
        try:
            from bpy_extras.anim_utils import action_get_channelbag_for_slot
        except ImportError:
            for layer in action.layers:
                for strip in layer.strips:
                    bag = strip.channelbag(slot)
                    if bag is not None:
                        return bag.fcurves
            return None
        bag = action_get_channelbag_for_slot(action, slot)
        return None if bag is None else bag.fcurves
    return getattr(action, "fcurves", None)


def set_multilayer_exr(settings: Any) -> None:
    """Multilayer EXR, 32 bit. From 5.0 the kind of medium is chosen before the format."""
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    settings.exr_codec = "ZIP"


def world_nodes(world: Any) -> Any:
    """The world's node tree where it is used, else None. From 5.0 it always is, and asking warns."""
    if bpy.app.version >= (5, 0, 0) or world.use_nodes:
        return world.node_tree
    return None


def use_cycles(scene: bpy.types.Scene) -> bool:
    """Switches to Cycles on the CPU; False when this Blender has none."""
    try:
        scene.render.engine = "CYCLES"
    except TypeError:
        return False
    scene.cycles.device = "CPU"
    return True


def disable_compositing(scene: bpy.types.Scene) -> None:
    """The picture straight from the renderer: no compositor, no sequencer, no denoiser."""
    scene.render.use_compositing = False
    scene.render.use_sequencer = False
    if hasattr(scene.cycles, "use_denoising"):
        scene.cycles.use_denoising = False


def line_shader(gpu: Any) -> Any:
    """A plain colour shader under the name this version knows (the 3D_ prefix went in 4.0)."""
    try:
        return gpu.shader.from_builtin("UNIFORM_COLOR")
    except (ValueError, SystemError):
        return gpu.shader.from_builtin("3D_UNIFORM_COLOR")


# Pixels of a sidebar's width that its tabs and its panels' margins take, before the interface is scaled.
SIDEBAR_MARGINS = 52 if bpy.app.version >= (5, 0, 0) else 30


def progress_bar(layout: Any, fraction: float, text: str) -> None:
    """In a panel; words alone before 4.0."""
    if hasattr(layout, "progress"):
        layout.progress(factor=fraction, text=text)
    else:
        layout.label(text=text, icon="TIME")


def has_cli_commands() -> bool:
    return hasattr(bpy.utils, "register_cli_command")


def lamps_as_before_4() -> bool:
    """Whether Cycles gives lamps what it gave before 4.0: area lamps a quarter of pi of what their watts say, spots fainter by the cosine
    off their axis. Measured on 3.4, 4.3 and 5.2."""
    return bpy.app.version < (4, 0, 0)


def power_of(data: bpy.types.Light) -> Any:
    """Red, green and blue of a lamp's energy, float64 (3,); exposure and colour temperature came with 4.5."""
    import numpy as np

    power = np.array(data.color[:3], dtype=np.float64) * float(data.energy) * 2.0 ** float(getattr(data, "exposure", 0.0))
    return power * np.array(data.temperature_color[:3]) if getattr(data, "use_temperature", False) else power


def corner_normals(mesh: Any) -> Any:
    """Shading normals of the corners of the mesh's triangles, float32 (triangles, 3, 3); None where every face is flat.
    Up to 4.0 they are made on demand."""
    import numpy as np

    smooth = np.empty(len(mesh.polygons), dtype=bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    if not smooth.any():
        return None
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
    normals = np.empty(9 * len(mesh.loop_triangles), np.float32)
    mesh.loop_triangles.foreach_get("split_normals", normals)
    return normals.reshape(-1, 3, 3)
