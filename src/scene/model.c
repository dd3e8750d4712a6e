#include "scene/model.h"

#include "math/twofold.h"

#include <stdio.h>
#include <string.h>

static const double plane_slack = 1e-6;   /* relative to the polygon's size */
static const double convex_slack = 1e-9;  /* sine */
static const double facing_slack = 1e-6;  /* |sine| between a surface and its base */
static const double least_height = 1e-12; /* relative to the longest side */

hpr_status hpr_model_create(hpr_context *ctx, const char *path, hpr_model **out)
{
    hpr_model *model = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &model, 1, sizeof *model, "a model");
    if (status != HPR_OK)
        return status;
    model->context = ctx;
    model->path = hpr_duplicate_text(ctx, path);
    model->title = hpr_duplicate_text(ctx, "");
    if (!model->path || !model->title) {
        hpr_model_destroy(&model);
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a model");
    }
    *out = model;
    return HPR_OK;
}

void hpr_model_destroy(hpr_model **out)
{
    hpr_model *model = *out;
    if (!model)
        return;
    hpr_context *ctx = model->context;
    for (size_t i = 0; i < model->count; i++)
        hpr_release(ctx, model->surface[i].name);
    hpr_release(ctx, model->surface);
    hpr_release(ctx, model->path);
    hpr_release(ctx, model->title);
    hpr_release(ctx, model);
    *out = NULL;
}

hpr_status hpr_model_add(hpr_model *model, const hpr_surface *surface)
{
    hpr_context *ctx = model->context;
    if (model->count + 1 >= HPR_NONE)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "%s: more surfaces than 32-bit indices can name", model->path);
    hpr_status status =
        hpr_grow(ctx, &model->surface, &model->capacity, model->count + 1, sizeof *model->surface);
    if (status != HPR_OK)
        return status;
    hpr_surface *copy = &model->surface[model->count];
    *copy = *surface;
    copy->name = hpr_duplicate_text(ctx, surface->name);
    if (!copy->name)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a model");
    model->count++;
    return HPR_OK;
}

static hpr_vec3 corner(const hpr_surface *s, size_t i)
{
    return hpr_vec3_load(s->corner[i % s->corner_count]);
}

/* Longest side or diagonal. */
static double size_of(const hpr_surface *s)
{
    double longest = 0;
    for (size_t i = 0; i < s->corner_count; i++) {
        for (size_t j = 0; j < i; j++)
            longest = fmax(longest, hpr_length(hpr_sub(corner(s, i), corner(s, j))));
    }
    return longest;
}

/* `what` with its measured value, NAN: none. */
static hpr_status refuse(const hpr_model *model, const hpr_surface *s, const char *what, double value)
{
    char number[32] = "";
    if (!isnan(value))
        snprintf(number, sizeof number, ": %.3g", value);
    return hpr_fail(model->context, HPR_ERR_FORMAT, "%s: line %zu: surface %zu '%.60s': %s%s", model->path,
                    s->line, (size_t)(s - model->surface) + 1, s->name, what, number);
}

/* Normal and area; false if there is none. */
static bool measure(hpr_surface *s, double size)
{
    hpr_vec3 d1 = hpr_sub(corner(s, 2), corner(s, 0));
    hpr_vec3 d2 = hpr_sub(corner(s, 3), corner(s, 1)); /* of a triangle: v0 - v1 */
    hpr_vec3 normal;
    double length = hpr_cross_exactly(d1, d2, &normal);
    /* Divided first: the square of a small size could vanish. */
    if (!(length / size > least_height * size))
        return false;
    s->area_m2 = length / 2;
    hpr_vec3_store(s->normal, normal);
    return true;
}

/* Without area although three corners span some: the sides cross each other. */
static bool is_crossed(const hpr_surface *s, double size)
{
    for (size_t i = 0; s->corner_count == 4 && i < 4; i++) {
        hpr_vec3 before = hpr_sub(corner(s, i + 1), corner(s, i));
        hpr_vec3 behind = hpr_sub(corner(s, i + 2), corner(s, i + 1));
        if (hpr_length(hpr_cross(before, behind)) / size > 4 * least_height * size)
            return true;
    }
    return false;
}

static hpr_status check_shape(const hpr_model *model, const hpr_surface *s, double size)
{
    hpr_vec3 normal = hpr_vec3_load(s->normal), middle = {0, 0, 0};
    size_t n = s->corner_count;
    for (size_t i = 0; i < n; i++)
        middle = hpr_madd(middle, 1.0 / (double)n, hpr_sub(corner(s, i), corner(s, 0)));
    middle = hpr_add(middle, corner(s, 0));
    for (size_t i = 0; n == 4 && i < n; i++) {
        double height = fabs(hpr_dot(normal, hpr_sub(corner(s, i), middle))) / size;
        if (height > plane_slack)
            return refuse(model, s,
                          "the four corners are not in one plane; height over it, relative to the size (at "
                          "most 1e-6)",
                          height);
        hpr_vec3 before = hpr_sub(corner(s, i), corner(s, i + n - 1));
        hpr_vec3 behind = hpr_sub(corner(s, i + 1), corner(s, i));
        double turn = hpr_dot(normal, hpr_cross(before, behind));
        if (turn < -convex_slack * hpr_length(before) * hpr_length(behind))
            return refuse(model, s, "the quadrilateral is not convex at corner", (double)(i + 1));
    }
    return HPR_OK;
}

