# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms, openings, sightlines and problems drawn over the 3D view. Batches are built once a result.

`gpu` is imported only where something is drawn: it raises in background mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from .. import session
from ..rules.building import INTERIOR, VIRTUAL, Building

CROWD = 12  # problems of a kind that are all marked; of more, one
NEIGHBOURHOODS = 8  # of so many along the building's length
MARK = 0.3, 4.0, 9.0  # a problem's mark: metres at the distance looked at, and pixels that it is at least and at most
SEEN = (0.98, 0.75, 0.20, 0.95)
START = (1.00, 0.92, 0.55, 1.0)
UNSEEN = (0.55, 0.58, 0.62, 0.28)
PLAIN = (0.60, 0.66, 0.74, 0.60)
FILL = {"open": (0.16, 0.70, 0.40, 0.35), "glass": (0.25, 0.55, 0.95, 0.28), "closed": (0.85, 0.25, 0.20, 0.45),
        VIRTUAL: (0.16, 0.70, 0.40, 0.07)}  # nothing is built there, and it may be as large as a room
LINE = (0.95, 0.45, 0.10, 0.8)
TROUBLE = {"error": (0.95, 0.20, 0.15, 1.0), "warning": (0.98, 0.65, 0.10, 1.0)}

_handle: Any = None
ORDER = ("TRIS", "LINES", "POINTS")  # what is drawn later lies on top
_still: list[tuple[str, Any, tuple, float]] = []  # what no look changes
_batches: list[tuple[str, Any, tuple, float]] = []  # that too
_built_for: tuple | None = None
_looked_for = -1
_outlined: tuple[Building, dict[int, np.ndarray]] | None = None


@dataclass
class Drawing:
    """Plain numbers to draw: what `build` makes and a test can look at."""

    lines: list[tuple[np.ndarray, tuple, float]] = field(default_factory=list)  # (2n, 3), colour, width in pixels
    triangles: list[tuple[np.ndarray, tuple]] = field(default_factory=list)  # (3n, 3), colour
    points: list[tuple[np.ndarray, tuple]] = field(default_factory=list)


def build(found: session.Session, settings) -> Drawing:
    """All that is drawn."""
    rooms, rest = of_view(found, settings), of_building(found, settings)
    return Drawing(rooms.lines + rest.lines, rest.triangles, rest.points)


def of_view(found: session.Session, settings) -> Drawing:
    """Rooms, coloured by whether they are seen: what every look changes."""
    out = Drawing()
    if not settings.show_rooms:
        return out
    view = found.views[-1] if found.views else None
    groups: dict[tuple, list[np.ndarray]] = {}
    seen = set(view.rooms) if view else set()
    start = {int(found.cells.rooms[c]) for c in view.camera_cells} if view else set()
    for i, outline in _outlines(found.building).items():
        colour = PLAIN if view is None else START if i in start else SEEN if i in seen else UNSEEN
        groups.setdefault(colour, []).append(outline)
    # faint ones first, so that what is seen lies on top
    for colour in (UNSEEN, PLAIN, SEEN, START):
        if colour in groups:
            out.lines.append((np.concatenate(groups[colour]), colour, 1.0 if colour in (UNSEEN, PLAIN) else 2.0))
    return out


def of_building(found: session.Session, settings) -> Drawing:
    """Openings, sightlines and problems."""
    out = Drawing()
    building = found.building
    if settings.show_openings:
        fills: dict[str, list[np.ndarray]] = {}
        for opening in building.openings:
            shapes = [opening.polygon] if opening.polygon is not None else list(opening.ends or ())
            for polygon in shapes:
                fills.setdefault(VIRTUAL if opening.kind == VIRTUAL else opening.state, []).append(_fan(polygon))
        for state, triangles in fills.items():
            out.triangles.append((np.concatenate(triangles), FILL.get(state, FILL["open"])))
    if settings.show_sightlines and found.matrix is not None and found.matrix.sightlines:
        # those that lead outdoors end anywhere, far off: between rooms is what is asked
        rooms = [r.kind == INTERIOR for r in building.rooms]
        inside = [(s.start, s.end) for s in found.matrix.sightlines if all(rooms[r] for r in s.rooms)]
        segments = np.array(inside, dtype=np.float64).reshape(-1, 3)
        out.lines.append((segments, LINE, 1.0))
    if settings.show_problems:
        muted = settings.muted
        for severity, colour in TROUBLE.items():
            kinds: dict[str, list] = {}
            for p in found.problems:
                if p.severity == severity and p.position is not None and p.code not in muted:
                    kinds.setdefault(p.code, []).append(p.position)
            if kinds:
                out.points.append((np.concatenate([_thinned(np.array(places)) for places in kinds.values()]), colour))
    return out


