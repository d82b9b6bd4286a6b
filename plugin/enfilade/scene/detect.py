# SPDX-License-Identifier: GPL-3.0-or-later
"""From a Blender scene to a Building: which source, its rooms and openings, and what is drawn, lights, cameras.

Rooms and openings read from an IFC file are kept in the .blend as a text, so that later commands need no IFC file. Marks in
the scene are read anew each time: they are the truth while somebody edits them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import bpy

from ..rules import building_io, geometry, ifc_library, ifc_scene, ifc_shapes, opening_rules
from ..rules.annotated import build
from ..rules.building import ERROR, INFO, INTERIOR, WARNING, Building, Object, Problem
from ..rules.tally import Change, Tally
from . import (
    apply_result,
    cameras,
    extract_annotated,
    extract_elements,
    extract_ifc_scene,
    extract_mesh,
    import_ifc,
    kept_text,
    since_detect,
)

SOURCES = ("auto", "ifc", "annotated", "geometry")
TEXT = "Enfilade building"
TEXT_KEY = "enfilade_building"  # on the scene: name of the text
SOURCE_KEY = "enfilade_source"
TALLY_KEY = "enfilade_tally"  # on the scene: counts of this Detect and of the one before, JSON
STAMP_KEY = "enfilade_detected"  # on the scene: which Detect what it remembers comes from
RULES_KEY = "enfilade_opening_states"  # on the scene: what the user says of openings, JSON
SPATIAL = ("IfcSpace/", "IfcOpeningElement/", "IfcOpeningStandardCase/", "IfcSpatialZone/", "IfcExternalSpatialElement/")

STOPPED = (geometry.Cancelled, ifc_shapes.Cancelled)  # what `Search.run` raises when it was told to stop

Progress = Callable[[float, str], bool]


class DetectError(ValueError):
    """No building can be had from this scene; the message says why and what to do."""


def marked_objects(scene: bpy.types.Scene, building: Building) -> set[str]:
    """Full names of the scene's objects that rooms and openings come from."""
    ids = {item.source_id for item in (*building.rooms, *building.openings)}
    found = {o.name_full for o in scene.objects if o.name_full in ids}
    for collection in scene.collection.children_recursive:
        if collection.name_full in ids:
            found |= {o.name_full for o in collection.all_objects if o.type == "MESH"}
    return found


def detect(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    source: str = "auto",
    ifc: str | None = None,
    progress: Progress | None = None,
    geometry_mode: str = "auto",
    draw: str = "all",
    bounds: bool = False,
) -> Building:
    """Finds the building anew and remembers it in the file: `Search`, all its steps at once."""
    search = Search(scene, view_layer, source, ifc, geometry_mode, draw, bounds)
    search.run(progress)
    return search.apply(scene, view_layer)


