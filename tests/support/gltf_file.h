/* Writes small glTF files into a directory of its own and reads them with hpr_scene_read. */
#ifndef HPR_TEST_GLTF_FILE_H
#define HPR_TEST_GLTF_FILE_H

#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FIXTURE_BYTES = 1 << 16 };

typedef struct fixture {
    char directory[64], path[128];
    hpr_context *ctx;
    hpr_scene *scene;
    hpr_read_options options;
    unsigned char data[FIXTURE_BYTES]; /* what data.bin will hold */
    size_t size;
    long allocations_left; /* < 0: unlimited */
} fixture;

static inline void *fixture_allocate(void *user, size_t count, size_t size)
{
    fixture *f = user;
    if (f->allocations_left == 0)
        return NULL;
    if (f->allocations_left > 0)
        f->allocations_left--;
    return calloc(count, size);
}

static inline void fixture_release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->directory, "/tmp/hprad_gltf_XXXXXX");
    f->allocations_left = -1;
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.allocate = fixture_allocate;
    options.release = fixture_release;
    options.user = f;
    options.threads = 1;
    hpr_read_options_init(&f->options);
    *state = f;
    return !mkdtemp(f->directory) || hpr_context_create(&options, &f->ctx) != HPR_OK;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    hpr_scene_destroy(&f->scene);
    hpr_context_destroy(&f->ctx);
    DIR *directory = opendir(f->directory);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", f->directory, entry->d_name);
        unlink(path);
    }
    closedir(directory);
    rmdir(f->directory);
    free(f);
    return 0;
}

/* Appends to data.bin at the next multiple of 4; returns the offset. */
static inline size_t put(fixture *f, const void *bytes, size_t size)
{
    f->size = (f->size + 3) / 4 * 4;
    assert_true(f->size + size <= FIXTURE_BYTES);
    memcpy(f->data + f->size, bytes, size);
    f->size += size;
    return f->size - size;
}

#define PUT(f, type, ...) put(f, (const type[]){__VA_ARGS__}, sizeof((const type[]){__VA_ARGS__}))

static inline void write_file(fixture *f, const char *name, const void *bytes, size_t size)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", f->directory, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

/* Reads the file `name` of the fixture's directory. */
static inline hpr_status read_name(fixture *f, const char *name)
{
    snprintf(f->path, sizeof f->path, "%s/%s", f->directory, name);
    hpr_scene_destroy(&f->scene);
    return hpr_scene_read(f->ctx, f->path, &f->options, &f->scene);
}

/* Writes data.bin and a.gltf, whose text may use ' for ", and reads it. */
static inline hpr_status read_text(fixture *f, const char *text)
{
    size_t size = strlen(text);
    char *json = malloc(size + 1);
    for (size_t i = 0; i <= size; i++)
        json[i] = text[i] == '\'' ? '"' : text[i];
    write_file(f, "data.bin", f->data, f->size);
    write_file(f, "a.gltf", json, size);
    free(json);
    return read_name(f, "a.gltf");
}

/* Around `body` (further members of the file): version, the buffer data.bin and one node with mesh 0. */
static inline hpr_status read_body(fixture *f, const char *body, ...)
{
    char text[8192], filled[7168];
    va_list arguments;
    va_start(arguments, body);
    vsnprintf(filled, sizeof filled, body, arguments);
    va_end(arguments);
    const char *nodes = strstr(filled, "'nodes'") ? "" : "'nodes':[{'mesh':0}],";
    snprintf(text, sizeof text,
             "{'asset':{'version':'2.0'},%s'buffers':[{'uri':'data.bin','byteLength':%zu}],%s}", nodes,
             f->size, filled);
    return read_text(f, text);
}

static inline void assert_ok(fixture *f, hpr_status status)
{
    if (status != HPR_OK)
        print_error("%s: %s\n", hpr_status_string(status), hpr_context_error(f->ctx));
    assert_int_equal(status, HPR_OK);
}

static inline void assert_near(double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound))
        print_error("%.17g is not %.17g: off by %g, bound %g\n", value, expected, fabs(value - expected),
                    bound);
    assert_true(fabs(value - expected) <= bound);
}

static inline void assert_point(const double *p, double x, double y, double z, double bound)
{
    assert_near(p[0], x, bound);
    assert_near(p[1], y, bound);
    assert_near(p[2], z, bound);
}

/* How many warnings contain the text. */
static inline size_t count_warnings(fixture *f, const char *text)
{
    size_t count = 0;
    for (size_t i = 0; i < hpr_warning_count(f->ctx); i++)
        count += strstr(hpr_warning_text(f->ctx, i), text) != NULL;
    return count;
}

/* The position of corner k of a face. */
static inline const double *corner(const fixture *f, size_t face, size_t k)
{
    return f->scene->position + 3 * f->scene->face_vertex[4 * face + k];
}

#endif
