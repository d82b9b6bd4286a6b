# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender materials and lights in the few words that previews know: a colour, mirror, glass, glow; point, spot, area, sun.

Textures and procedural colours become their mean. What can't be told stays diffuse and opaque, as Cycles' object index has it.
"""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

from ..compat import lamps_as_before_4, power_of

GREY = (0.6, 0.6, 0.6)
SEEN_THROUGH = 0.5  # Cycles' own threshold of alpha for its depth and index passes
MIRROR_ROUGHNESS = 0.08  # rougher metal blurs what it reflects: drawn as its colour
DEEPEST = 12  # nodes followed up one link


def _socket(node: bpy.types.Node, *names: str) -> Any:
    """The first input of these names: sockets of the Principled node were renamed in Blender 4.0."""
    for name in names:
        if name in node.inputs:
            return node.inputs[name]
    return None


def _number(socket: Any, otherwise: float) -> float:
    return otherwise if socket is None or socket.is_linked else float(socket.default_value)


def mean_colour(socket: Any, depth: int = 0) -> tuple[float, float, float]:
    """The mean of what feeds a colour socket, linear RGB."""
    if socket is None:
        return GREY
    if not socket.is_linked or depth > DEEPEST:
        value = socket.default_value
        return tuple(float(v) for v in value[:3]) if hasattr(value, "__len__") else (float(value),) * 3
    node = socket.links[0].from_node
    if node.type == "RGB":
        return tuple(float(v) for v in node.outputs[0].default_value[:3])
    if node.type == "VALTORGB":
        elements = [e.color[:3] for e in node.color_ramp.elements]
        return tuple(float(v) for v in np.mean(elements, axis=0)) if elements else GREY
    if node.type == "TEX_IMAGE":
        return _image_mean(node.image)
    if node.type in ("MIX_RGB", "MIX"):
        colours = [s for s in node.inputs if s.type == "RGBA" and s.enabled]
        share = next((s for s in node.inputs if s.type == "VALUE" and s.enabled), None)
        if len(colours) >= 2:
            t = min(1.0, max(0.0, _number(share, 0.5)))
            a, b = (np.array(mean_colour(s, depth + 1)) for s in colours[:2])
            return tuple(float(v) for v in (1 - t) * a + t * b)
    for other in node.inputs:
        if other.type == "RGBA":
            return mean_colour(other, depth + 1)
    return GREY


def _image_mean(image: bpy.types.Image | None) -> tuple[float, float, float]:
    if image is None or image.size[0] == 0 or image.size[0] * image.size[1] > 16_000_000:
        return GREY
    pixels = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
    try:
        image.pixels.foreach_get(pixels)
    except RuntimeError:
        return GREY
    pixels = pixels.reshape(-1, image.channels)
    mean = pixels[:: max(1, len(pixels) // 65536), : min(3, image.channels)].mean(axis=0)
    return tuple(float(v) for v in np.resize(mean, 3))


def describe(material: bpy.types.Material | None) -> dict[str, Any]:
    """kind, colour, emission, ior: the arguments of enfilade_native.Material."""
    if material is None:
        return {"kind": "diffuse", "colour": (0.8, 0.8, 0.8)}
    tree = material.node_tree if material.use_nodes else None
    output = None
    if tree is not None:
        outputs = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"]
        output = next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)
    if output is None or not output.inputs["Surface"].is_linked:
        return {"kind": "diffuse", "colour": tuple(material.diffuse_color[:3])}
    found = _shader(output.inputs["Surface"].links[0].from_node, 0)
    clear = found.pop("clear", 0.0)
    if clear > SEEN_THROUGH:
        found["kind"] = "clear"
    return found


def _shader(node: bpy.types.Node, depth: int) -> dict[str, Any]:
    """The arguments of a material, and `clear`: the share of light that goes straight through."""
    if node.type == "BSDF_PRINCIPLED":
        return _principled(node)
    if node.type == "EMISSION":
        strength = _number(node.inputs["Strength"], 1.0)
        colour = mean_colour(node.inputs["Color"])
        return {"kind": "diffuse", "colour": (0.0, 0.0, 0.0), "emission": tuple(strength * c for c in colour)}
    if node.type in ("BSDF_GLASS", "BSDF_REFRACTION"):
        return {"kind": "glass", "colour": mean_colour(node.inputs["Color"]), "ior": max(1.0, _number(node.inputs["IOR"], 1.45))}
    if node.type == "BSDF_TRANSPARENT":
        return {"kind": "diffuse", "colour": mean_colour(node.inputs["Color"]), "clear": 1.0}
    if node.type in ("BSDF_GLOSSY", "BSDF_ANISOTROPIC"):
        mirror = _number(node.inputs["Roughness"], 1.0) <= MIRROR_ROUGHNESS
        return {"kind": "mirror" if mirror else "diffuse", "colour": mean_colour(node.inputs["Color"])}
    if node.type in ("MIX_SHADER", "ADD_SHADER") and depth < DEEPEST:
        parts = [s.links[0].from_node for s in node.inputs if s.type == "SHADER" and s.is_linked]
        if len(parts) == 2:
            t = min(1.0, max(0.0, _number(node.inputs[0], 0.5))) if node.type == "MIX_SHADER" else 0.5
            a, b = _shader(parts[0], depth + 1), _shader(parts[1], depth + 1)
            out = dict(a if t < 0.5 else b)
            out["clear"] = (1 - t) * a.get("clear", 0.0) + t * b.get("clear", 0.0)
            glow = np.zeros(3)
            for part, share in ((a, 1 - t), (b, t)):
                glow += (1.0 if node.type == "ADD_SHADER" else share) * np.array(part.get("emission", (0.0, 0.0, 0.0)))
            out["emission"] = tuple(float(v) for v in glow)
            return out
        if parts:
            return _shader(parts[0], depth + 1)
    if node.type == "GROUP":
        return {"kind": "diffuse", "colour": GREY}
    return {"kind": "diffuse", "colour": mean_colour(_socket(node, "Color", "Base Color"))}


def _principled(node: bpy.types.Node) -> dict[str, Any]:
    colour = mean_colour(node.inputs["Base Color"])
    glow = _socket(node, "Emission Color", "Emission")
    strength = _number(_socket(node, "Emission Strength"), 1.0)
    out: dict[str, Any] = {"kind": "diffuse", "colour": colour,
                           "emission": tuple(strength * c for c in mean_colour(glow)) if glow is not None else (0.0, 0.0, 0.0),
                           "clear": 1.0 - _number(_socket(node, "Alpha"), 1.0)}
    rough = _number(node.inputs["Roughness"], 0.5)
    if _number(_socket(node, "Transmission Weight", "Transmission"), 0.0) >= 0.5:
        out["kind"], out["ior"] = "glass", max(1.0, _number(node.inputs["IOR"], 1.45))
    elif _number(node.inputs["Metallic"], 0.0) >= 0.9 and rough <= MIRROR_ROUGHNESS:
        out["kind"] = "mirror"
    return out


def light_form(data: bpy.types.Light, matrix: np.ndarray) -> dict[str, Any]:
    """Where a light is and which way it shines: the arguments of enfilade_native.Light but for what it gives. Empty where that can't be
    told. matrix: float64 (4, 4)."""
    axes = matrix[:3, :3]
    direction = -axes[:, 2]
    if not np.isfinite(matrix).all() or not np.linalg.norm(direction) > 0:
        return {}
    out: dict[str, Any] = {"kind": data.type, "position": tuple(matrix[:3, 3].tolist()), "direction": tuple(direction.tolist())}
    if data.type in ("POINT", "SPOT"):
        out["radius"] = float(data.shadow_soft_size)
        if data.type == "SPOT":
            out["spot_angle"], out["spot_blend"] = float(data.spot_size), float(data.spot_blend)
            out["cosine"] = lamps_as_before_4()
    elif data.type == "AREA":
        wide = float(data.size)
        tall = float(data.size_y) if data.shape in ("RECTANGLE", "ELLIPSE") else wide
        out["ellipse"] = data.shape in ("DISK", "ELLIPSE")
        out["spread"] = min(math.pi, max(1e-3, float(data.spread)))
        out["sides"] = tuple(tuple((0.5 * length * axes[:, k]).tolist()) for k, length in enumerate((wide, tall)))
    else:
        out["radius"] = 0.5 * float(data.angle)
        if out["radius"] >= 0.5 * math.pi:
            return {}
    return out


def describe_light(data: bpy.types.Light, matrix: np.ndarray) -> dict[str, Any] | None:
    """The arguments of enfilade_native.Light; None: it gives nothing. matrix: float64 (4, 4)."""
    out = light_form(data, matrix)
    colour = power_of(data)
    if not out or not np.isfinite(colour).all() or colour.max() <= 0.0:
        return None  # a negative lamp takes light away: no preview does
    colour = np.maximum(colour, 0.0)
    if data.type in ("POINT", "SPOT"):
        colour = colour / (4.0 * math.pi)  # watts over the whole sphere, a spot's cone being cut out of it
    elif data.type == "AREA":
        area = float(np.linalg.norm(np.cross(*out["sides"]))) * (math.pi if out["ellipse"] else 4.0)
        if not area > 0.0:
            return None
        colour = colour / ((4.0 if lamps_as_before_4() else math.pi) * area)
    out["intensity"] = tuple(colour.tolist())
    return out
