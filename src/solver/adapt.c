#include "solver/adapt.h"

#include "basis/basis.h"

#include <math.h>
#include <stdlib.h>

typedef struct decision {
    size_t leaf;
    double error2, gain2; /* what it leaves out, and how much less that will be */
    int added;            /* coefficients */
    bool raise, halve[2];
} decision;

static bool wants(const hpr_indicator *indicator, int axis)
{
    static const double part = 0.1; /* of the whole: what an axis may leave out without anything being done */
    double total = indicator->error2[0] + indicator->error2[1];
    return indicator->error2[axis] > part * total;
}

static int functions(const hpr_solution *solution, size_t leaf, int degree)
{
    uint32_t node = solution->elements->leaf[leaf];
    return (int)hpr_basis_count((hpr_shape)solution->patches->shape[solution->elements->patch[node]], degree);
}

/* Halving pays where it gains more per coefficient than the next degree: with (p+1)^2 functions more the
 * error falls by about 2^-(p+1) where H is smooth and by some 2^-1 where not, with 2p+3 more by q. */
static bool is_smooth(const hpr_indicator *indicator, int axis)
{
    static const double smooth = 0.25;
    return indicator->ratio[axis] < smooth;
}

static decision decide(const hpr_solution *solution, const hpr_indicator *indicator, size_t leaf,
                       hpr_refine_mode mode)
{
    static const double halved2 = 0.2; /* of error2, that is left after halving */
    const hpr_elements *e = solution->elements;
    int degree = e->degree[e->leaf[leaf]];
    decision d = {.leaf = leaf, .error2 = indicator->error2[0] + indicator->error2[1]};
    bool smooth = true;
    for (int axis = 0; axis < 2; axis++)
        smooth &= !wants(indicator, axis) || is_smooth(indicator, axis);
    d.raise = degree < HPR_MAX_ORDER && (mode == HPR_REFINE_P || (mode == HPR_REFINE_HP && smooth));
    int pieces = 1;
    for (int axis = 0; axis < 2; axis++) {
        double q = indicator->ratio[axis];
        d.halve[axis] = !d.raise && mode != HPR_REFINE_P && wants(indicator, axis) &&
                        (mode == HPR_REFINE_H || smooth || !is_smooth(indicator, axis));
        pieces *= d.halve[axis] ? 2 : 1;
        d.gain2 += indicator->error2[axis] * (d.raise ? 1 - q * q : d.halve[axis] ? 1 - halved2 : 0);
    }
    int now = functions(solution, leaf, degree);
    d.added = d.raise ? functions(solution, leaf, degree + 1) - now : (pieces - 1) * now;
    return d;
}

/* Most error first, ties to the lowest leaf. */
static int by_error(const void *a, const void *b)
{
    const decision *x = a, *y = b;
    if (x->error2 != y->error2)
        return x->error2 < y->error2 ? 1 : -1;
    return x->leaf < y->leaf ? -1 : 1;
}

/* How many decisions, in order of their error, are to be carried out. */
static size_t choose_count(const decision *decisions, size_t count, double goal2, double room)
{
    double left2 = 0, added = 0;
    for (size_t i = 0; i < count; i++)
        left2 += decisions[i].error2;
    size_t chosen = 0;
    while (chosen < count && left2 > goal2 && added < room && decisions[chosen].added > 0) {
        left2 -= decisions[chosen].gain2;
        added += decisions[chosen].added;
        chosen++;
    }
    return chosen;
}

typedef struct splitting {
    const hpr_patches *patches;
    const hpr_refinement **of_leaf; /* NULL: stays */
} splitting;

static int choose_axis(void *user, const hpr_piece_of_leaf *piece)
{
    const splitting *s = user;
    const hpr_refinement *d = s->of_leaf[piece->leaf];
    if (!d || d->raise)
        return -1;
    if (s->patches->shape[piece->patch] != HPR_SHAPE_PARALLELOGRAM)
        return piece->depth == 0 ? piece->level % 2 : -1;
    int both = d->halve[0] + d->halve[1];
    if (piece->depth >= both)
        return -1;
    return piece->depth == 0 && d->halve[0] ? 0 : 1;
}

hpr_status hpr_adapt_again(hpr_solution *solution, const hpr_refinement *refinement, size_t count)
{
    hpr_context *ctx = solution->context;
    hpr_elements *e = solution->elements;
    splitting s = {.patches = solution->patches};
    hpr_status status =
        hpr_allocate_into(ctx, &s.of_leaf, e->leaf_count, sizeof *s.of_leaf, "refined elements");
    for (size_t i = 0; status == HPR_OK && i < count; i++) {
        const hpr_refinement *r = refinement + i;
        if (r->leaf >= e->leaf_count || s.of_leaf[r->leaf] ||
            (r->raise && e->degree[e->leaf[r->leaf]] >= HPR_MAX_ORDER)) {
            status = hpr_fail(ctx, HPR_ERR_ARG, "%s: element %u cannot be refined after step %u",
                              solution->scene_name, (unsigned)r->leaf, (unsigned)r->step);
            break;
        }
        s.of_leaf[r->leaf] = r;
        e->degree[e->leaf[r->leaf]] += r->raise != 0;
    }
    if (status == HPR_OK)
        status = hpr_elements_refine(solution->patches, e, choose_axis, &s);
    hpr_release(ctx, s.of_leaf);
    return status;
}

hpr_status hpr_adapt(hpr_solution *solution, const hpr_indicator *indicator, double goal, uint32_t step,
                     hpr_refinements *done)
{
    static const double growth = 1.5; /* coefficients that a step may add, relative to what there are */
    hpr_context *ctx = solution->context;
    size_t count = solution->elements->leaf_count, before = done->count;
    decision *decisions = NULL;
    hpr_status status = hpr_allocate_into(ctx, &decisions, count, sizeof *decisions, "refined elements");
    if (status != HPR_OK)
        return status;
    for (size_t leaf = 0; leaf < count; leaf++)
        decisions[leaf] = decide(solution, &indicator[leaf], leaf, solution->summary.options.refine);
    qsort(decisions, count, sizeof *decisions, by_error);
    size_t chosen = choose_count(decisions, count, goal * goal, growth * (double)solution->summary.dof_count);
    status = hpr_grow(ctx, &done->item, &done->capacity, before + chosen, sizeof *done->item);
    for (size_t i = 0; status == HPR_OK && i < chosen; i++) {
        const decision *d = decisions + i;
        done->item[done->count++] = (hpr_refinement){
            .step = step, .leaf = (uint32_t)d->leaf, .raise = d->raise, .halve = {d->halve[0], d->halve[1]}};
    }
    if (status == HPR_OK && chosen)
        status = hpr_adapt_again(solution, done->item + before, chosen);
    hpr_release(ctx, decisions);
    return status;
}
