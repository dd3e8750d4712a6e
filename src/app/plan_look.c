#include "app/plan_look.h"

#include "baseline/random.h"
#include "link/afford.h"
#include "quadrature/pair.h"
#include "visibility/views.h"

#include <math.h>
#include <string.h>

typedef struct look {
    const hpr_patches *patches;
    const hpr_visibility *visibility;
    bool *reflects; /* [patches] */
    uint32_t *blocker;
    hpr_plan *plan;
    bool lit, interreflects;
    double gap;
} look;

/* In sizes of the smaller one, the root of its area. */
static double find_gap(const look *l, size_t i, size_t j)
{
    double corner[2][4][3];
    hpr_vec3 polygon[2][4];
    int counts[2] = {(int)hpr_patch_corners(l->patches, i, corner[0]),
                     (int)hpr_patch_corners(l->patches, j, corner[1])};
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < counts[side]; k++)
            polygon[side][k] = (hpr_vec3){corner[side][k][0], corner[side][k][1], corner[side][k][2]};
    }
    return hpr_polygon_distance(polygon[0], counts[0], polygon[1], counts[1]) /
           sqrt(fmin(l->patches->area_m2[i], l->patches->area_m2[j]));
}

static void count(look *l, size_t i, size_t j, hpr_verdict verdict, size_t blockers)
{
    l->plan->pairs_drawn++;
    l->plan->pairs_hidden += verdict == HPR_SEES_NOTHING;
    l->plan->pairs_visible += verdict == HPR_SEES_WHOLLY;
    l->plan->pairs_partial += verdict == HPR_SEES_PARTLY;
    if (verdict == HPR_SEES_PARTLY)
        l->plan->blocker_count += (double)blockers;
    if (verdict == HPR_SEES_NOTHING)
        return;
    l->interreflects |= l->reflects[i] || l->reflects[j];
    if (l->gap > 0)
        l->gap = fmin(l->gap, find_gap(l, i, j));
}

static hpr_status look_at_all(look *l)
{
    size_t n = l->patches->count, blockers = 0;
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    hpr_status status = hpr_views_create(l->visibility, NULL, &views);
    if (status == HPR_OK)
        status = hpr_views_cursor_create(views, &cursor);
    for (size_t i = 0; status == HPR_OK && i < n && !hpr_cancelled(l->patches->context); i++) {
        for (size_t j = i + 1; j < n; j++)
            count(l, i, j, hpr_views_classify(views, cursor, i, j, l->blocker, &blockers), blockers);
    }
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    return status;
}

static void look_at_some(look *l)
{
    enum { MOST_DRAWN = 20000, ENOUGH = 400 };
    size_t n = l->patches->count, blockers = 0;
    hpr_random random = hpr_random_of(1, 0, 0, 0);
    for (int k = 0; k < MOST_DRAWN && l->plan->pairs_drawn - l->plan->pairs_hidden < ENOUGH; k++) {
        size_t i = (size_t)(hpr_random_unit(&random) * (double)n),
               j = (size_t)(hpr_random_unit(&random) * (double)n);
        hpr_facet a = hpr_patch_facet(l->patches, i), b = hpr_patch_facet(l->patches, j);
        if (i != j)
            count(l, i, j, hpr_visibility_classify(l->visibility, &a, &b, NULL, 0, l->blocker, &blockers),
                  blockers);
    }
}

/* From drawn pairs to all. */
static void scale(hpr_plan *plan)
{
    double factor = plan->pairs_drawn > 0 ? plan->pairs / plan->pairs_drawn : 0;
    plan->blocker_count = plan->pairs_partial > 0 ? plan->blocker_count / plan->pairs_partial : 0;
    plan->pairs_hidden *= factor;
    plan->pairs_visible *= factor;
    plan->pairs_partial *= factor;
}

