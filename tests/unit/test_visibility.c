#include "places.h"

static void walls_of_a_room_see_each_other(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    for (int n = 0; n < PLACE_COUNT; n++) {
        hpr_patches *patches = turned_room(ctx, &places[n]);
        hpr_visibility *visibility = see(patches);
        uint32_t blockers[6];
        size_t count;
        for (size_t a = 0; a < 6; a++) {
            for (size_t b = 0; b < 6; b++) {
                hpr_verdict verdict = classify(visibility, patches, a, b, blockers, &count);
                if (verdict != (a == b ? HPR_SEES_NOTHING : HPR_SEES_WHOLLY) || count != 0)
                    fail_msg("place %d, walls %zu, %zu: verdict %d with %zu blockers", n, a, b, (int)verdict,
                             count);
            }
        }
        hpr_visibility_destroy(&visibility);
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    hpr_context_destroy(&ctx);
}

static void facing_away_sees_nothing(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 6);
    set_quad(patches, 0, 0, 0, 0, ex, ey);  /* up */
    set_quad(patches, 1, 0, 0, 1, ex, ey);  /* up, above 0 */
    set_quad(patches, 2, 0, 0, -1, ey, ex); /* down, below 0 */
    set_quad(patches, 3, 1, 0, 0, ex, ey);  /* coplanar neighbour of 0 */
    set_quad(patches, 4, 0, 0, 2, ey, ex);  /* down, above all */
    set_quad(patches, 5, 2, 0, 0, ez, ey);  /* normal -x, stands on 0's plane */
    hpr_visibility *visibility = see(patches);
    const int nothing = HPR_SEES_NOTHING, partly = HPR_SEES_PARTLY, wholly = HPR_SEES_WHOLLY;
    assert_int_equal(classify(visibility, patches, 0, 1, NULL, NULL), nothing);
    assert_int_equal(classify(visibility, patches, 1, 0, NULL, NULL), nothing);
    assert_int_equal(classify(visibility, patches, 0, 2, NULL, NULL), nothing);
    assert_int_equal(classify(visibility, patches, 0, 3, NULL, NULL), nothing);
    assert_int_equal(classify(visibility, patches, 2, 4, NULL, NULL), nothing);
    assert_int_equal(classify(visibility, patches, 1, 4, NULL, NULL), wholly);
    assert_int_equal(classify(visibility, patches, 0, 4, NULL, NULL), nothing); /* 1 hides it wholly */
    assert_int_equal(classify(visibility, patches, 3, 4, NULL, NULL), partly);
    assert_int_equal(classify(visibility, patches, 3, 5, NULL, NULL), wholly);
    assert_int_equal(classify(visibility, patches, 2, 5, NULL, NULL), nothing);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Two facing unit plates at z = 0 and 1 and one more patch: is it a blocker? 2 if it hides all. */
static size_t blockers_between_plates(hpr_context *ctx, const double origin[3], const double edge1[3],
                                      const double edge2[3], bool twins)
{
    hpr_patches *patches = shapes_create(ctx, twins ? 4 : 3);
    set_quad(patches, 0, 0, 0, 0, ex, ey);
    set_quad(patches, 1, 0, 0, 1, ey, ex);
    shapes_set(patches, 2, HPR_SHAPE_PARALLELOGRAM, origin, edge1, edge2);
    if (twins)
        shapes_twin(patches, 2, 3);
    hpr_visibility *visibility = see(patches);
    uint32_t blockers[4] = {HPR_NONE, HPR_NONE, HPR_NONE, HPR_NONE}, again[4];
    size_t count, without, few;
    hpr_verdict verdict = classify(visibility, patches, 0, 1, blockers, &count);
    bool hidden = verdict == HPR_SEES_NOTHING;
    assert_int_equal(verdict, hidden ? HPR_SEES_NOTHING : count ? HPR_SEES_PARTLY : HPR_SEES_WHOLLY);
    assert_true(!hidden || count == 0);
    assert_true(count <= 1);
    if (count)
        assert_int_equal(blockers[0], 2);
    assert_int_equal(classify(visibility, patches, 0, 1, NULL, &without), verdict);
    assert_int_equal(without, count);
    assert_int_equal(classify(visibility, patches, 0, 1, NULL, NULL), verdict);
    assert_int_equal(classify(visibility, patches, 1, 0, again, &few), verdict);
    assert_int_equal(few, count);
    const uint32_t others[] = {0, 1};
    hpr_facet a = facet_of(patches, 0), b = facet_of(patches, 1);
    assert_int_equal(hpr_visibility_classify(visibility, &a, &b, others, 2, again, &few), HPR_SEES_WHOLLY);
    assert_int_equal(few, 0);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    return hidden ? 2 : count;
}

static void only_what_is_between_blocks(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    const double small1[3] = {0.2, 0, 0}, small2[3] = {0, 0.2, 0}, up[3] = {0, 0, 0.4};
    const struct {
        const char *what;
        double origin[3];
        const double *edge1, *edge2;
        size_t blockers;
    } cases[] = {
        {"in the middle", {0.4, 0.4, 0.5}, small1, small2, 1},
        {"in the middle, from below", {0.4, 0.4, 0.5}, small2, small1, 1},
        {"upright in the middle", {0.4, 0.4, 0.3}, small1, up, 1},
        {"upright, standing on a plate", {0.4, 0.4, 0}, small1, up, 1},
        {"partly inside", {0.9, 0.9, 0.5}, small1, small2, 1},
        {"just above a plate", {0.4, 0.4, 1e-9}, small1, small2, 1},
        {"wholly covering", {-1, -1, 0.5}, (double[]){3, 0, 0}, (double[]){0, 3, 0}, 2},
        {"covering exactly", {0, 0, 0.5}, ex, ey, 2},
        {"covering all but a strip", {1e-9, 0, 0.5}, ex, ey, 1},
        {"covering, tilted", {-1, -1, 0.1}, (double[]){3, 0, 0.8}, (double[]){0, 3, 0}, 2},
        {"covering, tilted into a plate", {-1, -1, -0.4}, (double[]){3, 0, 0.8}, (double[]){0, 3, 0}, 1},
        {"covering, on a plate", {-1, -1, 0}, (double[]){3, 0, 0}, (double[]){0, 3, 0}, 0},
        {"beside", {1.2, 0.4, 0.5}, small1, small2, 0},
        {"beside, touching", {1, 0.4, 0.5}, small1, small2, 0},
        {"upright beside, touching", {1, 0.4, 0.3}, small2, up, 0},
        {"below", {0.4, 0.4, -0.5}, small1, small2, 0},
        {"above", {0.4, 0.4, 1.5}, small1, small2, 0},
        {"upright, hanging from a plate", {0.4, 0.4, -0.4}, small1, up, 0},
        {"on a plate", {0.4, 0.4, 0}, small1, small2, 0},
        {"at the other plate", {0.4, 0.4, 1}, small1, small2, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int twins = 0; twins < 2; twins++) {
            size_t count =
                blockers_between_plates(ctx, cases[i].origin, cases[i].edge1, cases[i].edge2, twins);
            if (count != cases[i].blockers)
                fail_msg("a patch %s: %zu blockers", cases[i].what, count);
        }
    }
    hpr_context_destroy(&ctx);
}

/* Inside the box around two small facets at opposite corners, yet outside the shaft between them. */
static void beside_the_shaft_does_not_block(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 4);
    const double small1[3] = {0.1, 0, 0}, small2[3] = {0, 0.1, 0};
    set_quad(patches, 0, 0, 0, 0, small1, small2);
    set_quad(patches, 1, 0.9, 0, 1, small2, small1);
    set_quad(patches, 2, 0.7, 0, 0.3, small1, small2); /* the shaft is at x = 0.27 ... 0.37 there */
    set_quad(patches, 3, 0.3, 0, 0.3, small1, small2);
    hpr_visibility *visibility = see(patches);
    uint32_t blockers[4];
    size_t count;
    assert_int_equal(classify(visibility, patches, 0, 1, blockers, &count), HPR_SEES_PARTLY);
    assert_int_equal(count, 1);
    assert_int_equal(blockers[0], 3);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Two squares at a right angle to a floor that they stand on and reach below: only what is above it counts.
 */
static void behind_the_plane_does_not_count(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    set_quad(patches, 0, 0, 0, 0, ex, ey);                         /* floor, up */
    set_quad(patches, 1, 2, 0, -0.5, ez, ey);                      /* faces -x, half below the floor */
    set_quad(patches, 2, 1.5, 0, -0.5, ey, (double[]){0, 0, 0.4}); /* between, wholly below the floor */
    hpr_visibility *visibility = see(patches);
    size_t count;
    assert_int_equal(classify(visibility, patches, 0, 1, NULL, &count), HPR_SEES_WHOLLY);
    assert_int_equal(classify(visibility, patches, 1, 0, NULL, &count), HPR_SEES_WHOLLY);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    patches = shapes_create(ctx, 3);
    set_quad(patches, 0, 0, 0, 0, ex, ey);
    set_quad(patches, 1, 2, 0, -0.5, ez, ey);
    set_quad(patches, 2, 1.5, -1, 0, (double[]){0, 3, 0}, ez); /* hides all that is above the floor */
    visibility = see(patches);
    assert_int_equal(classify(visibility, patches, 0, 1, NULL, &count), HPR_SEES_NOTHING);
    assert_int_equal(count, 0);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* What 30 segments between two patches say about a verdict. */
typedef struct trial {
    const place *place;
    const hpr_patches *patches;
    const hpr_visibility *visibility;
    size_t a, b;
    hpr_verdict verdict;
    bool listed[RANDOM_COUNT], used[RANDOM_COUNT];
} trial;

/* Whatever blocks some segment is listed; NOTHING means that no two points face or that one occluder blocks
 * all segments. Returns how many of those that faced were blocked. */
static size_t try_segments(trial *t, uint64_t *seed)
{
    bool hides[RANDOM_COUNT];
    size_t blocked = 0, faced = 0, occluders = hpr_visibility_occluder_count(t->visibility);
    memset(hides, true, sizeof hides);
    for (int ray = 0; ray < 30; ray++) {
        double x[3], y[3], step[3];
        point_on(t->patches, t->a, shapes_random(seed), shapes_random(seed), x);
        point_on(t->patches, t->b, shapes_random(seed), shapes_random(seed), y);
        hpr_subtract3(y, x, step);
        double slack = 1e-11 * (t->place->scale + t->place->offset * 1e-3);
        if (!(hpr_dot3(step, t->patches->normal + 3 * t->a) > slack &&
              hpr_dot3(step, t->patches->normal + 3 * t->b) < -slack))
            continue;
        faced++;
        bool any = false;
        for (uint32_t c = 0; c < occluders; c++) {
            bool blocks = hpr_visibility_blocked(t->visibility, x, y, &c, 1);
            any |= blocks;
            hides[c] &= blocks;
            t->used[c] |= blocks;
            if (blocks && t->verdict != HPR_SEES_NOTHING && !t->listed[c])
                fail_msg("%u blocks %zu - %zu, but is not listed", c, t->a, t->b);
        }
        blocked += any;
    }
    bool hidden = false;
    for (uint32_t c = 0; c < occluders; c++)
        hidden |= hides[c];
    if (faced && t->verdict == HPR_SEES_NOTHING && !hidden)
        fail_msg("%zu and %zu face each other past every occluder, verdict: nothing", t->a, t->b);
    return faced ? blocked : 0;
}

static void classify_is_conservative(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 11;
    size_t verdicts[3] = {0}, listed = 0, needed = 0, hidden = 0;
    for (int n = 0; n < PLACE_COUNT; n++) {
        hpr_patches *patches = random_scene(ctx, &seed, &places[n]);
        hpr_visibility *visibility = see(patches);
        for (int m = 0; m < 1500; m++) {
            trial t = {.place = &places[n], .patches = patches, .visibility = visibility};
            t.a = (size_t)(shapes_random(&seed) * RANDOM_COUNT);
            t.b = (size_t)(shapes_random(&seed) * RANDOM_COUNT);
            uint32_t blockers[RANDOM_COUNT];
            size_t count;
            t.verdict = classify(visibility, patches, t.a, t.b, blockers, &count);
            verdicts[t.verdict]++;
            listed += count;
            for (size_t i = 0; i < count; i++) {
                assert_true(i == 0 || blockers[i] > blockers[i - 1]);
                t.listed[blockers[i]] = true;
            }
            size_t blocked = try_segments(&t, &seed);
            hidden += t.verdict == HPR_SEES_NOTHING && blocked;
            for (uint32_t c = 0; c < RANDOM_COUNT && t.verdict != HPR_SEES_NOTHING; c++)
                needed += t.used[c];
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    print_message("verdicts: nothing %zu (%zu hidden by one), wholly %zu, partly %zu; %zu blockers listed, "
                  "%zu seen to block\n",
                  verdicts[0], hidden, verdicts[1], verdicts[2], listed, needed);
    assert_true(verdicts[0] > 500 && verdicts[1] > 50 && verdicts[2] > 500 && hidden > 20);
    assert_true(10 * listed < 25 * needed);
    hpr_context_destroy(&ctx);
}

/* The wall comes first, so its corners stand for the floor's, 1e-8 lower but within welding. */
static void welded_off_its_plane_does_not_hide_itself(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    patches->weld_m = 1e-7;
    set_quad(patches, 0, 0, 0, 1e-8, ey, ez); /* a wall, normal x */
    set_quad(patches, 1, 0, 0, 0, ex, ey);    /* the floor */
    set_quad(patches, 2, 0, 0, 3, ey, ex);    /* the ceiling */
    hpr_visibility *visibility = see(patches);
    assert_int_equal(classify(visibility, patches, 1, 2, NULL, NULL), HPR_SEES_WHOLLY);
    assert_int_equal(classify(visibility, patches, 2, 1, NULL, NULL), HPR_SEES_WHOLLY);
    const uint32_t all[] = {0, 1, 2};
    const double x[3] = {0.5, 0.5, 0}, y[3] = {0.5, 0.5, 3};
    assert_int_equal(hpr_visibility_occluder_count(visibility), 3);
    assert_false(hpr_visibility_blocked(visibility, x, y, all, 3));
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(welded_off_its_plane_does_not_hide_itself),
        cmocka_unit_test(walls_of_a_room_see_each_other),
        cmocka_unit_test(facing_away_sees_nothing),
        cmocka_unit_test(only_what_is_between_blocks),
        cmocka_unit_test(beside_the_shaft_does_not_block),
        cmocka_unit_test(behind_the_plane_does_not_count),
        cmocka_unit_test(classify_is_conservative),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
