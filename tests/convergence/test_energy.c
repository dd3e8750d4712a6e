/*
 * Where the light goes: emitted = absorbed + lost on backs + escaped, each computed by itself. Unoccluded
 * scenes, so that each has its closed form or at least its balance to 1e-9.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "open_cases.h"
#include "rooms.h"

#include <string.h>

/* The losses are integrated to 1e-11 of what is emitted, the blocks to 1e-12. */
static const double bound = 1e-9;

static double balance(const hpr_energy *e)
{
    return (e->emitted - e->absorbed - e->lost_on_backs - e->escaped) / e->emitted;
}

static hpr_energy energy_of(hpr_room *room, int order, int subdivide)
{
    hpr_solution *solution = room_solve(room, order, subdivide);
    const hpr_energy *e = hpr_solution_energy(solution);
    assert_memory_equal(&e[0], &e[1], sizeof *e); /* the channels agree */
    hpr_energy energy = e[0];
    hpr_solution_destroy(&solution);
    return energy;
}

static const open_factor *find(const char *id)
{
    for (int i = 0; i < OPEN_FACTORS; i++) {
        if (!strcmp(open_factors[i].id, id))
            return &open_factors[i];
    }
    fail_msg("no case %s", id);
    return NULL;
}

static double area_of(int count, const double (*corner)[3])
{
    double e1[3], e2[3], n[3];
    for (int k = 0; k < 3; k++) {
        e1[k] = corner[1][k] - corner[0][k];
        e2[k] = corner[count - 1][k] - corner[0][k];
    }
    n[0] = e1[1] * e2[2] - e1[2] * e2[1];
    n[1] = e1[2] * e2[0] - e1[0] * e2[2];
    n[2] = e1[0] * e2[1] - e1[1] * e2[0];
    return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / (count == 3 ? 2 : 1);
}

/* Relative error of a term, printed. */
static int off(const char *what, double got, double want, double unit)
{
    double error = fabs(got - want) / unit;
    if (!(error <= bound))
        print_error("%s: %.15g, expected %.15g, off by %.2e of what is emitted\n", what, got, want, error);
    return !(error <= bound);
}

/* The first patch emits M = 1, the second absorbs: A1 F12 arrives, A1 (1 - F12) escapes. */
static void black_pairs(void **state)
{
    (void)state;
    static const char *const id[] = {
        "ff_parallel_1x1_gap1", "ff_perp_edge_l1_h1_w1", "ff_inclined_60deg_1x1x1", "ff_par_off2",
        "ff_perp_off1",         "ff_perp_off2",          "ff_tri_edge60",           "ff_tri_general_2"};
    static const int mesh[][2] = {{0, 0}, {0, 2}, {2, 1}, {5, 0}};
    int failures = 0;
    for (size_t i = 0; i < sizeof id / sizeof *id; i++) {
        const open_factor *c = find(id[i]);
        double area = area_of(c->count1, c->corner1), worst = 0;
        for (size_t m = 0; m < sizeof mesh / sizeof *mesh; m++) {
            hpr_room room = room_open(2);
            room_add(&room, c->count1, c->corner1, 0, 1, false);
            room_add(&room, c->count2, c->corner2, 0, 0, false);
            hpr_energy e = energy_of(&room, mesh[m][0], mesh[m][1]);
            double escaped = area * (1 - c->value) - e.lost_on_backs;
            failures += off("emitted", e.emitted, area, area);
            failures += off("absorbed", e.absorbed, area * c->value, area);
            failures += off("escaped", e.escaped, escaped, area);
            worst =
                fmax(worst, fmax(fabs(e.absorbed / (area * c->value) - 1), fabs(e.escaped / escaped - 1)));
            if (m == 0)
                print_message("%-24s absorbed %.12g, on backs %.3g, escaped %.12g\n", id[i], e.absorbed,
                              e.lost_on_backs, e.escaped);
            /* All of the first patch lies before the second's plane in these. */
            failures += e.lost_on_backs != 0;
            room_close(&room);
        }
        print_message("%-24s worst relative error of absorbed and escaped %.1e, bound %.0e\n", id[i], worst,
                      bound);
        failures += !(worst <= bound);
    }
    assert_int_equal(failures, 0);
}

/* The second plate shows its back: all that reaches it is lost there. */
static void single_sided_plate_from_behind(void **state)
{
    (void)state;
    static const char *const id[] = {"ff_parallel_1x1_gap1", "ff_perp_off2", "ff_tri_edge60"};
    static const int mesh[][2] = {{0, 0}, {3, 1}, {1, 2}};
    int failures = 0;
    for (size_t i = 0; i < sizeof id / sizeof *id; i++) {
        const open_factor *c = find(id[i]);
        double area = area_of(c->count1, c->corner1), turned[4][3];
        for (int k = 0; k < c->count2; k++)
            memcpy(turned[k], c->corner2[c->count2 - 1 - k], sizeof turned[k]);
        for (size_t m = 0; m < sizeof mesh / sizeof *mesh; m++) {
            hpr_room room = room_open(2);
            room_add(&room, c->count1, c->corner1, 0.5, 1, false);
            room_add(&room, c->count2, (const double(*)[3])turned, 0.5, 0, false);
            hpr_energy e = energy_of(&room, mesh[m][0], mesh[m][1]);
            print_message("%-24s order %d, subdivide %d: on backs %.15g, expected %.15g, escaped %.15g, "
                          "absorbed %g, balance %.1e\n",
                          id[i], mesh[m][0], mesh[m][1], e.lost_on_backs, area * c->value, e.escaped,
                          e.absorbed, balance(&e));
            failures += off("lost on backs", e.lost_on_backs, area * c->value, area);
            failures += off("escaped", e.escaped, area * (1 - c->value), area);
            failures += e.absorbed != 0 || !(e.lost_on_backs > 0);
            room_close(&room);
        }
    }
    assert_int_equal(failures, 0);
}

