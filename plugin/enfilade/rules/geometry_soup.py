# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pieces of a polygon soup are: shell, leaf of a door or pane of a window, or something that only stands in a room.

Triangles hang together over edges that exactly two of them share, welded at a millimetre: a frame that fits its hole corner by
corner stays apart from the wall. Each piece is judged by its size alone, in the work frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .building import DOOR, GLASS, OPEN, WINDOW
from .geometry_elements import SHELL, Element
from .geometry_grid import SOLID, Grid, make, runs

WELD = 1e-3  # m
SMALL = 0.6  # m: what is smaller in every direction is a handle, a lamp, a switch
LOW = 1.4  # m: what stands lower, deeper than LOW_THIN, and is no slab is furniture: one sees over it
LOW_THIN = 0.5  # m: what is thinner may be the wall under a window
SLAB_SIDE, SLAB_AREA, SLAB_THICK = 0.8, 1.2, 0.7  # m, m2, m: a floor, a ceiling, a landing is at least that wide and at most that thick
LEAF_THICK = 0.08  # m: upright things thinner than that are leaves, panes, screens: one may see through
DOOR_WIDE, DOOR_HIGH = 2.6, 2.4  # m
STRING_THICK = 0.12  # m: upright things up to that thick that fill little of their rectangle are strings and balustrades
PANEL_THICK = 0.45  # m: a frame with its sill may be as deep as a wall
PANEL = ((0.4, 6.0), (0.4, 3.2))  # m: width and height of what fills a hole in a wall
BAR = 0.12  # m: what is thinner than that in two directions is a baluster, a handrail, a mullion
TALLEST_FLIGHT = 6.0  # m of height that one flight of stairs and its balustrade take at most
MOSTLY = 0.8  # share of a balustrade's faces that are upright, and of its columns that are no higher than LOW
FULL = 0.6  # share of its rectangle that a leaf fills; what fills less is a railing or runs aslant
MASSIVE = 0.6  # share of its box that a piece of wall fills at least
BESIDE = 0.12  # m: leaves that near are sashes of one opening
FRAME = 0.15  # m that a frame reaches beyond its leaf
CLEAR_OF_WALL = 0.6  # m to either side of a leaf: beyond the wall's face
MANY = 400_000  # pieces and more aren't judged one by one: they all count as shell


