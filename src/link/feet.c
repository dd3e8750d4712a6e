#include "link/feet.h"

#include "math/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The box of a patch. */
typedef struct hpr_foot_box {
    double low[3], high[3];
    uint32_t patch;
} hpr_foot_box;

/* Where the outline of another patch meets the plane of the search's patch: its edges in the plane, or the
 * chord in which it crosses. */
static hpr_status add_feet(hpr_feet *f, uint32_t other)
{
    const hpr_patches *patches = f->patches;
    double corner[4][3], height[4], point[8][3];
    size_t count = hpr_patch_corners(patches, other, corner), points = 0;
    for (size_t i = 0; i < count; i++) {
        double offset[3];
        hpr_subtract3(corner[i], patches->origin + 3 * (size_t)f->patch, offset);
        height[i] = hpr_dot3(offset, patches->normal + 3 * (size_t)f->patch);
    }
    hpr_status status = HPR_OK;
    bool coplanar = true;
    for (size_t i = 0; i < count; i++)
        coplanar &= fabs(height[i]) <= f->slack;
    f->faced |=
        coplanar && hpr_dot3(patches->normal + 3 * (size_t)f->patch, patches->normal + 3 * (size_t)other) < 0;
    for (size_t i = 0; i < count && status == HPR_OK; i++) {
        size_t j = (i + 1) % count;
        bool here = fabs(height[i]) <= f->slack, there = fabs(height[j]) <= f->slack;
        if (here && there) {
            hpr_foot edge;
            hpr_patch_parameters(patches, f->patch, corner[i], &edge.from[0], &edge.from[1]);
            hpr_patch_parameters(patches, f->patch, corner[j], &edge.to[0], &edge.to[1]);
            status = hpr_grow(f->patches->context, &f->foot, &f->capacity, f->count + 1, sizeof edge);
            if (status == HPR_OK)
                f->foot[f->count++] = edge;
        } else if (here) {
            memcpy(point[points++], corner[i], sizeof *point);
        } else if (!there && height[i] * height[j] < 0) {
            for (int k = 0; k < 3; k++)
                point[points][k] =
                    corner[i][k] + height[i] / (height[i] - height[j]) * (corner[j][k] - corner[i][k]);
            points++;
        }
    }
    if (status == HPR_OK && points == 2) {
        hpr_foot chord;
        hpr_patch_parameters(patches, f->patch, point[0], &chord.from[0], &chord.from[1]);
        hpr_patch_parameters(patches, f->patch, point[1], &chord.to[0], &chord.to[1]);
        status = hpr_grow(f->patches->context, &f->foot, &f->capacity, f->count + 1, sizeof chord);
        if (status == HPR_OK)
            f->foot[f->count++] = chord;
    }
    return status;
}

/* side[i][0] s + side[i][1] t >= side[i][2] inside; returns the number of sides. */
static int domain_sides(hpr_shape shape, const double opposite[2], double side[4][3])
{
    bool triangle = shape == HPR_SHAPE_TRIANGLE;
    const double fixed[4][3] = {{1, 0, 0}, {0, 1, 0}, {-1, triangle ? -1 : 0, -1}, {0, -1, -1}};
    memcpy(side, fixed, sizeof fixed);
    if (shape == HPR_SHAPE_QUADRILATERAL) {
        double a = opposite[0], b = opposite[1], c[2] = {hypot(a - 1, b), hypot(a, b - 1)};
        const double skew[2][3] = {{-b / c[0], (a - 1) / c[0], -b / c[0]},
                                   {(b - 1) / c[1], -a / c[1], -a / c[1]}};
        memcpy(side[2], skew, sizeof skew);
    }
    return triangle ? 3 : 4;
}

