/* A solution of random content, sound all the same. */
#ifndef HPR_TESTS_RANDOM_SOLUTION_H
#define HPR_TESTS_RANDOM_SOLUTION_H

#include "io/solution_format.h"
#include "io_support.h"
#include "patch/paint.h"
#include "shapes.h"
#include "solver/solution.h"

static inline char *copy_of(hpr_context *ctx, const char *text)
{
    char *copy = hpr_duplicate_text(ctx, text);
    assert_non_null(copy);
    return copy;
}

static inline void *array_of(hpr_context *ctx, size_t count, size_t bytes)
{
    void *array = hpr_allocate(ctx, count, bytes);
    assert_non_null(array);
    return array;
}

/* A texture of 3 x 2 texels on patch 5, which patch 4 emits by. */
static inline void add_paint(hpr_patches *p)
{
    float texel[6 * 8];
    for (size_t i = 0; i < 6 * p->channel_count; i++)
        texel[i] = (float)i / 48;
    const hpr_texture texture = {.width = 3, .height = 2, .wrap = {HPR_WRAP_MIRROR}, .texel = texel};
    assert_true(p->channel_count <= 8);
    assert_int_equal(hpr_paint_create(p, 1, &texture), HPR_OK);
    p->paint->of_patch[5] = 0;
    p->paint->glow_of[4] = 0;
    for (size_t k = 0; k < 6; k++) {
        p->paint->map[6 * 5 + k] = 0.1 * (double)k - 0.2;
        p->paint->glow_map[6 * 4 + k] = 0.3 - 0.1 * (double)k;
    }
    for (size_t c = 0; c < p->channel_count; c++)
        p->paint->glow[p->channel_count * 4 + c] = 0.5 + (double)c;
    for (size_t k = 0; k < 3 * p->channel_count; k++)
        p->paint->tint[3 * p->channel_count * 5 + k] = 0.05 * (double)k;
}

static inline hpr_patches *random_patches(hpr_context *ctx, uint64_t *seed, size_t channels)
{
    enum { COUNT = 7 };
    hpr_patches *p = NULL;
    assert_int_equal(hpr_patches_create(ctx, COUNT, channels, &p), HPR_OK);
    p->opposite[12] = 1.4; /* of patch 6 */
    p->opposite[13] = 0.7;
    for (size_t i = 0; i < COUNT; i++) {
        double frame[9];
        for (int k = 0; k < 9; k++)
            frame[k] = 10 * random_unit(seed) - 5;
        frame[0] += 1e4; /* far from the origin */
        p->twin[i] = p->material[i] = HPR_NONE;
        if (i == 4)
            shapes_twin(p, 3, 4);
        else
            shapes_set(p, i,
                       i == 6  ? HPR_SHAPE_QUADRILATERAL
                       : i % 2 ? HPR_SHAPE_TRIANGLE
                               : HPR_SHAPE_PARALLELOGRAM,
                       frame, frame + 3, frame + 6);
        p->node[i] = (uint32_t)random_bits(seed);
        p->primitive[i] = (uint32_t)random_bits(seed);
        if (i > 2)
            p->material[i] = (uint32_t)i;
        for (size_t c = 0; c < channels; c++) {
            p->reflectance[i * channels + c] = random_unit(seed);
            p->exitance[i * channels + c] = i == 2 ? 100 * random_unit(seed) : 0;
        }
    }
    p->degenerate_count = 3;
    p->duplicate_count = 5;
    p->weld_m = 1.25e-7;
    add_paint(p);
    return p;
}

static inline void add_camera(hpr_solution *s, size_t i, const char *name, uint64_t *seed)
{
    hpr_camera *camera = s->camera + i;
    *camera =
        (hpr_camera){.name = copy_of(s->context, name), .right = {1}, .up = {0, 0, 1}, .backward = {0, -1}};
    for (int k = 0; k < 3; k++)
        camera->origin[k] = 10 * random_unit(seed);
    camera->kind = i % 2 ? HPR_CAMERA_ORTHOGRAPHIC : HPR_CAMERA_PERSPECTIVE;
    camera->yfov_rad = 1.0 / 3;
    camera->aspect = i == 2 ? 0 : 16.0 / 9;
    camera->xmag = 1.1;
    camera->ymag = 0.7;
    camera->znear = i == 2 ? 0 : 0.1;
    camera->zfar = i == 3 ? 100 : INFINITY;
}

