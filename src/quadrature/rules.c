/* Which rule for which pair of pieces: product Gauss by an error bound, vertex and edge rules by trial. */
#include "quadrature/contact.h"
#include "quadrature/homothety.h"
#include "quadrature/rule.h"

#include <float.h>
#include <string.h>

enum { MAX_DEPTH = 60, MAX_TOUCHING_DEPTH = 40, MAX_RULES = 20000 };

typedef struct chooser {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_rule_demand *demand;
    double tolerance; /* relative, with what is negligible taken into account */
    hpr_group *group;
    hpr_rule_sink sink;
    void *user;
    int kernel_cap; /* product: more nodes than this for the kernel, and the larger cell is halved */
    int rule_count;
    const double *budget, *budget_used; /* kernels, NULL: any number */
    hpr_rule_outcome outcome;
} chooser;

int hpr_kernel_nodes(double length, double distance, double tolerance)
{
    double b = 2 * distance / length, rho = b + sqrt(b * b + 1);
    double n = log(64 / tolerance) / (2 * log(rho));
    return n < 1 ? 1 : n > 1000 ? 1000 : (int)ceil(n);
}

double hpr_kernel_error(double length, double distance, int nodes)
{
    double b = 2 * distance / length;
    return 64 * pow(b + sqrt(b * b + 1), -2.0 * nodes);
}

typedef struct extent {
    double length[2];
} extent;

static extent cell_extent(const hpr_element_frame *frame, const hpr_cell *cell)
{
    double l1 = hpr_length(hpr_frame_vector(frame, cell->edge1));
    double l2 = hpr_length(hpr_frame_vector(frame, cell->edge2));
    if (cell->shape == HPR_SHAPE_TRIANGLE) {
        double across[2] = {cell->edge2[0] - cell->edge1[0], cell->edge2[1] - cell->edge1[1]};
        double l3 = hpr_length(hpr_frame_vector(frame, across));
        /* Collapsed coordinates: along the first axis lines parallel to edge1, along the second any ray to
         * vertex 2. */
        l2 = fmax(l2, l3);
    }
    return (extent){{l1, l2}};
}

/* Halves a parallelogram along an axis, a triangle across its longest edge. */
static void halve(const hpr_element_frame *frame, const hpr_cell *cell, int axis, hpr_cell half[2])
{
    if (cell->shape == HPR_SHAPE_PARALLELOGRAM) {
        half[0] = *cell;
        double *edge = axis == 0 ? half[0].edge1 : half[0].edge2;
        edge[0] /= 2;
        edge[1] /= 2;
        half[1] = half[0];
        half[1].origin[0] += edge[0];
        half[1].origin[1] += edge[1];
        return;
    }
    double p[3][2];
    hpr_vec3 x[3];
    for (int i = 0; i < 3; i++) {
        for (int a = 0; a < 2; a++)
            p[i][a] = cell->origin[a] + (i == 1 ? cell->edge1[a] : i == 2 ? cell->edge2[a] : 0);
        x[i] = hpr_frame_point(frame, p[i][0], p[i][1]);
    }
    int longest = 0;
    double best = 0;
    for (int i = 0; i < 3; i++) {
        double length = hpr_length(hpr_sub(x[(i + 1) % 3], x[i]));
        if (length > best) {
            best = length;
            longest = i;
        }
    }
    int i = longest, j = (i + 1) % 3, k = (i + 2) % 3;
    double middle[2] = {(p[i][0] + p[j][0]) / 2, (p[i][1] + p[j][1]) / 2};
    half[0] = hpr_cell_triangle(middle, p[k], p[i]);
    half[1] = hpr_cell_triangle(middle, p[j], p[k]);
}

static void emit(chooser *c, const hpr_rule *rule)
{
    c->rule_count++;
    c->sink(c->user, rule);
}

static int clamp_nodes(chooser *c, int nodes, int least)
{
    if (nodes < least)
        nodes = least;
    if (nodes > HPR_NODES_MAX) {
        c->outcome.stopped_short = true;
        nodes = HPR_NODES_MAX;
    }
    return nodes;
}

/* Whether the height over the other's plane counts as a polynomial of degree 1: the bound on the kernel is
 * relative to its largest value in the cell. */
