# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews on disk through OpenImageIO: one EXR with every layer and named objects, a PNG a pass, a contact sheet of all cameras.

Objects are named in the EXR as Cryptomatte has it (J. Friedman, A. C. Jones, "Fully automatic ID mattes with support for motion blur and
transparency", 2015): a number a name, shares a pixel, and the list of names in the metadata. Compositors select by clicking.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from . import images, preview_passes, raster
from .drawing import FAINT_INK, INK, Drawing, shorten, text_width

PIXELS_A_COLUMN = 460  # of the contact sheet


# ---- Cryptomatte ------------------------------------------------------------------------------------------------


def murmur3(data: bytes, seed: int = 0) -> int:
    """MurmurHash3, 32 bits (A. Appleby): what Cryptomatte makes of a name."""
    mask = 0xFFFFFFFF
    h = seed
    whole = len(data) - len(data) % 4
    for i in range(0, whole, 4):
        k = int.from_bytes(data[i : i + 4], "little") * 0xCC9E2D51 & mask
        k = ((k << 15 | k >> 17) & mask) * 0x1B873593 & mask
        h ^= k
        h = ((h << 13 | h >> 19) & mask) * 5 + 0xE6546B64 & mask
    if len(data) % 4:
        k = int.from_bytes(data[whole:], "little") * 0xCC9E2D51 & mask
        h ^= ((k << 15 | k >> 17) & mask) * 0x1B873593 & mask
    h ^= len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & mask
    h = (h ^ h >> 13) * 0xC2B2AE35 & mask
    return h ^ h >> 16


def crypto_number(name: str) -> int:
    """The hash as the bits of a float that is a number: an exponent of all zeros or all ones is flipped."""
    h = murmur3(name.encode("utf-8", "surrogateescape"))
    exponent = h >> 23 & 255
    return h ^ 1 << 23 if exponent in (0, 255) else h


def _crypto(names: list[str], numbers: np.ndarray, coverage: np.ndarray, kind: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Channels and metadata of one kind of matte. numbers: int64 (h, w, ranks), -1 none; coverage: float32 (h, w, ranks)."""
    codes = np.array([crypto_number(n) for n in names] + [0], np.uint32)
    ids = codes[numbers].view(np.float32)
    shares = np.where(numbers >= 0, coverage, 0).astype(np.float32)
    channels = {}
    for level in range(ids.shape[2] // 2):
        for k, name in enumerate("RGBA"):
            source = ids if k % 2 == 0 else shares
            channels[f"{kind}{level:02d}.{name}"] = source[:, :, 2 * level + k // 2]
    key = f"cryptomatte/{crypto_number(kind):08x}"[:19]
    manifest = json.dumps({n: f"{int(c):08x}" for n, c in zip(names, codes, strict=False)}, ensure_ascii=True)
    return channels, {f"{key}/name": kind, f"{key}/hash": "MurmurHash3_32", f"{key}/conversion": "uint32_to_float32",
                      f"{key}/manifest": manifest}


# ---- Files ------------------------------------------------------------------------------------------------------


def write_exr(path: Path | str, layers: Any, object_names: list[str], room_of: np.ndarray, room_names: list[str],
              metadata: dict[str, str | int | float]) -> None:
    """Every layer, 32-bit, lossless (ZIP); whole or not at all."""
    images.need()
    oiio = images.oiio
    h, w = layers.depth.shape
    light = preview_passes.radiance(layers)
    channels: dict[str, np.ndarray] = {}
    for k, c in enumerate("RGB"):
        channels[c] = light[..., k]
    channels["A"] = np.isfinite(layers.depth).astype(np.float32)
    for name, layer in (("Albedo", layers.albedo), ("Direct", layers.direct), ("Surroundings", layers.surroundings)):
        for k, c in enumerate("RGB"):
            channels[f"{name}.{c}"] = layer[..., k]
    for k, c in enumerate("XYZ"):
        channels[f"Normal.{c}"] = layers.normal[..., k]
    channels["Depth.Z"] = np.where(np.isfinite(layers.depth), layers.depth, 1e10)  # as Blender writes nothing
    channels["Open.V"] = layers.open
    channels["Openings.V"] = layers.openings.astype(np.float32)
    channels["Lights.V"] = layers.lit.astype(np.float32)
    channels["Room.V"] = room_of.astype(np.float32)
    none = np.uint32(preview_passes.NOTHING)
    channels["Object.V"] = np.where(layers.object == none, -1.0, layers.object.astype(np.float64)).astype(np.float32)
    channels["Cell.V"] = np.where(layers.cell == none, -1.0, layers.cell.astype(np.float64)).astype(np.float32)
    attributes: dict[str, str | int | float] = dict(metadata)
    if object_names:
        numbers = layers.coverage[..., 0].astype(np.int64)
        more, about = _crypto(object_names, numbers, layers.coverage[..., 1], "CryptoObject")
        channels.update(more)
        attributes.update(about)
    if room_names:
        rank = np.stack([room_of, np.full_like(room_of, -1)], axis=2)
        more, about = _crypto(room_names, rank, np.stack([channels["A"], np.zeros((h, w), np.float32)], axis=2), "CryptoRoom")
        channels.update(more)
        attributes.update(about)
    spec = oiio.ImageSpec(w, h, len(channels), oiio.FLOAT)
    spec.channelnames = tuple(channels)
    spec.attribute("compression", "zip")
    for key, value in attributes.items():
        spec.attribute(key, value)
    images.write(path, spec, np.ascontiguousarray(np.stack([np.asarray(c, np.float32) for c in channels.values()], axis=2)))


def _legend(page: Drawing, x: float, y: float, width: float, legend: preview_passes.Legend) -> float:
    """Draws a legend below a column's heading; gives the height it takes."""
    top = y
    if legend.ramp:
        step = (width - 4) / len(legend.ramp)
        for i, c in enumerate(legend.ramp):
            page.polygon([(x + i * step, y), (x + (i + 1) * step + 0.5, y), (x + (i + 1) * step + 0.5, y + 12), (x + i * step, y + 12)], c)
        page.text(x, y + 27, legend.ends[0], 12)
        page.text(x + width - 4, y + 27, legend.ends[1], 12, anchor="end")
        y += 36
    column = x
    for colour, text in legend.entries:
        label = shorten(text, 30)
        need = 18 + text_width(label, 12) + 14
        if column > x and column + need > x + width:
            column, y = x, y + 19
        page.polygon([(column, y), (column + 12, y), (column + 12, y + 12), (column, y + 12)], colour)
        page.line([(column, y), (column + 12, y), (column + 12, y + 12), (column, y + 12)], FAINT_INK, 0.8, closed=True)
        page.text(column + 18, y + 11, label, 12)
        column += need
    if legend.entries:
        y += 21
    if legend.note:
        page.text(x, y + 11, legend.note, 11.5, FAINT_INK)
        y += 19
    return y - top


def contact_sheet(title: str, rows: list[tuple[str, str, list[tuple[str, np.ndarray, preview_passes.Legend]]]]) -> np.ndarray:
    """A row a camera: (name, a line of figures, [(pass's title, picture, legend), ...]). -> uint8 (h, w, 3)."""
    wide, gap, margin = PIXELS_A_COLUMN, 18, 34
    columns = max((len(r[2]) for r in rows), default=1)
    if columns > 3:  # two lines a camera: a sheet that fits a screen's width
        columns = (columns + 1) // 2
    placed = []
    page = Drawing(2 * margin + columns * wide + (columns - 1) * gap, 0, title)
    y = 42.0
    page.text(margin, y, shorten(title, 90), 24, bold=True)
    y += 34
    for name, figures, passes in rows:
        page.line([(margin, y - 12), (page.width - margin, y - 12)], "#d6d9dd", 1.0)
        heading, line = shorten(name, 60 if columns > 1 else 40), shorten(figures, 130 if columns > 1 else 70)
        page.text(margin, y + 12, heading, 17, bold=True)
        if 1.15 * text_width(heading, 17) + 24 + text_width(line, 12) <= page.width - 2 * margin:
            page.text(page.width - margin, y + 12, line, 12, FAINT_INK, anchor="end")
        else:
            y += 18
            page.text(margin, y + 12, line, 12, FAINT_INK)
        y += 28
        for first in range(0, len(passes), columns):
            tallest = deepest = 0.0
            for k, (_, picture, _) in enumerate(passes[first : first + columns]):
                small = images.shrink(picture, wide)
                x = margin + k * (wide + gap) + (wide - small.shape[1]) / 2
                placed.append((x, y, small))
                tallest = max(tallest, small.shape[0])
            for k, (label, _, legend) in enumerate(passes[first : first + columns]):
                x = margin + k * (wide + gap)
                page.text(x, y + tallest + 19, label, 13.5, INK, bold=True)
                deepest = max(deepest, _legend(page, x, y + tallest + 28, wide, legend))
            y += tallest + 32 + deepest + 10
        y += 12
    page.height = y + 8
    out = raster.paint(page, 1.0)
    for x, top, small in placed:
        out[round(top) : round(top) + small.shape[0], round(x) : round(x) + small.shape[1]] = small[..., :3]
    return out
