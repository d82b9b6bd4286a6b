# SPDX-License-Identifier: GPL-3.0-or-later
"""Brings what an IFC file draws into Blender: one object a product, instances sharing meshes, a collection a storey.

Works without Bonsai and names things as Bonsai does (`IfcDoor/D01`, collections `IfcBuildingStorey/Level 1`), so that
everything downstream treats both alike. Spaces and voids are not drawn: they become the rooms.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ..rules import ifc, ifc_elements, ifc_placement, ifc_shapes, ifc_units

GLOBAL_ID = "enfilade_global_id"  # on objects: the product's GlobalId, joins them with Building.objects
SOURCE = "enfilade_ifc_path"  # on the scene: the file it was read from
OFFSET = "enfilade_ifc_offset"  # on the scene: what was taken off the file's coordinates, metres
POSE = "enfilade_ifc_pose"  # on the scene: `Pose.numbers`, where another add-on put the model
LACKS = "enfilade_ifc_lacks"  # on the scene: the part of what the file draws that wasn't brought in yet


@dataclass
class Drawn:
    """What a file draws, read and not yet in a scene."""

    path: str
    part: str
    offset: np.ndarray  # float64 (3,), metres, taken off the file's coordinates
    project: str
    storeys: list[str]
    shapes: list[tuple[ifc_shapes.Shape, str]] = field(default_factory=list)  # with the storey's name, "" for none


def read(
    path: str | os.PathLike[str], *, model: Any = None, part: str = ifc_elements.ALL, progress: ifc_shapes.Progress | None = None
) -> Drawn:
    """part: all, or what is built first (BUILT) and the REST when it is needed (`complete`). Touches no Blender data.

    Coordinates are those of `read_ifc(..., local=True)`: whole kilometres are taken off models on a national grid, since
    Blender's 32-bit vertices would jitter there.
    """
    model = model if model is not None else ifc.open_model(path)
    unit = ifc_units.length_unit(model)
    offset = ifc_placement.model_offset(model, unit)
    names = {step: name for step, name, _ in ifc_placement.storeys(model, unit)}
    project = next(iter(model.by_type("IfcProject")), None)
    out = Drawn(os.fspath(path), part, offset, str(project.Name if project else None), list(dict.fromkeys(names.values())))
    for shape in ifc_elements.shapes(model, offset, materials=True, progress=progress, part=part):
        out.shapes.append((shape, ifc_placement.storey_of(shape.product, names)))
    return out


def put(scene: bpy.types.Scene, drawn: Drawn) -> list[bpy.types.Object]:
    """Makes the objects."""
    top = _collection(scene.collection, f"IfcProject/{drawn.project}")
    shelves = {name: _collection(top, f"IfcBuildingStorey/{name}") for name in drawn.storeys}
    meshes: dict[str, bpy.types.Mesh] = {}
    materials: dict[tuple, bpy.types.Material] = {}
    made = []
    for shape, storey in drawn.shapes:
        if shape.mesh not in meshes:
            meshes[shape.mesh] = _mesh(shape, materials)
        thing = bpy.data.objects.new(ifc_elements.object_name(shape.product), meshes[shape.mesh])
        thing.matrix_world = Matrix(shape.matrix.tolist())  # a bare list would be taken column by column
        thing[GLOBAL_ID] = shape.product.GlobalId
        shelves.get(storey, top).objects.link(thing)
        made.append(thing)
    scene[SOURCE] = drawn.path
    scene[OFFSET] = [float(x) for x in drawn.offset]
    scene.unit_settings.system = "METRIC"
    if drawn.part == ifc_elements.BUILT:
        scene[LACKS] = ifc_elements.REST
    elif LACKS in scene:
        del scene[LACKS]
    return made


def complete(scene: bpy.types.Scene, progress: ifc_shapes.Progress | None = None) -> list[bpy.types.Object]:
    """Brings in what was left in the file (furniture); nothing where all is there. Raises what `open_model` raises."""
    if LACKS not in scene:
        return []
    return put(scene, read(bpy.path.abspath(str(scene[SOURCE])), part=str(scene[LACKS]), progress=progress))


def _collection(parent: bpy.types.Collection, name: str) -> bpy.types.Collection:
    """The parent's child of that name; made where there is none."""
    for child in parent.children:
        if child.name == name:
            return child
    made = bpy.data.collections.new(name)
    parent.children.link(made)
    return made


def _mesh(shape: ifc_shapes.Shape, materials: dict[tuple, bpy.types.Material]) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(f"{shape.product.is_a()}/{shape.mesh}"[:60])
    count = len(shape.triangles)
    mesh.vertices.add(len(shape.local))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(shape.local, dtype=np.float32).reshape(-1))
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(shape.triangles, dtype=np.int32).reshape(-1))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    if bpy.app.version < (3, 6, 0):  # later versions derive it, and make it read-only
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, dtype=np.int32))
    for entry in shape.materials:
        mesh.materials.append(_material(entry, materials))
    if shape.material_of is not None and len(shape.materials) > 1:
        mesh.polygons.foreach_set("material_index", np.maximum(shape.material_of, 0).astype(np.int32))
    mesh.update(calc_edges=True)
    mesh.validate()
    return mesh


def _material(entry: tuple, materials: dict[tuple, bpy.types.Material]) -> bpy.types.Material:
    if entry in materials:
        return materials[entry]
    name, rgb, alpha = entry
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*rgb, alpha)
    made.use_nodes = True
    principled = next((n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
    if principled is not None:
        principled.inputs["Base Color"].default_value = (*rgb, 1.0)
        principled.inputs["Alpha"].default_value = alpha
    materials[entry] = made
    return made
