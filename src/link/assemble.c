/* The links' blocks: how much memory they take, how exact they have to be, and their integrals. */
#include "link/afford.h"
#include "link/between.h"
#include "link/blocked.h"
#include "link/kept.h"
#include "link/links.h"
#include "link/refine.h"
#include "quadrature/constants.h"
#include "quadrature/far.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>

/* Working memory of one thread, and what it counted. */
typedef struct worker {
    hpr_between between;
    hpr_block_scratch *scratch;
    double *far_scratch;
    /* of links by leaves: one of their blocks, the frames of both sides, what becomes of their pairs */
    double *piece;
    hpr_element_frame *frame;
    uint8_t *kind;
    uint64_t counts[HPR_COUNTER_COUNT];
} worker;

typedef struct assembly {
    const hpr_coverage *coverage;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_context *context;
    hpr_visibility *visibility;
    hpr_views *views;
    hpr_quadrature *quadrature;
    hpr_far *far;
    hpr_links *links;
    hpr_kept kept;
    worker *workers;  /* [threads] */
    uint8_t *verdict; /* [patches][patches] hpr_verdict, upper triangle */
    hpr_blocked blocked;
    const double *brightness; /* as in hpr_links_demand */
    double *left_out2; /* [link_count] square of what a link leaves out of H, of ‖B‖, as in refine.c */
} assembly;

/* Offsets of the blocks, and how many links each node has. */
static void place_blocks(assembly *a)
{
    hpr_links *links = a->links;
    for (size_t l = 0; l < links->count; l++) {
        hpr_link *link = &links->link[l];
        link->offset = links->block_count;
        links->block_count += hpr_link_size(links, link);
        links->row[link->recv + 1]++;
        links->row[link->send + 1]++;
    }
    for (size_t i = 0; i < a->elements->node_count; i++)
        links->row[i + 1] += links->row[i];
}

static hpr_status check_memory(assembly *a, double asked)
{
    double most = hpr_links_most_bytes(asked);
    double needed = (double)a->links->block_count * sizeof(double);
    if (needed > most)
        return hpr_fail(
            a->context, HPR_ERR_MEMORY,
            "%zu coefficients need %.3g GB for kernel blocks, more than %.3g GB (--max-memory): lower "
            "--subdivide or --order",
            a->elements->dof[a->elements->leaf_count], 1e-9 * needed, 1e-9 * most);
    return HPR_OK;
}

/* row_link: the links of each node, rising. */
static hpr_status index_rows(assembly *a)
{
    hpr_links *links = a->links;
    size_t *next = NULL;
    hpr_status status =
        hpr_allocate_into(a->context, &links->row_link, 2 * links->count, sizeof *links->row_link, "links");
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &next, a->elements->node_count, sizeof *next, "links");
    if (status == HPR_OK) {
        memcpy(next, links->row, a->elements->node_count * sizeof *next);
        for (size_t l = 0; l < links->count; l++) {
            links->row_link[next[links->link[l].recv]++] = (uint32_t)l;
            links->row_link[next[links->link[l].send]++] = (uint32_t)l;
        }
    }
    hpr_release(a->context, next);
    return status;
}

/* Verdicts of all pairs of patches of which one sends. */
static hpr_status find_verdicts(assembly *a, const bool *sends)
{
    size_t n = a->patches->count;
    atomic_bool occluded = false;
    hpr_status status = hpr_allocate_into(a->context, &a->verdict, n * n, 1, "visibility between patches");
    if (status != HPR_OK)
        return status;
#pragma omp parallel for schedule(dynamic, 4) num_threads(hpr_context_threads(a->context))
    for (size_t i = 0; i < n; i++) {
        hpr_views_cursor *cursor = a->workers[omp_get_thread_num()].between.cursor;
        for (size_t j = i + 1; j < n && !hpr_cancelled(a->context); j++) {
            hpr_verdict verdict = sends[i] || sends[j]
                                      ? hpr_views_classify(a->views, cursor, i, j, NULL, NULL)
                                      : HPR_SEES_NOTHING;
            a->verdict[i * n + j] = (uint8_t)verdict;
            if (verdict == HPR_SEES_PARTLY)
                occluded = true;
        }
    }
    a->links->occluded = occluded;
    return hpr_cancelled(a->context) ? hpr_fail(a->context, HPR_ERR_INTERRUPTED, "interrupted") : HPR_OK;
}

/* While all pairs of leaves can be had, links leave out next to nothing; beyond that less than elements of
 * low degree do. */
