/*
 * Eight doubles side by side. What is written with them has the same order of operations on every machine:
 * sums run in eight interleaved parts, and products are fused with sums only where `fused` says so, which an
 * instruction set either always does or never. A body is an HPR_INLINE function; one function for each
 * instruction set calls it, HPR_AVX512, HPR_AVX2 or neither standing before it, and hpr_isa chooses among
 * them at run time.
 */
#ifndef HPR_MATH_LANES_H
#define HPR_MATH_LANES_H

#include <stdbool.h>
#include <stddef.h>

#define HPR_INLINE static inline __attribute__((always_inline))
#if defined(__x86_64__)
#define HPR_AVX2 __attribute__((target("avx2,fma")))
#define HPR_AVX512 __attribute__((target("avx512f,avx512dq")))
#else
#define HPR_AVX2
#define HPR_AVX512
#endif

enum { HPR_LANES = 8 };

/* Nothing below is ever called, all is inlined: how such vectors would be passed does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"

typedef double hpr_lanes __attribute__((vector_size(8 * sizeof(double))));

/* The same anywhere in an array. */
typedef double hpr_lanes_anywhere
    __attribute__((vector_size(8 * sizeof(double)), aligned(sizeof(double)), may_alias));

/* count rounded up to whole lanes */
static inline size_t hpr_lanes_padded(size_t count)
{
    return (count + HPR_LANES - 1) / HPR_LANES * HPR_LANES;
}

HPR_INLINE hpr_lanes hpr_lanes_load(const double *from)
{
    return *(const hpr_lanes_anywhere *)from;
}

HPR_INLINE void hpr_lanes_store(double *to, hpr_lanes value)
{
    *(hpr_lanes_anywhere *)to = value;
}

HPR_INLINE hpr_lanes hpr_lanes_of(double value)
{
    return (hpr_lanes){value, value, value, value, value, value, value, value};
}

/* a b + c */
HPR_INLINE hpr_lanes hpr_lanes_mul_add(hpr_lanes a, hpr_lanes b, hpr_lanes c, bool fused)
{
    if (!fused)
        return a * b + c;
    return (hpr_lanes){__builtin_fma(a[0], b[0], c[0]), __builtin_fma(a[1], b[1], c[1]),
                       __builtin_fma(a[2], b[2], c[2]), __builtin_fma(a[3], b[3], c[3]),
                       __builtin_fma(a[4], b[4], c[4]), __builtin_fma(a[5], b[5], c[5]),
                       __builtin_fma(a[6], b[6], c[6]), __builtin_fma(a[7], b[7], c[7])};
}

HPR_INLINE double hpr_lanes_sum(hpr_lanes a)
{
    return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}

#endif
