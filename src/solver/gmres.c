#include "solver/iterations.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Vectors before a restart, and what they may take. */
enum { MAX_VECTORS = 60, LEAST_VECTORS = 8 };
static const double vector_bytes = 2e9;

/* One channel's Hessenberg matrix, made triangular by rotations as it grows. */
typedef struct arnoldi {
    double column[MAX_VECTORS][MAX_VECTORS + 1]; /* [column][row] */
    double cosine[MAX_VECTORS], sine[MAX_VECTORS];
    double rest[MAX_VECTORS + 1]; /* right-hand side; its last entry is the residual */
    double norm;                  /* of x at the start */
    int count;                    /* columns; ends before the others' if the channel is solved */
} arnoldi;

typedef struct krylov {
    hpr_relaxation *r;
    size_t channels, dofs;
    int capacity;
    double *vector;   /* [capacity + 1][channels][dofs] */
    double *work;     /* [channels][dofs] */
    double *weight;   /* [channels][dofs] of the inner product; NULL: 1 */
    arnoldi *arnoldi; /* [channels] */
} krylov;

static double *vector_of(const krylov *k, int index, size_t channel)
{
    return k->vector + ((size_t)index * k->channels + channel) * k->dofs;
}

/* a . b of a channel in chunks whose sums are added in order, so that threads change no bit. */
static double dot(const krylov *k, size_t channel, const double *a, const double *b)
{
    enum { CHUNKS = 64 };
    double sum[CHUNKS], total = 0;
    size_t n = k->dofs, width = n / CHUNKS + 1;
    const double *weight = k->weight ? k->weight + channel * n : NULL;
#pragma omp parallel for num_threads(hpr_context_threads(k->r->context)) if (n > 100000)
    for (size_t chunk = 0; chunk < CHUNKS; chunk++) {
        double part = 0;
        for (size_t i = chunk * width; i < n && i < (chunk + 1) * width; i++)
            part += weight ? weight[i] * a[i] * b[i] : a[i] * b[i];
        sum[chunk] = part;
    }
    for (size_t chunk = 0; chunk < CHUNKS; chunk++)
        total += sum[chunk];
    return total;
}

static void add_scaled(const krylov *k, double *to, double factor, const double *from)
{
    size_t n = k->dofs;
#pragma omp parallel for num_threads(hpr_context_threads(k->r->context)) if (n > 100000)
    for (size_t i = 0; i < n; i++)
        to[i] += factor * from[i];
}

static void scale_into(const krylov *k, double *to, double factor, const double *from)
{
    for (size_t i = 0; i < k->dofs; i++)
        to[i] = factor * from[i];
}

/* The first vector of each channel: the residual S(x) - x. */
static void start(krylov *k, const double *x)
{
    hpr_linear_problem *p = k->r->problem;
    memcpy(k->work, x, k->channels * k->dofs * sizeof *x);
    hpr_relaxation_sweep(k->r, k->work, true);
    p->sweeps++;
    for (size_t c = 0; c < k->channels; c++) {
        arnoldi *a = &k->arnoldi[c];
        double *first = vector_of(k, 0, c), *w = k->work + c * k->dofs;
        a->norm = sqrt(dot(k, c, w, w));
        add_scaled(k, w, -1, x + c * k->dofs);
        double norm = sqrt(dot(k, c, w, w));
        memset(a->rest, 0, sizeof a->rest);
        a->rest[0] = norm;
        a->count = norm > 0 ? 0 : -1;
        scale_into(k, first, norm > 0 ? 1 / norm : 0, w);
    }
}

static void rotate(arnoldi *a, int j)
{
    double *h = a->column[j];
    for (int i = 0; i < j; i++) {
        double upper = a->cosine[i] * h[i] + a->sine[i] * h[i + 1];
        h[i + 1] = a->cosine[i] * h[i + 1] - a->sine[i] * h[i];
        h[i] = upper;
    }
    double length = hypot(h[j], h[j + 1]);
    a->cosine[j] = length > 0 ? h[j] / length : 1;
    a->sine[j] = length > 0 ? h[j + 1] / length : 0;
    h[j] = length;
    a->rest[j + 1] = -a->sine[j] * a->rest[j];
    a->rest[j] *= a->cosine[j];
}

/* Vector j + 1 of each channel, from (I - L) applied to vector j, L a sweep without source. */
static void extend(krylov *k, int j)
{
    static const double nothing = 1e-15; /* of the vector before orthogonalisation: the space is complete */
    memcpy(k->work, vector_of(k, j, 0), k->channels * k->dofs * sizeof(double));
    hpr_relaxation_sweep(k->r, k->work, false);
    k->r->problem->sweeps++;
    for (size_t c = 0; c < k->channels; c++) {
        arnoldi *a = &k->arnoldi[c];
        double *w = k->work + c * k->dofs, *next = vector_of(k, j + 1, c);
        if (a->count != j) {
            scale_into(k, next, 0, w);
            continue;
        }
        scale_into(k, w, -1, w);
        add_scaled(k, w, 1, vector_of(k, j, c));
        double before = sqrt(dot(k, c, w, w));
        for (int i = 0; i <= j; i++) {
            a->column[j][i] = dot(k, c, w, vector_of(k, i, c));
            add_scaled(k, w, -a->column[j][i], vector_of(k, i, c));
        }
        double norm = sqrt(dot(k, c, w, w));
        a->column[j][j + 1] = norm;
        scale_into(k, next, norm > nothing * before ? 1 / norm : 0, w);
        rotate(a, j);
        a->count = norm > nothing * before ? j + 1 : -(j + 2);
    }
}

