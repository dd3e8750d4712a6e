/* Clip or rays: by what it costs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "link/blocked.h"

static double planned(size_t pairs, double blockers, double asked)
{
    const hpr_blocked_load load = {
        .pair_count = pairs, .blocker_count = blockers, .area_m2 = 2, .asked = asked};
    hpr_blocked blocked = hpr_blocked_plan(&load);
    assert_true(blocked.area_m2 == 2);
    return blocked.tolerance;
}

/* With 0.5 / 0.07 blockers a point costs a microsecond: 1000 pairs of 4000 points take 4 s. */
static void many_pairs_are_clipped_less_exactly_and_then_not_at_all(void **state)
{
    (void)state;
    static const struct {
        size_t most;
        double tolerance;
    } steps[] = {{1000, 1e-6}, {12000, 1e-3}, {83333, 1e-2}, {160000, 3e-2}};
    const double blockers = 0.5 / 0.07;
    for (size_t i = 0; i < 4; i++) {
        assert_true(planned(steps[i].most - 1, blockers, 0) == steps[i].tolerance);
        assert_true(planned(steps[i].most + 1, blockers, 0) == (i < 3 ? steps[i + 1].tolerance : 0));
    }
}

/* A tenth of the tolerance of the others, rays counting as 0.03, but not below 1e-5. */
static void open_blocks_are_ten_times_as_exact(void **state)
{
    (void)state;
    static const struct {
        size_t pairs;
        double asked, expected;
    } cases[] = {
        {100, 0, 1e-5}, {5000, 0, 1e-4}, {50000, 0, 1e-3}, {1000000, 0, 3e-3}, {1000000, 1e-4, 1e-4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const hpr_blocked_load load = {
            .pair_count = cases[i].pairs, .blocker_count = 5, .area_m2 = 2, .asked = cases[i].asked};
        assert_float_equal(hpr_blocked_plan(&load).open_tolerance, cases[i].expected, 1e-12);
    }
}

static void blockers_cost_as_pairs_do(void **state)
{
    (void)state;
    assert_true(planned(40000, 5, 0) == 1e-2);
    assert_true(planned(40000, 100, 0) == 0);
}

static void what_is_asked_for_is_done(void **state)
{
    (void)state;
    assert_true(planned(10, 1, 0.01) == 0.01);
    assert_true(planned(10000000, 50, 1e-8) == 1e-8);
}

/* Squares of 1 m over each other. */
static hpr_block_task squares(double height, size_t blockers)
{
    return (hpr_block_task){
        .recv = {.edge1 = {1, 0, 0}, .edge2 = {0, 1, 0}, .normal = {0, 0, 1}, .area_m2 = 1},
        .send = {.origin = {0, 0, height},
                 .edge1 = {0, 1, 0},
                 .edge2 = {1, 0, 0},
                 .normal = {0, 0, -1},
                 .area_m2 = 1},
        .tolerance = 1e-5,
        .negligible = 1e-5,
        .blocker_count = blockers};
}

static void a_pair_in_the_open_is_left_alone(void **state)
{
    (void)state;
    const hpr_blocked blocked = {.tolerance = 1e-3, .area_m2 = 10};
    hpr_block_task task = squares(1, 0);
    hpr_blocked_decide(&blocked, 1, 1, &task);
    assert_true(!task.clip && task.tolerance == 1e-5 && task.negligible == 1e-5);
}

static void a_clipped_block_may_err_by_its_share(void **state)
{
    (void)state;
    const hpr_blocked blocked = {.tolerance = 1e-3, .area_m2 = 10};
    hpr_block_task task = squares(1, 3);
    hpr_blocked_decide(&blocked, 0.25, 1, &task);
    assert_true(task.clip && task.tolerance == 1e-3);
    assert_float_equal(task.negligible, 1e-3 * 0.5 / 10, 1e-18);
}

/* Past more blockers than a clip takes, or where the plan says so; what is near is clipped all the same. */
static void rays_are_for_what_is_costly(void **state)
{
    (void)state;
    const hpr_blocked clips = {.tolerance = 1e-3, .area_m2 = 10}, rays = {.tolerance = 0, .area_m2 = 10};
    const struct {
        const hpr_blocked *plan;
        double height;
        size_t blockers;
        bool clip;
    } cases[] = {{&clips, 1, HPR_CLIP_BLOCKERS, true},
                 {&clips, 1, HPR_CLIP_BLOCKERS + 1, false},
                 {&rays, 1, 3, false},
                 {&rays, 0.4, 3, true},
                 {&rays, 0.6, 3, false},
                 {&rays, 0.4, HPR_CLIP_BLOCKERS + 1, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_block_task task = squares(cases[i].height, cases[i].blockers);
        hpr_blocked_decide(cases[i].plan, 1, 1, &task);
        assert_true(task.clip == cases[i].clip);
        double tolerance = cases[i].clip && cases[i].plan == &clips ? 1e-3 : 0.03;
        assert_float_equal(task.negligible, tolerance / 10, 1e-18);
    }
}

/* Nothing blocks, but some of the receiver is covered: there is no ray to trace. */
static void parts_alone_are_clipped(void **state)
{
    (void)state;
    const hpr_blocked rays = {.tolerance = 0, .area_m2 = 10};
    const hpr_polygon part = {3, {{0, 0}, {1, 0}, {0, 1}}};
    hpr_block_task task = squares(1, 0);
    task.recv_part = &part;
    task.recv_part_count = 1;
    hpr_blocked_decide(&rays, 0.5, 1, &task);
    assert_true(task.clip && task.tolerance == 0.03);
}

/* Squares at a distance of 1: 1 / pi at most, of which one ray errs by half; far away 1 / (pi r^2), near 1.
 */
static void one_ray_spreads_by_half_the_block(void **state)
{
    (void)state;
    const double heights[] = {1, 10, 0.1}, most[] = {1 / 3.14159265358979324, 0.01 / 3.14159265358979324, 1};
    for (size_t i = 0; i < 3; i++) {
        hpr_block_task task = squares(heights[i], 1);
        assert_float_equal(hpr_blocked_spread(&task.recv, &task.send, 8), most[i] / 2 * sqrt(2.0 / 8), 1e-15);
    }
}

/* Rays go where they do most; where few do, clipping is not worth it. A tolerance that is not asked for has
 * none. */
static void small_blocks_get_few_rays(void **state)
{
    (void)state;
    hpr_block_task task = squares(10, 3);
    double spread = hpr_blocked_spread(&task.recv, &task.send, 10);
    const hpr_blocked_load load = {.pair_count = 9, .area_m2 = 10, .asked = 0.01, .spread = 16e-4 / spread};
    hpr_blocked blocked = hpr_blocked_plan(&load);
    assert_float_equal(blocked.rays * spread, 16, 1e-12);
    blocked.rays *= 0.99;
    hpr_blocked_decide(&blocked, 1, 1, &task);
    assert_true(!task.clip && task.ray_nodes == 2);
    assert_float_equal(task.tolerance, 0.5 / sqrt(0.99 * 16), 1e-12);
    blocked.rays *= 1.02;
    task = squares(10, 3);
    hpr_blocked_decide(&blocked, 1, 1, &task);
    assert_true(task.clip && task.ray_nodes == 0);
    const hpr_blocked_load unasked = {.pair_count = 9, .area_m2 = 10, .spread = 1};
    assert_true(hpr_blocked_plan(&unasked).rays == 0);
}

/* d^2 (A_r + A_s) / A */
static void errors_count_both_ways(void **state)
{
    (void)state;
    const hpr_blocked blocked = {.area_m2 = 10};
    hpr_block_task task = squares(1, 3);
    task.recv.area_m2 = 3;
    const hpr_block_result result = {.sampling_error = 0.2};
    assert_float_equal(hpr_blocked_error2(&blocked, &task, &result), 0.04 * 4 / 10, 1e-16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_pairs_are_clipped_less_exactly_and_then_not_at_all),
        cmocka_unit_test(open_blocks_are_ten_times_as_exact),
        cmocka_unit_test(blockers_cost_as_pairs_do),
        cmocka_unit_test(what_is_asked_for_is_done),
        cmocka_unit_test(a_pair_in_the_open_is_left_alone),
        cmocka_unit_test(a_clipped_block_may_err_by_its_share),
        cmocka_unit_test(rays_are_for_what_is_costly),
        cmocka_unit_test(parts_alone_are_clipped),
        cmocka_unit_test(one_ray_spreads_by_half_the_block),
        cmocka_unit_test(small_blocks_get_few_rays),
        cmocka_unit_test(errors_count_both_ways),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
