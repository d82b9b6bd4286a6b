# SPDX-License-Identifier: GPL-3.0-or-later
"""An IFC model as a scene of the core, the way the add-on reads it, without Blender: ifc_scene.py MODEL.ifc OUT.enf.json"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
sys.path.append(str(ROOT / "build" / "python"))


def main() -> int:
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    import enfilade_native as native
    from enfilade.rules import assemble, ifc

    building, _ = ifc.read_with_outcomes(sys.argv[1], objects=False)
    with assemble.assemble(native, building).scene as scene:
        scene.save(sys.argv[2])
    return 0


if __name__ == "__main__":
    sys.exit(main())
