/*
 * The fast evaluation of kernel blocks. Groups of many points against many go through in eights of outer
 * points. Those of one outer point, of the nested and the clipped rules, give its moments against products of
 * polynomials (products.h); moments of HPR_ROWS outer points make one product of matrices, and the products
 * become the elements' own polynomials when a rule ends.
 */
#include "quadrature/evaluation.h"

#include <float.h>
#include <string.h>

/* With fewer outer points than these most of an eight would be idle. */
enum { GRID_LEAST = 4 };

static void begin(hpr_evaluation *e)
{
    for (int k = 0; k < 2; k++) {
        e->scratch->map[k].made = false;
        e->scratch->batch[k].count = 0;
        e->scratch->batch[k].used = false;
    }
}

static size_t lesser(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* The map of the inner side's polynomials; NULL if it would lose digits that are asked for. */
static const hpr_moment_map *map_of(hpr_evaluation *e, const hpr_element_frame *inner, bool by_recv)
{
    static const double share = 0.1; /* of the tolerance */
    hpr_moment_map *map = &e->scratch->map[by_recv];
    if (!map->made)
        hpr_moment_map_make(inner, map);
    return map->loss * DBL_EPSILON <= share * e->task->tolerance ? map : NULL;
}

/* batch->sum [inner][outer functions] += moments of the batch's outer points times their polynomials. */
static void flush(hpr_evaluation *e, const hpr_element_frame *outer, size_t inner_count, hpr_row_batch *batch)
{
    hpr_block_scratch *scratch = e->scratch;
    size_t outer_count = hpr_basis_count(outer->shape, outer->degree),
           padded = hpr_lanes_padded(batch->count);
    if (!batch->used)
        memset(batch->sum, 0, inner_count * outer_count * sizeof *batch->sum);
    batch->used = true;
    for (size_t i = batch->count; i < padded; i++) {
        batch->s[i] = batch->s[0];
        batch->t[i] = batch->t[0];
        for (size_t l = 0; l < inner_count; l++)
            batch->moment[l * HPR_ROWS + i] = 0;
    }
    batch->count = 0;
    hpr_frame_basis_many(scratch->isa, outer, padded, batch->s, batch->t, HPR_ROWS, scratch->outer_basis,
                         scratch->moments.recurrences);
    const hpr_row_product product = {.left = batch->moment,
                                     .right = scratch->outer_basis,
                                     .left_stride = HPR_ROWS,
                                     .right_stride = HPR_ROWS,
                                     .left_count = inner_count,
                                     .right_count = outer_count,
                                     .vectors = padded / HPR_LANES};
    hpr_sums_of(scratch->isa)->rows(&product, batch->sum, &scratch->moments.sums);
}

/* One outer point against all inner ones. */
static void add_row(hpr_evaluation *e, const hpr_group_sides *sides, bool by_recv, int i, double scale)
{
    hpr_block_scratch *scratch = e->scratch;
    const hpr_group_side *outer = &sides->outer, *inner = &sides->inner;
    const hpr_sums *sums = hpr_sums_of(scratch->isa);
    hpr_row_batch *batch = &scratch->batch[by_recv];
    if (batch->count == HPR_ROWS)
        flush(e, outer->frame, inner->basis_count, batch);
    double *moment = batch->moment + batch->count;
    batch->s[batch->count] = outer->points->s[i];
    batch->t[batch->count] = outer->points->t[i];
    batch->count++;
    sums->kernel(outer->points, (size_t)i, inner->points, scale * outer->points->weight[i], scratch->kernel);
    if (e->sampled)
        hpr_evaluation_sample(e, outer, i, inner, scratch->kernel);
    const hpr_moment_map *map = map_of(e, inner->frame, by_recv);
    if (map) {
        sums->moments(&map->products, (size_t)inner->points->count, inner->points->s, inner->points->t,
                      scratch->kernel, moment, HPR_ROWS, &scratch->moments.sums);
        return;
    }
    memset(scratch->transported, 0, inner->basis_count * sizeof *scratch->transported);
    hpr_own_moments(scratch->isa, inner->frame, inner->points, scratch->kernel, scratch->transported,
                    &scratch->moments);
    for (size_t l = 0; l < inner->basis_count; l++)
        moment[l * HPR_ROWS] = scratch->transported[l];
}

/* Factors of a side of a product rule; false if it has none. */
static bool factors_of(hpr_evaluation *e, const hpr_group_side *of, hpr_factors *factors)
{
    return e->rule->kind == HPR_RULE_PRODUCT &&
           hpr_factors_make(e->scratch->isa, e->quadrature->gauss, of->frame, of->cell, of->nodes,
                            &e->scratch->factors, factors);
}

/* Moments of up to HPR_ROWS outer points against an inner side without factors. */
static void add_tables(hpr_evaluation *e, const hpr_group_sides *sides, size_t first, double scale)
{
    hpr_block_scratch *scratch = e->scratch;
    const hpr_group_side *inner = &sides->inner;
    const size_t count = (size_t)inner->points->count;
    memset(scratch->moment, 0, inner->basis_count * HPR_ROWS * sizeof *scratch->moment);
    for (size_t start = 0; start < count; start += HPR_TABLE_POINTS) {
        hpr_frame_basis_many(scratch->isa, inner->frame,
                             hpr_lanes_padded(lesser(count - start, HPR_TABLE_POINTS)),
                             inner->points->s + start, inner->points->t + start, HPR_TABLE_POINTS,
                             scratch->moments.basis, scratch->moments.recurrences);
        hpr_sums_of(scratch->isa)
            ->grid(sides->outer.points, first, inner->points, start, scale, inner->basis_count,
                   scratch->moments.basis, scratch->moment, &scratch->moments.sums);
    }
}

/* The outer polynomials of all points, if a table of HPR_ROWS holds them with a padded row. */
static bool spread(hpr_evaluation *e, const hpr_group_side *outer)
{
    hpr_factors factors;
    const int *nodes = outer->nodes;
    if (e->rule->kind != HPR_RULE_PRODUCT ||
        (size_t)(nodes[0] * (nodes[1] - 1)) + hpr_lanes_padded((size_t)nodes[0]) > HPR_ROWS ||
        !factors_of(e, outer, &factors))
        return false;
    hpr_sums_of(e->scratch->isa)->spread(&factors, e->scratch->outer_basis);
    return true;
}

/* All against all, straight into the rule's part. */
static void add_grid(hpr_evaluation *e, const hpr_group_sides *sides, bool by_recv, double scale)
{
    hpr_block_scratch *scratch = e->scratch;
    const hpr_group_side *outer = &sides->outer, *inner = &sides->inner;
    const hpr_sums *sums = hpr_sums_of(scratch->isa);
    const size_t outer_points = (size_t)outer->points->count;
    hpr_factors factors;
    bool spreads = spread(e, outer), factored = factors_of(e, inner, &factors);
    for (size_t first = 0; first < outer_points; first += HPR_ROWS) {
        size_t padded = hpr_lanes_padded(lesser(outer_points - first, HPR_ROWS));
        if (factored)
            sums->factored(outer->points, first, inner->points, &factors, scale, scratch->moment,
                           &scratch->moments.sums);
        else
            add_tables(e, sides, first, scale);
        if (!spreads)
            hpr_frame_basis_many(scratch->isa, outer->frame, padded, outer->points->s + first,
                                 outer->points->t + first, HPR_ROWS, scratch->outer_basis,
                                 scratch->moments.recurrences);
        const hpr_row_product product = {.left = by_recv ? scratch->outer_basis : scratch->moment,
                                         .right = by_recv ? scratch->moment : scratch->outer_basis,
                                         .left_stride = HPR_ROWS,
                                         .right_stride = HPR_ROWS,
                                         .left_count = e->n_recv,
                                         .right_count = e->n_send,
                                         .vectors = padded / HPR_LANES};
        sums->rows(&product, scratch->part, &scratch->moments.sums);
    }
}

/* Which side is the outer one: that with fewer points, or the rule's. */
static bool outer_is_recv(const hpr_rule *rule, const hpr_group *group)
{
    if (group->recv.count != group->send.count)
        return group->recv.count < group->send.count;
    if (rule->kind == HPR_RULE_NESTED)
        return rule->nested.recv_is_outer;
    return rule->kind != HPR_RULE_CLIPPED || rule->recv_is_outer;
}

static void add_group(void *user, const hpr_group *group)
{
    hpr_evaluation *e = user;
    bool by_recv = outer_is_recv(e->rule, group);
    const hpr_group_sides sides = hpr_evaluation_sides(e, group, by_recv);
    const double scale = group->scale / 3.14159265358979323846;
    if (!group->recv.count || !group->send.count)
        return;
    hpr_points_pad(&e->scratch->points.recv);
    hpr_points_pad(&e->scratch->points.send);
    if (sides.outer.points->count >= GRID_LEAST && !e->sampled) {
        add_grid(e, &sides, by_recv, scale);
    } else {
        for (int i = 0; i < sides.outer.points->count; i++)
            add_row(e, &sides, by_recv, i, scale);
    }
    e->result->kernel_count += (uint64_t)group->recv.count * (uint64_t)group->send.count;
}

/* part += what the products' moments say of the polynomials. */
static void end_batch(hpr_evaluation *e, bool by_recv)
{
    hpr_block_scratch *scratch = e->scratch;
    hpr_row_batch *batch = &scratch->batch[by_recv];
    const hpr_element_frame *outer = by_recv ? &e->task->recv : &e->task->send,
                            *inner = by_recv ? &e->task->send : &e->task->recv;
    const size_t outer_count = by_recv ? e->n_recv : e->n_send, inner_count = by_recv ? e->n_send : e->n_recv;
    if (batch->count)
        flush(e, outer, inner_count, batch);
    if (!batch->used)
        return;
    batch->used = false;
    const hpr_moment_map *map = map_of(e, inner, by_recv);
    for (size_t l = 0; l < inner_count; l++) {
        double *mapped = scratch->transported;
        const double *row = batch->sum + l * outer_count;
        if (map) {
            hpr_moment_map_row(map, l, batch->sum, outer_count, mapped);
            row = mapped;
        }
        for (size_t k = 0; k < outer_count; k++)
            scratch->part[by_recv ? k * e->n_send + l : l * e->n_send + k] += row[k];
    }
}

static void end_rule(hpr_evaluation *e)
{
    end_batch(e, true);
    end_batch(e, false);
}

const hpr_evaluator hpr_evaluator_fast = {begin, add_group, end_rule};
