/* The simple evaluation of kernel blocks: one group of points after the other, one receiver point at a time.
 */
#include "quadrature/block.h"
#include "quadrature/rule.h"

#include <string.h>

struct hpr_quadrature {
    hpr_context *context;
    hpr_gauss_table gauss;
};

struct hpr_block_scratch {
    hpr_context *context;
    hpr_group points, trial; /* the choice of rules works in `trial` while `points` is being evaluated */
    double send_basis[(size_t)HPR_POINTS_MAX * HPR_MAX_BASIS]; /* [points][n_send] */
    double recv_basis[HPR_MAX_BASIS];
    double transported[HPR_MAX_BASIS]; /* sum over sender points of G phi_l */
    double kernel[HPR_POINTS_MAX];
};

hpr_status hpr_quadrature_create(hpr_context *ctx, hpr_quadrature **quadrature)
{
    hpr_status status = hpr_allocate_into(ctx, quadrature, 1, sizeof **quadrature, "quadrature tables");
    if (status != HPR_OK)
        return status;
    (*quadrature)->context = ctx;
    hpr_gauss_table_init(&(*quadrature)->gauss);
    return HPR_OK;
}

void hpr_quadrature_destroy(hpr_quadrature **quadrature)
{
    if (*quadrature)
        hpr_release((*quadrature)->context, *quadrature);
    *quadrature = NULL;
}

hpr_status hpr_block_scratch_create(hpr_context *ctx, hpr_block_scratch **scratch)
{
    hpr_status status = hpr_allocate_into(ctx, scratch, 1, sizeof **scratch, "quadrature scratch");
    if (status == HPR_OK)
        (*scratch)->context = ctx;
    return status;
}

void hpr_block_scratch_destroy(hpr_block_scratch **scratch)
{
    if (*scratch)
        hpr_release((*scratch)->context, *scratch);
    *scratch = NULL;
}

typedef struct evaluation {
    const hpr_quadrature *quadrature;
    const hpr_block_task *task;
    const hpr_pair *pair;
    size_t n_recv, n_send;
    double *block;
    hpr_block_scratch *scratch;
    hpr_block_result *result;
} evaluation;

static void kernel_row(const hpr_points *from, int i, const hpr_points *to, double scale, double *kernel)
{
    for (int j = 0; j < to->count; j++) {
        double dx = to->x[j] - from->x[i], dy = to->y[j] - from->y[i], dz = to->z[j] - from->z[i];
        double r2 = dx * dx + dy * dy + dz * dz;
        kernel[j] = scale * to->weight[j] / (r2 * r2);
    }
}

/* Points of a frame in scene coordinates. */
static void scene_point(const hpr_element_frame *frame, double s, double t, double point[3])
{
    hpr_vec3_store(point, hpr_frame_point(frame, s, t));
}

/* Zeroes the kernel where the ray is blocked. */
static void sample_visibility(const evaluation *e, const hpr_points *recv, int i, const hpr_points *send,
                              double *kernel)
{
    double x[3], y[3];
    scene_point(&e->task->recv, recv->s[i], recv->t[i], x);
    for (int j = 0; j < send->count; j++) {
        scene_point(&e->task->send, send->s[j], send->t[j], y);
        if (hpr_visibility_blocked(e->task->visibility, x, y, e->task->blockers, e->task->blocker_count))
            kernel[j] = 0;
    }
    e->result->ray_count += (uint64_t)send->count;
}

static void add_group(void *user, const hpr_group *group)
{
    evaluation *e = user;
    hpr_block_scratch *scratch = e->scratch;
    const hpr_points *recv = &group->recv, *send = &group->send;
    const double scale = group->scale / 3.14159265358979323846;
    for (int j = 0; j < send->count; j++)
        hpr_basis_eval(e->task->send.shape, e->task->send.degree, send->s[j], send->t[j],
                       scratch->send_basis + (size_t)j * e->n_send);
    for (int i = 0; i < recv->count; i++) {
        kernel_row(recv, i, send, scale * recv->weight[i], scratch->kernel);
        if (e->task->blocker_count)
            sample_visibility(e, recv, i, send, scratch->kernel);
        memset(scratch->transported, 0, e->n_send * sizeof(double));
        for (int j = 0; j < send->count; j++) {
            const double *basis = scratch->send_basis + (size_t)j * e->n_send;
            for (size_t l = 0; l < e->n_send; l++)
                scratch->transported[l] += scratch->kernel[j] * basis[l];
        }
        hpr_basis_eval(e->task->recv.shape, e->task->recv.degree, recv->s[i], recv->t[i],
                       scratch->recv_basis);
        for (size_t k = 0; k < e->n_recv; k++) {
            for (size_t l = 0; l < e->n_send; l++)
                e->block[k * e->n_send + l] += scratch->recv_basis[k] * scratch->transported[l];
        }
    }
    e->result->kernel_count += (uint64_t)recv->count * (uint64_t)send->count;
}

static void add_rule(void *user, const hpr_rule *rule)
{
    evaluation *e = user;
    hpr_rule_points(&e->quadrature->gauss, e->pair, rule, &e->scratch->points, add_group, e);
}

/* From parameter measure to area, and from phi to T. */
static double area_factor(const hpr_element_frame *frame)
{
    double jacobian = frame->shape == HPR_SHAPE_PARALLELOGRAM ? frame->area_m2 : 2 * frame->area_m2;
    return jacobian * hpr_basis_scale(frame->shape, frame->area_m2);
}

hpr_block_result hpr_block_ref(const hpr_quadrature *quadrature, const hpr_block_task *task, double *block,
                               hpr_block_scratch *scratch)
{
    /* Sampled visibility errs by a part in the number of rays; finer rules for the kernel would be wasted. */
    static const double sampled_tolerance = 1e-3;
    hpr_block_result result = {0};
    hpr_pair pair;
    hpr_pair_init(&pair, &task->recv, &task->send);
    evaluation e = {.quadrature = quadrature,
                    .task = task,
                    .pair = &pair,
                    .n_recv = hpr_basis_count(task->recv.shape, task->recv.degree),
                    .n_send = hpr_basis_count(task->send.shape, task->send.degree),
                    .block = block,
                    .scratch = scratch,
                    .result = &result};
    memset(block, 0, e.n_recv * e.n_send * sizeof *block);
    int degree = task->recv.degree > task->send.degree ? task->recv.degree : task->send.degree;
    hpr_rule_demand demand = {.tolerance = task->tolerance, .contact_m = task->contact_m, .least_nodes = 1};
    if (task->blocker_count) {
        demand.tolerance = fmax(task->tolerance, sampled_tolerance);
        demand.least_nodes = degree + 3;
    }
    hpr_rule_outcome outcome =
        hpr_rules_choose(&quadrature->gauss, &pair, &demand, &scratch->trial, add_rule, &e);
    double factor = area_factor(&task->recv) * area_factor(&task->send);
    for (size_t i = 0; i < e.n_recv * e.n_send; i++)
        block[i] *= factor;
    result.seen = outcome.seen;
    result.stopped_short = outcome.stopped_short;
    result.kernel_count += outcome.kernel_count;
    return result;
}
