# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms and openings back into IFC: IfcSpace and 2nd-level space boundaries, where a model lacks them.

What the file has is left as it is: a room that came from an IfcSpace isn't written again, nor a boundary between a space
and an element that the file relates already. The source file itself is never written to.
"""

from __future__ import annotations

import os
import tempfile
import uuid
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import ifc_library, indoorgml
from .building import EXTERIOR, VIRTUAL, Building, Opening, Room
from .ifc import IfcError, open_model
from .ifc_placement import absolute_placement, storeys
from .ifc_units import by_type, length_unit
from .shapes import convex_polygon, newell, unit

_NAMESPACE = uuid.UUID("6f0e7a52-6a0b-5a0c-9c5e-0a2f6d2a7e11")  # of our GlobalIds: the same input gives the same file


class IfcWriteError(ValueError):
    """The rooms can't be written; the message says why."""


@dataclass
class Written:
    spaces: int = 0
    boundaries: int = 0
    kept_spaces: int = 0  # rooms that the file had
    kept_boundaries: int = 0  # boundaries that the file had


def write(building: Building, source: str | os.PathLike[str], target: str | os.PathLike[str], offset=None) -> Written:
    """Copies the model in `source` to `target` with the building's rooms and boundaries added.

    offset: float64 (3,) in metres, what must be added to the building's coordinates to get the file's (default:
    `building.offset`). Raises IfcWriteError, also when target is the source, and IfcLibraryMissing.
    """
    ifc = ifc_library.load()
    source, target = os.fspath(source), os.fspath(target)
    if os.path.abspath(source) == os.path.abspath(target) or (os.path.exists(target) and os.path.samefile(source, target)):
        raise IfcWriteError(f"{target} is the model itself: it is never overwritten; name another file")
    try:
        model = open_model(source)
    except IfcError as error:
        raise IfcWriteError(str(error)) from error
    writer = _Writer(ifc, model, building, np.asarray(building.offset if offset is None else offset, dtype=np.float64))
    written = writer.run()
    folder = os.path.dirname(os.path.abspath(target))
    os.makedirs(folder, exist_ok=True)
    try:
        with tempfile.TemporaryDirectory(prefix=".enfilade-", dir=folder) as work:  # the writer leaves files of its own when it fails
            part = os.path.join(work, os.path.basename(target))
            model.write(part)
            os.replace(part, target)
    except (OSError, RuntimeError) as error:
        raise IfcWriteError(f"{target} can't be written: {error}") from error
    return written


