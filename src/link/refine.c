/*
 * From pairs of patches down to links. A pair of nodes becomes a link when what the degrees of its inner
 * nodes leave out is small enough; else the node that leaves out more is replaced by its children. What a
 * leaf's degree leaves out does not count: the elements cannot show it anyway. A node with few leaves is
 * linked by all their coefficients at once where that leaves out less, or takes fewer numbers, than a degree
 * of its own (the near field of Hackbusch's H2-matrices: leaf clusters of several elements).
 *
 * Links that see each other wholly: e_ij <= tolerance (w + ‖G_ij‖) / 2, w = sqrt(A_i A_j) / A. Half of it is
 * absolute: every pair of points is in one link, so sum w^2 = 1 and these add up to tolerance / 2 at most in
 * the Frobenius norm. Half of it is relative: by Schur's test it adds up to tolerance / 2 of the operator's
 * norm, which is at most 1.
 *
 * Links that see partly have a jump in the kernel, which no degree follows: e_ij is about a third of ‖G‖ on
 * any level, of either sign, and what falls when they are refined is their number's share: of the 16 pairs of
 * children of two nodes some 8 see partly. What a link leaves out of H is c = e_ij sqrt((A_i + A_j) / 2A) of
 * ‖B‖, the square root being the sender's part of ‖B‖ (that of a lamp more, as it is brighter), and all of
 * them leave out the root of sum c^2. Those 8 have c / 8 each, so to refine a link takes 7/8 c^2 off the sum,
 * whatever its level: the fewest links have all the same bound on c, which is lowered until sum c^2 <=
 * tolerance^2 / 4. (Not all of it is of either sign: at a foot the same shadow falls from many senders.)
 * Where links see partly, those that see wholly may stand by that bound, too, and are in the sum then.
 */
#include "link/refine.h"

#include "quadrature/far.h"

#include <math.h>
#include <omp.h>
#include <string.h>

/* Rounds of refinement below a pair of patches: twice the depth of a tree, 2 (HPR_MAX_SUBDIVIDE +
 * HPR_MAX_FEET + HPR_MAX_GRADE) at most. */
enum { MAX_DEPTH = 160 };

/* Links found by one thread. */
typedef struct link_list {
    size_t count, capacity;
    hpr_link *link;
} link_list;

/* A share of the work: patch i with [j, j_end). Its links are consecutive in the list of one thread. */
typedef struct task {
    uint32_t i, j, j_end, thread;
    size_t first, count;
    double left_out2; /* by its links that stand by the bound, of ‖B‖: sum c^2 */
} task;

typedef struct walker {
    const hpr_link_refinement *r;
    const hpr_tree *tree;
    hpr_views_cursor *cursor;
    uint32_t *blocker; /* [MAX_DEPTH + 1][occluder_count] */
    size_t occluder_count;
    link_list list;
    double bound, left_out2; /* of c, where some links see partly; sum c^2 of the task */
    uint64_t hidden;
    hpr_status status;
} walker;

hpr_facet hpr_node_facet(const hpr_coverage *coverage, const hpr_tree *tree, size_t node)
{
    hpr_element_frame frame = hpr_tree_frame(tree, node, 0);
    hpr_facet facet;
    int part_count = 0;
    const hpr_polygon *part = hpr_coverage_node_parts(coverage, node, &part_count);
    hpr_vec3_store(facet.normal, frame.normal);
    if (part && part_count == 1 && part->count <= 4) {
        facet.corner_count = (size_t)part->count;
        for (int i = 0; i < part->count; i++)
            hpr_vec3_store(facet.corner[i], hpr_frame_point(&frame, part->corner[i][0], part->corner[i][1]));
        return facet;
    }
    hpr_cell whole = hpr_cell_whole(&frame);
    hpr_vec3 corner[4];
    facet.corner_count = (size_t)hpr_cell_corners(&frame, &whole, corner);
    for (size_t i = 0; i < facet.corner_count; i++)
        hpr_vec3_store(facet.corner[i], corner[i]);
    return facet;
}

