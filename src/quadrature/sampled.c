#include "quadrature/sampled.h"

#include "math/hash.h"

#include <math.h>

void hpr_sampled_random(uint64_t seed, uint64_t index, double random[4])
{
    static const uint64_t step = HPR_HASH_STEP;
    uint64_t start = hpr_hash(hpr_hash(seed + step) + 2 * index * step);
    uint64_t bits[2] = {hpr_hash(start + step), hpr_hash(start + 2 * step)};
    for (int i = 0; i < 2; i++) {
        random[2 * i] = (double)(bits[i] >> 32) * 0x1p-32;
        random[2 * i + 1] = (double)(bits[i] & 0xffffffffu) * 0x1p-32;
    }
}

/* The part `random` of the way through the stratum of node `index`, as the weights divide [0,1]. */
static double in_stratum(const hpr_gauss_rule *rule, int count, int index, double random)
{
    double before = 0, total = 0;
    for (int i = 0; i < count; i++) {
        before += i < index ? rule->weight[i] : 0;
        total += rule->weight[i];
    }
    return (before + random * rule->weight[index]) / total;
}

void hpr_sampled_place(const hpr_gauss_table *gauss, const hpr_cell *cell, const int nodes[2], int index,
                       const double random[2], double *s, double *t)
{
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    const hpr_gauss_rule *second = triangle ? &gauss->jacobi[nodes[1]] : &gauss->legendre[nodes[1]];
    double a = in_stratum(&gauss->legendre[nodes[0]], nodes[0], index % nodes[0], random[0]);
    double b = in_stratum(second, nodes[1], index / nodes[0], random[1]);
    if (triangle) { /* collapsed: the part of the area below b is 1 - (1 - b)^2 */
        b = 1 - sqrt(1 - b);
        a *= 1 - b;
    }
    *s = cell->origin[0] + a * cell->edge1[0] + b * cell->edge2[0];
    *t = cell->origin[1] + a * cell->edge1[1] + b * cell->edge2[1];
}

double hpr_sampled_error(const hpr_sampled *rays)
{
    if (!(rays->weight > 0))
        return 0;
    double rarely = rays->square / (rays->weight * rays->weight); /* 1/n */
    double v = (rays->seen / rays->weight + rarely) / (1 + 2 * rarely);
    return sqrt(v * (1 - v) * rays->square);
}
