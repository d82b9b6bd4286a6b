# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks in a Blender scene (custom properties, names, collections) to `rules.annotated.Shape`.

Two passes: `find_marks` looks at names and properties only; geometry is read for what is marked and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Vector

from ..rules.annotated import EXTERIOR, IGNORE, ROLES, ROOM, Shape, role_of
from ..rules.building import WARNING, Problem
from .collections import members, own_objects, tree_of

PROPERTY = "enfilade"
_CUBE = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


@dataclass
class Marks:
    objects: dict[str, str] = field(default_factory=dict)  # full name -> role
    collections: dict[str, str] = field(default_factory=dict)
    ignored: set[str] = field(default_factory=set)  # full names of objects that are no scenery
    problems: list[Problem] = field(default_factory=list)

    @property
    def rooms(self) -> int:
        roles = [*self.objects.values(), *self.collections.values()]
        return roles.count(ROOM)


def find_marks(scene: bpy.types.Scene) -> Marks:
    marks = Marks()

    def read(item, names: bool) -> str:
        value = item.get(PROPERTY)
        if value is not None and not isinstance(value, str):
            value = None  # somebody else's data under our name
        role = role_of(item.name if names else "", value)
        if value and not role:
            marks.problems.append(
                Problem(
                    WARNING,
                    "unknown-mark",
                    f'{item.name}: enfilade = "{value}" is none of {", ".join(ROLES)}; ignored.',
                    [item.name],
                    _place(item),
                    remedy="Correct or remove the custom property.",
                )
            )
        return role

    tree = tree_of(scene)
    ours = members(tree)
    own = {o.name_full for o in own_objects(tree)}
    for collection in scene.collection.children_recursive:
        if collection.name_full in ours:
            continue
        role = read(collection, True)
        if role == IGNORE:
            marks.ignored.update(o.name_full for o in collection.all_objects)
        elif role in (ROOM, EXTERIOR):
            marks.collections[collection.name_full] = role
        elif role:
            marks.collections[collection.name_full] = role
            marks.ignored.update(o.name_full for o in collection.all_objects)
    for obj in scene.objects:
        if obj.name_full in own:
            marks.ignored.add(obj.name_full)
            continue
        if obj.instance_type == "COLLECTION" and obj.instance_collection is not None:
            _instanced(obj, scene, read, marks)
        # Lights, cameras and empties named Room_... are no shapes: only what has faces counts by name.
        role = read(obj, obj.type == "MESH")
        if not role:
            continue
        marks.ignored.add(obj.name_full)
        if role != IGNORE:
            marks.objects[obj.name_full] = role
    for name in list(marks.collections):
        if marks.collections[name] == ROOM:
            bound = _bound(bpy.data.collections[name] if name in bpy.data.collections else None)
            if bound is not None:
                marks.ignored.add(bound.name_full)
    return marks


def _instanced(instancer: bpy.types.Object, scene: bpy.types.Scene, read, marks: Marks) -> None:
    """Marks that only an instance shows are read nowhere: tells so."""
    here = scene.objects
    lost = [o.name for o in instancer.instance_collection.all_objects if o.name not in here and read(o, o.type == "MESH") not in ("", IGNORE)]
    if lost:
        marks.problems.append(
            Problem(WARNING, "marks-in-instance", f"{instancer.name} shows {len(lost)} marked objects ({', '.join(lost[:3])}) of another collection: "
                    "they are read as drawn things alone.", [instancer.name], _place(instancer),
                    "Object > Apply > Make Instances Real, or link the collection itself into the scene.")
        )  # fmt: skip


def _bound(collection: bpy.types.Collection | None) -> bpy.types.Object | None:
    if collection is None:
        return None
    return next((o for o in collection.all_objects if o.name.startswith("Bound") and o.type == "MESH"), None)


def read_shapes(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, marks: Marks) -> list[Shape]:
    """Shapes in a stable order (by name), geometry as evaluated, in world coordinates."""
    objects = {o.name_full: o for o in scene.objects}
    shapes: list[Shape] = []
    for name, role in sorted(marks.objects.items()):
        obj = objects[name]
        shapes.append(_shape(obj, role, *_mesh(obj, depsgraph)))
    for collection in sorted(scene.collection.children_recursive, key=lambda c: c.name_full):
        role = marks.collections.get(collection.name_full)
        if role is None:
            continue
        if role == EXTERIOR:
            shapes.append(Shape(collection.name, EXTERIOR, np.zeros((0, 3)), source_id=collection.name_full))
            continue
        bound = _bound(collection)
        if bound is not None:
            vertices, faces = _mesh(bound, depsgraph)
        else:
            own = [o for o in collection.all_objects if o.type == "MESH"]
            if role == ROOM:
                own = [o for o in own if o.name_full not in marks.ignored]
            points = [_mesh(o, depsgraph)[0] for o in own]
            vertices, faces = hull(np.concatenate(points) if points else np.zeros((0, 3)))
        shapes.append(_shape(collection, role, vertices, faces))
    return shapes


