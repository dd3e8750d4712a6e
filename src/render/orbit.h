/* Views around a scene. */
#ifndef HPR_RENDER_ORBIT_H
#define HPR_RENDER_ORBIT_H

#include "scene/scene.h"

/*
 * The camera turned by the angle 2 pi step / steps about the vertical (+y) through `centre`,
 * counter-clockwise as seen from above; step 0 is the camera itself, bit for bit. The name is shared.
 */
hpr_camera hpr_camera_orbit(const hpr_camera *camera, const double centre[3], size_t step, size_t steps);

#endif
