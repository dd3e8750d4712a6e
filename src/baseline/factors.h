/* The full matrix of form factors between the elements of a solution. */
#ifndef HPR_BASELINE_FACTORS_H
#define HPR_BASELINE_FACTORS_H

#include "patch/elements.h"

#include <hprad/baseline.h>

/* What the matrix says of itself beside its entries. */
typedef struct hpr_factors_done {
    size_t pair_count;  /* entries that are not zero */
    size_t short_count; /* pairs that stopped short of their tolerance */
    bool blocked;       /* something may come between some pair; not known of a hemicube */
} hpr_factors_done;

/*
 * factor [leaves][leaves], row-major, zero on entry: F_ij, the part of what leaves leaf i that reaches leaf
 * j, by options->method and the resolution in `baseline`. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_baseline_factors(const hpr_patches *patches, const hpr_elements *elements,
                                const hpr_solve_options *options, const hpr_baseline_options *baseline,
                                double *factor, hpr_factors_done *done);

#endif
