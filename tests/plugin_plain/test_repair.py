# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixes offered for the meshes of marked rooms: one fault each, mended, and a sound mesh left alone."""

from __future__ import annotations

import numpy as np
import pytest
from enfilade.rules import repair
from enfilade.rules.shapes import open_edges, signed_volume, weld

CORNERS = np.array([(x, y, z) for z in (0.0, 2.5) for y in (0.0, 4.0) for x in (0.0, 5.0)])
FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def _mend(vertices, faces, tolerance=repair.TOLERANCE) -> list[str]:
    """Applies what is offered until nothing is; the kinds in order. The result must be a sound box."""
    kinds = []
    for _ in range(10):
        fix = repair.offer("Room", vertices, faces, tolerance)
        if fix is None:
            break
        assert fix.reason and fix.remedy and np.isfinite(fix.position).all()
        kinds.append(fix.kind)
        vertices, faces = fix.vertices, fix.faces
    assert repair.offer("Room", vertices, faces, tolerance) is None
    v, f = weld(vertices, faces)
    assert open_edges(f) == 0 and signed_volume(v, f) == pytest.approx(50.0, rel=0.02)
    return kinds


def test_a_sound_mesh_is_left_alone() -> None:
    assert _mend(CORNERS, FACES) == []


def test_corners_that_nearly_meet_are_snapped() -> None:
    vertices = np.concatenate([CORNERS, CORNERS[[7]] + (0.002, 0.001, 0.0)])
    faces = [*FACES[:5], [1, 3, 8, 5]]
    assert _mend(vertices, faces) == ["snap"]
    assert repair.offer("Room", vertices, faces, 5e-4).kind == "fill"  # farther apart than the tolerance: a gap to fill


def test_a_missing_face_is_filled() -> None:
    assert _mend(CORNERS, FACES[:5]) == ["fill"]


@pytest.mark.parametrize("turned", [[0], [2, 4], [0, 1, 2, 3, 4, 5]])
def test_faces_that_look_inwards_are_flipped(turned: list[int]) -> None:
    faces = [f[::-1] if n in turned else f for n, f in enumerate(FACES)]
    assert _mend(CORNERS, faces) == ["flip"]


def test_bent_faces_are_planarized_within_the_tolerance_and_split_beyond() -> None:
    bent = CORNERS.copy()
    bent[7] += (0.0, 0.0, 0.004)
    assert _mend(bent, FACES) == ["planarize"]
    fix = repair.offer("Room", bent, FACES)
    assert np.linalg.norm(fix.vertices[:, None] - bent[None], axis=2).min(axis=1).max() <= repair.TOLERANCE
    bent[7] += (0.0, 0.0, 0.1)
    assert _mend(bent, FACES) == ["split"]


def test_faults_are_mended_one_after_the_other() -> None:
    bent = CORNERS.copy()
    bent[7] += (0.0, 0.0, 0.004)
    faces = [f[::-1] if n == 2 else f for n, f in enumerate(FACES[:5])]
    assert _mend(bent, faces)[-1] in ("planarize", "split") and "flip" in _mend(bent, faces)


def test_what_cannot_be_mended_offers_nothing() -> None:
    assert repair.offer("Sheet", CORNERS[:4], [[0, 1, 3, 2]]) is None
    bowl = [FACES[0], FACES[2]]  # two faces of a box: the hole branches at no corner, but closes to no room that was meant
    fix = repair.offer("Part", CORNERS, bowl)
    assert fix is None or fix.kind == "fill"


def test_a_bent_plane_is_put_into_one_plane_within_the_tolerance():
    corners = np.array([(0, 0, 0), (1, 0.004, 0), (1, 0, 2), (0, 0.004, 2)], dtype=float)
    fix = repair.offer("Door_1", corners, [[0, 1, 2, 3]])
    assert fix.kind == repair.PLANARIZE and "2.0 mm" in fix.reason
    assert np.ptp(fix.vertices[:, 1]) < 1e-9 and repair.offer("Door_1", fix.vertices, fix.faces) is None
    assert repair.offer("Door_1", corners * (1, 10, 1), [[0, 1, 2, 3]]) is None  # farther than its corners may be moved
