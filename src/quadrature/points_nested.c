/* The nested rule's points: for each outer point the inner set in polar coordinates (polar.h); for a constant
 * over a polygon, where it loses nothing to cancellation, the closed form of direct/lambert.h. */
#include "direct/lambert.h"
#include "quadrature/polar.h"

#include <float.h>

typedef struct nest {
    const hpr_nested *rule;
    const hpr_element_frame *outer, *inner;
    hpr_affine height; /* of outer points */
    hpr_vec3 offset;   /* from the inner to the outer origin */
    hpr_polar polar;
    hpr_points *points; /* of the outer side */
} nest;

static void set_polar(nest *n, const hpr_affine *inner_height)
{
    const hpr_nested *rule = n->rule;
    hpr_polar *p = &n->polar;
    hpr_vec3 across = hpr_cross(n->inner->edge1, n->inner->edge2);
    double square = hpr_dot(across, across);
    p->count = rule->inner.count;
    for (int i = 0; i < p->count; i++) {
        const double d[2] = {rule->inner.corner[i][0] - rule->inner_origin[0],
                             rule->inner.corner[i][1] - rule->inner_origin[1]};
        p->corner[i] = hpr_frame_vector(n->inner, d);
    }
    for (int i = 0; i < 2; i++)
        p->origin[i] = rule->inner_origin[i];
    p->normal = n->inner->normal;
    p->dual1 = hpr_scale(hpr_cross(n->inner->edge2, across), 1 / square);
    p->dual2 = hpr_scale(hpr_cross(across, n->inner->edge1), 1 / square);
    p->joined = rule->joined;
    p->height = *inner_height;
    p->outer_normal = n->outer->normal;
    p->jacobian = p->count == 2 ? hpr_length(hpr_sub(p->corner[1], p->corner[0])) : sqrt(square);
    p->tolerance = rule->tolerance;
    p->degree = hpr_total_degree(n->inner);
}

/* Gauss point i, j of the outer set. */
static void outer_point(const hpr_gauss_table *gauss, const hpr_nested *rule, int i, int j, double place[2],
                        double *weight)
{
    const double(*c)[2] = rule->outer;
    *weight = rule->weight;
    if (rule->dimension == 0) {
        place[0] = c[0][0];
        place[1] = c[0][1];
        return;
    }
    double u = gauss->legendre[rule->nodes[0]].node[i];
    *weight *= gauss->legendre[rule->nodes[0]].weight[i];
    if (rule->dimension == 1) {
        for (int a = 0; a < 2; a++)
            place[a] = c[0][a] + u * (c[1][a] - c[0][a]);
        return;
    }
    double v = gauss->legendre[rule->nodes[1]].node[j], by_u[2], by_v[2];
    for (int a = 0; a < 2; a++) {
        by_u[a] = (1 - v) * (c[1][a] - c[0][a]) + v * (c[2][a] - c[3][a]);
        by_v[a] = (1 - u) * (c[3][a] - c[0][a]) + u * (c[2][a] - c[1][a]);
        place[a] = c[0][a] + v * (c[3][a] - c[0][a]) + u * by_u[a];
    }
    *weight *= gauss->legendre[rule->nodes[1]].weight[j] * fabs(by_u[0] * by_v[1] - by_u[1] * by_v[0]);
}

static void add_outer(nest *n, const double place[2], double weight)
{
    hpr_points *points = n->points;
    int k = points->count++;
    points->s[k] = place[0];
    points->t[k] = place[1];
    points->x[k] = points->y[k] = points->z[k] = 0;
    points->weight[k] = weight;
}

/* Hands over the outer points whose weights hold the closed form, with one inner point at distance 1. */
static void flush_closed(nest *n)
{
    hpr_points *inner = n->polar.points;
    if (!n->points->count)
        return;
    inner->count = 1;
    inner->s[0] = inner->t[0] = 0.25;
    inner->x[0] = inner->weight[0] = 1;
    inner->y[0] = inner->z[0] = 0;
    n->polar.sink(n->polar.user, n->polar.group);
    n->points->count = 0;
}

/* In the weight measure: height over the outer plane times that of x, over r^4. */
static bool polygon_in_closed_form(const nest *n, hpr_vec3 x, double z, double most, double *integral)
{
    const hpr_polar *p = &n->polar;
    hpr_vec3 corner[HPR_POLYGON_MAX];
    for (int i = 0; i < p->count; i++)
        corner[i] = hpr_sub(p->corner[i], x);
    hpr_lambert closed = hpr_lambert_above(n->outer->normal, corner, (size_t)p->count);
    if (!(closed.rounding <= most))
        closed = hpr_lambert_beside(n->outer->normal, p->normal, z, corner, (size_t)p->count);
    *integral = closed.fraction * 3.14159265358979323846 / p->jacobian;
    return closed.rounding <= most;
}

/* True if the closed form serves. */
static bool closed_form(nest *n, hpr_vec3 x, double z, const double place[2], double weight)
{
    static const double least = 64, share = 0.01;
    const hpr_polar *p = &n->polar;
    double most = fmax(least, share * p->tolerance / DBL_EPSILON), integral;
    if (p->degree || !(p->count > 2 ? polygon_in_closed_form(n, x, z, most, &integral)
                                    : hpr_polar_closed(p, x, most, &integral)))
        return false;
    if (n->points->count == HPR_POINTS_MAX)
        flush_closed(n);
    add_outer(n, place, weight * integral * (p->count > 2 ? 1 : z));
    return true;
}

static void at_outer_point(nest *n, int i, int j)
{
    double place[2], weight;
    outer_point(n->polar.gauss, n->rule, i, j, place, &weight);
    const double d[2] = {place[0] - n->rule->outer_origin[0], place[1] - n->rule->outer_origin[1]};
    hpr_vec3 x = hpr_add(n->offset, hpr_frame_vector(n->outer, d));
    double z =
        n->rule->joined ? d[0] * n->height.along1 + d[1] * n->height.along2 : hpr_polar_height(&n->polar, x);
    if (!(z > 0) || closed_form(n, x, z, place, weight))
        return;
    flush_closed(n);
    add_outer(n, place, weight * z);
    hpr_polar_points(&n->polar, x, z);
    n->points->count = 0;
}

void hpr_points_nested(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *any,
                       hpr_group *group, hpr_group_sink sink, void *user)
{
    const hpr_nested *rule = &any->nested;
    bool by_recv = rule->recv_is_outer;
    nest n = {.rule = rule,
              .outer = by_recv ? &pair->recv : &pair->send,
              .inner = by_recv ? &pair->send : &pair->recv,
              .height = by_recv ? pair->recv_height : pair->send_height,
              .polar = {.gauss = gauss,
                        .points = by_recv ? &group->send : &group->recv,
                        .group = group,
                        .sink = sink,
                        .user = user},
              .points = by_recv ? &group->recv : &group->send};
    set_polar(&n, by_recv ? &pair->send_height : &pair->recv_height);
    if (!rule->joined)
        n.offset = hpr_sub(hpr_frame_point(n.outer, rule->outer_origin[0], rule->outer_origin[1]),
                           hpr_frame_point(n.inner, rule->inner_origin[0], rule->inner_origin[1]));
    group->scale = 1;
    n.points->count = 0;
    int first = rule->dimension > 0 ? rule->nodes[0] : 1, second = rule->dimension > 1 ? rule->nodes[1] : 1;
    for (int j = 0; j < second; j++) {
        for (int i = 0; i < first; i++)
            at_outer_point(&n, i, j);
    }
    flush_closed(&n);
}
