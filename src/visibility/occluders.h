/*
 * Occluders: what blocks, apart from how it is tessellated. Patches that lie in one plane and adjoin are
 * merged to convex polygons, so that a wall of a thousand patches is one thing that a ray has to be tested
 * against, and one polygon that a clipper has to cut out.
 */
#ifndef HPR_VISIBILITY_OCCLUDERS_H
#define HPR_VISIBILITY_OCCLUDERS_H

#include "math/convex.h"
#include "patch/patches.h"

/* Merging stops here; clipping by two planes must still fit into an hpr_convex. */
enum { HPR_OCCLUDER_CORNERS = 16 };

/* The plane of an occluder: a point in metres and its normal. */
typedef struct hpr_occluder_plane {
    double origin[3], normal[3];
} hpr_occluder_plane;

/*
 * The union of the listed patches as convex polygons, in metres: outline [*occluder_count], plane
 * [*occluder_count], both allocated here. The order is that of each one's lowest patch. A patch that is
 * merged with no other keeps its plane bit by bit, so that it does not hide itself; corners nearer to each
 * other than slack or patches->weld_m become one, and may so be off that plane. Merged are polygons that
 * share an edge, lie in one plane and have a convex union, as long as nothing moves by more than `slack`;
 * polygons that lie within another of their plane are left out. The same for any order of threads. Errors:
 * HPR_ERR_MEMORY.
 */
hpr_status hpr_occluders_merge(const hpr_patches *patches, const uint32_t *listed, size_t listed_count,
                               double slack, hpr_convex **outline, hpr_occluder_plane **plane,
                               size_t *occluder_count);

#endif
