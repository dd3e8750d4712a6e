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

/* An interval of d along one edge on which the overlap is of one kind. */
typedef struct span {
    enum { RISING, WHOLE, FALLING } kind;
    double low, high; /* of d */
} span;

/* Returns how many there are. Of three the middle one, where one side lies within the other, may be empty.
 * Each begins just where the last one ends: of a gap as wide as rounding a thin slit between the planes makes
 * more. */
static int find_spans(const hpr_overlap *o, span spans[3])
{
    static const double nothing = 8 * DBL_EPSILON;
    double shorter = fmin(1, o->length), longer = fmax(1, o->length), first = o->first - 1;
    int count = 0;
    spans[count++] = (span){RISING, first, first + shorter};
    if (longer - shorter > nothing * longer)
        spans[count++] = (span){WHOLE, first + shorter, first + longer};
    spans[count] = (span){FALLING, spans[count - 1].high, o->first + o->length};
    return count + 1;
}

/* The common part of both sides where d is `part` of the way through a span. */
typedef struct common {
    double length, recv, send; /* it begins there on the receiver and on the sender */
} common;

static common common_part(const hpr_overlap *o, const span *s, double part)
{
    double length = s->high - s->low, way = part * length;
    if (s->kind == RISING)
        return (common){way, 1 - way, 0};
    if (s->kind == FALLING) {
        double left = (1 - part) * length;
        return (common){left, 0, o->length - left};
    }
    return o->length >= 1 ? (common){1, 0, way} : (common){o->length, length - way, 0};
}

/* values[n] = P_n(x), n < count */
static void legendre(double x, int count, double *values)
{
    values[0] = 1;
    if (count > 1)
        values[1] = x;
    for (int n = 1; n + 1 < count; n++)
        values[n + 1] = ((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1);
}

/* The correlations along one edge as polynomials of d on a span: coefficient[(k * n_send + l) * functions +
 * a] of P_a, a < functions; Gauss with so many nodes is exact for them, with half of them for the common
 * part. */
typedef struct correlation {
    int n_recv, n_send, functions;
    double *coefficient;
} correlation;

/* c_kl(d) where d is `part` of the way through the span: value[k * n_send + l] */
static void correlation_at(const hpr_gauss_rule *gauss, int nodes, const hpr_overlap *o, const common *part,
                           const correlation *c, double *value)
{
    double recv[HPR_MAX_DEGREE + 1], send[HPR_MAX_DEGREE + 1];
    memset(value, 0, (size_t)(c->n_recv * c->n_send) * sizeof *value);
    for (int i = 0; i < nodes; i++) {
        double x = part->recv + part->length * gauss->node[i];
        double y = (part->send + part->length * gauss->node[i]) / o->length;
        double weight = gauss->weight[i] * part->length / o->length;
        legendre(2 * x - 1, c->n_recv, recv);
        legendre(o->reversed ? 1 - 2 * y : 2 * y - 1, c->n_send, send);
        for (int k = 0; k < c->n_recv; k++) {
            for (int l = 0; l < c->n_send; l++)
                value[k * c->n_send + l] += weight * sqrt((2 * k + 1) * (2 * l + 1)) * recv[k] * send[l];
        }
    }
}

static void correlate(const hpr_gauss_table *gauss, const hpr_overlap *o, const span *s, const correlation *c)
{
    double value[HPR_MAX_BASIS], of_d[HPR_PARALLEL_FUNCTIONS];
    const hpr_gauss_rule *outer = &gauss->legendre[c->functions];
    int pairs = c->n_recv * c->n_send, inner_count = c->functions / 2;
    memset(c->coefficient, 0, (size_t)(pairs * c->functions) * sizeof(double));
    for (int j = 0; j < c->functions; j++) {
        common part = common_part(o, s, outer->node[j]);
        correlation_at(&gauss->legendre[inner_count], inner_count, o, &part, c, value);
        legendre(2 * outer->node[j] - 1, c->functions, of_d);
        for (int a = 0; a < c->functions; a++)
            of_d[a] *= (2 * a + 1) * outer->weight[j];
        for (int kl = 0; kl < pairs; kl++) {
            double *to = c->coefficient + kl * c->functions;
            for (int a = 0; a < c->functions; a++)
                to[a] += value[kl] * of_d[a];
        }
    }
}

/* The moments of one cell: moment[a * functions + b] = ∫ G P_a P_b over it. */
typedef struct cell {
    const hpr_gauss_table *gauss;
    hpr_vec3 edge[2], normal;
    double height;
    span side[2]; /* along the edges */
    double tolerance;
    int functions;
    double *moment;
    uint64_t kernel_count;
} cell;

static void add_moments(cell *c, double u, double v, double kernel)
{
    double pu[HPR_PARALLEL_FUNCTIONS], pv[HPR_PARALLEL_FUNCTIONS];
    int n = c->functions;
    legendre(u, n, pu);
    legendre(v, n, pv);
    for (int a = 0; a < n; a++) {
        double *row = c->moment + a * n, value = kernel * pu[a];
        for (int b = 0; b < n; b++)
            row[b] += value * pv[b];
    }
    c->kernel_count++;
}

/* Where d is on the span from -1 to 1. */
static double within(const span *s, double d)
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
    const span *s = c->side;
    corner[0] = place(c, s[0].low, s[1].low);
    corner[1] = place(c, s[0].high, s[1].low);
    corner[2] = place(c, s[0].high, s[1].high);
    corner[3] = place(c, s[0].low, s[1].high);
}

static void near_moments(cell *c, hpr_group *group)
{
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
                       .degree = 2 * (c->functions - 1),
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
    const span *s = c->side;
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
static void add_cell(const cell *c, const correlation *along1, const correlation *along2, bool swapped,
                     double *half, double *part)
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
    span first[3], second[3];
    int first_count = find_spans(&parallel->along[0], first);
    int second_count = find_spans(&parallel->along[1], second);
    correlation along[4];
    for (int i = 0; i < 4; i++)
        along[i] = (correlation){nr, ns, functions, scratch + (size_t)i * table};
    for (int j = 0; j < second_count; j++)
        correlate(gauss, &parallel->along[1], &second[j], &along[1 + j]);
    for (int i = 0; i < first_count; i++) {
        correlate(gauss, &parallel->along[0], &first[i], &along[0]);
        for (int j = 0; j < second_count; j++) {
            c.side[0] = first[i];
            c.side[1] = second[j];
            find_moments(&c, group);
            add_cell(&c, &along[0], &along[1 + j], parallel->swapped, half, part);
        }
    }
    return c.kernel_count;
}
