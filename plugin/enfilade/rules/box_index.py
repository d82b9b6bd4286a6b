# SPDX-License-Identifier: GPL-3.0-or-later
"""Boxes by where they lie: asking what is near a place costs what is near, not the whole building."""

from __future__ import annotations

import numpy as np

CELL = 4.0  # m: a room's size
MOST_ALONG = 1 << 20  # cells along an axis, so that a cell's number fits 64 bits: strays far off make all cells larger
MOST_CELLS = 256  # boxes that reach over more cells (terrain, facades) are looked at each time


class BoxIndex:
    """low, high: float64 (n, 3), in metres. A box whose low corner isn't finite is near nothing."""

    def __init__(self, low: np.ndarray, high: np.ndarray) -> None:
        self.low, self.high = low, high
        some = np.nonzero(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1))[0]
        extent = np.max(high[some], initial=0.0) - np.min(low[some], initial=0.0)
        self._cell = max(CELL, extent / MOST_ALONG)
        first, last = np.floor(low[some] / self._cell), np.floor(high[some] / self._cell)
        self._start = first.min(axis=0, initial=0.0)
        self._end = last.max(axis=0, initial=0.0)
        count = (last - first + 1.0).prod(axis=1)
        wide = count > MOST_CELLS
        self._wide, some = some[wide], some[~wide]
        span, count = (last - first + 1.0)[~wide].astype(np.int64), count[~wide].astype(np.int64)
        first = (first[~wide] - self._start).astype(np.int64)
        owner = np.repeat(np.arange(len(some)), count)
        at = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)  # the number of the cell within its box
        inside = np.column_stack([at // (span[owner, 1] * span[owner, 2]), at // span[owner, 2] % span[owner, 1], at % span[owner, 2]])
        cell = self._number(*(first[owner] + inside).T)
        order = np.argsort(cell, kind="stable")
        self._cells, self._members = cell[order], some[owner[order]]

    def _number(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        size = (self._end - self._start + 1.0).astype(np.int64)
        return (x * size[1] + y) * size[2] + z

    def near(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The boxes that meet the box low..high, ascending indices."""
        first = (np.clip(np.floor(low / self._cell), self._start, self._end) - self._start).astype(np.int64)
        last = (np.clip(np.floor(high / self._cell), self._start, self._end) - self._start).astype(np.int64)
        if (last - first + 1)[:2].prod() >= len(self.low):
            some = np.arange(len(self.low))
        else:
            x, y = np.meshgrid(np.arange(first[0], last[0] + 1), np.arange(first[1], last[1] + 1))
            x, y = x.ravel(), y.ravel()
            begin = np.searchsorted(self._cells, self._number(x, y, np.full_like(x, first[2])), "left").tolist()
            end = np.searchsorted(self._cells, self._number(x, y, np.full_like(x, last[2])), "right").tolist()
            some = np.unique(np.concatenate([self._wide, *(self._members[a:b] for a, b in zip(begin, end, strict=True))]))
        return some[(self.low[some] <= high).all(axis=1) & (self.high[some] >= low).all(axis=1)]
