/*
 * The Cornell box at the default order and subdivision against path tracing that shares no code with the
 * solution (tests/support/path_estimate.h): RMS error of irradiance over points on every patch. Few
 * points would not do: the error sits in the elements that straddle a block's foot, and among a hundred
 * points a single one next to it decides between 2% and 8%.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "path_estimate.h"
#include "rooms.h"
#include "solver/solution.h"

#include <omp.h>
#include <string.h>
#include <time.h>

enum { SPREAD = 600, PER_PATCH = 4, POINTS_MAX = 1000, SIDE = 140 };

/* Observed 0.25% with an estimate four times as good; here the estimate's own error adds to it. */
static const double bound = 0.006, error_bound = 0.005;

typedef struct sample {
    size_t patch;
    double point[3];
    path_result exact;
    double solved[PATH_CHANNELS];
    bool lit;
} sample;

/* splitmix64 */
static double random_unit(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void place(const hpr_patches *patches, size_t patch, uint64_t *seed, sample *at)
{
    double u = random_unit(seed), v = random_unit(seed), st[2];
    hpr_shape_uniform((hpr_shape)patches->shape[patch], patches->opposite + 2 * patch, u, v, st);
    *at = (sample){.patch = patch};
    for (size_t k = 0; k < 3; k++)
        at->point[k] = patches->origin[3 * patch + k] + st[0] * patches->edge1[3 * patch + k] +
                       st[1] * patches->edge2[3 * patch + k];
}

/* SPREAD points stratified by area over all patches, then PER_PATCH on each. */
static size_t place_all(const hpr_patches *patches, sample *points)
{
    uint64_t seed = 1;
    double total = 0, before = 0;
    size_t count = 0, patch = 0;
    for (size_t i = 0; i < patches->count; i++)
        total += patches->area_m2[i];
    for (int n = 0; n < SPREAD; n++) {
        double at = (n + random_unit(&seed)) / SPREAD * total;
        while (patch + 1 < patches->count && at >= before + patches->area_m2[patch])
            before += patches->area_m2[patch++];
        place(patches, patch, &seed, &points[count++]);
    }
    for (size_t i = 0; i < patches->count; i++) {
        for (int n = 0; n < PER_PATCH && count < POINTS_MAX; n++)
            place(patches, i, &seed, &points[count++]);
    }
    return count;
}

static double cpu_seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* sqrt(sum of squares) over lit points in [from, to): of the error, of the estimate's error, of irradiance.
 */
static void norms(const sample *points, size_t from, size_t to, int channel, double norm[3])
{
    norm[0] = norm[1] = norm[2] = 0;
    for (size_t i = from; i < to; i++) {
        if (!points[i].lit)
            continue;
        double off = points[i].solved[channel] - points[i].exact.mean[channel];
        norm[0] += off * off;
        norm[1] += points[i].exact.error[channel] * points[i].exact.error[channel];
        norm[2] += points[i].exact.mean[channel] * points[i].exact.mean[channel];
    }
    for (int k = 0; k < 3; k++)
        norm[k] = sqrt(norm[k]);
}

static void print_worst(const hpr_patches *patches, const sample *points, size_t count, double rms)
{
    double least = INFINITY;
    for (int n = 0; n < 5; n++) { /* by falling error */
        size_t best = count;
        double largest = -1;
        for (size_t i = 0; i < count; i++) {
            double off = fabs(points[i].solved[0] - points[i].exact.mean[0]);
            if (points[i].lit && off > largest && off < least) {
                largest = off;
                best = i;
            }
        }
        if (best == count)
            return;
        const sample *p = &points[best];
        least = largest;
        print_message("  patch %2zu (normal %.1f %.1f %.1f) at (%.4f, %.4f, %.4f): R %.4f, estimate %.4f +- "
                      "%.4f: %.1f%% of RMS\n",
                      p->patch, patches->normal[3 * p->patch], patches->normal[3 * p->patch + 1],
                      patches->normal[3 * p->patch + 2], p->point[0], p->point[1], p->point[2], p->solved[0],
                      p->exact.mean[0], p->exact.error[0], 100 * largest / rms);
    }
}

/* On the sides of the blocks, this high over the floor. */
static size_t place_at_feet(const hpr_patches *patches, double height, sample *points)
{
    static const double block_m2 = 0.08, floor_m = 1e-6;
    enum { ALONG = 3 };
    size_t count = 0;
    for (size_t i = 0; i < patches->count; i++) {
        double corner[4][3], foot[4][3];
        size_t corners = hpr_patch_corners(patches, i, corner), feet = 0;
        for (size_t k = 0; k < corners; k++) {
            if (corner[k][1] < floor_m)
                memcpy(foot[feet++], corner[k], sizeof *foot);
        }
        if (feet != 2 || patches->area_m2[i] > block_m2)
            continue;
        for (int n = 1; n <= ALONG; n++) {
            sample *at = &points[count++];
            *at = (sample){.patch = i};
            for (int k = 0; k < 3; k++)
                at->point[k] = foot[0][k] + n / (ALONG + 1.0) * (foot[1][k] - foot[0][k]);
            at->point[1] = height;
        }
    }
    return count;
}

static void evaluate(hpr_context *ctx, const hpr_solution *solution, const path_scene *paths, size_t side,
                     sample *points, size_t count)
{
    const hpr_patches *patches = solution->patches;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t i = 0; i < count; i++)
        path_estimate(paths, points[i].point, patches->normal + 3 * points[i].patch, side, i,
                      &points[i].exact);
    for (size_t i = 0; i < count; i++) {
        double radiosity[PATH_CHANNELS];
        uint32_t patch;
        assert_int_equal(hpr_solution_probe(ctx, solution, 1, points[i].point,
                                            patches->normal + 3 * points[i].patch, points[i].solved,
                                            radiosity, &patch),
                         HPR_OK);
        assert_int_equal(patch, points[i].patch);
    }
}

