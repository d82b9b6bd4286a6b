# SPDX-License-Identifier: GPL-3.0-or-later
"""Enfilade without a window: blender -b FILE.blend --python-exit-code 3 -P plugin/batch.py -- COMMAND [options]

Only a door: the commands live in `enfilade.commands`, which from Blender 4.2 also answers `blender -b FILE -c enfilade ...`.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from enfilade.commands import run_script  # noqa: E402 - the path has to be set first

if __name__ == "__main__":
    run_script(sys.argv)
