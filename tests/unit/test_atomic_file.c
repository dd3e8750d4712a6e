#include "io/atomic_file.h"

#include "io_support.h"

#include <fcntl.h>
#include <pthread.h>

static void whole_file_appears_under_the_name(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.txt");
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, path, &file), HPR_OK);
    assert_int_equal(hpr_atomic_write(&file, "one ", 4), HPR_OK);
    hpr_atomic_print(&file, "%d", 2);
    assert_int_not_equal(access(path, F_OK), 0); /* nothing there before commit */
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    size_t bytes;
    unsigned char *text = slurp(path, &bytes);
    assert_non_null(text);
    assert_string_equal((char *)text, "one 2");
    free(text);
    assert_int_equal(count_files(f->folder, false), 1);
}

static void mode_follows_the_umask(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.txt");
    mode_t before = umask(027);
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, path, &file), HPR_OK);
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    umask(before);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
}

static void abort_leaves_the_old_file(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.txt");
    spill(path, "old", 3);
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, path, &file), HPR_OK);
    assert_int_equal(hpr_atomic_write(&file, "new", 3), HPR_OK);
    hpr_atomic_abort(&file);
    hpr_atomic_abort(&file); /* twice is harmless */
    size_t bytes;
    unsigned char *text = slurp(path, &bytes);
    assert_string_equal((char *)text, "old");
    free(text);
    assert_int_equal(count_files(f->folder, false), 1);
}

static void cancellation_ends_in_nothing(void **state)
{
    fixture *f = *state;
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, in_folder(f, "a.txt"), &file), HPR_OK);
    f->cancel = 1;
    assert_int_equal(hpr_atomic_commit(&file), HPR_ERR_INTERRUPTED);
    assert_int_equal(count_files(f->folder, false), 0);
}

static void symbolic_links_are_followed(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.txt"), *link = in_folder(f, "link");
    spill(path, "old", 3);
    assert_int_equal(symlink("a.txt", link), 0);
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, link, &file), HPR_OK);
    assert_int_equal(hpr_atomic_write(&file, "new", 3), HPR_OK);
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    size_t bytes;
    unsigned char *text = slurp(path, &bytes);
    assert_string_equal((char *)text, "new");
    free(text);
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
}

static void bad_paths_are_named(void **state)
{
    fixture *f = *state;
    char folder[80];
    snprintf(folder, sizeof folder, "%s/", f->folder);
    const struct {
        const char *path, *reason;
    } cases[] = {{"", "No such file"},
                 {f->folder, "Is a directory"},
                 {folder, "Is a directory"},
                 {in_folder(f, "missing/a.txt"), "No such file"},
                 {"/dev/null/a.txt", "Not a directory"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_atomic_file file;
        hpr_context_clear_error(f->context);
        assert_int_equal(hpr_atomic_open(f->context, cases[i].path, &file), HPR_ERR_IO);
        assert_message_has(f, cases[i].path);
        assert_message_has(f, cases[i].reason);
        hpr_atomic_abort(&file);
    }
    assert_int_equal(count_files(f->folder, false), 0);
}

static void long_names_fit(void **state)
{
    fixture *f = *state;
    char name[256];
    memset(name, 'x', 255);
    name[255] = '\0';
    char path[400];
    snprintf(path, sizeof path, "%s/%s", f->folder, name);
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, path, &file), HPR_OK);
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    assert_int_equal(access(path, F_OK), 0);
}

static void unwritable_folder_is_refused(void **state)
{
    fixture *f = *state;
    if (geteuid() == 0) { /* root may write everywhere: try it as someone else */
        assert_int_equal(chmod(f->folder, 0755), 0);
        assert_int_equal(seteuid(65534), 0);
    } else {
        chmod(f->folder, 0555);
    }
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(f->context, in_folder(f, "a.txt"), &file);
    if (geteuid() == 65534)
        assert_int_equal(seteuid(0), 0);
    chmod(f->folder, 0755);
    assert_int_equal(status, HPR_ERR_IO);
    assert_message_has(f, "Permission denied");
}

