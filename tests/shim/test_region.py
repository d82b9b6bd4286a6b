# SPDX-License-Identifier: GPL-3.0-or-later
"""From-region visibility from Python: rows, witnesses, rooms, jobs that are polled and cancelled."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys

import enfilade_native as native
import numpy as np
import pytest
from enfilade_native import region
from rooms import suite

IN_LINE = [(1.0, 2.0), (1.0, 2.0), (1.0, 2.0)]
# A narrow door in the middle, then doors at opposite sides: no line from room 0 reaches room 3.
ASIDE = [(0.0, 0.2), (2.8, 3.0), (0.0, 0.2)]


def pairs(result: region.RegionVis) -> set[tuple[int, int]]:
    return {(i, int(j)) for i in range(result.cell_count) for j in result.row(i)}


@pytest.mark.parametrize("method", region.METHODS)
def test_doors_in_line_join_every_pair(method):
    with suite(IN_LINE) as scene, region.run(scene, method=method) as result:
        assert pairs(result) == {(i, j) for i in range(4) for j in range(4)}
        assert result.stats["visible_pairs"] == 16


def test_doors_aside_hide_with_a_certificate():
    with suite(ASIDE) as scene, region.run(scene, method="exact") as result:
        assert result.pair(0, 3) == "hidden" and result.pair(3, 0) == "hidden"
        assert result.witness(0, 3) is None
        assert result.rooms(0, 3) == ("hidden", None)
        assert result.pair(0, 1) == "visible"
        assert result.stats["undecided_pairs"] == 0


def test_a_witness_is_a_line_through_the_portals_it_names():
    with suite(IN_LINE) as scene, region.run(scene) as result:
        witness = result.witness(0, 3)
        assert witness.portals == [0, 1, 2] and witness.clearance > 0
        assert scene.locate(witness.start).tolist() == [0] or 0 in scene.locate(witness.start)
        assert 3 in scene.locate(witness.end)
        direction = witness.end - witness.start
        for k in range(3):  # where the segment crosses x = 4 (k + 1) it is inside of door k
            t = (4.0 * (k + 1) - witness.start[0]) / direction[0]
            _, y, z = witness.start + t * direction
            assert 1.0 < y < 2.0 and 0.0 < z < 2.0


def test_rows_asked_for_are_the_same_as_in_the_whole():
    with suite(ASIDE) as scene, region.run(scene) as whole, region.run(scene, from_cells=[1]) as part:
        assert part.row(1).tolist() == whole.row(1).tolist()
        assert part.row(0).tolist() == []


def test_rooms_are_a_symmetric_matrix():
    with suite(ASIDE) as scene, region.run(scene) as result:
        matrix = result.room_matrix()
        assert np.array_equal(matrix > 0, matrix.T > 0)
        assert (np.diag(matrix) == region.STATUSES.index("visible")).all()


def test_rows_outlive_the_result():
    scene = suite(IN_LINE)
    result = region.run(scene)
    row = result.row(0)
    result.close()
    scene.close()
    del result, scene
    gc.collect()
    assert row.tolist() == [0, 1, 2, 3]


def test_a_job_is_polled_and_its_result_taken_once():
    with suite(IN_LINE) as scene, region.start(scene) as job:
        fractions = [job.progress.fraction]
        while not job.wait(0.001):
            fractions.append(job.progress.fraction)
        assert job.progress.done and job.progress.fraction == 1.0
        assert fractions == sorted(fractions) and fractions[0] >= 0
        with job.take() as result:
            assert result.cell_count == 4
        with pytest.raises(native.StateError):
            job.take()


def test_a_job_blocks_edits_until_it_ends():
    with suite([(1.0, 2.0)] * 2000) as scene:  # far more work than can be done before it is cancelled
        with region.start(scene) as job:
            assert not job.wait(0.001) and not job.progress.done
            with pytest.raises(native.StateError, match="bake"):
                scene.add_room("More")
            job.cancel()
            assert job.wait() and job.progress.done
        assert scene.add_room("More") == 2001


def test_a_cancelled_bake_keeps_what_it_has_and_errs_to_visible():
    with suite([(0.1 * (i % 20), 0.1 * (i % 20) + 0.2) for i in range(80)]) as scene, region.start(scene) as job:
        job.cancel()
        assert job.wait()
        with job.take() as result:
            assert all(i in result.row(i) for i in range(result.cell_count))
            stats = result.stats
            assert stats["visible_pairs"] + stats["hidden_certified"] == 81 * 81


def test_matrix_and_witnesses_are_written(tmp_path):
    with suite(ASIDE) as scene, region.run(scene) as result:
        result.write_matrix(tmp_path / "m.txt")
        result.write_witnesses(tmp_path / "w.txt")
        lines = (tmp_path / "m.txt").read_text().splitlines()
        assert [list(map(int, line.split())) for line in lines] == [result.row(i).tolist() for i in range(4)]
        for line in (tmp_path / "w.txt").read_text().splitlines():
            fields = line.split()
            assert len(fields) == 8 and int(fields[0]) < int(fields[1])


# The system kills it at the first byte beyond a size of its files: always at the same place, midway through a record.
BAKE_AND_DIE = """
import resource, signal, sys
import enfilade_native as native
from enfilade_native import region
scene = native.Scene.load(sys.argv[1])
scene.commit()
signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]), int(sys.argv[3])))
region.run(scene, threads=1, block_cells=4, state_path=sys.argv[2])
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="no limit to a file's size here")
def test_a_bake_killed_midway_goes_on_to_the_same_bytes(tmp_path):
    with suite([(0.1 * (i % 20), 0.1 * (i % 20) + 0.9) for i in range(200)]) as scene:
        scene.save(tmp_path / "scene.enf.json")
    with native.Scene.load(tmp_path / "scene.enf.json") as scene:
        scene.commit()
        with region.run(scene, block_cells=4) as whole:
            whole.write_matrix(tmp_path / "whole.txt")
            whole.write_witnesses(tmp_path / "whole.lines")
            blocks = whole.stats["blocks"]
        state = tmp_path / "bake.state"
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
        loaded = []
        for size in (3000, 20000):
            command = [sys.executable, "-c", BAKE_AND_DIE, str(tmp_path / "scene.enf.json"), str(state), str(size)]
            assert subprocess.run(command, env=environment).returncode == -signal.SIGXFSZ
            assert state.stat().st_size == size
            part = tmp_path / "part.state"
            part.write_bytes(state.read_bytes())
            with region.run(scene, block_cells=4, state_path=part) as resumed:
                loaded.append(resumed.stats["blocks_loaded"])
                resumed.write_matrix(tmp_path / "resumed.txt")
                resumed.write_witnesses(tmp_path / "resumed.lines")
            assert (tmp_path / "resumed.txt").read_bytes() == (tmp_path / "whole.txt").read_bytes()
            assert (tmp_path / "resumed.lines").read_bytes() == (tmp_path / "whole.lines").read_bytes()
        assert 0 < loaded[0] < blocks and loaded[0] <= loaded[1]


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="no limit to a file's size here")
def test_a_disk_that_fills_up_is_told_and_leaves_no_half_file(tmp_path):
    import resource

    with suite(IN_LINE * 20) as scene, region.run(scene) as result:
        state = tmp_path / "bake.state"
        kept, limit = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, limit[1]))  # bytes a file: what is beyond fails as on a full disk
        try:
            for write in (result.write_matrix, result.write_witnesses, result.save, scene.save):
                with pytest.raises(native.EnfIOError, match=r"new\.file"):
                    write(tmp_path / "new.file")
            with pytest.raises(native.EnfIOError, match=r"bake\.state"):
                region.run(scene, block_cells=4, state_path=state)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limit)
            signal.signal(signal.SIGXFSZ, kept)
        assert list(tmp_path.iterdir()) == [state]  # which goes on as after a crash
        with region.run(scene, block_cells=4, state_path=state) as resumed:
            assert pairs(resumed) == pairs(result) and resumed.stats["blocks_loaded"] > 0


