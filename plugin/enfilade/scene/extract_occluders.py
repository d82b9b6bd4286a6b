# SPDX-License-Identifier: GPL-3.0-or-later
"""What blocks sight, of objects that the user marked so: custom property `enfilade_occluder` = 1 (its faces) or "box" (all of
its bounds is solid).

Only what surely blocks is taken: an object that is animated, drawn several times, not rendered, without camera rays, see-through by its
material, or of another shape in renders than in the viewport, blocks nothing.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..rules.building import INFO, Object, Problem

PROPERTY = "enfilade_occluder"
MOST_POLYGONS = 400  # of one object, its largest: a few large ones do nearly all the hiding
MOST_CORNERS = 64  # the core's limit
LEAST_SHARE = 1e-3  # of the object's largest polygon: smaller ones cover no pixel of the depth buffer whole


def marked(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    return [o for o in scene.objects if o.get(PROPERTY)]


def extract(depsgraph: bpy.types.Depsgraph, objects: list[Object], changes_shape) -> list[Problem]:
    """Gives the marked ones of `objects` their occluders. changes_shape(object): why its render may differ, or a margin."""
    wanted = {o.name_full: o for o in marked(depsgraph.scene)}
    if not wanted:
        return []
    drawn: dict[str, list[Object]] = {}
    for item in objects:
        drawn.setdefault(item.source_id, []).append(item)
    problems = []
    for name, obj in wanted.items():
        items = drawn.get(name, [])
        reason = _reason(obj, changes_shape) or ("" if len(items) == 1 else "it is drawn several times, or not at all")
        polygons = None if reason else _polygons(depsgraph, obj)
        if not reason and not polygons:
            reason = "it has no faces"
        if reason:
            problems.append(Problem(INFO, "occluder-left-out", f"{name} doesn't count as an occluder: {reason}.", [name],
                                    remedy="Take its property enfilade_occluder away, or change what is named."))
        else:
            items[0].occluder = "box" if obj[PROPERTY] == "box" else polygons
    return problems


def _reason(obj: bpy.types.Object, changes_shape) -> str:
    if obj.type != "MESH":
        return "only meshes do"
    if obj.hide_render or not obj.visible_camera:
        return "renders don't show it"
    if obj.display_type in {"BOUNDS", "WIRE"}:
        return "the 3D view shows it as wires"
    if obj.animation_data is not None or obj.parent is not None and _moves(obj.parent) or obj.constraints:
        return "it may move"
    if changes_shape(obj) or any(m.show_viewport != m.show_render for m in obj.modifiers):
        return "renders may show another shape than the 3D view"
    for slot in obj.material_slots:
        if slot.material is not None and _seen_through(slot.material):
            return f"one sees through its material {slot.material.name}"
    return ""


def _moves(obj: bpy.types.Object | None) -> bool:
    while obj is not None:
        if obj.animation_data is not None or obj.constraints:
            return True
        obj = obj.parent
    return False


def _seen_through(material: bpy.types.Material) -> bool:
    """Glass, and whatever may let light through: transparency that a texture decides counts."""
    tree = material.node_tree if material.use_nodes else None
    if tree is None:
        return False
    for node in tree.nodes:
        if node.type in {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_TRANSPARENT", "HOLDOUT", "GROUP", "SCRIPT", "PRINCIPLED_VOLUME"}:
            return True
        if node.type == "BSDF_PRINCIPLED":
            for name, opaque in (("Alpha", 1.0), ("Transmission", 0.0), ("Transmission Weight", 0.0)):
                socket = node.inputs.get(name)
                if socket is not None and (socket.is_linked or abs(float(socket.default_value) - opaque) > 1e-6):
                    return True
        if node.type == "OUTPUT_MATERIAL" and node.inputs["Displacement"].is_linked:
            return True
    return False


def _polygons(depsgraph: bpy.types.Depsgraph, obj: bpy.types.Object) -> list[np.ndarray]:
    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        areas = np.empty(len(mesh.polygons), dtype=np.float32)
        mesh.polygons.foreach_get("area", areas)
        order = np.argsort(-areas, kind="stable")[:MOST_POLYGONS]
        order = [int(i) for i in order if areas[i] > LEAST_SHARE * areas.max()] if len(areas) else []
        points = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        mesh.vertices.foreach_get("co", points.reshape(-1))
        matrix = np.array(evaluated.matrix_world, dtype=np.float64)
        world = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        faces = [np.array(mesh.polygons[i].vertices[:], dtype=np.int64) for i in order]
        return [world[f] for f in faces if 3 <= len(f) <= MOST_CORNERS]
    finally:
        evaluated.to_mesh_clear()
