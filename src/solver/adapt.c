#include "solver/adapt.h"

#include "solver/proposal.h"

#include <math.h>

/* For each leaf the choice that makes error2 + price functions least; false if that changes nothing. */
typedef struct total {
    double error2, functions;
    size_t changed;
} total;

static int choose(const hpr_proposal *p, double price)
{
    int best = 0;
    double least = INFINITY;
    for (int k = 0; k < p->count; k++) {
        double cost = p->choice[k].error2 + price * p->choice[k].cost;
        if (cost < least) {
            least = cost;
            best = k;
        }
    }
    return best;
}

static total choose_all(const hpr_proposal *proposal, size_t count, double price)
{
    total sum = {0};
    for (size_t i = 0; i < count; i++) {
        int k = choose(&proposal[i], price);
        sum.error2 += proposal[i].choice[k].error2;
        sum.functions += proposal[i].choice[k].cost;
        sum.changed += k > 0;
    }
    return sum;
}

/*
 * The highest price of a coefficient, in error2, at which the sum of error2 comes down to what it should, or
 * if it cannot, near to what it can: so all elements gain as much for a coefficient, which is what makes the
 * sum least (Lagrange).
 */
static double find_price(const hpr_proposal *proposal, size_t count, double goal2)
{
    enum { HALVINGS = 60 };
    static const double near = 1.2, growth = 3, few = 60;
    total now = choose_all(proposal, count, INFINITY), least = choose_all(proposal, count, 0);
    double target2 = fmax(goal2, near * least.error2), room = growth * now.functions + few;
    double low = -40, high = 2; /* decimal logarithms */
    if (target2 >= now.error2)
        target2 = sqrt(now.error2 * least.error2);
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (low + high);
        total sum = choose_all(proposal, count, pow(10, middle));
        bool enough = sum.error2 <= target2 || sum.functions > room;
        low = enough ? middle : low;
        high = enough ? high : middle;
    }
    return pow(10, low);
}

static hpr_status propose_all(const hpr_solution *solution, const hpr_estimate *estimate, double goal,
                              hpr_proposal *proposal)
{
    static const double distant = 10;
    bool far = estimate->indicated > distant * goal;
    hpr_two_scale *two_scale = NULL;
    hpr_status status = hpr_two_scale_create(solution->context, HPR_MAX_ORDER, &two_scale);
    for (size_t leaf = 0; status == HPR_OK && leaf < solution->elements->leaf_count; leaf++)
        hpr_propose(solution, two_scale, estimate->indirect, estimate->norm2, &estimate->indicator[leaf],
                    leaf, far, &proposal[leaf]);
    hpr_two_scale_destroy(&two_scale);
    return status;
}

typedef struct splitting {
    const hpr_patches *patches;
    const hpr_refinement **of_leaf; /* NULL: stays */
} splitting;

static int choose_axis(void *user, const hpr_piece_of_leaf *piece)
{
    const splitting *s = user;
    const hpr_refinement *d = s->of_leaf[piece->leaf];
    if (!d || (!d->halve[0] && !d->halve[1]))
        return -1;
    int both = d->halve[0] + d->halve[1];
    if (piece->depth >= both)
        return -1;
    if (s->patches->shape[piece->patch] == HPR_SHAPE_TRIANGLE)
        return piece->level % 2;
    return piece->depth == 0 && d->halve[0] ? 0 : 1;
}

/* Degrees of what has taken the place of a node. */
static void set_degrees(hpr_elements *e, uint32_t node, const uint8_t **degree)
{
    uint32_t child = e->child[node];
    if (child == HPR_NONE) {
        e->degree[node] = *(*degree)++;
        return;
    }
    set_degrees(e, child, degree);
    set_degrees(e, child + 1, degree);
}

static bool fits(const hpr_elements *e, const hpr_refinement *r, const splitting *s)
{
    if (r->leaf >= e->leaf_count || s->of_leaf[r->leaf] || r->halve[0] > 1 || r->halve[1] > 1)
        return false;
    bool good = true;
    for (int i = 0; i < 4; i++)
        good &= r->degree[i] <= HPR_MAX_ORDER;
    return good;
}

hpr_status hpr_adapt_again(hpr_solution *solution, const hpr_refinement *refinement, size_t count)
{
    hpr_context *ctx = solution->context;
    hpr_elements *e = solution->elements;
    splitting s = {.patches = solution->patches};
    uint32_t *node = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &s.of_leaf, e->leaf_count, sizeof *s.of_leaf, "refined elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &node, count, sizeof *node, "refined elements");
    for (size_t i = 0; status == HPR_OK && i < count; i++) {
        const hpr_refinement *r = refinement + i;
        if (!fits(e, r, &s)) {
            status = hpr_fail(ctx, HPR_ERR_ARG, "%s: element %u cannot be refined after step %u",
                              solution->scene_name, (unsigned)r->leaf, (unsigned)r->step);
            break;
        }
        s.of_leaf[r->leaf] = r;
        node[i] = e->leaf[r->leaf];
    }
    if (status == HPR_OK)
        status = hpr_elements_refine(solution->patches, e, choose_axis, &s);
    for (size_t i = 0; status == HPR_OK && i < count; i++) {
        const uint8_t *degree = refinement[i].degree;
        set_degrees(e, node[i], &degree);
    }
    if (status == HPR_OK)
        status = hpr_elements_index(solution->patches, e);
    hpr_release(ctx, node);
    hpr_release(ctx, s.of_leaf);
    return status;
}

hpr_status hpr_adapt(hpr_solution *solution, const hpr_estimate *estimate, double goal, uint32_t step,
                     hpr_refinements *done)
{
    hpr_context *ctx = solution->context;
    size_t count = solution->elements->leaf_count, before = done->count;
    hpr_proposal *proposal = NULL;
    hpr_status status = hpr_allocate_into(ctx, &proposal, count, sizeof *proposal, "refined elements");
    if (status == HPR_OK)
        status = propose_all(solution, estimate, goal, proposal);
    if (status == HPR_OK)
        status = hpr_grow(ctx, &done->item, &done->capacity, before + count, sizeof *done->item);
    double price = status == HPR_OK ? find_price(proposal, count, goal * goal) : 0;
    for (size_t leaf = 0; status == HPR_OK && leaf < count; leaf++) {
        int k = choose(&proposal[leaf], price);
        const hpr_choice *c = &proposal[leaf].choice[k];
        if (k == 0)
            continue;
        done->item[done->count++] =
            (hpr_refinement){.step = step,
                             .leaf = (uint32_t)leaf,
                             .halve = {c->halve[0], c->halve[1]},
                             .degree = {c->degree[0], c->degree[1], c->degree[2], c->degree[3]}};
    }
    if (status == HPR_OK && done->count > before)
        status = hpr_adapt_again(solution, done->item + before, done->count - before);
    hpr_release(ctx, proposal);
    return status;
}