static double choose_link_tolerance(const assembly *a)
{
    enum { FEW_LEAVES = 4096 };
    bool few = a->elements->leaf_count <= FEW_LEAVES;
    return a->links->occluded ? (few ? 1e-5 : 1e-3) : (few ? 1e-13 : 1e-6);
}

/* The degree of inner nodes: higher ones make fewer links, but larger blocks. */
static int inner_degree(double link_tolerance)
{
    int degree = (int)ceil(-0.75 * log10(link_tolerance));
    return degree < 1 ? 1 : degree > 8 ? 8 : degree;
}

/* What the workers need for links of the tree's nodes. */
static hpr_status give_scratch(assembly *a)
{
    hpr_context *ctx = a->context;
    size_t most = a->links->tree->most_at_once, far = hpr_far_scratch(),
           constants = hpr_constants_scratch(most, most);
    hpr_status status = HPR_OK;
    for (int t = 0; status == HPR_OK && t < hpr_context_threads(ctx); t++) {
        worker *w = &a->workers[t];
        status = hpr_allocate_into(ctx, &w->far_scratch, far > constants ? far : constants, sizeof(double),
                                   "quadrature scratch");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->piece, most * most, sizeof(double), "quadrature scratch");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->frame, 2 * most, sizeof *w->frame, "quadrature scratch");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->kind, most * most, sizeof *w->kind, "quadrature scratch");
    }
    return status;
}

static hpr_status make_links(assembly *a, const hpr_links_demand *demand)
{
    hpr_links *links = a->links;
    hpr_status status = find_verdicts(a, demand->sends);
    links->link_tolerance = demand->link_tolerance > 0 ? demand->link_tolerance : choose_link_tolerance(a);
    int degree = demand->constant ? 0 : inner_degree(links->link_tolerance);
    if (status == HPR_OK)
        status = hpr_tree_create(a->coverage, a->elements, degree, &links->tree);
    if (status == HPR_OK)
        status = hpr_far_create(a->context, links->tree->highest_degree, &a->far);
    if (status == HPR_OK)
        status = give_scratch(a);
    if (status == HPR_OK) {
        const hpr_link_refinement refinement = {a->coverage, a->visibility, a->views,
                                                a->verdict,  a->brightness, links};
        status = hpr_links_refine(&refinement);
    }
    if (status == HPR_OK && links->count >= HPR_NONE)
        status = hpr_fail(a->context, HPR_ERR_MEMORY, "%zu links are more than 32-bit indices can name",
                          links->count);
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &links->row, a->elements->node_count + 1, sizeof *links->row,
                                   "links");
    if (status != HPR_OK)
        return status;
    links->row_count = a->elements->node_count;
    place_blocks(a);
    if (demand->counted)
        return index_rows(a);
    status = check_memory(a, demand->most_bytes);
    if (status == HPR_OK)
        status = index_rows(a);
    if (status == HPR_OK)
        status =
            hpr_allocate_into(a->context, &links->block, links->block_count, sizeof(double), "kernel blocks");
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &a->left_out2, links->count, sizeof(double), "links");
    if (status == HPR_OK)
        status = hpr_allocate_into(a->context, &links->note, links->count, sizeof *links->note, "links");
    return status;
}

/* Of pairs of patches that see partly, some of which are looked at: the same at any step of a series. */
static double sum_spread(const assembly *a)
{
    enum { LOOKED_AT = 10000 };
    size_t n = a->patches->count, partly = 0, seen = 0, looked_at = 0;
    double sum = 0;
    for (size_t i = 0; i < n * n; i++)
        partly += a->verdict[i] == HPR_SEES_PARTLY && i / n < i % n;
    size_t stride = 1 + partly / LOOKED_AT;
    for (size_t i = 0; i < n * n; i++) {
        if (a->verdict[i] != HPR_SEES_PARTLY || i / n >= i % n || seen++ % stride)
            continue;
        const hpr_element_frame recv = hpr_tree_frame(a->links->tree, i / n, 0),
                                send = hpr_tree_frame(a->links->tree, i % n, 0);
        sum += hpr_blocked_spread(&recv, &send, a->links->area_m2);
        looked_at++;
    }
    return looked_at ? sum * (double)partly / (double)looked_at : 0;
}

