#include "patch/overlap.h"

#include "math/vec3.h"

#include <math.h>
#include <stdlib.h>

/* A patch with its box. */
typedef struct outline {
    double low[3], high[3];
    hpr_vec3 normal, corner[4];
    size_t count;
    uint32_t patch;
} outline;

static outline outline_of(const hpr_patches *patches, uint32_t patch)
{
    double corner[4][3];
    outline it = {.count = hpr_patch_corners(patches, patch, corner),
                  .normal = hpr_vec3_load(patches->normal + 3 * (size_t)patch),
                  .patch = patch};
    for (size_t i = 0; i < it.count; i++) {
        it.corner[i] = hpr_vec3_load(corner[i]);
        for (int k = 0; k < 3; k++) {
            it.low[k] = i ? fmin(it.low[k], corner[i][k]) : corner[i][k];
            it.high[k] = i ? fmax(it.high[k], corner[i][k]) : corner[i][k];
        }
    }
    return it;
}

static int compare_outlines(const void *left, const void *right)
{
    const outline *a = left, *b = right;
    if (a->low[0] != b->low[0])
        return a->low[0] < b->low[0] ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

/* Are all corners of b this near to a's plane? */
static bool in_plane(const outline *a, const outline *b, double slack)
{
    for (size_t i = 0; i < b->count; i++) {
        if (fabs(hpr_dot(a->normal, hpr_sub(b->corner[i], a->corner[0]))) > slack)
            return false;
    }
    return true;
}

/* Is b beyond some edge of a, but for the slack? */
static bool beyond(const outline *a, const outline *b, double slack)
{
    for (size_t i = 0; i < a->count; i++) {
        hpr_vec3 edge = hpr_sub(a->corner[(i + 1) % a->count], a->corner[i]);
        hpr_vec3 outward = hpr_cross(edge, a->normal);
        double nearest = INFINITY;
        for (size_t k = 0; k < b->count; k++)
            nearest = fmin(nearest, hpr_dot(outward, hpr_sub(b->corner[k], a->corner[i])));
        if (nearest >= -slack * hpr_length(outward))
            return true;
    }
    return false;
}

static bool overlap(const outline *a, const outline *b, double slack)
{
    for (int k = 1; k < 3; k++) {
        if (a->low[k] > b->high[k] + slack || b->low[k] > a->high[k] + slack)
            return false;
    }
    return hpr_dot(a->normal, b->normal) > 0 && in_plane(a, b, slack) && in_plane(b, a, slack) &&
           !beyond(a, b, slack) && !beyond(b, a, slack);
}

static void keep(hpr_overlaps *overlaps, uint32_t a, uint32_t b)
{
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    bool first = overlaps->count == 0 || low < overlaps->first[0] ||
                 (low == overlaps->first[0] && high < overlaps->first[1]);
    if (first) {
        overlaps->first[0] = low;
        overlaps->first[1] = high;
    }
    overlaps->count++;
}

hpr_status hpr_overlaps_find(const hpr_patches *patches, hpr_overlaps *overlaps)
{
    outline *list = NULL;
    size_t count = 0;
    *overlaps = (hpr_overlaps){.first = {HPR_NONE, HPR_NONE}};
    hpr_status status =
        hpr_allocate_into(patches->context, &list, patches->count, sizeof *list, "patches that overlap");
    if (status != HPR_OK)
        return status;
    for (uint32_t i = 0; i < patches->count; i++) {
        if (patches->area_m2[i] > 0)
            list[count++] = outline_of(patches, i);
    }
    qsort(list, count, sizeof *list, compare_outlines);
    for (size_t i = 0; i < count; i++) {
        for (size_t j = i + 1; j < count && list[j].low[0] <= list[i].high[0]; j++) {
            if (overlap(&list[i], &list[j], patches->weld_m))
                keep(overlaps, list[i].patch, list[j].patch);
        }
    }
    hpr_release(patches->context, list);
    return HPR_OK;
}
