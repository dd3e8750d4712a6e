#include "visibility/faces.h"

#include <float.h>
#include <string.h>

/* One blocker takes about 8 ns, a walk through the tree 60 ns (18 occluders) to 600 ns (6000 occluders). */
enum { FEW_BLOCKERS = 16 };

/* Corners of the scene have |x'| <= 1; what lies outside this ball touches no face. */
static const double ball_radius = 1 + 1e-5;

/* The edges of a quadrilateral away from the origin. */
static void set_skew(hpr_face *face, const double opposite[2])
{
    double a = opposite[0], b = opposite[1];
    const double inside[2][3] = {{b, -b, a - 1}, {a, b - 1, -a}};
    for (int i = 0; i < 2; i++) {
        double gradient[3];
        for (int k = 0; k < 3; k++)
            gradient[k] = inside[i][1] * face->dual1[k] + inside[i][2] * face->dual2[k];
        for (int k = 0; k < 3; k++)
            face->skew[i][k] = inside[i][k] / hpr_length3(gradient);
    }
}

/* Corners of a quadrilateral whose edges are moved outward by reach. */
static void grow_quadrilateral(const hpr_face *face, double reach, double corner[4][2])
{
    /* s, t and the two functions of the other edges are >= -reach; in the order of the edges */
    const double edge[4][3] = {{reach, 0, 1 / face->per_length[1]},
                               {face->skew[0][0] + reach, face->skew[0][1], face->skew[0][2]},
                               {face->skew[1][0] + reach, face->skew[1][1], face->skew[1][2]},
                               {reach, 1 / face->per_length[0], 0}};
    for (int i = 0; i < 4; i++) {
        const double *f = edge[(i + 3) % 4], *g = edge[i];
        double determinant = f[1] * g[2] - f[2] * g[1];
        corner[i][0] = (f[2] * g[0] - f[0] * g[2]) / determinant;
        corner[i][1] = (f[0] * g[1] - f[1] * g[0]) / determinant;
    }
}

static void set_box(hpr_face *face, const double edge1[3], const double edge2[3], double reach)
{
    double a = reach * face->per_length[0], b = reach * face->per_length[1], c = reach * face->per_length[2];
    const double triangle[4][2] = {{-a, -b}, {1 + c + b, -b}, {-a, 1 + c + a}, {-a, -b}};
    double corner[4][2] = {{-a, -b}, {1 + a, -b}, {1 + a, 1 + b}, {-a, 1 + b}};
    if (face->shape == HPR_SHAPE_QUADRILATERAL)
        grow_quadrilateral(face, reach, corner);
    for (int k = 0; k < 3; k++) {
        face->low[k] = INFINITY;
        face->high[k] = -INFINITY;
        for (int i = 0; i < 4; i++) {
            const double *st = face->shape == HPR_SHAPE_TRIANGLE ? triangle[i] : corner[i];
            double x = face->origin[k] + st[0] * edge1[k] + st[1] * edge2[k];
            face->low[k] = fmin(face->low[k], x);
            face->high[k] = fmax(face->high[k], x);
        }
    }
}

static void set_face(const hpr_visibility *visibility, size_t patch, hpr_face *face)
{
    const hpr_patches *patches = visibility->patches;
    double edge1[3], edge2[3], across[3], sum[3];
    hpr_scene_units(visibility, patches->origin + 3 * patch, face->origin);
    for (int k = 0; k < 3; k++) {
        edge1[k] = patches->edge1[3 * patch + k] * visibility->scale;
        edge2[k] = patches->edge2[3 * patch + k] * visibility->scale;
        face->normal[k] = patches->normal[3 * patch + k];
    }
    hpr_cross3(edge1, edge2, across);
    double square = hpr_dot3(across, across);
    face->patch = (uint32_t)patch;
    face->shape = patches->shape[patch];
    face->single = patches->twin[patch] == HPR_NONE;
    face->empty = !(square >= DBL_MIN);
    if (face->empty)
        return;
    hpr_cross3(edge2, across, face->dual1);
    hpr_cross3(across, edge1, face->dual2);
    for (int k = 0; k < 3; k++) {
        face->dual1[k] /= square;
        face->dual2[k] /= square;
        sum[k] = face->dual1[k] + face->dual2[k];
    }
    face->per_length[0] = hpr_length3(face->dual1);
    face->per_length[1] = hpr_length3(face->dual2);
    face->per_length[2] = hpr_length3(sum);
    if (face->shape == HPR_SHAPE_QUADRILATERAL)
        set_skew(face, patches->opposite + 2 * patch);
    set_box(face, edge1, edge2, visibility->reach);
}

