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

/* Rotates rows and columns p and q of the symmetric a so that a_pq = 0; vectors [n][n] hold eigenvectors in
 * rows. */
static void rotate(size_t n, double *a, double *vectors, size_t p, size_t q)
{
    double apq = a[p * n + q];
    if (apq == 0)
        return;
    double theta = (a[q * n + q] - a[p * n + p]) / (2 * apq);
    double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
    double c = 1 / sqrt(t * t + 1), s = t * c;
    for (size_t k = 0; k < n; k++) {
        double akp = a[k * n + p], akq = a[k * n + q];
        a[k * n + p] = c * akp - s * akq;
        a[k * n + q] = s * akp + c * akq;
    }
    for (size_t k = 0; k < n; k++) {
        double apk = a[p * n + k], aqk = a[q * n + k];
        a[p * n + k] = c * apk - s * aqk;
        a[q * n + k] = s * apk + c * aqk;
        double vp = vectors[p * n + k], vq = vectors[q * n + k];
        vectors[p * n + k] = c * vp - s * vq;
        vectors[q * n + k] = s * vp + c * vq;
    }
    a[p * n + q] = a[q * n + p] = 0;
}

static double off_diagonal(size_t n, const double *a)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++)
            sum += a[i * n + j] * a[i * n + j];
    }
    return sqrt(sum);
}

/* Eigenvalues on the diagonal of a, eigenvectors in the rows of vectors. */
static void diagonalise(size_t n, double *a, double *vectors)
{
    enum { MAX_SWEEPS = 40 };
    double norm = off_diagonal(n, a);
    for (size_t i = 0; i < n * n; i++)
        vectors[i] = i % (n + 1) == 0;
    for (size_t i = 0; i < n; i++)
        norm = fmax(norm, fabs(a[i * n + i]));
    for (int sweep = 0; sweep < MAX_SWEEPS && off_diagonal(n, a) > 1e-15 * norm; sweep++) {
        for (size_t p = 0; p + 1 < n; p++) {
            for (size_t q = p + 1; q < n; q++)
                rotate(n, a, vectors, p, q);
        }
    }
}

void hpr_dense_pseudo_inverse(size_t n, double *a, double least, double *work)
{
    double largest = 0;
    diagonalise(n, a, work);
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, a[i * n + i]);
    for (size_t i = 0; i < n; i++) {
        double value = a[i * n + i], scale = value > 0 && value >= least * largest ? 1 / sqrt(value) : 0;
        for (size_t k = 0; k < n; k++)
            work[i * n + k] *= scale;
    }
    for (size_t k = 0; k < n; k++) {
        for (size_t l = 0; l < n; l++) {
            double sum = 0;
            for (size_t i = 0; i < n; i++)
                sum += work[i * n + k] * work[i * n + l];
            a[k * n + l] = sum;
        }
    }
}
