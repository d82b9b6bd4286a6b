# SPDX-License-Identifier: GPL-3.0-or-later
"""One chain of portals, asked directly: does any straight line pass them all, in this order? (chain_query.h)

    chain.query([door, window]).status  # "visible", "hidden", "grazing" or "undecided"
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._library import library
from ._signatures import ChainQueryHandle
from .errors import InvalidArgumentError
from .region import STATUSES

SHOWN_BY = ("nothing", "line", "windows", "cone")


@dataclass(frozen=True)
class ChainAnswer:
    status: str  # one of region.STATUSES
    shown_by: str  # one of SHOWN_BY: what decided it
    segment: np.ndarray | None  # float64 (2, 3), metres, through all portals; None when there is none
    clearance: float  # metres, of the segment; 0 without
    delta: float  # metres: the clearance asked for, as used
    exact_signs: int = 0  # signs of the cone that only exact arithmetic could tell


class _Query:
    """The core's scratch memory, one a thread."""

    def __init__(self) -> None:
        self.handle = ChainQueryHandle()
        library().enf_chain_query_create(ctypes.byref(self.handle))

    def __del__(self) -> None:
        handle, self.handle = getattr(self, "handle", None), None
        if handle:
            library().enf_chain_query_destroy(handle)


_local = threading.local()


def query(portals: Sequence[Any], clearance: float = 0.0) -> ChainAnswer:
    """portals: arrays (corners, 3) in metres, each so wound that its normal by the right-hand rule points the way the line
    goes. clearance: metres from every edge, 0 for 2.5e-7 of the chain's extent. From any thread."""
    arrays = [np.ascontiguousarray(portal, dtype=np.float64) for portal in portals]
    for i, array in enumerate(arrays):
        if array.ndim != 2 or array.shape[1] != 3:
            raise InvalidArgumentError(f"portal {i} has shape {array.shape}, expected (corners, 3)")
    if not hasattr(_local, "query"):
        _local.query = _Query()
    vertices = np.concatenate(arrays) if arrays else np.zeros((0, 3))
    counts = np.array([len(array) for array in arrays], dtype=np.uint32)
    answer = library().enf_default_chain_answer()
    library().enf_chain_query(
        _local.query.handle, vertices.ctypes.data, counts.ctypes.data, len(arrays), clearance, ctypes.byref(answer)
    )
    status = STATUSES[answer.status]
    segment = np.array(answer.segment).reshape(2, 3) if status in ("visible", "grazing") else None
    return ChainAnswer(status, SHOWN_BY[answer.shown_by], segment, answer.clearance, answer.delta, answer.exact_signs)
