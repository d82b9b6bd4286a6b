# SPDX-License-Identifier: GPL-3.0-or-later
"""A Drawing as pixels: polygons by exact horizontal coverage on four lines a pixel, strokes as polygons, letters by
lettering.py. Plain numpy; reading and writing of files is in images.py."""

from __future__ import annotations

import math

import numpy as np

from . import lettering
from .drawing import Drawing, Line, Polygon, Text
from .shapes2d import following

LINES = 4  # sub-scanlines a pixel


def colour(text: str) -> np.ndarray:
    """"#rrggbb" -> float32 (3,) 0..1, display-referred."""
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)], dtype=np.float32) / 255.0


def _upright(points: np.ndarray) -> tuple[float, float, float, float] | None:
    """Left, top, right, bottom of four corners that are a rectangle with sides along the axes."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = points.tolist()
    if (max(abs(ax - bx), abs(by - cy), abs(cx - dx), abs(dy - ay)) < 1e-6
            or max(abs(ay - by), abs(bx - cx), abs(cy - dy), abs(dx - ax)) < 1e-6):
        return min(ax, cx), min(ay, cy), max(ax, cx), max(ay, cy)
    return None


def _overlap(low: float, high: float, most: int) -> tuple[int, np.ndarray]:
    """The first of `most` pixels that [low, high] touches, and the share of each that it covers, float32; empty: none."""
    first, last = max(math.floor(low), 0), min(math.ceil(high), most)
    out = np.ones(max(last - first, 0), dtype=np.float32)
    if len(out):
        out[0] -= max(low - first, 0.0)
        out[-1] -= max(last - high, 0.0)
    return first, out


def _spans(columns: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Coverage of one span [a, b] a row. float32 (rows, columns)."""
    out = np.subtract(np.minimum(columns[None] + 1, b[:, None]), np.maximum(columns[None], a[:, None]), dtype=np.float64)
    return np.maximum(out, 0, out=out).astype(np.float32)


