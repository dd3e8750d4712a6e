/* View factors of triangles by Lambert's formula over one of them, in long double: another rule than the
 * blocks'. */
#ifndef HPR_TESTS_LAMBERT_OUTER_H
#define HPR_TESTS_LAMBERT_OUTER_H

#include "contour.h"

static inline contour_vec lambert_cross(contour_vec a, contour_vec b)
{
    return (contour_vec){{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
                          a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

/* The part of what leaves a diffuse triangle per area that arrives at 0, times 2 pi. Source: Lambert 1760. */
static inline long double lambert_fraction(contour_vec normal, const contour_vec corner[3])
{
    long double sum = 0;
    for (int i = 0; i < 3; i++) {
        contour_vec a = corner[i], b = corner[(i + 1) % 3], across = lambert_cross(b, a);
        long double sine = contour_length(across);
        if (sine > 0)
            sum += atan2l(sine, contour_dot(a, b)) / sine * contour_dot(across, normal);
    }
    return sum;
}

/* Over the triangle apex, apex + to0, apex + to1: tanh-sinh along the rays from the apex, and across them. */
static inline long double lambert_sum(contour_vec to0, contour_vec to1, const contour_vec corner[3],
                                      int per_unit)
{
    enum { REACH = 4, MOST = 2 * REACH * 32 + 1 };
    static long double gap[MOST], weight[MOST]; /* from the nearer end */
    int n = REACH * per_unit;
    for (int k = -n; k <= n; k++) {
        long double t = (long double)k / per_unit, w = acosl(0) * sinhl(t), c = coshl(w);
        gap[k + n] = expl(-fabsl(w)) / c / 2;
        weight[k + n] = acosl(0) * coshl(t) / (c * c) / 2 / per_unit;
    }
    contour_vec normal = lambert_cross(to0, to1);
    long double area2 = contour_length(normal), sum = 0;
    for (int i = 0; i < 3; i++)
        normal.x[i] /= area2;
    for (int j = -n; j <= n; j++) {
        long double u1 = j < 0 ? gap[j + n] : 1 - gap[j + n], u0 = j < 0 ? 1 - gap[j + n] : gap[j + n];
        for (int k = -n; k <= n; k++) {
            contour_vec from[3];
            long double v = k < 0 ? gap[k + n] : 1 - gap[k + n];
            for (int i = 0; i < 3; i++)
                from[i] = contour_add(contour_add(corner[i], -v * u0, to0), -v * u1, to1);
            sum += weight[j + n] * weight[k + n] * v * lambert_fraction(normal, from);
        }
    }
    return sum * area2 / (4 * acosl(0));
}

/*
 * A1 F12 of triangles that lie wholly in front of each other and share at most one corner. *error: half the
 * step about squares the relative error, so that the difference's power of 1.5 is on the safe side.
 */
static inline double lambert_exchange(const double (*one)[3], const double (*two)[3], double *error)
{
    int apex = 0;
    long double nearest = INFINITY;
    for (int i = 0; i < 9; i++) {
        long double gap =
            contour_length(contour_add(contour_point(one[i / 3]), -1, contour_point(two[i % 3])));
        if (gap < nearest) {
            nearest = gap;
            apex = i / 3;
        }
    }
    contour_vec at = contour_point(one[apex]), corner[3];
    contour_vec to0 = contour_add(contour_point(one[(apex + 1) % 3]), -1, at);
    contour_vec to1 = contour_add(contour_point(one[(apex + 2) % 3]), -1, at);
    for (int i = 0; i < 3; i++)
        corner[i] = contour_add(contour_point(two[i]), -1, at);
    long double rough = lambert_sum(to0, to1, corner, 12), fine = lambert_sum(to0, to1, corner, 24);
    *error = (double)(fabsl(fine) * powl(fabsl(rough / fine - 1), 1.5L));
    return (double)fine;
}

#endif
