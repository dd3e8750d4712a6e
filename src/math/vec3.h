/* Vectors of three doubles, inline. Results may not overlap their arguments unless a function says so. */
#ifndef HPR_MATH_VEC3_H
#define HPR_MATH_VEC3_H

#include <math.h>

static inline double hpr_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void hpr_cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

/* a - b; result may be a or b. */
static inline void hpr_subtract(const double a[3], const double b[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = a[k] - b[k];
}

/* a + factor * b; result may be a or b. */
static inline void hpr_add_scaled(const double a[3], double factor, const double b[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = a[k] + factor * b[k];
}

static inline double hpr_length(const double a[3])
{
    return sqrt(hpr_dot(a, a));
}

#endif
