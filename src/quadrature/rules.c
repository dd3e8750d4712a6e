/* Which rule for which pair of pieces: product Gauss by an error bound, vertex and edge rules by trial. */
#include "quadrature/contact.h"
#include "quadrature/rule.h"

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
    int recv_degree, send_degree; /* total degree of the polynomials in the parameters */
    int rule_count;
    hpr_rule_outcome outcome;
} chooser;

/*
 * Nodes that resolve 1/r^4 along a segment of this length with all else at least `distance` away. Along it
 * r^2 is a quadratic with complex roots at least distance/length (in units of the segment) from [0,1], so
 * that the kernel is analytic inside the Bernstein ellipse of parameter rho = b + sqrt(b^2 + 1), b = 2
 * distance/length, and n-point Gauss errs like rho^(-2n) (Trefethen 2013, thm. 19.3). The factor 64 is for
 * the kernel's growth near the ellipse, observed.
 */
static int kernel_nodes(double length, double distance, double tolerance)
{
    double b = 2 * distance / length, rho = b + sqrt(b * b + 1);
    double n = log(64 / tolerance) / (2 * log(rho));
    return n < 1 ? 1 : n > 1000 ? 1000 : (int)ceil(n);
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

typedef void (*cell_step)(chooser *c, const hpr_cell *recv, const hpr_cell *send, int depth);

/* Halves the side with the longest extent and goes on with each half. */
static void halve_larger(chooser *c, const hpr_cell *recv, const hpr_cell *send, int depth, cell_step step)
{
    extent a = cell_extent(&c->pair->recv, recv), b = cell_extent(&c->pair->send, send);
    bool recv_larger = fmax(a.length[0], a.length[1]) >= fmax(b.length[0], b.length[1]);
    extent larger = recv_larger ? a : b;
    hpr_cell half[2];
    halve(recv_larger ? &c->pair->recv : &c->pair->send, recv_larger ? recv : send,
          larger.length[1] > larger.length[0], half);
    for (int i = 0; i < 2; i++)
        step(c, recv_larger ? &half[i] : recv, recv_larger ? send : &half[i], depth + 1);
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
        nodes[i] = kernel_nodes(length[i], distance, c->tolerance);
        if (length[i] > length[longest])
            longest = i;
    }
    bool stop = depth >= MAX_DEPTH || c->rule_count >= MAX_RULES;
    if (nodes[longest] > c->kernel_cap && !stop) {
        halve_larger(c, recv, send, depth, separate);
        return;
    }
    c->outcome.stopped_short |= nodes[longest] > c->kernel_cap;
    hpr_rule rule = {.kind = HPR_RULE_PRODUCT, .recv = *recv, .send = *send};
    for (int i = 0; i < 4; i++) {
        int degree = i < 2 ? c->pair->recv.degree : c->pair->send.degree;
        int kernel = nodes[i] < c->kernel_cap ? nodes[i] : c->kernel_cap;
        int n = clamp_nodes(c, kernel + (degree + 1) / 2, c->demand->least_nodes);
        *(i < 2 ? &rule.recv_nodes[i] : &rule.send_nodes[i - 2]) = n;
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

/*
 * A touching pair: the kernel alone is integrated with rising numbers of nodes until two agree; then nodes
 * are added for the polynomials. Where the polynomials vary alone, the number that is exact for them is
 * taken.
 */
static void touching(chooser *c, hpr_rule rule)
{
    static const int trial[] = {2, 3, 4, 6, 8, 10, 12, 15, 19, 24, 30};
    enum { TRIALS = sizeof trial / sizeof *trial };
    double before = 0;
    bool reached = false;
    int i = 0;
    for (; i < TRIALS && !reached; i++) {
        kernel_sum total = {0};
        rule.kernel_nodes = trial[i];
        rule.scale_nodes = 1;
        hpr_rule_points(c->gauss, c->pair, &rule, c->group, add_kernel_sum, &total);
        c->outcome.kernel_count += total.count;
        reached = i > 0 && fabs(total.sum - before) <= c->tolerance * fabs(total.sum);
        before = total.sum;
    }
    c->outcome.stopped_short |= !reached;
    int degree = c->recv_degree + c->send_degree;
    rule.kernel_nodes = clamp_nodes(c, trial[i - 1] + (degree + 1) / 2, 1);
    rule.scale_nodes = clamp_nodes(c, (degree + 3) / 2, 1);
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

static void choose_for_pieces(chooser *c, const hpr_piece *a, const hpr_piece *b, int depth)
{
    if (a->touch == HPR_TOUCH_EDGE && b->touch == HPR_TOUCH_EDGE) {
        touching(c, (hpr_rule){.kind = HPR_RULE_EDGE, .recv = a->cell, .send = b->cell});
        return;
    }
    hpr_touch touch = a->touch == HPR_TOUCH_EDGE ? b->touch : a->touch;
    if (touch != HPR_TOUCH_NONE && (b->touch == touch || b->touch == HPR_TOUCH_EDGE))
        touching(
            c, (hpr_rule){.kind = HPR_RULE_VERTEX, .recv = turned_to(a, touch), .send = turned_to(b, touch)});
    else
        separate(c, &a->cell, &b->cell, depth);
}

/* Least width of a cell. */
static double cell_width(const hpr_element_frame *frame, const hpr_cell *cell)
{
    extent e = cell_extent(frame, cell);
    hpr_vec3 e1 = hpr_frame_vector(frame, cell->edge1), e2 = hpr_frame_vector(frame, cell->edge2);
    return hpr_length(hpr_cross(e1, e2)) / fmax(e.length[0], e.length[1]);
}

/* True if a touching pair is so much longer somewhere than its contact or its least width that halving it
 * pays. Halving a pair of similar extents would only give pairs of the same shape again. */
static bool uneven(const chooser *c, const hpr_cell *recv, const hpr_cell *send, const hpr_contact *contact)
{
    static const double ratio = 5;
    extent a = cell_extent(&c->pair->recv, recv), b = cell_extent(&c->pair->send, send);
    double longest = fmax(fmax(a.length[0], a.length[1]), fmax(b.length[0], b.length[1]));
    double width = fmin(cell_width(&c->pair->recv, recv), cell_width(&c->pair->send, send));
    if (contact->kind == HPR_CONTACT_EDGE)
        width = fmin(width, contact->length_m);
    return longest > ratio * width;
}

static void integrate(chooser *c, const hpr_cell *recv, const hpr_cell *send, int depth)
{
    hpr_contact contact;
    hpr_contact_find(c->pair, recv, send, c->demand->contact_m, &contact);
    c->outcome.seen |= contact.kind != HPR_CONTACT_HIDDEN;
    bool touch = contact.kind == HPR_CONTACT_VERTEX || contact.kind == HPR_CONTACT_EDGE;
    if (touch && depth < MAX_TOUCHING_DEPTH && c->rule_count < MAX_RULES && uneven(c, recv, send, &contact)) {
        halve_larger(c, recv, send, depth, integrate);
        return;
    }
    for (int i = 0; i < contact.recv_count; i++) {
        for (int j = 0; j < contact.send_count; j++)
            choose_for_pieces(c, &contact.recv[i], &contact.send[j], depth);
    }
}

static int total_degree(const hpr_element_frame *frame)
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
    chooser c = {.gauss = gauss, .pair = pair, .demand = demand, .group = group, .sink = sink, .user = user};
    hpr_cell recv = hpr_cell_whole(pair->recv.shape), send = hpr_cell_whole(pair->send.shape);
    c.tolerance = tolerance_of(pair, &recv, &send, demand);
    /* Cells about as large as their distance cost least at low degree; at high degree the polynomials' own
     * nodes pay for larger ones. */
    int degree = pair->recv.degree > pair->send.degree ? pair->recv.degree : pair->send.degree;
    c.kernel_cap = kernel_nodes(1, degree < 4 ? 1 : 0.5, c.tolerance);
    c.recv_degree = total_degree(&pair->recv);
    c.send_degree = total_degree(&pair->send);
    integrate(&c, &recv, &send, 0);
    return c.outcome;
}