/* Columns that a channel has, whether it goes on or not. */
static int columns_of(const arnoldi *a)
{
    return a->count >= 0 ? a->count : -a->count - 1;
}

/* x += V y with R y = rest. */
static void take_step(krylov *k, double *x)
{
    for (size_t c = 0; c < k->channels; c++) {
        const arnoldi *a = &k->arnoldi[c];
        int count = columns_of(a);
        double y[MAX_VECTORS];
        for (int i = count - 1; i >= 0; i--) {
            y[i] = a->rest[i];
            for (int j = i + 1; j < count; j++)
                y[i] -= a->column[j][i] * y[j];
            y[i] = a->column[i][i] != 0 ? y[i] / a->column[i][i] : 0;
        }
        for (int i = 0; i < count; i++)
            add_scaled(k, x + c * k->dofs, y[i], vector_of(k, i, c));
    }
}

/* Relative residual of the worst channel. */
static double worst_rest(const krylov *k)
{
    double worst = 0;
    for (size_t c = 0; c < k->channels; c++) {
        const arnoldi *a = &k->arnoldi[c];
        if (a->count >= 0 && a->norm > 0)
            worst = fmax(worst, fabs(a->rest[a->count]) / a->norm);
    }
    return worst;
}

static bool goes_on(const krylov *k)
{
    for (size_t c = 0; c < k->channels; c++) {
        if (k->arnoldi[c].count >= 0)
            return true;
    }
    return false;
}

/* Larger than any sum of reflections that is not the result of rounding: rho = 1 in a closed scene. */
static bool without_bound(const krylov *k, const double *x)
{
    static const double bound = 1e9;
    for (size_t c = 0; c < k->channels; c++) {
        const double *d = k->r->problem->direct + c * k->dofs;
        if (dot(k, c, x + c * k->dofs, x + c * k->dofs) > bound * bound * dot(k, c, d, d))
            return true;
    }
    return false;
}

static void iterate(krylov *k, double target, hpr_iteration *it)
{
    static const double progress = 0.5; /* what a restart must gain */
    hpr_linear_problem *p = k->r->problem;
    double before = INFINITY;
    it->end = HPR_ITERATION_LIMIT;
    while (p->sweeps < p->max_sweeps) {
        start(k, p->irradiance);
        double first = it->change = worst_rest(k);
        if (first <= target || first > progress * before) {
            it->end = first <= 10 * target ? HPR_ITERATION_DONE : HPR_ITERATION_STANDSTILL;
            return;
        }
        before = first;
        for (int j = 0; j < k->capacity && p->sweeps < p->max_sweeps && goes_on(k); j++) {
            extend(k, j);
            it->change = worst_rest(k);
            if (hpr_cancelled(k->r->context)) {
                it->end = HPR_ITERATION_CANCELLED;
                return;
            }
            hpr_stage_progress(k->r->context,
                               fmin(0.99, log(first / fmax(it->change, target)) / log(first / target)));
            if (it->change <= target)
                break;
        }
        take_step(k, p->irradiance);
        if (without_bound(k, p->irradiance)) {
            it->end = HPR_ITERATION_STANDSTILL;
            return;
        }
    }
}

/* Each patch relative to itself: 1 / ‖x‖^2 on it. */
static hpr_status weigh_patches(krylov *k)
{
    const hpr_relaxation *r = k->r;
    const hpr_elements *e = r->elements;
    hpr_status status =
        hpr_allocate_into(r->context, &k->weight, k->channels * k->dofs, sizeof(double), "the solver");
    for (size_t patch = 0; status == HPR_OK && patch < k->channels * e->patch_count; patch++) {
        size_t own = patch % e->patch_count, first = patch / e->patch_count * k->dofs;
        size_t begin = first + e->dof[e->patch_leaf[own]], end = first + e->dof[e->patch_leaf[own + 1]];
        double norm2 = 0;
        for (size_t i = begin; i < end; i++)
            norm2 += r->problem->irradiance[i] * r->problem->irradiance[i];
        for (size_t i = begin; i < end; i++)
            k->weight[i] = norm2 > 0 ? 1 / norm2 : 0;
    }
    return status;
}

hpr_status hpr_gmres(hpr_relaxation *r, double ratio, hpr_iteration *it)
{
    static const double rounding = 4 * DBL_EPSILON;
    hpr_context *ctx = r->context;
    size_t channels = r->problem->channel_count, size = channels * r->dofs;
    double affordable = vector_bytes / ((double)(size + 1) * sizeof(double));
    krylov k = {.r = r, .channels = channels, .dofs = r->dofs};
    k.capacity = (int)fmax(LEAST_VECTORS, fmin(MAX_VECTORS, affordable));
    hpr_status status =
        hpr_allocate_into(ctx, &k.vector, (size_t)(k.capacity + 1) * size, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &k.work, size, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &k.arnoldi, channels, sizeof *k.arnoldi, "the solver");
    if (status == HPR_OK && r->by_patch)
        status = weigh_patches(&k);
    if (status == HPR_OK) {
        double room = ratio > 0 && ratio < 1 ? 1 - ratio : 1;
        iterate(&k, fmax(r->problem->tolerance * room, rounding), it);
    }
    hpr_release(ctx, k.vector);
    hpr_release(ctx, k.work);
    hpr_release(ctx, k.weight);
    hpr_release(ctx, k.arnoldi);
    return status;
}
