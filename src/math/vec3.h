/* Three-vectors in double. */
#ifndef HPR_MATH_VEC3_H
#define HPR_MATH_VEC3_H

#include <math.h>

typedef struct hpr_vec3 {
    double x, y, z;
} hpr_vec3;

static inline hpr_vec3 hpr_vec3_load(const double *p)
{
    return (hpr_vec3){p[0], p[1], p[2]};
}

static inline void hpr_vec3_store(double *p, hpr_vec3 a)
{
    p[0] = a.x;
    p[1] = a.y;
    p[2] = a.z;
}

static inline hpr_vec3 hpr_add(hpr_vec3 a, hpr_vec3 b)
{
    return (hpr_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline hpr_vec3 hpr_sub(hpr_vec3 a, hpr_vec3 b)
{
    return (hpr_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline hpr_vec3 hpr_scale(hpr_vec3 a, double f)
{
    return (hpr_vec3){a.x * f, a.y * f, a.z * f};
}

/* a + f b */
static inline hpr_vec3 hpr_madd(hpr_vec3 a, double f, hpr_vec3 b)
{
    return (hpr_vec3){a.x + f * b.x, a.y + f * b.y, a.z + f * b.z};
}

static inline double hpr_dot(hpr_vec3 a, hpr_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline hpr_vec3 hpr_cross(hpr_vec3 a, hpr_vec3 b)
{
    return (hpr_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double hpr_length(hpr_vec3 a)
{
    return sqrt(hpr_dot(a, a));
}

#endif
