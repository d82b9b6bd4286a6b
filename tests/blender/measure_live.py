# SPDX-License-Identifier: GPL-3.0-or-later
"""What the live culled view costs: from a camera's move to the updated view layer, and the part of it that is ours.

    blender -b --factory-startup -P tests/blender/measure_live.py -- [flat] [OBJECTS ...]       (3000 30000)

A row of rooms with doors in line, a hundred objects each, in a collection a room (flat: all in one); the camera walks through them and looks about, 40 steps, with the live
view off (what Blender itself takes), then on. Checked at every step: exactly the objects that are to show are in the evaluated
scene. From Blender 3.4 on; prints a line for each size. Ours is all that Blender calls us for: noticing what changed, looking, writing.
Shares are of CPU time (the whole process against our thread meanwhile): on a busy machine the clock says little.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
for folder in (ROOT / "python_shim", ROOT / "plugin", ROOT / "tests" / "blender"):
    sys.path.insert(0, str(folder))

import enfilade  # noqa: E402
from enfilade import handlers, session  # noqa: E402
from kit import box, camera, empty_scene  # noqa: E402

STEPS = 40


def suite(count: int, flat: bool = False) -> bpy.types.Scene:
    scene = empty_scene()
    rng = np.random.default_rng(1)
    shared = bpy.data.meshes.new("thing")
    corners = [(x, y, z) for z in (0, 0.4) for y in (0, 0.4) for x in (0, 0.4)]
    shared.from_pydata(corners, [], [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
    for r in range(count // 100):
        x = 6.2 * r
        box(f"Room_{r:03}", (x, 0, 0), (x + 6, 8, 3)).hide_render = True
        if r:
            y = 1 + 5 * rng.random()
            box(f"Door_{r:03}", (x - 0.2, y, 0), (x, y + 1, 2.1)).hide_render = True
        shelf = scene.collection if flat else bpy.data.collections.new(f"shelf {r}")
        for k in range(100):
            thing = bpy.data.objects.new(f"thing {r:03} {k:02}", shared)
            thing.location = (x + 5.4 * rng.random(), 7.4 * rng.random(), 2.4 * rng.random())
            shelf.objects.link(thing)
        if not flat:
            scene.collection.children.link(shelf)
    scene.camera = camera("Eye", (3, 4, 1.6), (9, 4, 1.6))
    bpy.context.view_layer.update()
    return scene


def walk(scene: bpy.types.Scene, check) -> tuple[list[float], list[float]]:
    """Milliseconds by the clock, and of the CPU, for each step."""
    times, work = [], []
    for step in range(STEPS):
        eye = scene.camera
        begin, begun = time.perf_counter(), time.process_time()
        eye.location = (3 + 0.3 * step, 4, 1.6)
        eye.rotation_euler.z += 0.1
        bpy.context.view_layer.update()
        times.append(1e3 * (time.perf_counter() - begin))
        work.append(1e3 * (time.process_time() - begun))
        check()
    eye.rotation_euler.z -= 0.1 * STEPS
    return times, work


def measure(count: int, flat: bool) -> None:
    scene = suite(count, flat)
    bpy.ops.enfilade.detect()
    alone, alone_work = walk(scene, lambda: None)
    begin = time.perf_counter()
    bpy.ops.enfilade.culled_view()
    bpy.context.view_layer.update()
    on = 1e3 * (time.perf_counter() - begin)
    live = session.get(scene).live
    wrong = 0

    def check() -> None:
        nonlocal wrong
        names = {session.get(scene).building.objects[o].source_id for o in session.get(scene).views[-1].objects}
        graph = bpy.context.evaluated_depsgraph_get()
        shown = {i.object.name for i in graph.object_instances if i.object.name.startswith("thing")}
        wrong += shown != names

    live.looks.clear()
    hooks = bpy.app.handlers.depsgraph_update_post
    place = hooks.index(handlers.on_depsgraph_update)
    own_times, own_work = [], []

    def counted(*given):
        begin, begun = time.perf_counter(), time.thread_time()
        handlers.on_depsgraph_update(*given)
        own_times.append(1e3 * (time.perf_counter() - begin))
        own_work.append(1e3 * (time.thread_time() - begun))

    hooks[place] = counted
    times, work = walk(scene, check)
    hooks[place] = handlers.on_depsgraph_update
    changing = [i for i, look in enumerate(live.looks) if look.changed]
    all_work, own_work = statistics.median(work[i] for i in changing), statistics.median(own_work[i] for i in changing)
    looks = [look for look in live.looks if look.changed]
    ours = [own_times[i] for i in changing]
    written = [times[i] for i in changing]
    begin = time.perf_counter()
    bpy.ops.enfilade.culled_view()
    bpy.context.view_layer.update()
    off = 1e3 * (time.perf_counter() - begin)
    left = [o.name for o in bpy.data.objects if "enfilade_hidden" in o or (o.hide_viewport and o.name.startswith("thing"))]
    query = statistics.median(look.query_us for look in live.looks)
    print(
        f"live | Blender {bpy.app.version_string} | {count} objects{', flat' * flat} | CPU: camera alone {statistics.median(alone_work):.1f} ms, with the live view "
        f"{all_work:.1f} ms, of it ours {own_work:.2f} ms = {100 * own_work / all_work:.1f} % | clock: camera alone "
        f"{statistics.median(alone):.2f} ms | camera to updated view "
        f"layer {statistics.median(written):.1f} ms (worst {max(written):.1f}), of it ours {statistics.median(ours):.2f} ms = "
        f"{100 * statistics.median(ours) / statistics.median(written):.1f} % (medians; look {statistics.median(k.look_ms for k in looks):.2f}, write "
        f"{statistics.median(k.write_ms for k in looks):.2f}; query {query:.1f} us) | {len(looks)} of {STEPS} steps changed something, "
        f"{statistics.mean(k.changed for k in looks):.0f} objects each | on {on:.0f} ms, off {off:.0f} ms | wrong {wrong}, left behind {len(left)}",
        file=sys.stderr,
        flush=True,
    )


enfilade.register()
given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
for n in [int(a) for a in given if a != "flat"] or (3000, 30000):
    measure(n, "flat" in given)
