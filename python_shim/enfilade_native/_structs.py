# SPDX-License-Identifier: GPL-3.0-or-later
"""Public C structs as ctypes, field by field as the headers have them; sizes are compared with the library's at load."""

from __future__ import annotations

from ctypes import (
    POINTER,
    Structure,
    c_char,
    c_char_p,
    c_double,
    c_float,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
)


class EnfCamera(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("type", c_uint32),
        ("world_from_camera", c_double * 16),
        ("angle_x", c_double),
        ("angle_y", c_double),
        ("shift_x", c_double),
        ("shift_y", c_double),
        ("ortho_width", c_double),
        ("ortho_height", c_double),
        ("clip_near", c_double),
        ("clip_far", c_double),
    ]


class EnfProblem(Structure):
    _fields_ = [
        ("severity", c_uint32),
        ("item", c_uint32),
        ("index", c_uint32),
        ("code", c_uint32),
        ("position", c_double * 3),
        ("message", c_char * 232),
    ]


class EnfSceneCounts(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("rooms", c_uint32),
        ("cells", c_uint32),
        ("portals", c_uint32),
        ("openings", c_uint32),
        ("objects", c_uint32),
        ("lights", c_uint32),
        ("cameras", c_uint32),
        ("seams", c_uint32),
        ("closed_portals", c_uint32),
        ("reserved", c_uint32),
    ]


class EnfExteriorDef(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("max_cells", c_uint32),
        ("wall_gap", c_double),
        ("slab_gap", c_double),
        ("margin", c_double),
        ("room_tops", POINTER(c_double)),
        ("room_count", c_uint64),
    ]


class EnfExteriorReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("outcome", c_uint32),
        ("cells", c_uint32),
        ("seams", c_uint32),
        ("portals", c_uint32),
        ("split", c_uint32),
        ("bodies", c_uint32),
        ("leaves", c_uint32),
        ("wall_gap", c_double),
        ("slab_gap", c_double),
        ("seconds", c_double),
    ]


class EnfRay(Structure):
    _fields_ = [
        ("origin", c_double * 3),
        ("direction", c_double * 3),
        ("max_distance", c_double),
        ("cell", c_uint32),
        ("reserved", c_uint32),
    ]


class EnfRayHit(Structure):
    _fields_ = [
        ("distance", c_double),
        ("surface", c_uint32),
        ("cell", c_uint32),
        ("portals", c_uint32),
        ("openings", c_uint32),
    ]


class EnfRayBatch(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("simd", c_uint32),
        ("threads", c_uint32),
        ("coherent", c_uint32),
        ("without_furniture", c_uint32),
        ("count", c_uint64),
        ("origin_x", POINTER(c_float)),
        ("origin_y", POINTER(c_float)),
        ("origin_z", POINTER(c_float)),
        ("direction_x", POINTER(c_float)),
        ("direction_y", POINTER(c_float)),
        ("direction_z", POINTER(c_float)),
        ("max_distance", POINTER(c_float)),
        ("cell", POINTER(c_uint32)),
        ("target_cell", POINTER(c_uint32)),
    ]


class EnfRayHits(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("distance", POINTER(c_float)),
        ("surface", POINTER(c_uint32)),
        ("cell", POINTER(c_uint32)),
        ("portals", POINTER(c_uint8)),
        ("normal", POINTER(c_float)),
        ("uv", POINTER(c_float)),
    ]


class EnfSurface(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_uint32),
        ("cell", c_uint32),
        ("portal", c_uint32),
        ("opening", c_uint32),
        ("object", c_uint32),
        ("normal", c_double * 3),
        ("point", c_double * 3),
        ("u", c_double * 3),
        ("v", c_double * 3),
    ]


class EnfRaycastImage(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("threads", c_uint32),
        ("depth", POINTER(c_float)),
        ("surface", POINTER(c_uint32)),
        ("cell", POINTER(c_uint32)),
        ("portals", POINTER(c_uint8)),
        ("spans", c_uint64),
        ("visits", c_uint64),
        ("patched", c_uint64),
        ("normal", POINTER(c_float)),
        ("uv", POINTER(c_float)),
        ("method", c_uint32),
        ("simd", c_uint32),
        ("without_furniture", c_uint32),
        ("reserved", c_uint32),
    ]


class EnfViewDef(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("want_objects", c_uint32),
        ("max_apertures", c_uint32),
        ("visit_cap", c_uint32),
        ("work_budget", c_uint32),
        ("use_simd", c_uint32),
        ("measure_stages", c_uint32),
        ("occluders", c_uint32),
        ("occluder_pixels", c_uint32),
        ("outdoors", c_uint32),
        ("reserved", c_uint32),
        ("distance_limit", c_double),
        ("start_tolerance", c_double),
        ("reuse_distance", c_double),
        ("reuse_angle", c_double),
    ]


