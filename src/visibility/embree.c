/*
 * The only file that knows Embree (3.13 or 4). Faces of patches (for first hits) and occluders (for
 * occlusion) are user geometry: Embree walks its tree of boxes in float32 and calls back with everything
 * whose box the ray may touch; the predicates in double decide. (Its
 * own triangles and quads would not do: a float32 ray that starts 1e-8 in front of a wall starts behind it.)
 * A float32 ray strays from the true one by less than 4e-7 (|x'| <= 1, length <= 2: rounding of origin and
 * direction, 6e-8 and 2 x 6e-8 per axis); boxes are padded by `padding`, so nothing is missed.
 */
#include "visibility/faces.h"

#include <hprad/version.h>
#include <stdio.h>
#include <string.h>

#if HPR_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext query_base;
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext query_base;
#endif

const char *hpr_embree_version(void)
{
    return RTC_VERSION_STRING;
}

static const float padding = 1e-6f;

struct hpr_rays {
    const hpr_visibility *visibility;
    RTCDevice device;
    RTCScene faces, occluders;
};

/* Embree hands the context through to the callbacks, which find the query behind it. */
typedef struct occlusion_query {
    query_base base; /* first, so that the pointers agree */
    const hpr_visibility *visibility;
    const double *x, *y;
    const uint32_t *listed;
    size_t listed_count;
} occlusion_query;

/* What is met as near as the nearest, but for the rounding of its own distance. */
typedef struct candidate {
    hpr_hit hit;
    double slack; /* of the distance */
    bool back, single;
} candidate;

enum { MAX_TIED = 8 };

typedef struct first_query {
    query_base base;
    const hpr_visibility *visibility;
    const hpr_ray *ray;
    double nearest;
    int count;
    candidate tied[MAX_TIED];
} first_query;

static bool is_listed(const uint32_t *listed, size_t count, uint32_t occluder)
{
    while (count > 0) {
        size_t half = count / 2;
        if (listed[half] == occluder)
            return true;
        if (listed[half] < occluder) {
            listed += half + 1;
            count -= half + 1;
        } else {
            count = half;
        }
    }
    return false;
}

static void set_bounds(const double low[3], const double high[3], struct RTCBounds *box)
{
    box->lower_x = (float)low[0] - padding;
    box->lower_y = (float)low[1] - padding;
    box->lower_z = (float)low[2] - padding;
    box->upper_x = (float)high[0] + padding;
    box->upper_y = (float)high[1] + padding;
    box->upper_z = (float)high[2] + padding;
}

static void bounds_of_face(const struct RTCBoundsFunctionArguments *args)
{
    const hpr_visibility *visibility = args->geometryUserPtr;
    const hpr_face *face = &visibility->face[visibility->front[args->primID]];
    set_bounds(face->low, face->high, args->bounds_o);
}

static void bounds_of_occluder(const struct RTCBoundsFunctionArguments *args)
{
    const hpr_visibility *visibility = args->geometryUserPtr;
    const hpr_occluder *occluder = &visibility->occluder[args->primID];
    set_bounds(occluder->low, occluder->high, args->bounds_o);
}

