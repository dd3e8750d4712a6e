/*
 * Two-scale relations: how coefficients travel between an element and its two halves (as patch/elements.h
 * splits them). With T the orthonormal bases in area, M_kl = ∫_half T_k^whole T_l^half dA:
 *   pull: whole = sum over halves of M half     what the halves carry, as the whole sees it
 *   push: half = MT whole                       the polynomial of the whole, on a half of it
 * Both are exact: a polynomial of degree p on the whole is one of degree p on each half, and what a half
 * carries beyond the whole's degree has no part in the whole's moments. The degrees of the two may differ.
 * Source: Alpert 1993; Gortler, Schroeder, Cohen & Hanrahan 1993, sec. 4.
 */
#ifndef HPR_BASIS_TWO_SCALE_H
#define HPR_BASIS_TWO_SCALE_H

#include "basis/basis.h"

typedef struct hpr_two_scale hpr_two_scale;

/* Tables for degrees up to max_degree <= HPR_MAX_DEGREE. Read-only once made. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_two_scale_create(hpr_context *ctx, int max_degree, hpr_two_scale **tables);
void hpr_two_scale_destroy(hpr_two_scale **tables);

/* One half of an element: child `which` of a parallelogram halved along `axis`, or of a bisected triangle. Of
 * a quadrilateral the relations depend on its corners and are given. */
typedef struct hpr_half {
    hpr_shape shape;
    int axis, which;
    int whole_degree, half_degree;
    const double *matrix; /* of a quadrilateral: M [functions of the whole][functions of the half] */
} hpr_half;

/* whole += M half. Lengths: hpr_basis_count of the shape and the degrees. Thread-safe. */
void hpr_two_scale_pull(const hpr_two_scale *tables, const hpr_half *half, const double *from, double *whole);
/* half += MT whole. Thread-safe. */
void hpr_two_scale_push(const hpr_two_scale *tables, const hpr_half *half, const double *from, double *to);

#endif
