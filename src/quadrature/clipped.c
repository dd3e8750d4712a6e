/*
 * The rule for pairs that see each other partly: an outer integral over one polygon of the inner integral
 * over what a point sees of the other. The inner integral of a constant, Lambert's formula on the visible
 * part, is a continuous function of the outer point, analytic between the event lines on which the view
 * changes its kind (a corner of the inner polygon or of a blocker seen on an edge of the other: EV events,
 * Gigus & Malik 1990). At tight tolerances the outer polygon is cut along these lines; then boxes are halved
 * until the integrals of the constant and of the two linear functions are resolved.
 */
#include "quadrature/cuts.h"
#include "quadrature/events.h"
#include "quadrature/rule.h"

#include <string.h>

/* MAX_BOXES bounds the effort for one pair: about a second. */
enum { MAX_DEPTH = 40, MAX_BOXES = 8000, MOMENTS = 3 };

typedef struct clipped {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_element_frame *outer, *inner;
    hpr_convex outline; /* the inner polygon in space */
    hpr_rule rule;      /* all but cell and box */
    int nodes;          /* along each axis of a box */
    double allowed;     /* absolute error of a box */
    int box_count;
    hpr_clipped_outcome outcome;
    hpr_rule_sink sink;
    void *user;
} clipped;

typedef struct moments {
    double of[MOMENTS]; /* 1, 2s-1, 2t-1 */
} moments;

static moments box_moments(clipped *c, const hpr_cell *cell, const hpr_box *box)
{
    moments sum = {{0}};
    bool complete = true;
    c->box_count++;
    for (int k = 0; k < c->nodes * c->nodes; k++) {
        hpr_outer_point x = hpr_outer_at(c->gauss, c->outer, cell, box, c->nodes, k);
        double value =
            x.weight * hpr_inner_fraction(c->pair, c->outer, c->inner, &c->outline, x.position, &complete);
        sum.of[0] += value;
        sum.of[1] += value * (2 * x.s - 1);
        sum.of[2] += value * (2 * x.t - 1);
    }
    c->outcome.complete &= complete;
    c->outcome.clip_count += (uint64_t)(c->nodes * c->nodes);
    return sum;
}

static double difference(const moments *whole, const moments half[2])
{
    double worst = 0;
    for (int i = 0; i < MOMENTS; i++)
        worst = fmax(worst, fabs(whole->of[i] - half[0].of[i] - half[1].of[i]));
    return worst;
}

static void refine(clipped *c, const hpr_cell *cell, const hpr_box *box, const moments *whole, int depth)
{
    hpr_box half[2][2];
    moments part[2][2];
    double error[2];
    for (int axis = 0; axis < 2; axis++) {
        hpr_box_halve(box, axis, half[axis]);
        for (int which = 0; which < 2; which++)
            part[axis][which] = box_moments(c, cell, &half[axis][which]);
        error[axis] = difference(whole, part[axis]);
    }
    int axis = error[1] > error[0];
    bool stop = depth >= MAX_DEPTH || c->box_count > MAX_BOXES;
    if (error[axis] <= c->allowed || stop) {
        c->outcome.complete &= error[axis] <= c->allowed;
        c->outcome.error += error[axis];
        *(c->rule.recv_is_outer ? &c->rule.recv : &c->rule.send) = *cell;
        c->rule.box = *box;
        if (whole->of[0] > 0 || part[0][0].of[0] > 0 || part[0][1].of[0] > 0)
            c->sink(c->user, &c->rule);
        return;
    }
    for (int which = 0; which < 2; which++)
        refine(c, cell, &half[axis][which], &part[axis][which], depth + 1);
}

