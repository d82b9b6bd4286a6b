# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the sample scenes:

    blender -b --factory-startup --python-exit-code 3 -P sample_blends/make_samples.py -- house --out house.blend
    blender -b --factory-startup --python-exit-code 3 -P sample_blends/make_samples.py -- office --rooms 46 --out o.blend
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="make_samples.py", description="Makes Enfilade's sample scenes.")
    kinds = parser.add_subparsers(dest="kind", required=True)
    house_options = kinds.add_parser("house", help="8 rooms on two storeys")
    office_options = kinds.add_parser("office", help="a parametric office building")
    office_options.add_argument("--storeys", type=int, default=1, help="number of storeys (default 1)")
    office_options.add_argument("--rooms-per-storey", type=int, default=46,
                                help="rooms, corridors and stair cores of one storey (default 46)")
    office_options.add_argument("--seed", type=int, default=1, help="which furniture, which doors stand open (default 1)")
    for options in (house_options, office_options):
        options.add_argument("--out", type=Path, required=True, help="the .blend file to write")
    given = parser.parse_args(arguments)

    start = time.perf_counter()
    from scene_kit import empty_scene

    empty_scene()
    if given.kind == "house":
        import house

        house.build()
    else:
        import office

        office.build(given.storeys, given.rooms_per_storey, given.seed)
    made = time.perf_counter() - start
    given.out.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(given.out.resolve()), compress=True, check_existing=False)
    rooms = sum(1 for o in bpy.data.objects if o.get("enfilade") == "room")
    openings = sum(1 for o in bpy.data.objects if o.get("enfilade") in ("door", "window", "hole", "virtual"))
    print(f"{given.out}: {rooms} rooms, {openings} openings, {len(bpy.data.objects)} objects of "
          f"{len(bpy.data.meshes)} meshes; {made:.1f} s, {given.out.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
