# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges answers by rays: what a random ray meets first is visible, and nothing visible may be hidden.

    /usr/bin/python3 tests/oracle/oracle.py FILE.blend SCENE.enf.json [--rays N] [--frames A,B] [--region] [--methods ...]

FILE.blend is what Blender draws, SCENE.enf.json what `detect --scene-json` made of it. The rays (ray_oracle.c) know the
triangles alone. Prints a table: objects proven visible, kept by each method, hidden though proven (must be 0). Exit 1 when
something was hidden.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(__file__).resolve().parent
METHODS = ("frustum", "box", "clip")
# Share of rays that come upon faces from behind. In open air it is 0, within a solid wall or cupboard over a third (measured on IFC models).
WITHIN_SOLID = 0.25


def blender() -> str:
    return os.environ.get("ENFILADE_BLENDER") or shutil.which("blender") or "blender"


def build_oracle(folder: Path = ROOT / "build" / "oracle") -> Path:
    """Compiles ray_oracle.c when it is newer than the program."""
    source, program = FOLDER / "ray_oracle.c", folder / "ray_oracle"
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        folder.mkdir(parents=True, exist_ok=True)
        command = ["cc", "-std=c17", "-O2", "-Wall", "-Wextra", "-Wshadow", "-o", str(program), str(source),
                   "-lembree3", "-ljansson", "-lm"]
        subprocess.run(command, check=True)
    return program


def dump(blend: Path, out: Path, frames: Sequence[int] = ()) -> dict:
    """Triangles of a .blend file; returns the dump's header (objects, cameras)."""
    command = [blender(), "-b", "--factory-startup", str(blend), "--python-exit-code", "3", "-P",
               str(FOLDER / "dump_triangles.py"), "--", str(out)]
    if frames:
        command += ["--frames", ",".join(map(str, frames))]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"Blender could not dump {blend}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    with out.open("rb") as file:
        return json.loads(file.readline())


