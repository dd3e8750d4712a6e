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
