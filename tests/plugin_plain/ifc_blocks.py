# SPDX-License-Identifier: GPL-3.0-or-later
"""Small IFC models made of boxes, for tests: spaces, walls, voids and what fills them, in any unit and placement."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from enfilade.rules import ifc_library

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


class Blocks:
    """A model under construction; all coordinates in metres, boxes by their two corners."""

    def __init__(self, schema: str = "IFC4", unit: float = 1.0, origin: tuple = (0.0, 0.0, 0.0), degrees: float = 0.0):
        ifc = ifc_library.load()
        self.guid = ifc.guid.new
        self.unit = unit  # metres per unit: 1 or 0.001
        self.f = f = ifc.file(schema=schema)
        metre = f.createIfcSIUnit(None, "LENGTHUNIT", "MILLI" if unit == 0.001 else None, "METRE")
        stray = f.createIfcSIUnit(None, "LENGTHUNIT", "DECI", "METRE")  # units that aren't assigned must not count
        del stray
        radian = f.createIfcSIUnit(None, "PLANEANGLEUNIT", None, "RADIAN")
        units = f.createIfcUnitAssignment([metre, radian])
        self.context = f.createIfcGeometricRepresentationContext(
            None, "Model", 3, 1e-5, self._axes((0.0, 0.0, 0.0)), None
        )
        project = f.createIfcProject(self.guid(), None, "Test", None, None, None, None, [self.context], units)
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        self.world = f.createIfcLocalPlacement(None, self._axes(origin, (c, s, 0.0)))
        building = f.createIfcBuilding(self.guid(), None, "House", None, None, self.world, None, None, "ELEMENT")
        self.storey = f.createIfcBuildingStorey(
            self.guid(), None, "Ground", None, None, self.world, None, None, "ELEMENT", 0.0
        )
        f.createIfcRelAggregates(self.guid(), None, None, None, project, [building])
        f.createIfcRelAggregates(self.guid(), None, None, None, building, [self.storey])

    def product(self, name: str, entity: str, box: Box, *, box_representation: bool = False) -> Any:
        """A product of any class with a box for a body, standing in the storey."""
        f, u = self.f, self.unit
        low, high = box
        size = [b - a for a, b in zip(low, high, strict=True)]
        profile = f.createIfcRectangleProfileDef(
            "AREA", None,
            f.createIfcAxis2Placement2D(f.createIfcCartesianPoint([0.5 * size[0] / u, 0.5 * size[1] / u]), None),
            size[0] / u, size[1] / u,
        )  # fmt: skip
        solid = f.createIfcExtrudedAreaSolid(
            profile, self._axes((0.0, 0.0, 0.0)), f.createIfcDirection([0.0, 0.0, 1.0]), size[2] / u
        )
        shapes = [f.createIfcShapeRepresentation(self.context, "Body", "SweptSolid", [solid])]
        if box_representation:  # larger than the body: it would join everything
            bounds = f.createIfcBoundingBox(f.createIfcCartesianPoint([-9.0, -9.0, -9.0]), 99.0 / u, 99.0 / u, 99.0 / u)
            shapes.append(f.createIfcShapeRepresentation(self.context, "Box", "BoundingBox", [bounds]))
        return self._made(name, entity, low, shapes)

    def sheet(self, name: str, entity: str, corners: list[tuple[float, float, float]]) -> Any:
        """A product that is one face without thickness; corners counter-clockwise where it is seen from."""
        f = self.f
        points = [f.createIfcCartesianPoint([float(v) / self.unit for v in c]) for c in corners]
        face = f.createIfcFace([f.createIfcFaceOuterBound(f.createIfcPolyLoop(points), True)])
        surface = f.createIfcFaceBasedSurfaceModel([f.createIfcConnectedFaceSet([face])])
        shape = f.createIfcShapeRepresentation(self.context, "Body", "SurfaceModel", [surface])
        return self._made(name, entity, (0.0, 0.0, 0.0), [shape])

    def _made(self, name: str, entity: str, at: tuple, shapes: list[Any]) -> Any:
        f = self.f
        made = f.create_entity(
            entity,
            GlobalId=self.guid(),
            Name=name,
            ObjectPlacement=f.createIfcLocalPlacement(self.world, self._axes(at)),
            Representation=f.createIfcProductDefinitionShape(None, None, shapes),
        )
        if made.is_a("IfcSpace"):
            f.createIfcRelAggregates(self.guid(), None, None, None, self.storey, [made])
        elif not made.is_a("IfcOpeningElement"):
            f.createIfcRelContainedInSpatialStructure(self.guid(), None, None, None, [made], self.storey)
        return made

    def void(self, host: Any, box: Box, filler: Any = None, entity: str = "IfcOpeningElement") -> Any:
        opening = self.product("Void", entity, box)
        self.f.createIfcRelVoidsElement(self.guid(), None, None, None, host, opening)
        if filler is not None:
            self.f.createIfcRelFillsElement(self.guid(), None, None, None, opening, filler)
        return opening

    def save(self, folder: Path, name: str = "test.ifc") -> Path:
        path = folder / name
        self.f.write(str(path))
        return path

    def _axes(self, at: tuple, x: tuple = (1.0, 0.0, 0.0)) -> Any:
        f = self.f
        return f.createIfcAxis2Placement3D(
            f.createIfcCartesianPoint([float(v) / self.unit for v in at]),
            f.createIfcDirection([0.0, 0.0, 1.0]),
            f.createIfcDirection([float(v) for v in x]),
        )


def two_rooms(**options: Any) -> tuple[Blocks, Any]:
    """Rooms A (x 0..4) and B (x 4.2..8) in a closed shell, a wall between; the model and that wall."""
    m = Blocks(**options)
    m.product("A", "IfcSpace", ((0, 0, 0), (4, 5, 2.5)), box_representation=True)
    m.product("B", "IfcSpace", ((4.2, 0, 0), (8, 5, 2.5)))
    wall = m.product("Middle", "IfcWall", ((4, 0, 0), (4.2, 5, 2.5)))
    m.product("West", "IfcWall", ((-0.3, -0.3, 0), (0, 5.3, 2.5)))
    m.product("East", "IfcWall", ((8, -0.3, 0), (8.3, 5.3, 2.5)))
    m.product("South", "IfcWall", ((0, -0.3, 0), (8, 0, 2.5)))
    m.product("North", "IfcWall", ((0, 5, 0), (8, 5.3, 2.5)))
    m.product("Floor", "IfcSlab", ((-0.3, -0.3, -0.3), (8.3, 5.3, 0)))
    m.product("Roof", "IfcSlab", ((-0.3, -0.3, 2.5), (8.3, 5.3, 2.8)))
    return m, wall
