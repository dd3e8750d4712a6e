/* Final gathering: what a solution's radiosity sends to points, against better solutions and limits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "rooms.h"

#include <string.h>

enum { MOST = 16 };

/* Points, and what was found there. */
typedef struct places {
    size_t count;
    double point[MOST][3], normal[MOST][3], irradiance[MOST][3], radiosity[MOST][3];
    uint32_t patch[MOST];
} places;

static void place(places *p, double x, double y, double z, double nx, double ny, double nz)
{
    memcpy(p->point[p->count], (double[3]){x, y, z}, sizeof *p->point);
    memcpy(p->normal[p->count++], (double[3]){nx, ny, nz}, sizeof *p->normal);
}

static void gather(hpr_room *room, const hpr_solution *solution, places *p)
{
    assert_int_equal(hpr_solution_gather(room->context, solution, p->count, p->point[0], p->normal[0],
                                         p->irradiance[0], p->radiosity[0], p->patch),
                     HPR_OK);
}

static void probe(hpr_room *room, const hpr_solution *solution, places *p)
{
    assert_int_equal(hpr_solution_probe(room->context, solution, p->count, p->point[0], p->normal[0],
                                        p->irradiance[0], p->radiosity[0], p->patch),
                     HPR_OK);
}

/* Largest difference of H, relative to the largest H of b. */
static double distance(const places *a, const places *b)
{
    double most = 0, largest = 0;
    for (size_t i = 0; i < a->count; i++) {
        for (int c = 0; c < 3; c++) {
            most = fmax(most, fabs(a->irradiance[i][c] - b->irradiance[i][c]));
            largest = fmax(largest, b->irradiance[i][c]);
        }
    }
    return most / largest;
}

/* Plates of which the lower one shines: its H is all indirect. Seen at degree 2: 1.5e-3, and gathered 1.2e-5.
 */
static void it_gains_digits_where_light_is_smooth(void **state)
{
    (void)state;
    static const double least_gain = 50;
    hpr_room room = room_open(1);
    room_add_plates(&room, 1, 0.8, 1);
    hpr_solution *coarse = room_solve(&room, 2, 0), *fine = room_solve(&room, 12, 0);
    places a = {0}, b;
    place(&a, 0.1, 0.2, 0, 0, 0, 1);
    place(&a, 0.5, 0.5, 0, 0, 0, 1);
    place(&a, 0.97, 0.03, 0, 0, 0, 1);
    place(&a, 0.4, 0.9, 1, 0, 0, -1);
    b = a;
    probe(&room, fine, &b);
    probe(&room, coarse, &a);
    double plain = distance(&a, &b);
    gather(&room, coarse, &a);
    double gathered = distance(&a, &b);
    print_message("degree 2: polynomials err by %.2e, gathering by %.2e\n", plain, gathered);
    assert_true(plain > 1e-3 && gathered < plain / least_gain);
    for (size_t i = 0; i < a.count; i++) {
        double emitted = a.point[i][2] > 0.5 ? 0 : 1;
        assert_true(fabs(a.radiosity[i][0] - emitted - 0.8 * a.irradiance[i][0]) < 1e-14);
    }
    gather(&room, fine, &a); /* both to 1e-12 or so */
    assert_true(distance(&a, &b) < 1e-10);
    hpr_solution_destroy(&coarse);
    hpr_solution_destroy(&fine);
    room_close(&room);
}

/* A box with a lamp in its ceiling and a doubleSided sheet that hangs in it. */
static hpr_room sheet_room(int threads, bool open)
{
    static const double lamp[4][3] = {{0.4, 0.4, 0.9}, {0.4, 0.6, 0.9}, {0.6, 0.6, 0.9}, {0.6, 0.4, 0.9}};
    static const double sheet[4][3] = {{0.25, 0.2, 0.5}, {0.7, 0.2, 0.5}, {0.7, 0.8, 0.5}, {0.25, 0.8, 0.5}};
    static const double rho[6] = {0.7, 0.3, 0.5, 0.5, 0.6, 0.8}, dark[6] = {0};
    hpr_room room = room_open(threads);
    room_add_box(&room, 1, 1, 1, rho, dark, open ? 2 : -1);
    room_add(&room, 4, lamp, 0, 20, false);
    room_add(&room, 4, sheet, 0.5, 0, true);
    return room;
}

/* Over and under the sheet, on walls and ceiling, in shadow and penumbra. */
static places sheet_places(void)
{
    places p = {0};
    place(&p, 0.5, 0.5, 0.5, 0, 0, 1);
    place(&p, 0.3, 0.7, 0.5, 0, 0, -1);
    place(&p, 0.5, 0.45, 0, 0, 0, 1);
    place(&p, 0.11, 0.5, 0, 0, 0, 1);
    place(&p, 0, 0.3, 0.5, 1, 0, 0);
    place(&p, 1, 0.55, 0.1, -1, 0, 0);
    place(&p, 0.2, 0.8, 1, 0, 0, -1);
    return p;
}

/* What is gathered is the same whether direct light is evaluated or goes through the basis, and near the
 * polynomials of these elements: seen 2e-7 and 8e-3 to 1.5e-2, of the largest. */
