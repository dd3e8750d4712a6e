/*
 * The nested rule's points: for each outer point x the inner polygon is integrated in polar coordinates
 * around the foot of x on its plane, edge by edge (signed sectors). With z the height of x, d the distance of
 * the foot from the edge's line, along the edge p = d sinh(s), angle dψ = ds / cosh(s), reach R = d cosh(s),
 *   radius r = z sinh(τ), 0 <= τ <= asinh(R / z), area r dr dψ,
 * both s and τ in panels of Gauss points: the integrand is analytic in |Im s|, |Im τ| < π/2 however small z
 * and d are. Source: sinh transformation of Johnston & Elliott 2005; for a constant the closed form of
 * direct/lambert.h.
 */
#include "quadrature/rule.h"

typedef struct polar {
    const hpr_gauss_table *gauss;
    const hpr_pair *pair;
    const hpr_rule *rule;
    const hpr_element_frame *inner;
    hpr_affine inner_height; /* of inner points over the outer plane */
    double jacobian;         /* area per parameter measure of the inner side */
    int nodes;               /* per panel */
    double z;                /* height of the outer point */
    hpr_vec3 foot;
    hpr_group *group;
    hpr_points *outer_points, *inner_points;
    hpr_group_sink sink;
    void *user;
} polar;

static const double panel_length = 3;

/* Nodes per panel: kernel analytic to π/2 from the axis, Bernstein ellipse as in rules.c, and the polynomial.
 */
static int panel_nodes(double tolerance, int degree)
{
    double b = 3.14159265358979323846 / panel_length, rho = b + sqrt(b * b + 1);
    int nodes = (int)ceil(log(64 / tolerance) / (2 * log(rho))) + (degree + 1) / 2;
    return nodes < HPR_NODES_MAX ? nodes : HPR_NODES_MAX;
}

static int panels(double length)
{
    return length > panel_length ? (int)ceil(length / panel_length) : 1;
}

/* Inner points along one ray, for the panel [low, low + width] of τ. */
static void add_ray(const polar *p, hpr_vec3 direction, double weight, double low, double width)
{
    const hpr_gauss_rule *gauss = &p->gauss->legendre[p->nodes];
    hpr_points *points = p->inner_points;
    hpr_vec3 across = hpr_cross(p->inner->edge1, p->inner->edge2);
    double square = hpr_dot(across, across);
    for (int i = 0; i < p->nodes; i++) {
        double tau = low + width * gauss->node[i], sine = sinh(tau), r = p->z * sine;
        hpr_vec3 y = hpr_madd(p->foot, r, direction);
        double s = hpr_dot(hpr_cross(y, p->inner->edge2), across) / square;
        double t = hpr_dot(hpr_cross(p->inner->edge1, y), across) / square;
        int k = points->count++;
        points->s[k] = s;
        points->t[k] = t;
        points->x[k] = r * direction.x;
        points->y[k] = r * direction.y;
        points->z[k] = r * direction.z;
        points->weight[k] = weight * width * gauss->weight[i] * p->z * p->z * sine * cosh(tau) / p->jacobian *
                            hpr_affine_at(&p->inner_height, s, t);
    }
}

static void add_panel(const polar *p, hpr_vec3 normal, hpr_vec3 along, double distance, double sign,
                      double low, double width)
{
    const hpr_gauss_rule *gauss = &p->gauss->legendre[p->nodes];
    double longest = 0;
    for (int end = 0; end < 2; end++)
        longest = fmax(longest, asinh(distance * cosh(low + end * width) / p->z));
    int count = panels(longest);
    for (int k = 0; k < count; k++) {
        p->inner_points->count = 0;
        for (int i = 0; i < p->nodes; i++) {
            double s = low + width * gauss->node[i], cosine = cosh(s);
            double reach = asinh(distance * cosine / p->z);
            /* unit vector to the point d sinh(s) along the edge */
            hpr_vec3 direction = hpr_madd(hpr_scale(normal, 1 / cosine), tanh(s), along);
            add_ray(p, direction, sign * width * gauss->weight[i] / cosine, k * reach / count, reach / count);
        }
        p->sink(p->user, p->group);
    }
}

/* The signed sector between the foot and the edge from a to b (positions relative to the foot, in the plane).
 */
