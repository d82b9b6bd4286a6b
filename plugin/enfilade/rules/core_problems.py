# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core complains of, in the building's names and with what a person can do. Numbers: csrc/scene/problems.h."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from .building import ERROR, Problem

MANY = 12  # of one kind and more are told as one: who reads a thousand lines finds none

# code: (name, remedy)
KNOWN: dict[int, tuple[str, str]] = {
    1: ("not-finite", "Look for broken coordinates in its mesh."),
    2: ("dangling-index", ""),
    3: ("unknown-kind", ""),
    4: ("bad-bounds", "Look for broken coordinates in its mesh."),
    5: ("bad-camera", "Check the camera's lens and clip distances."),
    6: ("far-coordinate", "Move the model near the origin."),
    20: ("portal-without-polygon", "Draw the opening with an area."),
    21: ("portal-one-side", "Let the opening lie between two rooms."),
    22: ("portal-without-area", "Draw the opening with an area."),
    23: ("portal-double-corner", ""),
    24: ("portal-bent", "Flatten the opening's ends."),
    25: ("portal-not-convex", "Draw the opening convex, or as several."),
    26: ("portal-double", "Remove one of the two openings."),
    27: ("portal-off-room", "Move the opening to the room's face, or let the room reach it."),
    28: ("portal-orientation", "Check on which sides of the opening its rooms lie."),
    29: ("portal-inside-room", "Let the room end at the opening: one who stands beyond it there looks past it."),
    40: ("cell-bad-face", "Clean the room's mesh (merge by distance)."),
    41: ("cell-open", "Close the room's mesh."),
    42: ("cell-not-convex", ""),
    43: ("cell-flat", "Give the room a volume."),
    44: ("cell-inside-out", "Recalculate the room's normals outside."),
    46: ("rooms-overlap", "Let the rooms end where the other begins."),
    47: ("room-without-opening", "Nothing is seen of it from outside: does a door lack?"),
    48: ("cell-bent-face", "Flatten the room's faces."),
    60: ("room-empty", "Draw the room's air as a closed mesh."),
    61: ("opening-unused", "Let the opening lie between two rooms."),
    62: ("object-unplaced", "It lies in no room and always counts as seen: is a room missing there?"),
    63: ("room-open-mesh", "Close the room's mesh: Check Marks offers to."),
    64: ("room-bent-face", "Flatten the room's faces: Check Marks offers to."),
    65: ("room-as-hull", "Simplify the room's mesh: it crosses itself or has too many faces."),
    66: ("portal-outside-room", "Draw the opening no larger than the room's face there."),
    67: ("exterior-whole", "Nothing to mend: views from outdoors keep a little more."),
    68: ("room-curved", "Nothing to mend: a little more is kept beside curved walls."),
    80: ("scene-empty", "Mark rooms, or name an IFC file."),
    82: ("more", ""),
}

TOLD_BEFORE = {61, 63}  # what the rules say better, with the remedy that fits, of a room or an opening they speak of


def code_of(number: int) -> str:
    known = KNOWN.get(number)
    return f"core-{known[0]}" if known else f"core-{number}"


def remedy_of(number: int) -> str:
    known = KNOWN.get(number)
    return known[1] if known else ""


def reword(message: str, subject: str, rooms_of_cells: Sequence[str] = ()) -> str:
    """The core's sentence with names for numbers. subject: what it is about, in the building's words; "" leaves it. rooms_of_cells: the
    name of each cell's room."""

    def room(cell: re.Match) -> str:
        i = int(cell[1])
        return f"room '{rooms_of_cells[i]}'" if i < len(rooms_of_cells) and rooms_of_cells[i] else cell[0]

    if subject:
        message = re.sub(r"\bcell (\d+)\b(?!:)", room, message)
    message = re.sub(r'\broom \d+ \("([^"]*)"\)', r"room '\1'", message)
    return re.sub(r'^(portal|cell|room|opening|object) \d+(: "[^"]*")?', subject, message) if subject else message


def gathered(problems: Sequence[Problem]) -> list[Problem]:
    """The same in the order of their first; of warnings and notes of which there are MANY of a kind the worst alone, with how many there are and
    the names of all, worst first."""
    kinds: dict[tuple[str, str], list[Problem]] = {}
    for p in problems:
        kinds.setdefault((p.code, p.severity), []).append(p)
    result: list[Problem] = []
    for (_, severity), same in kinds.items():
        if severity == ERROR or len(same) < MANY:
            result += same
            continue
        same = sorted(same, key=lambda p: -_size(p.message))
        names = list(dict.fromkeys(n for p in same for n in p.names))
        result.append(replace(same[0], message=f"{len(same)} times; the worst: {same[0].message}", names=names))
    return result


def _size(message: str) -> float:
    """The measure that a sentence of the core tells: metres, cubic metres, per cent."""
    found = re.search(r"([0-9][0-9.e+-]*) (?:m3|m2|m|%)(?![a-z])", message)
    return float(found[1]) if found else 0.0
