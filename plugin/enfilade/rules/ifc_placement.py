# SPDX-License-Identifier: GPL-3.0-or-later
"""Where things stand in an IFC model: the model's offset from the origin, storeys and their elevations, containment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .shapes import cross as vec_cross

FAR = 1e4  # m: beyond, coordinates are taken as a national grid's and 32-bit drawing would jitter by millimetres
STEP = 1e-6  # m: corners are rounded to multiples of it in the frame they were drawn in
# Where between two multiples rounding changes over: no length in millimetres or binary fractions of an inch ends there.
TURN_OVER = 0.67


@dataclass
class Frame:
    """The axes that a model was drawn in. Whatever is decided by comparing numbers is decided in them, on rounded numbers:
    so it comes out the same to the last bit when the model stands elsewhere or is turned about the vertical."""

    origin: np.ndarray  # float64 (3,), in the file's world, metres
    axes: np.ndarray  # float64 (3, 3), rows: the frame's axes in the file's world

    def of_matrix(self, matrix: np.ndarray) -> np.ndarray:
        """float64 (4, 4): a placement about `origin` with the world's axes, in this frame's."""
        turned = matrix.copy()
        turned[:3] = self.axes @ matrix[:3]
        return turned

    def out(self, points: np.ndarray, origin: np.ndarray) -> np.ndarray:
        """Points (..., 3) of this frame in the file's world less `origin`."""
        return points @ self.axes + (self.origin - origin)


def rounded(points: np.ndarray) -> np.ndarray:
    """To multiples of STEP, off by at most 0.7 of it."""
    return np.floor(points / STEP + TURN_OVER) * STEP


def drawing_frame(model: Any, unit: float) -> Frame:
    """From the placement of the first space, or of the first element where there is none: it goes along with the model
    exactly, and authoring tools place in the axes that they draw in."""
    products = (p for name in ("IfcSpace", "IfcElement") for p in model.by_type(name))
    first = next((p.ObjectPlacement for p in products if p.ObjectPlacement and p.Representation), None)
    if first is None:
        return Frame(np.zeros(3), np.eye(3))
    matrix = absolute_placement(first)
    x = matrix[:2, 0] if np.hypot(*matrix[:2, 0]) > 0.5 else np.array([matrix[1, 1], -matrix[0, 1]])
    c, s = x / np.hypot(*x) if np.hypot(*x) > 0.0 else (1.0, 0.0)
    if abs(s) < 1e-9:
        c, s = np.sign(c), 0.0  # along the world's axes: nothing is turned, not even by a rounding
    return Frame(matrix[:3, 3] * unit, np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def model_offset(model: Any, unit: float) -> np.ndarray:
    """float64 (3,): whole kilometres to take off so that the model lies near the origin; zero for models that do.

    From the placements of spaces, or of elements where there are none; no geometry is made for it.
    """
    products = model.by_type("IfcSpace") or model.by_type("IfcElement")
    where = [absolute_placement(p.ObjectPlacement)[:3, 3] * unit for p in products[:2000] if p.ObjectPlacement]
    if not where:
        return np.zeros(3)
    centre = np.median(np.array(where), axis=0)
    return np.where(np.abs(centre) > FAR, np.round(centre / 1000.0) * 1000.0, 0.0)


def absolute_placement(placement: Any) -> np.ndarray:
    """float64 (4, 4) in file units; grid and linear placements count as their parent's."""
    chain = []
    depth = 0
    while placement is not None and depth < 64:
        if placement.is_a("IfcLocalPlacement") and placement.RelativePlacement is not None:
            chain.append(axis_placement(placement.RelativePlacement))
        placement = getattr(placement, "PlacementRelTo", None)
        depth += 1
    result = np.eye(4)
    for matrix in reversed(chain):
        result = result @ matrix
    return result


def axis_placement(placement: Any) -> np.ndarray:
    """float64 (4, 4) of an IfcAxis2Placement2D or 3D."""
    matrix = np.eye(4)
    location = [*(placement.Location.Coordinates if placement.Location else ()), 0.0, 0.0, 0.0]
    z = np.array([0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0])
    if placement.is_a("IfcAxis2Placement3D"):
        if placement.Axis:
            z = np.array(placement.Axis.DirectionRatios, dtype=float)
        if placement.RefDirection:
            x = np.array(placement.RefDirection.DirectionRatios, dtype=float)
    elif placement.RefDirection:
        x = np.array([*placement.RefDirection.DirectionRatios, 0.0][:3], dtype=float)
    z = z / np.linalg.norm(z)
    x = x - z * (x @ z)
    if np.linalg.norm(x) < 1e-9:  # parallel to the axis: any perpendicular, as the standard's default does
        x = vec_cross(np.array([0.0, 1.0, 0.0]), z) if abs(z[1]) < 0.9 else vec_cross(np.array([1.0, 0.0, 0.0]), z)
    x = x / np.linalg.norm(x)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, vec_cross(z, x), z, location[:3]
    return matrix


def storeys(model: Any, unit: float) -> list[tuple[int, str, float]]:
    """(STEP id, name, elevation in metres), ascending."""
    found = []
    for storey in model.by_type("IfcBuildingStorey"):
        elevation = storey.Elevation
        if elevation is None:
            elevation = absolute_placement(storey.ObjectPlacement)[2, 3] if storey.ObjectPlacement else 0.0
        found.append((storey.id(), storey.Name or f"Storey {storey.GlobalId}", float(elevation) * unit))
    found.sort(key=lambda s: s[2])
    return found


def storey_of(product: Any, names: dict[int, str]) -> str:
    """The storey's name that holds the product, through spaces, assemblies, hosts; "" when there is none."""
    seen = set()
    here = product
    while here is not None and here.id() not in seen:
        seen.add(here.id())
        if here.id() in names:
            return names[here.id()]
        here = _parent(here)
    return ""


def _parent(product: Any) -> Any:
    for inverse, attribute in (
        ("ContainedInStructure", "RelatingStructure"),
        ("Decomposes", "RelatingObject"),
        ("FillsVoids", "RelatingOpeningElement"),
        ("VoidsElements", "RelatingBuildingElement"),
    ):
        relations = getattr(product, inverse, None) or ()
        for relation in relations:
            parent = getattr(relation, attribute, None)
            if parent is not None:
                return parent
    return None
