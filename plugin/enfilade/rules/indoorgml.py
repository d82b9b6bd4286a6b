# SPDX-License-Identifier: GPL-3.0-or-later
"""Exchange of cells and transitions as IndoorGML 1.0 (OGC 14-005r5): rooms and thick openings are CellSpaces, where two of
them share a portal there is a Transition between their States, and the portal's polygon as a CellSpaceBoundary that is its dual.

The exterior isn't exported: IndoorGML ends at the building's skin. On import every cell becomes a room and every transition
a virtual opening: its boundary where it has one, to the last bit as written, else what the two cells' faces share, once for any two
cells; a transition between cells that share no face is told and left out.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from itertools import combinations
from pathlib import Path

import numpy as np

from . import convex_polygons as cp
from . import polyhedra
from .building import EXTERIOR, OPEN, VIRTUAL, WARNING, Building, Opening, Problem, Room
from .probing import Frame
from .shapes import newell
from .whole_file import whole_file

CORE = "http://www.opengis.net/indoorgml/1.0/core"
GML = "http://www.opengis.net/gml/3.2"
XLINK = "http://www.w3.org/1999/xlink"
SHARED_DISTANCE = 0.02  # m between two cells' faces that count as one: drawn to the centimetre
SHARED_AREA = 1e-3  # m2


class IndoorGmlError(ValueError):
    """The file isn't IndoorGML; the message says why."""


def write(building: Building, path: str | Path) -> tuple[int, int]:
    """Writes cells and transitions; returns how many of each."""
    for prefix, uri in (("core", CORE), ("gml", GML), ("xlink", XLINK)):
        ElementTree.register_namespace(prefix, uri)
    root = ElementTree.Element(_c("IndoorFeatures"), {_g("id"): "enfilade"})
    primal = ElementTree.SubElement(
        ElementTree.SubElement(root, _c("primalSpaceFeatures")), _c("PrimalSpaceFeatures"), {_g("id"): "PSF"}
    )
    layer = root
    for name, attributes in (
        ("multiLayeredGraph", {}), ("MultiLayeredGraph", {_g("id"): "MLG"}), ("spaceLayers", {_g("id"): "SLs"}),
        ("spaceLayerMember", {}), ("SpaceLayer", {_g("id"): "SL"}),
    ):  # fmt: skip
        layer = ElementTree.SubElement(layer, _c(name), attributes)
    nodes = ElementTree.SubElement(layer, _c("nodes"), {_g("id"): "nodes"})
    edges = ElementTree.SubElement(layer, _c("edges"), {_g("id"): "edges"})

    cells: dict[str, np.ndarray] = {}
    for i, room in enumerate(building.rooms):
        if room.kind == EXTERIOR or room.vertices is None:
            continue
        faces = room.faces if room.faces is not None else hull_faces(room.vertices)
        _cell(primal, nodes, f"R{i}", room.name, room.vertices, faces, room.source_id)
        cells[f"R{i}"] = room.vertices.mean(axis=0)
    links: list[tuple[str, str, np.ndarray]] = []  # two cells and the portal between them
    for n, opening in enumerate(building.openings):
        if opening.rooms is None:
            continue
        inside = [(s, f"R{r}") for s, r in enumerate(opening.rooms) if f"R{r}" in cells]
        if opening.body is not None and opening.ends is not None:
            if not inside:
                continue
            _cell(primal, nodes, f"O{n}", opening.name, opening.body, hull_faces(opening.body), opening.source_id)
            cells[f"O{n}"] = opening.body.mean(axis=0)
            links += [(f"O{n}", room, opening.ends[side]) for side, room in inside]
        elif len(inside) == 2 and inside[0][1] != inside[1][1]:
            links.append((inside[0][1], inside[1][1], opening.polygon))
    for n, (a, b, portal) in enumerate(links):
        transition = ElementTree.SubElement(
            ElementTree.SubElement(edges, _c("transitionMember")), _c("Transition"), {_g("id"): f"T{n}"}
        )
        ElementTree.SubElement(transition, _c("weight")).text = "1.0"
        for end in (a, b):
            ElementTree.SubElement(transition, _c("connects"), {_x("href"): f"#S-{end}"})
        ElementTree.SubElement(transition, _c("duality"), {_x("href"): f"#B{n}"})
        line = ElementTree.SubElement(
            ElementTree.SubElement(transition, _c("geometry")), _g("LineString"), {_g("id"): f"T{n}-line"}
        )
        ElementTree.SubElement(line, _g("posList")).text = _numbers(np.array([cells[a], portal.mean(axis=0), cells[b]]))
        boundary = ElementTree.SubElement(
            ElementTree.SubElement(primal, _c("cellSpaceBoundaryMember")), _c("CellSpaceBoundary"), {_g("id"): f"B{n}"}
        )
        ElementTree.SubElement(boundary, _c("duality"), {_x("href"): f"#T{n}"})
        holder = ElementTree.SubElement(ElementTree.SubElement(boundary, _c("cellSpaceBoundaryGeometry")), _c("geometry3D"))
        _polygon(holder, portal, {_g("id"): f"G-B{n}"})
    ElementTree.indent(root)
    with whole_file(path) as partial:
        ElementTree.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)
    return len(cells), len(links)


