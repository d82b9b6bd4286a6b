# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees whom, as a picture: labelled squares for small buildings, one pixel a pair (or block of pairs) for large.

Rooms are ordered by storey, then as in the model. Where several pairs share a pixel the most visible one colours it.
"""

from __future__ import annotations

import numpy as np

from . import drawing as d
from .drawing import Drawing
from .metrics import GRAZING, SEEN, UNPROVEN
from .plan import Model
from .raster import colour

LABELLED = 60  # rooms: more can't be labelled legibly
MOST_PIXELS = 1400
COLOURS = {SEEN: d.VISIBLE, GRAZING: d.GRAZING, UNPROVEN: d.UNDECIDED}
EMPTY = "#f3f2ee"


def order(model: Model) -> list[int]:
    """Room indices by storey, outdoors last."""
    n = len(model.building.rooms)
    far = len(model.storeys) + 1
    key = [far if i in model.exterior else model.room_storey[i] if model.room_storey[i] >= 0 else far - 1 for i in range(n)]
    return sorted(range(n), key=lambda i: (key[i], i))


def labelled(model: Model, status: np.ndarray) -> Drawing:
    """Squares with names on both sides."""
    rooms = order(model)
    n = len(rooms)
    cell = 26.0 if n <= 16 else 18.0 if n <= 34 else 13.0
    size = min(11.5, cell * 0.62)
    names = [d.shorten(model.names.room(i), 26) for i in rooms]
    side = max((d.text_width(t, size) for t in names), default=40.0) + 34
    head = 34.0
    out = Drawing(side + n * cell + 20, head + n * cell + 20, "Room to room")
    storey = [(-2 if r in model.exterior else model.room_storey[r]) for r in rooms]
    for a in range(n):
        y = head + a * cell
        out.text(side - 28, y + cell * 0.5 + size * 0.36, names[a], size, d.INK, "end")
        out.text(side - 6, y + cell * 0.5 + size * 0.36, str(rooms[a] + 1), size, d.FAINT_INK, "end")
        out.text(side + a * cell + cell / 2, head - 6, str(rooms[a] + 1), size, d.FAINT_INK, "middle")
        for b in range(n):
            x = side + b * cell
            s = int(status[rooms[a], rooms[b]])
            fill = d.SELF if a == b else COLOURS.get(s, EMPTY)
            title = f"{names[a]} – {names[b]}"
            out.polygon([(x + 0.6, y + 0.6), (x + cell - 0.6, y + 0.6), (x + cell - 0.6, y + cell - 0.6),
                         (x + 0.6, y + cell - 0.6)], fill, title=title if s and a != b else "")
    for a in range(1, n):
        if storey[a] != storey[a - 1]:
            for line in ([(side - 24, head + a * cell), (side + n * cell, head + a * cell)],
                         [(side + a * cell, head - 18), (side + a * cell, head + n * cell)]):
                out.line(line, d.INK, 1.0)
    return out


def pixels(model: Model, status: np.ndarray) -> tuple[np.ndarray, int]:
    """uint8 (h, w, 3) and how many rooms share a row of pixels; lines between storeys."""
    rooms = order(model)
    n = len(rooms)
    # Rank by how much a reader must know: visible over grazing over unproven over hidden.
    rank = np.zeros(256, dtype=np.uint8)
    rank[[UNPROVEN, GRAZING, SEEN]] = (1, 2, 3)
    table = rank[status[np.ix_(rooms, rooms)]]
    table[np.arange(n), np.arange(n)] = np.maximum(table[np.arange(n), np.arange(n)], 3)
    block = -(-n // MOST_PIXELS)
    if block > 1:
        full = -(-n // block) * block
        table = np.pad(table, ((0, full - n), (0, full - n)))
        table = table.reshape(full // block, block, full // block, block).max(axis=(1, 3))
    zoom = max(1, min(8, 700 // max(len(table), 1)))
    palette = np.stack([colour(c) for c in (EMPTY, d.UNDECIDED, d.GRAZING, d.VISIBLE)])
    picture = (palette[table] * 255 + 0.5).astype(np.uint8).repeat(zoom, axis=0).repeat(zoom, axis=1)
    storey = [(-2 if r in model.exterior else model.room_storey[r]) for r in rooms]
    for a in range(1, n):
        if storey[a] != storey[a - 1]:
            at = min(a // block * zoom, len(picture) - 1)
            picture[at, :] = picture[:, at] = (38, 40, 43)
    return picture, block


def bands(model: Model) -> list[tuple[str, int]]:
    """Storey names and numbers of rooms, in the order of the picture."""
    found: list[tuple[str, int]] = []
    for r in order(model):
        name = "Outdoors" if r in model.exterior else model.storey_name(r) or "no storey"
        if found and found[-1][0] == name:
            found[-1] = (name, found[-1][1] + 1)
        else:
            found.append((name, 1))
    return found
