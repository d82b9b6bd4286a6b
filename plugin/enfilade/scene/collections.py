# SPDX-License-Identifier: GPL-3.0-or-later
"""The `Enfilade` collection tree: what is visible and hidden, and the cells and portals as something to look at.

None of it renders, none of it adds visibility to a linked object, and none of it is ever taken for scenery.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from ..rules.building import EXTERIOR, Room
from ..rules.results import Cells, Sightline

TREE, VISIBLE, HIDDEN, CELLS, PORTALS, PROBLEMS, SIGHTLINES = (
    "Enfilade",
    "Enfilade Visible",
    "Enfilade Hidden",
    "Enfilade Cells",
    "Enfilade Portals",
    "Enfilade Problems",
    "Enfilade Sightlines",
)
TREE_KEY = "enfilade_tree"  # our collections, whatever somebody renames them to
NONE = 0xFFFFFFFF
STATE_COLOURS = {"open": (0.10, 0.60, 0.30, 0.5), "glass": (0.15, 0.45, 0.85, 0.4), "closed": (0.75, 0.20, 0.15, 0.6),
                 "seam": (0.5, 0.5, 0.5, 0.3)}


def tree_of(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    return next((c for c in scene.collection.children if c.get(TREE_KEY) == TREE), None)


def members(tree: bpy.types.Collection | None) -> set[str]:
    """Full names of the collections of the tree, its root included."""
    return set() if tree is None else {tree.name_full, *(c.name_full for c in tree.children_recursive)}


def own_objects(tree: bpy.types.Collection | None) -> list[bpy.types.Object]:
    """Objects that we made (Visible and Hidden only link the user's)."""
    if tree is None:
        return []
    return [o for c in tree.children if c.get(TREE_KEY) in (CELLS, PORTALS, PROBLEMS, SIGHTLINES) for o in c.objects]


def _make(key: str) -> bpy.types.Collection:
    collection = bpy.data.collections.new(key)
    collection[TREE_KEY] = key
    # Switched off in itself: a linked object gains no visibility through it, and neither renders.
    collection.hide_render = True
    collection.hide_viewport = key in (VISIBLE, HIDDEN)
    return collection


def ensure_tree(scene: bpy.types.Scene) -> bpy.types.Collection:
    tree = tree_of(scene)
    if tree is None:
        tree = bpy.data.collections.new(TREE)
        tree[TREE_KEY] = TREE
        tree.color_tag = "COLOR_05"
        scene.collection.children.link(tree)
    return tree


def child(scene: bpy.types.Scene, key: str) -> bpy.types.Collection | None:
    tree = tree_of(scene)
    return None if tree is None else next((c for c in tree.children if c.get(TREE_KEY) == key), None)


def list_objects(scene: bpy.types.Scene, visible: Iterable[bpy.types.Object], hidden: Iterable[bpy.types.Object]) -> None:
    """Makes `Enfilade Visible` and `Enfilade Hidden` list exactly these. New collections are filled before they are
    attached: linking into an attached one pays for every object."""
    tree = ensure_tree(scene)
    for key, objects in ((VISIBLE, visible), (HIDDEN, hidden)):
        _drop_list(scene, key)
        collection = _make(key)
        for obj in objects:
            collection.objects.link(obj)
        tree.children.link(collection)


def remove_lists(scene: bpy.types.Scene) -> None:
    for key in (VISIBLE, HIDDEN):
        _drop_list(scene, key)
    _drop_if_empty(scene)


def _drop_list(scene: bpy.types.Scene, key: str) -> None:
    """What the user took out of all collections of his own meanwhile stays in the scene: nobody else would hold it."""
    old = child(scene, key)
    if old is None:
        return
    ours = members(tree_of(scene))
    for obj in old.objects:
        if all(c.name_full in ours for c in obj.users_collection):
            scene.collection.objects.link(obj)
    bpy.data.collections.remove(old)


def remove_cells(scene: bpy.types.Scene) -> None:
    for key in (CELLS, PORTALS):
        remove_child(scene, key)


def ensure_child(scene: bpy.types.Scene, key: str) -> bpy.types.Collection:
    """One of our collections, for objects of our own making."""
    found = child(scene, key)
    if found is None:
        found = _make(key)
        ensure_tree(scene).children.link(found)
    return found


def remove_child(scene: bpy.types.Scene, key: str) -> None:
    """One of our collections with the objects that we made for it."""
    old = child(scene, key)
    if old is not None:
        _drop_own(list(old.objects))
        bpy.data.collections.remove(old)
    _drop_if_empty(scene)


def remove_tree(scene: bpy.types.Scene) -> None:
    """Everything of ours leaves the scene: lists, cells, portals, and the meshes made for them."""
    tree = tree_of(scene)
    if tree is None:
        return
    for key in (VISIBLE, HIDDEN):
        _drop_list(scene, key)
    _drop_own(own_objects(tree))
    for collection in list(tree.children):
        if collection.get(TREE_KEY):
            bpy.data.collections.remove(collection)
    _drop_if_empty(scene)


def _drop_if_empty(scene: bpy.types.Scene) -> None:
    tree = tree_of(scene)
    if tree is not None and not tree.children and not tree.objects:
        bpy.data.collections.remove(tree)


def _drop_own(objects: list[bpy.types.Object]) -> None:
    drawn = {o.data for o in objects if o.data is not None}
    for obj in objects:
        bpy.data.objects.remove(obj)
    for data in drawn:
        if data.users == 0:
            (bpy.data.curves if isinstance(data, bpy.types.Curve) else bpy.data.meshes).remove(data)


def _material(name: str, colour: tuple[float, float, float, float]) -> bpy.types.Material:
    label = f"Enfilade {name}"
    material = bpy.data.materials.get(label) or bpy.data.materials.new(label)
    material.diffuse_color = colour
    return material


def draw_cells(scene: bpy.types.Scene, cells: Cells, rooms: list[Room], opening_states: list[str]) -> None:
    """Cells as one wire object a room (and one for the passages), portals as one object coloured by their openings' state.

    Cells outdoors reach far round the building: their object is there, but hidden until asked for, and the seams between them
    aren't drawn.
    """
    from .extract_annotated import hull

    remove_cells(scene)
    tree = ensure_tree(scene)
    group = _make(CELLS)
    outdoors = {i for i, room in enumerate(rooms) if room.kind == EXTERIOR}
    open_air = np.isin(cells.rooms, list(outdoors))
    by_room: dict[int, list[int]] = {}
    for i, room in enumerate(cells.rooms):
        if len(cells.hulls[i]):
            by_room.setdefault(int(room), []).append(i)
    for room, members_ in sorted(by_room.items()):
        vertices: list[np.ndarray] = []
        faces: list[list[int]] = []
        base = 0
        for i in members_:
            points, triangles = hull(cells.hulls[i])
            vertices.append(points)
            faces += [[base + k for k in f] for f in triangles]
            base += len(points)
        name = "Enfilade passages" if room == NONE else f"Enfilade cells {rooms[room].name}"
        obj = _mesh_object(name, np.concatenate(vertices), faces)
        obj.display_type = "WIRE"
        obj.hide_viewport = room in outdoors
        group.objects.link(obj)
    tree.children.link(group)

    group = _make(PORTALS)
    vertices, faces, slots = [], [], []
    states = list(STATE_COLOURS)
    base = 0
    for polygon, opening, sides in zip(cells.portals, cells.portal_openings, cells.portal_cells, strict=True):
        if open_air[sides].all():
            continue
        vertices.append(polygon)
        faces.append(list(range(base, base + len(polygon))))
        base += len(polygon)
        slots.append(states.index("seam" if int(opening) == NONE else opening_states[int(opening)]))
    if faces:
        obj = _mesh_object("Enfilade portals", np.concatenate(vertices), faces)
        for state, colour in STATE_COLOURS.items():
            obj.data.materials.append(_material(f"portal {state}", colour))
        obj.data.polygons.foreach_set("material_index", np.array(slots, dtype=np.int32))
        obj.show_wire = True
        group.objects.link(obj)
    tree.children.link(group)


def draw_sightlines(
    scene: bpy.types.Scene, sightlines: list[Sightline], room_names: list[str], opening_names: list[str], cells: Cells
) -> None:
    """A curve a sightline: the line from room to room, and the outlines of the openings it passes, in order. Its name and the
    properties `enfilade_rooms`, `enfilade_openings` say through what."""
    remove_child(scene, SIGHTLINES)
    tree = ensure_tree(scene)
    group = _make(SIGHTLINES)
    outlines: dict[int, list[np.ndarray]] = {}
    for polygon, opening in zip(cells.portals, cells.portal_openings, strict=True):
        outlines.setdefault(int(opening), []).append(polygon)
    line_material, frame_material = _material("sightline", (0.95, 0.55, 0.05, 1.0)), _material("passed", (0.10, 0.60, 0.30, 1.0))
    for sight in sightlines:
        a, b = (room_names[r] for r in sight.rooms)
        through = [opening_names[o] for o in sight.openings]
        curve = bpy.data.curves.new(f"Enfilade {a} - {b}", "CURVE")
        curve.dimensions = "3D"
        curve.bevel_depth = 0.03  # metres: seen from across a house, thinner than any frame
        curve.materials.append(line_material)
        curve.materials.append(frame_material)
        origin = np.asarray(sight.start)  # the object carries the distance: curves are single precision
        _poly(curve, [np.asarray(sight.start) - origin, np.asarray(sight.end) - origin], 0, False)
        for opening in sight.openings:
            for polygon in outlines.get(opening, []):
                _poly(curve, [corner - origin for corner in polygon], 1, True)
        obj = bpy.data.objects.new(f"{a} - {b}" + (f" ({', '.join(through)})" if through else ""), curve)
        obj.location = origin
        obj["enfilade"] = "ignore"
        obj.show_in_front = True  # through walls
        obj["enfilade_rooms"] = [a, b]
        obj["enfilade_openings"] = ", ".join(through)
        obj.hide_render = True
        group.objects.link(obj)
    tree.children.link(group)


def _poly(curve: bpy.types.Curve, points: list[np.ndarray], slot: int, closed: bool) -> None:
    spline = curve.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for point, at in zip(spline.points, points, strict=True):
        point.co = (*at.tolist(), 1.0)
    spline.use_cyclic_u = closed
    spline.material_index = slot


def _mesh_object(name: str, vertices: np.ndarray, faces: list[list[int]]) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    origin = vertices.mean(axis=0)  # the object carries the distance: mesh corners are single precision
    mesh.from_pydata((vertices - origin).tolist(), [], faces)
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    obj.location = origin
    obj["enfilade"] = "ignore"
    obj.hide_render = True
    obj.hide_select = True
    return obj
