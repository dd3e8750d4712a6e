#include "app/manifest.h"

#include "io/json_text.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Locks lie far beyond any byte that the file will have; the byte 0 is that of who appends. */
static const uint64_t lock_base = UINT64_C(1) << 40;

static hpr_status fail_errno(const hpr_manifest *m, const char *what)
{
    return hpr_fail(m->context, HPR_ERR_IO, "cannot %s '%s': %s", what, m->path, strerror(errno));
}

static hpr_status make_folder(hpr_context *ctx, const char *folder)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return hpr_fail(ctx, HPR_ERR_IO, "cannot make the folder '%s': %s", folder, strerror(errno));
    return HPR_OK;
}

hpr_status hpr_manifest_open(hpr_context *ctx, const char *folder, bool create, hpr_manifest *m)
{
    static const char name[] = "/manifest.jsonl";
    *m = (hpr_manifest){.context = ctx, .file = -1};
    m->folder = hpr_duplicate_text(ctx, folder);
    hpr_status status = hpr_allocate_into(ctx, &m->path, strlen(folder) + sizeof name, 1, "a file name");
    if (!m->folder || status != HPR_OK)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    strcat(strcpy(m->path, folder), name);
    if (create)
        status = make_folder(ctx, folder);
    if (status != HPR_OK)
        return status;
    m->file = open(m->path, create ? O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC : O_RDONLY | O_CLOEXEC, 0666);
    if (m->file < 0 && (create || errno != ENOENT))
        return fail_errno(m, "open");
    return hpr_manifest_update(m);
}

void hpr_manifest_close(hpr_manifest *m)
{
    if (!m->context)
        return;
    if (m->file >= 0)
        close(m->file);
    for (size_t i = 0; i < m->count; i++)
        hpr_release(m->context, m->line[i].output);
    hpr_release(m->context, m->line);
    hpr_release(m->context, m->folder);
    hpr_release(m->context, m->path);
    *m = (hpr_manifest){.file = -1};
}

static bool take_hash(const cJSON *item, char text[HPR_SHA256_TEXT])
{
    const char *value = cJSON_GetStringValue(item);
    if (!value || strlen(value) != HPR_SHA256_TEXT - 1)
        return false;
    strcpy(text, value);
    return true;
}

static hpr_manifest_line *find_output(const hpr_manifest *m, const char *output)
{
    for (size_t i = m->count; i-- > 0;) {
        if (!strcmp(m->line[i].output, output))
            return m->line + i;
    }
    return NULL;
}

/* Takes one line of the file, or leaves it if it is none of ours. */
static hpr_status take_line(hpr_manifest *m, const char *text)
{
    hpr_manifest_line line = {0};
    size_t bytes = 0;
    hpr_status status = HPR_OK;
    cJSON *root = cJSON_Parse(text);
    const char *output = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(root, "output"));
    bool good = output && take_hash(cJSON_GetObjectItemCaseSensitive(root, "sha256"), line.sha256) &&
                take_hash(cJSON_GetObjectItemCaseSensitive(root, "key"), line.key) &&
                hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(root, "bytes"), 0x1p53, &bytes);
    line.bytes = bytes;
    line.missed = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(root, "missed"));
    hpr_manifest_line *old = good ? find_output(m, output) : NULL;
    if (old) {
        line.output = old->output;
        *old = line;
    } else if (good) {
        line.output = hpr_duplicate_text(m->context, output);
        status = line.output ? hpr_grow(m->context, &m->line, &m->capacity, m->count + 1, sizeof line)
                             : hpr_fail(m->context, HPR_ERR_MEMORY, "out of memory for '%s'", m->path);
        if (status == HPR_OK)
            m->line[m->count++] = line;
        else
            hpr_release(m->context, line.output);
    }
    cJSON_Delete(root);
    return status;
}

