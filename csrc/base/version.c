/* SPDX-License-Identifier: GPL-3.0-or-later
 * Versions, and the sizes of public structs for the shim's handshake. */
#include "enfilade/enfilade.h"

#include <string.h>

const char *enf_version(void) {
    return ENF_VERSION_STRING;
}
uint32_t enf_abi_version(void) {
    return ENF_ABI_VERSION;
}

uint64_t enf_struct_size(const char *struct_name) {
    /* One line for every struct of a public header. */
    static const struct {
        const char *name;
        uint64_t size;
    } table[] = {
        {"EnfCamera", sizeof(EnfCamera)},
        {"EnfChainAnswer", sizeof(EnfChainAnswer)},
        {"EnfExteriorDef", sizeof(EnfExteriorDef)},
        {"EnfExteriorReport", sizeof(EnfExteriorReport)},
        {"EnfJobProgress", sizeof(EnfJobProgress)},
        {"EnfDirectLight", sizeof(EnfDirectLight)},
        {"EnfLight", sizeof(EnfLight)},
        {"EnfLightSetsStats", sizeof(EnfLightSetsStats)},
        {"EnfLitPoint", sizeof(EnfLitPoint)},
        {"EnfMaterial", sizeof(EnfMaterial)},
        {"EnfPanorama", sizeof(EnfPanorama)},
        {"EnfPreview", sizeof(EnfPreview)},
        {"EnfTriangleCounts", sizeof(EnfTriangleCounts)},
        {"EnfTriangleHit", sizeof(EnfTriangleHit)},
        {"EnfProblem", sizeof(EnfProblem)},
        {"EnfRaycastImage", sizeof(EnfRaycastImage)},
        {"EnfRay", sizeof(EnfRay)},
        {"EnfRayBatch", sizeof(EnfRayBatch)},
        {"EnfRayHit", sizeof(EnfRayHit)},
        {"EnfRayHits", sizeof(EnfRayHits)},
        {"EnfRegionVisDef", sizeof(EnfRegionVisDef)},
        {"EnfRegionVisStats", sizeof(EnfRegionVisStats)},
        {"EnfSceneCounts", sizeof(EnfSceneCounts)},
        {"EnfSurface", sizeof(EnfSurface)},
        {"EnfViewDef", sizeof(EnfViewDef)},
        {"EnfViewResult", sizeof(EnfViewResult)},
        {"EnfViewStats", sizeof(EnfViewStats)},
    };
    for (size_t i = 0; struct_name && i < sizeof table / sizeof *table; i++)
        if (strcmp(struct_name, table[i].name) == 0)
            return table[i].size;
    return 0;
}
