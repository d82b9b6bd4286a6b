# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the public C headers: functions with their types, structs with their fields. A test's helper, no C parser.

Our headers keep to a small dialect (C17, fixed-width types, one typedef a struct), which is what makes this enough."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = ROOT / "csrc" / "include" / "enfilade"

CType = str  # "const uint32_t *", normalised spaces


def text_of(header: Path) -> str:
    text = re.sub(r"/\*.*?\*/", " ", header.read_text(encoding="utf-8"), flags=re.S)
    text = re.sub(r"//[^\n]*", " ", text)
    return re.sub(r"^\s*#(?:[^\n\\]|\\.|\\\n)*", " ", text, flags=re.M)


def _type(declaration: str) -> CType:
    """"const double bounds[6]" -> "const double *" (an array argument is a pointer)."""
    declaration = " ".join(declaration.replace("*", " * ").split())
    array = re.match(r"(.*?)(\w+) ?\[\d*\]$", declaration)
    if array:
        return f"{array.group(1).strip()} *"
    if declaration in ("void", ""):
        return ""
    match = re.match(r"(.*[ *])(\w+)$", declaration)
    return (match.group(1) if match else declaration).strip()


def functions() -> dict[str, tuple[CType, list[CType]]]:
    """Name -> (result, arguments) of every ENF_API declaration."""
    found: dict[str, tuple[CType, list[CType]]] = {}
    for header in sorted(INCLUDE.glob("*.h")):
        for result, name, arguments in re.findall(
            r"ENF_API\s+([\w\s*]+?)\s*\b(enf_\w+)\s*\(([^;]*?)\)\s*;", text_of(header), re.S
        ):
            types = [_type(a) for a in arguments.split(",")]
            found[name] = (" ".join(result.replace("*", " * ").split()), [t for t in types if t])
    return found


def structs() -> dict[str, list[str]]:
    """Name -> field names, of every struct that is defined (opaque handles are not)."""
    found: dict[str, list[str]] = {}
    for header in sorted(INCLUDE.glob("*.h")):
        for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", text_of(header), re.S):
            fields = []
            for declaration in body.split(";"):
                for part in declaration.split(","):
                    match = re.search(r"(\w+)\s*(?:\[\w+\])*\s*$", part)
                    if match and part.strip():
                        fields.append(match.group(1))
            found[name] = fields
    return found


def constants() -> dict[str, int]:
    """ENF_* enumerators and integer macros."""
    found: dict[str, int] = {}
    for header in sorted(INCLUDE.glob("*.h")):
        raw = header.read_text(encoding="utf-8")
        for name, value in re.findall(r"^#define (ENF_\w+) (0x[0-9A-Fa-f]+|\d+)u?\b", raw, re.M):
            found[name] = int(value, 0)
        for body in re.findall(r"enum \{(.*?)\};", text_of(header), re.S):
            number = -1
            for part in body.split(","):
                match = re.match(r"\s*(ENF_\w+)\s*(?:=\s*(\w+))?\s*$", part)
                if match:
                    number = int(match.group(2), 0) if match.group(2) else number + 1
                    found[match.group(1)] = number
    return found
