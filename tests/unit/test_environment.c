/* The open part V of a point's view: closed forms where there are some, and rays where there are none. */
#include "shapes.h"

#include "direct/environment.h"
#include "link/environment_moments.h"
#include "rectangle.h"

/* Sums of a few terms near 1, and atan2 of nearly parallel vectors near edges: worst seen 9e-16. */
static const double rounding = 1e-14;

static void set_rectangle(hpr_patches *patches, size_t i, const rectangle *r, bool down)
{
    const double origin[3] = {r->x0, r->y0, r->z};
    const double x[3] = {r->x1 - r->x0, 0, 0}, y[3] = {0, r->y1 - r->y0, 0};
    shapes_set(patches, i, HPR_SHAPE_PARALLELOGRAM, origin, down ? y : x, down ? x : y);
}

/* A view that is looked at from points: patch 0 is the unit square at z = 0, facing up. */
typedef struct scenery {
    hpr_context *context;
    hpr_patches *patches;
    hpr_elements *elements;
    hpr_environment *environment;
} scenery;

static const rectangle ground = {0, 1, 0, 1, 0};

static scenery scenery_of(size_t count, const rectangle *above)
{
    scenery s = {.context = shapes_context(1, NULL)};
    s.patches = shapes_create(s.context, count + 1);
    set_rectangle(s.patches, 0, &ground, false);
    for (size_t i = 0; i < count; i++)
        set_rectangle(s.patches, i + 1, &above[i], i % 2);
    assert_int_equal(hpr_elements_uniform(s.patches, 0, 0, &s.elements), HPR_OK);
    assert_int_equal(hpr_environment_create(s.patches, s.elements, &s.environment), HPR_OK);
    return s;
}

static void scenery_close(scenery *s)
{
    hpr_environment_destroy(&s->environment);
    hpr_elements_destroy(&s->elements);
    hpr_patches_destroy(&s->patches);
    hpr_context_destroy(&s->context);
}

static hpr_opening view_from(const scenery *s, double x, double y)
{
    return hpr_environment_opening(s->environment, 0, (hpr_vec3){x, y, 0});
}

typedef double (*expectation)(size_t count, const rectangle *above, double x, double y);

/* Compares V at random points of the ground, its border included. */
static void compare(const char *what, size_t count, const rectangle *above, expectation expected)
{
    scenery s = scenery_of(count, above);
    uint64_t seed = 5;
    double worst = 0;
    for (int i = 0; i < 200; i++) {
        double x = i < 20 ? i % 2 : shapes_random(&seed), y = shapes_random(&seed);
        hpr_opening v = view_from(&s, x, y);
        worst = fmax(worst, fabs(v.part - expected(count, above, x, y)));
        assert_true(v.error == 0);
    }
    print_message("%s: worst error %.1e, bound %.0e\n", what, worst, rounding);
    assert_true(worst <= rounding);
    scenery_close(&s);
}

static double all_open(size_t count, const rectangle *above, double x, double y)
{
    (void)count, (void)above, (void)x, (void)y;
    return 1;
}

static double all_but_each(size_t count, const rectangle *above, double x, double y)
{
    double v = 1;
    for (size_t i = 0; i < count; i++)
        v -= rectangle_part(&above[i], x, y);
    return v;
}

static double all_but_last(size_t count, const rectangle *above, double x, double y)
{
    return 1 - rectangle_part(&above[count - 1], x, y);
}

/* What two rectangles hide together: the first's shadow on the second's plane is a rectangle too. */
static double all_but_union(size_t count, const rectangle *above, double x, double y)
{
    assert_int_equal(count, 2);
    const rectangle *a = &above[0], *b = &above[1];
    double f = b->z / a->z;
    rectangle both = {fmax(b->x0, x + f * (a->x0 - x)), fmin(b->x1, x + f * (a->x1 - x)),
                      fmax(b->y0, y + f * (a->y0 - y)), fmin(b->y1, y + f * (a->y1 - y)), b->z};
    double twice = both.x1 > both.x0 && both.y1 > both.y0 ? rectangle_part(&both, x, y) : 0;
    return 1 - rectangle_part(a, x, y) - rectangle_part(b, x, y) + twice;
}

static void in_the_open_nothing_is_missing(void **state)
{
    (void)state;
    const rectangle below[1] = {{-1, 2, -1, 2, -0.5}};
    compare("nothing above", 1, below, all_open);
}

static void a_rectangle_hides_its_form_factor(void **state)
{
    (void)state;
    const rectangle wide[1] = {{-3, 4, -2, 5, 0.25}}, small[1] = {{0.4, 0.7, 0.2, 0.5, 0.1}};
    compare("wider than the ground", 1, wide, all_but_each);
    compare("small and near", 1, small, all_but_each);
}

/* Seen from the ground, the first is always in front of the second. */
static void what_is_hidden_hides_nothing_more(void **state)
{
    (void)state;
    const rectangle two[2] = {{0.25, 0.75, 0.25, 0.75, 0.5}, {-1, 2, -1, 2, 1}};
    compare("one within another's shadow", 2, two, all_but_last);
}