class Search:
    """A detection in three steps, so that the long one needn't stop the window: what is made reads from the scene what the search
    needs; `run` searches and touches no Blender data, it may be in a thread; `apply` puts what was found into the scene. Until
    then nothing of the file has changed.

    geometry_mode: what the search by geometry goes by, "auto", "classes" or "triangles". draw: what of an IFC file is brought
    into a scene that shows no IFC model yet: "all", "built" (all but furniture; `import_ifc.complete` adds it) or "nothing".
    bounds: with "nothing", whether `Building.objects` are read from the file all the same.
    """

    def __init__(
        self,
        scene: bpy.types.Scene,
        view_layer: bpy.types.ViewLayer,
        source: str = "auto",
        ifc: str | None = None,
        geometry_mode: str = "auto",
        draw: str = "all",
        bounds: bool = False,
    ) -> None:
        if source not in SOURCES:
            raise DetectError(f"source {source!r} is none of {', '.join(SOURCES)}")
        self._chosen = source == "auto"
        self._source = _choose(scene, ifc) if self._chosen else source
        self._mode = geometry_mode
        self._path = ""  # of the IFC file that is read; "": the scene is
        self._named = ifc or ifc_path_of(scene)
        self._lacks: tuple[str, str] | None = None  # file and part of it that are to be drawn
        self._drawn: import_ifc.Drawn | None = None
        self._placements: dict[str, Any] = {}  # of an IFC model in the scene that isn't ours, by name
        self._pose: Any = None
        self._model: Any = None
        self._building: Building | None = None
        self._unseen: list[Object] = []  # what the file draws and the scene doesn't
        if self._source == "ifc":
            self._without = _why_without(self._named)
            if ifc or not self._without or not extract_ifc_scene.has_spaces(scene):
                self._path = _existing(self._named)
        elif self._source == "geometry" and ifc:
            self._path = _existing(ifc)
        if self._path:
            self._states = opening_rules.of_ifc(rules_of(scene))
            self._lacks = _lacking(scene, self._path, draw)
            self._placements = extract_ifc_scene.placements(scene)
            self._bounds = draw == "nothing" and bounds and not has_ifc_geometry(scene)
            return
        with apply_result.all_shown(view_layer):
            if self._source == "annotated":
                self._marks = extract_annotated.find_marks(scene)
                self._shapes = extract_annotated.read_shapes(scene, _depsgraph(scene, view_layer), self._marks)
            elif self._source == "ifc":
                self._pieces, self._storeys = extract_ifc_scene.pieces(scene), extract_ifc_scene.storeys(scene)
            if self._source == "geometry" or (self._source == "ifc" and self._chosen):  # then it may come to that
                # Names don't make a helper here: a mesh named Door_1 is a drawn door.
                ignored = {o.name_full for o in scene.objects if _is_no_part(o)}
                self._elements = extract_elements.extract(_depsgraph(scene, view_layer), ignored)

    # ---- the search ----

    def run(self, progress: Progress | None = None) -> None:
        """DetectError; ifc_shapes.Cancelled or geometry.Cancelled once progress returned False."""
        if self._source == "ifc" and self._path and self._chosen and not self._opened().by_type("IfcSpace"):
            found = self._from_geometry(progress)
        elif self._source == "ifc":
            found = self._from_ifc(progress) if self._path else self._from_ifc_scene(progress)
            if self._chosen and not any(r.kind == INTERIOR for r in found.rooms):
                found = self._from_geometry(progress)
        elif self._source == "annotated":
            found = self._from_marks()
        else:
            found = self._from_geometry(progress)
        self._building, self._model = found, None

    def _opened(self) -> Any:
        """The IFC file's model, read once."""
        if self._model is None:
            try:
                from ..rules import ifc as ifc_rules
            except ImportError as error:
                raise DetectError(f"IFC can't be read by this copy of Enfilade: {error}") from error
            try:
                self._model = ifc_rules.open_model(self._path)
            except (ifc_rules.IfcError, ImportError) as error:
                raise DetectError(str(error)) from error
        return self._model

    def _from_marks(self) -> Building:
        building = build(self._shapes, self._marks.problems)
        if any(p.code == "no-rooms" for p in building.problems):
            raise DetectError(
                'No room is marked in this scene. Give a closed mesh of each room\'s air the custom property enfilade = "room" '
                "(or name it Room_...; panel Mark by Hand), or name an IFC file."
            )
        return building

    def _from_ifc(self, progress: Progress | None) -> Building:
        model = self._opened()
        from ..rules import ifc as ifc_rules

        try:
            building = ifc_rules.read_ifc(
                self._path, progress=self._share(progress), objects=self._bounds, local=True, model=model, door_states=self._states
            )
            self._unseen, building.objects = building.objects, []
            self._put(building, model)
            self._draw(model, progress)
        except (ifc_rules.IfcError, ImportError) as error:
            raise DetectError(str(error)) from error
        if not any(r.kind == INTERIOR for r in building.rooms):
            building.problems.append(
                Problem(ERROR, "no-rooms", f"{os.path.basename(self._path)} has no spaces.",
                        remedy="Use the source Geometry: batch.py -- detect --source geometry --ifc FILE.")
            )
        return building

    def _from_ifc_scene(self, progress: Progress | None) -> Building:
        """From what an IFC add-on loaded; the file isn't at hand, or the library that reads it."""
        building = ifc_scene.build(self._pieces, self._storeys, progress)
        building.problems.append(
            Problem(INFO, "ifc-scene", f"{self._without}: rooms and openings come from the scene's objects IfcSpace/..., IfcDoor/...",
                    remedy="Name the file: it knows voids, materials and door types that the scene doesn't show.")
        )
        return building

    def _from_geometry(self, progress: Progress | None) -> Building:
        """From an IFC file's elements, its spaces withheld, when one is named; else from what the scene draws."""
        try:
            if self._path:
                model = self._opened()
                from ..rules import ifc as ifc_rules

                try:
                    building = geometry.read_ifc(self._path, mode=self._mode, progress=self._share(progress), model=model)
                    self._put(building, model)
                    self._draw(model, progress)
                except (ifc_rules.IfcError, ImportError) as error:
                    raise DetectError(str(error)) from error
                return building
            if not self._elements:
                raise DetectError(
                    "There is nothing drawn in this scene, nothing is marked as a room, and no IFC file is named. Open or draw a building, "
                    "or name an IFC file (source IFC file in the panel, --ifc FILE in batch)."
                )
            return geometry.detect(self._elements, mode=self._mode, progress=progress)
        except geometry.GeometryError as error:
            raise DetectError(
                f"No rooms can be found from this geometry: {error}. Rooms can be marked by hand (panel Mark by Hand: "
                'custom property enfilade = "room"), or an IFC file named.'
            ) from error

    def _put(self, building: Building, model: Any) -> None:
        """To where the scene has the model, when another add-on loaded it."""
        if not self._placements:
            return
        from ..rules import ifc_pose

        self._pose = ifc_pose.find(model, self._placements)
        if self._pose is not None:
            self._pose.to_scene(building)
        else:
            building.problems.append(
                Problem(WARNING, "scene-elsewhere", f"The scene's objects named Ifc... aren't those of {self._path}, or stand elsewhere: rooms "
                        "are where the file has them.", remedy="Name the file that the scene was loaded from, or load it again.")
            )  # fmt: skip

    def _draw(self, model: Any, progress: Progress | None) -> None:
        """Reads what is to be brought into the scene, once."""
        if self._lacks is not None and self._drawn is None:
            path, part = self._lacks
            same = model if path == self._path else None
            self._drawn = import_ifc.read(path, model=same, part=part, progress=self._share(progress, last=True))

    def _share(self, progress: Progress | None, last: bool = False) -> Progress | None:
        """Of the whole: rooms and what is drawn take about as long."""
        if progress is None or self._lacks is None:
            return progress
        first = 0.5 if last else 0.0
        return lambda fraction, label: progress(first + 0.5 * fraction, label)

    # ---- into the scene ----

    def apply(self, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Building:
        """The building with today's objects, lights and cameras. Anything hidden by us is shown again first."""
        building = self._building
        if not self._path:
            building.problems += _unit_problems(scene)
        apply_result.restore(scene)
        if self._drawn is not None:
            import_ifc.put(scene, self._drawn)
        if self._path:
            scene[import_ifc.SOURCE] = self._path
        if self._pose is not None:
            scene[import_ifc.POSE] = self._pose.numbers()
        if building.source == "annotated":
            kept_text.remove(scene, TEXT_KEY)
        else:
            kept_text.store(scene, TEXT_KEY, TEXT, building_io.to_json(building))
        scene[SOURCE_KEY] = building.source
        _apply_rules(building, scene)
        add_scenery(building, scene, view_layer)
        if building.source == "annotated":
            since_detect.forget(scene)
        else:
            since_detect.note(scene, building)
        building.objects += self._unseen
        return building


def _unit_problems(scene: bpy.types.Scene) -> list[Problem]:
    scale = scene.unit_settings.scale_length
    if scene.unit_settings.system == "NONE" or abs(scale - 1.0) < 1e-6:
        return []
    return [
        Problem(WARNING, "unit-scale", f"The scene's unit scale is {scale:g}; doors, walls and rooms are looked for as if one unit were one metre.",
                remedy=f"Scale all objects by {scale:g}, apply it, and set Scene > Units > Unit Scale to 1.")
    ]  # fmt: skip


def _lacking(scene: bpy.types.Scene, path: str, draw: str) -> tuple[str, str] | None:
    """The file and the part of it that is asked for and not drawn in the scene yet."""
    if draw == "all" and import_ifc.LACKS in scene:
        return bpy.path.abspath(str(scene[import_ifc.SOURCE])), str(scene[import_ifc.LACKS])
    return (path, draw) if draw != "nothing" and not has_ifc_geometry(scene) else None


def note_counts(scene: bpy.types.Scene, building: Building, problems: Sequence[Problem]) -> Change:
    """Remembers what this Detect found, beside what the one before did. problems: the core's too."""
    change = Change(Tally.of(building, problems), counts_of(scene).now)
    scene[TALLY_KEY] = change.to_text()
    return change


def counts_of(scene: bpy.types.Scene) -> Change:
    return Change.from_text(str(scene.get(TALLY_KEY, "")))


def rules_of(scene: bpy.types.Scene) -> dict[str, str]:
    """What the user says of openings (rules/opening_rules.py); DetectError when the scene's note is damaged."""
    try:
        return opening_rules.from_text(str(scene.get(RULES_KEY, "")))
    except ValueError as error:
        raise DetectError(f"{error} Remove the scene's custom property {RULES_KEY}.") from error


def set_rules(scene: bpy.types.Scene, rules: dict[str, str]) -> None:
    if rules:
        scene[RULES_KEY] = opening_rules.to_text(rules)
    elif RULES_KEY in scene:
        del scene[RULES_KEY]


def _apply_rules(building: Building, scene: bpy.types.Scene) -> None:
    """After the building was remembered: what was found stays known."""
    rules = rules_of(scene)
    opening_rules.apply(building, rules)
    for key in opening_rules.unmatched(building, rules):
        building.problems.append(
            Problem(WARNING, "unknown-opening", f"A state is set for {key}, but nothing here has that name.", [key],
                    remedy="Correct the name, or take the rule away.")
        )


def current(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Building:
    """The building as detected before, with today's objects, lights and cameras, and a problem when these are others than then;
    detects when nothing was."""
    content = kept_text.load(scene, TEXT_KEY)
    if content is None:
        return detect(scene, view_layer)
    try:
        building = building_io.from_json(content)
    except ValueError as error:
        raise DetectError(f"{scene[TEXT_KEY]}: {error}. Run detect again.") from error
    _apply_rules(building, scene)
    add_scenery(building, scene, view_layer)
    changed = since_detect.problem(scene, building)
    if changed is not None:
        building.problems.append(changed)
    return building


def add_scenery(building: Building, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
    """Objects, lights and cameras of the scene as it is now. What we hid must be visible while this runs: an object that is
    hidden in the viewport isn't evaluated."""
    depsgraph = _depsgraph(scene, view_layer)
    marks = extract_annotated.find_marks(scene)
    ignored = set(marks.ignored)
    ignored.update(o.name_full for o in scene.objects if o.name.startswith(SPATIAL))
    drawn = extract_mesh.extract(depsgraph, ignored)
    building.objects, building.lights = drawn.objects, drawn.lights
    building.problems += drawn.problems
    building.cameras = [cameras.read_camera(scene, obj, depsgraph) for obj in cameras.scene_cameras(scene)]
    _camera_problems(building, scene)


def _depsgraph(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> bpy.types.Depsgraph:
    if bpy.context.scene == scene and bpy.context.view_layer == view_layer:
        return bpy.context.evaluated_depsgraph_get()
    depsgraph = view_layer.depsgraph
    if depsgraph is None:
        raise DetectError(f"Scene {scene.name} isn't the active one and has not been evaluated: make it active first.")
    depsgraph.update()
    return depsgraph


def _choose(scene: bpy.types.Scene, ifc: str | None) -> str:
    if ifc:
        return "ifc"
    if extract_annotated.find_marks(scene).rooms:
        return "annotated"
    path = ifc_path_of(scene)
    if (path and os.path.isfile(bpy.path.abspath(path))) or extract_ifc_scene.has_spaces(scene):
        return "ifc"
    return "ifc" if path else "geometry"


def ifc_path_of(scene: bpy.types.Scene) -> str:
    """The IFC file this scene shows: as we imported it, or as Bonsai has it open; "" when neither is known."""
    path = str(scene.get(import_ifc.SOURCE, ""))
    if not path and hasattr(scene, "BIMProperties"):
        path = str(getattr(scene.BIMProperties, "ifc_file", "") or "")
    elif not path and hasattr(scene.get("BIMProperties"), "get"):
        path = str(scene["BIMProperties"].get("ifc_file", ""))  # Bonsai isn't switched on; before 5.0 its notes can be read all the same
    return path


def has_ifc_geometry(scene: bpy.types.Scene) -> bool:
    """Whether the scene already draws an IFC model, ours or Bonsai's (both name objects IfcClass/Name)."""
    return any(o.type == "MESH" and o.name.startswith("Ifc") and "/" in o.name for o in scene.objects)


def _is_no_part(obj: bpy.types.Object) -> bool:
    """Of a building that is looked for by what it draws: what stands for a room or an opening, and meshes of types."""
    return obj.name.startswith(SPATIAL) or bool(obj.get("enfilade")) or ifc_scene.is_template(obj.name)


def _why_without(path: str) -> str:
    """Why the IFC file that a scene shows can't be asked; "" when it can."""
    if not path:
        return "no IFC file is named"
    if not os.path.isfile(bpy.path.abspath(path)):
        return f"{path} isn't there"
    return "" if ifc_library.available() else f"{os.path.basename(path)} can't be read here without IfcOpenShell"


def _existing(path: str) -> str:
    if not path:
        raise DetectError("Which IFC file? Name it with --ifc FILE.ifc (or in the panel).")
    path = os.path.abspath(bpy.path.abspath(path))  # kept with the file, which is opened from elsewhere another time
    if not os.path.isfile(path):
        raise DetectError(f"There is no file {path}.")
    return path


def _camera_problems(building: Building, scene: bpy.types.Scene) -> None:
    if not building.cameras:
        building.problems.append(
            Problem(WARNING, cameras.NO_CAMERA, "The scene has no camera: there is nothing to cull for.",
                    remedy="Add one, or let Add Cameras (detect --add-cameras N) put some into the largest rooms.")
        )
