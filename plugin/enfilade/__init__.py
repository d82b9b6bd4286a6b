# SPDX-License-Identifier: GPL-3.0-or-later
"""Enfilade: what can be seen through the doors and windows of a building, inside Blender."""

bl_info = {
    "name": "Enfilade",
    "author": "The Enfilade authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Enfilade",
    "description": "Hides what a view of a building doesn't need, renders faster for it, and reports who sees what",
    "category": "3D View",
}

# A name of its own: Blender 4.2 and newer take `bl_info` away from extensions.
VERSION = bl_info["version"]


def register() -> None:
    from . import registration

    registration.register()


def unregister() -> None:
    from . import registration

    registration.unregister()
