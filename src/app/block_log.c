#include "app/block_log.h"

#include "app/scene_hash.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char magic[8] = {'H', 'P', 'R', 'B', 'L', 'K', '0', '1'};

enum { KEY = HPR_SHA256_TEXT - 1, HEAD = sizeof magic + KEY };

typedef struct record {
    uint32_t recv, send;
    uint8_t recv_degree, send_degree;
    uint16_t unused;
    uint32_t count, short_count, check;
    double error, sampled_error, sampled2;
} record;

_Static_assert(sizeof(record) == 48, "a record has no holes");

/* FNV-1a over words of eight bytes; of the record with check = 0, then of its doubles. */
static uint32_t check_sum(const record *head, const void *block)
{
    uint64_t hash = 14695981039346656037u, word;
    record r = *head;
    r.check = 0;
    for (size_t i = 0; i < sizeof r; i += sizeof word) {
        memcpy(&word, (const char *)&r + i, sizeof word);
        hash = (hash ^ word) * 1099511628211u;
    }
    for (size_t i = 0; i < head->count; i++) {
        memcpy(&word, (const char *)block + i * sizeof word, sizeof word);
        hash = (hash ^ word) * 1099511628211u;
    }
    return (uint32_t)(hash ^ hash >> 32);
}

static record record_at(const hpr_block_log *log, size_t place)
{
    record r;
    memcpy(&r, log->data + place, sizeof r);
    return r;
}

static hpr_block_entry entry_of(uint32_t recv, uint32_t send, unsigned recv_degree, unsigned send_degree,
                                size_t place)
{
    return (hpr_block_entry){(uint64_t)recv << 32 | send, recv_degree << 8 | send_degree, place};
}

static int compare_entries(const void *a, const void *b)
{
    const hpr_block_entry *x = a, *y = b;
    return x->nodes != y->nodes ? (x->nodes < y->nodes ? -1 : 1) : (int)x->degrees - (int)y->degrees;
}

void hpr_block_log_init(hpr_context *ctx, const char *made_of, hpr_block_log *log)
{
    *log = (hpr_block_log){.context = ctx, .made_of = made_of};
    omp_init_lock(&log->lock);
}

void hpr_block_log_fini(hpr_block_log *log)
{
    if (!log->context)
        return;
    if (log->stream)
        fclose(log->stream);
    hpr_block_log_forget(log);
    hpr_release(log->context, log->path);
    omp_destroy_lock(&log->lock);
    *log = (hpr_block_log){0};
}

void hpr_block_log_forget(hpr_block_log *log)
{
    hpr_release(log->context, log->data);
    hpr_release(log->context, log->entry);
    log->data = NULL;
    log->entry = NULL;
    log->bytes = log->entry_count = log->entry_capacity = 0;
}

char *hpr_block_log_path(hpr_context *ctx, const char *checkpoint)
{
    static const char tail[] = ".blocks";
    size_t length = strlen(checkpoint);
    char *path = hpr_allocate(ctx, length + sizeof tail, 1);
    if (path) {
        memcpy(path, checkpoint, length);
        memcpy(path + length, tail, sizeof tail);
    }
    return path;
}

/* Finds the records, up to the first that is broken. */
static hpr_status index_records(hpr_block_log *log, size_t bytes)
{
    hpr_status status = HPR_OK;
    log->bytes = HEAD;
    while (status == HPR_OK && bytes - log->bytes >= sizeof(record)) {
        record r = record_at(log, log->bytes);
        size_t left = bytes - log->bytes - sizeof r;
        if (r.count > left / sizeof(double) || r.check != check_sum(&r, log->data + log->bytes + sizeof r))
            break;
        status = hpr_grow(log->context, &log->entry, &log->entry_capacity, log->entry_count + 1,
                          sizeof *log->entry);
        if (status == HPR_OK) {
            log->entry[log->entry_count++] =
                entry_of(r.recv, r.send, r.recv_degree, r.send_degree, log->bytes);
            log->bytes += sizeof r + r.count * sizeof(double);
        }
    }
    if (status == HPR_OK && log->entry_count)
        qsort(log->entry, log->entry_count, sizeof *log->entry, compare_entries);
    return status;
}

