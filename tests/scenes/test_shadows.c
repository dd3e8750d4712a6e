/*
 * Visibility in whole scenes: what is closed stays dark, what is open agrees with path tracing, what nothing
 * blocks costs neither rays nor clips.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "path_estimate.h"
#include "rooms.h"
#include "solver/solution.h"

/* splitmix64 */
static double random_unit(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void nothing_blocks_in_a_convex_room(void **state)
{
    (void)state;
    static const double reflectance[6] = {0.1, 0.3, 0.5, 0.7, 0.2, 0.4}, exitance[6] = {1, 0, 0, 2, 0, 0};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 2, 1.5, reflectance, exitance, -1);
    hpr_solution *solution = room_solve(&room, 2, 1);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_RAYS), 0);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_CLIPS), 0);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_PAIRS_PARTIAL), 0);
    assert_true(hpr_counter_value(room.context, HPR_COUNT_PAIRS_VISIBLE) > 0);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* A vertex of the small box: turned about its middle and rounded to float32, so that no face of it is exactly
 * a parallelogram, nor exactly planar. */
static void turned(double x, double y, double z, double corner[3])
{
    static const double angle = 0.3, middle = 1.5;
    double u = x - middle, v = y - middle;
    corner[0] = (float)(middle + u * cos(angle) - v * sin(angle));
    corner[1] = (float)(middle + u * sin(angle) + v * cos(angle));
    corner[2] = (float)z;
}

/* A room of 4 x 4 x 3 m; in it a doubleSided box of 1 m on the floor with a lamp inside. Its lid is pushed
 * aside by `gap` of its width. */
static hpr_room lamp_in_a_box(double gap)
{
    static const double reflectance[6] = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7}, dark[6] = {0};
    static const double box[6][4][3] = {
        {{1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}}, {{1, 1, 0}, {1, 1, 1}, {1, 2, 1}, {1, 2, 0}},
        {{2, 1, 0}, {2, 2, 0}, {2, 2, 1}, {2, 1, 1}}, {{1, 1, 0}, {2, 1, 0}, {2, 1, 1}, {1, 1, 1}},
        {{1, 2, 0}, {1, 2, 1}, {2, 2, 1}, {2, 2, 0}}, {{1, 1, 1}, {2, 1, 1}, {2, 2, 1}, {1, 2, 1}}};
    static const double lamp[4][3] = {{1.3, 1.3, 0.5}, {1.7, 1.3, 0.5}, {1.7, 1.7, 0.5}, {1.3, 1.7, 0.5}};
    hpr_room room = room_open(1);
    room_add_box(&room, 4, 4, 3, reflectance, dark, -1);
    for (int face = 0; face < 6; face++) {
        double corner[4][3];
        for (int i = 0; i < 4; i++)
            turned(box[face][i][0] + (face == 5 ? gap : 0), box[face][i][1], box[face][i][2], corner[i]);
        room_add(&room, 4, (const double(*)[3])corner, 0.5, 0, true);
    }
    room_add(&room, 4, lamp, 0, 30, false);
    return room;
}

