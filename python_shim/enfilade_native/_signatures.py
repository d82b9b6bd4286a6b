# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of C functions: name, result, arguments. tests/shim/test_headers_match.py compares it with the headers."""

from __future__ import annotations

from ctypes import POINTER, c_char_p, c_double, c_int32, c_uint8, c_uint32, c_uint64, c_void_p

from . import _structs as s

# The ABI this table was written for; the same number as ENF_ABI_VERSION in csrc/include/enfilade/base.h.
ABI_VERSION = 6


class Status(c_int32):
    """Result type of a fallible call; the loader turns anything but ENF_OK into an exception."""


class SceneHandle(c_void_p):
    """EnfScene *"""


class ViewHandle(c_void_p):
    """EnfView *"""


class JobHandle(c_void_p):
    """EnfJob *"""


class RegionVisHandle(c_void_p):
    """EnfRegionVis *"""


class ObjectVisHandle(c_void_p):
    """EnfObjectVis *"""


class ChainQueryHandle(c_void_p):
    """EnfChainQuery *"""


class RaycasterHandle(c_void_p):
    """EnfRaycaster *"""


class TrianglesHandle(c_void_p):
    """EnfTriangles *"""


class LightSetsHandle(c_void_p):
    """EnfLightSets *"""


U32, U64, F64, TEXT = c_uint32, c_uint64, c_double, c_char_p
PU32, PU64, PF64, PU8 = POINTER(c_uint32), POINTER(c_uint64), POINTER(c_double), POINTER(c_uint8)
# Arrays that numpy owns go in as plain addresses: their dtype and shape are checked in buffers.py.
IN = c_void_p
SCENE, VIEW, JOB, REGION, RAYS = SceneHandle, ViewHandle, JobHandle, RegionVisHandle, RaycasterHandle
TRIANGLES, LIGHTS = TrianglesHandle, LightSetsHandle

