#include "solver/proposal.h"

#include "solver/along.h"

#include <math.h>
#include <string.h>

enum { LOWEST = 2 /* degree that tells how coefficients fall */, PARTS = 4, BANDS = HPR_MAX_ORDER + 1 };

typedef struct element {
    hpr_element_frame frame;
    hpr_shape shape;
    int degree;
    const hpr_indicator *indicator;
    double error2;
    bool occluded; /* the scene */
} element;

static bool wants(const element *e, int axis)
{
    static const double part = 0.1; /* of the whole: what an axis may leave out without anything being done */
    return e->indicator->error2[axis] > part * e->error2;
}

/* With (p+1)^2 functions more, halving gains 2^-2(p+1) of the square where H is smooth and little where not,
 * the next degree gains q^2 with 2p+3. Halving along both axes takes as many functions as doubling p+1, which
 * gains q^2(p+1): more, if q < 1/2. Of middle degrees q is still that much too small where H is singular. */
static bool is_smooth(const element *e, int axis)
{
    enum { FEW = 4 /* bands, that tell little */, MANY = 6 };
    static const double smooth = 0.25, smooth_of_few = 0.5;
    bool both = e->shape == HPR_SHAPE_TRIANGLE || (wants(e, 0) && wants(e, 1));
    return e->indicator->ratio[axis] <
           (both && (e->degree < FEW || e->degree >= MANY) ? smooth_of_few : smooth);
}

/* In coefficients: near blocks past obstacles cost about as much whatever their degree. */
static int cost_of(const element *e, int degree)
{
    enum { OPEN = 2, OCCLUDED = 16 };
    return (e->occluded ? OCCLUDED : OPEN) + (int)hpr_basis_count(e->shape, degree);
}

/* Into how many parts an element is halved so, if at all. */
static int count_parts(const uint8_t halve[2])
{
    return (halve[0] ? 2 : 1) * (halve[1] ? 2 : 1);
}

/* The part of the square of what is left out that stays after so many degrees more. */
static double left_by_degrees(const element *e, int axis, int more)
{
    static const double first[LOWEST] = {0.4, 0.2}; /* of a constant, of degree 1: a guess */
    double left = 1;
    for (int degree = e->degree; degree < e->degree + more; degree++)
        left *= degree < LOWEST ? first[degree] : e->indicator->ratio[axis] * e->indicator->ratio[axis];
    return left;
}

/* The same after halving. Like r^lambda from a side, 0.5 < lambda < 1, what is left falls by 2^-(2 lambda+1)
 * in the half at that side and by more in the other. A bisected triangle needs two halvings for that. */
static double left_by_halving(const element *e, int axis)
{
    static const double singular = 0.2;
    double left = is_smooth(e, axis) ? ldexp(1, -2 * (e->degree + 1)) : singular;
    return e->shape == HPR_SHAPE_TRIANGLE ? sqrt(left) : left;
}

static hpr_choice raise_by(const element *e, int more)
{
    hpr_choice c = {.degree = {(uint8_t)(e->degree + more)}, .cost = cost_of(e, e->degree + more)};
    for (int axis = 0; axis < 2; axis++)
        c.error2 += e->indicator->error2[axis] * left_by_degrees(e, axis, more);
    return c;
}

/* The coefficients of a polynomial on one part of the element, both along its axes if it has any. */
static void restrict_to(const element *e, const hpr_two_scale *two_scale, const hpr_choice *c, int part,
                        const double *whole, double *value)
{
    double between[HPR_MAX_BASIS];
    hpr_shape shape = e->shape == HPR_SHAPE_TRIANGLE ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM;
    size_t bytes = hpr_basis_count(shape, e->degree) * sizeof *value;
    hpr_half half = {.shape = shape, .whole_degree = e->degree, .half_degree = e->degree};
    bool both = count_parts(c->halve) == PARTS;
    half.axis = c->halve[0] ? 0 : 1;
    half.which = both ? part / 2 : part;
    memset(value, 0, bytes);
    hpr_two_scale_push(two_scale, &half, whole, value);
    if (!both)
        return;
    memcpy(between, value, bytes);
    half.axis = 1;
    half.which = part % 2;
    memset(value, 0, bytes);
    hpr_two_scale_push(two_scale, &half, between, value);
}

/* Squares of the coefficients of a part by degree: of both axes the larger one, or the total one. */
static void add_bands(const element *e, const double *value, double weight, double square[BANDS])
{
    size_t n = (size_t)e->degree + 1, k = 0;
    if (e->shape != HPR_SHAPE_TRIANGLE) {
        for (size_t a = 0; a < n; a++) {
            for (size_t b = 0; b < n; b++, k++) {
                size_t larger = a > b ? a : b, total = a + b < n ? a + b : n - 1;
                square[e->shape == HPR_SHAPE_PARALLELOGRAM ? larger : total] += weight * value[k] * value[k];
            }
        }
        return;
    }
    for (size_t total = 0; total < n; total++) {
        for (size_t i = 0; i <= total; i++, k++)
            square[total] += weight * value[k] * value[k];
    }
}

/* The lowest degree of a part that loses little. */
static int degree_of_part(const element *e, const double square[BANDS], double allowed)
{
    int degree = e->degree;
    double lost = square[degree];
    while (degree > LOWEST && lost <= allowed)
        lost += square[--degree];
    return degree;
}

