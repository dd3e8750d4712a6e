#include "quadrature/homothety.h"

#include "direct/lambert.h"
#include "math/planar_basis.h"
#include "quadrature/analytic.h"
#include "quadrature/polar.h"

#include <string.h>

enum { MAX_DEPTH = 60, MAX_RULES = 20000 };

typedef struct side {
    const hpr_element_frame *frame;
    const hpr_polygon *polygon;
    const double *centre[2];
} side;

typedef struct chooser {
    const hpr_gauss_table *gauss;
    side side[2]; /* receiver, sender */
    int centre_count;
    bool joined;
    double tolerance;
    int cap; /* more nodes than this, and a segment is halved */
    int rule_count;
    bool reached;
    hpr_rule_sink sink;
    void *user;
} chooser;

/* Twice the area of the triangle from c to the edge, in parameters; 0 if the edge contains c, or would but
 * for the rounding of parameters. */
static double from_centre(const double a[2], const double b[2], const double c[2])
{
    static const double rounding = 1e-14, parameters = 1e-15;
    double ax = a[0] - c[0], ay = a[1] - c[1], bx = b[0] - c[0], by = b[1] - c[1];
    double area = ax * by - ay * bx;
    double size = hypot(ax, ay) * hypot(bx, by);
    double length = hypot(b[0] - a[0], b[1] - a[1]);
    return fabs(area) > fmax(rounding * size, parameters * length) ? area : 0;
}

static bool same(const double a[2], const double b[2])
{
    static const double rounding = 1e-14;
    return fabs(a[0] - b[0]) + fabs(a[1] - b[1]) <= rounding;
}

/* A point as a vector from the origin of a rule, or from the pair's. */
static hpr_vec3 placed(const chooser *c, const side *side, const double point[2], const double origin[2])
{
    const double d[2] = {point[0] - origin[0], point[1] - origin[1]};
    return c->joined ? hpr_frame_vector(side->frame, d) : hpr_frame_point(side->frame, point[0], point[1]);
}

/* A rule whose outer side is side `outer`, positions from contact point `level` - 1. */
static hpr_rule begin(const chooser *c, int outer, int level, double weight)
{
    hpr_rule rule = {.kind = HPR_RULE_NESTED};
    hpr_nested *n = &rule.nested;
    n->recv_is_outer = outer == 0;
    n->joined = c->joined;
    n->homothety = level;
    n->weight = weight;
    n->tolerance = c->tolerance;
    const side *o = &c->side[outer], *i = &c->side[1 - outer];
    memcpy(n->outer_origin, c->joined ? o->centre[level - 1] : o->polygon->corner[0], sizeof n->outer_origin);
    memcpy(n->inner_origin, c->joined ? i->centre[level - 1] : i->polygon->corner[0], sizeof n->inner_origin);
    return rule;
}

/* How Gauss converges for the inner set of a rule along a segment of the outer side. */
static hpr_convergence convergence(const chooser *c, const hpr_nested *rule, const double from[2],
                                   const double to[2])
{
    const side *outer = &c->side[!rule->recv_is_outer], *inner = &c->side[rule->recv_is_outer];
    hpr_vec3 outline[HPR_POLYGON_MAX], a = placed(c, outer, from, rule->outer_origin),
                                       b = placed(c, outer, to, rule->outer_origin);
    int count = rule->inner.count;
    for (int i = 0; i < count; i++)
        outline[i] = placed(c, inner, rule->inner.corner[i], rule->inner_origin);
    double ellipse = hpr_bernstein(a, b, outline, count);
    hpr_convergence con = {ellipse, INFINITY, ellipse, 1, hpr_total_degree(outer->frame)};
    if (con.degree) {
        double chord[2];
        hpr_frame_chord(outer->frame, from, to, chord);
        con.growth = hpr_chord_growth(con.ellipse, chord[0], chord[1]);
    }
    if (count > 2) {
        hpr_vec3 middle = hpr_scale(hpr_add(a, b), 0.5);
        for (int i = 0; i < count; i++)
            outline[i] = hpr_sub(outline[i], middle);
        con.strength = hpr_polygon_strength(
            hpr_lambert_above(outer->frame->normal, outline, (size_t)count).cancellation);
    }
    return con;
}

