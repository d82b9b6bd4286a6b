# SPDX-License-Identifier: GPL-3.0-or-later
"""Every problem code of the core has a name here, and its sentences lose their numbers."""

from __future__ import annotations

import re
from pathlib import Path

from enfilade.rules import core_problems

HEADER = Path(__file__).resolve().parents[2] / "csrc" / "scene" / "problems.h"


def test_every_code_of_the_core_has_a_name() -> None:
    codes = {int(n) for n in re.findall(r"ENF_PROBLEM_[A-Z_]+ = (\d+)", HEADER.read_text(encoding="utf-8"))}
    assert codes == set(core_problems.KNOWN)
    names = [name for name, _ in core_problems.KNOWN.values()]
    assert len(names) == len(set(names)) and all(re.fullmatch(r"[a-z-]+", n) for n in names)


def test_numbers_become_names() -> None:
    said = 'portal 106: 8 % of it lies outside of room 0 ("A101"); given to the nearest cell'
    assert core_problems.reword(said, "door 'D1'") == "door 'D1': 8 % of it lies outside of room 'A101'; given to the nearest cell"
    assert core_problems.reword(said, "").startswith("portal 106")
    assert core_problems.reword('room 2: "C": its shape isn\'t closed', "room 'C'") == "room 'C': its shape isn't closed"
    assert core_problems.reword('opening 1: "Lost" has no portal', "door 'Lost'") == "door 'Lost' has no portal"