/* Where the edges k - 1 and k meet when both are moved outward by reach: the farthest point of the corner. */
static void add_mitre(const hpr_occluder *occluder, const double corner[3], int k, double reach,
                      double low[3], double high[3])
{
    const double *n1 = occluder->inward[(k + occluder->edge_count - 1) % occluder->edge_count],
                 *n2 = occluder->inward[k];
    double opening = 1 + hpr_dot3(n1, n2);
    for (int a = 0; a < 3; a++) {
        double far = corner[a] - (opening > 0 ? reach * (n1[a] + n2[a]) / opening : 0);
        low[a] = opening > 0 ? fmin(low[a], far) : -ball_radius;
        high[a] = opening > 0 ? fmax(high[a], far) : ball_radius;
    }
}

/* The outline's corners in the plane: welding may have moved them off it. */
static void set_corners(const hpr_visibility *visibility, const hpr_convex *outline, hpr_occluder *occluder)
{
    occluder->edge_count = outline->count;
    for (int k = 0; k < outline->count; k++) {
        double world[3], offset[3];
        hpr_vec3_store(world, outline->corner[k]);
        hpr_scene_units(visibility, world, occluder->corner[k]);
        hpr_subtract3(occluder->corner[k], occluder->origin, offset);
        hpr_add_scaled3(occluder->corner[k], -hpr_dot3(occluder->normal, offset), occluder->normal,
                        occluder->corner[k]);
    }
}

static void set_occluder(const hpr_visibility *visibility, const hpr_convex *outline,
                         const hpr_occluder_plane *plane, hpr_occluder *occluder)
{
    const double *normal = occluder->normal;
    int count = outline->count;
    memcpy(occluder->normal, plane->normal, sizeof occluder->normal);
    hpr_scene_units(visibility, plane->origin, occluder->origin);
    set_corners(visibility, outline, occluder);
    const double(*corner)[3] = (const double(*)[3])occluder->corner;
    for (int k = 0; k < count; k++) {
        double edge[3], from[3];
        hpr_subtract3(corner[(k + 1) % count], corner[k], edge);
        hpr_cross3(normal, edge, occluder->inward[k]);
        double length = hpr_length3(occluder->inward[k]);
        for (int a = 0; a < 3; a++)
            occluder->inward[k][a] /= length;
        hpr_subtract3(corner[k], occluder->origin, from);
        occluder->offset[k] = hpr_dot3(occluder->inward[k], from);
    }
    for (int a = 0; a < 3; a++) {
        occluder->low[a] = INFINITY;
        occluder->high[a] = -INFINITY;
    }
    for (int k = 0; k < count; k++)
        add_mitre(occluder, corner[k], k, visibility->reach, occluder->low, occluder->high);
}

static hpr_bounds bounds_of(const hpr_occluder *occluder)
{
    hpr_bounds bounds = {.distance = hpr_dot3(occluder->normal, occluder->origin)};
    memcpy(bounds.low, occluder->low, sizeof bounds.low);
    memcpy(bounds.high, occluder->high, sizeof bounds.high);
    memcpy(bounds.normal, occluder->normal, sizeof bounds.normal);
    for (int k = 0; k < occluder->edge_count; k++)
        hpr_add_scaled3(bounds.middle, 1.0 / occluder->edge_count, occluder->corner[k], bounds.middle);
    for (int k = 0; k < occluder->edge_count; k++) {
        double offset[3];
        hpr_subtract3(occluder->corner[k], bounds.middle, offset);
        bounds.radius = hpr_max(bounds.radius, hpr_length3(offset));
    }
    bounds.radius *= 1 + 1e-14; /* its own rounding */
    return bounds;
}

static hpr_status set_occluders(hpr_visibility *visibility)
{
    hpr_context *ctx = visibility->context;
    hpr_occluder_plane *plane = NULL;
    hpr_status status = hpr_occluders_merge(visibility->patches, visibility->front, visibility->front_count,
                                            visibility->slack / visibility->scale, &visibility->outline,
                                            &plane, &visibility->occluder_count);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &visibility->occluder, visibility->occluder_count,
                                   sizeof *visibility->occluder, "visibility");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &visibility->bounds, visibility->occluder_count,
                                   sizeof *visibility->bounds, "visibility");
    for (size_t i = 0; status == HPR_OK && i < visibility->occluder_count; i++) {
        set_occluder(visibility, &visibility->outline[i], &plane[i], &visibility->occluder[i]);
        visibility->bounds[i] = bounds_of(&visibility->occluder[i]);
    }
    hpr_release(ctx, plane);
    return status;
}

