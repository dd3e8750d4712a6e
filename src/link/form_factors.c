#include "link/form_factors.h"

#include "quadrature/block.h"
#include "visibility/views.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>

/* Working memory of one thread, and what it counted. */
typedef struct worker {
    hpr_block_scratch *scratch;
    hpr_views_cursor *cursor;
    uint32_t *blocker; /* [occluder_count] */
    double *block;     /* [HPR_MAX_BASIS]^2 */
    double tolerance;  /* asked of the block */
    hpr_pairs_done done;
    uint64_t kernel_count, ray_count, clip_count;
} worker;

typedef struct assembly {
    const hpr_rows *rows;
    hpr_context *context;
    double tolerance;
    int degree;
    hpr_visibility *visibility;
    hpr_views *views;
    hpr_quadrature *quadrature;
    worker *workers;
    double *result;    /* packed A F, or blocks */
    size_t block_size; /* 0: A F is wanted */
} assembly;

static bool has_area(const hpr_patches *patches, size_t p)
{
    return patches->area_m2[p] > 0;
}

static hpr_element_frame frame_of(const assembly *a, size_t p)
{
    const hpr_patches *patches = a->rows->patches;
    return (hpr_element_frame){.shape = (hpr_shape)patches->shape[p],
                               .degree = a->degree,
                               .origin = hpr_vec3_load(patches->origin + 3 * p),
                               .edge1 = hpr_vec3_load(patches->edge1 + 3 * p),
                               .edge2 = hpr_vec3_load(patches->edge2 + 3 * p),
                               .normal = hpr_vec3_load(patches->normal + 3 * p),
                               .area_m2 = patches->area_m2[p],
                               .opposite = {patches->opposite[2 * p], patches->opposite[2 * p + 1]}};
}

static void count(worker *w, const hpr_block_task *task, const hpr_block_result *result)
{
    size_t entries = hpr_basis_count(task->recv.shape, task->recv.degree) *
                     hpr_basis_count(task->send.shape, task->send.degree);
    double most = 0;
    for (size_t k = 0; k < entries; k++)
        most = fmax(most, fabs(w->block[k]));
    double *error = result->status == HPR_BLOCK_SAMPLED ? &w->done.sampled_error : &w->done.relative_error;
    if (most > 0)
        *error = fmax(*error, result->error / most);
    w->done.pair_count++;
    w->done.blocked_count += task->blocker_count > 0;
    w->done.rounded_count += result->status == HPR_BLOCK_ROUNDED;
    w->done.short_count += result->status >= HPR_BLOCK_SHORT;
}

/* The block of patches p (receiver) and q into w->block; false if it is zero. */
static bool integrate_pair(const assembly *a, worker *w, size_t p, size_t q)
{
    const hpr_patches *patches = a->rows->patches;
    if (a->rows->patch_surface[p] == a->rows->patch_surface[q] || !has_area(patches, p) ||
        !has_area(patches, q))
        return false;
    hpr_block_task task = {.recv = frame_of(a, p),
                           .send = frame_of(a, q),
                           .tolerance = w->tolerance,
                           .contact_m = patches->weld_m,
                           .visibility = a->visibility,
                           .blockers = w->blocker,
                           .clip = true,
                           .seed = (uint64_t)p << 32 | q};
    if (hpr_views_classify(a->views, w->cursor, p, q, w->blocker, &task.blocker_count) == HPR_SEES_NOTHING)
        return false;
    hpr_block_result result = hpr_block(a->quadrature, &task, w->block, w->scratch);
    w->kernel_count += result.kernel_count;
    w->ray_count += result.ray_count;
    w->clip_count += result.clip_count;
    if (result.seen)
        count(w, &task, &result);
    return result.seen;
}

/* First of row i among the entries j >= i of all rows. */
static size_t packed_row(size_t count, size_t i)
{
    return i * count - i * (i - 1) / 2;
}

/* A_p F_pq to a relative tolerance. */
static double integrate_exchange(const assembly *a, worker *w, size_t p, size_t q, double tolerance)
{
    const double *area = a->rows->patches->area_m2;
    w->tolerance = tolerance;
    return integrate_pair(a, w, p, q) ? sqrt(area[p]) * sqrt(area[q]) * w->block[0] : 0;
}

/* A_i F_ij, i <= j, each pair of patches to an absolute error as well (INFINITY: only relative). Pairs within
 * one row count in both directions. */
static double sum_entry(const assembly *a, worker *w, size_t i, size_t j, double allowed_m2)
{
    static const double tight = 1e-14;
    const hpr_rows *rows = a->rows;
    double sum = 0;
    for (size_t m = rows->first[i]; m < rows->first[i + 1]; m++) {
        for (size_t n = i == j ? m + 1 : rows->first[j]; n < rows->first[j + 1]; n++) {
            uint32_t p = rows->member[m], q = rows->member[n];
            double part = integrate_exchange(a, w, p, q, a->tolerance);
            if (part * a->tolerance > allowed_m2)
                part = integrate_exchange(a, w, p, q, fmax(tight, allowed_m2 / part));
            sum += part;
        }
    }
    return i == j ? 2 * sum : sum;
}

