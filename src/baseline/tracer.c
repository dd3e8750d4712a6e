#include "baseline/tracer.h"

#include "math/vec3.h"
#include "patch/paint.h"

#include <float.h>
#include <string.h>

/* Before this many reflections no path is ended by chance: early vertices carry most of the light. (In a
 * closed room of rho 0.5, 3 give five times the accuracy of 1 for the same time, in the Cornell box three
 * quarters.) */
enum { ROULETTE_FROM = 3 };

static const double pi = 3.14159265358979323846;

static void set_light(hpr_tracer *tracer, const double *environment)
{
    const hpr_patches *patches = tracer->patches;
    size_t n = patches->channel_count;
    tracer->dark = true;
    for (size_t c = 0; c < n; c++) {
        tracer->environment[c] = environment ? environment[c] : 0;
        bool lit = tracer->environment[c] > 0;
        for (size_t i = 0; !lit && i < patches->count; i++)
            lit = patches->exitance[n * i + c] > 0;
        tracer->lit[c] = lit;
        tracer->dark = tracer->dark && !lit;
    }
}

/* As fine as visibility judges: 1e-12 of the scene, and what coordinates of that size resolve; with a margin.
 */
static double clearance_of(const hpr_patches *patches)
{
    double centre[3], largest = 0, radius = hpr_patches_radius(patches, centre);
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fabs(centre[k]) + radius);
    return 4e-12 * radius + 32 * DBL_EPSILON * largest;
}

hpr_status hpr_tracer_init(const hpr_patches *patches, const double *environment, hpr_tracer *tracer)
{
    hpr_context *ctx = patches->context;
    size_t n = patches->channel_count;
    *tracer = (hpr_tracer){.context = ctx, .patches = patches, .clearance_m = clearance_of(patches)};
    hpr_status status = hpr_allocate_into(ctx, &tracer->environment, n, sizeof(double), "path tracing");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &tracer->lit, n, sizeof(double), "path tracing");
    if (status == HPR_OK)
        status = hpr_lights_init(patches, &tracer->lights);
    if (status == HPR_OK)
        status = hpr_visibility_create(patches, &tracer->visibility);
    if (status != HPR_OK)
        return status;
    set_light(tracer, environment);
    return HPR_OK;
}

void hpr_tracer_fini(hpr_tracer *tracer)
{
    if (!tracer->context)
        return;
    hpr_visibility_destroy(&tracer->visibility);
    hpr_lights_fini(&tracer->lights);
    hpr_release(tracer->context, tracer->environment);
    hpr_release(tracer->context, tracer->lit);
    *tracer = (hpr_tracer){0};
}

/* A path on its way. */
typedef struct walk {
    const hpr_tracer *tracer;
    hpr_random *random;
    uint32_t patch; /* where it is */
    double point[3];
    double *throughput;  /* [channels] radiosity here to what the camera sees, 1/pi left out */
    double *sum;         /* [channels] W/m2 */
    double *reflectance; /* [channels] where it is */
    uint32_t rays;
} walk;

static const double *normal_of(const walk *w)
{
    return w->tracer->patches->normal + 3 * (size_t)w->patch;
}

static double strongest(const walk *w)
{
    double value = 0;
    for (size_t c = 0; c < w->tracer->patches->channel_count; c++)
        value = fmax(value, w->throughput[c]);
    return value;
}

/* The point of a hit, made from its parameters, so that it is in the plane to the last digits; a hit is
 * within rounding of the patch and is brought inside. */
static void point_of(const hpr_patches *patches, const hpr_hit *hit, double point[3])
{
    double s = fmin(fmax(hit->s, 0), 1), t = fmin(fmax(hit->t, 0), 1);
    if (patches->shape[hit->patch] == HPR_SHAPE_QUADRILATERAL) {
        s = hit->s;
        t = hit->t;
        hpr_quad_bring_inside(patches->opposite + 2 * (size_t)hit->patch, &s, &t);
    }
    if (patches->shape[hit->patch] == HPR_SHAPE_TRIANGLE && s + t > 1) {
        double excess = s + t;
        s /= excess;
        t /= excess;
    }
    for (int k = 0; k < 3; k++) {
        size_t i = 3 * (size_t)hit->patch + (size_t)k;
        point[k] = patches->origin[i] + s * patches->edge1[i] + t * patches->edge2[i];
    }
}

/*
 * What an estimate that has found point y of a lamp adds, in units of M: lamp sampling finds it with the
 * density p per area, a cosine-weighted direction with g = G(x,y), which is also the kernel of the integrand;
 * by the balance heuristic both add g / (p + g). Written so that it has a limit where x and y meet. 0 if the
 * two do not face each other.
 */
static double share_of(const walk *w, uint32_t lamp, const double y[3])
{
    double across[3];
    hpr_subtract3(y, w->point, across);
    double square = hpr_dot3(across, across), from = hpr_dot3(normal_of(w), across);
    double to = -hpr_dot3(w->tracer->patches->normal + 3 * (size_t)lamp, across);
    if (!(from > 0 && to > 0))
        return 0;
    return 1 / (1 + w->tracer->lights.density[lamp] * pi * square * square / (from * to));
}

/* y: the point of the lamp */
static void add_lamp(walk *w, uint32_t lamp, const double y[3], double share)
{
    const hpr_patches *patches = w->tracer->patches;
    double s = 0, t = 0;
    if (hpr_patch_glow(patches, lamp))
        hpr_patch_parameters(patches, lamp, y, &s, &t);
    for (size_t c = 0; c < patches->channel_count; c++)
        w->sum[c] += w->throughput[c] * share * hpr_patch_exitance(patches, lamp, s, t, c);
}

