# SPDX-License-Identifier: GPL-3.0-or-later
"""One render in a process of its own, so that its time and peak memory are its own. Started by `render --verify`.

blender -b FILE.blend --python-exit-code 3 -P render_child.py -- JOB.json : renders one frame of one camera as JOB says
and writes what it measured into JOB's `result`. Everything it changes (passes, pass indices, samples) dies with the process.
"""

import json
import sys
import time
from pathlib import Path


def peak_bytes() -> int:
    """The largest this process has been, 0 where the system doesn't tell."""
    try:
        import resource
    except ImportError:
        return 0
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size if sys.platform == "darwin" else size * 1024


def pin_instances(bpy, scene) -> None:
    """Gives every mesh and every instanced collection one more user, which only volumes could see.

    Cycles bakes the transform into a mesh that has a single user, and rounds corners otherwise than where rays are
    transformed: culling the second last user of a mesh moves the last bits of a depth. With the pins, in all variants, no
    mesh has a single user, and every bit of a depth must agree.
    """
    twins = []
    for data in {o.data for o in scene.objects if o.type == "MESH" and o.data is not None}:
        twins.append(bpy.data.objects.new("pin", data))
    for collection in {o.instance_collection for o in scene.objects if o.instance_collection is not None}:
        twin = bpy.data.objects.new("pin", None)
        twin.instance_type = "COLLECTION"
        twin.instance_collection = collection
        twins.append(twin)
    middle = sum((o.matrix_world.translation for o in scene.objects), start=scene.objects[0].location * 0) / len(scene.objects)
    for twin in twins:
        twin.location = middle
        for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
            setattr(twin, f"visible_{name}", False)
        scene.collection.objects.link(twin)


def clear_panes(bpy, describe) -> None:
    """What lets more than half of the light through is taken away: Cycles throws dice at each pixel whether a pane reflects, and where
    it does its index and depth are the pane's; and where a pane's rim coincides with its frame it may step over the frame as well."""
    import bmesh

    clear = {m.name_full for m in bpy.data.materials if describe(m)["kind"] == "clear"}
    for mesh in bpy.data.meshes:
        slots = {i for i, m in enumerate(mesh.materials) if m is not None and m.name_full in clear}
        if not slots or mesh.library is not None or mesh.shape_keys is not None:
            continue
        work = bmesh.new()
        work.from_mesh(mesh)
        bmesh.ops.delete(work, geom=[f for f in work.faces if min(f.material_index, len(mesh.materials) - 1) in slots], context="FACES_ONLY")
        work.to_mesh(mesh)
        work.free()
    for material in bpy.data.materials:  # what no mesh owns: curves, slots of objects
        if material.name_full in clear and material.node_tree is not None:
            tree = material.node_tree
            node = tree.nodes.new("ShaderNodeBsdfTransparent")
            for output in [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"]:
                tree.links.new(node.outputs[0], output.inputs["Surface"])


def main(job_path: str) -> None:
    begin = time.perf_counter()
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    import bpy

    if not bpy.data.filepath:  # bpy as a module: no file on a command line
        bpy.ops.wm.open_mainfile(filepath=job["blend"])
    plugin = str(Path(__file__).resolve().parent.parent.parent)
    sys.path.insert(0, plugin)
    package = Path(__file__).resolve().parent.parent.name
    from importlib import import_module

    apply_result = import_module(f"{package}.scene.apply_result")
    compat = import_module(f"{package}.compat")

    scene = bpy.context.scene
    objects = {o.name_full: o for o in scene.objects}
    scene.camera = objects[job["camera"]]
    if not compat.use_cycles(scene):
        raise SystemExit("this Blender has no Cycles")
    compat.disable_compositing(scene)
    render = scene.render
    scene.cycles.samples = job["samples"]
    scene.cycles.use_adaptive_sampling = False  # a pixel's samples must not depend on its neighbours
    if job.get("seed") is not None:
        scene.cycles.seed = job["seed"]
        scene.cycles.use_animated_seed = False
    if job["resolution"]:
        render.resolution_x, render.resolution_y = job["resolution"]
        render.resolution_percentage = 100
    if job.get("pixel_centres"):
        # All rays through the middle of their pixel, from one point, at one moment: what a preview's rays do.
        scene.cycles.pixel_filter_type = "GAUSSIAN"
        scene.cycles.filter_width = 0.01
        scene.camera.data.dof.use_dof = False
        render.use_motion_blur = False
        render.use_multiview = bool(job.get("view"))
        clear_panes(bpy, import_module(f"{package}.scene.extract_materials").describe)
    render.use_border = False
    if job["threads"]:
        render.threads_mode = "FIXED"
        render.threads = job["threads"]
    render.use_persistent_data = False
    layer = bpy.context.view_layer
    for other in scene.view_layers:
        other.use = other == layer
    layer.use_pass_combined = True
    layer.use_pass_z = True
    layer.use_pass_object_index = True
    compat.set_multilayer_exr(render.image_settings)
    if render.use_multiview:  # all eyes in the one file
        render.image_settings.views_format = "MULTIVIEW"
    render.filepath = job["out"]
    render.use_file_extension = False
    render.use_overwrite = True

    # One number an object, the same in every variant: sorted names. The pass is a short in Blender: beyond it numbers repeat.
    for i, obj in enumerate(sorted(bpy.data.objects, key=lambda o: o.name_full)):
        if obj.library is None:
            obj.pass_index = i % 32767 + 1
    if job["simplify"]:
        render.use_simplify = True
        scene.cycles.use_camera_cull = True
        for obj in scene.objects:
            if obj.library is None:
                obj.cycles.use_camera_cull = True
    hidden = set(job["hidden"])
    applied = 0
    if job["mode"]:
        names = set(job["candidates"])
        applied = apply_result.apply(scene, names - hidden, names, job["mode"]).hidden
    # After hiding: what is hidden needs no evaluation. The render evaluates the frame itself.
    if scene.frame_current != job["frame"]:
        scene.frame_set(job["frame"])
    if job.get("pin_instances"):
        pin_instances(bpy, scene)
    ready = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    done = time.perf_counter()
    result = {
        "load_s": round(ready - begin, 3),
        "render_s": round(done - ready, 3),
        "peak_bytes": peak_bytes(),
        "hidden": applied,
    }
    Path(job["result"]).write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1])