/* Where one sees hardly anything but the other, an error within the tolerance might make that more than all:
 * then the errors of all pairs of patches together must be rounding. */
static void integrate_entry(const assembly *a, worker *w, size_t i, size_t j)
{
    static const double rounding = 1e-14;
    const hpr_rows *rows = a->rows;
    double smaller = fmin(rows->row[i].area_m2, rows->row[j].area_m2);
    double sum = sum_entry(a, w, i, j, INFINITY);
    if (sum > (1 - a->tolerance) * smaller) {
        const hpr_pairs_done done = w->done;
        size_t pairs = (rows->first[i + 1] - rows->first[i]) * (rows->first[j + 1] - rows->first[j]);
        sum = sum_entry(a, w, i, j, rounding * smaller / (double)pairs);
        w->done = done;
    }
    a->result[packed_row(a->rows->count, i) + (j - i)] = sum;
}

/* K_ij and its transpose. */
static void integrate_block(const assembly *a, worker *w, size_t i, size_t j)
{
    const hpr_rows *rows = a->rows;
    if (i == j || rows->first[i] == rows->first[i + 1] || rows->first[j] == rows->first[j + 1])
        return;
    uint32_t p = rows->member[rows->first[i]], q = rows->member[rows->first[j]];
    w->tolerance = a->tolerance;
    if (!integrate_pair(a, w, p, q))
        return;
    size_t n = a->block_size, count = rows->count;
    size_t n_recv = hpr_basis_count((hpr_shape)rows->patches->shape[p], a->degree);
    size_t n_send = hpr_basis_count((hpr_shape)rows->patches->shape[q], a->degree);
    for (size_t k = 0; k < n_recv; k++) {
        for (size_t l = 0; l < n_send; l++) {
            a->result[((i * count + j) * n + k) * n + l] = w->block[k * n_send + l];
            a->result[((j * count + i) * n + l) * n + k] = w->block[k * n_send + l];
        }
    }
}

/* Entries are handed out in strips of one row: single ones where there are few, for a blocked pair may take
 * seconds, longer ones where the handing out would be felt. */
static void integrate_all(assembly *a)
{
    size_t count = a->rows->count, strip = 1 + count / 128, strips = (count + strip - 1) / strip;
    double entry_count = 0.5 * (double)count * ((double)count + 1);
    _Atomic uint64_t finished = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(a->context))
    for (size_t task = 0; task < count * strips; task++) {
        worker *w = &a->workers[omp_get_thread_num()];
        size_t i = task / strips, begin = task % strips * strip, end = begin + strip;
        if (end <= i)
            continue;
        for (size_t j = begin < i ? i : begin; j < end && j < count && !hpr_cancelled(a->context); j++) {
            if (a->block_size)
                integrate_block(a, w, i, j);
            else
                integrate_entry(a, w, i, j);
            finished++;
        }
        if (omp_get_thread_num() == 0)
            hpr_stage_progress(a->context, (double)finished / entry_count);
    }
}

static hpr_status make_workers(assembly *a)
{
    int threads = hpr_context_threads(a->context);
    size_t n = hpr_form_blocks_size(a->rows, a->degree);
    size_t occluders = hpr_visibility_occluder_count(a->visibility);
    hpr_status status =
        hpr_allocate_into(a->context, &a->workers, (size_t)threads, sizeof *a->workers, "quadrature scratch");
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        worker *w = &a->workers[t];
        status = hpr_block_scratch_create(a->context, &w->scratch);
        if (status == HPR_OK)
            status = hpr_views_cursor_create(a->views, &w->cursor);
        if (status == HPR_OK)
            status = hpr_allocate_into(a->context, &w->blocker, occluders, sizeof *w->blocker,
                                       "quadrature scratch");
        if (status == HPR_OK)
            status = hpr_allocate_into(a->context, &w->block, n * n, sizeof *w->block, "quadrature scratch");
    }
    return status;
}

