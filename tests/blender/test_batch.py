# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch commands as a farm runs them: a process each, results on stdout, the log on stderr, exit codes."""

from __future__ import annotations

import json
import subprocess

import bpy
import pytest
from kit import DATA, HOUSE, ROOT, two_rooms, visibility

BATCH = ROOT / "plugin" / "batch.py"


def run(blend, *arguments, expect=0, before="pass"):
    """before: Python that is run first."""
    command = [bpy.app.binary_path, "-b", "--factory-startup"]
    command += [str(blend)] if blend else []
    command += ["--python-expr", before]
    command += ["--python-exit-code", "3", "-P", str(BATCH), "--", *map(str, arguments)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=1800)
    assert done.returncode == expect, f"{done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    return (json.loads(lines[-1]) if lines else None), done


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("batch")
    two_rooms().render.engine = "CYCLES"  # EEVEE needs a display
    path = folder / "small.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_detect_writes_the_scene_and_its_json(tmp_path):
    found, done = run(HOUSE, "detect", "--save", tmp_path / "h.blend", "--scene-json", tmp_path / "h.enf.json")
    assert found["rooms"] == 9 and found["openings"] == found["openings_joined"]
    assert (tmp_path / "h.blend").stat().st_size > 1000
    assert json.loads((tmp_path / "h.enf.json").read_text())["format"] == "enfilade-scene"
    assert "rooms" in done.stderr and "Fra:" not in done.stdout
    tool = ROOT / "build" / "bin" / "enfilade"
    if tool.exists():
        view = [str(tool), "view", str(tmp_path / "h.enf.json"), "--camera", found["cameras"][0]]
        assert subprocess.run(view, capture_output=True).returncode == 0


def test_cull_then_restore_gives_the_same_flags_back(small, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(small))
    before = visibility()
    found, _ = run(small, "cull", "--mode", "render", "--save", tmp_path / "c.blend")
    assert found["kept"] == 2 and found["hidden"] == 1 and found["views"][0]["rooms"] == ["A", "B"]
    near, _ = run(small, "cull", "--mode", "render", "--distance", "0.5")
    assert near["kept"] < 2 and near["views"][0]["meshes"] == near["views"][0]["objects"]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "c.blend"))
    assert bpy.data.objects["Chair C"].hide_render
    assert [o.name for o in bpy.data.collections["Enfilade Hidden"].objects] == ["Chair C"]
    again, _ = run(tmp_path / "c.blend", "restore", "--save", tmp_path / "r.blend")
    assert again["restored"] == 1
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "r.blend"))
    assert visibility() == before


def test_a_culled_file_can_be_culled_again_for_another_camera(small, tmp_path):
    run(small, "cull", "--mode", "viewport", "--save", tmp_path / "a.blend")
    found, _ = run(tmp_path / "a.blend", "cull", "--mode", "viewport", "--save", tmp_path / "b.blend")
    assert (found["kept"], found["hidden"], found["objects"]) == (2, 1, 3)


def test_frames_make_a_table(small, tmp_path):
    found, _ = run(small, "cull", "--frames", "1-4", "--save", tmp_path / "t.blend")
    assert found["frames"]["first"] == 1 and found["frames"]["kept_most"] == 2
    rows = found["frames"]["table"]
    assert [r["frame"] for r in rows] == [1, 2, 3, 4] and [(r["kept"], r["entered"], r["left"]) for r in rows][0] == (2, 2, 0)
    assert all((r["entered"], r["left"]) == (0, 0) and r["microseconds"] > 0 for r in rows[1:])
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "t.blend"))
    assert bpy.context.scene["enfilade_frames"] in bpy.data.texts
    found, _ = run(small, "cull", "--frames", "1-4", "--keyframes", "--save", tmp_path / "k.blend")
    assert found["keys"] > 0


def test_render_verifies_and_leaves_the_file_alone(small, tmp_path):
    content = small.read_bytes()
    found, _ = run(small, "render", "--verify", "--out", tmp_path, "--samples", 1, "--resolution", "64x36", "--mode", "render")
    assert found["equal"] and found["index_wrong"] == found["depth_wrong"] == 0
    renders = found["shots"][0]["renders"]
    assert renders["culled"]["hidden"] == 1 and renders["whole"]["peak_bytes"] > 0
    assert small.read_bytes() == content
    assert (tmp_path / "Eye_compared.png").exists() and json.loads((tmp_path / "verify.json").read_text())["equal"]


