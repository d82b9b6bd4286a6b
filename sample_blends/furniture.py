# SPDX-License-Identifier: GPL-3.0-or-later
"""Furniture of the sample buildings. Every function returns a mesh that is made once and shared by its instances.

Origin: on the floor, at the middle of the back edge for what stands against a wall (front towards +y), else at the centre.
"""

from __future__ import annotations

import math
import random

import bpy
from building_kit import Kit
from mesh_kit import MeshBuilder


def _made(kit: Kit, name: str, fill) -> bpy.types.Mesh:
    return kit.mesh(("furniture", name), name, fill)


def _legs(b: MeshBuilder, x: float, y: float, height: float, thick: float, material) -> None:
    for sx in (-1, 1):
        for sy in (-1, 1):
            cx, cy = sx * (x - thick / 2), sy * (y - thick / 2)
            b.box((cx - thick / 2, cy - thick / 2, 0), (cx + thick / 2, cy + thick / 2, height), material, 0.003)


# ---- living -------------------------------------------------------------------------------------------------------
def sofa(kit: Kit, width: float = 2.2) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w, m = width / 2, p.wool_grey
        b.box((-w, 0.02, 0.12), (w, 0.92, 0.30), m, 0.03)
        b.box((-w, 0.02, 0.30), (w, 0.24, 0.80), m, 0.05)
        for s in (-1, 1):
            b.box((min(s * w, s * (w - 0.17)), 0.02, 0.12), (max(s * w, s * (w - 0.17)), 0.92, 0.58), m, 0.04)
        inner = w - 0.18
        for i in (-1, 0):
            b.box((i * inner + 0.005, 0.23, 0.30), ((i + 1) * inner - 0.005, 0.93, 0.44), m, 0.045)
            b.box((i * inner + 0.01, 0.22, 0.44), ((i + 1) * inner - 0.01, 0.42, 0.82), m, 0.06)
        b.box((-inner + 0.06, 0.42, 0.45), (-inner + 0.46, 0.56, 0.80), p.fabric_ochre, 0.06)
        b.box((inner - 0.42, 0.42, 0.45), (inner - 0.04, 0.55, 0.78), p.linen, 0.06)
        for sx in (-1, 1):
            for y in (0.10, 0.84):
                b.cylinder((sx * (w - 0.12), y, 0), 0.018, 0.12, p.walnut, 8, 0.025)

    return _made(kit, f"Sofa {width:g}", fill)


def armchair(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.33, -0.32, 0.28), (0.33, 0.36, 0.42), p.fabric_teal, 0.05)
        b.box((-0.33, -0.40, 0.34), (0.33, -0.24, 0.86), p.fabric_teal, 0.06)
        for s in (-1, 1):
            b.box((min(s * 0.39, s * 0.33), -0.40, 0.52), (max(s * 0.39, s * 0.33), 0.34, 0.56), p.oak, 0.012)
            for y in (-0.36, 0.28):
                b.box((min(s * 0.385, s * 0.345), y, 0), (max(s * 0.385, s * 0.345), y + 0.045, 0.52), p.oak, 0.008)
            b.box((min(s * 0.38, s * 0.35), -0.34, 0.24), (max(s * 0.38, s * 0.35), 0.30, 0.29), p.oak, 0.006)

    return _made(kit, "Armchair", fill)


def coffee_table(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.60, -0.35, 0.34), (0.60, 0.35, 0.38), p.walnut, 0.01)
        _legs(b, 0.56, 0.31, 0.34, 0.045, p.walnut)
        b.box((-0.54, -0.29, 0.12), (0.54, 0.29, 0.14), p.walnut, 0.004)
        b.box((-0.32, -0.12, 0.38), (-0.05, 0.10, 0.41), p.paper_cream, 0.003)
        b.box((-0.30, -0.10, 0.41), (-0.08, 0.09, 0.43), p.paper_blue, 0.003)
        b.cylinder((0.28, 0.05, 0.38), 0.05, 0.14, p.porcelain, 16, 0.07)

    return _made(kit, "Coffee table", fill)


