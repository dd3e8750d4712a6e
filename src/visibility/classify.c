#include "math/hull.h"
#include "visibility/faces.h"

#include <string.h>

enum { FACET_CORNERS = 5, MAX_PLANES = 2 + 2 * FACET_CORNERS };

/* Two facets in scene units, each without what is behind the other's plane, and what bounds the segments
 * between them. */
typedef struct shaft {
    const hpr_visibility *visibility;
    size_t count[2];
    double corner[2][FACET_CORNERS][3];
    double normal[2][3];
    double low[3], high[3]; /* box around both */
    hpr_extent end[2];      /* box of each */
    /* Planes {normal, offset} of the facets' convex hull: normal . x <= offset for all of it. Made when the
     * first candidate gets that far. */
    bool has_planes;
    size_t plane_count,
        last; /* last: the plane that had the last candidate outside; its neighbours are next */
    double plane[MAX_PLANES][4];
} shaft;

static void open_shaft(shaft *sh, const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b)
{
    const hpr_facet *facet[2] = {a, b};
    sh->visibility = visibility;
    sh->has_planes = false;
    for (int f = 0; f < 2; f++) {
        sh->count[f] = facet[f]->corner_count;
        memcpy(sh->normal[f], facet[f]->normal, sizeof sh->normal[f]);
        for (size_t i = 0; i < sh->count[f]; i++)
            hpr_scene_units(visibility, facet[f]->corner[i], sh->corner[f][i]);
    }
}

static double height_over(const double normal[3], const double origin[3], const double point[3])
{
    double offset[3];
    hpr_subtract3(point, origin, offset);
    return hpr_dot3(normal, offset);
}

/* Smallest and largest height of a facet's corners over the plane through `origin`. */
static void height_range(const shaft *sh, int facet, const double origin[3], const double normal[3],
                         double *least, double *most)
{
    *least = *most = height_over(normal, origin, sh->corner[facet][0]);
    for (size_t i = 1; i < sh->count[facet]; i++) {
        double height = height_over(normal, origin, sh->corner[facet][i]);
        *least = hpr_min(*least, height);
        *most = hpr_max(*most, height);
    }
}

/* Takes away what is behind the other facet's plane (Sutherland & Hodgman 1974); the plane's own points stay.
 * False if nothing is left that sees it. */
static bool keep_front(shaft *sh, int facet)
{
    int other = 1 - facet;
    size_t count = sh->count[facet], kept = 0;
    double least, most, height[FACET_CORNERS], whole[FACET_CORNERS][3];
    height_range(sh, facet, sh->corner[other][0], sh->normal[other], &least, &most);
    if (!(most > sh->visibility->slack))
        return false;
    if (least >= -sh->visibility->slack)
        return true;
    memcpy(whole, sh->corner[facet], sizeof whole);
    for (size_t i = 0; i < count; i++) {
        height[i] = height_over(sh->normal[other], sh->corner[other][0], whole[i]);
    }
    for (size_t i = 0; i < count; i++) {
        size_t next = (i + 1) % count;
        double step[3];
        if (height[i] >= 0)
            memcpy(sh->corner[facet][kept++], whole[i], sizeof *whole);
        if (height[i] * height[next] < 0) {
            hpr_subtract3(whole[next], whole[i], step);
            hpr_add_scaled3(whole[i], height[i] / (height[i] - height[next]), step,
                            sh->corner[facet][kept++]);
        }
    }
    sh->count[facet] = kept;
    return true;
}

static void set_box(shaft *sh)
{
    double low[2][3], high[2][3];
    for (int f = 0; f < 2; f++) {
        for (int k = 0; k < 3; k++) {
            low[f][k] = high[f][k] = sh->corner[f][0][k];
            for (size_t i = 1; i < sh->count[f]; i++) {
                low[f][k] = hpr_min(low[f][k], sh->corner[f][i][k]);
                high[f][k] = hpr_max(high[f][k], sh->corner[f][i][k]);
            }
        }
        sh->end[f] = hpr_extent_of(low[f], high[f]);
    }
    for (int k = 0; k < 3; k++) {
        sh->low[k] = hpr_min(low[0][k], low[1][k]);
        sh->high[k] = hpr_max(high[0][k], high[1][k]);
    }
}

/* Do segments from one facet to the other cross the occluder's plane; do all of them? */
static bool plane_divides(const shaft *sh, const hpr_occluder *occluder, bool *wholly)
{
    double least[2], most[2], slack = sh->visibility->slack;
    for (int f = 0; f < 2; f++)
        height_range(sh, f, occluder->origin, occluder->normal, &least[f], &most[f]);
    *wholly = (least[0] > slack && most[1] < -slack) || (most[0] < -slack && least[1] > slack);
    return (most[0] > slack && least[1] < -slack) || (least[0] < -slack && most[1] > slack);
}

