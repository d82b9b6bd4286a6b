# SPDX-License-Identifier: GPL-3.0-or-later
"""From labelled voxels to rooms: upright prisms on the walls' planes, cut by sloped planes above and below, outward of every free voxel.

A room whose prism would hold other rooms' air is divided into height bands, each a room of its own in contact with the next; what is then
still held is told. Coordinates: the work frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import polyhedra
from .geometry_grid import CAP, OUTSIDE, Grid, boxes
from .geometry_outline import ALONG, HOLE, NOTCH, AskewWall, Outliner, WallPlanes, closed, loops, triangulate
from .geometry_pace import Progress
from .probing import Frame, Passage

FOREIGN = 0.5  # m3 of other rooms' air in a room's prism from which on it is divided into bands
LEAST_BAND = 0.4  # m: thinner bands go to their neighbour (outward)
SLOPED = (0.05, 0.9962)  # of a normal's z: between upright and level (5 degrees): a roof, a slanted wall
UNDER_SKY = 2  # voxels under outdoor air that may hold some of it too: those of a roof of up to 60 degrees
LEAST_PLANE = 0.5  # m2 of sloped triangles on one plane before it bounds a room


@dataclass
class Shape:
    """A room's polyhedron and the label of its voxels."""

    label: int
    solid: polyhedra.Polyhedron
    floor: float
    area: float  # m2 in plan
    rings: list[np.ndarray]  # its outline, and the holes in it
    halves: list[tuple[np.ndarray, float]]  # n.x <= d: the sloped planes that bound it
    top: float = np.inf  # m: from there on up there is outdoor air in the shape too, where no such plane keeps it out


class Planes:
    """The drawn planes that rooms end at."""

    def __init__(self, corners: np.ndarray, caps: list[float]) -> None:
        """corners: float64 (n, 3, 3) of all shell triangles."""
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(cross, axis=1)
        good = size > 1e-8
        corners, size = corners[good], size[good]
        normals = cross[good] / size[:, None]
        self.walls = WallPlanes.of(corners, normals, 0), WallPlanes.of(corners, normals, 1)
        level = WallPlanes.of(corners, normals, 2)
        extra = np.array(caps)
        n = len(extra)
        order = np.argsort(np.concatenate([level.position, extra]), kind="stable")
        everywhere = np.full((n, 2), -np.inf), np.full((n, 2), np.inf)
        self.levels = WallPlanes(
            np.concatenate([level.position, extra])[order],
            np.concatenate([level.sign, np.zeros(n)])[order],
            np.concatenate([level.low, everywhere[0]])[order],
            np.concatenate([level.high, everywhere[1]])[order],
        )
        upright = (np.abs(normals[:, 2]) <= SLOPED[0]) & (np.abs(normals[:, :2]).max(axis=1) <= ALONG)
        self.askew = AskewWall.of(corners[upright], normals[upright], LEAST_PLANE)
        sloped = (np.abs(normals[:, 2]) > SLOPED[0]) & (np.abs(normals[:, 2]) < SLOPED[1])
        self.slopes = _group(corners[sloped], normals[sloped], 0.5 * size[sloped])

    def through_wall(self, p: Passage, step: float) -> Passage:
        """A passage whose host was measured in voxels, from face to face of its wall. Where no face is drawn it ends a voxel further in: what
        stuck out of the wall would have sides in the open air, at which looks along the facade would end."""
        section = np.array(p.section)
        ring = [(x, y) for x, y in (*(section + 2.0 * step * np.sign(section - section.mean(axis=0))), *section)]
        middle = 0.5 * (p.host[0] + p.host[1])
        host = []
        for t, sign in zip(p.host, (-1.0, 1.0), strict=True):
            box = p.frame.world(np.array([(x, y, t) for x, y in ring]))
            face = self._face(p.frame, t - sign * (step + 0.02), t + sign * (0.5 * step + 0.02), sign, box.min(axis=0), box.max(axis=0))
            inner = t - sign * min(step, 0.9 * abs(t - middle))
            host.append(inner if face is None or (face - middle) * sign < 0.0 else face)
        return Passage(p.frame, p.section, p.void, (host[0], host[1]), p.cuts, p.wall)

    def _face(self, frame: Frame, start: float, end: float, sign: float, low: np.ndarray, high: np.ndarray) -> float | None:
        """Where along a frame's axis, between start and end, a face looks out along sign * n, in the box low..high; the nearest to start."""
        axis = int(np.argmax(np.abs(frame.n)))
        if abs(frame.n[axis]) > ALONG:
            way = float(np.sign(frame.n[axis]))
            across = [1 - axis, 2] if axis < 2 else [0, 1]
            where = frame.origin[axis]
            found = (*self.walls, self.levels)[axis].outward(where + way * start, where + way * end, low[across], high[across], -sign * way)
            return None if found is None else (found - where) * way
        for wall in self.askew:
            if sign * float(wall.normal @ frame.n[:2]) > ALONG:
                t = sign * (wall.d - float(wall.normal @ frame.origin[:2]))
                if min(start, end) <= t <= max(start, end):
                    return t
        return None