/* Where a block stands on the floor, each lights the other over a few millimetres, on which the floor's
 * direct light jumps. Relative to the irradiance there, which is a tenth of the room's. */
static int check_feet(hpr_context *ctx, const hpr_solution *solution, const path_scene *paths)
{
    enum { FEET_MAX = 32, FEET_SIDE = 200 };
    static const double height = 0.0015, feet_bound = 0.04, deviations = 3;
    sample points[FEET_MAX];
    size_t count = place_at_feet(solution->patches, height, points);
    double worst = 0, least = 0;
    assert_int_equal(count, 24);
    evaluate(ctx, solution, paths, FEET_SIDE, points, count);
    for (size_t i = 0; i < count; i++) {
        double exact = points[i].exact.mean[0], off = fabs(points[i].solved[0] - exact) / exact;
        double sure = off - deviations * points[i].exact.error[0] / exact;
        print_message("  foot %zu: %.4f, estimate %.4f +- %.4f\n", i, points[i].solved[0], exact,
                      points[i].exact.error[0]);
        worst = fmax(worst, off);
        least = fmax(least, sure);
    }
    print_message("at the blocks' feet: at most %.1f%% off, at least %.1f%%, bound %.1f%%\n", 100 * worst,
                  100 * least, 100 * feet_bound);
    return least > feet_bound;
}

/*
 * Points at which the polynomials are 4.5 to 7.7 % off in the first channel, the worst kinds of 5800: on the
 * floor near a block's foot, under the ceiling, over the floor. Gathered they were 0.1 to 1.2 % off an
 * estimate of 1000 x 1000 paths; this one has a standard error of 0.2 to 0.6 %.
 */
