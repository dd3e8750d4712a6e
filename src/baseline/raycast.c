#include "baseline/raycast.h"

#include "math/vec3.h"
#include "visibility/views.h"

#include <omp.h>
#include <stdatomic.h>

/* Working memory of one thread, and what it counted. */
typedef struct worker {
    hpr_views_cursor *cursor;
    uint32_t *blocker; /* [occluder_count] */
    uint64_t kernel_count, ray_count;
} worker;

typedef struct caster {
    const hpr_rows *rows;
    hpr_context *context;
    hpr_visibility *visibility;
    hpr_views *views;
    worker *workers;
    int n;
    double *factor;
} caster;

/* A piece of a patch: its middle in the patch's parameters, and its part of the area. */
typedef struct piece {
    double at[2], part;
} piece;

/* Piece k of n x n: of a parallelogram in rows, of a triangle rows of triangles that stand and hang by turns,
 * of a quadrilateral between lines that divide opposite sides into equal parts. */
static piece piece_of(const hpr_patches *patches, size_t patch, int k, int n)
{
    hpr_shape shape = (hpr_shape)patches->shape[patch];
    const double *opposite = patches->opposite + 2 * patch;
    piece p = {.at = {(k % n + 0.5) / n, (k / n + 0.5) / n}, .part = 1.0 / ((double)n * n)};
    if (shape == HPR_SHAPE_QUADRILATERAL) {
        const double low[2] = {(double)(k % n) / n, (double)(k / n) / n}, width[2] = {1.0 / n, 1.0 / n};
        double measure, middle[2];
        hpr_quad_piece q = hpr_quad_box(opposite, low, width, &measure);
        hpr_shape_middle(shape, q.opposite, middle);
        for (int i = 0; i < 2; i++)
            p.at[i] = q.origin[i] + middle[0] * q.edge1[i] + middle[1] * q.edge2[i];
        p.part = measure / hpr_shape_measure(shape, opposite);
    } else if (shape == HPR_SHAPE_TRIANGLE) {
        int row = 0; /* of 2 (n - row) - 1 triangles */
        while (k >= 2 * (n - row) - 1)
            k -= 2 * (n - row++) - 1;
        double inset = k % 2 ? 2.0 / 3 : 1.0 / 3; /* a triangle that hangs begins a third later */
        p.at[0] = (k / 2 + inset) / n;
        p.at[1] = (row + inset) / n;
    }
    return p;
}

static hpr_vec3 point_of(const hpr_patches *patches, size_t p, double s, double t)
{
    return hpr_madd(
        hpr_madd(hpr_vec3_load(patches->origin + 3 * p), s, hpr_vec3_load(patches->edge1 + 3 * p)), t,
        hpr_vec3_load(patches->edge2 + 3 * p));
}

static double factor_of(const caster *c, worker *w, size_t i, size_t j)
{
    static const double pi = 3.14159265358979323846;
    const hpr_patches *patches = c->rows->patches;
    size_t blocker_count = 0;
    if (c->rows->patch_surface[i] == c->rows->patch_surface[j] ||
        hpr_views_classify(c->views, w->cursor, i, j, w->blocker, &blocker_count) == HPR_SEES_NOTHING)
        return 0;
    double own[2], sum = 0;
    hpr_shape_middle((hpr_shape)patches->shape[i], patches->opposite + 2 * i, own);
    hpr_vec3 x = point_of(patches, i, own[0], own[1]);
    hpr_vec3 from = hpr_vec3_load(patches->normal + 3 * i), to = hpr_vec3_load(patches->normal + 3 * j);
    for (int k = 0; k < c->n * c->n; k++) {
        piece p = piece_of(patches, j, k, c->n);
        double piece_m2 = p.part * patches->area_m2[j];
        hpr_vec3 y = point_of(patches, j, p.at[0], p.at[1]), d = hpr_sub(y, x);
        double here = hpr_dot(d, from), there = -hpr_dot(d, to), r2 = hpr_dot(d, d);
        w->kernel_count++;
        if (here <= 0 || there <= 0)
            continue;
        if (blocker_count) {
            const double begin[3] = {x.x, x.y, x.z}, end[3] = {y.x, y.y, y.z};
            w->ray_count++;
            if (hpr_visibility_blocked(c->visibility, begin, end, w->blocker, blocker_count))
                continue;
        }
        sum += piece_m2 * (here * there / r2) / (pi * r2 + piece_m2);
    }
    return sum;
}

static void cast_all(caster *c)
{
    size_t count = c->rows->count;
    atomic_size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(c->context))
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < count && !hpr_cancelled(c->context); j++)
            c->factor[i * count + j] = factor_of(c, &c->workers[omp_get_thread_num()], i, j);
        size_t finished = atomic_fetch_add(&done, 1) + 1;
        if (omp_get_thread_num() == 0)
            hpr_stage_progress(c->context, (double)finished / (double)count);
    }
}

static hpr_status make_workers(caster *c)
{
    size_t threads = (size_t)hpr_context_threads(c->context);
    size_t occluders = hpr_visibility_occluder_count(c->visibility);
    hpr_status status =
        hpr_allocate_into(c->context, &c->workers, threads, sizeof *c->workers, "ray casting");
    for (size_t k = 0; status == HPR_OK && k < threads; k++) {
        worker *w = &c->workers[k];
        status = hpr_views_cursor_create(c->views, &w->cursor);
        if (status == HPR_OK)
            status = hpr_allocate_into(c->context, &w->blocker, occluders, sizeof *w->blocker, "ray casting");
    }
    return status;
}

static void close_workers(caster *c, bool *blocked)
{
    *blocked = false;
    for (int k = 0; c->workers && k < hpr_context_threads(c->context); k++) {
        worker *w = &c->workers[k];
        hpr_count(c->context, HPR_COUNT_KERNEL, w->kernel_count);
        hpr_count(c->context, HPR_COUNT_RAYS, w->ray_count);
        *blocked |= w->ray_count > 0;
        hpr_views_cursor_destroy(&w->cursor);
        hpr_release(c->context, w->blocker);
    }
    hpr_release(c->context, c->workers);
}

hpr_status hpr_raycast_factors(const hpr_rows *rows, int n, double *factor, bool *blocked)
{
    hpr_context *ctx = rows->context;
    caster c = {.rows = rows, .context = ctx, .n = n, .factor = factor};
    hpr_status status = hpr_visibility_create(rows->patches, &c.visibility);
    if (status == HPR_OK)
        status = hpr_views_create(c.visibility, NULL, &c.views);
    if (status == HPR_OK)
        status = make_workers(&c);
    if (status == HPR_OK) {
        cast_all(&c);
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while casting rays");
    }
    close_workers(&c, blocked);
    hpr_views_destroy(&c.views);
    hpr_visibility_destroy(&c.visibility);
    return status;
}
