# SPDX-License-Identifier: GPL-3.0-or-later
"""What Detect found, beside what it had found before."""

from __future__ import annotations

import pytest
from enfilade.rules import building as b
from enfilade.rules.tally import Change, Tally


def test_counts_and_words() -> None:
    building = b.Building("made", rooms=[b.Room("A"), b.Room("Out", b.EXTERIOR)])
    building.openings = [b.Opening("D1", rooms=(0, 1)), b.Opening("D2")]
    problems = [b.Problem(b.INFO, "x", ""), b.Problem(b.WARNING, "y", ""), b.Problem(b.ERROR, "z", "")]
    now = Tally.of(building, problems)
    assert now == Tally(1, 2, 1, 2)
    change = Change(now, Tally(0, 1, 1, 2))
    assert change.sentence() == "rooms 1 (was 0), openings 1 of 2 joined (was 1), problems 2"
    assert Change(now, Tally()).sentence() == "rooms 1, openings 1 of 2 joined, problems 2"
    assert Change(now, now).figures() == {"Rooms": "1", "Openings": "1 of 2 joined", "Problems": "2"}
    assert Change.from_text(change.to_text()) == change
    assert Change(Tally(), Tally()).sentence() == ""


@pytest.mark.parametrize("text", ["", "{", "[]", '{"now": 3}', '{"now": {}, "before": {"rooms": "many"}}'])
def test_a_damaged_note_counts_as_none(text: str) -> None:
    assert Change.from_text(text) == Change(Tally(), Tally())