/* What clipping would take: links that see partly, and the blockers of some of their pairs of patches. */
static hpr_blocked_load estimate_load(assembly *a, double tolerance)
{
    enum { LOOKED_AT = 1000 };
    worker *w = &a->workers[0];
    const hpr_links *links = a->links;
    const uint32_t *patch = a->elements->patch;
    size_t stride = 1 + links->partly_count / LOOKED_AT, seen = 0, looked_at = 0;
    double blockers = 0;
    for (size_t l = 0; l < links->count; l++) {
        const hpr_link *link = &links->link[l];
        if (!link->partly || seen++ % stride)
            continue;
        hpr_between_patches(&w->between, patch[link->recv], patch[link->send]);
        blockers += (double)w->between.candidate_count;
        looked_at++;
    }
    return (hpr_blocked_load){.pair_count = links->partly_count,
                              .spread = sum_spread(a),
                              .blocker_count = looked_at ? blockers / (double)looked_at : 0,
                              .area_m2 = links->area_m2,
                              .asked = tolerance};
}

static void choose_tolerances(assembly *a, double tolerance, double blocked_tolerance)
{
    static const double part_of_links = 0.1; /* of what links leave out anyway */
    hpr_links *links = a->links;
    hpr_blocked_load load = estimate_load(a, tolerance);
    double least = tolerance > 0 ? tolerance : part_of_links * links->link_tolerance;
    a->blocked = hpr_blocked_plan(&load);
    if (a->blocked.tolerance > 0)
        a->blocked.tolerance = fmax(fmax(a->blocked.tolerance, least), blocked_tolerance);
    links->tolerance =
        tolerance > 0 ? tolerance : fmax(links->occluded ? a->blocked.open_tolerance : 1e-13, least);
    links->blocked_tolerance = links->occluded ? a->blocked.tolerance : 0;
}

/* What is integrated at once: the two nodes of a link, or two of the leaves that these are linked by. */
typedef struct piece {
    size_t link;
    uint32_t recv, send;
    int recv_degree, send_degree;
    double *block; /* compact */
} piece;

/* Is product Gauss with a fixed number of nodes exact enough? Either the block is, or the share of the
 * operator's error that a link may have. */
static bool is_far(const assembly *a, const hpr_block_task *task)
{
    static const double part = 0.03; /* of the share: quadrature errs with one sign */
    const hpr_links *links = a->links;
    const hpr_element_frame *r = &task->recv, *s = &task->send;
    if (task->recv_part_count || task->send_part_count)
        return false;
    hpr_far_view view = hpr_far_foretell(r, s);
    if (view.recv_straddles || view.send_straddles || view.hidden || !isfinite(view.norm))
        return false;
    double error = hypot(hpr_far_left_out(view.norm, view.recv_rho, r->degree + HPR_FAR_EXCESS),
                         hpr_far_left_out(view.norm, view.send_rho, s->degree + HPR_FAR_EXCESS));
    double share = links->link_tolerance * (sqrt(r->area_m2 * s->area_m2) / links->area_m2 + view.norm) / 2;
    return error <= fmax(part * share, links->tolerance * view.norm);
}

/* Does a link leave out what the elements could show? */
static bool leaves_out(const hpr_tree *tree, uint32_t node, int degree)
{
    return tree->elements->child[node] != HPR_NONE || degree < tree->degree[node];
}

static void integrate_far(const assembly *a, worker *w, const hpr_block_task *task, const piece *p)
{
    const hpr_tree *tree = a->links->tree;
    hpr_far_result result = hpr_far_block(a->far, &task->recv, &task->send, p->block, w->far_scratch);
    double recv = leaves_out(tree, p->recv, p->recv_degree) ? result.recv_error : 0;
    double send = leaves_out(tree, p->send, p->send_degree) ? result.send_error : 0;
    a->left_out2[p->link] +=
        hpr_link_part2(a->links, a->brightness, p->recv, p->send) * (recv * recv + send * send);
    w->counts[HPR_COUNT_PAIRS_VISIBLE]++;
    w->counts[HPR_COUNT_BLOCKS]++;
    w->counts[HPR_COUNT_KERNEL] += result.kernel_count;
}

static void add_note(hpr_link_note *note, const hpr_link_note *more)
{
    note->error = fmax(note->error, more->error);
    note->sampled_error = fmax(note->sampled_error, more->sampled_error);
    note->sampled2 += more->sampled2;
    note->short_count += more->short_count;
}

