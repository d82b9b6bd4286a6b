# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept with the file: a text of the .blend for each kind, named by a property of its scene. Content has no line breaks of its
own; the text does."""

from __future__ import annotations

import bpy

LINE = 2000  # characters. Blender's time to write a line grows with its square: a megabyte in one takes seconds, in many, milliseconds


def store(scene: bpy.types.Scene, key: str, name: str, content: str) -> None:
    """In place of what the scene kept under this key. Blender may number the text's name; the property has it as it is."""
    remove(scene, key)
    text = bpy.data.texts.new(name)
    text.from_string("\n".join(content[i : i + LINE] for i in range(0, len(content), LINE)))
    text.use_fake_user = True
    scene[key] = text.name


def load(scene: bpy.types.Scene, key: str) -> str | None:
    """None: nothing is kept."""
    text = bpy.data.texts.get(scene.get(key, ""))
    return None if text is None else text.as_string().replace("\n", "")


def remove(scene: bpy.types.Scene, key: str) -> None:
    text = bpy.data.texts.get(scene.get(key, ""))
    if text is not None:
        bpy.data.texts.remove(text)
    if key in scene:
        del scene[key]
