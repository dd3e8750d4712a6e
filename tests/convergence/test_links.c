/*
 * Links between nodes of any level against all pairs of leaves: the solution differs by less than the link
 * tolerance, its blocks take no more memory, and leaf plus ancestors close.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "direct/direct.h"
#include "lcg.h"
#include "link/direct_moments.h"
#include "mixed_cubes.h"
#include "rooms.h"
#include "solver/operator.h"
#include "solver/solution.h"

#include <stdlib.h>
#include <string.h>

/* The smallest tolerance that there is: links stand at leaves. */
static const double dense = 1e-300;

static hpr_solution *solved(const hpr_room *room, int order, int subdivide, double link_tolerance)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = subdivide;
    options.feet = 0;
    options.link_tolerance = link_tolerance;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_solve(room->context, room->scene, &options, &solution), HPR_OK);
    return solution;
}

/* A closed box of unequal sides with random materials, one face of which shines. */
static void add_random_box(hpr_room *room, uint64_t *state)
{
    double reflectance[6], exitance[6] = {0}, side[3];
    for (int k = 0; k < 3; k++)
        side[k] = 0.3 + random_unit(state);
    for (int k = 0; k < 6; k++)
        reflectance[k] = 0.9 * random_unit(state);
    exitance[(int)(6 * random_unit(state))] = 1;
    room_add_box(room, side[0], side[1], side[2], reflectance, exitance, -1);
}

/* A plate of two triangles in the middle of the room casts shadows from both sides. */
static void add_shelf(hpr_room *room)
{
    const double lower[3][3] = {{0.2, 0.2, 0.15}, {0.7, 0.25, 0.15}, {0.6, 0.6, 0.16}};
    room_add(room, 3, lower, 0.5, 0, true);
}

/* A closed box stands askew on the floor and covers a part of it, at no line of the elements. */
static void add_block(hpr_room *room)
{
    const double low[4][2] = {{0.1, 0.12}, {0.32, 0.08}, {0.36, 0.29}, {0.14, 0.33}}, h = 0.17;
    const double top[4][3] = {{low[0][0], low[0][1], h},
                              {low[1][0], low[1][1], h},
                              {low[2][0], low[2][1], h},
                              {low[3][0], low[3][1], h}};
    room_add(room, 4, top, 0.6, 0, false);
    for (int i = 0; i < 4; i++) {
        const double *a = low[i], *b = low[(i + 1) % 4];
        const double side[4][3] = {{a[0], a[1], 0}, {b[0], b[1], 0}, {b[0], b[1], h}, {a[0], a[1], h}};
        room_add(room, 4, side, 0.6, 0, false);
    }
}

