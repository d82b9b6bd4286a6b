# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with the mesh of a marked room or opening, and the mended mesh: snap, fill, flip, planarize, split.

Nothing is mended unasked: each `Fix` says what, where and why, and holds the whole mesh as it would be. They are offered
in the order in which they build on each other; apply one, then ask again.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .building import INFO, WARNING, Problem
from .shapes import WELD, newell, open_edges, signed_volume, unit, weld

SNAP, FILL, FLIP, PLANARIZE, SPLIT = "snap", "fill", "flip", "planarize", "split"
KINDS = (SNAP, FILL, FLIP, PLANARIZE, SPLIT)
TOLERANCE = 5e-3  # m that a corner may be moved by unless the user says otherwise


@dataclass
class Fix:
    """A mended mesh on offer."""

    name: str  # the object
    kind: str  # of KINDS
    reason: str
    remedy: str
    position: tuple[float, float, float]
    vertices: np.ndarray  # float64 (n, 3), world
    faces: list[list[int]]

    def problem(self) -> Problem:
        return Problem(WARNING if self.kind in (SNAP, FILL, FLIP) else INFO, f"fix-{self.kind}", self.reason, [self.name],
                       self.position, self.remedy)  # fmt: skip


def offer(name: str, vertices: np.ndarray, faces: Sequence[Sequence[int]], tolerance: float = TOLERANCE) -> Fix | None:
    """The next thing to mend in a mesh of float64 (n, 3) world vertices; None when it is sound.

    tolerance: metres that corners may be moved by.
    """
    vertices = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    faces = [list(f) for f in faces]
    if len(vertices) < 4 or not faces or not np.isfinite(vertices).all():
        return None
    if len(faces) == 1:
        return _flat_sheet(name, vertices, faces, tolerance)
    fine, fine_faces = weld(vertices, faces, WELD)
    missing = _missing(fine_faces)
    if missing:
        fix = _snapped(name, fine, fine_faces, missing, tolerance)
        if fix is not None:
            return fix
    turned = _oriented(fine, fine_faces)
    # Which way is out can't be told of an open mesh; but its faces must agree before a hole's outline can be followed.
    if turned is not None and (not missing or open_edges(fine_faces) > missing):
        count, mended = turned
        where = _middle(fine, next(f for f, g in zip(fine_faces, mended, strict=True) if f != g))
        what = "all its faces look" if count == len(fine_faces) else f"{count} of {len(fine_faces)} faces look"
        return Fix(name, FLIP, f"{name}: {what} inwards.", "Flip them outwards.", where, fine, mended)
    if missing:
        return _filled(name, fine, fine_faces, missing, tolerance)
    return _flattened(name, fine, fine_faces, tolerance)


def _flat_sheet(name: str, vertices: np.ndarray, faces: list[list[int]], tolerance: float) -> Fix | None:
    """Of a plane that marks an opening."""
    corners = vertices[faces[0]]
    normal, middle = unit(newell(corners)), corners.mean(axis=0)
    off = (vertices - middle) @ normal
    bent = float(np.abs(off[faces[0]]).max())
    if not WELD < bent <= tolerance:
        return None
    return Fix(name, PLANARIZE, f"{name}: its face is bent by {1e3 * bent:.1f} mm.", "Move its corners into one plane.",
               _middle(vertices, faces[0]), vertices - off[:, None] * normal, faces)  # fmt: skip


def _missing(faces: Sequence[Sequence[int]]) -> int:
    """Edges that an odd number of faces share: one, as a rule."""
    count: dict[tuple[int, int], int] = defaultdict(int)
    for face in faces:
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            count[(min(a, b), max(a, b))] += 1
    return sum(n % 2 for n in count.values())


def _snapped(name: str, vertices: np.ndarray, faces: list[list[int]], missing: int, tolerance: float) -> Fix | None:
    v, f = weld(vertices, faces, tolerance)
    if len(v) == len(vertices) or len(f) < 4 or _missing(f) >= missing:
        return None
    ends = _border(faces)
    return Fix(
        name, SNAP, f"{name}: {len(vertices) - len(v)} corners lie within {1e3 * tolerance:.0f} mm of others without "
        f"meeting them; {missing} edges are open.", "Snap these corners together.",
        tuple(float(x) for x in vertices[ends[0]]) if ends else _middle(vertices, faces[0]), v, f,
    )  # fmt: skip


def _filled(name: str, vertices: np.ndarray, faces: list[list[int]], missing: int, tolerance: float) -> Fix | None:
    loops = _border_loops(faces)
    if not loops:
        return None
    added = []
    for loop in loops:
        added += [loop] if _bent(vertices, loop) <= tolerance else [[loop[0], loop[i], loop[i + 1]] for i in range(1, len(loop) - 1)]
    if _missing(faces + added) != 0:
        return None
    return Fix(
        name, FILL, f"{name}: {len(loops)} holes in its surface, {missing} open edges.", "Close them with faces.",
        _middle(vertices, loops[0]), vertices, faces + added,
    )  # fmt: skip


