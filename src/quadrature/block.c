#include "quadrature/block.h"

#include "quadrature/aligned.h"
#include "quadrature/evaluation.h"
#include "quadrature/flat.h"
#include "quadrature/homothety.h"
#include "quadrature/parallel.h"
#include "quadrature/rooted.h"

#include <string.h>

hpr_status hpr_quadrature_create(hpr_context *ctx, hpr_quadrature **quadrature)
{
    hpr_status status = hpr_allocate_into(ctx, quadrature, 1, sizeof **quadrature, "quadrature tables");
    if (status != HPR_OK)
        return status;
    (*quadrature)->context = ctx;
    (*quadrature)->gauss = &hpr_gauss;
    return HPR_OK;
}

void hpr_quadrature_destroy(hpr_quadrature **quadrature)
{
    if (*quadrature)
        hpr_release((*quadrature)->context, *quadrature);
    *quadrature = NULL;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* Arrays of the scratch that grow with the number of functions. */
enum { ROOMS = 17 };

/* Of each in doubles; returns the sum. */
static size_t measure_rooms(int degree, size_t size[ROOMS])
{
    const size_t m = (size_t)degree + 1, n = m * m, row = HPR_FACTOR_POINTS, wide = row * HPR_LANES;
    const size_t relative = larger(hpr_parallel_scratch(degree), hpr_aligned_scratch(degree));
    const size_t wanted[ROOMS] = {n * HPR_TABLE_POINTS,
                                  n * HPR_ROWS,
                                  n * HPR_ROWS,
                                  n * HPR_ROWS,
                                  n * HPR_ROWS,
                                  n * n,
                                  n * n,
                                  n * n,
                                  n * n,
                                  n * n,
                                  n * n,
                                  n * n,
                                  larger(3 * n * n, relative),
                                  n * row,
                                  n * row,
                                  m * wide,
                                  m * (m + 1) / 2 * wide};
    size_t sum = 0;
    for (int i = 0; i < ROOMS; i++)
        sum += size[i] = hpr_lanes_padded(wanted[i]);
    return sum;
}

static void share_room(hpr_block_scratch *s, const size_t size[ROOMS])
{
    double **const array[ROOMS] = {&s->moments.basis,      &s->outer_basis,        &s->moment,
                                   &s->batch[0].moment,    &s->batch[1].moment,    &s->batch[0].sum,
                                   &s->batch[1].sum,       &s->map[0].matrix,      &s->map[1].matrix,
                                   &s->inside[0],          &s->inside[1],          &s->own_part,
                                   &s->matrices,           &s->factors.rows,       &s->factors.second,
                                   &s->factors.wide_first, &s->factors.wide_second};
    double *next = s->room;
    for (int i = 0; i < ROOMS; i++) {
        *array[i] = next;
        next += size[i];
    }
}

hpr_status hpr_block_scratch_create_for(hpr_context *ctx, int degree, hpr_block_scratch **scratch)
{
    size_t size[ROOMS], all = measure_rooms(degree, size);
    hpr_status status = hpr_allocate_aligned(ctx, scratch, sizeof **scratch + all * sizeof(double),
                                             _Alignof(hpr_block_scratch), "quadrature scratch");
    if (status != HPR_OK)
        return status;
    hpr_block_scratch *s = *scratch;
    share_room(s, size);
    s->context = ctx;
    s->isa = s->points.isa = s->choice.group.isa = hpr_context_isa_level(ctx);
    return HPR_OK;
}

hpr_status hpr_block_scratch_create(hpr_context *ctx, hpr_block_scratch **scratch)
{
    return hpr_block_scratch_create_for(ctx, HPR_MAX_DEGREE, scratch);
}

void hpr_block_scratch_destroy(hpr_block_scratch **scratch)
{
    if (*scratch)
        hpr_release_aligned((*scratch)->context, *scratch);
    *scratch = NULL;
}

/* Points of a frame in scene coordinates. */
static void scene_point(const hpr_element_frame *frame, double s, double t, double point[3])
{
    hpr_vec3_store(point, hpr_frame_point(frame, s, t));
}

/* Where the ray of a point begins or ends. */
static void ray_end(const hpr_evaluation *e, const hpr_group_side *side, int index, const double random[2],
                    double point[3])
{
    double s = side->points->s[index], t = side->points->t[index];
    if (e->rule->kind == HPR_RULE_PRODUCT)
        hpr_sampled_place(e->quadrature->gauss, side->cell, side->nodes, index, random, &s, &t);
    scene_point(side->frame, s, t, point);
}

void hpr_evaluation_sample(hpr_evaluation *e, const hpr_group_side *outer, int i, const hpr_group_side *inner,
                           double *kernel)
{
    double x[3], y[3], random[4];
    for (int j = 0; j < inner->points->count; j++) {
        hpr_sampled_random(e->task->seed, e->result->ray_count++, random);
        ray_end(e, outer, i, random, x);
        ray_end(e, inner, j, random + 2, y);
        e->rays.weight += kernel[j];
        e->rays.square += kernel[j] * kernel[j];
        if (hpr_visibility_blocked(e->task->visibility, x, y, e->task->blockers, e->task->blocker_count))
            kernel[j] = 0;
        e->rays.seen += kernel[j];
    }
}

hpr_group_sides hpr_evaluation_sides(const hpr_evaluation *e, const hpr_group *group, bool by_recv)
{
    const hpr_rule *rule = e->rule;
    const hpr_group_side recv = {&group->recv, &e->task->recv, e->n_recv, &rule->recv, rule->recv_nodes};
    const hpr_group_side send = {&group->send, &e->task->send, e->n_send, &rule->send, rule->send_nodes};
    return (hpr_group_sides){by_recv ? recv : send, by_recv ? send : recv};
}

static double largest(const hpr_evaluation *e, const double *entry, size_t count)
{
    return hpr_sums_of(e->scratch->isa)->largest(entry, count);
}

static void add(double *to, const double *from, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] += from[i];
}