/* Two by two squares without the last one, a metre high; a square of the ceiling at one end shines. */
static void add_l_room(hpr_room *room)
{
    static const double square[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    static const double ring[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (int i = 0; i < 3; i++) {
        double x = square[i][0], y = square[i][1];
        const double floor[4][3] = {{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}};
        const double ceiling[4][3] = {{x, y, 1}, {x, y + 1, 1}, {x + 1, y + 1, 1}, {x + 1, y, 1}};
        room_add(room, 4, floor, 0.3, 0, false);
        room_add(room, 4, ceiling, 0.8, i == 1, false);
    }
    for (int i = 0; i < 6; i++) {
        const double *a = ring[i], *b = ring[(i + 1) % 6];
        const double wall[4][3] = {{a[0], a[1], 0}, {a[0], a[1], 1}, {b[0], b[1], 1}, {b[0], b[1], 0}};
        room_add(room, 4, wall, 0.6, 0, false);
    }
}

typedef struct scene {
    const char *name;
    int boxes_seed;
    bool shelf, plates, block;
    int order, subdivide;
    const char *file; /* NULL: made here */
    int digits;       /* the tightest tolerance that is tried */
    bool dear;        /* only when asked for */
} scene;

/* A clipped block of a parent and those of its children differ by their own tolerances, chosen as 1e-6 for
 * few pairs: where a block stands askew, links at 1e-8 differ by 2.2e-8 of H. */
static const scene scenes[] = {
    {"box 1", 1, false, false, false, 0, 2, NULL, 8, false},
    {"box 2", 2, false, false, false, 1, 2, NULL, 8, false},
    {"box 3", 3, false, false, false, 2, 2, NULL, 8, false},
    {"box 4", 4, false, false, false, 1, 3, NULL, 8, false},
    {"plates", 0, false, true, false, 3, 2, NULL, 8, false},
    {"plates, fine", 0, false, true, false, 1, 4, NULL, 8, false},
    {"shelf 1", 5, true, false, false, 0, 2, NULL, 8, false},
    {"shelf 2", 6, true, false, false, 1, 2, NULL, 8, false},
    {"block", 7, false, false, true, 1, 2, NULL, 6, false},
    {"block, fine", 7, false, false, true, 1, 3, NULL, 6, false},
    {"L-room", -1, false, false, false, 0, 2, NULL, 8, false},
    {"Cornell box", 0, false, false, false, 0, 2, HPRAD_SCENES "/cornell_box.gltf", 8, false},
    {"L-room, fine", -1, false, false, false, 1, 2, NULL, 8, true},
    {"Cornell box, fine", 0, false, false, false, 1, 2, HPRAD_SCENES "/cornell_box.gltf", 8, true},
    {"furnished room", 0, false, false, false, 0, 1, HPRAD_SCENES "/furnished_room.gltf", 8, true},
};

static hpr_room opened(const scene *s)
{
    hpr_room room = room_open(2);
    uint64_t state = (uint64_t)s->boxes_seed;
    random_unit(&state);
    if (s->file) {
        hpr_scene_destroy(&room.scene);
        assert_int_equal(hpr_scene_read(room.context, s->file, NULL, &room.scene), HPR_OK);
    } else if (s->boxes_seed < 0)
        add_l_room(&room);
    else if (s->plates)
        room_add_plates(&room, 0.3, 0.8, 1);
    else
        add_random_box(&room, &state);
    if (s->shelf)
        add_shelf(&room);
    if (s->block)
        add_block(&room);
    return room;
}

static void test_against_all_pairs(void **state)
{
    const char *wanted = *state;
    static const double most_memory = 1; /* of all pairs of leaves */
    int failures = 0;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        const scene *s = &scenes[i];
        if (wanted ? strncmp(s->name, wanted, strlen(wanted)) != 0 : s->dear)
            continue;
        hpr_room room = opened(s);
        hpr_solution *all = solved(&room, s->order, s->subdivide, dense);
        for (int digits = 2; digits <= s->digits; digits += 2) {
            double tolerance = pow(10, -digits);
            hpr_solution *linked = solved(&room, s->order, s->subdivide, tolerance);
            double error = room_difference(all, linked);
            const hpr_solve_summary *a = hpr_solution_summary(all), *b = hpr_solution_summary(linked);
            double memory = (double)b->block_bytes / (double)a->block_bytes;
            bool good = error <= tolerance && memory <= most_memory;
            print_message(
                "%s, degree %d, tolerance %.0e: %zu links, %.2f of all blocks, H differs by %.1e%s\n",
                s->name, s->order, tolerance, b->link_count, memory, error, good ? "" : " FAILED");
            failures += !good;
            hpr_solution_destroy(&linked);
        }
        hpr_solution_destroy(&all);
        room_close(&room);
    }
    assert_int_equal(failures, 0);
}

/* Of a cube with 4^n elements per face, at 1e-2. The far field is settled high up in the trees: what grows is
 * the number of elements along the edges, 2^n. */
static void test_growth(void **state)
{
    (void)state;
    size_t before = 0;
    for (int subdivide = 3; subdivide <= 5; subdivide++) {
        hpr_room room = room_open(2);
        const mixed *m = &mixed_cubes[0];
        room_add_box(&room, 1, 1, 1, m->reflectance, m->exitance, -1);
        hpr_solution *solution = solved(&room, 1, subdivide, 1e-2);
        size_t links = hpr_solution_summary(solution)->link_count;
        double exponent = before ? log((double)links / (double)before) / log(4) : 0;
        print_message("%zu elements: %zu links, exponent %.2f\n",
                      hpr_solution_summary(solution)->element_count, links, exponent);
        if (before && !(exponent <= 0.9)) /* observed: 0.74, 0.65 */
            fail_msg("%zu links after %zu: exponent %.2f", links, before, exponent);
        before = links;
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
}

/* A closed box with its links, and the moments of what arrives if all faces send. */
typedef struct linked_box {
    hpr_room room;
    hpr_solution *solution;
    hpr_coverage *coverage;
    hpr_links *links;
    double *sent, *received; /* [dofs] */
} linked_box;

static linked_box box_of_links(double tolerance)
{
    linked_box b = {.room = room_open(2)};
    const mixed *m = &mixed_cubes[0];
    const bool sends[6] = {true, true, true, true, true, true};
    const hpr_links_demand demand = {.link_tolerance = tolerance, .sends = sends};
    room_add_box(&b.room, 1, 1, 1, m->reflectance, m->exitance, -1);
    b.solution = solved(&b.room, 2, 3, tolerance);
    const hpr_elements *e = b.solution->elements;
    assert_int_equal(hpr_coverage_create(b.solution->patches, e, &b.coverage), HPR_OK);
    assert_int_equal(hpr_links_assemble(b.coverage, e, &demand, &b.links), HPR_OK);
    b.sent = calloc(e->dof[e->leaf_count], sizeof *b.sent);
    b.received = calloc(e->dof[e->leaf_count], sizeof *b.received);
    return b;
}

/* exitance [patches]: what leaves them. */
static void send_constants(linked_box *b, const double *exitance)
{
    const hpr_elements *e = b->solution->elements;
    hpr_operator *op = NULL;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        uint32_t node = e->leaf[leaf];
        b->sent[e->dof[leaf]] = exitance[e->patch[node]] * sqrt(e->area_m2[node]);
    }
    assert_int_equal(hpr_operator_create(b->links, 1, &op), HPR_OK);
    hpr_operator_apply(op, b->sent, b->received);
    hpr_operator_destroy(&op);
}

static void close_box(linked_box *b)
{
    free(b->sent);
    free(b->received);
    hpr_links_destroy(&b->links);
    hpr_coverage_destroy(&b->coverage);
    hpr_solution_destroy(&b->solution);
    room_close(&b->room);
}

/* sum_j sqrt(A_j) K_ij^k0 = sqrt(A_i) delta_k0 over a leaf's links and its ancestors' pushed down: the
 * operator makes 1 of 1. Links between nodes leave that out by their tolerance. */
static void test_closure(void **state)
{
    (void)state;
    static const double tolerance = 1e-6, bound = 1e-6, one[6] = {1, 1, 1, 1, 1, 1};
    linked_box b = box_of_links(tolerance);
    const hpr_elements *e = b.solution->elements;
    double worst = 0;
    send_constants(&b, one);
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t i = e->dof[leaf]; i < e->dof[leaf + 1]; i++)
            worst = fmax(worst, fabs(b.received[i] - b.sent[i]) / b.sent[e->dof[leaf]]);
    }
    print_message("%zu links: closure %.1e, bound %.0e\n", b.links->count, worst, bound);
    assert_true(worst <= bound);
    assert_true(b.links->count < e->leaf_count * e->leaf_count / 3);
    close_box(&b);
}

