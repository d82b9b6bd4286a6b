# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures on disk: written and read through OpenImageIO (renders are compared in rules/compare_images.py).

Only where a Blender comes without the module are PNGs written by a few lines of our own (zlib); reading needs it and
says so.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..rules.whole_file import whole_file

try:
    import OpenImageIO as oiio
except ImportError:
    oiio = None


PNG_END = b"IEND\xaeB`\x82"


class ImageError(OSError):
    """A picture that can't be read or written; the message names the file and the reason."""


def need() -> None:
    """ImageError where OpenImageIO's module is missing."""
    if oiio is None:
        raise ImageError("OpenImageIO's Python module isn't installed: pictures can't be read")


def write_png(path: Path | str, pixels: np.ndarray, metadata: dict[str, str | int | float] | None = None) -> None:
    """uint8 (h, w) or (h, w, 1..4) to a PNG; through a temporary file, so never half a picture. metadata: texts beside it."""
    pixels = np.ascontiguousarray(pixels, dtype=np.uint8)
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    if oiio is None:
        with whole_file(path) as partial:
            partial.write_bytes(_png_bytes(pixels))
        return
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.UINT8)
    spec.attribute("png:compressionLevel", 4)
    for key, value in (metadata or {}).items():
        spec.attribute(key, value)
    write(path, spec, pixels, PNG_END)


def write(path: Path | str, spec: Any, pixels: np.ndarray, end: bytes = b"") -> None:
    """pixels (h, w, c) as an OpenImageIO spec describes them, in the format the path's ending names. end: what a whole file ends in, for
    writers that don't hear of a full disk."""
    with whole_file(path) as partial:
        out = oiio.ImageOutput.create(str(partial))
        if out is None:
            raise ImageError(f"{path}: {oiio.geterror() or 'no writer for this kind of picture'}")
        good = out.open(str(partial), spec) and out.write_image(pixels) and out.close()
        if not good or not partial.read_bytes().endswith(end):
            raise ImageError(f"{path}: {out.geterror() or 'writing failed: is the disk full?'}")


def png_bytes(pixels: np.ndarray) -> bytes:
    """A PNG in memory, for inlining; no metadata, so equal pixels give equal bytes."""
    pixels = np.ascontiguousarray(pixels, dtype=np.uint8)
    return _png_bytes(pixels[..., None] if pixels.ndim == 2 else pixels)


def _png_bytes(pixels: np.ndarray) -> bytes:
    height, width, channels = pixels.shape
    rows = np.zeros((height, 1 + width * channels), dtype=np.uint8)  # filter type 0 in front of each row
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b"")


@dataclass
class Picture:
    """All channels of a file."""

    pixels: np.ndarray  # float32 (h, w, channels)
    channels: list[str]
    subimages: list[str] = field(default_factory=list)  # names of parts (multi-layer EXR), in order of `channels`


def read_image(path: Path | str) -> Picture:
    """Every channel of every part of a picture as float32; parts of another size than the first are refused."""
    need()
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise ImageError(f"{path}: {oiio.geterror() or 'not a picture'}")
    parts, names, subimages = [], [], []
    try:
        index = 0
        while source.seek_subimage(index, 0):
            spec = source.spec()
            data = source.read_image(index, 0, 0, spec.nchannels, oiio.FLOAT)
            if data is None:
                raise ImageError(f"{path}: part {index}: {source.geterror() or 'reading failed'}")
            data = np.asarray(data, dtype=np.float32).reshape(spec.height, spec.width, spec.nchannels)
            if parts and data.shape[:2] != parts[0].shape[:2]:
                raise ImageError(f"{path}: part {index} is {spec.width}x{spec.height}, the first isn't")
            name = spec.get_string_attribute("oiio:subimagename") or spec.get_string_attribute("name")
            parts.append(data)
            names.append(list(spec.channelnames))
            subimages.append(name)
            index += 1
    finally:
        source.close()
    if not parts:
        raise ImageError(f"{path}: no picture in it")
    if len(parts) > 1:  # channels of one name in several parts are told apart by the part's name
        names = [[c if "." in c or not part else f"{part}.{c}" for c in own] for part, own in zip(subimages, names, strict=True)]
    return Picture(np.concatenate(parts, axis=2), [c for own in names for c in own], subimages)


def contact_sheet(pictures: list[tuple[str, np.ndarray]], columns: int = 0, cell: int = 320) -> np.ndarray:
    """Small versions of pictures (name, uint8 (h, w, 3)) side by side with their names. -> uint8 (h, w, 3)."""
    from . import raster
    from .drawing import Drawing, shorten

    if not pictures:
        raise ImageError("no pictures for a contact sheet")
    columns = columns or min(4, max(1, round(len(pictures) ** 0.5 + 0.4)))
    small = [(name, shrink(p, cell)) for name, p in pictures]
    tall = max(p.shape[0] for _, p in small)
    rows = -(-len(small) // columns)
    gap, foot = 14, 24
    page = Drawing(columns * (cell + gap) + gap, rows * (tall + gap + foot) + gap, "contact sheet")
    for k, (name, _) in enumerate(small):
        x, y = gap + (k % columns) * (cell + gap), gap + (k // columns) * (tall + gap + foot)
        page.text(x, y + tall + 16, shorten(name, cell // 8), 12)
    out = raster.paint(page, 1.0)
    for k, (_, picture) in enumerate(small):
        x, y = gap + (k % columns) * (cell + gap), gap + (k // columns) * (tall + gap + foot)
        y += (tall - picture.shape[0]) // 2
        out[y : y + picture.shape[0], x : x + picture.shape[1]] = picture[..., :3]
    return out


def shrink(pixels: np.ndarray, width: int) -> np.ndarray:
    """uint8 (h, w, c) brought to `width` columns (never enlarged), through OpenImageIO's resampling: weighted means, a sixth of the
    time of its own choice of filter."""
    height, wide, channels = pixels.shape
    if wide <= width:
        return pixels
    tall = max(1, round(height * width / wide))
    need()
    source = oiio.ImageBuf(oiio.ImageSpec(wide, height, channels, oiio.UINT8))
    source.set_pixels(oiio.ROI(0, wide, 0, height, 0, 1, 0, channels), np.ascontiguousarray(pixels))
    result = oiio.ImageBufAlgo.resize(source, filtername="triangle", roi=oiio.ROI(0, width, 0, tall, 0, 1, 0, channels))
    return np.asarray(result.get_pixels(oiio.UINT8)).reshape(tall, width, channels)