hpr_status hpr_block_log_read(hpr_block_log *log, const char *checkpoint)
{
    hpr_context *ctx = log->context;
    size_t bytes = 0;
    char *path = hpr_block_log_path(ctx, checkpoint);
    hpr_status status = path ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a checkpoint");
    bool there = status == HPR_OK && access(path, F_OK) == 0;
    if (there)
        status = hpr_scene_file_read(ctx, path, &log->data, &bytes);
    if (there && status == HPR_OK) {
        if (bytes >= HEAD && memcmp(log->data, magic, sizeof magic) == 0 &&
            memcmp(log->data + sizeof magic, log->made_of, KEY) == 0)
            status = index_records(log, bytes);
        else
            hpr_warn(ctx, "'%s' is of another solve: its blocks are integrated again", path);
    }
    hpr_release(ctx, path);
    return status;
}

static hpr_status fail(const hpr_block_log *log)
{
    return hpr_fail(log->context, HPR_ERR_IO, "'%s': %s", log->path, strerror(log->reason));
}

/* Appends; the first failure ends the writing, not the solve, until it is asked for. */
static void write_bytes(hpr_block_log *log, const void *data, size_t bytes)
{
    if (log->reason == 0 && fwrite(data, 1, bytes, log->stream) != bytes)
        log->reason = errno ? errno : EIO;
}

hpr_status hpr_block_log_begin(hpr_block_log *log, const char *checkpoint)
{
    log->path = hpr_block_log_path(log->context, checkpoint);
    if (!log->path)
        return hpr_fail(log->context, HPR_ERR_MEMORY, "out of memory for a checkpoint");
    errno = 0;
    log->stream = fopen(log->path, log->bytes ? "r+b" : "wb");
    if (!log->stream && log->bytes) /* what was read stands elsewhere */
        log->stream = fopen(log->path, "wb");
    if (!log->stream) {
        log->reason = errno;
        return fail(log);
    }
    if (log->bytes) {
        write_bytes(log, log->data, log->bytes);
    } else {
        write_bytes(log, magic, sizeof magic);
        write_bytes(log, log->made_of, KEY);
    }
    hpr_status status = hpr_block_log_flush(log);
    if (status == HPR_OK && ftruncate(fileno(log->stream), ftell(log->stream)) != 0) {
        log->reason = errno;
        status = fail(log);
    }
    return status;
}

hpr_status hpr_block_log_flush(hpr_block_log *log)
{
    if (!log->stream)
        return HPR_OK;
    if (log->reason == 0 && fflush(log->stream) != 0)
        log->reason = errno;
    log->flushed_s = omp_get_wtime();
    return log->reason ? fail(log) : HPR_OK;
}

void hpr_block_log_keep(void *user, const hpr_kept_block *block)
{
    static const double seconds = 0.05; /* of work that a kill may cost, beside what a step needs anyway */
    hpr_block_log *log = user;
    record r = {.recv = block->recv,
                .send = block->send,
                .recv_degree = block->recv_degree,
                .send_degree = block->send_degree,
                .count = block->count,
                .short_count = block->short_count,
                .error = block->error,
                .sampled_error = block->sampled_error,
                .sampled2 = block->sampled2};
    if (!log->stream)
        return;
    r.check = check_sum(&r, block->block);
    omp_set_lock(&log->lock);
    write_bytes(log, &r, sizeof r);
    write_bytes(log, block->block, block->count * sizeof *block->block);
    double now = omp_get_wtime();
    if (log->reason == 0 && now - log->flushed_s > seconds) {
        if (fflush(log->stream) != 0)
            log->reason = errno;
        log->flushed_s = now;
    }
    omp_unset_lock(&log->lock);
}

bool hpr_block_log_find(void *user, hpr_kept_block *block)
{
    const hpr_block_log *log = user;
    const hpr_block_entry wanted =
        entry_of(block->recv, block->send, block->recv_degree, block->send_degree, 0);
    const hpr_block_entry *found =
        log->entry_count ? bsearch(&wanted, log->entry, log->entry_count, sizeof *log->entry, compare_entries)
                         : NULL;
    if (!found)
        return false;
    record r = record_at(log, found->place);
    if (r.count != block->count)
        return false;
    block->short_count = r.short_count;
    block->error = r.error;
    block->sampled_error = r.sampled_error;
    block->sampled2 = r.sampled2;
    block->block = (const double *)(const void *)(log->data + found->place + sizeof r);
    return true;
}
