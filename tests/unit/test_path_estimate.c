/* The independent estimate that scenes are compared with, itself against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "path_estimate.h"
#include "rooms.h"

#include <string.h>

#define PI 3.14159265358979323846

/* Standard errors off; more than 4 in a fact of these few dozen is no chance. */
static const double most = 4;

static double check(const path_scene *scene, const double point[3], const double normal[3], double expected,
                    uint64_t seed, const char *what)
{
    path_result result;
    path_estimate(scene, point, normal, 64, seed, &result);
    double off = (result.mean[0] - expected) / result.error[0];
    if (!(fabs(off) <= most))
        fail_msg("%s at (%g, %g, %g): %g +- %g, expected %g: %.1f standard errors off", what, point[0],
                 point[1], point[2], result.mean[0], result.error[0], expected, off);
    return off;
}

/* H = M / (1 - rho) everywhere in a closed box, corners included. */
static void furnace(void **state)
{
    (void)state;
    static const double rho[] = {0.5, 0.9};
    static const double place[][2] = {{0.5, 0.5}, {0.1, 0.8}, {0.01, 0.3}, {0.001, 0.001}};
    for (int i = 0; i < 2; i++) {
        const double reflectance[6] = {rho[i], rho[i], rho[i], rho[i], rho[i], rho[i]};
        const double exitance[6] = {1, 1, 1, 1, 1, 1}, up[3] = {0, 0, 1};
        hpr_room room = room_open(1);
        room_add_box(&room, 1, 1, 1, reflectance, exitance, -1);
        path_scene *scene = path_scene_create(room.scene);
        double squares = 0, worst = 0, relative = 0;
        for (int p = 0; p < 4; p++) {
            for (uint64_t seed = 0; seed < 8; seed++) {
                const double point[3] = {place[p][0], place[p][1], 0};
                double off = check(scene, point, up, 1 / (1 - rho[i]), 8 * (uint64_t)p + seed, "furnace");
                squares += off * off / 32;
                worst = fmax(worst, fabs(off));
            }
        }
        path_result result;
        path_estimate(scene, (double[]){0.5, 0.5, 0}, up, 64, 1, &result);
        relative = result.error[0] * (1 - rho[i]);
        print_message("furnace, rho %g: worst %.2f standard errors of %.2f%%, bound %g; RMS %.2f\n", rho[i],
                      worst, 100 * relative, most, sqrt(squares));
        /* Strata make the true error smaller than the stated one; one that is far too wide would hide all. */
        assert_true(sqrt(squares) > 0.1 && relative < 0.02);
        path_scene_destroy(scene);
        room_close(&room);
    }
}

/* Lambert: irradiance at distance h under the corner of a parallel rectangle a x b of exitance 1. */
static double under_corner(double a, double b, double h)
{
    double x = a / h, y = b / h, p = sqrt(1 + x * x), q = sqrt(1 + y * y);
    return (x / p * atan(y / p) + y / q * atan(x / q)) / (2 * PI);
}

static void square_lamp(void **state)
{
    (void)state;
    static const double h[] = {2, 0.5, 0.05};
    const double up[3] = {0, 0, 1};
    for (int i = 0; i < 3; i++) {
        const double lamp[4][3] = {{0, 0, h[i]}, {0, 1, h[i]}, {1, 1, h[i]}, {1, 0, h[i]}};
        hpr_room room = room_open(1);
        room_add(&room, 4, lamp, 0, 3, false);
        path_scene *scene = path_scene_create(room.scene);
        double off[3];
        off[0] = check(scene, (double[]){0.5, 0.5, 0}, up, 12 * under_corner(0.5, 0.5, h[i]), 1, "centre");
        off[1] = check(scene, (double[]){0, 0, 0}, up, 3 * under_corner(1, 1, h[i]), 2, "corner");
        off[2] = check(scene, (double[]){2, 1, 0}, up,
                       3 * (under_corner(2, 1, h[i]) - under_corner(1, 1, h[i])), 3, "aside");
        print_message("lamp at %g: %.2f, %.2f, %.2f standard errors off, bound %g\n", h[i], off[0], off[1],
                      off[2], most);
        path_scene_destroy(scene);
        room_close(&room);
    }
}

/* A blocker takes half of the lamp away from the centre; single-sided it does so from behind as well; and a
 * lamp seen from behind gives nothing, unless it is double-sided. */
static void backs_block_and_are_black(void **state)
{
    (void)state;
    const double lamp[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const double facing_down[4][3] = {{-2, -2, 0.5}, {-2, 4, 0.5}, {0.5, 4, 0.5}, {0.5, -2, 0.5}};
    const double facing_up[4][3] = {{-2, -2, 0.5}, {0.5, -2, 0.5}, {0.5, 4, 0.5}, {-2, 4, 0.5}};
    const double point[3] = {0.5, 0.5, 0}, up[3] = {0, 0, 1}, above[3] = {0.5, 0.5, 2}, down[3] = {0, 0, -1};
    double half = 2 * under_corner(0.5, 0.5, 1), off[3];
    for (int i = 0; i < 2; i++) {
        hpr_room room = room_open(1);
        room_add(&room, 4, lamp, 0, 1, false);
        room_add(&room, 4, i ? facing_up : facing_down, 0, 0, false);
        path_scene *scene = path_scene_create(room.scene);
        off[i] = check(scene, point, up, half, 4, "half shade");
        path_result result;
        path_estimate(scene, above, down, 16, 5, &result);
        assert_true(result.mean[0] == 0);
        path_scene_destroy(scene);
        room_close(&room);
    }
    hpr_room room = room_open(1);
    room_add(&room, 4, lamp, 0, 1, true);
    path_scene *scene = path_scene_create(room.scene);
    off[2] = check(scene, above, down, 4 * under_corner(0.5, 0.5, 1), 6, "back of a doubleSided lamp");
    print_message("half shade %.2f, %.2f; back of a lamp %.2f standard errors off, bound %g\n", off[0],
                  off[1], off[2], most);
    path_scene_destroy(scene);
    room_close(&room);
}

static void same_seed_same_bits(void **state)
{
    (void)state;
    const double grey[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, light[6] = {0, 0, 0, 0, 0, 1};
    const double point[3] = {0.3, 0.6, 0}, up[3] = {0, 0, 1};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 1, 1, grey, light, -1);
    path_scene *scene = path_scene_create(room.scene);
    path_result a, b, c;
    path_estimate(scene, point, up, 16, 7, &a);
    path_estimate(scene, point, up, 16, 7, &b);
    path_estimate(scene, point, up, 16, 8, &c);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.mean[0] != c.mean[0] && a.mean[0] == a.mean[2]);
    path_scene_destroy(scene);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace),
        cmocka_unit_test(square_lamp),
        cmocka_unit_test(backs_block_and_are_black),
        cmocka_unit_test(same_seed_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
