/* What several tests need: patches by hand, numbers by seed, an allocator that fails on request. */
#ifndef HPR_TEST_SHAPES_H
#define HPR_TEST_SHAPES_H

#include "math/vec3.h"
#include "patch/patches.h"

#include <stdlib.h>
#include <string.h>

/* cmocka.h needs these four before it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* splitmix64 (Steele, Lea & Flood 2014): the same numbers on every machine. */
static inline double shapes_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* Calloc that fails at call number `fail_at` (0 first; SIZE_MAX never) and counts what is alive. */
typedef struct shapes_allocator {
    size_t calls, fail_at, alive;
} shapes_allocator;

static inline void *shapes_allocate(void *user, size_t count, size_t size)
{
    shapes_allocator *a = user;
    if (a->calls++ == a->fail_at)
        return NULL;
    void *memory = calloc(count, size);
    a->alive += memory != NULL;
    return memory;
}

static inline void shapes_release(void *user, void *memory)
{
    shapes_allocator *a = user;
    a->alive -= memory != NULL;
    free(memory);
}

static inline hpr_context *shapes_context(int threads, shapes_allocator *allocator)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = threads;
    if (allocator) {
        options.allocate = shapes_allocate;
        options.release = shapes_release;
        options.user = allocator;
    }
    hpr_context *ctx = NULL;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    return ctx;
}

static inline hpr_patches *shapes_create(hpr_context *ctx, size_t count)
{
    hpr_patches *patches = NULL;
    assert_int_equal(hpr_patches_create(ctx, count, 1, &patches), HPR_OK);
    for (size_t i = 0; i < count; i++)
        patches->twin[i] = patches->material[i] = HPR_NONE;
    return patches;
}

/* Of a quadrilateral, patches->opposite must be there already. */
static inline void shapes_set(hpr_patches *patches, size_t i, hpr_shape shape, const double origin[3],
                              const double edge1[3], const double edge2[3])
{
    double across[3];
    hpr_cross3(edge1, edge2, across);
    double length = hpr_length3(across);
    for (int k = 0; k < 3; k++) {
        patches->origin[3 * i + k] = origin[k];
        patches->edge1[3 * i + k] = edge1[k];
        patches->edge2[3 * i + k] = edge2[k];
        patches->normal[3 * i + k] = across[k] / length;
    }
    patches->shape[i] = (uint8_t)shape;
    patches->area_m2[i] = length * hpr_shape_measure(shape, patches->opposite + 2 * i);
}

/* Makes patch j the back of patch i. */
static inline void shapes_twin(hpr_patches *patches, size_t i, size_t j)
{
    shapes_set(patches, j, (hpr_shape)patches->shape[i], patches->origin + 3 * i, patches->edge2 + 3 * i,
               patches->edge1 + 3 * i);
    patches->side[j] = 1;
    patches->twin[i] = (uint32_t)j;
    patches->twin[j] = (uint32_t)i;
}

/* The six sides of the box origin + [0,1] a + [0,1] b + [0,1] c (a, b, c right-handed) as patches first ...
 * first + 5, fronts inside (a room) or outside (a thing). */
static inline void shapes_box(hpr_patches *patches, size_t first, const double origin[3], const double a[3],
                              const double b[3], const double c[3], bool inside)
{
    const double *edge[3] = {a, b, c};
    for (size_t k = 0; k < 3; k++) {
        const double *e1 = edge[(k + 1) % 3], *e2 = edge[(k + 2) % 3];
        double far[3];
        hpr_add_scaled3(origin, 1, edge[k], far);
        /* e1 x e2 points along edge[k]: inward on the near side, outward on the far side */
        shapes_set(patches, first + 2 * k, HPR_SHAPE_PARALLELOGRAM, origin, inside ? e1 : e2,
                   inside ? e2 : e1);
        shapes_set(patches, first + 2 * k + 1, HPR_SHAPE_PARALLELOGRAM, far, inside ? e2 : e1,
                   inside ? e1 : e2);
    }
}

#endif
