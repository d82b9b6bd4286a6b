/* SPDX-License-Identifier: GPL-3.0-or-later
 * Embree 3, opened when the first triangle question is asked. Internal to the core.
 *
 * Wald, Woop, Benthin, Johnson, Ernst, Embree: a kernel framework for efficient CPU ray tracing, 2014. Opened
 * at run time, because visibility needs no triangles: the core and its tool run on machines without it. */
#ifndef ENF_RAYCAST_EMBREE_H
#define ENF_RAYCAST_EMBREE_H

#include "enfilade/base.h"

#include <embree3/rtcore.h>

#define ENF_EMBREE_CALLS(CALL)                                                                                                             \
    CALL(rtcNewDevice)                                                                                                                     \
    CALL(rtcReleaseDevice)                                                                                                                 \
    CALL(rtcGetDeviceError)                                                                                                                \
    CALL(rtcSetDeviceMemoryMonitorFunction)                                                                                                \
    CALL(rtcNewScene)                                                                                                                      \
    CALL(rtcReleaseScene)                                                                                                                  \
    CALL(rtcSetSceneFlags)                                                                                                                 \
    CALL(rtcAttachGeometry)                                                                                                                \
    CALL(rtcCommitScene)                                                                                                                   \
    CALL(rtcNewGeometry)                                                                                                                   \
    CALL(rtcSetSharedGeometryBuffer)                                                                                                       \
    CALL(rtcCommitGeometry)                                                                                                                \
    CALL(rtcReleaseGeometry)                                                                                                               \
    CALL(rtcIntersect1)                                                                                                                    \
    CALL(rtcIntersect16)                                                                                                                   \
    CALL(rtcOccluded1)                                                                                                                     \
    CALL(rtcOccluded8)                                                                                                                     \
    CALL(rtcOccluded16)

typedef struct Embree {
#define ENF_EMBREE_POINTER(name) __typeof__(&name) name;
    ENF_EMBREE_CALLS(ENF_EMBREE_POINTER)
#undef ENF_EMBREE_POINTER
} Embree;

/* ENF_ERROR_IO: no Embree 3 on this machine, or one without a call we need. */
EnfStatus enf_embree_open(Embree *embree);

#endif
