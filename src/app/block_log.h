/*
 * The kernel blocks of a solve in a file beside its checkpoint, CHECKPOINT.blocks, as they are integrated: a
 * solve that is taken up reads those that it needs. Records are only appended and bear a check sum, so that
 * whatever stops the program, all but the last few are there; the end of a broken file is left out. Binary,
 * in the byte order of the machine: the magic "HPRBLK01", 64 hexadecimal digits that say what the solve is
 * made of, then records of 48 bytes (recv, send, degrees, count, short_count, check sum, three errors) and
 * count doubles. Deleting it costs time, and at most the last bit of a block.
 */
#ifndef HPR_APP_BLOCK_LOG_H
#define HPR_APP_BLOCK_LOG_H

#include "io/sha256.h"

#include <hprad/solve.h>
#include <omp.h>
#include <stdio.h>

/* Where a block stands in what was read. */
typedef struct hpr_block_entry {
    uint64_t nodes;
    uint32_t degrees;
    size_t place;
} hpr_block_entry;

typedef struct hpr_block_log {
    hpr_context *context;
    const char *made_of; /* borrowed; 64 digits */
    /* what was read */
    char *data;
    size_t bytes;           /* that are good */
    hpr_block_entry *entry; /* [entry_count] sorted */
    size_t entry_count, entry_capacity;
    /* what is written */
    char *path;
    FILE *stream; /* NULL: nothing is, or not any more */
    int reason;   /* errno of the first failure */
    double flushed_s;
    omp_lock_t lock;
} hpr_block_log;

/* Fini also after a failure. */
void hpr_block_log_init(hpr_context *ctx, const char *made_of, hpr_block_log *log);
void hpr_block_log_fini(hpr_block_log *log);

/* CHECKPOINT.blocks, to be released; NULL: out of memory. */
char *hpr_block_log_path(hpr_context *ctx, const char *checkpoint);

/* Reads what stands beside a checkpoint. A file that is missing, or of something else, holds nothing. Errors:
 * HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_block_log_read(hpr_block_log *log, const char *checkpoint);

/* Begins to write beside a checkpoint, after what was read. Errors: HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_block_log_begin(hpr_block_log *log, const char *checkpoint);

/* Everything so far is in the system's hands. Errors: HPR_ERR_IO, of this call or of a block before it. */
hpr_status hpr_block_log_flush(hpr_block_log *log);

/* Gives back what was read. Not while blocks are looked for. */
void hpr_block_log_forget(hpr_block_log *log);

/* For hpr_block_keeper; user: the log. */
void hpr_block_log_keep(void *user, const hpr_kept_block *block);
bool hpr_block_log_find(void *user, hpr_kept_block *block);

#endif