static void check_modes(hpr_room *room)
{
    static const double modes = 1e-5, polynomials = 3e-2;
    hpr_solution *exact = room_solve(room, 1, 0);
    hpr_solution *galerkin = room_solve_direct(room, 1, 0, HPR_DIRECT_GALERKIN);
    places a = sheet_places(), b = a, plain = a;
    gather(room, exact, &a);
    gather(room, galerkin, &b);
    probe(room, exact, &plain);
    print_message("modes differ by %.2e, polynomials by %.2e\n", distance(&a, &b), distance(&plain, &a));
    assert_true(distance(&a, &b) < modes);
    assert_true(distance(&plain, &a) < polynomials);
    hpr_solution_destroy(&exact);
    hpr_solution_destroy(&galerkin);
}

static void lamps_in_both_modes_agree(void **state)
{
    (void)state;
    hpr_room room = sheet_room(1, false);
    check_modes(&room);
    room_close(&room);
}

static void light_from_outside_takes_part(void **state)
{
    (void)state;
    static const double sky[3] = {1, 2, 0.5};
    hpr_room room = sheet_room(1, true);
    assert_int_equal(hpr_scene_set_environment(room.scene, 3, sky), HPR_OK);
    check_modes(&room);
    room_close(&room);
}

/* On the edge between two faces and in a corner: the limit from inside. */
static void edges_have_their_limit(void **state)
{
    (void)state;
    static const double near = 1e-5;
    hpr_room room = sheet_room(1, false);
    hpr_solution *solution = room_solve(&room, 2, 1);
    places on = {0}, off = {0};
    place(&on, 0, 0.3, 0, 0, 0, 1);
    place(&off, near, 0.3, 0, 0, 0, 1);
    place(&on, 0, 0.3, 0, 1, 0, 0);
    place(&off, 0, 0.3, near, 1, 0, 0);
    place(&on, 1, 1, 1, 0, -1, 0);
    place(&off, 1 - near, 1, 1 - near, 0, -1, 0);
    gather(&room, solution, &on);
    gather(&room, solution, &off);
    print_message("on edges off the limit by %.2e\n", distance(&on, &off));
    assert_true(distance(&on, &off) < 1e-3);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

static void threads_change_no_bit_and_other_points_are_named(void **state)
{
    (void)state;
    places found[2];
    for (int i = 0; i < 2; i++) {
        hpr_room room = sheet_room(1 + 2 * i, false);
        hpr_solution *solution = room_solve(&room, 1, 1);
        found[i] = sheet_places();
        place(&found[i], 3, 3, 3, 0, 0, 1);
        place(&found[i], 0, 0.7, 0.5, 1, 0, 0);
        gather(&room, solution, &found[i]);
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
    size_t none = found[0].count - 2;
    for (size_t i = 0; i < found[0].count; i++) {
        if (i == none)
            assert_true(isnan(found[0].irradiance[i][1]) && isnan(found[0].radiosity[i][2]) &&
                        found[0].patch[i] == HPR_NONE);
        else
            assert_memory_equal(found[0].irradiance[i], found[1].irradiance[i],
                                sizeof found[0].irradiance[i]);
    }
    assert_true(found[0].irradiance[none + 1][0] > 0);
}

static hpr_status solve_and_gather(hpr_context *ctx, void *data)
{
    places *p = data;
    hpr_room room = {.context = ctx};
    hpr_solution *solution = NULL;
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = options.subdivide = 0;
    hpr_status status = hpr_scene_create(ctx, "room", 3, NULL, &room.scene);
    const double corner[2][4][3] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                    {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}}};
    for (uint32_t i = 0; status == HPR_OK && i < 2; i++) {
        const double rho[3] = {0.5, 0.5, 0.5}, le[3] = {1 - i, 1 - i, 1 - i};
        uint32_t material, vertex[4] = {0, 1, 2, 3};
        status = hpr_scene_add_material(room.scene, "face", rho, le, false, &material);
        hpr_mesh mesh = {
            .node = i, .vertex_count = 4, .position = corner[i][0], .face_count = 1, .vertex = vertex};
        mesh.material = status == HPR_OK ? material : 0;
        if (status == HPR_OK)
            status = hpr_scene_add_mesh(room.scene, &mesh);
    }
    if (status == HPR_OK)
        status = hpr_solve(ctx, room.scene, &options, &solution);
    if (status == HPR_OK)
        status = hpr_solution_gather(ctx, solution, p->count, p->point[0], p->normal[0], p->irradiance[0],
                                     p->radiosity[0], p->patch);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&room.scene);
    return status;
}

static void memory_may_run_out(void **state)
{
    (void)state;
    places p = {0};
    place(&p, 0.3, 0.4, 0, 0, 0, 1);
    sweep_allocations(solve_and_gather, &p, 2);
    assert_true(p.irradiance[0][0] > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_gains_digits_where_light_is_smooth),
        cmocka_unit_test(lamps_in_both_modes_agree),
        cmocka_unit_test(light_from_outside_takes_part),
        cmocka_unit_test(edges_have_their_limit),
        cmocka_unit_test(threads_change_no_bit_and_other_points_are_named),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
