# SPDX-License-Identifier: GPL-3.0-or-later
"""What is hidden at which frame, kept in the file and applied before each frame is drawn.

Computed beforehand and keyed by `frame_current`: during an animation render the original camera never moves, so nothing
that looks at it can be right. Frames outside the table show everything.
"""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import apply_result, kept_text

TEXT = "Enfilade frames"
TEXT_KEY = "enfilade_frames"  # on the scene: name of the text
FORMAT, VERSION = "enfilade-frames", 1


@dataclass
class FrameTable:
    mode: str
    names: list[str]  # candidates, full object names
    frames: dict[int, np.ndarray] = field(default_factory=dict)  # bool (names,): hidden at that frame

    def to_json(self) -> str:
        packed = {
            str(frame): base64.b85encode(zlib.compress(np.packbits(hidden).tobytes(), 6)).decode()
            for frame, hidden in sorted(self.frames.items())
        }
        return json.dumps(
            {"format": FORMAT, "version": VERSION, "mode": self.mode, "names": self.names, "frames": packed},
            ensure_ascii=False,
        )

    @classmethod
    def from_json(cls, text: str) -> FrameTable:
        """ValueError with the reason for anything damaged."""
        try:
            data = json.loads(text)
            if data["format"] != FORMAT or data["version"] > VERSION:
                raise ValueError("not a frame table this Enfilade knows")
            if data["mode"] not in apply_result.MODES:
                raise ValueError(f"unknown mode {data['mode']}")
            names = [str(n) for n in data["names"]]
            frames = {}
            for frame, packed in data["frames"].items():
                raw = np.frombuffer(zlib.decompress(base64.b85decode(packed)), dtype=np.uint8)
                bits = np.unpackbits(raw)[: len(names)].astype(bool)
                if len(bits) != len(names):
                    raise ValueError(f"frame {frame} is cut short")
                frames[int(frame)] = bits
            return cls(data["mode"], names, frames)
        except (KeyError, TypeError, AttributeError, zlib.error) as error:
            raise ValueError(f"the frame table is damaged: {error!r}") from error


_cache: dict[str, tuple[int, FrameTable]] = {}  # scene name -> (hash of the text, table)


def store(scene: bpy.types.Scene, table: FrameTable) -> None:
    remove(scene)
    kept_text.store(scene, TEXT_KEY, TEXT, table.to_json())


def load(scene: bpy.types.Scene) -> FrameTable | None:
    content = kept_text.load(scene, TEXT_KEY)
    if content is None:
        return None
    key = hash(content)
    cached = _cache.get(scene.name_full)
    if cached and cached[0] == key:
        return cached[1]
    table = FrameTable.from_json(content)
    _cache[scene.name_full] = (key, table)
    return table


def remove(scene: bpy.types.Scene) -> None:
    kept_text.remove(scene, TEXT_KEY)
    _cache.pop(scene.name_full, None)


def apply_frame(scene: bpy.types.Scene, frame: int) -> int | None:
    """Writes what differs at this frame. Returns the flags written, None when the scene has no table."""
    if TEXT_KEY not in scene:
        return None
    table = load(scene)
    if table is None:
        return None
    hidden = table.frames.get(frame)
    wanted = set() if hidden is None else {table.names[i] for i in np.nonzero(hidden)[0]}
    ours = {o.name_full: o for o in apply_result.hidden_objects(table.mode)}
    missing = wanted.difference(ours)
    to_hide = [obj for obj in scene.objects if obj.name_full in missing] if missing else []
    to_show = [obj for name, obj in ours.items() if name not in wanted]
    return sum(apply_result.apply_difference(table.mode, to_hide, to_show))
