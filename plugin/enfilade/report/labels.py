# SPDX-License-Identifier: GPL-3.0-or-later
"""Where names go on a plan: inside their room, clear of each other and of symbols; what doesn't fit is shortened.

For each room the fullest wording that fits is taken: name and area on lines of their own, name alone, its number.
"""

from __future__ import annotations

import numpy as np

from . import shapes2d
from .drawing import shorten, text_width

LEADING = 1.22


class Occupied:
    """Axis-aligned boxes already taken on the page."""

    def __init__(self) -> None:
        self.boxes: list[tuple[float, float, float, float]] = []
        self.lines: list[tuple[float, float, float, float]] = []  # fine lines: crossed only when nothing else fits

    def add(self, x0: float, y0: float, x1: float, y1: float) -> None:
        self.boxes.append((x0, y0, x1, y1))

    def overlap(self, x0: float, y0: float, x1: float, y1: float) -> float:
        """Area shared with taken boxes."""
        if not self.boxes:
            return 0.0
        b = np.array(self.boxes)
        w = np.minimum(b[:, 2], x1) - np.maximum(b[:, 0], x0)
        h = np.minimum(b[:, 3], y1) - np.maximum(b[:, 1], y0)
        return float((np.maximum(w, 0) * np.maximum(h, 0)).sum())


    def crosses(self, x0: float, y0: float, x1: float, y1: float) -> bool:
        """Whether a box lies over a fine line."""
        return any(a < x1 and x0 < c and b < y1 and y0 < d for a, b, c, d in self.lines)


def copy(taken: Occupied) -> Occupied:
    """For trying something out."""
    other = Occupied()
    other.boxes, other.lines = list(taken.boxes), taken.lines
    return other


def wrap(text: str, size: float, width: float, lines: int) -> list[str] | None:
    """Words broken into at most `lines` lines no wider than `width`; None when they don't fit."""
    words: list[str] = []
    for word in text.split():  # "Bathroom 2" stays together: a lone numeral on a line reads as something else
        if words and len(word) <= 2:
            words[-1] += " " + word
        else:
            words.append(word)
    out, line = [], ""
    for word in words:
        longer = f"{line} {word}".strip()
        if text_width(longer, size) <= width:
            line = longer
            continue
        if not line or text_width(word, size) > width:
            return None
        out.append(line)
        line = word
    out.append(line)
    return out if len(out) <= lines else None


def place(pieces: list[np.ndarray], name: str, detail: str, number: str, taken: Occupied,
          sizes: tuple[float, ...]) -> tuple[float, float, list[tuple[str, float, bool]]] | None:
    """Best spot for a room's label: (centre x, centre y, lines of (text, size, bold)); None when nothing fits.

    pieces: the room's convex polygons in page units, counter-clockwise in page axes.
    """
    if not pieces:
        return None
    every = np.concatenate(pieces)
    (x0, y0), (x1, y1) = every.min(axis=0), every.max(axis=0)
    xs, ys = np.linspace(x0, x1, 13)[1:-1], np.linspace(y0, y1, 13)[1:-1]
    grid = np.array([(x, y) for x in xs for y in ys])
    biggest = max(pieces, key=lambda p: abs(shapes2d.area(p)))
    centre = shapes2d.centroid(biggest)
    grid = np.concatenate([[centre], [(x0 + x1, y0 + y1)] * np.array([0.5, 0.5]), grid])
    inside = np.zeros(len(grid), dtype=bool)
    for p in pieces:
        inside |= shapes2d.contains(p, grid, 0.0)
    grid = grid[inside]
    if not len(grid):
        return None
    home = np.array([(x0 + x1) / 2, (y0 + y1) / 2]) if len(pieces) == 1 else centre
    grid = grid[np.argsort(((grid - home) ** 2).sum(axis=1), kind="stable")]
    for lines in _wordings(name, detail, number, x1 - x0, sizes):
        w = max(text_width(t, s) * (1.08 if bold else 1.0) for t, s, bold in lines)
        h = sum(s * LEADING for _, s, _ in lines)
        if w > x1 - x0 or h > y1 - y0:
            continue
        second = None
        for cx, cy in grid:
            box = (cx - w / 2 - 3, cy - h / 2 - 1, cx + w / 2 + 3, cy + h / 2 + 1)
            if taken.overlap(*box) > 0 or not _covered(pieces, box):
                continue
            if not taken.crosses(*box):
                taken.add(*box)
                return float(cx), float(cy), lines
            second = second or (float(cx), float(cy), box)
        if second is not None:
            taken.add(*second[2])
            return second[0], second[1], lines
    return None


def place_upright(pieces: list[np.ndarray], name: str, detail: str, number: str, taken: Occupied,
                  sizes: tuple[float, ...]):
    """As `place`, for text turned a quarter (read from below upwards): tall narrow rooms such as corridors.

    Returns (centre x, centre y, lines) in page units; lines follow each other to the right.
    """
    turned = Occupied()  # page (x, y) is (-y, x) for a reader who tilts the head
    turned.boxes = [(-y1, x0, -y0, x1) for x0, y0, x1, y1 in taken.boxes]
    turned.lines = [(-y1, x0, -y0, x1) for x0, y0, x1, y1 in taken.lines]
    spot = place([np.stack([-p[:, 1], p[:, 0]], axis=1) for p in pieces], name, detail, number, turned, sizes)
    if spot is None:
        return None
    a0, b0, a1, b1 = turned.boxes[-1]
    if [t for t, _, _ in spot[2]] != [number]:
        taken.add(b0, -a1, b1, -a0)
    return spot[1], -spot[0], spot[2]


def _wordings(name: str, detail: str, number: str, width: float, sizes: tuple[float, ...]):
    name = shorten(name, 40)
    for size in sizes:
        small = max(size * 0.85, 7.0)
        for count in (1, 2, 3):
            lines = wrap(name, size, width - 6, count)
            if lines and len(lines) == count:
                named = [(t, size, True) for t in lines]
                if detail:
                    yield [*named, (detail, small, False)]
                yield named
                break
    size = sizes[-1]
    fits = int((width - 6) / (0.62 * size))
    if fits >= 5 and len(name) > fits:
        yield [(shorten(name, fits), size, True)]
    yield [(number, size, False)]


def _covered(pieces: list[np.ndarray], box: tuple[float, float, float, float]) -> bool:
    x0, y0, x1, y1 = box
    points = np.array([(x, y) for x in np.linspace(x0, x1, 7) for y in np.linspace(y0, y1, 4)])
    inside = np.zeros(len(points), dtype=bool)
    for p in pieces:
        inside |= shapes2d.contains(p, points, -0.5)
    return bool(inside.all())
