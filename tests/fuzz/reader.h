/* What the fuzz targets share: a file in memory, and a context that says nothing. */
#ifndef FUZZ_READER_H
#define FUZZ_READER_H

#include "base/context.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

/* Puts the bytes into a file without name; `path` opens it. Returns its descriptor, which the caller closes.
 */
static inline int fuzz_file(const uint8_t *data, size_t bytes, char path[64])
{
    int file = memfd_create("fuzz", MFD_CLOEXEC);
    if (file < 0 || write(file, data, bytes) != (ssize_t)bytes)
        abort();
    snprintf(path, 64, "/proc/self/fd/%d", file);
    return file;
}

/* Fails instead of taking memory without end, as a reader's check of lengths should have prevented. */
static inline void *fuzz_allocate(void *user, size_t count, size_t size)
{
    (void)user;
    return size && count > ((size_t)1 << 28) / size ? NULL : calloc(count ? count : 1, size ? size : 1);
}

static inline void fuzz_release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static inline hpr_context *fuzz_context(void)
{
    hpr_context_options options;
    hpr_context *context = NULL;
    hpr_context_options_init(&options);
    options.threads = 1;
    options.allocate = fuzz_allocate;
    options.release = fuzz_release;
    if (hpr_context_create(&options, &context) != HPR_OK)
        abort();
    return context;
}

/* A reader that fails says why, and hands nothing over. */
static inline void fuzz_expect(bool fact, const char *text)
{
    if (fact)
        return;
    fprintf(stderr, "%s\n", text);
    abort();
}

#endif
