/*
 * Kernel blocks of triangles by brute force, in long double: both are halved until they are as far apart as
 * they are large, then product Gauss; what still touches after many halvings is left out. Another rule than
 * the blocks', and a slow one. Not for triangles that share more than a point: they touch in too many places.
 */
#ifndef HPR_TESTS_HALVING_H
#define HPR_TESTS_HALVING_H

#include "blocks.h"

enum { HALVING_NODES = 18, HALVING_DEPTH = 200 };

typedef struct halving_triangle {
    long double s[3], t[3]; /* parameters of the corners */
} halving_triangle;

typedef struct halving {
    const hpr_element_frame *frame[2];
    long double normal[2][3];
    size_t k[2]; /* the entry */
    long double node[HALVING_NODES], weight[HALVING_NODES];
    int nodes;
    int cells, most; /* product rules so far, and how many are allowed */
} halving;

/* Gauss-Legendre on [0, 1] by Newton's method. */
static inline void halving_gauss(halving *h, int n)
{
    h->nodes = n;
    for (int i = 0; i < n; i++) {
        long double x = cosl(2 * acosl(0) * (i + 0.75L) / (n + 0.5L)), slope = 1;
        for (int step = 0; step < 50; step++) {
            long double before = 1, value = x;
            for (int m = 2; m <= n; m++) {
                long double next = ((2 * m - 1) * x * value - (m - 1) * before) / m;
                before = value;
                value = next;
            }
            slope = n * (before - x * value) / (1 - x * x);
            x -= value / slope;
        }
        h->node[i] = (1 + x) / 2;
        h->weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
}

static inline void halving_point(const hpr_element_frame *f, long double s, long double t, long double x[3])
{
    x[0] = f->origin.x + s * f->edge1.x + t * f->edge2.x;
    x[1] = f->origin.y + s * f->edge1.y + t * f->edge2.y;
    x[2] = f->origin.z + s * f->edge1.z + t * f->edge2.z;
}

static inline void halving_normal(const hpr_element_frame *f, long double normal[3])
{
    const long double a[3] = {f->edge1.x, f->edge1.y, f->edge1.z},
                      b[3] = {f->edge2.x, f->edge2.y, f->edge2.z};
    long double square = 0;
    for (int k = 0; k < 3; k++) {
        normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        square += normal[k] * normal[k];
    }
    for (int k = 0; k < 3; k++)
        normal[k] /= sqrtl(square);
}

/* Centre, half the longest way from it, the longest edge's first corner. */
static inline int halving_ball(const hpr_element_frame *f, const halving_triangle *a, long double centre[3],
                               long double *radius, long double *size)
{
    long double x[3][3];
    int longest = 0;
    *radius = *size = 0;
    for (int i = 0; i < 3; i++)
        halving_point(f, a->s[i], a->t[i], x[i]);
    for (int k = 0; k < 3; k++)
        centre[k] = (x[0][k] + x[1][k] + x[2][k]) / 3;
    for (int i = 0; i < 3; i++) {
        long double off = 0, edge = 0;
        for (int k = 0; k < 3; k++) {
            off += (x[i][k] - centre[k]) * (x[i][k] - centre[k]);
            edge += (x[(i + 1) % 3][k] - x[i][k]) * (x[(i + 1) % 3][k] - x[i][k]);
        }
        *radius = fmaxl(*radius, sqrtl(off));
        if (edge > *size) {
            *size = edge;
            longest = i;
        }
    }
    *size = sqrtl(*size);
    return longest;
}

/* Points of one side, weights in parameter measure times phi_k. */
typedef struct halving_points {
    int count;
    long double x[HALVING_NODES * HALVING_NODES][3], weight[HALVING_NODES * HALVING_NODES];
} halving_points;

static inline void halving_fill(const halving *h, int side, const halving_triangle *a, halving_points *points)
{
    const hpr_element_frame *f = h->frame[side];
    long double ds1 = a->s[1] - a->s[0], dt1 = a->t[1] - a->t[0], ds2 = a->s[2] - a->s[0],
                dt2 = a->t[2] - a->t[0];
    long double twice = fabsl(ds1 * dt2 - ds2 * dt1);
    points->count = 0;
    for (int i = 0; i < h->nodes; i++) {
        for (int j = 0; j < h->nodes; j++) {
            double basis[HPR_MAX_BASIS];
            long double u = h->node[i] * (1 - h->node[j]), v = h->node[j];
            long double s = a->s[0] + u * ds1 + v * ds2, t = a->t[0] + u * dt1 + v * dt2;
            hpr_basis_eval(f->shape, f->degree, (double)s, (double)t, basis);
            halving_point(f, s, t, points->x[points->count]);
            points->weight[points->count++] =
                h->weight[i] * h->weight[j] * (1 - v) * twice * basis[h->k[side]];
        }
    }
}

static inline long double halving_product(const halving *h, const halving_triangle *a,
                                          const halving_triangle *b)
{
    static halving_points one, two;
    const long double *n1 = h->normal[0], *n2 = h->normal[1];
    long double sum = 0;
    halving_fill(h, 0, a, &one);
    halving_fill(h, 1, b, &two);
    for (int i = 0; i < one.count; i++) {
        for (int j = 0; j < two.count; j++) {
            long double x = two.x[j][0] - one.x[i][0], y = two.x[j][1] - one.x[i][1],
                        z = two.x[j][2] - one.x[i][2], r2 = x * x + y * y + z * z;
            long double c1 = x * n1[0] + y * n1[1] + z * n1[2], c2 = -(x * n2[0] + y * n2[1] + z * n2[2]);
            sum += one.weight[i] * two.weight[j] * c1 * c2 / (r2 * r2);
        }
    }
    return sum / (2 * acosl(0));
}

static inline long double halving_sum(halving *h, const halving_triangle *a, const halving_triangle *b,
                                      int depth)
{
    long double c1[3], c2[3], r1, r2, size1, size2, gap = 0;
    int edge1 = halving_ball(h->frame[0], a, c1, &r1, &size1),
        edge2 = halving_ball(h->frame[1], b, c2, &r2, &size2);
    for (int k = 0; k < 3; k++)
        gap += (c1[k] - c2[k]) * (c1[k] - c2[k]);
    gap = sqrtl(gap) - r1 - r2;
    if (h->cells > h->most)
        return 0;
    if (gap >= 0.8L * fmaxl(size1, size2)) {
        h->cells++;
        return halving_product(h, a, b);
    }
    if (depth == HALVING_DEPTH)
        return 0;
    const halving_triangle *old = size1 >= size2 ? a : b;
    int p = size1 >= size2 ? edge1 : edge2, q = (p + 1) % 3, o = (p + 2) % 3;
    long double s = (old->s[p] + old->s[q]) / 2, t = (old->t[p] + old->t[q]) / 2, sum = 0;
    const halving_triangle half[2] = {{{old->s[p], s, old->s[o]}, {old->t[p], t, old->t[o]}},
                                      {{s, old->s[q], old->s[o]}, {t, old->t[q], old->t[o]}}};
    for (int i = 0; i < 2; i++)
        sum +=
            size1 >= size2 ? halving_sum(h, &half[i], b, depth + 1) : halving_sum(h, a, &half[i], depth + 1);
    return sum;
}

/* K^kl of two triangles; NAN if that takes more than `most` product rules. */
static inline double halving_entry(const hpr_element_frame *recv, const hpr_element_frame *send, size_t k,
                                   size_t l, int most)
{
    halving h = {.frame = {recv, send}, .k = {k, l}, .most = most};
    int degree = recv->degree > send->degree ? recv->degree : send->degree;
    const halving_triangle whole = {{0, 1, 0}, {0, 0, 1}};
    halving_normal(recv, h.normal[0]);
    halving_normal(send, h.normal[1]);
    halving_gauss(&h, 13 + degree / 2);
    long double sum = halving_sum(&h, &whole, &whole, 0);
    return h.cells > most ? NAN : (double)(sum * 2 * sqrtl((long double)recv->area_m2 * send->area_m2));
}

#endif