static void set_units(hpr_visibility *visibility)
{
    double radius = hpr_patches_radius(visibility->patches, visibility->centre);
    int exponent = 0;
    if (radius > 0)
        frexp(radius, &exponent);
    visibility->scale = ldexp(1, -exponent);
    double largest = radius;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fabs(visibility->centre[k]) + radius);
    visibility->slack = 1e-12 + 8 * DBL_EPSILON * largest * visibility->scale;
    visibility->reach = fmax(1e-7, 2 * visibility->slack);
}

/* What an occluder has on either side of its plane. */
typedef struct both_sides {
    bool above, below;
} both_sides;

static void add_sides(const hpr_visibility *visibility, const hpr_occluder *occluder,
                      const hpr_occluder *other, both_sides *sides)
{
    for (int k = 0; k < other->edge_count; k++) {
        double offset[3];
        hpr_subtract3(other->corner[k], occluder->origin, offset);
        double height = hpr_dot3(occluder->normal, offset);
        /* less than what counts as dividing, for an outline may be off by a part of the slack */
        sides->above |= height > visibility->slack / 4;
        sides->below |= height < -visibility->slack / 4;
    }
}

enum { EXTREMES = 26 };

/* Occluders that reach farthest along the directions to the sides, edges and corners of a cube: most planes
 * have some of these on both sides. */
static void find_extremes(const hpr_visibility *visibility, size_t extreme[EXTREMES])
{
    for (int e = 0; e < EXTREMES; e++) {
        int code = e < EXTREMES / 2 ? e : e + 1; /* without the middle of 3 x 3 x 3 */
        const double direction[3] = {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1};
        double farthest = -INFINITY;
        extreme[e] = 0;
        for (size_t i = 0; i < visibility->occluder_count; i++) {
            double reach = hpr_dot3(direction, visibility->occluder[i].corner[0]);
            if (reach > farthest) {
                farthest = reach;
                extreme[e] = i;
            }
        }
    }
}

/* All patches lie in occluders, so these stand for them. In a convex room there is none. */
static bool divides(const hpr_visibility *visibility, const hpr_occluder *occluder,
                    const size_t extreme[EXTREMES])
{
    both_sides sides = {false, false};
    for (int e = 0; e < EXTREMES; e++)
        add_sides(visibility, occluder, &visibility->occluder[extreme[e]], &sides);
    for (size_t i = 0; i < visibility->occluder_count && !(sides.above && sides.below); i++)
        add_sides(visibility, occluder, &visibility->occluder[i], &sides);
    return sides.above && sides.below;
}

static hpr_status find_dividers(hpr_visibility *visibility)
{
    hpr_status status =
        hpr_allocate_into(visibility->context, &visibility->divider, visibility->occluder_count,
                          sizeof *visibility->divider, "visibility");
    size_t extreme[EXTREMES];
    find_extremes(visibility, extreme);
    for (size_t i = 0; status == HPR_OK && i < visibility->occluder_count; i++) {
        if (divides(visibility, &visibility->occluder[i], extreme))
            visibility->divider[visibility->divider_count++] = (uint32_t)i;
    }
    return status;
}

hpr_status hpr_visibility_create_untraced(const hpr_patches *patches, hpr_visibility **out)
{
    hpr_context *ctx = patches->context;
    *out = NULL;
    hpr_visibility *visibility = NULL;
    hpr_status status = hpr_allocate_into(ctx, &visibility, 1, sizeof *visibility, "visibility");
    if (status != HPR_OK)
        return status;
    visibility->context = ctx;
    visibility->patches = patches;
    set_units(visibility);
    status =
        hpr_allocate_into(ctx, &visibility->face, patches->count, sizeof *visibility->face, "visibility");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &visibility->front, patches->count, sizeof *visibility->front,
                                   "visibility");
    if (status != HPR_OK)
        goto done;
    for (size_t i = 0; i < patches->count; i++) {
        set_face(visibility, i, &visibility->face[i]);
        if (!visibility->face[i].empty && (patches->twin[i] == HPR_NONE || patches->side[i] == 0))
            visibility->front[visibility->front_count++] = (uint32_t)i;
    }
    status = set_occluders(visibility);
    if (status == HPR_OK)
        status = find_dividers(visibility);
done:
    if (status != HPR_OK)
        hpr_visibility_destroy(&visibility);
    *out = visibility;
    return status;
}

hpr_status hpr_visibility_prepare_rays(hpr_visibility *visibility)
{
    return hpr_rays_create(visibility, &visibility->rays);
}

