#include "quadrature/polar.h"

#include "quadrature/analytic.h"
#include "quadrature/lanes_sums.h"

/* The points are seen from x; y0 is the nearest. */
typedef struct view {
    const hpr_polar *polar;
    hpr_vec3 nearest, offset; /* y0 from the origin, y0 from x */
    double distance;          /* r0 */
    double s0, t0, height0;   /* of y0, parameters from the origin on */
} view;

static const double panel_length = 2.5;

static int panels(double length)
{
    return length > panel_length ? (int)ceil(length / panel_length) : 1;
}

/* Sum of half axes of the largest ellipse around a panel inside |Im| < pi/2. */
static double panel_ellipse(double length)
{
    double b = 3.14159265358979323846 / length;
    return b + sqrt(b * b + 1);
}

static int panel_nodes(const hpr_polar *polar, double ellipse, double growth)
{
    static const double strength =
        4000; /* observed: 99 of 100 points err by less than a tenth of the tolerance */
    const hpr_convergence c = {ellipse, strength, 1, growth, polar->degree + 2};
    int nodes = hpr_convergence_nodes(&c, polar->tolerance);
    return nodes < HPR_NODES_MAX ? nodes : HPR_NODES_MAX;
}

/* Growth of a polynomial on [a, b] = d sinh[low, high] to the ellipse around the panel from `begin`. */
static double panel_growth(double ellipse, double d, double a, double b, double begin, double length)
{
    double beyond = length / 2 * ((ellipse + 1 / ellipse) / 2 - 1),
           high = length / 2 * (ellipse - 1 / ellipse) / 2;
    double left = (d * sinh(begin - beyond) - a) / (b - a);
    double right = (d * sinh(begin + length + beyond) - a) / (b - a), middle = begin + length / 2;
    double most = fmax(left < 0 ? hpr_ellipse(left, 0) : 1, right > 1 ? hpr_ellipse(right, 0) : 1);
    double re = (d * sinh(middle) * cos(high) - a) / (b - a), im = d * cosh(middle) * sin(high) / (b - a);
    return fmax(most, hpr_ellipse(re, im));
}

static void flush(const hpr_polar *polar)
{
    if (polar->points->count)
        polar->sink(polar->user, polar->group);
    polar->points->count = 0;
}

/* A direction from y0: what changes per length along it. */
typedef struct ray {
    hpr_vec3 direction;
    double s, t, height;
} ray;

static ray make_ray(const hpr_polar *polar, hpr_vec3 direction)
{
    double s = hpr_dot(polar->dual1, direction), t = hpr_dot(polar->dual2, direction);
    double rise = polar->joined ? s * polar->height.along1 + t * polar->height.along2
                                : hpr_dot(polar->outer_normal, direction);
    return (ray){direction, s, t, rise};
}

/* Nodes of tau as parts of the way to the edge: rho = reach * part, and weights of part dpart; up to the end
 * of the last eight. */
typedef struct steps {
    int count;
    double part[HPR_NODES_MAX], weight[HPR_NODES_MAX];
} steps;

/* Points at the distances reach * part along a ray from y0, weights times `factor`. */
static void add_points(const view *v, const ray *ray, const steps *st, double reach, double factor)
{
    const hpr_polar *polar = v->polar;
    const hpr_vec3 offset = v->offset, by = hpr_scale(ray->direction, reach);
    const hpr_point_line line = {
        .at = {polar->origin[0] + v->s0, polar->origin[1] + v->t0, offset.x, offset.y, offset.z, v->height0},
        .by = {reach * ray->s, reach * ray->t, by.x, by.y, by.z, reach * ray->height},
        .count = (size_t)st->count,
        .u = st->part,
        .weight = st->weight,
        .scale = factor,
        .least = -INFINITY};
    hpr_sums_of(polar->group->isa)->line(&line, polar->points);
}

/* The part of a triangle from y0 to an edge between two directions, by sigma. */
typedef struct sector {
    hpr_vec3 normal, along; /* from y0 to the edge's line, along the edge */
    double distance;        /* d */
    double begin, end;      /* of the whole edge, along it */
    double low, width;      /* of sigma */
} sector;

