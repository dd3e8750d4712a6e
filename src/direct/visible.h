/*
 * The part of a sender polygon that a point sees past polygonal blockers, exactly: each blocker's shadow on
 * the sender is the sender's intersection with the pyramid of planes through the point and the blocker's
 * edges, and is cut out; what is left is a set of convex polygons.
 */
#ifndef HPR_DIRECT_VISIBLE_H
#define HPR_DIRECT_VISIBLE_H

#include "math/convex.h"

#include <stdbool.h>
#include <stdint.h>

enum { HPR_VISIBLE_CORNERS = HPR_CONVEX_CORNERS, HPR_VISIBLE_PIECES = 64 };

typedef struct hpr_visible {
    int count;
    bool whole;                 /* nothing was cut out */
    struct hpr_visible *hidden; /* gets what is cut out, all at once or in pieces; NULL: nobody asks */
    hpr_convex piece[HPR_VISIBLE_PIECES];
} hpr_visible;

/*
 * Visible pieces of `sender` (convex, planar, its front toward the point or not) as seen from `point`;
 * corners are given relative to the point. normal: the sender's, length 1. A blocker counts where it is
 * between the point and the sender's plane. False if there were too many pieces; then the rest of the
 * blockers is left out. Blockers that touch the point's line of sight only at their outline change nothing.
 * visible->hidden is the caller's. Never allocates; thread-safe.
 */
bool hpr_visible_part(hpr_vec3 point, const hpr_convex *sender, hpr_vec3 normal, const hpr_convex *outline,
                      const uint32_t *blocker, int blocker_count, hpr_visible *visible);

/*
 * A plane through the point (the origin): normal . x >= 0 is inside. Heights within rounding |x| are rounding
 * and count as none, so that two blockers that share an edge leave no crack and cut off no sliver.
 */
typedef struct hpr_side {
    hpr_vec3 normal;
    double rounding;
} hpr_side;

/*
 * The planes through the point and the edges of a blocker, given relative to it, all pointing inward: what is
 * inside all of them is behind the blocker. sides: room for blocker->count. Returns their number, 0 if the
 * blocker is seen edge-on. Thread-safe.
 */
int hpr_visible_pyramid(const hpr_convex *blocker, hpr_side *sides);

/* Takes a pyramid out of every piece. False if there would be too many pieces; some are then left whole.
 * Thread-safe. */
bool hpr_visible_subtract(hpr_visible *visible, const hpr_side *sides, int side_count);

/* sum over the visible pieces of hpr_lambert_fraction at the point with the given receiver normal. */
double hpr_visible_fraction(hpr_vec3 receiver_normal, const hpr_visible *visible);

#endif