def rug(kit: Kit, x: float, y: float) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-x / 2, -y / 2, 0), (x / 2, y / 2, 0.012), p.rug, 0.005)
        b.box((-x / 2 + 0.12, -y / 2 + 0.12, 0.012), (x / 2 - 0.12, y / 2 - 0.12, 0.014), p.linen)

    return _made(kit, f"Rug {x:g}x{y:g}", fill)


def sideboard(kit: Kit, width: float = 1.8) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = width / 2
        b.box((-w, 0.01, 0.14), (w, 0.43, 0.72), p.oak, 0.008)
        n = max(2, round(width / 0.6))
        for i in range(n):
            x0, x1 = -w + 0.02 + (2 * w - 0.04) * i / n, -w + 0.02 + (2 * w - 0.04) * (i + 1) / n
            b.box((x0 + 0.004, 0.43, 0.16), (x1 - 0.004, 0.446, 0.70), p.white_paint, 0.004)
            b.box((x1 - 0.05, 0.446, 0.42), (x1 - 0.035, 0.462, 0.54), p.brass, 0.003)
        for sx in (-1, 1):
            for y in (0.06, 0.36):
                b.box((sx * (w - 0.08) - 0.02, y, 0), (sx * (w - 0.08) + 0.02, y + 0.04, 0.14), p.black)
        b.cylinder((-w * 0.6, 0.22, 0.72), 0.06, 0.24, p.terracotta, 16, 0.04)

    return _made(kit, f"Sideboard {width:g}", fill)


def bookshelf(kit: Kit, width: float = 0.9, height: float = 2.0, seed: int = 0, full: float = 0.8) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        rng = random.Random(seed)
        w, depth, board = width / 2, 0.30, 0.022
        b.box((-w, 0.005, 0), (-w + board, depth, height), p.oak, 0.002)
        b.box((w - board, 0.005, 0), (w, depth, height), p.oak, 0.002)
        b.box((-w + board, 0.005, 0), (w - board, 0.015, height), p.oak)
        shelves = round(height / 0.36)
        covers = [p.paper_red, p.paper_blue, p.paper_cream, p.linen, p.wool_grey, p.fabric_ochre, p.fabric_teal]
        for i in range(shelves + 1):
            z = 0.06 + (height - 0.06 - board) * i / shelves
            b.box((-w + board, 0.015, z), (w - board, depth - 0.005, z + board), p.oak)
            if i == shelves:
                break
            room = (height - 0.06 - board) / shelves - board
            x = -w + board + 0.01
            while x < -w + board + (2 * w - 2 * board) * min(1.0, full + rng.uniform(-0.35, 0.2)) - 0.05:
                thick, tall = rng.uniform(0.018, 0.045), room * rng.uniform(0.62, 0.93)
                b.box((x, 0.07, z + board), (x + thick, 0.07 + rng.uniform(0.14, 0.19), z + board + tall),
                      rng.choice(covers))
                x += thick + 0.001

    return _made(kit, f"Bookshelf {width:g}x{height:g} {seed}", fill)


def television(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.62, 0.02, 0.95), (0.62, 0.06, 1.66), p.black, 0.006)
        b.box((-0.605, 0.06, 0.965), (0.605, 0.062, 1.645), p.screen)

    return _made(kit, "Television", fill)


