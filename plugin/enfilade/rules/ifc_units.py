# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths of an IFC file in metres, by the project's IfcUnitAssignment.

Files hold several length units (for quantities, for properties); only the one assigned to the project counts.
"""

from __future__ import annotations

from typing import Any

_PREFIX = {
    "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3, "HECTO": 1e2, "DECA": 1e1,
    "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9, "PICO": 1e-12, "FEMTO": 1e-15, "ATTO": 1e-18,
}  # fmt: skip


def length_unit(model: Any) -> float:
    """Metres per length unit of the file; 1.0 where the file doesn't say."""
    for project in [*model.by_type("IfcProject"), *by_type(model, "IfcProjectLibrary")]:
        assignment = getattr(project, "UnitsInContext", None)
        for unit in assignment.Units if assignment else ():
            if getattr(unit, "UnitType", None) == "LENGTHUNIT":
                return _metres(unit)
    return 1.0


def _metres(unit: Any) -> float:
    if unit.is_a("IfcSIUnit"):
        return _PREFIX.get(unit.Prefix or "", 1.0)
    if unit.is_a("IfcConversionBasedUnit"):
        factor = unit.ConversionFactor
        component = factor.UnitComponent
        base = _metres(component) if hasattr(component, "UnitType") else 1.0
        return float(factor.ValueComponent.wrappedValue) * base
    return 1.0


def by_type(model: Any, name: str) -> list[Any]:
    """As model.by_type, empty where the file's schema doesn't know the class."""
    try:
        return list(model.by_type(name))
    except RuntimeError:  # the class is not in this schema
        return []
