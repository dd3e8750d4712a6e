/*
 * The rule for pairs that nearly touch in planes that nearly agree, and for polynomials where pairs nearly
 * touch anyhow: an outer integral over one polygon of the inner integral over the other. As a function of the
 * outer point the inner integral is analytic but near the inner polygon's edges (analytic.h). So the outer
 * polygon is cut along their projections, each piece falls into triangles with one of its sides as base,
 * these into trapezia across the base where a corner of the inner polygon is near it, and trapezia are halved
 * until Gauss resolves them: sides of all of them run along or across the edge that matters, and their number
 * grows like the square of the logarithm of the distance. Source: the idea of an outer integral over the
 * exact inner one as in Schroder & Hanrahan 1993, sec. 5, and Walton 2002 (View3D), with polynomials.
 */
#include "direct/lambert.h"
#include "quadrature/analytic.h"
#include "quadrature/cuts.h"
#include "quadrature/polar.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_DEPTH = 60, MAX_RULES = 20000, MAX_FEET = HPR_POLYGON_MAX + 3 };

typedef struct nested {
    const hpr_gauss_table *gauss;
    const hpr_element_frame *outer, *inner;
    int count; /* corners of the inner polygon */
    hpr_vec3 outline[HPR_POLYGON_MAX];
    hpr_rule rule;                      /* all but the outer set */
    double tolerance, total;            /* of the whole, in outer parameters */
    bool sandwich;                      /* constants face to face: settled() applies */
    hpr_affine height;                  /* of outer points over the inner plane */
    hpr_affine inside[HPR_POLYGON_MAX]; /* distance from edge i's projection, towards the inner polygon */
    int cap;
    int rule_count;
    bool counting; /* first the total is estimated */
    bool reached;
    hpr_rule_sink sink;
    void *user;
} nested;

/* A quadrilateral in parameters, corners at (u, v) = 00, 10, 11, 01. */
typedef struct quad {
    double corner[4][2];
} quad;

static hpr_vec3 place(const nested *n, const double at[2])
{
    return hpr_frame_point(n->outer, at[0], at[1]);
}

static void between(const double a[2], const double b[2], double f, double at[2])
{
    for (int i = 0; i < 2; i++)
        at[i] = a[i] + f * (b[i] - a[i]);
}

/* Nodes along one axis and the error that they leave. */
typedef struct grid {
    int nodes;
    double error;
} grid;

/* For the lines u = 0, 1/2, 1 (axis 1: those lines run along v) or v = 0, 1/2, 1. */
static grid quad_grid(const nested *n, const quad *q, int axis, double strength, double tolerance)
{
    const double(*c)[2] = q->corner;
    grid most = {1, 0};
    for (int k = 0; k < 3; k++) {
        double from[2], to[2], chord[2];
        between(c[0], axis == 0 ? c[3] : c[1], 0.5 * k, from);
        between(axis == 0 ? c[1] : c[3], c[2], 0.5 * k, to);
        double ellipse = hpr_bernstein(place(n, from), place(n, to), n->outline, n->count);
        hpr_convergence con = {ellipse, strength, ellipse, 1, hpr_total_degree(n->outer)};
        if (con.degree && isfinite(con.ellipse)) {
            hpr_frame_chord(n->outer, from, to, chord);
            con.growth = hpr_chord_growth(con.ellipse, chord[0], chord[1]);
        }
        int nodes = hpr_convergence_nodes(&con, tolerance);
        if (nodes >= most.nodes)
            most = (grid){nodes, hpr_convergence_error(&con, nodes)};
    }
    return most;
}

static hpr_lambert fraction_at(const nested *n, const double at[2])
{
    hpr_vec3 x = place(n, at), corner[HPR_POLYGON_MAX];
    for (int i = 0; i < n->count; i++)
        corner[i] = hpr_sub(n->outline[i], x);
    return hpr_lambert_above(n->outer->normal, corner, (size_t)n->count);
}

static double quad_area(const quad *q)
{
    const double(*c)[2] = q->corner;
    double d1[2] = {c[2][0] - c[0][0], c[2][1] - c[0][1]}, d2[2] = {c[3][0] - c[1][0], c[3][1] - c[1][1]};
    return fabs(d1[0] * d2[1] - d1[1] * d2[0]) / 2;
}

