#include "shapes.h"

#include "patch/frame.h"
#include "render/camera.h"
#include "render/strata.h"
#include "solver/solution.h"

#include <hprad/render.h>

static const double pi = 3.14159265358979323846;
static const double zero[3] = {0, 0, 0}, ex[3] = {1, 0, 0}, ey[3] = {0, 1, 0};

/* A solution made by hand: constant H on each patch, one camera, one channel. Borrows the patches. */
static hpr_solution solution_of(hpr_context *ctx, hpr_patches *patches, hpr_camera *camera,
                                const double *irradiance)
{
    hpr_solution solution = {.summary.direct = HPR_DIRECT_GALERKIN, /* all of H in the coefficients */
                             .context = ctx,
                             .channel_count = 1,
                             .patches = patches,
                             .camera_count = 1,
                             .camera = camera};
    assert_int_equal(hpr_elements_uniform(patches, 0, 0, &solution.elements), HPR_OK);
    solution.irradiance = calloc(patches->count + 1, sizeof(double));
    for (size_t i = 0; irradiance && i < patches->count; i++)
        solution.irradiance[i] = irradiance[i] * sqrt(patches->area_m2[i]);
    return solution;
}

static void release(hpr_solution *solution)
{
    free(solution->irradiance);
    hpr_elements_destroy(&solution->elements);
    hpr_patches_destroy(&solution->patches);
}

/* At z = 2, looking down the z axis; a square picture shows -1 .. 1 at z = 0. */
static hpr_camera camera_at_two(void)
{
    hpr_camera camera = {.kind = HPR_CAMERA_PERSPECTIVE,
                         .origin = {0, 0, 2},
                         .right = {1, 0, 0},
                         .up = {0, 1, 0},
                         .backward = {0, 0, 1},
                         .yfov_rad = 2 * atan(0.5),
                         .znear = 0.01,
                         .zfar = INFINITY};
    return camera;
}

/* Quarters of the square -1 .. 1 at z = 0: 0 upper left, 1 upper right, 2 lower left, 3 lower right. */
static hpr_patches *quarters(hpr_context *ctx)
{
    hpr_patches *patches = shapes_create(ctx, 4);
    for (size_t i = 0; i < 4; i++) {
        shapes_set(patches, i, HPR_SHAPE_PARALLELOGRAM, (double[]){i % 2 ? 0 : -1, i / 2 ? -1 : 0, 0}, ex,
                   ey);
        patches->exitance[i] = pi * (double)(i + 1);
        patches->reflectance[i] = 0.5;
    }
    return patches;
}

static void default_size_and_samples(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
    hpr_render_options options;
    hpr_render_options_init(&options);
    assert_true(options.width == 0 && options.height == 0 && options.samples == 4);
    const struct {
        hpr_camera_kind kind;
        double aspect, xmag;
        int width, height, want_width, want_height;
    } cases[] = {
        {HPR_CAMERA_PERSPECTIVE, 0, 0, 0, 0, 512, 512},     {HPR_CAMERA_PERSPECTIVE, 1.5, 0, 0, 0, 768, 512},
        {HPR_CAMERA_PERSPECTIVE, 0.333, 0, 0, 0, 170, 512}, {HPR_CAMERA_ORTHOGRAPHIC, 9, 0.5, 0, 0, 256, 512},
        {HPR_CAMERA_PERSPECTIVE, 1.5, 0, 30, 0, 30, 20},    {HPR_CAMERA_PERSPECTIVE, 1.5, 0, 0, 10, 15, 10},
        {HPR_CAMERA_PERSPECTIVE, 1.5, 0, 12, 34, 12, 34},
    };
    options.samples = 1;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_image image;
        camera.kind = cases[i].kind;
        camera.aspect = cases[i].aspect;
        camera.xmag = cases[i].xmag;
        camera.ymag = 1;
        options.width = cases[i].width;
        options.height = cases[i].height;
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
        assert_int_equal(image.width, cases[i].want_width);
        assert_int_equal(image.height, cases[i].want_height);
        hpr_image_fini(ctx, &image);
        hpr_image_fini(ctx, &image);
    }
    release(&solution);
    hpr_context_destroy(&ctx);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
    const hpr_render_options bad[] = {{32769, 1, 1}, {1, 32769, 1}, {-1, 4, 1}, {4, -1, 1},
                                      {4, 4, 0},     {4, 4, 4097},  {4, 4, -3}, {0, 32768, 1}};
    camera.aspect = 1.01;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hpr_image image;
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &bad[i], &image), HPR_ERR_ARG);
        assert_null(image.radiance);
        assert_true(hpr_context_error(ctx)[0] != '\0');
    }
    hpr_image image;
    assert_int_equal(hpr_solution_render(ctx, &solution, 1, NULL, &image), HPR_ERR_ARG);
    release(&solution);
    hpr_context_destroy(&ctx);
}