static hpr_link_note integrate_block(const assembly *a, worker *w, hpr_block_task *task, const piece *p)
{
    double recv_m2 = task->recv.area_m2 * hpr_coverage_node_share(a->coverage, p->recv),
           send_m2 = task->send.area_m2 * hpr_coverage_node_share(a->coverage, p->send);
    hpr_blocked_decide(&a->blocked, recv_m2, send_m2, task);
    hpr_block_result result = hpr_block(a->quadrature, task, p->block, w->scratch);
    hpr_counter kind = !result.seen          ? HPR_COUNT_PAIRS_HIDDEN
                       : task->blocker_count ? HPR_COUNT_PAIRS_PARTIAL
                                             : HPR_COUNT_PAIRS_VISIBLE;
    bool sampled = result.status == HPR_BLOCK_SAMPLED;
    w->counts[kind]++;
    w->counts[HPR_COUNT_BLOCKS] += result.seen;
    w->counts[HPR_COUNT_KERNEL] += result.kernel_count;
    w->counts[HPR_COUNT_RAYS] += result.ray_count;
    w->counts[HPR_COUNT_CLIPS] += result.clip_count;
    w->counts[HPR_COUNT_SHORT] += result.status == HPR_BLOCK_SHORT;
    w->counts[HPR_COUNT_ROUNDED] += result.status == HPR_BLOCK_ROUNDED;
    w->counts[HPR_COUNT_SAMPLED] += sampled;
    return (hpr_link_note){.error = sampled ? 0 : result.error,
                           .sampled_error = sampled ? result.error : 0,
                           .sampled2 = hpr_blocked_error2(&a->blocked, task, &result),
                           .short_count = result.status == HPR_BLOCK_SHORT};
}

/* whole: over what is covered, too; the block is not one of the open parts, and those are what is kept. */
static void integrate_near(const assembly *a, worker *w, hpr_block_task *task, const piece *p, bool whole)
{
    const hpr_link pair = {.recv = p->recv,
                           .send = p->send,
                           .recv_degree = (uint8_t)p->recv_degree,
                           .send_degree = (uint8_t)p->send_degree};
    size_t count = hpr_link_size(a->links, &pair);
    hpr_link_note note;
    if (whole) {
        note = integrate_block(a, w, task, p);
    } else if (!hpr_kept_take(&a->kept, &pair, count, p->block, &note)) {
        note = integrate_block(a, w, task, p);
        if (!hpr_cancelled(a->context))
            hpr_kept_give(&a->kept, &pair, count, p->block, &note);
    }
    add_note(&a->links->note[p->link], &note);
}

static void integrate_piece(const assembly *a, worker *w, const piece *p)
{
    hpr_block_task task = {.recv = hpr_tree_frame(a->links->tree, p->recv, p->recv_degree),
                           .send = hpr_tree_frame(a->links->tree, p->send, p->send_degree),
                           .tolerance = a->links->tolerance,
                           .negligible = a->links->tolerance,
                           .contact_m = a->patches->weld_m,
                           .visibility = a->visibility,
                           .seed = (uint64_t)p->recv << 32 | p->send};
    const hpr_tree *tree = a->links->tree;
    bool partly = a->links->link[p->link].partly, recv_whole = !partly && hpr_tree_is_mixed(tree, p->recv),
         send_whole = !partly && hpr_tree_is_mixed(tree, p->send);
    if (!recv_whole)
        task.recv_part = hpr_coverage_node_parts(a->coverage, p->recv, &task.recv_part_count);
    if (!send_whole)
        task.send_part = hpr_coverage_node_parts(a->coverage, p->send, &task.send_part_count);
    if (partly && !hpr_between_nodes(&w->between, a->coverage, a->links->tree, p->recv, p->send, &task)) {
        w->counts[HPR_COUNT_PAIRS_HIDDEN]++; /* its block stays zero */
        return;
    }
    if (task.blocker_count == 0 && is_far(a, &task))
        integrate_far(a, w, &task, p);
    else
        integrate_near(a, w, &task, p, recv_whole || send_whole);
}

/* The nodes that one end of a link stands for, and their frames. */
typedef struct link_end {
    size_t count;
    uint32_t node; /* if it is one */
    int degree;
    const uint32_t *leaf; /* [count] nodes, if they are leaves */
} link_end;

static link_end end_of(const hpr_tree *tree, uint32_t node, int degree)
{
    const uint32_t *range = tree->leaf + 2 * (size_t)node;
    if (degree != HPR_TREE_LEAVES)
        return (link_end){1, node, degree, NULL};
    return (link_end){range[1] - range[0], node, degree, tree->elements->leaf + range[0]};
}

static uint32_t end_node(const link_end *end, size_t index)
{
    return end->leaf ? end->leaf[index] : end->node;
}

