# SPDX-License-Identifier: GPL-3.0-or-later
"""Exchange of cells and transitions as IndoorGML 1.0 (OGC 14-005r5): rooms and thick openings are CellSpaces, where two of
them share a portal there is a Transition between their States.

The exterior isn't exported: IndoorGML ends at the building's skin. On import every cell becomes a room and every transition
a virtual opening over what the two cells' faces share; a transition between cells that share no face is told and left out.
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
    links: list[tuple[str, str, np.ndarray]] = []
    for n, opening in enumerate(building.openings):
        if opening.rooms is None:
            continue
        inside = [(s, f"R{r}") for s, r in enumerate(opening.rooms) if f"R{r}" in cells]
        if opening.body is not None and opening.ends is not None:
            if not inside:
                continue
            _cell(primal, nodes, f"O{n}", opening.name, opening.body, hull_faces(opening.body), opening.source_id)
            cells[f"O{n}"] = opening.body.mean(axis=0)
            links += [(f"O{n}", room, opening.ends[side].mean(axis=0)) for side, room in inside]
        elif len(inside) == 2 and inside[0][1] != inside[1][1]:
            links.append((inside[0][1], inside[1][1], opening.polygon.mean(axis=0)))
    for n, (a, b, through) in enumerate(links):
        transition = ElementTree.SubElement(
            ElementTree.SubElement(edges, _c("transitionMember")), _c("Transition"), {_g("id"): f"T{n}"}
        )
        ElementTree.SubElement(transition, _c("weight")).text = "1.0"
        for end in (a, b):
            ElementTree.SubElement(transition, _c("connects"), {_x("href"): f"#S-{end}"})
        line = ElementTree.SubElement(
            ElementTree.SubElement(transition, _c("geometry")), _g("LineString"), {_g("id"): f"T{n}-line"}
        )
        ElementTree.SubElement(line, _g("posList")).text = _numbers(np.array([cells[a], through, cells[b]]))
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
    for element in root.iter():
        if _local(element) != "Transition":
            continue
        ends = [_attribute(e, "href").lstrip("#") for e in element.iter() if _local(e) == "connects"]
        if len(ends) != 2 or any(e not in number for e in ends):
            building.problems.append(
                Problem(WARNING, "transition-without-cells", f"transition {_attribute(element, 'id')} names unknown cells")
            )
            continue
        i, j = sorted(number[e] for e in ends)
        shared = shared_faces(solids[i], solids[j])
        names = [building.rooms[i].name, building.rooms[j].name]
        if not shared:
            building.problems.append(
                Problem(WARNING, "transition-without-face", f"cells {names[0]} and {names[1]} share no face", names)
            )
        for k, polygon in enumerate(shared):
            label = " | ".join(names) + (f" ({k + 1})" if k else "")
            building.openings.append(Opening(label, VIRTUAL, OPEN, _attribute(element, "id"), (i, j), polygon=polygon))
    return building


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
        polygon = ElementTree.SubElement(ElementTree.SubElement(shell, _g("surfaceMember")), _g("Polygon"))
        ring = ElementTree.SubElement(ElementTree.SubElement(polygon, _g("exterior")), _g("LinearRing"))
        points = ElementTree.SubElement(ring, _g("posList"), {"srsDimension": "3"})
        points.text = _numbers(vertices[[*face, face[0]]])
    ElementTree.SubElement(cell, _c("duality"), {_x("href"): f"#S-{key}"})
    state = ElementTree.SubElement(
        ElementTree.SubElement(nodes, _c("stateMember")), _c("State"), {_g("id"): f"S-{key}"}
    )
    ElementTree.SubElement(state, _c("duality"), {_x("href"): f"#{key}"})
    point = ElementTree.SubElement(
        ElementTree.SubElement(state, _c("geometry")), _g("Point"), {_g("id"): f"P-{key}"}
    )
    ElementTree.SubElement(point, _g("pos")).text = _numbers(vertices.mean(axis=0))


def _triangles(loop: np.ndarray) -> list[tuple[int, int, int]]:
    """Ear clipping of a planar polygon (n, 3), indices into it."""
    newell = np.cross(loop - loop[0], np.roll(loop, -1, axis=0) - loop[0]).sum(axis=0)
    length = np.linalg.norm(newell)
    if length < 1e-12:
        return []
    frame = Frame.along(newell / length, loop[0])
    flat = [(float(x), float(y)) for x, y, _ in frame.local(loop)]
    left, result = list(range(len(flat))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            ear = [flat[a], flat[b], flat[c]]
            if cp.area(ear) <= 1e-12:
                continue
            if any(cp.contains(ear, flat[m], -1e-9) for m in left if m not in (a, b, c)):
                continue
            break
        else:
            k = 0  # no ear is left but slivers: any corner will do
        result.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    return [*result, (left[0], left[1], left[2])]


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
    return " ".join(f"{float(x):.9g}" if abs(x) < 1e3 else f"{float(x):.6f}" for x in np.asarray(points).reshape(-1))


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
