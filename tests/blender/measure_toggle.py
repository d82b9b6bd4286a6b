# SPDX-License-Identifier: GPL-3.0-or-later
"""What each way of hiding costs, and whether the evaluated scene and a render believe it. Prints a table.

    blender -b --factory-startup -P tests/blender/measure_toggle.py -- [few] [OBJECTS ...] [WORDS ...]   (3000 30000; all variants)

Half of the objects are hidden, then shown again; with "few" 15 of them, as many as a step of a walk changes. Times are the CPU's of the
whole process, so that they can be compared on a busy machine. write: the Python part; update: view_layer.update(). "graph": whether the
evaluated scene has exactly the visible ones afterwards (both ways); "layer": whether visible_get() agrees; "render": whether a
tiny Cycles render does (hidden first, then shown, persistent data on).
"""

from __future__ import annotations

import os
import sys
import tempfile
import time

import bpy
import numpy as np


def scene_of(count: int) -> list[bpy.types.Object]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("triangle")
    mesh.from_pydata([(0, 0, 0), (0.8, 0, 0), (0, 0.8, 0)], [], [(0, 1, 2)])
    side = int(np.ceil(np.sqrt(count)))
    made = []
    for k in range(100):
        shelf = bpy.data.collections.new(f"shelf {k}")
        for i in range(k, count, 100):
            obj = bpy.data.objects.new(f"o{i}", mesh)
            obj.location = (i % side, i // side, 0)
            shelf.objects.link(obj)
            made.append(obj)
        scene.collection.children.link(shelf)
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.data.type, eye.data.ortho_scale = "ORTHO", side
    eye.location = (side / 2, side / 2, 5)
    scene.collection.objects.link(eye)
    scene.camera = eye
    bpy.context.view_layer.update()
    return made


def write_bulk(attribute: str, objects, value: bool) -> None:
    flags = np.empty(len(bpy.data.objects), dtype=bool)
    bpy.data.objects.foreach_get(attribute, flags)
    where = {o.as_pointer(): i for i, o in enumerate(bpy.data.objects)}
    flags[[where[o.as_pointer()] for o in objects]] = value
    bpy.data.objects.foreach_set(attribute, flags)


def bulk_tag(attribute):
    def write(objects, hide):
        write_bulk(attribute, objects, hide)
        for o in objects:
            o.update_tag()

    return write


def bulk_tag_light(attribute):
    def write(objects, hide):
        write_bulk(attribute, objects, hide)
        for o in objects:
            o.update_tag(refresh={"OBJECT"})

    return write


def bulk_one(attribute, tag):
    def write(objects, hide):
        write_bulk(attribute, objects[:-1], hide)
        if tag:
            for o in objects:
                o.update_tag()
        setattr(objects[-1], attribute, hide)  # one write through RNA: syncs the layers and rebuilds relations

    return write


def bulk_eye(attribute):
    """The flags in bulk, then an eye of a layer collection there and back: syncs the layers."""

    def write(objects, hide):
        write_bulk(attribute, objects, hide)
        for o in objects:
            o.update_tag()
        layer = bpy.context.view_layer.layer_collection.children[0]
        layer.hide_viewport = not layer.hide_viewport
        layer.hide_viewport = not layer.hide_viewport

    return write


def bulk_sync(attribute):
    """What the add-on does: flags in bulk, the least tag, a layer collection's flag written with the value it has."""

    def write(objects, hide):
        write_bulk(attribute, objects, hide)
        for o in objects:
            o.update_tag(refresh={"OBJECT"})
        root = bpy.context.view_layer.layer_collection
        root.holdout = root.holdout

    return write


def one_by_one(objects, hide):
    for o in objects:
        o.hide_viewport = hide


def eyes(objects, hide):
    for o in objects:
        o.hide_set(hide)


homes: dict[str, list] = {}


def own_collections(objects, hide):
    """Out of their collections into one that isn't in the scene, and back: what hiding through collections would take."""
    shelf = bpy.data.collections.get("hidden") or bpy.data.collections.new("hidden")
    for o in objects:
        if hide:
            homes[o.name] = list(o.users_collection)
            shelf.objects.link(o)
            for c in homes[o.name]:
                c.objects.unlink(o)
        else:
            for c in homes.pop(o.name):
                c.objects.link(o)
            shelf.objects.unlink(o)


def bulk_only(attribute):
    return lambda objects, hide: write_bulk(attribute, objects, hide)


def camera_rays(objects, hide):
    for o in objects:
        o.visible_camera = not hide


PICTURE = os.path.join(tempfile.gettempdir(), "enfilade_toggle.exr")
VARIANTS = {
    "hide_viewport foreach_set alone": ("hide_viewport", bulk_only("hide_viewport")),
    "hide_viewport foreach_set + update_tag": ("hide_viewport", bulk_tag("hide_viewport")),
    "hide_viewport foreach_set + one RNA write": ("hide_viewport", bulk_one("hide_viewport", False)),
    "hide_viewport foreach_set + tag + one RNA write": ("hide_viewport", bulk_one("hide_viewport", True)),
    "hide_viewport foreach_set + tag + layer eye twice": ("hide_viewport", bulk_eye("hide_viewport")),
    "hide_viewport foreach_set + tag(OBJECT) + layer sync": ("hide_viewport", bulk_sync("hide_viewport")),
    "hide_viewport one by one": ("hide_viewport", one_by_one),
    "hide_set one by one": ("hide_viewport", eyes),
    "moved between collections": ("hide_viewport", own_collections),
    "hide_render foreach_set alone": ("hide_render", bulk_only("hide_render")),
    "hide_render foreach_set + update_tag": ("hide_render", bulk_tag("hide_render")),
    "hide_render foreach_set + update_tag(OBJECT)": ("hide_render", bulk_tag_light("hide_render")),
    "visible_camera one by one": ("visible_camera", camera_rays),
}


def in_graph(names: set[str]) -> set[str]:
    graph = bpy.context.evaluated_depsgraph_get()
    return {i.object.name for i in graph.object_instances if i.object.type == "MESH"}


def rendered(path: str) -> int:
    """How many of the pixels show something."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.render.use_persistent_data = True
    scene.render.film_transparent = True
    scene.render.resolution_x = scene.render.resolution_y = 96
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:]).reshape(-1, 4)
    bpy.data.images.remove(image)
    return int((pixels[:, 3] > 0.5).sum())


def measure(count: int, label: str, attribute: str, write, few: bool) -> None:
    if count > 5000 and not few and write in (one_by_one, eyes):
        return  # minutes
    objects = scene_of(count)
    half = objects[:: count // 15 if few else 2]
    hidden = {o.name for o in half}
    every = {o.name for o in objects}
    times, graph, layer = [], [], []
    shown_pixels = []
    persistent = attribute != "hide_viewport"
    if persistent:
        shown_pixels.append(rendered(PICTURE))
    for hide in (True, False):
        begin = time.process_time()
        write(half, hide)
        middle = time.process_time()
        bpy.context.view_layer.update()
        end = time.process_time()
        times.append((middle - begin, end - middle))
        wanted = every - hidden if hide and attribute == "hide_viewport" else every
        graph.append(in_graph(every) == wanted)
        layer.append({o.name for o in objects if o.name in bpy.context.view_layer.objects and o.visible_get()} == wanted)
        if persistent:
            shown_pixels.append(rendered(PICTURE))
    right = ""
    if persistent:
        a, b, c = shown_pixels
        right = "yes" if b < 0.75 * a and c == a else f"NO {shown_pixels}"
    print(
        f"{count:6d} | {label:50s} | hide {times[0][0]:.4f} + {times[0][1]:.4f} s | show {times[1][0]:.4f} + {times[1][1]:.4f} s | "
        f"graph {'yes' if all(graph) else 'NO'} | layer {'yes' if all(layer) else 'NO'} | render {right}",
        file=sys.stderr,
        flush=True,
    )


given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
words = [a for a in given if not a.isdigit() and a != "few"]
for n in [int(a) for a in given if a.isdigit()] or (3000, 30000):
    for name, (flag, writer) in VARIANTS.items():
        if not words or any(w in name for w in words):
            measure(n, name, flag, writer, "few" in given)
