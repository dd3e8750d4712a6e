/*
 * Who can see whom. The only user of Embree. Embree works in float32 and only finds candidates: predicates in
 * double decide, so that a ray neither leaks along an edge nor stops at the patch that it starts from.
 */
#ifndef HPR_VISIBILITY_VISIBILITY_H
#define HPR_VISIBILITY_VISIBILITY_H

#include "patch/patches.h"

typedef struct hpr_visibility hpr_visibility;

typedef enum hpr_verdict {
    HPR_SEES_NOTHING, /* facing away, coplanar, or wholly behind one another */
    HPR_SEES_WHOLLY,  /* no patch can come between */
    HPR_SEES_PARTLY   /* some patch may come between */
} hpr_verdict;

/* A planar convex piece of a patch: its corners (at most 4) and the patch's normal. */
typedef struct hpr_facet {
    size_t corner_count;
    double corner[4][3];
    double normal[3];
} hpr_facet;

/* Builds the ray structure over all patches, recentred and scaled to unit size. Twins share one geometry.
 * Errors: HPR_ERR_DEVICE, HPR_ERR_MEMORY. Borrows `patches` until destroyed. */
hpr_status hpr_visibility_create(const hpr_patches *patches, hpr_visibility **visibility);
void hpr_visibility_destroy(hpr_visibility **visibility);

/* The patches that it was made from. */
const hpr_patches *hpr_visibility_patches(const hpr_visibility *visibility);

/*
 * Conservative verdict for two facets. A patch can come between only if its plane has points of the two
 * facets strictly on both sides, it reaches strictly in front of both facets' planes, it meets the interior
 * of the box around both, and no plane of their convex hull has it outside. "Strictly" is by more than the
 * slack: 1e-12 of the scene's size plus 8 eps of its largest coordinate (faces.h).
 * `candidates` [candidate_count]: patches to consider (rising, as a classify of larger facets lists them),
 * NULL: all. The blockers found go to `blockers` (room for candidate_count, or for all patches; NULL: not
 * wanted) in rising order and *blocker_count. Of twins only the front is listed. Never says HPR_SEES_WHOLLY
 * when something blocks, nor HPR_SEES_NOTHING when something is seen. Thread-safe.
 */
hpr_verdict hpr_visibility_classify(const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b,
                                    const uint32_t *candidates, size_t candidate_count, uint32_t *blockers,
                                    size_t *blocker_count);

/* True if nothing can come between the patch and any other that faces it, backs of others included. Quadratic
 * in the number of patches. Thread-safe. */
bool hpr_visibility_unobstructed(const hpr_visibility *visibility, size_t patch);

/*
 * True if one of the given patches (rising, as classify lists them) cuts the open segment x-y: x and y lie
 * strictly on both sides of its plane and the crossing point is in the closed patch. Double precision; long
 * lists are searched through Embree with the same predicate. Thread-safe.
 */
bool hpr_visibility_blocked(const hpr_visibility *visibility, const double x[3], const double y[3],
                            const uint32_t *blockers, size_t blocker_count);

typedef struct hpr_hit {
    uint32_t patch; /* HPR_NONE: nothing hit */
    double s, t;    /* parameters in the patch */
    double distance;
} hpr_hit;

/*
 * Nearest patch along origin + d direction, near < d < far (direction of length 1). cull: backs of
 * single-sided patches let the ray through, as glTF culls them; else they stop it (patch is then the one
 * whose back is hit and *back is set, back may be NULL). Of twins the side that faces the origin is returned.
 * Distance and parameters are computed in double; equal distances go to the lowest index. Thread-safe.
 */
hpr_hit hpr_visibility_first_hit(const hpr_visibility *visibility, const double origin[3],
                                 const double direction[3], double near, double far, bool cull, bool *back);

#endif
