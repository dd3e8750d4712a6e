#include "render/strata.h"

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
    while (b) {
        uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

hpr_strata hpr_strata_of(uint32_t count)
{
    static const double golden = 0.61803398874989485;
    uint32_t rows = 1;
    for (uint32_t r = 1; r * r <= count; r++) {
        if (count % r == 0)
            rows = r;
    }
    hpr_strata strata = {.count = count, .columns = count / rows, .rows = rows};
    if (strata.columns <= 2 * rows)
        return strata;
    uint32_t near = (uint32_t)(golden * count + 0.5), away = 0;
    while (common_divisor(near - away, count) != 1 && common_divisor(near + away, count) != 1)
        away++;
    strata.step = common_divisor(near - away, count) == 1 ? near - away : near + away;
    strata.columns = strata.rows = count;
    return strata;
}

/* The finaliser of splitmix64 (Steele, Lea & Flood 2014). */
static uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void hpr_strata_place(const hpr_strata *strata, uint64_t pixel, uint32_t sample, double *x, double *y)
{
    uint64_t bits = mix((pixel * strata->count + sample + 1) * 0x9e3779b97f4a7c15u);
    uint32_t column = strata->step ? sample : sample % strata->columns;
    uint32_t row =
        strata->step ? (uint32_t)((uint64_t)sample * strata->step % strata->count) : sample / strata->columns;
    *x = (column + (double)(bits >> 32) * 0x1p-32) / strata->columns;
    *y = (row + (double)(bits & UINT32_MAX) * 0x1p-32) / strata->rows;
}