static void occlusion_of_occluder(const struct RTCOccludedFunctionNArguments *args)
{
    const occlusion_query *query = (const occlusion_query *)args->context;
    const hpr_visibility *visibility = query->visibility;
    if (args->valid[0] &&
        hpr_occluder_blocks(visibility, &visibility->occluder[args->primID], query->x, query->y) &&
        is_listed(query->listed, query->listed_count, args->primID))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

/* Of patches in one plane a front comes before a back, so that a wall of two faces shows the one that faces
 * the ray; then a sheet before what it covers; then the lowest number. */
static bool comes_before(const candidate *a, const candidate *b)
{
    if (a->back != b->back)
        return b->back;
    return a->single != b->single ? b->single : a->hit.patch < b->hit.patch;
}

/* Whatever order the tree shows them in, those remain that are tied with the nearest of all. */
static void add_candidate(first_query *query, const candidate *it)
{
    if (it->hit.distance > query->nearest + it->slack)
        return;
    query->nearest = fmin(query->nearest, it->hit.distance);
    int kept = 0, last = 0;
    for (int i = 0; i < query->count; i++) {
        const candidate *tied = &query->tied[i];
        if (tied->hit.distance <= query->nearest + tied->slack)
            query->tied[kept++] = *tied;
    }
    query->count = kept;
    if (query->count < MAX_TIED) {
        query->tied[query->count++] = *it;
        return;
    }
    for (int i = 1; i < MAX_TIED; i++)
        last = comes_before(&query->tied[last], &query->tied[i]) ? i : last;
    if (comes_before(it, &query->tied[last]))
        query->tied[last] = *it;
}

static void hit_of_face(const struct RTCIntersectFunctionNArguments *args)
{
    first_query *query = (first_query *)args->context;
    const hpr_ray *ray = query->ray;
    const hpr_face *face = &query->visibility->face[query->visibility->front[args->primID]];
    candidate it = {.single = face->single};
    hpr_hit *hit = &it.hit;
    if (!args->valid[0] || !hpr_face_hit(query->visibility, face, ray->base, ray->direction, &hit->distance,
                                         &hit->s, &hit->t, &it.back))
        return;
    float reached = (float)hit->distance;
    hit->distance += ray->offset;
    if (!(hit->distance > ray->near && hit->distance < ray->far) || (ray->cull && it.back && face->single))
        return;
    hit->patch = face->patch;
    if (it.back && !face->single) {
        /* The twin has the edges exchanged. */
        double s = hit->s;
        hit->patch = query->visibility->patches->twin[face->patch];
        hit->s = hit->t;
        hit->t = s;
        it.back = false;
    }
    it.slack = hpr_face_growth(query->visibility, fabs(hpr_dot3(face->normal, ray->direction)));
    add_candidate(query, &it);
    /* Whatever is as near must still be shown, so the ray ends a little behind the hit. */
    struct RTCRay *embree_ray = (struct RTCRay *)args->rayhit;
    embree_ray->tfar = fminf(embree_ray->tfar, reached + padding);
}

static hpr_status device_failure(hpr_context *ctx, RTCDevice device, const char *doing)
{
    enum RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: Embree, %s", doing);
    return hpr_fail(ctx, HPR_ERR_DEVICE, "Embree refused %s (error %d)", doing, (int)error);
}

/* A tree over `count` boxes. Either of hit and occlusion may be NULL. */
static RTCScene build_tree(const hpr_rays *rays, size_t count, RTCBoundsFunction bounds,
                           RTCIntersectFunctionN hit, RTCOccludedFunctionN occlusion)
{
    RTCScene scene = rtcNewScene(rays->device);
    RTCGeometry geometry = rtcNewGeometry(rays->device, RTC_GEOMETRY_TYPE_USER);
    if (scene && geometry) {
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)count);
        rtcSetGeometryUserData(geometry, (void *)rays->visibility);
        rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
        if (hit)
            rtcSetGeometryIntersectFunction(geometry, hit);
        if (occlusion)
            rtcSetGeometryOccludedFunction(geometry, occlusion);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcCommitScene(scene);
    }
    if (geometry)
        rtcReleaseGeometry(geometry);
    return scene;
}

static hpr_status build_trees(hpr_rays *rays)
{
    hpr_context *ctx = rays->visibility->context;
    size_t faces = rays->visibility->front_count, occluders = rays->visibility->occluder_count;
    char settings[64];
    snprintf(settings, sizeof settings, "threads=1,max_isa=%s", hpr_context_isa(ctx));
    rays->device = rtcNewDevice(settings);
    if (!rays->device)
        return device_failure(ctx, NULL, "to start");
    rays->faces = build_tree(rays, faces, bounds_of_face, hit_of_face, NULL);
    if (rays->faces)
        rays->occluders = build_tree(rays, occluders, bounds_of_occluder, NULL, occlusion_of_occluder);
    if (!rays->faces || !rays->occluders)
        return device_failure(ctx, rays->device, "a scene");
    enum RTCError error = rtcGetDeviceError(rays->device);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: Embree's trees of %zu faces, %zu occluders",
                        faces, occluders);
    if (error != RTC_ERROR_NONE)
        return hpr_fail(ctx, HPR_ERR_DEVICE,
                        "Embree refused the trees of %zu faces, %zu occluders (error %d)", faces, occluders,
                        (int)error);
    return HPR_OK;
}

