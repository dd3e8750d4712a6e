/*
 * The rule for pairs that nearly touch, or touch at small angles or in slender shapes: an outer integral over
 * one polygon of the exact inner integral over the other. The inner integral is a smooth function of the
 * outer point but near the inner polygon's edges, where it varies on the scale of the distance to them. So
 * the outer polygon is cut along the projections of these edges, each piece falls into triangles with a side
 * of the piece as base, and boxes of the triangles' collapsed coordinates are halved along the axis that
 * needs it: a box's sides are parallel to the edge, and the number of boxes grows like the logarithm of the
 * distance. Source: the idea of regularised outer and exact inner integrals as in Schroder & Hanrahan 1993,
 * sec. 5, and Walton 2002 (View3D), with polynomials.
 */
#include "quadrature/cuts.h"
#include "quadrature/rule.h"

#include <string.h>

enum { NODES = 8, MAX_DEPTH = 60, MAX_BOXES = 20000 };

typedef struct nested {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_element_frame *outer, *inner;
    hpr_affine outer_height; /* of outer points over the inner plane */
    hpr_convex outline;      /* the inner polygon in space */
    hpr_rule rule;           /* all but the box */
    double allowed;          /* absolute error of a box */
    int box_count;
    bool reached;
    hpr_rule_sink sink;
    void *user;
} nested;

/* Parameters in the outer frame of the foot of a point on the outer plane. */
static void project(const hpr_element_frame *outer, hpr_vec3 point, double foot[2])
{
    hpr_vec3 offset = hpr_sub(point, outer->origin), across = hpr_cross(outer->edge1, outer->edge2);
    double square = hpr_dot(across, across);
    foot[0] = hpr_dot(hpr_cross(offset, outer->edge2), across) / square;
    foot[1] = hpr_dot(hpr_cross(outer->edge1, offset), across) / square;
}

/* Along the inner polygon's projected edges. */
static void cut_by_edges(const nested *n, hpr_cuts *p)
{
    static const double point_size = 1e-14;
    int count = n->outline.count;
    for (int i = 0; i < count; i++) {
        double a[2], b[2];
        project(n->outer, n->outline.corner[i], a);
        project(n->outer, n->outline.corner[(i + 1) % count], b);
        const double d[2] = {b[0] - a[0], b[1] - a[1]};
        if (fabs(d[0]) + fabs(d[1]) <= point_size)
            continue; /* an edge at a right angle to the plane */
        hpr_affine f = {d[1] * a[0] - d[0] * a[1], -d[1], d[0]};
        hpr_cuts_along(p, &f);
    }
}

/* Integral of the inner polygon's Lambert fraction over a box, in the outer parameters' measure. */
static double box_integral(nested *n, const hpr_cell *cell, const hpr_box *box)
{
    const hpr_gauss_rule *gauss = &n->gauss->legendre[NODES];
    double jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]) *
                      box->width[0] * box->width[1];
    double sum = 0;
    n->box_count++;
    for (int j = 0; j < NODES; j++) {
        double v = box->low[1] + box->width[1] * gauss->node[j];
        for (int i = 0; i < NODES; i++) {
            double a = (box->low[0] + box->width[0] * gauss->node[i]) * (1 - v);
            double s = cell->origin[0] + a * cell->edge1[0] + v * cell->edge2[0];
            double t = cell->origin[1] + a * cell->edge1[1] + v * cell->edge2[1];
            double fraction = hpr_inner_fraction(n->pair, n->outer, n->inner, &n->outline,
                                                 hpr_frame_point(n->outer, s, t), &n->reached);
            sum += gauss->weight[i] * gauss->weight[j] * (1 - v) * fraction;
        }
    }
    return jacobian * sum;
}

static void emit_box(nested *n, const hpr_cell *cell, const hpr_box *box)
{
    *(n->rule.recv_is_outer ? &n->rule.recv : &n->rule.send) = *cell;
    n->rule.box = *box;
    n->sink(n->user, &n->rule);
}

static hpr_vec3 box_corner(const nested *n, const hpr_cell *cell, double u, double v)
{
    double a = u * (1 - v);
    return hpr_frame_point(n->outer, cell->origin[0] + a * cell->edge1[0] + v * cell->edge2[0],
                           cell->origin[1] + a * cell->edge1[1] + v * cell->edge2[1]);
}

/* Length of a across the direction of b. */
static double length_across(hpr_vec3 a, hpr_vec3 b)
{
    return hpr_length(hpr_cross(a, b)) / hpr_length(b);
}

/*
 * The axis along which a box reaches, across some edge of the inner polygon, far more than its distance from
 * that edge; or -1. Such a box can hide the edge's influence between its nodes, whatever its halves say;
 * boxes too small to matter may. An edge that the box touches hides nothing: there is no smallest scale, all
 * boxes at it look alike.
 */
