# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings to other tools' files, and cells and portals from them into the scene as marked objects."""

from __future__ import annotations

import copy
import os
from pathlib import Path

import bpy
import numpy as np

from ..rules import indoorgml, scene_file
from ..rules.building import EXTERIOR, Building
from .detect import ifc_path_of
from .import_ifc import OFFSET, POSE


class ExchangeError(ValueError):
    """The file can't be written or read; the message says why."""


def write_ifc(scene: bpy.types.Scene, building: Building, target: str, source: str | None = None) -> dict:
    """A copy of the scene's IFC model with what it lacks; counts of what was written and what was there."""
    source = source or ifc_path_of(scene)
    if not source:
        raise ExchangeError("This scene shows no IFC model: rooms are written into a copy of one. Name it with --ifc FILE.ifc (or in the panel).")
    source = bpy.path.abspath(source)
    if not os.path.isfile(source):
        raise ExchangeError(f"There is no file {source}.")
    try:
        from ..rules import ifc_pose, ifc_write

        offset = np.array(scene.get(OFFSET, building.offset), dtype=np.float64)
        if POSE in scene:
            building = copy.deepcopy(building)
            offset = ifc_pose.Pose.of_numbers(scene[POSE]).to_file(building)
        made = ifc_write.write(building, source, bpy.path.abspath(target), offset)
    except (ImportError, OSError, ifc_write.IfcWriteError) as error:
        raise ExchangeError(str(error)) from error
    return {
        "file": os.path.abspath(target), "spaces": made.spaces, "boundaries": made.boundaries,
        "spaces_there": made.kept_spaces, "boundaries_there": made.kept_boundaries,
    }  # fmt: skip


def write_indoorgml(building: Building, target: str) -> tuple[int, int]:
    """Cells and transitions written."""
    path = Path(bpy.path.abspath(target)).absolute()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return indoorgml.write(building, path)
    except OSError as error:
        raise ExchangeError(f"{path} can't be written: {error}") from error


def read(path: str) -> Building:
    """Cells and portals of a scene file (*.enf.json) or IndoorGML, by what is in it."""
    path = bpy.path.abspath(path)
    try:
        with open(path, "rb") as file:
            head = file.read(256).lstrip(b"\xef\xbb\xbf \t\r\n")
        return scene_file.read(path) if head.startswith(b"{") else indoorgml.read(path)
    except OSError as error:
        raise ExchangeError(f"{path} can't be read: {error.strerror}") from error
    except (scene_file.SceneFileError, indoorgml.IndoorGmlError) as error:
        raise ExchangeError(str(error)) from error


def add_marked(scene: bpy.types.Scene, building: Building, name: str) -> list[bpy.types.Object]:
    """Rooms and openings as marked objects in a collection of their own, so that Detect finds them and they can be edited."""
    shelf = bpy.data.collections.new(name)
    scene.collection.children.link(shelf)
    made = []

    def add(title: str, role: str, vertices: np.ndarray, faces: list[list[int]]) -> bpy.types.Object:
        mesh = bpy.data.meshes.new(title)
        centre = vertices.mean(axis=0)
        mesh.from_pydata((vertices - centre).tolist(), [], faces)
        obj = bpy.data.objects.new(title, mesh)
        obj.location = centre
        obj["enfilade"] = role
        obj.display_type = "WIRE"
        obj.hide_render = True
        shelf.objects.link(obj)
        made.append(obj)
        return obj

    labels: dict[int, str] = {}
    for i, room in enumerate(building.rooms):
        if room.kind == EXTERIOR or room.vertices is None:
            labels[i] = "exterior"
            continue
        faces = room.faces if room.faces is not None else indoorgml.hull_faces(room.vertices)
        obj = add(room.name, "room", room.vertices, faces)
        labels[i] = obj.name
        if room.storey:
            obj["enfilade_storey"] = room.storey
        if room.long_name:
            obj["enfilade_long_name"] = room.long_name
    for opening in building.openings:
        if opening.rooms is None:
            continue
        if opening.body is not None:
            obj = add(opening.name, opening.kind, opening.body, indoorgml.hull_faces(opening.body))
        else:
            obj = add(opening.name, opening.kind, opening.polygon, [list(range(len(opening.polygon)))])
        obj["enfilade_state"] = opening.state
        obj["enfilade_rooms"] = ";".join(labels[r] for r in opening.rooms)
    return made