FUNCTIONS: tuple[tuple[str, object, tuple[object, ...]], ...] = (
    # base.h
    ("enf_status_string", TEXT, (Status,)),
    ("enf_last_error", TEXT, ()),
    ("enf_version", TEXT, ()),
    ("enf_abi_version", U32, ()),
    ("enf_struct_size", U64, (TEXT,)),
    ("enf_live_bytes", U64, ()),
    ("enf_peak_bytes", U64, ()),
    # scene.h: life and files
    ("enf_scene_create", Status, (POINTER(SCENE),)),
    ("enf_scene_destroy", None, (SCENE,)),
    ("enf_scene_load", Status, (TEXT, POINTER(SCENE))),
    ("enf_scene_load_memory", Status, (IN, U64, POINTER(SCENE))),
    ("enf_scene_save_json", Status, (SCENE, TEXT)),
    # scene.h: adding
    ("enf_scene_add_room", Status, (SCENE, TEXT, U32, PU32)),
    ("enf_scene_add_cell", Status, (SCENE, U32, U32, IN, U64, U64, IN, U64, IN, PU32)),
    ("enf_scene_add_portal", Status, (SCENE, U32, U32, IN, U64, U64, U32, PU32)),
    ("enf_scene_add_opening", Status, (SCENE, TEXT, U32, U32, PU32)),
    ("enf_scene_add_object", Status, (SCENE, TEXT, IN, IN, U64, U32, PU32)),
    ("enf_scene_add_objects", Status, (SCENE, U64, TEXT, U64, IN, U64, IN, PU32)),
    ("enf_scene_set_occluder", Status, (SCENE, U32, IN, U64, IN, U64)),
    ("enf_scene_add_light", Status, (SCENE, TEXT, IN, PU32)),
    ("enf_default_camera", s.EnfCamera, ()),
    ("enf_scene_add_camera", Status, (SCENE, TEXT, POINTER(s.EnfCamera), PU32)),
    # scene.h: building from rooms
    ("enf_scene_add_room_polyhedron", Status, (SCENE, U32, IN, U64, U64, IN, U64, IN, PU32, PU32)),
    ("enf_scene_add_room_prism", Status, (SCENE, U32, IN, IN, U64, F64, F64, PU32, PU32)),
    ("enf_scene_join", Status, (SCENE, U32, U32, U32, U32, IN, U64, U64, U32, PU32, PU32)),
    # scene.h: the outdoors
    ("enf_default_exterior_def", s.EnfExteriorDef, ()),
    ("enf_scene_decompose_exterior", Status, (SCENE, POINTER(s.EnfExteriorDef), POINTER(s.EnfExteriorReport))),
    # scene.h: commit and problems
    ("enf_scene_commit", Status, (SCENE,)),
    ("enf_scene_problem_count", U64, (SCENE,)),
    ("enf_scene_problem", Status, (SCENE, U64, POINTER(s.EnfProblem))),
    # scene.h: reading
    ("enf_scene_counts", Status, (SCENE, POINTER(s.EnfSceneCounts))),
    ("enf_scene_cell_rooms", PU32, (SCENE,)),
    ("enf_scene_cell_openings", PU32, (SCENE,)),
    ("enf_scene_portal_cells", PU32, (SCENE,)),
    ("enf_scene_portal_openings", PU32, (SCENE,)),
    ("enf_scene_portal_vertex_first", PU32, (SCENE,)),
    ("enf_scene_portal_vertices", PF64, (SCENE,)),
    ("enf_scene_cell_vertex_first", PU32, (SCENE,)),
    ("enf_scene_cell_vertices", PF64, (SCENE,)),
    ("enf_scene_room_name", TEXT, (SCENE, U32)),
    ("enf_scene_room_kind", U32, (SCENE, U32)),
    ("enf_scene_opening_name", TEXT, (SCENE, U32)),
    ("enf_scene_opening", Status, (SCENE, U32, PU32, PU32)),
    ("enf_scene_set_opening_state", Status, (SCENE, U32, U32)),
    ("enf_scene_object_name", TEXT, (SCENE, U32)),
    ("enf_scene_object_cells", Status, (SCENE, U32, POINTER(PU32), PU32)),
    ("enf_scene_camera_name", TEXT, (SCENE, U32)),
    ("enf_scene_camera", Status, (SCENE, U32, POINTER(s.EnfCamera))),
    ("enf_scene_locate", Status, (SCENE, IN, IN, U32, PU32)),
    # portal_vis.h
    ("enf_default_view_def", s.EnfViewDef, ()),
    ("enf_default_view_result", s.EnfViewResult, ()),
    ("enf_default_view_stats", s.EnfViewStats, ()),
    ("enf_view_create", Status, (SCENE, POINTER(VIEW))),
    ("enf_view_create_shared", Status, (VIEW, POINTER(VIEW))),
    ("enf_view_destroy", None, (VIEW,)),
    ("enf_view_query", Status, (VIEW, POINTER(s.EnfCamera), POINTER(s.EnfViewDef))),
    ("enf_view_query_union", Status, (VIEW, POINTER(s.EnfCamera), U32, U32, POINTER(s.EnfViewDef))),
    ("enf_view_query_region", Status, (VIEW, IN, POINTER(s.EnfCamera), POINTER(s.EnfViewDef))),
    ("enf_view_result", Status, (VIEW, POINTER(s.EnfViewResult))),
    ("enf_view_stats", Status, (VIEW, POINTER(s.EnfViewStats))),
    ("enf_view_why_cell", Status, (VIEW, U32, IN, U32, PU32)),
    ("enf_view_why_object", Status, (VIEW, U32, IN, U32, PU32)),
    ("enf_view_groups", Status, (VIEW, PU32, POINTER(PU32), POINTER(PU32), POINTER(PU32))),
    # job.h
    ("enf_default_job_progress", s.EnfJobProgress, ()),
    ("enf_job_progress", Status, (JOB, POINTER(s.EnfJobProgress))),
    ("enf_job_cancel", None, (JOB,)),
    ("enf_job_wait", Status, (JOB, F64, PU32)),
    ("enf_job_destroy", None, (JOB,)),
    # chain_query.h
    ("enf_default_chain_answer", s.EnfChainAnswer, ()),
    ("enf_chain_query_create", Status, (POINTER(ChainQueryHandle),)),
    ("enf_chain_query_destroy", None, (ChainQueryHandle,)),
    ("enf_chain_query", Status, (ChainQueryHandle, IN, IN, U32, F64, POINTER(s.EnfChainAnswer))),
    # region_vis.h
    ("enf_default_region_vis_def", s.EnfRegionVisDef, ()),
    ("enf_default_region_vis_stats", s.EnfRegionVisStats, ()),
    ("enf_region_vis_start", Status, (SCENE, POINTER(s.EnfRegionVisDef), POINTER(JOB))),
    ("enf_region_vis_take", Status, (JOB, POINTER(REGION))),
    ("enf_region_vis_run", Status, (SCENE, POINTER(s.EnfRegionVisDef), POINTER(REGION))),
    ("enf_region_vis_destroy", None, (REGION,)),
    ("enf_region_vis_load", Status, (SCENE, POINTER(TEXT), U32, POINTER(REGION))),
    ("enf_region_vis_save", Status, (REGION, TEXT)),
    ("enf_region_vis_cell_count", U32, (REGION,)),
    ("enf_region_vis_row_first", PU64, (REGION,)),
    ("enf_region_vis_row_cells", PU32, (REGION,)),
    ("enf_region_vis_row_status", PU8, (REGION,)),
    ("enf_region_vis_pair", Status, (REGION, U32, U32, PU32)),
    ("enf_region_vis_witness", Status, (REGION, U32, U32, IN, IN, U32, PU32, PF64)),
    ("enf_region_vis_rooms", Status, (REGION, U32, U32, PU32, PU32, PU32)),
    ("enf_region_vis_object", Status, (REGION, U32, U32, PU32, PU32)),
    ("enf_object_vis_run", Status, (REGION, IN, U32, IN, U32, U32, POINTER(ObjectVisHandle))),
    ("enf_object_vis_destroy", None, (ObjectVisHandle,)),
    ("enf_object_vis_row_count", U32, (ObjectVisHandle,)),
    ("enf_object_vis_row_first", PU64, (ObjectVisHandle,)),
    ("enf_object_vis_row_objects", PU32, (ObjectVisHandle,)),
    ("enf_object_vis_row_status", PU8, (ObjectVisHandle,)),
    ("enf_object_vis_row_cells", PU32, (ObjectVisHandle,)),
    ("enf_object_vis_witness", Status, (ObjectVisHandle, U64, IN, IN, U32, PU32)),
    ("enf_region_vis_stats", Status, (REGION, POINTER(s.EnfRegionVisStats))),
    ("enf_region_vis_write_matrix", Status, (REGION, TEXT)),
    ("enf_region_vis_write_witnesses", Status, (REGION, TEXT)),
    # raycast.h
    ("enf_raycaster_create", Status, (SCENE, POINTER(RAYS))),
    ("enf_raycaster_destroy", None, (RAYS,)),
    ("enf_raycaster_face_count", U32, (RAYS,)),
    ("enf_raycast_rays", Status, (RAYS, POINTER(s.EnfRay), U64, POINTER(s.EnfRayHit))),
    ("enf_raycaster_furnish", Status, (RAYS, TRIANGLES)),
    ("enf_default_surface", s.EnfSurface, ()),
    ("enf_raycaster_surface", Status, (RAYS, U32, POINTER(s.EnfSurface))),
    ("enf_raycaster_origin", None, (RAYS, PF64)),
    ("enf_default_ray_batch", s.EnfRayBatch, ()),
    ("enf_default_ray_hits", s.EnfRayHits, ()),
    ("enf_raycast_closest", Status, (RAYS, POINTER(s.EnfRayBatch), POINTER(s.EnfRayHits))),
    ("enf_raycast_any", Status, (RAYS, POINTER(s.EnfRayBatch), PU8)),
    ("enf_default_raycast_image", s.EnfRaycastImage, ()),
    ("enf_raycast_image", Status, (RAYS, POINTER(s.EnfCamera), POINTER(s.EnfRaycastImage))),
    # triangles.h
    ("enf_triangles_create", Status, (PF64, POINTER(TRIANGLES))),
    ("enf_triangles_destroy", None, (TRIANGLES,)),
    ("enf_triangles_add_material", Status, (TRIANGLES, POINTER(s.EnfMaterial), PU32)),
    ("enf_triangles_add_mesh", Status, (TRIANGLES, U32, IN, U64, U64, IN, U64, IN, IN)),
    ("enf_triangles_commit", Status, (TRIANGLES,)),
    ("enf_default_triangle_counts", s.EnfTriangleCounts, ()),
    ("enf_triangles_counts", Status, (TRIANGLES, POINTER(s.EnfTriangleCounts))),
    ("enf_triangles_hit", Status, (TRIANGLES, IN, IN, IN, U64, POINTER(s.EnfTriangleHit))),
    # lighting.h
    ("enf_default_light", s.EnfLight, ()),
    ("enf_default_light_sets_stats", s.EnfLightSetsStats, ()),
    ("enf_light_sets_create", Status, (SCENE, POINTER(s.EnfLight), U32, U32, U32, POINTER(LIGHTS))),
    ("enf_light_sets_destroy", None, (LIGHTS,)),
    ("enf_light_sets_first", PU64, (LIGHTS,)),
    ("enf_light_sets_lights", PU32, (LIGHTS,)),
    ("enf_light_sets_stats", Status, (LIGHTS, POINTER(s.EnfLightSetsStats))),
    ("enf_default_direct_light", s.EnfDirectLight, ()),
    ("enf_direct_light", Status, (POINTER(s.EnfDirectLight), POINTER(s.EnfLitPoint), U64, IN, IN)),
    # preview.h
    ("enf_default_panorama", s.EnfPanorama, ()),
    ("enf_default_preview", s.EnfPreview, ()),
    ("enf_preview", Status, (POINTER(s.EnfPreview), POINTER(s.EnfCamera))),
    ("enf_preview_edges", Status, (POINTER(s.EnfPreview), POINTER(s.EnfCamera))),
    ("enf_preview_smooth", Status, (IN, IN, IN, U32, U32, U32)),
    # voxels.h
    ("enf_voxels_mark", Status, (IN, IN, F64, IN, U64, U64, IN, U64, c_uint8, IN)),
    ("enf_voxels_label", Status, (IN, IN, IN, PU32)),
    ("enf_voxels_grow", Status, (IN, IN, U32, IN)),
    ("enf_voxels_boxes", Status, (IN, IN, U32, IN)),
    ("enf_voxels_runs", Status, (IN, IN, IN, IN)),
    ("enf_voxels_widen", Status, (IN, IN, IN)),
    ("enf_voxels_rename", Status, (IN, IN, U32, IN)),
)

# In the headers, but of no use from Python: an allocator written in Python would be called without the GIL held safely
# only through ctypes' slow path, and per allocation.
NOT_BOUND = frozenset({"enf_set_allocator"})

__all__ = ["ABI_VERSION", "ChainQueryHandle", "FUNCTIONS", "NOT_BOUND", "ObjectVisHandle", "JobHandle", "LightSetsHandle", "RaycasterHandle", "RegionVisHandle",
           "SceneHandle", "Status", "TrianglesHandle", "ViewHandle"]
