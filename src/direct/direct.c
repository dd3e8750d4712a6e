#include "direct/direct.h"

#include "direct/lambert.h"
#include "direct/visible.h"
#include "patch/paint.h"
#include "visibility/views.h"

#include <string.h>

/* Each is clipped at every point. */
enum { MAX_EMITTERS = 16 };

/* How a leaf sees an emitter. */
typedef struct sight {
    uint8_t verdict;     /* hpr_verdict */
    size_t first, count; /* its blockers in hpr_direct.blocker */
} sight;

struct hpr_direct {
    hpr_context *context;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_visibility *visibility;
    size_t emitter_count;
    uint32_t *emitter; /* [emitter_count] patches with a constant M > 0 */
    hpr_convex *light; /* [emitter_count] their outlines */
    sight *sights;     /* [leaf_count][emitter_count] */
    uint32_t *blocker;
    size_t blocker_count, blocker_capacity;
    double size; /* of the scene */
};

/* A constant M. */
static bool emits(const hpr_patches *patches, size_t patch)
{
    if (hpr_patch_glow(patches, patch))
        return false;
    for (size_t c = 0; c < patches->channel_count; c++) {
        if (patches->exitance[patches->channel_count * patch + c] > 0)
            return true;
    }
    return false;
}

static size_t count_emitters(const hpr_patches *patches)
{
    size_t count = 0;
    for (size_t i = 0; i < patches->count; i++)
        count += emits(patches, i);
    return count;
}

bool hpr_direct_affordable(const hpr_patches *patches)
{
    return count_emitters(patches) <= MAX_EMITTERS;
}

void hpr_direct_destroy(hpr_direct **out)
{
    hpr_direct *direct = *out;
    if (!direct)
        return;
    hpr_context *ctx = direct->context;
    hpr_visibility_destroy(&direct->visibility);
    void *arrays[] = {direct->light, direct->emitter, direct->sights, direct->blocker};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, direct);
    *out = NULL;
}

static void leaf_facet(const hpr_direct *direct, size_t leaf, hpr_facet *facet)
{
    const hpr_elements *e = direct->elements;
    size_t node = e->leaf[leaf], patch = e->patch[node];
    hpr_shape shape = (hpr_shape)direct->patches->shape[patch];
    const double *opposite = e->opposite + 2 * node;
    facet->corner_count = shape == HPR_SHAPE_TRIANGLE ? 3 : 4;
    for (int k = 0; k < 3; k++) {
        double o = e->origin[3 * node + (size_t)k], a = e->edge1[3 * node + (size_t)k],
               b = e->edge2[3 * node + (size_t)k];
        facet->corner[0][k] = o;
        facet->corner[1][k] = o + a;
        facet->corner[2][k] = shape == HPR_SHAPE_TRIANGLE        ? o + b
                              : shape == HPR_SHAPE_PARALLELOGRAM ? o + a + b
                                                                 : o + opposite[0] * a + opposite[1] * b;
        facet->corner[3][k] = o + b;
    }
    memcpy(facet->normal, direct->patches->normal + 3 * patch, sizeof facet->normal);
}

/* Verdict and blockers of one leaf, out of the candidates of its patch. found: room for them. */
static hpr_status look(hpr_direct *direct, size_t leaf, size_t emitter, const uint32_t *candidates,
                       size_t candidate_count, uint32_t *found)
{
    hpr_facet own, light = hpr_patch_facet(direct->patches, direct->emitter[emitter]);
    size_t count = 0;
    sight *it = &direct->sights[leaf * direct->emitter_count + emitter];
    leaf_facet(direct, leaf, &own);
    it->verdict = (uint8_t)hpr_visibility_classify(direct->visibility, &own, &light, candidates,
                                                   candidate_count, found, &count);
    hpr_status status = hpr_grow(direct->context, &direct->blocker, &direct->blocker_capacity,
                                 direct->blocker_count + count, sizeof *direct->blocker);
    if (status != HPR_OK)
        return status;
    it->first = direct->blocker_count;
    it->count = count;
    if (count)
        memcpy(direct->blocker + direct->blocker_count, found, count * sizeof *found);
    direct->blocker_count += count;
    return HPR_OK;
}