/* Points spread over the ceiling and two walls. */
static void outer_point(uint64_t *seed, int i, double point[3], double normal[3])
{
    double a = random_unit(seed), b = random_unit(seed);
    const double at[3][3] = {{4 * a, 4 * b, 3}, {4 * a, 0, 3 * b}, {0, 4 * a, 3 * b}};
    const double facing[3][3] = {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
    for (int k = 0; k < 3; k++) {
        point[k] = at[i % 3][k];
        normal[k] = facing[i % 3][k];
    }
}

static void a_closed_box_lets_no_light_out(void **state)
{
    (void)state;
    hpr_room room = lamp_in_a_box(0);
    hpr_solution *solution = room_solve(&room, 2, 1);
    uint64_t seed = 5;
    for (int i = 0; i < 300; i++) {
        double point[3], normal[3];
        outer_point(&seed, i, point, normal);
        assert_true(room_radiosity(&room, solution, point, normal) == 0);
    }
    const double inside[3] = {1.5, 1.5, 1}, down[3] = {0, 0, -1};
    assert_true(room_radiosity(&room, solution, inside, down) > 1);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* The sum over points outside: single ones lie within their noise, which is not normal here. */
static void a_lid_open_by_a_hundredth_agrees_with_paths(void **state)
{
    (void)state;
    enum { POINTS = 24, SIDE = 300 };
    static const double deviations = 4, most_error = 0.05;
    hpr_room room = lamp_in_a_box(0.01);
    hpr_solution *solution = room_solve(&room, 2, 2);
    path_scene *paths = path_scene_create(room.scene);
    uint64_t seed = 9;
    double solved = 0, estimated = 0, variance = 0;
    for (int i = 0; i < POINTS; i++) {
        double point[3], normal[3], irradiance[3], radiosity[3];
        uint32_t patch;
        path_result result;
        outer_point(&seed, i, point, normal);
        assert_int_equal(
            hpr_solution_probe(room.context, solution, 1, point, normal, irradiance, radiosity, &patch),
            HPR_OK);
        path_estimate(paths, point, normal, SIDE, (uint64_t)i, &result);
        solved += irradiance[0];
        estimated += result.mean[0];
        variance += result.error[0] * result.error[0];
    }
    print_message("sum of irradiance: %.6g, by paths %.6g +- %.2g\n", solved, estimated, sqrt(variance));
    assert_true(sqrt(variance) <= most_error * estimated);
    assert_true(fabs(solved - estimated) <= deviations * sqrt(variance));
    path_scene_destroy(paths);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* A room of 4 x 4 x 3 m that a wall of two faces, back to back `thickness` apart, divides; a lamp at the
 * ceiling of one half. */
static void check_thin_wall(double thickness)
{
    static const double reflectance[6] = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7}, dark[6] = {0};
    static const double lamp[4][3] = {{0.5, 1.5, 2.9}, {0.5, 2.5, 2.9}, {1.5, 2.5, 2.9}, {1.5, 1.5, 2.9}};
    static const double at = 1.9, balance_bound = 1e-4; /* observed 3e-6 */
    const double left[4][3] = {{at, 0, 0}, {at, 0, 3}, {at, 4, 3}, {at, 4, 0}};
    const double right[4][3] = {
        {at + thickness, 0, 0}, {at + thickness, 4, 0}, {at + thickness, 4, 3}, {at + thickness, 0, 3}};
    hpr_room room = room_open(1);
    room_add_box(&room, 4, 4, 3, reflectance, dark, -1);
    room_add(&room, 4, left, 0.6, 0, false);
    room_add(&room, 4, right, 0.6, 0, false);
    room_add(&room, 4, lamp, 0.5, 60, false);
    hpr_solution *solution = room_solve(&room, 1, 1);
    uint64_t seed = 3;
    for (int i = 0; i < 50; i++) {
        double y = 4 * random_unit(&seed), z = 3 * random_unit(&seed);
        const double lit[3] = {at, y, z}, unlit[3] = {at + thickness, y, z}, beyond[3] = {4, y, z};
        const double to_left[3] = {-1, 0, 0}, to_right[3] = {1, 0, 0};
        assert_true(room_radiosity(&room, solution, lit, to_left) > 1);
        assert_true(room_radiosity(&room, solution, unlit, to_right) == 0);
        assert_true(room_radiosity(&room, solution, beyond, to_left) == 0);
    }
    const hpr_energy *energy = hpr_solution_energy(solution);
    double balance = energy->emitted - energy->absorbed - energy->lost_on_backs - energy->escaped;
    print_message("thickness %g: balance %.1e of what is emitted (bound %.0e)\n", thickness,
                  balance / energy->emitted, balance_bound);
    assert_true(fabs(balance) <= balance_bound * energy->emitted);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* 1e-6 is within the weld distance: the faces are in one plane then. */
static void a_thin_wall_has_two_sides(void **state)
{
    (void)state;
    check_thin_wall(0);
    check_thin_wall(1e-6);
    check_thin_wall(1e-3);
}

/* Its bottom lies on the floor and lights nothing. */
static void a_lamp_emits_where_nothing_covers_it(void **state)
{
    (void)state;
    static const double reflectance[6] = {0.7, 0.7, 0.7, 0.7, 0.7, 0.7}, dark[6] = {0};
    static const double bottom[4][3] = {{1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}};
    static const double balance_bound = 1e-4; /* observed 3e-6 */
    hpr_room room = room_open(1);
    room_add_box(&room, 4, 4, 3, reflectance, dark, -1);
    room_add(&room, 4, bottom, 0.8, 3, false);
    for (int i = 0; i < 4; i++) {
        const double *p = bottom[(i + 1) % 4], *q = bottom[i];
        const double side[4][3] = {{p[0], p[1], 0}, {q[0], q[1], 0}, {q[0], q[1], 0.6}, {p[0], p[1], 0.6}};
        room_add(&room, 4, side, 0.8, 3, false);
    }
    const double top[4][3] = {{1, 1, 0.6}, {2, 1, 0.6}, {2, 2, 0.6}, {1, 2, 0.6}};
    room_add(&room, 4, top, 0.8, 3, false);
    hpr_solution *solution = room_solve(&room, 1, 1);
    const hpr_energy *energy = hpr_solution_energy(solution);
    double balance = energy->emitted - energy->absorbed - energy->lost_on_backs - energy->escaped;
    print_message("emitted %.15g, balance %.1e of it (bound %.0e)\n", energy->emitted,
                  balance / energy->emitted, balance_bound);
    assert_true(fabs(energy->emitted - 3 * (1 + 4 * 0.6)) <= 1e-12);
    assert_true(fabs(balance) <= balance_bound * energy->emitted);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_blocks_in_a_convex_room),
        cmocka_unit_test(a_closed_box_lets_no_light_out),
        cmocka_unit_test(a_lid_open_by_a_hundredth_agrees_with_paths),
        cmocka_unit_test(a_thin_wall_has_two_sides),
        cmocka_unit_test(a_lamp_emits_where_nothing_covers_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
