#include "quadrature/parallel.h"

#include "quadrature/polar.h"

#include <float.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* The sender's edge `b` along the receiver's edge `e`, and what of it does not run there. */
static double along_edge(hpr_vec3 b, hpr_vec3 e, double *aside)
{
    double part = hpr_dot(b, e) / hpr_dot(e, e);
    *aside = hpr_length(hpr_madd(b, -part, e));
    return part;
}

bool hpr_parallel_find(const hpr_pair *pair, double tolerance, hpr_parallel *parallel)
{
    static const double share = 0.05, rounding = 4 * DBL_EPSILON;
    const hpr_element_frame *recv = &pair->recv, *send = &pair->send;
    if (recv->shape != HPR_SHAPE_PARALLELOGRAM || send->shape != HPR_SHAPE_PARALLELOGRAM ||
        hpr_dot(recv->normal, send->normal) >= 0)
        return false;
    const hpr_vec3 edge[2] = {recv->edge1, recv->edge2}, other[2] = {send->edge1, send->edge2};
    double aside[2], crossed[2], straight_part[2], crossed_part[2];
    for (int i = 0; i < 2; i++) {
        straight_part[i] = along_edge(other[i], edge[i], &aside[i]);
        crossed_part[i] = along_edge(other[1 - i], edge[i], &crossed[i]);
    }
    parallel->swapped = crossed[0] + crossed[1] < aside[0] + aside[1];
    const double *part = parallel->swapped ? crossed_part : straight_part;
    double moved = parallel->swapped ? crossed[0] + crossed[1] : aside[0] + aside[1];
    hpr_vec3 centre = hpr_frame_point(send, 0.5, 0.5), across = hpr_cross(edge[0], edge[1]);
    parallel->height = hpr_dot(recv->normal, centre);
    double size = hpr_length(edge[0]) + hpr_length(edge[1]) + hpr_length(other[0]) + hpr_length(other[1]);
    double known = rounding * (size + hpr_length(send->origin));
    if (!(parallel->height > 0 && moved <= fmax(share * tolerance * parallel->height, known)))
        return false;
    hpr_vec3 dual[2] = {hpr_cross(edge[1], across), hpr_cross(across, edge[0])};
    for (int i = 0; i < 2; i++) {
        double length = fabs(part[i]), middle = hpr_dot(dual[i], centre) / hpr_dot(across, across);
        parallel->along[i] = (hpr_overlap){middle - length / 2, length, part[i] < 0};
    }
    return true;
}

/* The moments of one cell: moment[a * functions + b] = ∫ G P_a P_b over it. */
typedef struct cell {
    const hpr_gauss_table *gauss;
    hpr_vec3 edge[2], normal;
    double height;
    hpr_span side[2]; /* along the edges */
    double tolerance;
    int functions;
    double *moment;
    uint64_t kernel_count;
} cell;

static void add_moments(cell *c, double u, double v, double kernel)
{
    double pu[HPR_CORRELATION_FUNCTIONS], pv[HPR_CORRELATION_FUNCTIONS];
    int n = c->functions;
    hpr_legendre(u, n, pu);
    hpr_legendre(v, n, pv);
    for (int a = 0; a < n; a++) {
        double *row = c->moment + a * n, value = kernel * pu[a];
        for (int b = 0; b < n; b++)
            row[b] += value * pv[b];
    }
    c->kernel_count++;
}

/* Where d is on the span from -1 to 1. */
static double within(const hpr_span *s, double d)
{
    return (2 * d - s->low - s->high) / (s->high - s->low);
}

/* Points in units of the edges, from the place where d is 0. */
static void add_points(void *user, const hpr_group *group)
{
    cell *c = user;
    const hpr_points *p = &group->send;
    for (int j = 0; j < p->count; j++) {
        double r2 = p->x[j] * p->x[j] + p->y[j] * p->y[j] + p->z[j] * p->z[j];
        double kernel = c->height * p->weight[j] / (pi * r2 * r2);
        add_moments(c, within(&c->side[0], p->s[j]), within(&c->side[1], p->t[j]), kernel);
    }
}

static hpr_vec3 place(const cell *c, double d1, double d2)
{
    return hpr_madd(hpr_scale(c->edge[0], d1), d2, c->edge[1]);
}

static void corners(const cell *c, hpr_vec3 corner[4])
{
    const hpr_span *s = c->side;
    corner[0] = place(c, s[0].low, s[1].low);
    corner[1] = place(c, s[0].high, s[1].low);
    corner[2] = place(c, s[0].high, s[1].high);
    corner[3] = place(c, s[0].low, s[1].high);
}