static int end_degree(const hpr_tree *tree, const link_end *end, size_t index)
{
    return end->leaf ? tree->degree[end->leaf[index]] : end->degree;
}

/* Constants against constants that are not near each other. Returns whether they could be had so; then
 * w->kind tells which are still missing. */
static bool integrate_constants(const assembly *a, worker *w, const hpr_link *link, const link_end *recv,
                                const link_end *send)
{
    const hpr_links *links = a->links;
    const hpr_tree *tree = links->tree;
    const hpr_element_frame r = hpr_tree_frame(tree, link->recv, 0), s = hpr_tree_frame(tree, link->send, 0);
    hpr_far_view view = hpr_far_foretell(&r, &s);
    bool open = tree->kind[link->recv] == HPR_NODE_OPEN && tree->kind[link->send] == HPR_NODE_OPEN;
    bool exact = (recv->leaf || !leaves_out(tree, link->recv, link->recv_degree)) &&
                 (send->leaf || !leaves_out(tree, link->send, link->send_degree));
    bool tables = r.shape != HPR_SHAPE_QUADRILATERAL && s.shape != HPR_SHAPE_QUADRILATERAL;
    bool smooth = tables && !view.recv_straddles && !view.send_straddles && !view.hidden;
    if (!open || !exact || !smooth || hpr_link_size(links, link) != recv->count * send->count)
        return false;
    for (size_t i = 0; i < recv->count; i++)
        w->frame[i] = hpr_tree_frame(tree, end_node(recv, i), 0);
    for (size_t j = 0; j < send->count; j++)
        w->frame[recv->count + j] = hpr_tree_frame(tree, end_node(send, j), 0);
    const hpr_constants_task task = {.tables = a->far,
                                     .recv = {recv->count, w->frame},
                                     .send = {send->count, w->frame + recv->count},
                                     .tolerance = links->tolerance,
                                     .slack_m = hpr_visibility_slack_m(a->visibility)};
    memset(w->kind, HPR_PAIR_WANTED, recv->count * send->count);
    hpr_constants_result done =
        hpr_constants_block(&task, links->block + link->offset, w->kind, w->far_scratch);
    w->counts[HPR_COUNT_KERNEL] += done.kernel_count;
    w->counts[HPR_COUNT_PAIRS_VISIBLE] += done.pair_count;
    w->counts[HPR_COUNT_BLOCKS] += done.pair_count;
    return true;
}

/* Of a link by leaves: the block of one pair of them, put in its place. */
static void integrate_leaves(const assembly *a, worker *w, piece *p, double *block, size_t columns)
{
    const hpr_tree *tree = a->links->tree;
    size_t rows = hpr_tree_count(tree, p->recv, p->recv_degree),
           width = hpr_tree_count(tree, p->send, p->send_degree);
    p->block = w->piece;
    integrate_piece(a, w, p);
    for (size_t k = 0; k < rows; k++)
        memcpy(block + k * columns, p->block + k * width, width * sizeof *block);
}

static void integrate_link(const assembly *a, worker *w, size_t l)
{
    const hpr_links *links = a->links;
    const hpr_link *link = &links->link[l];
    const hpr_tree *tree = links->tree;
    double *block = links->block + link->offset;
    piece p = {l, link->recv, link->send, link->recv_degree, link->send_degree, block};
    link_end recv = end_of(tree, link->recv, link->recv_degree),
             send = end_of(tree, link->send, link->send_degree);
    if (!recv.leaf && !send.leaf) {
        integrate_piece(a, w, &p);
        return;
    }
    size_t columns = hpr_tree_count(tree, link->send, link->send_degree), row = 0;
    bool constants = integrate_constants(a, w, link, &recv, &send);
    for (size_t i = 0; i < recv.count; i++) {
        size_t column = 0;
        p.recv = end_node(&recv, i);
        p.recv_degree = end_degree(tree, &recv, i);
        for (size_t j = 0; j < send.count; j++) {
            p.send = end_node(&send, j);
            p.send_degree = end_degree(tree, &send, j);
            if (!constants || w->kind[i * send.count + j] == HPR_PAIR_LEFT)
                integrate_leaves(a, w, &p, block + row * columns + column, columns);
            column += hpr_tree_count(tree, p.send, p.send_degree);
        }
        row += hpr_tree_count(tree, p.recv, p.recv_degree);
    }
}