static void close_workers(assembly *a, hpr_pairs_done *done)
{
    for (int t = 0; a->workers && t < hpr_context_threads(a->context); t++) {
        worker *w = &a->workers[t];
        done->pair_count += w->done.pair_count;
        done->blocked_count += w->done.blocked_count;
        done->rounded_count += w->done.rounded_count;
        done->short_count += w->done.short_count;
        done->relative_error = fmax(done->relative_error, w->done.relative_error);
        done->sampled_error = fmax(done->sampled_error, w->done.sampled_error);
        hpr_count(a->context, HPR_COUNT_KERNEL, w->kernel_count);
        hpr_count(a->context, HPR_COUNT_RAYS, w->ray_count);
        hpr_count(a->context, HPR_COUNT_CLIPS, w->clip_count);
        hpr_block_scratch_destroy(&w->scratch);
        hpr_views_cursor_destroy(&w->cursor);
        hpr_release(a->context, w->blocker);
        hpr_release(a->context, w->block);
    }
    hpr_release(a->context, a->workers);
}

static hpr_status run(assembly *a, hpr_pairs_done *done)
{
    *done = (hpr_pairs_done){0};
    hpr_status status = hpr_visibility_create(a->rows->patches, &a->visibility);
    if (status == HPR_OK)
        status = hpr_quadrature_create(a->context, &a->quadrature);
    if (status == HPR_OK)
        status = hpr_views_create(a->visibility, NULL, &a->views);
    if (status == HPR_OK)
        status = make_workers(a);
    if (status == HPR_OK) {
        integrate_all(a);
        if (hpr_cancelled(a->context))
            status = hpr_fail(a->context, HPR_ERR_INTERRUPTED, "interrupted");
    }
    close_workers(a, done);
    hpr_views_destroy(&a->views);
    hpr_quadrature_destroy(&a->quadrature);
    hpr_visibility_destroy(&a->visibility);
    return status;
}

double hpr_form_factors_bytes(size_t row_count)
{
    return (0.5 * ((double)row_count + 1) + 1) * (double)row_count * sizeof(double);
}

static void add_masks(const hpr_rows *rows, hpr_form_factors *factors)
{
    for (size_t m = 0; m < rows->mask_count; m++) {
        const hpr_mask *mask = &rows->mask[m];
        size_t i = mask->mask_row < mask->base_row ? mask->mask_row : mask->base_row;
        size_t j = mask->mask_row < mask->base_row ? mask->base_row : mask->mask_row;
        factors->exchange[packed_row(factors->count, i) + (j - i)] +=
            i == j ? 2 * mask->area_m2 : mask->area_m2;
    }
}

hpr_status hpr_form_factors_create(const hpr_rows *rows, double tolerance, hpr_form_factors **out)
{
    hpr_context *ctx = rows->context;
    hpr_form_factors *factors = NULL;
    size_t count = rows->count;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &factors, 1, sizeof *factors, "view factors");
    if (status != HPR_OK)
        return status;
    factors->context = ctx;
    factors->count = count;
    status = hpr_allocate_into(ctx, &factors->area_m2, count, sizeof(double), "view factors");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &factors->exchange, packed_row(count, count), sizeof(double),
                                   "view factors");
    if (status == HPR_OK) {
        for (size_t i = 0; i < count; i++)
            factors->area_m2[i] = rows->row[i].area_m2;
        assembly a = {.rows = rows, .context = ctx, .tolerance = tolerance, .result = factors->exchange};
        status = run(&a, &factors->done);
    }
    if (status == HPR_OK)
        add_masks(rows, factors);
    else
        hpr_form_factors_destroy(&factors);
    *out = factors;
    return status;
}

void hpr_form_factors_destroy(hpr_form_factors **out)
{
    hpr_form_factors *factors = *out;
    if (!factors)
        return;
    hpr_context *ctx = factors->context;
    hpr_release(ctx, factors->area_m2);
    hpr_release(ctx, factors->exchange);
    hpr_release(ctx, factors);
    *out = NULL;
}

double hpr_form_factors_at(const hpr_form_factors *factors, size_t i, size_t j)
{
    size_t low = i < j ? i : j, high = i < j ? j : i;
    return factors->exchange[packed_row(factors->count, low) + (high - low)];
}

void hpr_form_factors_row(const hpr_form_factors *factors, size_t i, double *row)
{
    double area = factors->area_m2[i];
    for (size_t j = 0; j < factors->count; j++)
        row[j] = area > 0 ? hpr_form_factors_at(factors, i, j) / area : 0;
}

size_t hpr_form_blocks_size(const hpr_rows *rows, int degree)
{
    size_t size = 1;
    for (size_t p = 0; p < rows->patches->count; p++) {
        size_t n = hpr_basis_count((hpr_shape)rows->patches->shape[p], degree);
        if (has_area(rows->patches, p) && n > size)
            size = n;
    }
    return size;
}

hpr_status hpr_form_blocks(const hpr_rows *rows, int degree, double tolerance, double *block,
                           hpr_pairs_done *done)
{
    assembly a = {.rows = rows,
                  .context = rows->context,
                  .tolerance = tolerance,
                  .degree = degree,
                  .result = block,
                  .block_size = hpr_form_blocks_size(rows, degree)};
    return run(&a, done);
}
