# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes as they are drawn, of the objects that are asked for and no others, as the core's triangles; and the lights.

Walls come as somebody modelled them, not as the cells have them: a preview shows the building, and its depth is Cycles'.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ..compat import corner_normals
from .extract_materials import describe, describe_light

MESHES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


@dataclass
class Drawn:
    triangles: Any  # enfilade_native.Triangles, committed
    names: list[str] = field(default_factory=list)  # object number -> full name of the object drawn
    skipped: int = 0  # objects that weren't asked for
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)
    soup: list[np.ndarray] = field(default_factory=list)  # with keep: opaque triangles as added, float64 (n, 3, 3)


def rendered(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> set[str]:
    """Full names of the objects that a render draws: hidden in renders neither themselves nor by all their collections."""
    shown: set[str] = set()

    def walk(layer: bpy.types.LayerCollection, hidden: bool) -> None:
        hidden = hidden or layer.exclude or layer.collection.hide_render
        if not hidden:
            shown.update(o.name_full for o in layer.collection.objects if not o.hide_render)
        for child in layer.children:
            walk(child, hidden)

    walk(view_layer.layer_collection, False)
    return shown


def helpers(scene: bpy.types.Scene) -> set[str]:
    """Marks of rooms and openings, and what IFC draws only to say where something is: no scenery, as in detection."""
    from . import detect, extract_annotated

    found = set(extract_annotated.find_marks(scene).ignored)
    return found | {o.name_full for o in scene.objects if o.name.startswith(detect.SPATIAL)}


@dataclass
class _Mesh:
    vertices: np.ndarray  # float64 (n, 3), local
    corners: np.ndarray  # uint32 (m, 3)
    slots: np.ndarray  # int32 (m,)
    normals: np.ndarray | None  # float32 (m, 3, 3)


def _read(obj: bpy.types.Object, smooth: bool) -> _Mesh | None:
    try:
        mesh = obj.to_mesh()
    except RuntimeError:
        return None
    if mesh is None:
        return None
    try:
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        if count == 0:
            return None
        vertices = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", vertices)
        corners = np.empty(3 * count, np.int32)
        mesh.loop_triangles.foreach_get("vertices", corners)
        slots = np.empty(count, np.int32)
        mesh.loop_triangles.foreach_get("material_index", slots)
        return _Mesh(vertices.astype(np.float64).reshape(-1, 3), corners.astype(np.uint32).reshape(-1, 3), slots,
                     corner_normals(mesh) if smooth else None)
    finally:
        obj.to_mesh_clear()


def extract(native: Any, depsgraph: bpy.types.Depsgraph, wanted: set[str] | None, origin: np.ndarray, ignored: set[str] = frozenset(),
            smooth: bool = True, keep: bool = False) -> Drawn:
    """wanted: full names of objects (instancers stand for what they instance); None: all that is drawn. smooth: with shading
    normals. keep: gives the triangles themselves too. The depsgraph must be of the scene's active view layer."""
    begin = time.perf_counter()
    scene, layer = depsgraph.scene, depsgraph.view_layer
    shown = rendered(scene, layer)
    triangles = native.Triangles(origin)
    out = Drawn(triangles)
    meshes: dict[int, _Mesh | None] = {}
    materials: dict[str, int] = {}
    numbers: dict[str, int] = {}
    clear: set[int] = set()
    broken: list[str] = []
    for instance in depsgraph.object_instances:
        obj = instance.object
        if obj.type not in MESHES:
            continue
        owner = instance.parent.original if instance.is_instance and instance.parent else obj.original
        if owner.name_full not in shown or owner.name_full in ignored or obj.original.name_full in ignored or obj.original.hide_render:
            continue
        if instance.is_instance and not instance.show_self:
            continue
        if wanted is not None and owner.name_full not in wanted:
            out.skipped += 1
            continue
        key = obj.original.as_pointer() if obj.type != "META" else obj.as_pointer()
        if key not in meshes:
            meshes[key] = _read(obj, smooth)
        mesh = meshes[key]
        if mesh is None:
            continue
        name = obj.original.name_full
        number = numbers.setdefault(name, len(numbers))
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        table = _materials(native, triangles, obj, materials, clear)
        normals = None
        if mesh.normals is not None:
            try:
                normals = mesh.normals @ np.linalg.inv(matrix[:3, :3]).astype(np.float32)  # rows: (inverse transposed) n
                normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
            except np.linalg.LinAlgError:
                normals = None
        world = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        kinds = table[np.clip(mesh.slots, 0, len(table) - 1)]
        if keep:
            out.soup.append(world[mesh.corners[~np.isin(kinds, list(clear))]])
        try:
            triangles.add_mesh(number, world, mesh.corners, kinds, normals)
        except native.EnfError:
            broken.append(name)
    out.names = [""] * len(numbers)
    for name, number in numbers.items():
        out.names[number] = name
    if broken:
        out.notes.append(f"{len(broken)} objects have coordinates that aren't numbers and aren't drawn: {', '.join(broken[:3])}")
    triangles.commit()
    out.seconds = time.perf_counter() - begin
    return out


def _materials(native: Any, triangles: Any, obj: bpy.types.Object, known: dict[str, int], clear: set[int]) -> np.ndarray:
    """Material numbers of the object's slots, uint32 (slots,); at least one. Those not there for any ray go into `clear`."""
    out = []
    for slot in obj.material_slots:
        name = slot.material.name_full if slot.material is not None else ""
        if name not in known:
            material = _finite(native, describe(slot.material.original if slot.material else None))
            known[name] = triangles.add_material(material)
            if material.kind == "clear":
                clear.add(known[name])
        out.append(known[name])
    if not out:
        if "" not in known:
            known[""] = triangles.add_material(native.Material(**describe(None)))
        out.append(known[""])
    return np.array(out, dtype=np.uint32)


def _finite(native: Any, described: dict) -> Any:
    """Colours may hold anything: what isn't a number is black, what is below nothing is nothing."""
    for key in ("colour", "emission"):
        if key in described:
            described[key] = tuple(float(v) for v in np.clip(np.nan_to_num(described[key], posinf=1e6, neginf=0.0), 0.0, 1e6))
    described["colour"] = tuple(min(1.0, v) for v in described["colour"])
    return native.Material(**described)


def lights(native: Any, depsgraph: bpy.types.Depsgraph) -> list[Any]:
    """Lights that a render uses."""
    shown = rendered(depsgraph.scene, depsgraph.view_layer)
    found = []
    for instance in depsgraph.object_instances:
        obj = instance.object
        owner = instance.parent.original if instance.is_instance and instance.parent else obj.original
        if obj.type != "LIGHT" or owner.name_full not in shown:
            continue
        described = describe_light(obj.data, np.array(instance.matrix_world, dtype=np.float64))
        if described is not None:
            found.append(native.Light(**described))
    return found
