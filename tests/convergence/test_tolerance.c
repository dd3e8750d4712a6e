/*
 * A tolerance is asked for: the true error, against a much finer solution, is what the estimate says within a
 * factor, and below the tolerance.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "lcg.h"
#include "rooms.h"

enum { POINTS = 600 };

typedef struct scene {
    const char *name;
    void (*make)(hpr_room *room, double emission);
    int order, subdivide, grade; /* of the solution to compare with */
} scene;

static void make_plates(hpr_room *room, double emission)
{
    room_add_plates(room, 1, 0.5, emission);
}

static void make_near_plates(hpr_room *room, double emission)
{
    room_add_plates(room, 0.25, 0.9, emission);
}

static void make_corner(hpr_room *room, double emission)
{
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double wall[4][3] = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    room_add(room, 4, floor, 0.8, 0, false);
    room_add(room, 4, wall, 0.8, emission, false);
}

static void make_open_box(hpr_room *room, double emission)
{
    const double rho[6] = {0.2, 0.7, 0.4, 0.6, 0.5, 0}, exitance[6] = {0, 0, emission, 0, 0, 0};
    room_add_box(room, 1, 1.5, 0.8, rho, exitance, 5);
}

static void make_box(hpr_room *room, double emission)
{
    const double rho[6] = {0.2, 0.7, 0.4, 0.6, 0.5, 0.8}, exitance[6] = {0, 0, 0, 0, 0, emission};
    room_add_box(room, 1, 1, 1, rho, exitance, -1);
}

static void make_blocked(hpr_room *room, double emission)
{
    const double lower[4][3] = {{0.25, 0.25, 0.5}, {0.75, 0.25, 0.5}, {0.75, 0.75, 0.5}, {0.25, 0.75, 0.5}};
    room_add_plates(room, 1, 0.8, emission);
    room_add(room, 4, lower, 0, 0, true);
}

static const scene scenes[] = {
    {"plates", make_plates, 16, 0, 0}, {"plates, gap 0.25", make_near_plates, 10, 1, 0},
    {"corner", make_corner, 4, 0, 9},  {"open box", make_open_box, 4, 0, 6},
    {"closed box", make_box, 4, 0, 6}, {"blocked plates", make_blocked, 6, 2, 0}};

static hpr_solution *solve(hpr_room *room, hpr_solve_options *options)
{
    hpr_solution *solution = NULL;
    hpr_status status = hpr_solve(room->context, room->scene, options, &solution);
    if (status != HPR_OK)
        print_error("solve: %s\n", hpr_context_error(room->context));
    assert_int_equal(status, HPR_OK);
    return solution;
}

static hpr_solution *solve_to(hpr_room *room, double tolerance, hpr_refine_mode mode)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.tolerance = tolerance;
    options.refine = mode;
    return solve(room, &options);
}

/* Points spread over all patches by area. */
static void choose_points(const hpr_patches *patches, double point[POINTS][3], double normal[POINTS][3])
{
    uint64_t state = 1;
    double area = 0;
    for (size_t i = 0; i < patches->count; i++)
        area += patches->area_m2[i];
    for (int k = 0; k < POINTS; k++) {
        double at = random_unit(&state) * area, s = random_unit(&state), t = random_unit(&state);
        size_t patch = 0;
        while (patch + 1 < patches->count && at > patches->area_m2[patch])
            at -= patches->area_m2[patch++];
        for (size_t i = 0; i < 3; i++) {
            point[k][i] = patches->origin[3 * patch + i] + s * patches->edge1[3 * patch + i] +
                          t * patches->edge2[3 * patch + i];
            normal[k][i] = patches->normal[3 * patch + i];
        }
    }
}

static void probe(hpr_room *room, const hpr_solution *solution, double irradiance[POINTS][3])
{
    static double point[POINTS][3], normal[POINTS][3], radiosity[POINTS][3];
    static uint32_t patch[POINTS];
    choose_points(solution->patches, point, normal);
    assert_int_equal(hpr_solution_probe(room->context, solution, POINTS, point[0], normal[0], irradiance[0],
                                        radiosity[0], patch),
                     HPR_OK);
}

static double true_error(hpr_room *room, const hpr_solution *solution, double fine[POINTS][3])
{
    static double value[POINTS][3];
    double d2 = 0, n2 = 0;
    probe(room, solution, value);
    for (int k = 0; k < POINTS; k++) {
        d2 += (value[k][0] - fine[k][0]) * (value[k][0] - fine[k][0]);
        n2 += fine[k][0] * fine[k][0];
    }
    return sqrt(d2 / n2);
}

