# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pieces of a polygon soup are: shell, leaf of a door or pane of a window, or something that only stands in a room.

Triangles hang together over edges that exactly two of them share, welded at a millimetre: a frame that fits its hole corner by
corner stays apart from the wall. Each piece is judged by its size alone, in the work frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .box_index import BoxIndex
from .building import WINDOW
from .geometry_elements import SHELL, Element
from .geometry_frame import own_directions
from .geometry_grid import SOLID, make
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
FRAMING = 0.2  # m that a frame reaches over a sheet in it, above and below
LID_THICK = 0.2  # m: a pane or a dome in a roof, with its frame
LID = (0.3, 6.0)  # m, m2: width at least, area at most; what is larger is a roof itself
MANY = 400_000  # pieces and more aren't judged one by one: they all count as shell


def pieces(vertices: np.ndarray, triangles: np.ndarray, watch: Progress = NOBODY) -> tuple[np.ndarray, np.ndarray]:
    """The piece of each triangle, int (m,), numbered from 0; and whether each piece is closed, bool."""
    count = len(triangles)
    if not count:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    place, corner = _welded(vertices)
    points = vertices[place]
    watch.at(0.1)
    turned, solid = _outward(vertices, triangles, watch)
    watch.at(0.2)
    half, owner, key = _by_edge(corner[turned])
    watch.at(0.25)
    first, length = equal_runs(key)
    pair = first[length == 2]
    shared = np.nonzero(np.repeat(length > 2, length))[0]
    left, right = _round_edges(points, half[shared], key[shared])
    a = owner[np.concatenate([pair, shared[left]])]
    b = owner[np.concatenate([pair + 1, shared[right]])]
    # A solid that was given as one stays one, whatever overlaps it.
    order = np.argsort(solid, kind="stable")
    same = (solid[order[1:]] == solid[order[:-1]]) & (solid[order[1:]] >= 0)
    a, b = np.concatenate([a, order[:-1][same]]), np.concatenate([b, order[1:][same]])
    watch.at(0.3)
    number = _joined(count, a, b)
    watch.at(0.35)
    groups = int(number.max()) + 1
    closed = 2 * np.bincount(number[a], minlength=groups) >= 3 * np.bincount(number, minlength=groups)
    closed[number[solid >= 0]] = True
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


def _outward(vertices: np.ndarray, triangles: np.ndarray, watch: Progress) -> tuple[np.ndarray, np.ndarray]:
    """The triangles, those of closed solids drawn inside out turned round; and the solid of each, -1 for those of none. A solid is what hangs
    together by the corners as they were given: those of solids that only touch are their own."""
    half, owner, key = _by_edge(triangles)
    watch.at(0.13)
    first, length = equal_runs(key)
    pair = first[length == 2]
    pair = pair[half[pair, 0] != half[pair + 1, 0]]  # both sides of the edge agree which way is out
    solid = _joined(len(triangles), owner[pair], owner[pair + 1])
    watch.at(0.17)
    whole = 2 * np.bincount(solid[owner[pair]], minlength=solid.max() + 1) == 3 * np.bincount(solid)
    a, b, c = (vertices[triangles[:, i]] - vertices[triangles[0, 0]] for i in range(3))
    volume = np.bincount(solid, np.einsum("ij,ij->i", a, np.cross(b, c)))
    turned = (whole & (volume < 0.0))[solid]
    return np.where(turned[:, None], triangles[:, ::-1], triangles), np.where(whole[solid], solid, -1)


