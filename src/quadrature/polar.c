#include "quadrature/polar.h"

#include "quadrature/analytic.h"
#include "quadrature/lanes_sums.h"

#include <string.h>

/* The points are seen from x; y0 is the nearest. */
typedef struct view {
    const hpr_polar *polar;
    hpr_vec3 nearest, offset; /* y0 from the origin, y0 from x */
    double distance;          /* r0 */
    double s0, t0, height0;   /* of y0, parameters from the origin on */
} view;

static const double panel_length = 4; /* from 3 to 6 it takes about the same time */

/* Whether a panel needs more nodes than there are; not if it is so narrow that only sizes beyond all numbers
 * ask for them: then it takes what there are. */
static bool falls_in_two(int *nodes, double width)
{
    static const double narrow = 1e-3;
    if (*nodes > HPR_NODES_MAX && width > narrow)
        return true;
    *nodes = *nodes < HPR_NODES_MAX ? *nodes : HPR_NODES_MAX;
    return false;
}

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

/* Without regard to HPR_NODES_MAX. */
static int panel_nodes(int degree, double tolerance, double ellipse, double growth)
{
    static const double strength =
        4000; /* observed: 99 of 100 points err by less than a tenth of the tolerance */
    const hpr_convergence c = {ellipse, strength, 1, growth, degree + 2};
    return hpr_convergence_nodes(&c, tolerance);
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

/* Points at the distances reach * part along a ray from y0, weights times `factor`; part and weight are read
 * to the end of the last eight. */
typedef struct ray_points {
    int count;
    double reach, factor;
    const double *part, *weight;
} ray_points;

static void add_points(const view *v, const ray *ray, const ray_points *of)
{
    const hpr_polar *polar = v->polar;
    const hpr_vec3 offset = v->offset, by = hpr_scale(ray->direction, of->reach);
    const hpr_point_line line = {
        .at = {polar->origin[0] + v->s0, polar->origin[1] + v->t0, offset.x, offset.y, offset.z, v->height0},
        .by = {of->reach * ray->s, of->reach * ray->t, by.x, by.y, by.z, of->reach * ray->height},
        .count = (size_t)of->count,
        .u = of->part,
        .weight = of->weight,
        .scale = of->factor,
        .least = -INFINITY};
    hpr_sums_of(polar->group->isa)->line(&line, polar->points);
}

/* A triangle from y0 to an edge, and the part of it between two directions, by sigma. */
typedef struct sector {
    hpr_vec3 normal, along; /* from y0 to the edge's line, along the edge */
    double distance;        /* d */
    double begin, end;      /* of the whole edge, along it */
    double low, width;      /* of sigma */
    int nodes;
} sector;

/* A panel over tau, by nodes as parts of the way to the edge: rho = reach * part. */
typedef struct steps {
    double low, width, top; /* of tau, sinh of all of it */
    int nodes;
    double part[HPR_NODES_MAX], weight[HPR_NODES_MAX]; /* weight: of part dpart */
} steps;

/* sinh and cosh at the nodes of a panel, up to the end of the last eight. */
typedef struct hyperbola {
    double sine[HPR_NODES_MAX], cosine[HPR_NODES_MAX];
} hyperbola;

static void hyperbola_at(const hpr_polar *polar, double low, double width, int nodes, hyperbola *at)
{
    hpr_sums_of(polar->group->isa)
        ->hyperbolic(low, width, polar->gauss->legendre[nodes].node, (size_t)nodes, at->sine, at->cosine);
}

static void make_steps(const hpr_polar *polar, steps *st)
{
    hyperbola at;
    hyperbola_at(polar, st->low, st->width, st->nodes, &at);
    const double *weight = polar->gauss->legendre[st->nodes].weight, down = 1 / st->top;
    for (size_t j = 0; j < hpr_lanes_padded((size_t)st->nodes); j++) {
        st->part[j] = at.sine[j] * down;
        st->weight[j] = weight[j] * (st->width * down) * st->part[j] * at.cosine[j];
    }
}

static void add_panel(const view *v, const sector *sec, const steps *st)
{
    const hpr_polar *polar = v->polar;
    const double *weight = polar->gauss->legendre[sec->nodes].weight;
    hyperbola at;
    if (polar->points->count + sec->nodes * st->nodes > HPR_POINTS_MAX)
        flush(polar);
    hyperbola_at(polar, sec->low, sec->width, sec->nodes, &at);
    for (int i = 0; i < sec->nodes; i++) {
        double inverse = 1 / at.cosine[i], reach = sec->distance * at.cosine[i];
        ray ray =
            make_ray(polar, hpr_madd(hpr_scale(sec->normal, inverse), at.sine[i] * inverse, sec->along));
        double factor = sec->width * weight[i] * inverse * reach * reach / polar->jacobian;
        add_points(v, &ray, &(ray_points){st->nodes, reach, factor, st->part, st->weight});
    }
}

/* All rays take the steps that suit the longest. Panels that would need more nodes than there are fall in
 * two. */
static void add_steps(const view *v, const sector *sec, double low, double width, double top)
{
    steps st = {.low = low, .width = width, .top = top};
    double ellipse = panel_ellipse(width);
    double growth = panel_growth(ellipse, 1 / top, 0, 1, low, width);
    st.nodes = panel_nodes(v->polar->degree, v->polar->tolerance, ellipse, growth);
    if (falls_in_two(&st.nodes, width)) {
        add_steps(v, sec, low, width / 2, top);
        add_steps(v, sec, low + width / 2, width / 2, top);
        return;
    }
    make_steps(v->polar, &st);
    add_panel(v, sec, &st);
}

/* The part from `low` on; panels as above. */
static void add_sector(const view *v, sector *sec, double low, double width)
{
    double ellipse = panel_ellipse(width);
    double growth = panel_growth(ellipse, sec->distance, sec->begin, sec->end, low, width);
    sec->low = low;
    sec->width = width;
    sec->nodes = panel_nodes(v->polar->degree, v->polar->tolerance, ellipse, growth);
    if (falls_in_two(&sec->nodes, width)) {
        add_sector(v, sec, low, width / 2);
        add_sector(v, sec, low + width / 2, width / 2);
        return;
    }
    double reach = fmax(cosh(low), cosh(low + width)) * sec->distance;
    double length = asinh(reach / v->distance), top = sinh(length);
    int count = panels(length);
    for (int k = 0; k < count; k++)
        add_steps(v, sec, k * length / count, length / count, top);
}

/* How far the polygon reaches from the line through y0 + a with this normal. */
static double reach_of(const view *v, hpr_vec3 a, hpr_vec3 normal)
{
    double reach = 0;
    for (int i = 0; i < v->polar->count; i++) {
        hpr_vec3 corner = hpr_sub(v->polar->corner[i], v->nearest);
        reach = fmax(reach, fabs(hpr_dot(hpr_sub(corner, a), normal)));
    }
    return reach;
}

/* Of a triangle so low that it is nothing beside what lies above it on the polygon, as far as x is away: the
 * foot of x is on the edge's line but for rounding. */
static bool is_sliver(const view *v, hpr_vec3 a, hpr_vec3 normal, double distance)
{
    static const double share = 0.01; /* of the tolerance */
    double allowed = share * v->polar->tolerance;
    return distance < allowed * v->distance && distance < allowed * reach_of(v, a, normal);
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
    hpr_vec3 end = hpr_dot(a, a) < hpr_dot(b, b) ? a : b;
    double turn = hpr_dot(hpr_cross(end, along), v->polar->normal), distance = fabs(turn);
    if (!(distance > nothing * (v->distance + length)))
        return;
    sector sec = {.normal = hpr_scale(hpr_cross(along, v->polar->normal), turn > 0 ? 1 : -1),
                  .along = along,
                  .distance = distance};
    if (is_sliver(v, a, sec.normal, distance))
        return;
    sec.begin = hpr_dot(a, along);
    sec.end = hpr_dot(b, along);
    double low = asinh(sec.begin / distance), high = asinh(sec.end / distance);
    int count = panels(high - low);
    for (int k = 0; k < count; k++)
        add_sector(v, &sec, low + k * (high - low) / count, (high - low) / count);
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

/* Nearest point of the segment between a and b; from the nearer end on, for rounding of the other may be more
 * than the height over the plane. */
static hpr_vec3 nearest_on_edge(hpr_vec3 p, hpr_vec3 a, hpr_vec3 b)
{
    hpr_vec3 from_a = hpr_sub(p, a), from_b = hpr_sub(p, b);
    bool first = hpr_dot(from_a, from_a) < hpr_dot(from_b, from_b);
    hpr_vec3 end = first ? a : b, from = first ? from_a : from_b,
             along = first ? hpr_sub(b, a) : hpr_sub(a, b);
    double square = hpr_dot(along, along), f = square > 0 ? hpr_dot(from, along) / square : 0;
    return f > 0 ? hpr_madd(end, f, along) : end;
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
        hpr_vec3 from_a = hpr_sub(p, a), from_b = hpr_sub(p, b);
        hpr_vec3 from_end = hpr_dot(from_a, from_a) < hpr_dot(from_b, from_b) ? from_a : from_b;
        double turn = hpr_dot(hpr_cross(hpr_sub(b, a), from_end), polar->normal);
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

/* Panels that would need more nodes than there are fall in two. */
static void line_panel(const hpr_line *line, double low, double width, hpr_line_sink sink, void *user)
{
    double ellipse = panel_ellipse(width), place[HPR_NODES_MAX], weight[HPR_NODES_MAX];
    double growth = panel_growth(ellipse, line->distance, line->begin, line->end, low, width);
    int nodes = panel_nodes(line->degree, line->tolerance, ellipse, growth);
    if (falls_in_two(&nodes, width)) {
        line_panel(line, low, width / 2, sink, user);
        line_panel(line, low + width / 2, width / 2, sink, user);
        return;
    }
    const hpr_gauss_rule *gauss = &line->gauss->legendre[nodes];
    hpr_sums_of(line->isa)->hyperbolic(low, width, gauss->node, (size_t)nodes, place, weight);
    for (int i = 0; i < nodes; i++) {
        place[i] *= line->distance;
        weight[i] *= width * gauss->weight[i] * line->distance;
    }
    sink(user, nodes, place, weight);
}

void hpr_polar_line(const hpr_line *line, hpr_line_sink sink, void *user)
{
    double low = asinh(line->begin / line->distance), high = asinh(line->end / line->distance);
    int count = panels(high - low);
    for (int k = 0; k < count; k++)
        line_panel(line, low + k * (high - low) / count, (high - low) / count, sink, user);
}

/* What the nodes of a segment become. */
typedef struct segment {
    const view *view;
    ray ray;
} segment;

static void segment_points(void *user, int count, const double *place, const double *weight)
{
    const segment *s = user;
    const hpr_polar *polar = s->view->polar;
    double u[HPR_NODES_MAX] = {0}, w[HPR_NODES_MAX] = {0}; /* 0 to the end of the last eight */
    memcpy(u, place, (size_t)count * sizeof *u);
    memcpy(w, weight, (size_t)count * sizeof *w);
    if (polar->points->count + count > HPR_POINTS_MAX)
        flush(polar);
    add_points(s->view, &s->ray, &(ray_points){count, 1, 1 / polar->jacobian, u, w});
}

/* The segment as it lies from the foot of x on its line, from `begin` to `end`. */
typedef struct seen_segment {
    view view;
    ray ray;
    double distance, begin, end;
} seen_segment;

static seen_segment see_segment(const hpr_polar *polar, hpr_vec3 x)
{
    hpr_vec3 a = polar->corner[0], along = hpr_sub(polar->corner[1], a);
    double length = hpr_length(along);
    along = hpr_scale(along, 1 / length);
    hpr_vec3 from = hpr_sub(a, x), foot = hpr_madd(from, -hpr_dot(from, along), along);
    double begin = hpr_dot(from, along);
    return (seen_segment){make_view(polar, x, hpr_add(x, foot)), make_ray(polar, along), hpr_length(foot),
                          begin, begin + length};
}

static void add_segment(const hpr_polar *polar, hpr_vec3 x)
{
    seen_segment seen = see_segment(polar, x);
    segment s = {&seen.view, seen.ray};
    const hpr_line line = {polar->gauss, polar->group->isa, seen.distance, seen.begin,
                           seen.end,     polar->tolerance,  polar->degree};
    hpr_polar_line(&line, segment_points, &s);
}

/*
 * ∫ (h0 + h1 t) / (d^2 + t^2)^2 dt = h0 / (2 d^3) (angle + sin(angle) cos(sum)) + h1 / 2 (1/b^2 - 1/e^2), b
 * and e the distances of the ends, of whose directions from the foot's `angle` is the difference and `sum`
 * the sum.
 */
bool hpr_polar_closed(const hpr_polar *polar, hpr_vec3 x, double rounding, double *integral)
{
    const seen_segment seen = see_segment(polar, x);
    double d2 = seen.distance * seen.distance, b = seen.begin, e = seen.end, b2 = d2 + b * b, e2 = d2 + e * e;
    double sine = seen.distance * (e - b), cosine = d2 + b * e, sum = d2 - b * e;
    double angle = atan2(sine, cosine), bend = sine * sum / (b2 * e2);
    double per_height = seen.view.height0 / (2 * d2 * seen.distance);
    double by_slope = seen.ray.height / 2 * (e - b) * (e + b) / (b2 * e2);
    double all = per_height * (angle + bend) + by_slope;
    *integral = all / polar->jacobian;
    return fabs(per_height) * (angle + fabs(bend)) + fabs(by_slope) <= rounding * all;
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
        add_segment(polar, x);
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
