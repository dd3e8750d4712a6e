/* Where no light comes: what is shut in between the backs of things, as the floor and the wall in a cupboard
 * that has neither bottom nor back of its own. */
#ifndef HPR_LINK_SHUT_H
#define HPR_LINK_SHUT_H

#include "quadrature/cuts.h"
#include "visibility/visibility.h"

/* A convex piece of a patch, in the patch's parameters. */
typedef struct hpr_region {
    hpr_polygon outline;
    uint32_t patch;
    uint32_t against;     /* patch in its plane that faces the other way, HPR_NONE: none */
    double against_at[2]; /* where the region's middle is on it */
    bool covered;         /* it neither sees nor sends */
    bool shut;
} hpr_region;

/* The region of a patch that holds a point; first [patches + 1]: the regions of each patch. The last one if
 * rounding puts it in none. */
size_t hpr_region_at(const hpr_region *region, const size_t *first, size_t patch, double s, double t);

/*
 * Sets `shut`, and more of `covered`, of regions that cover all patches. From the middle of each go rays in
 * directions on a Fibonacci lattice, cosine distributed. Where one region lies against another they cover
 * each other if one of them sees only backs: it is in a body that stands there. Else they are the two sides
 * of a thin wall. Regions of which one sees the other's front are in one space. A region is shut if it is
 * covered, or if in its space no emitter shines on anything and from nowhere in it a ray leaves the scene.
 * slack: rays do not see what is nearer. Same result for any thread count. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_regions_shut(const hpr_visibility *visibility, double slack, hpr_region *region,
                            const size_t *first);

#endif