static void probe_finest(hpr_room *room, const scene *s, double fine[POINTS][3])
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = s->order;
    options.subdivide = s->subdivide;
    options.grade = s->grade;
    hpr_solution *finest = solve(room, &options);
    probe(room, finest, fine);
    hpr_solution_destroy(&finest);
}

/* Observed: the estimate is 1.2 to 7 times the true error; the points add some 5 %. */
static void test_estimates(void **state)
{
    (void)state;
    static const double least = 0.7, most = 10, tolerances[] = {1e-1, 1e-2, 1e-3};
    static double fine[POINTS][3];
    int failures = 0;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        hpr_room room = room_open(2);
        scenes[i].make(&room, 1);
        probe_finest(&room, &scenes[i], fine);
        for (size_t t = 0; t < sizeof tolerances / sizeof *tolerances; t++) {
            hpr_solution *solution = solve_to(&room, tolerances[t], HPR_REFINE_HP);
            const hpr_solve_summary *s = hpr_solution_summary(solution);
            double error = true_error(&room, solution, fine), ratio = s->error_estimate / error;
            bool good = s->reached && ratio >= least && ratio <= most && error <= tolerances[t];
            print_message("%s, tolerance %.0e: %zu coefficients, error %.1e, estimate %.1e, ratio %.2f%s\n",
                          scenes[i].name, tolerances[t], s->dof_count, error, s->error_estimate, ratio,
                          good ? "" : " FAILED");
            failures += !good;
            hpr_solution_destroy(&solution);
        }
        room_close(&room);
    }
    assert_int_equal(failures, 0);
}

/* Elements of one constant are halved, with direct light through the basis or not; a mean alone does not tell
 * what it leaves out, nor do halves of an even function. Observed: the estimate is 1.9 to 6
 * times the true error. */
static void test_constants(void **state)
{
    (void)state;
    static const double least = 0.8, most = 10, tolerance = 0.1;
    static double fine[POINTS][3];
    static const size_t some[] = {0, 2, 4}; /* of the scenes */
    int failures = 0;
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        const scene *it = &scenes[some[i]];
        hpr_room room = room_open(2);
        it->make(&room, 1);
        probe_finest(&room, it, fine);
        for (int hierarchical = 0; hierarchical < 2; hierarchical++) {
            hpr_solve_options options;
            hpr_solve_options_init(&options);
            options.tolerance = tolerance;
            options.order = 0;
            options.refine = HPR_REFINE_H;
            options.method = hierarchical ? HPR_METHOD_HIERARCHICAL : HPR_METHOD_GALERKIN;
            hpr_solution *solution = solve(&room, &options);
            const hpr_solve_summary *s = hpr_solution_summary(solution);
            double error = true_error(&room, solution, fine), ratio = s->error_estimate / error;
            bool good = s->reached && ratio >= least && ratio <= most && s->dof_count == s->element_count;
            print_message("%s, %s: %zu constants in %d steps, error %.1e, estimate %.1e, ratio %.2f%s\n",
                          it->name, hpr_method_name(options.method), s->dof_count, s->steps, error,
                          s->error_estimate, ratio, good ? "" : " FAILED");
            failures += !good;
            hpr_solution_destroy(&solution);
        }
        room_close(&room);
    }
    assert_int_equal(failures, 0);
}

