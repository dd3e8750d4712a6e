/* One job of a batch, in a process of its own, and what that process tells the batch. */
#ifndef HPR_APP_BATCH_WORK_H
#define HPR_APP_BATCH_WORK_H

#include "app/batch_plan.h"

typedef enum hpr_batch_task_kind { HPR_BATCH_SOLVE, HPR_BATCH_RENDER } hpr_batch_task_kind;

/* What a job may use. */
typedef struct hpr_batch_means {
    int threads;
    double memory_bytes; /* of data; what needs more gets HPR_ERR_MEMORY */
    int pipe;            /* where messages go */
} hpr_batch_means;

typedef enum hpr_batch_message_kind {
    HPR_BATCH_MESSAGE_WROTE,   /* path: a file */
    HPR_BATCH_MESSAGE_WARNING, /* text */
    HPR_BATCH_MESSAGE_END      /* the last one: status, text of its error, counts */
} hpr_batch_message_kind;

/* Small enough (PIPE_BUF) to come through a pipe whole. Texts are cut to their room. */
typedef struct hpr_batch_message {
    hpr_batch_message_kind kind;
    hpr_status status;
    bool missed;         /* the tolerance */
    size_t made, reused; /* solutions or pictures */
    char path[1536], text[1536];
} hpr_batch_message;

/*
 * Does the job: a solution, or the pictures of a group whose solution is there. What the manifest lists is
 * left alone. Sends messages, the last of them END. To be called in a forked process, which ends afterwards.
 */
void hpr_batch_work(const hpr_batch_plan *plan, hpr_batch_task_kind kind, size_t index,
                    const hpr_batch_means *means);

#endif
