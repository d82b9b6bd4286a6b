# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials of the sample buildings: calm, procedural, no image files."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

Colour = tuple[float, float, float]


def set_input(node: bpy.types.Node, names: Sequence[str], value: object) -> None:
    """Sets the first input that exists: sockets of the Principled BSDF were renamed in Blender 4.0."""
    for name in names:
        if name in node.inputs:
            node.inputs[name].default_value = value
            return


class Palette:
    """Makes each material when it is first asked for."""

    def __init__(self) -> None:
        self._made: dict[str, bpy.types.Material] = {}

    def __getattr__(self, name: str) -> bpy.types.Material:
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._made:
            self._made[name] = self._make(name)
        return self._made[name]

    def _make(self, name: str) -> bpy.types.Material:
        if name in PLAIN:
            colour, roughness, metallic = PLAIN[name]
            return plain(TITLES.get(name, name.replace("_", " ").capitalize()), colour, roughness, metallic)
        if name in BOARDS:
            return boards(name.replace("_", " ").capitalize(), *BOARDS[name])
        if name == "glass":
            return glass("Glass")
        if name in GLOW:
            colour, strength = GLOW[name]
            return glow(name.replace("_", " ").capitalize(), colour, strength)
        raise AttributeError(f"no material {name!r}")


# name: colour (linear RGB), roughness, metallic
PLAIN: dict[str, tuple[Colour, float, float]] = {
    "plaster": ((0.74, 0.71, 0.66), 0.9, 0.0),
    "plaster_white": ((0.82, 0.81, 0.79), 0.9, 0.0),
    "plaster_sage": ((0.42, 0.47, 0.38), 0.9, 0.0),
    "plaster_blue": ((0.36, 0.44, 0.50), 0.9, 0.0),
    "plaster_clay": ((0.56, 0.38, 0.28), 0.9, 0.0),
    "ceiling": ((0.85, 0.85, 0.84), 0.95, 0.0),
    "render": ((0.80, 0.77, 0.71), 0.95, 0.0),
    "concrete": ((0.42, 0.41, 0.39), 0.85, 0.0),
    "plinth": ((0.24, 0.235, 0.23), 0.9, 0.0),
    "roof": ((0.085, 0.088, 0.095), 0.55, 0.0),
    "frame_dark": ((0.06, 0.062, 0.065), 0.45, 0.0),
    "white_paint": ((0.78, 0.77, 0.75), 0.4, 0.0),
    "oak": ((0.40, 0.25, 0.13), 0.5, 0.0),
    "walnut": ((0.13, 0.07, 0.04), 0.45, 0.0),
    "linen": ((0.62, 0.57, 0.50), 0.95, 0.0),
    "wool_grey": ((0.22, 0.23, 0.24), 0.95, 0.0),
    "fabric_teal": ((0.05, 0.17, 0.18), 0.9, 0.0),
    "fabric_ochre": ((0.50, 0.27, 0.06), 0.9, 0.0),
    "rug": ((0.50, 0.42, 0.34), 1.0, 0.0),
    "carpet": ((0.16, 0.18, 0.20), 1.0, 0.0),
    "steel": ((0.58, 0.58, 0.58), 0.28, 1.0),
    "brass": ((0.55, 0.37, 0.13), 0.3, 1.0),
    "black": ((0.015, 0.015, 0.016), 0.35, 0.0),
    "porcelain": ((0.85, 0.85, 0.84), 0.12, 0.0),
    "stone_top": ((0.10, 0.10, 0.105), 0.25, 0.0),
    "cabinet": ((0.20, 0.25, 0.22), 0.55, 0.0),
    "leaf": ((0.055, 0.14, 0.035), 0.7, 0.0),
    "leaf_dark": ((0.03, 0.085, 0.03), 0.7, 0.0),
    "bark": ((0.10, 0.065, 0.04), 0.9, 0.0),
    "terracotta": ((0.42, 0.16, 0.08), 0.8, 0.0),
    "lawn": ((0.10, 0.17, 0.045), 1.0, 0.0),
    "gravel": ((0.36, 0.34, 0.31), 1.0, 0.0),
    "paper_red": ((0.32, 0.06, 0.05), 0.8, 0.0),
    "paper_blue": ((0.06, 0.11, 0.22), 0.8, 0.0),
    "paper_cream": ((0.66, 0.60, 0.47), 0.8, 0.0),
    "screen": ((0.02, 0.025, 0.03), 0.15, 0.0),
    "mirror": ((0.85, 0.86, 0.86), 0.02, 1.0),
    "art_a": ((0.45, 0.30, 0.20), 0.8, 0.0),
    "art_b": ((0.16, 0.26, 0.30), 0.8, 0.0),
}
TITLES = {"plaster": "Plaster warm", "art_a": "Print A", "art_b": "Print B"}