/* Row 0 is the top, column 0 the left; a pixel is (M + rho H) / pi. */
static void pixels_show_radiance_in_place(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    const double irradiance[4] = {0, 2 * pi, -8 * pi, 4 * pi}; /* undershoot is shown as it is */
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, irradiance);
    const hpr_render_options options = {8, 8, 3};
    hpr_image image;
    for (int kind = 0; kind < 2; kind++) {
        camera.kind = kind ? HPR_CAMERA_ORTHOGRAPHIC : HPR_CAMERA_PERSPECTIVE;
        camera.xmag = camera.ymag = 1;
        uint64_t rays = hpr_counter_value(ctx, HPR_COUNT_CAMERA_RAYS);
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
        assert_int_equal(hpr_counter_value(ctx, HPR_COUNT_CAMERA_RAYS) - rays, 8 * 8 * 3);
        for (int row = 0; row < 8; row++) {
            for (int column = 0; column < 8; column++) {
                size_t patch = (size_t)(2 * (row / 4) + column / 4);
                double want = (double)(patch + 1) + 0.5 * irradiance[patch] / pi;
                double got = image.radiance[8 * row + column];
                if (fabs(got - want) > 4 * 0x1p-24 * fabs(want) || image.coverage[8 * row + column] != 1)
                    fail_msg("kind %d, row %d, column %d: %.9g, expected %.9g", kind, row, column, got, want);
            }
        }
        hpr_image_fini(ctx, &image);
    }
    release(&solution);
    hpr_context_destroy(&ctx);
}

static double mean_coverage(const hpr_image *image)
{
    double sum = 0;
    int pixels = image->width * image->height;
    for (int i = 0; i < pixels; i++)
        sum += image->coverage[i];
    return sum / pixels;
}

static void wide_and_narrow_pictures_keep_the_height(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
    const struct {
        int width, height;
        double covered;
    } cases[] = {{64, 32, 0.5}, {32, 64, 1}, {96, 32, 1.0 / 3}};
    for (int kind = 0; kind < 2; kind++) {
        camera.kind = kind ? HPR_CAMERA_ORTHOGRAPHIC : HPR_CAMERA_PERSPECTIVE;
        camera.xmag = 7; /* only for the default size */
        camera.ymag = 1;
        camera.aspect = 7;
        for (int i = 0; i < 3; i++) {
            hpr_image image;
            const hpr_render_options options = {cases[i].width, cases[i].height, 1};
            assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
            double covered = mean_coverage(&image);
            if (fabs(covered - cases[i].covered) > 1e-7) /* edges fall on pixel borders: float sums only */
                fail_msg("kind %d, case %d: coverage %.9g, expected %.9g", kind, i, covered,
                         cases[i].covered);
            hpr_image_fini(ctx, &image);
        }
    }
    release(&solution);
    hpr_context_destroy(&ctx);
}

/* znear and zfar are along the axis: a plate across the view is cut nowhere or everywhere. */
static void near_and_far_are_along_the_axis(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
    const double range[][3] = {{1.999, 2.001, 1}, {0.01, 1.999, 0}, {2.001, 9, 0}, {0.01, 2.001, 1}};
    for (int i = 0; i < 4; i++) {
        hpr_image image;
        const hpr_render_options options = {16, 16, 1};
        camera.znear = range[i][0];
        camera.zfar = range[i][1];
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
        assert_true(mean_coverage(&image) == range[i][2]);
        hpr_image_fini(ctx, &image);
    }
    release(&solution);
    hpr_context_destroy(&ctx);
}

static void backs_are_not_shown(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_patches *patches = quarters(ctx);
    shapes_set(patches, 1, HPR_SHAPE_PARALLELOGRAM, zero, ey, ex);
    hpr_solution solution = solution_of(ctx, patches, &camera, NULL);
    const hpr_render_options options = {4, 4, 1};
    hpr_image image;
    assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
    assert_true(image.coverage[0] == 1 && image.coverage[3] == 0 && image.radiance[3] == 0);
    assert_true(mean_coverage(&image) == 0.75);
    hpr_image_fini(ctx, &image);
    release(&solution);
    hpr_context_destroy(&ctx);
}