/* What is met first from where the path is; `far` times the direction's length, which is 1, ends the search.
 * The plane that it starts from is met at a distance of rounding over the cosine. */
static hpr_hit look(walk *w, const double direction[3], double far, bool *back)
{
    double cosine = hpr_dot3(normal_of(w), direction);
    w->rays++;
    return hpr_visibility_first_hit(w->tracer->visibility, w->point, direction,
                                    w->tracer->clearance_m / cosine, far, false, back);
}

/* Is the lamp what is met in the direction of its point y? Asked with the same ray by which a random
 * direction would find it, so that the two estimates agree on what is seen. */
static bool sees(walk *w, uint32_t lamp, const double y[3])
{
    double direction[3];
    hpr_subtract3(y, w->point, direction);
    double distance = hpr_length3(direction);
    for (int k = 0; k < 3; k++)
        direction[k] /= distance;
    return look(w, direction, 1.001 * distance, NULL).patch == lamp;
}

static void sample_lamp(walk *w)
{
    const hpr_tracer *tracer = w->tracer;
    double y[3];
    if (tracer->lights.count == 0)
        return;
    double u = hpr_random_unit(w->random), s = hpr_random_unit(w->random), t = hpr_random_unit(w->random);
    uint32_t lamp = hpr_lights_choose(&tracer->lights, w->point, u, s, t, y);
    double share = lamp == w->patch ? 0 : share_of(w, lamp, y);
    if (!(share > 0))
        return;
    if (sees(w, lamp, y))
        add_lamp(w, lamp, y, share);
}

/* A direction from the patch with the density cos / pi (Malley). */
static void choose_direction(walk *w, double direction[3])
{
    const hpr_patches *patches = w->tracer->patches;
    const double *normal = normal_of(w), *edge = patches->edge1 + 3 * (size_t)w->patch;
    double u = hpr_random_unit(w->random), angle = 2 * pi * hpr_random_unit(w->random);
    double side[3], cosine = sqrt(1 - u), along = sqrt(u) * cos(angle) / hpr_length3(edge),
                    aside = sqrt(u) * sin(angle) / hpr_length3(edge);
    hpr_cross3(normal, edge, side);
    for (int k = 0; k < 3; k++)
        direction[k] = cosine * normal[k] + along * edge[k] + aside * side[k];
}

/* Goes on to what is seen in a random direction and adds its light. False: the path ends there, outside or on
 * a black back. */
static bool go_on(walk *w)
{
    const hpr_tracer *tracer = w->tracer;
    size_t n = tracer->patches->channel_count;
    double direction[3], y[3];
    bool back = false;
    choose_direction(w, direction);
    hpr_hit hit = look(w, direction, INFINITY, &back);
    if (hit.patch == HPR_NONE) {
        for (size_t c = 0; c < n; c++)
            w->sum[c] += w->throughput[c] * pi * tracer->environment[c];
        return false;
    }
    if (back)
        return false;
    point_of(tracer->patches, &hit, y);
    if (tracer->lights.density[hit.patch] > 0)
        add_lamp(w, hit.patch, y, share_of(w, hit.patch, y));
    w->patch = hit.patch;
    memcpy(w->point, y, sizeof y);
    return true;
}

/*
 * Reflects at the patch that was reached; false if chance ends the path, or no light is left. The path goes
 * on with the chance by which its strongest channel is reflected, so that later vertices weigh no more than
 * earlier ones.
 */
static bool reflect(walk *w, int reflections)
{
    const hpr_patches *patches = w->tracer->patches;
    size_t n = patches->channel_count;
    double before = strongest(w), s = 0, t = 0;
    if (hpr_patch_texture(patches, w->patch))
        hpr_patch_parameters(patches, w->patch, w->point, &s, &t);
    hpr_patch_reflectance(patches, w->patch, s, t, w->reflectance);
    for (size_t c = 0; c < n; c++)
        w->throughput[c] *= w->reflectance[c];
    double chance = strongest(w) / before;
    if (reflections < ROULETTE_FROM || chance >= 1)
        return chance > 0;
    if (!(hpr_random_unit(w->random) < chance))
        return false;
    for (size_t c = 0; c < n; c++)
        w->throughput[c] /= chance;
    return true;
}

hpr_path hpr_tracer_follow(const hpr_tracer *tracer, const hpr_camera_ray *ray, hpr_random *random,
                           double *radiance, double *throughput)
{
    const hpr_patches *patches = tracer->patches;
    size_t n = patches->channel_count;
    hpr_path path = {0};
    hpr_hit hit = hpr_visibility_first_hit(tracer->visibility, ray->origin, ray->direction, ray->near,
                                           ray->far, true, NULL);
    path.covered = hit.patch != HPR_NONE;
    for (size_t c = 0; c < n; c++)
        radiance[c] = path.covered ? hpr_patch_exitance(patches, hit.patch, hit.s, hit.t, c)
                                   : pi * tracer->environment[c];
    if (path.covered && !tracer->dark) {
        walk w = {.tracer = tracer,
                  .random = random,
                  .patch = hit.patch,
                  .throughput = throughput,
                  .reflectance = throughput + n,
                  .sum = radiance};
        for (size_t c = 0; c < n; c++)
            throughput[c] = tracer->lit[c];
        point_of(patches, &hit, w.point);
        for (int reflections = 0; reflect(&w, reflections); reflections++) {
            if (reflections == HPR_MAX_REFLECTIONS) {
                path.endless = true;
                break;
            }
            sample_lamp(&w);
            if (!go_on(&w))
                break;
        }
        path.rays = w.rays;
    }
    for (size_t c = 0; c < n; c++)
        radiance[c] /= pi;
    return path;
}
