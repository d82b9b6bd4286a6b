/* SPDX-License-Identifier: GPL-3.0-or-later
 * The readers behind enf_scene_load. Each fills an empty, uncommitted scene; on failure the caller destroys
 * it. */
#ifndef ENF_SCENE_SCENE_FILE_H
#define ENF_SCENE_SCENE_FILE_H

#include "scene/scene_data.h"

/* `text` needn't end in a NUL. */
EnfStatus enf_scene_read_json(EnfScene *scene, const char *text, uint64_t size);
EnfStatus enf_scene_read_prt(EnfScene *scene, const char *text, uint64_t size);

#endif