/* Panel k of `count` over tau; all rays take the steps that suit the longest. */
static void make_steps(const view *v, double length, int k, int count, steps *st)
{
    const hpr_polar *polar = v->polar;
    double width = length / count, low = k * width, top = sinh(length), ellipse = panel_ellipse(width);
    double growth = panel_growth(ellipse, 1 / top, 0, 1, low, width);
    st->count = panel_nodes(polar, ellipse, growth);
    const hpr_gauss_rule *gauss = &polar->gauss->legendre[st->count];
    for (int j = 0; j < st->count; j++) {
        double sine = sinh(low + width * gauss->node[j]);
        st->part[j] = sine / top;
        st->weight[j] = gauss->weight[j] * width * st->part[j] * sqrt(1 + sine * sine) / top;
    }
    for (size_t j = (size_t)st->count; j < hpr_lanes_padded((size_t)st->count); j++)
        st->part[j] = st->weight[j] = 0;
}

static void add_panel(const view *v, const sector *sec, const steps *st, int nodes)
{
    const hpr_polar *polar = v->polar;
    const hpr_gauss_rule *gauss = &polar->gauss->legendre[nodes];
    if (polar->points->count + nodes * st->count > HPR_POINTS_MAX)
        flush(polar);
    for (int i = 0; i < nodes; i++) {
        double sigma = sec->low + sec->width * gauss->node[i], cosine = cosh(sigma);
        ray ray = make_ray(polar, hpr_madd(hpr_scale(sec->normal, 1 / cosine), tanh(sigma), sec->along));
        double reach = sec->distance * cosine;
        double factor = sec->width * gauss->weight[i] / cosine * reach * reach / polar->jacobian;
        add_points(v, &ray, st, reach, factor);
    }
}

static void add_sector(const view *v, const sector *sec)
{
    const hpr_polar *polar = v->polar;
    double reach = fmax(cosh(sec->low), cosh(sec->low + sec->width)) * sec->distance;
    double length = asinh(reach / v->distance), ellipse = panel_ellipse(sec->width);
    double growth = panel_growth(ellipse, sec->distance, sec->begin, sec->end, sec->low, sec->width);
    int count = panels(length), nodes = panel_nodes(polar, ellipse, growth);
    for (int k = 0; k < count; k++) {
        steps st;
        make_steps(v, length, k, count, &st);
        add_panel(v, sec, &st, nodes);
    }
}

/* The triangle from y0 to the edge from a to b, both relative to y0. */
static void add_triangle(const view *v, hpr_vec3 a, hpr_vec3 b)
{
    static const double nothing = 1e-18;
    hpr_vec3 along = hpr_sub(b, a);
    double length = hpr_length(along);
    if (!(length > 0))
        return;
    along = hpr_scale(along, 1 / length);
    double turn = hpr_dot(hpr_cross(a, along), v->polar->normal), distance = fabs(turn);
    if (!(distance > nothing * (v->distance + length)))
        return;
    sector sec = {.normal = hpr_scale(hpr_cross(along, v->polar->normal), turn > 0 ? 1 : -1),
                  .along = along,
                  .distance = distance};
    sec.begin = hpr_dot(a, along);
    sec.end = hpr_dot(b, along);
    double low = asinh(sec.begin / distance), high = asinh(sec.end / distance);
    int count = panels(high - low);
    sec.width = (high - low) / count;
    for (int k = 0; k < count; k++) {
        sec.low = low + k * sec.width;
        add_sector(v, &sec);
    }
}

static view make_view(const hpr_polar *polar, hpr_vec3 x, hpr_vec3 nearest)
{
    view v = {.polar = polar, .nearest = nearest, .offset = hpr_sub(nearest, x)};
    v.distance = hpr_length(v.offset);
    v.s0 = hpr_dot(polar->dual1, nearest);
    v.t0 = hpr_dot(polar->dual2, nearest);
    v.height0 = polar->joined ? v.s0 * polar->height.along1 + v.t0 * polar->height.along2
                              : hpr_dot(polar->outer_normal, v.offset);
    return v;
}

/* Nearest point of the segment a to b. */
static hpr_vec3 nearest_on_edge(hpr_vec3 p, hpr_vec3 a, hpr_vec3 b)
{
    hpr_vec3 along = hpr_sub(b, a);
    double square = hpr_dot(along, along), f = square > 0 ? hpr_dot(hpr_sub(p, a), along) / square : 0;
    return f <= 0 ? a : f >= 1 ? b : hpr_madd(a, f, along);
}

