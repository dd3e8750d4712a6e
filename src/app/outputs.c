#include "app/outputs.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void hpr_outputs_init(hpr_outputs *outputs, hpr_context *ctx)
{
    *outputs = (hpr_outputs){.context = ctx};
}

void hpr_outputs_fini(hpr_outputs *outputs)
{
    for (size_t i = 0; i < outputs->count; i++)
        hpr_release(outputs->context, outputs->path[i]);
    if (outputs->path)
        hpr_release(outputs->context, outputs->path);
    *outputs = (hpr_outputs){0};
}

void hpr_outputs_input(hpr_outputs *outputs, const char *path)
{
    outputs->input[outputs->input_count++] = path;
}

static bool same_file(const char *path, const struct stat *info)
{
    struct stat other;
    return stat(path, &other) == 0 && other.st_dev == info->st_dev && other.st_ino == info->st_ino;
}

/* Whether a file can be created in the folder, found out by doing it: permission bits say nothing of full,
 * read-only or virtual file systems. The file has no name where the file system allows that. Returns 0 or the
 * errno. */
static int try_folder(hpr_context *ctx, const char *folder)
{
    int file = open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (file < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
        size_t bytes = strlen(folder) + 48;
        char *name = hpr_allocate(ctx, bytes, 1);
        if (!name)
            return ENOMEM;
        snprintf(name, bytes, "%s/.hprad.%ld.try.tmp", folder, (long)getpid());
        file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        int reason = errno;
        if (file >= 0)
            unlink(name);
        hpr_release(ctx, name);
        errno = reason;
    }
    if (file < 0)
        return errno;
    close(file);
    return 0;
}

/* A link is followed by who writes, so the folder in question is that of the file behind it. */
static hpr_status check_folder(hpr_context *ctx, const char *path)
{
    char real[PATH_MAX];
    if (realpath(path, real))
        path = real;
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) : 0;
    char *folder = hpr_allocate(ctx, length + 2, 1);
    if (!folder)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for the folder of '%s'", path);
    if (length)
        memcpy(folder, path, length);
    else
        folder[0] = slash ? '/' : '.';
    int error = try_folder(ctx, folder);
    hpr_status status = HPR_OK;
    if (error)
        status =
            hpr_fail(ctx, HPR_ERR_IO, "cannot write '%s': folder '%s': %s", path, folder, strerror(error));
    hpr_release(ctx, folder);
    return status;
}

/* /dev/stdout may be a regular file; it is written to and not replaced, so its folder does not matter. */
static bool opened_by_shell(const char *path)
{
    return !strncmp(path, "/dev/", 5) || !strncmp(path, "/proc/", 6);
}

/* What stands under the name already may be replaced only if it is a file that we may write. */
static hpr_status check_existing(const hpr_outputs *outputs, const char *path, const struct stat *info)
{
    hpr_context *ctx = outputs->context;
    if (S_ISDIR(info->st_mode))
        return hpr_fail(ctx, HPR_ERR_IO, "cannot write '%s': it is a folder", path);
    if (access(path, W_OK) != 0)
        return hpr_fail(ctx, HPR_ERR_IO, "cannot write '%s': %s", path, strerror(errno));
    if (!S_ISREG(info->st_mode))
        return HPR_OK; /* a device or a pipe may take several outputs */
    for (size_t i = 0; i < outputs->input_count; i++) {
        if (same_file(outputs->input[i], info))
            return hpr_fail(ctx, HPR_ERR_ARG,
                            "output '%s' is the input '%s' itself; name another output (-o)", path,
                            outputs->input[i]);
    }
    for (size_t i = 0; i < outputs->count; i++) {
        if (same_file(outputs->path[i], info))
            return hpr_fail(ctx, HPR_ERR_ARG, "two outputs, '%s' and '%s', are the same file",
                            outputs->path[i], path);
    }
    return HPR_OK;
}

static hpr_status check_new(const hpr_outputs *outputs, const char *path)
{
    for (size_t i = 0; i < outputs->count; i++) {
        if (!strcmp(outputs->path[i], path))
            return hpr_fail(outputs->context, HPR_ERR_ARG, "two outputs would have the same name '%s'", path);
    }
    return HPR_OK;
}

hpr_status hpr_outputs_claim(hpr_outputs *outputs, const char *path)
{
    hpr_context *ctx = outputs->context;
    size_t length = strlen(path);
    if (!length)
        return hpr_fail(ctx, HPR_ERR_ARG, "an output has an empty name");
    struct stat info;
    hpr_status status;
    bool replaces = false;
    if (outputs->names_only) {
        status = check_new(outputs, path);
    } else if (stat(path, &info) == 0) {
        status = check_existing(outputs, path, &info);
        replaces = S_ISREG(info.st_mode) && !opened_by_shell(path);
    } else if (errno != ENOENT && errno != ENOTDIR) {
        return hpr_fail(ctx, HPR_ERR_IO, "cannot write '%s': %s", path, strerror(errno));
    } else if (path[length - 1] == '/') {
        return hpr_fail(ctx, HPR_ERR_IO, "cannot write '%s': it names a folder", path);
    } else {
        replaces = true;
        status = check_new(outputs, path);
    }
    if (status == HPR_OK && replaces)
        status = check_folder(ctx, path);
    if (status == HPR_OK)
        status = hpr_grow(ctx, &outputs->path, &outputs->capacity, outputs->count + 1, sizeof *outputs->path);
    if (status != HPR_OK)
        return status;
    char *copy = hpr_duplicate_text(ctx, path);
    if (!copy)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for the name '%s'", path);
    outputs->path[outputs->count++] = copy;
    return HPR_OK;
}

hpr_status hpr_outputs_spare(const hpr_outputs *outputs, const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return HPR_OK;
    for (size_t i = 0; i < outputs->count; i++) {
        if (same_file(outputs->path[i], &info))
            return hpr_fail(outputs->context, HPR_ERR_ARG, "output '%s' would overwrite '%s', which is read",
                            outputs->path[i], path);
    }
    return HPR_OK;
}
