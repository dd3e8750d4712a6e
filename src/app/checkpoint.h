/*
 * Where a solve with a tolerance stood between two steps, as a file: what was refined after each step, from
 * which all else follows, and what it was made of, so that it is taken up for the same scene and settings
 * only. JSON: version, made_of {name: text}, refinements [[step, leaf, halve s, halve t, four degrees], ...].
 * The blocks stand beside it (app/block_log.h).
 */
#ifndef HPR_APP_CHECKPOINT_H
#define HPR_APP_CHECKPOINT_H

#include "app/block_log.h"
#include "base/context.h"

#include <cjson/cJSON.h>
#include <hprad/job.h>

typedef struct hpr_checkpoint {
    hpr_context *context;
    const char *path;          /* to be written; NULL: none is */
    cJSON *made_of;            /* name: text */
    char key[HPR_SHA256_TEXT]; /* of made_of */
    hpr_block_log log;
    hpr_refinement *done;
    size_t done_count;
} hpr_checkpoint;

/* Notes what the solve is made of: program, instruction set, the scene's files, the options that change its
 * result (not the limits of time and memory). Close it also after a failure. Errors: HPR_ERR_IO,
 * HPR_ERR_FORMAT (of the scene), HPR_ERR_MEMORY. */
hpr_status hpr_checkpoint_open(hpr_context *ctx, const char *scene_path, const hpr_job_solve_options *options,
                               hpr_checkpoint *checkpoint);
void hpr_checkpoint_close(hpr_checkpoint *checkpoint);

/* Reads done, and the blocks. Errors: HPR_ERR_IO, HPR_ERR_FORMAT (no checkpoint; or made of something else:
 * the message says what), HPR_ERR_MEMORY. */
hpr_status hpr_checkpoint_read(hpr_checkpoint *checkpoint, const char *path);

/* Writes what there is to go on from, and begins to keep blocks. Errors: HPR_ERR_IO, HPR_ERR_MEMORY,
 * HPR_ERR_INTERRUPTED. */
hpr_status hpr_checkpoint_begin(hpr_checkpoint *checkpoint);

/* Writes to the checkpoint's path (stepped of hpr_solve_series; user: the checkpoint). Errors: HPR_ERR_IO,
 * HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. */
hpr_status hpr_checkpoint_write(void *user, const hpr_refinement *refinement, size_t count);

#endif