def _shape(item, role: str, vertices: np.ndarray, faces) -> Shape:
    rooms = item.get("enfilade_rooms", "")
    return Shape(
        name=item.name,
        role=role,
        vertices=vertices,
        faces=faces or None,
        state=str(item.get("enfilade_state", "")),
        rooms=[part.strip() for part in str(rooms).split(";")] if str(rooms).strip() else [],
        storey=str(item.get("enfilade_storey", "")),
        long_name=str(item.get("enfilade_long_name", "")),
        source_id=item.name_full,
        place=_place(item),
    )


def _place(item: bpy.types.Object | bpy.types.Collection) -> tuple[float, float, float] | None:
    """Of an object its middle, of a collection that of its first."""
    if isinstance(item, bpy.types.Collection):
        first = next(iter(item.all_objects), None)
        return None if first is None else _place(first)
    return tuple(item.matrix_world @ (sum((Vector(c) for c in item.bound_box), Vector()) / 8.0))


def _mesh(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[np.ndarray, list[list[int]]]:
    """World vertices float64 (n, 3) and faces. An n-gon that isn't convex or planar comes as Blender's own triangles.

    An empty drawn as a cube is that cube (a quick way to mark a passage); what has no geometry comes back empty."""
    evaluated = obj.evaluated_get(depsgraph)
    if obj.type == "EMPTY":
        if obj.empty_display_type != "CUBE" or obj.instance_collection is not None:
            return np.zeros((0, 3)), []
        size = float(obj.empty_display_size)
        local = np.array([(x, y, z) for z in (-size, size) for y in (-size, size) for x in (-size, size)])
        matrix = np.array(evaluated.matrix_world, dtype=np.float64)
        return local @ matrix[:3, :3].T + matrix[:3, 3], [list(f) for f in _CUBE]
    if obj.type not in {"MESH", "CURVE", "SURFACE", "META", "FONT"}:
        return np.zeros((0, 3)), []
    mesh = evaluated.to_mesh()
    try:
        count = len(mesh.vertices)
        local = np.empty(count * 3, dtype=np.float32)
        mesh.vertices.foreach_get("co", local)
        matrix = np.array(evaluated.matrix_world, dtype=np.float64)
        world = local.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        mesh.calc_loop_triangles()
        triangles: dict[int, list[list[int]]] = {}
        for t in mesh.loop_triangles:
            triangles.setdefault(t.polygon_index, []).append(list(t.vertices))
        faces: list[list[int]] = []
        rings = [list(polygon.vertices) for polygon in mesh.polygons]
        quads = np.array([r for r in rings if len(r) == 4], dtype=np.int64).reshape(-1, 4)
        fine_quads = iter(_convex_planar_quads(world[quads]))
        for polygon, corners in zip(mesh.polygons, rings, strict=True):
            fine = next(fine_quads) if len(corners) == 4 else len(corners) == 3 or _convex_planar(world[corners])
            if fine:
                faces.append(corners)
            else:
                faces.extend(triangles.get(polygon.index, []))
    finally:
        evaluated.to_mesh_clear()
    return world, faces


def _convex_planar_quads(points: np.ndarray, tolerance: float = 1e-4) -> np.ndarray:
    """`_convex_planar` of many quadrilaterals at once: points (n, 4, 3), bool (n,)."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    normal = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0.0, length, 1.0)[:, None]
    centred = points - points.mean(axis=1, keepdims=True)
    off = np.abs(np.einsum("nki,ni->nk", centred, normal)).max(axis=1)
    edges = np.roll(points, -1, axis=1) - points
    turns = np.einsum("nki,ni->nk", np.cross(edges, np.roll(edges, -1, axis=1)), normal)
    return (length > 0.0) & (off <= tolerance) & (turns >= -1e-9).all(axis=1)


def _convex_planar(points: np.ndarray, tolerance: float = 1e-4) -> bool:
    """tolerance: metres out of plane, as rules.shapes.WELD."""
    centred = points - points.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        return False
    normal /= length
    if np.abs(centred @ normal).max() > tolerance:
        return False
    edges = np.roll(points, -1, axis=0) - points
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ normal
    return bool((turns >= -1e-9).all())


def hull(points: np.ndarray) -> tuple[np.ndarray, list[list[int]]]:
    """Convex hull by Blender's bmesh: vertices and outward triangles. Fewer than four corners come back as they are."""
    import bmesh

    points = np.unique(np.asarray(points, dtype=np.float64).reshape(-1, 3), axis=0)
    if len(points) < 4:
        return points, []
    origin = points.mean(axis=0)  # bmesh is single precision: stay near zero
    bm = bmesh.new()
    try:
        for p in points - origin:
            bm.verts.new(p)
        result = bmesh.ops.convex_hull(bm, input=bm.verts, use_existing_faces=False)
        for vertex in {v for v in result["geom_interior"] if isinstance(v, bmesh.types.BMVert)}:
            bm.verts.remove(vertex)
        bm.verts.index_update()
        bm.normal_update()
        vertices = np.array([v.co[:] for v in bm.verts], dtype=np.float64).reshape(-1, 3) + origin
        faces = [[v.index for v in f.verts] for f in bm.faces]
    finally:
        bm.free()
    return vertices, faces
