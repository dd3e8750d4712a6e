/* Which blockers may come between a piece of one element and a polygon of the other. */
#ifndef HPR_QUADRATURE_BETWEEN_H
#define HPR_QUADRATURE_BETWEEN_H

#include "quadrature/pair.h"

typedef struct hpr_between {
    uint32_t index[HPR_CLIP_BLOCKERS];
} hpr_between;

/*
 * The pair with those of its blockers that no plane parts from the piece and the polygon; their numbers are
 * kept in `memory`. Planes through an edge of one and a corner of the other are tried, and the blockers' own.
 * Conservative. Thread-safe with distinct memory.
 */
hpr_pair hpr_between_choose(const hpr_pair *pair, const hpr_vec3 *piece, int piece_count,
                            const hpr_convex *polygon, hpr_between *memory);

#endif
