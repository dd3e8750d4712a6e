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

#endif
