#include "visibility/faces.h"

#include <string.h>

enum { FACET_CORNERS = 5, MAX_PLANES = 2 * FACET_CORNERS * FACET_CORNERS };

/* Two facets in scene units, each without what is behind the other's plane, and what bounds the segments
 * between them. */
typedef struct shaft {
    const hpr_visibility *visibility;
    size_t count[2];
    double corner[2][FACET_CORNERS][3];
    double normal[2][3];
    double low[3], high[3];
    /* Planes {normal, offset} of the facets' convex hull through an edge of one and a corner of the other:
     * normal . x <= offset for all of the hull. Made when the first candidate gets that far. */
    bool has_planes;
    size_t plane_count;
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

/* Takes away what is behind the other facet's plane (Sutherland & Hodgman 1974); the plane's own points stay.
 * False if nothing is left that sees it. */
static bool keep_front(shaft *sh, int facet)
{
    int other = 1 - facet;
    size_t count = sh->count[facet], kept = 0;
    double least, most, height[FACET_CORNERS], whole[FACET_CORNERS][3];
    height_range((const double(*)[3])sh->corner[facet], count, sh->corner[other][0], sh->normal[other],
                 &least, &most);
    if (!(most > sh->visibility->slack))
        return false;
    if (least >= -sh->visibility->slack)
        return true;
    memcpy(whole, sh->corner[facet], sizeof whole);
    for (size_t i = 0; i < count; i++) {
        double offset[3];
        hpr_subtract3(whole[i], sh->corner[other][0], offset);
        height[i] = hpr_dot3(sh->normal[other], offset);
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
    for (int k = 0; k < 3; k++) {
        sh->low[k] = INFINITY;
        sh->high[k] = -INFINITY;
        for (int f = 0; f < 2; f++) {
            for (size_t i = 0; i < sh->count[f]; i++) {
                sh->low[k] = fmin(sh->low[k], sh->corner[f][i][k]);
                sh->high[k] = fmax(sh->high[k], sh->corner[f][i][k]);
            }
        }
    }
}

/* Do segments from one facet to the other cross the occluder's plane; do all of them? */
static bool plane_divides(const shaft *sh, const hpr_occluder *occluder, bool *wholly)
{
    double least[2], most[2], slack = sh->visibility->slack;
    for (int f = 0; f < 2; f++)
        height_range((const double(*)[3])sh->corner[f], sh->count[f], occluder->origin, occluder->normal,
                     &least[f], &most[f]);
    *wholly = (least[0] > slack && most[1] < -slack) || (most[0] < -slack && least[1] > slack);
    return (most[0] > slack && least[1] < -slack) || (least[0] < -slack && most[1] > slack);
}

/* The occluder's box meets the inside of the box around both facets. */
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

/* The part of a polygon where limit - plane . x > 0 (Sutherland & Hodgman 1974); returns its corners. */
static size_t cut(const double (*in)[3], size_t count, const double plane[3], double limit, double (*out)[3])
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        const double *p = in[i], *q = in[(i + 1) % count];
        double hp = limit - hpr_dot3(plane, p), hq = limit - hpr_dot3(plane, q), step[3];
        if (hp > 0)
            memcpy(out[kept++], p, sizeof *out);
        if ((hp > 0) != (hq > 0)) {
            hpr_subtract3(q, p, step);
            hpr_add_scaled3(p, hp / (hp - hq), step, out[kept++]);
        }
    }
    return kept;
}

/* Something of the occluder is inside all planes of the hull by more than the slack. */
static bool meets_hull(shaft *sh, const double (*corner)[3], size_t count)
{
    double part[2][HPR_OCCLUDER_CORNERS + 2 + MAX_PLANES][3], slack = sh->visibility->slack;
    if (!sh->has_planes)
        make_planes(sh);
    for (size_t i = 0; i < sh->plane_count + 2; i++) {
        const double *plane = i < 2 ? sh->normal[i] : sh->plane[i - 2];
        double flipped[3], limit = i < 2 ? -hpr_dot3(plane, sh->corner[i][0]) : sh->plane[i - 2][3];
        for (int k = 0; k < 3; k++)
            flipped[k] = i < 2 ? -plane[k] : plane[k];
        size_t left = cut(corner, count, flipped, limit - slack, part[i % 2]);
        if (!left)
            return false;
        corner = (const double(*)[3])part[i % 2];
        count = left;
    }
    return true;
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
    const hpr_convex *outline = &visibility->outline[index];
    double own[HPR_OCCLUDER_CORNERS][3];
    bool divides_wholly;
    if (!plane_divides(sh, occluder, &divides_wholly))
        return HPR_SEES_WHOLLY;
    size_t count = (size_t)outline->count;
    for (size_t i = 0; i < count; i++) {
        double world[3];
        hpr_vec3_store(world, outline->corner[i]);
        hpr_scene_units(visibility, world, own[i]);
    }
    const double(*corner)[3] = (const double(*)[3])own;
    if (!meets_box(sh, corner, count) || !meets_hull(sh, corner, count))
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
