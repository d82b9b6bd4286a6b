# SPDX-License-Identifier: GPL-3.0-or-later
"""Enfilade's C core from Python: ctypes and numpy, no Blender.

    import enfilade_native as native
    with native.Scene.load("house.enf.json") as scene:
        scene.commit()
        print(scene.counts, scene.problems)

Importing loads nothing: the library is found and checked at the first call that needs it (`library()` does it on
purpose). Errors are exceptions (`EnfError` and its kinds); arrays that come back are read-only views without a copy.
"""

from . import chain, region, voxels
from ._library import default_library_names, library, library_path, version
from .errors import (
    BadInputError,
    CancelledError,
    EnfError,
    EnfIOError,
    EnfMemoryError,
    InternalError,
    InvalidArgumentError,
    LibraryError,
    StateError,
)
from .lighting import DirectLight, Light, LightSets, direct_light
from .preview import Layers, Panorama, Picture
from .raycast import Raycaster, RayHits, RayImage
from .scene import NONE, Camera, Exterior, Problem, Scene, SceneCounts
from .triangles import Material, Triangles
from .visibility import View, ViewResult

__all__ = [
    "NONE",
    "BadInputError",
    "Camera",
    "CancelledError",
    "DirectLight",
    "EnfError",
    "EnfIOError",
    "EnfMemoryError",
    "Exterior",
    "InternalError",
    "InvalidArgumentError",
    "LibraryError",
    "Layers",
    "Light",
    "LightSets",
    "Material",
    "Panorama",
    "Picture",
    "Problem",
    "RayHits",
    "RayImage",
    "Raycaster",
    "Scene",
    "SceneCounts",
    "StateError",
    "Triangles",
    "View",
    "ViewResult",
    "default_library_names",
    "direct_light",
    "library",
    "library_path",
    "chain",
    "region",
    "version",
    "voxels",
]
