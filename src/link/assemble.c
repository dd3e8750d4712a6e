/* From patches and elements to links: who sees whom, how much memory that takes, and all the blocks. */
#include "link/links.h"
#include "quadrature/block.h"
#include "visibility/views.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

/* Working memory of one thread, and what it counted. */
typedef struct worker {
    hpr_views_cursor *cursor;
    hpr_block_scratch *scratch;
    uint32_t *candidate, *blocker; /* [occluder_count] of a pair of patches, of a pair of elements */
    size_t candidate_count;
    double *block; /* [HPR_MAX_BASIS]^2 */
    uint64_t counts[HPR_COUNTER_COUNT];
    double block_error, sampled_error;
} worker;

typedef struct assembly {
    const hpr_coverage *coverage;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_context *context;
    hpr_visibility *visibility;
    hpr_views *views;
    hpr_quadrature *quadrature;
    hpr_links *links;
    worker *workers;    /* [threads] */
    uint8_t *verdict;   /* [patches][patches] hpr_verdict, upper triangle */
    double area_m2;     /* of all patches */
    size_t *task_first; /* [link_count + 1] first task of each link; a task is one receiver leaf */
} assembly;

/* The element, or its only open part. */
static void frame_facet(const hpr_element_frame *frame, const hpr_polygon *part, int part_count,
                        hpr_facet *facet)
{
    hpr_vec3_store(facet->normal, frame->normal);
    if (part_count == 1 && part->count <= 4) {
        facet->corner_count = (size_t)part->count;
        for (int i = 0; i < part->count; i++)
            hpr_vec3_store(facet->corner[i], hpr_frame_point(frame, part->corner[i][0], part->corner[i][1]));
        return;
    }
    hpr_cell whole = hpr_cell_whole(frame->shape);
    hpr_vec3 corner[4];
    facet->corner_count = (size_t)hpr_cell_corners(frame, &whole, corner);
    for (size_t i = 0; i < facet->corner_count; i++)
        hpr_vec3_store(facet->corner[i], corner[i]);
}

/* Verdicts of all pairs of patches; counts those that see something. */
static hpr_status find_verdicts(assembly *a, size_t *link_count)
{
    size_t n = a->patches->count;
    atomic_size_t seen = 0;
    hpr_status status = hpr_allocate_into(a->context, &a->verdict, n * n, 1, "visibility between patches");
    if (status != HPR_OK)
        return status;
#pragma omp parallel for schedule(dynamic, 4) num_threads(hpr_context_threads(a->context))
    for (size_t i = 0; i < n; i++) {
        hpr_views_cursor *cursor = a->workers[omp_get_thread_num()].cursor;
        size_t found = 0;
        for (size_t j = i + 1; j < n && !hpr_cancelled(a->context); j++) {
            hpr_verdict verdict = hpr_views_classify(a->views, cursor, i, j, NULL, NULL);
            a->verdict[i * n + j] = (uint8_t)verdict;
            found += verdict != HPR_SEES_NOTHING;
        }
        atomic_fetch_add(&seen, found);
    }
    *link_count = seen;
    return hpr_cancelled(a->context) ? hpr_fail(a->context, HPR_ERR_INTERRUPTED, "interrupted") : HPR_OK;
}

static size_t patch_dofs(const assembly *a, size_t patch)
{
    const hpr_elements *e = a->elements;
    return e->dof[e->patch_leaf[patch + 1]] - e->dof[e->patch_leaf[patch]];
}

static size_t leaf_dofs(const assembly *a, size_t leaf)
{
    return a->elements->dof[leaf + 1] - a->elements->dof[leaf];
}

static size_t patch_leaves(const assembly *a, size_t patch)
{
    return a->elements->patch_leaf[patch + 1] - a->elements->patch_leaf[patch];
}

static void place_links(assembly *a)
{
    hpr_links *links = a->links;
    size_t n = a->patches->count;
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t j = i + 1; j < n; j++) {
            if (a->verdict[i * n + j] == HPR_SEES_NOTHING)
                continue;
            links->occluded |= a->verdict[i * n + j] == HPR_SEES_PARTLY;
            links->link[links->count] = (hpr_link){i, j, links->block_count};
            links->block_count += patch_dofs(a, i) * patch_dofs(a, j);
            a->task_first[links->count + 1] = a->task_first[links->count] + patch_leaves(a, i);
            links->count++;
            links->row[i + 1]++;
            links->row[j + 1]++;
        }
    }
    for (size_t i = 0; i < n; i++)
        links->row[i + 1] += links->row[i];
}

