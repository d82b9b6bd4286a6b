# SPDX-License-Identifier: GPL-3.0-or-later
"""What Detect found in a few numbers, and the same of the time before: what a change to the model did. No bpy."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from .building import INFO, INTERIOR, Building, Problem


@dataclass
class Tally:
    """All zero: nothing was detected yet."""

    rooms: int = 0
    openings: int = 0
    joined: int = 0  # of these, to two rooms or to the outdoors
    problems: int = 0  # errors and warnings

    @staticmethod
    def of(building: Building, problems: Sequence[Problem]) -> Tally:
        return Tally(
            sum(r.kind == INTERIOR for r in building.rooms),
            len(building.openings),
            sum(o.rooms is not None for o in building.openings),
            sum(p.severity != INFO for p in problems),
        )


@dataclass
class Change:
    now: Tally
    before: Tally

    def figures(self) -> dict[str, str]:
        """By Rooms, Openings and Problems: "21 (was 20)", or "21" where nothing changed or this Detect is the first."""
        now, before = self.now, self.before if self.before != Tally() else self.now

        def was(text: str, old: str) -> str:
            return text if text == old else f"{text} (was {old})"

        return {
            "Rooms": was(str(now.rooms), str(before.rooms)),
            "Openings": was(_joined(now), _joined(before)),
            "Problems": was(str(now.problems), str(before.problems)),
        }

    def sentence(self) -> str:
        """Empty when nothing was detected."""
        return "" if self.now == Tally() else ", ".join(f"{name.lower()} {text}" for name, text in self.figures().items())

    def to_text(self) -> str:
        return json.dumps({"now": asdict(self.now), "before": asdict(self.before)})

    @staticmethod
    def from_text(text: str) -> Change:
        """What can't be read counts as nothing detected: these are numbers to look at, no more."""
        try:
            given = json.loads(text)
            names = [f.name for f in fields(Tally)]
            return Change(*(Tally(**{n: int(given[side][n]) for n in names}) for side in ("now", "before")))
        except (ValueError, TypeError, KeyError):
            return Change(Tally(), Tally())


def _joined(tally: Tally) -> str:
    return str(tally.openings) if tally.joined == tally.openings else f"{tally.joined} of {tally.openings} joined"
