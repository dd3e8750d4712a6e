/*
 * Output files that appear whole or not at all: everything goes to a temporary file in the same folder, which
 * commit renames over the final name. A target that is no regular file (a pipe, /dev/stdout, /dev/null) is
 * written directly, in order, so writers must not seek.
 */
#ifndef HPR_IO_ATOMIC_FILE_H
#define HPR_IO_ATOMIC_FILE_H

#include "base/context.h"

#include <stdio.h>

typedef struct hpr_atomic_file {
    hpr_context *context;
    FILE *stream;    /* NULL when closed */
    int reason;      /* errno of the first failed hpr_atomic_print, which the stream forgets */
    char *path;      /* as the caller named it, for messages */
    char *target;    /* what the temporary file is renamed to: path with symbolic links followed */
    char *temporary; /* NULL: the target is written directly */
} hpr_atomic_file;

/*
 * Opens `path` for writing. Whether this fails or not, the file can be given to abort. The temporary file is
 * named .<base>.<pid>.<n>.tmp; its mode is 0666 less the umask.
 * Errors: HPR_ERR_IO (with the path and the system's reason), HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_atomic_open(hpr_context *ctx, const char *path, hpr_atomic_file *file);

/* The same for the process's standard output: named "standard output" in messages, written directly, and left
 * open. */
hpr_status hpr_atomic_open_stdout(hpr_context *ctx, hpr_atomic_file *file);

/* Appends bytes. Errors: HPR_ERR_IO, HPR_ERR_INTERRUPTED. */
hpr_status hpr_atomic_write(hpr_atomic_file *file, const void *data, size_t bytes);

/* Is what stands under the name now, if anything, written directly? */
bool hpr_atomic_is_direct(const char *path);

/* Bytes at a place of their own, of a file that is not written directly. Calls for different places may be
 * concurrent. Errors: HPR_ERR_IO, HPR_ERR_INTERRUPTED. */
hpr_status hpr_atomic_write_at(hpr_atomic_file *file, const void *data, size_t bytes, size_t offset);

/* Appends formatted text; a failure shows at commit. */
void hpr_atomic_print(hpr_atomic_file *file, const char *format, ...) HPR_PRINTF(2, 3);

/*
 * Flushes, syncs, renames and closes. On any failure, and when the context was cancelled, the temporary file
 * is removed and what stood under the final name is untouched. Errors: HPR_ERR_IO, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_atomic_commit(hpr_atomic_file *file);

/* Closes and removes the temporary file. Accepts a zeroed, committed or aborted file. */
void hpr_atomic_abort(hpr_atomic_file *file);

#endif
