/* Small dense linear algebra. */
#ifndef HPR_MATH_DENSE_H
#define HPR_MATH_DENSE_H

#include <stdbool.h>
#include <stddef.h>

/*
 * Solves A X = B by Gaussian elimination with partial pivoting, row-major: a [n][n] is destroyed, b [n][m]
 * becomes X. False if a pivot is zero or not finite; both are then of no use. Bitwise the same for any
 * `threads` >= 1. Source: Golub & Van Loan 2013, 3.4.
 */
bool hpr_dense_solve(size_t n, double *a, size_t m, double *b, int threads);

/*
 * Replaces the symmetric a [n][n] by its pseudo-inverse without the eigenvalues below `least` times the
 * largest. work: [n][n]. Source: cyclic Jacobi rotations, Golub & Van Loan 2013, 8.5.
 */
void hpr_dense_pseudo_inverse(size_t n, double *a, double least, double *work);

#endif
