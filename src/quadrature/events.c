#include "quadrature/events.h"

#include "math/hull.h"

#include <string.h>

/* An edge of a blocker, as far as it lies between the polygons. */
typedef struct edge {
    hpr_vec3 end[2];   /* of the whole edge */
    hpr_vec3 inner[2]; /* ends of the part between the polygons */
    hpr_vec3 middle;   /* of the blocker, or of the two that share the edge */
    hpr_vec3 other_middle;
    bool shared;
} edge;

enum { MAX_EDGES = 128 };

typedef struct finder {
    const hpr_pair *pair;
    const hpr_element_frame *outer;
    const hpr_polygon *polygon; /* the outer one */
    const hpr_convex *inner;
    hpr_vec3 corner[HPR_POLYGON_MAX]; /* of the outer polygon in space */
    double size, slack;
    size_t plane_count;
    double plane[HPR_HULL_PLANES][4];
    int edge_count;
    edge edges[MAX_EDGES];
    hpr_events *events;
} finder;

static double plane_height(const double plane[4], hpr_vec3 x)
{
    return plane[0] * x.x + plane[1] * x.y + plane[2] * x.z - plane[3];
}

static hpr_vec3 middle_of(const hpr_convex *polygon)
{
    hpr_vec3 sum = {0, 0, 0};
    for (int k = 0; k < polygon->count; k++)
        sum = hpr_madd(sum, 1.0 / polygon->count, polygon->corner[k]);
    return sum;
}

/* Cuts a segment down to what is inside the hull by more than the slack; false if nothing is. */
static bool keep_inside(const finder *f, hpr_vec3 *a, hpr_vec3 *b)
{
    double from = 0, to = 1;
    hpr_vec3 along = hpr_sub(*b, *a);
    for (size_t i = 0; i < f->plane_count; i++) {
        double ha = plane_height(f->plane[i], *a) + f->slack, hb = plane_height(f->plane[i], *b) + f->slack;
        if (ha >= 0 && hb >= 0)
            return false;
        if (ha > 0)
            from = hpr_max(from, ha / (ha - hb));
        else if (hb > 0)
            to = hpr_min(to, ha / (ha - hb));
    }
    if (!((to - from) * hpr_length(along) > f->slack))
        return false;
    hpr_vec3 start = *a;
    *a = hpr_madd(start, from, along);
    *b = hpr_madd(start, to, along);
    return true;
}

static bool same_point(const finder *f, hpr_vec3 a, hpr_vec3 b)
{
    return hpr_length(hpr_sub(a, b)) <= f->slack;
}

/* The edge of another blocker that is the same, or NULL. */
static edge *find_twin(finder *f, hpr_vec3 a, hpr_vec3 b)
{
    for (int i = 0; i < f->edge_count; i++) {
        edge *it = &f->edges[i];
        if ((same_point(f, it->end[0], a) && same_point(f, it->end[1], b)) ||
            (same_point(f, it->end[0], b) && same_point(f, it->end[1], a)))
            return it;
    }
    return NULL;
}

static void collect_edges(finder *f)
{
    for (int b = 0; b < f->pair->blocker_count; b++) {
        const hpr_convex *blocker = &f->pair->blocker[b];
        for (int k = 0; k < blocker->count; k++) {
            edge it = {.end = {blocker->corner[k], blocker->corner[k + 1 < blocker->count ? k + 1 : 0]},
                       .middle = middle_of(blocker)};
            it.inner[0] = it.end[0];
            it.inner[1] = it.end[1];
            if (!keep_inside(f, &it.inner[0], &it.inner[1]))
                continue;
            edge *twin = find_twin(f, it.end[0], it.end[1]);
            if (twin && !twin->shared) {
                twin->shared = true;
                twin->other_middle = it.middle;
            } else if (!twin && f->edge_count < MAX_EDGES) {
                f->edges[f->edge_count++] = it;
            } else if (!twin) {
                f->events->complete = false;
            }
        }
    }
}

/* Two blockers meet in this edge and lie on its two sides, from wherever on the outer polygon it is seen:
 * then nothing shows between them. */
static bool is_crease(const finder *f, const edge *it)
{
    if (!it->shared)
        return false;
    for (int k = 0; k < f->polygon->count; k++) {
        hpr_vec3 x = f->corner[k];
        hpr_vec3 normal = hpr_cross(hpr_sub(it->end[0], x), hpr_sub(it->end[1], x));
        double one = hpr_dot(normal, hpr_sub(it->middle, x)),
               two = hpr_dot(normal, hpr_sub(it->other_middle, x));
        if (one * two > 0)
            return false;
    }
    return true;
}