def picture(kit: Kit, width: float, height: float, variant: int) -> bpy.types.Mesh:
    """Hangs with its lower edge at 1.25 m."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w, z = width / 2, 1.25
        b.box((-w, 0.004, z), (w, 0.028, z + height), p.black if variant % 2 else p.oak, 0.003)
        b.box((-w + 0.02, 0.028, z + 0.02), (w - 0.02, 0.030, z + height - 0.02), p.plaster_white)
        art = [p.art_a, p.art_b, p.fabric_ochre, p.plaster_sage][variant % 4]
        b.box((-w * 0.55, 0.030, z + height * 0.22), (w * 0.55, 0.031, z + height * 0.62), art)
        b.box((-w * 0.2, 0.031, z + height * 0.5), (w * 0.55, 0.032, z + height * 0.80), p.paper_cream)

    return _made(kit, f"Picture {width:g}x{height:g} {variant}", fill)


def plant(kit: Kit, height: float = 1.4, seed: int = 0) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        rng = random.Random(seed)
        pot = 0.12 + 0.06 * height
        b.cylinder((0, 0, 0), pot * 0.75, pot * 1.7, p.terracotta, 18, pot)
        b.cylinder((0, 0, pot * 1.7 - 0.02), pot * 0.9, 0.005, p.bark, 14)
        for i in range(22):
            turn, rise = i * 2.399963, rng.uniform(0.35, 1.0)
            length, lean = height * (0.45 + 0.35 * rng.random()), 0.25 + 0.75 * rng.random()
            base_z = pot * 1.6 + (height - pot * 1.6) * 0.35 * rise
            points = []
            for k in range(5):
                t = k / 4
                r = 0.02 + lean * length * 0.55 * t
                z = base_z + length * (0.75 * t * rise + 0.25 * t - 0.45 * lean * t * t)
                points.append((r * math.cos(turn), r * math.sin(turn), max(0.05, z)))
            side = (-math.sin(turn), math.cos(turn))
            wide = [0.004, 0.05, 0.065, 0.045, 0.0]
            vertices, faces = [], []
            for (x, y, z), half in zip(points, wide, strict=True):
                vertices += [(x - side[0] * half, y - side[1] * half, z), (x + side[0] * half, y + side[1] * half, z)]
            for k in range(4):
                faces.append((2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2))
            b.add(vertices, faces, p.leaf if i % 3 else p.leaf_dark, smooth=True)

    return _made(kit, f"Plant {height:g} {seed}", fill)


# ---- dining and kitchen -----------------------------------------------------------------------------------------------
def dining_table(kit: Kit, length: float = 1.9) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-length / 2, -0.45, 0.70), (length / 2, 0.45, 0.74), p.oak, 0.008)
        _legs(b, length / 2 - 0.05, 0.40, 0.70, 0.065, p.oak)
        b.box((-length / 2 + 0.1, -0.36, 0.62), (length / 2 - 0.1, 0.36, 0.70), p.oak)
        b.ball((0, 0, 0.80), (0.17, 0.17, 0.07), p.porcelain, 6, 16)

    return _made(kit, f"Dining table {length:g}", fill)


def chair(kit: Kit) -> bpy.types.Mesh:
    """Faces +y."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.22, -0.21, 0.43), (0.22, 0.22, 0.46), p.linen, 0.012)
        b.box((-0.22, -0.20, 0.40), (0.22, 0.21, 0.43), p.oak, 0.004)
        for s in (-1, 1):
            b.box((s * 0.20 - 0.017, 0.17, 0), (s * 0.20 + 0.017, 0.205, 0.42), p.oak, 0.004)
            b.box((s * 0.20 - 0.017, -0.225, 0), (s * 0.20 + 0.017, -0.19, 0.82), p.oak, 0.004)
        for z in (0.58, 0.72):
            b.box((-0.19, -0.22, z), (0.19, -0.195, z + 0.085), p.oak, 0.006)

    return _made(kit, "Chair", fill)


