# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for tests, and a dump of everything that decides whether an object shows."""

from __future__ import annotations

import json
import os
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[2]
HOUSE = ROOT / "sample_blends" / "house.blend"
DATA = Path(os.environ.get("ENFILADE_DATA", ROOT.parent / "shared" / "data"))


def empty_scene() -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def box(name: str, low, high, **properties) -> bpy.types.Object:
    (x0, y0, z0), (x1, y1, z1) = low, high
    vertices = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    for key, value in properties.items():
        obj[key] = value
    bpy.context.scene.collection.objects.link(obj)
    return obj


def camera(name: str, location, target) -> bpy.types.Object:
    from mathutils import Vector

    data = bpy.data.cameras.new(name)
    obj = bpy.data.objects.new(name, data)
    obj.location = location
    obj.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
    return obj


def two_rooms(state: str = "open") -> bpy.types.Scene:
    """Rooms A and B with a door between, C behind A without any door, a chair in each; the camera in A looks at the door."""
    scene = empty_scene()
    for name, x in (("A", 0.0), ("B", 4.2), ("C", -4.2)):
        room = box(f"Room_{name}", (x, 0, 0), (x + 4, 4, 2.5))
        room.hide_render = True
        box(f"Chair {name}", (x + 1.5, 1.5, 0), (x + 2.0, 2.0, 1.0))
    box("Door_AB", (4.0, 1.5, 0), (4.2, 2.5, 2.0), enfilade_state=state).hide_render = True
    scene.camera = camera("Eye", (0.2, 2.0, 1.2), (6.0, 2.0, 0.9))
    bpy.context.view_layer.update()
    return scene


def visibility() -> dict:
    """Every flag that we or Blender may use to hide, and who is in which collection."""
    bpy.context.view_layer.update()
    out: dict = {}
    for obj in bpy.data.objects:
        out[obj.name_full] = {
            **{k: bool(getattr(obj, k)) for k in ("hide_viewport", "hide_render", "hide_select", "visible_camera",
                                                  "visible_diffuse", "visible_glossy", "visible_shadow",
                                                  "visible_transmission", "visible_volume_scatter")},
            "keys": sorted(k for k in obj.keys() if k.startswith("enfilade")),
            "collections": sorted(c.name_full for c in obj.users_collection),
            "pass_index": obj.pass_index,
        }
    for layer in bpy.context.scene.view_layers:
        for obj in layer.objects:
            out[obj.name_full][f"layer {layer.name}"] = (obj.hide_get(view_layer=layer), obj.visible_get(view_layer=layer))
    out["collections"] = sorted((c.name_full, c.hide_render, c.hide_viewport) for c in bpy.data.collections)
    out["scene keys"] = sorted(k for k in bpy.context.scene.keys() if k.startswith("enfilade") and k != "enfilade_source")
    out["texts"] = sorted(t.name for t in bpy.data.texts)
    return json.loads(json.dumps(out))


def rendered_index(path: Path, names: list[str]) -> set[str]:
    """Which objects a tiny Cycles render of the open scene shows (by pass index)."""
    import numpy as np
    from enfilade import compat
    from enfilade.rules import compare_images

    scene = bpy.context.scene
    compat.use_cycles(scene)
    compat.disable_compositing(scene)
    scene.cycles.samples = 1
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 36, 100
    bpy.context.view_layer.use_pass_object_index = True
    compat.set_multilayer_exr(scene.render.image_settings)
    for i, name in enumerate(names):
        bpy.data.objects[name].pass_index = i + 1
    scene.render.filepath = str(path)
    scene.render.use_file_extension = False
    bpy.ops.render.render(write_still=True)
    found = np.unique(compare_images.index_channel(compare_images.read_layers(str(path)))).astype(int)
    return {names[i - 1] for i in found.tolist() if i > 0}
