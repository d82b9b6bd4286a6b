# SPDX-License-Identifier: GPL-3.0-or-later
"""A page of shapes in page units (pixels at 96 dpi, y down): drawn to SVG by svg.py and to pixels by raster.py alike.

Colours are chosen for paper: warm = seen, cool grey = not seen, told apart by lightness as well as hue, so that
readers with any colour vision, and a black-and-white printer, keep the difference.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

INK, FAINT_INK, PAPER = "#26282b", "#6d737b", "#ffffff"
WALL = "#33363b"  # cut walls, the heaviest tone of a plan
NOT_SEEN, SEEN, OWN_ROOM = "#dfe3e8", "#fcebc4", "#f9dc96"
ISOVIST = "#e39a12"  # laid over rooms half transparent
IN_PICTURE = "#f0c36b"  # so it looks over SEEN
CAMERA = "#9a3412"
GLASS = "#2b6ea5"
THRESHOLD, VOID = "#6d737b", "#7a808a"
RAMP = ("#dfe3e8", "#fcebc4", "#f7cf7a", "#eeaf3c", "#d98a12", "#cb8018")  # number of cameras: 0, 1, 2, 3, 4, 5 or more
STEPS = ("#f2f4f3", "#dbe8ec", "#bfdae2", "#9cc7d4", "#78b2c4")  # a figure from low to high
VISIBLE, GRAZING, UNDECIDED, SELF = "#1f6f8b", "#e39a12", "#a9cbd6", "#cdd2d8"


@dataclass
class Polygon:
    points: np.ndarray  # (n, 2)
    fill: str
    opacity: float = 1.0
    room: int = -1  # for highlighting and titles; -1 none
    title: str = ""


@dataclass
class Line:
    points: np.ndarray  # (n, 2)
    stroke: str
    width: float
    dash: tuple[float, ...] = ()
    closed: bool = False
    round: bool = False


@dataclass
class Text:
    x: float
    y: float  # baseline
    text: str
    size: float
    colour: str = INK
    anchor: str = "start"  # start, middle, end
    bold: bool = False
    halo: str = ""  # colour of an outline behind the letters
    upright: bool = False  # turned a quarter, read from below upwards; x is then the baseline


@dataclass
class Drawing:
    width: float
    height: float
    title: str
    items: list[Polygon | Line | Text] = field(default_factory=list)

    def polygon(self, points, fill: str, opacity: float = 1.0, room: int = -1, title: str = "") -> None:
        if len(points) >= 3:
            self.items.append(Polygon(np.asarray(points, dtype=np.float64), fill, opacity, room, title))

    def line(self, points, stroke: str, width: float, dash=(), closed: bool = False, round: bool = False) -> None:
        if len(points) >= 2:
            self.items.append(Line(np.asarray(points, dtype=np.float64), stroke, width, tuple(dash), closed, round))

    def text(self, x, y, text, size, colour=INK, anchor="start", bold=False, halo="",
             upright=False) -> None:
        if text:
            self.items.append(Text(float(x), float(y), text, size, colour, anchor, bold, halo, upright))


NARROW, WIDE = set("iljtfrI.,:;|'!()[]/ -`"), set("mwMW@%")


def text_width(text: str, size: float) -> float:
    """Generous estimate of a line's width in a common sans serif [page units]."""
    total = 0.0
    for c in text:
        if c in NARROW:
            total += 0.36
        elif c in WIDE:
            total += 0.92
        elif ord(c) > 0x2E7F:  # wide scripts
            total += 1.05
        elif c.isupper():
            total += 0.70
        else:
            total += 0.60
    return total * size


def shorten(text: str, limit: int) -> str:
    """At most `limit` characters, control characters as spaces, cut with an ellipsis."""
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= limit else text[: max(limit - 1, 1)].rstrip() + "…"