def test_shards_are_put_together(tmp_path):
    with suite(ASIDE) as scene, region.run(scene) as whole:
        paths = [tmp_path / f"{k}.state" for k in range(2)]
        for k in range(2):
            region.run(scene, block_cells=1, shard_index=k, shard_count=2, state_path=paths[k]).close()
        with region.load(scene, *reversed(paths)) as merged:
            assert pairs(merged) == pairs(whole)
        with pytest.raises(native.StateError, match="missing"):
            region.load(scene, paths[0])
        with pytest.raises(native.InvalidArgumentError, match="state_path"):
            region.run(scene, shard_index=0, shard_count=2)
        with pytest.raises(native.InvalidArgumentError, match="2 of 2"):
            region.run(scene, shard_index=2, shard_count=2, state_path=paths[0])


def test_a_shut_door_asks_only_what_it_changes(tmp_path):
    with suite(IN_LINE) as scene, region.run(scene) as before:
        before.save(tmp_path / "open.state")
        scene.set_opening_state(1, "closed")
        with region.run(scene, variant_of=before) as variant, region.run(scene) as fresh:
            assert pairs(variant) == pairs(fresh) == {(0, 0), (0, 1), (1, 0), (1, 1), (2, 2), (2, 3), (3, 2), (3, 3)}
            assert variant.stats["pairs_kept"] == 2 and variant.stats["pairs_reopened"] == 4
        with region.load(scene, tmp_path / "open.state") as loaded, region.run(scene, variant_of=loaded) as variant:
            assert pairs(loaded) == pairs(before)
            assert pairs(variant) == {(0, 0), (0, 1), (1, 0), (1, 1), (2, 2), (2, 3), (3, 2), (3, 3)}


def test_objects_are_seen_through_doors_they_line_up_with():
    with suite(ASIDE) as scene, region.run(scene) as result:
        seen = {o.object: o for o in result.objects([0])[0]}
        assert result.pair(0, 2) == "visible" and set(seen) == {0, 1}  # room 2 is seen, the thing in its middle not
        assert seen[0].portals == [] and seen[1].portals == [0]
        bounds = [[5.8, 0.1, 0.1], [6.2, 2.9, 2.0]]  # Thing 1
        assert (seen[1].end >= np.array(bounds[0]) - 1e-6).all() and (seen[1].end <= np.array(bounds[1]) + 1e-6).all()
        assert [o.object for o in result.objects([3], objects=[0, 3])[0]] == [3]
        assert [len(row) for row in result.objects()] == [len(row) for row in result.objects(range(4))]
        with pytest.raises(native.InvalidArgumentError, match="nothing"):
            result.objects([])


def test_wrong_input_is_refused_with_a_reason():
    with suite(IN_LINE) as scene:
        with pytest.raises(native.InvalidArgumentError, match="99"):
            region.run(scene, from_cells=[99])
        with pytest.raises(native.InvalidArgumentError, match="empty"):
            region.run(scene, from_cells=[])
        with pytest.raises(native.InvalidArgumentError, match="wobble"):
            region.run(scene, wobble=1)
        with region.run(scene) as result, pytest.raises(native.InvalidArgumentError):
            result.pair(0, 77)
    with native.Scene() as empty, pytest.raises(native.StateError):
        region.run(empty)
