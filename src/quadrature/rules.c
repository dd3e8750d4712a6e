/* Which rule for which pair: homotheties where it touches, product Gauss where it is far, between them
 * whichever is cheapest. */
#include "quadrature/aligned.h"
#include "quadrature/contact.h"
#include "quadrature/cuts.h"
#include "quadrature/homothety.h"
#include "quadrature/parallel.h"
#include "quadrature/rule.h"
#include "quadrature/strips.h"

#include <float.h>
#include <string.h>

enum { MAX_DEPTH = 60, MAX_RULES = 20000 };

typedef struct chooser {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_rule_demand *demand;
    double tolerance; /* relative, with what is negligible taken into account */
    hpr_rule_scratch *scratch;
    hpr_rule_sink sink;
    void *user;
    int kernel_cap; /* product: more nodes than this for the kernel, and the larger cell is halved */
    int rule_count;
    bool slit;                          /* the pair touches at an angle of next to nothing */
    double distance;                    /* of the two whole elements */
    const double *budget, *budget_used; /* kernels, NULL: any number */
    hpr_rule_outcome outcome;
} chooser;

static double ellipse(double length, double distance)
{
    double b = 2 * distance / length;
    return b + sqrt(b * b + 1);
}

/* Not in whole nodes, as polynomials may make use of the rest of one. */
static double nodes_wanted(double rho, double tolerance)
{
    return log(64 / tolerance) / (2 * log(rho));
}

int hpr_kernel_nodes(double length, double distance, double tolerance)
{
    double n = nodes_wanted(ellipse(length, distance), tolerance);
    return n < 1 ? 1 : n > 1000 ? 1000 : (int)ceil(n);
}

static double error_of(double rho, double nodes)
{
    return 64 * pow(rho, -2 * nodes);
}