def _thinned(places: np.ndarray) -> np.ndarray:
    """Of a kind that is found all over the building, one a neighbourhood: the panel steps through all of them."""
    if len(places) <= CROWD:
        return places
    cell = max(float(np.ptp(places, axis=0).max()) / NEIGHBOURHOODS, 1e-6)
    _, first = np.unique(np.floor((places - places.min(axis=0)) / cell).astype(np.int64), axis=0, return_index=True)
    return places[np.sort(first)]


def _outlines(building: Building) -> dict[int, np.ndarray]:
    """By room, of those that have a shape; found once a building."""
    global _outlined
    if _outlined is None or _outlined[0] is not building:
        shapes = {i: r for i, r in enumerate(building.rooms) if r.vertices is not None and len(r.vertices)}
        _outlined = building, {i: _outline(r.vertices, r.faces) for i, r in shapes.items()}
    return _outlined[1]


def _outline(vertices: np.ndarray, faces) -> np.ndarray:
    """Edges between faces that aren't in one plane; all hull edges' corners are kept simple for rooms without faces."""
    if not faces:
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        corners = np.array([(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
        edges = [(0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
        return corners[np.array(edges).reshape(-1)]
    normals = []
    owners: dict[tuple[int, int], list[int]] = {}
    for f, face in enumerate(faces):
        points = vertices[face]
        centred = points - points.mean(axis=0)
        normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
        normals.append(normal / (np.linalg.norm(normal) or 1.0))
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            owners.setdefault((min(a, b), max(a, b)), []).append(f)
    sharp = [
        edge
        for edge, around in owners.items()
        if len(around) != 2 or abs(float(normals[around[0]] @ normals[around[1]])) < 0.9995
    ]
    return vertices[np.array(sharp, dtype=np.int64).reshape(-1)] if sharp else np.zeros((0, 3))


def _fan(polygon: np.ndarray) -> np.ndarray:
    return np.concatenate([polygon[[0, i, i + 1]] for i in range(1, len(polygon) - 1)])


def _draw() -> None:
    context = bpy.context
    scene = context.scene
    settings = getattr(scene, "enfilade", None)
    found = session.get(scene)
    if settings is None or found is None or not settings.show_overlay:
        return
    if context.space_data is None or not getattr(context.space_data.overlay, "show_overlays", True):
        return
    _ensure_batches(scene, found, settings)
    import gpu

    from .. import compat

    width_of = context.preferences.system.ui_scale
    mark = _mark_size(context.region, context.region_data)
    shader = compat.line_shader(gpu)
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    try:
        for kind, batch, colour, width in _batches:
            # outlines and fills are hidden by walls only faintly: a room is understood through them
            if kind == "POINTS":
                gpu.state.depth_test_set("NONE")
                gpu.state.point_size_set(mark * width_of)
            elif kind == "LINES":
                gpu.state.depth_test_set("NONE")
                gpu.state.line_width_set(width * width_of)
            else:
                gpu.state.depth_test_set("LESS_EQUAL")
            shader.bind()
            shader.uniform_float("color", colour)
            batch.draw(shader)
    finally:
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")
        gpu.state.line_width_set(1.0)
        gpu.state.point_size_set(1.0)


def _mark_size(region, view) -> float:
    """Pixels: as large as the view makes things, within limits, so that a building seen from afar isn't covered by its marks."""
    metres, least, most = MARK
    a_metre = 0.5 * region.width * view.window_matrix[0][0] / (max(view.view_distance, 0.01) if view.is_perspective else 1.0)
    return min(max(metres * a_metre, least), most)


def _ensure_batches(scene, found, settings) -> None:
    global _built_for, _looked_for
    key = (
        scene.name_full,
        session.revision,
        settings.show_rooms,
        settings.show_openings,
        settings.show_sightlines,
        settings.show_problems,
        settings.muted_problems,
    )
    if key != _built_for:
        _still[:] = _batches_of(of_building(found, settings))
    if (key, session.looked) != (_built_for, _looked_for):
        _batches[:] = sorted(_batches_of(of_view(found, settings)) + _still, key=lambda batch: ORDER.index(batch[0]))
    _built_for, _looked_for = key, session.looked


def _batches_of(drawing: Drawing) -> list[tuple[str, Any, tuple, float]]:
    import gpu
    from gpu_extras.batch import batch_for_shader

    from .. import compat

    shader = compat.line_shader(gpu)
    parts = [("TRIS", points, colour, 1.0) for points, colour in drawing.triangles]
    parts += [("LINES", points, colour, width) for points, colour, width in drawing.lines]
    parts += [("POINTS", points, colour, 1.0) for points, colour in drawing.points]
    return [(kind, batch_for_shader(shader, kind, {"pos": points.astype(np.float32)}), colour, width) for kind, points, colour, width in parts]


def forget() -> None:
    global _built_for, _outlined
    _still.clear()
    _batches.clear()
    _built_for = _outlined = None


def sync(context) -> None:
    """A setting changed: draw again."""
    forget()
    from ..ops.common import redraw

    redraw(context)


def register() -> None:
    global _handle
    if _handle is None and not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    forget()
