#include "render/camera.h"

#include "math/vec3.h"

#include <string.h>

double hpr_camera_aspect(const hpr_camera *camera)
{
    if (camera->kind == HPR_CAMERA_ORTHOGRAPHIC)
        return camera->xmag / camera->ymag;
    return camera->aspect > 0 ? camera->aspect : 1;
}

void hpr_camera_ray_through(const hpr_camera *camera, double picture_aspect, double x, double y,
                            hpr_camera_ray *ray)
{
    bool perspective = camera->kind == HPR_CAMERA_PERSPECTIVE;
    double half = perspective ? tan(0.5 * camera->yfov_rad) : camera->ymag;
    double right = half * picture_aspect * (2 * x - 1), up = half * (1 - 2 * y);
    double across[3] = {0, 0, 0};
    hpr_add_scaled3(across, right, camera->right, across);
    hpr_add_scaled3(across, up, camera->up, across);
    double stretch = 1; /* length along the ray per length along the axis */
    if (perspective) {
        memcpy(ray->origin, camera->origin, sizeof ray->origin);
        hpr_subtract3(across, camera->backward, ray->direction);
        stretch = hpr_length3(ray->direction);
    } else {
        hpr_add_scaled3(camera->origin, 1, across, ray->origin);
        hpr_add_scaled3((double[]){0, 0, 0}, -1, camera->backward, ray->direction);
    }
    for (int k = 0; k < 3; k++)
        ray->direction[k] /= stretch;
    ray->near = camera->znear * stretch;
    ray->far = camera->zfar * stretch;
}

void hpr_camera_frame_scene(const hpr_patches *patches, hpr_camera *camera)
{
    /* backward = (2, 2, 4) / sqrt(24): three-quarter view; right and up follow from y being up */
    static const double border = 1.05, pi = 3.14159265358979323846;
    const double backward[3] = {2 / sqrt(24), 2 / sqrt(24), 4 / sqrt(24)};
    const double right[3] = {2 / sqrt(5), 0, -1 / sqrt(5)};
    double centre[3], half_width, distance = 0, foremost = 0;
    *camera = (hpr_camera){.kind = HPR_CAMERA_PERSPECTIVE, .yfov_rad = pi * 40 / 180, .zfar = INFINITY};
    memcpy(camera->backward, backward, sizeof backward);
    memcpy(camera->right, right, sizeof right);
    hpr_cross3(backward, right, camera->up);
    half_width = tan(0.5 * camera->yfov_rad) / border;
    hpr_patches_radius(patches, centre);
    for (size_t i = 0; i < patches->count; i++) {
        double corner[4][3];
        size_t corner_count = hpr_patch_corners(patches, i, corner);
        for (size_t c = 0; c < corner_count; c++) {
            hpr_subtract3(corner[c], centre, corner[c]);
            double toward = hpr_dot3(corner[c], backward);
            double aside = fmax(fabs(hpr_dot3(corner[c], right)), fabs(hpr_dot3(corner[c], camera->up)));
            distance = fmax(distance, toward + aside / half_width);
            foremost = fmax(foremost, toward);
        }
    }
    if (!(distance > 0))
        distance = 1;
    hpr_add_scaled3(centre, distance, backward, camera->origin);
    camera->znear = fmin(0.01 * distance, 0.5 * (distance - foremost));
}
