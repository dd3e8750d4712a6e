/*
 * Where the samples of a pixel lie: the same places in every pixel, so that edges come out even and nothing
 * is noise. n samples that are a grid of nx x ny cells, the sides at most 1 : 2, take one place in each cell,
 * sheared so that no two share a column or a row of 1/n (Chiu, Shirley & Wang 1994, the canonical
 * arrangement; 4 is the rotated grid). Other n (5, 7, 10, 11, 13 ...) take a Latin pattern: sample i is in
 * column i of n and in row i g mod n, g the number prime to n that is nearest to n over the golden ratio (a
 * Fibonacci-like lattice).
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

/* The place of a sample in its pixel, 0 < x, y < 1. */
void hpr_strata_place(const hpr_strata *strata, uint32_t sample, double *x, double *y);

#endif
