/*
 * Numbers that are a function of an index alone, so that they do not depend on who asks first.
 * Source: Steele, Lea & Flood 2014 (splitmix64), its finaliser; 0 maps to 0.
 */
#ifndef HPR_MATH_HASH_H
#define HPR_MATH_HASH_H

#include <stdint.h>

/* Added from draw to draw: 2^64 over the golden ratio. */
#define HPR_HASH_STEP UINT64_C(0x9E3779B97F4A7C15)

static inline uint64_t hpr_hash(uint64_t x)
{
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

/* In [0,1), a multiple of 2^-53. */
static inline double hpr_hash_unit(uint64_t x)
{
    return (double)(hpr_hash(x) >> 11) * 0x1p-53;
}

#endif
