# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests of this folder inside Blender's Python, headless.

    blender -b --factory-startup --python-exit-code 3 -P tests/blender/run.py -- [pytest arguments]
"""

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# Debian's Blender shares the system's Python and with it pytest; another Blender brings none: ENFILADE_PYTEST names a
# folder made by "pip install --target FOLDER pytest".
if os.environ.get("ENFILADE_PYTEST"):
    sys.path.append(os.environ["ENFILADE_PYTEST"])
try:
    import pytest
except ImportError:
    sys.exit("pytest is not in this Blender's Python: use Debian's Blender, or name a folder with it in ENFILADE_PYTEST")

for folder in (ROOT / "python_shim", ROOT / "plugin", ROOT / "tests"):
    sys.path.insert(0, str(folder))
arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
named = any(".py" in argument for argument in arguments)
code = pytest.main(["-q", "-p", "no:cacheprovider", f"--rootdir={ROOT}", *arguments, *([] if named else [str(HERE)])])
sys.stdout.flush()
if code:
    raise SystemExit(int(code))
