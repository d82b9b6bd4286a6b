# SPDX-License-Identifier: GPL-3.0-or-later
"""Every problem code of the core has a name here, and its sentences lose their numbers."""

from __future__ import annotations

import re
from pathlib import Path

from enfilade.rules import core_problems
from enfilade.rules.building import ERROR, WARNING, Problem

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
    overlap = core_problems.reword('room 1 ("B"): overlaps cell 2 by 10 m3; who stands there is in both', "", ["A", "A", "C"])
    assert "overlaps cell 2" in overlap  # of nobody known: left as the core says it
    overlap = core_problems.reword("cell 0: overlaps cell 2 by 10 m3", "room 'B'", ["B", "A", "C"])
    assert overlap == "room 'B': overlaps room 'C' by 10 m3"
    assert core_problems.reword('room 2: "C": its shape isn\'t closed', "room 'C'") == "room 'C': its shape isn't closed"
    assert core_problems.reword('opening 1: "Lost" has no portal', "door 'Lost'") == "door 'Lost' has no portal"


def test_many_of_a_kind_are_told_as_one() -> None:
    many = [Problem(WARNING, "core-rooms-overlap", f"room 'R{i}': overlaps cell 0 by {v:.3g} m3; who stands there is in both", [f"R{i}"], (i, 0.0, 0.0))
            for i, v in enumerate([0.01] * 20 + [0.5] + [0.02] * 20)]  # fmt: skip
    errors = [Problem(ERROR, "core-cell-open", "room 'X': is open", ["X"])] * 20
    few = [Problem(WARNING, "core-portal-bent", f"door 'D{i}': is 1 m out of plane", [f"D{i}"]) for i in range(3)]
    told = core_problems.gathered([*few, *many, *errors])
    assert told[:3] == few and told[4:] == errors
    assert told[3].message.startswith("41 times; the worst: room 'R20'") and told[3].names[0] == "R20" and len(told[3].names) == 41
    assert told[3].position == (20, 0.0, 0.0)
