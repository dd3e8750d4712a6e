#include "link/between.h"

#include "link/refine.h"

hpr_status hpr_between_init(hpr_context *ctx, const hpr_visibility *visibility, const hpr_views *views,
                            hpr_between *between)
{
    size_t occluders = hpr_visibility_occluder_count(visibility);
    *between = (hpr_between){.context = ctx,
                             .visibility = visibility,
                             .views = views,
                             .recv_patch = HPR_NONE,
                             .send_patch = HPR_NONE};
    hpr_status status = hpr_views_cursor_create(views, &between->cursor);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &between->candidate, occluders, sizeof(uint32_t), "blockers");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &between->blocker, occluders, sizeof(uint32_t), "blockers");
    return status;
}

void hpr_between_fini(hpr_between *between)
{
    if (!between->context)
        return;
    hpr_views_cursor_destroy(&between->cursor);
    hpr_release(between->context, between->candidate);
    hpr_release(between->context, between->blocker);
    *between = (hpr_between){0};
}

hpr_verdict hpr_between_patches(hpr_between *between, uint32_t recv, uint32_t send)
{
    if (recv != between->recv_patch || send != between->send_patch)
        between->verdict = hpr_views_classify(between->views, between->cursor, recv, send, between->candidate,
                                              &between->candidate_count);
    between->recv_patch = recv;
    between->send_patch = send;
    return between->verdict;
}

bool hpr_between_nodes(hpr_between *between, const hpr_coverage *coverage, const hpr_tree *tree,
                       uint32_t recv, uint32_t send, hpr_block_task *task)
{
    const uint32_t *patch = tree->elements->patch;
    hpr_verdict patches = hpr_between_patches(between, patch[recv], patch[send]);
    task->visibility = between->visibility;
    task->blockers = between->blocker;
    task->blocker_count = 0;
    if (patches != HPR_SEES_PARTLY)
        return patches == HPR_SEES_WHOLLY;
    hpr_facet from = hpr_node_facet(coverage, tree, recv), to = hpr_node_facet(coverage, tree, send);
    return hpr_visibility_classify(between->visibility, &from, &to, between->candidate,
                                   between->candidate_count, between->blocker,
                                   &task->blocker_count) != HPR_SEES_NOTHING;
}