hpr_status hpr_rays_create(const hpr_visibility *visibility, hpr_rays **out)
{
    *out = NULL;
    hpr_rays *rays = NULL;
    hpr_status status = hpr_allocate_into(visibility->context, &rays, 1, sizeof *rays, "rays");
    if (status != HPR_OK)
        return status;
    rays->visibility = visibility;
    status = build_trees(rays);
    if (status != HPR_OK)
        hpr_rays_destroy(&rays);
    *out = rays;
    return status;
}

void hpr_rays_destroy(hpr_rays **out)
{
    hpr_rays *rays = *out;
    if (!rays)
        return;
    if (rays->faces)
        rtcReleaseScene(rays->faces);
    if (rays->occluders)
        rtcReleaseScene(rays->occluders);
    if (rays->device)
        rtcReleaseDevice(rays->device);
    hpr_release(rays->visibility->context, rays);
    *out = NULL;
}

static void set_ray(struct RTCRay *ray, const double origin[3], const double direction[3], double length)
{
    *ray = (struct RTCRay){.org_x = (float)origin[0],
                           .org_y = (float)origin[1],
                           .org_z = (float)origin[2],
                           .dir_x = (float)direction[0],
                           .dir_y = (float)direction[1],
                           .dir_z = (float)direction[2],
                           .tfar = (float)length,
                           .mask = UINT32_MAX};
}

/* The one difference between the two versions: where the context goes. */
static void trace_occlusion(RTCScene scene, query_base *base, struct RTCRay *ray)
{
#if HPR_EMBREE_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitRayQueryContext(base);
    rtcInitOccludedArguments(&arguments);
    arguments.context = base;
    rtcOccluded1(scene, ray, &arguments);
#else
    rtcInitIntersectContext(base);
    rtcOccluded1(scene, base, ray);
#endif
}

static void trace_first(RTCScene scene, query_base *base, struct RTCRayHit *ray)
{
#if HPR_EMBREE_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(base);
    rtcInitIntersectArguments(&arguments);
    arguments.context = base;
    rtcIntersect1(scene, ray, &arguments);
#else
    rtcInitIntersectContext(base);
    rtcIntersect1(scene, base, ray);
#endif
}

bool hpr_rays_blocked(const hpr_rays *rays, const double x[3], const double y[3], const double start[3],
                      const double stop[3], const uint32_t *listed, size_t listed_count)
{
    occlusion_query query = {
        .visibility = rays->visibility, .x = x, .y = y, .listed = listed, .listed_count = listed_count};
    double step[3];
    struct RTCRay ray;
    hpr_subtract3(stop, start, step);
    set_ray(&ray, start, step, 1);
    trace_occlusion(rays->occluders, &query.base, &ray);
    return ray.tfar < 0;
}

hpr_hit hpr_rays_first(const hpr_rays *rays, const hpr_ray *ray, bool *back)
{
    first_query query;
    query.visibility = rays->visibility;
    query.ray = ray;
    query.nearest = INFINITY;
    query.count = 0;
    struct RTCRayHit embree_ray = {
        .hit = {.primID = RTC_INVALID_GEOMETRY_ID, .geomID = RTC_INVALID_GEOMETRY_ID}};
    set_ray(&embree_ray.ray, ray->base, ray->direction, ray->length + (double)padding);
    trace_first(rays->faces, &query.base, &embree_ray);
    const candidate none = {.hit = {.patch = HPR_NONE, .distance = INFINITY}}, *first = &none;
    for (int i = 0; i < query.count; i++) {
        if (i == 0 || comes_before(&query.tied[i], first))
            first = &query.tied[i];
    }
    *back = first->back;
    return first->hit;
}