double hpr_link_part2(const hpr_links *links, const double *brightness, uint32_t recv, uint32_t send)
{
    const hpr_elements *e = links->tree->elements;
    double bright[2] = {brightness ? brightness[e->patch[recv]] : 1,
                        brightness ? brightness[e->patch[send]] : 1};
    return (bright[0] * bright[0] * e->area_m2[recv] + bright[1] * bright[1] * e->area_m2[send]) /
           (2 * links->area_m2);
}

static const double jump = 0.3; /* of ‖G‖, that polynomials leave out of a jump */

double hpr_link_jump2(const hpr_links *links, const double *brightness, const hpr_link *link)
{
    const hpr_tree *tree = links->tree;
    const uint32_t *child = tree->elements->child;
    double norm2 = 0, stretch = hpr_tree_stretch(tree, link->recv) * hpr_tree_stretch(tree, link->send);
    if (!link->partly || (child[link->recv] == HPR_NONE && child[link->send] == HPR_NONE))
        return 0;
    for (size_t i = 0; i < hpr_link_size(links, link); i++)
        norm2 += pow(links->block[link->offset + i], 2);
    return pow(jump * stretch, 2) * norm2 * hpr_link_part2(links, brightness, link->recv, link->send);
}

/* One node of two that may be joined. */
typedef struct joint {
    uint32_t node;
    bool inner, straddles;
    bool mixed; /* inner, and some of it is covered */
    double area_m2, rho;
    int degree; /* that the block should have there, or HPR_TREE_LEAVES */
    bool fits;  /* the degree leaves out no more than it may */
} joint;

typedef struct candidate {
    joint recv, send;
    double norm;     /* of G */
    double left_out; /* of ‖B‖, if it stands by the bound */
    bool hidden;
} candidate;

static candidate look_at(const walker *w, uint32_t recv, uint32_t send)
{
    const hpr_elements *e = w->tree->elements;
    hpr_element_frame r = hpr_tree_frame(w->tree, recv, 0), s = hpr_tree_frame(w->tree, send, 0);
    hpr_far_view view = hpr_far_foretell(&r, &s);
    return (candidate){.recv = {recv, e->child[recv] != HPR_NONE, view.recv_straddles,
                                hpr_tree_is_mixed(w->tree, recv), r.area_m2, view.recv_rho, 0, false},
                       .send = {send, e->child[send] != HPR_NONE, view.send_straddles,
                                hpr_tree_is_mixed(w->tree, send), s.area_m2, view.send_rho, 0, false},
                       .norm = view.norm,
                       .hidden = view.hidden};
}

/* The lowest degree that leaves out no more than allowed; a leaf's own at most, for what that leaves out does
 * not count. A leaf of which a part is covered keeps its own: its coefficients belong to the open part, where
 * the functions are not orthogonal. An inner one has a constant or nothing where it sees partly (tree.h). */
static void choose_degree(const hpr_tree *tree, double norm, double allowed, bool partly, joint *j)
{
    int worth = partly && j->mixed ? 0 : tree->worth[j->node];
    bool trimmed = !j->inner && tree->kind[j->node] == HPR_NODE_MIXED;
    if (j->straddles || !isfinite(norm) || trimmed) {
        j->degree = worth;
        j->fits = !j->inner;
        return;
    }
    j->degree = 0;
    while (j->degree < worth && hpr_far_left_out(norm, j->rho, j->degree) > allowed)
        j->degree++;
    j->fits = !j->inner || hpr_far_left_out(norm, j->rho, j->degree) <= allowed;
}