def _group(corners: np.ndarray, normals: np.ndarray, areas: np.ndarray) -> list[tuple[np.ndarray, float, np.ndarray, np.ndarray]]:
    """Sloped planes as (unit normal upward, d, low, high of what is drawn on them)."""
    if not len(corners):
        return []
    up = normals * np.where(normals[:, 2] < 0.0, -1.0, 1.0)[:, None]
    d = np.einsum("ij,ij->i", up, corners[:, 0])
    key = np.round(np.column_stack([up * 200.0, d * 50.0])).astype(np.int64)
    _, inverse = np.unique(key, axis=0, return_inverse=True)
    inverse = np.asarray(inverse).reshape(-1)
    result = []
    for g in range(int(inverse.max()) + 1):
        mine = inverse == g
        if areas[mine].sum() < LEAST_PLANE:
            continue
        normal = np.average(up[mine], axis=0, weights=areas[mine])
        normal /= np.linalg.norm(normal)
        points = corners[mine].reshape(-1, 3)
        result.append((normal, float(np.average(d[mine], weights=areas[mine])), points.min(axis=0), points.max(axis=0)))
    return result


def shapes(native: Any, grid: Grid, labels: np.ndarray, count: int, planes: Planes, watch: Progress, first: int = 2) -> list[Shape]:
    """Every room's shape. Bands and parts that hang together no more get new labels, written into `labels`."""
    result: list[Shape] = []
    top = count
    for label, where in watch.over(boxes(native, labels, count)):
        if label < first:
            continue
        plan = tuple(slice(max(0, s.start - NOTCH - 2), s.stop + NOTCH + 2) for s in where[1:])
        zs = where[0]
        part = labels[(zs, *plan)]
        own = part == label
        foreign = (part != 0) & ~own
        whole = True
        for band in _bands(grid, own, foreign, planes, zs, plan):
            for outline in _pieces(own[band].any(axis=0)):
                mine = own[band] & outline
                number = label
                if not whole:
                    top += 1
                    number = top
                    part[band][mine] = number
                whole = False
                others = foreign[band] | (own[band] & ~outline)
                made = _shape(native, grid, number, mine, others, planes, zs.start + band.start, plan)
                result += [_under_sky(grid, labels, shape, plan) for shape in made]
    return result


def _pieces(mask: np.ndarray) -> list[np.ndarray]:
    """The parts of a plan that hang together by edges, as masks."""
    outlines = [loop for loop in loops(mask) if _signed(loop) > 0]
    if len(outlines) < 2:
        return [mask]
    whole = slice(0, mask.shape[0]), slice(0, mask.shape[1])
    return [_even_odd(loop, whole) & mask for loop in outlines]


def _signed(loop: list[tuple[int, int]]) -> int:
    return sum(loop[i - 1][0] * loop[i][1] - loop[i][0] * loop[i - 1][1] for i in range(len(loop)))


