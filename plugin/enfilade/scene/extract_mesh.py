# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's drawn objects and lights to `rules.building` entries.

Goes through the dependency graph's instances, so collections, vertex instancers and geometry nodes are included; what
the result names (`source_id`) is always the object in the file, since that is what can be switched off.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from ..rules.building import INFO, WARNING, Light, Object, Problem
from ..rules.instances import box_corners, group_boxes
from . import extract_occluders
from .extract_materials import light_form

DRAWN = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "HAIR", "POINTCLOUD", "VOLUME", "GPENCIL", "GREASEPENCIL"}


@dataclass
class Drawn:
    objects: list[Object] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)  # drawn, but never culled, with the reason in a problem


def unsure_bounds(obj: bpy.types.Object) -> str:
    """Why the bounds that the viewport knows may be smaller than what a render draws; "" when they hold."""
    for modifier in obj.modifiers:
        if modifier.show_render and not modifier.show_viewport:
            return f"its modifier {modifier.name} is rendered but not shown in the viewport"
    for system in obj.particle_systems:
        if system.settings.render_type not in {"NONE"}:
            return f"its particle system {system.name} reaches beyond its bounds"
    for slot in obj.material_slots:
        material = slot.material
        if material is None:
            continue
        method = getattr(material, "displacement_method", None)
        if method is None:
            settings = getattr(material, "cycles", None)
            method = getattr(settings, "displacement_method", "BUMP")
        if method != "BUMP":
            return f"its material {material.name} displaces the surface"
    return ""


def _margin(obj: bpy.types.Object) -> float:
    """Part of the bounds' diagonal to add: a subdivision surface at render level may leave the viewport level's bounds
    where its limit surface is used; a quarter is more than any Catmull-Clark surface can move. Curves and metaballs that
    render at another resolution bulge by less than a tenth."""
    data = obj.data
    for name, shown in (("render_resolution_u", "resolution_u"), ("render_resolution_v", "resolution_v"),
                        ("render_resolution", "resolution")):
        finer = getattr(data, name, 0)
        if finer and finer != getattr(data, shown, finer):
            return 0.1
    if getattr(getattr(obj, "cycles", None), "use_adaptive_subdivision", False):
        return 0.25
    for modifier in obj.modifiers:
        if modifier.type in {"SUBSURF", "MULTIRES"} and modifier.render_levels != modifier.levels:
            return 0.25
    return 0.0


def extract(depsgraph: bpy.types.Depsgraph, ignored: set[str]) -> Drawn:
    """Everything drawn in the depsgraph's view layer. `ignored`: full names of annotation objects, which are no scenery."""
    out = Drawn()
    scene = depsgraph.scene
    local: dict[int, np.ndarray] = {}
    order: dict[str, int] = {}
    boxes: list[list[np.ndarray]] = []
    matrices: list[list[tuple]] = []
    meshes: list[str] = []
    unsure: dict[str, str] = {}
    for instance in depsgraph.object_instances:
        obj = instance.object
        kind = obj.type
        if kind == "LIGHT":
            name = (instance.parent if instance.is_instance else obj).original.name_full
            matrix = np.array(instance.matrix_world, dtype=np.float64)
            out.lights.append(Light(name, matrix[:3, 3], obj.data.type, light_form(obj.data, matrix)))
            continue
        if kind not in DRAWN:
            continue
        owner = instance.parent.original if instance.is_instance and instance.parent else obj.original
        name = owner.name_full
        if name in ignored or obj.original.name_full in ignored:
            continue
        if name in unsure:
            continue
        source = obj.original
        pointer = source.as_pointer() if kind != "META" else 0
        box = local.get(pointer)
        if box is None or kind == "META":
            reason = unsure_bounds(source)
            if reason:
                unsure[name] = reason
                continue
            corners = np.array(obj.bound_box, dtype=np.float64)
            box = np.stack([corners.min(axis=0), corners.max(axis=0)])
            grow = _margin(source)
            if grow:
                reach = grow * float(np.linalg.norm(box[1] - box[0]))
                box = box + np.array([[-reach], [reach]])
            local[pointer] = box
        index = order.get(name)
        if index is None:
            index = order[name] = len(boxes)
            boxes.append([])
            matrices.append([])
            data = source.data
            meshes.append(data.name_full if data is not None else "")
        boxes[index].append(box)
        matrices[index].append(tuple(tuple(row) for row in instance.matrix_world))

    singles = [i for i in range(len(boxes)) if len(boxes[i]) == 1]
    world: dict[int, np.ndarray] = {}
    if singles:
        flat = box_corners(np.array([boxes[i][0] for i in singles]), np.array([matrices[i][0] for i in singles], dtype=np.float64))
        world = dict(zip(singles, flat, strict=True))
    for name, i in order.items():
        if name in unsure:
            continue
        if i in world:
            if np.isfinite(world[i]).all():
                out.objects.append(Object(name, world[i], source_id=name, mesh=meshes[i]))
            else:
                unsure[name] = "its bounds are not finite"
            continue
        groups = group_boxes(box_corners(np.array(boxes[i]), np.array(matrices[i], dtype=np.float64)))
        for n, union in enumerate(groups):
            label = name if len(groups) == 1 else f"{name} [{n + 1}/{len(groups)}]"
            out.objects.append(Object(label, union, source_id=name, mesh=meshes[i]))
    out.problems += extract_occluders.extract(depsgraph, out.objects, lambda obj: unsure_bounds(obj) or _margin(obj))
    out.kept = sorted(unsure)
    for name, reason in sorted(unsure.items()):
        out.problems.append(
            Problem(INFO, "object-always-kept", f"{name} is always kept: {reason}.", [name],
                    remedy="Apply or show it in the viewport to have it culled.")
        )
    seen = set(order) | set(unsure)
    missing = [
        o.name_full
        for o in depsgraph.view_layer.objects
        if o.type in DRAWN and not o.hide_render and o.name_full not in seen and o.name_full not in ignored
    ]
    if missing:
        shown = ", ".join(sorted(missing)[:3]) + (" ..." if len(missing) > 3 else "")
        out.problems.append(
            Problem(
                WARNING,
                "hidden-in-viewport",
                f"{len(missing)} objects of {scene.name} are rendered but hidden in the viewport ({shown}); they are always kept.",
                sorted(missing)[:20],
                remedy="Show them in the viewport, or switch their rendering off too.",
            )
        )
        out.kept += sorted(missing)
    return out
