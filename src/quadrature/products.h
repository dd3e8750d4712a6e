/* Polynomials that are cheaper to evaluate than an element's own and span the same. */
#ifndef HPR_QUADRATURE_PRODUCTS_H
#define HPR_QUADRATURE_PRODUCTS_H

#include "quadrature/lanes_sums.h"
#include "quadrature/pair.h"

/*
 * phi_k = sum_l matrix[k count + l] (X_a Y_b)_l; of a parallelogram phi_k = matrix[k] (X_a Y_b)_k. loss: the
 * largest sum of a row's magnitudes, phi_0 being 1: how many roundoffs of the constant's moment a moment of
 * phi may err by, |X_a Y_b| <= 1.
 */
typedef struct hpr_moment_map {
    bool made;
    hpr_products products;
    size_t count; /* of functions */
    double loss;
    double *matrix; /* [count][count], or [count] */
} hpr_moment_map;

/* map->matrix: room for it. Thread-safe with distinct maps. */
void hpr_moment_map_make(const hpr_element_frame *frame, hpr_moment_map *map);

/* moment [count][width] of products -> out [width], the moments of phi_k. */
void hpr_moment_map_row(const hpr_moment_map *map, size_t k, const double *moment, size_t width, double *out);

/* Memory of an hpr_factors for a degree. */
typedef struct hpr_factor_tables {
    double *rows, *second;            /* [functions][HPR_FACTOR_POINTS] */
    double *wide_first, *wide_second; /* [degree + 1], [functions of a triangle][HPR_FACTOR_POINTS][8] */
    double first[HPR_MAX_DEGREE + 1][HPR_FACTOR_POINTS];
} hpr_factor_tables;

/* Factors on the Gauss points of a cell, in `tables`; false if it has none: above degree 0 a cell with edges
 * along those of its parallelogram has, and a whole triangle. Thread-safe with distinct tables. */
bool hpr_factors_make(hpr_isa isa, const hpr_gauss_table *gauss, const hpr_element_frame *frame,
                      const hpr_cell *cell, const int nodes[2], hpr_factor_tables *tables,
                      hpr_factors *factors);

typedef struct hpr_moment_scratch {
    hpr_sums_scratch sums;
    double *basis; /* [functions][HPR_TABLE_POINTS] */
    double recurrences[4 * HPR_TABLE_POINTS];
} hpr_moment_scratch;

/* moment[k] += sum_j kernel_j phi_k(j), padded points, kernel 0 at those of no weight. */
void hpr_own_moments(hpr_isa isa, const hpr_element_frame *frame, const hpr_points *points,
                     const double *kernel, double *moment, hpr_moment_scratch *scratch);

#endif