hpr_status hpr_visibility_create(const hpr_patches *patches, hpr_visibility **out)
{
    hpr_status status = hpr_visibility_create_untraced(patches, out);
    if (status == HPR_OK)
        status = hpr_visibility_prepare_rays(*out);
    if (status != HPR_OK)
        hpr_visibility_destroy(out);
    return status;
}

void hpr_visibility_destroy(hpr_visibility **out)
{
    hpr_visibility *visibility = *out;
    if (!visibility)
        return;
    hpr_context *ctx = visibility->context;
    hpr_rays_destroy(&visibility->rays);
    hpr_release(ctx, visibility->face);
    hpr_release(ctx, visibility->front);
    hpr_release(ctx, visibility->occluder);
    hpr_release(ctx, visibility->bounds);
    hpr_release(ctx, visibility->outline);
    hpr_release(ctx, visibility->divider);
    hpr_release(ctx, visibility);
    *out = NULL;
}

/*
 * The part start < distance < stop of a line (direction of length 1) that is inside the ball around the
 * scene; false if none is. The foot of the perpendicular comes first: the quadratic formula would lose a far
 * origin's digits.
 */
static bool clip_to_ball(const double origin[3], const double direction[3], double *start, double *stop)
{
    double middle = -hpr_dot3(origin, direction), foot[3];
    hpr_add_scaled3(origin, middle, direction, foot);
    double square = ball_radius * ball_radius - hpr_dot3(foot, foot);
    if (!(square > 0))
        return false;
    *start = fmax(*start, middle - sqrt(square));
    *stop = fmin(*stop, middle + sqrt(square));
    return *start < *stop;
}

/* Long lists: the segment inside the ball goes to the tree. */
static bool blocked_by_many(const hpr_visibility *visibility, const double x[3], const double y[3],
                            const uint32_t *blockers, size_t blocker_count)
{
    double direction[3], start = 0, a[3], b[3];
    if (hpr_dot3(x, x) <= 1 && hpr_dot3(y, y) <= 1)
        return hpr_rays_blocked(visibility->rays, x, y, x, y, blockers, blocker_count);
    hpr_subtract3(y, x, direction);
    double length = hpr_length3(direction), stop = length;
    if (!(length > 0))
        return false;
    for (int k = 0; k < 3; k++)
        direction[k] /= length;
    if (!clip_to_ball(x, direction, &start, &stop))
        return false;
    hpr_add_scaled3(x, start, direction, a);
    hpr_add_scaled3(x, stop, direction, b);
    return hpr_rays_blocked(visibility->rays, x, y, a, b, blockers, blocker_count);
}

bool hpr_visibility_blocked(const hpr_visibility *visibility, const double x[3], const double y[3],
                            const uint32_t *blockers, size_t blocker_count)
{
    double a[3], b[3];
    hpr_scene_units(visibility, x, a);
    hpr_scene_units(visibility, y, b);
    if (blocker_count > FEW_BLOCKERS)
        return blocked_by_many(visibility, a, b, blockers, blocker_count);
    for (size_t i = 0; i < blocker_count; i++) {
        if (hpr_occluder_blocks(visibility, &visibility->occluder[blockers[i]], a, b))
            return true;
    }
    return false;
}

hpr_hit hpr_visibility_first_hit(const hpr_visibility *visibility, const double origin[3],
                                 const double direction[3], double near, double far, bool cull, bool *back)
{
    const hpr_hit none = {.patch = HPR_NONE, .distance = INFINITY};
    hpr_ray ray = {.near = near * visibility->scale, .far = far * visibility->scale, .cull = cull};
    double start[3], entry = ray.near, stop = ray.far;
    bool from_back = false;
    hpr_scene_units(visibility, origin, start);
    if (back)
        *back = false;
    if (!clip_to_ball(start, direction, &entry, &stop))
        return none;
    ray.offset = entry;
    ray.length = stop - entry;
    for (int k = 0; k < 3; k++)
        ray.direction[k] = direction[k];
    hpr_add_scaled3(start, entry, direction, ray.base);
    hpr_hit hit = hpr_rays_first(visibility->rays, &ray, &from_back);
    if (back)
        *back = from_back;
    hit.distance /= visibility->scale;
    return hit;
}

const hpr_patches *hpr_visibility_patches(const hpr_visibility *visibility)
{
    return visibility->patches;
}

double hpr_visibility_slack_m(const hpr_visibility *visibility)
{
    return visibility->slack / visibility->scale;
}

size_t hpr_visibility_occluder_count(const hpr_visibility *visibility)
{
    return visibility->occluder_count;
}

const hpr_convex *hpr_visibility_outlines(const hpr_visibility *visibility)
{
    return visibility->outline;
}
