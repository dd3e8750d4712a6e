/*
 * View factors of closed rooms whose surfaces hide each other: an L-shaped prism, a cube with a box inside.
 * Rows sum to 1, pairs that see each other wholly have closed forms, and nothing sees more for what stands
 * between.
 */
#include "blocks.h"

#include "link/form_factors.h"

enum { SURFACES_MAX = 12 };

/* Of each entry, relative; rows sum to 1 within 1e-9. */
static const double demanded = 1e-10, closure = 1e-9;

/* Rectangles, corners counter-clockwise from the front. */
typedef struct room {
    int count;
    double corner[SURFACES_MAX][4][3];
} room;

/* The rectangle at `at` on the axis, low to high on the two others; it faces up the axis or down. */
static void put(room *r, int axis, bool up, double at, const double u[2], const double v[2])
{
    static const int turn[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double(*corner)[3] = r->corner[r->count++];
    for (int i = 0; i < 4; i++) {
        int k = up ? i : 3 - i;
        corner[i][axis] = at;
        corner[i][(axis + 1) % 3] = u[turn[k][0]];
        corner[i][(axis + 2) % 3] = v[turn[k][1]];
    }
}

/* Faces 2k at the low end of axis k, 2k + 1 at the high end. */
static void put_box(room *r, const double low[3], const double high[3], bool inside)
{
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        put(r, k, inside, low[k], (double[]){low[a], high[a]}, (double[]){low[b], high[b]});
        put(r, k, !inside, high[k], (double[]){low[a], high[a]}, (double[]){low[b], high[b]});
    }
}

/* Of the surfaces [first, end). */
static hpr_form_factors *factors_of(const room *r, const int *which, int count)
{
    hpr_model *model = NULL;
    hpr_rows *rows = NULL;
    hpr_form_factors *factors = NULL;
    assert_int_equal(hpr_model_create(bench.context, "room", &model), HPR_OK);
    for (int i = 0; i < count; i++) {
        hpr_surface s = {.kind = HPR_SURFACE_RADIATES,
                         .corner_count = 4,
                         .base = HPR_NONE,
                         .combine = HPR_NONE,
                         .emissivity = 0.5,
                         .name = (char[]){"s"}};
        memcpy(s.corner, r->corner[which ? which[i] : i], sizeof r->corner[0]);
        assert_int_equal(hpr_model_add(model, &s), HPR_OK);
    }
    assert_int_equal(hpr_model_check(model), HPR_OK);
    assert_int_equal(hpr_rows_of_model(model, &rows), HPR_OK);
    assert_int_equal(hpr_form_factors_create(rows, demanded, &factors), HPR_OK);
    print_message("%zu short\n", factors->done.short_count);
    hpr_rows_destroy(&rows);
    hpr_model_destroy(&model);
    return factors;
}

static void assert_closed(const char *name, const hpr_form_factors *factors)
{
    double row[SURFACES_MAX], worst = 0;
    for (size_t i = 0; i < factors->count; i++) {
        double sum = -1;
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < factors->count; j++)
            sum += row[j];
        worst = fmax(worst, fabs(sum));
    }
    print_message("%s: %zu pairs, %zu of them blocked, rows sum to 1 within %.1e, bound %.0e\n", name,
                  factors->done.pair_count, factors->done.blocked_count, worst, closure);
    assert_true(factors->done.blocked_count > 0);
    assert_true(worst <= closure);
}

/* 0 <= F <= F of the pair alone; the pair alone may err by what is demanded. */
static void assert_between_zero_and_unblocked(const room *r, const hpr_form_factors *factors)
{
    int hidden = 0;
    for (int i = 0; i < r->count; i++) {
        for (int j = i + 1; j < r->count; j++) {
            hpr_form_factors *alone = factors_of(r, (int[]){i, j}, 2);
            double blocked = hpr_form_factors_at(factors, (size_t)i, (size_t)j);
            double open = hpr_form_factors_at(alone, 0, 1);
            if (!(blocked >= 0 && blocked <= open * (1 + 2 * demanded)))
                fail_msg("surfaces %d, %d: A F %.17g, %.17g without the others", i, j, blocked, open);
            hidden += blocked < 0.999 * open;
            hpr_form_factors_destroy(&alone);
        }
    }
    print_message("%d pairs lose more than a thousandth to what stands between\n", hidden);
    assert_true(hidden > 0);
}

static void assert_exchange(const char *what, const hpr_form_factors *factors, size_t i, size_t j,
                            double exact)
{
    double got = hpr_form_factors_at(factors, i, j), error = fabs(got / exact - 1);
    print_message("%-48s %.15g, error %.1e, bound %.0e\n", what, got, error, 2 * demanded);
    assert_true(error <= 2 * demanded);
}

/*
 * Height 1 over [0,2] x [0,1] and [0,1] x [1,2]: walls x = 0, y = 0, x = 2, y = 1, x = 1, y = 2 in this
 * order, then the floors and ceilings of both arms.
 */
static room l_room(void)
{
    const double one[2] = {0, 1}, two[2] = {0, 2}, beyond[2] = {1, 2};
    room r = {0};
    put(&r, 0, true, 0, two, one);
    put(&r, 1, true, 0, one, two);
    put(&r, 0, false, 2, one, one);
    put(&r, 1, false, 1, one, beyond);
    put(&r, 0, false, 1, beyond, one);
    put(&r, 1, false, 2, one, one);
    put(&r, 2, true, 0, two, one);
    put(&r, 2, true, 0, one, beyond);
    put(&r, 2, false, 1, two, one);
    put(&r, 2, false, 1, one, beyond);
    return r;
}

