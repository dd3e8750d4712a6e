#include "io/atomic_file.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static hpr_status fail_errno(const hpr_atomic_file *file, int reason)
{
    if (hpr_cancelled(file->context)) /* a signal cuts short a wait for a pipe, too */
        return hpr_fail(file->context, HPR_ERR_INTERRUPTED, "interrupted before '%s' was written",
                        file->path);
    char text[256];
    const char *message = strerror_r(reason, text, sizeof text); /* GNU: returns the text */
    return hpr_fail(file->context, HPR_ERR_IO, "cannot write '%s': %s", file->path, message);
}

static hpr_status copy_text(hpr_context *ctx, const char *text, char **copy)
{
    *copy = hpr_duplicate_text(ctx, text);
    return *copy ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: the name of an output file");
}

/* A file that the shell has opened (/dev/stdout) may be a regular one, but is not ours to replace; those in
 * shared memory are files like any other. */
static bool written_directly(const char *path, const struct stat *info)
{
    bool device = !strncmp(path, "/dev/", 5) && strncmp(path, "/dev/shm/", 9) != 0;
    return !S_ISREG(info->st_mode) || device || !strncmp(path, "/proc/", 6);
}

/* Finds out what stands under the name: *direct, or the file to replace in file->target. */
static hpr_status resolve(hpr_atomic_file *file, bool *direct)
{
    struct stat info;
    *direct = false;
    size_t length = strlen(file->path);
    if (length == 0)
        return fail_errno(file, ENOENT);
    if (file->path[length - 1] == '/')
        return fail_errno(file, EISDIR);
    if (stat(file->path, &info) != 0) {
        if (errno != ENOENT)
            return fail_errno(file, errno);
        return copy_text(file->context, file->path, &file->target);
    }
    if (S_ISDIR(info.st_mode))
        return fail_errno(file, EISDIR);
    /* rename needs leave of the folder only, but a write-protected file is not to be replaced */
    if (access(file->path, W_OK) != 0)
        return fail_errno(file, errno);
    *direct = written_directly(file->path, &info);
    if (*direct)
        return HPR_OK;
    char *real = realpath(file->path, NULL);
    if (!real)
        return fail_errno(file, errno);
    hpr_status status = copy_text(file->context, real, &file->target);
    free(real);
    return status;
}

static hpr_status open_temporary(hpr_atomic_file *file, int *fd)
{
    enum { TRIES = 1000, ROOM = 48, LONGEST_BASE = NAME_MAX - ROOM };
    const char *slash = strrchr(file->target, '/');
    const char *base = slash ? slash + 1 : file->target;
    int folder = (int)(base - file->target);
    size_t bytes = strlen(file->target) + ROOM;
    hpr_status status = hpr_allocate_into(file->context, &file->temporary, bytes, 1, "a file name");
    if (status != HPR_OK)
        return status;
    int reason = EEXIST;
    for (int n = 0; n < TRIES && reason == EEXIST; n++) {
        snprintf(file->temporary, bytes, "%.*s.%.*s.%ld.%d.tmp", folder, file->target, LONGEST_BASE, base,
                 (long)getpid(), n);
        *fd = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (*fd >= 0)
            return HPR_OK;
        reason = errno;
    }
    hpr_release(file->context, file->temporary);
    file->temporary = NULL;
    return fail_errno(file, reason);
}

/* Takes over the descriptor, whether it fails or not. */
static hpr_status attach(hpr_atomic_file *file, int fd)
{
    if (fd < 0)
        return fail_errno(file, errno);
    file->stream = fdopen(fd, "w");
    if (file->stream)
        return HPR_OK;
    hpr_status status = fail_errno(file, errno);
    close(fd);
    return status;
}

hpr_status hpr_atomic_open_stdout(hpr_context *ctx, hpr_atomic_file *file)
{
    *file = (hpr_atomic_file){.context = ctx};
    hpr_status status = copy_text(ctx, "standard output", &file->path);
    if (status == HPR_OK) {
        fflush(stdout); /* what was said before comes first */
        status = attach(file, dup(STDOUT_FILENO));
    }
    if (status != HPR_OK)
        hpr_atomic_abort(file);
    return status;
}

