#include "solver/indicator.h"

#include "basis/basis.h"

#include <math.h>

enum { BANDS = HPR_MAX_ORDER + 1 };

/* Squares of the bands of one leaf, of all channels with their weight. */
typedef struct bands {
    int degree;
    double square[2][BANDS];
} bands;

static int axes(hpr_shape shape)
{
    return shape == HPR_SHAPE_PARALLELOGRAM ? 2 : 1;
}

/* Degree of function k along an axis of a parallelogram, else its total degree. */
static int degree_of(hpr_shape shape, int degree, int axis, size_t k)
{
    size_t n = (size_t)degree + 1;
    if (shape == HPR_SHAPE_PARALLELOGRAM)
        return (int)(axis == 0 ? k / n : k % n);
    int total = 0;
    while (k > (size_t)total)
        k -= (size_t)++total;
    return total;
}

static void add_channel(hpr_shape shape, const double *coefficient, size_t count, size_t stride,
                        double weight, bands *b)
{
    for (int axis = 0; axis < axes(shape); axis++) {
        for (size_t k = 0; k < count; k++) {
            double c = coefficient[k * stride];
            b->square[axis][degree_of(shape, b->degree, axis, k)] += weight * c * c;
        }
    }
}

/* Of a constant there is one band only. */
static double last_bands(const bands *b, int axis)
{
    if (b->degree == 0)
        return b->square[axis][0];
    return b->square[axis][b->degree] + b->square[axis][b->degree - 1];
}

/* The factor from band to band. Band 0 tells nothing of it: it is the mean. */
static double fall(const double *square, int degree)
{
    static const double slowest = 0.85, fastest = 0.02;
    if (degree < 2)
        return slowest;
    int bands = degree >= 4 ? 2 : 1; /* in each of two groups */
    double last = 0, before = 0;
    for (int k = 0; k < bands; k++) {
        last += square[degree - k];
        before += square[degree - bands - k];
    }
    if (!(before > 0))
        return last > 0 ? slowest : fastest;
    return fmin(fmax(pow(last / before, 0.5 / bands), fastest), slowest);
}

/* What follows the last two bands, relative to their sum: sum_{m>p} q^2m / (q^2p + q^2(p-1)). */
static double tail(double q)
{
    double q4 = q * q * q * q;
    return q4 / (1 - q4);
}

void hpr_indicate(const hpr_solution *solution, const hpr_coverage *coverage, const double *indirect,
                  const double *norm2, hpr_indicator *indicator)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        uint32_t node = e->leaf[leaf];
        hpr_shape shape = (hpr_shape)solution->patches->shape[e->patch[node]];
        size_t count = e->dof[leaf + 1] - e->dof[leaf];
        double open = hpr_coverage_open_share(coverage, leaf);
        bands all = {.degree = e->degree[node]};
        for (size_t c = 0; c < n; c++)
            add_channel(shape, indirect + n * e->dof[leaf] + c, count, n, norm2[c] > 0 ? 1 / norm2[c] : 0,
                        &all);
        indicator[leaf] = (hpr_indicator){{0, 0}, {0, 0}};
        for (int axis = 0; axis < axes(shape); axis++) {
            double q = indicator[leaf].ratio[axis] = fall(all.square[axis], all.degree);
            indicator[leaf].error2[axis] = open * tail(q) * last_bands(&all, axis);
        }
    }
}