/* A rule of the same kind with few points, for when the budget is spent. */
static hpr_rule rough(const hpr_rule *rule)
{
    static const double tolerance = 1e-2, error = 2; /* of what it contributes */
    hpr_rule few = *rule;
    int *nodes[] = {few.recv_nodes,   few.recv_nodes + 1,   few.send_nodes,    few.send_nodes + 1,
                    few.nested.nodes, few.nested.nodes + 1, &few.kernel_nodes, &few.scale_nodes};
    for (size_t i = 0; i < sizeof nodes / sizeof *nodes; i++)
        *nodes[i] = *nodes[i] > 2 ? 2 : *nodes[i];
    few.tolerance = fmax(few.tolerance, tolerance);
    few.nested.tolerance = fmax(few.nested.tolerance, tolerance);
    few.error = fmax(few.error, error);
    return few;
}

/* Sum `level`: the block, or what homothety `level` is to be applied to. */
static double *sum_of(const hpr_evaluation *e, int level)
{
    return level ? e->scratch->inside[level - 1] : e->block;
}

/* Where something is put together that is to be added to a sum: in its place if it is the first. */
static double *begin_part(hpr_evaluation *e, int level)
{
    double *part = e->begun[level] ? e->scratch->own_part : sum_of(e, level);
    memset(part, 0, e->n_recv * e->n_send * sizeof *part);
    return part;
}

static void end_part(hpr_evaluation *e, int level, const double *part)
{
    if (e->begun[level])
        add(sum_of(e, level), part, e->n_recv * e->n_send);
    e->begun[level] = true;
}

static void add_rule(void *user, const hpr_rule *chosen)
{
    hpr_evaluation *e = user;
    const hpr_rule few = rough(chosen);
    e->spent |=
        e->result->kernel_count >= (e->task->kernel_limit ? e->task->kernel_limit : HPR_BLOCK_KERNELS);
    const hpr_rule *rule = e->spent ? &few : chosen;
    int level = rule->kind == HPR_RULE_NESTED ? rule->nested.homothety : 0;
    e->rule = rule;
    e->scratch->part = begin_part(e, level);
    if (rule->kind == HPR_RULE_PARALLEL)
        e->result->kernel_count +=
            hpr_parallel_add(e->quadrature->gauss, e->pair, &rule->parallel, rule->tolerance,
                             &e->scratch->points, e->scratch->part, e->scratch->matrices);
    else if (rule->kind == HPR_RULE_ALIGNED)
        e->complete &= hpr_aligned_add(e->quadrature->gauss, e->pair, &rule->aligned, rule->tolerance,
                                       e->scratch->part, e->scratch->matrices, &e->result->kernel_count);
    else
        hpr_rule_points(e->quadrature->gauss, e->pair, rule, &e->scratch->points, e->by->add_group, e);
    e->by->end_rule(e);
    double most = largest(e, e->scratch->part, e->n_recv * e->n_send);
    end_part(e, level, e->scratch->part);
    e->error[level] += rule->error * most;
    e->size[level] += most;
}

