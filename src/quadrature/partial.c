/*
 * The rule for constants that see each other partly: an outer integral over one polygon of the visible part
 * of the other, which Lambert's formula gives exactly for each point. Along the event lines that integrand
 * has its kinks; what they do not tell (blockers that overlap as seen from a point) the cells find by
 * halving.
 */
#include "quadrature/partial.h"

#include "direct/lambert.h"
#include "math/hull.h"
#include "quadrature/analytic.h"
#include "quadrature/cuts.h"
#include "quadrature/events.h"
#include "quadrature/strips.h"

#include <string.h>

enum { MAX_NODES = 8 };

typedef struct partial {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_element_frame *outer, *inner;
    hpr_convex outline; /* the inner polygon in space */
    hpr_strips strips;
    double slack; /* points nearer than this are one */
    double size;  /* of the inner polygon */
    const hpr_partial_demand *demand;
    int nodes[2]; /* of the rule that tells the error, of the one that counts */
    int count;
    hpr_partial_cell *cell; /* a heap by error, the largest first */
    double value, error;
    hpr_partial result;
} partial;

/* The blockers of one cell as a list. */
typedef struct blockers {
    int count;
    uint32_t index[64];
} blockers;

static blockers list_blockers(const hpr_partial_cell *q)
{
    blockers list;
    list.count = 0;
    for (uint32_t b = 0; b < 64; b++) {
        if (q->blockers >> b & 1)
            list.index[list.count++] = b;
    }
    return list;
}

/* Of the whole inner polygon. */
static double open_fraction(const partial *p, hpr_vec3 x)
{
    double point[3], normal[3];
    hpr_vec3_store(point, x);
    hpr_vec3_store(normal, p->outer->normal);
    return hpr_lambert_fraction(point, normal, (const double(*)[3])p->outline.corner,
                                (size_t)p->outline.count);
}

/*
 * Ends of cuts are known to rounding of the sizes. To a point next to the inner polygon that is a part of its
 * view: pieces that meet below it leave some out or count it twice. There they get their share of what would
 * be seen if nothing were hidden.
 */
static double fraction_at(partial *p, const blockers *list, double s, double t)
{
    static const double next_to = 1e-5;
    hpr_visible visible, hidden;
    hpr_vec3 x = hpr_frame_point(p->outer, s, t), offset = hpr_sub(x, p->outline.corner[0]);
    bool is_near = list->count > 0 && fabs(hpr_dot(p->inner->normal, offset)) < next_to * p->size;
    visible.hidden = is_near ? &hidden : NULL;
    p->result.complete &= hpr_visible_part(x, &p->outline, p->inner->normal, p->pair->blocker, list->index,
                                           list->count, &visible);
    p->result.clip_count += list->count > 0;
    double seen = hpr_visible_fraction(p->outer->normal, &visible);
    if (!is_near || hidden.count == 0)
        return seen;
    double all = seen + hpr_visible_fraction(p->outer->normal, &hidden);
    return all > 0 ? seen / all * open_fraction(p, x) : 0;
}

/* The point of a cell, and the area that its parameters take there. */
static double cell_point(const hpr_partial_cell *q, double u, double v, double point[2])
{
    double along_u[2], along_v[2];
    for (int k = 0; k < 2; k++) {
        double low = q->corner[0][k] + u * (q->corner[1][k] - q->corner[0][k]);
        double high = q->corner[3][k] + u * (q->corner[2][k] - q->corner[3][k]);
        point[k] = low + v * (high - low);
        along_u[k] = (1 - v) * (q->corner[1][k] - q->corner[0][k]) + v * (q->corner[2][k] - q->corner[3][k]);
        along_v[k] = high - low;
    }
    return fabs(along_u[0] * along_v[1] - along_u[1] * along_v[0]);
}

/* Gauss with n x n nodes; values: the integrand at them. */
static double gauss_sum(partial *p, const hpr_partial_cell *q, const blockers *list, int n,
                        double values[MAX_NODES * MAX_NODES])
{
    const hpr_gauss_rule *rule = &p->gauss->legendre[n];
    double sum = 0;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            double point[2], area = cell_point(q, rule->node[i], rule->node[j], point);
            double fraction = fraction_at(p, list, point[0], point[1]);
            values[j * n + i] = fraction;
            sum += rule->weight[i] * rule->weight[j] * area * fraction;
        }
    }
    return sum;
}