static hpr_status look_from_patch(hpr_direct *direct, const hpr_views *views, hpr_views_cursor *cursor,
                                  size_t patch, size_t emitter, uint32_t *candidates, uint32_t *found)
{
    const hpr_elements *e = direct->elements;
    size_t count = 0;
    hpr_verdict verdict =
        hpr_views_classify(views, cursor, direct->emitter[emitter], patch, candidates, &count);
    hpr_status status = HPR_OK;
    for (size_t leaf = e->patch_leaf[patch]; status == HPR_OK && leaf < e->patch_leaf[patch + 1]; leaf++) {
        if (verdict == HPR_SEES_NOTHING)
            direct->sights[leaf * direct->emitter_count + emitter] = (sight){.verdict = HPR_SEES_NOTHING};
        else
            status = look(direct, leaf, emitter, candidates, count, found);
    }
    return status;
}

static hpr_status look_everywhere(hpr_direct *direct)
{
    hpr_context *ctx = direct->context;
    size_t patches = direct->patches->count;
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    bool *wanted = NULL;
    uint32_t *candidates = NULL, *found = NULL;
    hpr_status status = hpr_visibility_create(direct->patches, &direct->visibility);
    if (status != HPR_OK)
        return status;
    size_t occluders = hpr_visibility_occluder_count(direct->visibility);
    status = hpr_allocate_into(ctx, &wanted, patches, sizeof *wanted, "direct light");
    for (size_t k = 0; status == HPR_OK && k < direct->emitter_count; k++)
        wanted[direct->emitter[k]] = true;
    if (status == HPR_OK)
        status = hpr_views_create(direct->visibility, wanted, &views);
    if (status == HPR_OK)
        status = hpr_views_cursor_create(views, &cursor);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &candidates, occluders, sizeof *candidates, "direct light");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &found, occluders, sizeof *found, "direct light");
    for (size_t emitter = 0; status == HPR_OK && emitter < direct->emitter_count; emitter++) {
        for (size_t patch = 0; status == HPR_OK && patch < patches; patch++)
            status = look_from_patch(direct, views, cursor, patch, emitter, candidates, found);
    }
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_release(ctx, wanted);
    hpr_release(ctx, candidates);
    hpr_release(ctx, found);
    return status;
}

static void set_emitters(hpr_direct *direct)
{
    double centre[3];
    direct->size = 2 * hpr_patches_radius(direct->patches, centre);
    for (size_t i = 0, next = 0; i < direct->patches->count; i++) {
        double corner[4][3];
        if (!emits(direct->patches, i))
            continue;
        hpr_convex *light = &direct->light[next];
        light->count = (int)hpr_patch_corners(direct->patches, i, corner);
        for (int k = 0; k < light->count; k++)
            light->corner[k] = hpr_vec3_load(corner[k]);
        direct->emitter[next++] = (uint32_t)i;
    }
}

hpr_status hpr_direct_create(const hpr_patches *patches, const hpr_elements *elements, hpr_direct **out)
{
    hpr_context *ctx = patches->context;
    hpr_direct *direct = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &direct, 1, sizeof *direct, "direct light");
    if (status != HPR_OK)
        return status;
    direct->context = ctx;
    direct->patches = patches;
    direct->elements = elements;
    direct->emitter_count = count_emitters(patches);
    status =
        hpr_allocate_into(ctx, &direct->light, direct->emitter_count, sizeof *direct->light, "direct light");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &direct->emitter, direct->emitter_count, sizeof *direct->emitter,
                                   "direct light");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &direct->sights, elements->leaf_count * direct->emitter_count,
                                   sizeof *direct->sights, "direct light");
    if (status == HPR_OK) {
        set_emitters(direct);
        status = look_everywhere(direct);
    }
    if (status != HPR_OK)
        hpr_direct_destroy(&direct);
    *out = direct;
    return status;
}

size_t hpr_direct_emitter_count(const hpr_direct *direct)
{
    return direct->emitter_count;
}

