/* Scenes for the tests of visibility, at several offsets and scales. */
#ifndef HPR_TEST_PLACES_H
#define HPR_TEST_PLACES_H

#include "shapes.h"
#include "visibility/visibility.h"

/* Where and how large a scene stands: x -> scale * x + offset. */
typedef struct place {
    double offset, scale;
} place;

static const place places[] = {{0, 1}, {1e3, 1}, {0, 1e-3}, {0, 1e3}, {1e3, 1e-3}};
enum { PLACE_COUNT = sizeof places / sizeof *places };

static inline void put(const place *p, const double x[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = p->scale * x[k] + p->offset;
}

static inline void random_point(uint64_t *seed, double low, double high, double point[3])
{
    for (int k = 0; k < 3; k++)
        point[k] = low + (high - low) * shapes_random(seed);
}

static inline void random_direction(uint64_t *seed, double direction[3])
{
    double length;
    do {
        random_point(seed, -1, 1, direction);
        length = hpr_length3(direction);
    } while (length > 1 || length < 0.1);
    for (int k = 0; k < 3; k++)
        direction[k] /= length;
}

static inline void set_quad(hpr_patches *patches, size_t i, double x, double y, double z,
                            const double edge1[3], const double edge2[3])
{
    shapes_set(patches, i, HPR_SHAPE_PARALLELOGRAM, (double[]){x, y, z}, edge1, edge2);
}

static const double ex[3] = {1, 0, 0}, ey[3] = {0, 1, 0}, ez[3] = {0, 0, 1};

static inline hpr_visibility *see(const hpr_patches *patches)
{
    hpr_visibility *visibility = NULL;
    assert_int_equal(hpr_visibility_create(patches, &visibility), HPR_OK);
    return visibility;
}

static inline hpr_facet facet_of(const hpr_patches *patches, size_t patch)
{
    hpr_facet facet;
    facet.corner_count = hpr_patch_corners(patches, patch, facet.corner);
    memcpy(facet.normal, patches->normal + 3 * patch, sizeof facet.normal);
    return facet;
}

static inline hpr_verdict classify(const hpr_visibility *visibility, const hpr_patches *patches, size_t a,
                                   size_t b, uint32_t *blockers, size_t *count)
{
    hpr_facet fa = facet_of(patches, a), fb = facet_of(patches, b);
    return hpr_visibility_classify(visibility, &fa, &fb, NULL, 0, blockers, count);
}

/* A unit room with its corner at the origin of the place, turned so that nothing is axis-parallel. */
static inline hpr_patches *turned_room(hpr_context *ctx, const place *p)
{
    hpr_patches *patches = shapes_create(ctx, 6);
    double a[3] = {0.8, 0.6, 0}, b[3] = {-0.48, 0.64, 0.6}, c[3] = {0.36, -0.48, 0.8}, origin[3];
    put(p, (double[]){0, 0, 0}, origin);
    for (int k = 0; k < 3; k++) {
        a[k] *= p->scale;
        b[k] *= p->scale;
        c[k] *= p->scale;
    }
    shapes_box(patches, 0, origin, a, b, c, true);
    return patches;
}

/* Boxes of random size and direction, their sides; then some free triangles. */
enum { BOX_COUNT = 12, FREE_COUNT = 28, RANDOM_COUNT = 6 * BOX_COUNT + FREE_COUNT };

static inline hpr_patches *random_scene(hpr_context *ctx, uint64_t *seed, const place *p)
{
    hpr_patches *patches = shapes_create(ctx, RANDOM_COUNT);
    for (size_t i = 0; i < BOX_COUNT + FREE_COUNT; i++) {
        double origin[3], a[3], b[3], c[3];
        random_point(seed, 0, 1, origin);
        put(p, origin, origin);
        random_direction(seed, a);
        random_direction(seed, c);
        if (i % 3 == 0) { /* axis-parallel, where boxes are thin and rays graze */
            memcpy(a, ex, sizeof a);
            memcpy(c, ey, sizeof c);
        }
        hpr_cross3(a, c, b);
        double length = hpr_length3(b);
        for (int k = 0; k < 3; k++)
            b[k] /= length;
        hpr_cross3(a, b, c);
        for (int k = 0; k < 3; k++) {
            a[k] *= p->scale * 0.3;
            b[k] *= p->scale * 0.4;
            c[k] *= p->scale * 0.2;
        }
        if (i < BOX_COUNT)
            shapes_box(patches, 6 * i, origin, a, b, c, false);
        else
            shapes_set(patches, 5 * BOX_COUNT + i, HPR_SHAPE_TRIANGLE, origin, a, b);
    }
    return patches;
}

static inline void point_on(const hpr_patches *patches, size_t i, double s, double t, double point[3])
{
    if (patches->shape[i] == HPR_SHAPE_TRIANGLE && s + t > 1) {
        s = 1 - s;
        t = 1 - t;
    }
    hpr_add_scaled3(patches->origin + 3 * i, s, patches->edge1 + 3 * i, point);
    hpr_add_scaled3(point, t, patches->edge2 + 3 * i, point);
}

static inline hpr_hit look_down(const hpr_visibility *visibility, double x, double y, double z, bool cull,
                                bool *back)
{
    return hpr_visibility_first_hit(visibility, (double[]){x, y, z}, (double[]){0, 0, -1}, 0, INFINITY, cull,
                                    back);
}

#endif