/* Emits a rule over the outer segment in panels that the inner set lets Gauss resolve. */
static void along_segment(chooser *c, const hpr_rule *whole, const double from[2], const double to[2],
                          double weight, int depth)
{
    const hpr_convergence con = convergence(c, &whole->nested, from, to);
    int nodes = hpr_convergence_nodes(&con, c->tolerance), most = c->cap + (con.degree + 1) / 2;
    most = most < HPR_NODES_MAX ? most : HPR_NODES_MAX;
    if (nodes > most && depth < MAX_DEPTH && c->rule_count < MAX_RULES) {
        const double middle[2] = {(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
        along_segment(c, whole, from, middle, weight / 2, depth + 1);
        along_segment(c, whole, middle, to, weight / 2, depth + 1);
        return;
    }
    c->reached &= nodes <= most;
    nodes = nodes < most ? nodes : most;
    hpr_rule rule = *whole;
    hpr_nested *n = &rule.nested;
    c->rule_count++;
    n->nodes[0] = nodes;
    n->dimension = 1;
    n->weight = weight;
    memcpy(n->outer[0], from, sizeof n->outer[0]);
    memcpy(n->outer[1], to, sizeof n->outer[1]);
    rule.error = hpr_convergence_error(&con, nodes) + hpr_polar_error(&n->inner, c->tolerance);
    c->sink(c->user, &rule);
}

/* The second homothety: an edge from the second contact point to `end`. */
static void from_contact(chooser *c, int outer, const double end[2], double weight)
{
    const side *inner = &c->side[1 - outer];
    hpr_rule rule = begin(c, outer, 2, weight);
    hpr_nested *n = &rule.nested;
    n->inner = *inner->polygon;
    memcpy(n->outer[0], end, sizeof n->outer[0]);
    rule.error = hpr_polar_error(&n->inner, c->tolerance);
    c->sink(c->user, &rule);
    n->inner.count = 2;
    for (int i = 0; i < inner->polygon->count; i++) {
        const double *a = inner->polygon->corner[i],
                     *b = inner->polygon->corner[(i + 1) % inner->polygon->count];
        double width = from_centre(a, b, inner->centre[1]);
        if (width == 0)
            continue;
        memcpy(n->inner.corner[0], a, sizeof n->inner.corner[0]);
        memcpy(n->inner.corner[1], b, sizeof n->inner.corner[1]);
        along_segment(c, &rule, c->side[outer].centre[1], end, weight * width, 0);
    }
}

/* The edges of one side times the other side's polygon. */
static void by_edges(chooser *c, int outer)
{
    const side *side = &c->side[outer];
    for (int i = 0; i < side->polygon->count; i++) {
        const double *a = side->polygon->corner[i],
                     *b = side->polygon->corner[(i + 1) % side->polygon->count];
        double width = from_centre(a, b, side->centre[0]);
        if (width == 0)
            continue;
        if (c->centre_count > 1 && same(a, side->centre[1])) {
            from_contact(c, outer, b, width);
        } else if (c->centre_count > 1 && same(b, side->centre[1])) {
            from_contact(c, outer, a, width);
        } else {
            hpr_rule rule = begin(c, outer, 1, width);
            rule.nested.inner = *c->side[1 - outer].polygon;
            along_segment(c, &rule, a, b, width, 0);
        }
    }
}

bool hpr_homothety_choose(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_homothety *h,
                          double tolerance, hpr_rule_sink sink, void *user)
{
    chooser c = {.gauss = gauss,
                 .side = {{&pair->recv, &h->recv, {h->centre[0].recv, h->centre[1].recv}},
                          {&pair->send, &h->send, {h->centre[0].send, h->centre[1].send}}},
                 .centre_count = h->centre_count,
                 .joined = h->touching,
                 .tolerance = tolerance,
                 .cap = hpr_kernel_nodes(1, 0.25, tolerance),
                 .reached = true,
                 .sink = sink,
                 .user = user};
    by_edges(&c, 0);
    by_edges(&c, 1);
    return c.reached;
}

hpr_homothety hpr_homothety_touching(const hpr_contact *contact)
{
    hpr_homothety h = {contact->recv_front, contact->send_front, true, contact->point_count, {{{0}, {0}}}};
    for (int k = 0; k < contact->point_count; k++) {
        memcpy(h.centre[k].recv, contact->recv_point[k], sizeof h.centre[k].recv);
        memcpy(h.centre[k].send, contact->send_point[k], sizeof h.centre[k].send);
    }
    return h;
}

/* Extent of a polygon along a direction. */
static void extent_along(const hpr_element_frame *frame, const hpr_polygon *polygon, hpr_vec3 direction,
                         double extent[2])
{
    extent[0] = INFINITY;
    extent[1] = -INFINITY;
    for (int i = 0; i < polygon->count; i++) {
        double at = hpr_dot(direction, hpr_frame_point(frame, polygon->corner[i][0], polygon->corner[i][1]));
        extent[0] = fmin(extent[0], at);
        extent[1] = fmax(extent[1], at);
    }
}

/* Parameters of the point of an element's plane at height 0 over the other's, at a place along the line. */
static void crossing(const hpr_element_frame *frame, const hpr_affine *height, hpr_vec3 direction, double at,
                     double point[2])
{
    double e1 = hpr_dot(direction, frame->edge1), e2 = hpr_dot(direction, frame->edge2);
    double rest = at - hpr_dot(direction, frame->origin);
    double determinant = height->along1 * e2 - height->along2 * e1;
    point[0] = (-height->at_origin * e2 - height->along2 * rest) / determinant;
    point[1] = (height->along1 * rest + height->at_origin * e1) / determinant;
}

/* The same from a quadrilateral: across each side, as far as the element reaches from it. */
static double skew_growth(const hpr_element_frame *frame, const double centre[2])
{
    const hpr_polygon outline = hpr_frame_outline(frame);
    double growth = 1;
    for (int i = 0; i < 4; i++) {
        const double *p = outline.corner[i], *q = outline.corner[(i + 1) % 4];
        const hpr_affine inside = {(q[1] - p[1]) * p[0] - (q[0] - p[0]) * p[1], p[1] - q[1], q[0] - p[0]};
        double reach = hpr_frame_largest(frame, &inside);
        growth = fmax(growth, hpr_ellipse(hpr_affine_at(&inside, centre[0], centre[1]) / reach, 0));
    }
    return growth;
}

/* Growth of polynomials from the element to the centre. */
static double side_growth(const hpr_element_frame *frame, const double centre[2])
{
    double growth = hpr_ellipse(centre[0], 0) * hpr_ellipse(centre[1], 0);
    if (frame->shape == HPR_SHAPE_TRIANGLE)
        growth = fmax(fmax(hpr_ellipse(centre[0], 0), hpr_ellipse(centre[1], 0)),
                      hpr_ellipse(1 - centre[0] - centre[1], 0));
    if (frame->shape == HPR_SHAPE_QUADRILATERAL)
        growth = skew_growth(frame, centre);
    return pow(growth, frame->degree);
}

/* Sums of the kernel over all rules, with and without regard to sign. */
typedef struct cancellation {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    hpr_group *group;
    double sum, size;
} cancellation;

static void add_group(void *user, const hpr_group *group)
{
    cancellation *c = user;
    double part = hpr_group_sum(group);
    c->sum += part;
    c->size += fabs(part);
}

static void add_rule(void *user, const hpr_rule *rule)
{
    cancellation *c = user;
    hpr_rule_points(c->gauss, c->pair, rule, c->group, add_group, c);
}

/* By how much the terms cancel where the polynomials are constants. */
static double cancels(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_homothety *h,
                      hpr_group *group)
{
    static const double tolerance = 1e-3;
    hpr_pair constants = *pair;
    constants.recv.degree = constants.send.degree = 0;
    cancellation c = {gauss, &constants, group, 0, 0};
    hpr_homothety_choose(gauss, &constants, h, tolerance, add_rule, &c);
    return c.size / fabs(c.sum);
}

hpr_homothety hpr_homothety_apart(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                  const hpr_contact *contact, hpr_group *group, double *condition)
{
    static const double parallel = 1e-6;
    hpr_homothety h = {contact->recv_front, contact->send_front, false, 1, {{{0}, {0}}}};
    hpr_vec3 direction = hpr_cross(pair->recv.normal, pair->send.normal);
    double sine = hpr_length(direction), recv[2], send[2];
    *condition = INFINITY;
    if (!(sine > parallel))
        return h;
    direction = hpr_scale(direction, 1 / sine);
    extent_along(&pair->recv, &h.recv, direction, recv);
    extent_along(&pair->send, &h.send, direction, send);
    /* the middle of what they share along the line, or of the gap */
    double at = (fmax(recv[0], send[0]) + fmin(recv[1], send[1])) / 2;
    crossing(&pair->recv, &pair->recv_height, direction, at, h.centre[0].recv);
    crossing(&pair->send, &pair->send_height, direction, at, h.centre[0].send);
    *condition = side_growth(&pair->recv, h.centre[0].recv) * side_growth(&pair->send, h.centre[0].send) *
                 cancels(gauss, pair, &h, group);
    return h;
}

/* C_lm of a one-dimensional basis: p_l(c + lambda (s - c)) = sum_m C_lm p_m(s), both orthonormal on [0, 1].
 */
static void scale_tensor(const hpr_gauss_table *gauss, int degree, double centre, double lambda,
                         double *matrix)
{
    size_t n = (size_t)degree + 1;
    const hpr_gauss_rule *rule = &gauss->legendre[n];
    double here[HPR_MAX_BASIS], there[HPR_MAX_BASIS];
    memset(matrix, 0, n * n * sizeof *matrix);
    for (size_t q = 0; q < n; q++) {
        double s = rule->node[q];
        /* the functions of s alone stand at k = (p + 1) a; p_0(t) = 1 */
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, degree, s, 0.5, here);
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, degree, centre + lambda * (s - centre), 0.5, there);
        for (size_t l = 0; l < n; l++) {
            for (size_t m = 0; m <= l; m++)
                matrix[l * n + m] += rule->weight[q] * there[l * n] * here[m * n];
        }
    }
}