/* row_link, each row rising by the other patch: first the links in which the patch is the sender. */
static hpr_status index_rows(assembly *a)
{
    hpr_links *links = a->links;
    size_t n = a->patches->count, *next = NULL;
    hpr_status status =
        hpr_allocate_into(a->context, &links->row_link, 2 * links->count, sizeof *links->row_link, "links");
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &next, n, sizeof *next, "links");
    if (status == HPR_OK) {
        memcpy(next, links->row, n * sizeof *next);
        for (size_t l = 0; l < links->count; l++)
            links->row_link[next[links->link[l].send]++] = (uint32_t)l;
        for (size_t l = 0; l < links->count; l++)
            links->row_link[next[links->link[l].recv]++] = (uint32_t)l;
    }
    hpr_release(a->context, next);
    return status;
}

static hpr_status check_memory(assembly *a)
{
    double machine = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGE_SIZE);
    double needed = (double)a->links->block_count * sizeof(double);
    if (needed > 0.9 * machine)
        return hpr_fail(
            a->context, HPR_ERR_MEMORY,
            "%zu coefficients need %.3g GB for kernel blocks, this machine has %.3g GB: lower --subdivide "
            "or --order",
            a->elements->dof[a->elements->leaf_count], 1e-9 * needed, 1e-9 * machine);
    return HPR_OK;
}

static hpr_status make_links(assembly *a)
{
    size_t n = a->patches->count, link_count;
    hpr_links *links = a->links;
    hpr_status status = find_verdicts(a, &link_count);
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &links->link, link_count, sizeof *links->link, "links");
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &links->row, n + 1, sizeof *links->row, "links");
    if (status == HPR_OK)
        status =
            hpr_allocate_into(a->context, &a->task_first, link_count + 1, sizeof *a->task_first, "links");
    if (status != HPR_OK)
        return status;
    place_links(a);
    status = check_memory(a);
    if (status == HPR_OK)
        status = index_rows(a);
    if (status == HPR_OK)
        status =
            hpr_allocate_into(a->context, &links->block, links->block_count, sizeof(double), "kernel blocks");
    return status;
}

/*
 * What the partly visible pairs cost, about 0.1 to 10 ms each, decides how exactly they are clipped. A
 * block's error of t sqrt(A_r A_s) / A is one of t A_s / A in the form factor: of one sign in all senders, a
 * relative error of t in the irradiance; in truth they have either sign.
 */
static void choose_tolerances(assembly *a, double tolerance)
{
    static const struct {
        size_t pairs;
        double tolerance;
    } level[] = {{200, 1e-6}, {8000, 1e-3}, {60000, 3e-2}, {SIZE_MAX, 0}};
    hpr_links *links = a->links;
    size_t pairs = 0, n = a->patches->count, k = 0;
    for (size_t l = 0; l < links->count; l++) {
        const hpr_link *link = &links->link[l];
        if (a->verdict[link->recv * n + link->send] == HPR_SEES_PARTLY)
            pairs += patch_leaves(a, link->recv) * patch_leaves(a, link->send);
    }
    while (pairs > level[k].pairs)
        k++;
    /* Where many things stand about, a pair has tens of blockers, and rays are cheaper. */
    enum { FEW_OCCLUDERS = 64, FEW_PAIRS = 500 };
    bool crowded = hpr_visibility_occluder_count(a->visibility) > FEW_OCCLUDERS && pairs > FEW_PAIRS;
    links->tolerance = tolerance > 0 ? tolerance : links->occluded ? 1e-5 : 1e-12;
    links->blocked_tolerance = !links->occluded ? 0
                               : tolerance > 0  ? tolerance
                               : crowded        ? 0
                                                : level[k].tolerance;
    for (size_t i = 0; i < n; i++)
        a->area_m2 += a->patches->area_m2[i];
}

/* Pairs with covered parts are clipped even where the others are sampled: what a small open part receives is
 * divided by its area. */
