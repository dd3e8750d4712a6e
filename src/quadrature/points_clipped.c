/*
 * The clipped rule's points: for each outer point the visible pieces of the inner polygon, each as a fan of
 * triangles with Gauss points in collapsed coordinates; triangles that are large for their distance are
 * bisected. Outer points that see all of it share its inner points. Constants take Lambert's formula instead.
 */
#include "quadrature/between.h"
#include "quadrature/cuts.h"
#include "quadrature/lanes_sums.h"
#include "quadrature/rule.h"

enum { MAX_HALVINGS = 48, CAP = 8 };

typedef struct fan {
    const hpr_gauss_table *gauss;
    const hpr_sums *sums;
    const hpr_element_frame *inner;
    hpr_vec3 outer_normal, x; /* x: the outer point, to which positions are relative */
    hpr_vec3 dual1, dual2;    /* s = dual1 . (y - origin), t = dual2 . (y - origin) */
    double jacobian, tolerance;
    int degree;
    hpr_group *group;
    hpr_points *points;
    hpr_group_sink sink;
    void *user;
} fan;

static void flush(fan *f)
{
    if (f->points->count)
        f->sink(f->user, f->group);
    f->points->count = 0;
}

/* Parameters, position and height over the outer plane of a point `y` from x, or of a difference. */
static void set_values(const fan *f, hpr_vec3 y, hpr_vec3 offset, double value[6])
{
    value[0] = hpr_dot(f->dual1, offset);
    value[1] = hpr_dot(f->dual2, offset);
    hpr_vec3_store(value + 2, y);
    value[5] = hpr_dot(f->outer_normal, y);
}

static void add_gauss(fan *f, const hpr_vec3 corner[3], double area, int nodes)
{
    const hpr_gauss_rule *along = &f->gauss->legendre[nodes], *across = &f->gauss->jacobi[nodes];
    hpr_vec3 e1 = hpr_sub(corner[1], corner[0]), e2 = hpr_sub(corner[2], corner[0]);
    double at[6], by_u[6], by_v[6];
    set_values(f, corner[0], hpr_add(corner[0], hpr_sub(f->x, f->inner->origin)), at);
    set_values(f, e1, e1, by_u);
    set_values(f, e2, e2, by_v);
    if (f->points->count + nodes * nodes > HPR_POINTS_MAX)
        flush(f);
    hpr_point_line line = {.count = (size_t)nodes, .u = along->node, .weight = along->weight};
    for (int j = 0; j < nodes; j++) {
        double v = across->node[j];
        for (int k = 0; k < 6; k++) {
            line.at[k] = at[k] + v * by_v[k];
            line.by[k] = (1 - v) * by_u[k];
        }
        line.scale = 2 * area / f->jacobian * across->weight[j];
        f->sums->line(&line, f->points);
    }
}

static void add_triangle(fan *f, const hpr_vec3 corner[3], int depth)
{
    hpr_vec3 normal = hpr_cross(hpr_sub(corner[1], corner[0]), hpr_sub(corner[2], corner[0]));
    double area = hpr_length(normal) / 2;
    if (!(area > 0))
        return;
    const hpr_vec3 origin = {0, 0, 0};
    double distance = hpr_polygon_distance(corner, 3, &origin, 1), length = 0;
    int longest = 0;
    for (int i = 0; i < 3; i++) {
        double side = hpr_length(hpr_sub(corner[(i + 1) % 3], corner[i]));
        if (side > length) {
            length = side;
            longest = i;
        }
    }
    int nodes = hpr_kernel_nodes(length, distance, f->tolerance);
    if (nodes > CAP && depth < MAX_HALVINGS) {
        hpr_vec3 a = corner[longest], b = corner[(longest + 1) % 3], c = corner[(longest + 2) % 3];
        hpr_vec3 middle = hpr_scale(hpr_add(a, b), 0.5);
        add_triangle(f, (const hpr_vec3[3]){middle, c, a}, depth + 1);
        add_triangle(f, (const hpr_vec3[3]){middle, b, c}, depth + 1);
        return;
    }
    nodes = nodes < CAP ? nodes : CAP;
    add_gauss(f, corner, area, nodes + hpr_polynomial_nodes(f->degree, f->tolerance));
}

/* True, and nothing added, if the point sees all of the outline and that is to be `deferred`. */
static bool polynomial_inner(fan *f, const hpr_pair *pair, const hpr_convex *outline, bool deferred)
{
    hpr_visible visible;
    visible.hidden = NULL;
    hpr_visible_part(f->x, outline, f->inner->normal, pair->blocker, pair->chosen, pair->blocker_count,
                     &visible);
    if (visible.whole && deferred)
        return true;
    f->points->count = 0;
    for (int p = 0; p < visible.count; p++) {
        const hpr_convex *piece = &visible.piece[p];
        for (int k = 1; k + 1 < piece->count; k++)
            add_triangle(f, (const hpr_vec3[3]){piece->corner[0], piece->corner[k], piece->corner[k + 1]}, 0);
    }
    flush(f);
    return false;
}

static void add_at(hpr_points *points, const hpr_outer_point *x, hpr_vec3 position, double weight)
{
    int k = points->count++;
    points->s[k] = x->s;
    points->t[k] = x->t;
    points->x[k] = position.x;
    points->y[k] = position.y;
    points->z[k] = position.z;
    points->weight[k] = weight;
}

static void set_one(hpr_points *points, const hpr_outer_point *x, double weight)
{
    points->count = 0;
    add_at(points, x, (hpr_vec3){0, 0, 0}, weight);
}

