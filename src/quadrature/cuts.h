/* A polygon in the parameters of an element, cut along lines into convex pieces, and these into triangles. */
#ifndef HPR_QUADRATURE_CUTS_H
#define HPR_QUADRATURE_CUTS_H

#include "quadrature/pair.h"

enum { HPR_MAX_CUTS = 400 };

typedef struct hpr_cuts {
    int count;
    double least; /* area below which nothing is cut off: slivers of rounding */
    hpr_polygon piece[HPR_MAX_CUTS];
} hpr_cuts;

double hpr_polygon_area(const hpr_polygon *polygon);

/* The polygon as the only piece. */
void hpr_cuts_init(hpr_cuts *pieces, const hpr_polygon *polygon);

/* The part of a polygon where sign * f >= 0; its count is 0 if nothing is left. */
hpr_polygon hpr_polygon_half(const hpr_polygon *polygon, const hpr_affine *f, double sign);

/* Cuts every piece along the line f = 0; stops quietly at HPR_MAX_CUTS. */
void hpr_cuts_along(hpr_cuts *pieces, const hpr_affine *f);

/* Cuts the pieces through which the segment runs by more than `slack`, each all along its line; so the
 * segment lies on borders of pieces, and what is far from it stays in one piece. Stops quietly at
 * HPR_MAX_CUTS. */
void hpr_cuts_segment(hpr_cuts *pieces, const double from[2], const double to[2], double slack);

/* Joins pieces that share an edge and make a convex polygon together, until there are none; points within
 * `slack` are one. Returns how many are left. */
int hpr_cuts_merge(hpr_polygon *piece, int count, double slack);

/* Triangles from a piece's sides (edge 1) to its centroid; returns their number. cells: [HPR_POLYGON_MAX] */
int hpr_cuts_fan(const hpr_polygon *piece, hpr_cell *cells);

/* The same, but a parallelogram stays one cell. */
int hpr_cuts_tiles(const hpr_polygon *piece, hpr_cell *cells);

/* The same, but a polygon that is a whole parallelogram element stays one cell. */
int hpr_cuts_cells(hpr_shape shape, const hpr_polygon *piece, hpr_cell *cells);

#endif
