/* SPDX-License-Identifier: GPL-3.0-or-later
 * Unknown keys of a loaded file: kept as the text they were, and written back where they stood. */
#ifndef ENF_SCENE_EXTRAS_H
#define ENF_SCENE_EXTRAS_H

#include "scene/scene_data.h"

#include <stddef.h>

typedef struct EnfExtra {
    uint32_t item, index; /* ENF_ITEM_*, and which one; ENF_NONE for the scene itself */
    uint64_t text, size;  /* into `text`: "key": value */
} EnfExtra;

typedef struct EnfExtras {
    EnfExtra *items;
    uint64_t count;
    char *text;
    uint64_t text_size;
} EnfExtras;

/* Keeps `"key": value`, given as raw JSON text. Gives 0 when memory runs out. */
int enf_extras_add(EnfScene *scene, uint32_t item, uint32_t index, const char *text, size_t size);
/* Gives the extras of item i the index new_index[i]. Before enf_extras_sort; extras NULL is fine. */
void enf_extras_renumber(EnfExtras *extras, uint32_t item, const uint32_t *new_index, uint64_t count);
/* Sorts by item, index; kept in file order within one. Call once after loading. */
void enf_extras_sort(EnfExtras *extras);
/* The extras of one item after enf_extras_sort: first in *out_first, number returned. */
uint64_t enf_extras_find(const EnfExtras *extras, uint32_t item, uint32_t index, uint64_t *out_first);
void enf_extras_destroy(EnfExtras *extras);

#endif
