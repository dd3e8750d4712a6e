/* A camera for scenes that bring none. */
#ifndef HPR_PATCH_FRAME_H
#define HPR_PATCH_FRAME_H

#include "patch/patches.h"

/*
 * A camera that frames the scene, for scenes without one: perspective, yfov 40 degrees, from the right and
 * above
 * (+x, +y, +z, as glTF has y up and z toward the viewer), as near as it can with every corner inside a square
 * picture with a border of 5%. name is NULL. No patches: it looks at the origin from a distance of 1.
 */
void hpr_patches_frame(const hpr_patches *patches, hpr_camera *camera);

#endif
