/* View factors of models: closed forms, and one thing computed two ways. */
#include "failing_allocator.h"
#include "link/form_factors.h"
#include "shapes.h"
#include "solver/exchange.h"

#include <stdio.h>

/* Howell C-11 and C-14 for unit squares: face to face at distance 1, and with a common edge at a right angle.
 */
static const double opposite = 0.19982489569838738, adjacent = 0.20004377607540316;

static void add(hpr_model *model, hpr_surface_kind kind, const double *corner, size_t count, uint32_t base,
                uint32_t combine)
{
    hpr_surface s = {.kind = kind,
                     .corner_count = count,
                     .base = base,
                     .combine = combine,
                     .emissivity = 0.5,
                     .name = (char[]){"s"}};
    memcpy(s.corner, corner, count * sizeof s.corner[0]);
    assert_int_equal(hpr_model_add(model, &s), HPR_OK);
}

/* The square [0,1]^2 at z, facing up or down. */
static void add_plate(hpr_model *model, double z, bool up)
{
    const double above[] = {0, 0, z, 1, 0, z, 1, 1, z, 0, 1, z};
    const double below[] = {0, 0, z, 0, 1, z, 1, 1, z, 1, 0, z};
    add(model, HPR_SURFACE_RADIATES, up ? above : below, 4, HPR_NONE, HPR_NONE);
}

static hpr_model *begin(hpr_context *ctx)
{
    hpr_model *model = NULL;
    assert_int_equal(hpr_model_create(ctx, "model", &model), HPR_OK);
    return model;
}

/* The unit cube, fronts inside: z = 0, z = 1, x = 0, x = 1, y = 0, y = 1. */
static hpr_model *cube(hpr_context *ctx)
{
    static const double walls[4][12] = {{0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1},
                                        {1, 0, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0},
                                        {0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 0},
                                        {0, 1, 0, 1, 1, 0, 1, 1, 1, 0, 1, 1}};
    hpr_model *model = begin(ctx);
    add_plate(model, 0, true);
    add_plate(model, 1, false);
    for (int i = 0; i < 4; i++)
        add(model, HPR_SURFACE_RADIATES, walls[i], 4, HPR_NONE, HPR_NONE);
    return model;
}

/* Checks the model, makes rows and factors, destroys the model. */
static hpr_form_factors *factors_of(hpr_model *model, double tolerance, hpr_rows **keep)
{
    hpr_rows *rows = NULL;
    hpr_form_factors *factors = NULL;
    if (hpr_model_check(model) != HPR_OK)
        fail_msg("%s", hpr_context_error(model->context));
    assert_int_equal(hpr_rows_of_model(model, &rows), HPR_OK);
    assert_int_equal(hpr_form_factors_create(rows, tolerance, &factors), HPR_OK);
    assert_int_equal(factors->done.short_count, 0);
    hpr_model_destroy(&model);
    if (keep)
        *keep = rows;
    else
        hpr_rows_destroy(&rows);
    return factors;
}

static void near(const hpr_form_factors *factors, size_t i, size_t j, double exchange, double tolerance)
{
    double value = hpr_form_factors_at(factors, i, j);
    if (!(fabs(value - exchange) <= tolerance))
        fail_msg("A F [%zu][%zu] = %.17g, expected %.17g, off by %.2g, more than %.2g", i, j, value, exchange,
                 fabs(value - exchange), tolerance);
}

/* Worst error seen at 1e-12: 4e-16. */
static void cube_has_its_closed_forms(void **state)
{
    hpr_context *ctx = *state;
    hpr_form_factors *factors = factors_of(cube(ctx), 1e-12, NULL);
    assert_int_equal(factors->count, 6);
    for (size_t i = 0; i < 6; i++) {
        for (size_t j = 0; j < 6; j++)
            near(factors, i, j, i == j ? 0 : i / 2 == j / 2 ? opposite : adjacent, 1e-12);
    }
    hpr_form_factors_destroy(&factors);
}