/* How much the values bend along each axis. */
static int bending_axis(const double *values, int n)
{
    double bend[2] = {0, 0};
    for (int j = 0; j < n; j++) {
        for (int i = 1; i + 1 < n; i++) {
            bend[0] += fabs(values[j * n + i - 1] - 2 * values[j * n + i] + values[j * n + i + 1]);
            bend[1] += fabs(values[(i - 1) * n + j] - 2 * values[i * n + j] + values[(i + 1) * n + j]);
        }
    }
    return bend[1] > bend[0];
}

/* Does the blocker cross every segment from a corner of the cell to one of the inner polygon? Then it hides
 * one from the other: the crossings of all segments are the convex hull of these. */
static bool hides(const partial *p, const hpr_convex *blocker, const hpr_vec3 corner[4])
{
    hpr_vec3 origin = blocker->corner[0],
             normal = hpr_cross(hpr_sub(blocker->corner[1], origin), hpr_sub(blocker->corner[2], origin));
    double limit = p->slack * hpr_length(normal);
    for (int i = 0; i < 4; i++) {
        double from = hpr_dot(normal, hpr_sub(corner[i], origin));
        for (int j = 0; j < p->outline.count; j++) {
            double to = hpr_dot(normal, hpr_sub(p->outline.corner[j], origin));
            if (!((from > limit && to < -limit) || (from < -limit && to > limit)))
                return false;
            hpr_vec3 crossing =
                hpr_madd(corner[i], from / (from - to), hpr_sub(p->outline.corner[j], corner[i]));
            for (int k = 0; k < blocker->count; k++) {
                hpr_vec3 a = blocker->corner[k], b = blocker->corner[k + 1 < blocker->count ? k + 1 : 0];
                if (hpr_dot(hpr_cross(normal, hpr_sub(b, a)), hpr_sub(crossing, a)) < 0)
                    return false;
            }
        }
    }
    return true;
}

/* Leaves those blockers that meet the hull of the cell and the inner polygon. */
static void cull(const partial *p, hpr_partial_cell *q)
{
    hpr_vec3 corner[4];
    double plane[HPR_HULL_PLANES][4], normals[2][3];
    hpr_vec3_store(normals[0], p->outer->normal);
    hpr_vec3_store(normals[1], p->inner->normal);
    for (int i = 0; i < 4; i++)
        corner[i] = hpr_frame_point(p->outer, q->corner[i][0], q->corner[i][1]);
    const hpr_hull_end end[2] = {
        {(const double(*)[3])corner, 4, normals[0]},
        {(const double(*)[3])p->outline.corner, (size_t)p->outline.count, normals[1]}};
    size_t count = hpr_hull_planes(end, p->slack, plane);
    q->hidden = false;
    for (int b = 0; b < p->pair->blocker_count && !q->hidden; b++) {
        const hpr_convex *blocker = &p->pair->blocker[b];
        if (!(q->blockers >> b & 1))
            continue;
        if (!hpr_hull_meets((const double(*)[4])plane, count, (const double(*)[3])blocker->corner,
                            (size_t)blocker->count, p->slack))
            q->blockers &= ~((uint64_t)1 << b);
        else
            q->hidden = hides(p, blocker, corner);
    }
}

/* What an edge of the inner polygon next to the cell may hide from the nodes, the integrand being at most 1;
 * 0 if the two rules tell by themselves. *axis: along which to halve. */
static double overlooked(const partial *p, const hpr_partial_cell *q, int *axis)
{
    static const double told = 1.7, strength = 4;
    const double(*c)[2] = q->corner;
    double least[2] = {INFINITY, INFINITY}, end[2][2], d[2][2];
    for (int k = 0; k < 6; k++) {
        bool along_v = k % 2;
        for (int i = 0; i < 2; i++) {
            end[0][i] = c[0][i] + 0.25 * (k - along_v) * (c[along_v ? 1 : 3][i] - c[0][i]);
            end[1][i] = c[along_v ? 3 : 1][i] + 0.25 * (k - along_v) * (c[2][i] - c[along_v ? 3 : 1][i]);
        }
        hpr_vec3 from = hpr_frame_point(p->outer, end[0][0], end[0][1]),
                 to = hpr_frame_point(p->outer, end[1][0], end[1][1]);
        least[along_v] = fmin(least[along_v], hpr_bernstein(from, to, p->outline.corner, p->outline.count));
    }
    double ellipse = fmin(least[0], least[1]);
    if (!(ellipse < told))
        return 0;
    *axis = least[1] < least[0];
    for (int i = 0; i < 2; i++) {
        d[0][i] = c[2][i] - c[0][i];
        d[1][i] = c[3][i] - c[1][i];
    }
    double area = fabs(d[0][0] * d[1][1] - d[0][1] * d[1][0]) / 2;
    return area * fmin(hpr_strips_left(&p->strips, c), strength * pow(ellipse, -2.0 * p->nodes[1]));
}