static int hiding_axis(const nested *n, const hpr_cell *cell, const hpr_box *box)
{
    static const double ratio = 8, touching = 1e-10;
    double u0 = box->low[0], u1 = u0 + box->width[0], v0 = box->low[1], v1 = v0 + box->width[1];
    hpr_vec3 corner[4] = {box_corner(n, cell, u0, v0), box_corner(n, cell, u1, v0),
                          box_corner(n, cell, u1, v1), box_corner(n, cell, u0, v1)};
    double jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]);
    if (jacobian * box->width[0] * box->width[1] <= n->allowed)
        return -1;
    hpr_vec3 along_u = hpr_sub(corner[1], corner[0]);
    hpr_vec3 along_v[2] = {hpr_sub(corner[3], corner[0]), hpr_sub(corner[2], corner[1])};
    double worst = ratio;
    int axis = -1, count = n->rule.inner.count;
    for (int i = 0; i < count; i++) {
        hpr_vec3 edge[2] = {n->outline.corner[i], n->outline.corner[(i + 1) % count]},
                 direction = hpr_sub(edge[1], edge[0]);
        double distance = hpr_outline_distance(corner, 4, edge, 2);
        double u = length_across(along_u, direction);
        double v = fmax(length_across(along_v[0], direction), length_across(along_v[1], direction));
        if (distance > touching * fmax(u, v) && fmax(u, v) > worst * distance) {
            worst = fmax(u, v) / distance;
            axis = v > u;
        }
    }
    return axis;
}

static void refine(nested *n, const hpr_cell *cell, const hpr_box *box, double whole, int depth)
{
    hpr_box half[2][2];
    double part[2][2], error[2];
    for (int axis = 0; axis < 2; axis++) {
        hpr_box_halve(box, axis, half[axis]);
        for (int which = 0; which < 2; which++)
            part[axis][which] = box_integral(n, cell, &half[axis][which]);
        error[axis] = fabs(whole - part[axis][0] - part[axis][1]);
    }
    int axis = error[1] > error[0];
    if (fmax(error[0], error[1]) <= n->allowed) {
        axis = hiding_axis(n, cell, box);
        if (axis < 0) {
            emit_box(n, cell, box);
            return;
        }
    }
    if (depth >= MAX_DEPTH || n->box_count > MAX_BOXES) {
        n->reached = false;
        emit_box(n, cell, box);
        return;
    }
    for (int which = 0; which < 2; which++)
        refine(n, cell, &half[axis][which], part[axis][which], depth + 1);
}

static double frame_area(const hpr_element_frame *frame, const hpr_polygon *polygon)
{
    return hpr_polygon_area(polygon) * (frame->shape == HPR_SHAPE_PARALLELOGRAM ? 1 : 2) * frame->area_m2;
}

static void set_nodes(nested *n, bool recv_is_outer, const hpr_polygon *inner, double tolerance)
{
    int nodes = NODES + (hpr_total_degree(n->outer) + 1) / 2;
    n->rule = (hpr_rule){.kind = HPR_RULE_NESTED,
                         .recv_is_outer = recv_is_outer,
                         .inner = *inner,
                         .inner_degree = hpr_total_degree(n->inner),
                         .tolerance = tolerance};
    nodes = nodes < HPR_NODES_MAX ? nodes : HPR_NODES_MAX;
    int *outer_nodes = recv_is_outer ? n->rule.recv_nodes : n->rule.send_nodes;
    outer_nodes[0] = outer_nodes[1] = nodes;
}

bool hpr_nested_choose(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                       const hpr_polygon *send, double tolerance, hpr_rule_sink sink, void *user)
{
    const hpr_box whole_box = hpr_box_unit();
    /* Some hundred boxes err within their share, most of them far below it; none can be nearer than rounding.
     */
    static const double box_share = 0.005, rounding = 1e-15;
    /* The smaller polygon is the outer one: seen from it, the other fills much of the sky and nothing
     * cancels. */
    bool recv_is_outer = frame_area(&pair->recv, recv) <= frame_area(&pair->send, send);
    const hpr_polygon *outer = recv_is_outer ? recv : send, *inner = recv_is_outer ? send : recv;
    nested n = {.gauss = gauss,
                .pair = pair,
                .outer = recv_is_outer ? &pair->recv : &pair->send,
                .inner = recv_is_outer ? &pair->send : &pair->recv,
                .reached = true,
                .sink = sink,
                .user = user};
    set_nodes(&n, recv_is_outer, inner, tolerance);
    n.outline.count = inner->count;
    for (int i = 0; i < inner->count; i++)
        n.outline.corner[i] = hpr_frame_point(n.inner, inner->corner[i][0], inner->corner[i][1]);
    hpr_cuts cut;
    hpr_cuts_init(&cut, outer);
    cut_by_edges(&n, &cut);
    double whole[HPR_MAX_CUTS][HPR_POLYGON_MAX], total = 0;
    hpr_cell cell[HPR_POLYGON_MAX];
    for (int p = 0; p < cut.count; p++) {
        int count = hpr_cuts_fan(&cut.piece[p], cell);
        for (int i = 0; i < count; i++)
            total += whole[p][i] = box_integral(&n, &cell[i], &whole_box);
    }
    n.allowed = fmax(box_share * tolerance, rounding) * total;
    for (int p = 0; p < cut.count; p++) {
        int count = hpr_cuts_fan(&cut.piece[p], cell);
        for (int i = 0; i < count; i++)
            refine(&n, &cell[i], &whole_box, whole[p][i], 0);
    }
    return n.reached;
}