/* A quarter of the lower plate sees A F that the whole one lacks; rows refer to their own area. */
static void unequal_areas_are_reciprocal(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    const double half[] = {0, 0, 0, 0.5, 0, 0, 0.5, 1, 0, 0, 1, 0};
    add(model, HPR_SURFACE_RADIATES, half, 4, HPR_NONE, HPR_NONE);
    add_plate(model, 1, false);
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL);
    double row[2][2];
    for (size_t i = 0; i < 2; i++)
        hpr_form_factors_row(factors, i, row[i]);
    near(factors, 0, 1, opposite / 2, 1e-12); /* by symmetry */
    assert_true(row[0][1] * 0.5 == hpr_form_factors_at(factors, 0, 1));
    assert_true(row[1][0] == hpr_form_factors_at(factors, 1, 0));
    hpr_form_factors_destroy(&factors);
}

/* A trapezoid and the triangle that completes it to the unit square. */
static void quads_that_are_no_parallelograms(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    const double trapezoid[] = {0, 0, 0, 1, 0, 0, 0.25, 1, 0, 0, 1, 0};
    const double triangle[] = {1, 0, 0, 1, 1, 0, 0.25, 1, 0};
    add(model, HPR_SURFACE_RADIATES, trapezoid, 4, HPR_NONE, HPR_NONE);
    add(model, HPR_SURFACE_RADIATES, triangle, 3, HPR_NONE, HPR_NONE);
    add_plate(model, 1, false);
    hpr_rows *rows;
    hpr_form_factors *factors = factors_of(model, 1e-12, &rows);
    assert_int_equal(rows->patches->count, 4);
    assert_int_equal(hpr_rows_composite(rows), 0);
    assert_true(rows->row[0].area_m2 == 0.625);
    near(factors, 0, 0, 0, 0);
    double sum = hpr_form_factors_at(factors, 0, 2) + hpr_form_factors_at(factors, 1, 2);
    if (fabs(sum - opposite) > 1e-12)
        fail_msg("the parts sum to %.17g, the whole is %.17g", sum, opposite);
    hpr_form_factors_destroy(&factors);
    hpr_rows_destroy(&rows);
}

static const double window[] = {0.25, 0.25, 0, 0.75, 0.25, 0, 0.75, 0.5, 0, 0.25, 0.5, 0};
static const double shutter[] = {0.25, 0.5, 0, 0.75, 0.5, 0, 0.75, 0.25, 0, 0.25, 0.25, 0};

/* The window's own factors, the wall's as the difference to the whole wall, and closure. */
static void a_subsurface_is_taken_out_of_its_base(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = cube(ctx);
    add(model, HPR_SURFACE_RADIATES, window, 4, 0, HPR_NONE);
    hpr_model *alone = begin(ctx);
    add(alone, HPR_SURFACE_RADIATES, window, 4, HPR_NONE, HPR_NONE);
    add_plate(alone, 1, false);
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL), *pair = factors_of(alone, 1e-12, NULL);
    double part = hpr_form_factors_at(pair, 0, 1), row[7];
    assert_int_equal(factors->count, 7);
    near(factors, 6, 1, part, 1e-12);
    near(factors, 0, 1, opposite - part, 1e-12);
    near(factors, 0, 6, 0, 0);
    assert_true(fabs(factors->area_m2[0] - 0.875) < 1e-15);
    for (size_t i = 0; i < 7; i++) {
        double sum = 0;
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < 7; j++)
            sum += row[j];
        if (fabs(sum - 1) > 7e-12)
            fail_msg("row %zu sums to 1%+.2g", i, sum - 1);
    }
    hpr_form_factors_destroy(&factors);
    hpr_form_factors_destroy(&pair);
}

