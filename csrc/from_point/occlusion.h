/* SPDX-License-Identifier: GPL-3.0-or-later
 * Occluders in a traversal: drawn as their cells are reached, asked before portals are crossed and objects are taken. */
#ifndef ENF_FROM_POINT_OCCLUSION_H
#define ENF_FROM_POINT_OCCLUSION_H

#include "from_point/view_data.h"

/* Packs which cells hold which occluders. */
EnfStatus enf_occlusion_pack(EnfViewIndex *index);

/* Whether occluders can be used on the screen at all: there are some, one eye, perspective. */
int enf_occlusion_possible(const EnfView *view, const EnfScreen *screen);
/* Begins a screen with an empty buffer (and the occluders in no cell); sets view->occluding. */
EnfStatus enf_occlusion_begin(EnfView *view, const EnfScreen *screen);
/* The cell's occluders; each is drawn once a screen. */
void enf_occlusion_draw(EnfView *view, const EnfScreen *screen, uint32_t cell);
/* Whether what `poly` shows of the portal is certainly hidden. distance: of the eye from the portal's plane, metres. */
int enf_occlusion_hides_portal(EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, double distance, const EnfPoly *poly,
                               const double rect[4]);
/* Whether what can be seen of the bounds within `rect` of the screen is certainly hidden. */
int enf_occlusion_hides_box(EnfView *view, const EnfScreen *screen, const double bounds[6], const double rect[4]);
/* Whether ENF_OCCLUDERS_AUTO wants them, after a traversal without: `objects` were kept on this screen. */
int enf_occlusion_pays(const EnfView *view, const EnfScreen *screen, uint32_t objects);

#endif
