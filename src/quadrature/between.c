#include "quadrature/between.h"

enum { PLANES = 2 * HPR_CONVEX_CORNERS };

/* normal . x >= offset, up to rounding, for all of the piece and the polygon */
typedef struct plane {
    hpr_vec3 normal;
    double offset, rounding;
} plane;

typedef struct planes {
    int count;
    plane plane[PLANES];
} planes;

static const double slack = 1e-14; /* of distances: what rounding may do to them */

static double largest_coordinate(const hpr_vec3 *point, int count)
{
    double most = 0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fmax(fabs(point[i].x), fmax(fabs(point[i].y), fabs(point[i].z))));
    return most;
}

static bool is_above(const plane *p, const hpr_vec3 *point, int count)
{
    for (int i = 0; i < count; i++) {
        if (!(hpr_dot(p->normal, point[i]) >= p->offset - p->rounding))
            return false;
    }
    return true;
}

static bool is_below(const plane *p, const hpr_vec3 *point, int count)
{
    for (int i = 0; i < count; i++) {
        if (!(hpr_dot(p->normal, point[i]) <= p->offset + p->rounding))
            return false;
    }
    return true;
}

/* Through each edge of `own` the plane that touches `other` with both on one side. */
static void add_planes(planes *all, const hpr_vec3 *own, int own_count, const hpr_vec3 *other,
                       int other_count, double size)
{
    for (int i = 0; i < own_count && all->count < PLANES; i++) {
        hpr_vec3 a = own[i], along = hpr_sub(own[i + 1 < own_count ? i + 1 : 0], a);
        hpr_vec3 inside = hpr_sub(own[i > 0 ? i - 1 : own_count - 1], a), normal = {0, 0, 0};
        for (int k = 0; k < other_count; k++) {
            hpr_vec3 to = hpr_sub(other[k], a);
            if (hpr_dot(normal, normal) > 0 && hpr_dot(normal, to) >= 0)
                continue;
            normal = hpr_cross(along, to);
            normal = hpr_scale(normal, hpr_dot(normal, inside) >= 0 ? 1 : -1);
        }
        plane p = {normal, hpr_dot(normal, a), slack * size * hpr_length(normal)};
        bool exists = hpr_dot(normal, normal) > 0; /* not if all of `other` lies on the edge's line */
        if (exists && is_above(&p, own, own_count) && is_above(&p, other, other_count))
            all->plane[all->count++] = p;
    }
}

/* The piece and the polygon are on one side of the blocker's plane. */
static bool is_passed(const hpr_convex *blocker, const hpr_vec3 *piece, int piece_count,
                      const hpr_convex *polygon, double size)
{
    hpr_vec3 a = blocker->corner[0], normal = {0, 0, 0};
    for (int i = 1; i + 1 < blocker->count; i++)
        normal =
            hpr_add(normal, hpr_cross(hpr_sub(blocker->corner[i], a), hpr_sub(blocker->corner[i + 1], a)));
    plane p = {normal, hpr_dot(normal, a), slack * size * hpr_length(normal)};
    if (!is_above(&p, blocker->corner, blocker->count) || !is_below(&p, blocker->corner, blocker->count))
        return false; /* not planar enough to tell */
    return (is_above(&p, piece, piece_count) && is_above(&p, polygon->corner, polygon->count)) ||
           (is_below(&p, piece, piece_count) && is_below(&p, polygon->corner, polygon->count));
}

hpr_pair hpr_between_choose(const hpr_pair *pair, const hpr_vec3 *piece, int piece_count,
                            const hpr_convex *polygon, hpr_between *memory)
{
    planes all = {0};
    hpr_pair chosen = *pair;
    double size =
        fmax(largest_coordinate(piece, piece_count), largest_coordinate(polygon->corner, polygon->count));
    add_planes(&all, polygon->corner, polygon->count, piece, piece_count, size);
    add_planes(&all, piece, piece_count, polygon->corner, polygon->count, size);
    chosen.blocker_count = 0;
    chosen.chosen = memory->index;
    for (int b = 0; b < pair->blocker_count; b++) {
        uint32_t index = pair->chosen ? pair->chosen[b] : (uint32_t)b;
        const hpr_convex *blocker = &pair->blocker[index];
        bool apart = is_passed(blocker, piece, piece_count, polygon, size);
        for (int k = 0; k < all.count && !apart; k++)
            apart = is_below(&all.plane[k], blocker->corner, blocker->count);
        if (!apart)
            memory->index[chosen.blocker_count++] = index;
    }
    return chosen;
}