class _Writer:
    def __init__(self, ifc: Any, model: Any, building: Building, offset: np.ndarray) -> None:
        self.ifc, self.model, self.building, self.offset = ifc, model, building, offset
        self.metres = length_unit(model)
        self.old = model.schema == "IFC2X3"
        self.owner = next(iter(model.by_type("IfcOwnerHistory")), None)
        if self.owner is None and self.old:
            self.owner = self._owner_history()
        self.context = self._context()
        self.storeys = storeys(model, self.metres)
        self.elements = {e.GlobalId: e for e in model.by_type("IfcElement")}
        self.spaces = {s.GlobalId: s for s in model.by_type("IfcSpace")}
        self.known: set[tuple[int, int]] = set()  # (space, element) that the file relates, by STEP id
        self.virtual: set[int] = set()  # spaces that have virtual boundaries
        for relation in model.by_type("IfcRelSpaceBoundary"):
            space, element = relation.RelatingSpace, relation.RelatedBuildingElement
            if space is None:
                continue
            if element is not None:
                self.known.add((space.id(), element.id()))
            if relation.PhysicalOrVirtualBoundary == "VIRTUAL" or (element is not None and element.is_a("IfcVirtualElement")):
                self.virtual.add(space.id())
        self.written = Written()

    def run(self) -> Written:
        products = [self._space(i, room) for i, room in enumerate(self.building.rooms)]
        had_virtual = set(self.virtual)
        for n, opening in enumerate(self.building.openings):
            if opening.rooms is None:
                continue
            sides = [(s, products[r]) for s, r in enumerate(opening.rooms) if products[r] is not None]
            if opening.kind == VIRTUAL and sides and all(space.id() in had_virtual for _, space in sides):
                self.written.kept_boundaries += len(sides)
                continue
            self._boundaries(n, opening, sides)
        return self.written

    def _id(self, *words: object) -> str:
        return self.ifc.guid.compress(uuid.uuid5(_NAMESPACE, "/".join(map(str, words))).hex)

    def _space(self, index: int, room: Room) -> Any:
        """The IfcSpace of a room; None for the exterior and for rooms without a shape."""
        if room.kind == EXTERIOR or room.vertices is None or len(room.vertices) < 4:
            return None
        if room.source_id in self.spaces:
            self.written.kept_spaces += 1
            return self.spaces[room.source_id]
        model = self.model
        storey = self._storey(room)
        parent = storey.ObjectPlacement if storey is not None else None
        world = room.vertices + self.offset
        corner = world.min(axis=0)
        frame = self._frame(parent)
        local = (np.linalg.inv(frame) @ np.append(corner / self.metres, 1.0))[:3]
        placement = model.create_entity("IfcLocalPlacement", PlacementRelTo=parent, RelativePlacement=self._axes(local))
        frame = frame.copy()
        frame[:3, 3] = (frame @ np.append(local, 1.0))[:3]
        points = self._local(world, frame)
        faces = room.faces if room.faces is not None else indoorgml.hull_faces(room.vertices)
        corners = [model.create_entity("IfcCartesianPoint", Coordinates=p) for p in points.tolist()]
        shell = model.create_entity(
            "IfcClosedShell",
            CfsFaces=[
                model.create_entity("IfcFace", Bounds=[
                    model.create_entity("IfcFaceOuterBound", Orientation=True, Bound=model.create_entity(
                        "IfcPolyLoop", Polygon=[corners[k] for k in face])),
                ])
                for face in faces
            ],
        )  # fmt: skip
        body = model.create_entity(
            "IfcShapeRepresentation", ContextOfItems=self.context, RepresentationIdentifier="Body",
            RepresentationType="Brep", Items=[model.create_entity("IfcFacetedBrep", Outer=shell)],
        )  # fmt: skip
        space = model.create_entity(
            "IfcSpace", GlobalId=self._id("space", index, room.name, points.round(4).tolist()), OwnerHistory=self.owner,
            Name=room.name, LongName=room.long_name or None, ObjectPlacement=placement,
            Representation=model.create_entity("IfcProductDefinitionShape", Representations=[body]),
            CompositionType="ELEMENT",
        )  # fmt: skip
        if self.old:
            space.InteriorOrExteriorSpace = "INTERNAL"
        else:
            space.PredefinedType = "INTERNAL"
        if storey is not None:
            self._aggregate(storey, space)
        self.written.spaces += 1
        return space

    def _aggregate(self, storey: Any, space: Any) -> None:
        for relation in getattr(storey, "IsDecomposedBy", ()) or ():
            if relation.is_a("IfcRelAggregates") and any(o.is_a("IfcSpace") for o in relation.RelatedObjects):
                relation.RelatedObjects = [*relation.RelatedObjects, space]
                return
        self.model.create_entity(
            "IfcRelAggregates", GlobalId=self._id("spaces of", storey.GlobalId), OwnerHistory=self.owner,
            RelatingObject=storey, RelatedObjects=[space],
        )  # fmt: skip

    def _storey(self, room: Room) -> Any:
        """The room's storey by name, else the highest one that its floor isn't below, else any building."""
        for step, name, _ in self.storeys:
            if name == room.storey:
                return self.model.by_id(step)
        floor = float(room.vertices[:, 2].min() + self.offset[2])
        below = [step for step, _, height in self.storeys if height <= floor + 0.5]
        if below or self.storeys:
            return self.model.by_id(below[-1] if below else self.storeys[0][0])
        return next(iter(self.model.by_type("IfcBuilding")), None)

    def _boundaries(self, n: int, opening: Opening, sides: list[tuple[int, Any]]) -> None:
        model = self.model
        element = self.elements.get(opening.source_id)
        made: list[Any] = []
        for side, space in sides:
            if element is not None and (space.id(), element.id()) in self.known:
                self.written.kept_boundaries += 1
                continue
            if element is None and not self.old:
                element = model.create_entity(
                    "IfcVirtualElement", GlobalId=self._id("virtual", n, opening.name), OwnerHistory=self.owner,
                    Name=opening.name,
                )  # fmt: skip
                self._contain(element, space)
            polygon = opening.ends[side] if opening.ends is not None else opening.polygon
            virtual = element is None or element.is_a("IfcVirtualElement")
            outward = len(sides) < 2
            known = dict(
                GlobalId=self._id("boundary", n, side, opening.name), OwnerHistory=self.owner, Name="2ndLevel", Description="2a",
                RelatingSpace=space, RelatedBuildingElement=element, ConnectionGeometry=self._surface(space, polygon),
                PhysicalOrVirtualBoundary="VIRTUAL" if virtual else "PHYSICAL",
                InternalOrExternalBoundary="EXTERNAL" if outward else "INTERNAL",
            )  # fmt: skip
            made.append(model.create_entity("IfcRelSpaceBoundary" if self.old else "IfcRelSpaceBoundary2ndLevel", **known))
            self.written.boundaries += 1
        if not self.old and len(made) == 2:
            made[0].CorrespondingBoundary, made[1].CorrespondingBoundary = made[1], made[0]

    def _contain(self, element: Any, space: Any) -> None:
        """A virtual element belongs to the storey of its space."""
        storey = next((r.RelatingObject for r in getattr(space, "Decomposes", ()) or ()), None)
        if storey is None:
            return
        for relation in getattr(storey, "ContainsElements", ()) or ():
            relation.RelatedElements = [*relation.RelatedElements, element]
            return
        self.model.create_entity(
            "IfcRelContainedInSpatialStructure", GlobalId=self._id("elements of", storey.GlobalId),
            OwnerHistory=self.owner, RelatedElements=[element], RelatingStructure=storey,
        )  # fmt: skip

    def _surface(self, space: Any, polygon: np.ndarray) -> Any:
        """The polygon as a bounded plane in the space's own coordinates, its normal out of the polygon's corners' order."""
        model = self.model
        points = self._local(polygon + self.offset, self._frame(space.ObjectPlacement))
        normal = unit(newell(points))
        flat = convex_polygon(points, normal)
        x = unit(flat[1] - flat[0])
        y = np.cross(normal, x)
        plane = model.create_entity("IfcPlane", Position=self._axes(flat[0], normal, x))
        ring = [((p - flat[0]) @ x, (p - flat[0]) @ y) for p in flat]
        corners = [model.create_entity("IfcCartesianPoint", Coordinates=[float(a), float(b)]) for a, b in ring]
        outline = model.create_entity("IfcPolyline", Points=[*corners, corners[0]])
        bounded = model.create_entity("IfcCurveBoundedPlane", BasisSurface=plane, OuterBoundary=outline, InnerBoundaries=[])
        return model.create_entity("IfcConnectionSurfaceGeometry", SurfaceOnRelatingElement=bounded)

    def _local(self, world: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """World metres (n, 3) in a placement's own coordinates and the file's unit."""
        return (world / self.metres - frame[:3, 3]) @ frame[:3, :3]

    def _frame(self, placement: Any) -> np.ndarray:
        return absolute_placement(placement) if placement is not None else np.eye(4)

    def _axes(self, at: np.ndarray, z: np.ndarray | None = None, x: np.ndarray | None = None) -> Any:
        model = self.model
        made = model.create_entity(
            "IfcAxis2Placement3D", Location=model.create_entity("IfcCartesianPoint", Coordinates=[float(v) for v in at])
        )
        if z is not None and x is not None:
            made.Axis = model.create_entity("IfcDirection", DirectionRatios=[float(v) for v in z])
            made.RefDirection = model.create_entity("IfcDirection", DirectionRatios=[float(v) for v in x])
        return made

    def _context(self) -> Any:
        contexts = self.model.by_type("IfcGeometricRepresentationContext")
        for context in contexts:
            if context.is_a("IfcGeometricRepresentationSubContext") and context.ContextIdentifier == "Body":
                return context
        for context in contexts:
            if context.ContextType == "Model" and not context.is_a("IfcGeometricRepresentationSubContext"):
                return context
        if contexts:
            return contexts[0]
        raise IfcWriteError("the model has no geometric context to draw spaces in")

    def _owner_history(self) -> Any:
        """IFC2X3 wants one on everything."""
        model = self.model
        person = next(iter(by_type(model, "IfcPersonAndOrganization")), None)
        if person is None:
            organisation = model.create_entity("IfcOrganization", Name="Enfilade")
            person = model.create_entity(
                "IfcPersonAndOrganization", ThePerson=model.create_entity("IfcPerson", FamilyName="Enfilade"),
                TheOrganization=organisation,
            )  # fmt: skip
        application = next(iter(model.by_type("IfcApplication")), None) or model.create_entity(
            "IfcApplication", ApplicationDeveloper=person.TheOrganization, Version="1", ApplicationFullName="Enfilade",
            ApplicationIdentifier="enfilade",
        )  # fmt: skip
        return model.create_entity(
            "IfcOwnerHistory", OwningUser=person, OwningApplication=application, ChangeAction="ADDED", CreationDate=0
        )