/* Node of n x n product Gauss on a triangle or a quadrilateral, exact up to degree 2 n - 2. Returns its
 * weight. */
static double domain_node(const hpr_gauss_table *gauss, const hpr_element_frame *frame, int n, int index,
                          double *s, double *t)
{
    if (frame->shape == HPR_SHAPE_QUADRILATERAL) {
        hpr_planar_node node = hpr_planar_gauss(frame->opposite, &gauss->legendre[n], n, index);
        *s = node.s;
        *t = node.t;
        return node.weight;
    }
    *t = gauss->jacobi[n].node[index / n];
    *s = gauss->legendre[n].node[index % n] * (1 - *t);
    return gauss->legendre[n].weight[index % n] * gauss->jacobi[n].weight[index / n];
}

/* C [count][count] of one side that is no parallelogram. */
static void scale_matrix(const hpr_gauss_table *gauss, const hpr_element_frame *frame, const double centre[2],
                         double lambda, double *matrix)
{
    size_t n = (size_t)frame->degree + 1, count = hpr_basis_count(frame->shape, frame->degree);
    double here[HPR_MAX_BASIS], there[HPR_MAX_BASIS];
    memset(matrix, 0, count * count * sizeof *matrix);
    for (size_t q = 0; q < n * n; q++) {
        double s, t, weight = domain_node(gauss, frame, (int)n, (int)q, &s, &t);
        hpr_frame_basis(frame, s, t, here);
        hpr_frame_basis(frame, centre[0] + lambda * (s - centre[0]), centre[1] + lambda * (t - centre[1]),
                        there);
        for (size_t l = 0; l < count; l++) {
            for (size_t m = 0; m < count; m++)
                matrix[l * count + m] += weight * there[l] * here[m];
        }
    }
}