/* The coverage of a triangle whose edges run anywhere, and premultiplied radiance. */
static void edges_are_covered_in_part(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_camera camera = camera_at_two();
    hpr_patches *patches = shapes_create(ctx, 1);
    const double edge1[3] = {1.31, 0.23, 0}, edge2[3] = {0.37, 1.17, 0};
    shapes_set(patches, 0, HPR_SHAPE_TRIANGLE, (double[]){-0.61, -0.53, 0}, edge1, edge2);
    patches->exitance[0] = 3 * pi;
    hpr_solution solution = solution_of(ctx, patches, &camera, NULL);
    for (int samples = 1; samples <= 16; samples++) {
        const hpr_render_options options = {64, 64, samples};
        hpr_image image;
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
        double exact = patches->area_m2[0] / 4, covered = mean_coverage(&image);
        /* About 150 edge pixels; one uniform sample has a deviation of at most 1/2, so the mean's is below
         * sqrt(150) / 2 / 64^2 = 1.5e-3 over sqrt(samples), and stratification only lowers it. 4 sigma. */
        if (fabs(covered - exact) > 6e-3 / sqrt(samples))
            fail_msg("%d samples: coverage %.6f of %.6f", samples, covered, exact);
        for (int i = 0; i < 64 * 64; i++)
            assert_true(fabs(image.radiance[i] - 3 * (double)image.coverage[i]) <= 8 * 0x1p-24);
        hpr_image_fini(ctx, &image);
    }
    release(&solution);
    hpr_context_destroy(&ctx);
}

static void every_stratum_has_one_sample(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 300; n++) {
        hpr_strata strata = hpr_strata_of(n);
        if (strata.step == 0) {
            assert_int_equal(strata.columns * strata.rows, n);
            assert_true(strata.columns <= 2 * strata.rows);
        } else {
            assert_true(strata.columns == n && strata.rows == n);
        }
        uint8_t columns[300] = {0}, rows[300] = {0}, cells[300] = {0};
        for (uint32_t i = 0; i < n; i++) {
            double x, y;
            hpr_strata_place(&strata, i, &x, &y);
            assert_true(x > 0 && x < 1 && y > 0 && y < 1);
            columns[(uint32_t)(x * n)]++;
            rows[(uint32_t)(y * n)]++;
            if (!strata.step)
                cells[(uint32_t)(y * strata.rows) * strata.columns + (uint32_t)(x * strata.columns)]++;
        }
        for (uint32_t i = 0; i < n; i++) {
            if (columns[i] != 1 || rows[i] != 1 || (!strata.step && cells[i] != 1))
                fail_msg("%u samples: stratum %u is taken %d, %d, %d times", n, i, columns[i], rows[i],
                         cells[i]);
        }
    }
    hpr_strata four = hpr_strata_of(4), five = hpr_strata_of(5);
    assert_true(four.columns == 2 && four.rows == 2 && four.step == 0 && five.step == 3);
}

static hpr_patches *room(hpr_context *ctx, double offset, double scale)
{
    hpr_patches *patches = shapes_create(ctx, 6);
    double a[3] = {scale, 0, 0}, b[3] = {0, 2 * scale, 0}, c[3] = {0, 0, 3 * scale};
    shapes_box(patches, 0, (double[]){offset, offset, offset}, a, b, c, true);
    for (size_t i = 0; i < 6; i++) {
        patches->exitance[i] = (double)i;
        patches->reflectance[i] = 0.7;
    }
    return patches;
}

static void framing_camera_holds_every_corner(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    const double place[][2] = {{0, 1}, {1e3, 1}, {-5, 1e-3}, {7, 1e3}};
    for (int n = 0; n < 4; n++) {
        hpr_patches *patches = room(ctx, place[n][0], place[n][1]);
        hpr_camera camera;
        hpr_patches_frame(patches, &camera);
        assert_true(fabs(camera.yfov_rad - pi * 40 / 180) < 1e-15 && camera.znear > 0);
        /* right x up = backward, all of length 1 */
        double axis[3];
        hpr_cross3(camera.right, camera.up, axis);
        hpr_subtract3(axis, camera.backward, axis);
        assert_true(hpr_length3(axis) < 1e-15 && fabs(hpr_length3(camera.up) - 1) < 1e-15);
        double widest = 0;
        for (size_t i = 0; i < 6; i++) {
            double corner[4][3];
            size_t count = hpr_patch_corners(patches, i, corner);
            for (size_t c = 0; c < count; c++) {
                hpr_subtract3(corner[c], camera.origin, corner[c]);
                double depth = -hpr_dot3(corner[c], camera.backward);
                assert_true(depth > camera.znear && depth < camera.zfar);
                double half = depth * tan(camera.yfov_rad / 2);
                widest = fmax(widest, fabs(hpr_dot3(corner[c], camera.right)) / half);
                widest = fmax(widest, fabs(hpr_dot3(corner[c], camera.up)) / half);
            }
        }
        /* the border is 5%, up to the rounding of coordinates over the scene's size */
        if (fabs(widest - 1 / 1.05) > 1e-9)
            fail_msg("place %d: corners reach to %.12g of the picture", n, widest);
        /* from outside one looks through the culled walls into the room */
        hpr_solution solution = solution_of(ctx, patches, &camera, NULL);
        const hpr_render_options options = {32, 32, 1};
        hpr_image image;
        assert_int_equal(hpr_solution_render(ctx, &solution, 0, &options, &image), HPR_OK);
        double covered = mean_coverage(&image);
        assert_true(covered > 0.2 && covered < 0.95);
        hpr_image_fini(ctx, &image);
        release(&solution);
    }
    hpr_patches *none = shapes_create(ctx, 0);
    hpr_camera camera;
    hpr_patches_frame(none, &camera);
    assert_true(fabs(hpr_length3(camera.origin) - 1) < 1e-15 && camera.znear > 0);
    hpr_patches_destroy(&none);
    hpr_context_destroy(&ctx);
}

