# SPDX-License-Identifier: GPL-3.0-or-later
"""Letters for pictures: OpenImageIO's render_text with a font found on the machine, else strokes of our own.

OpenImageIO before 2.5 reads the bytes of non-ASCII letters wrongly (u-umlaut comes out as "<"), so such letters are set
as their base letter with the accent drawn over it; letters without a Latin base become a small box, never a wrong letter.
"""

from __future__ import annotations

import functools
import math
import os
import sys
import unicodedata
from pathlib import Path

import numpy as np

try:
    import OpenImageIO as oiio
except ImportError:  # a Blender without the module: strokes
    oiio = None

BOX = "\x01"  # stands for a letter that can't be set
SPELLED = {"ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L", "đ": "d",
           "–": "-", "—": "-", "‐": "-", "’": "'", "‘": "'", "“": '"', "”": '"', "„": '"', "…": "...", "×": "x",
           "·": "\x02", "µ": "u", "→": ">", "←": "<", "•": "\x02", "\u00a0": " ", "°": "\x03", "≤": "<", "≥": ">"}
RAISED = {"²": "2", "³": "3", "¹": "1"}
MARKS = {0x300: "grave", 0x301: "acute", 0x302: "circumflex", 0x303: "tilde", 0x308: "dots", 0x30A: "ring",
         0x327: "cedilla", 0x30C: "caron", 0x304: "macron", 0x30B: "dots", 0x306: "caron", 0x307: "dot", 0x328: "cedilla"}

# Strokes on a grid 4 wide, 6 high (baseline 0): polylines of digit pairs.
STROKES = {
    "A": "00 24 40;12 32", "B": "00 06 36 45 33 03;33 42 30 00", "C": "45 36 16 05 01 10 30 41", "D": "00 06 26 44 42 20 00",
    "E": "46 06 00 40;03 33", "F": "46 06 00;03 33", "G": "45 36 16 05 01 10 30 41 43 23", "H": "00 06;40 46;03 43",
    "I": "20 26", "J": "46 41 30 10 01", "K": "00 06;46 03 40", "L": "06 00 40", "M": "00 06 23 46 40", "N": "00 06 40 46",
    "O": "10 01 05 16 36 45 41 30 10", "P": "00 06 36 45 44 33 03", "Q": "10 01 05 16 36 45 41 30 10;22 40",
    "R": "00 06 36 45 44 33 03;23 40", "S": "45 36 16 05 04 13 33 42 41 30 10 01", "T": "06 46;26 20", "U": "06 01 10 30 41 46",
    "V": "06 20 46", "W": "06 10 23 30 46", "X": "00 46;06 40", "Y": "06 23 46;23 20", "Z": "06 46 00 40",
    "0": "10 01 05 16 36 45 41 30 10;11 35", "1": "05 26 20", "2": "05 16 36 45 44 00 40", "3": "06 46 23 42 41 30 10 01",
    "4": "30 36 02 42", "5": "46 06 03 33 42 41 30 00", "6": "36 16 04 01 10 30 41 42 33 02", "7": "06 46 10",
    "8": "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33", "9": "10 30 42 45 36 16 05 04 13 43",
    ".": "20 21", ",": "10 21", ":": "21 22;24 25", ";": "10 21;24 25", "-": "03 43", "_": "00 40", "+": "03 43;21 25",
    "/": "00 46", "\\": "06 40", "(": "36 24 22 30", ")": "16 24 22 10", "[": "36 16 10 30", "]": "16 36 30 10", "=": "02 42;04 44",
    "'": "26 25", '"': "16 15;36 35", "!": "26 22;21 20", "?": "05 16 36 45 44 22;21 20", "<": "46 03 40", ">": "06 43 00",
    "%": "00 46;05 16;30 41", "*": "13 35;15 33", "#": "10 16;30 36;02 42;04 44", "&": "40 14 15 26 35 02 10 20 42",
    "@": "41 30 10 01 05 16 36 45 42 22 24 44", "|": "20 26", "$": "45 05 03 43 41 01;26 20", "`": "16 25", "^": "04 26 44",
    "~": "03 14 32 43", "{": "36 25 24 13 22 21 30", "}": "16 25 24 33 22 21 10", BOX: "00 05 35 30 00", "\x02": "23 33",
    "\x03": "14 15 25 24 14", " ": "",
}


