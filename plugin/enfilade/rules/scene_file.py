# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings from a scene file (*.enf.json): each cell of a room is a room of its own, seams are virtual openings.

A room of one cell keeps its name; the cells of others are numbered (`Hall 1`, `Hall 2`). A cell of an opening with two
portals becomes the opening's body again.
"""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from .building import EXTERIOR, OPEN, VIRTUAL, WARNING, Building, Opening, Problem, Room


class SceneFileError(ValueError):
    """The file isn't a scene with cells; the message says why."""


def read(path: str | Path) -> Building:
    """The building in a scene file. SceneFileError names the file and the reason."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise SceneFileError(f"{path} can't be read: {error}") from error
    if not isinstance(data, dict) or data.get("format") != "enfilade-scene" or data.get("version") != 1:
        raise SceneFileError(f"{path} isn't a scene file of version 1")
    try:
        return _building(data)
    except (KeyError, TypeError, IndexError, ValueError) as error:
        raise SceneFileError(f"{path} is damaged: {error!r}") from error


def _building(data: dict[str, Any]) -> Building:
    out = Building(source="scene file")
    where, of_whole = _add_rooms(out, data)
    for cell, found in _add_openings(out, data, where, of_whole).items():
        _add_passage(out, data, cell, found)
    if not any(r.vertices is not None for r in out.rooms):
        raise ValueError("it has no cells with a shape")
    return out


def _add_rooms(out: Building, data: dict[str, Any]) -> tuple[dict[int, int], dict[int, int]]:
    """Rooms here by cell of the file, and by room of the file that is one room here."""
    cells = data.get("cells", [])
    of_room: dict[int, list[int]] = defaultdict(list)
    for c, cell in enumerate(cells):
        if cell.get("room") is not None:
            of_room[cell["room"]].append(c)
    where: dict[int, int] = {}
    of_whole: dict[int, int] = {}
    for r, room in enumerate(data.get("rooms", [])):
        mine = of_room[r]
        drawn = _drawn(room, out)
        if drawn is not None and not mine:
            of_whole[r] = len(out.rooms)
            out.rooms.append(drawn)
        elif room.get("kind") == EXTERIOR:
            of_whole[r] = len(out.rooms)
            where.update(dict.fromkeys(mine, len(out.rooms)))
            out.rooms.append(Room(room["name"], EXTERIOR))
        else:
            for number, c in enumerate(mine, 1):
                made = _cell_room(out, c, cells[c], room["name"], f" {number}" * (len(mine) > 1))
                if made is not None:
                    where[c] = len(out.rooms)
                    out.rooms.append(made)
    return where, of_whole


def _cell_room(out: Building, number: int, cell: dict[str, Any], name: str, suffix: str) -> Room | None:
    vertices = np.array(cell.get("vertices", []), dtype=np.float64).reshape(-1, 3)
    if len(vertices) < 4 or not np.isfinite(vertices).all():
        message = f"cell {number} of '{name}' has no volume and is left out"
        out.problems.append(Problem(WARNING, "room-without-geometry", message, [name]))
        return None
    faces = cell.get("faces")
    return Room(f"{name}{suffix}", vertices=vertices, faces=[[int(i) for i in f] for f in faces] if faces else None)


# The portals of a cell of an opening: the room each leads to, its polygon, and the opening's own entry.
Ends = list[tuple[int, np.ndarray, Any]]


def _add_openings(out: Building, data: dict[str, Any], where: dict[int, int], of_whole: dict[int, int]) -> dict[int, Ends]:
    """Those between two rooms. Returns what leads into cells of openings, by cell."""
    openings = data.get("openings", [])
    ends: dict[int, Ends] = defaultdict(list)
    for n, portal in enumerate(data.get("portals", [])):
        if "sides" in portal:
            sides = [of_whole.get(s["room"]) if "room" in s else where.get(s["cell"]) for s in portal["sides"]]
        else:
            sides = [where.get(c) for c in portal["cells"]]
        a, b = portal.get("cells", (None, None))
        polygon = np.array(portal["polygon"], dtype=np.float64).reshape(-1, 3)
        known = openings[portal["opening"]] if portal.get("opening") is not None else None
        if sides[0] is not None and sides[1] is not None:
            if sides[0] != sides[1]:
                name = known["name"] if known else f"{out.rooms[sides[0]].name} | {out.rooms[sides[1]].name}"
                kind = known.get("kind", VIRTUAL) if known else VIRTUAL
                state = known.get("state", OPEN) if known else OPEN
                out.openings.append(Opening(name, kind, state, rooms=(sides[0], sides[1]), polygon=polygon))
        elif a in where or b in where:
            inner, cell = (a, b) if a in where else (b, a)
            ends[cell].append((where[inner], polygon, known))
        else:
            out.problems.append(Problem(WARNING, "opening-no-room", f"portal {n} joins two cells that belong to no room", []))
    return ends


def _add_passage(out: Building, data: dict[str, Any], cell: int, ends: Ends) -> None:
    """A cell of an opening as that opening's body. Where it meets several cells of a room it has several portals on a side: one
    opening for each pair."""
    known = ends[0][2] or {"name": f"Opening {cell}"}
    if len(ends) < 2:
        out.problems.append(Problem(WARNING, "opening-no-room", f"'{known['name']}' has one portal only; it joins nothing", [known["name"]]))
        return
    body = np.array(data["cells"][cell].get("vertices") or np.concatenate([p for _, p, _ in ends]), dtype=np.float64).reshape(-1, 3)
    normal = _normal(ends[0][1])
    middle = float(normal @ body.mean(axis=0))
    sides: dict[bool, list[int]] = defaultdict(list)
    for k, (_, polygon, _) in enumerate(ends):
        sides[float(normal @ polygon.mean(axis=0)) < middle].append(k)
    low, high = sides.values() if len(sides) == 2 else ([0], range(1, len(ends)))
    for i in low:
        for j in high:
            if ends[i][0] != ends[j][0]:
                out.openings.append(
                    Opening(known["name"], known.get("kind", "hole"), known.get("state", OPEN), rooms=(ends[i][0], ends[j][0]),
                            body=body, ends=(ends[i][1], ends[j][1]))
                )  # fmt: skip


def _drawn(room: dict[str, Any], out: Building) -> Room | None:
    """A room that the file draws as a mesh or a prism; None when it has neither."""
    if "mesh" in room:
        vertices = np.array(room["mesh"]["vertices"], dtype=np.float64).reshape(-1, 3)
        return Room(room["name"], vertices=vertices, faces=[[int(i) for i in f] for f in room["mesh"]["faces"]])
    if "prism" not in room:
        return None
    prism = room["prism"]
    ring = np.array(prism["outline"], dtype=np.float64).reshape(-1, 2)
    if float(ring[:, 0] @ np.roll(ring[:, 1], -1) - ring[:, 1] @ np.roll(ring[:, 0], -1)) < 0.0:
        ring = ring[::-1]
    if prism.get("holes"):
        message = f"room '{room['name']}' has {len(prism['holes'])} holes in its plan; they are taken as part of it"
        out.problems.append(Problem(WARNING, "room-holes", message, [room["name"]], remedy="draw the room as a mesh"))
    n = len(ring)
    vertices = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in prism["z"]])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return Room(room["name"], vertices=vertices, faces=[list(range(n))[::-1], list(range(n, 2 * n)), *sides])


def _normal(polygon: np.ndarray) -> np.ndarray:
    a = polygon - polygon.mean(axis=0)
    normal = np.cross(a, np.roll(a, -1, axis=0)).sum(axis=0)
    return normal / (np.linalg.norm(normal) or 1.0)
