/*
 * What visibility knows of a patch and of an occluder, and the predicates in double that decide every ray: a
 * patch is hit, an occluder blocks.
 *
 * All of it is in scene units: x' = (x - centre) * scale with scale a power of two, so that every corner has
 * |x'| <= 1, differences of neighbouring points lose nothing to the scene's offset, and a length goes back to
 * metres exactly.
 *
 * slack is the distance below which two points are the same: 1e-12 of the scene plus what the coordinates of
 * the input resolve, 8 eps max|x|. A plane separates two points if both are farther than slack from it. A
 * crossing at the angle theta to the plane is known to slack / sin(theta); a polygon is closed and grows by
 * that much, at most by reach, so that polygons that share an edge leave no gap. reach bounds the growth, so
 * that the box of the grown polygon (low, high) holds every accepted crossing: that makes "which candidates
 * did Embree's tree show" irrelevant to the result.
 */
#ifndef HPR_VISIBILITY_FACES_H
#define HPR_VISIBILITY_FACES_H

#include "math/vec3.h"
#include "visibility/occluders.h"
#include "visibility/rays.h"
#include "visibility/visibility.h"

typedef struct hpr_face {
    double origin[3], normal[3];
    double dual1[3], dual2[3]; /* s = dual1 . (x - origin), t = dual2 . (x - origin) */
    double per_length[3];      /* change of s, t and 1 - s - t per length across their edges */
    double low[3], high[3];    /* box of the corners after growing by reach */
    uint32_t patch;
    uint8_t shape;     /* hpr_shape */
    double skew[2][3]; /* quadrilateral: [0] + [1] s + [2] t, in scene units inside of the edges away from
                        * the origin */
    bool single;       /* no twin: the back lets culled rays through */
    bool empty;        /* no area: nothing hits it */
} hpr_face;

/* A convex polygon; inside of edge k is where inward[k] . (x - origin) >= offset[k]. */
typedef struct hpr_occluder {
    double origin[3], normal[3];
    double low[3], high[3]; /* box of the corners after growing by reach */
    int edge_count;
    double corner[HPR_OCCLUDER_CORNERS][3]; /* edge k is from corner k to the next */
    double inward[HPR_OCCLUDER_CORNERS][3]; /* of length 1 */
    double offset[HPR_OCCLUDER_CORNERS];
} hpr_occluder;

/* Enough of an occluder to find most of them out of the way; small, for long lists of them. */
typedef struct hpr_bounds {
    double low[3], high[3];
    double normal[3], distance; /* the plane: normal . x = distance */
    double middle[3], radius;   /* a ball that holds the corners */
} hpr_bounds;

/* A box as its middle and half its sides. */
typedef struct hpr_extent {
    double middle[3], half[3];
} hpr_extent;

struct hpr_visibility {
    hpr_context *context;
    const hpr_patches *patches;
    double centre[3], scale, slack, reach;
    hpr_face *face; /* [patches->count] */
    size_t front_count;
    uint32_t *front; /* [front_count] patches that are not the back of another, rising */
    size_t occluder_count;
    hpr_occluder *occluder; /* [occluder_count] */
    hpr_bounds *bounds;     /* [occluder_count] */
    hpr_convex *outline;    /* [occluder_count] the same in metres */
    size_t divider_count;
    uint32_t *divider; /* [divider_count] occluders with something on both sides of their plane: only these
                        * can come between patches; rising */
    hpr_rays *rays;
};

