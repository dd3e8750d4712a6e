/*
 * Light paths from the camera: an estimate of the radiance along one ray whose expectation is the solution of
 *   L(x) = (M(x) + rho(x) H(x)) / pi,   H(x) = ∫ G(x,y) V(x,y) B(y) dA_y + pi L_env f(x),
 * f the part of what x sees that lies outside. It shares the patches and first-hit rays with the rest of
 * hprad, and nothing else: not even occlusion rays, for occluders are merged patches.
 */
#ifndef HPR_BASELINE_TRACER_H
#define HPR_BASELINE_TRACER_H

#include "baseline/lights.h"
#include "baseline/random.h"
#include "render/camera.h"
#include "visibility/visibility.h"

/* A path that is reflected more often than this will not end; with rho = 0.9999 everywhere one in 10^43 is.
 */
enum { HPR_MAX_REFLECTIONS = 1000000 };

typedef struct hpr_tracer {
    hpr_context *context;
    const hpr_patches *patches; /* borrowed */
    hpr_visibility *visibility;
    hpr_lights lights;
    double *environment; /* [channels] radiance from outside, W/m2/sr */
    double *lit;         /* [channels] 1: light enters the scene in this channel, 0: it is black */
    bool dark;           /* all channels are black */
    double clearance_m;  /* two points nearer than this to one plane both lie in it */
} hpr_tracer;

/* environment: [channels] or NULL: black. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE. Fini accepts a zeroed or
 * half-built struct. */
hpr_status hpr_tracer_init(const hpr_patches *patches, const double *environment, hpr_tracer *tracer);
void hpr_tracer_fini(hpr_tracer *tracer);

/* What one path did. */
typedef struct hpr_path {
    bool covered;  /* the camera ray met a surface */
    bool endless;  /* HPR_MAX_REFLECTIONS were not enough; the radiance is then wrong */
    uint32_t rays; /* after the first one */
} hpr_path;

/*
 * Traces one path along a camera ray; radiance [channels], W/m2/sr. At every vertex one point of a lamp is
 * sampled and one cosine-weighted direction followed; the two are joined by the balance heuristic (Veach &
 * Guibas 1995, eq. 9), so that a lamp counts once. Russian roulette (Arvo & Kirk 1990) ends the path.
 * throughput: scratch, [2][channels]. Concurrent calls allowed with distinct random, radiance and throughput.
 */
hpr_path hpr_tracer_follow(const hpr_tracer *tracer, const hpr_camera_ray *ray, hpr_random *random,
                           double *radiance, double *throughput);

#endif