def read(path: str | Path) -> Building:
    """Cells become rooms, transitions virtual openings. IndoorGmlError names the file and the reason."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise IndoorGmlError(f"{path} can't be read: {error}") from error
    building = Building(source="indoorgml")
    solids: list[polyhedra.Polyhedron] = []
    number: dict[str, int] = {}
    for element in root.iter():
        if _local(element) != "CellSpace":
            continue
        key = _attribute(element, "id")
        loops = [_points(e.text) for e in element.iter() if _local(e) == "posList"]
        loops = [p[:-1] if len(p) > 3 and np.allclose(p[0], p[-1]) else p for p in loops]
        loops = [p for p in loops if len(p) >= 3]
        name = next((e.text for e in element if _local(e) == "name" and e.text), key)
        if not loops:
            building.problems.append(
                Problem(WARNING, "room-without-geometry", f"cell '{name}' has no solid and is left out", [name])
            )
            continue
        triangles, count = [], 0
        for loop in loops:
            triangles += [(count + a, count + b, count + c) for a, b, c in _triangles(loop)]
            count += len(loop)
        solid = polyhedra.build(np.concatenate(loops), np.array(triangles))
        number[key] = len(building.rooms)
        # A State stands for its cell: transitions may name either.
        dual = next((_attribute(e, "href") for e in element.iter() if _local(e) == "duality"), "")
        number[dual.lstrip("#") or key] = len(building.rooms)
        faces = [list(x) for x in solid.loops] if solid.closed else None
        if faces is None:
            building.problems.append(
                Problem(WARNING, "room-not-closed", f"cell '{name}' isn't closed; its convex hull stands in", [name])
            )
        building.rooms.append(Room(name, source_id=key, vertices=solid.vertices, faces=faces))
        solids.append(solid)
    if not solids:
        raise IndoorGmlError(f"{path} holds no CellSpace: it isn't an IndoorGML file of cells")
    for element in root.iter():
        if _local(element) == "State":
            dual = next((_attribute(e, "href") for e in element.iter() if _local(e) == "duality"), "").lstrip("#")
            if dual in number:
                number[_attribute(element, "id")] = number[dual]
    building.rooms.append(Room("Exterior", EXTERIOR))
    boundaries = {_attribute(e, "id"): _portal(e) for e in root.iter() if _local(e) == "CellSpaceBoundary"}
    told: set[tuple[int, int]] = set()  # whose shared faces are openings already
    for element in root.iter():
        if _local(element) != "Transition":
            continue
        key = _attribute(element, "id")
        ends = [_attribute(e, "href").lstrip("#") for e in element.iter() if _local(e) == "connects"]
        if len(ends) != 2 or any(e not in number for e in ends):
            building.problems.append(
                Problem(WARNING, "transition-without-cells", f"transition {key} names unknown cells")
            )
            continue
        i, j = sorted(number[e] for e in ends)
        names = [building.rooms[i].name, building.rooms[j].name]
        dual = next((_attribute(e, "href") for e in element.iter() if _local(e) == "duality"), "").lstrip("#")
        portals = [portal] if (portal := boundaries.get(dual)) is not None else []
        if not portals and (i, j) not in told:
            told.add((i, j))
            portals = shared_faces(solids[i], solids[j])
            if not portals:
                building.problems.append(
                    Problem(WARNING, "transition-without-face", f"cells {names[0]} and {names[1]} share no face", names)
                )
        for k, polygon in enumerate(portals):
            label = " | ".join(names) + (f" ({k + 1})" if k else "")
            building.openings.append(Opening(label, VIRTUAL, OPEN, key, (i, j), polygon=polygon))
    return building


def _portal(boundary: ElementTree.Element) -> np.ndarray | None:
    """The polygon (k, 3) of a CellSpaceBoundary; None where it isn't one that is flat and convex."""
    loops = [_points(e.text) for e in boundary.iter() if _local(e) == "posList"]
    if len(loops) != 1 or len(loops[0]) < 4:
        return None
    ring = loops[0][:-1]
    normal = newell(ring)
    length = float(np.linalg.norm(normal))
    if length < 1e-12 or not np.allclose(loops[0][0], loops[0][-1]):
        return None
    local = Frame.along(normal / length, ring.mean(axis=0)).local(ring)
    hull = cp.hull((x, y) for x, y, _ in local)
    flat = np.abs(local[:, 2]).max() < SHARED_DISTANCE
    return ring if flat and cp.area(hull) < 0.5 * length + SHARED_AREA else None