/* All leaves at once, where that is better. */
static void consider_leaves(const hpr_tree *tree, joint *j)
{
    if (!j->inner || tree->kind[j->node] != HPR_NODE_OPEN || !hpr_tree_at_once(tree, j->node))
        return;
    size_t leaves = hpr_tree_count(tree, j->node, HPR_TREE_LEAVES);
    if (!j->fits || hpr_tree_count(tree, j->node, j->degree) >= leaves)
        j->degree = HPR_TREE_LEAVES;
    j->fits = true;
}

/* Nothing is left out there that the elements could show. */
static bool is_exact(const joint *j)
{
    return !j->inner || j->degree == HPR_TREE_LEAVES;
}

/* What the degree of one end leaves out. */
static double end_left_out(const candidate *c, const joint *j)
{
    return is_exact(j) ? 0 : hpr_far_left_out(c->norm, j->rho, j->degree);
}

/* Is it not known of an end what of it is open? */
static bool is_intricate(const walker *w, const joint *j)
{
    int count = 0;
    return j->mixed && (!hpr_coverage_node_parts(w->r->coverage, j->node, &count) || count == 0);
}

/* With the degrees that leave out no more than allowed; sets what is left out. */
static bool fits(const walker *w, candidate *c, double allowed, bool partly)
{
    static const double root_half = 0.7;
    choose_degree(w->tree, c->norm, root_half * allowed, partly, &c->recv);
    choose_degree(w->tree, c->norm, root_half * allowed, partly, &c->send);
    if (!partly) {
        consider_leaves(w->tree, &c->recv);
        consider_leaves(w->tree, &c->send);
    }
    if (is_exact(&c->recv) && is_exact(&c->send))
        return true;
    return isfinite(c->norm) && c->recv.fits && c->send.fits;
}

/* May the pair stay as it is? Chooses the degrees. */
static bool stands(const walker *w, candidate *c, bool partly)
{
    const hpr_links *links = w->r->links;
    double share = sqrt(c->recv.area_m2 * c->send.area_m2) / links->area_m2,
           part = sqrt(hpr_link_part2(links, w->r->brightness, c->recv.node, c->send.node));
    bool leaves = !c->recv.inner && !c->send.inner;
    c->left_out = 0;
    if (partly && leaves) {
        c->recv.degree = w->tree->worth[c->recv.node];
        c->send.degree = w->tree->worth[c->send.node];
        return true;
    }
    if (partly) {
        c->left_out = jump * c->norm * part;
        bool known = !is_intricate(w, &c->recv) && !is_intricate(w, &c->send);
        return fits(w, c, w->bound / part, partly) && known && c->left_out <= w->bound;
    }
    double allowed = links->link_tolerance * (share + (isfinite(c->norm) ? c->norm : 0)) / 2;
    if (fits(w, c, allowed, partly))
        return true;
    if (!links->occluded || allowed >= w->bound / part || !fits(w, c, w->bound / part, partly))
        return false;
    c->left_out = hypot(end_left_out(c, &c->recv), end_left_out(c, &c->send)) * part;
    return true;
}

/* Is the receiver the one to refine? */
static bool refines_recv(const candidate *c, bool partly)
{
    bool exact[2] = {is_exact(&c->recv), is_exact(&c->send)};
    if (exact[0] || exact[1])
        return exact[1];
    if (c->recv.straddles != c->send.straddles)
        return c->recv.straddles;
    if (partly || !isfinite(c->norm) || c->recv.fits == c->send.fits)
        return c->recv.area_m2 >= c->send.area_m2;
    return !c->recv.fits;
}

static void emit(walker *w, const candidate *c, bool partly)
{
    link_list *list = &w->list;
    if (list->count == list->capacity && w->status == HPR_OK)
        w->status = hpr_grow(w->tree->context, &list->link, &list->capacity, 2 * list->count + 64,
                             sizeof *list->link);
    if (w->status == HPR_OK)
        list->link[list->count++] = (hpr_link){.recv = c->recv.node,
                                               .send = c->send.node,
                                               .recv_degree = (uint8_t)c->recv.degree,
                                               .send_degree = (uint8_t)c->send.degree,
                                               .partly = partly};
    w->left_out2 += c->left_out * c->left_out;
}

