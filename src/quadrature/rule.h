/*
 * Quadrature rules for one pair: the choice of rules (rules.c) is one thing, the points that a rule makes
 * (points_*.c) another, their evaluation (block_ref.c) a third. Between choice and evaluation stands
 * hpr_rule; between points and evaluation stands hpr_group.
 */
#ifndef HPR_QUADRATURE_RULE_H
#define HPR_QUADRATURE_RULE_H

#include "math/gauss.h"
#include "quadrature/correlation.h"
#include "quadrature/pair.h"
#include "quadrature/partial.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum hpr_rule_kind {
    HPR_RULE_PRODUCT,  /* separate cells: product Gauss */
    HPR_RULE_VERTEX,   /* triangles sharing vertex 0 */
    HPR_RULE_EDGE,     /* triangles sharing the edge from vertex 0 to vertex 1 */
    HPR_RULE_NESTED,   /* one side point by point, the other integrated in polar coordinates seen from it */
    HPR_RULE_CLIPPED,  /* one side point by point, the other over what the point sees of it */
    HPR_RULE_PARALLEL, /* parallel planes and edges: over the difference of the points (parallel.h) */
    HPR_RULE_ALIGNED   /* one direction of the edges in common: over the difference along it (aligned.h) */
} hpr_rule_kind;

/* A box in the coordinates of a rule: [low, low + width] along each axis. */
typedef struct hpr_box {
    double low[3], width[3];
} hpr_box;

/*
 * An outer integral over a point, a segment or a quadrilateral of one side, of an inner integral over a
 * polygon or a segment of the other.
 */
typedef struct hpr_nested {
    bool recv_is_outer;
    int dimension;      /* of the outer set: 0, 1, 2 */
    double outer[4][2]; /* its corners in parameters; of a quadrilateral at (u, v) = 00, 10, 11, 01 */
    int nodes[2];       /* along u and v */
    hpr_polygon inner;  /* 2 corners: a segment */
    double weight;    /* of all points; the measure is that of u, v and the inner parameters or 0 <= t <= 1 */
    double tolerance; /* of the inner integral */
    /* Parameters of the point from which both sides' positions are measured, if it is one (joined); then it
     * lies in both planes. */
    bool joined;
    double outer_origin[2], inner_origin[2];
    int homothety; /* what becomes of the sum: 0 nothing, 1 the first, 2 the second, then the first */
} hpr_nested;

/* Of a pair in parallel planes with parallel edges (parallel.h). */
typedef struct hpr_parallel {
    double height;        /* of one plane over the other */
    hpr_overlap along[2]; /* edge1 and edge2 of the receiver */
    bool swapped;         /* the sender's edge1 runs along the receiver's edge2 */
} hpr_parallel;

/* Of a pair with a direction of edges in common (aligned.h); lengths in units of the receiver's edge along
 * it. */
typedef struct hpr_aligned {
    int recv_edge, send_edge;                  /* 0: edge1 runs along it, 1: edge2 */
    double unit;                               /* that length */
    hpr_overlap along;                         /* of the two where v = w = 0; it moves */
    double recv_slant, send_slant;             /* by so much back per v, on per w */
    hpr_vec3 offset, recv_across, send_across; /* across: from x to y where v = w = 0, per v, per w */
    double recv_range[2], send_range[2];       /* of v and w, in front of the other's plane */
} hpr_aligned;

typedef struct hpr_rule {
    hpr_rule_kind kind;
    double error; /* estimated, relative to what the rule contributes */
    hpr_cell recv, send;
    int recv_nodes[2], send_nodes[2]; /* product; clipped (its outer side): nodes along each axis */
    /* vertex, edge: one term of their sums */
    int term;
    int kernel_nodes; /* along the axes on which the kernel varies */
    int scale_nodes;  /* along the others, on which only the polynomials vary */
    hpr_nested nested;
    /* clipped */
    hpr_box box; /* hpr_outer_at's u, v */
    bool recv_is_outer;
    hpr_polygon inner; /* the other side's part, in its parameters */
    int inner_degree;  /* total degree of the inner polynomials; 0: the closed form is used */
    double tolerance;  /* of the inner integral; parallel, aligned: of the whole */
    hpr_parallel parallel;
    hpr_aligned aligned;
} hpr_rule;

/* Terms of the vertex and the edge rule. */
enum { HPR_VERTEX_TERMS = 2, HPR_EDGE_TERMS = 5 };

/* Largest number of points on one side of a group. */
enum { HPR_NODES_MAX = HPR_GAUSS_MAX, HPR_POINTS_MAX = HPR_NODES_MAX * HPR_NODES_MAX };

/* Points of one side: parameters in the element, position relative to an origin that both sides share, weight
 * (in parameter measure) times height over the other's plane. */
typedef struct hpr_points {
    int count;
    double s[HPR_POINTS_MAX], t[HPR_POINTS_MAX];
    double x[HPR_POINTS_MAX], y[HPR_POINTS_MAX], z[HPR_POINTS_MAX];
    double weight[HPR_POINTS_MAX];
} hpr_points;

/*
 * A set of receiver points times a set of sender points. It contributes
 *   scale * sum_ab w_a w_b / (pi |y_b - x_a|^4) phi_k(a) phi_l(b),
 * the heights in the weights being the numerator of G times r^2.
 */
typedef struct hpr_group {
    hpr_points recv, send;
    double scale;
} hpr_group;

typedef void (*hpr_group_sink)(void *user, const hpr_group *group);

