/*
 * Where the samples of a pixel lie. n samples that are a grid of nx x ny cells, the sides at most 1 : 2, take
 * one jittered place in each cell. Other n (5, 7, 10, 11, 13 ...) take a Latin pattern: sample i is in column
 * i of n and in row i g mod n, g the number prime to n that is nearest to n over the golden ratio (a
 * Fibonacci-like lattice), jittered in its cell of 1/n x 1/n.
 */
#ifndef HPR_RENDER_STRATA_H
#define HPR_RENDER_STRATA_H

#include <stdbool.h>
#include <stdint.h>

typedef struct hpr_strata {
    uint32_t count, columns, rows;
    uint32_t step; /* g, or 0 for a grid */
} hpr_strata;

/* count >= 1 */
hpr_strata hpr_strata_of(uint32_t count);

/* The place of a sample in its pixel, 0 <= x, y < 1. Depends on its arguments only. */
void hpr_strata_place(const hpr_strata *strata, uint64_t pixel, uint32_t sample, double *x, double *y);

#endif