static int check_gathered(hpr_context *ctx, const hpr_solution *solution, const path_scene *paths)
{
    enum { COUNT = 4, HARD_SIDE = 500 };
    static const double bound = 0.025, plain_least = 0.03;
    static const double point[COUNT][3] = {{0.12315, 0, 0.06089},
                                           {0.07384, 0, 0.21459},
                                           {0.17528, 0.54865, 0.5592},
                                           {0, 0.00106, 0.16555}},
                        normal[COUNT][3] = {{0, 1, 0}, {0, 1, 0}, {0, 0, -1}, {1, 0, 0}};
    double plain[COUNT][PATH_CHANNELS], gathered[COUNT][PATH_CHANNELS], radiosity[COUNT][PATH_CHANNELS];
    uint32_t patch[COUNT];
    int failures = 0;
    assert_int_equal(
        hpr_solution_probe(ctx, solution, COUNT, point[0], normal[0], plain[0], radiosity[0], patch), HPR_OK);
    assert_int_equal(
        hpr_solution_gather(ctx, solution, COUNT, point[0], normal[0], gathered[0], radiosity[0], patch),
        HPR_OK);
    for (size_t i = 0; i < COUNT; i++) {
        path_result exact;
        path_estimate(paths, point[i], normal[i], HARD_SIDE, i, &exact);
        double off = fabs(gathered[i][0] / exact.mean[0] - 1), was = fabs(plain[i][0] / exact.mean[0] - 1);
        print_message("hard point %zu: polynomials %.2f%% off, gathered %.2f%%, standard error %.2f%%\n", i,
                      100 * was, 100 * off, 100 * exact.error[0] / exact.mean[0]);
        failures += !(off <= bound && was >= plain_least);
    }
    return failures;
}

static void irradiance_is_within_its_bound(void **state)
{
    (void)state;
    static sample points[POINTS_MAX];
    hpr_context *ctx = NULL;
    hpr_scene *scene = NULL;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_int_equal(hpr_scene_read(ctx, HPRAD_SCENES "/cornell_box.gltf", NULL, &scene), HPR_OK);
    double begin = cpu_seconds();
    assert_int_equal(hpr_solve(ctx, scene, NULL, &solution), HPR_OK);
    const hpr_solve_summary *summary = hpr_solution_summary(solution);
    print_message("order %d, subdivide %d: %zu elements, %zu DOFs, %.1f CPU s\n", summary->options.order,
                  summary->options.subdivide, summary->element_count, summary->dof_count,
                  cpu_seconds() - begin);
    const hpr_patches *patches = solution->patches;
    size_t count = place_all(patches, points), unlit = 0;
    path_scene *paths = path_scene_create(scene);
    assert_non_null(paths);
    begin = cpu_seconds();
    evaluate(ctx, solution, paths, SIDE, points, count);
    for (size_t i = 0; i < count; i++) {
        /* Under a block: no path finds any light. */
        points[i].lit = points[i].exact.mean[0] > 0;
        unlit += !points[i].lit;
    }
    print_message("%zu points, %zu of them under the blocks and skipped; %d paths each, %.1f CPU s\n", count,
                  unlit, SIDE * SIDE, cpu_seconds() - begin);
    int failures = 0;
    for (int c = 0; c < PATH_CHANNELS; c++) {
        double all[3], spread[3];
        norms(points, 0, count, c, all);
        norms(points, 0, SPREAD, c, spread);
        print_message("%s: RMS error %.2f%% of RMS irradiance (by area alone %.2f%%), bound %.1f%%; standard "
                      "error of the estimate %.2f%%, bound %.1f%%\n",
                      hpr_solution_channel_name(solution, (size_t)c), 100 * all[0] / all[2],
                      100 * spread[0] / spread[2], 100 * bound, 100 * all[1] / all[2], 100 * error_bound);
        failures += !(all[0] <= bound * all[2]) || !(all[1] <= error_bound * all[2]);
        if (c == 0)
            print_worst(patches, points, count, all[2] / sqrt((double)(count - unlit)));
    }
    /* The blocks cover a sixth of the floor, which is a seventh of the area: 2% of the points. */
    assert_true(unlit <= 30);
    failures += check_feet(ctx, solution, paths);
    failures += check_gathered(ctx, solution, paths);
    path_scene_destroy(paths);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&ctx);
    assert_int_equal(failures, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_is_within_its_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