def _by_edge(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each triangle from each of its edges, sorted by edge: start, end and third corner, int64 (3 m, 3); the triangle; and the edge, a number
    that is the same from both ends."""
    half = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]]).astype(np.int64)
    key = half[:, :2].min(axis=1) * (half.max() + 1) + half[:, :2].max(axis=1)
    order = np.argsort(key, kind="stable")
    return half[order], order % len(triangles), key[order]


def equal_runs(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    first, length = equal_runs(key)
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
    group = beside(low, high)[piece]
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


def beside(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Groups of boxes (n, 3) that hang together by lying within BESIDE of one another."""
    index = BoxIndex(low, high)
    pairs = [(a, b) for a in range(len(low)) for b in index.near(low[a] - BESIDE, high[a] + BESIDE).tolist()]
    return _joined(len(low), *np.array(pairs).T)


@dataclass
class Soup:
    """shell: what parts rooms. leaves: upright panels that may fill holes. frames: what may belong to such a leaf (it is in shell too).
    tall: what is as high as a door and deep: it parts rooms unless there is air over it. plugs: solid boxes of a door's or window's size,
    as thick as walls: openings where a wall is all round them. lids: thin level things with nothing over them, that may close a hole in a roof."""

    shell: list[Element] = field(default_factory=list)
    leaves: list[Element] = field(default_factory=list)
    frames: list[Element] = field(default_factory=list)
    tall: list[Element] = field(default_factory=list)
    plugs: list[Element] = field(default_factory=list)
    lids: list[Element] = field(default_factory=list)


@dataclass
class _Sizes:
    """Measures of the pieces of a mesh, arrays by piece. Boxes `low`, `high` lie along the grid, `size` along each piece's own upright faces."""

    given: np.ndarray  # float64 (triangles, 3, 3)
    corners: np.ndarray  # the same, turned with their piece
    order: np.ndarray  # triangles sorted by piece
    starts: np.ndarray  # where each piece begins in that
    low: np.ndarray
    high: np.ndarray
    size: np.ndarray  # m
    flat: np.ndarray  # m, thickness and width
    side: np.ndarray  # m2 of one of its two upright sides
    total: np.ndarray  # m2 of all faces
    sloped: np.ndarray  # m2 of what is neither level nor upright
    slender: np.ndarray  # bool: bars all along
    hollow: np.ndarray  # bool: fills little of its box
    whole: np.ndarray  # bool: closed
    stairs: np.ndarray  # bool
    slab: np.ndarray  # bool: a floor, a ceiling, a landing
    wide: np.ndarray  # bool: a roof, a whole building in one


def _sizes(given: np.ndarray, piece: np.ndarray, whole: np.ndarray) -> _Sizes:
    count = len(whole)
    order, starts, low, high = _by_piece(given, piece)
    corners = _along_own_faces(given, piece, count)
    _, _, own_low, own_high = _by_piece(corners, piece)
    size = own_high - own_low
    flat = np.sort(size[:, :2], axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(cross, axis=1)
    rise = np.abs(cross[:, 2]) / np.maximum(2.0 * areas, 1e-12)
    total = np.bincount(piece, areas, count)
    # Frames and handrails are bars all along; a thin wall with a door in it has a lintel, or a pier, that is broader.
    facing = np.abs(cross[np.arange(len(cross)), np.argmin(size[:, :2], axis=1)[piece]]) > 1.9 * areas
    face = 0.5 * np.bincount(piece, np.where(facing, areas, 0.0), count)
    a, b, c = (corners[:, i] - own_low[piece] for i in range(3))
    volume = np.abs(np.bincount(piece, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, count))
    return _Sizes(
        given, corners, order, starts, low, high, size, flat,
        side=0.5 * np.bincount(piece, np.where(rise < 0.1, areas, 0.0), count),
        total=total,
        sloped=np.bincount(piece, np.where((rise > 0.1) & (rise < 0.99), areas, 0.0), count),
        slender=2.0 * face * flat[:, 0] <= BROADEST_BAR * (total - 2.0 * face),
        hollow=volume < MASSIVE * size.prod(axis=1),
        whole=whole,
        stairs=_stairs(corners, cross, piece, count, size) | _loose_steps(low, high),
        slab=(flat[:, 0] >= SLAB_SIDE) & (flat.prod(axis=1) >= SLAB_AREA) & (size[:, 2] <= SLAB_THICK),
        wide=(size[:, 2] > SLAB_THICK) & (flat[:, 0] >= 2.0) & (flat.prod(axis=1) >= 6.0),
    )  # fmt: skip


def _along_own_faces(corners: np.ndarray, piece: np.ndarray, count: int) -> np.ndarray:
    """Triangles (m, 3, 3), each turned about z so that most upright faces of its piece run along x and y: what is askew isn't as thick as its box."""
    turn = own_directions(corners, piece, count)
    if not turn.any():
        return corners
    s, c = np.sin(turn)[piece][:, None], np.cos(turn)[piece][:, None]
    x, y = corners[:, :, 0], corners[:, :, 1]
    return np.stack([c * x + s * y, c * y - s * x, corners[:, :, 2]], axis=2)


def judged(native: Any, element: Element, watch: Progress) -> Soup:
    """The pieces of a mesh, without what only stands about."""
    piece, whole = pieces(element.vertices, element.triangles, watch)
    watch.at(0.4)
    if not len(whole) or len(whole) > MANY:
        return Soup([Element(element.name, SHELL, element.vertices, element.triangles, element.source_id)])
    m = _sizes(element.vertices[element.triangles], piece, whole)
    thin, height = m.flat[:, 0], m.size[:, 2]
    small, bar = (m.size < SMALL).all(axis=1), np.sort(m.size, axis=1)[:, 1] <= BAR
    panel = _within(m.flat[:, 1], PANEL[0]) & _within(height, PANEL[1])
    full = m.side >= FULL * m.flat[:, 1] * height
    leaf = _leaves(m, panel & full, bar)
    frame = whole & panel & (thin <= PANEL_THICK) & ~leaf
    leaf |= _framed_sheets(m, panel & ~bar & ~whole, frame & ~full)
    stands = _standing(native, m, small | bar, panel & ~full, leaf, watch) & ~leaf
    tall, plug = _boxes_in_walls(m, stands | leaf, watch)
    lid = _lids(m, stands | leaf)

    def parts(chosen: np.ndarray) -> list[Element]:
        return [_part(element, m, n) for n in np.nonzero(chosen)[0].tolist()]

    shell = ~(stands | leaf | tall | plug | lid)[piece]
    return Soup(
        [Element(element.name, SHELL, element.vertices, element.triangles[shell], element.source_id)] if shell.any() else [],
        parts(leaf), parts(frame | ((small | bar) & ~leaf)) if leaf.any() else [], parts(tall), parts(plug), parts(lid),
    )  # fmt: skip


def _part(element: Element, m: _Sizes, n: int) -> Element:
    mine = element.triangles[m.order[m.starts[n] : m.starts[n + 1]]]
    used, index = np.unique(mine, return_inverse=True)
    return Element(f"Leaf {n}", WINDOW, element.vertices[used], np.asarray(index).reshape(-1, 3), element.source_id)


def _leaves(m: _Sizes, panel: np.ndarray, bar: np.ndarray) -> np.ndarray:
    """Closed upright panels, alone or in one piece with their frame: that is as deep as a wall, but no higher than a door, and far from filling its box
    as a short wall does. An open sheet may be the face of a wall whose corners meet others': nothing is told from its size."""
    thin, wide, height = m.flat[:, 0], m.flat[:, 1], m.size[:, 2]
    leaf = (thin <= LEAF_THICK) & ~bar
    leaf |= m.hollow & (thin <= PANEL_THICK) & (height <= DOOR_HIGH) & (wide <= DOOR_WIDE)
    return leaf & m.whole & panel & (wide * height >= LEAST_PANE)


def _framed_sheets(m: _Sizes, sheet: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Open sheets (of `sheet`) in a closed frame (of `frame`) that runs round them: panes and leaves without thickness."""
    result = np.zeros(len(sheet), dtype=bool)
    around = np.nonzero(frame)[0]
    index = BoxIndex(m.low[around], m.high[around])
    reach = np.array([PANEL_THICK, PANEL_THICK, FRAMING])
    full = m.total >= FULL * m.flat[:, 1] * m.size[:, 2]
    for n in np.nonzero(sheet & full & (m.flat[:, 0] <= WELD))[0].tolist():
        near = around[index.near(m.low[n], m.high[n])]
        over = np.concatenate([m.low[n] - m.low[near], m.high[near] - m.high[n]], axis=1)
        result[n] = ((over >= -WELD) & (over <= np.tile(reach, 2))).all(axis=1).any()
    return result


def _standing(native: Any, m: _Sizes, little: np.ndarray, sparse: np.ndarray, leaf: np.ndarray, watch: Progress) -> np.ndarray:
    """What only stands about: handles, bars, low furniture, railings, stairs and their strings."""
    thin, height = m.flat[:, 0], m.size[:, 2]
    # What is low and thin may carry a window: without it the room under the sill would run out to the outdoors.
    low = (height < LOW) & (thin > LOW_THIN) & ~m.slab & ~m.wide & m.whole
    railing = sparse & (thin <= STRING_THICK) & (m.whole | (thin > 0.01)) & (m.slender | (height < LOW))
    result = little | low | railing | m.stairs
    for n in watch.over(np.nonzero(~result & ~leaf & ~m.slab & (height >= LOW) & (height <= TALLEST_FLIGHT))[0].tolist(), 0.5, 0.9):
        result[n] = _climbs(native, m.corners[m.order[m.starts[n] : m.starts[n + 1]]])
    return result


def _boxes_in_walls(m: _Sizes, known: np.ndarray, watch: Progress) -> tuple[np.ndarray, np.ndarray]:
    """`Soup.tall` and `Soup.plugs` among what isn't known yet."""
    thin, wide, height = m.flat[:, 0], m.flat[:, 1], m.size[:, 2]
    tall = m.whole & _within(height, (LOW, DOOR_HIGH)) & (thin > LOW_THIN) & ~m.slab & ~known & ~(m.wide & (m.sloped >= ROOF * m.total))
    plug = m.whole & ~m.hollow & (thin <= PANEL_THICK) & (thin > LEAF_THICK) & ~known & ~tall
    plug &= _within(wide, (SMALL, DOOR_WIDE)) & _within(height, (SMALL, HIGHEST_PLUG))
    walls = 2.0 * m.side >= 0.5 * m.total  # at least half of it upright
    index = BoxIndex(m.low, m.high)
    for n in watch.over(np.nonzero(plug)[0].tolist(), 0.9):  # a wall reaches round the hole in it; a piece of wall between others has none round it
        near = index.near(m.low[n], m.high[n])
        plug[n] = (walls[near] & ((m.low[near] <= m.low[n] + 0.02) & (m.high[near] >= m.high[n] - 0.02)).all(axis=1)).sum() > 1
    return tall, plug


def _lids(m: _Sizes, known: np.ndarray) -> np.ndarray:
    """`Soup.lids` among what isn't known yet."""
    lid = m.whole & ~known & (m.size[:, 2] <= LID_THICK) & (m.flat[:, 0] >= LID[0]) & (m.flat.prod(axis=1) <= LID[1])
    index = BoxIndex(m.low, m.high)
    for n in np.nonzero(lid)[0].tolist():
        inset = 0.25 * (m.high[n] - m.low[n])[:2]
        low, high = m.low[n, :2] + inset, m.high[n, :2] - inset
        over = index.near(np.append(low, m.high[n, 2]), np.append(high, np.inf))
        over = over[m.high[over, 2] > m.high[n, 2] + LID_THICK]
        above = [m.given[m.order[m.starts[k] : m.starts[k + 1]]] for k in over.tolist()]
        lid[n] = not any(_reaches_over(t, low, high, m.high[n, 2] + LID_THICK) for t in above)
    return lid


def _reaches_over(triangles: np.ndarray, low: np.ndarray, high: np.ndarray, z: float) -> bool:
    """Whether the box of some triangle (m, 3, 3) that reaches higher than z meets the rectangle low..high in plan."""
    meets = (triangles.min(axis=1)[:, :2] < high).all(axis=1) & (triangles.max(axis=1)[:, :2] > low).all(axis=1)
    return bool((triangles[meets, :, 2] > z).any())


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


def _within(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    return (values >= limits[0]) & (values <= limits[1])
