#include "math/dense.h"

#include <math.h>

static void swap_rows(double *a, size_t width, size_t i, size_t j)
{
    for (size_t k = 0; i != j && k < width; k++) {
        double kept = a[i * width + k];
        a[i * width + k] = a[j * width + k];
        a[j * width + k] = kept;
    }
}

static size_t find_pivot(size_t n, const double *a, size_t column)
{
    size_t best = column;
    for (size_t i = column + 1; i < n; i++) {
        if (fabs(a[i * n + column]) > fabs(a[best * n + column]))
            best = i;
    }
    return best;
}

/* row -= factor * pivot row, in columns from `first` on */
static void subtract_row(double *row, const double *pivot_row, double factor, size_t first, size_t width)
{
    for (size_t k = first; k < width; k++)
        row[k] -= factor * pivot_row[k];
}

bool hpr_dense_solve(size_t n, double *a, size_t m, double *b, int threads)
{
    for (size_t c = 0; c < n; c++) {
        size_t pivot = find_pivot(n, a, c);
        swap_rows(a, n, c, pivot);
        swap_rows(b, m, c, pivot);
        double head = a[c * n + c];
        if (!(fabs(head) > 0) || !isfinite(head))
            return false;
#pragma omp parallel for schedule(static) num_threads(threads) if (n - c > 64)
        for (size_t i = c + 1; i < n; i++) {
            double factor = a[i * n + c] / head;
            if (factor == 0)
                continue;
            subtract_row(a + i * n, a + c * n, factor, c + 1, n);
            subtract_row(b + i * m, b + c * m, factor, 0, m);
        }
    }
    for (size_t c = n; c-- > 0;) {
        double head = a[c * n + c];
        for (size_t k = 0; k < m; k++)
            b[c * m + k] /= head;
#pragma omp parallel for schedule(static) num_threads(threads) if (c > 64)
        for (size_t i = 0; i < c; i++)
            subtract_row(b + i * m, b + c * m, a[i * n + c], 0, m);
    }
    return true;
}
