/* Visibility between many patches by groups, against the plain loop over all pairs and all occluders. */
#include "places.h"

#include "visibility/views.h"

/* Compares all pairs, or those with a wanted patch; counts verdicts, and blockers. */
static void compare_all(const hpr_patches *patches, const hpr_visibility *visibility, const bool *wanted,
                        const char *what, size_t verdicts[3], size_t *blocker_count)
{
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    size_t room = hpr_visibility_occluder_count(visibility);
    uint32_t *found = calloc(room + 1, sizeof *found), *expected = calloc(room + 1, sizeof *expected);
    assert_int_equal(hpr_views_create(visibility, wanted, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    for (size_t p = 0; p < patches->count; p++) {
        for (size_t q = 0; q < patches->count; q++) {
            if (wanted && !wanted[p] && !wanted[q])
                continue;
            size_t found_count = 99, expected_count = 99;
            hpr_verdict verdict = hpr_views_classify(views, cursor, p, q, found, &found_count);
            hpr_verdict plain = classify(visibility, patches, p, q, expected, &expected_count);
            if (verdict != plain || found_count != expected_count ||
                memcmp(found, expected, found_count * sizeof *found))
                fail_msg("%s: patches %zu, %zu: verdict %d past %zu, loop %d past %zu", what, p, q,
                         (int)verdict, found_count, (int)plain, expected_count);
            verdicts[verdict]++;
            *blocker_count += found_count;
        }
    }
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_views_destroy(&views);
    free(found);
    free(expected);
}

static void random_scenes_agree_with_the_plain_loop(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(2, NULL);
    uint64_t seed = 41;
    size_t verdicts[3] = {0}, blockers = 0;
    bool wanted[RANDOM_COUNT] = {[3] = true, [70] = true, [71] = true};
    for (int n = 0; n < 2 * PLACE_COUNT; n++) {
        hpr_patches *patches = random_scene(ctx, &seed, &places[n % PLACE_COUNT]);
        hpr_visibility *visibility = see(patches);
        compare_all(patches, visibility, NULL, "random scene", verdicts, &blockers);
        compare_all(patches, visibility, wanted, "random scene, three wanted", verdicts, &blockers);
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    print_message("nothing %zu, wholly %zu, partly %zu past %zu blockers\n", verdicts[0], verdicts[1],
                  verdicts[2], blockers);
    assert_true(verdicts[0] > 1000 && verdicts[1] > 1000 && verdicts[2] > 1000);
    hpr_context_destroy(&ctx);
}

/* Every side of `count` boxes (the first with its fronts inside) in m x m squares. */
static hpr_patches *cells_of_boxes(hpr_context *ctx, const double (*box)[6], size_t count, size_t m)
{
    hpr_patches *whole = shapes_create(ctx, 6 * count), *patches = shapes_create(ctx, 6 * count * m * m);
    for (size_t b = 0; b < count; b++) {
        const double a[3] = {box[b][3], 0, 0}, c[3] = {0, box[b][4], 0}, d[3] = {0, 0, box[b][5]};
        shapes_box(whole, 6 * b, box[b], a, c, d, b == 0);
    }
    for (size_t i = 0; i < patches->count; i++) {
        size_t w = i / (m * m), x = i % m, y = i / m % m;
        double origin[3], e1[3], e2[3];
        for (int k = 0; k < 3; k++) {
            e1[k] = whole->edge1[3 * w + (size_t)k] / (double)m;
            e2[k] = whole->edge2[3 * w + (size_t)k] / (double)m;
        }
        hpr_add_scaled3(whole->origin + 3 * w, (double)x, e1, origin);
        hpr_add_scaled3(origin, (double)y, e2, origin);
        shapes_set(patches, i, HPR_SHAPE_PARALLELOGRAM, origin, e1, e2);
    }
    hpr_patches_destroy(&whole);
    return patches;
}

static void tessellated_boxes_agree_with_the_plain_loop(void **state)
{
    (void)state;
    static const double boxes[][6] = {
        {0, 0, 0, 1, 1, 1}, {0.3, 0.25, 0.25, 0.5, 0.5, 0.5}, {0.05, 0.1, 0, 0.125, 0.25, 0.75}};
    hpr_context *ctx = shapes_context(2, NULL);
    for (size_t count = 2; count <= 3; count++) {
        size_t verdicts[3] = {0}, blockers = 0;
        hpr_patches *patches = cells_of_boxes(ctx, boxes, count, 8);
        hpr_visibility *visibility = see(patches);
        /* the third stands on the floor: its bottom lies in it */
        assert_int_equal(hpr_visibility_occluder_count(visibility), count == 3 ? 17 : 12);
        compare_all(patches, visibility, NULL, "boxes", verdicts, &blockers);
        print_message("%zu boxes: nothing %zu, wholly %zu, partly %zu past %zu blockers\n", count,
                      verdicts[0], verdicts[1], verdicts[2], blockers);
        assert_true(verdicts[0] > 1000 && verdicts[1] > 1000 && verdicts[2] > 1000);
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    hpr_context_destroy(&ctx);
}

/* Nothing can come between anything: nothing is listed, whatever the number of patches. */
static void a_convex_room_needs_no_lists(void **state)
{
    (void)state;
    static const double room[][6] = {{0, 0, 0, 3, 4, 5}};
    hpr_context *ctx = shapes_context(2, NULL);
    hpr_patches *patches = cells_of_boxes(ctx, room, 1, 30);
    hpr_visibility *visibility = see(patches);
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    assert_int_equal(hpr_views_create(visibility, NULL, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    assert_int_equal(hpr_views_lists(views), 0);
    for (size_t p = 0; p < patches->count; p += 7) {
        for (size_t q = 0; q < patches->count; q += 11) {
            bool same = p / 900 == q / 900;
            assert_int_equal(hpr_views_classify(views, cursor, p, q, NULL, NULL),
                             same ? HPR_SEES_NOTHING : HPR_SEES_WHOLLY);
        }
    }
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Lists of pairs of groups stay short of all occluders for all pairs by far. */
static void lists_are_short(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(2, NULL);
    uint64_t seed = 43;
    enum { COUNT = 2000 };
    hpr_patches *patches = shapes_create(ctx, COUNT);
    for (size_t i = 0; i < COUNT; i++) { /* a cloud of small squares */
        double origin[3], a[3], b[3], c[3];
        random_point(&seed, 0, 1, origin);
        random_direction(&seed, a);
        random_direction(&seed, c);
        hpr_cross3(a, c, b);
        for (int k = 0; k < 3; k++) {
            a[k] *= 0.02;
            b[k] *= 0.02;
        }
        shapes_set(patches, i, HPR_SHAPE_PARALLELOGRAM, origin, a, b);
    }
    hpr_visibility *visibility = see(patches);
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    assert_int_equal(hpr_visibility_occluder_count(visibility), COUNT);
    assert_int_equal(hpr_views_create(visibility, NULL, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    size_t listed = hpr_views_lists(views), groups = hpr_views_groups(views);
    double all = 0.5 * (double)groups * (double)groups * COUNT;
    print_message("%zu groups, %zu entries: %.3g of all occluders in all lists\n", groups, listed,
                  (double)listed / all);
    assert_true((double)listed < 0.15 * all); /* observed 0.117; 0.225 by boxes and planes alone */
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void patches_without_area_see_nothing(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    set_quad(patches, 0, 0, 0, 0, ex, ey);
    set_quad(patches, 2, 0, 0, 1, ey, ex);
    hpr_visibility *visibility = see(patches);
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    assert_int_equal(hpr_views_create(visibility, NULL, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    assert_int_equal(hpr_views_classify(views, cursor, 0, 2, NULL, NULL), HPR_SEES_WHOLLY);
    assert_int_equal(hpr_views_classify(views, cursor, 0, 1, NULL, NULL), HPR_SEES_NOTHING);
    assert_int_equal(hpr_views_classify(views, cursor, 1, 2, NULL, NULL), HPR_SEES_NOTHING);
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    patches = shapes_create(ctx, 0);
    visibility = see(patches);
    assert_int_equal(hpr_views_create(visibility, NULL, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    hpr_views_cursor_destroy(&cursor);
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    static const double boxes[][6] = {{0, 0, 0, 1, 1, 1}, {0.3, 0.25, 0.25, 0.5, 0.5, 0.5}};
    shapes_allocator allocator = {.fail_at = SIZE_MAX};
    hpr_context *ctx = shapes_context(1, &allocator);
    hpr_patches *patches = cells_of_boxes(ctx, boxes, 2, 4);
    hpr_visibility *visibility = see(patches);
    size_t before = allocator.alive, failures = 0;
    for (size_t k = 0;; k++) {
        hpr_views *views = NULL;
        hpr_views_cursor *cursor = NULL;
        allocator.fail_at = allocator.calls + k;
        hpr_status status = hpr_views_create(visibility, NULL, &views);
        assert_true((status == HPR_OK) == (views != NULL));
        hpr_views_cursor_destroy(&cursor);
        hpr_views_destroy(&views);
        assert_int_equal(allocator.alive, before);
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        failures++;
    }
    assert_true(failures > 10); /* six of its own, then lists of the rows */
    allocator.fail_at = SIZE_MAX;
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_scenes_agree_with_the_plain_loop),
        cmocka_unit_test(tessellated_boxes_agree_with_the_plain_loop),
        cmocka_unit_test(a_convex_room_needs_no_lists),
        cmocka_unit_test(lists_are_short),
        cmocka_unit_test(patches_without_area_see_nothing),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
