# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pieces of a polygon soup are: shell, leaf of a door or pane of a window, or something that only stands in a room.

Triangles hang together over edges that exactly two of them share, welded at a millimetre: a frame that fits its hole corner by
corner stays apart from the wall. Each piece is judged by its size alone, in the work frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .box_index import BoxIndex
from .building import DOOR, GLASS, OPEN, WINDOW
from .geometry_elements import SHELL, Element
from .geometry_grid import SOLID, Grid, make, mark
from .geometry_pace import NOBODY, Progress

WELD = 1e-3  # m
SAME_ANGLE = 2e-3  # radians: faces round an edge that near each other lie on each other
SMALL = 0.6  # m: what is smaller in every direction is a handle, a lamp, a switch
LOW = 1.4  # m: what stands lower, deeper than LOW_THIN, and is no slab is furniture: one sees over it
LOW_THIN = 0.5  # m: what is thinner may be the wall under a window
SLAB_SIDE, SLAB_AREA, SLAB_THICK = 0.8, 1.2, 0.7  # m, m2, m: a floor, a ceiling, a landing is at least that wide and at most that thick
LEAF_THICK = 0.08  # m: upright things thinner than that are leaves, panes, screens: one may see through
DOOR_WIDE, DOOR_HIGH, HIGHEST_PLUG = 2.6, 2.4, 2.6  # m
STRING_THICK = 0.12  # m: upright things up to that thick that fill little of their rectangle may be frames and balustrades
BROADEST_BAR = 0.15  # m: twice the face of a frame over its outline; a thin wall with a door has 0.2 and more
PANEL_THICK = 0.45  # m: a frame with its sill may be as deep as a wall
PANEL = ((0.2, 6.0), (0.2, 3.2))  # m: width and height of what fills a hole in a wall, one pane of many it may be
LEAST_PANE = 0.1  # m2
AIR_OVER = 0.5  # share of a deep piece's columns with air, and a ceiling, over them: more than a frame's under its lintel
HANGS, FILLS, WALL = "hangs", "fills", "wall"
STEPS = 4  # heights that make a flight of stairs
STEP_RISE, STEP_THICK, LANDING_AREA = (0.08, 0.28), 0.3, 6.0  # m, m, m2: from one step to the next; boards and landings
BAR = 0.12  # m: what is thinner than that in two directions is a baluster, a handrail, a mullion
TALLEST_FLIGHT = 6.0  # m of height that one flight of stairs and its balustrade take at most
MOSTLY = 0.8  # share of a balustrade's columns that are no higher than LOW
FULL = 0.6  # share of its rectangle that a leaf fills; what fills less is a railing or runs aslant
ROOF = 0.5  # share of a roof's faces that slope
MASSIVE = 0.6  # share of its box that a piece of wall fills at least
WIDEST_OPENING = 4.0  # m: an object named for a door that is wider may hold several
BESIDE = 0.12  # m: leaves that near are sashes of one opening
FRAME = 0.15  # m that a frame reaches beyond its leaf
SASHES = 1.2  # m: and that far at most where it holds other sashes too
NEAR_FRAME = 0.03  # m between what touches
DOOR_LEAF = 0.06  # m: what is as high as its room, between jambs, is a leaf up to that thick, and a wall beyond
NEAR_SOLID = (0.05, 0.15, 0.25)  # m from a leaf or its frame: lintel and jambs begin there
BEHIND = (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)  # m to either side of a leaf where its wall would be if there were no hole
IN_WALL = 0.1  # m: a leaf flush with one face of its wall has the wall's middle that far to a side
CLEAR_OF_WALL = 0.6  # m to either side of a leaf: beyond the wall's face
MANY = 400_000  # pieces and more aren't judged one by one: they all count as shell


