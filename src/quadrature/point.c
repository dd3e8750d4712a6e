#include "quadrature/point.h"

#include "quadrature/cuts.h"
#include "quadrature/products.h"
#include "quadrature/rule.h"

#include <math.h>
#include <string.h>

struct hpr_point_scratch {
    hpr_context *context;
    hpr_group points;
    hpr_moment_scratch moments;
    double kernel[HPR_POINTS_ROOM], basis[HPR_MAX_BASIS * HPR_TABLE_POINTS];
    hpr_convex blocker[HPR_CLIP_BLOCKERS];
};

hpr_status hpr_point_scratch_create(hpr_context *ctx, hpr_point_scratch **out)
{
    hpr_point_scratch *scratch = NULL;
    hpr_status status = hpr_allocate_aligned(ctx, &scratch, sizeof *scratch, _Alignof(hpr_point_scratch),
                                             "quadrature scratch");
    if (status == HPR_OK) {
        scratch->context = ctx;
        scratch->moments.basis = scratch->basis;
        scratch->points.isa = hpr_context_isa_level(ctx);
    }
    *out = scratch;
    return status;
}

void hpr_point_scratch_destroy(hpr_point_scratch **scratch)
{
    if (*scratch)
        hpr_release_aligned((*scratch)->context, *scratch);
    *scratch = NULL;
}

typedef struct arrival {
    const hpr_block_task *task;
    double at[2], factor;
    bool by_rays;
    double *row;
    hpr_point_scratch *scratch;
    hpr_block_result *result;
} arrival;

static bool is_hidden(const arrival *a, double s, double t)
{
    double x[3], y[3];
    hpr_vec3_store(x, hpr_frame_point(&a->task->recv, a->at[0], a->at[1]));
    hpr_vec3_store(y, hpr_frame_point(&a->task->send, s, t));
    a->result->ray_count++;
    return hpr_visibility_blocked(a->task->visibility, x, y, a->task->blockers, a->task->blocker_count);
}

/* The receiver's only point against the sender's points. */
static void add_group(void *user, const hpr_group *group)
{
    const arrival *a = user;
    hpr_point_scratch *scratch = a->scratch;
    hpr_points *y = &scratch->points.send;
    hpr_points_pad(y);
    hpr_sums_of(group->isa)
        ->kernel(&group->recv, 0, y, a->factor * group->scale * group->recv.weight[0], scratch->kernel);
    for (int j = 0; j < y->count && a->by_rays; j++) {
        if (is_hidden(a, y->s[j], y->t[j]))
            scratch->kernel[j] = 0;
    }
    hpr_own_moments(group->isa, &a->task->send, y, scratch->kernel, a->row, &scratch->moments);
    a->result->kernel_count += (uint64_t)y->count;
}

static hpr_rule open_rule(const hpr_block_task *task, const double at[2], const hpr_polygon *inner)
{
    hpr_rule rule = {.kind = HPR_RULE_NESTED, .recv_is_outer = true};
    rule.nested = (hpr_nested){
        .recv_is_outer = true, .inner = *inner, .weight = 1, .tolerance = task->tolerance, .nodes = {1, 1}};
    memcpy(rule.nested.outer[0], at, sizeof rule.nested.outer[0]);
    memcpy(rule.nested.outer_origin, at, sizeof rule.nested.outer_origin);
    memcpy(rule.nested.inner_origin, inner->corner[0], sizeof rule.nested.inner_origin);
    return rule;
}

/* A cell so small that its middle stands for it; its measure is taken out again. */
static const double tiny = 0x1p-24;

static hpr_rule clipped_rule(const hpr_block_task *task, const double at[2], const hpr_polygon *inner)
{
    return (hpr_rule){.kind = HPR_RULE_CLIPPED,
                      .recv_is_outer = true,
                      .recv = {.shape = HPR_SHAPE_PARALLELOGRAM,
                               .origin = {at[0] - tiny / 2, at[1] - tiny / 2},
                               .edge1 = {tiny, 0},
                               .edge2 = {0, tiny}},
                      .recv_nodes = {1, 1},
                      .box = hpr_box_unit(),
                      .inner = *inner,
                      .inner_degree = hpr_total_degree(&task->send),
                      .tolerance = task->tolerance};
}

void hpr_point_gather(const hpr_block_task *task, double s, double t, double *row, hpr_point_scratch *scratch,
                      hpr_block_result *result)
{
    const hpr_element_frame *send = &task->send;
    const double at[2] = {s, t};
    const hpr_polygon whole = hpr_frame_outline(send);
    const hpr_polygon *part = task->send_part ? task->send_part : &whole;
    int part_count = task->send_part ? task->send_part_count : 1;
    hpr_pair pair;
    memset(row, 0, hpr_basis_count(send->shape, send->degree) * sizeof *row);
    hpr_pair_init(&pair, &task->recv, send);
    if (!(hpr_affine_at(&pair.recv_height, s, t) > 0))
        return;
    bool clip = task->blocker_count > 0 && task->blocker_count <= HPR_CLIP_BLOCKERS;
    if (clip)
        hpr_block_set_blockers(task, 1, &pair, scratch->blocker);
    arrival a = {.task = task,
                 .at = {s, t},
                 .factor = hpr_frame_jacobian(send) * hpr_frame_scale(send) / 3.14159265358979323846 *
                           (clip ? 1 / (tiny * tiny) : 1),
                 .by_rays = task->blocker_count > HPR_CLIP_BLOCKERS,
                 .row = row,
                 .scratch = scratch,
                 .result = result};
    for (int i = 0; i < part_count; i++) {
        hpr_polygon front = hpr_polygon_half(&part[i], &pair.send_height, 1);
        if (front.count < 3)
            continue;
        hpr_rule rule = clip ? clipped_rule(task, at, &front) : open_rule(task, at, &front);
        hpr_rule_points(&hpr_gauss, &pair, &rule, &scratch->points, add_group, &a);
    }
    result->clip_count += clip;
}
