/* Cameras: from a place in the picture to a ray. */
#ifndef HPR_RENDER_CAMERA_H
#define HPR_RENDER_CAMERA_H

#include "patch/patches.h"

typedef struct hpr_camera_ray {
    double origin[3], direction[3]; /* direction has length 1 */
    double near, far;               /* along the ray; the camera's znear and zfar are along its axis */
} hpr_camera_ray;

/* Width over height that the camera asks for: aspect, or xmag / ymag; 1 if it asks for none. */
double hpr_camera_aspect(const hpr_camera *camera);

/*
 * The ray through the place (x, y) of a picture, x from 0 (left) to 1, y from 0 (top) to 1. picture_aspect is
 * the picture's width over height: pixels are square. What the camera sees from top to bottom (yfov, ymag) is
 * kept when the picture's aspect is not the camera's; the sides give way. Concurrent calls allowed.
 */
void hpr_camera_ray_through(const hpr_camera *camera, double picture_aspect, double x, double y,
                            hpr_camera_ray *ray);

#endif