static void a_mask_sees_its_base_only(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = cube(ctx), *with_window = cube(ctx);
    add(model, HPR_SURFACE_MASKS, shutter, 4, 0, HPR_NONE);
    add(with_window, HPR_SURFACE_RADIATES, window, 4, 0, HPR_NONE);
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL),
                     *expected = factors_of(with_window, 1e-12, NULL);
    double row[7];
    hpr_form_factors_row(factors, 6, row);
    for (size_t j = 0; j < 7; j++)
        assert_true(row[j] == (j == 0));
    assert_true(factors->area_m2[6] == 0.125);
    assert_true(fabs(factors->area_m2[0] - 1) < 1e-15);
    for (size_t j = 1; j < 6; j++)
        near(factors, 0, j, hpr_form_factors_at(expected, 0, j), 1e-12); /* cut in another order */
    hpr_form_factors_destroy(&factors);
    hpr_form_factors_destroy(&expected);
}

/* A wall with a hole between two plates: what passes the hole is what a frame of four walls lets pass. */
static void a_hole_lets_light_through(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx), *frame = begin(ctx);
    static const double sheet[] = {-1, -1, 0, 2, -1, 0, 2, 2, 0, -1, 2, 0};
    static const double bars[4][12] = {{-1, -1, 0, 2, -1, 0, 2, 0.25, 0, -1, 0.25, 0},
                                       {-1, 0.5, 0, 2, 0.5, 0, 2, 2, 0, -1, 2, 0},
                                       {-1, 0.25, 0, 0.25, 0.25, 0, 0.25, 0.5, 0, -1, 0.5, 0},
                                       {0.75, 0.25, 0, 2, 0.25, 0, 2, 0.5, 0, 0.75, 0.5, 0}};
    hpr_model *both[] = {model, frame};
    for (int i = 0; i < 2; i++) {
        add_plate(both[i], -0.5, true);
        add_plate(both[i], 0.5, false);
    }
    add(model, HPR_SURFACE_OBSTRUCTS, sheet, 4, HPR_NONE, HPR_NONE);
    add(model, HPR_SURFACE_IS_ABSENT, window, 4, 2, HPR_NONE);
    for (int i = 0; i < 4; i++)
        add(frame, HPR_SURFACE_OBSTRUCTS, bars[i], 4, HPR_NONE, HPR_NONE);
    hpr_form_factors *factors = factors_of(model, 1e-7, NULL), *expected = factors_of(frame, 1e-7, NULL);
    double value = hpr_form_factors_at(expected, 0, 1);
    assert_int_equal(factors->count, 2);
    assert_true(value > 0.001 && value < 0.5 * opposite);
    near(factors, 0, 1, value, 2e-7 * value);
    hpr_form_factors_destroy(&factors);
    hpr_form_factors_destroy(&expected);
}

/* A quarter of the way is blocked by a square in a corner. The hidden part is bounded by single lines of
 * sight, so a product rule finds it: Gauss, 28 nodes per axis, all digits agree with 20 nodes. */
static void an_obstruction_hides(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    static const double square[] = {0, 0, 0.5, 0.5, 0, 0.5, 0.5, 0.5, 0.5, 0, 0.5, 0.5};
    add_plate(model, 0, true);
    add_plate(model, 1, false);
    add(model, HPR_SURFACE_OBSTRUCTS, square, 4, HPR_NONE, HPR_NONE);
    hpr_form_factors *factors = factors_of(model, 1e-9, NULL);
    assert_int_equal(factors->count, 2);
    near(factors, 0, 1, 0.1498686717737906, 1e-10);
    hpr_form_factors_destroy(&factors);
}

/* A subsurface that fills its base leaves nothing of it. */
static void a_base_may_be_filled(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    add_plate(model, 0, true);
    add_plate(model, 0, true);
    add_plate(model, 1, false);
    model->surface[1].base = 0;
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL);
    near(factors, 0, 2, 0, 0);
    near(factors, 1, 2, opposite, 1e-12);
    assert_true(factors->area_m2[0] == 0);
    hpr_form_factors_destroy(&factors);
}

