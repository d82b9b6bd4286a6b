# SPDX-License-Identifier: GPL-3.0-or-later
"""A storey plan as DXF (R12 ASCII, which every CAD reads): metres, one layer a kind of thing, isovists per camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..rules.whole_file import whole_file
from . import shapes2d
from .plan import Model, StoreyPlan

# Layer and AutoCAD colour index.
LAYERS = {"ROOMS": 7, "ROOM_NAMES": 8, "OPENINGS": 5, "VOIDS": 8, "CAMERAS": 1, "ISOVISTS": 2}


def _layer(name: str) -> str:
    """Layer names in R12: capitals, digits, dash, underscore, 31 characters."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in name.upper())[:31] or "_"


class Writer:
    def __init__(self) -> None:
        self.parts: list[str] = []

    def put(self, code: int, value) -> None:
        self.parts.append(f"{code}\n{f'{value:.4f}' if isinstance(value, float) else value}\n")

    def polyline(self, points: np.ndarray, layer: str, closed: bool) -> None:
        self.put(0, "POLYLINE")
        self.put(8, layer)
        self.put(66, 1)
        self.put(70, 1 if closed else 0)
        for x, y in points:
            self.put(0, "VERTEX")
            self.put(8, layer)
            self.put(10, float(x))
            self.put(20, float(y))
        self.put(0, "SEQEND")

    def text(self, x: float, y: float, height: float, text: str, layer: str) -> None:
        self.put(0, "TEXT")
        self.put(8, layer)
        self.put(10, float(x))
        self.put(20, float(y))
        self.put(40, float(height))
        plain = "".join(c if 32 <= ord(c) < 127 else f"\\U+{ord(c):04X}" if 127 < ord(c) <= 0xFFFF else " " for c in text)
        self.put(1, plain[:200])


def write(model: Model, plan: StoreyPlan, path: Path) -> None:
    """Writes one plan; world coordinates, metres."""
    w = Writer()
    isovist_layers = {c.group: _layer("ISOVIST_" + model.cameras[c.group].name) for c in plan.cameras}
    w.put(0, "SECTION")
    w.put(2, "TABLES")
    w.put(0, "TABLE")
    w.put(2, "LAYER")
    layers = {**LAYERS, **dict.fromkeys(isovist_layers.values(), 2)}
    w.put(70, len(layers))
    for name, colour in layers.items():
        w.put(0, "LAYER")
        w.put(2, name)
        w.put(70, 0)
        w.put(62, colour)
        w.put(6, "CONTINUOUS")
    w.put(0, "ENDTAB")
    w.put(0, "ENDSEC")
    w.put(0, "SECTION")
    w.put(2, "ENTITIES")
    for room in plan.rooms:
        if len(room.pieces) == 1 or not room.outline:
            for piece in room.pieces:
                w.polyline(piece, "ROOMS", True)
        else:
            for segment in room.outline:
                w.polyline(segment, "ROOMS", False)
        x, y = shapes2d.centroid(max(room.pieces, key=lambda p: abs(shapes2d.area(p))))
        w.text(x, y, 0.2, model.names.room(room.index), "ROOM_NAMES")
    for o in plan.openings:
        w.polyline(o.footprint, "VOIDS" if o.level.startswith("void") else "OPENINGS", len(o.footprint) > 2)
    for camera in plan.cameras:
        x, y = camera.position
        w.polyline(np.array([(x + 0.15 * np.cos(t), y + 0.15 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 13)[:-1]]),
                   "CAMERAS", True)
        w.text(x + 0.2, y, 0.2, model.cameras[camera.group].name, "CAMERAS")
        for isovist in camera.isovists[:1]:
            for _, piece in isovist.pieces:
                w.polyline(piece, isovist_layers[camera.group], True)
    w.put(0, "ENDSEC")
    w.put(0, "EOF")
    with whole_file(path) as partial:
        partial.write_text("".join(w.parts), encoding="ascii", errors="replace")
