#include "link/pairs.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>

static bool has_area(const hpr_patches *patches, size_t p)
{
    return patches->area_m2[p] > 0;
}

hpr_element_frame hpr_pairs_frame(const hpr_pairs *pairs, size_t p)
{
    const hpr_patches *patches = pairs->rows->patches;
    return (hpr_element_frame){.shape = (hpr_shape)patches->shape[p],
                               .degree = pairs->degree,
                               .origin = hpr_vec3_load(patches->origin + 3 * p),
                               .edge1 = hpr_vec3_load(patches->edge1 + 3 * p),
                               .edge2 = hpr_vec3_load(patches->edge2 + 3 * p),
                               .normal = hpr_vec3_load(patches->normal + 3 * p),
                               .area_m2 = patches->area_m2[p],
                               .opposite = {patches->opposite[2 * p], patches->opposite[2 * p + 1]}};
}

bool hpr_pairs_counts(const hpr_pairs *pairs, size_t p, size_t q)
{
    const hpr_rows *rows = pairs->rows;
    return rows->patch_surface[p] != rows->patch_surface[q] && has_area(rows->patches, p) &&
           has_area(rows->patches, q);
}

static void count(hpr_pairs_worker *w, const hpr_block_task *task, const hpr_block_result *result)
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

hpr_verdict hpr_pairs_look(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q)
{
    return hpr_views_classify(pairs->views, w->cursor, p, q, w->blocker, &w->blocker_count);
}

bool hpr_pairs_integrate_past(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q,
                              double tolerance)
{
    const hpr_block_task task = {.recv = hpr_pairs_frame(pairs, p),
                                 .send = hpr_pairs_frame(pairs, q),
                                 .tolerance = tolerance,
                                 .contact_m = pairs->rows->patches->weld_m,
                                 .visibility = pairs->visibility,
                                 .blockers = w->blocker,
                                 .blocker_count = w->blocker_count,
                                 .clip = true,
                                 .seed = (uint64_t)p << 32 | q};
    hpr_block_result result = hpr_block_ref(pairs->quadrature, &task, w->block, w->scratch);
    w->kernel_count += result.kernel_count;
    w->ray_count += result.ray_count;
    w->clip_count += result.clip_count;
    if (result.seen)
        count(w, &task, &result);
    return result.seen;
}

bool hpr_pairs_integrate(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t p, size_t q, double tolerance)
{
    return hpr_pairs_counts(pairs, p, q) && hpr_pairs_look(pairs, w, p, q) != HPR_SEES_NOTHING &&
           hpr_pairs_integrate_past(pairs, w, p, q, tolerance);
}

static hpr_status make_workers(hpr_pairs *pairs)
{
    hpr_context *ctx = pairs->context;
    int threads = hpr_context_threads(ctx);
    size_t n = hpr_form_blocks_size(pairs->rows, pairs->degree);
    size_t occluders = hpr_visibility_occluder_count(pairs->visibility);
    hpr_status status =
        hpr_allocate_into(ctx, &pairs->worker, (size_t)threads, sizeof *pairs->worker, "quadrature scratch");
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        hpr_pairs_worker *w = &pairs->worker[t];
        status = hpr_block_scratch_create_for(ctx, pairs->degree, &w->scratch);
        if (status == HPR_OK)
            status = hpr_views_cursor_create(pairs->views, &w->cursor);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->blocker, occluders, sizeof *w->blocker, "quadrature scratch");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->block, n * n, sizeof *w->block, "quadrature scratch");
    }
    return status;
}

hpr_status hpr_pairs_open(const hpr_rows *rows, int degree, hpr_pairs *pairs)
{
    *pairs = (hpr_pairs){.context = rows->context, .rows = rows, .degree = degree};
    hpr_status status = hpr_visibility_create_untraced(rows->patches, &pairs->visibility);
    /* so few are always clipped */
    if (status == HPR_OK && hpr_visibility_occluder_count(pairs->visibility) > HPR_CLIP_BLOCKERS)
        status = hpr_visibility_prepare_rays(pairs->visibility);
    if (status == HPR_OK)
        status = hpr_quadrature_create(pairs->context, &pairs->quadrature);
    if (status == HPR_OK)
        status = hpr_views_create(pairs->visibility, NULL, &pairs->views);
    if (status == HPR_OK)
        status = make_workers(pairs);
    return status;
}

