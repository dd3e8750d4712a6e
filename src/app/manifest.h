/*
 * What a folder of a batch holds: FOLDER/manifest.jsonl, one line of JSON for each finished file,
 *   {"output": "room_fine_door.exr", "sha256": "...", "bytes": 1234, "key": "...", "missed": false}
 * output relative to the folder; key: the hash of all that it was made from. Later lines replace earlier
 * ones; a line that a dying process left unfinished counts for nothing.
 */
#ifndef HPR_APP_MANIFEST_H
#define HPR_APP_MANIFEST_H

#include "io/sha256.h"

typedef struct hpr_manifest_line {
    char *output;
    char sha256[HPR_SHA256_TEXT], key[HPR_SHA256_TEXT];
    uint64_t bytes;
    bool missed; /* the tolerance */
} hpr_manifest_line;

typedef struct hpr_manifest {
    hpr_context *context;
    char *folder, *path;
    int file; /* -1: closed, or not there and only read */
    size_t count, capacity;
    hpr_manifest_line *line; /* [count] one for each output */
    uint64_t seen;           /* bytes read so far */
} hpr_manifest;

/* Opens and reads it. create: make it, and its folder, if it is not there. Close it in any case. A process
 * must open its own. Errors: HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_manifest_open(hpr_context *ctx, const char *folder, bool create, hpr_manifest *manifest);
void hpr_manifest_close(hpr_manifest *manifest);

/* Reads what others have added meanwhile. Errors: HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_manifest_update(hpr_manifest *manifest);

/* The line of an output that was made from `key` and is there unchanged; NULL: it is to be made. `path` is
 * the output's own, within the folder. Valid until the next update. */
const hpr_manifest_line *hpr_manifest_find(hpr_manifest *manifest, const char *path, const char *key);

/* Files that are finished together: all of a picture, or a solution. */
typedef struct hpr_manifest_entry {
    const char *const *path; /* [count], at least one */
    size_t count;
    const char *key;
    bool missed; /* the tolerance */
} hpr_manifest_entry;

/* Notes them, in one write: whoever dies has noted all or none. Errors: HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_manifest_add(hpr_manifest *manifest, const hpr_manifest_entry *entry);

/* Locks an output against other batches; it lasts until unlock, close or the process's death. Without `wait`
 * *locked tells whether it worked. Errors: HPR_ERR_IO, HPR_ERR_INTERRUPTED. */
hpr_status hpr_manifest_lock(hpr_manifest *manifest, const char *path, bool wait, bool *locked);
void hpr_manifest_unlock(hpr_manifest *manifest, const char *path);

/* Removes the temporary files that dead processes left of an output. To be called under its lock. */
void hpr_manifest_tidy(const char *path);

#endif
