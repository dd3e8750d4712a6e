/* Refuses, before any work, outputs that could not be written or that would destroy something of the job. */
#ifndef HPR_APP_OUTPUTS_H
#define HPR_APP_OUTPUTS_H

#include "base/context.h"

#include <sys/types.h>

enum { HPR_MAX_INPUTS = 3 };

typedef struct hpr_outputs {
    hpr_context *context;
    size_t input_count;
    const char *input[HPR_MAX_INPUTS]; /* borrowed */
    bool names_only;                   /* claims look at no file, only that no name comes twice */
    size_t count, capacity;
    char **path; /* [count] claimed so far, owned */
} hpr_outputs;

/* Fini releases what claims have allocated; accepts a zeroed struct. */
void hpr_outputs_init(hpr_outputs *outputs, hpr_context *ctx);
void hpr_outputs_fini(hpr_outputs *outputs);

/* Declares a file that the job reads. `path` is borrowed. At most HPR_MAX_INPUTS. */
void hpr_outputs_input(hpr_outputs *outputs, const char *path);

/*
 * Declares a file that the job will write. Errors: HPR_ERR_ARG (the name of an input or of an earlier claim,
 * also through links, or empty), HPR_ERR_IO (a folder, a folder that is missing or not writable, a
 * write-protected file, a read-only file system), HPR_ERR_MEMORY. Creates nothing that has a name.
 */
hpr_status hpr_outputs_claim(hpr_outputs *outputs, const char *path);

/* Makes sure that a file which is read only later is none of the claimed ones. Errors: HPR_ERR_ARG. */
hpr_status hpr_outputs_spare(const hpr_outputs *outputs, const char *path);

#endif