/* An array [before][n][after], of which the middle index is to be multiplied by matrix [n][n]. */
typedef struct axis {
    size_t before, n, after;
    const double *matrix;
} axis;

static void multiply(const axis *a, const double *in, double *out)
{
    const size_t n = a->n, after = a->after;
    memset(out, 0, a->before * n * after * sizeof *out);
    for (size_t i = 0; i < a->before; i++, in += n * after, out += n * after) {
        for (size_t l = 0; l < n; l++) {
            for (size_t m = 0; m < n; m++) {
                double f = a->matrix[l * n + m];
                for (size_t k = 0; k < after && f != 0; k++)
                    out[l * after + k] += f * in[m * after + k];
            }
        }
    }
}

/* What one side is multiplied by while the other waits: arrays [functions][after]. */
typedef struct two_arrays {
    double *now, *next;
} two_arrays;

static void multiply_by(const axis *axis, two_arrays *arrays)
{
    double *done = arrays->now;
    multiply(axis, done, arrays->next);
    arrays->now = arrays->next;
    arrays->next = done;
}

/* A parallelogram's C is a product of two of one dimension. matrices: [count^2] */
static void scale_side(const hpr_gauss_table *gauss, const hpr_element_frame *frame, const double centre[2],
                       double lambda, size_t after, double *matrices, two_arrays *arrays)
{
    size_t n = (size_t)frame->degree + 1, count = hpr_basis_count(frame->shape, frame->degree);
    if (frame->shape != HPR_SHAPE_PARALLELOGRAM) {
        scale_matrix(gauss, frame, centre, lambda, matrices);
        multiply_by(&(axis){1, count, after, matrices}, arrays);
        return;
    }
    scale_tensor(gauss, frame->degree, centre[0], lambda, matrices);
    multiply_by(&(axis){1, n, n * after, matrices}, arrays);
    scale_tensor(gauss, frame->degree, centre[1], lambda, matrices);
    multiply_by(&(axis){n, n, after, matrices}, arrays);
}