def shared_faces(a: polyhedra.Polyhedron, b: polyhedra.Polyhedron) -> list[np.ndarray]:
    """Convex polygons (k, 3) over which faces of two cells lie on each other."""
    result = []
    for f in a.faces:
        for g in b.faces:
            if f.normal @ g.normal > -0.9994:  # 2 degrees
                continue
            frame = Frame.along(f.normal, f.normal * f.d)
            p = frame.local(a.vertices[f.triangles.reshape(-1)]).reshape(-1, 3, 3)
            q = frame.local(b.vertices[g.triangles.reshape(-1)]).reshape(-1, 3, 3)
            if abs(float(q[:, :, 2].mean())) > SHARED_DISTANCE:
                continue
            pieces = [cp.clip(_ccw(s), _ccw(t)) for s in p for t in q]
            merged = cp.merge([x for x in pieces if x and cp.area(x) > 1e-9])
            result += [
                frame.world(np.array([(x, y, 0.0) for x, y in m])) for m in merged if cp.area(m) > SHARED_AREA
            ]
    return result


def hull_faces(points: np.ndarray) -> list[list[int]]:
    """Faces of the convex hull of a few points (n, 3), counter-clockwise from outside: every supporting plane."""
    scale = float(np.ptp(points, axis=0).max()) or 1.0
    planes: list[tuple[np.ndarray, list[int]]] = []
    for a, b, c in combinations(range(len(points)), 3):
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        size = np.linalg.norm(normal)
        if size < 1e-9 * scale * scale:
            continue
        normal = normal / size
        height = (points - points[a]) @ normal
        if height.min() < -1e-7 * scale:
            normal, height = -normal, -height
        if height.min() < -1e-7 * scale:
            continue
        outward = -normal
        on = np.nonzero(np.abs(height) < 1e-7 * scale)[0]
        if any(outward @ n > 0.999999 for n, _ in planes):
            continue
        frame = Frame.along(outward, points[a])
        flat = frame.local(points[on])
        corners = cp.hull((x, y) for x, y, _ in flat)
        order = [int(on[np.argmin(np.hypot(flat[:, 0] - x, flat[:, 1] - y))]) for x, y in corners]
        planes.append((outward, order))
    return [order for _, order in planes]


