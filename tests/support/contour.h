/* View factors of polygons by Stokes' theorem: another integral than the blocks', in long double. */
#ifndef HPR_TESTS_CONTOUR_H
#define HPR_TESTS_CONTOUR_H

#include <math.h>
#include <stddef.h>

typedef struct contour_vec {
    long double x[3];
} contour_vec;

static inline contour_vec contour_point(const double *a)
{
    return (contour_vec){{a[0], a[1], a[2]}};
}

/* a + f b */
static inline contour_vec contour_add(contour_vec a, long double f, contour_vec b)
{
    return (contour_vec){{a.x[0] + f * b.x[0], a.x[1] + f * b.x[1], a.x[2] + f * b.x[2]}};
}

static inline long double contour_dot(contour_vec a, contour_vec b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static inline long double contour_length(contour_vec a)
{
    return sqrtl(contour_dot(a, a));
}

/* Primitive of ln sqrt(t^2 + d^2). */
static inline long double contour_primitive(long double t, long double d)
{
    long double r2 = t * t + d * d;
    return (r2 > 0 ? t * logl(r2) / 2 : 0) - t + (d > 0 ? d * atanl(t / d) : 0);
}

/* The integral of ln |x - y| over the y of the segment from q along the unit vector u. */
static inline long double contour_inner(contour_vec x, contour_vec q, contour_vec u, long double length)
{
    contour_vec from = contour_add(x, -1, q);
    long double along = contour_dot(from, u), d = contour_length(contour_add(from, -along, u));
    return contour_primitive(length - along, d) - contour_primitive(-along, d);
}

/* Of contour_inner over the x of p + s v, s from a to b; tanh-sinh, so that a and b may be singular. */
static inline long double contour_outer(contour_vec p, contour_vec v, long double a, long double b,
                                        contour_vec q, contour_vec u, long double length)
{
    const long double step = 1 / 32.0L, half_pi = acosl(0);
    long double sum = 0, half = (b - a) / 2;
    for (int k = -130; k <= 130; k++) {
        long double t = step * k, w = half_pi * sinhl(t), c = coshl(w);
        /* from the nearer end, where digits count */
        long double gap = half * expl(-fabsl(w)) / c, weight = half * half_pi * coshl(t) / (c * c);
        contour_vec x = contour_add(p, k < 0 ? a + gap : b - gap, v);
        sum += weight * contour_inner(x, q, u, length);
    }
    return sum * step;
}

/* The double integral of ln r over two segments; the outer one is cut where the inner one's ends are near. */
static inline long double contour_segments(contour_vec p, contour_vec p1, contour_vec q, contour_vec q1)
{
    contour_vec v = contour_add(p1, -1, p), u = contour_add(q1, -1, q);
    long double long_p = contour_length(v), long_q = contour_length(u), cut[4] = {0, 0, 0, long_p};
    for (int i = 0; i < 3; i++) {
        v.x[i] /= long_p;
        u.x[i] /= long_q;
    }
    long double f0 = contour_dot(contour_add(q, -1, p), v), f1 = contour_dot(contour_add(q1, -1, p), v);
    cut[1] = fminl(fmaxl(fminl(f0, f1), 0), long_p);
    cut[2] = fminl(fmaxl(fmaxl(f0, f1), 0), long_p);
    long double sum = 0;
    for (int i = 0; i < 3; i++) {
        if (cut[i + 1] > cut[i])
            sum += contour_outer(p, v, cut[i], cut[i + 1], q, u, long_q);
    }
    return sum;
}

/*
 * A1 F12 = 1/(2 pi) sum over edges e of 1, f of 2: (t_e . t_f) ∫_e ∫_f ln r dt ds, of polygons that lie
 * wholly in front of each other and of which nothing crosses. Counter-clockwise from the front. *error: some
 * 1e-18 times the sum of the terms. Source: Sparrow 1963.
 */
static inline double contour_exchange_within(int count1, const double (*corner1)[3], int count2,
                                             const double (*corner2)[3], double *error)
{
    long double sum = 0, size = 0;
    for (int i = 0; i < count1; i++) {
        contour_vec p = contour_point(corner1[i]), p1 = contour_point(corner1[(i + 1) % count1]);
        contour_vec v = contour_add(p1, -1, p);
        for (int j = 0; j < count2; j++) {
            contour_vec q = contour_point(corner2[j]), q1 = contour_point(corner2[(j + 1) % count2]);
            contour_vec u = contour_add(q1, -1, q);
            long double turn = contour_dot(v, u) / (contour_length(v) * contour_length(u));
            if (turn == 0)
                continue;
            long double term = turn * contour_segments(p, p1, q, q1);
            sum += term;
            size += fabsl(term);
        }
    }
    *error = (double)(size * 1e-18L / (4 * acosl(0)));
    return (double)(sum / (4 * acosl(0)));
}

static inline double contour_exchange(int count1, const double (*corner1)[3], int count2,
                                      const double (*corner2)[3])
{
    double error;
    return contour_exchange_within(count1, corner1, count2, corner2, &error);
}

#endif