def pieces(vertices: np.ndarray, triangles: np.ndarray, watch: Progress = NOBODY) -> tuple[np.ndarray, np.ndarray]:
    """The piece of each triangle, int (m,), numbered from 0; and whether each piece is closed, bool."""
    count = len(triangles)
    if not count:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    place, corner = _welded(vertices)
    points = vertices[place]
    watch.at(0.1)
    turned = _outward(vertices, triangles, watch)
    watch.at(0.2)
    half, owner, key = _by_edge(corner[turned])
    watch.at(0.25)
    first, length = _equal_runs(key)
    pair = first[length == 2]
    shared = np.nonzero(np.repeat(length > 2, length))[0]
    left, right = _round_edges(points, half[shared], key[shared])
    a = owner[np.concatenate([pair, shared[left]])]
    b = owner[np.concatenate([pair + 1, shared[right]])]
    watch.at(0.3)
    number = _joined(count, a, b)
    watch.at(0.35)
    groups = int(number.max()) + 1
    closed = 2 * np.bincount(number[a], minlength=groups) >= 3 * np.bincount(number, minlength=groups)
    # What isn't closed by itself (faces turned this way and that) belongs to what it shares edges of more than two with.
    at = shared[1:][key[shared[1:]] == key[shared[:-1]]]
    before, after = owner[at - 1], owner[at]
    loose = ~closed[number[before]] & ~closed[number[after]]
    number = _joined(count, np.concatenate([a, before[loose]]), np.concatenate([b, after[loose]]))
    groups = int(number.max()) + 1
    odd = np.bincount(number[owner], np.repeat(length % 2 == 1, length), groups)
    return number, odd == 0


def _welded(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A vertex of each place, places told apart by WELD, and the place of each vertex."""
    key = np.round(vertices / WELD).astype(np.int64)
    key -= key.min(axis=0)
    size = [int(n) + 1 for n in key.max(axis=0)]
    if size[0] * size[1] * size[2] < 1 << 62:  # one number sorts ten times faster than three; true within 1,600 km
        key = (key[:, 0] * size[1] + key[:, 1]) * size[2] + key[:, 2]
        _, place, corner = np.unique(key, return_index=True, return_inverse=True)
    else:
        _, place, corner = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return place, np.asarray(corner).reshape(-1)


def _outward(vertices: np.ndarray, triangles: np.ndarray, watch: Progress) -> np.ndarray:
    """The triangles, those of closed solids drawn inside out turned round. A solid is what hangs together by the corners as they were given: those
    of solids that only touch are their own."""
    half, owner, key = _by_edge(triangles)
    watch.at(0.13)
    first, length = _equal_runs(key)
    pair = first[length == 2]
    pair = pair[half[pair, 0] != half[pair + 1, 0]]  # both sides of the edge agree which way is out
    solid = _joined(len(triangles), owner[pair], owner[pair + 1])
    watch.at(0.17)
    whole = 2 * np.bincount(solid[owner[pair]], minlength=solid.max() + 1) == 3 * np.bincount(solid)
    a, b, c = (vertices[triangles[:, i]] - vertices[triangles[0, 0]] for i in range(3))
    volume = np.bincount(solid, np.einsum("ij,ij->i", a, np.cross(b, c)))
    turned = (whole & (volume < 0.0))[solid]
    return np.where(turned[:, None], triangles[:, ::-1], triangles)


def _by_edge(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each triangle from each of its edges, sorted by edge: start, end and third corner, int64 (3 m, 3); the triangle; and the edge, a number
    that is the same from both ends."""
    half = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]]).astype(np.int64)
    key = half[:, :2].min(axis=1) * (half.max() + 1) + half[:, :2].max(axis=1)
    order = np.argsort(key, kind="stable")
    return half[order], order % len(triangles), key[order]


