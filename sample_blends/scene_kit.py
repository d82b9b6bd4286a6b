# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, cameras, a camera path, and the settings of the scene itself."""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
from building_kit import Piece
from mathutils import Euler, Vector
from mesh_kit import Vec3


def sun(name: str, degrees: Vec3, strength: float, where: bpy.types.Collection) -> bpy.types.Object:
    light = bpy.data.lights.new(name, "SUN")
    light.energy = strength
    light.angle = math.radians(1.0)
    light.color = (1.0, 0.95, 0.87)
    made = Piece(name, light, where, (-6.0, -10.0, 14.0)).make()
    # Blender's sun shines along its local -z.
    made.rotation_euler = Euler([math.radians(a) for a in (degrees[0], degrees[1], -degrees[2])])
    return made


def point_light(name: str, place: Vec3, watts: float, where: bpy.types.Collection) -> bpy.types.Object:
    light = bpy.data.lights.new(name, "POINT")
    light.energy = watts
    light.shadow_soft_size = 0.08
    light.color = (1.0, 0.86, 0.70)
    return Piece(name, light, where, place).make()


def _aim(direction: Vector) -> Euler:
    return direction.to_track_quat("-Z", "Y").to_euler()


def look_at(name: str, eye: Vec3, target: Vec3, lens: float, where: bpy.types.Collection) -> bpy.types.Object:
    camera = bpy.data.cameras.new(name)
    camera.lens = lens
    camera.clip_start = 0.05
    camera.clip_end = 500.0
    made = Piece(name, camera, where, eye).make()
    made.rotation_euler = _aim(Vector(target) - Vector(eye))
    return made


class Path:
    """A smooth way through points, asked for by its length."""

    def __init__(self, points: Sequence[Vector]) -> None:
        self.points = list(points)
        self.lengths = [0.0]
        for a, b in zip(self.points, self.points[1:], strict=False):
            self.lengths.append(self.lengths[-1] + (b - a).length)

    @property
    def length(self) -> float:
        return self.lengths[-1]

    def at(self, s: float) -> Vector:
        s = min(max(s, 0.0), self.length)
        low, high = 0, len(self.points) - 2
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if self.lengths[middle] <= s else (low, middle - 1)
        span = self.lengths[low + 1] - self.lengths[low]
        t = (s - self.lengths[low]) / span if span else 0.0
        return self.points[low].lerp(self.points[low + 1], t)

    def animate(self, camera: bpy.types.Object, frames: int, every: int, ahead: float) -> None:
        """Keyframes along the path at even speed; the camera looks at where it will be in `ahead` metres."""
        before: Euler | None = None
        heading = Vector((0.0, 1.0, 0.0))
        for frame in [*range(1, frames, every), frames]:
            s = self.length * (frame - 1) / (frames - 1)
            eye = self.at(s)
            towards = self.at(s + ahead) - eye
            if towards.length > 0.3:
                heading = towards
            heading = Vector((heading.x, heading.y, heading.z * 0.5 - 0.05))
            turn = _aim(heading)
            if before is not None:
                turn.make_compatible(before)
            before = turn
            camera.location = eye
            camera.rotation_euler = turn
            camera.keyframe_insert("location", frame=frame)
            camera.keyframe_insert("rotation_euler", frame=frame)


def catmull_rom(points: Sequence[Vec3], steps: int = 12) -> Path:
    """A centripetal-looking curve through all points, as a fine polyline."""
    p = [Vector(q) for q in points]
    p = [2 * p[0] - p[1], *p, 2 * p[-1] - p[-2]]
    curve = []
    for i in range(1, len(p) - 2):
        a, b, c, d = p[i - 1], p[i], p[i + 1], p[i + 2]
        for k in range(steps):
            t = k / steps
            curve.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t
                                + (3 * b - a - 3 * c + d) * t ** 3))
    curve.append(p[-2])
    return Path(curve)


def empty_scene() -> None:
    """Takes the start-up cube, lamp and camera away."""
    for made in list(bpy.data.objects):
        bpy.data.objects.remove(made)
    for made in list(bpy.data.collections):
        bpy.data.collections.remove(made)
    for block in (bpy.data.meshes, bpy.data.lights, bpy.data.cameras, bpy.data.materials):
        for made in list(block):
            block.remove(made)


def set_up_scene(camera: bpy.types.Object, frames: int = 1, resolution: tuple[int, int] = (960, 540),
                 ambient: float = 0.0) -> None:
    """ambient: strength of a soft fill from short occlusion rays; rooms with little daylight need it to look calm."""
    scene = bpy.context.scene
    scene.name = "Scene"
    scene.camera = camera
    scene.frame_start, scene.frame_end = 1, frames
    scene.frame_set(1)
    scene.unit_settings.system = "METRIC"
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = resolution
    cycles = scene.cycles
    cycles.samples = 64
    cycles.use_adaptive_sampling = True
    cycles.max_bounces = 8
    cycles.diffuse_bounces = 4
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect = 4.0
    cycles.blur_glossy = 0.5
    _sky(scene)
    if ambient:
        cycles.use_fast_gi = True
        cycles.fast_gi_method = "ADD"
        scene.world.light_settings.ao_factor = ambient
        scene.world.light_settings.distance = 3.0
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.shading.type = "SOLID"
                    space.shading.color_type = "MATERIAL"
                    space.clip_end = 2000.0
                    space.clip_start = 0.05
                    if space.region_3d:
                        space.region_3d.view_perspective = "CAMERA"


def _sky(scene: bpy.types.Scene) -> None:
    """A gradient from a pale horizon to blue: no image, no model that changes between Blender versions."""
    world = bpy.data.worlds[0] if bpy.data.worlds else bpy.data.worlds.new("World")
    scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputWorld")
    background = tree.nodes.new("ShaderNodeBackground")
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], split.inputs[0])
    tree.links.new(split.outputs["Z"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Strength"].default_value = 1.1
    stops = ramp.color_ramp.elements
    stops[0].position, stops[0].color = 0.0, (0.78, 0.82, 0.85, 1.0)
    stops[1].position, stops[1].color = 0.6, (0.23, 0.42, 0.72, 1.0)
