/*
 * The inner integral of a nested rule: points of a planar convex polygon, or of a segment, as they are seen
 * from a point x, in polar coordinates around the nearest of them. A convex polygon is the union of the
 * triangles from that point y0 to its edges, so that nothing cancels, and in any direction the distance
 *   r^2 = r0^2 + 2 c rho + rho^2,  0 <= c <= r0,  rho the distance from y0,
 * only grows. With rho = r0 sinh(tau), and p = d sinh(sigma) along an edge at the distance d from y0, the
 * kernel is analytic for |Im tau|, |Im sigma| < pi/2, however small r0 and d are. Source: sinh transformation
 * of Johnston & Elliott 2005, around the nearest point instead of the foot.
 */
#ifndef HPR_QUADRATURE_POLAR_H
#define HPR_QUADRATURE_POLAR_H

#include "quadrature/rule.h"

typedef struct hpr_polar {
    const hpr_gauss_table *gauss;
    int count;                        /* corners; 2: a segment */
    hpr_vec3 corner[HPR_POLYGON_MAX]; /* relative to the origin, counter-clockwise or not */
    hpr_vec3 normal;                  /* of the plane, length 1 */
    double origin[2];                 /* parameters of the origin */
    hpr_vec3 dual1, dual2;            /* parameters per length */
    /* Heights over the outer plane: of the parameters from the origin on, if that is a common point of the
     * planes (exact beside it); else of positions, which errs as if the outer point had moved. */
    bool joined;
    hpr_affine height;
    hpr_vec3 outer_normal;
    double jacobian; /* area (segment: length) per weight */
    double tolerance;
    int degree; /* total, of the polynomials */
    hpr_points *points;
    hpr_group *group;
    hpr_group_sink sink;
    void *user;
} hpr_polar;

/* A segment of a line at `distance` from a point, from `begin` to `end` on from the point's foot; degree of
 * the polynomials. */
typedef struct hpr_line {
    const hpr_gauss_table *gauss;
    hpr_isa isa;
    double distance, begin, end, tolerance;
    int degree;
} hpr_line;

typedef void (*hpr_line_sink)(void *user, int count, const double *place, const double *weight);

/* Places (from the foot) and weights on a segment, at most HPR_NODES_MAX at a time, for 1 / (distance^2 +
 * place^2)^2 and the like. distance > 0. */
void hpr_polar_line(const hpr_line *line, hpr_line_sink sink, void *user);

/* The relative error that an integral over the inner set is expected to have. Observed: 99 of 100 points err
 * by less, on average over the points of a rule by far less. */
double hpr_polar_error(const hpr_polygon *inner, double tolerance);

/* Height of x over the plane, by way of the nearest point of the outline: the plane of a slender polygon is
 * known well only there. */
double hpr_polar_height(const hpr_polar *polar, hpr_vec3 x);

/* The integral of height / r^4 over a segment, of constants, in closed form; false if its terms cancel by
 * more than the factor `rounding`. */
bool hpr_polar_closed(const hpr_polar *polar, hpr_vec3 x, double rounding, double *integral);

/* Hands over groups whose inner points are all points seen from x (relative to the origin, at height z > 0
 * over the polygon's plane), their positions relative to x; the other side of the group must be filled. */
void hpr_polar_points(const hpr_polar *polar, hpr_vec3 x, double z);

#endif
