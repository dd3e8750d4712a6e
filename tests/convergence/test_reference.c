/*
 * Path tracing against closed forms, with the standard error that it states itself. Seeds are fixed, so a run
 * that passes passes always; the bound of 4 standard errors is missed by chance once in 16000 facts. Every
 * fact also fixes how large the standard error may be: else noise would agree with anything.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "traced.h"

#define PI 3.14159265358979323846

static const double most = 4;

/* The relative standard error must be within `error`. */
static void compare_channel(const hpr_image *image, size_t channel, double expected, double error,
                            const char *what)
{
    traced_estimate got = traced_mean_of(image, channel);
    double off = (got.mean - expected) / got.error;
    print_message("%s: %.6g +- %.2g, expected %.6g: %.2f standard errors off, bound %g; relative standard "
                  "error %.3f%%, bound %g%%\n",
                  what, got.mean, got.error, expected, off, most, 100 * got.error / expected, 100 * error);
    if (!(fabs(off) <= most && got.error <= error * expected))
        fail_msg("%s", what);
}

static void compare(const hpr_image *image, double expected, double error, const char *what)
{
    compare_channel(image, 0, expected, error, what);
}

static hpr_room cube(int threads, double reflectance, double exitance)
{
    const double rho[6] = {reflectance, reflectance, reflectance, reflectance, reflectance, reflectance};
    const double m[6] = {exitance, exitance, exitance, exitance, exitance, exitance};
    hpr_room room = room_open(threads);
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    traced_look_along_x(&room, 0.125, 0.25, 0.375);
    return room;
}

/* L = Le / (1 - rho) everywhere in a closed room. */
static void furnace(void **state)
{
    (void)state;
    hpr_room room = cube(2, 0.5, PI);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 32, .samples = 256});
    compare(&image, 2, 1e-3, "furnace, rho 0.5");
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

static void furnace_that_hardly_absorbs(void **state)
{
    (void)state;
    hpr_room room = cube(2, 0.999, PI);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 16});
    compare(&image, 1000, 0.04, "furnace, rho 0.999");
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* Each channel has its own; the path goes on by the strongest. */
static void coloured_furnace(void **state)
{
    (void)state;
    const double rho[3] = {0.2, 0.5, 0.8}, radiance[3] = {1, 3, 0.5}, corner[3] = {0};
    const double axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    hpr_room room = room_open(2);
    traced_add_cube(&room, corner, axis, rho, radiance);
    traced_look_along_x(&room, 0.125, 0.25, 0.375);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 32, .samples = 64});
    for (size_t c = 0; c < 3; c++)
        compare_channel(&image, c, radiance[c] / (1 - rho[c]), 4e-3, "coloured furnace");
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* No point is in its plane exactly: a path must neither stop at the wall that it leaves nor pass the next. */
static void tilted_furnace_far_from_the_origin(void **state)
{
    (void)state;
    const double rho[3] = {0.5, 0.5, 0.5}, radiance[3] = {1, 1, 1}, corner[3] = {1000.1, -2000.2, 500.3};
    const double third = 1.0 / 3;
    const double axis[3][3] = {
        {2 * third, 2 * third, third}, {-2 * third, third, 2 * third}, {third, -2 * third, 2 * third}};
    hpr_room room = room_open(2);
    traced_add_cube(&room, corner, axis, rho, radiance);
    traced_look_along_x(&room, corner[0] + 0.2, corner[1] + 0.2, corner[2] + 0.8);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 32, .samples = 256});
    for (size_t i = 0; i < 1024; i++)
        assert_true(image.coverage[i] == 1);
    compare(&image, 2, 1e-3, "tilted furnace");
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* Fraction of the rectangle a x b at height h that a horizontal surface element under its corner sees. */
static double under_corner(double a, double b, double h)
{
    double p = sqrt(a * a + h * h), q = sqrt(b * b + h * h);
    return (a / p * atan(b / p) + b / q * atan(a / q)) / (2 * PI);
}

/* A unit lamp in z = 1 over a floor of rho 0.5; below its middle H = 4 M under_corner(1/2, 1/2, 1). */
static void lamp_of(void (*add)(hpr_room *room), double error, const char *what)
{
    const double floor[4][3] = {{-2, -2, 0}, {3, -2, 0}, {3, 3, 0}, {-2, 3, 0}};
    hpr_room room = room_open(2);
    room_add(&room, 4, floor, 0.5, 0, false);
    add(&room);
    traced_look_down(&room, 0.5, 0.5, 0.5, 1e-6);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 1024});
    compare(&image, 0.5 * 4 * under_corner(0.5, 0.5, 1) * 3 / PI, error, what);
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