static inline void hpr_scene_units(const hpr_visibility *visibility, const double point[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = (point[k] - visibility->centre[k]) * visibility->scale;
}

static inline hpr_extent hpr_extent_of(const double low[3], const double high[3])
{
    hpr_extent extent;
    for (int k = 0; k < 3; k++) {
        extent.middle[k] = 0.5 * (low[k] + high[k]);
        extent.half[k] = 0.5 * (high[k] - low[k]);
    }
    return extent;
}

/* Is the occluder out of the way between two boxes: beside the box around both, or its plane does not divide
 * them? low, high: the box around both. At least as generous as the exact tests of what lies in the boxes. */
static inline bool hpr_bounds_aside(const hpr_bounds *bounds, const double low[3], const double high[3],
                                    const hpr_extent end[2])
{
    double height[2], reach[2];
    for (int k = 0; k < 3; k++) {
        if (bounds->low[k] > high[k] || bounds->high[k] < low[k])
            return true;
    }
    for (int e = 0; e < 2; e++) {
        const double *n = bounds->normal, *half = end[e].half;
        height[e] = hpr_dot3(n, end[e].middle) - bounds->distance;
        reach[e] = fabs(n[0]) * half[0] + fabs(n[1]) * half[1] + fabs(n[2]) * half[2];
    }
    return !((height[0] + reach[0] > 0 && height[1] - reach[1] < 0) ||
             (height[0] - reach[0] < 0 && height[1] + reach[1] > 0));
}

/* Is origin + offset, a point of the plane, in the closed patch grown by `growth`? */
static inline bool hpr_face_holds(const hpr_face *face, const double offset[3], double growth, double *s,
                                  double *t)
{
    *s = hpr_dot3(face->dual1, offset);
    *t = hpr_dot3(face->dual2, offset);
    double grow_s = growth * face->per_length[0], grow_t = growth * face->per_length[1];
    if (*s < -grow_s || *t < -grow_t)
        return false;
    if (face->shape == HPR_SHAPE_QUADRILATERAL)
        return face->skew[0][0] + face->skew[0][1] * *s + face->skew[0][2] * *t >= -growth &&
               face->skew[1][0] + face->skew[1][1] * *s + face->skew[1][2] * *t >= -growth;
    if (face->shape == HPR_SHAPE_TRIANGLE)
        return *s + *t <= 1 + growth * face->per_length[2];
    return *s <= 1 + grow_s && *t <= 1 + grow_t;
}

static inline double hpr_face_growth(const hpr_visibility *visibility, double sine)
{
    return fmin(visibility->slack / sine, visibility->reach);
}

/* Is origin + offset, a point of the plane, in the closed polygon grown by `growth`? */
static inline bool hpr_occluder_holds(const hpr_occluder *occluder, const double offset[3], double growth)
{
    for (int k = 0; k < occluder->edge_count; k++) {
        if (hpr_dot3(occluder->inward[k], offset) < occluder->offset[k] - growth)
            return false;
    }
    return true;
}

/* Where the segment between x and y, in scene units, crosses the occluder's plane, relative to its origin,
 * and the sine of the angle between them; false if it does not. */
static inline bool hpr_occluder_crossing(const hpr_visibility *visibility, const hpr_occluder *occluder,
                                         const double x[3], const double y[3], double crossing[3],
                                         double *sine)
{
    double slack = visibility->slack, from_x[3], from_y[3], step[3];
    hpr_subtract3(x, occluder->origin, from_x);
    hpr_subtract3(y, occluder->origin, from_y);
    double height_x = hpr_dot3(occluder->normal, from_x), height_y = hpr_dot3(occluder->normal, from_y);
    if (!((height_x > slack && height_y < -slack) || (height_x < -slack && height_y > slack)))
        return false;
    double drop = height_x - height_y;
    hpr_subtract3(y, x, step);
    hpr_add_scaled3(from_x, height_x / drop, step, crossing);
    *sine = fabs(drop) / hpr_length3(step);
    return true;
}

/* Does the occluder cut the segment between x and y, in scene units? */
static inline bool hpr_occluder_blocks(const hpr_visibility *visibility, const hpr_occluder *occluder,
                                       const double x[3], const double y[3])
{
    double crossing[3], sine;
    return hpr_occluder_crossing(visibility, occluder, x, y, crossing, &sine) &&
           hpr_occluder_holds(occluder, crossing, hpr_face_growth(visibility, sine));
}

/* Where the line base + distance * direction (length 1) meets the face; false if it does not. */
static inline bool hpr_face_hit(const hpr_visibility *visibility, const hpr_face *face, const double base[3],
                                const double direction[3], double *distance, double *s, double *t,
                                bool *from_back)
{
    double offset[3], crossing[3];
    double fall = hpr_dot3(face->normal, direction);
    if (fall == 0 || face->empty)
        return false;
    hpr_subtract3(base, face->origin, offset);
    *distance = -hpr_dot3(face->normal, offset) / fall;
    *from_back = fall > 0;
    hpr_add_scaled3(offset, *distance, direction, crossing);
    return hpr_face_holds(face, crossing, hpr_face_growth(visibility, fabs(fall)), s, t);
}

#endif