/* Floor and one wall in one row: its diagonal is what they exchange, twice. */
static void combined_surfaces_share_a_row(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = cube(ctx);
    model->surface[2].combine = 0;
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL);
    assert_int_equal(factors->count, 5);
    assert_true(factors->area_m2[0] == 2);
    near(factors, 0, 0, 2 * adjacent, 2e-12);
    near(factors, 0, 1, opposite + adjacent, 2e-12);
    near(factors, 0, 2, opposite + adjacent, 2e-12);
    near(factors, 0, 3, 2 * adjacent, 2e-12);
    hpr_form_factors_destroy(&factors);
}

/* What has no area, or was there before, keeps a row of zeros. */
static void dropping_never_renumbers(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    const double line[] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
    const double turned[] = {1, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
    add(model, HPR_SURFACE_RADIATES, line, 3, HPR_NONE, HPR_NONE);
    add_plate(model, 0, true);
    add(model, HPR_SURFACE_RADIATES, turned, 4, HPR_NONE, HPR_NONE);
    add_plate(model, 1, false);
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL);
    double row[4];
    for (size_t i = 0; i < 4; i += 2) {
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < 4; j++)
            assert_true(row[j] == 0);
    }
    near(factors, 1, 3, opposite, 1e-12);
    hpr_form_factors_destroy(&factors);
}

static void threads_do_not_change_a_bit(void **state)
{
    double first[3] = {0};
    (void)state;
    const int threads[] = {1, 2, 7, 16};
    for (int t = 0; t < 4; t++) {
        hpr_context *ctx = shapes_context(threads[t], NULL);
        hpr_model *model = cube(ctx);
        add(model, HPR_SURFACE_RADIATES, window, 4, 0, HPR_NONE);
        hpr_form_factors *factors = factors_of(model, 1e-9, NULL);
        const double some[] = {hpr_form_factors_at(factors, 0, 1), hpr_form_factors_at(factors, 6, 3),
                               hpr_form_factors_at(factors, 2, 5)};
        if (t == 0)
            memcpy(first, some, sizeof some);
        assert_memory_equal(first, some, sizeof some);
        hpr_form_factors_destroy(&factors);
        hpr_context_destroy(&ctx);
    }
}

/* In an enclosure row i sums to its emittance: at one temperature it absorbs what it emits. */
static void exchange_factors_close_and_are_symmetric(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = cube(ctx);
    add(model, HPR_SURFACE_RADIATES, window, 4, 0, HPR_NONE);
    hpr_form_factors *factors = factors_of(model, 1e-12, NULL);
    const double e[7] = {0.5, 0.9, 1, 0.1, 0.3, 0, 0.7};
    double exchange[7][7];
    assert_int_equal(hpr_exchange_factors(factors, e, exchange[0]), HPR_OK);
    for (size_t i = 0; i < 7; i++) {
        double sum = 0;
        for (size_t j = 0; j < 7; j++) {
            double there = factors->area_m2[i] * exchange[i][j], back = factors->area_m2[j] * exchange[j][i];
            if (fabs(there - back) > 1e-14)
                fail_msg("A S [%zu][%zu] = %.17g and back %.17g", i, j, there, back);
            sum += exchange[i][j];
        }
        if (fabs(sum - e[i]) > 1e-11)
            fail_msg("row %zu sums to %.17g, expected %g", i, sum, e[i]);
    }
    hpr_form_factors_destroy(&factors);
}