def _oriented(vertices: np.ndarray, faces: list[list[int]]) -> tuple[int, list[list[int]]] | None:
    """How many faces look the wrong way and the mesh with all outward; None when they do already."""
    users: dict[tuple[int, int], list[int]] = defaultdict(list)
    for n, face in enumerate(faces):
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            users[(min(a, b), max(a, b))].append(n)
    flipped: list[bool | None] = [None] * len(faces)
    for seed in range(len(faces)):
        if flipped[seed] is not None:
            continue
        flipped[seed] = False
        shell, queue = [seed], deque([seed])
        while queue:
            n = queue.popleft()
            face = faces[n]
            for a, b in zip(face, [*face[1:], face[0]], strict=True):
                around = users[(min(a, b), max(a, b))]
                if len(around) != 2:
                    continue
                m = around[0] if around[1] == n else around[1]
                if flipped[m] is not None:
                    continue
                other = faces[m]
                same = (a, b) in zip(other, [*other[1:], other[0]], strict=True)
                flipped[m] = bool(flipped[n]) != same
                shell.append(m)
                queue.append(m)
        made = [faces[n][::-1] if flipped[n] else faces[n] for n in shell]
        if signed_volume(vertices, made) < 0.0:
            for n in shell:
                flipped[n] = not flipped[n]
    count = sum(bool(x) for x in flipped)
    if not count:
        return None
    return count, [face[::-1] if turn else face for face, turn in zip(faces, flipped, strict=True)]


def _flattened(name: str, vertices: np.ndarray, faces: list[list[int]], tolerance: float) -> Fix | None:
    bends = [_bent(vertices, face) for face in faces]
    bad = [n for n, bend in enumerate(bends) if bend > WELD]
    if not bad:
        return None
    worst = max(bad, key=lambda n: bends[n])
    where = _middle(vertices, faces[worst])
    message = f"{name}: {len(bad)} faces are bent, by up to {1e3 * bends[worst]:.1f} mm."
    moved = _planarized(vertices, faces)
    shift = float(np.linalg.norm(moved - vertices, axis=1).max())
    if shift <= tolerance and max(_bent(moved, f) for f in faces) <= WELD:
        return Fix(name, PLANARIZE, message, f"Move corners by up to {1e3 * shift:.1f} mm into the faces' planes.", where, moved, faces)
    split: list[list[int]] = []
    for n, face in enumerate(faces):
        split += [[face[0], face[i], face[i + 1]] for i in range(1, len(face) - 1)] if n in bad else [face]
    return Fix(name, SPLIT, message, "Split these faces into triangles.", where, vertices, split)


def _planarized(vertices: np.ndarray, faces: list[list[int]], rounds: int = 60) -> np.ndarray:
    """Corners moved towards the planes of their faces until these are flat: alternating projections."""
    moved = vertices.copy()
    for _ in range(rounds):
        target, weight = np.zeros_like(moved), np.zeros(len(moved))
        for face in faces:
            if len(face) < 4:
                continue
            corners = moved[face]
            normal, middle = unit(newell(corners)), corners.mean(axis=0)
            target[face] += corners - ((corners - middle) @ normal)[:, None] * normal
            weight[face] += 1.0
        used = weight > 0
        moved[used] = target[used] / weight[used, None]
        if max((_bent(moved, f) for f in faces), default=0.0) <= 0.5 * WELD:
            break
    return moved


def _bent(vertices: np.ndarray, face: Sequence[int]) -> float:
    """Metres by which a face's corners leave its plane."""
    if len(face) < 4:
        return 0.0
    corners = vertices[list(face)]
    return float(np.abs((corners - corners.mean(axis=0)) @ unit(newell(corners))).max())


def _border(faces: list[list[int]]) -> list[int]:
    """Corners on edges that have no neighbour."""
    return [a for loop in _border_loops(faces) for a in loop] or [faces[0][0]]


def _border_loops(faces: list[list[int]]) -> list[list[int]]:
    """Rings of open edges, turned so that a face put in them fits its neighbours; none where they branch."""
    edges = {(a, b) for face in faces for a, b in zip(face, [*face[1:], face[0]], strict=True)}
    following: dict[int, int] = {}
    for a, b in edges:
        if (b, a) not in edges:
            if b in following:
                return []
            following[b] = a
    loops = []
    while following:
        start = min(following)
        loop = [start]
        here = following.pop(start)
        while here != start:
            if here not in following:
                return []
            loop.append(here)
            here = following.pop(here)
        loops.append(loop)
    return [loop for loop in loops if len(loop) > 2]


def _middle(vertices: np.ndarray, face: Sequence[int]) -> tuple[float, float, float]:
    return tuple(float(x) for x in vertices[list(face)].mean(axis=0))
