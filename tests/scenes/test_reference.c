/*
 * hprad reference in the Cornell box against the estimator of the tests (path_estimate.h), which shares
 * nothing with it but the scene's arrays: no patches, no Embree, other random numbers. Two estimates at a
 * point of every patch, compared by both standard errors.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "patch/patches.h"
#include "path_estimate.h"
#include "traced.h"

#define PI 3.14159265358979323846

enum { PATCHES = 20, SIDE = 84, PIXELS = 8, PATHS = 110 };

/* Of 72 comparisons none is beyond this by chance but once in 1000 seeds (Bonferroni: 1e-3 / 72, two-sided).
 */
static const double most = 4.35;
/* Largest standard error of the difference, RMS over the points, relative to the RMS radiance. */
static const double error_bound = 0.01;

/* A camera 1 mm above the point, looking at it. */
static void look_at(hpr_scene *scene, const double point[3], const double normal[3], const double edge[3])
{
    hpr_camera camera = {
        .name = "near", .kind = HPR_CAMERA_ORTHOGRAPHIC, .xmag = 1e-6, .ymag = 1e-6, .zfar = INFINITY};
    double length = sqrt(edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]);
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        camera.origin[k] = point[k] + 1e-3 * normal[k];
        camera.backward[k] = normal[k];
        camera.right[k] = edge[k] / length;
        camera.up[k] = (normal[i] * edge[j] - normal[j] * edge[i]) / length;
    }
    assert_int_equal(hpr_scene_add_camera(scene, &camera), HPR_OK);
}

static size_t place_all(hpr_scene *scene, const hpr_patches *patches, double point[PATCHES][3])
{
    size_t first = scene->camera_count;
    assert_int_equal(patches->count, PATCHES);
    for (size_t i = 0; i < PATCHES; i++) {
        double s = 0.2 + 0.025 * (double)(i % 10), t = 0.65 - 0.025 * (double)(i % 7); /* s + t < 1.1 */
        if (patches->shape[i] != HPR_SHAPE_PARALLELOGRAM)
            t = fmin(t, 0.9 - s);
        for (size_t k = 0; k < 3; k++)
            point[i][k] =
                patches->origin[3 * i + k] + s * patches->edge1[3 * i + k] + t * patches->edge2[3 * i + k];
        look_at(scene, point[i], patches->normal + 3 * i, patches->edge1 + 3 * i);
    }
    return first;
}

/* Squares of difference, error and radiance over points and channels. */
typedef struct sums {
    double off, error, radiance, worst;
} sums;

static void compare(const hpr_patches *patches, size_t patch, const hpr_image *image,
                    const path_result *other, sums *s)
{
    for (size_t c = 0; c < 3; c++) {
        traced_estimate got = traced_mean_of(image, c);
        double rho = patches->reflectance[3 * patch + c], m = patches->exitance[3 * patch + c];
        double expected = (m + rho * other->mean[c]) / PI,
               error = hypot(got.error, rho * other->error[c] / PI);
        /* A lamp's own radiance is stored in single precision. */
        double off = fabs(got.mean - expected) / fmax(error, 1e-6 * expected);
        if (expected == 0)
            off = got.mean == 0 ? 0 : INFINITY;
        if (off > most)
            print_error("patch %zu, channel %zu: %.6g +- %.2g, the other %.6g\n", patch, c, got.mean,
                        got.error, expected);
        s->worst = fmax(s->worst, off);
        s->off += off * off / (3 * PATCHES);
        if (m > 0)
            continue; /* the lamp would outshine the rest */
        s->error += error * error;
        s->radiance += expected * expected;
    }
}

static void two_path_tracers_agree(void **state)
{
    (void)state;
    hpr_context *ctx = NULL;
    hpr_scene *scene = NULL;
    hpr_patches *patches = NULL;
    hpr_reference *reference = NULL;
    double point[PATCHES][3];
    sums s = {0};
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_int_equal(hpr_scene_read(ctx, HPRAD_SCENES "/cornell_box.gltf", NULL, &scene), HPR_OK);
    assert_int_equal(hpr_patches_build(scene, &patches), HPR_OK);
    size_t first = place_all(scene, patches, point);
    path_scene *paths = path_scene_create(scene);
    assert_int_equal(hpr_reference_create(ctx, scene, NULL, &reference), HPR_OK);
    for (size_t i = 0; i < PATCHES; i++) {
        const hpr_render_options film = {PIXELS, PIXELS, PATHS};
        hpr_image image;
        path_result other;
        assert_int_equal(hpr_reference_render(ctx, reference, first + i, &film, &image), HPR_OK);
        path_estimate(paths, point[i], patches->normal + 3 * i, SIDE, 1000 + i, &other);
        compare(patches, i, &image, &other, &s);
        hpr_image_fini(ctx, &image);
    }
    double error = sqrt(s.error / s.radiance);
    print_message(
        "%d points: at most %.2f standard errors apart, bound %g; RMS %.2f; standard error %.2f%%, bound "
        "%g%%\n",
        PATCHES, s.worst, most, sqrt(s.off), 100 * error, 100 * error_bound);
    path_scene_destroy(paths);
    hpr_reference_destroy(&reference);
    hpr_patches_destroy(&patches);
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&ctx);
    assert_true(s.worst <= most && error <= error_bound);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_path_tracers_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