def pendant(kit: Kit, drop: float = 0.9) -> bpy.types.Mesh:
    """Hangs from its origin."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.cylinder((0, 0, -0.03), 0.05, 0.03, p.black, 14)
        b.cylinder((0, 0, -drop + 0.2), 0.004, drop - 0.22, p.black, 6)
        b.cylinder((0, 0, -drop), 0.20, 0.20, p.black, 24, 0.05, caps=False)
        b.ball((0, 0, -drop + 0.05), (0.045, 0.045, 0.045), p.lamp_shade, 6, 10)

    return _made(kit, f"Pendant {drop:g}", fill)


def kitchen_run(kit: Kit, length: float, appliances: bool) -> bpy.types.Mesh:
    """Base units with a worktop; `appliances`: hob and oven, else a sink."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = length / 2
        b.box((-w, 0.0, 0.0), (w, 0.52, 0.10), p.black)
        b.box((-w, 0.0, 0.10), (w, 0.57, 0.86), p.cabinet)
        b.box((-w, 0.0, 0.86), (w, 0.62, 0.90), p.stone_top, 0.004)
        n = max(1, round(length / 0.6))
        for i in range(n):
            x0, x1 = -w + length * i / n + 0.002, -w + length * (i + 1) / n - 0.002
            oven = appliances and i == n // 2
            b.box((x0, 0.57, 0.115), (x1, 0.59, 0.66 if not oven else 0.72), p.black if oven else p.cabinet, 0.003)
            if not oven:
                b.box((x0, 0.57, 0.665), (x1, 0.59, 0.85), p.cabinet, 0.003)
            b.box((x0 + 0.12, 0.59, 0.80 if not oven else 0.76), (x1 - 0.12, 0.612, 0.815 if not oven else 0.775),
                  p.brass, 0.003)
        middle = -w + length * (n // 2 + 0.5) / n
        if appliances:
            b.box((middle - 0.29, 0.07, 0.90), (middle + 0.29, 0.56, 0.906), p.black)
            for dx in (-0.14, 0.14):
                for y in (0.19, 0.43):
                    b.cylinder((middle + dx, y, 0.906), 0.085, 0.002, p.wool_grey, 18)
        else:
            b.box((middle - 0.26, 0.12, 0.898), (middle + 0.26, 0.50, 0.903), p.steel)
            b.box((middle - 0.24, 0.14, 0.903), (middle + 0.24, 0.48, 0.9035), p.black)
            b.cylinder((middle, 0.07, 0.90), 0.014, 0.28, p.steel, 10)
            b.box((middle - 0.011, 0.07, 1.16), (middle + 0.011, 0.27, 1.18), p.steel, 0.004)

    return _made(kit, f"Kitchen run {length:g} {int(appliances)}", fill)


def wall_cabinets(kit: Kit, length: float) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = length / 2
        b.box((-w, 0.0, 1.48), (w, 0.33, 2.16), p.cabinet)
        n = max(1, round(length / 0.6))
        for i in range(n):
            b.box((-w + length * i / n + 0.002, 0.33, 1.482), (-w + length * (i + 1) / n - 0.002, 0.35, 2.158),
                  p.cabinet, 0.003)

    return _made(kit, f"Wall cabinets {length:g}", fill)


def tall_unit(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.30, 0.0, 0.0), (0.30, 0.57, 2.16), p.cabinet)
        b.box((-0.298, 0.57, 0.10), (0.298, 0.59, 0.85), p.cabinet, 0.003)
        b.box((-0.298, 0.57, 0.855), (0.298, 0.59, 2.155), p.cabinet, 0.003)
        b.box((-0.27, 0.59, 0.95), (-0.255, 0.612, 1.45), p.brass, 0.003)
        b.box((-0.27, 0.59, 0.45), (-0.255, 0.612, 0.80), p.brass, 0.003)

    return _made(kit, "Tall unit", fill)


def island(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.75, -0.36, 0.0), (0.75, 0.36, 0.10), p.black)
        b.box((-0.78, -0.40, 0.10), (0.78, 0.40, 0.87), p.oak, 0.004)
        b.box((-0.82, -0.44, 0.87), (0.82, 0.44, 0.91), p.stone_top, 0.005)
        b.ball((0.4, 0.0, 0.955), (0.16, 0.16, 0.055), p.terracotta, 6, 16)

    return _made(kit, "Kitchen island", fill)


# ---- bedroom and bath --------------------------------------------------------------------------------------------------
def bed(kit: Kit, width: float = 1.6) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = width / 2
        b.box((-w - 0.06, 0.01, 0.0), (w + 0.06, 0.07, 0.98), p.oak, 0.01)
        b.box((-w - 0.03, 0.07, 0.16), (w + 0.03, 2.10, 0.30), p.oak, 0.008)
        for sx in (-1, 1):
            b.box((sx * (w - 0.08) - 0.03, 1.98, 0), (sx * (w - 0.08) + 0.03, 2.04, 0.16), p.oak)
        b.box((-w, 0.09, 0.30), (w, 2.08, 0.50), p.plaster_white, 0.05)
        b.box((-w - 0.03, 0.62, 0.36), (w + 0.03, 2.11, 0.56), p.linen, 0.06)
        b.box((-w - 0.035, 1.35, 0.355), (w + 0.035, 1.95, 0.572), p.fabric_teal, 0.06)
        n = 2 if width > 1.2 else 1
        for i in range(n):
            c = 0.0 if n == 1 else (-w / 2 if i == 0 else w / 2)
            b.box((c - 0.33, 0.11, 0.50), (c + 0.33, 0.50, 0.63), p.plaster_white, 0.06)

    return _made(kit, f"Bed {width:g}", fill)