static bool height_varies(const hpr_affine *height, const hpr_cell *cell)
{
    double first = hpr_affine_at(height, cell->origin[0], cell->origin[1]);
    double along1 = cell->edge1[0] * height->along1 + cell->edge1[1] * height->along2;
    double along2 = cell->edge2[0] * height->along1 + cell->edge2[1] * height->along2;
    double low = first + fmin(along1, 0) + fmin(along2, 0), high = first + fmax(along1, 0) + fmax(along2, 0);
    return low < 0.5 * high;
}

static void count_product(void *user, const hpr_rule *rule)
{
    double *kernels = user;
    *kernels += (double)(rule->recv_nodes[0] * rule->recv_nodes[1]) * (rule->send_nodes[0] * rule->send_nodes[1]);
}

static void separate(chooser *c, const hpr_cell *recv, const hpr_cell *send, int depth)
{
    hpr_vec3 a[4], b[4];
    int na = hpr_cell_corners(&c->pair->recv, recv, a), nb = hpr_cell_corners(&c->pair->send, send, b);
    double distance = hpr_polygon_distance(a, na, b, nb);
    extent ea = cell_extent(&c->pair->recv, recv), eb = cell_extent(&c->pair->send, send);
    double length[4] = {ea.length[0], ea.length[1], eb.length[0], eb.length[1]};
    int nodes[4], longest = 0;
    for (int i = 0; i < 4; i++) {
        nodes[i] = hpr_kernel_nodes(length[i], distance, c->tolerance);
        if (length[i] > length[longest])
            longest = i;
    }
    bool stop = depth >= MAX_DEPTH || c->rule_count >= MAX_RULES;
    if (c->budget && *c->budget_used >= *c->budget)
        return;
    if (nodes[longest] > c->kernel_cap && !stop) {
        hpr_cell half[2];
        halve(longest < 2 ? &c->pair->recv : &c->pair->send, longest < 2 ? recv : send, longest % 2, half);
        for (int i = 0; i < 2; i++)
            separate(c, longest < 2 ? &half[i] : recv, longest < 2 ? send : &half[i], depth + 1);
        return;
    }
    c->outcome.stopped_short |= nodes[longest] > c->kernel_cap;
    const int varies[2] = {height_varies(&c->pair->recv_height, recv),
                           height_varies(&c->pair->send_height, send)};
    hpr_rule rule = {.kind = HPR_RULE_PRODUCT, .recv = *recv, .send = *send};
    for (int i = 0; i < 4; i++) {
        const hpr_element_frame *frame = i < 2 ? &c->pair->recv : &c->pair->send;
        bool triangle = (i < 2 ? recv : send)->shape == HPR_SHAPE_TRIANGLE;
        int degree = (triangle ? hpr_total_degree(frame) : frame->degree) + varies[i / 2];
        int kernel = nodes[i] < c->kernel_cap ? nodes[i] : c->kernel_cap;
        int n = clamp_nodes(c, kernel + (degree + 1) / 2, c->demand->least_nodes);
        *(i < 2 ? &rule.recv_nodes[i] : &rule.send_nodes[i - 2]) = n;
        rule.error += hpr_kernel_error(length[i], distance, kernel);
    }
    emit(c, &rule);
}

typedef struct kernel_sum {
    double sum;
    uint64_t count;
} kernel_sum;

static void add_kernel_sum(void *user, const hpr_group *group)
{
    kernel_sum *total = user;
    total->sum += hpr_group_sum(group);
    total->count += (uint64_t)group->recv.count * (uint64_t)group->send.count;
}

static int term_count(const hpr_rule *rule)
{
    return rule->kind == HPR_RULE_EDGE ? HPR_EDGE_TERMS : HPR_VERTEX_TERMS;
}

/* The kernel's integral over the rule's term and box, all polynomials 1. */
static double kernel_integral(chooser *c, const hpr_rule *rule)
{
    kernel_sum total = {0};
    hpr_rule_points(c->gauss, c->pair, rule, c->group, add_kernel_sum, &total);
    c->outcome.kernel_count += total.count;
    return total.sum;
}

/* Nodes are added for the polynomials; where they vary alone, the number that is exact for them is taken. */
static void emit_touching(chooser *c, const hpr_rule *kernel_rule)
{
    hpr_rule rule = *kernel_rule;
    int degree = hpr_total_degree(&c->pair->recv) + hpr_total_degree(&c->pair->send);
    rule.kernel_nodes = clamp_nodes(c, rule.kernel_nodes + (degree + 1) / 2, 1);
    rule.scale_nodes = clamp_nodes(c, (degree + 3) / 2, 1);
    emit(c, &rule);
}

