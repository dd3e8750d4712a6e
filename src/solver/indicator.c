#include "solver/indicator.h"

#include "basis/basis.h"
#include "solver/along.h"

#include <math.h>

enum { BANDS = HPR_MAX_ORDER + 1 };

/* Of what elements do not send of direct light, what arrives. */
#define PART_OF_CONSTANT 0.3
#define PART_OF_LINEAR 0.2
/* Of the square of a mean, what is left out where nothing tells. */
#define OF_MEAN 0.1

/* Squares of the bands of one leaf, of all channels with their weight. */
typedef struct bands {
    int degree;
    double square[2][BANDS];
} bands;

static int axes(hpr_shape shape)
{
    return shape == HPR_SHAPE_TRIANGLE ? 1 : 2;
}

/* Of a triangle by total degree. */
static void add_total(const double *coefficient, size_t stride, double weight, bands *b)
{
    size_t k = 0;
    for (int total = 0; total <= b->degree; total++) {
        for (int i = 0; i <= total; i++, k++)
            b->square[0][total] += weight * coefficient[k * stride] * coefficient[k * stride];
    }
}

/* Of a quadrilateral, which has no functions of a higher total degree, bands are of that too; what is in one
 * goes to the axes by their degrees in it. */
static void add_tensor(const hpr_element_frame *frame, const double *value, double weight, bands *b)
{
    int n = b->degree + 1;
    bool product = frame->shape == HPR_SHAPE_PARALLELOGRAM;
    for (int k = 0; k < n * n; k++) {
        const int degree[2] = {k / n, k % n}, total = degree[0] + degree[1];
        for (int axis = 0; axis < 2; axis++) {
            double share = product || total == 0 ? 1 : (double)degree[axis] / total;
            int band = product ? degree[axis] : total < n ? total : b->degree;
            b->square[axis][band] += share * weight * value[k] * value[k];
        }
    }
}

static void add_channel(const hpr_element_frame *frame, const double *coefficient, size_t stride,
                        double norm2, bands *b)
{
    double value[HPR_MAX_BASIS], weight = norm2 > 0 ? 1 / norm2 : 0;
    if (frame->shape == HPR_SHAPE_TRIANGLE) {
        add_total(coefficient, stride, weight, b);
        return;
    }
    hpr_along_axes(frame, coefficient, stride, value);
    add_tensor(frame, value, weight, b);
}

/* From one band to the next, or, where there is next to nothing in that, half of the way from the one before.
 */
static double ratio(const double *square, int band)
{
    static const double of_mean = 0.1; /* of the square of the mean, that counts like a band before band 2 */
    double last = square[band], before = square[band - 1];
    if (!(last > 0))
        return 0;
    if (before >= last)
        return sqrt(last / before);
    double far = band < 2 ? 0 : square[band - 2] * (band == 2 ? of_mean : 1);
    return far > last ? sqrt(sqrt(last / far)) : 1;
}

/* The factor from band to band; a function that is even or odd is not to deceive. */
static double fall(const double *square, int degree)
{
    static const double slowest = 0.85, fastest = 0.02, unknown = 0.5;
    double q;
    if (degree < 2)
        return unknown;
    if (degree == 2)
        q = ratio(square, 2);
    else if (degree == 3)
        q = fmax(ratio(square, 3), ratio(square, 2));
    else {
        double last = square[degree] + square[degree - 1], before = square[degree - 2] + square[degree - 3];
        q = before > 0 ? sqrt(sqrt(last / before)) : last > 0 ? slowest : fastest;
    }
    return fmin(fmax(q, fastest), slowest);
}

/* The square of what follows the last band. From two bands of a fall q it is their sum times
 * sum_{m>p} q^2m / (q^2p + q^2(p-1)); a constant and a slope tell little of it. */
static double tail(const bands *b, int axis, double q)
{
    static const double of_slope = 0.2, least = 0.002;
    const double *square = b->square[axis];
    if (b->degree == 0)
        return OF_MEAN * square[0];
    if (b->degree == 1)
        return of_slope * square[1] + least * square[0];
    double q4 = q * q * q * q;
    return q4 / (1 - q4) * (square[b->degree] + square[b->degree - 1]);
}

/*
 * What an element does not send of the light that comes straight from lamps. Of low degree it leaves out much
 * of it, and what it leaves out of a mean or a slope is seen by all that it sends to; from degree 2 on that
 * is the product of two small things, and no residual at points shows it (solver/residual.h), so that it has
 * to be told here. Square of the norm, of H.
 */
static double unsent(const hpr_solution *solution, const hpr_element_frame *frame, const double *direct,
                     const double *norm2, size_t leaf)
{
    static const double part[2] = {PART_OF_CONSTANT, PART_OF_LINEAR};
    const hpr_elements *e = solution->elements;
    const hpr_patches *patches = solution->patches;
    size_t n = solution->channel_count, dofs = e->dof[e->leaf_count], first = e->dof[leaf];
    size_t patch = e->patch[e->leaf[leaf]];
    double sum = 0;
    for (size_t c = 0; frame->degree < 2 && c < n; c++) {
        bands b = {.degree = frame->degree};
        double rho = part[frame->degree] * patches->reflectance[n * patch + c];
        add_channel(frame, direct + c * dofs + first, 1, norm2[c], &b);
        for (int axis = 0; axis < axes(frame->shape); axis++)
            sum += rho * rho * tail(&b, axis, 1) / axes(frame->shape);
    }
    return sum;
}