def _cell(primal, nodes, key: str, name: str, vertices: np.ndarray, faces: list[list[int]], source: str) -> None:
    cell = ElementTree.SubElement(
        ElementTree.SubElement(primal, _c("cellSpaceMember")), _c("CellSpace"), {_g("id"): key}
    )
    if source:
        ElementTree.SubElement(cell, _g("description")).text = source
    ElementTree.SubElement(cell, _g("name")).text = name
    holder = ElementTree.SubElement(ElementTree.SubElement(cell, _c("cellSpaceGeometry")), _c("Geometry3D"))
    solid = ElementTree.SubElement(holder, _g("Solid"), {_g("id"): f"G-{key}"})
    shell = ElementTree.SubElement(ElementTree.SubElement(solid, _g("exterior")), _g("Shell"))
    for face in faces:
        _polygon(ElementTree.SubElement(shell, _g("surfaceMember")), vertices[face])
    ElementTree.SubElement(cell, _c("duality"), {_x("href"): f"#S-{key}"})
    state = ElementTree.SubElement(
        ElementTree.SubElement(nodes, _c("stateMember")), _c("State"), {_g("id"): f"S-{key}"}
    )
    ElementTree.SubElement(state, _c("duality"), {_x("href"): f"#{key}"})
    point = ElementTree.SubElement(
        ElementTree.SubElement(state, _c("geometry")), _g("Point"), {_g("id"): f"P-{key}"}
    )
    ElementTree.SubElement(point, _g("pos")).text = _numbers(vertices.mean(axis=0))


def _polygon(parent: ElementTree.Element, corners: np.ndarray, attributes: dict[str, str] | None = None) -> None:
    polygon = ElementTree.SubElement(parent, _g("Polygon"), attributes or {})
    ring = ElementTree.SubElement(ElementTree.SubElement(polygon, _g("exterior")), _g("LinearRing"))
    points = ElementTree.SubElement(ring, _g("posList"), {"srsDimension": "3"})
    points.text = _numbers(np.concatenate([corners, corners[:1]]))


def _triangles(loop: np.ndarray) -> list[tuple[int, int, int]]:
    """Triangles that fill a planar polygon (n, 3), indices into it."""
    normal = newell(loop)
    length = np.linalg.norm(normal)
    if length < 1e-12:
        return []
    frame = Frame.along(normal / length, loop[0])
    return cp.ears([(float(x), float(y)) for x, y, _ in frame.local(loop)])


def _ccw(tri: np.ndarray) -> cp.Polygon:
    flat = [(float(p[0]), float(p[1])) for p in tri]
    return flat if cp.area(flat) >= 0.0 else flat[::-1]


def _points(text: str | None) -> np.ndarray:
    try:
        numbers = np.array([float(x) for x in (text or "").split()])
    except ValueError as error:
        raise IndoorGmlError(f"a posList holds what isn't a number: {error}") from error
    return numbers[: len(numbers) // 3 * 3].reshape(-1, 3)


def _numbers(points: np.ndarray) -> str:
    return " ".join(map(repr, np.asarray(points).reshape(-1).tolist()))


def _local(element: ElementTree.Element) -> str:
    return element.tag.rsplit("}", 1)[-1] if isinstance(element.tag, str) else ""


def _attribute(element: ElementTree.Element, name: str) -> str:
    return next((v for k, v in element.attrib.items() if k.rsplit("}", 1)[-1] == name), "")


def _c(name: str) -> str:
    return f"{{{CORE}}}{name}"


def _g(name: str) -> str:
    return f"{{{GML}}}{name}"


def _x(name: str) -> str:
    return f"{{{XLINK}}}{name}"
