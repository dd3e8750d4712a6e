/* Kernel blocks of elements given by their corners, and closed forms to compare them with. */
#ifndef HPR_TESTS_BLOCKS_H
#define HPR_TESTS_BLOCKS_H

#include "quadrature/block.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* What every block needs; one per test program. */
typedef struct block_bench {
    hpr_context *context;
    hpr_quadrature *quadrature;
    hpr_block_scratch *scratch;
} block_bench;

static block_bench bench;

static inline int bench_open(void **state)
{
    (void)state;
    return hpr_context_create(NULL, &bench.context) != HPR_OK ||
           hpr_quadrature_create(bench.context, &bench.quadrature) != HPR_OK ||
           hpr_block_scratch_create(bench.context, &bench.scratch) != HPR_OK;
}

static inline int bench_close(void **state)
{
    (void)state;
    hpr_block_scratch_destroy(&bench.scratch);
    hpr_quadrature_destroy(&bench.quadrature);
    hpr_context_destroy(&bench.context);
    return 0;
}

/* origin = first corner, edge1 towards the second, edge2 towards the last. */
static inline hpr_element_frame frame_of(hpr_shape shape, int degree, const double first[3],
                                         const double second[3], const double last[3])
{
    hpr_element_frame f = {.shape = shape, .degree = degree, .origin = hpr_vec3_load(first)};
    f.edge1 = hpr_sub(hpr_vec3_load(second), f.origin);
    f.edge2 = hpr_sub(hpr_vec3_load(last), f.origin);
    hpr_vec3 across = hpr_cross(f.edge1, f.edge2);
    double length = hpr_length(across);
    f.normal = hpr_scale(across, 1 / length);
    f.area_m2 = shape == HPR_SHAPE_TRIANGLE ? length / 2 : length;
    return f;
}

/* 3 or 4 corners, counter-clockwise from the front. */
static inline hpr_element_frame frame_of_corners(int degree, int count, const double (*corner)[3])
{
    return frame_of(count == 3 ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM, degree, corner[0], corner[1],
                    corner[count - 1]);
}

static inline size_t frame_basis(const hpr_element_frame *f)
{
    return hpr_basis_count(f->shape, f->degree);
}

static inline void stretch_box(const hpr_element_frame *f, hpr_vec3 *low, hpr_vec3 *high)
{
    for (int i = 0; i < 4; i++) {
        double s = i % 2, t = f->shape == HPR_SHAPE_TRIANGLE && i == 3 ? 0 : i / 2;
        hpr_vec3 p = hpr_frame_point(f, s, t);
        *low = (hpr_vec3){fmin(low->x, p.x), fmin(low->y, p.y), fmin(low->z, p.z)};
        *high = (hpr_vec3){fmax(high->x, p.x), fmax(high->y, p.y), fmax(high->z, p.z)};
    }
}

/* Judged as in a scene of just these two: the weld distance. */
static inline double pair_contact(const hpr_element_frame *a, const hpr_element_frame *b)
{
    hpr_vec3 low = a->origin, high = a->origin;
    stretch_box(a, &low, &high);
    stretch_box(b, &low, &high);
    return 4 * 0x1p-23 * fmax(fmax(high.x - low.x, high.y - low.y), high.z - low.z);
}

static inline hpr_block_result block_of(const hpr_element_frame *recv, const hpr_element_frame *send,
                                        double tolerance, double *block)
{
    hpr_block_task task = {
        .recv = *recv, .send = *send, .tolerance = tolerance, .contact_m = pair_contact(recv, send)};
    return hpr_block(bench.quadrature, &task, block, bench.scratch);
}

static inline double largest_entry(const double *block, size_t count)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, fabs(block[i]));
    return largest;
}

/* int_1 int_2 G, the sum of K^00 over pieces being comparable then. */
static inline double exchange_of(const hpr_element_frame *recv, const hpr_element_frame *send,
                                 double tolerance)
{
    hpr_element_frame a = *recv, b = *send;
    a.degree = b.degree = 0;
    double block;
    hpr_block_result result = block_of(&a, &b, tolerance, &block);
    assert_true(result.status < HPR_BLOCK_SHORT);
    return block * sqrt(a.area_m2 * b.area_m2);
}

/*
 * int_1 int_2 G of [x0,x1] x [y0,y1] in z = 0 and [u0,u1] x [v0,v1] in z = h, facing each other, and of
 * [x0,x1] x [y0,y1] in z = 0 and [u0,u1] x [y: v0,v1] in x = 0 (u along z), x0, u0 >= 0.
 * Source: Ehlert & Smith 1993. Alternating sums, in long double: they lose digits where the pair is far
 * apart.
 */
static inline long double corner_parallel(long double dx, long double dy, long double h)
{
    long double a = sqrtl(dx * dx + h * h), b = sqrtl(dy * dy + h * h);
    return (dy * a * atanl(dy / a) + dx * b * atanl(dx / b) - h * h / 2 * logl(dx * dx + dy * dy + h * h)) /
           (4 * acosl(0));
}

static inline long double corner_perpendicular(long double x, long double u, long double dy)
{
    long double q = x * x + u * u, c = sqrtl(q), r2 = q + dy * dy;
    long double angle = c > 0 ? dy * c * atanl(dy / c) : 0, part = r2 > 0 ? (q - dy * dy) / 4 * logl(r2) : 0;
    return (angle - part) / (4 * acosl(0));
}

static inline double exchange_parallel(const double x[2], const double y[2], const double u[2],
                                       const double v[2], double h)
{
    long double sum = 0;
    for (int i = 0; i < 16; i++) {
        int a = i & 1, b = i >> 1 & 1, c = i >> 2 & 1, d = i >> 3;
        sum += ((a + b + c + d) % 2 ? -1 : 1) *
               corner_parallel((long double)x[a] - u[c], (long double)y[b] - v[d], h);
    }
    return (double)sum;
}

static inline double exchange_perpendicular(const double x[2], const double y[2], const double u[2],
                                            const double v[2])
{
    long double sum = 0;
    for (int i = 0; i < 16; i++) {
        int a = i & 1, b = i >> 1 & 1, c = i >> 2 & 1, d = i >> 3;
        sum += ((a + b + c + d) % 2 ? -1 : 1) * corner_perpendicular(x[a], u[c], (long double)y[b] - v[d]);
    }
    return (double)sum;
}

#endif
