/* What rectangles hide, in closed form. */
#ifndef HPR_TESTS_RECTANGLE_H
#define HPR_TESTS_RECTANGLE_H

#include <math.h>

/* The part of the view from (x,y,0), looking up, that the rectangle x0..x1, y0..y1 at height z takes. Source:
 * Hamilton & Morgan 1952, configuration P-4. */
static inline double corner_part(double a, double b, double z)
{
    double p = sqrt(a * a + z * z), q = sqrt(b * b + z * z);
    return (a / p * atan(b / p) + b / q * atan(a / q)) / (2 * 3.14159265358979323846);
}

typedef struct rectangle {
    double x0, x1, y0, y1, z;
} rectangle;

static inline double rectangle_part(const rectangle *r, double x, double y)
{
    return corner_part(r->x1 - x, r->y1 - y, r->z) - corner_part(r->x0 - x, r->y1 - y, r->z) -
           corner_part(r->x1 - x, r->y0 - y, r->z) + corner_part(r->x0 - x, r->y0 - y, r->z);
}

#endif
