/* SPDX-License-Identifier: GPL-3.0-or-later
 * A portal onto the screen as a convex polygon. Internal to the from-point engine. */
#ifndef ENF_FROM_POINT_PROJECT_SIDE_H
#define ENF_FROM_POINT_PROJECT_SIDE_H

#include "from_point/aperture.h"
#include "from_point/parallax.h"
#include "from_point/view_data.h"

enum { ENF_PROJECT_OUT, ENF_PROJECT_POLYGON, ENF_PROJECT_WHOLE };

/* Projects a side's polygon; out of `rect` gives ENF_PROJECT_OUT. ENF_PROJECT_WHOLE: too near for a sound projection.
 * hull: a bent portal, whose corners may not project to a convex outline: their hull is taken. *out_error: how much the polygon may err, in screen units. */
int enf_project_side(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, int hull, const double rect[4], EnfPoly *out,
                     double *out_error);
/* What rays from any of the eyes may meet of it, as their middle sees it. */
int enf_project_parallax(const EnfView *view, const EnfScreen *screen, const EnfPortalSide *side, EnfDeepPoly *poly, double *out_error);

#endif