/* One box of a term: emitted if its halves along every axis agree with it, else halved where they agree
 * least. */
static void refine_touching(chooser *c, hpr_rule rule, double whole, double allowed, int depth)
{
    enum { AXES = HPR_VERTEX_AXES };
    int axes = rule.kind == HPR_RULE_EDGE ? HPR_EDGE_AXES : HPR_VERTEX_AXES, worst = 0;
    hpr_box box = rule.box, half[AXES][2];
    double part[AXES][2], error[AXES];
    for (int axis = 0; axis < axes; axis++) {
        hpr_box_halve(&box, axis, half[axis]);
        for (int which = 0; which < 2; which++) {
            rule.box = half[axis][which];
            part[axis][which] = kernel_integral(c, &rule);
        }
        error[axis] = fabs(whole - part[axis][0] - part[axis][1]);
        worst = error[axis] > error[worst] ? axis : worst;
    }
    rule.box = box;
    bool stop = depth >= MAX_TOUCHING_DEPTH || c->rule_count >= MAX_RULES;
    if (error[worst] <= allowed || stop) {
        c->outcome.stopped_short |= error[worst] > allowed;
        emit_touching(c, &rule);
        return;
    }
    for (int which = 0; which < 2; which++) {
        rule.box = half[worst][which];
        refine_touching(c, rule, part[worst][which], allowed, depth + 1);
    }
}

/*
 * The number of nodes for a touching pair: the kernel alone is integrated with rising numbers of nodes until
 * two agree. 0 if that converges too slowly, as at small angles and for slender wings. *total: the integral.
 */
static int trial_nodes(chooser *c, hpr_rule rule, double *total)
{
    static const int trial[] = {2, 3, 4, 6, 8, 10, 12, 15, 19, 24, 30};
    /* Boxes cost their nodes for the polynomials each, so that at high degree one large box wins for longer.
     */
    enum { HALF_WAY = 10, LOW_DEGREE = 8 };
    int degree = hpr_total_degree(&c->pair->recv) + hpr_total_degree(&c->pair->send);
    double before = 0;
    rule.scale_nodes = 1;
    rule.box = hpr_box_unit();
    for (size_t i = 0; i < sizeof trial / sizeof *trial; i++) {
        rule.kernel_nodes = trial[i];
        *total = 0;
        for (rule.term = 0; rule.term < term_count(&rule); rule.term++)
            *total += kernel_integral(c, &rule);
        double change = fabs(*total - before);
        if (i > 0 && change <= c->tolerance * *total)
            return trial[i];
        if (trial[i] == HALF_WAY && degree <= LOW_DEGREE && change > sqrt(c->tolerance) * *total)
            return 0;
        before = *total;
    }
    return 0;
}

/* A touching pair with the nodes that the trial found, or in boxes: the kernel's variables are two or three
 * whatever the polynomials are, so that cutting them adaptively is cheap. */
static void touching(chooser *c, hpr_rule rule, int nodes, double total)
{
    static const double box_share = 0.01, rounding = 1e-15;
    enum { BOX_NODES = 8 };
    double allowed = fmax(box_share * c->tolerance, rounding) * total;
    rule.box = hpr_box_unit();
    rule.scale_nodes = 1;
    rule.kernel_nodes = nodes ? nodes : BOX_NODES;
    for (rule.term = 0; rule.term < term_count(&rule); rule.term++) {
        if (nodes)
            emit_touching(c, &rule);
        else
            refine_touching(c, rule, kernel_integral(c, &rule), allowed, 0);
    }
}

/* The piece with its contact point `touch` as vertex 0. */
static hpr_cell turned_to(const hpr_piece *piece, hpr_touch touch)
{
    if (piece->touch != HPR_TOUCH_EDGE || touch == HPR_TOUCH_FIRST)
        return piece->cell;
    const hpr_cell *cell = &piece->cell;
    double p0[2] = {cell->origin[0] + cell->edge1[0], cell->origin[1] + cell->edge1[1]};
    double p1[2] = {cell->origin[0] + cell->edge2[0], cell->origin[1] + cell->edge2[1]};
    return hpr_cell_triangle(p0, p1, cell->origin);
}

