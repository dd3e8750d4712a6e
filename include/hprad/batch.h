#ifndef HPRAD_BATCH_H
#define HPRAD_BATCH_H

#include <hprad/job.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What a batch has to say while it runs. Texts are valid during the call. */
typedef enum hpr_batch_event_kind {
    HPR_BATCH_PLANNED,  /**< of a dry run: `path` would be made; `reused`: is there already */
    HPR_BATCH_WROTE,    /**< a file was finished */
    HPR_BATCH_FAILED,   /**< a job: `path` is its solution or first picture, `text` says why */
    HPR_BATCH_LEFT_OUT, /**< pictures whose solution failed */
} hpr_batch_event_kind;

typedef struct hpr_batch_event {
    hpr_batch_event_kind kind;
    const char *path, *text;
    int reused;
} hpr_batch_event;

typedef struct hpr_batch_options {
    int jobs;            /**< at a time, each in a process of its own (default 1) */
    double memory_bytes; /**< for all together; 0: nine tenths of the machine's. Each job has its share,
                              and one that needs more runs again alone, with all of it */
    int shard,
        shard_count; /**< only every shard_count-th group of pictures, from number `shard` (from 1) on */
    int dry_run;     /**< 1: say what would be done, do nothing */
    void (*said)(void *user, const hpr_batch_event *event); /**< NULL: not wanted */
    void *user;
} hpr_batch_options;

HPR_API void hpr_batch_options_init(hpr_batch_options *options);

typedef struct hpr_batch_result {
    size_t solved, solutions_reused; /**< reused: finished before, or for another scene of the same content */
    size_t pictures, pictures_reused; /**< made now; finished before */
    size_t failed, left_out; /**< jobs that failed; pictures that were not tried for want of a solution */
    size_t missed;           /**< solutions that missed their tolerance; their pictures are made */
} hpr_batch_result;

/**
 * Scenes x settings x cameras -> pictures, as a batch file asks for (its keys are in the README). Solves once
 * per scene and setting, into FOLDER/solutions/KEY.glb, KEY being a hash of the program, the scene's files
 * and the settings; then every picture. FOLDER/manifest.jsonl has one line for each finished file: output,
 * sha256, bytes, key. What it lists and is there unchanged is not made again, so that a batch which was
 * killed goes on where it was. Several batches may run in one folder: files are locked while they are made
 * (locks on ranges of the manifest, which the system drops when a process dies), and appear whole.
 *
 * A job that fails does not end the batch. Returns HPR_OK if the batch ran to its end; whether jobs failed
 * says `result`. Errors: HPR_ERR_IO, HPR_ERR_FORMAT (the batch file), HPR_ERR_ARG (an output twice, bad
 * options), HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Forks: not to be called in a process that has used OpenMP.
 */
HPR_API hpr_status hpr_job_batch(hpr_context *context, const char *path, const hpr_batch_options *options,
                                 hpr_batch_result *result);

#ifdef __cplusplus
}
#endif

#endif