/* The difference of the two rules is the error of the lower one: an honest bound where there are kinks, a
 * generous one elsewhere. */
static void integrate_cell(partial *p, hpr_partial_cell *q)
{
    double values[MAX_NODES * MAX_NODES];
    cull(p, q);
    q->value = q->error = 0;
    q->axis = 0;
    if (q->hidden)
        return;
    blockers list = list_blockers(q);
    double low = gauss_sum(p, q, &list, p->nodes[0], values);
    q->value = gauss_sum(p, q, &list, p->nodes[1], values);
    q->axis = bending_axis(values, p->nodes[1]);
    q->error = fabs(q->value - low);
    if (p->demand->slit)
        q->error += overlooked(p, q, &q->axis);
}

static void sift_up(partial *p, int i)
{
    while (i > 0 && p->cell[i].error > p->cell[(i - 1) / 2].error) {
        hpr_partial_cell exchange = p->cell[i];
        p->cell[i] = p->cell[(i - 1) / 2];
        p->cell[(i - 1) / 2] = exchange;
        i = (i - 1) / 2;
    }
}

static void sift_down(partial *p)
{
    for (int i = 0;;) {
        int largest = i;
        for (int child = 2 * i + 1; child <= 2 * i + 2 && child < p->count; child++) {
            if (p->cell[child].error > p->cell[largest].error)
                largest = child;
        }
        if (largest == i)
            return;
        hpr_partial_cell exchange = p->cell[i];
        p->cell[i] = p->cell[largest];
        p->cell[largest] = exchange;
        i = largest;
    }
}

static void add_cell(partial *p, const hpr_partial_cell *q)
{
    p->cell[p->count] = *q;
    integrate_cell(p, &p->cell[p->count]);
    sift_up(p, p->count++);
}

/* The halves of a cell along an axis of its own. */
static void halve(const hpr_partial_cell *q, hpr_partial_cell half[2])
{
    double middle[2][2];
    int axis = q->axis;
    half[0] = half[1] = *q;
    cell_point(q, axis ? 0 : 0.5, axis ? 0.5 : 0, middle[0]);
    cell_point(q, axis ? 1 : 0.5, axis ? 0.5 : 1, middle[1]);
    if (axis) {
        memcpy(half[0].corner[3], middle[0], sizeof middle[0]);
        memcpy(half[0].corner[2], middle[1], sizeof middle[0]);
        memcpy(half[1].corner[0], middle[0], sizeof middle[0]);
        memcpy(half[1].corner[1], middle[1], sizeof middle[0]);
    } else {
        memcpy(half[0].corner[1], middle[0], sizeof middle[0]);
        memcpy(half[0].corner[2], middle[1], sizeof middle[0]);
        memcpy(half[1].corner[0], middle[0], sizeof middle[0]);
        memcpy(half[1].corner[3], middle[1], sizeof middle[0]);
    }
}

/* A polygon as quadrilaterals, the last perhaps a triangle. */
static void add_polygon(partial *p, const hpr_polygon *polygon)
{
    uint64_t all = p->pair->blocker_count < 64 ? ((uint64_t)1 << p->pair->blocker_count) - 1 : ~(uint64_t)0;
    for (int k = 1; k + 1 < polygon->count && p->count < HPR_PARTIAL_CELLS; k += 2) {
        const int index[4] = {0, k, k + 1, k + 2 < polygon->count ? k + 2 : k + 1};
        hpr_partial_cell q = {.blockers = all};
        for (int i = 0; i < 4; i++)
            memcpy(q.corner[i], polygon->corner[index[i]], sizeof q.corner[i]);
        add_cell(p, &q);
    }
}