/* About what a quadrilateral contributes, and the least cancellation there. */
static double contribution(const nested *n, const quad *q, double *cancellation)
{
    double most = 0;
    *cancellation = INFINITY;
    for (int j = 0; j < 3; j++) {
        double from[2], to[2];
        between(q->corner[0], q->corner[3], 0.1 + 0.4 * j, from);
        between(q->corner[1], q->corner[2], 0.1 + 0.4 * j, to);
        for (int i = 0; i < 3; i++) {
            double at[2];
            between(from, to, 0.1 + 0.4 * i, at);
            hpr_lambert here = fraction_at(n, at);
            most = fmax(most, here.fraction);
            *cancellation = fmin(*cancellation, here.cancellation);
        }
    }
    return most * quad_area(q);
}

static void emit(nested *n, const quad *q, const grid axes[2], double tolerance)
{
    hpr_rule rule = n->rule;
    memcpy(rule.nested.outer, q->corner, sizeof q->corner);
    rule.nested.tolerance = tolerance;
    rule.error = hpr_polar_error(&rule.nested.inner, tolerance);
    for (int axis = 0; axis < 2; axis++) {
        int nodes = axes[axis].nodes;
        n->reached &= nodes <= n->cap;
        rule.nested.nodes[axis] = nodes < HPR_NODES_MAX ? nodes : HPR_NODES_MAX;
        rule.error += axes[axis].error;
    }
    n->rule_count++;
    n->sink(n->user, &rule);
}

static void halve(const quad *q, int axis, quad half[2])
{
    double low[2], high[2];
    half[0] = half[1] = *q;
    if (axis == 0) {
        between(q->corner[0], q->corner[1], 0.5, low);
        between(q->corner[3], q->corner[2], 0.5, high);
        memcpy(half[0].corner[1], low, sizeof low);
        memcpy(half[0].corner[2], high, sizeof high);
        memcpy(half[1].corner[0], low, sizeof low);
        memcpy(half[1].corner[3], high, sizeof high);
    } else {
        between(q->corner[0], q->corner[3], 0.5, low);
        between(q->corner[1], q->corner[2], 0.5, high);
        memcpy(half[0].corner[3], low, sizeof low);
        memcpy(half[0].corner[2], high, sizeof high);
        memcpy(half[1].corner[0], low, sizeof low);
        memcpy(half[1].corner[1], high, sizeof high);
    }
}

/* How far a half plane that is `height` away can be from filling the view, or from filling nothing of it, at
 * `distance` from the projection of its edge; on average over a strip from there on of this width. */
static double half_plane(double distance, double height, double width)
{
    double r = hypot(distance, height), end = r > 0 ? height * height / (2 * r * (r + distance)) : 0;
    return fmin(end, height / width);
}

/*
 * Two planes face each other closely: but for strips along the projections of the inner edges, as wide as the
 * planes are apart, a point sees nothing but the inner polygon, or nothing of it. A bound on what that leaves
 * out on average over a quadrilateral: of the edges together inside, of any that is between outside.
 */
static double unsettled(const nested *n, const quad *q)
{
    double height = 0, inside = 0, outside = 1;
    for (int k = 0; k < 4; k++)
        height = fmax(height, hpr_affine_at(&n->height, q->corner[k][0], q->corner[k][1]));
    for (int i = 0; i < n->count; i++) {
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < 4; k++) {
            double at = hpr_affine_at(&n->inside[i], q->corner[k][0], q->corner[k][1]);
            low = fmin(low, at);
            high = fmax(high, at);
        }
        if (low + high > 0)
            inside += half_plane(fmax(low, 0), height, high - low);
        else
            outside = fmin(outside, half_plane(fmax(-high, 0), height, high - low));
    }
    return outside < 1 ? outside : inside;
}

