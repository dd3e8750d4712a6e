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

/* The six faces of a cube of side 1, front inside, of one material; from its own axes into the world by
 * x -> origin + x0 axis[0] + x1 axis[1] + x2 axis[2]. rho, radiance: [3] channels. */
static inline void traced_add_cube(hpr_room *room, const double origin[3], const double axis[3][3],
                                   const double rho[3], const double radiance[3])
{
    static const int corner[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}}; /* bits: x, y, z */
    static const uint32_t vertex[4] = {0, 1, 2, 3};
    uint32_t material;
    assert_int_equal(hpr_scene_add_material(room->scene, "face", rho, radiance, false, &material), HPR_OK);
    for (int face = 0; face < 6; face++) {
        double position[4][3];
        for (int v = 0; v < 4; v++) {
            for (int k = 0; k < 3; k++) {
                position[v][k] = origin[k];
                for (int a = 0; a < 3; a++)
                    position[v][k] += (corner[face][v] >> a & 1) * axis[a][k];
            }
        }
        const hpr_mesh mesh = {.node = room->faces++,
                               .material = material,
                               .vertex_count = 4,
                               .position = position[0],
                               .face_count = 1,
                               .vertex = vertex};
        assert_int_equal(hpr_scene_add_mesh(room->scene, &mesh), HPR_OK);
    }
}

typedef struct traced_setting {
    int side, samples; /* pixels per side, paths per pixel */
    uint64_t seed;
    double environment; /* of all channels */
} traced_setting;

static inline hpr_status traced_try(hpr_room *room, size_t camera, traced_setting set, hpr_image *image)
{
    const hpr_reference_options options = {.seed = set.seed};
    const hpr_render_options film = {set.side, set.side, set.samples};
    hpr_reference *reference = NULL;
    *image = (hpr_image){0};
    assert_int_equal(hpr_scene_set_environment(room->scene, 1, &set.environment), HPR_OK);
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

/* Mean of a channel over all pixels, its standard error by the variance layer. */
typedef struct traced_estimate {
    double mean, error;
} traced_estimate;

static inline traced_estimate traced_mean_of(const hpr_image *image, size_t channel)
{
    size_t pixels = (size_t)image->width * (size_t)image->height, n = image->channel_count;
    double sum = 0, variance = 0;
    for (size_t i = 0; i < pixels; i++) {
        sum += (double)image->radiance[n * i + channel];
        variance += (double)image->variance[n * i + channel];
    }
    return (traced_estimate){sum / (double)pixels, sqrt(variance) / (double)pixels};
}

static inline traced_estimate traced_mean(const hpr_image *image)
{
    return traced_mean_of(image, 0);
}

#endif