class EnfViewStats(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("cells", c_uint32),
        ("objects", c_uint32),
        ("start_cells", c_uint32),
        ("visits", c_uint32),
        ("portals_tested", c_uint32),
        ("portals_projected", c_uint32),
        ("apertures", c_uint32),
        ("apertures_contained", c_uint32),
        ("apertures_sliver", c_uint32),
        ("merges_exact", c_uint32),
        ("merges_forced", c_uint32),
        ("cells_snapped", c_uint32),
        ("visit_cap_hit", c_uint32),
        ("budget_hit", c_uint32),
        ("portals_unclipped", c_uint32),
        ("objects_tested", c_uint32),
        ("objects_refined", c_uint32),
        ("objects_unplaced", c_uint32),
        ("screens", c_uint32),
        ("eyes", c_uint32),
        ("reused", c_uint32),
        ("hulls", c_uint32),
        ("occluder_polygons", c_uint32),
        ("portals_occluded", c_uint32),
        ("objects_occluded", c_uint32),
        ("eye_outside", c_uint32),
        ("near_in_wall", c_uint32),
        ("swept", c_uint32),
        ("windows", c_uint32),
        ("work", c_uint64),
        ("microseconds", c_double),
        ("microseconds_locate", c_double),
        ("microseconds_traverse", c_double),
        ("microseconds_objects", c_double),
    ]


class EnfViewResult(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("cell_count", c_uint32),
        ("object_count", c_uint32),
        ("step_count", c_uint32),
        ("cells", POINTER(c_uint32)),
        ("cell_step", POINTER(c_uint32)),
        ("objects", POINTER(c_uint32)),
        ("object_step", POINTER(c_uint32)),
        ("step_cell", POINTER(c_uint32)),
        ("step_portal", POINTER(c_uint32)),
        ("step_parent", POINTER(c_uint32)),
        ("cells_entered_count", c_uint32),
        ("cells_left_count", c_uint32),
        ("objects_entered_count", c_uint32),
        ("objects_left_count", c_uint32),
        ("cells_entered", POINTER(c_uint32)),
        ("cells_left", POINTER(c_uint32)),
        ("objects_entered", POINTER(c_uint32)),
        ("objects_left", POINTER(c_uint32)),
    ]


class EnfJobProgress(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("done", c_uint32),
        ("fraction", c_double),
        ("elapsed_s", c_double),
        ("phase", c_char * 48),
    ]


class EnfChainAnswer(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("status", c_uint32),
        ("shown_by", c_uint32),
        ("exact_signs", c_uint32),
        ("segment", c_double * 6),
        ("clearance", c_double),
        ("delta", c_double),
    ]


class EnfRegionVisDef(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("threads", c_uint32),
        ("from_count", c_uint32),
        ("from_cells", POINTER(c_uint32)),
        ("clearance", c_double),
        ("time_limit", c_double),
        ("sample_effort", c_double),
        ("shard_index", c_uint32),
        ("shard_count", c_uint32),
        ("state_path", c_char_p),
        ("seed", c_uint64),
        ("chain_cap", c_uint64),
        ("block_cells", c_uint32),
        ("reserved", c_uint32),
        ("variant_of", c_void_p),
    ]


class EnfRegionVisStats(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("threads", c_uint32),
        ("interrupted", c_uint32),
        ("cells", c_uint64),
        ("portals", c_uint64),
        ("visible_pairs", c_uint64),
        ("proven_pairs", c_uint64),
        ("grazing_pairs", c_uint64),
        ("undecided_pairs", c_uint64),
        ("hidden_certified", c_uint64),
        ("wall_s", c_double),
        ("cpu_s", c_double),
        ("peak_bytes", c_uint64),
        ("clearance", c_double),
        ("might_pairs", c_uint64),
        ("seed_lines", c_uint64),
        ("seed_pairs", c_uint64),
        ("chains", c_uint64),
        ("clips", c_uint64),
        ("targets_dropped", c_uint64),
        ("line_tests", c_uint64),
        ("line_hits", c_uint64),
        ("cone_tests", c_uint64),
        ("cone_hidden", c_uint64),
        ("cone_visible", c_uint64),
        ("cone_rays", c_uint64),
        ("filter_failures", c_uint64),
        ("exact_signs", c_uint64),
        ("chain_capped", c_uint64),
        ("skipped_cells", c_uint64),
        ("might_s", c_double),
        ("seed_s", c_double),
        ("search_s", c_double),
        ("blocks", c_uint64),
        ("blocks_loaded", c_uint64),
        ("pairs_kept", c_uint64),
        ("pairs_reopened", c_uint64),
        ("partial", c_uint64),
        ("cone_signs", c_uint64),
    ]


