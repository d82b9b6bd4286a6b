# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the helpers beside these tests importable, and the package from the source tree."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
for folder in (HERE, HERE.parents[1] / "python_shim"):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
