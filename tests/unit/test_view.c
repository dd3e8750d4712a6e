/* The parts of a view: filter, orbit, comparison. */
#include "shapes.h"

#include "render/filter.h"
#include "render/orbit.h"

#include <hprad/compare.h>

static const double pi = 3.14159265358979323846;

/*
 * Second moments about the pixel's centre: W² / 12 of the box; of the Gaussian cut off at 3 s,
 * s² (1 - 6 phi(3) / erf(3 / sqrt 2)) with phi the normal density. The strata's own error is of the order
 * 1/n².
 */
static void places_have_the_density_of_the_filter(void **state)
{
    (void)state;
    enum { N = 4096 };
    static double place[2 * N];
    double density = exp(-4.5) / sqrt(2 * pi);
    double kept = 1 - 6 * density / erf(3 / sqrt(2));
    const struct {
        hpr_filter filter;
        double width, support, variance;
    } cases[] = {{HPR_FILTER_BOX, 0, 1, 1.0 / 12},
                 {HPR_FILTER_BOX, 2.5, 2.5, 2.5 * 2.5 / 12},
                 {HPR_FILTER_GAUSSIAN, 0, 3, 0.25 * kept},
                 {HPR_FILTER_GAUSSIAN, 6, 6, kept}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_filter_places(cases[i].filter, cases[i].width, N, place);
        for (int axis = 0; axis < 2; axis++) {
            double mean = 0, square = 0;
            for (size_t k = 0; k < N; k++) {
                double x = place[2 * k + (size_t)axis] - 0.5;
                assert_true(fabs(x) < cases[i].support / 2);
                mean += x / N;
                square += x * x / N;
            }
            /* seen: 2e-12 and 8e-7 */
            if (fabs(mean) > 1e-9 || fabs(square - cases[i].variance) > 1e-5 * cases[i].variance)
                fail_msg("case %zu: mean %g, variance %.9g, expected %.9g", i, mean, square,
                         cases[i].variance);
        }
    }
}

static void an_orbit_keeps_height_and_distance(void **state)
{
    (void)state;
    const hpr_camera camera = {
        .origin = {3, 2, 1}, .right = {0, 0, 1}, .up = {0.6, 0.8, 0}, .backward = {-0.8, 0.6, 0}};
    const double centre[3] = {1, 5, -2};
    hpr_camera same = hpr_camera_orbit(&camera, centre, 0, 7),
               round = hpr_camera_orbit(&camera, centre, 7, 7);
    assert_memory_equal(&same, &camera, sizeof camera);
    assert_memory_equal(&round, &camera, sizeof camera);
    for (size_t k = 1; k < 7; k++) {
        hpr_camera turned = hpr_camera_orbit(&camera, centre, k, 7);
        double from = atan2(-(camera.origin[2] - centre[2]), camera.origin[0] - centre[0]);
        double to = atan2(-(turned.origin[2] - centre[2]), turned.origin[0] - centre[0]);
        double angle = remainder(to - from - 2 * pi * (double)k / 7, 2 * pi), axis[3];
        assert_true(fabs(angle) < 1e-14 && turned.origin[1] == camera.origin[1]);
        double distance = hypot(turned.origin[0] - 1, turned.origin[2] + 2);
        assert_true(fabs(distance - hypot(2, 3)) < 1e-14);
        hpr_cross3(turned.right, turned.up, axis);
        hpr_subtract3(axis, turned.backward, axis);
        assert_true(hpr_length3(axis) < 1e-14); /* still a right-handed frame */
    }
}

static void differences_are_measured(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    float picture[] = {1, 2, 3, 4}, other[] = {9, 9, 9, 9, 1, 2, 9, 3, 2}, covered[9] = {0};
    hpr_image image = {.width = 2,
                       .height = 2,
                       .left = 1,
                       .top = 1,
                       .full_width = 3,
                       .full_height = 3,
                       .channel_count = 1,
                       .radiance = picture,
                       .coverage = covered};
    hpr_image reference = {
        .width = 3, .height = 3, .channel_count = 1, .radiance = other, .coverage = covered};
    hpr_difference result;
    hpr_image difference;
    assert_int_equal(hpr_image_compare(ctx, &image, &reference, &result, &difference), HPR_OK);
    const float expected[] = {0, 0, 0, 2};
    assert_memory_equal(difference.radiance, expected, sizeof expected);
    assert_true(difference.left == 1 && difference.full_height == 3);
    assert_true(fabs(result.rmse - 1) < 1e-15 && fabs(result.rel_mse - 1 / 4.01) < 1e-15);
    assert_true(fabs(result.psnr_db - 20 * log10(3)) < 1e-13);
    hpr_image_fini(ctx, &difference);
    reference.full_width = reference.full_height = 4; /* another size */
    assert_int_equal(hpr_image_compare(ctx, &image, &reference, &result, &difference), HPR_ERR_ARG);
    reference.full_width = reference.full_height = 3;
    reference.width = reference.height = 2; /* a window that ends too early */
    assert_int_equal(hpr_image_compare(ctx, &image, &reference, &result, &difference), HPR_ERR_ARG);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_have_the_density_of_the_filter),
        cmocka_unit_test(an_orbit_keeps_height_and_distance),
        cmocka_unit_test(differences_are_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
