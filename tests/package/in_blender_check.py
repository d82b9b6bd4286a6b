# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender with the zip installed and no source tree in sight: the add-on works, and leaves nothing behind.

    blender -b --python-exit-code 3 -P in_blender_check.py -- MODULE USER_FOLDER OUT.enf.json
"""

import importlib
import sys
from pathlib import Path

import addon_utils
import bpy

module_name, user_folder, scene_json = sys.argv[sys.argv.index("--") + 1 :]

enabled, loaded = addon_utils.check(module_name)
assert enabled and loaded, f"{module_name}: enabled {enabled}, loaded {loaded} in a fresh Blender"
module = sys.modules[module_name]
assert Path(module.__file__).resolve().is_relative_to(Path(user_folder).resolve()), module.__file__

native = importlib.import_module(module_name + ".native")
usable, line = native.status()
assert usable, line
library = Path(native.load().library_path()).resolve()
assert library.is_relative_to(Path(user_folder).resolve()), f"the library comes from elsewhere: {library}"
print("library:", line)

# The verbs a user has: registered, and detect works on the open file.
verbs = [name for name in dir(bpy.ops.enfilade) if not name.startswith("_")]
print("operators:", " ".join(verbs))
assert "detect" in verbs, verbs
if len(bpy.data.objects) > 100:  # the sample house
    assert bpy.ops.enfilade.detect() == {"FINISHED"}
    commands = importlib.import_module(module_name + ".commands")
    code = commands.run(["detect", "--scene-json", scene_json])
    assert not code, code
    with native.load().Scene.load(scene_json) as scene:
        scene.commit()
        print("cells:", scene.counts.cells, "portals:", scene.counts.portals)
        assert scene.counts.cells >= 8 and scene.counts.portals >= 10

# Off and on again, twice: nothing of the add-on stays, nothing is registered twice.
for _ in range(2):
    addon_utils.disable(module_name)
    assert not [name for name in dir(bpy.ops.enfilade) if not name.startswith("_")]
    left = [h for group in ("load_post", "frame_change_pre", "frame_change_post", "render_init", "render_pre",
                            "render_complete", "render_cancel", "depsgraph_update_post", "save_pre", "save_post")
            for h in getattr(bpy.app.handlers, group) if "enfilade" in (getattr(h, "__module__", "") or "")]  # fmt: skip
    assert not left, left
    assert not [n for n in dir(bpy.types.Scene) if n.startswith("enfilade")]
    assert addon_utils.enable(module_name) is not None
print("package check passed")
