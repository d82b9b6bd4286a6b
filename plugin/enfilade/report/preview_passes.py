# SPDX-License-Identifier: GPL-3.0-or-later
"""A preview's layers as pictures for people: shaded, rooms, objects, depth, openings looked through, lights. Numpy, no bpy.

All passes share one drawing: the form in soft light, outlines where one thing ends, and a calm colour that says what the pass is about.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass, field
from typing import Any

import numpy as np

TITLES = {"shaded": "Shaded", "rooms": "Rooms", "objects": "Objects", "depth": "Depth", "openings": "Openings looked through",
          "lights": "Lights that reach it"}
NOTHING = 0xFFFFFFFF
PAPER = np.array([0.955, 0.957, 0.96], np.float32)  # display-referred: what no pass has anything to say about
# From near to far, from few to many: even steps of lightness, so that a grey print keeps the order.
NEAR_FAR = ("#fbf3dd", "#f3d9a4", "#e3b27c", "#c58870", "#97656f", "#66496a", "#3b3057", "#1d1b38")
FEW = ("#f4f1ea", "#f6d99a", "#eeae5c", "#d97d45", "#b4503f", "#82304a", "#531d4c", "#2a1140")
MOST_NAMED = 24  # entries of a legend


@dataclass
class Legend:
    """What the colours of a pass mean."""

    entries: list[tuple[str, str]] = field(default_factory=list)  # "#rrggbb", text
    ramp: list[str] = field(default_factory=list)  # colours from low to high, with `ends`
    ends: tuple[str, str] = ("", "")
    note: str = ""


def srgb(linear: np.ndarray) -> np.ndarray:
    x = np.clip(linear, 0.0, None)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(np.maximum(x, 1e-9), 1 / 2.4) - 0.055).astype(np.float32)


def colours(names: tuple[str, ...] | list[str]) -> np.ndarray:
    """"#rrggbb" each -> float32 (n, 3), 0..1."""
    return np.array([[int(n[i : i + 2], 16) / 255.0 for i in (1, 3, 5)] for n in names], np.float32)


def hexed(rgb: np.ndarray) -> str:
    return "#" + "".join(f"{round(255 * float(np.clip(v, 0, 1))):02x}" for v in rgb)


def spread(count: int, saturation: float = 0.36, value: float = 0.95) -> np.ndarray:
    """`count` colours that neighbours in number don't share: hues by the golden ratio, two strengths. float32 (count, 3)."""
    out = []
    for i in range(count):
        hue = (0.07 + i * 0.61803398875) % 1.0
        out.append(colorsys.hsv_to_rgb(hue, saturation * (1.0 if i % 2 else 0.72), value - 0.10 * (i // 2 % 2)))
    return np.array(out, np.float32).reshape(-1, 3)


# ---- Form -----------------------------------------------------------------------------------------------------


def background(layers: Any) -> np.ndarray:
    return ~np.isfinite(layers.depth)


def radiance(layers: Any) -> np.ndarray:
    """Lights, and the surroundings as far as they are open. float32 (h, w, 3), linear."""
    shade = layers.open.astype(np.float32) ** 1.25  # corners a little deeper than sums of sky say: the eye expects bounces to be coloured
    return layers.direct + layers.surroundings * shade[..., None]


def exposure(layers: Any) -> float:
    """The factor that brings what is drawn to a bright but not white tone."""
    light = radiance(layers).mean(axis=2)
    drawn = light[~background(layers)]
    drawn = drawn[drawn > 0]
    if not drawn.size:
        return 1.0
    middle, bright = np.exp(np.log(np.maximum(drawn, 1e-6)).mean()), np.percentile(drawn, 92)
    return float(1.3 / max(0.5 * (2.2 * middle + bright), 1e-6))


def tone(linear: np.ndarray) -> np.ndarray:
    """Rolls highlights off towards white; mid-tones keep their hue. -> display-referred 0..1."""
    x = np.maximum(linear, 0.0)
    peak = x.max(axis=-1, keepdims=True)
    rolled = peak * (1.0 + peak / 9.0) / (1.0 + peak)  # Reinhard, white at 3
    scaled = x * (rolled / np.maximum(peak, 1e-9)) * 1.25
    over = np.clip(scaled - 1.0, 0.0, None).max(axis=-1, keepdims=True)
    return srgb(np.clip(scaled + 0.35 * over, 0.0, 1.0))


def form(layers: Any) -> np.ndarray:
    """How light the shape alone is, 0..1 display-referred (h, w): open surroundings, brighter from above and from the viewer's left."""
    facing = 0.80 + 0.14 * layers.normal[..., 2] + 0.06 * layers.normal[..., 0]
    return np.clip(facing * (0.42 + 0.58 * layers.open), 0.0, 1.0)


def outlines(layers: Any) -> np.ndarray:
    """How strong a line passes through each pixel, 0..1 (h, w): strong between objects, weak along creases."""
    h, w = layers.depth.shape
    strong = np.zeros((h, w), np.float32)
    inverse = np.where(np.isfinite(layers.depth), 1.0 / np.maximum(layers.depth, 1e-6), 0.0).astype(np.float64)
    for axis in (0, 1):
        a = [slice(None)] * 2
        b = [slice(None)] * 2
        a[axis], b[axis] = slice(None, -1), slice(1, None)
        a, b = tuple(a), tuple(b)
        crease = (layers.normal[a] * layers.normal[b]).sum(axis=2) < 0.82
        other = layers.object[a] != layers.object[b]
        # 1/depth is straight over a plane: what bends is a step
        bend = np.zeros((h, w))
        middle = [slice(None)] * 2
        low, high = [slice(None)] * 2, [slice(None)] * 2
        middle[axis], low[axis], high[axis] = slice(1, -1), slice(None, -2), slice(2, None)
        bend[tuple(middle)] = np.abs(inverse[tuple(low)] + inverse[tuple(high)] - 2 * inverse[tuple(middle)])
        step = np.maximum(bend[a], bend[b]) > 0.03 * np.maximum(inverse[a], inverse[b])
        line = np.where(step & other, 0.85, np.where(crease | step, 0.5, 0.0)).astype(np.float32)
        # drawn on the nearer side
        near_a = layers.depth[a] <= layers.depth[b]
        strong[a] = np.maximum(strong[a], np.where(near_a, line, 0.25 * line))
        strong[b] = np.maximum(strong[b], np.where(near_a, 0.25 * line, line))
    far = np.clip(np.where(np.isfinite(layers.depth), layers.depth, 1e9) / 40.0, 0.0, 1.0)  # metres: distant detail isn't drowned in lines
    return strong * (1.0 - 0.75 * far).astype(np.float32)


def _inked(picture: np.ndarray, layers: Any, strength: float) -> np.ndarray:
    ink = np.array([0.13, 0.135, 0.15], np.float32)
    a = (strength * outlines(layers))[..., None]
    return picture * (1 - a) + ink * a


# ---- Passes ---------------------------------------------------------------------------------------------------


def shaded(layers: Any) -> tuple[np.ndarray, Legend]:
    factor = exposure(layers)
    empty = background(layers)[..., None]
    shown = np.where(empty, srgb(np.clip(layers.direct, 0, 1)), tone(radiance(layers) * factor))
    return _inked(shown, layers, 0.28), Legend()


def _tinted(layers: Any, tint: np.ndarray) -> np.ndarray:
    """Colours (h, w, 3) on the form; background stays paper."""
    out = tint * form(layers)[..., None] ** 0.85
    out[background(layers)] = PAPER
    return _inked(out, layers, 0.42)


def rooms(layers: Any, room_of: np.ndarray, names: list[str]) -> tuple[np.ndarray, Legend]:
    palette = np.vstack([spread(len(names)), [[0.88, 0.885, 0.89]]]).astype(np.float32)
    legend = Legend()
    shown, counts = np.unique(room_of[~background(layers)], return_counts=True)
    for r in shown[np.argsort(-counts, kind="stable")][:MOST_NAMED]:
        if r >= 0:
            legend.entries.append((hexed(palette[r]), names[r]))
    if (shown < 0).any():
        legend.entries.append((hexed(palette[-1]), "in no room"))
    return _tinted(layers, palette[room_of]), legend


def objects(layers: Any, names: list[str]) -> tuple[np.ndarray, Legend]:
    drawn = ~background(layers)
    shown, where, counts = np.unique(layers.object[drawn], return_inverse=True, return_counts=True)
    # the largest get the first colours, which lie farthest apart
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    palette = spread(len(shown), 0.46, 0.93)
    tint = np.zeros((*layers.object.shape, 3), np.float32)
    tint[drawn] = palette[rank[where.reshape(-1)]]
    legend = Legend(note=f"{len(shown)} objects" if names else f"{len(shown)} faces")
    for k in order[:MOST_NAMED]:
        number = int(shown[k])
        if number < len(names):
            legend.entries.append((hexed(palette[rank[k]]), names[number]))
    return _tinted(layers, tint), legend


def _ramp(value: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    stops = colours(names)
    x = np.clip(value, 0.0, 1.0) * (len(stops) - 1)
    i = np.minimum(x.astype(np.int64), len(stops) - 2)
    t = (x - i)[..., None].astype(np.float32)
    return stops[i] * (1 - t) + stops[i + 1] * t


def depth(layers: Any) -> tuple[np.ndarray, Legend]:
    known = layers.depth[np.isfinite(layers.depth)]
    if not known.size:
        return np.broadcast_to(PAPER, (*layers.depth.shape, 3)).copy(), Legend(note="nothing is drawn")
    near, far = (float(v) for v in np.percentile(known, (0.5, 99.0)))
    near, far = max(near, 1e-3), max(far, 1.001 * max(near, 1e-3))
    # even steps of the logarithm: a metre matters nearby
    value = np.log(np.clip(np.where(np.isfinite(layers.depth), layers.depth, far), near, far) / near) / np.log(far / near)
    out = _ramp(value, NEAR_FAR)
    out[background(layers)] = PAPER
    return _inked(out, layers, 0.22), Legend(ramp=list(NEAR_FAR), ends=(f"{near:.1f} m", f"{far:.1f} m"))


def _counted(layers: Any, number: np.ndarray, what: str) -> tuple[np.ndarray, Legend]:
    drawn = ~background(layers)
    most = int(number[drawn].max()) if drawn.any() else 0
    steps = min(most, len(FEW) - 1)
    palette = colours(FEW)  # up to seven a colour means the same number in every picture
    legend = Legend(note=what)
    # many lights: a colour stands for a range of numbers
    edges = [0] + [round(1 + (most - 1) * i / max(steps - 1, 1)) for i in range(steps)] if most > len(FEW) - 1 else list(range(most + 1))
    index = np.searchsorted(np.array(edges), number, side="right") - 1
    for i, low in enumerate(edges):
        high = edges[i + 1] - 1 if i + 1 < len(edges) else most
        legend.entries.append((hexed(palette[i]), f"{low}" if high <= low else f"{low} to {high}"))
    return _tinted(layers, palette[np.clip(index, 0, len(palette) - 1)]), legend


def openings(layers: Any) -> tuple[np.ndarray, Legend]:
    return _counted(layers, layers.openings.astype(np.int64), "doors, windows and holes between the camera and the surface")


def lights(layers: Any) -> tuple[np.ndarray, Legend]:
    return _counted(layers, layers.lit.astype(np.int64), "lamps and suns whose light arrives straight")


def draw(name: str, layers: Any, room_of: np.ndarray, room_names: list[str], object_names: list[str]) -> tuple[np.ndarray, Legend]:
    """One pass: uint8 (h, w, 3) and what its colours mean."""
    made = {
        "shaded": lambda: shaded(layers),
        "rooms": lambda: rooms(layers, room_of, room_names),
        "objects": lambda: objects(layers, object_names),
        "depth": lambda: depth(layers),
        "openings": lambda: openings(layers),
        "lights": lambda: lights(layers),
    }[name]()
    return np.rint(255.0 * np.clip(made[0], 0.0, 1.0)).astype(np.uint8), made[1]