double hpr_kernel_error(double length, double distance, int nodes)
{
    return error_of(ellipse(length, distance), nodes);
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

/* Product rules that are counted, not made. */
typedef struct product_trial {
    double kernels;
    int count;
    hpr_rule first;
} product_trial;

static void count_product(void *user, const hpr_rule *rule)
{
    product_trial *trial = user;
    if (trial->count++ == 0)
        trial->first = *rule;
    trial->kernels +=
        (double)(rule->recv_nodes[0] * rule->recv_nodes[1]) * (rule->send_nodes[0] * rule->send_nodes[1]);
}

static bool is_whole(const hpr_element_frame *frame, const hpr_cell *cell)
{
    return cell->shape == frame->shape && cell->origin[0] == 0 && cell->origin[1] == 0 &&
           cell->edge1[0] == 1 && cell->edge1[1] == 0 && cell->edge2[0] == 0 && cell->edge2[1] == 1;
}

static double cell_distance(const chooser *c, const hpr_cell *recv, const hpr_cell *send)
{
    hpr_vec3 a[4], b[4];
    if (is_whole(&c->pair->recv, recv) && is_whole(&c->pair->send, send))
        return c->distance;
    int na = hpr_cell_corners(&c->pair->recv, recv, a), nb = hpr_cell_corners(&c->pair->send, send, b);
    return hpr_polygon_distance(a, na, b, nb);
}

/* Nodes per axis for the kernel, `wanted` of them, and the polynomials: with n of them products up to degree
 * 2n - 1 are exact, so that half a node too many for the one is there for the others. */
static void set_product(chooser *c, const double rho[4], const double wanted[4], hpr_rule *rule)
{
    const int varies[2] = {height_varies(&c->pair->recv_height, &rule->recv),
                           height_varies(&c->pair->send_height, &rule->send)};
    for (int i = 0; i < 4; i++) {
        const hpr_element_frame *frame = i < 2 ? &c->pair->recv : &c->pair->send;
        bool triangle = (i < 2 ? &rule->recv : &rule->send)->shape == HPR_SHAPE_TRIANGLE;
        int degree = (triangle ? hpr_total_degree(frame) : frame->degree) + varies[i / 2];
        double kernel = wanted[i] < c->kernel_cap ? wanted[i] : c->kernel_cap;
        int n = clamp_nodes(c, (int)ceil(fmax(kernel, 1) + 0.5 * degree), c->demand->least_nodes);
        *(i < 2 ? &rule->recv_nodes[i] : &rule->send_nodes[i - 2]) = n;
        rule->error += error_of(rho[i], fmax(kernel, n - 0.5 * degree));
    }
}

static void separate(chooser *c, const hpr_cell *recv, const hpr_cell *send, int depth)
{
    double distance = cell_distance(c, recv, send);
    extent ea = cell_extent(&c->pair->recv, recv), eb = cell_extent(&c->pair->send, send);
    double length[4] = {ea.length[0], ea.length[1], eb.length[0], eb.length[1]}, rho[4], wanted[4];
    int longest = 0;
    for (int i = 0; i < 4; i++) {
        rho[i] = ellipse(length[i], distance);
        wanted[i] = nodes_wanted(rho[i], c->tolerance);
        if (length[i] > length[longest])
            longest = i;
    }
    bool stop = depth >= MAX_DEPTH || c->rule_count >= MAX_RULES;
    if (c->budget && *c->budget_used >= *c->budget)
        return;
    bool fits = wanted[longest] <= c->kernel_cap;
    if (!fits && !stop) {
        hpr_cell half[2];
        halve(longest < 2 ? &c->pair->recv : &c->pair->send, longest < 2 ? recv : send, longest % 2, half);
        for (int i = 0; i < 2; i++)
            separate(c, longest < 2 ? &half[i] : recv, longest < 2 ? send : &half[i], depth + 1);
        return;
    }
    c->outcome.stopped_short |= !fits;
    hpr_rule rule = {.kind = HPR_RULE_PRODUCT, .recv = *recv, .send = *send};
    set_product(c, rho, wanted, &rule);
    emit(c, &rule);
}

/* A touching pair whose visibility is sampled: nodes for about three digits, and those that are exact where
 * the polynomials vary alone. */
static void touching(chooser *c, hpr_rule rule)
{
    enum { KERNEL_NODES = 6 };
    int degree = hpr_total_degree(&c->pair->recv) + hpr_total_degree(&c->pair->send);
    rule.kernel_nodes = clamp_nodes(c, KERNEL_NODES + (degree + 1) / 2, 1);
    rule.scale_nodes = clamp_nodes(c, (degree + 3) / 2, 1);
    rule.error = c->tolerance;
    for (rule.term = 0; rule.term < (rule.kind == HPR_RULE_EDGE ? HPR_EDGE_TERMS : HPR_VERTEX_TERMS);
         rule.term++)
        emit(c, &rule);
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

/* Rules for all pairs of pieces. */
static void emit_pieces(chooser *c, const hpr_contact *contact)
{
    for (int i = 0; i < contact->recv_count; i++) {
        for (int j = 0; j < contact->send_count; j++) {
            const hpr_piece *a = &contact->recv[i], *b = &contact->send[j];
            hpr_rule rule;
            if (touching_rule(a, b, &rule))
                touching(c, rule);
            else
                separate(c, &a->cell, &b->cell, 0);
        }
    }
}

/* Planes that face each other so closely that nodes would miss how the view ends at the edges. */
static bool close_planes(const hpr_pair *pair)
{
    static const double close = 1e-3;
    double size = sqrt(fmin(pair->recv.area_m2, pair->send.area_m2));
    return hpr_strips_apply(pair) && hpr_frame_largest(&pair->recv, &pair->recv_height) < close * size;
}

static void clip_parts(chooser *c, const hpr_polygon *recv, const hpr_polygon *send)
{
    const hpr_clipped_demand demand = {c->demand->tolerance, c->demand->negligible};
    if (recv->count < 3 || send->count < 3)
        return;
    if (constants(c)) {
        double scale_m2 = sqrt(c->pair->recv.area_m2 * c->pair->send.area_m2);
        const hpr_partial_demand whole = {.tolerance = c->demand->tolerance,
                                          .allowed_m2 = c->demand->negligible * scale_m2,
                                          .flat = c->slit ? c->outcome.flat : 0,
                                          .swept_m2 = c->outcome.swept * scale_m2,
                                          .slit = c->slit || close_planes(c->pair)};
        hpr_partial part = hpr_partial_integrate(c->gauss, c->pair, recv, send, &whole, c->scratch->cell);
        c->outcome.exchange_m2 += part.exchange_m2;
        c->outcome.stopped_short |= !part.complete;
        c->outcome.error += part.error_m2 / scale_m2;
        c->outcome.clip_count += part.clip_count;
        return;
    }
    hpr_clipped_outcome outcome =
        hpr_clipped_choose(c->gauss, c->pair, recv, send, &demand, c->sink, c->user);
    c->outcome.stopped_short |= !outcome.complete;
    c->outcome.clip_count += outcome.clip_count;
    c->outcome.error += outcome.error;
}

/* What the product rules of a separate pair would need, counted until there are `limit` kernels. */
static product_trial try_products(const chooser *c, const hpr_contact *contact, double limit)
{
    product_trial products = {0};
    chooser trial = *c;
    trial.sink = count_product;
    trial.user = &products;
    trial.budget = &limit;
    trial.budget_used = &products.kernels;
    emit_pieces(&trial, contact);
    if (trial.outcome.stopped_short)
        products.kernels = limit;
    return products;
}

static void emit_products(chooser *c, const hpr_contact *contact, const product_trial *products)
{
    if (products->count == 1)
        emit(c, &products->first);
    else
        emit_pieces(c, contact);
}

static void reduce(chooser *c, const hpr_homothety *homothety, double tolerance)
{
    c->outcome.centre_count = homothety->centre_count;
    memcpy(c->outcome.centre, homothety->centre, sizeof c->outcome.centre);
    c->outcome.stopped_short |=
        !hpr_homothety_choose(c->gauss, c->pair, homothety, tolerance, c->sink, c->user);
}

static void nested(chooser *c, const hpr_contact *contact)
{
    c->outcome.stopped_short |= !hpr_nested_choose(c->gauss, c->pair, &contact->recv_front,
                                                   &contact->send_front, c->tolerance, c->sink, c->user);
}

/* Parallelograms with edges along the same directions. */
static bool find_directions(const chooser *c, hpr_rule *rule)
{
    static const double errors = 0.5; /* of the tolerance that their points were chosen for, observed */
    rule->tolerance = c->tolerance;
    rule->error = errors * c->tolerance;
    rule->kind = HPR_RULE_PARALLEL;
    if (hpr_parallel_find(c->pair, c->tolerance, &rule->parallel))
        return true;
    rule->kind = HPR_RULE_ALIGNED;
    return !constants(c) && hpr_aligned_find(c->pair, c->tolerance, &rule->aligned);
}

/*
 * Pairs that do not touch: product rules where those are cheap, rules for directions in common, a homothety
 * where it loses nothing, else the nested rule. The limits in kernels are where their times are about equal,
 * measured; of the rules for directions they are what these do besides.
 */
static void near_or_far(chooser *c, const hpr_contact *contact)
{
    enum { POINTS = 2000, TERMS = 90 };
    static const double loss = 1e-14, rounding = 1e-15;
    double cheap = constants(c) ? 1e5 : 2e6, dear = constants(c) ? 5e5 : 3e7, condition;
    int recv = c->pair->recv.degree + 1, send = c->pair->send.degree + 1;
    double work = POINTS + TERMS * recv * send * (recv + send);
    product_trial products = try_products(c, contact, work);
    if (products.kernels < work) {
        emit_products(c, contact, &products);
        return;
    }
    hpr_rule rule = {0};
    if (find_directions(c, &rule)) {
        emit(c, &rule);
        return;
    }
    products = try_products(c, contact, dear);
    if (products.kernels > cheap && c->outcome.flat < c->tolerance) {
        hpr_homothety apart = hpr_homothety_apart(c->gauss, c->pair, contact, &c->scratch->group, &condition);
        /* where the planes meet is known as well as the planes */
        double known = loss * hpr_frame_slenderness(&c->pair->recv) * hpr_frame_slenderness(&c->pair->send);
        if (condition * known < c->tolerance) {
            reduce(c, &apart, fmax(c->tolerance / condition, rounding));
            return;
        }
    }
    if (products.kernels < dear)
        emit_products(c, contact, &products);
    else
        nested(c, contact);
}

/* What rounding does to the heights of one side's front over the other's plane, relative to the largest. */
static double height_rounding(const hpr_element_frame *frame, const hpr_element_frame *other,
                              const hpr_affine *height, const hpr_polygon *front, double distance,
                              double offset)
{
    double highest = 0, size = hpr_frame_longest(frame), base = hpr_frame_longest(other);
    for (int i = 0; i < front->count; i++)
        highest = fmax(highest, hpr_affine_at(height, front->corner[i][0], front->corner[i][1]));
    /* the normal of a slender element is known to rounding times its slenderness */
    double lever = distance + size, slenderness = hpr_frame_slenderness(other);
    return DBL_EPSILON * (offset + base + lever * (1 + slenderness)) / highest;
}

/*
 * What rounding of the coordinates does, as if the elements were moved by that: the heights change, which
 * counts relative to them where the pair is seen flat; but no flux changes by more than what the edges sweep.
 */
static void set_rounding(chooser *c, const hpr_contact *contact)
{
    const hpr_element_frame *recv = &c->pair->recv, *send = &c->pair->send;
    double distance = c->distance, offset = hpr_length(send->origin);
    double length = offset + hpr_frame_longest(recv) + hpr_frame_longest(send);
    double edge = fmin(hpr_frame_longest(recv), hpr_frame_longest(send));
    double functions = (recv->degree + 1.0) * (send->degree + 1.0);
    c->outcome.rounding = DBL_EPSILON * 4;
    c->outcome.flat =
        height_rounding(recv, send, &c->pair->recv_height, &contact->recv_front, distance, offset) +
        height_rounding(send, recv, &c->pair->send_height, &contact->send_front, distance, offset);
    c->outcome.swept = DBL_EPSILON * functions * 4 * length * edge / sqrt(recv->area_m2 * send->area_m2);
}

/* Part k of an element, cut to the front of the other's plane. */
static hpr_polygon front_part(const hpr_polygon *part, const hpr_affine *height, const hpr_polygon *front,
                              int k, int count)
{
    return count ? hpr_polygon_half(&part[k], height, 1) : *front;
}

static void clipped(chooser *c, const hpr_contact *contact)
{
    const hpr_pair *p = c->pair;
    for (int i = 0; i < (p->recv_part_count ? p->recv_part_count : 1); i++) {
        hpr_polygon recv =
            front_part(p->recv_part, &p->recv_height, &contact->recv_front, i, p->recv_part_count);
        for (int j = 0; j < (p->send_part_count ? p->send_part_count : 1); j++) {
            hpr_polygon send =
                front_part(p->send_part, &p->send_height, &contact->send_front, j, p->send_part_count);
            clip_parts(c, &recv, &send);
        }
    }
}

/*
 * Elements whose planes all but agree, and that touch only as well as the planes are known: where one sees
 * that the line of both planes is, it misses the other by far more. A homothety from there adds and takes
 * away parts of that size, which beside a view as narrow as the square of the angle is too much.
 */
static bool touch_is_vague(const chooser *c, const hpr_contact *contact)
{
    static const double small_angle = 1e-2, rounding = 4 * DBL_EPSILON, share = 0.01;
    const hpr_element_frame *recv = &c->pair->recv, *send = &c->pair->send;
    double sine = hpr_length(hpr_cross(recv->normal, send->normal)), gap = 0;
    double size = fmin(hpr_frame_longest(recv), hpr_frame_longest(send));
    if (hpr_dot(recv->normal, send->normal) < 0 || sine > small_angle)
        return false;
    for (int k = 0; k < contact->point_count; k++) {
        hpr_vec3 x = hpr_frame_point(recv, contact->recv_point[k][0], contact->recv_point[k][1]),
                 y = hpr_frame_point(send, contact->send_point[k][0], contact->send_point[k][1]);
        gap = fmax(gap, hpr_length(hpr_sub(x, y)));
    }
    double known = rounding * (hpr_length(send->origin) + hpr_frame_longest(recv) + hpr_frame_longest(send));
    return gap > fmax(known, share * c->tolerance * sine * sine * size);
}

static void integrate(chooser *c, const hpr_cell *recv, const hpr_cell *send)
{
    hpr_contact contact;
    hpr_contact_find(c->pair, recv, send, c->demand->contact_m, &contact);
    c->outcome.seen = contact.kind != HPR_CONTACT_HIDDEN;
    if (!c->outcome.seen)
        return;
    set_rounding(c, &contact);
    bool sampled = c->demand->least_nodes > 1, separate = contact.kind == HPR_CONTACT_SEPARATE;
    bool parts = c->pair->recv_part_count || c->pair->send_part_count;
    static const double smallest_angle = 1e-3;
    c->slit = !separate && hpr_dot(c->pair->recv.normal, c->pair->send.normal) < 0 &&
              hpr_length(hpr_cross(c->pair->recv.normal, c->pair->send.normal)) < smallest_angle;
    if (c->pair->blocker_count || (parts && !sampled)) {
        clipped(c, &contact);
        return;
    }
    if (sampled) {
        emit_pieces(c, &contact);
        return;
    }
    /* What a homothety puts together belongs to no pair of planes if rounding turns these by more than is
     * asked, while the part of the view that one fills, point by point, is at most 1. */
    if (constants(c) && (c->slit || (!separate && touch_is_vague(c, &contact)))) {
        nested(c, &contact);
        return;
    }
    if (!separate) {
        hpr_homothety touching = hpr_homothety_touching(&contact);
        reduce(c, &touching, c->tolerance);
        return;
    }
    near_or_far(c, &contact);
}

/* Part k of an element in cells; all of it if it has no parts. */
static int part_cells(const hpr_element_frame *frame, const hpr_polygon *part, int part_count, int k,
                      hpr_cell *cell)
{
    if (part_count)
        return hpr_cuts_tiles(&part[k], cell);
    cell[0] = hpr_cell_whole(frame);
    return 1;
}

/* Where visibility is sampled, each part has points of its own: few of those of the whole element might be on
 * it. */
static void integrate_parts(chooser *c)
{
    const hpr_pair *p = c->pair;
    hpr_cell recv[HPR_POLYGON_MAX], send[HPR_POLYGON_MAX];
    bool seen = false;
    for (int i = 0; i < (p->recv_part_count ? p->recv_part_count : 1); i++) {
        int recv_count = part_cells(&p->recv, p->recv_part, p->recv_part_count, i, recv);
        for (int j = 0; j < (p->send_part_count ? p->send_part_count : 1); j++) {
            int send_count = part_cells(&p->send, p->send_part, p->send_part_count, j, send);
            for (int k = 0; k < recv_count * send_count; k++) {
                integrate(c, &recv[k / send_count], &send[k % send_count]);
                seen |= c->outcome.seen;
            }
        }
    }
    c->outcome.seen = seen;
}

int hpr_total_degree(const hpr_element_frame *frame)
{
    return frame->shape == HPR_SHAPE_PARALLELOGRAM ? 2 * frame->degree : frame->degree;
}

static double largest_height(const hpr_affine *height, const hpr_element_frame *frame)
{
    return fmax(hpr_frame_largest(frame, height), 0);
}

/*
 * The tolerance that applies: relative, or what is negligible next to the bound
 * K^00 <= sqrt(A_r A_s) max G, G = h_r h_s / (pi r^4).
 */
static double tolerance_of(const hpr_pair *pair, double distance, const hpr_rule_demand *demand)
{
    static const double loosest = 1e-2;
    double r2 = distance * distance;
    double heights =
        largest_height(&pair->recv_height, &pair->recv) * largest_height(&pair->send_height, &pair->send);
    double numerator = heights * sqrt(pair->recv.area_m2 * pair->send.area_m2);
    double allowed = demand->negligible * (3.14159265358979323846 * r2 * r2);
    return fmax(demand->tolerance, fmin(loosest, numerator > 0 ? allowed / numerator : loosest));
}

hpr_rule_outcome hpr_rules_choose(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                  const hpr_rule_demand *demand, hpr_rule_scratch *scratch,
                                  hpr_rule_sink sink, void *user)
{
    static const double share = 0.5; /* a rule errs along several axes */
    chooser c = {
        .gauss = gauss, .pair = pair, .demand = demand, .scratch = scratch, .sink = sink, .user = user};
    hpr_cell recv = hpr_cell_whole(&pair->recv), send = hpr_cell_whole(&pair->send);
    hpr_vec3 a[4], b[4];
    int na = hpr_cell_corners(&pair->recv, &recv, a), nb = hpr_cell_corners(&pair->send, &send, b);
    c.distance = hpr_polygon_distance(a, na, b, nb);
    c.tolerance = share * tolerance_of(pair, c.distance, demand);
    /* Cells about as large as their distance cost least at low degree; at high degree the polynomials' own
     * nodes pay for larger ones. */
    int degree = pair->recv.degree > pair->send.degree ? pair->recv.degree : pair->send.degree;
    c.kernel_cap = hpr_kernel_nodes(1, degree < 4 ? 1 : 0.5, c.tolerance);
    if (demand->least_nodes > 1 && (pair->recv_part_count || pair->send_part_count))
        integrate_parts(&c);
    else
        integrate(&c, &recv, &send);
    return c.outcome;
}
