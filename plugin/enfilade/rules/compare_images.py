# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares two renders through OpenImageIO: object index and depth bit for bit, the picture as figures. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..report import images
from ..report.images import ImageError

# Beauty may differ by this much in a channel before a pixel counts as different (linear light, 1.0 = white): a third of an
# 8-bit step. Noise that differs shows far above it; rounding far below.
SAME_COLOUR = 1.0 / 765.0


@dataclass
class Comparison:
    width: int
    height: int
    index_different: int  # pixels, as they are
    depth_different: int  # pixels, any bit
    # Of these, ties: both renders have both objects, and they lie in one place (within TIE of the depth). Two faces that
    # coincide are drawn in whichever order the renderer's tree has them; hiding a third object changes the tree.
    ties: int
    index_wrong: int  # what remains: something was hidden that shows
    depth_wrong: int
    depth_worst: float  # metres, the largest difference where both hit something
    beauty_rms: float  # of all colour channels, linear
    beauty_max: float
    beauty_different: int  # pixels beyond SAME_COLOUR
    beauty_share: float  # of all pixels

    @property
    def equal(self) -> bool:
        """What may never differ: which object each pixel shows and how far it is."""
        return self.index_wrong == 0 and self.depth_wrong == 0

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "equal": self.equal}


# Depths that differ by less than this part are one place: single precision carries 6e-8, a transformed ray loses some of it.
TIE = 1e-5


def read_layers(path: str) -> dict[str, np.ndarray]:
    """Channels of an EXR by name, float32 (height, width), whole names such as "ViewLayer.Depth.Z"."""
    picture = images.read_image(path)
    out: dict[str, np.ndarray] = {}
    for i, name in enumerate(picture.channels):
        out.setdefault(name, np.ascontiguousarray(picture.pixels[:, :, i]))
    return out


def of_view(layers: dict[str, np.ndarray], view: str) -> dict[str, np.ndarray]:
    """The channels of one view of a stereo pair, named as without ("ViewLayer.Depth.left.Z" is "ViewLayer.Depth.Z"); view "": all."""
    if not view:
        return layers
    return {n.replace(f".{view}.", "."): p for n, p in layers.items() if f".{view}." in n}


def beside(layers: dict[str, np.ndarray], views: Sequence[str]) -> dict[str, np.ndarray]:
    """The views of a stereo pair beside each other as one picture, in the order given; without views the layers as they are."""
    if not views:
        return layers
    eyes = [of_view(layers, view) for view in views]
    return {name: np.concatenate([eye[name] for eye in eyes], axis=1) for name in eyes[0] if all(name in eye for eye in eyes)}


def channel(layers: dict[str, np.ndarray], ending: str) -> np.ndarray:
    """The channel whose name ends so, e.g. "Depth.Z" (letters' case doesn't matter; Blender's spelling changed)."""
    for name, pixels in layers.items():
        if name.lower().endswith(ending.lower()):
            return pixels
    raise ImageError(f"there is no channel ...{ending}; there are {', '.join(layers)}")


def index_channel(layers: dict[str, np.ndarray]) -> np.ndarray:
    for ending in ("IndexOB.X", "Object Index.X", "ObjectIndex.X"):
        try:
            return channel(layers, ending)
        except ImageError:
            continue
    raise ImageError(f"there is no object index channel; there are {', '.join(layers)}")


def beauty(layers: dict[str, np.ndarray]) -> np.ndarray:
    """float32 (height, width, 3)."""
    return np.stack([channel(layers, f"Combined.{c}") for c in "RGB"], axis=2)


def compare(a: dict[str, np.ndarray], b: dict[str, np.ndarray], present: set[int] | None = None) -> Comparison:
    """a: the whole scene, b: the culled one. present: index values of objects that are surely in both renders; without it
    every difference counts as wrong."""
    index_a, index_b = index_channel(a), index_channel(b)
    depth_a, depth_b = channel(a, "Depth.Z"), channel(b, "Depth.Z")
    if index_a.shape != index_b.shape:
        raise ImageError(f"the pictures have different sizes: {index_a.shape[::-1]} and {index_b.shape[::-1]}")
    height, width = index_a.shape
    # bits, not values: nan equals nan, and -0 is not 0
    depth_bits = depth_a.view(np.uint32) != depth_b.view(np.uint32)
    index_bits = index_a.view(np.uint32) != index_b.view(np.uint32)
    with np.errstate(invalid="ignore"):
        same_place = np.abs(depth_a.astype(np.float64) - depth_b) <= TIE * np.maximum(np.abs(depth_a), 1e-3)
    known = np.array(sorted(present or ()), dtype=np.float32)
    ties = (index_bits | depth_bits) & same_place & np.isin(index_a, known) & np.isin(index_b, known)
    both = np.isfinite(depth_a) & np.isfinite(depth_b) & (depth_a < 1e9) & (depth_b < 1e9)
    worst = float(np.abs(depth_a.astype(np.float64) - depth_b)[both].max()) if both.any() else 0.0
    colour = np.abs(beauty(a).astype(np.float64) - beauty(b))
    different = int((colour.max(axis=2) > SAME_COLOUR).sum())
    return Comparison(
        width,
        height,
        int(index_bits.sum()),
        int(depth_bits.sum()),
        int(ties.sum()),
        int((index_bits & ~ties).sum()),
        int((depth_bits & ~ties).sum()),
        worst,
        float(np.sqrt((colour**2).mean())),
        float(colour.max()),
        different,
        different / (width * height),
    )


def write_png(path: str, linear: np.ndarray) -> None:
    """linear: float (height, width, 3), shown with the sRGB curve."""
    clipped = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * np.power(clipped, 1 / 2.4) - 0.055)
    images.write_png(path, np.rint(curve * 255.0).astype(np.uint8))


def side_by_side(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> np.ndarray:
    """Whole, culled, and where they differ (red: index or depth, else the colour difference ten times over)."""
    wrong = (index_channel(a) != index_channel(b)) | (channel(a, "Depth.Z").view(np.uint32) != channel(b, "Depth.Z").view(np.uint32))
    difference = np.clip(10.0 * np.abs(beauty(a) - beauty(b)), 0.0, 1.0)
    difference[wrong] = (1.0, 0.0, 0.0)
    line = np.ones((difference.shape[0], 4, 3), dtype=np.float32)
    return np.concatenate([beauty(a), line, beauty(b), line, difference], axis=1)