/* Applies homothety `level` to its sum. Errors grow as the sum itself does. */
static void apply_homothety(hpr_evaluation *e, int level, const hpr_centre *centre)
{
    const double *inside = sum_of(e, level);
    size_t count = e->n_recv * e->n_send;
    if (!e->begun[level])
        return;
    double *part = begin_part(e, level - 1);
    hpr_homothety_apply(e->quadrature->gauss, e->pair, centre, level == 1, inside, part,
                        e->scratch->matrices);
    double before = largest(e, inside, count), grown = before > 0 ? largest(e, part, count) / before : 0;
    end_part(e, level - 1, part);
    e->error[level - 1] += grown * e->error[level];
    e->size[level - 1] += grown * e->size[level];
}

/* From parameter measure to area, and from phi to T. */
static double area_factor(const hpr_element_frame *frame)
{
    return hpr_frame_jacobian(frame) * hpr_frame_scale(frame);
}

/* A power of two that makes the longer edges about 1 long, so that no fourth power of a distance runs over.
 */
static double unit_scale(const hpr_block_task *task)
{
    double longest = fmax(fmax(hpr_length(task->recv.edge1), hpr_length(task->recv.edge2)),
                          fmax(hpr_length(task->send.edge1), hpr_length(task->send.edge2)));
    return longest > 0 && longest < INFINITY ? ldexp(1, -ilogb(longest)) : 1;
}

/* phi_0, for T_0 = 1 / sqrt(A). */
static double first_value(const hpr_element_frame *frame)
{
    return 1 / (sqrt(frame->area_m2) * hpr_frame_scale(frame));
}

void hpr_block_set_blockers(const hpr_block_task *task, double scale, hpr_pair *pair, hpr_convex *outline)
{
    const hpr_convex *all = hpr_visibility_outlines(task->visibility);
    for (size_t i = 0; i < task->blocker_count; i++) {
        const hpr_convex *whole = &all[task->blockers[i]];
        outline[i].count = whole->count;
        for (int k = 0; k < whole->count; k++)
            outline[i].corner[k] = hpr_scale(hpr_sub(whole->corner[k], task->recv.origin), scale);
    }
    pair->blocker = outline;
    pair->blocker_count = (int)task->blocker_count;
}

/*
 * A view through a slit no wider than the distance over which points count as touching is no view: the faces
 * of a closed box whose corners are rounded to float32 leave such slits. Bound: K^00 of the slit's share of
 * the smaller element, all of it seen squarely from the distance of the two centres.
 */
static double slit_block(const hpr_pair *pair, double contact)
{
    static const double slits = 4;
    const hpr_element_frame *recv = &pair->recv, *send = &pair->send;
    double smaller = fmin(recv->area_m2, send->area_m2);
    hpr_vec3 gap = hpr_sub(hpr_frame_point(recv, 0.5, 0.5), hpr_frame_point(send, 0.5, 0.5));
    double square = fmax(hpr_dot(gap, gap), smaller);
    return slits * contact / sqrt(smaller) * sqrt(recv->area_m2 * send->area_m2) /
           (3.14159265358979323846 * square);
}

/* Standard error of block[0] / factor. */
static double sampling_error(const hpr_evaluation *e)
{
    return first_value(&e->task->recv) * first_value(&e->task->send) * hpr_sampled_error(&e->rays);
}

/* Blockers and parts, and what is to be reached. */
static hpr_rule_demand prepare(hpr_evaluation *e, hpr_pair *pair)
{
    /* Sampled visibility errs by a part in the number of rays; finer rules for the kernel would be wasted. */
    static const double sampled_tolerance = 1e-3;
    const hpr_block_task *task = e->task;
    hpr_rule_demand demand = {.tolerance = task->tolerance,
                              .negligible = task->negligible,
                              .contact_m = task->contact_m * e->scale,
                              .least_nodes = 1};
    bool clip = task->clip && task->blocker_count <= HPR_CLIP_BLOCKERS;
    e->sampled = task->blocker_count && !clip;
    if (e->sampled) {
        int degree = task->recv.degree > task->send.degree ? task->recv.degree : task->send.degree;
        bool parts = task->recv_part_count || task->send_part_count;
        demand.tolerance = fmax(task->tolerance, sampled_tolerance);
        /* parts are many cells, each with nodes of its own */
        demand.least_nodes = task->ray_nodes > 0 ? task->ray_nodes : parts ? 2 : degree > 1 ? degree + 2 : 3;
    } else if (task->blocker_count)
        hpr_block_set_blockers(task, e->scale, pair, e->scratch->blocker);
    pair->recv_part = task->recv_part;
    pair->send_part = task->send_part;
    pair->recv_part_count = task->recv_part_count;
    pair->send_part_count = task->send_part_count;
    return demand;
}

