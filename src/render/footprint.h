/*
 * What one sample of a pixel shows of a textured patch: the mean of reflectance and emission over the part of
 * the patch that the sample stands for, where that covers more than a texel; else the point's own.
 */
#ifndef HPR_RENDER_FOOTPRINT_H
#define HPR_RENDER_FOOTPRINT_H

#include "render/camera.h"

/* The parallelogram around (s,t), in the parameters of the patch. */
typedef struct hpr_footprint {
    size_t patch;
    double s, t;
    double across[2], down[2];
} hpr_footprint;

/* A view, and how wide a sample is: of the picture's width and height. */
typedef struct hpr_sample_view {
    const hpr_patches *patches;
    const hpr_camera *camera;
    double aspect, across, down;
} hpr_sample_view;

/* Of the sample at (x,y) of the picture (as in hpr_camera_ray_through), which shows (s,t) of the patch. Where
 * the patch is seen edge-on it may be long. */
hpr_footprint hpr_footprint_of(const hpr_sample_view *view, double x, double y, size_t patch, double s,
                               double t);

/*
 * reflectance, exitance [channels]: means over the footprint. At most 256 points of a lattice (Roberts 2018,
 * R2), four to a texel as long as that suffices; those beyond the patch do not count. room: [channels].
 * Thread-safe.
 */
void hpr_footprint_shade(const hpr_patches *patches, const hpr_footprint *footprint, double *reflectance,
                         double *exitance, double *room);

#endif