/* Degree 0 is the factors; the transpose is the block of the pair the other way round. */
static void blocks_hold_the_factors(void **state)
{
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    const double triangle[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    add(model, HPR_SURFACE_RADIATES, triangle, 3, HPR_NONE, HPR_NONE);
    add_plate(model, 1, false);
    hpr_rows *rows;
    hpr_form_factors *factors = factors_of(model, 1e-12, &rows);
    enum { N = 4 };
    double block[2][2][N][N];
    hpr_pairs_done done;
    assert_int_equal(hpr_rows_composite(rows), HPR_NONE);
    assert_int_equal(hpr_form_blocks_size(rows, 1), N);
    memset(block, 0, sizeof block);
    assert_int_equal(hpr_form_blocks(rows, 1, 1e-12, block[0][0][0], &done), HPR_OK);
    double expected = hpr_form_factors_at(factors, 0, 1) / sqrt(0.5);
    assert_true(fabs(block[0][1][0][0] - expected) < 1e-12);
    for (int k = 0; k < N; k++) {
        for (int l = 0; l < N; l++) {
            assert_true(block[0][1][k][l] == block[1][0][l][k]);
            assert_true(block[0][0][k][l] == 0 && block[1][1][k][l] == 0);
        }
        assert_true(block[0][1][3][k] == 0); /* a triangle has three functions */
        assert_true(block[0][1][2][k] != 0);
    }
    hpr_form_factors_destroy(&factors);
    hpr_rows_destroy(&rows);
}

enum { CELLS = 6 };

/* Each face of the cube in CELLS x CELLS squares, turned so that no coordinate is exact. */
static hpr_model *cube_of_squares(hpr_context *ctx)
{
    static const double turn[3][3] = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}};
    hpr_model *whole = cube(ctx), *model = begin(ctx);
    for (size_t f = 0; f < 6; f++) {
        const double(*corner)[3] = (const double(*)[3])whole->surface[f].corner;
        for (int cell = 0; cell < CELLS * CELLS; cell++) {
            double square[4][3];
            for (int c = 0; c < 4; c++) {
                double s = (cell % CELLS + (c == 1 || c == 2)) / (double)CELLS, at[3];
                double t = (cell / CELLS + (c >= 2)) / (double)CELLS;
                for (int k = 0; k < 3; k++)
                    at[k] =
                        corner[0][k] + s * (corner[1][k] - corner[0][k]) + t * (corner[3][k] - corner[0][k]);
                for (int k = 0; k < 3; k++)
                    square[c][k] = turn[k][0] * at[0] + turn[k][1] * at[1] + turn[k][2] * at[2];
            }
            add(model, HPR_SURFACE_RADIATES, square[0], 4, HPR_NONE, HPR_NONE);
        }
    }
    hpr_model_destroy(&whole);
    return model;
}

/* A F of two faces, from their squares. */
static double sum_of_faces(const hpr_form_factors *factors, size_t f, size_t g)
{
    enum { PER_FACE = CELLS * CELLS };
    double sum = 0;
    for (size_t i = 0; i < PER_FACE; i++) {
        for (size_t j = 0; j < PER_FACE; j++)
            sum += hpr_form_factors_at(factors, f * PER_FACE + i, g * PER_FACE + j);
    }
    return sum;
}

/* Most pairs go eight by eight through rules whose error is foretold; worst error seen 7e-11, of faces 2e-12.
 */
static void many_squares_keep_the_tolerance_each(void **state)
{
    static const double tolerance = 1e-9;
    hpr_context *ctx = *state;
    hpr_form_factors *factors = factors_of(cube_of_squares(ctx), tolerance, NULL),
                     *exact = factors_of(cube_of_squares(ctx), 1e-13, NULL);
    double worst = 0, row[6 * CELLS * CELLS];
    for (size_t i = 0; i < factors->count; i++) {
        double sum = 0;
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < factors->count; j++) {
            double value = hpr_form_factors_at(factors, i, j), truth = hpr_form_factors_at(exact, i, j);
            bool same_face = i / (CELLS * CELLS) == j / (CELLS * CELLS);
            assert_true((value == 0) == same_face && (truth == 0) == same_face);
            if (!same_face)
                worst = fmax(worst, fabs(value / truth - 1));
            sum += row[j];
        }
        assert_true(fabs(sum - 1) <= tolerance);
    }
    print_message("worst entry off by %.1e, faces by %.1e and %.1e\n", worst,
                  fabs(sum_of_faces(factors, 0, 1) / opposite - 1),
                  fabs(sum_of_faces(factors, 0, 3) / adjacent - 1));
    assert_true(worst <= tolerance && factors->done.relative_error <= tolerance);
    assert_true(fabs(sum_of_faces(factors, 0, 1) / opposite - 1) <= tolerance);
    assert_true(fabs(sum_of_faces(factors, 0, 3) / adjacent - 1) <= tolerance);
    assert_true(factors->done.pair_count == 15 * CELLS * CELLS * CELLS * CELLS);
    hpr_form_factors_destroy(&exact);
    hpr_form_factors_destroy(&factors);
}

