# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews inside Blender: every type of camera against Cycles, materials and lamps as they are read, files and the button."""

from __future__ import annotations

import json
import math

import bpy
import numpy as np
import pytest
from enfilade import commands, compat, native
from enfilade.report import images, preview_files
from enfilade.rules.building import Building, Object
from enfilade.scene import extract_drawn, extract_materials, preview
from enfilade.scene.preview import Previewer, largest_first
from mathutils import Euler


def fill(camera: str = "PERSP", **settings):
    """A room of walls with things in it, one camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 1.5), scale=(6, 5, 3))
    bpy.context.object.name = "Walls"
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.6, location=(1.2, 0.7, 0.8))
    bpy.ops.mesh.primitive_torus_add(location=(-1.4, 1.2, 1.1), rotation=(0.4, 0.3, 0))
    bpy.ops.mesh.primitive_cone_add(location=(0.3, -1.6, 0.9))
    data = bpy.data.cameras.new("Camera")
    data.type = camera
    for name, value in settings.items():
        setattr(data if hasattr(data, name) else data.cycles, name, value)
    obj = bpy.data.objects.new("Camera", data)
    obj.location, obj.rotation_euler = (-2.3, -1.9, 1.7), Euler((math.radians(82), 0.05, math.radians(-52)))
    scene.collection.objects.link(obj)
    scene.camera = obj
    bpy.context.view_layer.update()
    return scene


def run(*arguments) -> dict:
    lines = []
    assert commands.main(list(arguments), lines.append) == 0
    return json.loads(lines[0])


CAMERAS = [
    ("PERSP", {"lens": 24.0, "shift_x": 0.13, "shift_y": -0.07, "sensor_fit": "VERTICAL", "sensor_height": 20.0}),
    ("ORTHO", {"ortho_scale": 4.2, "shift_x": 0.1}),
    ("PANO", {"panorama_type": "EQUIRECTANGULAR"}),
    ("PANO", {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": math.radians(170)}),
    ("PANO", {"panorama_type": "FISHEYE_EQUISOLID", "fisheye_fov": math.radians(150), "fisheye_lens": 9.0}),
    ("PANO", {"panorama_type": "MIRRORBALL"}),
    ("PANO", {"panorama_type": "FISHEYE_LENS_POLYNOMIAL", "fisheye_fov": math.radians(140), "fisheye_polynomial_k1": -0.06,
              "fisheye_polynomial_k2": 2e-4}),
    ("PANO", {"panorama_type": "EQUIANGULAR_CUBEMAP_FACE"}),
]
if bpy.app.version >= (4, 3, 0):
    CAMERAS.append(("PANO", {"panorama_type": "CENTRAL_CYLINDRICAL", "central_cylindrical_range_u_min": -2.0,
                             "central_cylindrical_range_v_max": 1.5, "central_cylindrical_radius": 1.2}))


@pytest.mark.parametrize(("kind", "settings"), CAMERAS, ids=[s.get("panorama_type", k) for k, s in CAMERAS])
def test_depth_and_objects_are_those_of_cycles(kind, settings, tmp_path):
    fill(kind, **settings)
    result = run("preview", "--out", str(tmp_path), "--resolution", "160x100", "--verify", "--passes", "shaded", "--no-lights")
    found = result["verify"][0]
    assert found["equal"], found
    assert found["objects_different"] <= 0.002 * found["pixels"]
    assert found["depth_worst_off_edges"] < 1e-4


@pytest.mark.parametrize("convergence", ["OFFAXIS", "PARALLEL", "TOE"])
def test_both_eyes_of_a_stereo_pair_see_what_cycles_has_them_see(convergence, tmp_path):
    scene = fill("PERSP", lens=24.0, shift_x=0.05)
    scene.render.use_multiview, scene.render.views_format = True, "STEREO_3D"
    stereo = scene.camera.data.stereo
    stereo.convergence_mode, stereo.pivot = convergence, "LEFT"
    stereo.interocular_distance, stereo.convergence_distance = 0.3, 2.5
    result = run("preview", "--out", str(tmp_path), "--resolution", "120x80", "--verify", "--passes", "depth", "--no-lights", "--no-exr")
    assert {"Camera-left_depth.png", "Camera-right_depth.png"} <= set(result["files"])
    assert [v["camera"] for v in result["verify"]] == ["Camera left", "Camera right"]
    for found in result["verify"]:
        assert found["equal"] and found["depth_worst_off_edges"] < 1e-4, found
    depths = [images.read_image(tmp_path / f"Camera-{eye}_depth.png").pixels for eye in ("left", "right")]
    assert (depths[0] != depths[1]).any()


def test_files_hold_layers_names_and_what_made_them(tmp_path):
    scene = fill()
    light = bpy.data.lights.new("Lamp", "POINT")
    light.energy = 100
    lamp = bpy.data.objects.new("Lamp", light)
    lamp.location = (0, 0, 2.5)
    scene.collection.objects.link(lamp)
    result = run("preview", "--out", str(tmp_path), "--resolution", "120x80")
    assert result["lights"] == 1 and result["pictures"][0]["objects"] == 4
    assert {"Camera.exr", "Camera_shaded.png", "Camera_rooms.png", "Camera_depth.png", "contact_sheet.png"} <= set(result["files"])
    picture = images.read_image(tmp_path / "Camera.exr")
    named = dict(zip(picture.channels, np.moveaxis(picture.pixels, 2, 0), strict=True))
    assert {"R", "Depth.Z", "Normal.X", "Lights.V", "Openings.V", "CryptoObject00.R", "CryptoObject00.G"} <= set(named)
    assert named["Lights.V"].max() == 1
    spec = images.oiio.ImageInput.open(str(tmp_path / "Camera.exr")).spec()
    about = {a.name: a.value for a in spec.extra_attribs if a.name.startswith("cryptomatte/")}
    key = next(k for k, v in about.items() if v == "CryptoObject").removesuffix("/name")
    codes = json.loads(about[f"{key}/manifest"])
    assert {"Walls", "Sphere", "Torus", "Cone"} == set(codes)
    wall = np.array([int(codes["Walls"], 16)], np.uint32).view(np.float32)[0]
    assert (named["CryptoObject00.R"] == wall).mean() > 0.3
    shares = named["CryptoObject00.G"] + named["CryptoObject00.A"]
    assert shares.max() <= 1.001 and (shares[named["A"] > 0] > 0.6).all()


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="the compositor's tree is a node group from 5.0")
def test_the_compositor_picks_an_object_by_its_name(tmp_path):
    fill()
    run("preview", "--out", str(tmp_path), "--resolution", "64x48", "--passes", "shaded", "--no-lights")
    picture = images.read_image(tmp_path / "Camera.exr")
    named = dict(zip(picture.channels, np.moveaxis(picture.pixels, 2, 0), strict=True))
    torus = np.array([preview_files.crypto_number("Torus")], np.uint32).view(np.float32)[0]
    share = sum(np.where(named[f"CryptoObject0{k // 2}.{'RB'[k % 2]}"] == torus, named[f"CryptoObject0{k // 2}.{'GA'[k % 2]}"], 0) for k in range(4))
    scene = bpy.context.scene
    assert compat.use_cycles(scene)
    scene.cycles.samples, scene.cycles.use_denoising, scene.use_nodes = 1, False, True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
    scene.node_tree.nodes.clear()
    matte, out = (scene.node_tree.nodes.new(f"CompositorNode{n}") for n in ("CryptomatteV2", "Composite"))
    matte.source, matte.image = "IMAGE", bpy.data.images.load(str(tmp_path / "Camera.exr"))
    matte.layer_name, matte.matte_id = "CryptoObject", "Torus"
    scene.node_tree.links.new(matte.outputs["Matte"], out.inputs[0])
    compat.set_multilayer_exr(scene.render.image_settings)
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.use_file_extension, scene.render.filepath = False, str(tmp_path / "matte.exr")
    bpy.ops.render.render(write_still=True)
    found = images.read_image(tmp_path / "matte.exr").pixels[..., 0]
    assert share.sum() > 50 and np.abs(found - share).max() < 1e-3


def test_numbers_of_names_are_cryptomattes():
    # values of the reference implementation of MurmurHash3 (x86, 32 bits)
    assert preview_files.murmur3(b"") == 0
    assert preview_files.murmur3(b"hello") == 0x248BFA47
    assert preview_files.murmur3(b"hello, world") == 0x149BBB7F


def node_material(build):
    material = bpy.data.materials.new("M")
    material.use_nodes = True
    tree = material.node_tree
    for node in [n for n in tree.nodes if n.type != "OUTPUT_MATERIAL"]:
        tree.nodes.remove(node)
    output = tree.nodes["Material Output"]
    tree.links.new(build(tree).outputs[0], output.inputs["Surface"])
    return material


def test_materials_in_few_words():
    bpy.ops.wm.read_factory_settings(use_empty=True)

    def pane(tree):
        mix = tree.nodes.new("ShaderNodeMixShader")
        mix.inputs[0].default_value = 0.1
        for socket, kind in ((1, "ShaderNodeBsdfTransparent"), (2, "ShaderNodeBsdfGlossy")):
            tree.links.new(tree.nodes.new(kind).outputs[0], mix.inputs[socket])
        return mix

    def mirror(tree):
        node = tree.nodes.new("ShaderNodeBsdfGlossy")
        node.inputs["Roughness"].default_value = 0.0
        return node

    def ramp(tree):
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        colours = tree.nodes.new("ShaderNodeValToRGB")
        colours.color_ramp.elements[0].color = (1, 0, 0, 1)
        colours.color_ramp.elements[1].color = (0, 0, 1, 1)
        tree.links.new(colours.outputs[0], node.inputs["Base Color"])
        return node

    assert extract_materials.describe(node_material(pane))["kind"] == "clear"
    assert extract_materials.describe(node_material(mirror))["kind"] == "mirror"
    assert extract_materials.describe(node_material(lambda t: t.nodes.new("ShaderNodeBsdfGlass")))["kind"] == "glass"
    assert extract_materials.describe(node_material(ramp))["colour"] == pytest.approx((0.5, 0, 0.5))
    assert extract_materials.describe(None)["kind"] == "diffuse"


def test_lamps_give_what_blender_says():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    eye = np.eye(4)
    light = bpy.data.lights.new("L", "AREA")
    light.energy, light.shape, light.size, light.size_y = 10.0, "RECTANGLE", 2.0, 0.5
    made = extract_materials.describe_light(light, eye)
    assert made["intensity"] == pytest.approx((10 / (4 if bpy.app.version < (4, 0, 0) else math.pi),) * 3) and made["direction"] == (0, 0, -1)
    light.type = "SPOT"
    made = extract_materials.describe_light(bpy.data.lights["L"], eye)
    assert made["intensity"] == pytest.approx((10 / (4 * math.pi),) * 3)
    bpy.data.lights["L"].energy = -5
    assert extract_materials.describe_light(bpy.data.lights["L"], eye) is None
    assert extract_materials.describe_light(bpy.data.lights["L"], np.full((4, 4), np.nan)) is None


LAMPS = [
    ("POINT", {"shadow_soft_size": 0.2}),
    ("SPOT", {"spot_size": math.radians(70), "spot_blend": 0.3, "shadow_soft_size": 0.0}),
    ("AREA", {"shape": "ELLIPSE", "size": 1.2, "size_y": 0.4}),
    ("AREA", {"shape": "SQUARE", "size": 0.5, "spread": math.radians(80)}),
    ("SUN", {"angle": math.radians(10)}),
]


@pytest.mark.parametrize(("kind", "settings"), LAMPS, ids=["point", "spot", "area", "spread", "sun"])
def test_lamps_light_as_in_cycles(kind, settings, tmp_path):
    scene = fill("ORTHO", ortho_scale=5.0)
    bpy.data.objects.remove(scene.objects["Walls"])
    bpy.ops.mesh.primitive_plane_add(size=20)
    white = node_material(lambda tree: tree.nodes.new("ShaderNodeBsdfDiffuse"))
    for obj in [o for o in scene.objects if o.type == "MESH"]:
        obj.data.materials.append(white)
    scene.camera.location, scene.camera.rotation_euler = (0.0, 0.0, 9.0), (0.0, 0.0, 0.0)
    data = bpy.data.lights.new("Lamp", kind)
    data.energy = 3.0 if kind == "SUN" else 100.0
    for name, value in settings.items():
        setattr(data, name, value)
    lamp = bpy.data.objects.new("Lamp", data)
    lamp.location, lamp.rotation_euler = (0.3, 0.2, 3.0), (0.2, 0.1, 0.0)
    scene.collection.objects.link(lamp)
    bpy.context.view_layer.update()
    assert compat.use_cycles(scene)
    compat.disable_compositing(scene)
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_adaptive_sampling = 48, 0, False
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.render.resolution_percentage = 100
    compat.set_multilayer_exr(scene.render.image_settings)
    scene.render.use_file_extension, scene.render.filepath = False, str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    theirs = images.read_image(tmp_path / "cycles.exr").pixels[..., :3].mean(axis=2)
    dark = {"sky": (0, 0, 0), "ground": (0, 0, 0), "background": ((0, 0, 0), (0, 0, 0))}
    previewer = Previewer(native.load(), scene, None, options={"light_samples": 32, "max_bounces": 0, **dark})
    mine = previewer.render(scene.camera, 48, 48).layers.direct.mean(axis=2)
    lit = (mine > 0.1 * mine.max()) & (theirs > 0.1 * theirs.max())
    assert lit.mean() > 0.05
    assert np.median(mine[lit] / theirs[lit]) == pytest.approx(1.0, abs=0.01)
    assert mine.sum() == pytest.approx(theirs.sum(), rel=0.02)


def test_what_isnt_rendered_isnt_drawn():
    scene = fill()
    scene.objects["Torus"].hide_render = True
    bpy.context.view_layer.update()
    drawn = extract_drawn.extract(native.load(), bpy.context.evaluated_depsgraph_get(), None, np.zeros(3))
    assert set(drawn.names) == {"Walls", "Sphere", "Cone"}
    drawn = extract_drawn.extract(native.load(), bpy.context.evaluated_depsgraph_get(), {"Cone"}, np.zeros(3))
    assert drawn.names == ["Cone"] and drawn.skipped == 2


def test_bad_wishes_are_refused(tmp_path, monkeypatch):
    fill()
    out = str(tmp_path)
    monkeypatch.setattr(preview, "free_bytes", lambda: 8 << 30)
    assert not preview.too_large(640, 360) and "105.0 GiB" in preview.too_large(16384, 16384)
    assert commands.main(["preview", "--out", out, "--resolution", "16384x16384"]) == 2
    assert commands.main(["preview", "--out", out, "--passes", "nonsense"]) == 1
    assert commands.main(["preview", "--out", out, "--resolution", "0x5"]) == 1
    assert commands.main(["preview", "--out", out, "--resolution", "20000x5"]) == 2
    assert commands.main(["preview", "--out", out, "--camera", "Nobody"]) == 2
    bpy.data.objects.remove(bpy.data.objects["Camera"])
    assert commands.main(["preview", "--out", out]) == 2


def test_the_button_leaves_images():
    fill()
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 120, 80
    from enfilade import registration

    registration.register()
    try:
        assert bpy.ops.enfilade.preview(percentage=50) == {"FINISHED"}
        image = bpy.data.images["Enfilade Preview shaded"]
        assert tuple(image.size) == (60, 40) and 0.1 < np.mean(image.pixels[:]) < 1.0
        assert "Enfilade Preview openings" in bpy.data.images
        bpy.data.objects.remove(bpy.data.objects["Camera"])
        assert not bpy.ops.enfilade.preview.poll()
    finally:
        registration.unregister()


def test_of_too_many_casters_out_of_sight_the_largest_stay():
    building = Building("annotated")
    for size in (3.0, 0.5, 8.0, 1.0):
        building.objects.append(Object(f"{size}", np.array([[0.0, 0, 0], [size, 0, 0]]), f"{size}"))
    kept, left, most = largest_first(np.arange(4), building, 2)
    assert sorted(kept.tolist()) == [0, 2] and left == 2 and most == 1.0
    kept, left, _ = largest_first(np.arange(4), building, 4)
    assert kept.tolist() == [0, 1, 2, 3] and left == 0