static void l_shaped_room(void **state)
{
    (void)state;
    const double one[2] = {0, 1}, two[2] = {0, 2}, beyond[2] = {1, 2};
    room r = l_room();
    hpr_form_factors *factors = factors_of(&r, NULL, r.count);
    assert_closed("L-shaped room", factors);
    /* the lines of sight between their far ends graze the inner edge */
    assert_exchange("the long walls", factors, 0, 1, exchange_perpendicular(two, one, two, one));
    assert_exchange("long wall and the inner wall opposite", factors, 1, 3,
                    exchange_parallel(beyond, one, two, one, 1));
    assert_exchange("the other long wall and its inner wall", factors, 0, 4,
                    exchange_parallel(beyond, one, two, one, 1));
    assert_exchange("floor and ceiling of one arm", factors, 6, 8, exchange_parallel(two, one, two, one, 1));
    assert_exchange("floor of one arm and the end of it", factors, 6, 2,
                    exchange_perpendicular(two, one, one, one));
    assert_exchange("floor of one arm and the inner wall over it", factors, 6, 3,
                    exchange_perpendicular(one, two, one, beyond));
    assert_true(hpr_form_factors_at(factors, 3, 4) == 0); /* the inner walls: a convex edge */
    /* the end walls: every line of sight but one passes behind the inner edge */
    print_message("end walls: A F %g\n", hpr_form_factors_at(factors, 2, 5));
    assert_true(hpr_form_factors_at(factors, 2, 5) == 0);
    /* floors and ceilings change places in a mirror */
    assert_exchange("floor and ceiling of different arms", factors, 6, 9, hpr_form_factors_at(factors, 7, 8));
    assert_between_zero_and_unblocked(&r, factors);
    hpr_form_factors_destroy(&factors);
}

/* Faces 0 to 5 are the room's, 6 to 11 the box's. */
static room cube_with_box(const double low[3], const double high[3])
{
    room r = {0};
    put_box(&r, (double[]){0, 0, 0}, (double[]){3, 3, 3}, true);
    put_box(&r, low, high, false);
    return r;
}

/* A box face sees wholly the wall opposite, and of the four beside that what rises over its own plane. */
static void assert_box_rows(const hpr_form_factors *factors, const double low[3], const double high[3])
{
    const double whole[2] = {0, 3};
    for (int k = 0; k < 6; k++) {
        int axis = k / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
        const double u[2] = {low[a], high[a]}, v[2] = {low[b], high[b]};
        double gap = k % 2 ? 3 - high[axis] : low[axis];
        const double rise[2] = {0, gap}, u_back[2] = {3 - u[1], 3 - u[0]}, v_back[2] = {3 - v[1], 3 - v[0]};
        size_t face = (size_t)(6 + k);
        assert_exchange("box face and the wall opposite", factors, face, (size_t)k,
                        exchange_parallel(u, v, whole, whole, gap));
        assert_exchange("box face and a wall beside", factors, face, (size_t)(2 * a),
                        exchange_perpendicular(u, v, rise, whole));
        assert_exchange("box face and a wall beside", factors, face, (size_t)(2 * a + 1),
                        exchange_perpendicular(u_back, v, rise, whole));
        assert_exchange("box face and a wall beside", factors, face, (size_t)(2 * b),
                        exchange_perpendicular(v, u, rise, whole));
        assert_exchange("box face and a wall beside", factors, face, (size_t)(2 * b + 1),
                        exchange_perpendicular(v_back, u, rise, whole));
    }
}

static void cube_with_a_box_in_its_middle(void **state)
{
    (void)state;
    const double low[3] = {1, 1, 1}, high[3] = {2, 2, 2};
    room r = cube_with_box(low, high);
    hpr_form_factors *factors = factors_of(&r, NULL, r.count);
    assert_closed("cube with a box in its middle", factors);
    assert_box_rows(factors, low, high);
    /* What the box takes from a wall is known, and the wall's other exchange is with 1 wall opposite and 4
     * equal ones beside. Each is symmetric to all of its kind. */
    double opposite = hpr_form_factors_at(factors, 0, 1), beside = hpr_form_factors_at(factors, 0, 2),
           worst = 0;
    double box = 0;
    for (size_t j = 6; j < 12; j++)
        box += hpr_form_factors_at(factors, 0, j);
    for (size_t i = 0; i < 6; i++) {
        for (size_t j = i + 1; j < 6; j++) {
            double expected = i / 2 == j / 2 ? opposite : beside;
            worst = fmax(worst, fabs(hpr_form_factors_at(factors, i, j) / expected - 1));
        }
    }
    print_message(
        "wall: %.12g to the wall opposite, %.12g to each beside, %.12g to the box; symmetric within "
        "%.1e, bound %.0e\n",
        opposite, beside, box, worst, 2 * demanded);
    assert_true(worst <= 2 * demanded);
    assert_between_zero_and_unblocked(&r, factors);
    hpr_form_factors_destroy(&factors);
}

static void cube_with_a_box_aside(void **state)
{
    (void)state;
    const double low[3] = {0.5, 1.25, 0.25}, high[3] = {1.25, 2.5, 1.5};
    room r = cube_with_box(low, high);
    hpr_form_factors *factors = factors_of(&r, NULL, r.count);
    assert_closed("cube with a box aside", factors);
    assert_box_rows(factors, low, high);
    assert_between_zero_and_unblocked(&r, factors);
    hpr_form_factors_destroy(&factors);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(l_shaped_room),
        cmocka_unit_test(cube_with_a_box_in_its_middle),
        cmocka_unit_test(cube_with_a_box_aside),
    };
    return cmocka_run_group_tests(tests, bench_open, bench_close);
}
