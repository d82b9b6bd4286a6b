# SPDX-License-Identifier: GPL-3.0-or-later
"""Passages through walls and slabs: the axis and cross-section of a void, or of a door that has none.

The axis is the normal of those faces of the uncut host that the void pierces. The void's thinnest side misleads (voids
deeper than wide are common), and so does the filler's mesh (sills and handles).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from . import convex_polygons as cp
from .ifc_placement import absolute_placement
from .ifc_shapes import Shape
from .polyhedra import signed_volume
from .probing import Frame, Passage
from .shapes import cross as vec_cross

SAME_DIRECTION = 0.94  # cosine of 20 degrees: facets of one curved face
OVERLAP = 2e-3  # m: a void that reaches less into its host takes nothing away
SPLAYED = 0.42  # sine of 25 degrees: reveals may widen towards a room
AHEAD = np.array([0.86, 0.44, 0.26])  # no wall stands square to it
GONE_ROUND = 0.8  # of a filler's width and height that its hole's faces must span
JAMB = 0.3  # m between a door's or window's own bounds and the hole it stands in
DEEP = 0.8  # m that a reveal may go on before or behind the filler
PIERCE = 0.03  # m beyond the void's ends in which a host's face counts as pierced


def of_void(void: Shape, host: Shape | None, across: np.ndarray | None) -> Passage | None:
    """The passage of an opening element through its host; None for a void without extent. across: the axis where the
    host's shape doesn't tell (`placement_axis`)."""
    points = void.world
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    axis = pierced_normal(points, host) if host is not None else None
    if axis is None and host is not None:
        # A host whose shape has the hole already, or a void that stays inside its host: nothing is pierced right through.
        axis = broad_normal(host, centre)
    if axis is None:
        axis = across
    if axis is None:
        axis = _widest_normal(points, void.triangles)
    return of_points(points, axis, centre, host)


def of_points(points: np.ndarray, axis: np.ndarray, centre: np.ndarray, host: Shape | None) -> Passage | None:
    frame = Frame.along(axis, centre, _longest_level_edge(points))
    local = frame.local(points)
    section = cp.hull((x, y) for x, y, _ in local)
    if len(section) < 3 or cp.area(section) < 1e-4:
        return None
    section = cp.limit_corners(section, 24)
    reach = (float(local[:, 2].min()), float(local[:, 2].max()))
    through = host_range(frame, section, reach, host) if host is not None else None
    passage = Passage(frame, section, reach, through or reach, wall=host)
    if through is not None and min(through[1], reach[1]) - max(through[0], reach[0]) < OVERLAP:
        passage.cuts = False
    return passage


def of_filler(filler: Shape, host: Shape | None) -> Passage | None:
    """The passage of a door or window that no void makes room for: its own extent, across the wall it stands in.

    The axis is the host's where there is one; else the thinner of depth and height in the filler's own placement (a
    skylight lies).
    """
    centre = 0.5 * (filler.world.min(axis=0) + filler.world.max(axis=0))
    axis = broad_normal(host, centre) if host is not None else None
    if axis is None:
        extent = filler.local.max(axis=0) - filler.local.min(axis=0)
        axis = filler.matrix[:3, 1] if extent[1] <= extent[2] else filler.matrix[:3, 2]
    return of_points(filler.world, axis, centre, None)


def of_reveals(filler: Shape, hosts: Iterable[Shape]) -> Passage | None:
    """The passage of a filler whose host is drawn with its hole: the hole's own faces, which look at the filler from its sides, tell its
    section and how thick the host is. hosts: what stands near; leaves of one wall are passed as one. None where no hole goes round
    most of the filler."""
    centre = 0.5 * (filler.world.min(axis=0) + filler.world.max(axis=0))
    own = [filler.matrix[:3, k] / np.linalg.norm(filler.matrix[:3, k]) for k in range(3)]
    found = []
    for host in hosts:
        broad = broad_normal(host, centre)
        for axis in own if broad is None else [broad, *own]:
            axis = axis if axis @ AHEAD > 0.0 else -axis  # so that leaves of one wall agree
            passage = _of_reveals(Frame.along(axis, centre, _longest_level_edge(filler.world)), filler, host)
            if passage is not None:
                found.append(passage)
                break
    if not found:
        return None
    best = max(found, key=lambda p: cp.area(p.section))
    leaves = np.array([p.host for p in found if p.frame.n @ best.frame.n > SAME_DIRECTION])
    depths = (float(leaves[:, 0].min()), float(leaves[:, 1].max()))
    return Passage(best.frame, best.section, depths, depths)


def _of_reveals(frame: Frame, filler: Shape, host: Shape) -> Passage | None:
    """Along the frame's axis; None where the host stands in the way."""
    own, corner = frame.local(filler.world), frame.local(host.world)[host.triangles]
    cross = vec_cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.maximum(np.linalg.norm(cross, axis=1), 1e-12)
    low, high = own.min(axis=0), own.max(axis=0)
    middle = 0.5 * (low + high)
    grown = np.array([JAMB, JAMB, DEEP])
    reveal = np.abs(cross[:, 2]) < SPLAYED * size
    reveal &= np.einsum("ij,ij->i", cross[:, :2], middle[:2] - corner.mean(axis=1)[:, :2]) > 0.0
    reveal &= (corner.min(axis=1) >= low - grown).all(axis=1) & (corner.max(axis=1) <= high + grown).all(axis=1)
    around = corner[reveal].reshape(-1, 3)
    if not len(around) or (np.ptp(around, axis=0)[:2] < GONE_ROUND * (high - low)[:2]).any():
        return None
    section = section_of(frame, frame.world(around))
    depths = (float(around[:, 2].min()), float(around[:, 2].max()))
    if not section or cp.area(section) < 1e-4:
        return None
    across = (np.abs(cross[:, 2]) > 0.5 * size) & (corner[:, :, 2].max(axis=1) >= depths[0]) & (corner[:, :, 2].min(axis=1) <= depths[1])
    pieces = (cp.hull((x, y) for x, y, _ in tri) for tri in corner[across])
    shut = sum(cp.area(shared) for piece in pieces if len(piece) > 2 and (shared := cp.clip(piece, section)))
    return Passage(frame, section, depths, depths) if shut < (1.0 - GONE_ROUND) * cp.area(section) else None


