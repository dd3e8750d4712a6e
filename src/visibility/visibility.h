/*
 * Who can see whom. The only user of Embree. Embree works in float32 and only finds candidates: predicates in
 * double decide, so that a ray neither leaks along an edge nor stops at the patch that it starts from.
 */
#ifndef HPR_VISIBILITY_VISIBILITY_H
#define HPR_VISIBILITY_VISIBILITY_H

#include "math/convex.h"
#include "patch/patches.h"

typedef struct hpr_visibility hpr_visibility;

typedef enum hpr_verdict {
    HPR_SEES_NOTHING, /* facing away, coplanar, wholly behind one another, or hidden by one occluder */
    HPR_SEES_WHOLLY,  /* no occluder can come between */
    HPR_SEES_PARTLY   /* some occluder may come between */
} hpr_verdict;

/* A planar convex piece of a patch: its corners (at most 4) and the patch's normal. */
typedef struct hpr_facet {
    size_t corner_count;
    double corner[4][3];
    double normal[3];
} hpr_facet;

/*
 * Builds what rays need, recentred and scaled to unit size: the patches, of which twins share one geometry,
 * and the occluders. Occluders are what blocks, apart from how it is tessellated: patches of one plane that
 * adjoin, merged to convex polygons that cover the same up to the slack (see classify). They have indices of
 * their own, in the order of their lowest patches; if nothing merges and nothing is a twin, those of the
 * patches. Errors: HPR_ERR_DEVICE, HPR_ERR_MEMORY. Borrows `patches` until destroyed.
 */
hpr_status hpr_visibility_create(const hpr_patches *patches, hpr_visibility **visibility);
void hpr_visibility_destroy(hpr_visibility **visibility);

/* The two halves of it: all but rays (hpr_visibility_blocked and hpr_visibility_first_hit), for those who may
 * turn out to trace none, for Embree takes longer to start than a few pairs to integrate; and the rest. */
hpr_status hpr_visibility_create_untraced(const hpr_patches *patches, hpr_visibility **visibility);
hpr_status hpr_visibility_prepare_rays(hpr_visibility *visibility);

/* The patches that it was made from. */
const hpr_patches *hpr_visibility_patches(const hpr_visibility *visibility);

/* Points nearer than this to a plane are in it. */
double hpr_visibility_slack_m(const hpr_visibility *visibility);

size_t hpr_visibility_occluder_count(const hpr_visibility *visibility);

/* The occluders as polygons in metres, [occluder_count]; valid as long as `visibility` is. */
const hpr_convex *hpr_visibility_outlines(const hpr_visibility *visibility);

/*
 * Verdict for two facets, pieces of patches. An occluder can come between if its plane has points of the two
 * facets strictly on both sides and it meets the interior of their convex hull; of the facets only what is in
 * front of the other's plane counts. Nothing is seen if the facets face away, or if all segments from corner
 * to corner cross one and the same occluder (then all segments do: where they cross its plane is the convex
 * hull of the corners' crossings). "Strictly" is by more than the slack: 1e-12 of the scene's size plus 8 eps
 * of its largest coordinate (faces.h). So no facet is blocked by the occluder that it is part of.
 * `candidates` [candidate_count]: occluders to consider (rising, as a classify of larger facets lists them),
 * NULL: all. The blockers found go to `blockers` (room for candidate_count, or for all occluders; NULL: not
 * wanted) in rising order and *blocker_count (0 unless seen partly). Never says HPR_SEES_WHOLLY when
 * something blocks, nor HPR_SEES_NOTHING when something is seen. Thread-safe.
 */
hpr_verdict hpr_visibility_classify(const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b,
                                    const uint32_t *candidates, size_t candidate_count, uint32_t *blockers,
                                    size_t *blocker_count);

/* True if nothing can come between the patch and any other that faces it, backs of others included. Quadratic
 * in the number of patches. Thread-safe. */
bool hpr_visibility_unobstructed(const hpr_visibility *visibility, size_t patch);

/*
 * True if one of the given occluders (rising, as classify lists them) cuts the open segment x-y: x and y lie
 * strictly on both sides of its plane and the crossing point is in the closed polygon. Double precision; long
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
 * Distance and parameters are computed in double; of hits in one plane, within rounding, a
 * front comes before a back, then a patch with a twin before one without, as the former covers the latter
 * (link/coverage.h), then the lowest index. Thread-safe.
 */
hpr_hit hpr_visibility_first_hit(const hpr_visibility *visibility, const double origin[3],
                                 const double direction[3], double near, double far, bool cull, bool *back);

#endif