/* The estimate is relative: the same elements, and the same figures to rounding. */
static void test_emission_scaled(void **state)
{
    (void)state;
    hpr_solve_summary figures[2];
    for (int k = 0; k < 2; k++) {
        hpr_room room = room_open(1);
        make_corner(&room, k ? 1024 : 1);
        hpr_solution *solution = solve_to(&room, 1e-2, HPR_REFINE_HP);
        figures[k] = *hpr_solution_summary(solution);
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
    assert_int_equal(figures[0].element_count, figures[1].element_count);
    assert_int_equal(figures[0].dof_count, figures[1].dof_count);
    assert_true(fabs(figures[0].error_estimate - figures[1].error_estimate) <=
                1e-9 * figures[0].error_estimate);
}

static void test_modes(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    make_near_plates(&room, 1);
    hpr_solution *p = solve_to(&room, 1e-3, HPR_REFINE_P), *h = solve_to(&room, 1e-3, HPR_REFINE_H);
    assert_int_equal(hpr_solution_summary(p)->element_count, 2);
    assert_true(hpr_solution_summary(p)->dof_count > 2 * 25);
    assert_true(hpr_solution_summary(h)->element_count > 2);
    assert_int_equal(hpr_solution_summary(h)->dof_count, 25 * hpr_solution_summary(h)->element_count);
    assert_true(hpr_solution_summary(p)->reached && hpr_solution_summary(h)->reached);
    hpr_solution_destroy(&p);
    hpr_solution_destroy(&h);
    room_close(&room);
}

/* Radiosity of two squares at a distance of 1, the lower of which emits, to 14 digits (Nystroem, as in
 * scenes/README.md). Observed: 545 coefficients, off by 1.1e-12 of itself at most, at a corner, where the
 * tolerance, of the mean square over all of it, says nothing. */
static void test_to_the_last_digits(void **state)
{
    (void)state;
    static const double point[5][3] = {{0.5, 0.5, 0}, {0, 0, 0}, {0.5, 0.5, 1}, {0.5, 0, 1}, {0, 0, 1}};
    static const double normal[5][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, -1}, {0, 0, -1}, {0, 0, -1}};
    static const double known[5] = {1.01232676296358, 1.00700634835602, 0.120976802028842, 0.0911150166561578,
                                    0.0699750447890256};
    double irradiance[5][3], radiosity[5][3];
    uint32_t patch[5];
    hpr_room room = room_open(1);
    make_plates(&room, 1);
    hpr_solution *solution = solve_to(&room, 1e-12, HPR_REFINE_HP);
    const hpr_solve_summary *s = hpr_solution_summary(solution);
    assert_true(s->reached && s->dof_count <= 600);
    assert_int_equal(hpr_solution_probe(room.context, solution, 5, point[0], normal[0], irradiance[0],
                                        radiosity[0], patch),
                     HPR_OK);
    for (int k = 0; k < 5; k++)
        assert_float_equal(radiosity[k][0] / known[k], 1, 4e-12);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* How many it takes; 0: the tolerance is not reached. */
static size_t count_constants(hpr_room *room, double tolerance)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.tolerance = tolerance;
    options.method = HPR_METHOD_HIERARCHICAL;
    options.max_seconds = 60; /* of a failure */
    hpr_solution *solution = solve(room, &options);
    const hpr_solve_summary *s = hpr_solution_summary(solution);
    size_t count = s->reached ? s->dof_count : 0;
    hpr_solution_destroy(&solution);
    return count;
}

/* A floor that is no parallelogram by a hair is halved along one axis at a time like one, its small parts get
 * low degrees, and of a degree it has fewer functions. Observed: 1055 coefficients against 1429; halved along
 * both axes in turn and of one degree it took 1507 against 1309. Of constants 432 against 506. */
static void test_quadrilaterals(void **state)
{
    (void)state;
    size_t dofs[2], constants[2];
    for (int k = 0; k < 2; k++) {
        const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {k ? 1.001 : 1, 1, 0}, {0, 1, 0}};
        const double wall[4][3] = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
        hpr_room room = room_open(1);
        room_add(&room, 4, floor, 0.8, 0, false);
        room_add(&room, 4, wall, 0.8, 1, false);
        hpr_solution *solution = solve_to(&room, 1e-3, HPR_REFINE_HP);
        assert_true(hpr_solution_summary(solution)->reached);
        dofs[k] = hpr_solution_summary(solution)->dof_count;
        hpr_solution_destroy(&solution);
        constants[k] = count_constants(&room, 0.1);
        room_close(&room);
    }
    print_message("%zu coefficients, of a parallelogram %zu; %zu constants, of a parallelogram %zu\n",
                  dofs[1], dofs[0], constants[1], constants[0]);
    assert_true(dofs[1] <= dofs[0]);
    assert_true(constants[1] > 0 && 2 * constants[1] <= 3 * constants[0]);
}

/* Every thread count gives the same bits. */
static void test_threads(void **state)
{
    (void)state;
    double estimate[3];
    static const int threads[] = {1, 2, 7};
    for (int k = 0; k < 3; k++) {
        hpr_room room = room_open(threads[k]);
        make_blocked(&room, 1);
        hpr_solution *solution = solve_to(&room, 1e-3, HPR_REFINE_HP);
        estimate[k] = hpr_solution_summary(solution)->error_estimate;
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
    assert_true(estimate[0] == estimate[1] && estimate[0] == estimate[2]);
}

/* No step is begun that would take too long; what there is stands, and says that it is not enough. */
static void test_limits(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    make_corner(&room, 1);
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.tolerance = 1e-6;
    options.max_seconds = 1e-9;
    hpr_solution *solution = solve(&room, &options);
    const hpr_solve_summary *s = hpr_solution_summary(solution);
    assert_int_equal(s->steps, 1);
    assert_false(s->reached);
    assert_true(s->error_estimate > 1e-6 && s->error_estimate < 0.1);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_estimates),
                                       cmocka_unit_test(test_constants),
                                       cmocka_unit_test(test_emission_scaled),
                                       cmocka_unit_test(test_modes),
                                       cmocka_unit_test(test_to_the_last_digits),
                                       cmocka_unit_test(test_threads),
                                       cmocka_unit_test(test_limits),
                                       cmocka_unit_test(test_quadrilaterals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