def _bands(
    grid: Grid, own: np.ndarray, foreign: np.ndarray, planes: Planes, zs: slice, where: tuple[slice, slice]
) -> list[slice]:
    """Height bands of a room: one, unless its prism would take in other rooms' air that no sloped plane cuts off."""
    whole = slice(0, own.shape[0])
    if own.shape[0] < 2 * grid.count(LEAST_BAND):
        return [whole]
    footprint = own.any(axis=0)
    taken = foreign & footprint
    if taken.sum() * grid.step**3 < FOREIGN:
        return [whole]
    for normal, d in _bounding(grid, own, planes, zs, where):
        taken &= _below(grid, own.shape, zs, where, normal, d)
    if taken.sum() * grid.step**3 < FOREIGN:
        return [whole]
    # Cut where the taken volume falls most, again in each half.
    least = grid.count(LEAST_BAND)
    best = None
    below, above = _taken(own, foreign), _taken(own[::-1], foreign[::-1])
    for cut in range(least, own.shape[0] - least + 1):
        halves = int(below[cut] + above[own.shape[0] - cut])
        if best is None or halves < best[0]:
            best = (halves, cut)
    if best is None or best[0] > 0.8 * int(taken.sum()):
        return [whole]
    cut = best[1]
    result = []
    for s in (slice(0, cut), slice(cut, own.shape[0])):
        inner = _bands(grid, own[s], foreign[s], planes, slice(zs.start + s.start, zs.start + s.stop), where)
        result += [slice(s.start + b.start, s.start + b.stop) for b in inner]
    return result


def _taken(own: np.ndarray, foreign: np.ndarray) -> np.ndarray:
    """How many voxels of others the prism round a room's first n layers would take, int (nz + 1,) by n."""
    result = np.zeros(len(own) + 1, dtype=np.int64)
    others = np.zeros(own.shape[1:], dtype=np.int64)
    footprint = np.zeros(own.shape[1:], dtype=bool)
    for n in range(len(own)):
        footprint |= own[n]
        others += foreign[n]
        result[n + 1] = others[footprint].sum()
    return result


def _centres(grid: Grid, own: np.ndarray, zs: slice, where: tuple[slice, slice]) -> np.ndarray:
    """Centres of the surface voxels of a mask, float64 (n, 3)."""
    inner = own.copy()
    for axis in range(3):
        edge = np.zeros_like(own)
        ahead, behind = [slice(None)] * 3, [slice(None)] * 3
        ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
        edge[tuple(behind)] = own[tuple(ahead)]
        both = np.zeros_like(own)
        both[tuple(ahead)] = own[tuple(behind)]
        inner &= edge & both
    k, j, i = np.nonzero(own & ~inner)
    index = np.column_stack([i + where[1].start, j + where[0].start, k + zs.start])
    return grid.origin + (index + 0.5) * grid.step


def _bounding(
    grid: Grid, own: np.ndarray, planes: Planes, zs: slice, where: tuple[slice, slice]
) -> list[tuple[np.ndarray, float]]:
    """Half-spaces n.x <= d by sloped planes that hold every free voxel, tight ones only."""
    if not planes.slopes:
        return []
    points = _centres(grid, own, zs, where)
    low, high = points.min(axis=0) - 2 * grid.step, points.max(axis=0) + 2 * grid.step
    result: list[tuple[np.ndarray, float]] = []
    for normal, d, a, b in planes.slopes:
        if (a > high).any() or (b < low).any():
            continue
        for sign in (1.0, -1.0):
            over = float((sign * (points @ normal - d)).max())
            # Within: centres of free voxels lie at least half a voxel's reach inside, at most two voxels away.
            if -2.0 * grid.step <= over <= 0.0 and (over + sign * 0.0) <= 0.0:
                touching = (sign * (points @ normal - d) > -2.0 * grid.step).sum()
                if touching * grid.step**2 >= LEAST_PLANE:
                    result.append((sign * normal, sign * d))
    return _tightest(result)


def _tightest(planes: list[tuple[np.ndarray, float]]) -> list[tuple[np.ndarray, float]]:
    """Of parallel planes (2 degrees) the one that holds least... kept outward: the farther, since both hold all."""
    kept: list[tuple[np.ndarray, float]] = []
    for normal, d in sorted(planes, key=lambda p: p[1]):
        if not any(float(normal @ n) > 0.9994 for n, _ in kept):
            kept.append((normal, d))
    return kept


def _below(
    grid: Grid, shape: tuple[int, ...], zs: slice, where: tuple[slice, slice], normal: np.ndarray, d: float
) -> np.ndarray:
    z, y, x = (
        grid.origin[2 - axis] + (np.arange(n) + start + 0.5) * grid.step
        for axis, (n, start) in enumerate(zip(shape, (zs.start, where[0].start, where[1].start), strict=True))
    )
    return normal[2] * z[:, None, None] + normal[1] * y[:, None] + normal[0] * x <= d