static void integrate_all(assembly *a)
{
    enum { CHUNK = 16 };
    size_t count = a->links->count;
    atomic_size_t done = 0;
#pragma omp parallel num_threads(hpr_context_threads(a->context))
    {
        worker *w = &a->workers[omp_get_thread_num()];
#pragma omp for schedule(dynamic, 1)
        for (size_t first = 0; first < count; first += CHUNK) {
            size_t end = first + CHUNK < count ? first + CHUNK : count;
            for (size_t l = first; l < end && !hpr_cancelled(a->context); l++) {
                integrate_link(a, w, l);
                a->left_out2[l] += hpr_link_jump2(a->links, a->brightness, &a->links->link[l]);
            }
            size_t finished = atomic_fetch_add(&done, end - first) + end - first;
            if (omp_get_thread_num() == 0)
                hpr_stage_progress(a->context, (double)finished / (double)count);
        }
    }
}

static hpr_status make_workers(assembly *a)
{
    hpr_context *ctx = a->context;
    int threads = hpr_context_threads(ctx);
    hpr_status status =
        hpr_allocate_into(ctx, &a->workers, (size_t)threads, sizeof *a->workers, "quadrature scratch");
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        worker *w = &a->workers[t];
        status = hpr_between_init(ctx, a->visibility, a->views, &w->between);
        if (status == HPR_OK)
            status = hpr_block_scratch_create(ctx, &w->scratch);
    }
    return status;
}

static void sum_notes(const assembly *a, hpr_links *links)
{
    double left_out2 = 0, sampled2 = 0;
    for (size_t l = 0; l < links->count; l++) {
        left_out2 += a->left_out2[l];
        sampled2 += links->note[l].sampled2;
        links->short_count += links->note[l].short_count;
        links->block_error = fmax(links->block_error, links->note[l].error);
        links->sampled_error = fmax(links->sampled_error, links->note[l].sampled_error);
    }
    links->link_error = sqrt(left_out2);
    links->sampling_error = sqrt(sampled2);
}

static void close_workers(assembly *a)
{
    for (int t = 0; a->workers && t < hpr_context_threads(a->context); t++) {
        worker *w = &a->workers[t];
        for (int c = 0; c < HPR_COUNTER_COUNT; c++)
            hpr_count(a->context, (hpr_counter)c, w->counts[c]);
        hpr_between_fini(&w->between);
        hpr_block_scratch_destroy(&w->scratch);
        hpr_release(a->context, w->far_scratch);
        hpr_release(a->context, w->piece);
        hpr_release(a->context, w->frame);
        hpr_release(a->context, w->kind);
    }
    hpr_release(a->context, a->workers);
}

static hpr_status prepare(assembly *a, const hpr_links_demand *demand)
{
    for (size_t i = 0; i < a->patches->count; i++)
        a->links->area_m2 += a->patches->area_m2[i];
    hpr_status status = hpr_visibility_create(a->patches, &a->visibility);
    if (status == HPR_OK)
        status = hpr_links_afford(a->visibility, a->elements, demand->most_bytes);
    if (status == HPR_OK)
        status = hpr_views_create(a->visibility, demand->sends, &a->views);
    if (status == HPR_OK)
        status = hpr_quadrature_create(a->context, &a->quadrature);
    if (status == HPR_OK)
        status = make_workers(a);
    return status;
}

hpr_status hpr_links_assemble(const hpr_coverage *coverage, const hpr_elements *elements,
                              const hpr_links_demand *demand, hpr_links **out)
{
    const hpr_patches *patches = hpr_coverage_patches(coverage);
    hpr_context *ctx = patches->context;
    assembly a = {.coverage = coverage,
                  .patches = patches,
                  .elements = elements,
                  .context = ctx,
                  .brightness = demand->brightness,
                  .kept = {demand->known, demand->keeper}};
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &a.links, 1, sizeof *a.links, "links");
    if (status != HPR_OK)
        return status;
    a.links->context = ctx;
    status = prepare(&a, demand);
    if (status == HPR_OK)
        status = make_links(&a, demand);
    if (status == HPR_OK && !demand->counted) {
        choose_tolerances(&a, demand->block_tolerance, demand->blocked_tolerance);
        integrate_all(&a);
        sum_notes(&a, a.links);
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted during assembly");
    }
    close_workers(&a);
    hpr_views_destroy(&a.views);
    hpr_visibility_destroy(&a.visibility);
    hpr_quadrature_destroy(&a.quadrature);
    hpr_far_destroy(&a.far);
    hpr_release(ctx, a.verdict);
    hpr_release(ctx, a.left_out2);
    if (status != HPR_OK)
        hpr_links_destroy(&a.links);
    *out = a.links;
    return status;
}