static void overlapping_shadows_count_once(void **state)
{
    (void)state;
    const rectangle two[2] = {{0.1, 0.8, 0.3, 1.1, 0.5}, {0.4, 1.7, -0.6, 0.6, 0.9}};
    compare("two shadows that overlap", 2, two, all_but_union);
}

/* A lattice of 16 x 16 separate squares: far more pieces than clipping keeps at once. */
static void hundreds_of_holes_are_clipped_too(void **state)
{
    (void)state;
    enum { SIDE = 16 };
    rectangle lattice[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        double x = (i % SIDE) / 8.0 - 0.5, y = (i / SIDE) / 8.0 - 0.5;
        lattice[i] = (rectangle){x, x + 0.07, y, y + 0.07, 0.3};
    }
    compare("256 squares", SIDE * SIDE, lattice, all_but_each);
}

/* Random triangles all about, single-sided or not: the mean square of what rays and clipping differ by is
 * that of the rays' noise. */
static void clipping_agrees_with_rays(void **state)
{
    (void)state;
    enum { COUNT = 120, POINTS = 300 };
    uint64_t seed = 77;
    scenery s = {.context = shapes_context(1, NULL)};
    s.patches = shapes_create(s.context, COUNT + 1);
    set_rectangle(s.patches, 0, &ground, false);
    for (size_t i = 1; i <= COUNT; i++) {
        double frame[9];
        for (int k = 0; k < 9; k++)
            frame[k] = k < 3 ? 3 * shapes_random(&seed) - 1 : shapes_random(&seed) - 0.5;
        shapes_set(s.patches, i, HPR_SHAPE_TRIANGLE, frame, frame + 3, frame + 6);
    }
    assert_int_equal(hpr_elements_uniform(s.patches, 0, 0, &s.elements), HPR_OK);
    assert_int_equal(hpr_environment_create(s.patches, s.elements, &s.environment), HPR_OK);
    double off = 0, noise = 0, least = 1, most = 0;
    for (int i = 0; i < POINTS; i++) {
        hpr_vec3 x = {shapes_random(&seed), shapes_random(&seed), 0};
        hpr_opening v = hpr_environment_opening(s.environment, 0, x);
        hpr_opening rays = hpr_environment_sample(s.environment, 0, x, 16, (uint64_t)i);
        off += (v.part - rays.part) * (v.part - rays.part);
        noise += rays.error * rays.error;
        least = fmin(least, v.part);
        most = fmax(most, v.part);
        assert_true(v.error == 0);
    }
    print_message("V from %.3f to %.3f; rays differ by %.2e, their own error %.2e\n", least, most,
                  sqrt(off / POINTS), sqrt(noise / POINTS));
    /* F-distribution with 300 and 900 degrees of freedom: the ratio is in 0.75 .. 1.3 but for one in 10^5;
     * lattices are a little better than their spread shows. */
    assert_true(off / noise > 0.5 && off / noise < 1.3);
    assert_true(most - least > 0.2);
    scenery_close(&s);
}

/* Every allocation of what this is about fails once. */
static void allocations_may_fail(void **state)
{
    (void)state;
    hpr_status status = HPR_ERR_MEMORY;
    size_t k = 0;
    for (; status != HPR_OK; k++) {
        shapes_allocator allocator = {.fail_at = SIZE_MAX};
        hpr_context *ctx = shapes_context(2, &allocator);
        hpr_patches *patches = shapes_create(ctx, 2);
        const rectangle top = {0, 2, 0, 1, 0.5};
        set_rectangle(patches, 0, &ground, false);
        set_rectangle(patches, 1, &top, true);
        hpr_elements *elements = NULL;
        hpr_coverage *coverage = NULL;
        hpr_environment *environment = NULL;
        hpr_environment_figures figures;
        double moment[8] = {0};
        assert_int_equal(hpr_elements_uniform(patches, 0, 1, &elements), HPR_OK);
        assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
        allocator.fail_at = allocator.calls + k;
        status = hpr_environment_create(patches, elements, &environment);
        if (status == HPR_OK)
            status = hpr_environment_moments(environment, coverage, elements, 1e-3, moment, &figures);
        assert_true(status == HPR_OK || status == HPR_ERR_MEMORY);
        allocator.fail_at = SIZE_MAX;
        hpr_environment_destroy(&environment);
        hpr_coverage_destroy(&coverage);
        hpr_elements_destroy(&elements);
        hpr_patches_destroy(&patches);
        hpr_context_destroy(&ctx);
        assert_int_equal(allocator.alive, 0);
    }
    assert_true(k > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(in_the_open_nothing_is_missing),
        cmocka_unit_test(a_rectangle_hides_its_form_factor),
        cmocka_unit_test(what_is_hidden_hides_nothing_more),
        cmocka_unit_test(overlapping_shadows_count_once),
        cmocka_unit_test(hundreds_of_holes_are_clipped_too),
        cmocka_unit_test(clipping_agrees_with_rays),
        cmocka_unit_test(allocations_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