/* Keeps a line once, scaled to gradient 1. */
static void add_line(finder *f, hpr_affine line)
{
    static const double same = 1e-10;
    double gradient = sqrt(line.along1 * line.along1 + line.along2 * line.along2);
    if (!(gradient > 0))
        return;
    double scale = (fabs(line.along1) >= fabs(line.along2) ? line.along1 : line.along2) > 0 ? 1 / gradient
                                                                                            : -1 / gradient;
    line = (hpr_affine){scale * line.at_origin, scale * line.along1, scale * line.along2};
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < f->polygon->count; k++) {
        double value = hpr_affine_at(&line, f->polygon->corner[k][0], f->polygon->corner[k][1]);
        low = hpr_min(low, value);
        high = hpr_max(high, value);
    }
    if (!(low < -same && high > same))
        return;
    for (int i = 0; i < f->events->count; i++) {
        const hpr_affine *other = &f->events->line[i];
        double sign = line.along1 * other->along1 + line.along2 * other->along2 < 0 ? -1 : 1;
        if (fabs(line.at_origin - sign * other->at_origin) <= same &&
            fabs(line.along1 - sign * other->along1) <= same &&
            fabs(line.along2 - sign * other->along2) <= same)
            return;
    }
    if (f->events->count < HPR_EVENTS_MAX)
        f->events->line[f->events->count++] = line;
    else
        f->events->complete = false;
}

/* The line in which the outer plane is cut by the plane through q with this normal. */
static void add_plane(finder *f, hpr_vec3 q, hpr_vec3 normal)
{
    add_line(f, (hpr_affine){hpr_dot(normal, hpr_sub(f->outer->origin, q)), hpr_dot(normal, f->outer->edge1),
                             hpr_dot(normal, f->outer->edge2)});
}

/* Parameters of the point in which the line from y through p meets the outer plane; false if it does not,
 * beyond p. */
static bool shadow(const finder *f, hpr_vec3 y, hpr_vec3 p, double foot[2])
{
    hpr_vec3 normal = f->outer->normal, along = hpr_sub(p, y);
    double hy = hpr_dot(normal, hpr_sub(y, f->outer->origin)), fall = -hpr_dot(normal, along);
    if (!(fall > 1e-12 * hpr_length(along)) || !(hy > 0))
        return false;
    hpr_vec3 offset = hpr_sub(hpr_madd(y, hy / fall, along), f->outer->origin);
    hpr_vec3 across = hpr_cross(f->outer->edge1, f->outer->edge2);
    double square = hpr_dot(across, across);
    foot[0] = hpr_dot(hpr_cross(offset, f->outer->edge2), across) / square;
    foot[1] = hpr_dot(hpr_cross(f->outer->edge1, offset), across) / square;
    return true;
}

/* Does the segment from a to b in the parameters come near the outer polygon? */
static bool touches_polygon(const finder *f, const double a[2], const double b[2])
{
    static const double margin = 1e-9;
    double from = 0, to = 1, turn = 0;
    const hpr_polygon *p = f->polygon;
    for (int k = 1; k + 1 < p->count; k++)
        turn += (p->corner[k][0] - p->corner[0][0]) * (p->corner[k + 1][1] - p->corner[0][1]) -
                (p->corner[k][1] - p->corner[0][1]) * (p->corner[k + 1][0] - p->corner[0][0]);
    for (int k = 0; k < p->count; k++) {
        const double *c = p->corner[k], *d = p->corner[k + 1 < p->count ? k + 1 : 0];
        double e[2] = {d[0] - c[0], d[1] - c[1]}, length = sqrt(e[0] * e[0] + e[1] * e[1]);
        double sign = turn < 0 ? -1 : 1;
        double ha = sign * (e[0] * (a[1] - c[1]) - e[1] * (a[0] - c[0])) + margin * length;
        double hb = sign * (e[0] * (b[1] - c[1]) - e[1] * (b[0] - c[0])) + margin * length;
        if (ha < 0 && hb < 0)
            return false;
        if (ha < 0)
            from = hpr_max(from, ha / (ha - hb));
        else if (hb < 0)
            to = hpr_min(to, ha / (ha - hb));
    }
    return from <= to;
}