static void refine(nested *n, const quad *q, int depth)
{
    static const double share = 0.005, loosest = 1e-2;
    double cancellation, part = contribution(n, q, &cancellation);
    double strength = hpr_polygon_strength(cancellation), allowed = share * n->tolerance * n->total;
    double tolerance = fmin(loosest, fmax(n->tolerance, allowed / part));
    double rest = n->sandwich ? unsettled(n, q) * quad_area(q) : INFINITY;
    if (rest < allowed) {
        const grid one = {1, rest > 0 ? rest / fmax(part, rest) : 0};
        emit(n, q, (grid[2]){one, one}, tolerance);
        return;
    }
    grid axes[2] = {quad_grid(n, q, 0, strength, tolerance), quad_grid(n, q, 1, strength, tolerance)};
    int axis = axes[1].nodes > axes[0].nodes;
    bool stop = depth >= MAX_DEPTH || n->rule_count >= MAX_RULES;
    if (!stop && axes[axis].nodes > n->cap) {
        quad half[2];
        halve(q, axis, half);
        refine(n, &half[0], depth + 1);
        refine(n, &half[1], depth + 1);
        return;
    }
    emit(n, q, axes, tolerance);
}

static void add_quad(nested *n, const quad *q)
{
    if (!(quad_area(q) > 0))
        return;
    double cancellation;
    if (n->counting)
        n->total += contribution(n, q, &cancellation) / 2;
    else
        refine(n, q, 0);
}

/* A triangle over a base: distances along the base, the base from 0 to its length, the apex at its foot. */
typedef struct tent {
    const double *p, *q, *apex;
    double length, peak;
} tent;

