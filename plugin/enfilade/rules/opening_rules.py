# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's say over the state of doors and windows, whatever the building came from: by opening, by storey, by class.

Written as `KEY=STATE`: `D01=closed` (name or GlobalId), `storey:Level 1=closed`, `class:window=open` (or `class:IfcDoor`),
`doors=closed` (every door without a say of its own). The most particular rule wins. What a rule doesn't reach stays as
it was found, which errs to open.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping

from .building import CLOSED, DOOR, GLASS, HOLE, OPEN, VIRTUAL, WINDOW, Building, Opening
from .ifc_states import DoorStates

STATES = (OPEN, CLOSED, GLASS)
_CLASSES = {"ifcdoor": DOOR, "ifcwindow": WINDOW, "ifccurtainwall": WINDOW, "ifcopeningelement": HOLE}
KINDS = (DOOR, WINDOW, HOLE, VIRTUAL)


def parse(rules: Iterable[str]) -> dict[str, str]:
    """`KEY=STATE` texts to a mapping; ValueError names the one that can't be read."""
    result: dict[str, str] = {}
    for rule in rules:
        key, equals, state = rule.rpartition("=")
        key, state = key.strip(), state.strip().lower()
        if not equals or not key:
            raise ValueError(f"'{rule}' isn't KEY=STATE (as in D01=closed, storey:Level 1=closed, class:door=open, doors=closed)")
        if state not in STATES:
            raise ValueError(f"'{rule}': a state is one of {', '.join(STATES)}")
        if key == "doors" and state == GLASS:
            raise ValueError(f"'{rule}': doors are open or closed by default; those of glass are found by themselves")
        scope, colon, name = key.partition(":")
        if colon and scope == "class" and kind_of(name) not in KINDS:
            raise ValueError(f"'{rule}': a class is one of {', '.join(KINDS)}, or an IFC class")
        result[key] = state
    return result


def kind_of(name: str) -> str:
    """The kind of opening that a class name means."""
    lowered = name.strip().lower()
    for prefix, kind in _CLASSES.items():
        if lowered.startswith(prefix):
            return kind
    return lowered


def to_text(rules: Mapping[str, str]) -> str:
    return json.dumps(dict(rules), ensure_ascii=False, sort_keys=True)


def from_text(text: str) -> dict[str, str]:
    """ValueError for anything that isn't such rules."""
    try:
        data = json.loads(text) if text else {}
        return parse(f"{key}={state}" for key, state in data.items())
    except (AttributeError, json.JSONDecodeError) as error:
        raise ValueError(f"the stored states of openings are damaged: {error}") from error


def of_ifc(rules: Mapping[str, str]) -> DoorStates:
    """What the IFC reader has to know itself: it alone can tell a glazed door from an opaque one."""
    return DoorStates(doors=rules.get("doors", OPEN))


def state_of(building: Building, opening: Opening, rules: Mapping[str, str]) -> str | None:
    """What the rules say of an opening; None: nothing."""
    for key in (opening.source_id, opening.name):
        if key and key in rules:
            return rules[key]
    if opening.kind != VIRTUAL and opening.rooms is not None:
        said = [s for r in opening.rooms if (s := rules.get(f"storey:{building.rooms[r].storey}")) is not None]
        if said:
            return OPEN if OPEN in said else said[0]  # between two storeys: the more open one
    for key, state in rules.items():
        scope, colon, name = key.partition(":")
        if colon and scope == "class" and kind_of(name) == opening.kind:
            return state
    return None


def most_open(openings: Iterable[Opening]) -> str:
    return min((o.state for o in openings), key=(OPEN, GLASS, CLOSED).index)


def apply(building: Building, rules: Mapping[str, str]) -> int:
    """Sets the states; returns how many changed. `doors=closed` closes doors that stand open here unless the building
    came from IFC, whose reader has done it. What several openings share follows them: nothing is said of it alone."""
    changed = 0
    for opening in sorted(building.openings, key=lambda o: len(o.members)):
        if opening.members:
            state = most_open(building.openings[i] for i in opening.members)
        else:
            state = state_of(building, opening, rules)
        if state is None and opening.kind == DOOR and opening.state == OPEN and building.source != "ifc":
            state = rules.get("doors")
        if state is not None and state != opening.state:
            opening.state = state
            changed += 1
    return changed


def unmatched(building: Building, rules: Mapping[str, str]) -> list[str]:
    """Keys that name nothing in this building."""
    known = {"doors"} | {o.name for o in building.openings} | {o.source_id for o in building.openings if o.source_id}
    known |= {f"storey:{r.storey}" for r in building.rooms}
    return [k for k in rules if k not in known and not k.startswith("class:")]