def _candidates(bold: bool):
    names = ("DejaVuSans-Bold", "LiberationSans-Bold", "Arial Bold", "arialbd", "NotoSans-Bold") if bold else \
        ("DejaVuSans", "LiberationSans-Regular", "Arial", "arial", "NotoSans-Regular", "Helvetica")
    folders = [Path(p) for p in (os.environ.get("ENFILADE_FONTS"), "/usr/share/fonts/truetype/dejavu",
                                 "/usr/share/fonts/truetype/liberation", "/usr/share/fonts/truetype/noto",
                                 "/usr/share/fonts/TTF", "/usr/share/fonts/dejavu", "/Library/Fonts",
                                 "/System/Library/Fonts/Supplemental", "C:/Windows/Fonts") if p]
    for start in {Path(sys.executable).resolve().parent, Path(sys.prefix)}:  # Blender's own fonts lie near its Python
        for up in (start, *list(start.parents)[:3]):
            folders.append(up / "datafiles" / "fonts")
    for folder in folders:
        for name in names:
            for end in (".ttf", ".otf", ".woff2"):
                if (folder / (name + end)).is_file():
                    yield str(folder / (name + end))
    yield from names[:2]  # OpenImageIO looks in places of its own
    if bold:
        yield from _candidates(False)


@functools.lru_cache(maxsize=2)
def font(bold: bool = False) -> str | None:
    """A font that OpenImageIO can draw with, or None."""
    if oiio is None or not hasattr(oiio.ImageBufAlgo, "text_size"):
        return None
    for path in _candidates(bold):
        try:
            roi = oiio.ImageBufAlgo.text_size("Hg", 20, path)
        except Exception:  # any failure of a foreign library here only means: not this font
            continue
        if roi.defined and roi.xend > roi.xbegin + 4:
            return path
    return None


@functools.lru_cache(maxsize=1)
def _reads_utf8() -> bool:
    name = font()
    if name is None:
        return False
    return oiio.ImageBufAlgo.text_size("ü", 64, name) != oiio.ImageBufAlgo.text_size("<", 64, name) and \
        oiio.ImageBufAlgo.text_size("é", 64, name) != oiio.ImageBufAlgo.text_size(")", 64, name)


def spell(text: str) -> tuple[str, list[tuple[int, str]]]:
    """ASCII letters to set, and (index, accent) to draw over them; "raised" marks a superscript digit."""
    letters, marks = "", []
    for c in unicodedata.normalize("NFC", text):
        if " " <= c <= "~":
            letters += c
        elif c in SPELLED:
            letters += SPELLED[c]
        elif c in RAISED:
            marks.append((len(letters), "raised"))
            letters += RAISED[c]
        elif not c.isprintable():
            letters += " "
        else:
            base, *combining = unicodedata.normalize("NFD", c)
            if " " <= base <= "~":
                marks += [(len(letters), MARKS[ord(m)]) for m in combining if ord(m) in MARKS]
                letters += base
            else:
                letters += BOX
    return letters, marks


def _special(letters: str) -> bool:
    return any(c < " " for c in letters)


@functools.lru_cache(maxsize=4096)
def _run_width(letters: str, size: int, bold: bool) -> float:
    name = font(bold)
    measure = oiio.ImageBufAlgo.text_size
    return measure("|" + letters + "|", size, name).xend - measure("||", size, name).xend


def _pieces(text: str, size: float, bold: bool):
    """(run of letters, x, size factor, raise) set one after the other, accents as (x, name), total width."""
    letters, marks = spell(text)
    raised = {i for i, m in marks if m == "raised"}
    width = (lambda s, z: float(_run_width(s, max(6, round(z)), bold))) if font(bold) else (lambda s, z: len(s) * z * 0.62)
    runs, x, start = [], 0.0, 0
    edges: list[float] = []
    k = 0
    while k <= len(letters):
        stop = k == len(letters) or k in raised or letters[k] < " "
        if stop:
            if k > start:
                run = letters[start:k]
                edges += [x + width(run[:i], size) for i in range(len(run))] if any(start <= i < k for i, _ in marks) \
                    else [x] * len(run)
                runs.append((run, x, 1.0, 0.0))
                x += width(run, size)
            if k < len(letters):
                edges.append(x)
                if k in raised:
                    runs.append((letters[k], x, 0.62, 0.36))
                    x += width(letters[k], size * 0.62)
                else:
                    runs.append((letters[k], x, 1.0, 0.0))
                    x += size * 0.55
            start = k + 1
        k += 1
    edges.append(x)
    accents = [((edges[i] + (edges[i + 1] if edges[i + 1] > edges[i] else edges[i] + size * 0.55)) / 2, m, letters[i])
               for i, m in marks if m != "raised"]
    return runs, accents, x


@functools.lru_cache(maxsize=4096)
def advance(text: str, size: float, bold: bool = False) -> float:
    """Width of a line of text [pixels]."""
    if font(bold) and _reads_utf8():
        return float(_run_width(text, max(6, round(size)), bold))
    return _pieces(text, size, bold)[2]