def _oracle(*arguments: object) -> list[dict]:
    done = subprocess.run([str(build_oracle()), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr or f"ray_oracle ended with {done.returncode}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def shoot_view(dump_file: Path, camera: int, rays: int, seed: int = 1) -> dict:
    """Objects that rays from a camera of the dump meet: {"rays": ..., "seen": [{"object", "rays", "from", "to"}]}."""
    return _oracle("view", dump_file, "--camera", camera, "--rays", rays, "--seed", seed)[0]


def shoot_views(dump_file: Path, cameras: Sequence[dict], rays: int, seed: int = 1) -> list[dict]:
    """The same for any cameras (in the form of the dump's), `rays` each."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(list(cameras), file)
        file.flush()
        return _oracle("view", dump_file, "--cameras", file.name, "--rays", rays, "--seed", seed)


def random_cameras(scene: dict, count: int, seed: int = 1) -> list[dict]:
    """Cameras where it hurts: anywhere in rooms, within doorways, a hair's breadth beside portals, around the building; with
    any lens and turn. One in seven looks in from outside."""
    rng = np.random.default_rng(seed)
    planes = cell_planes(scene)
    usable = [i for i, faces in enumerate(planes) if len(faces)]
    ways = [p for p in scene["portals"]
            if p.get("opening") is None or scene["openings"][p["opening"]].get("state") != "closed"]
    outdoors = {i for i, room in enumerate(scene["rooms"]) if room.get("kind") == "exterior"}
    every = np.concatenate([np.array(c["vertices"]) for c in scene["cells"] if c.get("vertices") and c.get("room") not in outdoors])
    low, high = every.min(axis=0), every.max(axis=0)
    cameras: list[dict] = []
    while len(cameras) < count:
        if len(cameras) % 7 == 3:
            eye = low - 12.0 + rng.random(3) * (high - low + 24.0)
            eye[2] = low[2] + 0.3 + rng.random() * (high[2] - low[2] + 6.0)
            if ((eye > low - 1.0) & (eye < high + 1.0))[:2].all():
                continue
        elif len(cameras) % 3 == 2 and ways:
            ring = np.array(ways[rng.integers(len(ways))]["polygon"])
            weights = rng.dirichlet(np.ones(len(ring)))
            normal = np.cross(ring[1] - ring[0], ring[2] - ring[0])
            length = np.linalg.norm(normal)
            if not length > 0:
                continue
            beside = rng.choice([0.0, 1e-6, 1e-4, 1e-2, 0.1]) * rng.choice([-1.0, 1.0])
            eye = weights @ ring + beside * normal / length
        else:
            cell = usable[rng.integers(len(usable))]
            points = np.array(scene["cells"][cell]["vertices"])
            eye = points.min(axis=0) + rng.random(3) * np.ptp(points, axis=0)
            if (planes[cell][:, :3] @ eye > planes[cell][:, 3] - 1e-6).any():
                continue
        back = rng.normal(size=3) * [1.0, 1.0, 0.35]
        if len(cameras) % 7 == 3:
            back = eye - (low + rng.random(3) * (high - low))
        back /= np.linalg.norm(back)
        right = np.cross([0.0, 0.0, 1.0], back) + rng.normal(size=3) * rng.choice([0.0, 0.3])
        right -= back * (right @ back)
        if not np.linalg.norm(right) > 1e-3:
            continue
        right /= np.linalg.norm(right)
        up = np.cross(back, right)
        width = 2.0 * np.tan(rng.uniform(0.1, 1.25) / 2.0)
        height = width * rng.choice([0.5625, 0.75, 1.0, 1.7])
        shift = rng.uniform(-0.3, 0.3, 2) * rng.choice([0.0, 1.0])
        corner = -back + (shift[0] - 0.5) * width * right + (shift[1] - 0.5) * height * up
        cameras.append({"name": f"random {len(cameras)}", "frame": 0, "type": "PERSP", "origin": eye.tolist(),
                        "corner": corner.tolist(), "right": (width * right).tolist(), "up": (height * up).tolist(),
                        "forward": (-back).tolist(), "clip": [float(rng.choice([1e-3, 0.05, 0.1])), 500.0]})
    return cameras


@dataclass
class Verdict:
    """One camera, one method."""

    camera: str
    frame: int
    method: str
    rays: int
    proven: int  # objects with a ray
    kept: int  # objects the method reports
    microseconds: float
    hidden: list[dict] = field(default_factory=list)  # proven, but not reported: the unforgivable ones
    unknown: list[str] = field(default_factory=list)  # proven, but not an object of the scene at all
    # the same for an eye within a drawn solid, such as an outer wall without windows, which cells outdoors reach into: counted, not judged
    hidden_within_solid: list[dict] = field(default_factory=list)

    def describe(self) -> str:
        lines = [f"{self.camera} @{self.frame} {self.method}: {len(self.hidden)} objects hidden though a ray meets them"]
        for proof in self.hidden[:10]:
            start, end = (" ".join(f"{v:.4f}" for v in proof[key]) for key in ("from", "to"))
            lines.append(f"   {proof['object']}: {proof['rays']} rays, e.g. from ({start}) to ({end})")
        return "\n".join(lines)


def judge(seen: dict, frame: int, method: str, kept: Iterable[str], every: Iterable[str], microseconds: float) -> Verdict:
    """Compares proven objects with reported ones, all by name."""
    kept, every = set(kept), set(every)
    verdict = Verdict(seen["camera"], frame, method, seen["rays"], len(seen["seen"]), len(kept), microseconds)
    for proof in seen["seen"]:
        if proof["object"] not in every:
            verdict.unknown.append(proof["object"])
        elif proof["object"] not in kept:
            within = seen.get("behind", 0) > WITHIN_SOLID * seen["rays"]
            (verdict.hidden_within_solid if within else verdict.hidden).append(proof)
    return verdict


def blender_camera(native, view: dict):
    """The engine's camera for a camera of the dump, from Blender's own frame corners (so that the judged camera and the
    rays' camera are one and the same, also at frames that aren't in the scene file)."""
    corner, right, up, forward = (np.array(view[k]) for k in ("corner", "right", "up", "forward"))
    width, height = np.linalg.norm(right), np.linalg.norm(up)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = right / width, up / height, -forward
    matrix[:3, 3] = view["origin"]
    depth = corner @ forward
    centre = corner + right / 2 + up / 2 - depth * forward
    shift_x, shift_y = centre @ right / width**2, centre @ up / height**2
    ortho = view["type"] == "ORTHO"
    return native.Camera(
        matrix_world=matrix, type=view["type"],
        angle_x=0.0 if ortho else 2 * float(np.arctan(width / 2 / depth)),
        angle_y=0.0 if ortho else 2 * float(np.arctan(height / 2 / depth)),
        shift_x=float(shift_x), shift_y=float(shift_y), ortho_width=float(width) if ortho else 0.0,
        ortho_height=float(height) if ortho else 0.0, clip=tuple(view["clip"]))


def native():
    """The shim, out of this tree."""
    sys.path.insert(0, str(ROOT / "python_shim"))
    os.environ.setdefault("ENFILADE_LIBRARY", str(ROOT / "build" / "lib" / "libenfilade.so"))
    import enfilade_native

    return enfilade_native


def check_views(dump_file: Path, header: dict, scene_file: Path, rays: int, methods: Sequence[str] = METHODS,
                seed: int = 1, repeats: int = 1, cameras: Sequence[str] = ()) -> list[Verdict]:
    """Every camera of `header` against every method. rays: per camera. repeats: queries timed, the best is given."""
    module = native()
    verdicts = []
    with module.Scene.load(scene_file) as scene:
        scene.commit()
        names = json.loads(Path(scene_file).read_text())["objects"]
        every = [o["name"] for o in names]
        view = module.View(scene)
        wanted = [c for c in header["cameras"] if not cameras or c["name"] in cameras]
        for camera, seen in zip(wanted, shoot_views(dump_file, wanted, rays, seed), strict=True):
            engine_camera = blender_camera(module, camera)
            for method in methods:
                best, kept = float("inf"), []
                for _ in range(repeats):
                    answer = view.query(engine_camera, method)
                    best = min(best, float(answer.stats["microseconds"]))
                    kept = [every[i] for i in answer.objects]
                verdicts.append(judge(seen, camera["frame"], method, kept, every, best))
    return verdicts


# ---- from-region --------------------------------------------------------------------------------------------------
def cell_planes(scene: dict) -> list[np.ndarray]:
    """Per cell of a scene file: its face planes (n, 4), inside where n.p <= d.

    (0, 4) for cells without geometry, and for those of closed openings: what lies in the recess before a closed door is
    drawn geometry, but nobody is asked to see the recess.
    """
    result = []
    openings = scene.get("openings", [])
    for cell in scene["cells"]:
        points, faces = np.array(cell.get("vertices") or np.zeros((0, 3)), float), cell.get("faces")
        opening = cell.get("opening")
        closed = opening is not None and openings[opening].get("state") == "closed"
        if len(points) == 0 or closed:
            result.append(np.zeros((0, 4)))
            continue
        if not faces:
            result.append(_hull_planes(points))
            continue
        planes = []
        for face in faces:
            ring = points[face]
            normal = np.zeros(3)
            for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                normal += np.cross(a - ring[0], b - ring[0])
            length = np.linalg.norm(normal)
            if length > 0:
                normal /= length
                planes.append([*normal, (ring @ normal).max()])
        result.append(np.array(planes))
    return result


def _hull_planes(points: np.ndarray) -> np.ndarray:
    """Planes through three points with all others behind: slow and simple, for the few dozen corners of a cell."""
    found: list[list[float]] = []
    size = np.ptp(points, axis=0).max()
    n = len(points)
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                normal = np.cross(points[j] - points[i], points[k] - points[i])
                length = np.linalg.norm(normal)
                if length < 1e-9 * size * size:
                    continue
                for sign in (1.0, -1.0):
                    unit = sign * normal / length
                    d = float(points[i] @ unit)
                    if (points @ unit).max() <= d + 1e-7 * size:
                        if not any(np.allclose([*unit, d], plane, atol=1e-6) for plane in found):
                            found.append([*unit, d])
    return np.array(found).reshape(-1, 4)


def shoot_region(dump_file: Path, scene: dict, rays: int, seed: int = 1) -> dict:
    """Ordered pairs of cells proven visible by rays among the drawn triangles."""
    planes = cell_planes(scene)
    with tempfile.NamedTemporaryFile("w", suffix=".volumes") as file:
        file.write(f"{len(planes)}\n")
        for cell, faces in zip(scene["cells"], planes, strict=True):
            points = np.array(cell.get("vertices") or [[0, 0, 0]], float)
            values = [len(faces), *points.min(axis=0), *points.max(axis=0), *faces.ravel()]
            file.write(" ".join(repr(float(v)) if i else str(v) for i, v in enumerate(values)) + "\n")
        file.flush()
        return _oracle("region", dump_file, "--volumes", file.name, "--rays", rays, "--seed", seed)[0]


def pvs_matrix(scene_file: Path, method: str, out: Path) -> list[set[int]]:
    """Rows of `enfilade pvs --matrix`."""
    tool = ROOT / "build" / "bin" / "enfilade"
    subprocess.run([str(tool), "pvs", str(scene_file), "--method", method, "--matrix", str(out)], check=True,
                   stdout=subprocess.DEVNULL)
    return [set(map(int, line.split())) for line in out.read_text().splitlines()]


def judge_region(proven: dict, rows: list[set[int]]) -> list[dict]:
    """Proven pairs that the matrix lacks, in either direction: what sees is seen."""
    missing = []
    for pair in proven["pairs"]:
        a, b = pair["from_volume"], pair["to_volume"]
        if b not in rows[a] or a not in rows[b]:
            missing.append(pair)
    return missing


# ---- command line -----------------------------------------------------------------------------------------------------
def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("blend", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--rays", type=int, default=1_000_000, help="per camera (default 1,000,000)")
    parser.add_argument("--frames", default="", help="further frames for animated cameras")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--region", default="", metavar="METHOD", help="also judge `enfilade pvs --method METHOD`")
    parser.add_argument("--random", type=int, default=0, metavar="N", help="also N random cameras in rooms and doorways")
    parser.add_argument("--quiet", action="store_true", help="only rows with something hidden, and the sum")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    wrong = within = 0
    with tempfile.TemporaryDirectory() as folder:
        dump_file = Path(folder) / "triangles.dump"
        header = dump(given.blend, dump_file, [int(f) for f in given.frames.split(",") if f])
        scene = json.loads(given.scene.read_text())
        header["cameras"] += random_cameras(scene, given.random, given.seed)
        kept: dict[str, list[int]] = {}
        print(f"{'camera':24} {'frame':>5} {'method':8} {'rays':>10} {'proven':>7} {'kept':>7} {'hidden':>7} {'us':>9}")
        for v in check_views(dump_file, header, given.scene, given.rays, given.methods.split(","), given.seed, 5):
            kept.setdefault(v.method, []).append(v.kept)
            within += len(v.hidden_within_solid)
            if given.quiet and not v.hidden and not v.unknown:
                continue
            print(f"{v.camera:24} {v.frame:5} {v.method:8} {v.rays:10} {v.proven:7} {v.kept:7} {len(v.hidden):7} "
                  f"{v.microseconds:9.1f}")
            if v.unknown:
                print(f"   {len(v.unknown)} drawn objects are not in the scene file: {', '.join(v.unknown[:5])}")
            if v.hidden:
                print(v.describe())
                wrong += len(v.hidden)
        print(f"{len(header['cameras'])} cameras, objects kept on average: "
              + ", ".join(f"{m} {np.mean(n):.1f}" for m, n in kept.items()) + f"; hidden wrongly: {wrong}; from within solids: {within}")
        if given.region:
            proven = shoot_region(dump_file, scene, given.rays, given.seed)
            missing = judge_region(proven, pvs_matrix(given.scene, given.region, Path(folder) / "matrix.txt"))
            print(f"from-region, {given.region}: {proven['rays']} rays prove {len(proven['pairs'])} ordered pairs of cells, "
                  f"{len(missing)} missing in the matrix")
            for pair in missing[:10]:
                print(f"   cell {pair['from_volume']} sees {pair['to_volume']}: {pair['rays']} rays, from {pair['from']} to "
                      f"{pair['to']}")
            wrong += len(missing)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
