# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual portals of an IFC building: between spaces that touch, and where a space is open to what no space claims."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from . import face_view, ifc_reveals, ifc_shapes, touching
from .blockers import Blockers
from .building import INFO, OPEN, VIRTUAL, WARNING, Opening, Problem
from .ifc_openings import Context, Outcome
from .ifc_shapes import Cancelled

TOLD_AREA = 0.25  # m2 of open boundary from which on a room's leak to the exterior is worth a line


def _reveals(context: Context, blockers: Blockers) -> list[touching.OpenPart]:
    """What rooms see out of the sides of passages; told as problems."""
    result = []
    for index, passage in context.passages.items():
        opening = context.openings[index]
        if context.exterior in opening.rooms:
            continue
        t = passage.frame.local(opening.body)[:, 2]
        depths = (float(t.min()), float(t.max()))
        for leak in ifc_reveals.leaks(passage, depths, context.solids, context.near(passage), blockers):
            if leak.room in opening.rooms:
                continue
            for room, end in zip(opening.rooms, opening.ends, strict=True):
                pair = sorted((room, leak.room)) if leak.room >= 0 else (room, -1)
                result.append(touching.OpenPart(*pair, end, leak.area, passage.frame.n))
            beyond = "the exterior" if leak.room < 0 else f"room '{context.rooms[leak.room].name}'"
            context.problems.append(
                Problem(
                    INFO, "opening-open-beside",
                    f"{opening.kind} '{opening.name}' has no wall or slab beside it over {leak.area:.2f} m2: {beyond} is "
                    "seen there", [opening.name], tuple(float(x) for x in leak.position),
                    "draw the slab, sill or lintel that closes the opening's recess",
                )
            )  # fmt: skip
    return result


def open_parts(context: Context, blockers: Blockers, progress: ifc_shapes.Progress | None) -> list[touching.OpenPart]:
    """What neither walls nor known openings cover of the rooms' boundaries."""
    ends: list[list[np.ndarray]] = [[] for _ in context.solids]
    for index, opening in enumerate(context.openings):
        if opening.rooms is None:
            continue
        for side, room in enumerate(opening.rooms):
            if room < len(ends):
                end = opening.ends[side] if opening.ends is not None else opening.polygon
                ends[room].append(context.narrow.get((index, room), end))

    def step(fraction: float) -> bool:
        if progress is not None and progress(fraction, "open boundaries") is False:
            raise Cancelled("open boundaries")
        return True

    return touching.find(context.solids, blockers, ends, step)


def add(context: Context, blockers: Blockers, progress: ifc_shapes.Progress | None) -> None:
    """Finds open parts of the rooms' boundaries and adds them as virtual openings, with a Problem per room or pair."""
    found: dict[tuple[int, int], list[touching.OpenPart]] = defaultdict(list)
    for part in [*open_parts(context, blockers, progress), *_reveals(context, blockers)]:
        found[(part.room, part.other)].append(part)
    corners = [solid.vertices.mean(axis=0) for solid in context.solids]
    centre = np.mean(corners, axis=0) if corners else np.zeros(3)

    def order(part: touching.OpenPart) -> tuple[float, float]:
        """Largest first; equal ones by what doesn't change when the model is moved or turned."""
        away = float(np.linalg.norm(part.polygon.mean(axis=0) - centre))
        return (-round(part.area + face_view.OFF_ROUND, 2), round(away + face_view.OFF_ROUND, 3))

    for (i, j), parts in sorted(found.items()):
        other = context.exterior if j < 0 else j
        names = [context.rooms[i].name, context.rooms[other].name]
        area = sum(p.area for p in parts)
        for number, part in enumerate(sorted(parts, key=order)):
            name = " | ".join(names)
            name = name if number == 0 else f"{name} ({number + 1})"
            context.openings.append(
                Opening(name, VIRTUAL, OPEN, "", (i, other), polygon=part.polygon)
            )
        context.outcomes.append(
            Outcome(" | ".join(names), VIRTUAL, "", "joined" if j >= 0 else "exterior", [(i, other)])
        )
        if not all(p.followed for p in parts):
            context.problems.append(
                Problem(
                    INFO, "room-crowded",
                    f"so much is drawn behind the faces of room '{names[0]}' that air there wasn't followed: it counts as open", names[:1],
                )
            )  # fmt: skip
        largest = max(parts, key=lambda p: p.area)
        position = tuple(float(x) for x in largest.polygon.mean(axis=0))
        if j >= 0:
            message = f"rooms '{names[0]}' and '{names[1]}' touch with no wall between over {area:.1f} m2: virtual portal"
            context.problems.append(Problem(INFO, "rooms-touch", message, names, position))
        elif area >= TOLD_AREA:
            message = f"room '{names[0]}' is open over {area:.1f} m2: nothing is drawn within 0.1 m behind its boundary"
            context.problems.append(
                Problem(
                    WARNING if area > 1.0 else INFO, "room-open", message, names[:1], position,
                    "draw the missing wall, slab or ceiling, or let the space reach to it",
                )
            )  # fmt: skip
