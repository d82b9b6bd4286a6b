# SPDX-License-Identifier: GPL-3.0-or-later
"""Voids of one wall that touch or overlap: a look may go in by one and out by the other, through neither from end to end.

Two doors side by side in one hole, a window drawn into its door's jamb: between them is air. For each pair of rooms that such
voids join together an opening is added that holds them all, never smaller than their air.
"""

from __future__ import annotations

import numpy as np

from . import convex_polygons as cp
from .box_index import BoxIndex
from .building import HOLE, Opening
from .ifc_openings import Context
from .opening_rules import most_open
from .probing import Passage

MEETS = 1e-3  # m: voids nearer than this are one air, for models are drawn to the millimetre
PARALLEL = 0.9994  # cosine of 2 degrees


def add(context: Context, drawn: dict[int, Passage] | None = None) -> None:
    """Adds the openings that touching voids make together. drawn: the voids, by opening, whose walls aren't known; None: those of known walls."""
    if drawn is None:
        drawn = {i: p for i, p in context.passages.items() if p.wall is not None}
    for group in _groups(drawn):
        frame = context.passages[group[0]].frame
        middle = np.mean([np.mean(context.passages[g].host) for g in group])
        sides: tuple[dict[int, dict[int, np.ndarray]], ...] = ({}, {})  # room -> opening -> its end, in the frame
        for index in group:
            opening = context.openings[index]
            local = [frame.local(end) for end in opening.ends]
            low = 0 if local[0][:, 2].mean() <= local[1][:, 2].mean() else 1
            for side, which in ((0, low), (1, 1 - low)):
                sides[side].setdefault(opening.rooms[which], {})[index] = local[which]
        for a, lows in sides[0].items():
            for b, highs in sides[1].items():
                if a != b and len(lows.keys() | highs.keys()) > 1:
                    _add(context, group, (a, lows, max, middle), (b, highs, min, middle))


def _groups(passages: dict[int, Passage]) -> list[list[int]]:
    """Openings whose voids hang together, two at least each, by index."""
    left = list(passages)
    if not left:
        return []
    boxes = BoxIndex(np.array([passages[i].low for i in left]) - MEETS, np.array([passages[i].high for i in left]) + MEETS)
    known: dict[int, list[int]] = {}  # the group of each opening
    for index in left:
        group = known.setdefault(index, [index])
        near = [left[k] for k in boxes.near(passages[index].low, passages[index].high).tolist()]
        for other in near:
            theirs = known.setdefault(other, [other])
            if theirs is not group and passages[other].wall is passages[index].wall and _meet(passages[index], passages[other]):
                group += theirs
                known.update((i, group) for i in theirs)
    groups = [sorted(g) for g in {id(g): g for g in known.values()}.values()]
    return [g for g in groups if len({id(passages[i]) for i in g}) > 1]


def _meet(passage: Passage, other: Passage) -> bool:
    """Whether two passages are one, or their voids share air inside their wall."""
    if passage is other:
        return True
    if (passage.low > other.high + MEETS).any() or (passage.high < other.low - MEETS).any():
        return False
    if abs(passage.frame.n @ other.frame.n) < PARALLEL:
        return False
    local = passage.frame.local(other.corners)
    depth = min(local[:, 2].max(), passage.void[1], passage.host[1]) - max(local[:, 2].min(), passage.void[0], passage.host[0])
    return depth > MEETS and bool(cp.clip(cp.grow(passage.section, MEETS), cp.hull((x, y) for x, y, _ in local)))


def _add(context: Context, group: list[int], low: tuple, high: tuple) -> None:
    frame = context.passages[group[0]].frame
    ends = []
    for room, found, nearest, middle in (low, high):
        local = np.concatenate(list(found.values()))
        # Across the passage where the nearest end is: each look between the rooms crosses it before it meets the others.
        t = float(nearest(local[:, 2]))
        spread = float(np.abs(local[:, 2] - t).max())
        outline = cp.limit_corners(cp.grow(cp.hull((x, y) for x, y, _ in local), spread), 24)
        t = min(t, middle) if nearest is max else max(t, middle)
        ends.append((room, frame.world(np.array([(x, y, t) for x, y in outline]))))
    ends.sort(key=lambda e: e[0])
    indices = tuple(sorted(low[1].keys() | high[1].keys()))
    members = [context.openings[i] for i in indices]
    kinds = {m.kind for m in members}
    joint = Opening(
        " + ".join(dict.fromkeys(m.name for m in members)), members[0].kind if len(kinds) == 1 else HOLE,
        most_open(members), rooms=(ends[0][0], ends[1][0]), members=indices,
    )  # fmt: skip
    joint.ends = (ends[0][1], ends[1][1])
    joint.body = np.concatenate(joint.ends)
    context.openings.append(joint)