static void add_square_lamp(hpr_room *room)
{
    const double lamp[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    room_add(room, 4, lamp, 0, 3, false);
}

static void square_lamp(void **state)
{
    (void)state;
    lamp_of(add_square_lamp, 2e-3, "square lamp");
}

static void add_triangles(hpr_room *room)
{
    const double one[3][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}}, two[3][3] = {{0, 0, 1}, {1, 1, 1}, {1, 0, 1}};
    room_add(room, 3, one, 0, 3, false);
    room_add(room, 3, two, 0, 3, false);
}

static void triangular_lamps(void **state)
{
    (void)state;
    lamp_of(add_triangles, 2e-3, "two triangles");
}

/* 19 lamps far away have most of the power, one near has its back turned; they supply less than 1e-9. */
static void add_many(hpr_room *room)
{
    add_square_lamp(room);
    for (int i = 0; i < 19; i++) {
        double x = 1e4 + 10 * i;
        const double far[4][3] = {{x, 0, 1}, {x, 1, 1}, {x + 1, 1, 1}, {x + 1, 0, 1}};
        room_add(room, 4, far, 0, 3, false);
    }
    const double away[4][3] = {{0, 0, 1.5}, {1, 0, 1.5}, {1, 1, 1.5}, {0, 1, 1.5}};
    room_add(room, 4, away, 0, 1, false);
}

static void a_weak_lamp_among_many(void **state)
{
    (void)state;
    lamp_of(add_many, 1e-2, "one near lamp among 21");
}

/* The back of a doubleSided lamp shines as its front does: from above as lamp_of from below. */
static void double_sided_lamp(void **state)
{
    (void)state;
    const double lamp[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const double ceiling[4][3] = {{-2, -2, 2}, {-2, 3, 2}, {3, 3, 2}, {3, -2, 2}};
    hpr_room room = room_open(2);
    room_add(&room, 4, lamp, 0, 3, true);
    room_add(&room, 4, ceiling, 0.5, 0, false);
    traced_look_up(&room, 0.5, 0.5, 1.5, 1e-6);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 1024});
    compare(&image, 0.5 * 4 * under_corner(0.5, 0.5, 1) * 3 / PI, 2e-3, "above a doubleSided lamp");
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* Reference case occ_square_centre (scenes/README.md, blocked_plates): the top emits M = 1, a black square
 * 0.5 x 0.5 is halfway; direct irradiance of the bottom. */
static void lamp_behind_a_blocker(void **state)
{
    (void)state;
    static const double expected[][3] = {
        {0.25, 0.25, 0.104630061835206475}, {0.3, 0.6, 0.0667340199555804208}, {0.5, 0.5, 0}};
    const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double top[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const double blocker[4][3] = {{0.25, 0.25, 0.5}, {0.75, 0.25, 0.5}, {0.75, 0.75, 0.5}, {0.25, 0.75, 0.5}};
    hpr_room room = room_open(2);
    room_add(&room, 4, bottom, 0.5, 0, false);
    room_add(&room, 4, top, 0, 1, false);
    room_add(&room, 4, blocker, 0, 0, true);
    for (size_t i = 0; i < 3; i++)
        traced_look_down(&room, expected[i][0], expected[i][1], 0.25, 1e-6);
    for (size_t i = 0; i < 2; i++) {
        hpr_image image = traced(&room, i, (traced_setting){.side = 8, .samples = 2048});
        compare(&image, 0.5 * expected[i][2] / PI, 5e-3, "behind a blocker");
        hpr_image_fini(room.context, &image);
    }
    hpr_image dark = traced(&room, 2, (traced_setting){.side = 8, .samples = 64});
    assert_true(traced_mean(&dark).mean == 0);
    hpr_image_fini(room.context, &dark);
    room_close(&room);
}

/* Nothing absorbs, but light escapes: as finite as any. Against the Galerkin solution at the bottom's middle
 * (order 8; its own error is below 1e-8). */
static void plates_that_absorb_nothing(void **state)
{
    (void)state;
    const double middle[3] = {0.5, 0.5, 0}, up[3] = {0, 0, 1};
    hpr_room room = room_open(2);
    room_add_plates(&room, 1, 1, 1);
    traced_look_down(&room, 0.5, 0.5, 0.5, 1e-6);
    hpr_solution *solution = room_solve(&room, 8, 0);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 512});
    compare(&image, room_radiosity(&room, solution, middle, up) / PI, 2e-3, "plates, rho 1");
    hpr_image_fini(room.context, &image);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* RMS difference from L = 2 in the furnace. */
static double furnace_error(int samples, uint64_t seed)
{
    hpr_room room = cube(2, 0.5, PI);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 24, .samples = samples, .seed = seed});
    double squares = 0;
    for (size_t i = 0; i < 576; i++)
        squares += pow((double)image.radiance[3 * i] - 2, 2);
    hpr_image_fini(room.context, &image);
    room_close(&room);
    return sqrt(squares / 576);
}

/* The RMS over 576 pixels is itself known to 3% (Gaussian) or 4% (8 paths have tails), the rate over a factor
 * of 64 to 0.05 / ln 64 = 0.012; bound: four times that. */
