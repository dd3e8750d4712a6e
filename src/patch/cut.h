/* Convex polygons in a plane, and what is left of one when others are cut out of it. */
#ifndef HPR_PATCH_CUT_H
#define HPR_PATCH_CUT_H

#include "base/context.h"
#include "math/vec3.h"

/* Pieces have at most HPR_PIECE_CORNERS corners; each of the four sides of a hole adds one, or two where
 * rounding has left the piece a shade less than convex. */
enum { HPR_PIECE_CORNERS = 8, HPR_PIECE_ROOM = HPR_PIECE_CORNERS + 10 };

typedef struct hpr_piece {
    int count;
    hpr_vec3 corner[HPR_PIECE_ROOM]; /* counter-clockwise about the normal of its plane */
} hpr_piece;

typedef struct hpr_piece_list {
    hpr_context *context;
    size_t count, capacity;
    hpr_piece *piece;
} hpr_piece_list;

void hpr_pieces_release(hpr_piece_list *list);

/* Errors: HPR_ERR_MEMORY. */
hpr_status hpr_pieces_add(hpr_piece_list *list, const hpr_piece *piece);

/*
 * Replaces every piece by convex pieces of piece minus hole; pieces that the hole does not reach stay as they
 * are. All lie in one plane with this normal (length 1); the hole is convex, of 3 or 4 corners, in either
 * direction. Corners within `slack` of a side of the hole count as on it, and what is nowhere wider is
 * dropped. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_pieces_cut(hpr_piece_list *list, hpr_vec3 normal, const hpr_vec3 *hole, int hole_count,
                          double slack);

#endif