static void render_room(int threads, hpr_image *image, hpr_context **ctx)
{
    *ctx = shapes_context(threads, NULL);
    hpr_camera camera;
    hpr_patches *patches = room(*ctx, 3, 1);
    hpr_patches_frame(patches, &camera);
    const double irradiance[6] = {5, 4, 3, 2, 1, 0.1};
    hpr_solution solution = solution_of(*ctx, patches, &camera, irradiance);
    const hpr_render_options options = {97, 61, 5};
    assert_int_equal(hpr_solution_render(*ctx, &solution, 0, &options, image), HPR_OK);
    release(&solution);
}

static void threads_give_the_same_bits(void **state)
{
    (void)state;
    hpr_context *ctx, *other;
    hpr_image image, again;
    render_room(1, &image, &ctx);
    const int threads[] = {2, 7, 16};
    for (int i = 0; i < 3; i++) {
        render_room(threads[i], &again, &other);
        assert_memory_equal(image.radiance, again.radiance, sizeof(float) * 97 * 61);
        assert_memory_equal(image.coverage, again.coverage, sizeof(float) * 97 * 61);
        hpr_image_fini(other, &again);
        hpr_context_destroy(&other);
    }
    hpr_image_fini(ctx, &image);
    hpr_context_destroy(&ctx);
}

typedef struct watch {
    volatile sig_atomic_t cancel;
    double last, cancel_at;
    bool fell;
} watch;

static void on_progress(void *user, const char *stage, double fraction)
{
    watch *w = user;
    assert_string_equal(stage, "render");
    w->fell = w->fell || fraction < w->last;
    w->last = fraction;
    if (fraction >= w->cancel_at)
        w->cancel = 1;
}

static void progress_rises_and_cancelling_works(void **state)
{
    (void)state;
    for (int cancels = 0; cancels < 2; cancels++) {
        watch w = {.cancel_at = cancels ? 0.3 : 2};
        hpr_context_options options;
        hpr_context_options_init(&options);
        options.threads = 2;
        options.progress = on_progress;
        options.user = &w;
        options.cancel = &w.cancel;
        hpr_context *ctx = NULL;
        assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
        hpr_camera camera = camera_at_two();
        hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
        const hpr_render_options size = {16, 64, 1};
        hpr_image image;
        hpr_status status = hpr_solution_render(ctx, &solution, 0, &size, &image);
        assert_int_equal(status, cancels ? HPR_ERR_INTERRUPTED : HPR_OK);
        assert_true(cancels == (image.radiance == NULL));
        assert_true(!w.fell && w.last == 1);
        hpr_image_fini(ctx, &image);
        release(&solution);
        hpr_context_destroy(&ctx);
    }
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    shapes_allocator allocator = {.fail_at = SIZE_MAX};
    hpr_context *ctx = shapes_context(1, &allocator);
    hpr_camera camera = camera_at_two();
    hpr_solution solution = solution_of(ctx, quarters(ctx), &camera, NULL);
    size_t before = allocator.alive, failures = 0;
    for (size_t k = 0;; k++) {
        hpr_image image;
        const hpr_render_options options = {4, 4, 1};
        allocator.fail_at = allocator.calls + k;
        hpr_status status = hpr_solution_render(ctx, &solution, 0, &options, &image);
        hpr_image_fini(ctx, &image);
        assert_int_equal(allocator.alive, before);
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        failures++;
    }
    assert_true(failures >= 3 + 4); /* picture, scratch; visibility at least */
    allocator.fail_at = SIZE_MAX;
    release(&solution);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(default_size_and_samples),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(pixels_show_radiance_in_place),
        cmocka_unit_test(wide_and_narrow_pictures_keep_the_height),
        cmocka_unit_test(near_and_far_are_along_the_axis),
        cmocka_unit_test(backs_are_not_shown),
        cmocka_unit_test(edges_are_covered_in_part),
        cmocka_unit_test(every_stratum_has_one_sample),
        cmocka_unit_test(framing_camera_holds_every_corner),
        cmocka_unit_test(threads_give_the_same_bits),
        cmocka_unit_test(progress_rises_and_cancelling_works),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
