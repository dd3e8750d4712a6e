/* What the tests of src/io share: a folder of their own, whole files, a context whose k-th allocation fails.
 */
#ifndef HPR_TESTS_IO_SUPPORT_H
#define HPR_TESTS_IO_SUPPORT_H

#include "base/context.h"

#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct fixture {
    hpr_context *context;
    char folder[64];
    long allocations_left; /* < 0: no limit */
    long live;             /* allocations not yet released */
    volatile sig_atomic_t cancel;
    bool mounted;
} fixture;

static inline void *counting_allocate(void *user, size_t count, size_t size)
{
    fixture *f = user;
    if (f->allocations_left == 0)
        return NULL;
    void *memory = calloc(count, size);
    if (f->allocations_left > 0)
        f->allocations_left--;
    f->live += memory != NULL;
    return memory;
}

static inline void counting_release(void *user, void *memory)
{
    fixture *f = user;
    f->live -= memory != NULL;
    free(memory);
}

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/hprad_test_XXXXXX");
    if (!mkdtemp(f->folder))
        return -1;
    f->allocations_left = -1;
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = 1;
    options.allocate = counting_allocate;
    options.release = counting_release;
    options.user = f;
    options.cancel = &f->cancel;
    if (hpr_context_create(&options, &f->context) != HPR_OK)
        return -1;
    *state = f;
    return 0;
}

/* Number of files in the folder; removes them if asked. */
static inline int count_files(const char *folder, bool remove_them)
{
    int count = 0;
    DIR *d = opendir(folder);
    for (struct dirent *e; d && (e = readdir(d));) {
        if (!strcmp(e->d_name, ".") || !strcmp(e->d_name, ".."))
            continue;
        count++;
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (remove_them)
            remove(path);
    }
    if (d)
        closedir(d);
    return count;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    hpr_context_destroy(&f->context);
    if (f->mounted)
        umount(f->folder);
    count_files(f->folder, true);
    rmdir(f->folder);
    long live = f->live;
    free(f);
    if (live)
        fprintf(stderr, "%ld allocations leaked\n", live);
    return live ? -1 : 0;
}

/* Path of a name in the test's folder; valid until the fourth further call. */
static inline const char *in_folder(const fixture *f, const char *name)
{
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", f->folder, name);
    return path;
}

/* Makes the folder a file system of 64 KB; false where that is not allowed. */
static inline bool mount_small(fixture *f)
{
    f->mounted = mount("tmpfs", f->folder, "tmpfs", 0, "size=64k") == 0;
    return f->mounted;
}

/* Whole file, one zero byte appended; NULL if there is none. */
static inline unsigned char *slurp(const char *path, size_t *bytes)
{
    FILE *stream = fopen(path, "rb");
    *bytes = 0;
    if (!stream)
        return NULL;
    fseek(stream, 0, SEEK_END);
    *bytes = (size_t)ftell(stream);
    rewind(stream);
    unsigned char *data = calloc(*bytes + 1, 1);
    if (fread(data, 1, *bytes, stream) != *bytes)
        abort();
    fclose(stream);
    return data;
}

static inline void spill(const char *path, const void *data, size_t bytes)
{
    FILE *stream = fopen(path, "wb");
    if (!stream || fwrite(data, 1, bytes, stream) != bytes || fclose(stream))
        abort();
}

static inline void assert_message_has(const fixture *f, const char *part)
{
    if (!strstr(hpr_context_error(f->context), part))
        fail_msg("message '%s' lacks '%s'", hpr_context_error(f->context), part);
}

/* xorshift64*: the same numbers everywhere */
static inline uint64_t random_bits(uint64_t *seed)
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return *seed * 2685821657736338717u;
}

static inline double random_unit(uint64_t *seed)
{
    return (double)(random_bits(seed) >> 11) * 0x1p-53;
}

#define IO_TEST(test) cmocka_unit_test_setup_teardown(test, fixture_setup, fixture_teardown)

#endif
