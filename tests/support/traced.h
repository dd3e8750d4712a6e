/* Pictures of rooms by path tracing: cameras, a run, and the mean over a picture with its standard error.
 * After rooms.h. */
#ifndef HPR_TESTS_TRACED_H
#define HPR_TESTS_TRACED_H

#include "rooms.h"

#include <hprad/reference.h>
#include <math.h>

/* Parallel rays along -z from height z; the picture shows x -+ half, y -+ half. */
static inline void traced_look_down(hpr_room *room, double x, double y, double z, double half)
{
    const hpr_camera camera = {.name = "down",
                               .kind = HPR_CAMERA_ORTHOGRAPHIC,
                               .origin = {x, y, z},
                               .right = {1, 0, 0},
                               .up = {0, 1, 0},
                               .backward = {0, 0, 1},
                               .xmag = half,
                               .ymag = half,
                               .zfar = INFINITY};
    assert_int_equal(hpr_scene_add_camera(room->scene, &camera), HPR_OK);
}

/* The same along +z. */
static inline void traced_look_up(hpr_room *room, double x, double y, double z, double half)
{
    const hpr_camera camera = {.name = "up",
                               .kind = HPR_CAMERA_ORTHOGRAPHIC,
                               .origin = {x, y, z},
                               .right = {-1, 0, 0},
                               .up = {0, 1, 0},
                               .backward = {0, 0, -1},
                               .xmag = half,
                               .ymag = half,
                               .zfar = INFINITY};
    assert_int_equal(hpr_scene_add_camera(room->scene, &camera), HPR_OK);
}

/* From a point in all of a box: 90 degrees along +x. */
static inline void traced_look_along_x(hpr_room *room, double x, double y, double z)
{
    const hpr_camera camera = {.name = "along",
                               .kind = HPR_CAMERA_PERSPECTIVE,
                               .origin = {x, y, z},
                               .right = {0, -1, 0},
                               .up = {0, 0, 1},
                               .backward = {-1, 0, 0},
                               .yfov_rad = 1.5707963267948966,
                               .znear = 1e-3,
                               .zfar = INFINITY};
    assert_int_equal(hpr_scene_add_camera(room->scene, &camera), HPR_OK);
}

typedef struct traced_setting {
    int side, samples; /* pixels per side, paths per pixel */
    uint64_t seed;
    double environment; /* of all channels */
} traced_setting;

static inline hpr_status traced_try(hpr_room *room, size_t camera, traced_setting set, hpr_image *image)
{
    const hpr_reference_options options = {
        .seed = set.seed, .environment_count = 1, .environment = &set.environment};
    const hpr_render_options film = {set.side, set.side, set.samples};
    hpr_reference *reference = NULL;
    *image = (hpr_image){0};
    hpr_status status = hpr_reference_create(room->context, room->scene, &options, &reference);
    if (status == HPR_OK)
        status = hpr_reference_render(room->context, reference, camera, &film, image);
    hpr_reference_destroy(&reference);
    return status;
}

static inline hpr_image traced(hpr_room *room, size_t camera, traced_setting set)
{
    hpr_image image;
    hpr_status status = traced_try(room, camera, set, &image);
    if (status != HPR_OK)
        print_error("path tracing: %s\n", hpr_context_error(room->context));
    assert_int_equal(status, HPR_OK);
    return image;
}

/* Mean of the first channel over all pixels, its standard error by the variance layer. */
typedef struct traced_estimate {
    double mean, error;
} traced_estimate;

static inline traced_estimate traced_mean(const hpr_image *image)
{
    size_t pixels = (size_t)image->width * (size_t)image->height, n = image->channel_count;
    double sum = 0, variance = 0;
    for (size_t i = 0; i < pixels; i++) {
        sum += (double)image->radiance[n * i];
        variance += (double)image->variance[n * i];
    }
    return (traced_estimate){sum / (double)pixels, sqrt(variance) / (double)pixels};
}

#endif
