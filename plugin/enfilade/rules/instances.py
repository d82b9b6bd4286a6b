# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounding boxes of one object's many instances, grouped into few boxes that stay tight.

What is switched on and off is the object in the file; a scatter of ten thousand plants is one switch, but one box round
all of them would be seen from everywhere. Plain numpy.
"""

from __future__ import annotations

import numpy as np

MOST_GROUPS = 256  # boxes of one instancer: beyond it groups just stay larger (safe: a larger box is seen sooner)
# A group is split while its box is longer than this many times the largest box inside it.
LOOSE = 2.0


def box_corners(boxes: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """World bounds (n, 2, 3) of local boxes (n, 2, 3) under matrices (n, 4, 4), all float64."""
    low, high = boxes[:, 0], boxes[:, 1]
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    linear = matrices[:, :3, :3]
    middle = np.einsum("nij,nj->ni", linear, centre) + matrices[:, :3, 3]
    reach = np.einsum("nij,nj->ni", np.abs(linear), half)
    return np.stack([middle - reach, middle + reach], axis=1)


def group_boxes(boxes: np.ndarray) -> list[np.ndarray]:
    """Groups (m, 2, 3) boxes into at most MOST_GROUPS; returns float64 (2, 3) unions that cover every box."""
    boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 2, 3)
    if len(boxes) == 0:
        return []
    pending = [np.arange(len(boxes))]
    done: list[np.ndarray] = []
    while pending:
        # the largest group first, so that the cap leaves many small ones rather than one huge one
        pending.sort(key=lambda g: float(np.linalg.norm(_union(boxes[g])[1] - _union(boxes[g])[0])))
        group = pending.pop()
        union = _union(boxes[group])
        size = float(np.linalg.norm(union[1] - union[0]))
        largest = float(np.linalg.norm(boxes[group, 1] - boxes[group, 0], axis=1).max())
        if len(group) == 1 or size <= LOOSE * largest or len(pending) + len(done) + 2 > MOST_GROUPS:
            done.append(union)
            continue
        centres = boxes[group].mean(axis=1)
        axis = int(np.argmax(np.ptp(centres, axis=0)))
        order = np.argsort(centres[:, axis], kind="stable")
        middle = len(group) // 2
        pending += [group[order[:middle]], group[order[middle:]]]
    return done


def _union(boxes: np.ndarray) -> np.ndarray:
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
