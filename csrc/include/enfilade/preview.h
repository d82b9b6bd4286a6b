/* SPDX-License-Identifier: GPL-3.0-or-later
 * Pictures without a renderer, GPU or display: what a camera sees, as layers to look at and to compute with.
 *
 * Primary rays meet what is drawn (triangles), or the cells alone; the walk through the cells beside them tells room, openings and the
 * lights to ask. Rows are independent: a caller renders a few at a time, shows progress, stops when it likes.
 * Mirrors and glass reflect and refract up to max_bounces times, each ray starting in the cell where it is. */
#ifndef ENFILADE_PREVIEW_H
#define ENFILADE_PREVIEW_H

#include "enfilade/lighting.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Panoramas as Blender has them, for cameras of type ENF_CAMERA_PANO. */
enum {
    ENF_PANORAMA_EQUIRECTANGULAR = 0,
    ENF_PANORAMA_FISHEYE_EQUIDISTANT = 1,
    ENF_PANORAMA_FISHEYE_EQUISOLID = 2,
    ENF_PANORAMA_MIRROR_BALL = 3,
    ENF_PANORAMA_FISHEYE_POLYNOMIAL = 4,
    ENF_PANORAMA_CUBE_FACE = 5, /* of even angles */
    ENF_PANORAMA_CYLINDER = 6   /* seen from its axis */
};
typedef struct EnfPanorama {
    uint32_t kind; /* ENF_PANORAMA_* */
    uint32_t reserved;
    double longitude[2], latitude[2]; /* equirectangular: left, right; bottom, top. Radians. cylinder: latitude as height over radius */
    double field;                     /* fisheyes: whole field, radians */
    double lens, sensor_width, sensor_height; /* millimetres; lens: equisolid; sensor: also polynomial */
    double polynomial[5];                     /* polynomial: minus the angle off the axis by powers of the millimetres on the sensor */
} EnfPanorama;
ENF_API EnfPanorama enf_default_panorama(void); /* the whole sphere */

typedef struct EnfPreview {
    uint32_t struct_size;
    uint32_t width, height;        /* 1 .. 16384 */
    uint32_t row_first, row_count; /* rows to render now, row 0 at the top; row_count 0: all */
    uint32_t threads;              /* 0: one a core; the same bits for any number */
    EnfPanorama panorama;
    const EnfRaycaster *raycaster; /* cells; may be NULL when there are triangles */
    const EnfTriangles *triangles; /* committed; NULL: the cells' faces are drawn */
    const EnfLight *lights;
    const EnfLightSets *light_sets;    /* NULL: every light is asked */
    const EnfMaterial *face_materials; /* [face_count + portals], for cells drawn alone: mirrors, glass; NULL: all grey */
    uint32_t light_count;
    uint32_t light_samples;   /* points of a light with a size, 1 .. 64 [default: 4] */
    uint32_t max_bounces;     /* at mirrors and glass, 0 .. 16 [default: 4]; glass is looked through even when they are used up */
    uint32_t ambient_samples; /* rays a pixel that measure how open its surroundings are, 0 .. 64 [default: 6] */
    double ambient_reach;     /* metres beyond which nothing shades [default: 1.5] */
    uint32_t edge_samples;    /* rays more for pixels on an edge, 1 .. 64 (enf_preview_edges) [default: 8] */
    uint32_t reserved;
    float sky[3], ground[3]; /* radiance of the surroundings from above and from below */
    float background[2][3];  /* where nothing is: at the horizon, at the zenith */
    /* Layers, each [height][width]; any may be NULL. All but `direct` and `surroundings` are of the pixel's centre alone. */
    float *depth;        /* metres: along the view axis; along the ray for panoramas. Infinity: nothing */
    uint32_t *object;    /* triangles: their mesh's number; cells: the surface, as in EnfRayHit. ENF_NONE: nothing */
    uint32_t *cell;      /* where the ray ended, ENF_NONE: in none */
    uint8_t *openings;   /* doors, windows and holes looked through, at most 255 */
    float *normal;       /* [3] world, towards the viewer; 0, 0, 0: nothing */
    float *albedo;       /* [3] colour of the surface */
    float *direct;       /* [3] radiance from lights, emission, mirrors, glass, background */
    float *surroundings; /* [3] radiance of what comes from all around, were nothing in its way */
    float *open;         /* share of the surroundings that is open, 0 .. 1; grainy, see enf_preview_smooth */
    uint16_t *lit;       /* lights that reach the pixel */
    float *coverage;     /* [4][2] objects of the pixel by falling share: number, share; -1, 0: none (enf_preview_edges) */
    /* out, added up over calls */
    uint64_t rays; /* primary */
    uint64_t bounce_rays, ambient_rays, shadow_rays, lights_asked, edge_pixels;
} EnfPreview;
ENF_API EnfPreview enf_default_preview(void);

/* Renders the rows asked for. What it reads (raycaster, triangles, sets) may be read by others at the same time: safe on different
 * previews. ENF_ERROR_BAD_INPUT: a camera or a light whose numbers make no sense. */
ENF_API EnfStatus enf_preview(EnfPreview *preview, const EnfCamera *camera);
/* Once all rows are there: sends more rays through the pixels whose neighbours show another object, or a surface turned otherwise;
 * averages direct and surroundings there and fills coverage. Needs the layers object, depth and normal. Rows as above. */
ENF_API EnfStatus enf_preview_edges(EnfPreview *preview, const EnfCamera *camera);

/* Evens out the grain of the layer `open` over neighbours of the same surface: pixels whose depth and normal go on. In place. */
ENF_API EnfStatus enf_preview_smooth(float *open, const float *depth, const float *normal, uint32_t width, uint32_t height,
                                     uint32_t threads);

#ifdef __cplusplus
}
#endif
#endif
