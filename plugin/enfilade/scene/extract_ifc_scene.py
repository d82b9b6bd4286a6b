# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that an IFC add-on loaded (`IfcSpace/Hall`, collections `IfcBuildingStorey/Level 1`) to `rules.ifc_scene.Piece`.

Meshes are read as they are, hidden ones too: spaces are hidden as a rule. Neither the file nor the add-on is needed.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..rules import ifc_scene
from .import_ifc import GLOBAL_ID, OFFSET

_STOREY = "IfcBuildingStorey/"


def has_spaces(scene: bpy.types.Scene) -> bool:
    return any(o.type == "MESH" and o.name.startswith("IfcSpace/") for o in scene.objects)


def pieces(scene: bpy.types.Scene) -> list[ifc_scene.Piece]:
    """Spaces, voids, doors, windows and what can close a room off, by name."""
    storeys: dict[str, str] = {}
    for collection in scene.collection.children_recursive:
        if collection.name.startswith(_STOREY):
            for obj in collection.all_objects:
                storeys[obj.name_full] = _plain(collection.name[len(_STOREY) :])
    found = []
    for obj in sorted(scene.objects, key=lambda o: o.name_full):
        if obj.type != "MESH" or not ifc_scene.is_wanted(obj.name):
            continue
        mesh = obj.data
        local = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", local)
        materials = tuple(s.material.name for s in obj.material_slots if s.material is not None)
        found.append(
            ifc_scene.Piece(
                obj.name_full, local.reshape(-1, 3).astype(np.float64), [list(p.vertices) for p in mesh.polygons],
                world_matrix(obj), storeys.get(obj.name_full, ""), materials, str(obj.get(GLOBAL_ID, "")),
            )
        )  # fmt: skip
    return found


def storeys(scene: bpy.types.Scene) -> list[tuple[str, float]]:
    """Names and elevations of the objects that stand for storeys, ascending."""
    found = [(_plain(o.name[len(_STOREY) :]), float(world_matrix(o)[2, 3])) for o in scene.objects if o.name.startswith(_STOREY)]
    return sorted(found, key=lambda s: s[1])


def placements(scene: bpy.types.Scene) -> dict[str, np.ndarray]:
    """World matrices by name of what another add-on loaded; {} where we did, or nothing is loaded."""
    if OFFSET in scene:
        return {}
    return {o.name: world_matrix(o) for o in scene.objects if o.type == "MESH" and o.name.startswith("Ifc") and "/" in o.name}


def world_matrix(obj: bpy.types.Object) -> np.ndarray:
    """float64 (4, 4). Of an object in an excluded collection too: nothing has worked it out since the file was opened."""
    own = obj.matrix_basis if obj.parent is None else obj.matrix_local
    matrix = np.array(own, dtype=np.float64)
    return matrix if obj.parent is None else world_matrix(obj.parent) @ matrix


def _plain(name: str) -> str:
    """Without the number that Blender adds to a name that is taken."""
    stem, dot, tail = name.rpartition(".")
    return stem if dot and len(tail) == 3 and tail.isdigit() else name