static void error_falls_as_one_over_the_root(void **state)
{
    (void)state;
    double coarse = furnace_error(8, 1), middle = furnace_error(64, 2), fine = furnace_error(512, 3);
    double rate = log(fine / coarse) / log(64);
    print_message("RMS error %.3g, %.3g, %.3g with 8, 64, 512 paths: N^%.3f, expected N^-0.5 within 0.05\n",
                  coarse, middle, fine, rate);
    assert_true(fabs(rate + 0.5) <= 0.05);
    assert_true(middle < coarse && fine < middle);
}

enum { SEEDS = 64, SIDE = 8, PIXELS = SIDE * SIDE };

/* Mean and squares of every pixel over many seeds, and the mean of what the layer says. */
typedef struct spread {
    double mean[PIXELS], variance[PIXELS], stated[PIXELS];
} spread;

static void measure_spread(hpr_room *room, int samples, spread *s)
{
    *s = (spread){0};
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        hpr_image image =
            traced(room, 0, (traced_setting){.side = SIDE, .samples = samples, .seed = 100 + seed});
        for (size_t i = 0; i < PIXELS; i++) {
            double value = (double)image.radiance[3 * i], off = value - s->mean[i];
            s->mean[i] += off / (double)(seed + 1);
            s->variance[i] += off * (value - s->mean[i]) / (SEEDS - 1);
            s->stated[i] += (double)image.variance[3 * i] / SEEDS;
        }
        hpr_image_fini(room->context, &image);
    }
}

/*
 * What the layer says is the variance of a pixel's mean over seeds. Both are summed over the pixels: 64 x 63
 * degrees of freedom know a variance to sqrt(2 / 4032) = 2.2% if the noise is Gaussian; a pixel is the mean
 * of 16 paths whose excess kurtosis is a few, which makes it 2.5% at most; bound: 4 times that.
 */
static void the_layer_is_the_variance_over_seeds(void **state)
{
    (void)state;
    static const int samples[] = {2, 16};
    hpr_room room = cube(2, 0.5, PI);
    for (int k = 0; k < 2; k++) {
        spread s;
        double measured = 0, stated = 0;
        measure_spread(&room, samples[k], &s);
        for (size_t i = 0; i < PIXELS; i++) {
            measured += s.variance[i] / PIXELS;
            stated += s.stated[i] / PIXELS;
        }
        print_message("%d paths: variance %.4g over %d seeds, %.4g stated; ratio %.3f, bound 1 +- 0.1\n",
                      samples[k], measured, SEEDS, stated, stated / measured);
        assert_true(fabs(stated / measured - 1) <= 0.1);
    }
    room_close(&room);
}

static void a_seed_changes_the_noise_and_not_the_mean(void **state)
{
    (void)state;
    hpr_room room = cube(2, 0.8, PI);
    hpr_image a = traced(&room, 0, (traced_setting){.side = 32, .samples = 32, .seed = 7});
    hpr_image b = traced(&room, 0, (traced_setting){.side = 32, .samples = 32, .seed = 8});
    size_t same = 0;
    double products = 0;
    for (size_t i = 0; i < 1024; i++) {
        same += a.radiance[3 * i] == b.radiance[3 * i];
        products += ((double)a.radiance[3 * i] - 5) * ((double)b.radiance[3 * i] - 5);
    }
    traced_estimate one = traced_mean(&a), two = traced_mean(&b);
    double off = (one.mean - two.mean) / hypot(one.error, two.error);
    /* Independent noise: the products sum to 0 +- sqrt(1024) times the product of the pixels' errors. */
    double correlation = products / 1024 / (1024 * one.error * two.error);
    print_message(
        "%zu of 1024 pixels agree; means %.2f standard errors apart, bound %g; correlation %.3f, bound "
        "%.3f\n",
        same, off, most, correlation, most / 32);
    assert_int_equal(same, 0);
    assert_true(fabs(off) <= most && fabs(correlation) <= most / 32);
    hpr_image_fini(room.context, &a);
    hpr_image_fini(room.context, &b);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace),
        cmocka_unit_test(furnace_that_hardly_absorbs),
        cmocka_unit_test(coloured_furnace),
        cmocka_unit_test(tilted_furnace_far_from_the_origin),
        cmocka_unit_test(square_lamp),
        cmocka_unit_test(triangular_lamps),
        cmocka_unit_test(a_weak_lamp_among_many),
        cmocka_unit_test(double_sided_lamp),
        cmocka_unit_test(lamp_behind_a_blocker),
        cmocka_unit_test(plates_that_absorb_nothing),
        cmocka_unit_test(error_falls_as_one_over_the_root),
        cmocka_unit_test(the_layer_is_the_variance_over_seeds),
        cmocka_unit_test(a_seed_changes_the_noise_and_not_the_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