hpr_emitter hpr_direct_emitter(const hpr_direct *direct, size_t emitter)
{
    const hpr_patches *p = direct->patches;
    size_t patch = direct->emitter[emitter];
    return (hpr_emitter){.shape = (hpr_shape)p->shape[patch],
                         .origin = hpr_vec3_load(p->origin + 3 * patch),
                         .edge1 = hpr_vec3_load(p->edge1 + 3 * patch),
                         .edge2 = hpr_vec3_load(p->edge2 + 3 * patch),
                         .normal = hpr_vec3_load(p->normal + 3 * patch),
                         .area_m2 = p->area_m2[patch],
                         .opposite = {p->opposite[2 * patch], p->opposite[2 * patch + 1]},
                         .exitance = p->exitance + p->channel_count * patch};
}

hpr_sight hpr_direct_sight(const hpr_direct *direct, size_t leaf, size_t emitter)
{
    const sight *it = &direct->sights[leaf * direct->emitter_count + emitter];
    return (hpr_sight){(hpr_verdict)it->verdict, direct->blocker + it->first, it->count};
}

const hpr_visibility *hpr_direct_visibility(const hpr_direct *direct)
{
    return direct->visibility;
}

static hpr_vec3 leaf_point(const hpr_elements *e, size_t node, double s, double t)
{
    return hpr_madd(hpr_madd(hpr_vec3_load(e->origin + 3 * node), s, hpr_vec3_load(e->edge1 + 3 * node)), t,
                    hpr_vec3_load(e->edge2 + 3 * node));
}

/* A point in the plane of an emitter that the leaf sees is moved inward, so that a shared edge shows its
 * limit from inside; for all emitters alike, so that their fractions belong to one point. */
static hpr_vec3 limit_point(const hpr_direct *direct, size_t leaf, double s, double t)
{
    static const double in_plane = 1e-9, inward = 1e-6;
    const hpr_patches *patches = direct->patches;
    size_t node = direct->elements->leaf[leaf];
    hpr_vec3 x = leaf_point(direct->elements, node, s, t);
    bool touches = false;
    for (size_t k = 0; k < direct->emitter_count; k++) {
        size_t emitter = direct->emitter[k];
        double height = hpr_dot(hpr_vec3_load(patches->normal + 3 * emitter),
                                hpr_sub(x, hpr_vec3_load(patches->origin + 3 * emitter)));
        touches |= direct->sights[leaf * direct->emitter_count + k].verdict != HPR_SEES_NOTHING &&
                   fabs(height) <= in_plane * direct->size;
    }
    if (!touches)
        return x;
    double middle[2];
    hpr_shape_middle((hpr_shape)patches->shape[direct->elements->patch[node]],
                     direct->elements->opposite + 2 * node, middle);
    return leaf_point(direct->elements, node, s + inward * (middle[0] - s), t + inward * (middle[1] - t));
}

/* k: index of the emitter in direct->emitter. */
static double seen_fraction(const hpr_direct *direct, const sight *it, size_t k, hpr_vec3 x, hpr_vec3 normal)
{
    const hpr_convex *light = &direct->light[k];
    hpr_vec3 light_normal = hpr_vec3_load(direct->patches->normal + 3 * (size_t)direct->emitter[k]);
    if (hpr_dot(light_normal, hpr_sub(x, light->corner[0])) <= 0)
        return 0; /* behind the emitter */
    hpr_visible visible;
    visible.hidden = NULL;
    hpr_visible_part(x, light, light_normal, hpr_visibility_outlines(direct->visibility),
                     direct->blocker + it->first, (int)it->count, &visible);
    return hpr_visible_fraction(normal, &visible);
}

void hpr_direct_add(const hpr_direct *direct, size_t leaf, double s, double t, double *irradiance)
{
    const hpr_patches *patches = direct->patches;
    size_t node = direct->elements->leaf[leaf], patch = direct->elements->patch[node],
           n = patches->channel_count;
    hpr_vec3 normal = hpr_vec3_load(patches->normal + 3 * patch), x = limit_point(direct, leaf, s, t);
    for (size_t k = 0; k < direct->emitter_count; k++) {
        const sight *it = &direct->sights[leaf * direct->emitter_count + k];
        if (it->verdict == HPR_SEES_NOTHING)
            continue;
        size_t emitter = direct->emitter[k];
        double fraction = seen_fraction(direct, it, k, x, normal);
        for (size_t c = 0; c < n; c++)
            irradiance[c] += fraction * patches->exitance[n * emitter + c];
    }
}
