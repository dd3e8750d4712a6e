/*
 * Eight numbers side by side. Code over them is written once, as an HPR_LANES_BODY, and compiled for each
 * instruction set by functions that do nothing but call it:
 *   HPR_LANES_BODY void body(bool fused, ...);
 *   static HPR_TARGET_AVX512 void with_avx512(...) { body(true, ...); }
 * Products are fused into sums only where the code says so and only with AVX-512 (for AVX2 the compiler takes
 * the eight apart to do so), so results have the same bits on all machines with one instruction set.
 */
#ifndef HPR_MATH_LANES_H
#define HPR_MATH_LANES_H

#include <stdbool.h>
#include <string.h>

enum { HPR_LANES = 8 };

/* Everything here is inlined, so how such values would be passed does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"

typedef double hpr_lanes __attribute__((vector_size(8 * HPR_LANES)));

#define HPR_LANES_BODY static inline __attribute__((always_inline))
#define HPR_TARGET_AVX2 __attribute__((target("avx2")))
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
    return (hpr_lanes){a, a, a, a, a, a, a, a};
}

/* a b + c */
HPR_LANES_BODY hpr_lanes hpr_lanes_madd(bool fused, hpr_lanes a, hpr_lanes b, hpr_lanes c)
{
    if (!fused)
        return a * b + c;
    hpr_lanes sum;
    for (int k = 0; k < HPR_LANES; k++)
        sum[k] = __builtin_fma(a[k], b[k], c[k]);
    return sum;
}

#endif