/* Two rows of more patches than are gone through at once: two plates in strips, all strips of each combined.
 */
static void a_row_may_have_any_number_of_patches(void **state)
{
    enum { STRIPS = HPR_FACTOR_TILE_MOST + 88 };
    hpr_context *ctx = *state;
    hpr_model *model = begin(ctx);
    for (uint32_t i = 0; i < STRIPS; i++) {
        double a = i / (double)STRIPS, b = (i + 1) / (double)STRIPS;
        const double up[] = {a, 0, 0, b, 0, 0, b, 1, 0, a, 1, 0},
                     down[] = {a, 0, 1, a, 1, 1, b, 1, 1, b, 0, 1};
        add(model, HPR_SURFACE_RADIATES, up, 4, HPR_NONE, i ? 0 : HPR_NONE);
        add(model, HPR_SURFACE_RADIATES, down, 4, HPR_NONE, i ? 1 : HPR_NONE);
    }
    hpr_form_factors *factors = factors_of(model, 1e-6, NULL);
    assert_int_equal(factors->count, 2);
    assert_int_equal(factors->done.pair_count, STRIPS * STRIPS);
    near(factors, 0, 0, 0, 0);
    near(factors, 0, 1, opposite, 1e-6 * opposite);
    hpr_form_factors_destroy(&factors);
}

static hpr_status make_factors(hpr_context *ctx, void *data)
{
    (void)data;
    hpr_model *model = NULL;
    hpr_rows *rows = NULL;
    hpr_form_factors *factors = NULL;
    hpr_status status = hpr_model_create(ctx, "model", &model);
    const double corner[][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0, 1, 0}};
    hpr_surface s = {.corner_count = 4, .base = HPR_NONE, .combine = HPR_NONE, .name = (char[]){"s"}};
    memcpy(s.corner, corner, sizeof corner);
    for (int i = 0; status == HPR_OK && i < 2; i++) {
        status = hpr_model_add(model, &s);
        s.base = 0;
        for (int k = 0; k < 4; k++)
            s.corner[k][0] = 0.1 + s.corner[k][0] / 2;
        for (int k = 0; k < 4; k++)
            s.corner[k][1] = 0.1 + s.corner[k][1] / 2;
    }
    if (status == HPR_OK)
        status = hpr_model_check(model);
    if (status == HPR_OK)
        status = hpr_rows_of_model(model, &rows);
    if (status == HPR_OK)
        status = hpr_form_factors_create(rows, 1e-6, &factors);
    hpr_form_factors_destroy(&factors);
    hpr_rows_destroy(&rows);
    hpr_model_destroy(&model);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    assert_true(sweep_allocations(make_factors, NULL, 2) > 20);
}

static int set_up(void **state)
{
    hpr_context *ctx = shapes_context(2, NULL);
    *state = ctx;
    return 0;
}

static int tear_down(void **state)
{
    hpr_context *ctx = *state;
    hpr_context_destroy(&ctx);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_has_its_closed_forms),
        cmocka_unit_test(unequal_areas_are_reciprocal),
        cmocka_unit_test(quads_that_are_no_parallelograms),
        cmocka_unit_test(a_subsurface_is_taken_out_of_its_base),
        cmocka_unit_test(a_mask_sees_its_base_only),
        cmocka_unit_test(a_hole_lets_light_through),
        cmocka_unit_test(an_obstruction_hides),
        cmocka_unit_test(a_base_may_be_filled),
        cmocka_unit_test(combined_surfaces_share_a_row),
        cmocka_unit_test(dropping_never_renumbers),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(exchange_factors_close_and_are_symmetric),
        cmocka_unit_test(blocks_hold_the_factors),
        cmocka_unit_test(many_squares_keep_the_tolerance_each),
        cmocka_unit_test(a_row_may_have_any_number_of_patches),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