/* Whole lines only: what has no end yet is read again. */
hpr_status hpr_manifest_update(hpr_manifest *m)
{
    struct stat info;
    if (m->file < 0)
        return HPR_OK;
    if (fstat(m->file, &info) != 0)
        return fail_errno(m, "read");
    if ((uint64_t)info.st_size <= m->seen)
        return HPR_OK;
    size_t bytes = (size_t)((uint64_t)info.st_size - m->seen);
    char *text = NULL;
    hpr_status status = hpr_allocate_into(m->context, &text, bytes + 1, 1, "a manifest");
    ssize_t got = status == HPR_OK ? pread(m->file, text, bytes, (off_t)m->seen) : 0;
    if (got < 0)
        status = fail_errno(m, "read");
    for (char *at = text, *end; status == HPR_OK && (end = memchr(at, '\n', (size_t)(text + got - at)));
         at = end + 1) {
        *end = '\0';
        status = take_line(m, at);
        m->seen += (uint64_t)(end + 1 - at);
    }
    hpr_release(m->context, text);
    return status;
}

/* The name within the folder. */
static const char *relative(const hpr_manifest *m, const char *path)
{
    size_t length = strlen(m->folder);
    return !strncmp(path, m->folder, length) && path[length] == '/' ? path + length + 1 : path;
}

static hpr_status hash_file(hpr_context *ctx, const char *path, char text[HPR_SHA256_TEXT], uint64_t *bytes)
{
    hpr_sha256 hash;
    hpr_sha256_init(&hash);
    hpr_status status = hpr_sha256_add_file(ctx, &hash, path, bytes);
    hpr_sha256_finish(&hash, text);
    return status;
}

const hpr_manifest_line *hpr_manifest_find(hpr_manifest *m, const char *path, const char *key)
{
    char sha256[HPR_SHA256_TEXT];
    struct stat info;
    uint64_t bytes = 0;
    const hpr_manifest_line *line = find_output(m, relative(m, path));
    if (!line || strcmp(line->key, key) != 0 || stat(path, &info) != 0 ||
        (uint64_t)info.st_size != line->bytes)
        return NULL;
    if (hash_file(m->context, path, sha256, &bytes) != HPR_OK) {
        hpr_context_clear_error(m->context); /* it will be made again */
        return NULL;
    }
    return strcmp(sha256, line->sha256) == 0 ? line : NULL;
}

/* Locks or unlocks a byte; EINTR and EAGAIN are left to the caller. */
static int set_lock(const hpr_manifest *m, uint64_t byte, short type, bool wait)
{
    struct flock lock = {.l_type = type, .l_whence = SEEK_SET, .l_start = (off_t)byte, .l_len = 1};
    return fcntl(m->file, wait ? F_OFD_SETLKW : F_OFD_SETLK, &lock);
}

static hpr_status lock_byte(hpr_manifest *m, uint64_t byte, bool wait, bool *locked)
{
    *locked = false;
    while (set_lock(m, byte, F_WRLCK, wait) != 0) {
        if (hpr_cancelled(m->context))
            return hpr_fail(m->context, HPR_ERR_INTERRUPTED, "interrupted");
        if (!wait && (errno == EAGAIN || errno == EACCES))
            return HPR_OK;
        if (errno != EINTR)
            return fail_errno(m, "lock");
    }
    *locked = true;
    return HPR_OK;
}

/* Two names may share a byte: then one waits for the other without need. */
static uint64_t byte_of(const hpr_manifest *m, const char *path)
{
    char text[HPR_SHA256_TEXT];
    hpr_sha256 hash;
    hpr_sha256_init(&hash);
    hpr_sha256_add_text(&hash, relative(m, path));
    hpr_sha256_finish(&hash, text);
    text[14] = '\0'; /* 56 bits */
    return lock_base + strtoull(text, NULL, 16);
}

hpr_status hpr_manifest_lock(hpr_manifest *m, const char *path, bool wait, bool *locked)
{
    return lock_byte(m, byte_of(m, path), wait, locked);
}

void hpr_manifest_unlock(hpr_manifest *m, const char *path)
{
    set_lock(m, byte_of(m, path), F_UNLCK, false);
}

