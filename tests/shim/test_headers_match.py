# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of signatures and the structs say what the C headers say."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import c_headers
import pytest
from enfilade_native import _signatures as signatures
from enfilade_native import _structs, region, scene, visibility

POINTERS_BY_NAME = {
    "EnfScene": signatures.SceneHandle,
    "EnfView": signatures.ViewHandle,
    "EnfJob": signatures.JobHandle,
    "EnfRegionVis": signatures.RegionVisHandle,
    "EnfObjectVis": signatures.ObjectVisHandle,
    "EnfChainQuery": signatures.ChainQueryHandle,
    "EnfRaycaster": signatures.RaycasterHandle,
    "EnfTriangles": signatures.TrianglesHandle,
    "EnfLightSets": signatures.LightSetsHandle,
}
SCALARS = {
    "uint8_t": ctypes.c_uint8,
    "uint16_t": ctypes.c_uint16,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "EnfStatus": signatures.Status,
}
STRUCTS = {struct.__name__: struct for struct in _structs.STRUCTS}


def accepted(c_type: str) -> list[object]:
    """The ctypes that may stand for a C type in the table."""
    words = c_type.replace("const", " ").split()
    base, stars = words[0], words.count("*")
    if stars == 0:
        return [SCALARS.get(base) or STRUCTS.get(base) or (None if base == "void" else base)]
    if base == "char" and stars == 1:
        # A name in UTF-8 that ends with 0, or (in) many of them in one buffer.
        return [ctypes.c_char_p, ctypes.c_void_p]
    if base == "char" and stars == 2:
        return [ctypes.POINTER(ctypes.c_char_p)]
    if base in POINTERS_BY_NAME:
        handle = POINTERS_BY_NAME[base]
        return [handle] if stars == 1 else [ctypes.POINTER(handle)]
    if stars == 1 and base in STRUCTS:
        return [ctypes.POINTER(STRUCTS[base])]
    pointer = SCALARS.get(base)
    for _ in range(stars):
        pointer = ctypes.POINTER(pointer) if pointer is not None else None
    # Arrays that numpy owns go in as addresses.
    return [pointer, ctypes.c_void_p] if stars == 1 else [pointer]


DECLARED = c_headers.functions()
TABLE = {name: (result, arguments) for name, result, arguments in signatures.FUNCTIONS}


def test_the_parser_sees_the_headers():
    assert len(DECLARED) > 50
    assert DECLARED["enf_scene_add_light"] == ("EnfStatus", ["EnfScene *", "const char *", "const double *", "uint32_t *"])


def test_every_function_of_the_headers_is_in_the_table_once():
    assert len(TABLE) == len(signatures.FUNCTIONS)
    assert set(DECLARED) - set(TABLE) - signatures.NOT_BOUND == set()
    assert set(TABLE) - set(DECLARED) == set()


@pytest.mark.parametrize("name", sorted(set(TABLE) & set(DECLARED)))
def test_signature_matches_the_header(name):
    result, arguments = TABLE[name]
    c_result, c_arguments = DECLARED[name]
    assert len(arguments) == len(c_arguments)
    assert result in accepted(c_result), c_result
    for ours, theirs in zip(arguments, c_arguments, strict=True):
        assert ours in accepted(theirs), theirs


def test_abi_number_matches_the_header():
    assert c_headers.constants()["ENF_ABI_VERSION"] == signatures.ABI_VERSION


def test_every_struct_of_the_headers_is_known():
    assert set(c_headers.structs()) == set(STRUCTS)
    for name, fields in c_headers.structs().items():
        assert [field for field, _ in STRUCTS[name]._fields_] == fields, name


def test_struct_layouts_match_the_compiler(tmp_path):
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler to ask for offsets")
    lines = ['#include "enfilade/enfilade.h"', "#include <stdio.h>", "int main(void) {"]
    expected = []
    for name, struct in STRUCTS.items():
        lines.append(f'printf("{name} %zu\\n", sizeof({name}));')
        expected.append(f"{name} {ctypes.sizeof(struct)}")
        for field, _ in struct._fields_:
            size = f"sizeof((({name} *)0)->{field})"
            lines.append(f'printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), {size});')
            expected.append(f"{name}.{field} {getattr(struct, field).offset} {getattr(struct, field).size}")
    lines.append("return 0; }")
    source = tmp_path / "offsets.c"
    source.write_text("\n".join(lines))
    binary = tmp_path / "offsets"
    subprocess.run([compiler, "-std=c17", f"-I{c_headers.INCLUDE.parent}", str(source), "-o", str(binary)], check=True)
    assert subprocess.run([str(binary)], check=True, capture_output=True, text=True).stdout.splitlines() == expected


def test_words_stand_in_the_order_of_the_enumerators():
    values = c_headers.constants()
    for prefix, words in (
        ("ENF_ROOM_", scene.ROOM_KINDS),
        ("ENF_OPENING_", scene.OPENING_KINDS),
        ("ENF_STATE_", scene.OPENING_STATES),
        ("ENF_CAMERA_", scene.CAMERA_TYPES),
        ("ENF_SEVERITY_", scene.SEVERITIES),
        ("ENF_ITEM_", scene.ITEMS),
        ("ENF_VIEW_", visibility.METHODS),
        ("ENF_REGION_", region.METHODS),
        ("ENF_PAIR_", region.STATUSES),
    ):
        there = {name[len(prefix) :].lower(): value for name, value in values.items() if name.startswith(prefix)}
        assert there == {word.lower(): i for i, word in enumerate(words)}, prefix
    assert values["ENF_NONE"] == scene.NONE
