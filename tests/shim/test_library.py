# SPDX-License-Identifier: GPL-3.0-or-later
"""Finding, checking and refusing a library: each failure ends in one exception that says what to do."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import c_headers
import enfilade_native as native
import pytest

SHIM = c_headers.ROOT / "python_shim"


def in_a_new_process(code: str, **environment: str) -> str:
    """What `code` prints in a Python that hasn't loaded the library yet."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(SHIM), os.environ.get("PYTHONPATH", "")]), **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


ASK = "import enfilade_native as n\ntry:\n    print(n.version())\nexcept n.LibraryError as e:\n    print('refused:', e)"


def fake(tmp_path, source: str):
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler to make a wrong library with")
    (tmp_path / "fake.c").write_text(source)
    path = tmp_path / "libfake.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-o", str(path), str(tmp_path / "fake.c")], check=True)
    return path


def test_the_library_is_found_once():
    assert native.library() is native.library()
    assert native.library_path().is_file()
    assert native.version() == (c_headers.ROOT / "VERSION").read_text().strip()


def test_a_named_file_is_the_only_one_tried():
    out = in_a_new_process(ASK, ENFILADE_LIBRARY="/nowhere/libenfilade.so")
    assert out.startswith("refused:") and "/nowhere/libenfilade.so: not there" in out and "build.sh build" in out
    assert "build/lib" not in out


def test_a_file_that_is_no_library_is_refused(tmp_path):
    path = tmp_path / "libenfilade.so"
    path.write_text("not a library")
    assert "refused:" in in_a_new_process(ASK, ENFILADE_LIBRARY=str(path))


def test_another_library_is_refused_by_name(tmp_path):
    path = fake(tmp_path, "int something(void) { return 1; }")
    out = in_a_new_process(ASK, ENFILADE_LIBRARY=str(path))
    assert "is not an Enfilade library" in out and str(path) in out


def test_another_abi_number_is_refused_with_both_numbers(tmp_path):
    path = fake(tmp_path, "unsigned enf_abi_version(void) { return 4242; }")
    out = in_a_new_process(ASK, ENFILADE_LIBRARY=str(path))
    assert "ABI 4242" in out and str(native._signatures.ABI_VERSION) in out


def test_a_missing_function_is_refused_by_name(tmp_path):
    path = fake(tmp_path, f"unsigned enf_abi_version(void) {{ return {native._signatures.ABI_VERSION}; }}")
    out = in_a_new_process(ASK, ENFILADE_LIBRARY=str(path))
    assert "do not match" in out and "enf_" in out


def test_a_struct_of_another_size_is_refused_by_name(tmp_path):
    names = [name for name, _, _ in native._signatures.FUNCTIONS if name not in ("enf_abi_version", "enf_struct_size")]
    source = "".join(f"void {name}(void) {{}}\n" for name in names)
    source += f"unsigned enf_abi_version(void) {{ return {native._signatures.ABI_VERSION}; }}\n"
    source += "unsigned long long enf_struct_size(const char *name) { (void)name; return 3; }\n"
    out = in_a_new_process(ASK, ENFILADE_LIBRARY=str(fake(tmp_path, source)))
    assert "EnfCamera has 3 bytes there" in out


def test_the_package_finds_a_library_beside_itself(tmp_path):
    shutil.copytree(SHIM / "enfilade_native", tmp_path / "enfilade_native", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "enfilade_native" / "lib").mkdir()
    shutil.copy(native.library_path(), tmp_path / "enfilade_native" / "lib" / native.default_library_names()[0])
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import enfilade_native as n; print(n.library_path())"
    environment = {k: "" for k in ("ENFILADE_LIBRARY",)}
    assert str(tmp_path) in in_a_new_process(code, **environment)
