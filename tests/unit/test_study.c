/* Studies: which runs there are, what an error is, and rows that are found again. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "app/study_error.h"
#include "app/study_grid.h"
#include "app/study_table.h"
#include "failing_allocator.h"
#include "rooms.h"

static hpr_job_study_options small_study(void)
{
    static const int orders[] = {0, 2}, subdivisions[] = {1, 2};
    hpr_job_study_options options;
    hpr_job_study_options_init(&options);
    options.order_count = options.subdivide_count = 2;
    options.order = orders;
    options.subdivide = subdivisions;
    return options;
}

static size_t plan(const hpr_job_study_options *options, char text[256])
{
    hpr_context *ctx;
    hpr_study_run *run;
    size_t count, length = 0;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_int_equal(hpr_study_plan(ctx, options, &count, &run), HPR_OK);
    text[0] = 0;
    for (size_t i = 0; i < count; i++)
        length += (size_t)snprintf(text + length, 256 - length, "%d%d%d ", run[i].order, run[i].subdivide,
                                   run[i].grade);
    hpr_release(ctx, run);
    hpr_context_destroy(&ctx);
    return count;
}

/* As order, subdivision, grading. */
static void runs_are_planned_once_each(void **state)
{
    (void)state;
    char text[256];
    hpr_job_study_options options = small_study();
    assert_int_equal(plan(&options, text), 4);
    assert_string_equal(text, "010 020 210 220 ");
    options.refine = HPR_STUDY_P;
    plan(&options, text);
    assert_string_equal(text, "010 210 ");
    options.refine = HPR_STUDY_HP;
    plan(&options, text);
    assert_string_equal(text, "010 212 ");
    options.refine = HPR_STUDY_H | HPR_STUDY_P | HPR_STUDY_HP; /* order 0 without grading is one of h */
    plan(&options, text);
    assert_string_equal(text, "010 020 210 220 212 ");
    const hpr_method methods[] = {HPR_METHOD_HEMICUBE, HPR_METHOD_GALERKIN};
    const hpr_direct_mode directs[] = {HPR_DIRECT_EXACT, HPR_DIRECT_GALERKIN};
    options.refine = HPR_STUDY_H;
    options.method = methods;
    options.direct = directs;
    options.method_count = options.direct_count = 2;
    assert_int_equal(plan(&options, text), 2 + 2 * 4);
}

/* Adaptive runs come behind those of each kind of direct light, without order and subdivision. */
static void tolerances_add_adaptive_runs(void **state)
{
    (void)state;
    char text[256];
    static const double tolerances[] = {0.1, 0.01, 0.1}, large[] = {1};
    hpr_job_study_options options = small_study();
    options.tolerance_count = 3;
    options.tolerance = tolerances;
    assert_int_equal(plan(&options, text), 6);
    assert_string_equal(text, "010 020 210 220 -1-10 -1-10 ");
    options.adapt = HPR_STUDY_H | HPR_STUDY_P;
    assert_int_equal(plan(&options, text), 8);
    hpr_context *ctx;
    hpr_study_run *run;
    size_t count;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_int_equal(hpr_study_plan(ctx, &options, &count, &run), HPR_OK);
    assert_true(run[4].adapt == HPR_REFINE_H && run[4].tolerance == 0.1 && run[5].tolerance == 0.01);
    assert_true(run[6].adapt == HPR_REFINE_P && run[3].tolerance == 0);
    hpr_release(ctx, run);
    const hpr_method exact = HPR_METHOD_EXACT;
    options.method = &exact;
    assert_int_equal(hpr_study_plan(ctx, &options, &count, &run), HPR_ERR_ARG);
    options = small_study();
    options.tolerance_count = 1;
    options.tolerance = large;
    assert_int_equal(hpr_study_plan(ctx, &options, &count, &run), HPR_ERR_ARG);
    hpr_context_destroy(&ctx);
}

static hpr_yardstick_points points_of(int subdivide, int per_edge)
{
    static const double probe[2][3] = {{0.25, 0.5, 0}, {7, 7, 7}}, normal[2][3] = {{0, 0, 1}, {0, 0, 1}};
    return (hpr_yardstick_points){.subdivide = subdivide,
                                  .per_edge = per_edge,
                                  .probe_count = 2,
                                  .probe = probe[0],
                                  .probe_normal = normal[0]};
}

/* A room with triangles too; everything 1 % brighter is off by 0.01 in every sense. */
static void an_error_of_one_percent_is_one(void **state)
{
    (void)state;
    const double roof[3][3] = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    hpr_room room = room_open(2);
    room_add_plates(&room, 1.5, 0.5, 1);
    room_add(&room, 3, roof, 0.3, 0, false);
    hpr_solution *truth = room_solve_direct(&room, 2, 1, HPR_DIRECT_GALERKIN),
                 *other = room_solve_direct(&room, 2, 1, HPR_DIRECT_GALERKIN);
    const hpr_yardstick_points points = points_of(2, 4);
    hpr_yardstick y;
    hpr_study_row row;
    double area = 0, integral2 = 0, coefficients2 = 0;
    assert_int_equal(hpr_yardstick_init(truth, &points, &y), HPR_OK);
    for (size_t i = 0; i < y.count; i++) {
        area += y.weight[i];
        integral2 += y.weight[i] * y.value[3 * i] * y.value[3 * i];
    }
    assert_true(fabs(area - 2.5) < 1e-13); /* two squares and half of one */
    for (size_t i = 0; i < truth->summary.dof_count; i++)
        coefficients2 += truth->irradiance[3 * i] * truth->irradiance[3 * i];
    assert_true(fabs(integral2 / coefficients2 - 1) < 1e-13); /* Parseval */
    assert_int_equal(hpr_yardstick_measure(&y, other, &row), HPR_OK);
    assert_true(row.error_l1 == 0 && row.error_l2 == 0 && row.error_linf == 0 && row.error_points == 0 &&
                row.error_points_l2 == 0);
    for (size_t i = 0; i < 3 * truth->summary.dof_count; i++)
        other->irradiance[i] *= 1.01;
    assert_int_equal(hpr_yardstick_measure(&y, other, &row), HPR_OK);
    const double errors[] = {row.error_l1,     row.error_l2,        row.error_linf,
                             row.error_points, row.error_points_l2, row.error_face_means};
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++)
        assert_true(fabs(errors[i] - 0.01) < 1e-12);
    hpr_solution_destroy(&other);
    hpr_yardstick_fini(&y);
    hpr_solution_destroy(&truth);
    room_close(&room);
}

