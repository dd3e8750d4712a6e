/* File names that jobs make. */
#include "app/names.h"

#include "failing_allocator.h"
#include <string.h>

static hpr_context *context;

static int make_context(void **state)
{
    (void)state;
    return hpr_context_create(NULL, &context) == HPR_OK ? 0 : -1;
}

static int drop_context(void **state)
{
    (void)state;
    hpr_context_destroy(&context);
    return 0;
}

static void expect_text(char *text, const char *expected)
{
    assert_non_null(text);
    assert_string_equal(text, expected);
    hpr_release(context, text);
}

static void expect_expanded(const char *pattern, const char *camera, size_t frame, const char *expected)
{
    char *path = NULL;
    hpr_context_clear_error(context);
    assert_int_equal(hpr_name_check(context, pattern), HPR_OK);
    assert_int_equal(hpr_name_expand(context, pattern, camera, frame, &path), HPR_OK);
    expect_text(path, expected);
}

static void default_name_has_no_folder_and_the_new_extension(void **state)
{
    (void)state;
    expect_text(hpr_name_default(context, "scenes/box.gltf", ".exr"), "box.exr");
    expect_text(hpr_name_default(context, "a.b/room.v2.gltf", ".glb"), "room.v2.glb");
    expect_text(hpr_name_default(context, "a.b/room", ".glb"), "room.glb");
    expect_text(hpr_name_default(context, ".hidden", ".glb"), ".hidden.glb");
}

static void neighbour_keeps_the_folder(void **state)
{
    (void)state;
    expect_text(hpr_name_beside(context, "out/a.exr", ".png"), "out/a.png");
    expect_text(hpr_name_beside(context, "out.d/a", ".png"), "out.d/a.png");
    expect_text(hpr_name_beside(context, "a.b.exr", ".png"), "a.b.png");
}

static void camera_goes_before_the_extension(void **state)
{
    (void)state;
    expect_text(hpr_name_insert(context, "out/a.exr", "_{camera}"), "out/a_{camera}.exr");
    expect_text(hpr_name_insert(context, "out.d/a", "_{camera}"), "out.d/a_{camera}");
}

static void placeholders_are_replaced(void **state)
{
    (void)state;
    expect_expanded("{camera}.exr", "door", 3, "door.exr");
    expect_expanded("v/{camera}/{camera}.exr", "door", 3, "v/door/door.exr");
    expect_expanded("{frame}.exr", "door", 12, "12.exr");
    expect_expanded("{frame:04}.exr", "door", 12, "0012.exr");
    expect_expanded("{frame:01}.exr", "door", 12, "12.exr");
    expect_expanded("f{frame:03}_{camera}.exr", "a{b}", 0, "f000_a{b}.exr");
    expect_expanded("plain.exr", "door", 1, "plain.exr");
    expect_expanded("odd}.exr", "door", 1, "odd}.exr");
}

static void unknown_placeholders_are_refused_by_name(void **state)
{
    (void)state;
    static const char *const bad[] = {"{}",         "{Camera}",    "{frame:4}", "{frame:}",
                                      "{frame:00}", "{frame:010}", "{{camera}", "{camera"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hpr_context_clear_error(context);
        if (hpr_name_check(context, bad[i]) != HPR_ERR_ARG)
            fail_msg("'%s' was accepted", bad[i]);
        if (!strstr(hpr_context_error(context), bad[i]))
            fail_msg("'%s' is not in the message '%s'", bad[i], hpr_context_error(context));
    }
}

static void only_placeholders_make_names_vary(void **state)
{
    (void)state;
    assert_true(hpr_name_varies("{camera}.exr"));
    assert_true(hpr_name_varies("{frame:04}.exr"));
    assert_false(hpr_name_varies("camera.exr"));
    assert_false(hpr_name_varies("{cameras}.exr"));
}

static void camera_labels_are_distinct_file_names(void **state)
{
    (void)state;
    static const char *const name[] = {"a", "", "x/y", "a", NULL, "a_1", "a", "x_y"};
    static const char *const expected[] = {"a",         "camera0", "x_y", "a_1",
                                           "camera0_1", "a_1_1",   "a_2", "x_y_1"};
    enum { COUNT = sizeof name / sizeof *name };
    char **label = NULL;
    assert_int_equal(hpr_camera_labels(context, COUNT, name, &label), HPR_OK);
    for (size_t i = 0; i < COUNT; i++)
        assert_string_equal(label[i], expected[i]);
    hpr_camera_labels_release(context, COUNT, &label);
    assert_null(label);
}

static void camera_is_found_by_label_name_or_index(void **state)
{
    (void)state;
    static const char *const name[] = {"x/y", "1", "", "x/y"};
    char **label = NULL;
    assert_int_equal(hpr_camera_labels(context, 4, name, &label), HPR_OK);
    static const struct {
        const char *wanted;
        size_t camera;
    } cases[] = {{"x/y", 0}, {"x_y", 0}, {"x_y_1", 3}, {"camera0", 2}, {"1", 1}, {"0", 0}, {"3", 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t camera = 99;
        assert_int_equal(hpr_camera_find(context, 4, name, label, cases[i].wanted, &camera), HPR_OK);
        assert_int_equal(camera, cases[i].camera);
    }
    hpr_camera_labels_release(context, 4, &label);
}

static void unknown_camera_lists_the_names(void **state)
{
    (void)state;
    static const char *const name[] = {"door", "window"};
    char **label = NULL;
    assert_int_equal(hpr_camera_labels(context, 2, name, &label), HPR_OK);
    static const char *const wanted[] = {"roof", "2", "-1", "0x1", "", "1 "};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        size_t camera;
        hpr_context_clear_error(context);
        if (hpr_camera_find(context, 2, name, label, wanted[i], &camera) != HPR_ERR_ARG)
            fail_msg("camera '%s' was found", wanted[i]);
        if (!strstr(hpr_context_error(context), "door, window"))
            fail_msg("no names in '%s'", hpr_context_error(context));
    }
    hpr_camera_labels_release(context, 2, &label);
}

static hpr_status make_labels(hpr_context *ctx, void *data)
{
    (void)data;
    static const char *const name[] = {"a", "a", "b"};
    char **label = NULL;
    hpr_status status = hpr_camera_labels(ctx, 3, name, &label);
    hpr_camera_labels_release(ctx, 3, &label);
    return status;
}

static void labels_survive_without_memory(void **state)
{
    (void)state;
    assert_true(sweep_allocations(make_labels, NULL, 1) > 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(default_name_has_no_folder_and_the_new_extension),
        cmocka_unit_test(neighbour_keeps_the_folder),
        cmocka_unit_test(camera_goes_before_the_extension),
        cmocka_unit_test(placeholders_are_replaced),
        cmocka_unit_test(unknown_placeholders_are_refused_by_name),
        cmocka_unit_test(only_placeholders_make_names_vary),
        cmocka_unit_test(camera_labels_are_distinct_file_names),
        cmocka_unit_test(camera_is_found_by_label_name_or_index),
        cmocka_unit_test(unknown_camera_lists_the_names),
        cmocka_unit_test(labels_survive_without_memory),
    };
    return cmocka_run_group_tests(tests, make_context, drop_context);
}
