# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that lack a face, or have one twice, come out as the closed ones that were meant."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import polyhedra

PLAN = [(0, 0), (4, 0), (4, 3), (2, 3), (2, 5), (0, 5)]  # an L, 16 m2
HEIGHT = 2.5


def _faces() -> list[np.ndarray]:
    """Floor, ceiling, and the six walls, each float64 (n, 3), counter-clockwise from outside."""
    floor = np.array([(x, y, 0.0) for x, y in PLAN])
    walls = [
        np.array([(*PLAN[k - 1], 0.0), (*PLAN[k], 0.0), (*PLAN[k], HEIGHT), (*PLAN[k - 1], HEIGHT)]) for k in range(len(PLAN))
    ]
    return [np.roll(floor[::-1], 1, axis=0), floor + [0.0, 0.0, HEIGHT], *walls]


def _mesh(faces: list[np.ndarray], first: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Triangles, by fans from corner `first` (the L's corners 0 and 3 see all others, as any of a quad)."""
    vertices, triangles = [], []
    for face in faces:
        n, start = len(face), len(vertices)
        vertices += face.tolist()
        triangles += [(start + first % n, start + (first + k) % n, start + (first + k + 1) % n) for k in range(1, n - 1)]
    return np.array(vertices), np.array(triangles)


def _joined(*meshes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    counts = np.cumsum([0] + [len(v) for v, _ in meshes])
    return np.concatenate([v for v, _ in meshes]), np.concatenate([t + n for (_, t), n in zip(meshes, counts, strict=False)])


@pytest.mark.parametrize("missing", [(1,), (2,), (4,), (2, 5)])
def test_missing_faces_are_put_in(missing: tuple[int, ...]) -> None:
    solid = polyhedra.build(*_mesh([f for k, f in enumerate(_faces()) if k not in missing]))
    assert solid.closed and solid.repaired and solid.volume == pytest.approx(16.0 * HEIGHT)
    assert len(solid.faces) == 8 and sorted(len(loop) for loop in solid.loops) == [4] * 6 + [6, 6]


@pytest.mark.parametrize(("twice", "missing"), [(0, 1), (2, 5)])
def test_a_face_drawn_twice_is_taken_off(twice: int, missing: int) -> None:
    """The second time in other triangles, so that none of them is any of the first; another face is missing."""
    faces = _faces()
    whole = _mesh([f for k, f in enumerate(faces) if k != missing])
    solid = polyhedra.build(*_joined(whole, _mesh([faces[twice]], first=3)))
    assert solid.closed and solid.volume == pytest.approx(16.0 * HEIGHT)
    assert len(solid.triangles) == 2 * len(PLAN) * 2 - 4  # of any closed surface without handles


def test_a_face_across_the_inside_is_taken_off() -> None:
    """Two storeys of a stair in one mesh, the floor between drawn once."""
    floor, ceiling, *walls = _faces()
    up = np.array([0.0, 0.0, HEIGHT])
    solid = polyhedra.build(*_mesh([floor, *walls, ceiling, *(w + up for w in walls), ceiling + up]))
    assert solid.closed and solid.volume == pytest.approx(2.0 * 16.0 * HEIGHT) and len(solid.faces) == 8


def test_a_hole_that_bends_stays_open() -> None:
    """Two faces side by side are missing: their outline is one."""
    assert not polyhedra.build(*_mesh(_faces()[1:-1])).closed