/* blocker [blocker_count]: what may come between, if `partly` */
static void walk(walker *w, uint32_t recv, uint32_t send, bool partly, const uint32_t *blocker,
                 size_t blocker_count, int depth)
{
    const hpr_tree *tree = w->tree;
    const uint32_t *child = tree->elements->child;
    if (w->status != HPR_OK || hpr_cancelled(tree->context))
        return;
    if (tree->kind[recv] == HPR_NODE_COVERED || tree->kind[send] == HPR_NODE_COVERED) {
        w->hidden++;
        return;
    }
    candidate c = look_at(w, recv, send);
    uint32_t *own = w->blocker + (size_t)(depth + 1) * w->occluder_count;
    size_t own_count = 0;
    if (partly && depth > 0) {
        hpr_facet a = hpr_node_facet(w->r->coverage, tree, recv),
                  b = hpr_node_facet(w->r->coverage, tree, send);
        hpr_verdict verdict =
            hpr_visibility_classify(w->r->visibility, &a, &b, blocker, blocker_count, own, &own_count);
        if (verdict == HPR_SEES_NOTHING) {
            w->hidden++;
            return;
        }
        partly = verdict == HPR_SEES_PARTLY;
        blocker = own;
        blocker_count = own_count;
    }
    if (!partly && c.hidden) {
        w->hidden++;
        return;
    }
    if (stands(w, &c, partly)) {
        emit(w, &c, partly);
        return;
    }
    bool first = refines_recv(&c, partly);
    uint32_t refined = first ? child[recv] : child[send];
    for (uint32_t k = 0; k < 2; k++)
        walk(w, first ? refined + k : recv, first ? send : refined + k, partly, blocker, blocker_count,
             depth + 1);
}

static void walk_task(walker *w, task *t)
{
    const hpr_link_refinement *r = w->r;
    t->thread = (uint32_t)omp_get_thread_num();
    t->first = w->list.count;
    w->left_out2 = 0;
    for (uint32_t j = t->j; j < t->j_end && w->status == HPR_OK; j++) {
        uint8_t verdict = r->verdict[t->i * w->tree->elements->patch_count + j];
        size_t blocker_count = 0;
        if (verdict == HPR_SEES_NOTHING)
            continue;
        if (verdict == HPR_SEES_PARTLY)
            hpr_views_classify(r->views, w->cursor, t->i, j, w->blocker, &blocker_count);
        walk(w, t->i, j, verdict == HPR_SEES_PARTLY, w->blocker, blocker_count, 0);
    }
    t->count = w->list.count - t->first;
    t->left_out2 = w->left_out2;
}

static hpr_status make_tasks(const hpr_link_refinement *r, task **tasks, size_t *count)
{
    size_t n = r->links->tree->elements->patch_count, width = n / 64 + 1;
    *count = 0;
    for (size_t i = 0; i < n; i++)
        *count += (n - i - 1 + width - 1) / width;
    hpr_status status = hpr_allocate_into(r->links->context, tasks, *count, sizeof **tasks, "links");
    if (status != HPR_OK)
        return status;
    size_t next = 0;
    for (size_t i = 0; i < n; i++) {
        for (size_t j = i + 1; j < n; j += width) {
            size_t end = j + width < n ? j + width : n;
            (*tasks)[next++] = (task){.i = (uint32_t)i, .j = (uint32_t)j, .j_end = (uint32_t)end};
        }
    }
    return HPR_OK;
}

