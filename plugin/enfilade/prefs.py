# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences: always registered, also when the core can't be loaded, so that there is a place that says why."""

from __future__ import annotations

import os

import bpy
from bpy.props import StringProperty

from . import native
from .rules import ifc_library


def _folder_changed(self, context) -> None:
    ifc_library.extra_folders[:] = [bpy.path.abspath(self.python_folder)] if self.python_folder else []


class EnfiladePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    python_folder: StringProperty(
        name="IfcOpenShell folder",
        description="A folder made by 'pip install --target FOLDER ifcopenshell', for reading IFC files without Bonsai",
        subtype="DIR_PATH",
        update=_folder_changed,
    )

    def draw(self, context) -> None:
        usable, line = native.status()
        self.layout.label(text=line, icon="CHECKMARK" if usable else "ERROR")
        there = ifc_library.seems_there()
        row = self.layout.row()
        row.label(text="IFC files can be read" if there else "IFC files can't be read: IfcOpenShell is missing", icon="CHECKMARK" if there else "INFO")
        if not there:
            self.layout.label(text="Install the extension Bonsai, which brings it; or paste the command into a terminal:")
            row.operator("enfilade.copy_ifc_command", icon="COPYDOWN")
            self.layout.label(text=ifc_library.install_command())
        self.layout.prop(self, "python_folder")
        self.layout.operator("enfilade.copy_diagnostics", icon="COPYDOWN")


CLASSES = (EnfiladePreferences,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    folder = os.path.join(bpy.utils.user_resource("DATAFILES"), "enfilade")
    ifc_library.own_folder = os.path.join(folder, f"python-{ifc_library.python_version()}")
    addon = bpy.context.preferences.addons.get(__package__)
    if addon is not None and addon.preferences is not None:
        _folder_changed(addon.preferences, bpy.context)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
