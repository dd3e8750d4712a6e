/* Outputs that are refused before any work. */
#include "app/outputs.h"

#include "io_support.h"

static hpr_status claim(fixture *f, hpr_outputs *outputs, const char *path)
{
    hpr_context_clear_error(f->context);
    return hpr_outputs_claim(outputs, path);
}

static void refused(fixture *f, hpr_outputs *outputs, const char *path, hpr_status status, const char *reason)
{
    if (claim(f, outputs, path) != status)
        fail_msg("'%s' was not refused as '%s'", path, hpr_status_string(status));
    assert_message_has(f, path);
    assert_message_has(f, reason);
}

static void a_new_file_is_accepted_and_not_created(void **state)
{
    fixture *f = *state;
    hpr_outputs outputs;
    hpr_outputs_init(&outputs, f->context);
    assert_int_equal(claim(f, &outputs, in_folder(f, "new.exr")), HPR_OK);
    assert_int_equal(count_files(f->folder, false), 0);
    hpr_outputs_fini(&outputs);
}

static void what_cannot_be_written_is_refused_with_the_reason(void **state)
{
    fixture *f = *state;
    hpr_outputs outputs;
    hpr_outputs_init(&outputs, f->context);
    spill(in_folder(f, "file"), "x", 1);
    refused(f, &outputs, in_folder(f, "missing/a.exr"), HPR_ERR_IO, "No such file or directory");
    refused(f, &outputs, in_folder(f, "file/a.exr"), HPR_ERR_IO, "Not a directory");
    refused(f, &outputs, f->folder, HPR_ERR_IO, "folder");
    refused(f, &outputs, in_folder(f, "new/"), HPR_ERR_IO, "folder");
    refused(f, &outputs, "/proc/a.exr", HPR_ERR_IO, "");
    refused(f, &outputs, "", HPR_ERR_ARG, "empty");
    hpr_outputs_fini(&outputs);
}

static void an_input_is_refused_also_through_links(void **state)
{
    fixture *f = *state;
    hpr_outputs outputs;
    hpr_outputs_init(&outputs, f->context);
    const char *input = in_folder(f, "in.glb"), *symbolic = in_folder(f, "s.glb"),
               *hard = in_folder(f, "h.glb");
    spill(input, "x", 1);
    assert_int_equal(symlink("in.glb", symbolic), 0);
    assert_int_equal(link(input, hard), 0);
    hpr_outputs_input(&outputs, input);
    refused(f, &outputs, input, HPR_ERR_ARG, "input");
    refused(f, &outputs, symbolic, HPR_ERR_ARG, "input");
    refused(f, &outputs, hard, HPR_ERR_ARG, "input");
    hpr_outputs_fini(&outputs);
}

static void two_outputs_of_one_name_are_refused(void **state)
{
    fixture *f = *state;
    hpr_outputs outputs;
    hpr_outputs_init(&outputs, f->context);
    const char *path = in_folder(f, "new.exr"), *old = in_folder(f, "old.exr"), *symbolic = in_folder(f, "s");
    assert_int_equal(claim(f, &outputs, path), HPR_OK);
    refused(f, &outputs, path, HPR_ERR_ARG, "two outputs");
    spill(old, "x", 1);
    assert_int_equal(symlink("old.exr", symbolic), 0);
    assert_int_equal(claim(f, &outputs, old), HPR_OK);
    refused(f, &outputs, symbolic, HPR_ERR_ARG, "same file");
    hpr_outputs_fini(&outputs);
}

static void a_device_is_accepted(void **state)
{
    fixture *f = *state;
    hpr_outputs outputs;
    hpr_outputs_init(&outputs, f->context);
    assert_int_equal(claim(f, &outputs, "/dev/full"), HPR_OK);
    assert_int_equal(claim(f, &outputs, "/dev/null"), HPR_OK);
    hpr_outputs_fini(&outputs);
}

static void claims_survive_without_memory(void **state)
{
    fixture *f = *state;
    hpr_status status = HPR_ERR_MEMORY;
    for (long k = 0; status == HPR_ERR_MEMORY; k++) {
        hpr_outputs outputs;
        hpr_outputs_init(&outputs, f->context);
        f->allocations_left = k;
        status = claim(f, &outputs, in_folder(f, "new.exr"));
        f->allocations_left = -1;
        hpr_outputs_fini(&outputs);
    }
    assert_int_equal(status, HPR_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(a_new_file_is_accepted_and_not_created),
        IO_TEST(what_cannot_be_written_is_refused_with_the_reason),
        IO_TEST(an_input_is_refused_also_through_links),
        IO_TEST(two_outputs_of_one_name_are_refused),
        IO_TEST(a_device_is_accepted),
        IO_TEST(claims_survive_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
