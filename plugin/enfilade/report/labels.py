# SPDX-License-Identifier: GPL-3.0-or-later
"""Where names go on a plan: inside their room, clear of each other and of symbols; what doesn't fit is shortened.

For each room the fullest wording that fits is taken: name and area on lines of their own, name alone, its number.
"""

from __future__ import annotations

import numpy as np

from . import shapes2d
from .drawing import shorten, text_width

LEADING = 1.22
LEAST_CUT = 8  # letters: cut shorter, "0.West 07" and "0.West 08" are the same; the number tells them apart


class Occupied:
    """Axis-aligned boxes already taken on the page."""

    def __init__(self) -> None:
        self.boxes: list[tuple[float, float, float, float]] = []
        self.lines: list[tuple[float, float, float, float]] = []  # fine lines: crossed only when nothing else fits

    def add(self, x0: float, y0: float, x1: float, y1: float) -> None:
        self.boxes.append((x0, y0, x1, y1))

    def overlap(self, x0: float, y0: float, x1: float, y1: float) -> float:
        """Area shared with taken boxes."""
        b = _near(self.boxes, x0, y0, x1, y1)
        w = np.minimum(b[:, 2], x1) - np.maximum(b[:, 0], x0)
        h = np.minimum(b[:, 3], y1) - np.maximum(b[:, 1], y0)
        return float((w * h).sum())


def _near(boxes: list[tuple[float, float, float, float]], x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """The boxes that overlap one, (m, 4)."""
    b = np.array(boxes, dtype=np.float64).reshape(-1, 4)
    return b[(b[:, 0] < x1) & (b[:, 2] > x0) & (b[:, 1] < y1) & (b[:, 3] > y0)]


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
    near, lines_near = (_near(b, x0, y0, x1, y1) for b in (taken.boxes, taken.lines))
    for lines in _wordings(name, detail, number, x1 - x0, sizes):
        w = max(text_width(t, s) * (1.08 if bold else 1.0) for t, s, bold in lines)
        h = sum(s * LEADING for _, s, _ in lines)
        if w > x1 - x0 or h > y1 - y0:
            continue
        half = np.array([w / 2 + 3, h / 2 + 1])
        spots = grid[_clear(grid, half, near)]
        spots = spots[_inside(pieces, spots, half)]
        if not len(spots):
            continue
        best = spots[_clear(spots, half, lines_near)]
        cx, cy = best[0] if len(best) else spots[0]  # over a fine line only where nothing else is left
        taken.add(cx - half[0], cy - half[1], cx + half[0], cy + half[1])
        return float(cx), float(cy), lines
    return None


def is_whole(spot, name: str) -> bool:
    """Whether a spot that was found shows all of the name."""
    return spot is not None and "".join(t for t, _, bold in spot[2] if bold).replace(" ", "") == shorten(name, 40).replace(" ", "")


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
    if fits >= LEAST_CUT and len(name) > fits:
        yield [(shorten(name, fits), size, True)]
    yield [(number, size, False)]


def _clear(spots: np.ndarray, half: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Which label boxes (centres (n, 2), half size) touch none of `boxes` (m, 4). bool (n,)."""
    if not len(boxes) or not len(spots):
        return np.ones(len(spots), dtype=bool)
    low, high = (spots - half)[:, None], (spots + half)[:, None]
    return ~((boxes[None, :, :2] < high) & (boxes[None, :, 2:] > low)).all(axis=2).any(axis=1)


SAMPLES = np.array([(x, y) for x in np.linspace(-1, 1, 7) for y in np.linspace(-1, 1, 4)])
CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)


def _inside(pieces: list[np.ndarray], spots: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Which label boxes lie in the room: by corners in a convex room, by samples in one of several pieces. bool (n,)."""
    pattern = CORNERS if len(pieces) == 1 else SAMPLES
    points = (spots[:, None] + pattern[None] * half).reshape(-1, 2)
    inside = np.zeros(len(points), dtype=bool)
    for p in pieces:
        inside |= shapes2d.contains(p, points, -0.5)
    return inside.reshape(len(spots), len(pattern)).all(axis=1)