/* Makes the groups of a rule, one after the other, in `group` (scratch), and hands each to `sink`. */
void hpr_points_product(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                        hpr_group *group, hpr_group_sink sink, void *user);
void hpr_points_vertex(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                       hpr_group *group, hpr_group_sink sink, void *user);
void hpr_points_edge(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                     hpr_group *group, hpr_group_sink sink, void *user);
void hpr_points_nested(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                       hpr_group *group, hpr_group_sink sink, void *user);
void hpr_points_clipped(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                        hpr_group *group, hpr_group_sink sink, void *user);
/* Whichever of them the rule's kind asks for. */
void hpr_rule_points(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                     hpr_group *group, hpr_group_sink sink, void *user);

/* A point of an outer integral. */
typedef struct hpr_outer_point {
    double s, t;
    double weight; /* in parameter measure */
    hpr_vec3 position;
} hpr_outer_point;

/*
 * Point `index` of nodes x nodes Gauss points in a box of the cell's coordinates u, v: a = u, b = v, or for a
 * triangle collapsed, a = u (1 - v), b = v.
 */
hpr_outer_point hpr_outer_at(const hpr_gauss_table *gauss, const hpr_element_frame *outer,
                             const hpr_cell *cell, const hpr_box *box, int nodes, int index);

/*
 * Nodes that resolve 1/r^4 along a segment of this length with all else at least `distance` away. Along it
 * r^2 is a quadratic with complex roots at least distance/length (in units of the segment) from [0,1], so
 * that the kernel is analytic inside the Bernstein ellipse of parameter rho = b + sqrt(b^2 + 1), b = 2
 * distance/length, and n-point Gauss errs like rho^(-2n) (Trefethen 2013, thm. 19.3). The factor 64 is for
 * the kernel's growth near the ellipse, observed.
 */
int hpr_kernel_nodes(double length, double distance, double tolerance);
double hpr_kernel_error(double length, double distance, int nodes);

/* sum of a group with phi = 1: its part of sqrt(A_r A_s) K^00 over the parameter measures. */
double hpr_group_sum(const hpr_group *group);

static inline hpr_box hpr_box_unit(void)
{
    return (hpr_box){{0, 0, 0}, {1, 1, 1}};
}

/* The two halves along an axis. */
static inline void hpr_box_halve(const hpr_box *box, int axis, hpr_box half[2])
{
    half[0] = *box;
    half[0].width[axis] /= 2;
    half[1] = half[0];
    half[1].low[axis] += half[1].width[axis];
}

/* What the choice depends on besides the geometry. */
typedef struct hpr_rule_demand {
    double tolerance;  /* relative to the block's largest entry */
    double negligible; /* an absolute error of the (dimensionless) block that does not matter either */
    double contact_m;  /* points nearer than this count as touching */
    int least_nodes;   /* product: at least so many nodes per axis; above 1 visibility is sampled */
} hpr_rule_demand;

/* Centres of homotheties (homothety.h), in the parameters of both. */
typedef struct hpr_centre {
    double recv[2], send[2];
} hpr_centre;

typedef struct hpr_rule_outcome {
    bool seen;           /* false: neither faces the other, the block is zero */
    bool stopped_short;  /* the effort was at its limit */
    double error;        /* estimated, absolute, of the dimensionless block; beside the rules' own */
    double rounding;     /* relative to what the rules contribute; */
    double flat, swept;  /* and the lesser of this, relative, and that, absolute */
    uint64_t clip_count; /* points for which the choice clipped the other side */
    double exchange_m2;  /* ∫_r ∫_s G V dA dA, as far as no rules were emitted for it: of constants */
    int centre_count;    /* homotheties that the sums still have to go through */
    hpr_centre centre[2];
} hpr_rule_outcome;

typedef void (*hpr_rule_sink)(void *user, const hpr_rule *rule);

/*
 * Rules for one pair of polygons that face each other wholly and do not touch: the outer polygon is cut along
 * the projections of the inner one's edges and divided until Gauss resolves the inner integral to `tolerance`
 * of the whole. Returns false if it stopped short.
 */
bool hpr_nested_choose(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                       const hpr_polygon *send, double tolerance, hpr_rule_sink sink, void *user);

typedef struct hpr_clipped_demand {
    double tolerance;  /* relative to the block's largest entry */
    double negligible; /* an absolute error of the dimensionless block that does not matter either */
} hpr_clipped_demand;

typedef struct hpr_clipped_outcome {
    bool complete;       /* false: it stopped short */
    double error;        /* estimated, absolute, of the dimensionless block */
    uint64_t clip_count; /* points that were clipped for */
} hpr_clipped_outcome;

/*
 * Rules for one pair of polygons past the pair's blockers: the outer polygon is cut along the event lines,
 * unless the tolerance is loose, and halved in boxes until the inner integral over the visible part is
 * resolved to the demand.
 */
hpr_clipped_outcome hpr_clipped_choose(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                       const hpr_polygon *recv, const hpr_polygon *send,
                                       const hpr_clipped_demand *demand, hpr_rule_sink sink, void *user);

/*
 * Nodes that are added for polynomials of a degree: half of it, so that they are integrated like the kernel;
 * a quarter where the tolerance is loose, for there the moments against high degrees are small beside it.
 */
int hpr_polynomial_nodes(int degree, double tolerance);

/* Total degree of an element's polynomials in its parameters. */
int hpr_total_degree(const hpr_element_frame *frame);

/* Working memory of a choice, not in use by its sink. */
typedef struct hpr_rule_scratch {
    hpr_group group;
    hpr_partial_cell cell[HPR_PARTIAL_CELLS];
} hpr_rule_scratch;

/* Chooses the rules of a pair and hands each to `sink`. Thread-safe with distinct scratch. */
hpr_rule_outcome hpr_rules_choose(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                  const hpr_rule_demand *demand, hpr_rule_scratch *scratch,
                                  hpr_rule_sink sink, void *user);

#endif