class EnfMaterial(Structure):
    _fields_ = [
        ("kind", c_uint32),
        ("colour", c_float * 3),
        ("emission", c_float * 3),
        ("ior", c_float),
    ]


class EnfTriangleCounts(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("committed", c_uint32),
        ("triangles", c_uint64),
        ("without_area", c_uint64),
        ("bytes", c_uint64),
        ("materials", c_uint32),
        ("reserved", c_uint32),
    ]


class EnfTriangleHit(Structure):
    _fields_ = [
        ("distance", c_double),
        ("normal", c_double * 3),
        ("triangle", c_uint32),
        ("object", c_uint32),
        ("material", c_uint32),
        ("reserved", c_uint32),
    ]


class EnfLight(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_uint32),
        ("position", c_double * 3),
        ("direction", c_double * 3),
        ("side", c_double * 3 * 2),
        ("radius", c_double),
        ("spot_angle", c_double),
        ("spot_blend", c_double),
        ("spread", c_double),
        ("intensity", c_double * 3),
        ("reach", c_double),
        ("ellipse", c_uint32),
        ("cosine", c_uint32),
    ]


class EnfLightSetsStats(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_uint32),
        ("pairs", c_uint64),
        ("lights", c_uint32),
        ("everywhere", c_uint32),
        ("dropped_behind", c_uint64),
        ("dropped_region", c_uint64),
        ("wall_s", c_double),
        ("bytes", c_uint64),
    ]


class EnfLitPoint(Structure):
    _fields_ = [
        ("position", c_double * 3),
        ("normal", c_double * 3),
        ("cell", c_uint32),
        ("seed", c_uint32),
    ]


class EnfDirectLight(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("raycaster", c_void_p),
        ("triangles", c_void_p),
        ("lights", POINTER(EnfLight)),
        ("light_sets", c_void_p),
        ("light_count", c_uint32),
        ("samples", c_uint32),
        ("shadow_rays", c_uint64),
        ("lights_asked", c_uint64),
        ("lights_reaching", c_uint64),
    ]


class EnfPanorama(Structure):
    _fields_ = [
        ("kind", c_uint32),
        ("reserved", c_uint32),
        ("longitude", c_double * 2),
        ("latitude", c_double * 2),
        ("field", c_double),
        ("lens", c_double),
        ("sensor_width", c_double),
        ("sensor_height", c_double),
        ("polynomial", c_double * 5),
    ]


class EnfPreview(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("row_first", c_uint32),
        ("row_count", c_uint32),
        ("threads", c_uint32),
        ("panorama", EnfPanorama),
        ("raycaster", c_void_p),
        ("triangles", c_void_p),
        ("lights", POINTER(EnfLight)),
        ("light_sets", c_void_p),
        ("face_materials", POINTER(EnfMaterial)),
        ("light_count", c_uint32),
        ("light_samples", c_uint32),
        ("max_bounces", c_uint32),
        ("ambient_samples", c_uint32),
        ("ambient_reach", c_double),
        ("edge_samples", c_uint32),
        ("reserved", c_uint32),
        ("sky", c_float * 3),
        ("ground", c_float * 3),
        ("background", c_float * 3 * 2),
        ("depth", POINTER(c_float)),
        ("object", POINTER(c_uint32)),
        ("cell", POINTER(c_uint32)),
        ("openings", POINTER(c_uint8)),
        ("normal", POINTER(c_float)),
        ("albedo", POINTER(c_float)),
        ("direct", POINTER(c_float)),
        ("surroundings", POINTER(c_float)),
        ("open", POINTER(c_float)),
        ("lit", POINTER(c_uint16)),
        ("coverage", POINTER(c_float)),
        ("rays", c_uint64),
        ("bounce_rays", c_uint64),
        ("ambient_rays", c_uint64),
        ("shadow_rays", c_uint64),
        ("lights_asked", c_uint64),
        ("edge_pixels", c_uint64),
    ]


STRUCTS: tuple[type[Structure], ...] = (
    EnfCamera,
    EnfProblem,
    EnfSceneCounts,
    EnfExteriorDef,
    EnfExteriorReport,
    EnfRay,
    EnfRayHit,
    EnfRayBatch,
    EnfRayHits,
    EnfSurface,
    EnfRaycastImage,
    EnfMaterial,
    EnfTriangleCounts,
    EnfTriangleHit,
    EnfLight,
    EnfLightSetsStats,
    EnfLitPoint,
    EnfDirectLight,
    EnfPanorama,
    EnfPreview,
    EnfViewDef,
    EnfViewStats,
    EnfViewResult,
    EnfJobProgress,
    EnfChainAnswer,
    EnfRegionVisDef,
    EnfRegionVisStats,
)
