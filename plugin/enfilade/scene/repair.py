# SPDX-License-Identifier: GPL-3.0-or-later
"""Offers to mend the meshes of marked rooms and openings, and does so when asked. Fixes stand in `rules/repair.py`."""

from __future__ import annotations

import bpy
import numpy as np

from ..rules import repair
from ..rules.annotated import EXTERIOR
from . import extract_annotated


def offers(scene: bpy.types.Scene, tolerance: float = repair.TOLERANCE) -> list[repair.Fix]:
    """The next fix of every marked mesh that isn't sound, in the order of their names."""
    marks = extract_annotated.find_marks(scene)
    found = []
    for name, role in sorted(marks.objects.items()):
        obj = scene.objects.get(name)
        if role == EXTERIOR or obj is None or obj.type != "MESH":
            continue
        vertices, faces = _mesh(obj)
        fix = repair.offer(obj.name_full, vertices, faces, tolerance)
        if fix is not None:
            found.append(fix)
    return found


def refusal(obj: bpy.types.Object | None) -> str:
    """Why an object's mesh can't be mended here; "" when it can."""
    if obj is None:
        return "the object is gone"
    if obj.library is not None or obj.data.library is not None:
        return "it comes from a linked file"
    if obj.modifiers:
        return "it has modifiers: apply them first"
    if obj.data.users > 1:
        return "other objects share its mesh: make it single-user first"
    if obj.data.shape_keys is not None:
        return "it has shape keys: remove them first"
    if obj.mode != "OBJECT":
        return "it is being edited: leave edit mode first"
    return ""


def apply(scene: bpy.types.Scene, fix: repair.Fix) -> str:
    """Puts the mended mesh in place; returns why not, "" when done. Materials stay; undo is the caller's."""
    obj = scene.objects.get(fix.name)
    reason = refusal(obj)
    if reason:
        return reason
    inverse = np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64))
    local = fix.vertices @ inverse[:3, :3].T + inverse[:3, 3]
    mesh = obj.data
    faces = fix.faces
    if np.linalg.det(inverse[:3, :3]) < 0.0:  # a mirrored object shows its faces the other way round
        faces = [face[::-1] for face in faces]
    mesh.clear_geometry()
    mesh.from_pydata(local.tolist(), [], faces)
    mesh.update()
    return ""


def apply_all(
    scene: bpy.types.Scene, kinds: set[str], tolerance: float = repair.TOLERANCE
) -> tuple[list[repair.Fix], list[tuple[str, str]]]:
    """Applies fixes of these kinds until none is left; returns what was done, and (object, why) of what couldn't be."""
    done: list[repair.Fix] = []
    refused: dict[str, str] = {}
    for _ in range(2 * len(repair.KINDS)):  # each object needs one of each at most, and one may call for another
        pending = [f for f in offers(scene, tolerance) if f.kind in kinds and f.name not in refused]
        if not pending:
            break
        for fix in pending:
            reason = apply(scene, fix)
            if reason:
                refused[fix.name] = reason
            else:
                done.append(fix)
    return done, sorted(refused.items())


def _mesh(obj: bpy.types.Object) -> tuple[np.ndarray, list[list[int]]]:
    """The object's own mesh in world coordinates, mirrored ones turned right."""
    mesh = obj.data
    local = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", local)
    matrix = np.array(obj.matrix_world, dtype=np.float64)
    world = local.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    faces = [list(p.vertices) for p in mesh.polygons]
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        faces = [face[::-1] for face in faces]
    return world, faces