def _equal_runs(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where each run of equal values begins in a sorted array, and how long it is."""
    first = np.nonzero(np.concatenate([[True], key[1:] != key[:-1]]))[0]
    return first, np.diff(np.append(first, len(key)))


def _round_edges(points: np.ndarray, half: np.ndarray, key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of triangles that have matter between them, going round an edge that more than two share: a door whose corners are the
    wall's is no part of the wall. half: start, end, third corner, sorted by edge (key); gives indices into it. Edges round which
    triangles don't open and close matter by turns (turned wrongly, or one solid in another) give none.
    """
    if not len(half):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    closes = half[:, 0] < half[:, 1]  # outward on the left of the edge as all see it: matter lies before it, counting angles upward
    p, q = points[half[:, :2].min(axis=1)], points[half[:, :2].max(axis=1)]
    axis = (q - p) / np.maximum(np.linalg.norm(q - p, axis=1), 1e-12)[:, None]
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
    v = np.cross(axis, u)
    out = points[half[:, 2]] - p
    angle = np.round(np.arctan2(np.einsum("ij,ij->i", out, v), np.einsum("ij,ij->i", out, u)) / SAME_ANGLE).astype(np.int64)
    angle %= int(round(2.0 * np.pi / SAME_ANGLE))
    order = np.lexsort((~closes, angle, key))  # where solids touch by a face, the one closes before the other opens
    key, closes = key[order], closes[order]
    first, length = _equal_runs(key)
    after = np.arange(len(key)) + 1
    after[first + length - 1] = first
    fine = np.logical_and.reduceat(closes != closes[after], first)
    opens = np.nonzero(~closes & np.repeat(fine, length))[0]
    return order[opens], order[after[opens]]


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


def parts_of(e: Element) -> list[Element]:
    """An object that holds many doors or windows in one mesh as one element each: pieces that lie near each other belong together. What is
    no larger than one opening stays as it is; of the others signs and handles are left out."""
    if not len(e.triangles) or np.ptp(e.vertices[:, :2], axis=0).max() <= WIDEST_OPENING:
        return [e]
    piece, _ = pieces(e.vertices, e.triangles)
    _, _, low, high = _by_piece(e.vertices[e.triangles], piece)
    group = _beside(low, high)[piece]
    result = []
    for g in range(int(group.max()) + 1):
        used, index = np.unique(e.triangles[group == g], return_inverse=True)
        one = replace(e, name=f"{e.name} {g + 1}", vertices=e.vertices[used], triangles=np.asarray(index).reshape(-1, 3))
        if (np.ptp(one.vertices, axis=0) >= SMALL).any():
            result.append(one)
    return result


def _by_piece(corners: np.ndarray, piece: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Triangles (m, 3, 3) sorted by piece: their order, where in it each piece begins (and the last ends), and the pieces' low and high corners."""
    order = np.argsort(piece, kind="stable")
    starts = np.searchsorted(piece[order], np.arange(int(piece.max()) + 2))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts[:-1])
    high = np.maximum.reduceat(corners.max(axis=1)[order], starts[:-1])
    return order, starts, low, high


def _beside(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Groups of boxes (n, 3) that hang together by lying within BESIDE of one another."""
    index = BoxIndex(low, high)
    pairs = [(a, b) for a in range(len(low)) for b in index.near(low[a] - BESIDE, high[a] + BESIDE).tolist()]
    return _joined(len(low), *np.array(pairs).T)


@dataclass
class Soup:
    """shell: what parts rooms. leaves: upright panels that may fill holes. frames: what may belong to such a leaf (it is in shell too).
    tall: what is as high as a door and deep: it parts rooms unless there is air over it. plugs: solid boxes of a door's or window's size,
    as thick as walls: openings where a wall is all round them."""

    shell: list[Element] = field(default_factory=list)
    leaves: list[Element] = field(default_factory=list)
    frames: list[Element] = field(default_factory=list)
    tall: list[Element] = field(default_factory=list)
    plugs: list[Element] = field(default_factory=list)


def judged(native: Any, element: Element, watch: Progress) -> Soup:
    """The pieces of a mesh, without what only stands about."""
    piece, whole = pieces(element.vertices, element.triangles, watch)
    watch.at(0.4)
    count = int(piece.max()) + 1 if len(piece) else 0
    if count == 0 or count > MANY:
        return Soup([Element(element.name, SHELL, element.vertices, element.triangles, element.source_id)])
    corners = element.vertices[element.triangles]
    order, starts, low, high = _by_piece(corners, piece)
    size = high - low
    flat = np.sort(size[:, :2], axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = np.abs(cross[:, 2]) < 0.1 * np.linalg.norm(cross, axis=1)
    side = 0.25 * np.bincount(piece, np.where(upright, np.linalg.norm(cross, axis=1), 0.0), count)  # m2, one of two sides
    slab = (flat[:, 0] >= SLAB_SIDE) & (size[:, 0] * size[:, 1] >= SLAB_AREA) & (size[:, 2] <= SLAB_THICK)
    sloped = (size[:, 2] > SLAB_THICK) & (flat[:, 0] >= 2.0) & (size[:, 0] * size[:, 1] >= 6.0)  # a roof, a whole building in one
    small = (size < SMALL).all(axis=1)
    bar = np.sort(size, axis=1)[:, 1] <= BAR
    # What is low and thin may carry a window: without it the room under the sill would run out to the outdoors.
    low_thing = (size[:, 2] < LOW) & (flat[:, 0] > LOW_THIN) & ~slab & ~sloped
    # An open sheet may be the face of a wall whose corners meet others': nothing is told from its size.
    upright_sheet = whole & _within(flat[:, 1], PANEL[0]) & _within(size[:, 2], PANEL[1])
    full = side >= FULL * flat[:, 1] * size[:, 2]
    leaf = (flat[:, 0] <= LEAF_THICK) & upright_sheet & full & ~bar
    # A leaf in one piece with its frame: as deep as a wall, but no higher than a door, and far from filling its box as a short wall does.
    a, b, c = (corners[:, i] - low[piece] for i in range(3))
    volume = np.abs(np.bincount(piece, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, count))
    hollow = volume < MASSIVE * size.prod(axis=1)
    leaf |= hollow & (flat[:, 0] <= PANEL_THICK) & upright_sheet & full & (size[:, 2] <= DOOR_HIGH) & (flat[:, 1] <= DOOR_WIDE)
    leaf &= flat[:, 1] * size[:, 2] >= LEAST_PANE
    sheet = _within(flat[:, 1], PANEL[0]) & _within(size[:, 2], PANEL[1]) & (whole | (flat[:, 0] > 0.01))
    # Frames and handrails are bars all along; a thin wall with a door in it has a lintel, or a pier, that is broader.
    areas = 0.5 * np.linalg.norm(cross, axis=1)
    facing = np.abs(cross[np.arange(len(cross)), np.argmin(size[:, :2], axis=1)[piece]]) > 1.9 * areas
    face, total = 0.5 * np.bincount(piece, np.where(facing, areas, 0.0), count), np.bincount(piece, areas, count)
    slender = 2.0 * face * flat[:, 0] <= BROADEST_BAR * (total - 2.0 * face)
    askew = (flat[:, 0] <= STRING_THICK) & sheet & ~full & (slender | (size[:, 2] < LOW))
    stairs = _stairs(corners, cross, piece, count, size) | _loose_steps(low, high)
    frame = (flat[:, 0] <= PANEL_THICK) & upright_sheet & ~leaf
    stands = (small | bar | (low_thing & whole) | askew | stairs) & ~leaf
    for n in watch.over(np.nonzero(~stands & ~leaf & ~slab & (size[:, 2] >= LOW) & (size[:, 2] <= TALLEST_FLIGHT))[0].tolist(), 0.5, 0.9):
        stands[n] = _climbs(native, corners[order[starts[n] : starts[n + 1]]])
    rise = np.abs(cross[:, 2]) / np.maximum(2.0 * areas, 1e-12)
    roof = sloped & (np.bincount(piece, np.where((rise > 0.1) & (rise < 0.99), areas, 0.0), count) >= ROOF * total)
    tall = whole & (size[:, 2] >= LOW) & (size[:, 2] <= DOOR_HIGH) & (flat[:, 0] > LOW_THIN) & ~slab & ~stands & ~leaf & ~roof
    plug = whole & ~hollow & (flat[:, 0] <= PANEL_THICK) & (flat[:, 0] > LEAF_THICK) & _within(flat[:, 1], (SMALL, DOOR_WIDE)) & _within(
        size[:, 2], (SMALL, HIGHEST_PLUG)
    ) & ~stands & ~leaf & ~tall  # fmt: skip
    walls = 4.0 * side >= total  # at least half of it upright
    index = BoxIndex(low, high)
    for n in watch.over(np.nonzero(plug)[0].tolist(), 0.9):  # a wall reaches round the hole in it; a piece of wall between others has none round it
        near = index.near(low[n], high[n])
        plug[n] = (walls[near] & ((low[near] <= low[n] + 0.02) & (high[near] >= high[n] - 0.02)).all(axis=1)).sum() > 1
    result = Soup()
    chosen = ~(stands | leaf | tall | plug)[piece]
    if chosen.any():
        result.shell.append(Element(element.name, SHELL, element.vertices, element.triangles[chosen], element.source_id))

    def part(n: int) -> Element:
        mine = element.triangles[order[starts[n] : starts[n + 1]]]
        used, index = np.unique(mine, return_inverse=True)
        return Element(f"Leaf {n}", WINDOW, element.vertices[used], np.asarray(index).reshape(-1, 3), element.source_id)

    result.plugs = [part(n) for n in np.nonzero(plug)[0].tolist()]
    result.tall = [part(n) for n in np.nonzero(tall)[0].tolist()]
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


def _loose_steps(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Pieces that are steps and landings one by one: boards each a step above the next, STEPS of them at least."""
    size = high - low
    board = np.nonzero((size[:, 2] <= STEP_THICK) & (size[:, :2].min(axis=1) >= 0.15) & (size[:, 0] * size[:, 1] <= LANDING_AREA))[0]
    result = np.zeros(len(low), dtype=bool)
    if len(board) < STEPS:
        return result
    board = board[np.argsort(high[board, 2], kind="stable")]
    top = high[board, 2]
    pairs = []
    for i, end in enumerate(np.searchsorted(top, top + STEP_RISE[1]).tolist()):
        other = np.arange(np.searchsorted(top, top[i] + STEP_RISE[0]), end)
        mine = board[i]
        near = (low[board[other], :2] <= high[mine, :2] + 0.1) & (high[board[other], :2] >= low[mine, :2] - 0.1)
        pairs += [(i, j) for j in other[near.all(axis=1)].tolist()]
    if not pairs:
        return result
    a, b = np.array(pairs).T
    flight = _joined(len(board), a, b)
    levels = np.unique(np.column_stack([flight, np.round(top / STEP_RISE[0]).astype(np.int64)]), axis=0)
    result[board[np.bincount(levels[:, 0], minlength=len(board))[flight] >= STEPS]] = True
    return result


def _climbs(native: Any, corners: np.ndarray) -> bool:
    """Whether a piece (triangles, float64 (n, 3, 3)) rises further than it is high anywhere: a balustrade along stairs, their string. One sees
    over it, where a wall goes all the way down, or ends at one height over a door. Told from its upright faces in each column of voxels."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    upright = np.abs(cross[:, 2]) < 0.1 * size
    if size[upright].sum() < 0.5 * size.sum():
        return False  # a roof, a flight
    points = corners[upright].reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    part = make(low, high)
    native.voxels.mark(part.blocked, part.origin, part.step, points, np.arange(len(points)).reshape(-1, 3), SOLID)
    tallest = native.voxels.runs((part.blocked == 0).astype(np.uint8))[0].max(axis=0)
    there = tallest > 0
    drop = (part.blocked[::-1] > 0).argmax(axis=0)[there] * part.step  # of the top of each column, m
    level = (drop - drop.min() <= 2 * part.step).mean() > 0.5
    return not level and bool((tallest[there] * part.step <= LOW + part.step).mean() > MOSTLY)


def settle(native: Any, grid: Grid, soup: Soup, watch: Progress) -> list[Element]:
    """Leaves that fill a hole in a wall, together with their frames, as openings; the others are marked as solid, and what is tall too."""
    for e in watch.over(soup.tall, 0.0, 0.1):
        if not _stands_free(native, grid, e):
            mark(native, grid, [(e.vertices, e.triangles)], SOLID)
    result: list[Element] = []
    for e in watch.over(soup.plugs, 0.1, 0.2):
        low, high = e.vertices.min(axis=0), e.vertices.max(axis=0)
        thin = int(np.argmin((high - low)[:2]))
        probe = _Probe(grid, thin, 0.5 * (low[thin] + high[thin]))
        if _place(grid, low, high, thin, np.inf, low, high) == FILLS and _between_jambs(probe, low, high):
            result.append(_opening(e.vertices, grid, len(result)))
        else:
            mark(native, grid, [(e.vertices, e.triangles)], SOLID)
    frames = BoxIndex(*_bounds(soup.frames))
    for leaves, low, high in watch.over(_together(soup.leaves, frames), 0.3, 0.5):
        thin = int(np.argmin((high - low)[:2]))
        reach = np.full(3, FRAME)
        reach[thin] = PANEL_THICK
        near = frames.near(low - reach, high + reach)
        framing = ((frames.low[near] >= low - reach) & (frames.high[near] <= high + reach)).all(axis=1)
        around = [soup.frames[k].vertices for k in near[framing].tolist()]
        flat = np.concatenate([*(e.vertices for e in leaves), *around, [low, high]])
        thickest = max(float(np.ptp(e.vertices[:, thin])) for e in leaves)
        what = _place(grid, low, high, thin, thickest, flat.min(axis=0), flat.max(axis=0))
        if what == WALL:
            mark(native, grid, [(e.vertices, e.triangles) for e in leaves], SOLID)
        if what != FILLS:
            continue
        result.append(_opening(flat, grid, len(result)))
    return result


def _together(leaves: Sequence[Element], frames: BoxIndex) -> list[tuple[list[Element], np.ndarray, np.ndarray]]:
    """Leaves that are sashes of one opening, beside each other or within one frame: the leaves, and the bounds of the frames round them."""
    if not leaves:
        return []
    wide = np.array([_framed(a, b, frames) for a, b in zip(*_bounds(leaves), strict=True)])
    low, high = wide[:, 0], wide[:, 1]
    group = _beside(low, high)
    order = np.argsort(group, kind="stable")
    members = [m.tolist() for m in np.split(order, _equal_runs(group[order])[0][1:])]
    return [([leaves[i] for i in m], low[m].min(axis=0), high[m].max(axis=0)) for m in members]


def _framed(low: np.ndarray, high: np.ndarray, frames: BoxIndex) -> tuple[np.ndarray, np.ndarray]:
    """The bounds of a leaf, grown to those of the frame it stands in with other sashes: a pair of bars that run along two sides of it and end
    alike, or a piece round it."""
    thin = int(np.argmin((high - low)[:2]))
    reach = FRAME + NEAR_FRAME
    near = frames.near(low - reach, high + reach)
    near = near[frames.high[near, thin] - frames.low[near, thin] <= STRING_THICK]
    a, b = frames.low[near], frames.high[near]
    best = low, high
    for axis, side in ((2, 1 - thin), (1 - thin, 2)):
        over = np.stack([low[axis] - a[:, axis], b[:, axis] - high[axis]])  # beyond the leaf, m
        along = (over >= -NEAR_FRAME).all(axis=0) & (over <= SASHES).all(axis=0)
        narrow = along & ((b - a)[:, side] <= BROADEST_BAR)
        first, last = narrow & (b[:, side] <= low[side] + NEAR_FRAME), narrow & (a[:, side] >= high[side] - NEAR_FRAME)
        alike = np.abs(over[:, first][:, :, None] - over[:, last][:, None]).max(axis=0) <= NEAR_FRAME
        round_it = along & (over.min(axis=0) <= reach) & (np.abs([a[:, side] - low[side], b[:, side] - high[side]]) <= reach).all(axis=0)
        for k in [*np.nonzero(first)[0][alike.any(axis=1)].tolist(), *np.nonzero(round_it)[0].tolist()]:
            grown = low.copy(), high.copy()
            grown[0][axis], grown[1][axis] = min(low[axis], a[k, axis]), max(high[axis], b[k, axis])
            best = max(best, grown, key=lambda box: float((box[1] - box[0]).sum()))
    return best


def _bounds(elements: Sequence[Element]) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners, float64 (n, 3) each."""
    boxes = np.array([(e.vertices.min(axis=0), e.vertices.max(axis=0)) for e in elements]).reshape(-1, 2, 3)
    return boxes[:, 0], boxes[:, 1]


def _opening(corners: np.ndarray, grid: Grid, number: int) -> Element:
    floor = any(abs(float(corners[:, 2].min()) - z) < 0.3 for z in grid.levels)
    kind = DOOR if floor and np.ptp(corners[:, 2]) > 1.7 else WINDOW
    state = OPEN if kind == DOOR else GLASS
    return Element(f"{kind.title()} {number + 1}", kind, corners, np.zeros((0, 3), dtype=np.int64), "", state)


def _stands_free(native: Any, grid: Grid, e: Element) -> bool:
    """Whether a room's air goes on over much of a piece: a cupboard, or a door drawn open. Under the sky nothing is told."""
    low, high = grid.index(np.array([e.vertices.min(axis=0), e.vertices.max(axis=0)]))
    k = min(int(high[0]) + 2, grid.shape[0] - 1)
    box = tuple(slice(max(0, a), b + 1) for a, b in zip(low, high, strict=True))
    own = np.zeros([s.stop - s.start for s in box], dtype=np.uint8)
    origin = grid.origin + np.array([s.start for s in box][::-1]) * grid.step
    native.voxels.mark(own, origin, grid.step, e.vertices, e.triangles, SOLID)
    columns = (own > 0).any(axis=0)
    over = grid.blocked[(slice(k, None), *box[1:])]
    free = (over[0] & SOLID == 0) & (over & SOLID > 0).any(axis=0)
    return bool(free[columns].mean() >= AIR_OVER)


@dataclass
class _Probe:
    """Asks the grid about points round leaves that are thin along one axis: every place along, offset across, height."""

    grid: Grid
    thin: int
    middle: float

    def solid(self, along: Sequence[float], across: Sequence[float], heights: Sequence[float]) -> np.ndarray:
        """bool (len(along), len(across), len(heights))"""
        points = np.zeros((len(along), len(across), len(heights), 3))
        points[..., 1 - self.thin] = np.array(along)[:, None, None]
        points[..., self.thin] = self.middle + np.array(across)[None, :, None]
        points[..., 2] = np.array(heights)
        return _solid(self.grid, points.reshape(-1, 3)).reshape(points.shape[:3])


def _place(
    grid: Grid, low: np.ndarray, high: np.ndarray, thin: int, thickest: float, frame_low: np.ndarray, frame_high: np.ndarray
) -> str:
    """What leaves in the box low..high, thin along an axis, with a frame round them, are: HANGS before a wall; FILLS a hole in one, under a
    lintel (solid above, with air on at least one side of it) or, as high as the room, between two jambs with air on both sides; or WALL."""
    along = 1 - thin
    probe = _Probe(grid, thin, 0.5 * (low[thin] + high[thin]))
    places = np.linspace(low[along], high[along], 7)[1:-1]
    heights = _heights(low, high)
    if probe.solid(places, BEHIND, heights).any(axis=1).mean() > 0.5:
        return HANGS
    tops = [top + rise for top in (high[2], frame_high[2]) for rise in NEAR_SOLID]
    lintel = probe.solid(places, [0.0, -IN_WALL, IN_WALL], tops)
    covered = lintel.any(axis=(1, 2))
    if covered.sum() < 3:
        return WALL
    first = np.array(tops)[lintel.any(axis=1).argmax(axis=1)]  # where the lintel of each place was met
    for side in (-CLEAR_OF_WALL, CLEAR_OF_WALL):
        if sum(not probe.solid([p], [side], [z]).any() for p, z in zip(places[covered], first[covered], strict=True)) >= 3:
            return FILLS
    if thickest > DOOR_LEAF or high[along] - low[along] > DOOR_WIDE:
        return WALL
    if not _between_jambs(probe, frame_low, frame_high):
        return WALL
    return WALL if probe.solid(places, [-CLEAR_OF_WALL, CLEAR_OF_WALL], heights).any() else FILLS


def _heights(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.linspace(low[2], high[2], 5)[1:-1]


def _between_jambs(probe: _Probe, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether something solid stands at both ends, for most of the height."""
    along = 1 - probe.thin
    return all(
        probe.solid([end + sign * off for off in NEAR_SOLID], [0.0, -IN_WALL, IN_WALL], _heights(low, high)).any(axis=(0, 1)).sum() >= 2
        for end, sign in ((low[along], -1.0), (high[along], 1.0))
    )


def _solid(grid: Grid, points: np.ndarray) -> np.ndarray:
    index = grid.index(points)
    there = grid.inside(index)
    result = np.zeros(len(points), dtype=bool)
    result[there] = grid.blocked[tuple(index[there].T)] & SOLID > 0
    return result


def _within(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    return (values >= limits[0]) & (values <= limits[1])