def nightstand(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.23, 0.01, 0.14), (0.23, 0.39, 0.50), p.oak, 0.006)
        b.box((-0.21, 0.39, 0.30), (0.21, 0.405, 0.48), p.white_paint, 0.003)
        _legs_back(b, 0.19, 0.05, 0.35, 0.14, p.oak)
        b.cylinder((0, 0.2, 0.50), 0.06, 0.015, p.brass, 16)
        b.cylinder((0, 0.2, 0.515), 0.008, 0.17, p.brass, 8)
        b.cylinder((0, 0.2, 0.66), 0.12, 0.16, p.lamp_shade, 20, 0.08, caps=False)

    return _made(kit, "Nightstand", fill)


def _legs_back(b: MeshBuilder, x: float, y0: float, y1: float, height: float, material) -> None:
    for sx in (-1, 1):
        for y in (y0, y1):
            b.box((sx * x - 0.015, y - 0.015, 0), (sx * x + 0.015, y + 0.015, height), material)


def wardrobe(kit: Kit, width: float = 2.0) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = width / 2
        b.box((-w, 0.005, 0), (w, 0.58, 2.25), p.white_paint, 0.004)
        n = max(2, round(width / 0.5))
        for i in range(n):
            x0, x1 = -w + width * i / n + 0.003, -w + width * (i + 1) / n - 0.003
            b.box((x0, 0.58, 0.08), (x1, 0.60, 2.24), p.white_paint, 0.004)
            x = x1 - 0.03 if i % 2 == 0 else x0 + 0.018
            b.box((x, 0.60, 1.0), (x + 0.012, 0.622, 1.25), p.brass, 0.003)

    return _made(kit, f"Wardrobe {width:g}", fill)


def bathtub(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w, d, h = 0.85, 0.75, 0.56
        b.box((-w, 0.0, 0.0), (w, 0.06, h), p.porcelain, 0.01)
        b.box((-w, d - 0.06, 0.0), (w, d, h), p.porcelain, 0.01)
        b.box((-w, 0.06, 0.0), (-w + 0.08, d - 0.06, h), p.porcelain, 0.01)
        b.box((w - 0.08, 0.06, 0.0), (w, d - 0.06, h), p.porcelain, 0.01)
        b.box((-w + 0.08, 0.06, 0.0), (w - 0.08, d - 0.06, 0.14), p.porcelain)
        b.cylinder((w - 0.04, d / 2, h), 0.015, 0.16, p.steel, 10)
        b.box((w - 0.20, d / 2 - 0.011, h + 0.14), (w - 0.03, d / 2 + 0.011, h + 0.16), p.steel, 0.004)

    return _made(kit, "Bathtub", fill)


def washbasin(kit: Kit, width: float = 0.9) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = width / 2
        b.box((-w, 0.0, 0.48), (w, 0.44, 0.78), p.oak, 0.004)
        b.box((-w, 0.0, 0.78), (w, 0.46, 0.86), p.porcelain, 0.012)
        b.box((-w * 0.6, 0.11, 0.8605), (w * 0.6, 0.40, 0.862), p.steel)
        b.cylinder((0, 0.07, 0.86), 0.012, 0.14, p.steel, 10)
        b.box((-0.009, 0.07, 0.98), (0.009, 0.19, 0.998), p.steel, 0.003)
        b.box((-w, 0.0, 1.10), (w, 0.02, 1.90), p.frame_dark)
        b.box((-w + 0.01, 0.02, 1.11), (w - 0.01, 0.021, 1.89), p.mirror)

    return _made(kit, f"Washbasin {width:g}", fill)


def toilet(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.19, 0.0, 0.0), (0.19, 0.14, 1.05), p.white_paint, 0.004)
        b.box((-0.17, 0.14, 0.12), (0.17, 0.44, 0.40), p.porcelain, 0.06)
        b.cylinder((0, 0.44, 0.16), 0.11, 0.24, p.porcelain, 20, 0.17)
        b.box((-0.18, 0.14, 0.40), (0.18, 0.46, 0.43), p.porcelain, 0.012)
        b.cylinder((0, 0.44, 0.40), 0.18, 0.03, p.porcelain, 20)
        b.box((-0.11, 0.14, 0.92), (0.11, 0.148, 1.0), p.steel, 0.003)

    return _made(kit, "Toilet", fill)


