#include "reconstruct/reconstruct.h"

#include "basis/basis.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

hpr_status hpr_reconstruction_init(const hpr_solution *solution, hpr_reconstruction *reconstruction)
{
    *reconstruction = (hpr_reconstruction){.solution = solution};
    hpr_status status = hpr_coverage_create(solution->patches, solution->elements, &reconstruction->coverage);
    if (status == HPR_OK && solution->summary.direct == HPR_DIRECT_EXACT)
        status = hpr_direct_create(solution->patches, solution->elements, &reconstruction->direct);
    if (status == HPR_OK && solution->summary.environment == HPR_ENVIRONMENT_EXACT)
        status = hpr_environment_create(solution->patches, solution->elements, &reconstruction->environment);
    if (status == HPR_OK && reconstruction->environment &&
        !hpr_environment_affordable(reconstruction->environment))
        status =
            hpr_fail(solution->context, HPR_ERR_UNSUPPORTED,
                     "%s: more stands before the light from outside than this version evaluates at points",
                     solution->scene_name);
    return status;
}

void hpr_reconstruction_fini(hpr_reconstruction *reconstruction)
{
    hpr_direct_destroy(&reconstruction->direct);
    hpr_coverage_destroy(&reconstruction->coverage);
    hpr_environment_destroy(&reconstruction->environment);
}

/* V at a point of a leaf, which is moved where surfaces touch, so that lamps are evaluated at the very same
 * point. */
static double find_opening(const hpr_reconstruction *reconstruction, size_t leaf, double *s, double *t)
{
    const hpr_elements *e = reconstruction->solution->elements;
    size_t node = e->leaf[leaf];
    hpr_environment_limit(reconstruction->environment, leaf, s, t);
    hpr_vec3 x = hpr_madd(hpr_vec3_load(e->origin + 3 * node), *s, hpr_vec3_load(e->edge1 + 3 * node));
    x = hpr_madd(x, *t, hpr_vec3_load(e->edge2 + 3 * node));
    return hpr_environment_opening(reconstruction->environment, e->patch[node], x).part;
}

bool hpr_reconstruct_parted(const hpr_reconstruction *reconstruction)
{
    return reconstruction->direct && (reconstruction->environment ||
                                      reconstruction->solution->summary.environment == HPR_ENVIRONMENT_NONE);
}

void hpr_reconstruct_point(const hpr_reconstruction *reconstruction, size_t patch, double s, double t,
                           double *irradiance)
{
    hpr_reconstruct_parts(reconstruction, patch, s, t, irradiance, NULL);
}

void hpr_reconstruct_parts(const hpr_reconstruction *reconstruction, size_t patch, double s, double t,
                           double *irradiance, double *indirect)
{
    const hpr_solution *solution = reconstruction->solution;
    const hpr_elements *elements = solution->elements;
    size_t n = solution->channel_count;
    double leaf_s, leaf_t, basis[HPR_MAX_BASIS];
    size_t leaf = hpr_elements_locate(solution->patches, elements, patch, s, t, &leaf_s, &leaf_t);
    const hpr_element_frame frame = hpr_leaf_frame(solution->patches, elements, leaf);
    size_t count = hpr_basis_count(frame.shape, frame.degree);
    double scale = hpr_frame_scale(&frame);
    hpr_frame_basis(&frame, leaf_s, leaf_t, basis);
    for (size_t c = 0; c < n; c++)
        irradiance[c] = 0;
    for (size_t c = 0; c < n && indirect; c++)
        indirect[c] = 0;
    if (!hpr_coverage_open(reconstruction->coverage, leaf, leaf_s, leaf_t))
        return;
    for (size_t k = 0; k < count; k++) {
        const double *coefficient = solution->irradiance + n * (elements->dof[leaf] + k);
        for (size_t c = 0; c < n; c++)
            irradiance[c] += scale * basis[k] * coefficient[c];
    }
    double open = 0;
    if (reconstruction->environment)
        open = find_opening(reconstruction, leaf, &leaf_s, &leaf_t);
    for (size_t c = 0; c < n; c++) {
        if (reconstruction->environment)
            irradiance[c] -= solution->surroundings[n * patch + c] * open;
        /* No light is negative: where the polynomial dips below 0, 0 is nearer to the truth. */
        if (reconstruction->direct)
            irradiance[c] = fmax(irradiance[c], 0);
        if (indirect)
            indirect[c] = irradiance[c];
        if (reconstruction->environment)
            irradiance[c] += pi * solution->environment[c] * open;
    }
    if (reconstruction->direct)
        hpr_direct_add(reconstruction->direct, leaf, leaf_s, leaf_t, irradiance);
}
