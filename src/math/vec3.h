/* Three-vectors in double. */
#ifndef HPR_MATH_VEC3_H
#define HPR_MATH_VEC3_H

#include <math.h>

typedef struct hpr_vec3 {
    double x, y, z;
} hpr_vec3;

/* Unlike fmin and fmax no calls of the C library; for numbers that are not NaN. */
static inline double hpr_min(double a, double b)
{
    return b < a ? b : a;
}

static inline double hpr_max(double a, double b)
{
    return b > a ? b : a;
}

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

/* The length of x y z whose sum of squares this is: where that over- or underflows it is formed anew. */
static inline double hpr_length_of(double square, double x, double y, double z)
{
    if (square > 0x1p-960 && square < 0x1p1000)
        return sqrt(square);
    double largest = fmax(fmax(fabs(x), fabs(y)), fabs(z));
    if (!(largest > 0 && largest < INFINITY))
        return largest;
    int e = ilogb(largest);
    x = ldexp(x, -e);
    y = ldexp(y, -e);
    z = ldexp(z, -e);
    return ldexp(sqrt(x * x + y * y + z * z), e);
}

static inline double hpr_length(hpr_vec3 a)
{
    return hpr_length_of(hpr_dot(a, a), a.x, a.y, a.z);
}

/* The same on arrays of three. A result may be one of its arguments, except for the cross product's. */

static inline double hpr_dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void hpr_cross3(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void hpr_subtract3(const double a[3], const double b[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = a[k] - b[k];
}

/* a + factor b */
static inline void hpr_add_scaled3(const double a[3], double factor, const double b[3], double result[3])
{
    for (int k = 0; k < 3; k++)
        result[k] = a[k] + factor * b[k];
}

static inline double hpr_length3(const double a[3])
{
    return hpr_length_of(hpr_dot3(a, a), a[0], a[1], a[2]);
}

#endif