/* A point of a patch and a direction from it, as diffuse light leaves it. */
static void draw_ray(const hpr_patches *patches, size_t patch, hpr_random *random, double origin[3],
                     double direction[3])
{
    static const double turn = 6.283185307179586;
    double s = hpr_random_unit(random), t = hpr_random_unit(random), u = hpr_random_unit(random),
           angle = turn * hpr_random_unit(random), edge = 0;
    if (s + t > 1) { /* in the triangle of the two edges, which every shape holds */
        s = 1 - s;
        t = 1 - t;
    }
    const double *o = patches->origin + 3 * patch, *e1 = patches->edge1 + 3 * patch,
                 *e2 = patches->edge2 + 3 * patch, *n = patches->normal + 3 * patch;
    for (int k = 0; k < 3; k++) {
        origin[k] = o[k] + s * e1[k] + t * e2[k];
        edge += e1[k] * e1[k];
    }
    const double across[3] = {n[1] * e1[2] - n[2] * e1[1], n[2] * e1[0] - n[0] * e1[2],
                              n[0] * e1[1] - n[1] * e1[0]};
    for (int k = 0; k < 3; k++)
        direction[k] = sqrt(1 - u) * n[k] + sqrt(u / edge) * (cos(angle) * e1[k] + sin(angle) * across[k]);
}

/* The part of rays from all fronts, weighted by area, that meet nothing. */
static double find_openness(const look *l)
{
    enum { RAYS = 4096 };
    const hpr_patches *patches = l->patches;
    double area = 0, open = 0;
    size_t each = patches->count < RAYS ? 1 + RAYS / (patches->count + 1) : 1;
    for (size_t i = 0; i < patches->count; i++) {
        hpr_random random = hpr_random_of(2, i, 0, 0);
        for (size_t k = 0; k < each; k++) {
            double origin[3], direction[3];
            draw_ray(patches, i, &random, origin, direction);
            hpr_hit hit =
                hpr_visibility_first_hit(l->visibility, origin, direction, 0, INFINITY, false, NULL);
            open += hit.patch == HPR_NONE ? patches->area_m2[i] : 0;
            area += patches->area_m2[i];
        }
    }
    return area > 0 ? open / area : 1;
}

static hpr_status look_around(look *l, const hpr_elements *elements)
{
    hpr_context *ctx = l->patches->context;
    size_t n = l->patches->count, channels = l->patches->channel_count;
    l->plan->patch_count = n;
    l->plan->pairs = 0.5 * (double)n * ((double)n - 1);
    l->plan->occluder_count = hpr_visibility_occluder_count(l->visibility);
    hpr_status status = hpr_allocate_into(ctx, &l->reflects, n, sizeof *l->reflects, "a plan");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &l->blocker, l->plan->occluder_count, sizeof *l->blocker, "a plan");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < n * channels; i++)
        l->reflects[i / channels] |= l->patches->reflectance[i] > 0;
    if (n <= HPR_PLAN_FEW_PATCHES) {
        status = look_at_all(l);
    } else {
        look_at_some(l);
        if (l->lit && hpr_links_afford(l->visibility, elements, 0) != HPR_OK) {
            hpr_context_clear_error(ctx);
            l->plan->least_bytes = hpr_links_predict(l->visibility, elements);
        }
    }
    scale(l->plan);
    if (status == HPR_OK && hpr_cancelled(ctx))
        status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted");
    return status;
}

/* Do all patches emit and reflect alike? */
static bool all_alike(const hpr_patches *patches)
{
    size_t n = patches->channel_count;
    for (size_t i = n; i < patches->count * n; i++) {
        if (patches->exitance[i] != patches->exitance[i % n] ||
            patches->reflectance[i] != patches->reflectance[i % n])
            return false;
    }
    return true;
}

hpr_status hpr_plan_look(const hpr_solution *solution, hpr_plan *plan, hpr_effect_facts *facts,
                         hpr_outlook *outlook)
{
    static const double touching = 1e-9;
    hpr_visibility *visibility = NULL;
    hpr_context *ctx = solution->context;
    hpr_status status = hpr_visibility_create(solution->patches, &visibility);
    look l = {.patches = solution->patches,
              .visibility = visibility,
              .plan = plan,
              .gap = INFINITY,
              .lit = facts->lit};
    if (status == HPR_OK)
        status = look_around(&l, solution->elements);
    if (status == HPR_OK) {
        facts->occluded = plan->pairs_partial > 0;
        facts->interreflects = l.interreflects;
        facts->escaping = find_openness(&l);
        *outlook = (hpr_outlook){.gap = l.gap < touching ? 0 : l.gap,
                                 .trial_error = NAN,
                                 .slowness = 1,
                                 .lit = facts->lit,
                                 .uniform = facts->escaping == 0 && all_alike(solution->patches)};
    }
    hpr_release(ctx, l.reflects);
    hpr_release(ctx, l.blocker);
    hpr_visibility_destroy(&visibility);
    return status;
}
