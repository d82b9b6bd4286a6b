# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples of python_shim/README.md run as they stand there."""

from __future__ import annotations

import re

import c_headers


def test_the_examples_run(capsys):
    page = (c_headers.ROOT / "python_shim" / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len(blocks) == 2
    exec(compile("".join(blocks), "python_shim/README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "[0 1]" in printed  # both rooms are seen through the door
    assert "Witness(" in printed
