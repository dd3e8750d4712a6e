/*
 * Eight numbers side by side. Code over them is written once, as an HPR_LANES_BODY, and compiled for each
 * instruction set by functions that do nothing but call it:
 *   HPR_LANES_BODY void body(bool fused, ...);
 *   static HPR_TARGET_AVX512 void with_avx512(...) { body(true, ...); }
 * Products are fused into sums only where the code says so, so results have the same bits on all machines
 * with one instruction set.
 */
#ifndef HPR_MATH_LANES_H
#define HPR_MATH_LANES_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

enum { HPR_LANES = 8 };

/* Everything here is inlined, so how such values would be passed does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"

typedef double hpr_lanes __attribute__((vector_size(8 * HPR_LANES)));
typedef long long hpr_lanes_bits __attribute__((vector_size(8 * HPR_LANES)));

#define HPR_LANES_BODY static inline __attribute__((always_inline))
#define HPR_TARGET_AVX2 __attribute__((target("avx2,fma")))
#ifdef __clang__
#define HPR_TARGET_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,fma")))
#else /* which else takes half the width */
#define HPR_TARGET_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,fma,prefer-vector-width=512")))
#endif

HPR_LANES_BODY hpr_lanes hpr_lanes_load(const double *from)
{
    hpr_lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}

HPR_LANES_BODY void hpr_lanes_store(double *to, hpr_lanes a)
{
    memcpy(to, &a, sizeof a);
}

HPR_LANES_BODY hpr_lanes hpr_lanes_of(double a)
{
    /* by way of integers: GCC 12 loads eight doubles that are the same one after the other */
    hpr_lanes_bits whole;
    long long bits;
    memcpy(&bits, &a, sizeof bits);
    whole = bits - (hpr_lanes_bits){0};
    return (hpr_lanes)whole;
}

/* a b + c */
HPR_LANES_BODY hpr_lanes hpr_lanes_madd(bool fused, hpr_lanes a, hpr_lanes b, hpr_lanes c)
{
    if (!fused)
        return a * b + c;
    return (hpr_lanes){__builtin_fma(a[0], b[0], c[0]), __builtin_fma(a[1], b[1], c[1]),
                       __builtin_fma(a[2], b[2], c[2]), __builtin_fma(a[3], b[3], c[3]),
                       __builtin_fma(a[4], b[4], c[4]), __builtin_fma(a[5], b[5], c[5]),
                       __builtin_fma(a[6], b[6], c[6]), __builtin_fma(a[7], b[7], c[7])};
}

/* count rounded up to whole eights */
static inline size_t hpr_lanes_padded(size_t count)
{
    return (count + HPR_LANES - 1) / HPR_LANES * HPR_LANES;
}

#endif
