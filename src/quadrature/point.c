#include "quadrature/point.h"

#include "quadrature/cuts.h"
#include "quadrature/rule.h"

#include <math.h>
#include <string.h>

struct hpr_point_scratch {
    hpr_context *context;
    hpr_group points;
    hpr_convex blocker[HPR_CLIP_BLOCKERS];
};

hpr_status hpr_point_scratch_create(hpr_context *ctx, hpr_point_scratch **scratch)
{
    hpr_status status = hpr_allocate_into(ctx, scratch, 1, sizeof **scratch, "quadrature scratch");
    if (status == HPR_OK)
        (*scratch)->context = ctx;
    return status;
}

void hpr_point_scratch_destroy(hpr_point_scratch **scratch)
{
    if (*scratch)
        hpr_release((*scratch)->context, *scratch);
    *scratch = NULL;
}

typedef struct arrival {
    const hpr_block_task *task;
    double at[2], factor;
    bool by_rays;
    double *row;
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
    const hpr_points *x = &group->recv, *y = &group->send;
    const hpr_element_frame *send = &a->task->send;
    size_t count = hpr_basis_count(send->shape, send->degree);
    double basis[HPR_MAX_BASIS];
    for (int j = 0; j < y->count; j++) {
        double dx = y->x[j] - x->x[0], dy = y->y[j] - x->y[0], dz = y->z[j] - x->z[0];
        double r2 = dx * dx + dy * dy + dz * dz;
        if (a->by_rays && is_hidden(a, y->s[j], y->t[j]))
            continue;
        double kernel = a->factor * group->scale * x->weight[0] * y->weight[j] / (r2 * r2);
        hpr_frame_basis(send, y->s[j], y->t[j], basis);
        for (size_t l = 0; l < count; l++)
            a->row[l] += kernel * basis[l];
    }
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
