/* SPDX-License-Identifier: GPL-3.0-or-later
 * Cells that are upright prisms, packed so that one look at sixteen corners of the outline tells where a ray leaves.
 * Internal to the core.
 *
 * The outline of a prism, counter-clockwise seen from above, has a corner wherever a wall or an opening in it begins: between two
 * corners stands a *section*, and up a section there are bands of wall and opening. Corners are single precision and the very same
 * bits in every cell that has them: on which side of an upright line a ray passes is then one answer for all of its cells.
 * Based on: Maria, Horna, Aveneau 2014, section 4 (convex volumes as prisms). */
#ifndef ENF_RAYCAST_PRISM_MODEL_H
#define ENF_RAYCAST_PRISM_MODEL_H

#include "enfilade/scene.h"

enum { PRISM_CHUNK = 16 }; /* corners looked at together; chunks overlap by one, so that each section lies in one of them whole */

/* Where a ray goes next: a node, a surface that ends it, a cell it never leaves again, or one whose planes must be asked (not a prism, a
 * cap with openings, a ray so upright that it leaves through no section). */
#define LINK_END     0x80000000u /* | surface */
#define LINK_OUT     0xA0000000u /* | cell without walls, into which no portal leads that a ray could leave through again: hits nothing */
#define LINK_PLANES  0xC0000000u /* | cell */
#define LINK_TALL    0xE0000000u /* | section whose bands decide; only between sections */
#define LINK_INDEX   0x3FFFFFFFu
#define LINK_SECTION 0x1FFFFFFFu
#define LINK_SURFACE 0x1FFFFFFFu
#define LINK_NOTHING (LINK_OUT | LINK_SURFACE) /* ended on the way: by its limit, at its target, or outdoors */

static inline int link_asks_planes(uint32_t link) {
    return link >= LINK_PLANES;
}

/* Of links that end a ray. */
static inline int link_hits_nothing(uint32_t link) {
    return link >= LINK_OUT;
}

/* One chunk of an outline. */
typedef struct PrismNode {
    float x[PRISM_CHUNK], y[PRISM_CHUNK]; /* what is left over repeats the last corner */
    float z[2];                           /* floor, ceiling */
    uint32_t cap_link[2];                 /* through the floor, through the ceiling */
    uint32_t section_first;               /* section i stands between corners i and i + 1 of this chunk */
    uint32_t next;                        /* a link: where to look when it leaves through none of these */
    uint32_t cell;
    uint32_t sections; /* that stand in this chunk, at most 15 */
} PrismNode;

/* Three heights do for nearly all walls. Where more windows stand above each other, a band leads to another section of the same place. */
enum { SECTION_HEIGHTS = 3 };
typedef struct PrismSection {
    float nx, ny;                       /* unit, outward */
    float height[SECTION_HEIGHTS];      /* ascending; infinity: not used */
    uint32_t link[SECTION_HEIGHTS + 1]; /* below, between and above the heights */
} PrismSection;

/* A link that leads through a portal while its opening is open, and to its leaf else. */
typedef struct PrismDoor {
    uint32_t link;    /* 4 * section + band, or 2 * node + which cap */
    uint32_t in_node; /* 1: a cap's */
    uint32_t portal, to;
} PrismDoor;

typedef struct PrismModel {
    PrismNode *nodes;
    PrismSection *sections; /* [section_count + PRISM_CHUNK] */
    uint32_t *node_of_cell; /* [cells] link to the first chunk, or LINK_PLANES | cell: where a ray starts */
    uint32_t *way_into;     /* [cells] the same, or LINK_OUT | cell: where a ray goes on */
    PrismDoor *doors;
    uint32_t node_count, section_count, door_count;
    uint32_t prisms;                /* cells that are */
    uint32_t open_sides, open_caps; /* of prisms: those whose rays ask the planes */
    uint32_t unwalled;              /* cells without faces */
} PrismModel;

struct EnfRaycaster;
EnfStatus enf_prism_model_build(PrismModel *model, const struct EnfRaycaster *raycaster);
/* Sets the links by the openings' states now. */
void enf_prism_model_set_doors(PrismModel *model, const struct EnfRaycaster *raycaster);
void enf_prism_model_free(PrismModel *model);

#endif
