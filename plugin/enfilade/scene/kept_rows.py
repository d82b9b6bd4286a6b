# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees whom, kept in the file: the core's state file, compressed, in a text of the .blend.

Belongs to the geometry it was baked for: the core refuses it for any other, and then it is as if it weren't there. Door states may
have changed: what they can't change is taken over.
"""

from __future__ import annotations

import base64
import zlib

import bpy

from . import kept_text

TEXT = "Enfilade rows"
TEXT_KEY = "enfilade_rows"  # on the scene: name of the text
HEAD = "enfilade-rows 1"


def store(scene: bpy.types.Scene, state: bytes) -> None:
    packed = base64.b85encode(zlib.compress(state, 6)).decode()
    kept_text.store(scene, TEXT_KEY, TEXT, f"{HEAD} {packed}")


def load(scene: bpy.types.Scene) -> bytes | None:
    """None: nothing kept, or it is damaged."""
    content = kept_text.load(scene, TEXT_KEY) or ""
    if not content.startswith(HEAD):
        return None
    try:
        return zlib.decompress(base64.b85decode(content[len(HEAD) :].strip()))
    except (ValueError, zlib.error):
        return None


def remove(scene: bpy.types.Scene) -> None:
    kept_text.remove(scene, TEXT_KEY)
