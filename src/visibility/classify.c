#include "visibility/faces.h"

#include <string.h>

/* Two facets in scene units, and what bounds the segments between them. */
typedef struct shaft {
    const hpr_visibility *visibility;
    size_t count[2];
    double corner[2][4][3];
    double normal[2][3];
    double low[3], high[3];
    /* Planes {normal, offset} of the facets' convex hull through an edge of one and a corner of the other:
     * normal . x <= offset for all of the hull. Made when the first candidate gets that far. */
    bool has_planes;
    size_t plane_count;
    double plane[32][4];
} shaft;

static void open_shaft(shaft *sh, const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b)
{
    const hpr_facet *facet[2] = {a, b};
    sh->visibility = visibility;
    sh->has_planes = false;
    for (int k = 0; k < 3; k++) {
        sh->low[k] = INFINITY;
        sh->high[k] = -INFINITY;
    }
    for (int f = 0; f < 2; f++) {
        sh->count[f] = facet[f]->corner_count;
        memcpy(sh->normal[f], facet[f]->normal, sizeof sh->normal[f]);
        for (size_t i = 0; i < sh->count[f]; i++) {
            double *corner = sh->corner[f][i];
            hpr_scene_units(visibility, facet[f]->corner[i], corner);
            for (int k = 0; k < 3; k++) {
                sh->low[k] = fmin(sh->low[k], corner[k]);
                sh->high[k] = fmax(sh->high[k], corner[k]);
            }
        }
    }
}

/* Smallest and largest height of points over the plane through `origin`. */
static void height_range(const double (*point)[3], size_t count, const double origin[3],
                         const double normal[3], double *least, double *most)
{
    *least = INFINITY;
    *most = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        double offset[3];
        hpr_subtract3(point[i], origin, offset);
        double height = hpr_dot3(normal, offset);
        *least = fmin(*least, height);
        *most = fmax(*most, height);
    }
}

static bool reaches_before(const shaft *sh, int facet, const double (*point)[3], size_t count)
{
    double least, most;
    height_range(point, count, sh->corner[facet][0], sh->normal[facet], &least, &most);
    return most > sh->visibility->slack;
}

/* Segments from one facet to the other cross the face's plane. */
static bool plane_divides(const shaft *sh, const hpr_face *face)
{
    double least[2], most[2], slack = sh->visibility->slack;
    for (int f = 0; f < 2; f++)
        height_range((const double(*)[3])sh->corner[f], sh->count[f], face->origin, face->normal, &least[f],
                     &most[f]);
    return (most[0] > slack && least[1] < -slack) || (least[0] < -slack && most[1] > slack);
}

/* The face's box meets the inside of the box around both facets. */
static bool meets_box(const shaft *sh, const double (*corner)[3], size_t count)
{
    double slack = sh->visibility->slack;
    for (int k = 0; k < 3; k++) {
        double least = INFINITY, most = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            least = fmin(least, corner[i][k]);
            most = fmax(most, corner[i][k]);
        }
        if (least >= sh->high[k] - slack || most <= sh->low[k] + slack)
            return false;
    }
    return true;
}

/* Keeps the plane through p, q, r if the facets are on one side of it, whatever its own rounding. */
static void try_plane(shaft *sh, const double p[3], const double q[3], const double r[3])
{
    double edge[3], across[3], normal[3], least[2], most[2], slack = sh->visibility->slack;
    hpr_subtract3(q, p, edge);
    hpr_subtract3(r, p, across);
    hpr_cross3(edge, across, normal);
    double length = hpr_length3(normal);
    if (!(length > slack * slack))
        return;
    for (int k = 0; k < 3; k++)
        normal[k] /= length;
    for (int f = 0; f < 2; f++)
        height_range((const double(*)[3])sh->corner[f], sh->count[f], p, normal, &least[f], &most[f]);
    double sign = fmax(most[0], most[1]) <= slack ? 1 : fmin(least[0], least[1]) >= -slack ? -1 : 0;
    if (sign == 0)
        return;
    double *plane = sh->plane[sh->plane_count++];
    for (int k = 0; k < 3; k++)
        plane[k] = sign * normal[k];
    plane[3] = hpr_dot3(plane, p);
}

static void make_planes(shaft *sh)
{
    sh->has_planes = true;
    sh->plane_count = 0;
    for (int f = 0; f < 2; f++) {
        for (size_t i = 0; i < sh->count[f]; i++) {
            for (size_t j = 0; j < sh->count[1 - f]; j++)
                try_plane(sh, sh->corner[f][i], sh->corner[f][(i + 1) % sh->count[f]], sh->corner[1 - f][j]);
        }
    }
}

/* Some plane of the hull has the whole face outside, or touching it. */
static bool outside_hull(shaft *sh, const double (*corner)[3], size_t count)
{
    double slack = sh->visibility->slack;
    if (!sh->has_planes)
        make_planes(sh);
    for (size_t i = 0; i < sh->plane_count; i++) {
        size_t outside = 0;
        while (outside < count && hpr_dot3(sh->plane[i], corner[outside]) >= sh->plane[i][3] - slack)
            outside++;
        if (outside == count)
            return true;
    }
    return false;
}

static bool may_block(shaft *sh, uint32_t patch)
{
    const hpr_visibility *visibility = sh->visibility;
    const hpr_face *face = &visibility->face[patch];
    double world[4][3], own[4][3];
    if (face->empty || (!face->single && visibility->patches->side[patch] != 0))
        return false;
    if (!plane_divides(sh, face))
        return false;
    size_t count = hpr_patch_corners(visibility->patches, patch, world);
    for (size_t i = 0; i < count; i++)
        hpr_scene_units(visibility, world[i], own[i]);
    const double(*corner)[3] = (const double(*)[3])own;
    return meets_box(sh, corner, count) && reaches_before(sh, 0, corner, count) &&
           reaches_before(sh, 1, corner, count) && !outside_hull(sh, corner, count);
}

hpr_verdict hpr_visibility_classify(const hpr_visibility *visibility, const hpr_facet *a, const hpr_facet *b,
                                    const uint32_t *candidates, size_t candidate_count, uint32_t *blockers,
                                    size_t *blocker_count)
{
    shaft sh;
    open_shaft(&sh, visibility, a, b);
    if (blocker_count)
        *blocker_count = 0;
    if (!reaches_before(&sh, 0, (const double(*)[3])sh.corner[1], sh.count[1]) ||
        !reaches_before(&sh, 1, (const double(*)[3])sh.corner[0], sh.count[0]))
        return HPR_SEES_NOTHING;
    size_t found = 0, count = candidates ? candidate_count : visibility->patches->count;
    for (size_t i = 0; i < count; i++) {
        uint32_t patch = candidates ? candidates[i] : (uint32_t)i;
        if (!may_block(&sh, patch))
            continue;
        if (!blockers && !blocker_count)
            return HPR_SEES_PARTLY;
        if (blockers)
            blockers[found] = patch;
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