static void full_device_is_reported(void **state)
{
    fixture *f = *state;
    char block[4096] = {0};
    for (int printed = 0; printed < 2; printed++) {
        for (int blocks = 1; blocks < 4; blocks++) { /* seen at flush, or before */
            hpr_atomic_file file;
            hpr_context_clear_error(f->context);
            assert_int_equal(hpr_atomic_open(f->context, "/dev/full", &file), HPR_OK);
            hpr_status status = HPR_OK;
            for (int i = 0; i < blocks && status == HPR_OK; i++) {
                if (printed)
                    hpr_atomic_print(&file, "%4095d", i);
                else
                    status = hpr_atomic_write(&file, block, sizeof block);
            }
            if (status == HPR_OK)
                status = hpr_atomic_commit(&file);
            hpr_atomic_abort(&file);
            assert_int_equal(status, HPR_ERR_IO);
            assert_message_has(f, "/dev/full");
            assert_message_has(f, "No space left");
        }
    }
}

static void full_disk_leaves_nothing(void **state)
{
    fixture *f = *state;
    if (!mount_small(f))
        skip();
    char block[4096] = {1};
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, in_folder(f, "a.bin"), &file), HPR_OK);
    hpr_status status = HPR_OK;
    for (int i = 0; i < 64 && status == HPR_OK; i++)
        status = hpr_atomic_write(&file, block, sizeof block);
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    assert_int_equal(status, HPR_ERR_IO);
    assert_message_has(f, "a.bin");
    assert_message_has(f, "No space left");
    assert_int_equal(count_files(f->folder, false), 0);
}

static void *drain(void *path)
{
    char *text = calloc(64, 1);
    FILE *stream = fopen(path, "r");
    if (stream && fread(text, 1, 63, stream) == 0)
        text[0] = '!';
    if (stream)
        fclose(stream);
    return text;
}

static void pipes_are_written_directly(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "pipe");
    assert_int_equal(mkfifo(path, 0600), 0);
    pthread_t reader;
    pthread_create(&reader, NULL, drain, (void *)path);
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, path, &file), HPR_OK);
    assert_int_equal(hpr_atomic_write(&file, "through", 7), HPR_OK);
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    void *text;
    pthread_join(reader, &text);
    assert_string_equal(text, "through");
    free(text);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_true(S_ISFIFO(info.st_mode)); /* not replaced */
}

static void null_device_stays(void **state)
{
    fixture *f = *state;
    hpr_atomic_file file;
    assert_int_equal(hpr_atomic_open(f->context, "/dev/null", &file), HPR_OK);
    assert_int_equal(hpr_atomic_write(&file, "x", 1), HPR_OK);
    assert_int_equal(hpr_atomic_commit(&file), HPR_OK);
    struct stat info;
    assert_int_equal(stat("/dev/null", &info), 0);
    assert_true(S_ISCHR(info.st_mode));
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    for (long k = 0;; k++) {
        long live = f->live;
        hpr_context_clear_error(f->context);
        f->allocations_left = k;
        hpr_atomic_file file;
        hpr_status status = hpr_atomic_open(f->context, in_folder(f, "a.txt"), &file);
        f->allocations_left = -1;
        hpr_atomic_abort(&file);
        assert_int_equal(f->live, live);
        assert_int_equal(count_files(f->folder, false), 0);
        if (status == HPR_OK) {
            assert_true(k > 0);
            break;
        }
        assert_int_equal(status, HPR_ERR_MEMORY);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(whole_file_appears_under_the_name),
        IO_TEST(mode_follows_the_umask),
        IO_TEST(abort_leaves_the_old_file),
        IO_TEST(cancellation_ends_in_nothing),
        IO_TEST(symbolic_links_are_followed),
        IO_TEST(bad_paths_are_named),
        IO_TEST(long_names_fit),
        IO_TEST(unwritable_folder_is_refused),
        IO_TEST(full_device_is_reported),
        IO_TEST(full_disk_leaves_nothing),
        IO_TEST(pipes_are_written_directly),
        IO_TEST(null_device_stays),
        IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
