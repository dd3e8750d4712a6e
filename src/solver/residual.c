#include "solver/residual.h"

#include "basis/basis.h"
#include "math/hash.h"
#include "solver/arrivals.h"

#include <math.h>

typedef struct measuring {
    const hpr_solution *solution;
    const hpr_transport *transport;
    const double *indirect, *norm2;
    hpr_indicator *indicator;
    size_t count;
    hpr_spot *spot;     /* [count] */
    double *weight;     /* [count] 1 / density, square metres */
    double *part;       /* [count] of all points that the leaf has */
    double *irradiance; /* [count][channels] H~ - D, and then (H~ - H)2 / density / norm2 */
} measuring;

static double part_of(const hpr_elements *e, double area, double error2, const hpr_indicator *indicator,
                      size_t leaf)
{
    static const double by_area = 0.3; /* of the points, for what the indicator overlooks */
    double here = indicator[leaf].error2[0] + indicator[leaf].error2[1];
    double even = e->area_m2[e->leaf[leaf]] / area;
    return error2 > 0 ? by_area * even + (1 - by_area) * here / error2 : even;
}

/* The k-th of the points of a leaf: a lattice with a shift of its own (Source: Roberts 2018, R2), denser to
 * the rim like 1 / sqrt(s (1-s)): there polynomials leave out most, so that all points count about as much.
 * *thinness: 1 / density, relative to even points. */
static hpr_spot place(const hpr_solution *solution, size_t leaf, size_t k, double *thinness)
{
    static const double half_pi = 1.57079632679489661923;
    static const double step[2] = {0.75487766624669276, 0.56984029099805327};
    const hpr_element_frame frame = hpr_leaf_frame(solution->patches, solution->elements, leaf);
    double at[2], point[2];
    *thinness = 1;
    for (size_t i = 0; i < 2; i++) {
        at[i] = hpr_hash_unit(2 * leaf + i + 1) + (double)(k + 1) * step[i];
        double angle = half_pi * (at[i] - floor(at[i]));
        at[i] = sin(angle) * sin(angle);
        *thinness *= half_pi * sin(2 * angle);
    }
    hpr_shape_uniform(frame.shape, frame.opposite, at[0], at[1], point);
    return (hpr_spot){leaf, point[0], point[1]};
}

/* The k-th of those that are open, denser by as much as they are fewer: of one of which little is open few
 * points would meet that, and each would count for many. */
static hpr_spot place_open(const measuring *m, size_t leaf, size_t k, double *thinness)
{
    enum { LOOKED_AT = 128 };
    const hpr_coverage *coverage = m->transport->coverage;
    hpr_spot spot;
    size_t open = 0;
    for (size_t i = 0; i < LOOKED_AT && hpr_coverage_open_share(coverage, leaf) < 1; i++) {
        spot = place(m->solution, leaf, i, thinness);
        open += hpr_coverage_open(coverage, leaf, spot.s, spot.t);
    }
    if (open == 0 || open == LOOKED_AT)
        return place(m->solution, leaf, k, thinness);
    for (size_t i = 0, passed = 0; passed <= k; i++) {
        spot = place(m->solution, leaf, i, thinness);
        passed += hpr_coverage_open(coverage, leaf, spot.s, spot.t);
    }
    *thinness *= (double)open / LOOKED_AT;
    return spot;
}

/* Systematic sampling of the leaves by their parts. */
static void choose_spots(measuring *m)
{
    const hpr_elements *e = m->solution->elements;
    double area = 0, error2 = 0, passed = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        area += e->area_m2[e->leaf[leaf]];
        error2 += m->indicator[leaf].error2[0] + m->indicator[leaf].error2[1];
    }
    size_t next = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        double part = part_of(e, area, error2, m->indicator, leaf);
        passed += part;
        bool last = leaf + 1 == e->leaf_count;
        for (size_t k = 0; next < m->count && (last || ((double)next + 0.5) / (double)m->count < passed);
             k++) {
            double thinness;
            m->spot[next] = place_open(m, leaf, k, &thinness);
            m->weight[next] = thinness * e->area_m2[e->leaf[leaf]] / part;
            m->part[next++] = part;
        }
    }
}