# name: two colours, joint colour, board length and width in metres, roughness, "flat" | "upright"
BOARDS: dict[str, tuple[Colour, Colour, Colour, float, float, float, str]] = {
    "oak_floor": ((0.36, 0.23, 0.125), (0.29, 0.175, 0.09), (0.12, 0.07, 0.04), 1.4, 0.16, 0.42, "flat"),
    "tile_floor": ((0.46, 0.45, 0.43), (0.43, 0.42, 0.40), (0.28, 0.27, 0.26), 0.6, 0.6, 0.3, "flat"),
    "tile_wall": ((0.70, 0.73, 0.72), (0.66, 0.70, 0.69), (0.48, 0.49, 0.48), 0.20, 0.20, 0.18, "wall"),
    "larch": ((0.34, 0.205, 0.115), (0.27, 0.155, 0.085), (0.07, 0.04, 0.025), 3.2, 0.14, 0.75, "upright"),
    "paving": ((0.42, 0.40, 0.37), (0.37, 0.355, 0.33), (0.20, 0.19, 0.17), 0.8, 0.4, 0.9, "flat"),
}
GLOW: dict[str, tuple[Colour, float]] = {"lamp_shade": ((1.0, 0.85, 0.66), 2.0), "panel_light": ((1.0, 0.96, 0.90), 6.0)}


def _new(name: str) -> tuple[bpy.types.Material, bpy.types.NodeTree]:
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # always there in newer versions, where setting use_nodes is deprecated
        material.use_nodes = True
    return material, material.node_tree


def _principled(tree: bpy.types.NodeTree) -> bpy.types.Node:
    return next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")


def _output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    return next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")


def plain(name: str, colour: Colour, roughness: float, metallic: float) -> bpy.types.Material:
    material, tree = _new(name)
    node = _principled(tree)
    set_input(node, ["Base Color"], (*colour, 1.0))
    set_input(node, ["Roughness"], roughness)
    set_input(node, ["Metallic"], metallic)
    set_input(node, ["Specular IOR Level", "Specular"], 0.3)
    material.diffuse_color = (*colour, 1.0)
    material.roughness = roughness
    material.metallic = metallic
    return material


def boards(name: str, a: Colour, b: Colour, joint: Colour, length: float, width: float, roughness: float,
           lie: str) -> bpy.types.Material:
    """Boards or tiles in world coordinates, so the pattern runs on from one object to the next."""
    material, tree = _new(name)
    node = _principled(tree)
    set_input(node, ["Roughness"], roughness)
    set_input(node, ["Specular IOR Level", "Specular"], 0.3)
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    brick = tree.nodes.new("ShaderNodeTexBrick")
    set_input(brick, ["Color1"], (*a, 1.0))
    set_input(brick, ["Color2"], (*b, 1.0))
    set_input(brick, ["Mortar"], (*joint, 1.0))
    set_input(brick, ["Scale"], 1.0)
    set_input(brick, ["Mortar Size"], 0.004)
    set_input(brick, ["Mortar Smooth"], 0.1)
    set_input(brick, ["Brick Width"], length)
    set_input(brick, ["Row Height"], width)
    if lie == "flat":
        tree.links.new(geometry.outputs["Position"], brick.inputs["Vector"])
    else:
        # On walls along x or y the sum x + y runs along the wall.
        split = tree.nodes.new("ShaderNodeSeparateXYZ")
        along = tree.nodes.new("ShaderNodeMath")
        along.operation = "ADD"
        join = tree.nodes.new("ShaderNodeCombineXYZ")
        tree.links.new(geometry.outputs["Position"], split.inputs[0])
        tree.links.new(split.outputs["X"], along.inputs[0])
        tree.links.new(split.outputs["Y"], along.inputs[1])
        first, second = (split.outputs["Z"], along.outputs[0]) if lie == "upright" else (along.outputs[0],
                                                                                        split.outputs["Z"])
        tree.links.new(first, join.inputs["X"])
        tree.links.new(second, join.inputs["Y"])
        tree.links.new(join.outputs[0], brick.inputs["Vector"])
    tree.links.new(brick.outputs["Color"], node.inputs["Base Color"])
    material.diffuse_color = (*a, 1.0)
    material.roughness = roughness
    return material


def glass(name: str) -> bpy.types.Material:
    """Window glass as one pane: mostly transparent, so sunlight and camera rays go straight through."""
    material, tree = _new(name)
    tree.nodes.remove(_principled(tree))
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    clear.inputs["Color"].default_value = (0.93, 0.96, 0.95, 1.0)
    gloss = tree.nodes.new("ShaderNodeBsdfGlossy")
    gloss.inputs["Roughness"].default_value = 0.0
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.06
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(gloss.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], _output(tree).inputs["Surface"])
    material.diffuse_color = (0.75, 0.87, 0.90, 0.25)
    if hasattr(material, "surface_render_method"):
        material.surface_render_method = "BLENDED"
    elif hasattr(material, "blend_method"):
        material.blend_method = "BLEND"
        material.shadow_method = "NONE"
    return material


def glow(name: str, colour: Colour, strength: float) -> bpy.types.Material:
    material, tree = _new(name)
    node = _principled(tree)
    set_input(node, ["Base Color"], (*colour, 1.0))
    set_input(node, ["Emission Color", "Emission"], (*colour, 1.0))
    set_input(node, ["Emission Strength"], strength)
    material.diffuse_color = (*colour, 1.0)
    # Thousands of lit panels would share the light samples among them: they are found by bounces instead.
    if hasattr(material.cycles, "emission_sampling"):
        material.cycles.emission_sampling = "NONE"
    else:
        material.cycles.sample_as_light = False
    return material
