#include "patch/grade.h"

#include "math/vec3.h"

#include <math.h>

/* Sides of a parallelogram, or of the unit square of a quadrilateral: where a parameter is at its end. */
enum { SIDE_S0, SIDE_S1, SIDE_T0, SIDE_T1, SIDES };

typedef struct grading {
    const hpr_patches *patches;
    double least;          /* width of the narrowest strips, 2^-levels */
    bool (*shared)[SIDES]; /* [patches] */
} grading;

/* Is the point on a patch, its rim included? */
static bool touches(const hpr_patches *patches, size_t patch, const double point[3])
{
    double s, t, gap2 = 0, slack = patches->weld_m;
    if (patches->area_m2[patch] == 0)
        return false;
    hpr_patch_parameters(patches, patch, point, &s, &t);
    double over = patches->shape[patch] == HPR_SHAPE_TRIANGLE ? fmax(s + t - 1, 0) : 0;
    if (patches->shape[patch] == HPR_SHAPE_QUADRILATERAL) {
        hpr_quad_bring_inside(patches->opposite + 2 * patch, &s, &t);
    } else {
        s = fmin(fmax(s, 0), 1);
        t = fmin(fmax(t, 0), 1);
    }
    if (over > 0) {
        s -= over / 2;
        t -= over / 2;
    }
    for (int k = 0; k < 3; k++) {
        size_t i = 3 * patch + (size_t)k;
        double gap = point[k] - (patches->origin[i] + s * patches->edge1[i] + t * patches->edge2[i]);
        gap2 += gap * gap;
    }
    return gap2 <= slack * slack;
}

/* A patch on its back, or in its plane and facing the same way, gives no edge. */
static bool meets_at_an_angle(const hpr_patches *patches, size_t a, size_t b)
{
    static const double flat = 1e-6;
    hpr_vec3 n = hpr_cross(hpr_vec3_load(patches->normal + 3 * a), hpr_vec3_load(patches->normal + 3 * b));
    return a != b && hpr_length(n) > flat;
}

static bool is_shared(const hpr_patches *patches, size_t patch, int side)
{
    enum { PLACES = 9 };
    for (int place = 1; place <= PLACES; place++) {
        double along = (double)place / (PLACES + 1), point[3];
        double s = side == SIDE_S0 ? 0 : side == SIDE_S1 ? 1 : along;
        double t = side == SIDE_T0 ? 0 : side == SIDE_T1 ? 1 : along;
        if (patches->shape[patch] == HPR_SHAPE_QUADRILATERAL) { /* the bilinear map */
            double both = s * t;
            s += both * (patches->opposite[2 * patch] - 1);
            t += both * (patches->opposite[2 * patch + 1] - 1);
        }
        for (int k = 0; k < 3; k++) {
            size_t i = 3 * patch + (size_t)k;
            point[k] = patches->origin[i] + s * patches->edge1[i] + t * patches->edge2[i];
        }
        for (size_t other = 0; other < patches->count; other++) {
            if (meets_at_an_angle(patches, patch, other) && touches(patches, other, point))
                return true;
        }
    }
    return false;
}

/* A piece is a box; the widest that it may be along each axis. */
static void widest(const grading *g, const bool shared[SIDES], const double low[2], const double high[2],
                   double limit[2])
{
    limit[0] = limit[1] = 1;
    for (int side = 0; side < SIDES; side++) {
        if (!shared[side])
            continue;
        int across = side < SIDE_T0 ? 0 : 1, along = 1 - across;
        bool far_end = side % 2;
        double near = far_end ? 1 - high[across] : low[across],
               far = far_end ? 1 - low[across] : high[across];
        if (near == 0)
            limit[across] = fmin(limit[across], g->least);
        if (low[along] == 0 || high[along] == 1)
            limit[along] = fmin(limit[along], fmax(far, g->least));
    }
}

static int choose(void *user, const hpr_piece_of_leaf *piece)
{
    const grading *g = user;
    if (g->patches->shape[piece->patch] == HPR_SHAPE_TRIANGLE)
        return -1;
    double high[2] = {piece->origin[0] + piece->edge1[0], piece->origin[1] + piece->edge2[1]}, limit[2];
    widest(g, g->shared[piece->patch], piece->origin, high, limit);
    double s = piece->edge1[0] / limit[0], t = piece->edge2[1] / limit[1];
    return s <= 1 && t <= 1 ? -1 : s >= t ? 0 : 1;
}

hpr_status hpr_elements_grade(const hpr_patches *patches, hpr_elements *elements, int levels,
                              size_t *skipped_count)
{
    hpr_context *ctx = patches->context;
    grading g = {.patches = patches, .least = ldexp(1, -levels)};
    *skipped_count = 0;
    if (levels < 0 || levels > HPR_MAX_GRADE)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d levels of grading are not in 0 .. %d", levels, HPR_MAX_GRADE);
    hpr_status status =
        hpr_allocate_into(ctx, &g.shared, patches->count, sizeof *g.shared, "graded elements");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < patches->count; i++) {
        bool triangle = patches->shape[i] == HPR_SHAPE_TRIANGLE;
        *skipped_count += triangle;
        for (int side = 0; side < SIDES && !triangle && patches->area_m2[i] > 0; side++)
            g.shared[i][side] = is_shared(patches, i, side);
    }
    status = hpr_elements_refine(patches, elements, choose, &g);
    hpr_release(ctx, g.shared);
    return status;
}