hpr_status hpr_atomic_open(hpr_context *ctx, const char *path, hpr_atomic_file *file)
{
    if (!strcmp(path, "/dev/stdout")) /* which cannot be opened if it is a socket */
        return hpr_atomic_open_stdout(ctx, file);
    *file = (hpr_atomic_file){.context = ctx};
    int fd = -1;
    bool direct = false;
    hpr_status status = copy_text(ctx, path, &file->path);
    if (status == HPR_OK)
        status = resolve(file, &direct);
    if (status == HPR_OK && direct)
        fd = open(path, O_WRONLY | O_APPEND | O_CLOEXEC);
    else if (status == HPR_OK)
        status = open_temporary(file, &fd);
    if (status == HPR_OK)
        status = attach(file, fd);
    if (status != HPR_OK)
        hpr_atomic_abort(file);
    return status;
}

hpr_status hpr_atomic_write(hpr_atomic_file *file, const void *data, size_t bytes)
{
    if (bytes && fwrite(data, 1, bytes, file->stream) != bytes)
        return fail_errno(file, errno);
    return HPR_OK;
}

bool hpr_atomic_is_direct(const char *path)
{
    struct stat info;
    return !strcmp(path, "/dev/stdout") || (stat(path, &info) == 0 && written_directly(path, &info));
}

hpr_status hpr_atomic_write_at(hpr_atomic_file *file, const void *data, size_t bytes, size_t offset)
{
    const char *at = data;
    assert(file->temporary);
    while (bytes) {
        ssize_t written = pwrite(fileno(file->stream), at, bytes, (off_t)offset);
        if (written < 0 && errno == EINTR && !hpr_cancelled(file->context))
            continue;
        if (written <= 0)
            return fail_errno(file, written < 0 ? errno : EIO);
        at += written;
        offset += (size_t)written;
        bytes -= (size_t)written;
    }
    return HPR_OK;
}

void hpr_atomic_print(hpr_atomic_file *file, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (vfprintf(file->stream, format, arguments) < 0 && !file->reason)
        file->reason = errno;
    va_end(arguments);
}

/* Some file systems have no fsync. */
static bool cannot_sync(int reason)
{
    return reason == EINVAL || reason == ENOSYS || reason == ENOTSUP;
}

static hpr_status finish_stream(hpr_atomic_file *file)
{
    hpr_status status = HPR_OK;
    errno = 0;
    if (file->reason)
        status = fail_errno(file, file->reason);
    else if (fflush(file->stream) != 0 || ferror(file->stream))
        status = fail_errno(file, errno ? errno : EIO);
    else if (file->temporary && fsync(fileno(file->stream)) != 0 && !cannot_sync(errno))
        status = fail_errno(file, errno);
    FILE *stream = file->stream;
    file->stream = NULL;
    if (fclose(stream) != 0 && status == HPR_OK)
        status = fail_errno(file, errno);
    return status;
}

hpr_status hpr_atomic_commit(hpr_atomic_file *file)
{
    hpr_status status = finish_stream(file);
    if (status == HPR_OK && hpr_cancelled(file->context))
        status = fail_errno(file, EINTR);
    if (status == HPR_OK && file->temporary) {
        if (rename(file->temporary, file->target) != 0) {
            status = fail_errno(file, errno);
        } else {
            hpr_release(file->context, file->temporary);
            file->temporary = NULL;
        }
    }
    hpr_atomic_abort(file);
    return status;
}

void hpr_atomic_abort(hpr_atomic_file *file)
{
    if (file->stream)
        fclose(file->stream);
    if (file->temporary)
        unlink(file->temporary);
    hpr_release(file->context, file->temporary);
    hpr_release(file->context, file->target);
    hpr_release(file->context, file->path);
    file->stream = NULL;
    file->temporary = file->target = file->path = NULL;
}
