/*
 * What the parameters (s,t) of a patch or an element range over, the domain of its shape:
 *   parallelogram   0 <= s, t <= 1
 *   triangle        0 <= s, t and s + t <= 1
 *   quadrilateral   convex, with the corners (0,0), (1,0), (a,b), (0,1); a, b > 0, a + b > 1
 * (a,b), the corner `opposite` to the origin, is looked at for quadrilaterals only.
 */
#ifndef HPR_PATCH_SHAPE_H
#define HPR_PATCH_SHAPE_H

#include <stdbool.h>
#include <stddef.h>

typedef enum hpr_shape {
    HPR_SHAPE_PARALLELOGRAM = 0,
    HPR_SHAPE_TRIANGLE = 1,
    HPR_SHAPE_QUADRILATERAL = 2
} hpr_shape;

/* Corners of the domain, counter-clockwise from the origin. Returns their number. */
size_t hpr_shape_corners(hpr_shape shape, const double opposite[2], double corner[4][2]);

/* Its area: 1, 1/2 or (a + b)/2. */
double hpr_shape_measure(hpr_shape shape, const double opposite[2]);

/* A point well inside: its centre, of a quadrilateral the mean of the corners. */
void hpr_shape_middle(hpr_shape shape, const double opposite[2], double middle[2]);

/* Is the point inside, not on the rim? */
bool hpr_shape_holds(hpr_shape shape, const double opposite[2], double s, double t);

/* The point of the domain for (u,v) in the unit square, uniform if (u,v) is. */
void hpr_shape_uniform(hpr_shape shape, const double opposite[2], double u, double v, double point[2]);

/* A piece of a quadrilateral: (s,t) = origin + x edge1 + y edge2 with (x,y) in the domain that `opposite`
 * gives. */
typedef struct hpr_quad_piece {
    double origin[2], edge1[2], edge2[2], opposite[2];
} hpr_quad_piece;

/* The quadrilateral that the bilinear map (s,t) = (u,v) + u v (a - 1, b - 1) makes of the box [low, low +
 * width] of (u,v); *measure: its area in (s,t). */
hpr_quad_piece hpr_quad_box(const double opposite[2], const double low[2], const double width[2],
                            double *measure);

/* Child `which` of a quadrilateral that the line between the middles of two sides cuts: those that s runs
 * along (axis 0), or the other two. */
hpr_quad_piece hpr_quad_half(const double opposite[2], int axis, int which);

/* A quadrilateral moved inside, if it is not, toward its middle. */
void hpr_quad_bring_inside(const double opposite[2], double *s, double *t);

#endif
