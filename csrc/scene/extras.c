/* SPDX-License-Identifier: GPL-3.0-or-later
 * Unknown keys of a loaded file. */
#include "scene/extras.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

int enf_extras_add(EnfScene *scene, uint32_t item, uint32_t index, const char *text, size_t size) {
    if (!scene->extras && !(scene->extras = ENF_NEW(EnfExtras, 1)))
        return 0;
    EnfExtras *extras = scene->extras;
    if (!ENF_RESERVE(extras->items, extras->count + 1) || !ENF_RESERVE(extras->text, extras->text_size + size))
        return 0;
    memcpy(extras->text + extras->text_size, text, size);
    extras->items[extras->count++] = (EnfExtra){item, index, extras->text_size, size};
    extras->text_size += size;
    return 1;
}

void enf_extras_renumber(EnfExtras *extras, uint32_t item, const uint32_t *new_index, uint64_t count) {
    for (uint64_t i = 0; extras && i < extras->count; i++)
        if (extras->items[i].item == item && extras->items[i].index < count)
            extras->items[i].index = new_index[extras->items[i].index];
}

static int compare(const void *left, const void *right) {
    const EnfExtra *a = left, *b = right;
    if (a->item != b->item)
        return a->item < b->item ? -1 : 1;
    if (a->index != b->index)
        return a->index < b->index ? -1 : 1;
    return a->text < b->text ? -1 : a->text > b->text;
}

void enf_extras_sort(EnfExtras *extras) {
    if (extras && extras->count)
        qsort(extras->items, (size_t)extras->count, sizeof *extras->items, compare);
}

uint64_t enf_extras_find(const EnfExtras *extras, uint32_t item, uint32_t index, uint64_t *out_first) {
    if (!extras)
        return 0;
    EnfExtra wanted = {item, index, 0, 0};
    uint64_t low = 0, high = extras->count;
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        const EnfExtra *extra = &extras->items[middle];
        if (extra->item < wanted.item || (extra->item == wanted.item && extra->index < wanted.index))
            low = middle + 1;
        else
            high = middle;
    }
    uint64_t end = low;
    while (end < extras->count && extras->items[end].item == item && extras->items[end].index == index)
        end++;
    *out_first = low;
    return end - low;
}

void enf_extras_destroy(EnfExtras *extras) {
    if (!extras)
        return;
    enf_free(extras->items);
    enf_free(extras->text);
    enf_free(extras);
}