static void transpose(size_t rows, size_t columns, two_arrays *arrays)
{
    double *from = arrays->now, *to = arrays->next;
    for (size_t i = 0; i < rows; i++) {
        for (size_t j = 0; j < columns; j++)
            to[j * rows + i] = from[i * columns + j];
    }
    arrays->now = to;
    arrays->next = from;
}

void hpr_homothety_apply(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_centre *centre,
                         int power, const double *inside, double *block, double *scratch)
{
    size_t rows = hpr_basis_count(pair->recv.shape, pair->recv.degree);
    size_t columns = hpr_basis_count(pair->send.shape, pair->send.degree), count = rows * columns;
    int degree = hpr_total_degree(&pair->recv) + hpr_total_degree(&pair->send) + power;
    const hpr_gauss_rule *rule = &gauss->legendre[degree / 2 + 1];
    for (int q = 0; q < degree / 2 + 1; q++) {
        double lambda = rule->node[q], weight = rule->weight[q] * (power ? lambda : 1);
        two_arrays arrays = {scratch, scratch + count};
        memcpy(arrays.now, inside, count * sizeof *inside);
        scale_side(gauss, &pair->recv, centre->recv, lambda, columns, scratch + 2 * count, &arrays);
        transpose(rows, columns, &arrays);
        scale_side(gauss, &pair->send, centre->send, lambda, rows, scratch + 2 * count, &arrays);
        transpose(columns, rows, &arrays);
        for (size_t i = 0; i < count; i++)
            block[i] += weight * arrays.now[i];
    }
}
