/* What of an element lies open. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "link/tree.h"
#include "rooms.h"

#include <stdlib.h>
#include <string.h>

/* A box on the floor without a bottom, its faces outward. */
static void add_leg(hpr_room *room, double x, double y, double a, double height)
{
    const double low[4][2] = {{x, y}, {x + a, y}, {x + a, y + a}, {x, y + a}};
    double top[4][3];
    for (int i = 0; i < 4; i++) {
        const double *p = low[i], *q = low[(i + 1) % 4];
        const double side[4][3] = {
            {p[0], p[1], 0}, {q[0], q[1], 0}, {q[0], q[1], height}, {p[0], p[1], height}};
        room_add(room, 4, side, 0.5, 0, false);
        top[i][0] = p[0];
        top[i][1] = p[1];
        top[i][2] = height;
    }
    room_add(room, 4, (const double(*)[3])top, 0.5, 0, false);
}

/* The legs of a few chairs: 4 x 4 of them on one element. */
static void many_legs_on_one_element_cover_their_area(void **state)
{
    (void)state;
    static const double a = 0.05, rounding = 1e-12;
    enum { SIDE = 4 };
    hpr_room room = room_open(1);
    room_add(&room, 4, (const double[4][3]){{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0.5, 1, false);
    for (int i = 0; i < SIDE * SIDE; i++) /* no two edges on one line */
        add_leg(&room, 0.1 + 0.2 * (i % SIDE) + 0.011 * (i / SIDE),
                0.1 + 0.2 * (i / SIDE) + 0.013 * (i % SIDE), a, 0.3);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(patches, 1, 0, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    int parts;
    assert_non_null(hpr_coverage_parts(coverage, 0, &parts));
    double share = hpr_coverage_open_share(coverage, 0), expected = 1 - SIDE * SIDE * a * a;
    print_message("%d parts, open %.15g, expected %.15g\n", parts, share, expected);
    assert_true(parts <= HPR_COVERAGE_PIECES && fabs(share - expected) <= rounding);
    assert_false(hpr_coverage_open(coverage, 0, 0.12, 0.12));
    assert_true(hpr_coverage_open(coverage, 0, 0.08, 0.12));
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/*
 * A floor in 64 elements of degree 1 with a leg on it that cuts four of them and covers none wholly. Pulled
 * up, B = 1 on the open part is its moments over that part; what is pushed down, H = 1, has on every leaf the
 * moments that G makes of it, from which G+ makes the coefficients again.
 */
static void inner_nodes_have_moments_over_the_open_part(void **state)
{
    (void)state;
    static const double a = 0.05, rounding = 1e-13;
    hpr_room room = room_open(1);
    room_add(&room, 4, (const double[4][3]){{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0.5, 1, false);
    add_leg(&room, 0.23, 0.24, a, 0.3);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    hpr_tree *tree = NULL;
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(patches, 1, 3, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    assert_int_equal(hpr_tree_create(coverage, elements, 2, &tree), HPR_OK);
    size_t dofs = elements->dof[elements->leaf_count];
    double *leaf = calloc(dofs, sizeof *leaf), *node = calloc(tree->dof_count, sizeof *node);
    assert_non_null(leaf);
    assert_non_null(node);
    for (size_t i = elements->patch_leaf[0]; i < elements->patch_leaf[1]; i++)
        leaf[elements->dof[i]] = sqrt(elements->area_m2[elements->leaf[i]]);
    hpr_tree_pull(tree, 0, leaf, node);
    double open = node[tree->dof[0]];
    print_message("∫_O T_0 dA on the floor: %.15g, expected %.15g\n", open, 1 - a * a);
    assert_true(hpr_tree_is_mixed(tree, 0));
    assert_true(fabs(open - (1 - a * a)) <= rounding);
    assert_true(fabs(hpr_tree_stretch(tree, 0) - 1 / (1 - a * a)) <= rounding);
    memset(node, 0, tree->dof_count * sizeof *node);
    memset(leaf, 0, dofs * sizeof *leaf);
    node[tree->dof[0]] = 1; /* T_0 = 1 / sqrt(1 m2) */
    hpr_tree_push(tree, 0, node, leaf);
    size_t cut = 0;
    for (size_t i = elements->patch_leaf[0]; i < elements->patch_leaf[1]; i++) {
        double side = sqrt(elements->area_m2[elements->leaf[i]]), *own = leaf + elements->dof[i];
        cut += own[0] < (1 - 1e-3) * side;
        assert_true(fabs(own[0] - hpr_coverage_open_share(coverage, i) * side) <= rounding);
        hpr_coverage_project(coverage, i, own);
        assert_true(fabs(own[0] - side) <= rounding && fabs(own[1]) <= rounding && fabs(own[3]) <= rounding);
    }
    assert_int_equal(cut, 4);
    free(leaf);
    free(node);
    hpr_tree_destroy(&tree);
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/* A room of 1 m, faces inward, its ceiling a lamp; in it a cupboard at the wall x = 0 and on the floor, which
 * has neither a back nor a bottom of its own, its other faces outward. lamp: M of a plate in it that faces
 * the wall. */
static void cupboard_shares(double lamp, double *floor, double *wall)
{
    static const double rho[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, shine[6] = {0, 0, 0, 0, 0, 1};
    static const double faces[4][4][3] = {{{0.4, 0.3, 0}, {0.4, 0.7, 0}, {0.4, 0.7, 0.5}, {0.4, 0.3, 0.5}},
                                          {{0, 0.3, 0}, {0.4, 0.3, 0}, {0.4, 0.3, 0.5}, {0, 0.3, 0.5}},
                                          {{0, 0.7, 0}, {0, 0.7, 0.5}, {0.4, 0.7, 0.5}, {0.4, 0.7, 0}},
                                          {{0, 0.3, 0.5}, {0.4, 0.3, 0.5}, {0.4, 0.7, 0.5}, {0, 0.7, 0.5}}};
    static const double plate[4][3] = {{0.2, 0.4, 0.2}, {0.2, 0.4, 0.4}, {0.2, 0.6, 0.4}, {0.2, 0.6, 0.2}};
    hpr_room room = room_open(2);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    room_add_box(&room, 1, 1, 1, rho, shine, -1);
    for (int i = 0; i < 4; i++)
        room_add(&room, 4, faces[i], 0.5, 0, false);
    if (lamp > 0)
        room_add(&room, 4, plate, 0.5, lamp, false);
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(patches, 1, 0, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    *wall = hpr_coverage_open_share(coverage, 0); /* x = 0 comes first, z = 0 fifth */
    *floor = hpr_coverage_open_share(coverage, 4);
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/* Floor and wall in it see each other's fronts, but no light. */
static void what_is_shut_in_behind_several_faces_is_covered(void **state)
{
    (void)state;
    static const double rounding = 1e-12;
    double floor, wall;
    cupboard_shares(0, &floor, &wall);
    print_message("floor %.15g, wall %.15g\n", floor, wall);
    assert_true(fabs(floor - (1 - 0.4 * 0.4)) <= rounding);
    assert_true(fabs(wall - (1 - 0.4 * 0.5)) <= rounding);
}

static void a_lamp_in_there_opens_it(void **state)
{
    (void)state;
    double floor, wall;
    cupboard_shares(1, &floor, &wall);
    assert_true(floor == 1 && wall == 1);
}

/* Of two sheets in one plane the first counts: the second is covered where they overlap, on both sides; a
 * single face and the sides that face it cover each other. */
static void of_sheets_the_first_counts(void **state)
{
    (void)state;
    static const double rounding = 1e-12;
    static const double first[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                        second[4][3] = {{0.5, 0, 0}, {1.5, 0, 0}, {1.5, 1, 0}, {0.5, 1, 0}},
                        face[4][3] = {{0, 0, 0}, {1.5, 0, 0}, {1.5, 0.5, 0}, {0, 0.5, 0}};
    hpr_room room = room_open(1);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    room_add(&room, 4, face, 0.5, 1, false);
    room_add(&room, 4, first, 0.5, 1, true);
    room_add(&room, 4, second, 0.5, 1, true);
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(patches->count, 5);
    assert_int_equal(hpr_elements_uniform(patches, 1, 0, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    const double expected[5] = {0, 1, 0.5, 0.5, 0.25};
    for (size_t i = 0; i < 5; i++) {
        double share = hpr_coverage_open_share(coverage, i);
        print_message("patch %zu, twin %u: open %.15g, expected %g\n", i, patches->twin[i], share,
                      expected[i]);
        assert_true(fabs(share - expected[i]) <= rounding);
    }
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_legs_on_one_element_cover_their_area),
        cmocka_unit_test(inner_nodes_have_moments_over_the_open_part),
        cmocka_unit_test(what_is_shut_in_behind_several_faces_is_covered),
        cmocka_unit_test(a_lamp_in_there_opens_it),
        cmocka_unit_test(of_sheets_the_first_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