static void choose_degrees(const hpr_solution *solution, const element *e, const hpr_two_scale *two_scale,
                           const double *indirect, const double *norm2, size_t leaf, hpr_choice *c)
{
    static const double share = 0.1; /* of what is left out, that low degrees may add */
    const size_t n = solution->channel_count, first = solution->elements->dof[leaf];
    const size_t count = hpr_basis_count(e->shape, e->degree);
    int parts = count_parts(c->halve);
    c->cost = 0;
    for (int part = 0; part < parts; part++) {
        double square[BANDS] = {0}, whole[HPR_MAX_BASIS], value[HPR_MAX_BASIS];
        for (size_t channel = 0; channel < n; channel++) {
            const double *coefficient = indirect + n * first + channel;
            for (size_t k = 0; k < count && e->shape == HPR_SHAPE_TRIANGLE; k++)
                whole[k] = coefficient[n * k];
            if (e->shape != HPR_SHAPE_TRIANGLE)
                hpr_along_axes(&e->frame, coefficient, n, whole);
            restrict_to(e, two_scale, c, part, whole, value);
            add_bands(e, value, norm2[channel] > 0 ? 1 / norm2[channel] : 0, square);
        }
        int degree = degree_of_part(e, square, share * c->error2 / parts);
        c->degree[part] = (uint8_t)degree;
        c->cost += cost_of(e, degree);
    }
    c->error2 *= 1 + share;
}

static hpr_choice halve(const element *e, const uint8_t axis[2])
{
    hpr_choice c = {.halve = {axis[0], axis[1]}};
    int parts = count_parts(axis), degree = e->degree;
    bool triangle = e->shape == HPR_SHAPE_TRIANGLE;
    for (int i = 0; i < 2; i++) {
        double left = axis[i] ? left_by_halving(e, i) : 1;
        c.error2 += e->indicator->error2[i] * (triangle && axis[1] ? left * left : left);
    }
    c.cost = parts * cost_of(e, degree);
    for (int part = 0; part < parts; part++)
        c.degree[part] = (uint8_t)degree;
    return c;
}

typedef struct proposing {
    const hpr_solution *solution;
    const hpr_two_scale *two_scale;
    const double *indirect, *norm2;
    size_t leaf;
    hpr_proposal *proposal;
} proposing;

static void offer(const proposing *p, const hpr_choice *choice)
{
    p->proposal->choice[p->proposal->count++] = *choice;
}

static void offer_degrees(const proposing *p, const element *e, int most)
{
    for (int more = 1; more <= most && e->degree + more <= HPR_MAX_ORDER; more++) {
        hpr_choice c = raise_by(e, more);
        offer(p, &c);
    }
}

/* Where something stands on the element its coefficients are of the open part, and tell nothing of the parts
 * that lower degrees would leave out. */
static void offer_halves(const proposing *p, const element *e, uint8_t first, uint8_t second)
{
    hpr_choice c = halve(e, (const uint8_t[2]){first, second});
    if (p->solution->summary.options.refine == HPR_REFINE_HP && !e->indicator->cut)
        choose_degrees(p->solution, e, p->two_scale, p->indirect, p->norm2, p->leaf, &c);
    offer(p, &c);
}

/* Once and twice. */
static void offer_bisections(const proposing *p, const element *e)
{
    offer_halves(p, e, 1, 0);
    offer_halves(p, e, 1, 1);
}

/* Along the axes that want it, those that are singular or all; of two also along the worse one alone. */
static void offer_axes(const proposing *p, const element *e, bool all)
{
    uint8_t axis[2];
    for (int i = 0; i < 2; i++)
        axis[i] = wants(e, i) && (all || !is_smooth(e, i));
    offer_halves(p, e, axis[0], axis[1]);
    if (axis[0] && axis[1]) {
        int worse = e->indicator->error2[1] > e->indicator->error2[0];
        offer_halves(p, e, worse == 0, worse == 1);
    }
}

/* Where one axis is smooth and the other is not, most may be left out along the smooth one: then halving the
 * other gains next to nothing. */
static void offer_all(const proposing *p, const element *e, bool far)
{
    hpr_refine_mode mode = p->solution->summary.options.refine;
    bool smooth = true, some = false;
    for (int axis = 0; axis < 2; axis++) {
        smooth &= !wants(e, axis) || is_smooth(e, axis);
        some |= wants(e, axis) && is_smooth(e, axis);
    }
    bool raises = mode == HPR_REFINE_P || (mode == HPR_REFINE_HP && (smooth || e->degree < LOWEST));
    if (raises && e->degree < HPR_MAX_ORDER) {
        offer_degrees(p, e, e->degree >= LOWEST ? 2 : far ? 3 : 1);
    } else if (mode != HPR_REFINE_P) {
        if (e->shape == HPR_SHAPE_TRIANGLE)
            offer_bisections(p, e);
        else
            offer_axes(p, e, mode == HPR_REFINE_H || smooth);
        if (mode == HPR_REFINE_HP && some && !smooth) {
            offer_axes(p, e, true);
            offer_degrees(p, e, 1);
        }
    }
}

void hpr_propose(const hpr_solution *solution, const hpr_two_scale *two_scale, const double *indirect,
                 const double *norm2, const hpr_indicator *indicator, size_t leaf, bool far,
                 hpr_proposal *proposal)
{
    const hpr_elements *elements = solution->elements;
    const proposing p = {solution, two_scale, indirect, norm2, leaf, proposal};
    uint32_t node = elements->leaf[leaf];
    const element e = {.frame = hpr_leaf_frame(solution->patches, elements, leaf),
                       .shape = (hpr_shape)solution->patches->shape[elements->patch[node]],
                       .degree = elements->degree[node],
                       .indicator = indicator,
                       .occluded = solution->summary.occluded,
                       .error2 = indicator->error2[0] + indicator->error2[1]};
    proposal->count = 1;
    proposal->choice[0] =
        (hpr_choice){.error2 = e.error2, .cost = cost_of(&e, e.degree), .degree = {(uint8_t)e.degree}};
    if (e.error2 > 0)
        offer_all(&p, &e, far);
}