static hpr_status gather(measuring *m, double tolerance)
{
    enum { MOST = 4096 }; /* points of a call, so that each of each step has a number of its own */
    const hpr_arrivals_task task = {.solution = m->solution,
                                    .transport = m->transport,
                                    .tolerance = tolerance,
                                    .count = m->count,
                                    .spot = m->spot,
                                    .call = (uint32_t)(MOST * (size_t)m->solution->summary.steps + m->count)};
    hpr_status status = hpr_arrivals_gather(&task, m->irradiance);
    return status == HPR_OK ? hpr_arrivals_add_outside(&task, true, m->irradiance) : status;
}

/* From H~ to the squares that are summed; channels without light count nothing. */
static void square_all(measuring *m)
{
    const hpr_solution *solution = m->solution;
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count;
    for (size_t i = 0; i < m->count; i++) {
        size_t leaf = m->spot[i].leaf;
        bool open = hpr_coverage_open(m->transport->coverage, leaf, m->spot[i].s, m->spot[i].t);
        const hpr_element_frame frame = hpr_leaf_frame(solution->patches, e, leaf);
        double basis[HPR_MAX_BASIS];
        hpr_frame_basis(&frame, m->spot[i].s, m->spot[i].t, basis);
        for (size_t c = 0; c < n; c++) {
            double h = 0, *value = &m->irradiance[n * i + c];
            for (size_t k = e->dof[leaf]; k < e->dof[leaf + 1]; k++)
                h += basis[k - e->dof[leaf]] * m->indirect[n * k + c];
            double difference = *value - h * hpr_frame_scale(&frame);
            *value = open && m->norm2[c] > 0 ? m->weight[i] * difference * difference / m->norm2[c] : 0;
        }
    }
}

static hpr_residual sum_up(const measuring *m)
{
    hpr_residual worst = {0};
    size_t n = m->solution->channel_count;
    for (size_t c = 0; c < n; c++) {
        double sum = 0, squares = 0, count = (double)m->count;
        for (size_t i = 0; i < m->count; i++) {
            double square = m->irradiance[n * i + c];
            sum += square;
            squares += square * square;
        }
        double mean = sum / count;
        if (mean >= worst.error2)
            worst = (hpr_residual){mean, sqrt(fmax(squares / count - mean * mean, 0) / count)};
    }
    return worst;
}

/* The mean of the squares at a leaf's points is an estimate of what it leaves out; so is the indicator, which
 * counts as much as a few of them. */
static void correct_indicator(const measuring *m)
{
    static const double told_points = 2, least = 0.1;
    size_t n = m->solution->channel_count;
    for (size_t first = 0, end; first < m->count; first = end) {
        size_t leaf = m->spot[first].leaf;
        double sum = 0;
        for (end = first; end < m->count && m->spot[end].leaf == leaf; end++) {
            for (size_t c = 0; c < n; c++)
                sum += m->irradiance[n * end + c];
        }
        double points = (double)(end - first), error2 = sum * m->part[first] / points;
        hpr_indicator *it = &m->indicator[leaf];
        double told = it->error2[0] + it->error2[1];
        error2 = (points * error2 + told_points * told) / (points + told_points);
        if (!(told > 0))
            it->error2[0] = it->error2[1] = error2 / 2;
        for (int axis = 0; axis < 2 && told > 0; axis++)
            it->error2[axis] *= fmax(error2 / told, least);
    }
}

hpr_status hpr_residual_measure(const hpr_solution *solution, const hpr_transport *transport,
                                const double *indirect, const double *norm2, double tolerance, size_t count,
                                hpr_indicator *indicator, hpr_residual *residual)
{
    hpr_context *ctx = solution->context;
    measuring m = {.solution = solution,
                   .transport = transport,
                   .indirect = indirect,
                   .norm2 = norm2,
                   .indicator = indicator,
                   .count = count};
    hpr_status status = hpr_allocate_into(ctx, &m.spot, count, sizeof *m.spot, "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &m.weight, count, sizeof(double), "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &m.part, count, sizeof(double), "the error estimate");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &m.irradiance, count * solution->channel_count, sizeof(double),
                                   "the error estimate");
    if (status == HPR_OK) {
        choose_spots(&m);
        status = gather(&m, tolerance);
    }
    if (status == HPR_OK) {
        square_all(&m);
        *residual = sum_up(&m);
        correct_indicator(&m);
    }
    hpr_release(ctx, m.spot);
    hpr_release(ctx, m.weight);
    hpr_release(ctx, m.part);
    hpr_release(ctx, m.irradiance);
    return status;
}