@functools.lru_cache(maxsize=8192)  # a report writes each room's name on a dozen sheets
def mask(text: str, size: float, bold: bool = False) -> tuple[np.ndarray, int, int]:
    """Coverage float32 (h, w) of a line of text, pixels left of its start, and the row of its baseline."""
    pad, baseline = math.ceil(size * 0.4) + 1, math.ceil(size * 1.15)
    height = baseline + math.ceil(size * 0.45)
    name = font(bold)
    if name and _reads_utf8():
        total = advance(text, size, bold)
        return _oiio_mask(text, size, name, math.ceil(total) + 2 * pad, height, pad, baseline), pad, baseline
    runs, accents, total = _pieces(text, size, bold)
    out = np.zeros((height, math.ceil(total) + 2 * pad), dtype=np.float32)
    for run, x, factor, lift in runs:
        base = baseline - round(lift * size)
        if name and not _special(run):
            part = _oiio_mask(run, size * factor, name, out.shape[1], height, pad + round(x), base)
        else:
            part = _stroke_mask(run, size * factor, bold, out.shape, pad + x, base)
        np.maximum(out, part, out=out)
    for x, accent, letter in accents:
        np.maximum(out, _accent_mask(accent, letter, size, bold, out.shape, pad + x, baseline), out=out)
    return out, pad, baseline


@functools.lru_cache(maxsize=8192)
def halo(text: str, size: float, bold: bool, reach: int) -> np.ndarray:
    """`mask` grown by `reach` pixels on every side, float32."""
    letters = mask(text, size, bold)[0]
    height, width = letters.shape
    out = np.zeros((height + 2 * reach, width + 2 * reach), dtype=np.float32)
    for dy in range(2 * reach + 1):
        for dx in range(2 * reach + 1):
            if (dx - reach) ** 2 + (dy - reach) ** 2 <= reach**2 + 0.5:
                part = out[dy : dy + height, dx : dx + width]
                np.maximum(part, letters, out=part)
    return out


def _oiio_mask(text: str, size: float, name: str, width: int, height: int, x: int, y: int) -> np.ndarray:
    buf = oiio.ImageBuf(oiio.ImageSpec(width, height, 1, oiio.FLOAT))
    oiio.ImageBufAlgo.zero(buf)
    oiio.ImageBufAlgo.render_text(buf, x, y, text, max(6, round(size)), name, (1.0,))
    return np.clip(np.asarray(buf.get_pixels(oiio.FLOAT), dtype=np.float32).reshape(height, width), 0, 1)


def _draw(lines: list[np.ndarray], width: float, shape) -> np.ndarray:
    from . import raster
    from .drawing import Line

    canvas = raster.Canvas(shape[1], shape[0], "#000000")
    for line in lines:
        canvas.stroke(Line(line, "#ffffff", width, round=True), 1.0)
    return canvas.pixels[..., 0]


def _stroke_mask(text: str, size: float, bold: bool, shape, x: float, y: int) -> np.ndarray:
    lines = []
    step = size * 0.62 if len(text) > 1 else size * 0.55
    for i, c in enumerate(text):
        unit = size * 0.72 / 6 * (0.8 if c.islower() else 1.0)
        for stroke in STROKES.get(c.upper(), STROKES[BOX]).split(";"):
            points = [(x + i * step + int(p[0]) * unit, y - int(p[1]) * unit) for p in stroke.split()]
            if len(points) > 1:
                lines.append(np.array(points))
    return _draw(lines, size * (0.13 if bold else 0.085), shape)


def _accent_mask(accent: str, letter: str, size: float, bold: bool, shape, x: float, y: int) -> np.ndarray:
    low = y - size * (0.64 if letter.islower() and letter not in "bdfhklt" else 0.84)
    r = size * 0.13
    top = low - r
    shapes = {
        "grave": [[(x - r, top), (x + r * 0.4, low)]], "acute": [[(x + r, top), (x - r * 0.4, low)]],
        "circumflex": [[(x - r, low), (x, top), (x + r, low)]], "caron": [[(x - r, top), (x, low), (x + r, top)]],
        "tilde": [[(x - 1.2 * r, low), (x - 0.4 * r, top), (x + 0.4 * r, low), (x + 1.2 * r, top)]],
        "dots": [[(x - r, low - r / 2), (x - r + 0.1, low - r / 2)], [(x + r, low - r / 2), (x + r + 0.1, low - r / 2)]],
        "dot": [[(x, low - r / 2), (x + 0.1, low - r / 2)]], "macron": [[(x - r, low - r / 2), (x + r, low - r / 2)]],
        "ring": [[(x + r * math.cos(t), low - r + r * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 13)]],
        "cedilla": [[(x, y), (x + r, y + r), (x - r * 0.4, y + 1.6 * r)]],
    }
    return _draw([np.array(s) for s in shapes[accent]], size * (0.12 if bold else 0.09), shape)
