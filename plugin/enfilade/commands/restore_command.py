# SPDX-License-Identifier: GPL-3.0-or-later
"""`restore`: shows again whatever we hid, as it was."""

from __future__ import annotations

import argparse

import bpy

from ..scene import apply_result, collections, cull, frame_table
from . import BadInput
from .common import save


def run(options: argparse.Namespace) -> dict:
    shown = apply_result.restore()
    for item in bpy.data.scenes:
        shown += cull.unkey(item)
    for scene in bpy.data.scenes:
        frame_table.remove(scene)
        collections.remove_lists(scene)
    target = options.save or bpy.data.filepath
    if not target:
        raise BadInput("the open file has no name yet: say where to write with --save FILE.blend")
    if options.save:
        saved = save(options.save)
    else:
        bpy.ops.wm.save_mainfile(check_existing=False)
        saved = bpy.data.filepath
    return {"restored": shown, "saved": saved}