/* Plates of two sides, the lower one emitting on both; the upper one shows the lower its second side. Inside
 * all is as with single-sided plates, and what the outer side emits escapes. */
static void double_sided_plates(void **state)
{
    (void)state;
    static const int mesh[][2] = {{0, 0}, {4, 0}, {2, 1}};
    const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double top[2][4][3] = {{{0, 0, 0.5}, {0, 1, 0.5}, {1, 1, 0.5}, {1, 0, 0.5}},
                                 {{0, 0, 0.5}, {1, 0, 0.5}, {1, 1, 0.5}, {0, 1, 0.5}}};
    int failures = 0;
    for (size_t m = 0; m < sizeof mesh / sizeof *mesh; m++) {
        hpr_energy e[2];
        for (int both = 0; both < 2; both++) {
            hpr_room room = room_open(2);
            room_add(&room, 4, bottom, 0.7, 1, both);
            room_add(&room, 4, top[both], 0.4, 0, both);
            e[both] = energy_of(&room, mesh[m][0], mesh[m][1]);
            room_close(&room);
        }
        print_message(
            "order %d, subdivide %d: emitted %.12g and %.12g, escaped %.12g and %.12g, balance %.1e "
            "and %.1e\n",
            mesh[m][0], mesh[m][1], e[0].emitted, e[1].emitted, e[0].escaped, e[1].escaped, balance(&e[0]),
            balance(&e[1]));
        failures += off("emitted", e[1].emitted, 2, 2);
        failures += off("absorbed", e[1].absorbed, e[0].absorbed, 2);
        failures += off("escaped", e[1].escaped, e[0].escaped + 1, 2);
        failures +=
            e[1].lost_on_backs != 0 || !(fabs(balance(&e[0])) <= bound) || !(fabs(balance(&e[1])) <= bound);
    }
    assert_int_equal(failures, 0);
}

typedef void (*room_maker)(hpr_room *room);

static void make_l_corner(hpr_room *room)
{
    const double ground[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double wall[4][3] = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    room_add(room, 4, ground, 0.8, 1, false);
    room_add(room, 4, wall, 0.8, 0, false);
}

static void make_open_box(hpr_room *room)
{
    const double rho[6] = {0.5, 0.9, 0.3, 0.7, 0.2, 0}, light[6] = {0, 0, 0, 0.5, 1, 0};
    room_add_box(room, 1.5, 0.75, 2, rho, light, 5);
}

static void make_plates(hpr_room *room)
{
    room_add_plates(room, 0.25, 0.9, 1);
}

/* A triangle over a square, showing part of its front and part of its back. */
static void make_leaning_triangle(hpr_room *room)
{
    const double ground[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double leaf[3][3] = {{0.5, 0.2, 0.4}, {0.4, 0.9, 0.5}, {0.7, 0.5, 1.2}};
    room_add(room, 4, ground, 0.6, 1, false);
    room_add(room, 3, leaf, 0.8, 0.3, false);
}

static void rooms_balance(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        room_maker make;
        bool backs; /* some light goes there */
    } rooms[] = {{"L-corner", make_l_corner, false},
                 {"open box", make_open_box, false},
                 {"plates, gap 0.25", make_plates, false},
                 {"leaning triangle", make_leaning_triangle, true}};
    static const int mesh[][2] = {{0, 0}, {1, 0}, {4, 0}, {0, 2}, {2, 1}, {8, 0}};
    int failures = 0;
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        for (size_t m = 0; m < sizeof mesh / sizeof *mesh; m++) {
            hpr_room room = room_open(2);
            rooms[i].make(&room);
            hpr_energy e = energy_of(&room, mesh[m][0], mesh[m][1]);
            print_message(
                "%-18s order %d, subdivide %d: emitted %.6f absorbed %.6f on backs %.6f escaped %.6f "
                "balance %.1e, bound %.0e\n",
                rooms[i].name, mesh[m][0], mesh[m][1], e.emitted, e.absorbed, e.lost_on_backs, e.escaped,
                balance(&e), bound);
            failures += !(fabs(balance(&e)) <= bound) || (e.lost_on_backs > 0) != rooms[i].backs;
            failures += !(e.absorbed > 0 && e.escaped > 0);
            room_close(&room);
        }
    }
    assert_int_equal(failures, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(black_pairs),
        cmocka_unit_test(single_sided_plate_from_behind),
        cmocka_unit_test(double_sided_plates),
        cmocka_unit_test(rooms_balance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
