#include "render/orbit.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static void turn(double c, double s, double v[3])
{
    double x = c * v[0] + s * v[2], z = c * v[2] - s * v[0];
    v[0] = x;
    v[2] = z;
}

hpr_camera hpr_camera_orbit(const hpr_camera *camera, const double centre[3], size_t step, size_t steps)
{
    hpr_camera turned = *camera;
    if (step % steps == 0)
        return turned;
    double angle = 2 * pi * (double)(step % steps) / (double)steps, c = cos(angle), s = sin(angle);
    for (int k = 0; k < 3; k++)
        turned.origin[k] -= centre[k];
    turn(c, s, turned.origin);
    turn(c, s, turned.right);
    turn(c, s, turned.up);
    turn(c, s, turned.backward);
    for (int k = 0; k < 3; k++)
        turned.origin[k] += centre[k];
    return turned;
}