/* The two parts of the estimated error of a block. */
typedef struct estimate {
    double quadrature, rounding;
} estimate;

static estimate estimate_of(const hpr_evaluation *e, const hpr_rule_outcome *outcome, double factor,
                            double exchange)
{
    /* Of 30000 random pairs one in 500 errs by more than this part of the rules' bounds. */
    static const double observed = 0.4;
    double size = factor * e->size[0] + exchange;
    return (estimate){outcome->error + factor * observed * e->error[0] +
                          (e->sampled ? factor * sampling_error(e) : 0),
                      outcome->rounding * size + fmin(outcome->flat * size, outcome->swept)};
}

static hpr_block_status status_of(const hpr_evaluation *e, const estimate *error, bool complete)
{
    double most = largest(e, e->block, e->n_recv * e->n_send);
    double allowed = fmax(e->task->tolerance * most, e->task->negligible);
    if (e->sampled)
        return HPR_BLOCK_SAMPLED;
    if (!complete || error->quadrature > fmax(allowed, error->rounding))
        return HPR_BLOCK_SHORT;
    return error->quadrature + error->rounding > allowed ? HPR_BLOCK_ROUNDED : HPR_BLOCK_WITHIN;
}

/* Parts are in the parameters that the elements have. */
static hpr_block_task rooted(const hpr_block_task *task)
{
    hpr_block_task own = *task;
    if (!own.recv_part_count && !own.send_part_count)
        hpr_frames_root(&own.recv, &own.send);
    return own;
}

static hpr_block_result integrate(const hpr_evaluator *by, const hpr_quadrature *quadrature,
                                  const hpr_block_task *given, double *block, hpr_block_scratch *scratch)
{
    const hpr_block_task own = rooted(given), *task = &own;
    hpr_block_result result = {0};
    hpr_pair pair;
    double scale = unit_scale(task);
    const hpr_element_frame recv = hpr_frame_rescaled(&task->recv, scale),
                            send = hpr_frame_rescaled(&task->send, scale);
    hpr_pair_init(&pair, &recv, &send);
    if (!task->blocker_count)
        hpr_pair_flatten(&pair, task->contact_m * scale);
    hpr_evaluation e = {.by = by,
                        .quadrature = quadrature,
                        .task = task,
                        .pair = &pair,
                        .scale = scale,
                        .n_recv = hpr_basis_count(task->recv.shape, task->recv.degree),
                        .n_send = hpr_basis_count(task->send.shape, task->send.degree),
                        .block = block,
                        .scratch = scratch,
                        .complete = true,
                        .result = &result};
    size_t count = e.n_recv * e.n_send;
    by->begin(&e);
    hpr_rule_demand demand = prepare(&e, &pair);
    hpr_rule_outcome outcome =
        hpr_rules_choose(quadrature->gauss, &pair, &demand, &scratch->choice, add_rule, &e);
    for (int level = outcome.centre_count; level > 0; level--)
        apply_homothety(&e, level, &outcome.centre[level - 1]);
    double factor = area_factor(&recv) * area_factor(&send);
    double exchange = outcome.exchange_m2 / sqrt(recv.area_m2 * send.area_m2);
    if (!e.begun[0])
        memset(block, 0, count * sizeof *block);
    for (size_t i = 0; i < count; i++)
        block[i] *= factor;
    if (e.sampled)
        result.sampling_error = factor * sampling_error(&e);
    block[0] += exchange;
    bool by_parts = pair.blocker_count || pair.recv_part_count || pair.send_part_count;
    result.seen = outcome.seen && !(by_parts && block[0] <= slit_block(&pair, demand.contact_m));
    if (!result.seen)
        memset(block, 0, count * sizeof *block);
    estimate error = {0, 0};
    if (result.seen)
        error = estimate_of(&e, &outcome, factor, exchange);
    result.error = error.quadrature + error.rounding;
    result.status = status_of(&e, &error, e.complete && !outcome.stopped_short && !e.spent);
    result.clip_count = outcome.clip_count;
    return result;
}

hpr_block_result hpr_block(const hpr_quadrature *quadrature, const hpr_block_task *task, double *block,
                           hpr_block_scratch *scratch)
{
    return integrate(&hpr_evaluator_fast, quadrature, task, block, scratch);
}

hpr_block_result hpr_block_ref(const hpr_quadrature *quadrature, const hpr_block_task *task, double *block,
                               hpr_block_scratch *scratch)
{
    return integrate(&hpr_evaluator_simple, quadrature, task, block, scratch);
}
