#include "link/spots.h"

#include "link/between.h"
#include "quadrature/point.h"

#include <math.h>
#include <omp.h>
#include <string.h>

typedef struct worker {
    hpr_point_scratch *scratch;
    hpr_between between;
    uint64_t counts[HPR_COUNTER_COUNT];
} worker;

typedef struct gathering {
    const hpr_links *links;
    const hpr_coverage *coverage;
    const hpr_elements *elements;
    uint32_t *parent; /* [node_count] HPR_NONE: root */
    hpr_visibility *visibility;
    hpr_views *views;
    worker *workers; /* [threads] */
    size_t channel_count;
    const double *sent;
    double tolerance;
} gathering;

static void add_node(const gathering *g, worker *w, const hpr_spot *spot, uint32_t send, int degree,
                     bool partly, double *irradiance)
{
    const hpr_tree *tree = g->links->tree;
    uint32_t leaf = g->elements->leaf[spot->leaf];
    hpr_block_task task = {.recv = hpr_tree_frame(tree, leaf, 0),
                           .send = hpr_tree_frame(tree, send, degree),
                           .tolerance = g->tolerance};
    if (!hpr_between_nodes(&w->between, g->coverage, tree, leaf, send, &task))
        return;
    if (partly || !hpr_tree_is_mixed(tree, send))
        task.send_part = hpr_coverage_node_parts(g->coverage, send, &task.send_part_count);
    double stretch = partly ? hpr_tree_stretch(tree, send) : 1;
    double row[HPR_MAX_BASIS], room[HPR_MAX_BASIS];
    hpr_block_result result = {0};
    hpr_point_gather(&task, spot->s, spot->t, row, w->scratch, &result);
    for (size_t c = 0; c < g->channel_count; c++) {
        const double *sent = hpr_tree_take(tree, send, degree, g->sent + c * tree->dof_count, room);
        for (size_t k = 0; k < hpr_tree_count(tree, send, degree); k++)
            irradiance[c] += stretch * row[k] * sent[k];
    }
    w->counts[HPR_COUNT_KERNEL] += result.kernel_count;
    w->counts[HPR_COUNT_RAYS] += result.ray_count;
    w->counts[HPR_COUNT_CLIPS] += result.clip_count;
}

/* The other end of a link: a node, or all leaves below it. */
static void add_end(const gathering *g, worker *w, const hpr_spot *spot, uint32_t node, int degree,
                    bool partly, double *irradiance)
{
    const hpr_tree *tree = g->links->tree;
    const uint32_t *range = tree->leaf + 2 * (size_t)node;
    if (degree != HPR_TREE_LEAVES) {
        add_node(g, w, spot, node, degree, partly, irradiance);
        return;
    }
    for (uint32_t leaf = range[0]; leaf < range[1]; leaf++) {
        uint32_t send = g->elements->leaf[leaf];
        add_node(g, w, spot, send, tree->degree[send], partly, irradiance);
    }
}

static void gather_spot(const gathering *g, worker *w, const hpr_spot *spot, double *irradiance)
{
    const hpr_links *links = g->links;
    memset(irradiance, 0, g->channel_count * sizeof *irradiance);
    if (!hpr_coverage_open(g->coverage, spot->leaf, spot->s, spot->t))
        return;
    for (uint32_t node = g->elements->leaf[spot->leaf]; node != HPR_NONE; node = g->parent[node]) {
        for (size_t i = links->row[node]; i < links->row[node + 1]; i++) {
            const hpr_link *link = &links->link[links->row_link[i]];
            if (link->recv == node)
                add_end(g, w, spot, link->send, link->send_degree, link->partly, irradiance);
            else
                add_end(g, w, spot, link->recv, link->recv_degree, link->partly, irradiance);
        }
    }
}

static hpr_status make_workers(gathering *g)
{
    hpr_context *ctx = g->links->context;
    int threads = hpr_context_threads(ctx);
    hpr_status status = hpr_allocate_into(ctx, &g->workers, (size_t)threads, sizeof *g->workers, "spots");
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        worker *w = &g->workers[t];
        status = hpr_between_init(ctx, g->visibility, g->views, &w->between);
        if (status == HPR_OK)
            status = hpr_point_scratch_create(ctx, &w->scratch);
    }
    return status;
}

static hpr_status prepare(gathering *g)
{
    hpr_context *ctx = g->links->context;
    const hpr_elements *e = g->elements;
    hpr_status status = hpr_allocate_into(ctx, &g->parent, e->node_count, sizeof *g->parent, "spots");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < e->node_count; i++)
        g->parent[i] = HPR_NONE;
    for (size_t i = 0; i < e->node_count; i++) {
        if (e->child[i] != HPR_NONE)
            g->parent[e->child[i]] = g->parent[e->child[i] + 1] = (uint32_t)i;
    }
    status = hpr_visibility_create(hpr_coverage_patches(g->coverage), &g->visibility);
    if (status == HPR_OK)
        status = hpr_views_create(g->visibility, NULL, &g->views);
    if (status == HPR_OK)
        status = make_workers(g);
    return status;
}

static void shut_down(gathering *g)
{
    hpr_context *ctx = g->links->context;
    for (int t = 0; g->workers && t < hpr_context_threads(ctx); t++) {
        worker *w = &g->workers[t];
        for (int c = 0; c < HPR_COUNTER_COUNT; c++)
            hpr_count(ctx, (hpr_counter)c, w->counts[c]);
        hpr_between_fini(&w->between);
        hpr_point_scratch_destroy(&w->scratch);
    }
    hpr_release(ctx, g->workers);
    hpr_release(ctx, g->parent);
    hpr_views_destroy(&g->views);
    hpr_visibility_destroy(&g->visibility);
}

/* As a block of its own kind: no degree is so high. */
static hpr_kept_block name_spot(const hpr_spots_task *task, size_t i)
{
    return (hpr_kept_block){.recv = (uint32_t)i,
                            .send = task->call,
                            .recv_degree = UINT8_MAX,
                            .send_degree = UINT8_MAX,
                            .count = (uint32_t)task->channel_count};
}

/* What was gathered before a solve was stopped, or is now. */
static void take_spot(const gathering *g, worker *w, const hpr_spots_task *task, size_t i, double *irradiance)
{
    const hpr_block_keeper *keeper = task->keeper;
    hpr_kept_block block = name_spot(task, i);
    if (keeper && keeper->find && keeper->find(keeper->user, &block)) {
        memcpy(irradiance, block.block, task->channel_count * sizeof *irradiance);
        return;
    }
    gather_spot(g, w, &task->spot[i], irradiance);
    block.block = irradiance;
    if (keeper && keeper->keep)
        keeper->keep(keeper->user, &block);
}

hpr_status hpr_spots_gather(const hpr_spots_task *task, double *irradiance)
{
    hpr_context *ctx = task->links->context;
    gathering g = {.links = task->links,
                   .coverage = task->coverage,
                   .elements = task->links->tree->elements,
                   .channel_count = task->channel_count,
                   .sent = task->sent,
                   .tolerance = task->tolerance};
    hpr_status status = prepare(&g);
    if (status == HPR_OK) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
        for (size_t i = 0; i < task->count; i++) {
            if (!hpr_cancelled(ctx))
                take_spot(&g, &g.workers[omp_get_thread_num()], task, i,
                          irradiance + i * task->channel_count);
        }
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while the error was measured");
    }
    shut_down(&g);
    return status;
}
