# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that an IFC add-on loaded (`IfcSpace/Hall`, collections `IfcBuildingStorey/Level 1`) to `rules.ifc_scene.Piece`.

Meshes are read as they are, hidden ones too: spaces are hidden as a rule. Neither the file nor the add-on is needed.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..rules import ifc_scene
from .import_ifc import GLOBAL_ID

_STOREY = "IfcBuildingStorey/"


def has_spaces(scene: bpy.types.Scene) -> bool:
    return any(o.type == "MESH" and o.name.startswith("IfcSpace/") for o in scene.objects)


def pieces(scene: bpy.types.Scene) -> list[ifc_scene.Piece]:
    """Spaces, voids, doors, windows and what can close a room off, by name."""
    wanted = (*ifc_scene.SPACES, *ifc_scene.FILLERS, *ifc_scene.VOIDS, *ifc_scene.SHELL)
    storeys: dict[str, str] = {}
    for collection in scene.collection.children_recursive:
        if collection.name.startswith(_STOREY):
            for obj in collection.all_objects:
                storeys[obj.name_full] = _plain(collection.name[len(_STOREY) :])
    found = []
    for obj in sorted(scene.objects, key=lambda o: o.name_full):
        if obj.type != "MESH" or not obj.name.startswith(wanted) or "/" not in obj.name:
            continue
        mesh = obj.data
        local = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", local)
        materials = tuple(s.material.name for s in obj.material_slots if s.material is not None)
        found.append(
            ifc_scene.Piece(
                obj.name_full, local.reshape(-1, 3).astype(np.float64), [list(p.vertices) for p in mesh.polygons],
                np.array(obj.matrix_world, dtype=np.float64), storeys.get(obj.name_full, ""), materials,
                str(obj.get(GLOBAL_ID, "")),
            )
        )  # fmt: skip
    return found


def _plain(name: str) -> str:
    """Without the number that Blender adds to a name that is taken."""
    stem, dot, tail = name.rpartition(".")
    return stem if dot and len(tail) == 3 and tail.isdigit() else name
