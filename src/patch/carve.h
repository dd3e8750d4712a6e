/* Convex polygons in a plane, and what is left of one when others are cut out of it. */
#ifndef HPR_PATCH_CARVE_H
#define HPR_PATCH_CARVE_H

#include "base/context.h"
#include "math/vec3.h"

/* Pieces have at most HPR_CARVED_CORNERS corners; each of the four sides of a hole adds one, or two where
 * rounding has left the piece a shade less than convex. */
enum { HPR_CARVED_CORNERS = 8, HPR_CARVED_ROOM = HPR_CARVED_CORNERS + 10 };

typedef struct hpr_carved {
    int count;
    hpr_vec3 corner[HPR_CARVED_ROOM]; /* counter-clockwise about the normal of its plane */
} hpr_carved;

typedef struct hpr_carving {
    hpr_context *context;
    size_t count, capacity;
    hpr_carved *piece;
} hpr_carving;

void hpr_carving_release(hpr_carving *list);

/* Errors: HPR_ERR_MEMORY. */
hpr_status hpr_carving_add(hpr_carving *list, const hpr_carved *piece);

/*
 * Replaces every piece by convex pieces of piece minus hole; pieces that the hole does not reach stay as they
 * are. All lie in one plane with this normal (length 1); the hole is convex, of 3 or 4 corners, in either
 * direction. Corners within `slack` of a side of the hole count as on it, and what is nowhere wider is
 * dropped. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_carve(hpr_carving *list, hpr_vec3 normal, const hpr_vec3 *hole, int hole_count, double slack);

#endif
