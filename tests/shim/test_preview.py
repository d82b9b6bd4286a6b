# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles, lights and pictures from Python: arrays in and out, lifetimes, wrong input refused with a reason."""

from __future__ import annotations

import math

import enfilade_native as native
import numpy as np
import pytest
from rooms import camera_at, suite

QUAD = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=np.float64)
TWO = [[0, 1, 2], [0, 2, 3]]


def test_a_ray_finds_the_triangle_and_its_object():
    with native.Triangles((5.0, 5.0, 5.0)) as t:
        red = t.add_material(native.Material(colour=(1, 0, 0)))
        t.add_mesh(7, QUAD, TWO, [red, red])
        t.commit()
        hits = t.hit([(0.2, 0.3, 2), (0.2, 0.3, -2), (3, 3, 3)], [(0, 0, -1), (0, 0, 2), (0, 0, 1)])
        assert hits["object"][:2].tolist() == [7, 7] and hits["triangle"][2] == native.NONE
        assert hits["distance"].tolist() == [2.0, 1.0, math.inf]
        assert np.abs(hits["normal"][0]).tolist() == [0, 0, 1]
        assert t.counts["triangles"] == 2 and t.counts["bytes"] > 0
        assert math.isinf(t.hit([(0.2, 0.3, 2)], [(0, 0, -1)], [1.5])["distance"][0])


def test_wrong_meshes_are_refused_with_a_reason():
    with native.Triangles() as t:
        with pytest.raises(native.BadInputError, match="triangle 0 names vertex 9"):
            t.add_mesh(0, QUAD, [[0, 1, 9]])
        with pytest.raises(native.BadInputError, match="vertex 1 isn't finite"):
            t.add_mesh(0, [(0, 0, 0), (math.nan, 0, 0), (0, 1, 0)], [[0, 1, 2]])
        with pytest.raises(native.InvalidArgumentError, match="not three each"):
            t.add_mesh(0, QUAD, [0, 1, 2, 3])
        with pytest.raises(native.InvalidArgumentError):
            t.add_mesh(0, QUAD, TWO, [0])
        with pytest.raises(native.StateError):
            t.hit([(0, 0, 1)], [(0, 0, -1)])
        with pytest.raises(native.BadInputError):
            t.add_material(native.Material(colour=(math.inf, 0, 0)))
    with pytest.raises(native.StateError, match="closed"):
        t.commit()


def test_light_sets_follow_doors():
    with suite([(1.0, 2.0)] * (3 - 1)) as scene:
        lamp = native.Light(position=(2.0, 1.5, 1.5))
        every = native.LightSets(scene, [lamp])
        assert every.cells_of(0).tolist() == [c for c in range(every.cell_count) if 0 in every.of(c).tolist()]
        assert len(every.cells_of(0)) > 1 and every.stats["lights"] == 1
        for opening in range(scene.counts.openings):
            scene.set_opening_state(opening, "closed")
        assert len(native.LightSets(scene, [lamp], method="region").cells_of(0)) < len(every.cells_of(0))
        assert native.LightSets(scene, []).stats["pairs"] == 0
        with pytest.raises(native.BadInputError, match="light 0"):
            native.LightSets(scene, [native.Light(position=(math.nan, 0, 0))])
        with pytest.raises(native.InvalidArgumentError):
            every.of(99)


def test_direct_light_is_the_same_with_and_without_sets():
    with suite([(1.0, 2.0)] * (3 - 1)) as scene, native.Raycaster(scene) as rays:
        lamps = [native.Light(position=(2.0 + 4.0 * i, 1.5, 2.0), radius=0.05) for i in range(3)]
        sets = native.LightSets(scene, lamps)
        places = np.random.default_rng(3).uniform((0.3, 0.3, 0.3), (11.7, 2.7, 1.5), (200, 3))
        up = np.broadcast_to((0.0, 0.0, 1.0), places.shape)
        a = native.direct_light(lamps, places, up, raycaster=rays, samples=4)
        b = native.direct_light(lamps, places, up, raycaster=rays, samples=4, light_sets=sets, threads=2)
        assert (a.irradiance == b.irradiance).all() and (a.lights == b.lights).all()
        assert 0 < b.shadow_rays <= a.shadow_rays and a.irradiance.max() > 0
        with pytest.raises(native.InvalidArgumentError):
            native.direct_light(lamps, places, up[:5], raycaster=rays)


def test_pictures_tell_progress_and_can_be_stopped():
    with suite([(1.0, 2.0)] * (2 - 1)) as scene, native.Raycaster(scene) as rays:
        picture = native.Picture(rays, ambient_samples=2)
        told = []
        whole = picture.render(camera_at((1, 1.5, 1.5), (3, 1.5, 1.4)), 80, 150, progress=told.append)
        assert told[-1] == 1.0 and told == sorted(told) and whole.rows == 150
        assert np.isfinite(whole.depth).any() and whole.counts["rays"] >= 80 * 150
        part = picture.render(camera_at((1, 1.5, 1.5), (3, 1.5, 1.4)), 80, 150, progress=lambda f: False)
        assert part.rows == 64 and (part.depth[:64] == whole.depth[:64]).all() and np.isinf(part.depth[64:]).all()


def test_wrong_pictures_are_refused():
    with suite([(1.0, 2.0)] * (2 - 1)) as scene, native.Raycaster(scene) as rays:
        picture = native.Picture(rays)
        with pytest.raises(native.InvalidArgumentError, match="0 x 5"):
            picture.render(camera_at((1, 1.5, 1.5), (3, 1.5, 1.4)), 0, 5)
        with pytest.raises(native.InvalidArgumentError, match="no preview option"):
            native.Picture(rays, colour=3)
        with pytest.raises(native.InvalidArgumentError):
            native.Picture().render(camera_at((1, 1.5, 1.5), (3, 1.5, 1.4)), 8, 8)
        with pytest.raises(native.BadInputError):
            picture.render(native.Camera(np.full((4, 4), np.nan), angle_x=1.0, angle_y=1.0), 8, 8)
        with pytest.raises(native.InvalidArgumentError):
            native.Picture(rays, max_bounces=99).render(camera_at((1, 1.5, 1.5), (3, 1.5, 1.4)), 8, 8)
