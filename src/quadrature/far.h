/*
 * Blocks between nodes that see each other wholly from afar, where the kernel is smooth: how well polynomials
 * carry it, foretold from the geometry and measured from the block.
 */
#ifndef HPR_QUADRATURE_FAR_H
#define HPR_QUADRATURE_FAR_H

#include "basis/basis.h"
#include "quadrature/pair.h"

#include <stdint.h>

/* Nodes, weights and basis values for degrees up to a largest; read-only once made. */
typedef struct hpr_far hpr_far;

/* Rules have up to so many nodes per axis, or more for the largest degree. */
enum { HPR_FAR_NODES = 8 };

/* Errors: HPR_ERR_MEMORY. */
hpr_status hpr_far_create(hpr_context *ctx, int max_degree, hpr_far **tables);
void hpr_far_destroy(hpr_far **tables);

/* The instruction set of the context that they were made with. */
hpr_isa hpr_far_isa(const hpr_far *tables);

/* A rule on a shape: parameters and weights (in parameter measure) of its points. Borrowed. */
typedef struct hpr_far_rule {
    size_t count;
    const double *s, *t, *weight; /* [count] */
} hpr_far_rule;

/* nodes per axis: 2 .. HPR_FAR_NODES */
hpr_far_rule hpr_far_nodes(const hpr_far *tables, hpr_shape shape, int nodes);

/*
 * How smooth the kernel is between two elements, from the geometry. Along a segment of one element the kernel
 * 1/r^4 is analytic inside the Bernstein ellipse of parameter rho = a + sqrt(a^2 - 1), a = (|y - P| + |y -
 * Q|) / |P - Q| for the segment's ends P, Q and the nearest point y of the other element, and its Legendre
 * coefficients fall like rho^-n (Trefethen 2013, thm. 8.1). So ‖G - P_r G‖, P_r the projection to the
 * receiver's polynomials of degree p, is about norm * recv_rho^-(p+1), and likewise for the sender. Observed
 * on random pairs: 0.3 to 3 times that in nine of ten.
 */
typedef struct hpr_far_view {
    double norm;                         /* of G in L2 over both, an upper estimate; INFINITY if they touch */
    double recv_rho, send_rho;           /* >= 1 */
    bool recv_straddles, send_straddles; /* the element crosses the other's plane: G has a kink on it */
    bool hidden;                         /* one is wholly behind the other's plane */
} hpr_far_view;

hpr_far_view hpr_far_foretell(const hpr_element_frame *recv, const hpr_element_frame *send);

/* What a degree leaves out along one side, twice the estimate. */
double hpr_far_left_out(double norm, double rho, int degree);

typedef struct hpr_far_result {
    double norm;                   /* ‖G‖ */
    double recv_error, send_error; /* ‖G - P_r G‖, ‖G - G P_s‖, not resolved below 1e-7 of the norm */
    uint64_t kernel_count;
} hpr_far_result;

/* Doubles that hpr_far_block needs as scratch, for any degree. */
size_t hpr_far_scratch(void);

/*
 * The block of hpr_block for such a pair by product Gauss with degree + 2 nodes per axis (of a
 * quadrilateral through the bilinear map), row-major [n_recv x n_send]. Its own error is about what degrees
 * higher by HPR_FAR_EXCESS leave out. Concurrent calls allowed with distinct block and scratch.
 */
enum { HPR_FAR_EXCESS = 3 };

hpr_far_result hpr_far_block(const hpr_far *tables, const hpr_element_frame *recv,
                             const hpr_element_frame *send, double *block, double *scratch);

#endif
