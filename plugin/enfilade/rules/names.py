# SPDX-License-Identifier: GPL-3.0-or-later
"""What people call rooms and openings: the same words in the panel, in pictures and in the report. No bpy."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

from .building import Building

_FAMILY_TYPE_NUMBER = re.compile(r"[^:]+(?::[^:]+)+:(\d+(?: \(\d+\))?)")


class Names:
    """Of one building; what the names have in common is looked at once."""

    def __init__(self, building: Building):
        self.building = building
        self._long_names = Counter(r.long_name for r in building.rooms)
        self._shared_word = _shared_start([o.name for o in building.openings])

    def room(self, index: int) -> str:
        """Its long name where that is its alone, else name and long name."""
        room = self.building.rooms[index]
        if room.long_name and room.long_name != room.name:
            shared = self._long_names[room.long_name] > 1
            return f"{room.name} {room.long_name}".strip() if shared else room.long_name
        return room.name or f"Room {index + 1}"

    def rooms(self) -> list[str]:
        return [self.room(i) for i in range(len(self.building.rooms))]

    def opening(self, index: int) -> str:
        """Without the word that all openings begin with ("Opening Hall-Kitchen"), and kind and number alone of an
        authoring tool's "Family:Type size:159834"."""
        opening = self.building.openings[index]
        made = _FAMILY_TYPE_NUMBER.fullmatch(opening.name)
        return f"{opening.kind} {made[1]}" if made else opening.name[self._shared_word :] or opening.name

    def way(self, openings: Iterable[int]) -> str:
        """A sequence of openings, as it is looked through."""
        return " \u203a ".join(self.opening(o) for o in openings)


def sentence(text: str) -> str:
    """As people write one: a capital first, square and cubic metres as signs."""
    text = re.sub(r"(?<=\d )m([23])\b", lambda found: "m" + "\u00b2\u00b3"[int(found[1]) - 2], text)
    return text[:1].upper() + text[1:]


def _shared_start(names: list[str]) -> int:
    """Length of the first word and the space after it, where every one of several names begins with it; else 0."""
    first = names[0].split(" ")[0] + " " if len(names) > 2 else " "
    return len(first) if len(first) > 1 and all(n.startswith(first) and len(n) > len(first) for n in names) else 0