/* The first bounce is made of moments of direct light, by Lambert's formula on every leaf, and the links'
 * blocks are the later ones': both carry the same light from the lamps, leaf plus ancestors. */
static void test_direct_light(void **state)
{
    (void)state;
    static const double tolerance = 1e-6, bound = 1e-6;
    linked_box b = box_of_links(tolerance);
    const hpr_elements *e = b.solution->elements;
    size_t dofs = e->dof[e->leaf_count], short_count = 0;
    double *direct = calloc(3 * dofs, sizeof *direct), difference2 = 0, norm2 = 0;
    hpr_direct *lamps = NULL;
    send_constants(&b, mixed_cubes[0].exitance);
    assert_int_equal(hpr_direct_create(b.solution->patches, e, &lamps), HPR_OK);
    assert_int_equal(hpr_direct_moments(lamps, b.coverage, e, tolerance, tolerance, direct, &short_count),
                     HPR_OK);
    for (size_t i = 0; i < dofs; i++) {
        difference2 += (b.received[i] - direct[i]) * (b.received[i] - direct[i]);
        norm2 += direct[i] * direct[i];
    }
    double error = sqrt(difference2 / norm2);
    print_message("%zu lamps: direct light differs from the links' by %.1e, bound %.0e\n",
                  hpr_direct_emitter_count(lamps), error, bound);
    assert_int_equal(short_count, 0);
    assert_true(error <= bound);
    hpr_direct_destroy(&lamps);
    free(direct);
    close_box(&b);
}

/* Constants in a furnace: near elements are linked many at once, so that there are about as many links as
 * elements, where pairs of leaves are 16 million. Observed: an error of 2e-9, 8328 links, 0.73 of all blocks.
 */
static void test_constants(void **state)
{
    (void)state;
    static const double bound = 1e-8;
    const double rho[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, exitance[6] = {1, 1, 1, 1, 1, 1};
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1, 1, rho, exitance, -1);
    hpr_solution *solution = solved(&room, 0, 5, 1e-7);
    const hpr_solve_summary *summary = hpr_solution_summary(solution);
    double error = room_furnace_error(&room, solution, 0.5);
    double pairs = 15 * pow((double)summary->element_count / 6, 2);
    print_message("%zu elements, %zu links, %.2f of all blocks: error of B %.1e\n", summary->element_count,
                  summary->link_count, (double)summary->block_bytes / (sizeof(double) * pairs), error);
    assert_true(error <= bound);
    assert_true(summary->link_count <= 2 * summary->element_count);
    assert_true((double)summary->block_bytes <= 0.8 * sizeof(double) * pairs);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* A black room: no link, no block. */
static void test_black_room(void **state)
{
    (void)state;
    const double reflectance[6] = {0}, exitance[6] = {1, 0, 0, 0, 0, 0};
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1, 1, reflectance, exitance, -1);
    hpr_solution *solution = solved(&room, 1, 1, 0);
    assert_int_equal(hpr_solution_summary(solution)->link_count, 0);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* With an argument only the scenes against all pairs whose names begin so, dear ones too. */
int main(int argc, char **argv)
{
    char *wanted = argc > 1 ? argv[1] : NULL;
    const struct CMUnitTest some[] = {cmocka_unit_test_prestate(test_against_all_pairs, wanted)};
    if (wanted)
        return cmocka_run_group_tests(some, NULL, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_growth),       cmocka_unit_test(test_closure),
        cmocka_unit_test(test_direct_light), cmocka_unit_test(test_constants),
        cmocka_unit_test(test_black_room),   cmocka_unit_test(test_against_all_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