/* The tent's lower and upper end at a place along the base. */
static void tent_ends(const tent *t, double at, double low[2], double high[2])
{
    double on_left = at / t->peak, on_right = (at - t->length) / (t->peak - t->length);
    if (at < 0) {
        between(t->p, t->apex, on_left, low);
        between(t->q, t->apex, on_right, high);
        return;
    }
    if (at > t->length) {
        between(t->q, t->apex, on_right, low);
        between(t->p, t->apex, on_left, high);
        return;
    }
    between(t->p, t->q, at / t->length, low);
    if (t->peak > 0 && at <= t->peak)
        between(t->p, t->apex, on_left, high);
    else
        between(t->q, t->apex, on_right, high);
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Where a tent is to be cut across its base: at the base's ends, below the apex and beside near corners. */
static int find_feet(const nested *n, const tent *t, hpr_vec3 start, hpr_vec3 along, double *foot)
{
    static const double near = 0.5;
    double first = fmin(t->peak, 0), last = fmax(t->peak, t->length);
    int count = 0;
    foot[count++] = 0;
    foot[count++] = t->length;
    foot[count++] = t->peak;
    for (int i = 0; i < n->count; i++) {
        hpr_vec3 offset = hpr_sub(n->outline[i], start);
        double at = hpr_dot(offset, along), gap = hpr_length(hpr_madd(offset, -at, along));
        if (at > first && at < last && gap < near * t->length)
            foot[count++] = at;
    }
    qsort(foot, (size_t)count, sizeof *foot, compare);
    return count;
}

/* The triangle from the side p q to the apex: trapezia across p q if that is near an edge. */
static void add_triangle(nested *n, const double p[2], const double q[2], const double apex[2])
{
    hpr_vec3 start = place(n, p), end = place(n, q), along = hpr_sub(end, start);
    tent t = {p, q, apex, hpr_length(along), 0};
    quad piece;
    if (!(t.length > 0))
        return;
    const hpr_convergence con = {hpr_bernstein(start, end, n->outline, n->count), INFINITY, 1, 1, 0};
    if (hpr_convergence_nodes(&con, n->tolerance) <= n->cap) {
        const double *corner[4] = {p, q, apex, apex};
        for (int k = 0; k < 4; k++)
            memcpy(piece.corner[k], corner[k], sizeof piece.corner[k]);
        add_quad(n, &piece);
        return;
    }
    along = hpr_scale(along, 1 / t.length);
    t.peak = hpr_dot(hpr_sub(place(n, apex), start), along);
    double foot[MAX_FEET];
    int count = find_feet(n, &t, start, along, foot);
    for (int i = 0; i + 1 < count; i++) {
        tent_ends(&t, foot[i], piece.corner[0], piece.corner[3]);
        tent_ends(&t, foot[i + 1], piece.corner[1], piece.corner[2]);
        if (foot[i + 1] > foot[i])
            add_quad(n, &piece);
    }
}

/* Where outer points lie beside the projections of the inner polygon's edges. */
static void project_edges(nested *n)
{
    hpr_vec3 middle = {0, 0, 0};
    for (int i = 0; i < n->count; i++)
        middle = hpr_madd(middle, 1.0 / n->count, n->outline[i]);
    for (int i = 0; i < n->count; i++) {
        hpr_vec3 from = n->outline[i], edge = hpr_sub(n->outline[(i + 1) % n->count], from);
        hpr_vec3 normal = hpr_cross(edge, n->outer->normal);
        double sign = hpr_dot(normal, hpr_sub(middle, from)) < 0 ? -1 : 1, length = hpr_length(normal);
        normal = hpr_scale(normal, length > 0 ? sign / length : 0);
        n->inside[i] = (hpr_affine){hpr_dot(normal, hpr_sub(n->outer->origin, from)),
                                    hpr_dot(normal, n->outer->edge1), hpr_dot(normal, n->outer->edge2)};
    }
}

static void add_pieces(nested *n, const hpr_polygon *outer)
{
    hpr_cuts cut;
    hpr_cuts_init(&cut, outer);
    for (int i = 0; i < n->count; i++)
        hpr_cuts_along(&cut, &n->inside[i]);
    for (int p = 0; p < cut.count; p++) {
        const hpr_polygon *piece = &cut.piece[p];
        double middle[2] = {0, 0};
        for (int i = 0; i < piece->count; i++) {
            middle[0] += piece->corner[i][0] / piece->count;
            middle[1] += piece->corner[i][1] / piece->count;
        }
        for (int i = 0; i < piece->count; i++)
            add_triangle(n, piece->corner[i], piece->corner[(i + 1) % piece->count], middle);
    }
}

static double frame_area(const hpr_element_frame *frame, const hpr_polygon *polygon)
{
    return hpr_polygon_area(polygon) * hpr_frame_jacobian(frame);
}

bool hpr_nested_choose(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                       const hpr_polygon *send, double tolerance, hpr_rule_sink sink, void *user)
{
    static const double small_angle = 1e-3;
    bool constants = pair->recv.degree == 0 && pair->send.degree == 0;
    /* The smaller polygon is the outer one: seen from it, the other fills much of the sky. */
    bool recv_is_outer = frame_area(&pair->recv, recv) <= frame_area(&pair->send, send);
    const hpr_polygon *outer = recv_is_outer ? recv : send, *inner = recv_is_outer ? send : recv;
    nested n = {.gauss = gauss,
                .outer = recv_is_outer ? &pair->recv : &pair->send,
                .inner = recv_is_outer ? &pair->send : &pair->recv,
                .count = inner->count,
                .rule = {.kind = HPR_RULE_NESTED},
                .tolerance = tolerance,
                .cap = hpr_kernel_nodes(1, 0.5, tolerance) +
                       (recv_is_outer ? hpr_total_degree(&pair->recv) : hpr_total_degree(&pair->send)) / 2,
                .counting = true,
                .reached = true,
                .sink = sink,
                .user = user};
    n.rule.nested = (hpr_nested){
        .recv_is_outer = recv_is_outer, .dimension = 2, .inner = *inner, .weight = 1, .tolerance = tolerance};
    for (int i = 0; i < inner->count; i++)
        n.outline[i] = hpr_frame_point(n.inner, inner->corner[i][0], inner->corner[i][1]);
    memcpy(n.rule.nested.outer_origin, outer->corner[0], sizeof n.rule.nested.outer_origin);
    memcpy(n.rule.nested.inner_origin, inner->corner[0], sizeof n.rule.nested.inner_origin);
    n.height = recv_is_outer ? pair->recv_height : pair->send_height;
    n.sandwich = constants && hpr_dot(pair->recv.normal, pair->send.normal) < 0 &&
                 hpr_length(hpr_cross(pair->recv.normal, pair->send.normal)) < small_angle;
    project_edges(&n);
    add_pieces(&n, outer);
    n.counting = false;
    add_pieces(&n, outer);
    return n.reached;
}