/* A point of space seen on a segment: the plane through them, if it meets the outer polygon behind the
 * segment (the point beyond) or behind the point (the segment beyond). */
static void add_view(finder *f, hpr_vec3 point, hpr_vec3 a, hpr_vec3 b, bool point_is_beyond)
{
    double foot[2][2];
    bool falls = point_is_beyond ? shadow(f, point, a, foot[0]) && shadow(f, point, b, foot[1])
                                 : shadow(f, a, point, foot[0]) && shadow(f, b, point, foot[1]);
    if (falls && !touches_polygon(f, foot[0], foot[1]))
        return;
    add_plane(f, a, hpr_cross(hpr_sub(b, a), hpr_sub(point, a)));
}

static bool inside_hull(const finder *f, hpr_vec3 x)
{
    for (size_t i = 0; i < f->plane_count; i++) {
        if (plane_height(f->plane[i], x) >= -f->slack)
            return false;
    }
    return true;
}

static void add_edge_events(finder *f, const edge *it)
{
    for (int j = 0; j < f->inner->count; j++)
        add_view(f, f->inner->corner[j], it->inner[0], it->inner[1], true);
    for (int e = 0; e < 2; e++) {
        if (!inside_hull(f, it->end[e]))
            continue;
        for (int j = 0; j < f->inner->count; j++) {
            int next = j + 1 < f->inner->count ? j + 1 : 0;
            add_view(f, it->end[e], f->inner->corner[j], f->inner->corner[next], false);
        }
    }
}

/* Where the inner polygon is near, the view changes fast at its edges. */
static void add_near_edges(finder *f)
{
    static const double near = 0.5;
    if (hpr_polygon_distance(f->corner, f->polygon->count, f->inner->corner, f->inner->count) >
        near * f->size)
        return;
    for (int j = 0; j < f->inner->count; j++) {
        hpr_vec3 from = f->inner->corner[j], to = f->inner->corner[j + 1 < f->inner->count ? j + 1 : 0];
        add_plane(f, from, hpr_cross(hpr_sub(to, from), f->outer->normal));
    }
}

/* Sizes, and the hull of the two polygons. */
static void open_finder(finder *f, hpr_vec3 inner_normal)
{
    static const double rounding = 1e-12;
    double reach = 0;
    for (int k = 0; k < f->polygon->count; k++) {
        f->corner[k] = hpr_frame_point(f->outer, f->polygon->corner[k][0], f->polygon->corner[k][1]);
        f->size = hpr_max(f->size, hpr_length(hpr_sub(f->corner[k], f->corner[0])));
        reach = hpr_max(reach, hpr_length(hpr_sub(f->corner[k], f->inner->corner[0])));
    }
    f->slack = rounding * reach;
    const double normals[2][3] = {{f->outer->normal.x, f->outer->normal.y, f->outer->normal.z},
                                  {inner_normal.x, inner_normal.y, inner_normal.z}};
    const hpr_hull_end end[2] = {{(const double(*)[3])f->corner, (size_t)f->polygon->count, normals[0]},
                                 {(const double(*)[3])f->inner->corner, (size_t)f->inner->count, normals[1]}};
    f->plane_count = hpr_hull_planes(end, f->slack, f->plane);
}

void hpr_events_find(const hpr_pair *pair, const hpr_element_frame *outer, const hpr_polygon *outer_polygon,
                     const hpr_convex *inner, hpr_vec3 inner_normal, hpr_events *events)
{
    finder f;
    f.pair = pair;
    f.outer = outer;
    f.polygon = outer_polygon;
    f.inner = inner;
    f.size = 0;
    f.edge_count = 0;
    f.events = events;
    events->count = 0;
    events->complete = true;
    open_finder(&f, inner_normal);
    collect_edges(&f);
    for (int i = 0; i < f.edge_count; i++) {
        if (!is_crease(&f, &f.edges[i]))
            add_edge_events(&f, &f.edges[i]);
    }
    for (int b = 0; b < pair->blocker_count; b++) {
        const hpr_convex *blocker = &pair->blocker[b];
        add_plane(&f, blocker->corner[0],
                  hpr_cross(hpr_sub(blocker->corner[1], blocker->corner[0]),
                            hpr_sub(blocker->corner[2], blocker->corner[0])));
    }
    add_near_edges(&f);
}