/* The vertex or edge rule for two pieces; false if they do not touch. */
static bool touching_rule(const hpr_piece *a, const hpr_piece *b, hpr_rule *rule)
{
    if (a->touch == HPR_TOUCH_EDGE && b->touch == HPR_TOUCH_EDGE) {
        *rule = (hpr_rule){.kind = HPR_RULE_EDGE, .recv = a->cell, .send = b->cell};
        return true;
    }
    hpr_touch touch = a->touch == HPR_TOUCH_EDGE ? b->touch : a->touch;
    if (touch == HPR_TOUCH_NONE || (b->touch != touch && b->touch != HPR_TOUCH_EDGE))
        return false;
    *rule = (hpr_rule){.kind = HPR_RULE_VERTEX, .recv = turned_to(a, touch), .send = turned_to(b, touch)};
    return true;
}

static bool constants(const chooser *c)
{
    return c->pair->recv.degree == 0 && c->pair->send.degree == 0;
}

enum { MAX_PAIRS = HPR_PIECES_MAX * HPR_PIECES_MAX };

/* Rules for all pairs of pieces. False, and nothing emitted, if the nested rule serves better: constants in a
 * configuration in which the touching rules converge slowly. */
static bool emit_pieces(chooser *c, const hpr_contact *contact)
{
    hpr_rule rule[MAX_PAIRS];
    int nodes[MAX_PAIRS], count = contact->recv_count * contact->send_count;
    double total[MAX_PAIRS];
    bool sampled = c->demand->least_nodes > 1;
    for (int i = 0; i < count; i++) {
        const hpr_piece *a = &contact->recv[i / contact->send_count],
                        *b = &contact->send[i % contact->send_count];
        nodes[i] = touching_rule(a, b, &rule[i]) ? trial_nodes(c, rule[i], &total[i]) : -1;
        if (nodes[i] == 0 && constants(c) && !sampled)
            return false;
    }
    for (int i = 0; i < count; i++) {
        if (nodes[i] >= 0)
            touching(c, rule[i], nodes[i], total[i]);
        else
            separate(c, &contact->recv[i / contact->send_count].cell,
                     &contact->send[i % contact->send_count].cell, 0);
    }
    return true;
}

static void clipped(chooser *c, const hpr_contact *contact)
{
    const hpr_clipped_demand demand = {c->demand->tolerance, c->demand->negligible};
    hpr_clipped_outcome outcome = hpr_clipped_choose(c->gauss, c->pair, &contact->recv_front,
                                                     &contact->send_front, &demand, c->sink, c->user);
    c->outcome.stopped_short |= !outcome.complete;
    c->outcome.clip_count += outcome.clip_count;
    c->outcome.error += outcome.error;
}

/* Kernels that the product rules of a separate pair would need, counted up to a limit. */
static double product_cost(const chooser *c, const hpr_contact *contact, double limit)
{
    double kernels = 0;
    chooser trial = *c;
    trial.sink = count_product;
    trial.user = &kernels;
    trial.budget = &limit;
    trial.budget_used = &kernels;
    emit_pieces(&trial, contact);
    return trial.outcome.stopped_short ? limit : kernels;
}

static void reduce(chooser *c, const hpr_homothety *homothety, double tolerance)
{
    c->outcome.centre_count = homothety->centre_count;
    memcpy(c->outcome.centre, homothety->centre, sizeof c->outcome.centre);
    c->outcome.stopped_short |=
        !hpr_homothety_choose(c->gauss, c->pair, homothety, tolerance, c->sink, c->user);
}

/* Pairs that do not touch: product rules where those are cheap, a homothety where it loses nothing, else the
 * nested rule. The limits in kernels are where their times are about equal, measured. */
static void near_or_far(chooser *c, const hpr_contact *contact)
{
    static const double loss = 1e-14, rounding = 1e-15;
    double cheap = constants(c) ? 1e5 : 2e6, dear = constants(c) ? 5e5 : 3e7, condition;
    double cost = product_cost(c, contact, dear);
    if (cost > cheap) {
        hpr_homothety apart = hpr_homothety_apart(c->gauss, c->pair, contact, c->group, &condition);
        if (condition * loss < c->tolerance) {
            reduce(c, &apart, fmax(c->tolerance / condition, rounding));
            return;
        }
    }
    if (cost < dear)
        emit_pieces(c, contact);
    else
        c->outcome.stopped_short |= !hpr_nested_choose(c->gauss, c->pair, &contact->recv_front,
                                                       &contact->send_front, c->tolerance, c->sink, c->user);
}