def section_of(frame: Frame, points: np.ndarray) -> cp.Polygon:
    """The convex outline of points across a frame's axis, [] for a line."""
    section = cp.hull((x, y) for x, y, _ in frame.local(points))
    return cp.limit_corners(section, 24) if len(section) > 2 else []


def of_panes(shapes: list[Shape]) -> list[Passage]:
    """Passages of panes of glass: one per plane, the convex hull of its panes."""
    groups: list[tuple[np.ndarray, float, list[np.ndarray]]] = []
    for shape in shapes:
        centre = 0.5 * (shape.world.min(axis=0) + shape.world.max(axis=0))
        normal = broad_normal(shape, centre)
        if normal is None:
            continue
        for known, d, members in groups:
            # Panes of one plane: 2 degrees, 15 cm.
            if abs(known @ normal) > 0.9994 and abs(centre @ known - d) < 0.15:
                members.append(shape.world)
                break
        else:
            groups.append((normal, float(centre @ normal), [shape.world]))
    result = []
    for normal, _, members in groups:
        points = np.concatenate(members)
        passage = of_points(points, normal, 0.5 * (points.min(axis=0) + points.max(axis=0)), None)
        if passage is not None:
            result.append(passage)
    return result


def pierced_normal(points: np.ndarray, host: Shape) -> np.ndarray | None:
    """The direction of the host's faces that the void (given by its corners) cuts most of, or None."""
    corners, triangles = host.world, host.triangles
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    cross = vec_cross(b - a, c - a)
    size = np.linalg.norm(cross, axis=1)
    low, high = points.min(axis=0) - PIERCE, points.max(axis=0) + PIERCE
    near = (np.minimum(np.minimum(a, b), c) <= high).all(axis=1) & (np.maximum(np.maximum(a, b), c) >= low).all(axis=1)
    near &= size > 1e-10
    if not near.any():
        return None
    normals = cross[near] / size[near, None]
    tris = np.stack([a[near], b[near], c[near]], axis=1)
    # Directions up to sign, largest triangles first; facets of a curved face share one direction.
    order = np.argsort(-size[near], kind="stable")
    directions: list[np.ndarray] = []
    for k in order:
        if not any(abs(d @ normals[k]) > 0.9999 for d in directions):
            directions.append(normals[k])
        if len(directions) >= 24:
            break
    best, best_score = None, 0.0
    for d in directions:
        frame = Frame.along(d, 0.5 * (low + high))
        local = frame.local(points)
        section = cp.hull((x, y) for x, y, _ in local)
        if len(section) < 3:
            continue
        bottom, top = local[:, 2].min() - PIERCE, local[:, 2].max() + PIERCE
        score, mean = 0.0, np.zeros(3)
        cosine = normals @ d
        for k in np.nonzero(np.abs(cosine) > SAME_DIRECTION)[0]:
            flat = frame.local(tris[k])
            if flat[:, 2].max() < bottom or flat[:, 2].min() > top:
                continue
            # A face that looks into the void is the reveal of a hole the shape has already, not a face to pierce.
            if cosine[k] * (flat[:, 2].mean() - 0.5 * (bottom + top)) < 0.0:
                continue
            piece = [(float(p[0]), float(p[1])) for p in flat]
            if cp.area(piece) < 0.0:
                piece.reverse()
            shared = cp.clip(piece, section)
            if shared:
                weight = cp.area(shared)
                score += weight * cosine[k] ** 2
                mean += weight * np.sign(cosine[k]) * normals[k]
        # Right through is twice the section: two faces. Once is a door's void that is flush with its wall's foot.
        if score > best_score * 1.0001 and score > 1.2 * cp.area(section):
            best, best_score = mean / np.linalg.norm(mean), score
    return best