static hpr_status open_walkers(const hpr_link_refinement *r, walker *walkers, int threads)
{
    hpr_context *ctx = r->links->context;
    size_t occluders = hpr_visibility_occluder_count(r->visibility);
    hpr_status status = HPR_OK;
    for (int t = 0; t < threads && status == HPR_OK; t++) {
        walker *w = &walkers[t];
        *w = (walker){.r = r, .tree = r->links->tree, .occluder_count = occluders};
        status = hpr_views_cursor_create(r->views, &w->cursor);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->blocker, (MAX_DEPTH + 2) * occluders, sizeof(uint32_t),
                                       "blockers");
    }
    return status;
}

static void close_walkers(const hpr_link_refinement *r, walker *walkers, int threads)
{
    hpr_context *ctx = r->links->context;
    for (int t = 0; t < threads; t++) {
        hpr_count(ctx, HPR_COUNT_PAIRS_HIDDEN, walkers[t].hidden);
        hpr_views_cursor_destroy(&walkers[t].cursor);
        hpr_release(ctx, walkers[t].blocker);
        hpr_release(ctx, walkers[t].list.link);
    }
    hpr_release(ctx, walkers);
}

/* The lists of all threads in the order of the tasks. */
static hpr_status join_lists(const hpr_link_refinement *r, const walker *walkers, const task *tasks,
                             size_t count)
{
    hpr_links *links = r->links;
    size_t total = 0;
    for (size_t t = 0; t < count; t++)
        total += tasks[t].count;
    hpr_status status = hpr_allocate_into(links->context, &links->link, total, sizeof *links->link, "links");
    for (size_t t = 0; status == HPR_OK && t < count; t++) {
        const link_list *list = &walkers[tasks[t].thread].list;
        if (tasks[t].count == 0)
            continue;
        memcpy(links->link + links->count, list->link + tasks[t].first, tasks[t].count * sizeof *links->link);
        links->count += tasks[t].count;
    }
    for (size_t l = 0; l < links->count; l++)
        links->partly_count += links->link[l].partly;
    return status;
}

/* All links, in the walkers' lists. */
static hpr_status walk_all(const hpr_link_refinement *r, walker *walkers, double bound, task *tasks,
                           size_t count, double *left_out2)
{
    hpr_context *ctx = r->links->context;
    int threads = hpr_context_threads(ctx);
    for (int t = 0; t < threads; t++) {
        walkers[t].bound = bound;
        walkers[t].list.count = walkers[t].hidden = 0;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t t = 0; t < count; t++)
        walk_task(&walkers[omp_get_thread_num()], &tasks[t]);
    *left_out2 = 0;
    for (size_t t = 0; t < count; t++)
        *left_out2 += tasks[t].left_out2;
    for (int t = 0; t < threads; t++) {
        if (walkers[t].status != HPR_OK)
            return walkers[t].status;
    }
    return hpr_cancelled(ctx) ? hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while linking") : HPR_OK;
}

hpr_status hpr_links_refine(const hpr_link_refinement *r)
{
    /* The sum falls about like the bound: of c = n^-3, n the nodes along an edge, are some n^3 links. */
    static const double aim = 0.9, least = 0.02, largest = 0.8;
    hpr_context *ctx = r->links->context;
    int threads = hpr_context_threads(ctx);
    walker *walkers = NULL;
    task *tasks = NULL;
    size_t count = 0;
    hpr_status status = make_tasks(r, &tasks, &count);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &walkers, (size_t)threads, sizeof *walkers, "links");
    if (status == HPR_OK)
        status = open_walkers(r, walkers, threads);
    double most = pow(r->links->link_tolerance, 2) / 4, bound = most, left_out2 = INFINITY;
    while (status == HPR_OK && left_out2 > most) {
        status = walk_all(r, walkers, bound, tasks, count, &left_out2);
        bound *= fmin(fmax(aim * most / left_out2, least), largest);
    }
    if (status == HPR_OK)
        status = join_lists(r, walkers, tasks, count);
    if (walkers)
        close_walkers(r, walkers, threads);
    hpr_release(ctx, tasks);
    return status;
}
