/* Patches that lie on each other are found and warned about; those that only adjoin are not. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "patch/overlap.h"
#include "rooms.h"

static const double square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

/* The pairs that overlap when the square and one other polygon are all there is. */
static size_t pairs_with(size_t count, const double (*corner)[3])
{
    hpr_room room = room_open(1);
    room_add(&room, 4, square, 0.5, 1, false);
    room_add(&room, count, corner, 0.5, 0, false);
    hpr_patches *patches = NULL;
    hpr_overlaps found;
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_overlaps_find(patches, &found), HPR_OK);
    if (found.count)
        assert_true(found.first[0] == 0 && found.first[1] == 1);
    else
        assert_true(found.first[0] == HPR_NONE && found.first[1] == HPR_NONE);
    assert_int_equal(hpr_warning_count(room.context), found.count > 0);
    hpr_patches_destroy(&patches);
    room_close(&room);
    return found.count;
}

/* The square moved, and turned over. */
static size_t pairs_with_moved(double x, double y, double z, bool over)
{
    double corner[4][3];
    for (int i = 0; i < 4; i++) {
        const double *from = square[over ? 3 - i : i];
        corner[i][0] = from[0] + x;
        corner[i][1] = from[1] + y;
        corner[i][2] = from[2] + z;
    }
    return pairs_with(4, (const double(*)[3])corner);
}

static void what_overlaps_is_found(void **state)
{
    (void)state;
    assert_int_equal(pairs_with_moved(0.5, 0.25, 0, false), 1);
    assert_int_equal(pairs_with_moved(-0.999, 0.999, 0, false), 1);
    const double inside[3][3] = {{0.2, 0.2, 0}, {0.4, 0.2, 0}, {0.2, 0.4, 0}};
    assert_int_equal(pairs_with(3, inside), 1);
    const double across[4][3] = {{-1, 0.4, 0}, {2, 0.4, 0}, {2, 0.6, 0}, {-1, 0.6, 0}};
    assert_int_equal(pairs_with(4, across), 1);
}

/* The scene is 2 m wide: it is welded within 4 float32 ulp of that, 9.5e-7. */
static void what_adjoins_is_not(void **state)
{
    (void)state;
    assert_int_equal(pairs_with_moved(1, 0, 0, false), 0);
    assert_int_equal(pairs_with_moved(1 - 4e-7, 0.5, 0, false), 0);
    assert_int_equal(pairs_with_moved(1 - 4e-6, 0.5, 0, false), 1);
    const double over_a_corner[3][3] = {{0.6, 1.3, 0}, {1.3, 0.6, 0}, {1.5, 1.5, 0}};
    assert_int_equal(pairs_with(3, over_a_corner), 1);
    const double beside[3][3] = {{0.6, 1.5, 0}, {1.5, 0.6, 0}, {1.5, 1.5, 0}};
    assert_int_equal(pairs_with(3, beside), 0);
}

static void another_plane_or_side_is_not(void **state)
{
    (void)state;
    assert_int_equal(pairs_with_moved(0.5, 0.25, 0, true), 0);
    assert_int_equal(pairs_with_moved(0.5, 0.25, 1e-4, false), 0);
    const double tilted[4][3] = {{0.5, 0, 0}, {1.5, 0, 0}, {1.5, 1, 0.01}, {0.5, 1, 0.01}};
    assert_int_equal(pairs_with(4, tilted), 0);
}

/* Three squares in a row of which the neighbours overlap, the middle one of two sides, and a back that faces
 * it from behind: said once, with the number of pairs and the first of them. */
static void a_scene_says_it_once(void **state)
{
    (void)state;
    const double second[4][3] = {{0.8, 0, 0}, {1.8, 0, 0}, {1.8, 1, 0}, {0.8, 1, 0}};
    const double third[4][3] = {{1.6, 0, 0}, {2.6, 0, 0}, {2.6, 1, 0}, {1.6, 1, 0}};
    const double under[4][3] = {{1.7, 1, 0}, {1.75, 1, 0}, {1.75, 0.1, 0}, {1.7, 0.1, 0}};
    hpr_room room = room_open(1);
    room_add(&room, 4, third, 0.5, 0, false);
    room_add(&room, 4, square, 0.5, 1, false);
    room_add(&room, 4, second, 0.5, 0, true);
    room_add(&room, 4, under, 0.5, 0, false);
    hpr_solution *solution = room_solve(&room, 0, 0);
    assert_int_equal(hpr_warning_count(room.context), 1);
    const char *text = hpr_warning_text(room.context, 0);
    print_message("%s\n", text);
    assert_non_null(strstr(text, ": 3 pairs of patches"));
    assert_non_null(
        strstr(text, "the first are patch 0 (node 0, primitive 0) and patch 2 (node 2, primitive 0)"));
    hpr_solution_destroy(&solution);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_overlaps_is_found),
        cmocka_unit_test(what_adjoins_is_not),
        cmocka_unit_test(another_plane_or_side_is_not),
        cmocka_unit_test(a_scene_says_it_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
