# SPDX-License-Identifier: GPL-3.0-or-later
"""These tests run inside Blender only (tests/blender/run.py); elsewhere they are not collected."""

import importlib.util

import pytest

if importlib.util.find_spec("bpy") is None:
    collect_ignore_glob = ["test_*.py"]


@pytest.fixture
def addon():
    import enfilade

    enfilade.register()
    yield
    enfilade.unregister()
