/* The same bits for any number of threads: coefficients, energy terms and picture. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "solver/solution.h"

#include <hprad/render.h>
#include <stdlib.h>
#include <string.h>

typedef struct outcome {
    size_t value_count, pixel_count;
    double *irradiance;
    hpr_energy *energy; /* [3] */
    float *radiance;
} outcome;

static double *copy(const void *from, size_t bytes)
{
    double *to = malloc(bytes);
    assert_non_null(to);
    return memcpy(to, from, bytes);
}

static outcome run(const char *path, int threads, int order, int subdivide)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = threads;
    hpr_context *ctx = NULL;
    hpr_scene *scene = NULL;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    assert_int_equal(hpr_context_threads(ctx), threads);
    assert_int_equal(hpr_scene_read(ctx, path, NULL, &scene), HPR_OK);
    hpr_solve_options solve;
    hpr_solve_options_init(&solve);
    solve.order = order;
    solve.subdivide = subdivide;
    assert_int_equal(hpr_solve(ctx, scene, &solve, &solution), HPR_OK);
    hpr_render_options render;
    hpr_render_options_init(&render);
    render.width = render.height = 64;
    hpr_image image = {0};
    assert_int_equal(hpr_solution_render(ctx, solution, 0, &render, &image), HPR_OK);
    outcome o = {.value_count = hpr_solution_summary(solution)->dof_count * solution->channel_count,
                 .pixel_count = (size_t)image.width * (size_t)image.height * image.channel_count};
    assert_int_equal(solution->channel_count, 3);
    o.irradiance = copy(solution->irradiance, o.value_count * sizeof(double));
    o.energy = (hpr_energy *)copy(solution->energy, 3 * sizeof(hpr_energy));
    o.radiance = (float *)copy(image.radiance, o.pixel_count * sizeof(float));
    hpr_image_fini(ctx, &image);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&ctx);
    return o;
}

static void discard(outcome *o)
{
    free(o->irradiance);
    free(o->energy);
    free(o->radiance);
}

/* Number of differing bytes' places, counted in items. */
static size_t differing(const void *a, const void *b, size_t count, size_t size)
{
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
        found += memcmp((const char *)a + i * size, (const char *)b + i * size, size) != 0;
    return found;
}

static void check(const char *name, const char *path, int order, int subdivide)
{
    static const int threads[] = {2, 7};
    outcome one = run(path, 1, order, subdivide);
    double lit = 0;
    for (size_t i = 0; i < one.pixel_count; i++)
        lit += one.radiance[i] > 0;
    assert_true(lit > 0.1 * (double)one.pixel_count); /* else there would be nothing to compare */
    for (int t = 0; t < 2; t++) {
        outcome many = run(path, threads[t], order, subdivide);
        size_t coefficients = differing(one.irradiance, many.irradiance, one.value_count, sizeof(double));
        size_t terms = differing(one.energy, many.energy, 12, sizeof(double));
        size_t pixels = differing(one.radiance, many.radiance, one.pixel_count, sizeof(float));
        print_message(
            "%s, order %d, subdivide %d, 1 and %d threads: %zu of %zu coefficients, %zu of 12 energy "
            "terms, %zu of %zu pixel values differ\n",
            name, order, subdivide, threads[t], coefficients, one.value_count, terms, pixels,
            one.pixel_count);
        assert_int_equal(one.value_count, many.value_count);
        assert_int_equal(coefficients + terms + pixels, 0);
        discard(&many);
    }
    discard(&one);
}

static void cornell_box(void **state)
{
    (void)state;
    check("cornell_box", HPRAD_SCENES "/cornell_box.gltf", 1, 1);
}

static void furnace(void **state)
{
    (void)state;
    check("furnace_cube", HPRAD_SCENES "/furnace_cube.gltf", 3, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cornell_box),
        cmocka_unit_test(furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