static void clip_if_due(const assembly *a, size_t leaf_i, size_t leaf_j, hpr_block_task *task)
{
    static const double with_parts = 0.03;
    double tolerance = a->links->blocked_tolerance;
    bool parts = task->recv_part_count || task->send_part_count;
    if (tolerance == 0 && parts)
        tolerance = with_parts;
    if ((!task->blocker_count && !parts) || tolerance == 0)
        return;
    double recv_m2 = task->recv.area_m2 * hpr_coverage_open_share(a->coverage, leaf_i);
    double send_m2 = task->send.area_m2 * hpr_coverage_open_share(a->coverage, leaf_j);
    task->clip = true;
    task->tolerance = tolerance;
    task->negligible = tolerance * sqrt(recv_m2 * send_m2) / a->area_m2;
}

static void integrate_pair(const assembly *a, worker *w, size_t l, size_t leaf_i, size_t leaf_j)
{
    const hpr_link *link = &a->links->link[l];
    hpr_block_task task = {.recv = hpr_leaf_frame(a->patches, a->elements, leaf_i),
                           .send = hpr_leaf_frame(a->patches, a->elements, leaf_j),
                           .tolerance = a->links->tolerance,
                           .negligible = a->links->tolerance,
                           .contact_m = a->patches->weld_m,
                           .visibility = a->visibility};
    task.recv_part = hpr_coverage_parts(a->coverage, leaf_i, &task.recv_part_count);
    task.send_part = hpr_coverage_parts(a->coverage, leaf_j, &task.send_part_count);
    if ((task.recv_part && !task.recv_part_count) || (task.send_part && !task.send_part_count)) {
        w->counts[HPR_COUNT_PAIRS_HIDDEN]++;
        return;
    }
    if (a->verdict[link->recv * a->patches->count + link->send] == HPR_SEES_PARTLY) {
        hpr_facet recv, send;
        frame_facet(&task.recv, task.recv_part, task.recv_part_count, &recv);
        frame_facet(&task.send, task.send_part, task.send_part_count, &send);
        if (hpr_visibility_classify(a->visibility, &recv, &send, w->candidate, w->candidate_count, w->blocker,
                                    &task.blocker_count) == HPR_SEES_NOTHING) {
            w->counts[HPR_COUNT_PAIRS_HIDDEN]++; /* its block stays zero */
            return;
        }
        task.blockers = w->blocker;
    }
    clip_if_due(a, leaf_i, leaf_j, &task);
    hpr_block_result result = hpr_block_ref(a->quadrature, &task, w->block, w->scratch);
    size_t stride, rows = leaf_dofs(a, leaf_i), columns = leaf_dofs(a, leaf_j);
    double *block = a->links->block + hpr_link_block(a->links, link, leaf_i, leaf_j, &stride);
    for (size_t k = 0; k < rows; k++)
        memcpy(block + k * stride, w->block + k * columns, columns * sizeof *block);
    hpr_counter kind = !result.seen         ? HPR_COUNT_PAIRS_HIDDEN
                       : task.blocker_count ? HPR_COUNT_PAIRS_PARTIAL
                                            : HPR_COUNT_PAIRS_VISIBLE;
    w->counts[kind]++;
    w->counts[HPR_COUNT_BLOCKS] += result.seen;
    w->counts[HPR_COUNT_KERNEL] += result.kernel_count;
    w->counts[HPR_COUNT_RAYS] += result.ray_count;
    w->counts[HPR_COUNT_CLIPS] += result.clip_count;
    w->counts[HPR_COUNT_SHORT] += result.status == HPR_BLOCK_SHORT;
    w->counts[HPR_COUNT_ROUNDED] += result.status == HPR_BLOCK_ROUNDED;
    w->counts[HPR_COUNT_SAMPLED] += result.status == HPR_BLOCK_SAMPLED;
    double *error = result.status == HPR_BLOCK_SAMPLED ? &w->sampled_error : &w->block_error;
    *error = fmax(*error, result.error);
}

