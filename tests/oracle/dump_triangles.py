# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what Blender draws as triangles with object numbers, for the ray oracle. Uses nothing of Enfilade.

    blender -b FILE.blend --python-exit-code 3 -P tests/oracle/dump_triangles.py -- OUT.dump [--frames A,B,...]

One JSON line, then raw little-endian arrays: per mesh float32 vertices (n, 3), uint32 triangles (m, 3), uint8
see-through (m,); then float64 matrices (objects, 3, 4), world from mesh. An object is what a person sees in the
outliner: the parts of a collection instance count as its empty.
"""

from __future__ import annotations

import argparse
import json
import sys

import bpy
import numpy as np


def see_through(material: bpy.types.Material | None) -> bool:
    """Whether sight passes a surface: mostly transparent, transmitting, or drawn with low opacity."""
    if material is None:
        return False
    if material.node_tree is None:
        return material.diffuse_color[3] < 0.5
    nodes = material.node_tree.nodes
    for node in nodes:
        if node.type == "BSDF_PRINCIPLED":
            for name in ("Transmission Weight", "Transmission"):
                if name in node.inputs and node.inputs[name].default_value > 0.5:
                    return True
            if "Alpha" in node.inputs and node.inputs["Alpha"].default_value < 0.5:
                return True
    kinds = {node.type for node in nodes}
    return bool(kinds & {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION"}) and "BSDF_PRINCIPLED" not in kinds


def cameras(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, frame: int) -> list[dict]:
    """The corners of each camera's picture at distance one (perspective) or on its plane (orthographic), in the world.

    `view_frame` gives them with lens, sensor fit and shift applied, the way Blender itself sees it.
    """
    found = []
    for camera in sorted((o for o in scene.objects if o.type == "CAMERA"), key=lambda o: o.name):
        if camera.data.type == "PANO":
            continue
        seen = camera.evaluated_get(depsgraph)
        turn = np.array(seen.matrix_world.normalized().to_3x3())
        frame_corners = [turn @ np.array(corner) for corner in camera.data.view_frame(scene=scene)]
        top_right, bottom_right, bottom_left, _ = frame_corners
        found.append({
            "name": camera.name, "frame": frame, "type": camera.data.type,
            "origin": list(seen.matrix_world.translation),
            "corner": bottom_left.tolist(), "right": (bottom_right - bottom_left).tolist(),
            "up": (top_right - bottom_right).tolist(), "forward": (turn @ np.array([0.0, 0.0, -1.0])).tolist(),
            "clip": [camera.data.clip_start, camera.data.clip_end]})
    return found


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="dump_triangles.py")
    parser.add_argument("out")
    parser.add_argument("--frames", default="", help="cameras are also dumped at these frames (default: the file's own)")
    given = parser.parse_args(arguments)
    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    meshes: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    mesh_index: dict[tuple, int] = {}
    objects: list[dict] = []
    matrices: list[np.ndarray] = []
    for instance in depsgraph.object_instances:
        drawn = instance.object
        owner = instance.parent if instance.is_instance else drawn
        if owner.original.hide_render or drawn.original.hide_render or drawn.original.display_type == "WIRE":
            continue
        if drawn.type not in {"MESH", "CURVE", "SURFACE", "FONT", "META"}:
            continue
        shared = drawn.type == "MESH" and not drawn.original.modifiers
        key = (drawn.original.data.name,) if shared else (drawn.original.name, "own")
        if key not in mesh_index:
            mesh = drawn.to_mesh()
            if mesh is None:
                continue
            mesh.calc_loop_triangles()
            n, m = len(mesh.vertices), len(mesh.loop_triangles)
            vertices, triangles = np.empty(n * 3, np.float32), np.empty(m * 3, np.int32)
            slots = np.zeros(m, np.int32)
            mesh.vertices.foreach_get("co", vertices)
            mesh.loop_triangles.foreach_get("vertices", triangles)
            mesh.loop_triangles.foreach_get("material_index", slots)
            passes = [see_through(slot.material) for slot in drawn.original.material_slots] or [False]
            clear = np.array(passes, np.uint8)[np.clip(slots, 0, len(passes) - 1)]
            mesh_index[key] = len(meshes)
            meshes.append((vertices, triangles.astype(np.uint32), clear))
            drawn.to_mesh_clear()
        if len(meshes[mesh_index[key]][1]) == 0:
            continue
        objects.append({"name": owner.original.name, "mesh": mesh_index[key]})
        matrices.append(np.array(instance.matrix_world, np.float64)[:3].copy())
    views = cameras(scene, depsgraph, scene.frame_current)
    for frame in (int(f) for f in given.frames.split(",") if f):
        scene.frame_set(frame)
        views += [c for c in cameras(scene, bpy.context.evaluated_depsgraph_get(), frame)
                  if bpy.data.objects[c["name"]].animation_data]
    header = {"format": "enfilade-oracle-dump", "version": 1,
              "meshes": [{"vertices": len(v) // 3, "triangles": len(t) // 3} for v, t, _ in meshes],
              "objects": objects, "cameras": views}
    with open(given.out, "wb") as out:
        out.write(json.dumps(header).encode() + b"\n")
        for vertices, triangles, clear in meshes:
            out.write(vertices.tobytes() + triangles.tobytes() + clear.tobytes())
        out.write(np.array(matrices, np.float64).tobytes())
    print(f"{given.out}: {len(objects)} objects, {sum(len(t) for _, t, _ in meshes) // 3} triangles in "
          f"{len(meshes)} meshes, {len(views)} cameras")


main(sys.argv[sys.argv.index("--") + 1:])