static void set_rule(clipped *c, bool recv_is_outer, const hpr_polygon *inner, double tolerance)
{
    static const double loose = 1e-4, medium = 1e-7;
    c->nodes = tolerance >= loose ? 3 : tolerance >= medium ? 5 : 8;
    int nodes = c->nodes + hpr_polynomial_nodes(hpr_total_degree(c->outer), tolerance);
    nodes = nodes < HPR_NODES_MAX ? nodes : HPR_NODES_MAX;
    c->rule = (hpr_rule){.kind = HPR_RULE_CLIPPED,
                         .recv_is_outer = recv_is_outer,
                         .inner = *inner,
                         .inner_degree = hpr_total_degree(c->inner),
                         .error = hpr_total_degree(c->inner) ? tolerance : 0,
                         .tolerance = tolerance};
    int *outer_nodes = recv_is_outer ? c->rule.recv_nodes : c->rule.send_nodes;
    outer_nodes[0] = outer_nodes[1] = nodes;
}

static double frame_area(const hpr_element_frame *frame, const hpr_polygon *polygon)
{
    return hpr_polygon_area(polygon) * hpr_frame_jacobian(frame);
}

/* The constant side is the inner one, where the closed form serves; else the larger. */
static bool outer_is_recv(const hpr_pair *pair, const hpr_polygon *recv, const hpr_polygon *send)
{
    bool recv_constant = pair->recv.degree == 0, send_constant = pair->send.degree == 0;
    if (recv_constant != send_constant)
        return send_constant;
    return frame_area(&pair->recv, recv) <= frame_area(&pair->send, send);
}

hpr_clipped_outcome hpr_clipped_choose(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                       const hpr_polygon *recv, const hpr_polygon *send,
                                       const hpr_clipped_demand *demand, hpr_rule_sink sink, void *user)
{
    /* Errors of the boxes have either sign, most are far below their share. */
    static const double box_share = 0.02, tight = 1e-4, tightest = 1e-7, rounding = 1e-15;
    enum { FEW_LINES = 24 };
    const hpr_box whole_box = hpr_box_unit();
    bool recv_is_outer = outer_is_recv(pair, recv, send);
    const hpr_polygon *outer = recv_is_outer ? recv : send, *inner = recv_is_outer ? send : recv;
    clipped c = {.gauss = gauss,
                 .pair = pair,
                 .outer = recv_is_outer ? &pair->recv : &pair->send,
                 .inner = recv_is_outer ? &pair->send : &pair->recv,
                 .outcome = {.complete = true},
                 .sink = sink,
                 .user = user};
    set_rule(&c, recv_is_outer, inner, demand->tolerance);
    c.outline.count = inner->count;
    for (int i = 0; i < inner->count; i++)
        c.outline.corner[i] = hpr_frame_point(c.inner, inner->corner[i][0], inner->corner[i][1]);
    hpr_cuts pieces;
    hpr_cuts_init(&pieces, outer);
    if (demand->tolerance < tight) {
        hpr_events events;
        hpr_events_find(pair, c.outer, outer, &c.outline, c.inner->normal, &events);
        /* Many lines make more cells than a loose tolerance needs, halving alone never meets a tight one. */
        bool cut = demand->tolerance < tightest || events.count <= FEW_LINES;
        for (int i = 0; i < events.count && cut; i++)
            hpr_cuts_along(&pieces, &events.line[i]);
    }
    moments whole[HPR_MAX_CUTS][HPR_POLYGON_MAX];
    double total = 0;
    hpr_cell cell[HPR_POLYGON_MAX];
    for (int p = 0; p < pieces.count; p++) {
        int count = hpr_cuts_cells(c.outer->shape, &pieces.piece[p], cell);
        for (int i = 0; i < count; i++) {
            whole[p][i] = box_moments(&c, &cell[i], &whole_box);
            total += whole[p][i].of[0];
        }
    }
    /* From the dimensionless block to the integral over the outer parameters. */
    double per_block = sqrt(c.inner->area_m2 / c.outer->area_m2) * hpr_frame_measure(c.outer);
    c.allowed = box_share * fmax(fmax(demand->tolerance * total, demand->negligible * per_block),
                                 rounding / box_share * total);
    for (int p = 0; p < pieces.count; p++) {
        int count = hpr_cuts_cells(c.outer->shape, &pieces.piece[p], cell);
        for (int i = 0; i < count; i++)
            refine(&c, &cell[i], &whole_box, &whole[p][i], 0);
    }
    c.outcome.error /= per_block;
    return c.outcome;
}