/* One line in one write; what was cut off before it gets an end of its own. */
static hpr_status append(hpr_manifest *m, char *text)
{
    struct stat info;
    char last = '\n';
    size_t length = strlen(text);
    if (fstat(m->file, &info) != 0 || (info.st_size > 0 && pread(m->file, &last, 1, info.st_size - 1) != 1))
        return fail_errno(m, "read");
    if (last != '\n' && write(m->file, "\n", 1) != 1)
        return fail_errno(m, "write");
    text[length] = '\n';
    ssize_t done = write(m->file, text, length + 1);
    text[length] = '\0';
    if (done != (ssize_t)(length + 1) || (fsync(m->file) != 0 && errno != EINVAL))
        return fail_errno(m, "write");
    return HPR_OK;
}

/* The line of a finished file, NULL if memory ran out. */
static char *line_of(const hpr_manifest *m, const char *path, const char *sha256, uint64_t bytes,
                     const hpr_manifest_entry *entry)
{
    bool ok = true;
    cJSON *root = cJSON_CreateObject();
    hpr_json_text(root, "output", relative(m, path), &ok);
    hpr_json_text(root, "sha256", sha256, &ok);
    hpr_json_number(root, "bytes", (double)bytes, &ok);
    hpr_json_text(root, "key", entry->key, &ok);
    hpr_json_bool(root, "missed", entry->missed, &ok);
    char *text = ok ? cJSON_PrintUnformatted(root) : NULL;
    cJSON_Delete(root);
    return text;
}

/* text += the line of file k. */
static hpr_status add_line(const hpr_manifest *m, const hpr_manifest_entry *entry, size_t k, char **text)
{
    char sha256[HPR_SHA256_TEXT], *line = NULL, *longer = NULL;
    uint64_t bytes = 0;
    hpr_status status = hash_file(m->context, entry->path[k], sha256, &bytes);
    if (status != HPR_OK)
        return status;
    line = line_of(m, entry->path[k], sha256, bytes, entry);
    if (!line || asprintf(&longer, "%s%s%s", *text ? *text : "", *text ? "\n" : "", line) < 0)
        status = hpr_fail(m->context, HPR_ERR_MEMORY, "out of memory for '%s'", m->path);
    cJSON_free(line);
    if (status == HPR_OK) {
        free(*text);
        *text = longer;
    }
    return status;
}

hpr_status hpr_manifest_add(hpr_manifest *m, const hpr_manifest_entry *entry)
{
    bool locked = false;
    char *text = NULL;
    hpr_status status = HPR_OK;
    for (size_t k = 0; k < entry->count && status == HPR_OK; k++)
        status = add_line(m, entry, k, &text);
    if (status == HPR_OK)
        status = lock_byte(m, 0, true, &locked);
    if (status == HPR_OK)
        status = append(m, text);
    if (locked)
        set_lock(m, 0, F_UNLCK, false);
    free(text);
    return status;
}

/* Whether a name is ".BASE.<pid>.<n>.tmp". */
static bool is_temporary(const char *name, const char *base)
{
    size_t length = strlen(base);
    if (name[0] != '.' || strncmp(name + 1, base, length) != 0 || name[1 + length] != '.')
        return false;
    const char *pid = name + 2 + length;
    size_t digits = strspn(pid, "0123456789");
    if (!digits || pid[digits] != '.')
        return false;
    const char *number = pid + digits + 1;
    digits = strspn(number, "0123456789");
    return digits && !strcmp(number + digits, ".tmp");
}

void hpr_manifest_tidy(const char *path)
{
    char folder[4096];
    const char *slash = strrchr(path, '/');
    int length = slash ? (int)(slash - path) : 1;
    if (snprintf(folder, sizeof folder, "%.*s", length, slash ? path : ".") >= (int)sizeof folder)
        return;
    DIR *list = opendir(folder);
    for (struct dirent *entry; list && (entry = readdir(list)) != NULL;) {
        if (is_temporary(entry->d_name, slash ? slash + 1 : path))
            unlinkat(dirfd(list), entry->d_name, 0);
    }
    if (list)
        closedir(list);
}
