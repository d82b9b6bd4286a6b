# SPDX-License-Identifier: GPL-3.0-or-later
"""Closes meshes that lack whole faces or have some too many, as spaces come out of models now and then.

Where an odd number of triangles meets at an edge, the mesh is open. Those edges make outlines; one that is flat is either that of a
missing face, which is put in, or that of a face drawn a second time or across the inside, which is taken off.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from . import convex_polygons as cp
from .shapes import cross as vec_cross
from .shapes import newell

FLAT = 1e-3  # m that an outline's corners may be off its plane: models are drawn to the millimetre

Edge = tuple[int, int]


def close(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """The triangles (n, 3) of a closed mesh; None where an outline isn't flat or not a simple one."""
    users: dict[Edge, list[int]] = defaultdict(list)
    for n, (a, b, c) in enumerate(triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            users[_key(edge)].append(n)
    outlines = _outlines([edge for edge, around in users.items() if len(around) % 2])
    if outlines is None:
        return None
    surplus: set[int] = set()
    caps = []
    for loop in outlines:
        normal = newell(vertices[loop])
        size = float(np.linalg.norm(normal))
        if size < FLAT * FLAT:
            return None
        normal = normal / size
        if np.abs((vertices[loop] - vertices[loop[0]]) @ normal).max() > FLAT:
            return None
        extra, filled = _too_many(vertices, triangles, users, loop, normal)
        surplus |= extra
        if not filled:
            caps += _cap(vertices, loop, normal)
    kept = np.delete(triangles, sorted(surplus), axis=0)
    return np.concatenate([kept, np.array(caps, dtype=kept.dtype).reshape(-1, 3)])


def _key(edge: Edge) -> Edge:
    return edge if edge[0] < edge[1] else (edge[1], edge[0])


def _outlines(edges: list[Edge]) -> list[list[int]] | None:
    """Loops of corners that edges make; None where they branch."""
    beside: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        beside[a].append(b)
        beside[b].append(a)
    if any(len(ends) != 2 for ends in beside.values()):
        return None
    loops, seen = [], set()
    for start in sorted(beside):
        loop, here = [], start
        while here not in seen:
            seen.add(here)
            loop.append(here)
            here = next((b for b in beside[here] if b not in seen), start)
        if loop:
            loops.append(loop)
    return loops


def _too_many(
    vertices: np.ndarray, triangles: np.ndarray, users: dict[Edge, list[int]], loop: list[int], normal: np.ndarray
) -> tuple[set[int], bool]:
    """Triangles in the plane of a loop that fill it, those of one too many, and whether nothing need come in its place: where
    triangles of two faces there have an edge in common they aren't told apart, and both are given."""
    outline = {_key((loop[k - 1], loop[k])) for k in range(len(loop))}
    level = np.abs((vertices[triangles] - vertices[loop[0]]) @ normal).max(axis=1) <= FLAT
    for first in (n for edge in sorted(outline) for n in users[edge] if level[n]):
        found, stack = {first}, [first]
        ends: set[Edge] = set()
        while stack:
            a, b, c = triangles[stack.pop()].tolist()
            for edge in map(_key, ((a, b), (b, c), (c, a))):
                ends ^= {edge}
                if edge not in outline:
                    more = {n for n in users[edge] if level[n]} - found
                    found |= more
                    stack += sorted(more)
        if not ends or ends == outline:
            return found, bool(ends)
    return set(), False


def _cap(vertices: np.ndarray, loop: list[int], normal: np.ndarray) -> list[tuple[int, int, int]]:
    """Triangles that fill a flat loop."""
    u = vec_cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u = u / np.linalg.norm(u)
    flat = vertices[loop] @ np.column_stack([u, vec_cross(normal, u)])
    return [(loop[a], loop[b], loop[c]) for a, b, c in cp.ears([(float(x), float(y)) for x, y in flat])]
