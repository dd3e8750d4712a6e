/*
 * Two planes that face each other closely: but for strips along the projections of the inner polygon's edges,
 * as wide as the planes are apart, an outer point sees nothing but the inner polygon, or nothing of it.
 */
#ifndef HPR_QUADRATURE_STRIPS_H
#define HPR_QUADRATURE_STRIPS_H

#include "quadrature/pair.h"

typedef struct hpr_strips {
    int count;
    hpr_affine height;                  /* of outer points over the inner plane */
    hpr_affine inside[HPR_POLYGON_MAX]; /* distance from edge i's projection, towards the inner polygon */
} hpr_strips;

/* Whether the planes are parallel enough. */
bool hpr_strips_apply(const hpr_pair *pair);

/* outline [count]: the inner polygon. */
void hpr_strips_init(hpr_strips *strips, const hpr_element_frame *outer, const hpr_affine *height,
                     const hpr_vec3 *outline, int count);

/* A bound on how far what the points of a piece of the outer polygon see of the inner one is from all or
 * nothing, on average: of the edges together inside, of any that is between outside; 1 if an edge's
 * projection crosses the piece. */
double hpr_strips_left(const hpr_strips *strips, const double corner[4][2]);

#endif
