/* Irradiance and radiosity at given points. */
#include "math/vec3.h"
#include "patch/paint.h"
#include "reconstruct/reconstruct.h"

static double outside(double x, double low, double high)
{
    return x < low ? low - x : x > high ? x - high : 0;
}

/* Distance of a point to a patch, and the parameters of the nearest point found (exact near the patch). */
static double patch_distance(const hpr_patches *patches, size_t patch, const double point[3], double *s,
                             double *t)
{
    hpr_patch_parameters(patches, patch, point, s, t);
    if (patches->shape[patch] == HPR_SHAPE_PARALLELOGRAM) {
        *s -= outside(*s, 0, 1) * (*s < 0 ? -1 : 1);
        *t -= outside(*t, 0, 1) * (*t < 0 ? -1 : 1);
    } else if (patches->shape[patch] == HPR_SHAPE_QUADRILATERAL) {
        hpr_quad_bring_inside(patches->opposite + 2 * patch, s, t);
    } else {
        *s = *s < 0 ? 0 : *s;
        *t = *t < 0 ? 0 : *t;
        double over = *s + *t - 1;
        if (over > 0) {
            *s = fmin(fmax(*s - over / 2, 0), 1);
            *t = 1 - *s;
        }
    }
    hpr_vec3 nearest = hpr_madd(
        hpr_madd(hpr_vec3_load(patches->origin + 3 * patch), *s, hpr_vec3_load(patches->edge1 + 3 * patch)),
        *t, hpr_vec3_load(patches->edge2 + 3 * patch));
    return hpr_length(hpr_sub(hpr_vec3_load(point), nearest));
}

typedef struct match {
    uint32_t patch;
    double s, t;
} match;

/* The side within `reach` whose normal agrees best, ties to the lowest index. */
static match find_side(const hpr_patches *patches, const double point[3], const double normal[3],
                       double reach)
{
    /* Normals that agree to rounding are a tie. */
    static const double tie = 1e-9;
    match best = {.patch = HPR_NONE};
    double agreement = 0;
    for (size_t i = 0; i < patches->count; i++) {
        double own = hpr_dot3(normal, patches->normal + 3 * i), s, t;
        if (!(own > agreement + tie * hpr_length3(normal)))
            continue;
        if (patch_distance(patches, i, point, &s, &t) <= reach) {
            best = (match){(uint32_t)i, s, t};
            agreement = own;
        }
    }
    return best;
}

hpr_status hpr_solution_probe(hpr_context *context, const hpr_solution *solution, size_t count,
                              const double *point, const double *normal, double *irradiance,
                              double *radiosity, uint32_t *patch)
{
    const hpr_patches *patches = solution->patches;
    size_t n = solution->channel_count;
    double centre[3];
    double reach = 2e-6 * hpr_patches_radius(patches, centre);
    hpr_reconstruction reconstruction;
    hpr_context_clear_error(context);
    hpr_stage_begin(context, "probe");
    hpr_status status = hpr_reconstruction_init(solution, &reconstruction);
    if (status != HPR_OK)
        count = 0;
#pragma omp parallel for schedule(dynamic, 64) num_threads(hpr_context_threads(context))
    for (size_t i = 0; i < count; i++) {
        match found = {.patch = HPR_NONE};
        if (!hpr_cancelled(context))
            found = find_side(patches, point + 3 * i, normal + 3 * i, reach);
        patch[i] = found.patch;
        if (found.patch != HPR_NONE)
            hpr_reconstruct_point(&reconstruction, found.patch, found.s, found.t, irradiance + n * i);
        if (found.patch != HPR_NONE) /* rho, until it is used */
            hpr_patch_reflectance(patches, found.patch, found.s, found.t, radiosity + n * i);
        for (size_t c = 0; c < n; c++) {
            if (found.patch == HPR_NONE)
                irradiance[n * i + c] = radiosity[n * i + c] = NAN;
            else
                radiosity[n * i + c] = hpr_patch_exitance(patches, found.patch, found.s, found.t, c) +
                                       radiosity[n * i + c] * irradiance[n * i + c];
        }
    }
    hpr_reconstruction_fini(&reconstruction);
    hpr_stage_end(context);
    if (status == HPR_OK && hpr_cancelled(context))
        status = hpr_fail(context, HPR_ERR_INTERRUPTED, "interrupted while probing");
    return status;
}
