/* View factors between the rows of a model, and the kernel blocks between patches that are one row each. */
#ifndef HPR_LINK_FORM_FACTORS_H
#define HPR_LINK_FORM_FACTORS_H

#include "patch/rows.h"

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

typedef struct hpr_form_factors {
    hpr_context *context;
    size_t count;
    double *area_m2;  /* [count] */
    double *exchange; /* A_i F_ij for j >= i, row after row: see hpr_form_factors_at */
    hpr_pairs_done done;
} hpr_form_factors;

/* Memory that create takes for this many rows, bytes. */
double hpr_form_factors_bytes(size_t row_count);

/*
 * A_i F_ij = sum over patches p of row i, q of row j of ∫_p ∫_q G V dA dA, each pair integrated once, to the
 * relative tolerance; plus the masks. The same bits for any number of threads. Blocks that stop short are
 * counted. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_form_factors_create(const hpr_rows *rows, double tolerance, hpr_form_factors **factors);
void hpr_form_factors_destroy(hpr_form_factors **factors);

/* A_i F_ij, in any order of i and j. */
double hpr_form_factors_at(const hpr_form_factors *factors, size_t i, size_t j);

/* row[count] = F_ij for all j; zero where A_i is. */
void hpr_form_factors_row(const hpr_form_factors *factors, size_t i, double *row);

/*
 * Kernel blocks of the given degree, block [count][count][n][n] with n that of hpr_form_blocks_size:
 *   block[((i*N + j)*n + k)*n + l] = K_ij^kl, receiver i, sender j,
 * zero where a shape has fewer functions than n. The rows must not be composite (hpr_rows_composite).
 * Errors: as above.
 */
hpr_status hpr_form_blocks(const hpr_rows *rows, int degree, double tolerance, double *block,
                           hpr_pairs_done *done);

/* Functions of the largest patch at this degree; 1 if there is none. */
size_t hpr_form_blocks_size(const hpr_rows *rows, int degree);

#endif
