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

void hpr_strata_place(const hpr_strata *strata, uint32_t sample, double *x, double *y)
{
    if (strata->step) {
        uint32_t row = (uint32_t)((uint64_t)sample * strata->step % strata->count);
        *x = (sample + 0.5) / strata->count;
        *y = (row + 0.5) / strata->count;
        return;
    }
    uint32_t column = sample % strata->columns, row = sample / strata->columns;
    *x = (column + (row + 0.5) / strata->rows) / strata->columns;
    *y = (row + (column + 0.5) / strata->columns) / strata->rows;
}
