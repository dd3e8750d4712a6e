/*
 * A shadow close to its receiver: unit plates of reflectance 0.8 at distance 1, the upper one emitting, and a
 * black square of side 1/2 at height 1/16 over the middle of the lower one. With direct light evaluated
 * exactly the basis carries what is smooth; with direct light through the basis the polynomials ring.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "rooms.h"

typedef struct place {
    double x, y, z, radiosity;
} place;

/* Radiosity for Le = 1 W/m2/sr above, from order 5 on 4^4 elements per patch at block tolerance 1e-6; order 4
 * differs from it by 4e-6 of the RMS. */
static const place places[] = {
    {0.1286, 0.4993, 0, 0.52280921}, {0.6015, 0.0287, 1, 3.18969116}, {0.1479, 0.9282, 0, 0.43407466},
    {0.0704, 0.1298, 1, 3.18579986}, {0.9483, 0.6219, 0, 0.47907222}, {0.369, 0.5114, 1, 3.20058609},
    {0.6628, 0.2753, 0, 0.00000000}, {0.138, 0.788, 1, 3.19070300},   {0.6704, 0.5124, 0, 0.00000000},
    {0.8167, 0.5491, 1, 3.19614578}, {0.9809, 0.2045, 0, 0.42850445}, {0.5537, 0.4836, 1, 3.20132173},
    {0.3533, 0.5916, 0, 0.00000000}, {0.2353, 0.8022, 1, 3.19325604}, {0.8673, 0.1288, 0, 0.45082481},
    {0.4671, 0.2771, 1, 3.19884033}, {0.0831, 0.8959, 0, 0.42336572}, {0.4299, 0.1477, 1, 3.19479936},
    {0.6734, 0.2022, 0, 0.52549042}, {0.9014, 0.2171, 1, 3.18941049}, {0.0331, 0.2008, 0, 0.43374559},
    {0.3457, 0.4689, 1, 3.20019638}, {0.9061, 0.6974, 0, 0.48589852}, {0.3393, 0.0169, 1, 3.18846673},
    {0.1598, 0.9964, 0, 0.40894904}, {0.4597, 0.691, 1, 3.19950157},  {0.0547, 0.0341, 0, 0.38667576},
    {0.8459, 0.5879, 1, 3.19489007}, {0.3087, 0.3174, 0, 0.00000000}, {0.0892, 0.1727, 1, 3.18782546},
    {0.0246, 0.8391, 0, 0.41841865}, {0.4663, 0.1272, 1, 3.19422547}, {0.7392, 0.1957, 0, 0.51645905},
    {0.0619, 0.5984, 1, 3.19117846}, {0.8958, 0.0269, 0, 0.40120929}, {0.8051, 0.1902, 1, 3.19190775},
    {0.0929, 0.018, 0, 0.39377514},  {0.293, 0.7271, 1, 3.19661339},  {0.4932, 0.8529, 0, 0.53079862},
    {0.2172, 0.3152, 1, 3.19560542}, {0.2581, 0.9783, 0, 0.44313494}, {0.941, 0.3407, 1, 3.19033206},
    {0.436, 0.3143, 0, 0.00000000},  {0.7465, 0.04, 1, 3.18792932},   {0.0674, 0.404, 0, 0.48956264},
    {0.2451, 0.8452, 1, 3.19213336}, {0.7418, 0.5458, 0, 0.08261335}, {0.6615, 0.6923, 1, 3.19821972},
};

enum { PLACES = sizeof places / sizeof *places };

typedef struct outcome {
    double error; /* RMS of the radiosity's error, relative to the RMS radiosity */
    double least; /* radiosity */
} outcome;

static outcome solve(int order, hpr_direct_mode direct)
{
    static const double height = 1.0 / 16, exitance = 3.14159265358979323846;
    const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double top[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const double blocker[4][3] = {
        {0.25, 0.25, height}, {0.75, 0.25, height}, {0.75, 0.75, height}, {0.25, 0.75, height}};
    hpr_room room = room_open(1);
    room_add(&room, 4, bottom, 0.8, 0, false);
    room_add(&room, 4, top, 0.8, exitance, false);
    room_add(&room, 4, blocker, 0, 0, true);
    hpr_solution *solution = NULL;
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = 3;
    options.direct = direct;
    assert_int_equal(hpr_solve(room.context, room.scene, &options, &solution), HPR_OK);
    outcome result = {0, INFINITY};
    double norm = 0;
    for (size_t i = 0; i < PLACES; i++) {
        const double point[3] = {places[i].x, places[i].y, places[i].z};
        const double normal[3] = {0, 0, places[i].z > 0.5 ? -1 : 1};
        double irradiance[3], radiosity[3];
        uint32_t patch;
        assert_int_equal(
            hpr_solution_probe(room.context, solution, 1, point, normal, irradiance, radiosity, &patch),
            HPR_OK);
        assert_true(patch != HPR_NONE);
        result.error += pow(radiosity[0] - places[i].radiosity, 2);
        norm += pow(places[i].radiosity, 2);
        result.least = fmin(result.least, radiosity[0]);
    }
    result.error = sqrt(result.error / norm);
    hpr_solution_destroy(&solution);
    room_close(&room);
    return result;
}

static void exact_direct_light_keeps_the_order(void **state)
{
    (void)state;
    static const double bound = 1e-4; /* observed 2.5e-5 */
    outcome exact = solve(4, HPR_DIRECT_EXACT);
    print_message("order 4, exact: RMS error %.2e (bound %.0e), least radiosity %.3g\n", exact.error, bound,
                  exact.least);
    assert_true(exact.error <= bound);
    assert_true(exact.least >= 0);
}

/* Why direct light is evaluated apart: the same mesh and order with it in the basis. Observed: 100 times. */
static void interpolated_direct_light_is_far_worse(void **state)
{
    (void)state;
    static const double factor = 20;
    outcome exact = solve(2, HPR_DIRECT_EXACT), galerkin = solve(2, HPR_DIRECT_GALERKIN);
    print_message("order 2: exact %.2e, galerkin %.2e, least radiosity %.3g\n", exact.error, galerkin.error,
                  galerkin.least);
    assert_true(galerkin.error >= factor * exact.error);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_direct_light_keeps_the_order),
        cmocka_unit_test(interpolated_direct_light_is_far_worse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