def test_a_safe_render_is_the_same_picture_to_the_last_bit(small, tmp_path):
    found, _ = run(small, "render", "--verify", "--out", tmp_path, "--samples", 2, "--resolution", "64x36")
    assert found["mode"] == "safe" and found["shots"][0]["comparison"]["beauty_max"] == 0.0


def test_render_without_verify_makes_pictures(small, tmp_path):
    found, _ = run(small, "render", "--out", tmp_path, "--samples", 1, "--resolution", "32x18", "--frames", "2-3")
    assert [p["frame"] for p in found["pictures"]] == [2, 3]
    assert (tmp_path / "Eye_0002.png").exists() and (tmp_path / "Eye_0003.png").exists()


def test_report(small, tmp_path):
    found, _ = run(small, "report", "--out", tmp_path / "report")
    assert "report.html" in found["files"] and found["matrix"]["visible_pairs"] == 5


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ([], 1, "required"),
        (["nonsense"], 1, "nonsense"),
        (["cull", "--keep", "everything"], 1, "everything"),
        (["cull", "--frames", "9-3"], 1, "backwards"),
        (["cull", "--keyframes"], 1, "--frames"),
        (["cull", "--distance", "-1"], 1, "above 0"),
        (["cull", "--save", "x.txt"], 1, "a .blend file is wanted"),
        (["cull", "--save", "/"], 1, "a .blend file is wanted"),
        (["report", "--out", __file__], 1, "a folder is wanted"),
        (["report", "--out", "x", "--time-limit", "-1"], 1, "negative"),
        (["detect", "--scene-json", f"{__file__}/x.enf.json"], 2, "test_batch.py"),
        (["render"], 1, "--out"),
        (["cull", "--camera", "Nobody"], 2, "there are: Eye"),
        (["detect", "--ifc", "no-such.ifc"], 2, "no-such.ifc"),
    ],
)
def test_exit_codes(small, arguments, code, said):
    _, done = run(small, *arguments, expect=code)
    assert said in done.stderr
    assert "{" not in "".join(line for line in done.stdout.splitlines() if line.startswith("{"))


# The process gets the signal as soon as it tells how far it is: neither before its work has begun nor after.
CTRL_C_ONCE_IT_WORKS = """
import os, signal, sys
class Log:
    told = False
    def write(self, text):
        if "%" in text and not self.told:
            self.told = True
            os.kill(os.getpid(), signal.SIGINT)
        return sys.__stderr__.write(text)
    def __getattr__(self, name):
        return getattr(sys.__stderr__, name)
sys.stderr = Log()
"""


def test_an_interrupted_report_says_so_and_leaves_whole_files(small, tmp_path):
    found, done = run(HOUSE, "report", "--out", tmp_path, expect=130, before=CTRL_C_ONCE_IT_WORKS)
    assert found is None and "stopped" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "report.html").exists() and not [p for p in tmp_path.iterdir() if ".part" in p.name]


def test_a_scene_without_rooms_is_bad_input(tmp_path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty.blend"))
    _, done = run(tmp_path / "empty.blend", "detect", expect=2)
    assert "room" in done.stderr


def test_an_ifc_file_goes_all_the_way(tmp_path):
    model = DATA / "ifc" / "AC20-FZK-Haus.ifc"
    if not model.exists():
        pytest.skip(f"{model.name} is not at hand")
    from enfilade.rules import ifc_library

    if not ifc_library.available():
        pytest.skip("IfcOpenShell is not at hand")
    found, _ = run(None, "detect", "--ifc", model, "--add-cameras", 2, "--save", tmp_path / "fzk.blend")
    assert found["source"] == "ifc" and found["doors_two_rooms"] >= 3 and len(found["cameras"]) == 2
    verified, _ = run(tmp_path / "fzk.blend", "render", "--verify", "--out", tmp_path, "--samples", 1, "--resolution", "160x90",
                      "--mode", "render")
    assert verified["equal"]
    culled, _ = run(tmp_path / "fzk.blend", "cull")
    assert culled["hidden"] > 0


def test_verify_compares_both_eyes_of_a_stereo_pair(tmp_path):
    scene = two_rooms()
    scene.render.use_multiview, scene.render.views_format = True, "STEREO_3D"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "stereo.blend"))
    found, _ = run(tmp_path / "stereo.blend", "render", "--verify", "--out", tmp_path, "--samples", 1, "--resolution", "64x36", "--mode", "render")
    (shot,) = found["shots"]
    assert found["equal"] and shot["hidden"] and (shot["comparison"]["width"], shot["comparison"]["height"]) == (128, 36)