def pieces(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The piece of each triangle, int (m,), numbered from 0; and whether each piece is closed, bool."""
    keys = np.round(vertices / WELD).astype(np.int64)
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    t = np.asarray(corner).reshape(-1)[triangles]
    count = len(t)
    edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(count), 3)
    key = edges[:, 0].astype(np.int64) * (int(t.max()) + 1 if count else 1) + edges[:, 1]
    order = np.argsort(key, kind="stable")
    key, owner = key[order], owner[order]
    first = np.nonzero(np.concatenate([[True], key[1:] != key[:-1]]))[0] if count else np.zeros(0, dtype=int)
    length = np.diff(np.append(first, len(key)))
    pair = first[length == 2]
    a, b = owner[pair], owner[pair + 1]
    number = _joined(count, a, b)
    many = int(number.max()) + 1 if count else 0
    closed = 2 * np.bincount(number[a], minlength=many) >= 3 * np.bincount(number, minlength=many)
    # What isn't closed by itself (faces between edges of four, as where a step meets its string) belongs to what it shares such edges with.
    inner = np.ones(len(key), dtype=bool)
    inner[first] = False
    at = np.nonzero(inner & np.repeat(length > 2, length))[0]
    left, right = owner[at - 1], owner[at]
    loose = ~closed[number[left]] & ~closed[number[right]]
    number = _joined(count, np.concatenate([a, left[loose]]), np.concatenate([b, right[loose]]))
    many = int(number.max()) + 1 if count else 0
    odd = np.bincount(number[owner], np.repeat(length % 2 == 1, length), many)
    return number, odd == 0


def _joined(count: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Groups of 0..count-1 that the pairs (a, b) hold together, numbered in the order of their first member."""
    label = np.arange(count)  # the smallest member each is known to hang together with
    while True:
        low = np.minimum(label[a], label[b])
        new = label.copy()
        np.minimum.at(new, label[a], low)
        np.minimum.at(new, label[b], low)
        while (further := new[new]).tobytes() != new.tobytes():
            new = further
        if (new == label).all():
            break
        label = new
    _, number = np.unique(label, return_inverse=True)
    return np.asarray(number).reshape(-1)


@dataclass
class Soup:
    """shell: what parts rooms. leaves: upright panels that may fill holes. frames: what may belong to such a leaf (it is in shell too)."""

    shell: list[Element] = field(default_factory=list)
    leaves: list[Element] = field(default_factory=list)
    frames: list[Element] = field(default_factory=list)


def judged(native: Any, element: Element) -> Soup:
    """The pieces of a mesh, without what only stands about."""
    piece, whole = pieces(element.vertices, element.triangles)
    count = int(piece.max()) + 1 if len(piece) else 0
    if count == 0 or count > MANY:
        return Soup([Element(element.name, SHELL, element.vertices, element.triangles, element.source_id)])
    corners = element.vertices[element.triangles]
    order = np.argsort(piece, kind="stable")
    starts = np.searchsorted(piece[order], np.arange(count))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts)
    high = np.maximum.reduceat(corners.max(axis=1)[order], starts)
    size = high - low
    flat = np.sort(size[:, :2], axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = np.abs(cross[:, 2]) < 0.1 * np.linalg.norm(cross, axis=1)
    side = 0.25 * np.bincount(piece, np.where(upright, np.linalg.norm(cross, axis=1), 0.0), count)  # m2, one of two sides
    slab = (flat[:, 0] >= SLAB_SIDE) & (size[:, 0] * size[:, 1] >= SLAB_AREA) & (size[:, 2] <= SLAB_THICK)
    sloped = (size[:, 2] > SLAB_THICK) & (flat[:, 0] >= 2.0) & (size[:, 0] * size[:, 1] >= 6.0)  # a roof, a whole building in one
    small = (size < SMALL).all(axis=1)
    # What is low and thin may carry a window: without it the room under the sill would run out to the outdoors.
    low_thing = (size[:, 2] < LOW) & (flat[:, 0] > LOW_THIN) & ~slab & ~sloped
    # An open sheet may be the face of a wall whose corners meet others': nothing is told from its size.
    upright_sheet = whole & _within(flat[:, 1], PANEL[0]) & _within(size[:, 2], PANEL[1])
    full = side >= FULL * flat[:, 1] * size[:, 2]
    leaf = (flat[:, 0] <= LEAF_THICK) & upright_sheet & full & (flat[:, 1] * size[:, 2] >= 0.3)
    # A leaf in one piece with its frame: as deep as a wall, but no higher than a door, and far from filling its box as a short wall does.
    a, b, c = (corners[:, i] - low[piece] for i in range(3))
    volume = np.abs(np.bincount(piece, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, count))
    hollow = volume < MASSIVE * size.prod(axis=1)
    leaf |= hollow & (flat[:, 0] <= PANEL_THICK) & upright_sheet & full & (size[:, 2] <= DOOR_HIGH) & (flat[:, 1] <= DOOR_WIDE)
    leaf &= flat[:, 1] * size[:, 2] >= 0.3
    sheet = _within(flat[:, 1], PANEL[0]) & _within(size[:, 2], PANEL[1]) & (whole | (flat[:, 0] > 0.01))
    askew = (flat[:, 0] <= STRING_THICK) & sheet & ~full  # a stair's string, a balustrade
    stairs = _stairs(corners, cross, piece, count, size)
    bar = np.sort(size, axis=1)[:, 1] <= BAR
    frame = (flat[:, 0] <= PANEL_THICK) & upright_sheet & ~leaf
    stands = (small | bar | (low_thing & whole) | askew | stairs) & ~leaf
    for n in np.nonzero(~stands & ~leaf & ~slab & (size[:, 2] >= LOW) & (size[:, 2] <= TALLEST_FLIGHT))[0].tolist():
        stands[n] = _climbs(native, corners[order[starts[n] : starts[n + 1] if n + 1 < count else None]])
    result = Soup()
    chosen = ~(stands | leaf)[piece]
    if chosen.any():
        result.shell.append(Element(element.name, SHELL, element.vertices, element.triangles[chosen], element.source_id))

    def part(n: int) -> Element:
        mine = element.triangles[order[starts[n] : starts[n + 1] if n + 1 < count else None]]
        used, index = np.unique(mine, return_inverse=True)
        return Element(f"Leaf {n}", WINDOW, element.vertices[used], np.asarray(index).reshape(-1, 3), element.source_id)

    result.leaves = [part(n) for n in np.nonzero(leaf)[0].tolist()]
    if result.leaves:
        result.frames = [part(n) for n in np.nonzero(frame | ((small | bar) & ~leaf))[0].tolist()]
    return result


def _stairs(corners: np.ndarray, cross: np.ndarray, piece: np.ndarray, count: int, size: np.ndarray) -> np.ndarray:
    """Pieces with treads: at least four level faces at different heights, a step apart, none much larger than the others."""
    tread = (cross[:, 2] > 0.99 * np.linalg.norm(cross, axis=1)) & (np.linalg.norm(cross, axis=1) > 1e-9)
    level = np.round(corners[tread, 0, 2] / 0.02).astype(np.int64)
    owner = piece[tread]
    key, inverse = np.unique(np.column_stack([owner, level]), axis=0, return_inverse=True)
    areas = np.bincount(np.asarray(inverse).reshape(-1), 0.5 * np.linalg.norm(cross[tread], axis=1), len(key))
    steps = np.bincount(key[:, 0], areas > 0.05, count) if len(key) else np.zeros(count)
    largest = np.zeros(count)
    if len(key):
        np.maximum.at(largest, key[:, 0], areas)
    return (steps >= 4) & (size[:, 2] > 0.5) & (size[:, 2] < 6.0) & (largest < 6.0) & (size[:, 2] / np.maximum(steps, 1) < 0.4)


def _climbs(native: Any, corners: np.ndarray) -> bool:
    """Whether a piece (triangles, float64 (n, 3, 3)) rises further than it is high anywhere: a balustrade along stairs. One sees over
    it, where a wall goes all the way down. Told from how high its upright faces stand in each column of voxels."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    upright = np.abs(cross[:, 2]) < 0.1 * size
    if size[upright].sum() < MOSTLY * size.sum():
        return False  # a roof, a flight
    points = corners[upright].reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    part = make(low, high)
    native.voxels.mark(part.blocked, part.origin, part.step, points, np.arange(len(points)).reshape(-1, 3), SOLID)
    tallest = runs(part.blocked == 0)[0].max(axis=0)
    there = tallest > 0
    return bool((tallest[there] * part.step <= LOW + part.step).mean() > MOSTLY)


def settle(native: Any, grid: Grid, soup: Soup) -> list[Element]:
    """Leaves that fill a hole in a wall, together with their frames, as openings; the others are marked as solid."""
    taken: list[tuple[np.ndarray, np.ndarray, list[Element]]] = []
    for leaf in soup.leaves:
        if not _fills(grid, leaf):
            native.voxels.mark(grid.blocked, grid.origin, grid.step, leaf.vertices, leaf.triangles, SOLID)
            continue
        low, high = leaf.vertices.min(axis=0), leaf.vertices.max(axis=0)
        together = [leaf]
        apart = []
        for other in taken:
            if (other[0] <= high + BESIDE).all() and (other[1] >= low - BESIDE).all():
                low, high = np.minimum(low, other[0]), np.maximum(high, other[1])
                together += other[2]
            else:
                apart.append(other)
        taken = [*apart, (low, high, together)]
    boxes = [(f, f.vertices.min(axis=0), f.vertices.max(axis=0)) for f in soup.frames]
    result = []
    for number, (low, high, together) in enumerate(taken):
        thin = int(np.argmin((high - low)[:2]))
        reach = np.full(3, FRAME)
        reach[thin] = PANEL_THICK
        points = [e.vertices for e in together] + [
            f.vertices for f, a, b in boxes if (a >= low - reach).all() and (b <= high + reach).all()
        ]
        flat = np.concatenate(points)
        floor = any(abs(float(flat[:, 2].min()) - z) < 0.3 for z in grid.levels)
        kind = DOOR if floor and np.ptp(flat[:, 2]) > 1.7 else WINDOW
        state = OPEN if kind == DOOR else GLASS
        result.append(Element(f"{kind.title()} {number + 1}", kind, flat, np.zeros((0, 3), dtype=np.int64), "", state))
    return result


def _fills(grid: Grid, leaf: Element) -> bool:
    """Whether something solid lies right above the sheet that is thin across: free at that height on at least one side."""
    low, high = leaf.vertices.min(axis=0), leaf.vertices.max(axis=0)
    thin = int(np.argmin((high - low)[:2]))
    along = 1 - thin
    places = np.linspace(low[along], high[along], 7)[1:-1]
    middle = 0.5 * (low[thin] + high[thin])
    above, beside = 0, [0, 0]
    for place in places:
        for rise in (0.05, 0.15, 0.25):
            point = np.zeros(3)
            point[along], point[thin], point[2] = place, middle, high[2] + rise
            if not _solid(grid, point):
                continue
            above += 1
            for k, sign in enumerate((-1.0, 1.0)):
                point[thin] = middle + sign * CLEAR_OF_WALL
                beside[k] += not _solid(grid, point)
            break
    return above >= 3 and max(beside) >= 3


def _solid(grid: Grid, point: np.ndarray) -> bool:
    index = grid.index(point[None])
    return bool(grid.inside(index)[0]) and bool(grid.blocked[tuple(index[0])] & SOLID)


def _within(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    return (values >= limits[0]) & (values <= limits[1])
