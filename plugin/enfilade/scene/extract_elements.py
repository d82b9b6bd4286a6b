# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's drawn meshes as elements for the search by geometry: triangles in world metres, and the class that names tell.

The class comes from the object's name, else from its collections', else from its mesh's; what hides (marks, hidden objects) is no element.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..rules.geometry_elements import HOLE, UNKNOWN, Element, kind_of

_SURFACES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


def extract(depsgraph: bpy.types.Depsgraph, ignored: set[str]) -> list[Element]:
    """Every mesh that renders, instances apart. ignored: full names of objects that are no scenery."""
    found: list[Element] = []
    meshes: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for instance in depsgraph.object_instances:
        obj = instance.object
        owner = instance.parent.original if instance.is_instance and instance.parent else obj.original
        if obj.type not in _SURFACES or owner.name_full in ignored or obj.original.name_full in ignored:
            continue
        key = obj.original.name_full
        if key not in meshes:
            meshes[key] = _triangles(obj, depsgraph)
        local, triangles = meshes[key]
        if not len(triangles):
            continue
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        kind = _kind(obj.original)
        world = local @ matrix[:3, :3].T + matrix[:3, 3]
        found.append(Element(obj.original.name, kind, world, triangles, owner.name_full))
    return found


def _triangles(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[np.ndarray, np.ndarray]:
    evaluated = obj if obj.is_evaluated else obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        if mesh is None:
            return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        mesh.calc_loop_triangles()
        vertices = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        return vertices.reshape(-1, 3).astype(np.float64), triangles.reshape(-1, 3).astype(np.int64)
    finally:
        evaluated.to_mesh_clear()


def _kind(obj: bpy.types.Object) -> str:
    names = [obj.name, *(c.name for c in obj.users_collection), obj.data.name if obj.data is not None else ""]
    for name in names:
        kind = kind_of(name)
        if kind == HOLE:
            continue  # a drawn thing isn't a void
        if kind != UNKNOWN:
            return kind
    return UNKNOWN