/* Lambert's formula stands in the weight, next to one inner point at distance 1. */
static void constant_inner(fan *f, const hpr_pair *pair, const hpr_element_frame *outer,
                           const hpr_convex *outline, const hpr_outer_point *x, hpr_points *outer_points)
{
    bool complete = true; /* the choice of rules has seen to it */
    double fraction = hpr_inner_fraction(pair, outer, f->inner, outline, x->position, &complete);
    hpr_outer_point anywhere = {.s = 0.25, .t = 0.25};
    set_one(outer_points, x, x->weight * fraction * 3.14159265358979323846 / f->jacobian);
    set_one(f->points, &anywhere, 1);
    f->points->x[0] = 1;
    f->sink(f->user, f->group);
}

/* Nodes per axis of the inner polygon's cells, seen from anywhere in the outer cell; 0 if too near. */
static int common_nodes(const fan *f, const hpr_element_frame *outer, const hpr_cell *outer_cell,
                        const hpr_convex *outline)
{
    hpr_vec3 corner[4];
    double length = 0;
    int count = hpr_cell_corners(outer, outer_cell, corner);
    double distance = hpr_polygon_distance(corner, count, outline->corner, outline->count);
    for (int i = 0; i < outline->count; i++)
        length =
            fmax(length, hpr_length(hpr_sub(outline->corner[(i + 1) % outline->count], outline->corner[i])));
    int nodes = hpr_kernel_nodes(length, distance, f->tolerance);
    return nodes > CAP ? 0 : nodes;
}

/* All inner points of one cell after the other, against the outer points that stand in the group. */
static void add_common(fan *f, const hpr_rule *rule, const hpr_affine *inner_height, int nodes)
{
    const hpr_box whole = hpr_box_unit();
    hpr_cell cell[HPR_POLYGON_MAX];
    int count = hpr_cuts_cells(f->inner->shape, &rule->inner, cell);
    for (int c = 0; c < count; c++) {
        bool triangle = cell[c].shape == HPR_SHAPE_TRIANGLE;
        int n = nodes + hpr_polynomial_nodes(triangle ? f->degree : f->inner->degree, f->tolerance);
        f->points->count = 0;
        for (int k = 0; k < n * n; k++) {
            hpr_outer_point y = hpr_outer_at(f->gauss, f->inner, &cell[c], &whole, n, k);
            double height = hpr_affine_at(inner_height, y.s, y.t);
            add_at(f->points, &y, y.position, y.weight * fmax(height, 0));
        }
        f->sink(f->user, f->group);
    }
}

void hpr_points_clipped(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                        hpr_group *group, hpr_group_sink sink, void *user)
{
    bool recv_is_outer = rule->recv_is_outer;
    const hpr_element_frame *outer = recv_is_outer ? &pair->recv : &pair->send;
    const hpr_element_frame *inner = recv_is_outer ? &pair->send : &pair->recv;
    const hpr_affine *height = recv_is_outer ? &pair->recv_height : &pair->send_height;
    const hpr_affine *inner_height = recv_is_outer ? &pair->send_height : &pair->recv_height;
    const hpr_cell *cell = recv_is_outer ? &rule->recv : &rule->send;
    int nodes = recv_is_outer ? rule->recv_nodes[0] : rule->send_nodes[0];
    hpr_points *outer_points = recv_is_outer ? &group->recv : &group->send;
    hpr_vec3 across = hpr_cross(inner->edge1, inner->edge2);
    double square = hpr_dot(across, across);
    fan f = {.gauss = gauss,
             .sums = hpr_sums_of(group->isa),
             .inner = inner,
             .outer_normal = outer->normal,
             .dual1 = hpr_scale(hpr_cross(inner->edge2, across), 1 / square),
             .dual2 = hpr_scale(hpr_cross(across, inner->edge1), 1 / square),
             .jacobian = hpr_frame_jacobian(inner),
             .tolerance = rule->tolerance,
             .degree = rule->inner_degree,
             .group = group,
             .points = recv_is_outer ? &group->send : &group->recv,
             .sink = sink,
             .user = user};
    hpr_convex outline = {.count = rule->inner.count};
    for (int i = 0; i < outline.count; i++)
        outline.corner[i] = hpr_frame_point(inner, rule->inner.corner[i][0], rule->inner.corner[i][1]);
    hpr_vec3 box_corner[4];
    hpr_between memory;
    int corners = hpr_outer_corners(outer, cell, &rule->box, box_corner);
    const hpr_pair past =
        nodes > 1 ? hpr_between_choose(pair, box_corner, corners, &outline, &memory) : *pair;
    group->scale = 1;
    bool sees_all[HPR_POINTS_MAX] = {false};
    int common = common_nodes(&f, outer, cell, &outline), all_count = 0;
    for (int k = 0; k < nodes * nodes; k++) {
        hpr_outer_point x = hpr_outer_at(gauss, outer, cell, &rule->box, nodes, k);
        double z = hpr_affine_at(height, x.s, x.t);
        if (!(z > 0))
            continue;
        f.x = x.position;
        if (rule->inner_degree == 0) {
            constant_inner(&f, &past, outer, &outline, &x, outer_points);
        } else {
            set_one(outer_points, &x, x.weight * z);
            sees_all[k] = polynomial_inner(&f, &past, &outline, common > 0);
            all_count += sees_all[k];
        }
    }
    outer_points->count = 0;
    for (int k = 0; k < nodes * nodes && all_count; k++) {
        hpr_outer_point x = hpr_outer_at(gauss, outer, cell, &rule->box, nodes, k);
        if (sees_all[k])
            add_at(outer_points, &x, x.position, x.weight * hpr_affine_at(height, x.s, x.t));
    }
    if (all_count)
        add_common(&f, rule, inner_height, common);
}
