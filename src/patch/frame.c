#include "patch/frame.h"

#include "math/vec3.h"

#include <string.h>

void hpr_patches_frame(const hpr_patches *patches, hpr_camera *camera)
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
