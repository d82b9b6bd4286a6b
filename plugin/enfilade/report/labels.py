# SPDX-License-Identifier: GPL-3.0-or-later
"""Where names go on a plan: inside their room, clear of each other and of symbols; what doesn't fit is shortened.

For each room the fullest wording that fits is taken: name and area on lines of their own, name alone, its number.
"""

from __future__ import annotations

from dataclasses import dataclass

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
    return np.array([b for b in boxes if b[0] < x1 and b[2] > x0 and b[1] < y1 and b[3] > y0]).reshape(-1, 4)


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


@dataclass
class Spot:
    """A label where it fits."""

    x: float  # centre
    y: float
    lines: list[tuple[str, float, bool]]  # text, size, whether it is the name
    half: np.ndarray  # half of its width and height on the page
    upright: bool  # read from below upwards; the lines follow each other to the right
    whole: bool  # all of the name


def place(pieces: list[np.ndarray], name: str, detail: str, number: str, taken: Occupied, sizes: tuple[float, ...]) -> Spot | None:
    """The best spot for a room's label, which then is taken; None when nothing fits. Names lie, unless they fit better upright: along a
    corridor, and where a room is too narrow for its name.

    pieces: the room's convex polygons in page units, counter-clockwise in page axes.
    """
    if not pieces:
        return None
    every = np.concatenate(pieces)
    low, high = every.min(axis=0), every.max(axis=0)
    near, lines_near = (_near(b, *low.tolist(), *high.tolist()) for b in (taken.boxes, taken.lines))
    wording = name, detail, number
    narrow = high[1] - low[1] > 1.8 * (high[0] - low[0])
    spot = _find(pieces, *wording, near, lines_near, sizes[:2] if narrow else sizes)
    if spot is None or not spot.whole:
        # the page (x, y) is (-y, x) for a reader who tilts the head
        tilted = _find([p[:, ::-1] * (-1, 1) for p in pieces], *wording, _tilt(near), _tilt(lines_near), sizes)
        if tilted is not None and tilted.whole:
            spot = Spot(tilted.y, -tilted.x, tilted.lines, tilted.half[::-1], True, True)
        elif narrow:
            spot = _find(pieces, *wording, near, lines_near, sizes)
    if spot is not None:
        taken.add(spot.x - spot.half[0], spot.y - spot.half[1], spot.x + spot.half[0], spot.y + spot.half[1])
    return spot


def _tilt(boxes: np.ndarray) -> np.ndarray:
    return boxes[:, [3, 0, 1, 2]] * (-1, 1, -1, 1)


GRID = np.stack(np.meshgrid(np.arange(1, 12) / 12, np.arange(1, 12) / 12, indexing="ij"), axis=-1).reshape(-1, 2)


def _find(pieces: list[np.ndarray], name: str, detail: str, number: str, near: np.ndarray, lines_near: np.ndarray,
          sizes: tuple[float, ...]) -> Spot | None:
    """A lying label: the fullest wording that fits, as near the room's middle as may be. near, lines_near: boxes (m, 4) to keep clear of,
    and those crossed only when nothing else fits."""
    every = np.concatenate(pieces)
    low, high = every.min(axis=0), every.max(axis=0)
    biggest = max(pieces, key=lambda p: abs(shapes2d.area(p)))
    centre, middle = shapes2d.centroid(biggest), (low + high) / 2
    grid = np.concatenate([[centre, middle], low + (high - low) * GRID])
    inside = np.zeros(len(grid), dtype=bool)
    for p in pieces:
        inside |= shapes2d.contains(p, grid, 0.0)
    grid = grid[inside]
    if not len(grid):
        return None
    home = middle if len(pieces) == 1 else centre
    grid = grid[np.argsort(((grid - home) ** 2).sum(axis=1), kind="stable")]
    wide, tall = (high - low).tolist()
    for lines in _wordings(name, detail, number, wide, sizes):
        w = max(text_width(t, s) * (1.08 if bold else 1.0) for t, s, bold in lines)
        h = sum(s * LEADING for _, s, _ in lines)
        if w > wide or h > tall:
            continue
        half = np.array([w / 2 + 3, h / 2 + 1])
        spots = grid[_clear(grid, half, near)]
        spots = spots[_inside(pieces, spots, half)]
        if not len(spots):
            continue
        best = spots[_clear(spots, half, lines_near)]
        x, y = (best[0] if len(best) else spots[0]).tolist()  # over a fine line only where nothing else is left
        shown = "".join(t for t, _, bold in lines if bold)
        return Spot(x, y, lines, half, False, shown.replace(" ", "") == shorten(name, 40).replace(" ", ""))
    return None


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
