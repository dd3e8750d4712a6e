/*
 * The fraction of a diffuse sender polygon's exitance that arrives at a point, in closed form: the irradiance
 * at the point per unit radiosity of the polygon, F(x) = 1/(2 pi) sum_e angle_e (n . unit(a_e x b_e)), over
 * the edges a_e -> b_e of the polygon as seen from x, cut at the receiver's horizon. Source: Lambert 1760;
 * Baum, Rushmeier & Winget 1989, eq. 8.
 */
#ifndef HPR_DIRECT_LAMBERT_H
#define HPR_DIRECT_LAMBERT_H

#include "math/vec3.h"

#include <stddef.h>

/*
 * F >= 0 for a polygon seen from either side. corner: [count][3], count <= 24, planar and convex. normal has
 * length 1. A point in the polygon's plane gets 0. Never allocates; thread-safe.
 */
double hpr_lambert_fraction(const double point[3], const double normal[3], const double (*corner)[3],
                            size_t count);

/* The same with what it lost. */
typedef struct hpr_lambert {
    double fraction;
    double cancellation; /* sum of the edges' terms without regard to sign, over the sum: >= 1 */
    double rounding;     /* relative error over the unit roundoff, to be expected; >= cancellation */
} hpr_lambert;

/* For a polygon wholly above the horizon, corners relative to the point; count >= 3. */
hpr_lambert hpr_lambert_above(hpr_vec3 normal, const hpr_vec3 *corner, size_t count);

/*
 * The same for a point not far from the polygon's plane, `height` > 0 in front of it (its normal `plane`, of
 * length 1). Beside the polygon the edges' terms cancel there but for squares of the height. But seen from
 * the point's foot in the plane the edges' angles, with the signs of their sides, sum up to a full turn or to
 * none; only what the terms differ from these is summed, and formed without cancellation.
 */
hpr_lambert hpr_lambert_beside(hpr_vec3 normal, hpr_vec3 plane, double height, const hpr_vec3 *corner,
                               size_t count);

#endif