bool hpr_foot_cuts(const hpr_foot *f, hpr_shape shape, const double opposite[2], double slack)
{
    double low = 0, high = 1; /* the part of the segment inside, clipped by the sides moved inward */
    double d[2] = {f->to[0] - f->from[0], f->to[1] - f->from[1]}, side[4][3];
    int sides = domain_sides(shape, opposite, side);
    for (int i = 0; i < sides; i++) {
        double at = side[i][0] * f->from[0] + side[i][1] * f->from[1] - side[i][2] - slack;
        double along = side[i][0] * d[0] + side[i][1] * d[1];
        if (along == 0) {
            if (at <= 0)
                return false;
        } else if (along > 0) {
            low = fmax(low, -at / along);
        } else {
            high = fmin(high, -at / along);
        }
    }
    return (high - low) * hypot(d[0], d[1]) > slack;
}

static int compare_boxes(const void *left, const void *right)
{
    const hpr_foot_box *a = left, *b = right;
    if (a->low[0] != b->low[0])
        return a->low[0] < b->low[0] ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

static hpr_foot_box box_of(const hpr_patches *patches, uint32_t patch)
{
    double corner[4][3];
    size_t count = hpr_patch_corners(patches, patch, corner);
    hpr_foot_box box = {.patch = patch};
    for (int k = 0; k < 3; k++) {
        box.low[k] = box.high[k] = corner[0][k];
        for (size_t i = 1; i < count; i++) {
            box.low[k] = fmin(box.low[k], corner[i][k]);
            box.high[k] = fmax(box.high[k], corner[i][k]);
        }
    }
    return box;
}

static hpr_status make_boxes(hpr_feet *f)
{
    const hpr_patches *patches = f->patches;
    hpr_status status =
        hpr_allocate_into(f->patches->context, &f->box, patches->count, sizeof *f->box, "covered elements");
    for (uint32_t i = 0; status == HPR_OK && i < patches->count; i++) {
        f->box[i] = box_of(patches, i);
        f->widest = fmax(f->widest, f->box[i].high[0] - f->box[i].low[0]);
    }
    if (status == HPR_OK)
        qsort(f->box, patches->count, sizeof *f->box, compare_boxes);
    return status;
}

static bool boxes_meet(const hpr_foot_box *a, const hpr_foot_box *b, double slack)
{
    bool apart = false;
    for (int k = 0; k < 3; k++)
        apart |= a->low[k] > b->high[k] + slack || b->low[k] > a->high[k] + slack;
    return !apart;
}

/* The first box that begins at x or after it. */
static size_t first_from(const hpr_feet *f, double x)
{
    size_t low = 0, high = f->patches->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (f->box[middle].low[0] < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

hpr_status hpr_feet_find(hpr_feet *f, uint32_t patch)
{
    f->patch = patch;
    const hpr_patches *patches = f->patches;
    hpr_shape shape = (hpr_shape)patches->shape[f->patch];
    double size = sqrt(patches->area_m2[f->patch]);
    hpr_foot_box own = box_of(patches, f->patch);
    hpr_status status = HPR_OK;
    f->count = 0;
    f->faced = false;
    for (size_t i = first_from(f, own.low[0] - f->widest - f->slack);
         i < patches->count && f->box[i].low[0] <= own.high[0] + f->slack && status == HPR_OK; i++) {
        uint32_t other = f->box[i].patch;
        if (other != f->patch && other != patches->twin[f->patch] && boxes_meet(&own, &f->box[i], f->slack))
            status = add_feet(f, other);
    }
    size_t kept = 0;
    for (size_t i = 0; i < f->count; i++) {
        if (hpr_foot_cuts(&f->foot[i], shape, patches->opposite + 2 * (size_t)f->patch, f->slack / size))
            f->foot[kept++] = f->foot[i];
    }
    f->count = kept;
    return status;
}

hpr_status hpr_feet_init(const hpr_patches *patches, double slack_m, hpr_feet *f)
{
    *f = (hpr_feet){.patches = patches, .slack = slack_m};
    return make_boxes(f);
}

void hpr_feet_fini(hpr_feet *f)
{
    hpr_release(f->patches->context, f->box);
    hpr_release(f->patches->context, f->foot);
}
