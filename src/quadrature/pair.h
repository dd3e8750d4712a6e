/* Two elements whose kernel block is wanted, and the pieces of them that one rule integrates over. */
#ifndef HPR_QUADRATURE_PAIR_H
#define HPR_QUADRATURE_PAIR_H

#include "direct/visible.h"
#include "math/vec3.h"
#include "patch/elements.h"

/* One element: x(s,t) = origin + s edge1 + t edge2, front where normal = edge1 x edge2 / |.| points. */
typedef struct hpr_element_frame {
    hpr_shape shape;
    int degree;
    hpr_vec3 origin, edge1, edge2, normal;
    double area_m2;
    /* Of a quadrilateral: patch/shape.h; and its basis, math/planar_basis.h, borrowed, NULL will do for
     * degree 0. */
    double opposite[2];
    const double *recurrence;
} hpr_element_frame;

/* Area of the parameter domain, and |edge1 x edge2|: from it to the area in space. */
double hpr_frame_measure(const hpr_element_frame *frame);
double hpr_frame_jacobian(const hpr_element_frame *frame);

/* The longer of the two edges, and its square over the area: how much more exactly it is known than the
 * plane. */
double hpr_frame_longest(const hpr_element_frame *frame);
double hpr_frame_slenderness(const hpr_element_frame *frame);

/* hpr_basis_eval, hpr_basis_many and hpr_basis_scale for any shape. Thread-safe. */
void hpr_frame_basis(const hpr_element_frame *frame, double s, double t, double *values);
void hpr_frame_basis_many(hpr_isa isa, const hpr_element_frame *frame, size_t count, const double *s,
                          const double *t, size_t stride, double *values, double *scratch);
double hpr_frame_scale(const hpr_element_frame *frame);

/* The frame of a node, and that of a leaf. */
hpr_element_frame hpr_node_frame(const hpr_patches *patches, const hpr_elements *elements, size_t node);
hpr_element_frame hpr_leaf_frame(const hpr_patches *patches, const hpr_elements *elements, size_t leaf);

/* A piece of an element in its parameters: (s,t) = origin + a edge1 + b edge2, (a,b) in the unit square or
 * the unit triangle. A quadrilateral is only ever a whole element, which rules take in triangles. */
typedef struct hpr_cell {
    hpr_shape shape;
    double origin[2], edge1[2], edge2[2];
    double opposite[2]; /* of a quadrilateral */
} hpr_cell;

/* A convex piece of an element in its parameters, counter-clockwise or not. */
enum { HPR_POLYGON_MAX = 12 };

typedef struct hpr_polygon {
    int count;
    double corner[HPR_POLYGON_MAX][2];
} hpr_polygon;

/* Affine function of the parameters: value(s,t) = at_origin + s along1 + t along2. */
typedef struct hpr_affine {
    double at_origin, along1, along2;
} hpr_affine;

/* At most so many blockers are clipped out. */
enum { HPR_CLIP_BLOCKERS = 64 };

/* receiver r and sender s, moved so that the receiver's origin is 0. */
typedef struct hpr_pair {
    hpr_element_frame recv, send;
    hpr_affine recv_height; /* of receiver points over the sender's plane, metres */
    hpr_affine send_height; /* of sender points over the receiver's plane */
    /* Polygons that come between and are to be clipped out exactly; none: wholly visible. Borrowed, moved
     * like the pair. */
    const hpr_convex *blocker;
    const uint32_t *chosen; /* which of them, blocker_count; NULL: all */
    int blocker_count;
    /* Convex parts of the elements that are integrated over instead of all of them; 0: all. Borrowed. */
    const hpr_polygon *recv_part, *send_part;
    int recv_part_count, send_part_count;
} hpr_pair;

void hpr_pair_init(hpr_pair *pair, const hpr_element_frame *recv, const hpr_element_frame *send);

static inline double hpr_affine_at(const hpr_affine *f, double s, double t)
{
    return f->at_origin + s * f->along1 + t * f->along2;
}

static inline hpr_vec3 hpr_frame_point(const hpr_element_frame *frame, double s, double t)
{
    return hpr_madd(hpr_madd(frame->origin, s, frame->edge1), t, frame->edge2);
}

/* A parameter vector as a vector in space. */
static inline hpr_vec3 hpr_frame_vector(const hpr_element_frame *frame, const double d[2])
{
    return hpr_madd(hpr_scale(frame->edge1, d[0]), d[1], frame->edge2);
}

/* The part of what leaves the inner polygon per unit radiosity that arrives at a point of the outer element,
 * past the pair's blockers; false in *complete if there were too many of them. */
double hpr_inner_fraction(const hpr_pair *pair, const hpr_element_frame *outer,
                          const hpr_element_frame *inner, const hpr_convex *polygon, hpr_vec3 point,
                          bool *complete);

/* The element in another unit of length, `scale` of them to one of its own: exact for a power of two. */
hpr_element_frame hpr_frame_rescaled(const hpr_element_frame *frame, double scale);

/* The whole element as a cell, and as a polygon. */
hpr_cell hpr_cell_whole(const hpr_element_frame *frame);
hpr_polygon hpr_frame_outline(const hpr_element_frame *frame);
/* The largest and the least value of a function on the element. */
double hpr_frame_largest(const hpr_element_frame *frame, const hpr_affine *f);
double hpr_frame_least(const hpr_element_frame *frame, const hpr_affine *f);
hpr_cell hpr_cell_triangle(const double p0[2], const double p1[2], const double p2[2]);

/* The part of the line from + u (to - from), in parameters, that lies in the element: [chord[0], chord[1]],
 * made to hold [0, 1]. */
void hpr_frame_chord(const hpr_element_frame *frame, const double from[2], const double to[2],
                     double chord[2]);

/* Corners of a cell in space, 3 or 4; returns their number. */
int hpr_cell_corners(const hpr_element_frame *frame, const hpr_cell *cell, hpr_vec3 corner[4]);

/* Smallest distance of the outlines of two polygons. */
double hpr_outline_distance(const hpr_vec3 *a, int a_count, const hpr_vec3 *b, int b_count);

/* Smallest distance of two planar convex polygons that do not pierce each other. Source: Ericson 2005, 5.1.
 */
double hpr_polygon_distance(const hpr_vec3 *a, int a_count, const hpr_vec3 *b, int b_count);

#endif