static void make_planes(shaft *sh)
{
    hpr_hull_end end[2];
    for (int f = 0; f < 2; f++)
        end[f] = (hpr_hull_end){(const double(*)[3])sh->corner[f], sh->count[f], sh->normal[f]};
    sh->plane_count = hpr_hull_planes(end, sh->visibility->slack, sh->plane);
    sh->has_planes = true;
    sh->last = 0;
}

/* Something of the occluder is inside all planes of the hull by more than the slack. */
static bool meets_hull(shaft *sh, const hpr_occluder *occluder, const hpr_bounds *bounds)
{
    double cutting[MAX_PLANES][4], slack = sh->visibility->slack;
    size_t cutting_count = 0;
    if (!sh->has_planes)
        make_planes(sh);
    const double *last = sh->plane[sh->last];
    if (hpr_dot3(last, bounds->middle) - bounds->radius >= last[3] - slack)
        return false;
    for (size_t i = 0; i < sh->plane_count; i++) {
        double depth = sh->plane[i][3] - slack - hpr_dot3(sh->plane[i], bounds->middle);
        if (depth <= -bounds->radius) {
            sh->last = i;
            return false;
        }
        if (depth < bounds->radius)
            memcpy(cutting[cutting_count++], sh->plane[i], sizeof *cutting);
    }
    return hpr_hull_meets((const double(*)[4])cutting, cutting_count, occluder->corner,
                          (size_t)occluder->edge_count, slack);
}

/* Every segment from corner to corner is blocked. */
static bool hides(const shaft *sh, const hpr_occluder *occluder)
{
    for (size_t i = 0; i < sh->count[0]; i++) {
        for (size_t j = 0; j < sh->count[1]; j++) {
            if (!hpr_occluder_blocks(sh->visibility, occluder, sh->corner[0][i], sh->corner[1][j]))
                return false;
        }
    }
    return true;
}

/* What one occluder does to the view. */
static hpr_verdict view_past(shaft *sh, uint32_t index)
{
    const hpr_visibility *visibility = sh->visibility;
    const hpr_occluder *occluder = &visibility->occluder[index];
    bool divides_wholly;
    if (hpr_bounds_aside(&visibility->bounds[index], sh->low, sh->high, sh->end) ||
        !meets_hull(sh, occluder, &visibility->bounds[index]) ||
        !plane_divides(sh, occluder, &divides_wholly))
        return HPR_SEES_WHOLLY;
    return divides_wholly && hides(sh, occluder) ? HPR_SEES_NOTHING : HPR_SEES_PARTLY;
}

hpr_verdict hpr_visibility_classify(const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b,
                                    const uint32_t *candidates, size_t candidate_count, uint32_t *blockers,
                                    size_t *blocker_count)
{
    shaft sh;
    open_shaft(&sh, visibility, a, b);
    if (blocker_count)
        *blocker_count = 0;
    if (!keep_front(&sh, 0) || !keep_front(&sh, 1))
        return HPR_SEES_NOTHING;
    set_box(&sh);
    if (!candidates) {
        candidates = visibility->divider;
        candidate_count = visibility->divider_count;
    }
    size_t found = 0;
    for (size_t i = 0; i < candidate_count; i++) {
        uint32_t index = candidates[i];
        hpr_verdict past = view_past(&sh, index);
        if (past == HPR_SEES_NOTHING)
            return past;
        if (past == HPR_SEES_WHOLLY)
            continue;
        if (blockers)
            blockers[found] = index;
        found++;
    }
    if (blocker_count)
        *blocker_count = found;
    return found ? HPR_SEES_PARTLY : HPR_SEES_WHOLLY;
}

static void patch_facet(const hpr_patches *patches, size_t patch, double sign, hpr_facet *facet)
{
    facet->corner_count = hpr_patch_corners(patches, patch, facet->corner);
    for (int k = 0; k < 3; k++)
        facet->normal[k] = sign * patches->normal[3 * patch + k];
}

bool hpr_visibility_unobstructed(const hpr_visibility *visibility, size_t patch)
{
    const hpr_patches *patches = visibility->patches;
    const uint32_t nobody = 0;
    hpr_facet own, other;
    patch_facet(patches, patch, 1, &own);
    for (size_t j = 0; j < patches->count; j++) {
        for (int sign = -1; sign <= 1 && j != patch && j != patches->twin[patch]; sign += 2) {
            patch_facet(patches, j, sign, &other);
            /* Without candidates: whether they face each other. What is hidden wholly is obstructed too. */
            if (hpr_visibility_classify(visibility, &own, &other, &nobody, 0, NULL, NULL) !=
                    HPR_SEES_NOTHING &&
                hpr_visibility_classify(visibility, &own, &other, NULL, 0, NULL, NULL) != HPR_SEES_WHOLLY)
                return false;
        }
    }
    return true;
}
