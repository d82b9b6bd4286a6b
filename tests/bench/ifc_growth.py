# SPDX-License-Identifier: GPL-3.0-or-later
"""How reading an IFC model grows with its size: an office of N equal storeys (21 spaces, 38 doors and windows in walls, a slab, desks), made here.

Usage: /usr/bin/python3 tests/bench/ifc_growth.py [STOREYS ...]
Each size runs in a process of its own. Seconds are CPU; `made` is how many meshes were asked of the geometry library by kind: spaces and what
bounds them, no furniture.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "plugin"), str(ROOT / "python_shim")]
sys.path.append(str(ROOT / "build" / "python"))
ROOM, DEEP, CORRIDOR, ROOMS, STOREY, CLEAR = 4.0, 6.0, 2.4, 10, 3.2, 2.9  # m; rooms on either side of the corridor


class Model:
    """Boxes as products of one storey after the other."""

    def __init__(self) -> None:
        import ifcopenshell

        self.file = f = ifcopenshell.file(schema="IFC4")
        self.axes = f.createIfcAxis2Placement3D(f.createIfcCartesianPoint((0.0, 0.0, 0.0)))
        unit = f.createIfcUnitAssignment([f.createIfcSIUnit(None, "LENGTHUNIT", None, "METRE")])
        self.context = f.createIfcGeometricRepresentationContext(None, "Model", 3, 1e-5, self.axes)
        project = f.createIfcProject(self.guid(), None, "Growth", RepresentationContexts=[self.context], UnitsInContext=unit)
        self.building = f.createIfcBuilding(self.guid(), None, "Building", ObjectPlacement=f.createIfcLocalPlacement(None, self.axes))
        f.createIfcRelAggregates(self.guid(), None, None, None, project, [self.building])

    @staticmethod
    def guid() -> str:
        import ifcopenshell.guid

        return ifcopenshell.guid.new()

    def box(self, kind: str, name: str, low, high, **more):
        f = self.file
        size = [float(b - a) for a, b in zip(low, high, strict=True)]
        middle = f.createIfcAxis2Placement2D(f.createIfcCartesianPoint((0.5 * size[0], 0.5 * size[1])))
        profile = f.createIfcRectangleProfileDef("AREA", None, middle, size[0], size[1])
        solid = f.createIfcExtrudedAreaSolid(profile, self.axes, f.createIfcDirection((0.0, 0.0, 1.0)), size[2])
        shape = f.createIfcProductDefinitionShape(None, None, [f.createIfcShapeRepresentation(self.context, "Body", "SweptSolid", [solid])])
        place = f.createIfcLocalPlacement(None, f.createIfcAxis2Placement3D(f.createIfcCartesianPoint([float(x) for x in low])))
        return f.create_entity(kind, self.guid(), None, name, ObjectPlacement=place, Representation=shape, **more)

    def wall(self, low, high, holes=()):
        """holes: (kind, low, high) of voids with a door or window in each."""
        wall = self.box("IfcWall", "Wall", low, high)
        products = [wall]
        for kind, a, b in holes:
            void = self.box("IfcOpeningElement", "Void", a, b)
            self.file.createIfcRelVoidsElement(self.guid(), None, None, None, wall, void)
            filling = self.box(kind, kind[3:], a, b, OverallHeight=float(b[2] - a[2]))
            self.file.createIfcRelFillsElement(self.guid(), None, None, None, void, filling)
            products.append(filling)
        return products

    def storey(self, number: int) -> None:
        f, z, long, wide = self.file, number * STOREY, ROOM * ROOMS, 2 * DEEP + CORRIDOR
        storey = f.createIfcBuildingStorey(self.guid(), None, f"Level {number}", ObjectPlacement=f.createIfcLocalPlacement(None, self.axes), Elevation=z)
        top, products = z + CLEAR, [self.box("IfcSlab", "Slab", (-0.1, -0.1, z - 0.3), (long + 0.1, wide + 0.1, z))]
        spaces = [self.box("IfcSpace", f"{number}.0", (0.1, DEEP + 0.1, z), (long - 0.1, DEEP + CORRIDOR - 0.1, top))]
        for y, kind in ((0.0, "IfcWindow"), (DEEP, "IfcDoor"), (DEEP + CORRIDOR, "IfcDoor"), (wide, "IfcWindow")):
            sill, head, left, right = (0.9, 2.2, 1.0, 3.0) if kind == "IfcWindow" else (0.0, 2.1, 1.5, 2.4)
            holes = [(kind, (i * ROOM + left, y - 0.1, z + sill), (i * ROOM + right, y + 0.1, z + head)) for i in range(ROOMS)]
            products += self.wall((-0.1, y - 0.1, z), (long + 0.1, y + 0.1, top), holes)
        for y in (0.0, DEEP + CORRIDOR):
            for i in range(ROOMS + 1):
                products += self.wall((i * ROOM - 0.1, y + 0.1, z), (i * ROOM + 0.1, y + DEEP - 0.1, top))
            for i in range(ROOMS):
                spaces.append(self.box("IfcSpace", f"{number}.{len(spaces)}", (i * ROOM + 0.1, y + 0.1, z), ((i + 1) * ROOM - 0.1, y + DEEP - 0.1, top)))
                products.append(self.box("IfcFurniture", "Desk", (i * ROOM + 1.0, y + 2.0, z), (i * ROOM + 2.6, y + 2.8, z + 0.75)))
        for x in (0.0, long):
            products += self.wall((x - 0.1, DEEP + 0.1, z), (x + 0.1, DEEP + CORRIDOR - 0.1, top))
        f.createIfcRelAggregates(self.guid(), None, None, None, self.building, [storey])
        f.createIfcRelAggregates(self.guid(), None, None, None, storey, spaces)
        f.createIfcRelContainedInSpatialStructure(self.guid(), None, None, None, products, storey)


def cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def measure(path: str) -> dict:
    from enfilade.rules import ifc, ifc_shapes

    made: Counter = Counter()
    run = ifc_shapes._run

    def counted(model, wanted, *rest, **more):
        made.update(p.is_a() for p in wanted)
        return run(model, wanted, *rest, **more)

    ifc_shapes._run = counted
    start = cpu()
    model = ifc.open_model(path)
    opened = cpu()
    building = ifc.read_ifc(path, objects=False, local=True, model=model)
    return {"products": len(model.by_type("IfcProduct")), "open": opened - start, "read": cpu() - opened, "rooms": len(building.rooms) - 1,
            "openings": len(building.openings), "joined": sum(o.rooms is not None for o in building.openings), "made": made,
            "mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0, "stages": building.statistics}  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("storeys", nargs="*", type=int, default=[1, 5, 20])
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.one)))
        return 0
    sys.stdout.reconfigure(line_buffering=True)
    print("storeys products  rooms openings (joined)  open s  read s  s/storey   MiB  made")
    with tempfile.TemporaryDirectory() as folder:
        for count in options.storeys:
            model = Model()
            for number in range(count):
                model.storey(number)
            path = Path(folder) / f"{count}.ifc"
            model.file.write(str(path))
            run = subprocess.run([sys.executable, __file__, "--one", str(path)], capture_output=True, text=True)
            if run.returncode:
                print(f"{count:7d} failed: {run.stderr.strip()[-600:]}")
                return 1
            m = json.loads(run.stdout.splitlines()[-1])
            made = ", ".join(f"{n} {kind[3:]}" for kind, n in sorted(m["made"].items()))
            print(f"{count:7d} {m['products']:8d} {m['rooms']:6d} {m['openings']:8d} ({m['joined']:d}) {m['open']:8.2f} {m['read']:7.2f} "
                  f"{m['read'] / count:8.3f} {m['mib']:6.0f}  {made}\n        {({k: round(v, 2) for k, v in m['stages'].items()})}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
