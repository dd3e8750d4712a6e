/* The seam to Embree (embree.c): trees of boxes that show every face, or occluder, whose box a ray may touch.
 */
#ifndef HPR_VISIBILITY_RAYS_H
#define HPR_VISIBILITY_RAYS_H

#include "visibility/visibility.h"

typedef struct hpr_rays hpr_rays;

/* Builds the trees over visibility->front and over the occluders; everything but `rays` must be set. Errors:
 * HPR_ERR_DEVICE, HPR_ERR_MEMORY. */
hpr_status hpr_rays_create(const hpr_visibility *visibility, hpr_rays **rays);
void hpr_rays_destroy(hpr_rays **rays);

/* True if one of the listed occluders (rising) blocks x-y by hpr_occluder_blocks. start-stop is the part of
 * the segment near the scene, within the ball of radius 1.1 around the origin. All in scene units. */
bool hpr_rays_blocked(const hpr_rays *rays, const double x[3], const double y[3], const double start[3],
                      const double stop[3], const uint32_t *listed, size_t listed_count);

/* A ray in scene units: base within the ball of radius 1.1, direction of length 1. `offset` is what lies
 * before base: near < offset + distance < far. `length` ends the search. */
typedef struct hpr_ray {
    double base[3], direction[3];
    double offset, near, far, length;
    bool cull;
} hpr_ray;

/* The nearest hit; of those in one plane, within rounding, a front before a back, then a patch with a twin,
 * then the lowest index. hit.distance includes offset, in scene units. */
hpr_hit hpr_rays_first(const hpr_rays *rays, const hpr_ray *ray, bool *back);

#endif