class Canvas:
    """Pixels 0..1, display-referred; a plane a channel, which is what blending goes over."""

    def __init__(self, width: int, height: int, ground: str = "#ffffff"):
        self.planes = np.empty((3, height, width), dtype=np.float32)
        self.planes[:] = colour(ground)[:, None, None]

    @property
    def pixels(self) -> np.ndarray:
        """The same memory as float32 (height, width, 3)."""
        return self.planes.transpose(1, 2, 0)

    def coverage(self, points: np.ndarray):
        """Even-odd coverage of a polygon: (row0, col0, float32 (h, w)), or None off the canvas."""
        height, width = self.planes.shape[1:]
        if len(points) < 3 or not np.isfinite(points).all():
            return None
        box = _upright(points) if len(points) == 4 else None
        if box is not None:  # most of a plan: exact and much cheaper
            (x0, across), (y0, down) = _overlap(box[0], box[2], width), _overlap(box[1], box[3], height)
            return (y0, x0, down[:, None] * across[None]) if len(across) and len(down) else None
        x0, y0 = np.floor(points.min(axis=0)).astype(int)
        x1, y1 = np.ceil(points.max(axis=0)).astype(int)
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
        if x1 <= x0 or y1 <= y0:
            return None
        lines = y0 + (np.arange((y1 - y0) * LINES) + 0.5) / LINES
        p, q = points, following(points)
        low, high = np.minimum(p[:, 1], q[:, 1]), np.maximum(p[:, 1], q[:, 1])
        # Half-open: a corner shared by two edges is crossed once.
        active = (lines[None] >= low[:, None]) & (lines[None] < high[:, None])
        rise = np.where(q[:, 1] == p[:, 1], 1.0, q[:, 1] - p[:, 1])
        cross = p[:, :1] + (lines[None] - p[:, 1:]) * ((q[:, 0] - p[:, 0]) / rise)[:, None]
        cross = np.sort(np.where(active, cross, np.inf), axis=0)
        columns = np.arange(x0, x1)
        total = np.zeros((y1 - y0, len(columns)), dtype=np.float32)
        for k in range(0, len(cross) - 1, 2):
            a, b = cross[k], cross[k + 1]
            if not np.isfinite(b).any():
                break
            empty = ~np.isfinite(b)
            a, b = np.where(empty, x0, a), np.where(empty, x0, b)
            for sub in range(LINES):
                total += _spans(columns, a[sub::LINES], b[sub::LINES])
        total /= LINES
        return y0, x0, total

    def blend(self, row: int, col: int, mask: np.ndarray, ink: np.ndarray, opacity: float = 1.0) -> None:
        height, width = self.planes.shape[1:]
        r0, c0 = max(row, 0), max(col, 0)
        r1, c1 = min(row + mask.shape[0], height), min(col + mask.shape[1], width)
        if r1 <= r0 or c1 <= c0:
            return
        m = mask[r0 - row : r1 - row, c0 - col : c1 - col] * np.float32(opacity)
        band = self.planes[:, r0:r1, c0:c1]
        change = ink[:, None, None] - band
        change *= m
        band += change

    def fill(self, polygons: list[np.ndarray], ink: str, opacity: float = 1.0) -> None:
        """Several polygons of one look, blended once: where they overlap nothing gets darker.

        Transparent ones are taken to tile (coverages of shared border pixels add up), opaque ones to overlap (the
        largest counts), which keeps seams out of the ones and edges of the others crisp."""
        parts = [c for c in (self.coverage(p) for p in polygons) if c is not None]
        if not parts:
            return
        if len(parts) == 1:
            self.blend(*parts[0], colour(ink), opacity)
            return
        r0, c0 = min(p[0] for p in parts), min(p[1] for p in parts)
        r1, c1 = max(p[0] + p[2].shape[0] for p in parts), max(p[1] + p[2].shape[1] for p in parts)
        mask = np.zeros((r1 - r0, c1 - c0), dtype=np.float32)
        for r, c, m in parts:
            view = mask[r - r0 : r - r0 + m.shape[0], c - c0 : c - c0 + m.shape[1]]
            if opacity < 1.0:
                np.minimum(view + m, 1.0, out=view)
            else:
                np.maximum(view, m, out=view)
        ink3 = colour(ink)
        if sum(m.size for _, _, m in parts) >= mask.size:
            self.blend(r0, c0, mask, ink3, opacity)
            return
        for r, c, m in parts:  # far apart: piece by piece, each pixel still once
            view = mask[r - r0 : r - r0 + m.shape[0], c - c0 : c - c0 + m.shape[1]]
            self.blend(r, c, view, ink3, opacity)
            view[:] = 0.0

    def stroke(self, line: Line, scale: float) -> None:
        points = line.points * scale
        if line.closed:
            points = np.concatenate([points, points[:1]])
        half = max(line.width * scale / 2, 0.4)
        quads = []
        for a, b in _dashes(points, [v * scale for v in line.dash]):
            d = b - a
            n = math.hypot(*d)
            if n < 1e-9:
                if line.round:
                    quads.append(_disc(a, half))
                continue
            u = d / n
            v = np.array([-u[1], u[0]]) * half
            grow = u * half if (not line.dash and (line.closed or len(points) > 2)) else u * 0
            quads.append(np.array([a + v - grow, b + v + grow, b - v + grow, a - v - grow]))
            if line.round:
                quads += [_disc(a, half), _disc(b, half)]
        self.fill(quads, line.stroke)

    def letters(self, text: Text, scale: float) -> None:
        mask, left, baseline = lettering.mask(text.text, text.size * scale, text.bold)
        width = lettering.advance(text.text, text.size * scale, text.bold)
        back = {"start": 0.0, "middle": width / 2, "end": width}[text.anchor]
        if text.upright:
            mask = np.rot90(mask)
            row = round(text.y * scale + back) + left - mask.shape[0]
            col = round(text.x * scale) - baseline
        else:
            row, col = round(text.y * scale) - baseline, round(text.x * scale - back) - left
        if text.halo:
            r = max(1, round(1.4 * scale))
            grown = lettering.halo(text.text, text.size * scale, text.bold, r)
            self.blend(row - r, col - r, np.rot90(grown) if text.upright else grown, colour(text.halo))
        self.blend(row, col, mask, colour(text.colour))


def _disc(centre: np.ndarray, radius: float) -> np.ndarray:
    turn = np.linspace(0, 2 * math.pi, 17)[:-1]
    return centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def _dashes(points: np.ndarray, pattern: list[float]):
    """The pen-down segments of a polyline."""
    if not pattern or min(pattern) <= 0:
        yield from zip(points[:-1], points[1:], strict=False)
        return
    k, left = 0, pattern[0]
    for a, b in zip(points[:-1], points[1:], strict=False):
        n = math.hypot(*(b - a))
        at = 0.0
        while n - at > 1e-9:
            step = min(left, n - at)
            if k % 2 == 0:
                yield a + (b - a) * (at / n), a + (b - a) * ((at + step) / n)
            at, left = at + step, left - step
            if left <= 1e-9:
                k += 1
                left = pattern[k % len(pattern)]


def paint(drawing: Drawing, scale: float = 2.0) -> np.ndarray:
    """uint8 pixels (height, width, 3) of a drawing, `scale` pixels a page unit."""
    canvas = Canvas(max(1, math.ceil(drawing.width * scale)), max(1, math.ceil(drawing.height * scale)))
    run: list[Polygon] = []

    def flush() -> None:
        if run:
            canvas.fill([p.points * scale for p in run], run[0].fill, run[0].opacity)
            run.clear()

    for item in drawing.items:
        if isinstance(item, Polygon):
            if run and (item.fill, item.opacity) != (run[0].fill, run[0].opacity):
                flush()
            run.append(item)
            continue
        flush()
        if isinstance(item, Line):
            canvas.stroke(item, scale)
        elif isinstance(item, Text):
            canvas.letters(item, scale)
    flush()
    out = np.empty(canvas.pixels.shape, dtype=np.uint8)
    for k, plane in enumerate(canvas.planes):  # blends of 0..1 stay there: nothing to clip
        plane *= 255.0
        plane += 0.5
        out[..., k] = plane
    return out
