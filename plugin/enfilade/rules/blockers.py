# SPDX-License-Identifier: GPL-3.0-or-later
"""What blocks a short look: the drawn, opaque shell (walls, slabs, roofs, ceilings) without its voids.

Cutting voids out of meshes is slow, so shapes come whole and their voids are kept beside them. What the shell doesn't
block and no passage covers is open: rooms that touch without a wall, terraces, floors that were never drawn.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .box_index import BoxIndex
from .ifc_shapes import Shape
from .polyhedra import is_closed, signed_volume
from .probing import Passage
from .shapes import cross as vec_cross

EDGE = 1e-9  # relative: a look that meets an edge between two triangles is blocked


class Blockers:
    """Triangles with bounds, for batches of segments."""

    def __init__(self, shapes: list[Shape], holes: dict[int, list[Passage]] | None = None) -> None:
        """holes: by STEP id of a shape's product, the voids cut into it, as passages."""
        corners, owner = [], []
        for n, shape in enumerate(shapes):
            corners.append(shape.world[shape.triangles])
            owner.append(np.full(len(shape.triangles), n))
        self.shapes = shapes
        self._holes = [(holes or {}).get(s.product.id(), []) for s in shapes]
        self.triangles = np.concatenate(corners) if corners else np.zeros((0, 3, 3))
        self.owner = np.concatenate(owner) if owner else np.zeros(0, dtype=int)
        self._index: BoxIndex | None = None
        self._sheets: np.ndarray | None = None
        self._edges: dict[int, np.ndarray] = {}
        self._winding: dict[int, int] = {}
        self.low = self.triangles.min(axis=1) if len(self.triangles) else np.zeros((0, 3))
        self.high = self.triangles.max(axis=1) if len(self.triangles) else np.zeros((0, 3))

    def near(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Indices of the triangles whose bounds meet the box, ascending."""
        if self._index is None:
            self._index = BoxIndex(self.low, self.high)
        return self._index.near(low, high)

    @cached_property
    def middle(self) -> np.ndarray:
        """The centroid of all surface, float64 (3,): a landmark that turns with the model."""
        if not len(self.triangles):
            return np.zeros(3)
        a, b, c = (self.triangles[:, k] for k in range(3))
        weight = np.linalg.norm(vec_cross(b - a, c - a), axis=1)
        return np.average(self.triangles.mean(axis=1), axis=0, weights=np.maximum(weight, 1e-12))

    @property
    def sheets(self) -> np.ndarray:
        """Per triangle the number of the sheet it is of: the triangles of one product in one plane, int (n,)."""
        if self._sheets is None:
            self._make_sheets()
        return self._sheets

    def edges_of(self, sheet: int) -> np.ndarray:
        """A sheet's outline: the edges that no two of its triangles share, float64 (k, 2, 3)."""
        found = self._edges.get(sheet)
        if found is None:
            triangles = self.triangles[self._members[self._first[sheet] : self._first[sheet + 1]]]
            found = self._edges[sheet] = free_edges(triangles)
        return found

    def plane_of(self, sheet: int) -> tuple[np.ndarray, float]:
        """Unit normal n and d of a sheet, n.x = d."""
        return self._normals[sheet], float(self._offsets[sheet])

    def holes_of_sheet(self, sheet: int) -> list[Passage]:
        """The voids of the product that a sheet belongs to."""
        return self._holes[int(self.owner[self._members[self._first[sheet]]])]

    def of_owners(self, owners: np.ndarray) -> np.ndarray:
        """Indices of all triangles of some shapes, ascending."""
        first, last = np.searchsorted(self.owner, owners), np.searchsorted(self.owner, owners, side="right")
        return np.concatenate([np.arange(0), *(np.arange(a, b) for a, b in zip(first, last, strict=True))])

    def winding(self, owners: np.ndarray) -> np.ndarray:
        """Per shape 1 where it is watertight and its faces look out, -1 where they look in, 0 where it isn't watertight: int (n,)."""
        for owner in np.unique(owners).tolist():
            if owner not in self._winding:
                shape = self.shapes[owner]
                corners, welded = np.unique(np.round(shape.world, 6), axis=0, return_inverse=True)
                triangles = welded.reshape(-1)[shape.triangles]
                closed = is_closed(triangles)
                self._winding[owner] = int(np.sign(signed_volume(corners, triangles))) if closed else 0
        return np.array([self._winding[o] for o in owners.tolist()], dtype=int)

    def _make_sheets(self) -> None:
        a = self.triangles[:, 0]
        cross = vec_cross(self.triangles[:, 1] - a, self.triangles[:, 2] - a)
        normals = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-300)[:, None]
        offsets = np.einsum("ij,ij->i", normals, a)
        key = np.column_stack([self.owner, np.round(normals * 1e4), np.round(offsets * 1e4)])
        _, first, self._sheets = np.unique(key, axis=0, return_index=True, return_inverse=True)
        self._sheets = self._sheets.reshape(-1)
        self._normals, self._offsets = normals[first], offsets[first]
        self._members = np.argsort(self._sheets, kind="stable")
        self._first = np.searchsorted(self._sheets[self._members], np.arange(len(first) + 1))

    def first_hit(self, start: np.ndarray, end: np.ndarray, without: set[int] | None = None) -> np.ndarray:
        """For segments start, end float64 (n, 3): the fraction 0..1 of the first hit, inf where nothing blocks.

        without: indices into `shapes` that are looked through.
        """
        best = np.full(len(start), np.inf)
        if not len(self.triangles) or not len(start):
            return best
        low = np.minimum(start, end).min(axis=0)
        high = np.maximum(start, end).max(axis=0)
        chosen = self.near(low, high)
        if without:
            chosen = chosen[~np.isin(self.owner[chosen], list(without))]
        if not len(chosen):
            return best
        step = max(1, 400_000 // len(start))
        direction = end - start
        for first in range(0, len(chosen), step):
            tri = self.triangles[chosen[first : first + step]]
            best = np.minimum(best, _hits(start, direction, tri))
        return best


def free_edges(triangles: np.ndarray) -> np.ndarray:
    """The edges (k, 2, 3) of triangles (m, 3, 3) that aren't run through in both directions."""
    edges: dict[tuple[tuple[float, ...], tuple[float, ...]], int] = {}
    for corners in np.round(triangles, 6).tolist():
        points = [tuple(p) for p in corners]
        for k in range(3):
            a, b = points[k - 1], points[k]
            if edges.get((b, a), 0) > 0:
                edges[(b, a)] -= 1
            else:
                edges[(a, b)] = edges.get((a, b), 0) + 1
    return np.array([e for e, n in edges.items() if n > 0]).reshape(-1, 2, 3)


def _hits(start: np.ndarray, direction: np.ndarray, tri: np.ndarray) -> np.ndarray:
    """Moeller & Trumbore 1997 for all pairs; (n,) least parameter per segment."""
    e1, e2 = tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]
    p = vec_cross(direction[:, None], e2[None])
    determinant = np.einsum("nmk,mk->nm", p, e1)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / determinant
        s = start[:, None] - tri[None, :, 0]
        u = np.einsum("nmk,nmk->nm", s, p) * inverse
        q = vec_cross(s, e1[None])
        v = np.einsum("nk,nmk->nm", direction, q) * inverse
        t = np.einsum("mk,nmk->nm", e2, q) * inverse
        good = (u >= -EDGE) & (v >= -EDGE) & (u + v <= 1.0 + EDGE) & (t >= 0.0) & (t <= 1.0)
    good &= np.abs(determinant) > 1e-14
    return np.where(good, t, np.inf).min(axis=1)
