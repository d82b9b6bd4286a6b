# SPDX-License-Identifier: GPL-3.0-or-later
"""A Drawing as SVG: one well-formed file, or a fragment to put into a page."""

from __future__ import annotations

import itertools
from html import escape
from pathlib import Path

import numpy as np

from ..rules.whole_file import whole_file
from .drawing import Drawing, Line, Polygon, Text

FONTS = "'Helvetica Neue',Helvetica,Arial,'DejaVu Sans',sans-serif"


def number(value: float) -> str:
    """Short decimal: a tenth of a page unit is finer than any line."""
    text = f"{value:.1f}"
    return text[:-2] if text.endswith(".0") else text


def clean(text: str) -> str:
    """Escaped for XML and HTML; characters that XML forbids become spaces."""
    allowed = "".join(c if c in "\t\n\r" or (0x20 <= ord(c) <= 0xD7FF and not 0x7F <= ord(c) <= 0x9F)
                      or 0xE000 <= ord(c) <= 0xFFFD or ord(c) >= 0x10000 else " " for c in text)
    return escape(allowed, quote=True)


def _path(points: np.ndarray, closed: bool) -> str:
    """Points as `number` writes them; level and upright sides, most of a plan, in the short form."""
    text = ("%.1f %.1f|" * len(points)) % tuple(points.ravel().tolist())
    corners = [corner.split(" ") for corner in text.replace(".0 ", " ").replace(".0|", "|")[:-1].split("|")]
    last_x, last_y = corners[0]
    out = [f"M{last_x} {last_y}"]
    for x, y in corners[1:]:
        out.append(f"V{y}" if x == last_x else f"H{x}" if y == last_y else f"L{x} {y}")
        last_x, last_y = x, y
    return "".join(out) + ("Z" if closed else "")


def _look(item: Polygon | Line | Text) -> tuple:
    """Neighbours of one look become one path: smaller, and transparent pieces show no seam."""
    if isinstance(item, Polygon):
        return Polygon, item.fill, item.opacity, item.room, item.title
    if isinstance(item, Line):
        return Line, item.stroke, item.width, item.dash, item.round
    return (Text,)


def _text(item: Text) -> str:
    weight = ' font-weight="600"' if item.bold else ""
    halo = f' stroke="{item.halo}" stroke-width="3" paint-order="stroke" stroke-linejoin="round"' if item.halo else ""
    anchor = f' text-anchor="{item.anchor}"' if item.anchor != "start" else ""
    turn = f' transform="rotate(-90 {number(item.x)} {number(item.y)})"' if item.upright else ""
    return (f'<text x="{number(item.x)}" y="{number(item.y)}"{turn} font-size="{number(item.size)}" '
            f'fill="{item.colour}"{anchor}{weight}{halo}>{clean(item.text)}</text>')


def _filled(first: Polygon, path: str) -> str:
    opacity = f' fill-opacity="{first.opacity:.2f}"' if first.opacity < 1 else ""
    data = f' data-room="{first.room}"' if first.room >= 0 else ""
    end = f"><title>{clean(first.title)}</title></path>" if first.title else "/>"
    return f'<path d="{path}" fill="{first.fill}"{opacity}{data}{end}'


def _stroked(first: Line, path: str) -> str:
    dash = f' stroke-dasharray="{" ".join(number(v) for v in first.dash)}"' if first.dash else ""
    cap = ' stroke-linecap="round" stroke-linejoin="round"' if first.round else ""
    return f'<path d="{path}" fill="none" stroke="{first.stroke}" stroke-width="{number(first.width)}"{dash}{cap}/>'


def fragment(drawing: Drawing) -> str:
    """The <svg> element. Rooms carry data-room, for highlighting in the report."""
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {number(drawing.width)} {number(drawing.height)}" '
           f'role="img" font-family="{FONTS}"><title>{clean(drawing.title)}</title>']
    for look, alike in itertools.groupby(drawing.items, _look):
        items = list(alike)
        if look[0] is Text:
            out += map(_text, items)
        elif look[0] is Polygon:
            out.append(_filled(items[0], "".join(_path(p.points, True) for p in items)))
        else:
            out.append(_stroked(items[0], "".join(_path(line.points, line.closed) for line in items)))
    out.append("</svg>")
    return "\n".join(out)


def write(drawing: Drawing, path: Path) -> str:
    """Writes a stand-alone SVG file, sized in page units, on white; gives the fragment that it holds."""
    body = text = fragment(drawing)
    head = f'width="{number(drawing.width)}" height="{number(drawing.height)}" viewBox='
    body = body.replace("viewBox=", head, 1)
    mark = body.index("</title>") + len("</title>")
    paper = f'<rect width="{number(drawing.width)}" height="{number(drawing.height)}" fill="#ffffff"/>'
    with whole_file(path) as partial:
        partial.write_text('<?xml version="1.0" encoding="UTF-8"?>\n' + body[:mark] + paper + body[mark:] + "\n", encoding="utf-8")
    return text