static void near_moments(cell *c, hpr_group *group)
{
    static const double enough =
        1.5; /* of 2, what the degrees are: down to rounding, observed up to degree 16 */
    hpr_vec3 across = hpr_cross(c->edge[0], c->edge[1]);
    double square = hpr_dot(across, across);
    hpr_polar polar = {.gauss = c->gauss,
                       .count = 4,
                       .normal = c->normal,
                       .dual1 = hpr_scale(hpr_cross(c->edge[1], across), 1 / square),
                       .dual2 = hpr_scale(hpr_cross(across, c->edge[0]), 1 / square),
                       .outer_normal = hpr_scale(c->normal, -1),
                       .jacobian = sqrt(square),
                       .tolerance = c->tolerance,
                       .degree = (int)(enough * c->functions),
                       .points = &group->send,
                       .group = group,
                       .sink = add_points,
                       .user = c};
    corners(c, polar.corner);
    hpr_polar_points(&polar, hpr_scale(c->normal, c->height), c->height);
}

static void far_moments(cell *c, const int nodes[2])
{
    const hpr_gauss_rule *first = &c->gauss->legendre[nodes[0]], *second = &c->gauss->legendre[nodes[1]];
    const hpr_span *s = c->side;
    double half[2] = {(s[0].high - s[0].low) / 2, (s[1].high - s[1].low) / 2};
    double area = 4 * half[0] * half[1], square = c->height * c->height;
    for (int i = 0; i < nodes[0]; i++) {
        for (int j = 0; j < nodes[1]; j++) {
            double u = 2 * first->node[i] - 1, v = 2 * second->node[j] - 1;
            hpr_vec3 d = place(c, s[0].low + (1 + u) * half[0], s[1].low + (1 + v) * half[1]);
            double r2 = hpr_dot(d, d) + square;
            add_moments(c, u, v, area * first->weight[i] * second->weight[j] * square / (pi * r2 * r2));
        }
    }
}

static void find_moments(cell *c, hpr_group *group)
{
    enum { CAP = 12 };
    hpr_vec3 around[4], from = hpr_scale(c->normal, c->height);
    int nodes[2];
    corners(c, around);
    double distance = hpr_polygon_distance(around, 4, &from, 1);
    for (int i = 0; i < 2; i++)
        nodes[i] = hpr_kernel_nodes((c->side[i].high - c->side[i].low) * hpr_length(c->edge[i]), distance,
                                    c->tolerance);
    memset(c->moment, 0, (size_t)(c->functions * c->functions) * sizeof(double));
    if (nodes[0] > CAP || nodes[1] > CAP) {
        near_moments(c, group);
        return;
    }
    for (int i = 0; i < 2; i++)
        nodes[i] += c->functions / 2;
    far_moments(c, nodes);
}

/* part += what a cell gives, of the correlations along both edges. half: [n_recv n_send functions] */
static void add_cell(const cell *c, const hpr_correlation *along1, const hpr_correlation *along2,
                     bool swapped, double *half, double *part)
{
    int n = c->functions, nr = along1->n_recv, ns = along1->n_send;
    for (int kl = 0; kl < nr * ns; kl++) {
        const double *first = along1->coefficient + kl * n;
        double *row = half + kl * n;
        memset(row, 0, (size_t)n * sizeof *row);
        for (int a = 0; a < n; a++) {
            for (int b = 0; b < n; b++)
                row[b] += first[a] * c->moment[a * n + b];
        }
    }
    for (int kl1 = 0; kl1 < nr * ns; kl1++) {
        for (int kl2 = 0; kl2 < nr * ns; kl2++) {
            const double *row = half + kl1 * n, *second = along2->coefficient + kl2 * n;
            int k = (kl1 / ns) * nr + kl2 / ns, l1 = kl1 % ns, l2 = kl2 % ns;
            double sum = 0;
            for (int b = 0; b < n; b++)
                sum += row[b] * second[b];
            part[k * ns * ns + (swapped ? l2 * ns + l1 : l1 * ns + l2)] += sum;
        }
    }
}

uint64_t hpr_parallel_add(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_parallel *parallel,
                          double tolerance, hpr_group *group, double *part, double *scratch)
{
    const hpr_element_frame *recv = &pair->recv;
    int nr = recv->degree + 1, ns = pair->send.degree + 1, functions = recv->degree + pair->send.degree + 2;
    size_t table = (size_t)(nr * ns * functions);
    double *half = scratch + 4 * table;
    cell c = {.gauss = gauss,
              .edge = {recv->edge1, recv->edge2},
              .normal = recv->normal,
              .height = parallel->height,
              .tolerance = tolerance,
              .functions = functions,
              .moment = scratch + 5 * table};
    hpr_span first[3], second[3];
    int first_count = hpr_overlap_spans(&parallel->along[0], first);
    int second_count = hpr_overlap_spans(&parallel->along[1], second);
    hpr_correlation along[4];
    for (int i = 0; i < 4; i++)
        along[i] = (hpr_correlation){nr, ns, functions, scratch + (size_t)i * table};
    for (int j = 0; j < second_count; j++)
        hpr_correlate(gauss, &parallel->along[1], &second[j], &along[1 + j]);
    for (int i = 0; i < first_count; i++) {
        hpr_correlate(gauss, &parallel->along[0], &first[i], &along[0]);
        for (int j = 0; j < second_count; j++) {
            c.side[0] = first[i];
            c.side[1] = second[j];
            find_moments(&c, group);
            add_cell(&c, &along[0], &along[1 + j], parallel->swapped, half, part);
        }
    }
    return c.kernel_count;
}
