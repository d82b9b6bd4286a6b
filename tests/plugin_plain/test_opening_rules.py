# SPDX-License-Identifier: GPL-3.0-or-later
"""States of openings by rule: the most particular wins, mistakes are told, what no rule reaches stays."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import opening_rules as rules
from enfilade.rules.building import Building, Opening, Room


def _building(source: str = "annotated") -> Building:
    out = Building(source, rooms=[Room("Hall", storey="Ground"), Room("Bed", storey="Upper"), Room("Exterior", "exterior")])
    square = np.zeros((4, 3))
    out.openings = [
        Opening("D1", "door", "open", "guid1", (0, 1), polygon=square),
        Opening("D2", "door", "open", "guid2", (0, 2), polygon=square),
        Opening("W1", "window", "glass", "guid3", (1, 2), polygon=square),
        Opening("Hall | Bed", "virtual", "open", "", (0, 1), polygon=square),
        Opening("Lost", "door", "open", "", None),
    ]
    return out


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([], "open open glass open open"),
        (["D1=closed"], "closed open glass open open"),
        (["guid3=closed"], "open open closed open open"),
        (["doors=closed"], "closed closed glass open closed"),
        (["class:window=open"], "open open open open open"),
        (["class:IfcDoorStandardCase=glass"], "glass glass glass open glass"),
        (["storey:Upper=closed"], "closed open closed open open"),  # not what has no wall
        (["storey:Upper=closed", "W1=open", "class:door=glass"], "closed glass open open glass"),
        (["storey:Upper=closed", "storey:Ground=open"], "open open closed open open"),  # between two storeys: the more open
        (["doors=closed", "D2=open"], "closed open glass open closed"),
    ],
)
def test_the_most_particular_rule_wins(given: list[str], expected: str) -> None:
    building = _building()
    rules.apply(building, rules.parse(given))
    assert " ".join(o.state for o in building.openings) == expected


def test_ifc_doors_are_left_to_the_reader_that_knows_glass() -> None:
    building = _building("ifc")
    assert rules.apply(building, {"doors": "closed"}) == 0 and rules.of_ifc({"doors": "closed"}).doors == "closed"


@pytest.mark.parametrize("text", ["D1", "=open", "D1=ajar", "doors=glass", "class:roof=open"])
def test_a_rule_that_cannot_be_read_is_named(text: str) -> None:
    with pytest.raises(ValueError, match=text.replace("|", ".")):
        rules.parse([text])


def test_rules_are_kept_as_text_and_strays_are_told() -> None:
    given = rules.parse(["D1=closed", "storey:Attic=open", "Nobody=open", "class:hole=closed", "a=b=open"])
    assert rules.from_text(rules.to_text(given)) == given and rules.from_text("") == {}
    assert rules.unmatched(_building(), given) == ["storey:Attic", "Nobody", "a=b"]
    with pytest.raises(ValueError, match="damaged"):
        rules.from_text("[1]")