static inline void fill_figures(hpr_solution *s, uint64_t *seed)
{
    size_t count;
    const hpr_field *fields = hpr_summary_fields(&count);
    for (size_t i = 0; i < count; i++) {
        char *at = (char *)&s->summary + fields[i].offset;
        double number = random_unit(seed) / 3;
        int whole = (int)(random_bits(seed) >> 40);
        size_t size = (size_t)(random_bits(seed) >> 20);
        if (fields[i].kind == HPR_FIELD_DOUBLE)
            memcpy(at, &number, sizeof number);
        else if (fields[i].kind == HPR_FIELD_INT)
            memcpy(at, &whole, sizeof whole);
        else
            memcpy(at, &size, sizeof size);
    }
    s->summary.residual = NAN;
    s->summary.environment = HPR_ENVIRONMENT_GALERKIN; /* all in the coefficients */
    s->energy = array_of(s->context, s->channel_count, sizeof *s->energy);
    for (size_t c = 0; c < s->channel_count; c++)
        s->energy[c] =
            (hpr_energy){random_unit(seed), random_unit(seed), random_unit(seed) * 1e-300, -0.0, INFINITY};
}

/* Trees of depth 2 `subdivide` with degrees 0 .. most, random numbers everywhere. */
static inline hpr_solution *random_solution(hpr_context *ctx, uint64_t seed, size_t channels, int subdivide,
                                            int most)
{
    static const char *const names[] = {"R", "G", "B", "infrared", "\xc3\xa9t\xc3\xa9"};
    hpr_solution *s = array_of(ctx, 1, sizeof *s);
    s->context = ctx;
    s->scene_name = copy_of(ctx, "scene \"1\".gltf");
    s->channel_count = channels;
    s->channel_name = array_of(ctx, channels, sizeof(char *));
    for (size_t c = 0; c < channels; c++)
        s->channel_name[c] = copy_of(ctx, names[c]);
    s->environment = array_of(ctx, channels, sizeof(double));
    for (size_t c = 0; c < channels; c++)
        s->environment[c] = random_unit(&seed) / 3;
    s->patches = random_patches(ctx, &seed, channels);
    assert_int_equal(hpr_elements_uniform(s->patches, 0, subdivide, &s->elements), HPR_OK);
    hpr_elements *e = s->elements;
    for (size_t i = 0; i < e->node_count; i++)
        e->degree[i] = (uint8_t)(random_bits(&seed) >> 8) % (uint8_t)(most + 1);
    assert_int_equal(hpr_elements_index(s->patches, e), HPR_OK);
    size_t dofs = e->dof[e->leaf_count];
    s->irradiance = array_of(ctx, dofs * channels, sizeof(double));
    for (size_t i = 0; i < dofs * channels; i++)
        s->irradiance[i] = 20 * random_unit(&seed) - 2;
    s->surroundings = array_of(ctx, s->patches->count * channels, sizeof(double));
    for (size_t i = 0; i < s->patches->count * channels; i++)
        s->surroundings[i] = random_unit(&seed) / 7;
    s->error = array_of(ctx, e->leaf_count, sizeof(double));
    for (size_t i = 0; i < e->leaf_count; i++) {
        uint64_t payload = 0x7ff8000000001234u + i; /* the payload of a NaN, too */
        memcpy(s->error + i, &payload, sizeof payload);
        if (i % 2)
            s->error[i] = random_unit(&seed);
    }
    s->camera_count = 4;
    s->camera = array_of(ctx, 4, sizeof *s->camera);
    const char *const cameras[] = {"front", "", "a/b \xe2\x9c\x93", "front"};
    for (size_t i = 0; i < 4; i++)
        add_camera(s, i, cameras[i], &seed);
    fill_figures(s, &seed);
    return s;
}

#endif