static hpr_status check_inside(const hpr_model *model, const hpr_surface *s, const hpr_surface *base)
{
    hpr_vec3 normal = hpr_vec3_load(base->normal);
    double size = size_of(base);
    double agreement = hpr_dot(normal, hpr_vec3_load(s->normal));
    if (s->area_m2 > 0 && hpr_length(hpr_cross(normal, hpr_vec3_load(s->normal))) > facing_slack)
        return refuse(model, s, "not parallel to its base; cosine", agreement);
    if (s->kind == HPR_SURFACE_MASKS && agreement > 0)
        return refuse(model, s, "a mask must face its base, not away like it", NAN);
    if (s->kind != HPR_SURFACE_MASKS && s->kind != HPR_SURFACE_IS_ABSENT && agreement < 0)
        return refuse(model, s, "must face the same way as its base", NAN);
    for (size_t i = 0; i < s->corner_count; i++) {
        double height = fabs(hpr_dot(normal, hpr_sub(corner(s, i), corner(base, 0)))) / size;
        if (height > plane_slack)
            return refuse(model, s, "not in the plane of its base; height over it, relative to its size",
                          height);
        for (size_t k = 0; k < base->corner_count; k++) {
            hpr_vec3 edge = hpr_sub(corner(base, k + 1), corner(base, k));
            double length = hpr_length(edge);
            if (!(length > 0))
                continue;
            hpr_vec3 inward = hpr_scale(hpr_cross(normal, edge), 1 / length);
            double beyond = -hpr_dot(inward, hpr_sub(corner(s, i), corner(base, k))) / size;
            if (beyond > plane_slack)
                return refuse(model, s, "reaches out of its base, by this part of its size", beyond);
        }
    }
    return HPR_OK;
}

static hpr_status check_relations(const hpr_model *model, const hpr_surface *s)
{
    if (s->base == HPR_NONE && s->kind == HPR_SURFACE_MASKS)
        return refuse(model, s, "a mask (M) needs a base", NAN);
    if (s->base == HPR_NONE && s->kind == HPR_SURFACE_IS_ABSENT)
        return refuse(model, s, "a null surface (N) needs a base", NAN);
    if (s->combine != HPR_NONE) {
        const hpr_surface *target = &model->surface[s->combine];
        if (s->kind == HPR_SURFACE_OBSTRUCTS || s->kind == HPR_SURFACE_IS_ABSENT)
            return refuse(model, s, "has no row that could be combined with surface", (double)s->combine + 1);
        if (target->kind == HPR_SURFACE_OBSTRUCTS || target->kind == HPR_SURFACE_IS_ABSENT)
            return refuse(model, s, "is to be combined with a surface that has no row",
                          (double)s->combine + 1);
        if (target->combine != HPR_NONE)
            return refuse(model, s, "is to be combined with a surface that is itself combined",
                          (double)s->combine + 1);
    }
    if (s->base == HPR_NONE)
        return HPR_OK;
    const hpr_surface *base = &model->surface[s->base];
    if (base->kind == HPR_SURFACE_MASKS || base->kind == HPR_SURFACE_IS_ABSENT)
        return refuse(model, s, "its base is a mask or a null surface, number", (double)s->base + 1);
    if (!(base->area_m2 > 0))
        return refuse(model, s, "its base has no area, number", (double)s->base + 1);
    return check_inside(model, s, base);
}

hpr_status hpr_model_check(hpr_model *model)
{
    for (size_t i = 0; i < model->count; i++) {
        hpr_surface *s = &model->surface[i];
        double size = size_of(s);
        if (!isfinite(size * size))
            return refuse(model, s, "too large; longest side", size);
        s->area_m2 = 0;
        memset(s->normal, 0, sizeof s->normal);
        hpr_status status = HPR_OK;
        if (measure(s, size))
            status = check_shape(model, s, size);
        else if (is_crossed(s, size))
            status = refuse(model, s, "the sides of the quadrilateral cross each other", NAN);
        else
            hpr_warn(model->context, "%s: line %zu: surface %zu '%.60s' has no area; its row is zero",
                     model->path, s->line, i + 1, s->name);
        if (status == HPR_OK)
            status = check_relations(model, s);
        if (status != HPR_OK)
            return status;
    }
    return HPR_OK;
}
