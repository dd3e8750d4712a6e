/* Hottel's total exchange factors. */
#ifndef HPR_SOLVER_EXCHANGE_H
#define HPR_SOLVER_EXCHANGE_H

#include "link/form_factors.h"

/* Memory that hpr_exchange_factors takes beside its result, bytes; the result takes half of it. */
double hpr_exchange_bytes(size_t row_count);

/*
 * script-F, row-major [count][count]: of what the black body at row j's temperature would emit from row i's
 * area, the part that i absorbs from j, directly and after reflections, exchange_ij = e_i [(I - F R)^-1 F]_ij
 * e_j,   R = diag(1 - e). A_i exchange_ij is symmetric; in an enclosure row i sums to e_i. emissivity
 * [count], 0 to 1. Errors: HPR_ERR_MEMORY, HPR_ERR_NUMERIC (nothing absorbs in a closed model). Source:
 * Hottel & Sarofim 1967, ch. 3.
 */
hpr_status hpr_exchange_factors(const hpr_form_factors *factors, const double *emissivity, double *exchange);

#endif