/* One channel that is off counts, the others do not dilute it. */
static void the_worst_channel_counts(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    room_add_plates(&room, 1.5, 0.5, 1);
    hpr_solution *truth = room_solve_direct(&room, 1, 0, HPR_DIRECT_GALERKIN),
                 *other = room_solve_direct(&room, 1, 0, HPR_DIRECT_GALERKIN);
    const hpr_yardstick_points points = points_of(0, 3);
    hpr_yardstick y;
    hpr_study_row row;
    assert_int_equal(hpr_yardstick_init(truth, &points, &y), HPR_OK);
    for (size_t i = 0; i < truth->summary.dof_count; i++)
        other->irradiance[3 * i + 1] *= 1.1;
    assert_int_equal(hpr_yardstick_measure(&y, other, &row), HPR_OK);
    assert_true(fabs(row.error_l2 - 0.1) < 1e-12 && fabs(row.error_face_means - 0.1) < 1e-12);
    hpr_solution_destroy(&other);
    hpr_yardstick_fini(&y);
    hpr_solution_destroy(&truth);
    room_close(&room);
}

static const hpr_study_labels labels = {"a \"b\", c.gltf", "order 3", "x=1"};
static const hpr_study_run wanted = {HPR_METHOD_RAYCAST, HPR_DIRECT_GALERKIN, 0, 2, 0, 0, HPR_REFINE_HP};

/* What is written is found, with all its digits and what is not known; what differs is not. */
static void rows_are_found_again(void **state)
{
    (void)state;
    char path[] = "/tmp/hprad_study_XXXXXX", text[8192] = "";
    int file = mkstemp(path);
    assert_true(file >= 0);
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    hpr_study_row rows[2] = {{.run = {.order = 3}}, {.run = wanted}}, found;
    rows[1].error_l2 = 0.1;
    rows[1].order_l2 = NAN;
    rows[1].dofs = 96;
    const hpr_study_table table = {labels, 2, rows};
    assert_int_equal(hpr_study_write_csv(ctx, &table, path), HPR_OK);
    FILE *stream = fopen(path, "r");
    assert_non_null(stream);
    assert_true(fread(text, 1, sizeof text - 1, stream) > 0);
    fclose(stream);
    remove(path);
    bool there;
    hpr_study_find(&labels, &wanted, text, &found, &there);
    assert_true(there);
    assert_true(found.error_l2 == 0.1 && isnan(found.order_l2) && found.dofs == 96);
    hpr_study_run other = wanted;
    other.subdivide = 3;
    hpr_study_find(&labels, &other, text, &found, &there);
    assert_false(there);
    const hpr_study_labels others = {labels.scene, labels.truth, "x=2"};
    hpr_study_find(&others, &wanted, text, &found, &there);
    assert_false(there);
    hpr_study_run adaptive = wanted;
    adaptive.tolerance = 0.1;
    hpr_study_find(&labels, &adaptive, text, &found, &there);
    assert_false(there);
    text[strlen(text) - 1] = 0; /* a last line that was cut */
    hpr_study_find(&labels, &wanted, text, &found, &there);
    assert_false(there);
    hpr_context_destroy(&ctx);
}

static hpr_status plan_and_measure(hpr_context *ctx, void *data)
{
    const hpr_job_study_options options = small_study();
    const hpr_yardstick_points points = points_of(0, 2);
    hpr_study_run *run = NULL;
    hpr_study_row row;
    hpr_yardstick y = {0};
    size_t count;
    hpr_solution *truth = data;
    truth->context = truth->patches->context = truth->elements->context = ctx;
    hpr_status status = hpr_study_plan(ctx, &options, &count, &run);
    if (status == HPR_OK)
        status = hpr_yardstick_init(truth, &points, &y);
    if (status == HPR_OK)
        status = hpr_yardstick_measure(&y, truth, &row);
    hpr_yardstick_fini(&y);
    hpr_release(ctx, run);
    return status;
}

static void measuring_survives_without_memory(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    room_add_plates(&room, 1.5, 0.5, 1);
    hpr_solution *truth = room_solve_direct(&room, 1, 0, HPR_DIRECT_GALERKIN);
    sweep_allocations(plan_and_measure, truth, 1);
    truth->context = truth->patches->context = truth->elements->context = room.context;
    hpr_solution_destroy(&truth);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tolerances_add_adaptive_runs),   cmocka_unit_test(runs_are_planned_once_each),
        cmocka_unit_test(an_error_of_one_percent_is_one), cmocka_unit_test(the_worst_channel_counts),
        cmocka_unit_test(rows_are_found_again),           cmocka_unit_test(measuring_survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
