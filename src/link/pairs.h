/*
 * Integrating pairs of patches one by one, past what may come between: what view factors and kernel blocks
 * share.
 */
#ifndef HPR_LINK_PAIRS_H
#define HPR_LINK_PAIRS_H

#include "patch/rows.h"
#include "quadrature/block.h"
#include "visibility/views.h"

/* What an integration over all pairs has to say beside its numbers. */
typedef struct hpr_pairs_done {
    size_t pair_count;    /* pairs of patches that see something of each other */
    size_t blocked_count; /* of these, how many have something that may come between */
    size_t rounded_count; /* how many only rounding of the coordinates may keep from the tolerance */
    size_t short_count;   /* how many stopped short of it */
    /* Largest estimated error of a pair's block, relative to its largest entry: of those that are not
     * sampled, and of those that are. */
    double relative_error, sampled_error;
} hpr_pairs_done;

/* Working memory of one thread, and what it counted. */
typedef struct hpr_pairs_worker {
    hpr_block_scratch *scratch;
    hpr_views_cursor *cursor;
    uint32_t *blocker; /* [occluder_count] what may come between the pair looked at last */
    size_t blocker_count;
    double *block; /* [HPR_MAX_BASIS]^2 */
    hpr_pairs_done done;
    uint64_t kernel_count, ray_count, clip_count;
} hpr_pairs_worker;

typedef struct hpr_pairs {
    hpr_context *context;
    const hpr_rows *rows;
    int degree;
    hpr_visibility *visibility;
    hpr_views *views;
    hpr_quadrature *quadrature;
    hpr_pairs_worker *worker; /* [threads] */
} hpr_pairs;

/* Whether it fails or not, `pairs` can be closed. Borrows the rows. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE.
 */
hpr_status hpr_pairs_open(const hpr_rows *rows, int degree, hpr_pairs *pairs);

/* Adds up what the workers counted and frees everything. */
void hpr_pairs_close(hpr_pairs *pairs, hpr_pairs_done *done);

hpr_element_frame hpr_pairs_frame(const hpr_pairs *pairs, size_t patch);

/* Do patches of different surfaces, both with an area, meet here? */
bool hpr_pairs_counts(const hpr_pairs *pairs, size_t p, size_t q);

/* Who sees whom, and past what: that goes to the worker. Of patches that count. */
hpr_verdict hpr_pairs_look(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q);

/* The block of patches p (receiver) and q into w->block, to this tolerance, past the blockers in the worker;
 * false if it is zero. */
bool hpr_pairs_integrate_past(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q,
                              double tolerance);

/* Both, of any two patches. */
bool hpr_pairs_integrate(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q, double tolerance);

/* Functions of the largest patch at this degree; 1 if there is none. */
size_t hpr_form_blocks_size(const hpr_rows *rows, int degree);

/*
 * Kernel blocks of the given degree, block [count][count][n][n] with n that of hpr_form_blocks_size:
 *   block[((i*N + j)*n + k)*n + l] = K_ij^kl, receiver i, sender j,
 * zero where a shape has fewer functions than n. The rows must not be composite (hpr_rows_composite).
 * Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_form_blocks(const hpr_rows *rows, int degree, double tolerance, double *block,
                           hpr_pairs_done *done);

#endif