def _shape(
    native: Any, grid: Grid, label: int, own: np.ndarray, foreign: np.ndarray, planes: Planes, k0: int, where: tuple[slice, slice]
) -> list[Shape]:
    layers = np.nonzero(own.any(axis=(1, 2)))[0]
    if not len(layers):
        return []
    bottom, top = k0 + int(layers[0]), k0 + int(layers[-1]) + 1
    mask, others = own.any(axis=0), foreign.any(axis=0)
    halves = _bounding(grid, own, planes, slice(k0, k0 + own.shape[0]), where)
    if halves:
        # What sloped planes cut off is no obstacle to the outline.
        kept = foreign.copy()
        for normal, d in halves:
            kept &= _below(grid, own.shape, slice(k0, k0 + own.shape[0]), where, normal, d)
        others = kept.any(axis=0)
    others = others & ~mask
    mask = closed(native, mask, others)
    mask = _without_holes(grid, mask, others)
    corner = grid.origin[:2] + np.array([where[1].start, where[0].start]) * grid.step
    box_low, box_high = corner, corner + np.array(mask.shape[::-1]) * grid.step
    z0 = _level(grid, planes, bottom, -1.0, box_low, box_high)
    z1 = _level(grid, planes, top, 1.0, box_low, box_high)
    outliner = Outliner(corner, grid.step, mask, others, planes.walls, planes.askew, (z0, z1))
    result = []
    for rings in outliner.polygons():
        solid = _prism(rings, z0, z1)
        for normal, d in halves:
            solid = clip(solid, normal, d) or solid
        if solid is not None and solid.closed and solid.volume > 1e-3:
            result.append(Shape(label, solid, z0, float(mask.sum()) * grid.step**2, rings, halves))
    return result


def _under_sky(grid: Grid, labels: np.ndarray, shape: Shape, where: tuple[slice, slice]) -> Shape:
    """The shape with its `top`."""
    low, high = float(shape.solid.low[2]), float(shape.solid.high[2])
    zs = slice(max(0, grid.layer(low)), min(grid.shape[0], grid.layer(high) + 1 + UNDER_SKY))
    taken = (labels[(zs, *where)] == OUTSIDE) & _covered(grid, shape.rings, where)
    for normal, d in shape.halves if taken.any() else ():
        taken &= _below(grid, taken.shape, zs, where, normal, d)
    layers = np.nonzero(taken.any(axis=(1, 2)))[0]
    if len(layers):
        shape.top = float(grid.origin[2] + (zs.start + layers[0] - UNDER_SKY) * grid.step)
    return shape


def _covered(grid: Grid, rings: list[np.ndarray], where: tuple[slice, slice]) -> np.ndarray:
    """Which columns have their middle within a polygon of several rings, bool (ny, nx)."""
    y, x = (grid.origin[1 - axis] + (np.arange(s.start, s.stop) + 0.5) * grid.step for axis, s in enumerate(where))
    flips = np.zeros((len(y), len(x) + 1), dtype=np.int64)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            rows = np.nonzero((a[1] > y) != (b[1] > y))[0]
            at = a[0] + (y[rows] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) if len(rows) else rows
            flips[rows, np.searchsorted(x, at)] += 1
    return np.cumsum(flips, axis=1)[:, :-1] % 2 == 1