# ---- work --------------------------------------------------------------------------------------------------------------
def desk(kit: Kit, width: float = 1.6, depth: float = 0.8, dark: bool = False) -> bpy.types.Mesh:
    """Centred; the user sits at +y."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        top = p.walnut if dark else p.white_paint
        frame = p.black if dark else p.steel
        w, d = width / 2, depth / 2
        b.box((-w, -d, 0.71), (w, d, 0.735), top, 0.005)
        for sx in (-1, 1):
            x0, x1 = sorted((sx * (w - 0.06), sx * (w - 0.10)))
            b.box((x0, -d + 0.08, 0.0), (x1, d - 0.08, 0.03), frame, 0.004)
            b.box((x0, -0.04, 0.03), (x1, 0.04, 0.69), frame, 0.004)
            b.box((x0, -d + 0.1, 0.69), (x1, d - 0.1, 0.71), frame)
        b.box((-w + 0.1, -0.02, 0.64), (w - 0.1, 0.02, 0.69), frame)

    return _made(kit, f"Desk {width:g}x{depth:g} {int(dark)}", fill)


def office_chair(kit: Kit) -> bpy.types.Mesh:
    """Faces +y."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        for i in range(5):
            a = 2 * math.pi * i / 5
            c, s = math.cos(a), math.sin(a)
            n = (-s * 0.018, c * 0.018)
            b.add([(-n[0], -n[1], 0.09), (n[0], n[1], 0.09), (0.30 * c + n[0], 0.30 * s + n[1], 0.06),
                   (0.30 * c - n[0], 0.30 * s - n[1], 0.06)], [(3, 2, 1, 0), (0, 1, 2, 3)], p.black)
            b.ball((0.29 * c, 0.29 * s, 0.03), (0.03, 0.03, 0.03), p.black, 4, 8)
        b.cylinder((0, 0, 0.07), 0.03, 0.36, p.steel, 10, 0.022)
        b.box((-0.24, -0.22, 0.43), (0.24, 0.25, 0.50), p.wool_grey, 0.03)
        b.box((-0.03, -0.29, 0.42), (0.03, -0.25, 0.70), p.black, 0.006)
        b.box((-0.22, -0.28, 0.60), (0.22, -0.22, 1.06), p.wool_grey, 0.028)
        for s in (-1, 1):
            b.box((s * 0.27 - 0.02, -0.14, 0.66), (s * 0.27 + 0.02, 0.12, 0.685), p.black, 0.008)
            b.box((s * 0.27 - 0.012, -0.02, 0.46), (s * 0.27 + 0.012, 0.02, 0.66), p.black)

    return _made(kit, "Office chair", fill)


