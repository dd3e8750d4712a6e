/* Numbers as sums of two doubles, where one loses too many digits. Source: the error-free product of Dekker
 * 1971 and sum of Knuth 1969, as in Shewchuk 1997. */
#ifndef HPR_MATH_TWOFOLD_H
#define HPR_MATH_TWOFOLD_H

#include "math/vec3.h"

typedef struct hpr_twofold {
    double high, low;
} hpr_twofold;

static inline hpr_twofold hpr_twofold_sum(hpr_twofold a, hpr_twofold b)
{
    double s = a.high + b.high, t = s - a.high;
    double error = (a.high - (s - t)) + (b.high - t) + (a.low + b.low), high = s + error;
    return (hpr_twofold){high, error - (high - s)};
}

static inline hpr_twofold hpr_twofold_product(double a, double b)
{
    double p = a * b;
    return (hpr_twofold){p, fma(a, b, -p)};
}

static inline hpr_twofold hpr_twofold_times(hpr_twofold a, double b)
{
    hpr_twofold p = hpr_twofold_product(a.high, b);
    p.low += a.low * b;
    double high = p.high + p.low;
    return (hpr_twofold){high, p.low - (high - p.high)};
}

/* a b - c d */
static inline hpr_twofold hpr_twofold_minor(double a, double b, double c, double d)
{
    return hpr_twofold_sum(hpr_twofold_product(a, b), hpr_twofold_product(-c, d));
}

/* |a x b|, and the direction of a x b: to the last digit however nearly parallel the two are, and however
 * large or small, as far as the result is a number. 0 and no direction if there is none. */
static inline double hpr_cross_exactly(hpr_vec3 a, hpr_vec3 b, hpr_vec3 *direction)
{
    const double most[2] = {fmax(fmax(fabs(a.x), fabs(a.y)), fabs(a.z)),
                            fmax(fmax(fabs(b.x), fabs(b.y)), fabs(b.z))};
    *direction = (hpr_vec3){0, 0, 0};
    if (!(most[0] > 0 && most[1] > 0))
        return 0;
    const int exponent[2] = {ilogb(most[0]), ilogb(most[1])};
    a = (hpr_vec3){ldexp(a.x, -exponent[0]), ldexp(a.y, -exponent[0]), ldexp(a.z, -exponent[0])};
    b = (hpr_vec3){ldexp(b.x, -exponent[1]), ldexp(b.y, -exponent[1]), ldexp(b.z, -exponent[1])};
    hpr_vec3 c = {hpr_twofold_minor(a.y, b.z, a.z, b.y).high, hpr_twofold_minor(a.z, b.x, a.x, b.z).high,
                  hpr_twofold_minor(a.x, b.y, a.y, b.x).high};
    double length = hpr_length(c);
    if (length > 0)
        *direction = hpr_scale(c, 1 / length);
    return ldexp(length, exponent[0] + exponent[1]);
}

#endif