def _without_holes(grid: Grid, mask: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Columns and ducts inside a room count as its air; cores of HOLE m2 and more, or other rooms, stay cut out."""
    filled = mask.copy()
    for loop in loops(mask):
        signed = _signed(loop)
        if signed > 0 or -0.5 * signed * grid.step**2 >= HOLE:
            continue
        x, y = [p[0] for p in loop], [p[1] for p in loop]
        box = slice(min(y), max(y)), slice(min(x), max(x))
        inside = _even_odd(loop, box)
        if not (others[box] & inside).any():
            filled[box] |= inside
    return filled


def _even_odd(loop: list[tuple[int, int]], box: tuple[slice, slice]) -> np.ndarray:
    shape = box[0].stop - box[0].start, box[1].stop - box[1].start
    flips = np.zeros((shape[0], shape[1] + 1), dtype=np.int64)
    for i in range(len(loop)):
        (xa, ya), (xb, yb) = loop[i - 1], loop[i]
        if xa == xb:
            flips[min(ya, yb) - box[0].start : max(ya, yb) - box[0].start, xa - box[1].start] += 1
    return (np.cumsum(flips, axis=1) % 2 == 1)[:, :-1]


def _level(grid: Grid, planes: Planes, layer: int, outward: float, low: np.ndarray, high: np.ndarray) -> float:
    """The height a room ends at: the drawn level plane (or cap) in the voxel beyond its last free layer, or over that voxel."""
    at = float(grid.origin[2] + layer * grid.step)
    plane = planes.levels.outward(at - 0.02 * outward, at + outward * (grid.step + 0.02), low, high, outward)
    beyond = layer if outward > 0 else layer - 1
    if plane is None and 0 <= beyond < grid.shape[0] and (grid.blocked[beyond] & CAP).any():
        plane = at + 0.5 * outward * grid.step
    return plane if plane is not None else at + outward * grid.step


def _prism(rings: list[np.ndarray], z0: float, z1: float) -> polyhedra.Polyhedron | None:
    points, flat = triangulate(rings)
    if not len(flat):
        return None
    n = len(points)
    vertices = np.concatenate([np.column_stack([points, np.full(n, z)]) for z in (z0, z1)])
    triangles = [flat[:, ::-1], flat + n]
    start = 0
    for ring in rings:
        i = np.arange(len(ring)) + start
        j = np.roll(i, -1)
        triangles += [np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])]
        start += len(ring)
    return polyhedra.build(vertices, np.concatenate(triangles))


def clip(solid: polyhedra.Polyhedron, normal: np.ndarray, d: float) -> polyhedra.Polyhedron | None:
    """The part of a closed polyhedron where normal.x <= d; None when that can't be closed or nothing is left."""
    v, t = solid.vertices, solid.triangles
    s = v @ normal - d
    s[np.abs(s) < 1e-6] = 0.0
    if (s <= 0.0).all():
        return solid
    if (s >= 0.0).all():
        return None
    points = [p for p in v]
    new: dict[tuple[int, int], int] = {}

    def cut(a: int, b: int) -> int:
        key = (a, b) if a < b else (b, a)
        if key not in new:
            k = s[key[0]] / (s[key[0]] - s[key[1]])
            new[key] = len(points)
            points.append(v[key[0]] + k * (v[key[1]] - v[key[0]]))
        return new[key]

    kept: list[tuple[int, int, int]] = []
    following: dict[int, list[int]] = {}
    for tri in t.tolist():
        ring: list[int] = []
        for i in range(3):
            a, b = tri[i], tri[(i + 1) % 3]
            if s[a] <= 0.0:
                ring.append(a)
            if s[a] * s[b] < 0.0:
                ring.append(cut(a, b))
        if len(ring) < 3 or all(i < len(v) and s[i] == 0.0 for i in ring):
            continue
        kept += [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
        on = [i >= len(v) or s[i] == 0.0 for i in ring]
        for i in range(len(ring)):
            j = (i + 1) % len(ring)
            if on[i] and on[j]:
                following.setdefault(ring[j], []).append(ring[i])  # the lid runs the other way
    # Edges in the plane that two kept triangles share run both ways and need no lid.
    for a in list(following):
        for b in list(following[a]):
            if a in following.get(b, []):
                following[a].remove(b)
                following[b].remove(a)
    rings = []
    while any(following.values()):
        start = next(a for a, bs in following.items() if bs)
        ring, here = [], start
        while following.get(here):
            ring.append(here)
            here = following[here].pop()
            if here == start:
                break
        if here != start or len(ring) < 3:
            return None
        rings.append(ring)
    hint = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(hint, normal)
    u /= np.linalg.norm(u)
    w = np.cross(normal, u)
    world = np.array(points)
    lids = [(r, np.column_stack([world[r] @ u, world[r] @ w])) for r in rings]
    outer = [(r, p) for r, p in lids if _area2(p) > 0]
    inner = [(r, p) for r, p in lids if _area2(p) <= 0]
    if not outer or (inner and len(outer) > 1):
        return None
    for r, p in outer:
        rings2 = [p] + ([q for _, q in inner])
        index = np.array(r + [i for q, _ in inner for i in q])
        _, flat = triangulate(rings2)
        kept += [tuple(x) for x in index[flat].tolist()]
    used, index = np.unique(np.array(kept, dtype=np.int64), return_inverse=True)
    made = polyhedra.build(world[used], np.asarray(index).reshape(-1, 3))
    return made if made.closed and made.volume > 1e-3 else None


def _area2(p: np.ndarray) -> float:
    q = np.roll(p, -1, axis=0)
    return float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())
