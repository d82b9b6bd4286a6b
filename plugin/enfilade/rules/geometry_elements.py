# SPDX-License-Identifier: GPL-3.0-or-later
"""What bare geometry is given as: drawn things with a class, or without one; and which class a thing's name tells."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .building import DOOR, HOLE, WINDOW
from .probing import Frame, Passage

SHELL = "shell"  # walls, slabs, roofs, columns, ceilings: what can part rooms
STAIR, FURNITURE, SITE, UNKNOWN = "stair", "furniture", "site", "unknown"
OPENINGS = (DOOR, WINDOW, HOLE)
KINDS = (SHELL, DOOR, WINDOW, HOLE, STAIR, FURNITURE, SITE, UNKNOWN)

# Words in the names of objects, collections and IFC classes. The first that fits wins: a "door frame" is no frame of a wall,
# a "curtain wall" is a wall, a "wall cabinet" is furniture.
_WORDS = (
    (SITE, r"site|terrain|topograph|ground ?plane|landscape|gelände"),
    (FURNITURE, r"furni|cabinet|sanitary|flow ?(terminal|segment|fitting|controller)|distribution|chair|table\b|desk|sofa|\bbed\b|lamp|"
                r"light ?fixture|toilet|sink|appliance|plant\b|curtain\b(?! ?wall)|shelf|shelv|möbel"),
    (STAIR, r"stair|ramp|railing|handrail|balust|treppe|geländer|escalator|transport"),
    (DOOR, r"door|gate\b|\btür|porte"),
    (WINDOW, r"window|skylight|fenster|glazing|\bglass"),
    (HOLE, r"opening"),
    (SHELL, r"wall|slab|floor|roof|ceiling|covering|column|beam|footing|foundation|plate|member|pillar|partition|facade|"
            r"chimney|building ?element|wand|decke|dach|boden|stütze"),
)  # fmt: skip
_PATTERNS = tuple((kind, re.compile(words, re.IGNORECASE)) for kind, words in _WORDS)


def kind_of(name: str) -> str:
    """The class that a name tells; UNKNOWN when none. Camel case and underscores part words."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])|[_./:-]+|\d+", " ", name)
    for kind, pattern in _PATTERNS:
        if pattern.search(spaced):
            return kind
    return UNKNOWN


@dataclass
class Element:
    """One drawn thing. vertices: float64 (n, 3), world metres; triangles: int (m, 3). passage: for an opening whose way
    through the wall is known (a void); else it is found from the mesh."""

    name: str
    kind: str
    vertices: np.ndarray
    triangles: np.ndarray
    source_id: str = ""
    state: str = ""
    storey: str = ""
    passage: Passage | None = None

    @property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        return self.vertices, self.triangles

    def moved(self, rotation: np.ndarray, offset: np.ndarray) -> Element:
        """Turned by `rotation` (3, 3), then moved."""
        return replace(
            self,
            vertices=self.vertices @ rotation.T + offset,
            passage=None if self.passage is None else move_passage(self.passage, rotation, offset),
        )


def move_passage(p: Passage, rotation: np.ndarray, offset: np.ndarray) -> Passage:
    f = p.frame
    frame = Frame(rotation @ f.origin + offset, rotation @ f.u, rotation @ f.v, rotation @ f.n)
    return Passage(frame, p.section, p.void, p.host, p.cuts)


def soup(elements: Sequence[Element]) -> Element:
    """Everything drawn as one mesh without classes. Openings that are only known (voids), not drawn, aren't in it."""
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for e in elements:
        if e.passage is not None and e.kind == HOLE:
            continue
        vertices.append(e.vertices)
        triangles.append(np.asarray(e.triangles, dtype=np.int64) + count)
        count += len(e.vertices)
    return Element("soup", UNKNOWN, np.concatenate(vertices), np.concatenate(triangles))