def monitor(kit: Kit) -> bpy.types.Mesh:
    """Stands on its origin, faces +y."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.12, -0.09, 0), (0.12, 0.09, 0.012), p.black, 0.004)
        b.box((-0.02, -0.03, 0.012), (0.02, 0.0, 0.30), p.black)
        b.box((-0.31, -0.005, 0.14), (0.31, 0.018, 0.52), p.black, 0.005)
        b.box((-0.30, 0.018, 0.152), (0.30, 0.0185, 0.508), p.screen)

    return _made(kit, "Monitor", fill)


def keyboard(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.21, -0.065, 0), (0.21, 0.065, 0.02), p.white_paint, 0.006)
        b.box((-0.20, -0.055, 0.02), (0.20, 0.055, 0.0225), p.wool_grey)
        b.box((0.27, -0.05, 0), (0.33, 0.05, 0.03), p.white_paint, 0.012)

    return _made(kit, "Keyboard", fill)


def desk_lamp(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.cylinder((0, 0, 0), 0.08, 0.02, p.black, 18)
        b.box((-0.008, -0.008, 0.02), (0.008, 0.008, 0.42), p.black)
        b.box((-0.008, -0.008, 0.41), (0.008, 0.25, 0.426), p.black)
        b.cylinder((0, 0.23, 0.35), 0.07, 0.07, p.black, 18, 0.035, caps=False)

    return _made(kit, "Desk lamp", fill)


def waste_bin(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette
    return _made(kit, "Waste bin", lambda b: b.cylinder((0, 0, 0), 0.11, 0.30, p.black, 16, 0.14))


def cabinet(kit: Kit, width: float = 0.8, height: float = 1.1) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        w = width / 2
        b.box((-w, 0.005, 0), (w, 0.42, height), p.white_paint, 0.004)
        rows = max(2, round(height / 0.36))
        for i in range(rows):
            z0, z1 = 0.05 + (height - 0.06) * i / rows + 0.003, 0.05 + (height - 0.06) * (i + 1) / rows - 0.003
            b.box((-w + 0.005, 0.42, z0), (w - 0.005, 0.438, z1), p.white_paint, 0.003)
            b.box((-0.08, 0.438, z1 - 0.05), (0.08, 0.45, z1 - 0.035), p.steel)

    return _made(kit, f"Cabinet {width:g}x{height:g}", fill)


def meeting_table(kit: Kit, length: float) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-length / 2, -0.55, 0.70), (length / 2, 0.55, 0.735), p.oak, 0.01)
        for x in (-length / 2 + 0.45, length / 2 - 0.45):
            b.box((x - 0.03, -0.35, 0.03), (x + 0.03, 0.35, 0.70), p.black)
            b.box((x - 0.06, -0.42, 0), (x + 0.06, 0.42, 0.03), p.black)

    return _made(kit, f"Meeting table {length:g}", fill)


def ceiling_panel(kit: Kit) -> bpy.types.Mesh:
    """Hangs from its origin."""
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.60, -0.15, -0.05), (0.60, 0.15, -0.005), p.white_paint, 0.004)
        b.box((-0.58, -0.13, -0.052), (0.58, 0.13, -0.05), p.panel_light)

    return _made(kit, "Ceiling panel", fill)


def whiteboard(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-0.9, 0.004, 0.95), (0.9, 0.022, 2.0), p.steel, 0.003)
        b.box((-0.88, 0.022, 0.97), (0.88, 0.024, 1.98), p.porcelain)
        b.box((-0.4, 0.022, 0.93), (0.4, 0.07, 0.945), p.steel)

    return _made(kit, "Whiteboard", fill)


# ---- outside -------------------------------------------------------------------------------------------------------------
def tree(kit: Kit, height: float, seed: int) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        rng = random.Random(seed)
        b.cylinder((0, 0, 0), 0.14, height * 0.55, p.bark, 12, 0.08)
        for i in range(7):
            a, r = i * 2.4, height * 0.17 * (0.4 + rng.random())
            size = height * rng.uniform(0.15, 0.23)
            phase = rng.uniform(0, 6)
            b.ball((r * math.cos(a), r * math.sin(a), height * rng.uniform(0.52, 0.82)), (size, size, size * 0.8),
                   p.leaf if i % 2 else p.leaf_dark, 12, 18,
                   lambda u, v, q=phase: 1.0 + 0.07 * math.sin(7 * u + q) * math.sin(5 * v) + 0.05 * math.sin(11 * v + q))

    return _made(kit, f"Tree {height:g} {seed}", fill)


def hedge(kit: Kit, length: float) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        b.box((-length / 2, -0.3, 0), (length / 2, 0.3, 1.15), p.leaf_dark, 0.12)

    return _made(kit, f"Hedge {length:g}", fill)


def bench(kit: Kit) -> bpy.types.Mesh:
    p = kit.palette

    def fill(b: MeshBuilder) -> None:
        for i in range(4):
            b.box((-0.8, -0.22 + i * 0.115, 0.42), (0.8, -0.125 + i * 0.115, 0.45), p.oak, 0.005)
        for x in (-0.65, 0.65):
            b.box((x - 0.03, -0.2, 0), (x + 0.03, 0.22, 0.42), p.black)

    return _made(kit, "Bench", fill)
