# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms written back into IFC: read again they are the same, the file stays valid, the source stays as it was."""

from __future__ import annotations

import hashlib
import logging
from pathlib import Path

import numpy as np
import pytest
from enfilade.rules import ifc, ifc_library, ifc_write, indoorgml
from enfilade.rules.building import Building
from ifc_blocks import two_rooms

pytestmark = pytest.mark.skipif(not ifc_library.available(), reason="IfcOpenShell isn't installed (./build.sh deps)")


def _model(folder: Path, **options):
    model, wall = two_rooms(**options)
    door = model.product("D1", "IfcDoor", ((4.05, 2, 0), (4.1, 2.9, 2.1)))
    model.void(wall, ((4.0, 2, 0), (4.2, 2.9, 2.1)), door)
    window = model.product("W1", "IfcWindow", ((-0.2, 1, 1), (-0.1, 2, 2)))
    west = next(w for w in model.f.by_type("IfcWall") if w.Name == "West")
    model.void(west, ((-0.3, 1, 1), (0, 2, 2)), window)
    return model, model.save(folder, "whole.ifc")


def _without_spaces(model, folder: Path) -> Path:
    for space in model.f.by_type("IfcSpace"):
        for relation in list(space.Decomposes):
            model.f.remove(relation)
        model.f.remove(space)
    return model.save(folder, "bare.ifc")


def _openings(building: Building) -> list:
    return sorted((o.name, o.kind, tuple(sorted(building.rooms[r].name for r in o.rooms))) for o in building.openings)


def _errors(path: Path) -> list[str]:
    import ifcopenshell.validate

    found: list[str] = []

    class Keep(logging.Handler):
        def emit(self, record):
            found.append(record.getMessage())

    logger = logging.getLogger(f"validate {path.name}")
    logger.addHandler(Keep())
    logger.propagate = False
    ifcopenshell.validate.validate(str(path), logger)
    return found


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4", "IFC4X3"])
@pytest.mark.parametrize("options", [{}, {"unit": 0.001, "origin": (5e5, 5e6, 100.0), "degrees": 33.0}])
def test_rooms_that_were_missing_come_back(tmp_path: Path, schema: str, options: dict) -> None:
    model, whole = _model(tmp_path, schema=schema, **options)
    building = ifc.read_ifc(whole, objects=False, local=True)
    bare = _without_spaces(model, tmp_path)
    before = hashlib.sha256(bare.read_bytes()).digest()
    made = ifc_write.write(building, bare, tmp_path / "out.ifc")
    assert (made.spaces, made.boundaries, made.kept_spaces) == (2, 3, 0)
    assert hashlib.sha256(bare.read_bytes()).digest() == before
    again = ifc.read_ifc(tmp_path / "out.ifc", objects=False, local=True)
    assert _openings(again) == _openings(building)
    for r, q in zip(building.rooms, again.rooms, strict=True):
        if r.vertices is not None:
            here, there = r.vertices + building.offset, q.vertices + again.offset
            assert np.linalg.norm(here[:, None] - there[None], axis=2).min(axis=1).max() < 1e-5
            assert q.storey == r.storey
    assert [e for e in _errors(tmp_path / "out.ifc") if e not in _errors(bare)] == []
    same = ifc_write.write(building, bare, tmp_path / "twice.ifc")
    assert same == made
    assert _data(tmp_path / "twice.ifc") == _data(tmp_path / "out.ifc")


def _data(path: Path) -> str:
    return path.read_text().partition("DATA;")[2]


def test_boundaries_lie_where_the_openings_end(tmp_path: Path) -> None:
    model, whole = _model(tmp_path)
    building = ifc.read_ifc(whole, objects=False)
    ifc_write.write(building, whole, tmp_path / "out.ifc")
    out = ifc_library.load().open(str(tmp_path / "out.ifc"))
    assert len(out.by_type("IfcSpace")) == 2  # those that were there
    boundaries = out.by_type("IfcRelSpaceBoundary2ndLevel")
    door = [b for b in boundaries if b.RelatedBuildingElement.Name == "D1"]
    assert {b.RelatingSpace.Name for b in door} == {"A", "B"}
    assert door[0].CorrespondingBoundary == door[1] and door[1].CorrespondingBoundary == door[0]
    assert {b.InternalOrExternalBoundary for b in door} == {"INTERNAL"} and {b.PhysicalOrVirtualBoundary for b in door} == {"PHYSICAL"}
    for b in door:
        plane = b.ConnectionGeometry.SurfaceOnRelatingElement
        corners = np.array([p.Coordinates for p in plane.OuterBoundary.Points])
        assert np.ptp(corners, axis=0) == pytest.approx([0.9, 2.1], abs=1e-6) or np.ptp(corners, axis=0) == pytest.approx([2.1, 0.9], abs=1e-6)
        x = plane.BasisSurface.Position.Location.Coordinates[0]
        assert x == pytest.approx(4.0 if b.RelatingSpace.Name == "A" else 0.0, abs=1e-6)  # in the space's own coordinates
    kept = ifc_write.write(ifc.read_ifc(tmp_path / "out.ifc", objects=False), tmp_path / "out.ifc", tmp_path / "third.ifc")
    assert (kept.spaces, kept.boundaries, kept.kept_spaces, kept.kept_boundaries) == (0, 0, 2, 3)


def test_the_model_itself_is_never_overwritten(tmp_path: Path) -> None:
    _, whole = _model(tmp_path)
    building = ifc.read_ifc(whole, objects=False)
    for target in (whole, tmp_path / "." / "whole.ifc"):
        with pytest.raises(ifc_write.IfcWriteError, match="never overwritten"):
            ifc_write.write(building, whole, target)
    (tmp_path / "link.ifc").symlink_to(whole)
    with pytest.raises(ifc_write.IfcWriteError, match="never overwritten"):
        ifc_write.write(building, whole, tmp_path / "link.ifc")


def test_rooms_go_through_indoorgml_and_back(tmp_path: Path) -> None:
    _, whole = _model(tmp_path)
    building = ifc.read_ifc(whole, objects=False)
    assert indoorgml.write(building, tmp_path / "x.gml") == (4, 3)
    back = indoorgml.read(tmp_path / "x.gml")
    assert {r.name for r in back.rooms} >= {"A", "B", "D1", "W1"} and len(back.openings) == 3