/* Length of a side over the height of its front: by so much rounding of the coordinates grows in the heights. */
static double flatness(const hpr_element_frame *frame, const hpr_affine *height, const hpr_polygon *front)
{
    double highest = 0;
    for (int i = 0; i < front->count; i++)
        highest = fmax(highest, hpr_affine_at(height, front->corner[i][0], front->corner[i][1]));
    return fmax(hpr_length(frame->edge1), hpr_length(frame->edge2)) / highest;
}

static void integrate(chooser *c, const hpr_cell *recv, const hpr_cell *send)
{
    hpr_contact contact;
    hpr_contact_find(c->pair, recv, send, c->demand->contact_m, &contact);
    c->outcome.seen = contact.kind != HPR_CONTACT_HIDDEN;
    if (!c->outcome.seen)
        return;
    c->outcome.rounding = DBL_EPSILON * (4 + flatness(&c->pair->recv, &c->pair->recv_height, &contact.recv_front) +
                                         flatness(&c->pair->send, &c->pair->send_height, &contact.send_front));
    bool sampled = c->demand->least_nodes > 1, separate = contact.kind == HPR_CONTACT_SEPARATE;
    if (c->pair->blocker_count) {
        clipped(c, &contact);
        return;
    }
    if (sampled) {
        emit_pieces(c, &contact);
        return;
    }
    if (!separate) {
        hpr_homothety touching = hpr_homothety_touching(&contact);
        reduce(c, &touching, c->tolerance);
        return;
    }
    near_or_far(c, &contact);
}

int hpr_total_degree(const hpr_element_frame *frame)
{
    return frame->shape == HPR_SHAPE_PARALLELOGRAM ? 2 * frame->degree : frame->degree;
}

static double largest_height(const hpr_affine *height, hpr_shape shape)
{
    double a = height->at_origin, b = a + height->along1, c = a + height->along2;
    double d = shape == HPR_SHAPE_PARALLELOGRAM ? b + height->along2 : a;
    return fmax(fmax(fmax(a, b), fmax(c, d)), 0);
}

/*
 * The tolerance that applies: relative, or what is negligible next to the bound
 * K^00 <= sqrt(A_r A_s) max G, G = h_r h_s / (pi r^4).
 */
static double tolerance_of(const hpr_pair *pair, const hpr_cell *recv, const hpr_cell *send,
                           const hpr_rule_demand *demand)
{
    static const double loosest = 1e-2;
    hpr_vec3 a[4], b[4];
    int na = hpr_cell_corners(&pair->recv, recv, a), nb = hpr_cell_corners(&pair->send, send, b);
    double r2 = pow(hpr_polygon_distance(a, na, b, nb), 2);
    double heights = largest_height(&pair->recv_height, pair->recv.shape) *
                     largest_height(&pair->send_height, pair->send.shape);
    double numerator = heights * sqrt(pair->recv.area_m2 * pair->send.area_m2);
    double allowed = demand->negligible * (3.14159265358979323846 * r2 * r2);
    return fmax(demand->tolerance, fmin(loosest, numerator > 0 ? allowed / numerator : loosest));
}

hpr_rule_outcome hpr_rules_choose(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                  const hpr_rule_demand *demand, hpr_group *group, hpr_rule_sink sink,
                                  void *user)
{
    static const double share = 0.7; /* a rule errs along several axes */
    chooser c = {.gauss = gauss, .pair = pair, .demand = demand, .group = group, .sink = sink, .user = user};
    hpr_cell recv = hpr_cell_whole(pair->recv.shape), send = hpr_cell_whole(pair->send.shape);
    c.tolerance = share * tolerance_of(pair, &recv, &send, demand);
    /* Cells about as large as their distance cost least at low degree; at high degree the polynomials' own
     * nodes pay for larger ones. */
    int degree = pair->recv.degree > pair->send.degree ? pair->recv.degree : pair->send.degree;
    c.kernel_cap = hpr_kernel_nodes(1, degree < 4 ? 1 : 0.5, c.tolerance);
    integrate(&c, &recv, &send);
    return c.outcome;
}