/*
 * Of constants the difference between the halves of the smallest piece that was halved along an axis tells
 * what is left out along it: where H is linear, a twelfth of its square. Where H is even about the middle it
 * tells nothing; so that this does not deceive, part of what was left out before halving is believed to stay.
 * Two last bisections tell it of triangles.
 */
typedef struct details {
    const hpr_solution *solution;
    const hpr_coverage *coverage;
    const double *coefficient, *norm2;
    size_t of_dof, of_channel; /* strides */
    bool of_direct;            /* the coefficients */
    hpr_indicator *indicator;
} details;

static double mean_of(const details *d, uint32_t node, size_t channel)
{
    const hpr_elements *e = d->solution->elements;
    uint32_t child = e->child[node], leaf = e->leaf_of_node[node];
    if (child == HPR_NONE)
        return d->coefficient[e->dof[leaf] * d->of_dof + channel * d->of_channel] / sqrt(e->area_m2[node]);
    double first = e->area_m2[child], second = e->area_m2[child + 1];
    return (first * mean_of(d, child, channel) + second * mean_of(d, child + 1, channel)) / (first + second);
}

static double weight(const details *d, uint32_t node, size_t channel)
{
    const hpr_solution *solution = d->solution;
    size_t patch = solution->elements->patch[node];
    double rho = d->of_direct ? PART_OF_CONSTANT *
                                    solution->patches->reflectance[solution->channel_count * patch + channel]
                              : 1;
    return d->norm2[channel] > 0 ? rho * rho / d->norm2[channel] : 0;
}

static double difference2(const details *d, uint32_t child)
{
    static const double of_linear = 1. / 12;
    double sum = 0;
    for (size_t c = 0; c < d->solution->channel_count; c++) {
        double difference = mean_of(d, child, c) - mean_of(d, child + 1, c);
        sum += of_linear * weight(d, child, c) * difference * difference;
    }
    return sum;
}

/* density: left out along each axis, per area. */
static void descend(const details *d, uint32_t node, const double density[2])
{
    const hpr_elements *e = d->solution->elements;
    hpr_shape shape = (hpr_shape)d->solution->patches->shape[e->patch[node]];
    static const double stays = 1. / 16;
    bool tensor = shape != HPR_SHAPE_TRIANGLE;
    uint32_t child = e->child[node], leaf = e->leaf_of_node[node];
    if (child != HPR_NONE) {
        int halved = tensor ? e->axis[node] : 1;
        double here = fmax(difference2(d, child), stays * density[halved]);
        double next[2] = {tensor ? density[0] : here, density[tensor ? 1 : 0]};
        if (tensor)
            next[halved] = here;
        descend(d, child, next);
        descend(d, child + 1, next);
        return;
    }
    double sum = density[0] + density[1];
    if (e->degree[node] > 0)
        return;
    double open = e->area_m2[node] * hpr_coverage_open_share(d->coverage, leaf);
    if (d->of_direct) {
        d->indicator[leaf].unsent2 = open * sum;
        return;
    }
    d->indicator[leaf].error2[0] = open * (tensor ? density[0] : sum);
    d->indicator[leaf].error2[1] = tensor ? open * density[1] : 0;
}

static void indicate_details(const details *d)
{
    for (uint32_t patch = 0; patch < d->solution->patches->count; patch++) {
        double sum = 0;
        for (size_t c = 0; c < d->solution->channel_count; c++) {
            double mean = mean_of(d, patch, c);
            sum += OF_MEAN * weight(d, patch, c) * mean * mean;
        }
        descend(d, patch, (double[2]){sum, sum});
    }
}

void hpr_indicate(const hpr_solution *solution, const hpr_coverage *coverage, const double *indirect,
                  const double *direct, const double *norm2, hpr_indicator *indicator)
{
    static const double singular = 0.7; /* of r^lambda, lambda > 0.5, about degree 4 */
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        const hpr_element_frame frame = hpr_leaf_frame(solution->patches, e, leaf);
        double open = hpr_coverage_open_share(coverage, leaf);
        bands all = {.degree = frame.degree};
        for (size_t c = 0; c < n; c++)
            add_channel(&frame, indirect + n * e->dof[leaf] + c, n, norm2[c], &all);
        indicator[leaf] = (hpr_indicator){.unsent2 = open * unsent(solution, &frame, direct, norm2, leaf),
                                          .cut = hpr_coverage_cut(coverage, leaf)};
        for (int axis = 0; axis < axes(frame.shape); axis++) {
            double q = fall(all.square[axis], all.degree);
            q = indicator[leaf].ratio[axis] = indicator[leaf].cut ? fmax(q, singular) : q;
            indicator[leaf].error2[axis] = open * tail(&all, axis, q);
        }
    }
    /* both refinements of degree have their own way with the first degrees */
    if (solution->summary.options.tolerance > 0 && solution->summary.options.refine != HPR_REFINE_H)
        return;
    details d = {.solution = solution,
                 .coverage = coverage,
                 .coefficient = indirect,
                 .norm2 = norm2,
                 .of_dof = n,
                 .of_channel = 1,
                 .indicator = indicator};
    indicate_details(&d);
    d.coefficient = direct;
    d.of_dof = 1;
    d.of_channel = e->dof[e->leaf_count];
    d.of_direct = true;
    indicate_details(&d);
}
