/* SPDX-License-Identifier: GPL-3.0-or-later
 * A perspective camera that stands level, as tests and benchmarks look through rooms with. */
#ifndef ENF_TESTS_LEVEL_CAMERA_H
#define ENF_TESTS_LEVEL_CAMERA_H

#include "enfilade/enfilade.h"

/* Looks along `yaw` (radians from +x towards +y), `pitch` up; 90 x 59 degrees, no near or far end. */
EnfCamera level_camera(const double eye[3], double yaw, double pitch);

#endif