static size_t link_of_task(const assembly *a, size_t task)
{
    size_t low = 0, high = a->links->count;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (a->task_first[middle] <= task)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void integrate_all(assembly *a)
{
    size_t task_count = a->task_first[a->links->count];
    atomic_size_t done = 0;
#pragma omp parallel num_threads(hpr_context_threads(a->context))
    {
        worker *w = &a->workers[omp_get_thread_num()];
#pragma omp for schedule(dynamic, 1)
        for (size_t task = 0; task < task_count; task++) {
            size_t l = link_of_task(a, task);
            const hpr_link *link = &a->links->link[l];
            size_t leaf_i = a->elements->patch_leaf[link->recv] + (task - a->task_first[l]);
            if (a->verdict[link->recv * a->patches->count + link->send] == HPR_SEES_PARTLY)
                hpr_views_classify(a->views, w->cursor, link->recv, link->send, w->candidate,
                                   &w->candidate_count);
            for (size_t leaf_j = a->elements->patch_leaf[link->send];
                 leaf_j < a->elements->patch_leaf[link->send + 1] && !hpr_cancelled(a->context); leaf_j++)
                integrate_pair(a, w, l, leaf_i, leaf_j);
            size_t finished = atomic_fetch_add(&done, 1) + 1;
            if (omp_get_thread_num() == 0)
                hpr_stage_progress(a->context, (double)finished / (double)task_count);
        }
    }
}

static hpr_status make_workers(assembly *a)
{
    hpr_context *ctx = a->context;
    int threads = hpr_context_threads(ctx);
    size_t occluders = hpr_visibility_occluder_count(a->visibility),
           square = (size_t)HPR_MAX_BASIS * HPR_MAX_BASIS;
    hpr_status status =
        hpr_allocate_into(ctx, &a->workers, (size_t)threads, sizeof *a->workers, "quadrature scratch");
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        worker *w = &a->workers[t];
        status = hpr_views_cursor_create(a->views, &w->cursor);
        if (status == HPR_OK)
            status = hpr_block_scratch_create(ctx, &w->scratch);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->candidate, occluders, sizeof(uint32_t), "blockers");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->blocker, occluders, sizeof(uint32_t), "blockers");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->block, square, sizeof(double), "quadrature scratch");
    }
    return status;
}

static void close_workers(assembly *a)
{
    for (int t = 0; a->workers && t < hpr_context_threads(a->context); t++) {
        worker *w = &a->workers[t];
        for (int c = 0; c < HPR_COUNTER_COUNT; c++)
            hpr_count(a->context, (hpr_counter)c, w->counts[c]);
        a->links->short_count += w->counts[HPR_COUNT_SHORT];
        a->links->block_error = fmax(a->links->block_error, w->block_error);
        a->links->sampled_error = fmax(a->links->sampled_error, w->sampled_error);
        hpr_views_cursor_destroy(&w->cursor);
        hpr_block_scratch_destroy(&w->scratch);
        hpr_release(a->context, w->candidate);
        hpr_release(a->context, w->blocker);
        hpr_release(a->context, w->block);
    }
    hpr_release(a->context, a->workers);
}

hpr_status hpr_links_assemble(const hpr_coverage *coverage, const hpr_elements *elements, double tolerance,
                              hpr_links **out)
{
    const hpr_patches *patches = hpr_coverage_patches(coverage);
    hpr_context *ctx = patches->context;
    assembly a = {.coverage = coverage, .patches = patches, .elements = elements, .context = ctx};
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &a.links, 1, sizeof *a.links, "links");
    if (status != HPR_OK)
        return status;
    a.links->context = ctx;
    a.links->elements = elements;
    status = hpr_visibility_create(patches, &a.visibility);
    if (status == HPR_OK)
        status = hpr_views_create(a.visibility, NULL, &a.views);
    if (status == HPR_OK)
        status = hpr_quadrature_create(ctx, &a.quadrature);
    if (status == HPR_OK)
        status = make_workers(&a);
    if (status == HPR_OK)
        status = make_links(&a);
    if (status == HPR_OK) {
        choose_tolerances(&a, tolerance);
        integrate_all(&a);
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted during assembly");
    }
    close_workers(&a);
    hpr_views_destroy(&a.views);
    hpr_visibility_destroy(&a.visibility);
    hpr_quadrature_destroy(&a.quadrature);
    void *arrays[] = {a.verdict, a.task_first};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    if (status != HPR_OK)
        hpr_links_destroy(&a.links);
    *out = a.links;
    return status;
}