static void sum_up(partial *p)
{
    p->value = p->error = 0;
    for (int i = 0; i < p->count; i++) {
        p->value += p->cell[i].value;
        p->error += p->cell[i].error;
    }
}

static double allowed(const partial *p, double jacobian)
{
    static const double rounding = 1e-15, share = 0.25;
    const hpr_partial_demand *d = p->demand;
    double anyhow = share * fmin(d->flat * p->value, d->swept_m2 / jacobian);
    return fmax(fmax(d->allowed_m2 / jacobian, anyhow), fmax(d->tolerance, rounding) * p->value);
}

/* Halves the worst cell again and again. */
static void refine(partial *p, double jacobian)
{
    for (sum_up(p); p->error > allowed(p, jacobian); sum_up(p)) {
        if (p->count == HPR_PARTIAL_CELLS) {
            p->result.complete = false;
            return;
        }
        hpr_partial_cell half[2];
        halve(&p->cell[0], half);
        p->cell[0] = half[0];
        integrate_cell(p, &p->cell[0]);
        sift_down(p);
        add_cell(p, &half[1]);
    }
}

static void choose_nodes(partial *p, double tolerance)
{
    static const struct {
        double tolerance;
        int nodes[2];
    } level[] = {{1e-4, {2, 3}}, {1e-6, {3, 4}}, {1e-8, {4, 6}}, {0, {6, 8}}};
    int k = 0;
    while (tolerance < level[k].tolerance)
        k++;
    p->nodes[0] = level[k].nodes[0];
    p->nodes[1] = level[k].nodes[1];
}

static double frame_area(const hpr_element_frame *frame, const hpr_polygon *polygon)
{
    return hpr_polygon_area(polygon) * hpr_frame_jacobian(frame);
}

hpr_partial hpr_partial_integrate(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                                  const hpr_polygon *send, const hpr_partial_demand *demand,
                                  hpr_partial_cell cells[HPR_PARTIAL_CELLS])
{
    static const double rounding = 1e-12 /* of the distance */, tight = 1e-4;
    enum { FEW_LINES = 24 };
    bool recv_is_outer = frame_area(&pair->recv, recv) <= frame_area(&pair->send, send);
    const hpr_polygon *outer = recv_is_outer ? recv : send, *inner = recv_is_outer ? send : recv;
    partial p;
    p.gauss = gauss;
    p.pair = pair;
    p.outer = recv_is_outer ? &pair->recv : &pair->send;
    p.inner = recv_is_outer ? &pair->send : &pair->recv;
    p.cell = cells;
    p.count = 0;
    p.result = (hpr_partial){.complete = true};
    p.slack = 0;
    p.size = sqrt(frame_area(p.inner, inner));
    p.demand = demand;
    p.outline.count = inner->count;
    for (int i = 0; i < inner->count; i++)
        p.outline.corner[i] = hpr_frame_point(p.inner, inner->corner[i][0], inner->corner[i][1]);
    for (int i = 0; i < outer->count; i++) {
        hpr_vec3 x = hpr_frame_point(p.outer, outer->corner[i][0], outer->corner[i][1]);
        p.slack = hpr_max(p.slack, rounding * hpr_length(hpr_sub(x, p.outline.corner[0])));
    }
    hpr_strips_init(&p.strips, p.outer, recv_is_outer ? &pair->recv_height : &pair->send_height,
                    p.outline.corner, p.outline.count);
    double jacobian = hpr_frame_jacobian(p.outer);
    double tolerance = demand->tolerance;
    hpr_events events;
    hpr_cuts pieces;
    hpr_cuts_init(&pieces, outer);
    hpr_events_find(pair, p.outer, outer, &p.outline, p.inner->normal, &events);
    /* Many lines make more cells than a loose tolerance needs: those that matter are found by halving. */
    bool cut = tolerance < tight || events.count <= FEW_LINES;
    for (int i = 0; i < events.count && cut; i++)
        hpr_cuts_along(&pieces, &events.line[i]);
    choose_nodes(&p, tolerance);
    for (int k = 0; k < pieces.count; k++)
        add_polygon(&p, &pieces.piece[k]);
    refine(&p, jacobian);
    p.result.exchange_m2 = p.value * jacobian;
    p.result.error_m2 = p.error * jacobian;
    return p.result;
}