/* Nearest point of the polygon to a point of its plane; *edge: the edge that it is on, -1: inside. */
static hpr_vec3 nearest_in_polygon(const hpr_polar *polar, hpr_vec3 p, int *edge)
{
    double least = INFINITY, sides[2] = {0, 0};
    hpr_vec3 nearest = p;
    *edge = -1;
    for (int i = 0; i < polar->count; i++) {
        hpr_vec3 a = polar->corner[i], b = polar->corner[(i + 1) % polar->count];
        hpr_vec3 q = nearest_on_edge(p, a, b), gap = hpr_sub(q, p);
        double turn = hpr_dot(hpr_cross(hpr_sub(b, a), hpr_sub(p, a)), polar->normal);
        sides[turn > 0] += turn != 0;
        if (hpr_dot(gap, gap) < least) {
            least = hpr_dot(gap, gap);
            nearest = q;
            *edge = i;
        }
    }
    if (sides[0] == 0 || sides[1] == 0) {
        *edge = -1;
        return p;
    }
    return nearest;
}

/* sigma along the segment itself: its points at the distance d cosh(sigma) from x. */
static void segment_points(const hpr_polar *polar, hpr_vec3 x)
{
    hpr_vec3 a = polar->corner[0], along = hpr_sub(polar->corner[1], a);
    double length = hpr_length(along);
    along = hpr_scale(along, 1 / length);
    hpr_vec3 from = hpr_sub(a, x), foot = hpr_madd(from, -hpr_dot(from, along), along);
    double distance = hpr_length(foot), begin = hpr_dot(from, along);
    view v = make_view(polar, x, hpr_add(x, foot));
    ray ray = make_ray(polar, along);
    double low = asinh(begin / distance), high = asinh((begin + length) / distance);
    int count = panels(high - low);
    double width = (high - low) / count, ellipse = panel_ellipse(width);
    for (int k = 0; k < count; k++) {
        double start = low + k * width;
        double growth = panel_growth(ellipse, distance, begin, begin + length, start, width);
        int nodes = panel_nodes(polar, ellipse, growth);
        const hpr_gauss_rule *gauss = &polar->gauss->legendre[nodes];
        if (polar->points->count + nodes > HPR_POINTS_MAX)
            flush(polar);
        steps st = {.count = nodes};
        for (int i = 0; i < nodes; i++) {
            double sine = sinh(start + width * gauss->node[i]);
            st.part[i] = sine;
            st.weight[i] = width * gauss->weight[i] * sqrt(1 + sine * sine);
        }
        add_points(&v, &ray, &st, distance, distance / polar->jacobian);
    }
}

double hpr_polar_height(const hpr_polar *polar, hpr_vec3 x)
{
    double z = hpr_dot(polar->normal, hpr_sub(x, polar->corner[0])), least = INFINITY;
    hpr_vec3 foot = hpr_madd(x, -z, polar->normal);
    for (int i = 0; i < polar->count; i++) {
        hpr_vec3 q = nearest_on_edge(foot, polar->corner[i], polar->corner[(i + 1) % polar->count]);
        hpr_vec3 gap = hpr_sub(q, foot);
        if (hpr_dot(gap, gap) < least) {
            least = hpr_dot(gap, gap);
            z = hpr_dot(polar->normal, hpr_sub(x, q));
        }
    }
    return z;
}

double hpr_polar_error(const hpr_polygon *inner, double tolerance)
{
    static const double share = 0.1; /* of a panel's error, on average over many points */
    return share * tolerance * (inner->count > 2 ? 2 : 1);
}

void hpr_polar_points(const hpr_polar *polar, hpr_vec3 x, double z)
{
    polar->points->count = 0;
    if (polar->count == 2) {
        segment_points(polar, x);
    } else {
        int edge;
        hpr_vec3 foot = hpr_madd(x, -z, polar->normal);
        view v = make_view(polar, x, nearest_in_polygon(polar, foot, &edge));
        for (int i = 0; i < polar->count; i++) {
            if (i != edge)
                add_triangle(&v, hpr_sub(polar->corner[i], v.nearest),
                             hpr_sub(polar->corner[(i + 1) % polar->count], v.nearest));
        }
    }
    flush(polar);
}
