# SPDX-License-Identifier: GPL-3.0-or-later
"""From a mask of voxels in plan to a polygon round it: on the walls' own planes, with few corners, never smaller than the mask.

Polygons are float64 (n, 2), counter-clockwise, in metres of the work frame; a region with holes is one outer loop and its holes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .geometry_grid import dilate

ALONG = 0.9999  # of a normal: what is turned less (0.8 degrees) lies along an axis
NOTCH = 2  # voxels: recesses narrower than twice that are filled, steps up to that deep are straightened (outward)
LONG = 4  # voxels: an edge as long as that lies along a wall and is put on its plane
DEEP = 0.25  # m: a step of the outline that is less deep is cut across (outward): slanted and curved walls become straight pieces
HOLE = 4.0  # m2: a solid core smaller than that counts as air of its room (outward)
BEHIND, BEFORE = 0.40, 0.15  # m behind and before an askew wall that an outline of voxels along it reaches: their diagonal, and DEEP
CORNER = 0.6  # m: a corner farther than that from where it was is no corner of two walls


@dataclass
class WallPlanes:
    """Upright triangles along one axis, sorted by where they stand: position, which way they look, and their box in the plane."""

    position: np.ndarray  # float64 (n,)
    sign: np.ndarray  # float64 (n,), of the normal along the axis
    low: np.ndarray  # float64 (n, 2): along the wall, height
    high: np.ndarray

    @staticmethod
    def of(corners: np.ndarray, normals: np.ndarray, axis: int) -> WallPlanes:
        """corners: float64 (n, 3, 3); normals: unit (n, 3)."""
        chosen = np.abs(normals[:, axis]) > ALONG
        c, sign = corners[chosen], np.sign(normals[chosen, axis])
        position = c[:, :, axis].mean(axis=1)
        across = c[:, :, [1 - axis, 2] if axis < 2 else [0, 1]]
        order = np.argsort(position, kind="stable")
        return WallPlanes(position[order], sign[order], across.min(axis=1)[order], across.max(axis=1)[order])

    def outward(self, start: float, end: float, box_low: np.ndarray, box_high: np.ndarray, outward: float) -> float | None:
        """The plane farthest out between start and end (either order) that overlaps the box; those looking back at the room come first."""
        a, b = min(start, end), max(start, end)
        i, j = np.searchsorted(self.position, [a, b])
        if i >= j:
            return None
        shared = np.minimum(self.high[i:j], box_high) - np.maximum(self.low[i:j], box_low)
        good = (shared > 0.05).all(axis=1)
        if not good.any():
            return None
        facing = good & (self.sign[i:j] * outward < 0.0)
        chosen = self.position[i:j][facing if facing.any() else good]
        return float(chosen.max() if outward > 0.0 else chosen.min())


@dataclass
class AskewWall:
    """An upright plane that runs along neither axis, in plan: the side it looks to, where it stands, and its reach along the wall and in height."""

    normal: np.ndarray  # float64 (2,), unit
    d: float  # normal . (x, y) on it
    low: np.ndarray  # float64 (2,): along (-normal[1], normal[0]), height
    high: np.ndarray

    @staticmethod
    def of(corners: np.ndarray, normals: np.ndarray, least: float) -> list[AskewWall]:
        """Planes with `least` m2 and more, the largest first; then, as seen from behind, those of single sheets. corners: float64 (n, 3, 3);
        normals: unit (n, 3), of upright triangles."""
        if not len(corners):
            return []
        d = np.einsum("ij,ij->i", normals[:, :2], corners[:, :, :2].mean(axis=1))
        key = np.round(np.column_stack([normals[:, :2] * 200.0, d * 100.0])).astype(np.int64)
        _, group = np.unique(key, axis=0, return_inverse=True)
        group = np.asarray(group).reshape(-1)
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        total = np.bincount(group, areas)
        result = []
        for g in np.argsort(-total, kind="stable")[: int((total >= least).sum())].tolist():
            mine = group == g
            normal = np.average(normals[mine, :2], axis=0, weights=areas[mine])
            normal /= np.linalg.norm(normal)
            points = corners[mine].reshape(-1, 3)
            flat = np.column_stack([points[:, :2] @ (-normal[1], normal[0]), points[:, 2]])
            result.append(AskewWall(normal, float((points[:, :2] @ normal).mean()), flat.min(axis=0), flat.max(axis=0)))
        behind = [AskewWall(-w.normal, -w.d, w.high * (-1, 0) + w.low * (0, 1), w.low * (-1, 0) + w.high * (0, 1)) for w in result]
        return result + [b for b in behind if not any(b.covered_by(w) for w in result)]

    def covered_by(self, other: AskewWall) -> bool:
        """Whether another face that looks the same way stands before or behind this one: the other side of a wall that has two."""
        parallel = float(self.normal @ other.normal) > ALONG and abs(self.d - other.d) <= BEHIND + BEFORE
        return parallel and bool((np.minimum(self.high, other.high) > np.maximum(self.low, other.low)).all())


def loops(mask: np.ndarray) -> list[list[tuple[int, int]]]:
    """Boundary loops of a mask (ny, nx) as corners (x, y) in whole voxels, the mask on their left; cells that touch by a corner only are apart."""
    padded = np.pad(mask, 1).astype(np.int8)
    following: dict[tuple[int, int], list[tuple[int, int]]] = {}

    def add(x: np.ndarray, y: np.ndarray, dx0: int, dy0: int, dx1: int, dy1: int) -> None:
        for i, j in zip(x.tolist(), y.tolist(), strict=True):
            following.setdefault((i + dx0, j + dy0), []).append((i + dx1, j + dy1))

    own = padded[1:-1, 1:-1]
    for other, ends in (
        (padded[:-2, 1:-1], (0, 0, 1, 0)),  # below: runs along +x
        (padded[1:-1, 2:], (1, 0, 1, 1)),  # right: +y
        (padded[2:, 1:-1], (1, 1, 0, 1)),  # above: -x
        (padded[1:-1, :-2], (0, 1, 0, 0)),  # left: -y
    ):
        y, x = np.nonzero((own == 1) & (other == 0))
        add(x, y, *ends)
    result = []
    while following:
        start = min(following)
        here, before, loop = start, None, []
        while True:
            choices = following[here]
            if len(choices) == 1 or before is None:
                after = choices.pop(0)
            else:  # two cells touch by this corner: turn left, so that each keeps its own loop
                dx, dy = here[0] - before[0], here[1] - before[1]
                left = (here[0] - dy, here[1] + dx)
                after = left if left in choices else choices[0]
                choices.remove(after)
            if not choices:
                del following[here]
            loop.append(here)
            before, here = here, after
            if here == start:
                break
        result.append(_corners(loop))
    return result


def _corners(loop: list[tuple[int, int]]) -> list[tuple[int, int]]:
    n = len(loop)
    return [
        p for i, p in enumerate(loop)
        if (loop[i - 1][0] - p[0]) * (loop[(i + 1) % n][1] - p[1]) != (loop[i - 1][1] - p[1]) * (loop[(i + 1) % n][0] - p[0])
    ]  # fmt: skip


def closed(native: Any, mask: np.ndarray, forbidden: np.ndarray, steps: int = NOTCH) -> np.ndarray:
    """Recesses filled; nothing forbidden comes in."""
    wide = dilate(native, np.pad(mask, steps + 1), steps)
    narrow = ~dilate(native, ~wide, steps)
    inner = slice(steps + 1, -steps - 1)
    return mask | (narrow[inner, inner] & ~forbidden)


def area(polygon: np.ndarray) -> float:
    following = np.roll(polygon, -1, axis=0)
    return 0.5 * float((polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum())


@dataclass
class Outliner:
    """Turns masks into polygons. forbidden(a, b, c) is asked of triangles that simplifying would add."""

    origin: np.ndarray  # float64 (2,), of the mask's corner (0, 0)
    step: float
    mask: np.ndarray
    forbidden: np.ndarray  # cells that belong to others
    planes: tuple[WallPlanes, WallPlanes]
    askew: list[AskewWall]
    heights: tuple[float, float]

    def polygons(self) -> list[list[np.ndarray]]:
        """One list per connected region: its outer loop, then its holes (clockwise)."""
        found = [(loop, self._polygon(loop)) for loop in loops(self.mask)]
        outer = [[p] for loop, p in found if _loop_area(loop) > 0]
        boxes = [(p[0].min(axis=0), p[0].max(axis=0)) for p in outer]
        for loop, hole in found:
            if _loop_area(loop) < 0:
                middle = hole.mean(axis=0)
                owners = [i for i, (a, b) in enumerate(boxes) if (a <= middle).all() and (middle <= b).all()]
                if owners:
                    best = min(owners, key=lambda i: float(np.prod(boxes[i][1] - boxes[i][0])))
                    outer[best].append(hole)
        return outer

    def _polygon(self, loop: list[tuple[int, int]]) -> np.ndarray:
        straight = self._straightened(loop)
        for candidate in (self._snapped(straight), self._snapped(loop), None):
            if candidate is None:
                polygon = self.origin + np.array(loop, dtype=np.float64) * self.step
            else:
                polygon = _tidy(candidate)
                if len(polygon) < 3 or area(polygon) * _loop_area(loop) <= 0.0 or not is_simple(polygon):
                    continue
            return self._on_askew_walls(self._simplified(polygon))
        raise AssertionError("unreachable")

    def _straightened(self, loop: list[tuple[int, int]]) -> list[tuple[int, int]]:
        """Steps up to NOTCH deep between two long edges that run the same way are moved outward onto one line."""
        points = list(loop)
        changed = True
        while changed and len(points) > 4:
            changed = False
            n = len(points)
            for i in range(n):
                p0, p1, p2, p3 = (points[(i + k) % n] for k in range(4))
                d0, d1, d2 = _minus(p1, p0), _minus(p2, p1), _minus(p3, p2)
                depth = abs(d1[0]) + abs(d1[1])
                if depth > NOTCH or d0[0] * d2[0] + d0[1] * d2[1] <= 0:
                    continue
                length0, length2 = abs(d0[0]) + abs(d0[1]), abs(d2[0]) + abs(d2[1])
                if min(length0, length2) < LONG:
                    continue
                # Outward is to the right of the direction of travel: a step to the right moves the first edge, one to the left the second.
                right = d0[0] * d1[1] - d0[1] * d1[0] < 0
                moved = p0 if right else p3
                target = (moved[0] + d1[0], moved[1] + d1[1]) if right else (moved[0] - d1[0], moved[1] - d1[1])
                box = (p0, p2) if right else (p1, p3)
                if self._touches(box):
                    continue
                if right:
                    points[i] = target
                    drop = sorted(((i + 1) % n, (i + 2) % n), reverse=True)
                else:
                    points[(i + 3) % n] = target
                    drop = sorted(((i + 1) % n, (i + 2) % n), reverse=True)
                for k in drop:
                    del points[k]
                points = _corners(points)
                changed = True
                break
        return points

    def _touches(self, box: tuple[tuple[int, int], tuple[int, int]]) -> bool:
        (xa, ya), (xb, yb) = box
        return bool(self.forbidden[min(ya, yb) : max(ya, yb), min(xa, xb) : max(xa, xb)].any())

    def _snapped(self, loop: list[tuple[int, int]]) -> np.ndarray:
        """Each edge moved outward onto the wall plane in the next voxel, or over that voxel; contacts with other rooms stay where they are."""
        n = len(loop)
        lines = []
        for i in range(n):
            (xa, ya), (xb, yb) = loop[i], loop[(i + 1) % n]
            axis = 0 if xa == xb else 1  # the coordinate that is fixed
            at = xa if axis == 0 else ya
            first, last = (min(ya, yb), max(ya, yb)) if axis == 0 else (min(xa, xb), max(xa, xb))
            outward = 1 if (yb > ya if axis == 0 else xb < xa) else -1
            beyond = at if outward > 0 else at - 1
            limit = self.forbidden.shape[1 - axis]
            contact = 0
            if 0 <= beyond < limit:
                cells = self.forbidden[first:last, beyond] if axis == 0 else self.forbidden[beyond, first:last]
                contact = int(cells.sum())
            here = float(self.origin[axis]) + at * self.step
            if contact * 2 > last - first:
                lines.append((axis, here))
                continue
            along = float(self.origin[1 - axis])
            low = np.array([along + first * self.step, self.heights[0]])
            high = np.array([along + last * self.step, self.heights[1]])
            plane = None
            if last - first >= LONG:
                plane = self.planes[axis].outward(here - 0.02 * outward, here + outward * (self.step + 0.02), low, high, outward)
            if plane is None:
                plane = here + outward * self.step * (1.0 if not contact else 0.0)
            lines.append((axis, plane))
        points = []
        for i in range(n):
            (axis, at), (_, before) = lines[i], lines[i - 1]
            points.append((at, before) if axis == 0 else (before, at))
        return np.array(points)

    def _simplified(self, polygon: np.ndarray) -> np.ndarray:
        """Reflex corners less deep than DEEP are cut across where nothing forbidden comes in by it."""
        points = [tuple(p) for p in polygon.tolist()]
        while len(points) > 4:
            n = len(points)
            best = None
            for i in range(n):
                a, b, c = points[i - 1], points[i], points[(i + 1) % n]
                cross = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
                if cross >= -1e-12:
                    continue
                base = np.hypot(c[0] - a[0], c[1] - a[1])
                depth = -cross / base if base > 0.0 else np.inf
                if depth > DEEP or (best is not None and -cross >= best[0]):
                    continue
                if self._forbids(a, b, c) or _holds_corner(points, i):
                    continue
                best = (-cross, i)
            if best is None:
                break
            del points[best[1]]
        return _tidy(np.array(points))

    def _on_askew_walls(self, polygon: np.ndarray) -> np.ndarray:
        """What runs along a wall that is askew to the grid is put on its plane, or rooms would reach through thin walls into each other."""
        y, x = np.nonzero(self.mask)
        cells = self.origin + (np.column_stack([x, y]) + 0.5) * self.step
        low, high = polygon.min(axis=0) - BEHIND, polygon.max(axis=0) + BEHIND
        box = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])
        for wall in self.askew:
            off = box @ wall.normal - wall.d
            if wall.high[1] <= self.heights[0] or wall.low[1] >= self.heights[1] or off.min() > 0.0 or off.max() < 0.0:
                continue
            moved = self._onto(polygon, wall, cells)
            if moved is not None:
                polygon = moved
        return polygon

    def _onto(self, polygon: np.ndarray, wall: AskewWall, cells: np.ndarray) -> np.ndarray | None:
        """The polygon with its longest stretch along the wall replaced by the wall's line; None when none runs there, or a cell would be lost."""
        tangent = np.array([-wall.normal[1], wall.normal[0]])
        off, along = polygon @ wall.normal - wall.d, polygon @ tangent
        near = (off >= -BEHIND) & (off <= BEFORE) & (along >= wall.low[0] - BEHIND) & (along <= wall.high[0] + BEHIND)
        n = len(polygon)
        starts = [i for i in range(n) if near[i] and not near[i - 1]]
        best = None
        for i in starts:
            j = i
            while near[(j + 1) % n]:
                j += 1
            # The room is on the left of the outline, and on the side the wall looks to: the outline runs against the tangent.
            length = along[i] - along[j % n]
            if length >= LONG * self.step and (best is None or length > best[0]):
                best = (length, i, j)
        if best is None:
            return None
        _, i, j = best
        first = _met(polygon[i - 1], polygon[i], wall)
        last = _met(polygon[(j + 1) % n], polygon[j % n], wall)
        kept = [polygon[k % n] for k in range(j + 1, i + n)]
        result = _tidy(np.array([first, last, *kept]))
        if len(result) < 3 or area(result) * area(polygon) <= 0.0 or not is_simple(result):
            return None
        s = cells @ tangent
        mine = (s <= first @ tangent) & (s >= last @ tangent)
        depth = cells[mine] @ wall.normal - wall.d
        return None if ((depth < -0.5 * self.step) & (depth > -BEHIND)).any() else result

    def _forbids(self, a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
        t = (np.array([a, b, c]) - self.origin) / self.step
        low = np.maximum(np.floor(t.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(t.max(axis=0)).astype(int), self.forbidden.shape[::-1])
        if (high <= low).any():
            return False
        part = self.forbidden[low[1] : high[1], low[0] : high[0]]
        if not part.any():
            return False
        y, x = np.nonzero(part)
        p = np.column_stack([x + low[0] + 0.5, y + low[1] + 0.5])
        inside = np.ones(len(p), dtype=bool)
        if _cross2(t[0], t[1], t[2]) < 0:
            t = t[::-1]
        for i in range(3):
            u, v = t[i - 1], t[i]
            inside &= (v[0] - u[0]) * (p[:, 1] - u[1]) - (v[1] - u[1]) * (p[:, 0] - u[0]) > -0.35 * np.hypot(*(v - u))
        return bool(inside.any())


def _met(before: np.ndarray, corner: np.ndarray, wall: AskewWall) -> np.ndarray:
    """Where the edge that comes from `before` to `corner` meets the wall's plane; the point of the plane nearest to the corner when that is far off."""
    step = corner - before
    k = float(step @ wall.normal)
    off = float(corner @ wall.normal) - wall.d
    if abs(k) * CORNER > abs(off) * float(np.hypot(*step)):
        return corner - step * (off / k)
    return corner - wall.normal * off


def _minus(a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    return a[0] - b[0], a[1] - b[1]


def _loop_area(loop: list[tuple[int, int]]) -> float:
    return 0.5 * sum(loop[i - 1][0] * loop[i][1] - loop[i][0] * loop[i - 1][1] for i in range(len(loop)))


def _cross2(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _holds_corner(points: list[tuple[float, float]], i: int) -> bool:
    """Whether another corner lies in or on the triangle at corner i."""
    n = len(points)
    p = np.array(points)
    a, b, c = p[i - 1], p[i], p[(i + 1) % n]
    others = np.delete(p, [(i - 1) % n, i, (i + 1) % n], axis=0)
    s = [
        (v[0] - u[0]) * (others[:, 1] - u[1]) - (v[1] - u[1]) * (others[:, 0] - u[0]) for u, v in ((a, c), (c, b), (b, a))
    ]
    return bool(((s[0] >= -1e-9) & (s[1] >= -1e-9) & (s[2] >= -1e-9)).any())


def _tidy(polygon: np.ndarray) -> np.ndarray:
    """Without doubled and collinear corners (below 0.1 mm)."""
    points = [tuple(p) for p in polygon.tolist()]
    changed = True
    while changed and len(points) > 3:
        changed = False
        for i in range(len(points)):
            a, b, c = points[i - 1], points[i], points[(i + 1) % len(points)]
            base = np.hypot(c[0] - a[0], c[1] - a[1])
            cross = abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            if np.hypot(b[0] - a[0], b[1] - a[1]) < 1e-4 or (base < 1e-4) or cross < 1e-4 * base:
                del points[i]
                changed = True
                break
    return np.array(points)


def is_simple(polygon: np.ndarray) -> bool:
    """Whether no two edges that aren't neighbours meet."""
    n = len(polygon)
    a, b = polygon, np.roll(polygon, -1, axis=0)

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    s1, s2 = side(a[:, None], b[:, None], a[None]), side(a[:, None], b[:, None], b[None])
    crossing = (s1 * s2 <= 0.0) & (s1 * s2 <= 0.0).T
    # Collinear pairs count only where they overlap.
    low, high = np.minimum(a, b), np.maximum(a, b)
    near = ((low[:, None] <= high[None] + 1e-9) & (high[:, None] >= low[None] - 1e-9)).all(axis=2)
    crossing &= near
    i = np.arange(n)
    crossing[i, i] = False
    crossing[i, (i + 1) % n] = False
    crossing[(i + 1) % n, i] = False
    return not bool(crossing.any())


def triangulate(rings: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 2) and triangles (m, 3), counter-clockwise, of an outer loop with holes: holes bridged to the outline (Held 2001, simplified),
    then ears cut. Corners keep their order: the rings one after another."""
    points = np.concatenate(rings)
    first = np.cumsum([0] + [len(r) for r in rings])
    outline = list(range(len(rings[0])))
    holes = sorted(range(1, len(rings)), key=lambda k: -float(rings[k][:, 0].max()))
    for k in holes:
        ring = list(range(int(first[k]), int(first[k + 1])))
        start = max(ring, key=lambda i: points[i, 0])
        ring = ring[ring.index(start) :] + ring[: ring.index(start)]
        best = min(
            (v for v in range(len(outline)) if _sees(points, outline, start, outline[v])),
            key=lambda v: float(((points[outline[v]] - points[start]) ** 2).sum()),
            default=None,
        )
        if best is None:
            best = min(range(len(outline)), key=lambda v: float(((points[outline[v]] - points[start]) ** 2).sum()))
        outline = outline[: best + 1] + ring + [start] + outline[best:]
    triangles = []
    stuck = 0
    i = 0
    while len(outline) > 3 and stuck < len(outline):
        n = len(outline)
        ia, ib, ic = outline[(i - 1) % n], outline[i % n], outline[(i + 1) % n]
        a, b, c = points[ia], points[ib], points[ic]
        cross = _cross2(a, b, c)
        others = [v for v in outline if v not in (ia, ib, ic)]
        ear = cross > 1e-12
        if ear and others:
            p = points[others]
            same = (np.abs(p[:, None] - np.array([a, b, c])).max(axis=2) < 1e-9).any(axis=1)
            s0 = (b[0] - a[0]) * (p[:, 1] - a[1]) - (b[1] - a[1]) * (p[:, 0] - a[0])
            s1 = (c[0] - b[0]) * (p[:, 1] - b[1]) - (c[1] - b[1]) * (p[:, 0] - b[0])
            s2 = (a[0] - c[0]) * (p[:, 1] - c[1]) - (a[1] - c[1]) * (p[:, 0] - c[0])
            ear = not bool(((s0 >= -1e-12) & (s1 >= -1e-12) & (s2 >= -1e-12) & ~same).any())
        if ear:
            triangles.append((ia, ib, ic))
            del outline[i % n]
            stuck = 0
            i = (i - 1) % len(outline)
        else:
            i = (i + 1) % n
            stuck += 1
    if len(outline) == 3:
        triangles.append(tuple(outline))
    return points, np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _sees(points: np.ndarray, outline: list[int], start: int, target: int) -> bool:
    """Whether the bridge from start to target crosses no edge of the outline so far."""
    p, q = points[start], points[target]
    if q[0] < p[0] - 1e-9:
        return False
    for i in range(len(outline)):
        a, b = outline[i - 1], outline[i]
        if target in (a, b):
            continue
        u, v = points[a], points[b]
        if _cross2(p, q, u) * _cross2(p, q, v) <= 0.0 and _cross2(u, v, p) * _cross2(u, v, q) <= 0.0:
            return False
    return True
