# SPDX-License-Identifier: GPL-3.0-or-later
"""A Drawing as SVG: one well-formed file, or a fragment to put into a page."""

from __future__ import annotations

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
    return "M" + "L".join(f"{number(x)} {number(y)}" for x, y in points) + ("Z" if closed else "")


def fragment(drawing: Drawing, link: bool = True) -> str:
    """The <svg> element. `link`: rooms carry data-room, for highlighting in the report."""
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {number(drawing.width)} {number(drawing.height)}" '
           f'role="img" font-family="{FONTS}"><title>{clean(drawing.title)}</title>']
    rooms: list[Polygon] = []

    def flush() -> None:
        if not rooms:
            return
        first = rooms[0]
        opacity = f' fill-opacity="{first.opacity:.2f}"' if first.opacity < 1 else ""
        data = f' data-room="{first.room}"' if link and first.room >= 0 else ""
        paths = "".join(_path(p.points, True) for p in rooms)
        title = f"<title>{clean(first.title)}</title>" if first.title else ""
        end = f">{title}</path>" if title else "/>"
        out.append(f'<path d="{paths}" fill="{first.fill}"{opacity}{data}{end}')
        rooms.clear()

    for item in drawing.items:
        if isinstance(item, Polygon):
            # Neighbouring pieces of one look become one path: smaller, and transparent pieces show no seam.
            if rooms and (item.fill, item.opacity, item.room, item.title) != (
                    rooms[0].fill, rooms[0].opacity, rooms[0].room, rooms[0].title):
                flush()
            rooms.append(item)
            continue
        flush()
        if isinstance(item, Line):
            dash = f' stroke-dasharray="{" ".join(number(v) for v in item.dash)}"' if item.dash else ""
            cap = ' stroke-linecap="round" stroke-linejoin="round"' if item.round else ""
            out.append(f'<path d="{_path(item.points, item.closed)}" fill="none" stroke="{item.stroke}" '
                       f'stroke-width="{number(item.width)}"{dash}{cap}/>')
        elif isinstance(item, Text):
            weight = ' font-weight="600"' if item.bold else ""
            halo = f' stroke="{item.halo}" stroke-width="3" paint-order="stroke" stroke-linejoin="round"' if item.halo else ""
            anchor = f' text-anchor="{item.anchor}"' if item.anchor != "start" else ""
            turn = f' transform="rotate(-90 {number(item.x)} {number(item.y)})"' if item.upright else ""
            out.append(f'<text x="{number(item.x)}" y="{number(item.y)}"{turn} font-size="{number(item.size)}" '
                       f'fill="{item.colour}"{anchor}{weight}{halo}>{clean(item.text)}</text>')
    flush()
    out.append("</svg>")
    return "\n".join(out)


def write(drawing: Drawing, path: Path) -> None:
    """Writes a stand-alone SVG file, sized in page units, on white."""
    body = fragment(drawing, link=False)
    head = f'width="{number(drawing.width)}" height="{number(drawing.height)}" viewBox='
    body = body.replace("viewBox=", head, 1)
    mark = body.index("</title>") + len("</title>")
    paper = f'<rect width="{number(drawing.width)}" height="{number(drawing.height)}" fill="#ffffff"/>'
    with whole_file(path) as partial:
        partial.write_text('<?xml version="1.0" encoding="UTF-8"?>\n' + body[:mark] + paper + body[mark:] + "\n", encoding="utf-8")
