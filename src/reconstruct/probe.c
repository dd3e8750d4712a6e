/* Irradiance and radiosity at given points. */
#include "math/vec3.h"
#include "patch/paint.h"
#include "reconstruct/reconstruct.h"
#include "solver/gather.h"

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

typedef struct probing {
    const hpr_solution *solution;
    hpr_reconstruction reconstruction;
    size_t count;
    match *found; /* [count] */
    double *irradiance, *radiosity;
} probing;

static hpr_status find_all(probing *p, const double *point, const double *normal, uint32_t *patch)
{
    const hpr_patches *patches = p->solution->patches;
    hpr_context *ctx = p->solution->context;
    double centre[3];
    double reach = 2e-6 * hpr_patches_radius(patches, centre);
    hpr_status status = hpr_allocate_into(ctx, &p->found, p->count, sizeof *p->found, "points");
    if (status != HPR_OK)
        return status;
#pragma omp parallel for schedule(dynamic, 64) num_threads(hpr_context_threads(ctx))
    for (size_t i = 0; i < p->count; i++) {
        p->found[i] = (match){.patch = HPR_NONE};
        if (!hpr_cancelled(ctx))
            p->found[i] = find_side(patches, point + 3 * i, normal + 3 * i, reach);
        patch[i] = p->found[i].patch;
    }
    return hpr_reconstruction_init(p->solution, &p->reconstruction);
}

/* H, or of it only what is evaluated at points. */
static void reconstruct_all(const probing *p, bool evaluated)
{
    size_t n = p->solution->channel_count;
#pragma omp parallel for schedule(dynamic, 64) num_threads(hpr_context_threads(p->solution->context))
    for (size_t i = 0; i < p->count; i++) {
        const match *m = &p->found[i];
        double *irradiance = p->irradiance + n * i,
               *indirect = p->radiosity + n * i; /* until that is known */
        if (m->patch == HPR_NONE)
            continue;
        hpr_reconstruct_parts(&p->reconstruction, m->patch, m->s, m->t, irradiance, indirect);
        for (size_t c = 0; c < n && evaluated; c++)
            irradiance[c] -= indirect[c];
    }
}

static const double inward = 1e-6;

static bool is_at_rim(const hpr_element_frame *frame, double s, double t)
{
    hpr_polygon outline = hpr_frame_outline(frame);
    bool at_rim = false;
    for (int k = 0; k < outline.count; k++) {
        const double *from = outline.corner[k], *to = outline.corner[(k + 1) % outline.count];
        double along[2] = {to[0] - from[0], to[1] - from[1]};
        double area = fabs(along[0] * (t - from[1]) - along[1] * (s - from[0]));
        at_rim |= area <= inward * hypot(along[0], along[1]);
    }
    return at_rim;
}

/* Where the point is on its leaf; at the rim a little toward the middle, for the limit from inside. */
static hpr_spot spot_of(const hpr_solution *solution, const match *m)
{
    const hpr_elements *e = solution->elements;
    hpr_spot spot;
    spot.leaf = hpr_elements_locate(solution->patches, e, m->patch, m->s, m->t, &spot.s, &spot.t);
    const hpr_element_frame frame = hpr_leaf_frame(solution->patches, e, spot.leaf);
    if (is_at_rim(&frame, spot.s, spot.t)) {
        double middle[2];
        hpr_shape_middle(frame.shape, frame.opposite, middle);
        spot.s += inward * (middle[0] - spot.s);
        spot.t += inward * (middle[1] - spot.t);
    }
    return spot;
}

/* The rest of H. */
static hpr_status gather_all(const probing *p)
{
    const hpr_solution *solution = p->solution;
    hpr_context *ctx = solution->context;
    size_t n = solution->channel_count, count = 0;
    hpr_spot *spot = NULL;
    double *indirect = NULL;
    hpr_status status = hpr_allocate_into(ctx, &spot, p->count, sizeof *spot, "points");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &indirect, p->count, n * sizeof *indirect, "points");
    for (size_t i = 0; status == HPR_OK && i < p->count; i++) {
        if (p->found[i].patch != HPR_NONE)
            spot[count++] = spot_of(solution, &p->found[i]);
    }
    if (status == HPR_OK)
        status = hpr_gather(solution, count, spot, indirect);
    for (size_t i = 0, k = 0; status == HPR_OK && i < p->count; i++) {
        for (size_t c = 0; c < n && p->found[i].patch != HPR_NONE; c++)
            p->irradiance[n * i + c] += indirect[k++];
    }
    hpr_release(ctx, spot);
    hpr_release(ctx, indirect);
    return status;
}

static void reflect_all(const probing *p)
{
    const hpr_patches *patches = p->solution->patches;
    size_t n = p->solution->channel_count;
    for (size_t i = 0; i < p->count; i++) {
        const match *m = &p->found[i];
        double *irradiance = p->irradiance + n * i, *radiosity = p->radiosity + n * i;
        if (m->patch != HPR_NONE) /* rho, until it is used */
            hpr_patch_reflectance(patches, m->patch, m->s, m->t, radiosity);
        for (size_t c = 0; c < n; c++) {
            if (m->patch == HPR_NONE)
                irradiance[c] = radiosity[c] = NAN;
            else
                radiosity[c] =
                    hpr_patch_exitance(patches, m->patch, m->s, m->t, c) + radiosity[c] * irradiance[c];
        }
    }
}

static hpr_status probe(hpr_context *context, probing *p, bool gather, const double *point,
                        const double *normal, uint32_t *patch)
{
    hpr_context_clear_error(context);
    hpr_stage_begin(context, "probe");
    hpr_status status = find_all(p, point, normal, patch);
    if (status == HPR_OK)
        reconstruct_all(p, gather);
    hpr_stage_end(context);
    if (status == HPR_OK && gather)
        status = gather_all(p);
    if (status == HPR_OK && hpr_cancelled(context))
        status = hpr_fail(context, HPR_ERR_INTERRUPTED, "interrupted while probing");
    if (status == HPR_OK)
        reflect_all(p);
    hpr_reconstruction_fini(&p->reconstruction);
    hpr_release(p->solution->context, p->found);
    return status;
}

hpr_status hpr_solution_probe(hpr_context *context, const hpr_solution *solution, size_t count,
                              const double *point, const double *normal, double *irradiance,
                              double *radiosity, uint32_t *patch)
{
    probing p = {.solution = solution, .count = count, .irradiance = irradiance, .radiosity = radiosity};
    return probe(context, &p, false, point, normal, patch);
}

hpr_status hpr_solution_gather(hpr_context *context, const hpr_solution *solution, size_t count,
                               const double *point, const double *normal, double *irradiance,
                               double *radiosity, uint32_t *patch)
{
    probing p = {.solution = solution, .count = count, .irradiance = irradiance, .radiosity = radiosity};
    return probe(context, &p, true, point, normal, patch);
}