def broad_normal(host: Shape, centre: np.ndarray) -> np.ndarray | None:
    """The direction in which the host's faces near a point are largest: across a wall, along a slab's thickness."""
    corners, triangles = host.world, host.triangles
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    cross = vec_cross(b - a, c - a)
    size = np.linalg.norm(cross, axis=1)
    # Of a long curved wall only what is near counts: triangles whose bounds come within 2 m.
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    near = (size > 1e-10) & (low <= centre + 2.0).all(axis=1) & (high >= centre - 2.0).all(axis=1)
    if not near.any():
        return None
    normals = cross[near] / size[near, None]
    best, most = None, 0.0
    for k in np.argsort(-size[near], kind="stable")[:24]:
        aligned = np.abs(normals @ normals[k]) > SAME_DIRECTION
        total = float(size[near][aligned].sum())
        if total > most * 1.0001:
            best, most = normals[k], total
    return best


def host_range(
    frame: Frame, section: cp.Polygon, reach: tuple[float, float], host: Shape
) -> tuple[float, float] | None:
    """Between which t along the axis the host is solid where the void is; None when it is nowhere pierced."""
    corners, triangles = host.world, host.triangles
    local = frame.local(corners)
    depths: list[float] = []
    xs, ys = [p[0] for p in section], [p[1] for p in section]
    corner = local[triangles]
    least, most = corner.min(axis=1), corner.max(axis=1)
    near = (most[:, 0] >= min(xs)) & (least[:, 0] <= max(xs)) & (most[:, 1] >= min(ys)) & (least[:, 1] <= max(ys))
    near &= (most[:, 2] >= reach[0] - 0.5) & (least[:, 2] <= reach[1] + 0.5)
    for flat in corner[near]:
        piece = [(float(p[0]), float(p[1])) for p in flat]
        area = cp.area(piece)
        if abs(area) < 1e-9:
            continue
        if area < 0.0:
            piece.reverse()
        shared = cp.clip(piece, section)
        if not shared or cp.area(shared) < 1e-6:
            continue
        normal = vec_cross(flat[1] - flat[0], flat[2] - flat[0])
        depths += [
            float(flat[0, 2] - ((x - flat[0, 0]) * normal[0] + (y - flat[0, 1]) * normal[1]) / normal[2])
            for x, y in shared
        ]
    if len(depths) < 3 or max(depths) - min(depths) < 1e-4:
        return None
    return min(depths), max(depths)


def placement_axis(product: Any) -> np.ndarray | None:
    """Across a wall, door or window: local y of its placement. Across a slab: local z."""
    if product is None or getattr(product, "ObjectPlacement", None) is None:
        return None
    matrix = absolute_placement(product.ObjectPlacement)
    if product.is_a("IfcSlab") or product.is_a("IfcRoof") or product.is_a("IfcCovering"):
        return matrix[:3, 2].copy()
    across = matrix[:3, 1].copy()
    across[2] = 0.0
    length = np.linalg.norm(across)
    return across / length if length > 0.5 else None


def is_convex_enough(void: Shape, passage: Passage) -> bool:
    """Whether the void fills its cross-section (97 %): else its convex hull stands in for it, and is told."""
    volume = abs(signed_volume(void.world, void.triangles))
    prism = cp.area(passage.section) * (passage.void[1] - passage.void[0])
    return prism < 1e-9 or volume > 0.97 * prism or volume < 1e-9


def _widest_normal(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The level normal under which the shape shows the largest area; for want of a host."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cross = vec_cross(b - a, c - a)
    best = np.array([0.0, 1.0, 0.0])
    most = -1.0
    for n in cross:
        length = np.hypot(n[0], n[1])
        if length < 1e-9:
            continue
        d = np.array([n[0] / length, n[1] / length, 0.0])
        seen = float(np.abs(cross @ d).sum())
        if seen > most * 1.0001:
            best, most = d, seen
    return best


def _longest_level_edge(points: np.ndarray) -> np.ndarray:
    """A direction fixed to the shape, so that the answer turns with the model."""
    outline = cp.hull((p[0], p[1]) for p in points)
    if len(outline) < 2:
        return np.array([1.0, 0.0, 0.0])
    edges = [np.subtract(outline[i], outline[i - 1]) for i in range(len(outline))]
    longest = max(edges, key=lambda e: round(float(np.hypot(*e)), 4))
    return np.array([longest[0], longest[1], 0.0])