static void add_edge(const polar *p, hpr_vec3 a, hpr_vec3 b)
{
    static const double nothing = 1e-200;
    hpr_vec3 along = hpr_sub(b, a);
    double length = hpr_length(along);
    if (!(length > 0))
        return;
    along = hpr_scale(along, 1 / length);
    double turn = hpr_dot(hpr_cross(a, along), p->inner->normal), distance = fabs(turn);
    if (distance <= nothing)
        return;
    /* The unit vector from the foot to the line: along turned by a right angle, so that it keeps its
     * direction when d is tiny. */
    hpr_vec3 normal = hpr_scale(hpr_cross(along, p->inner->normal), turn > 0 ? 1 : -1);
    double low = asinh(hpr_dot(a, along) / distance), high = asinh(hpr_dot(b, along) / distance);
    int count = panels(high - low);
    for (int k = 0; k < count; k++)
        add_panel(p, normal, along, distance, turn > 0 ? 1 : -1, low + k * (high - low) / count,
                  (high - low) / count);
}

static void integrate_inner(const polar *p)
{
    const hpr_polygon *inner = &p->rule->inner;
    for (int i = 0; i < inner->count; i++) {
        const double *a = inner->corner[i], *b = inner->corner[(i + 1) % inner->count];
        hpr_vec3 from = hpr_frame_vector(p->inner, a), to = hpr_frame_vector(p->inner, b);
        add_edge(p, hpr_sub(from, p->foot), hpr_sub(to, p->foot));
    }
}

static void set_point(hpr_points *points, int k, const hpr_outer_point *point, hpr_vec3 position,
                      double weight)
{
    points->s[k] = point->s;
    points->t[k] = point->t;
    points->x[k] = position.x;
    points->y[k] = position.y;
    points->z[k] = position.z;
    points->weight[k] = weight;
}

/* Constant inner function: the closed form stands in the outer weight, next to one inner point at distance 1.
 */
static void constant_inner(const polar *p, const hpr_element_frame *outer, const hpr_cell *cell, int nodes)
{
    const hpr_rule *rule = p->rule;
    hpr_convex polygon = {.count = rule->inner.count};
    bool complete = true; /* the choice of rules has seen to it */
    for (int i = 0; i < polygon.count; i++)
        polygon.corner[i] = hpr_frame_point(p->inner, rule->inner.corner[i][0], rule->inner.corner[i][1]);
    p->outer_points->count = nodes * nodes;
    for (int k = 0; k < nodes * nodes; k++) {
        hpr_outer_point point = hpr_outer_at(p->gauss, outer, cell, &rule->box, nodes, k);
        double fraction = hpr_inner_fraction(p->pair, outer, p->inner, &polygon, point.position, &complete);
        set_point(p->outer_points, k, &point, (hpr_vec3){0, 0, 0},
                  point.weight * fraction * 3.14159265358979323846 / p->jacobian);
    }
    hpr_outer_point anywhere = {.s = 0.25, .t = 0.25};
    p->inner_points->count = 1;
    set_point(p->inner_points, 0, &anywhere, (hpr_vec3){1, 0, 0}, 1);
    p->sink(p->user, p->group);
}

void hpr_points_nested(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                       hpr_group *group, hpr_group_sink sink, void *user)
{
    bool recv_is_outer = rule->recv_is_outer;
    const hpr_element_frame *outer = recv_is_outer ? &pair->recv : &pair->send;
    const hpr_affine *outer_height = recv_is_outer ? &pair->recv_height : &pair->send_height;
    const hpr_cell *cell = recv_is_outer ? &rule->recv : &rule->send;
    int nodes = recv_is_outer ? rule->recv_nodes[0] : rule->send_nodes[0];
    polar p = {.gauss = gauss,
               .pair = pair,
               .rule = rule,
               .inner = recv_is_outer ? &pair->send : &pair->recv,
               .inner_height = recv_is_outer ? pair->send_height : pair->recv_height,
               .nodes = panel_nodes(rule->tolerance, rule->inner_degree),
               .group = group,
               .outer_points = recv_is_outer ? &group->recv : &group->send,
               .inner_points = recv_is_outer ? &group->send : &group->recv,
               .sink = sink,
               .user = user};
    p.jacobian = p.inner->area_m2 * (p.inner->shape == HPR_SHAPE_PARALLELOGRAM ? 1 : 2);
    group->scale = 1;
    if (rule->inner_degree == 0) {
        constant_inner(&p, outer, cell, nodes);
        return;
    }
    p.outer_points->count = 1;
    for (int k = 0; k < nodes * nodes; k++) {
        hpr_outer_point point = hpr_outer_at(gauss, outer, cell, &rule->box, nodes, k);
        p.z = hpr_affine_at(outer_height, point.s, point.t);
        /* the foot relative to the inner element's origin, like the edges */
        p.foot = hpr_madd(hpr_sub(point.position, p.inner->origin), -p.z, p.inner->normal);
        set_point(p.outer_points, 0, &point, hpr_scale(p.inner->normal, p.z), point.weight * p.z);
        if (p.z > 0)
            integrate_inner(&p);
    }
}