void hpr_pairs_close(hpr_pairs *pairs, hpr_pairs_done *done)
{
    hpr_context *ctx = pairs->context;
    *done = (hpr_pairs_done){0};
    for (int t = 0; pairs->worker && t < hpr_context_threads(ctx); t++) {
        hpr_pairs_worker *w = &pairs->worker[t];
        done->pair_count += w->done.pair_count;
        done->blocked_count += w->done.blocked_count;
        done->rounded_count += w->done.rounded_count;
        done->short_count += w->done.short_count;
        done->relative_error = fmax(done->relative_error, w->done.relative_error);
        done->sampled_error = fmax(done->sampled_error, w->done.sampled_error);
        hpr_count(ctx, HPR_COUNT_KERNEL, w->kernel_count);
        hpr_count(ctx, HPR_COUNT_RAYS, w->ray_count);
        hpr_count(ctx, HPR_COUNT_CLIPS, w->clip_count);
        hpr_block_scratch_destroy(&w->scratch);
        hpr_views_cursor_destroy(&w->cursor);
        hpr_release(ctx, w->blocker);
        hpr_release(ctx, w->block);
    }
    hpr_release(ctx, pairs->worker);
    hpr_views_destroy(&pairs->views);
    hpr_quadrature_destroy(&pairs->quadrature);
    hpr_visibility_destroy(&pairs->visibility);
    *pairs = (hpr_pairs){0};
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

/* K_ij and its transpose into `all`, where a block takes n x n. */
static void integrate_block(const hpr_pairs *pairs, hpr_pairs_worker *w, size_t i, size_t j, double tolerance,
                            double *all, size_t n)
{
    const hpr_rows *rows = pairs->rows;
    if (i == j || rows->first[i] == rows->first[i + 1] || rows->first[j] == rows->first[j + 1])
        return;
    uint32_t p = rows->member[rows->first[i]], q = rows->member[rows->first[j]];
    if (!hpr_pairs_integrate(pairs, w, p, q, tolerance))
        return;
    size_t count = rows->count;
    size_t n_recv = hpr_basis_count((hpr_shape)rows->patches->shape[p], pairs->degree);
    size_t n_send = hpr_basis_count((hpr_shape)rows->patches->shape[q], pairs->degree);
    for (size_t k = 0; k < n_recv; k++) {
        for (size_t l = 0; l < n_send; l++) {
            all[((i * count + j) * n + k) * n + l] = w->block[k * n_send + l];
            all[((j * count + i) * n + l) * n + k] = w->block[k * n_send + l];
        }
    }
}

/* Blocks are handed out in strips of one row: single ones where there are few, for a blocked pair may take
 * seconds, longer ones where the handing out would be felt. */
static void integrate_blocks(const hpr_pairs *pairs, double tolerance, double *all)
{
    hpr_context *ctx = pairs->context;
    size_t count = pairs->rows->count, strip = 1 + count / 128, strips = (count + strip - 1) / strip;
    size_t n = hpr_form_blocks_size(pairs->rows, pairs->degree);
    double entry_count = 0.5 * (double)count * ((double)count + 1);
    _Atomic uint64_t finished = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t task = 0; task < count * strips; task++) {
        hpr_pairs_worker *w = &pairs->worker[omp_get_thread_num()];
        size_t i = task / strips, begin = task % strips * strip, end = begin + strip;
        if (end <= i)
            continue;
        for (size_t j = begin < i ? i : begin; j < end && j < count && !hpr_cancelled(ctx); j++) {
            integrate_block(pairs, w, i, j, tolerance, all, n);
            finished++;
        }
        if (omp_get_thread_num() == 0)
            hpr_stage_progress(ctx, (double)finished / entry_count);
    }
}

hpr_status hpr_form_blocks(const hpr_rows *rows, int degree, double tolerance, double *block,
                           hpr_pairs_done *done)
{
    hpr_pairs pairs;
    hpr_status status = hpr_pairs_open(rows, degree, &pairs);
    if (status == HPR_OK) {
        integrate_blocks(&pairs, tolerance, block);
        if (hpr_cancelled(rows->context))
            status = hpr_fail(rows->context, HPR_ERR_INTERRUPTED, "interrupted");
    }
    hpr_pairs_close(&pairs, done);
    return status;
}
