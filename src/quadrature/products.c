#include "quadrature/products.h"

#include "math/planar_basis.h"

#include <math.h>
#include <string.h>

static void make_parallelogram(int degree, hpr_moment_map *map)
{
    map->products = (hpr_products){.degree = degree, .u = {-1, 2, 0}, .w = {-1, 2}};
    double *next = map->matrix;
    for (int a = 0; a <= degree; a++) {
        for (int b = 0; b <= degree; b++)
            *next++ = hpr_legendre_norm[a] * hpr_legendre_norm[b];
    }
}

/* Place of X_a Y_b among those with a + b <= degree. */
static size_t place_of(int degree, int a, int b)
{
    return (size_t)(a * (2 * degree + 3 - a) / 2 + b);
}

/*
 * X_i is what phi_ij has of s already, and the rest is a Jacobi polynomial: P_j^(alpha,0)(w) = sum_m c_m
 * P_m(w), alpha = 2i + 1, by its recurrence on the coefficients.
 */
static void make_triangle(int degree, hpr_moment_map *map)
{
    map->products = (hpr_products){.degree = degree, .total = true, .u = {-1, 2, 1}, .c = 1, .w = {-1, 2}};
    for (int i = 0; i <= degree; i++) {
        double alpha = 2 * i + 1, before[HPR_MAX_DEGREE + 2] = {0}, now[HPR_MAX_DEGREE + 2] = {1};
        for (int j = 0; i + j <= degree; j++) {
            int d = i + j;
            double *row = map->matrix + (size_t)(d * (d + 1) / 2 + j) * map->count;
            for (int m = 0; m <= j; m++)
                row[place_of(degree, i, m)] = hpr_legendre_norm[i] * sqrt(2 * d + 2) * now[m];
            double c = 2 * j + alpha, below = 2.0 * (j + 1) * (j + 1 + alpha) * c;
            double rise = (c + 1) * c * (c + 2) / below, shift = (c + 1) * alpha * alpha / below;
            double fall = 2 * (j + alpha) * j * (c + 2) / below, next[HPR_MAX_DEGREE + 2] = {0};
            for (int m = 0; m <= j; m++) {
                next[m + 1] += rise * now[m] * (m + 1) / (2 * m + 1);
                if (m > 0)
                    next[m - 1] += rise * now[m] * m / (2 * m + 1);
                next[m] += shift * now[m] - fall * before[m];
            }
            memcpy(before, now, sizeof now);
            memcpy(now, next, sizeof next);
        }
    }
}

/* Legendre polynomials of the box around it. */
static void make_quadrilateral(const hpr_element_frame *frame, hpr_moment_map *map)
{
    const double box[2] = {fmax(1, frame->opposite[0]), fmax(1, frame->opposite[1])};
    map->products = (hpr_products){
        .degree = frame->degree, .total = true, .u = {-1, 2 / box[0], 0}, .w = {-1, 2 / box[1]}};
    if (frame->degree > 0)
        hpr_planar_matrix(frame->recurrence, frame->degree, box, map->matrix);
    else
        map->matrix[0] = 1 / sqrt(hpr_frame_measure(frame));
}

void hpr_moment_map_make(const hpr_element_frame *frame, hpr_moment_map *map)
{
    map->made = true;
    map->count = hpr_basis_count(frame->shape, frame->degree);
    map->loss = 1;
    if (frame->shape == HPR_SHAPE_PARALLELOGRAM) {
        make_parallelogram(frame->degree, map);
        return;
    }
    memset(map->matrix, 0, map->count * map->count * sizeof *map->matrix);
    if (frame->shape == HPR_SHAPE_TRIANGLE)
        make_triangle(frame->degree, map);
    else
        make_quadrilateral(frame, map);
    for (size_t k = 0; k < map->count; k++) {
        double sum = 0;
        for (size_t l = 0; l < map->count; l++)
            sum += fabs(map->matrix[k * map->count + l]);
        map->loss = fmax(map->loss, sum / map->matrix[0]);
    }
}

void hpr_moment_map_row(const hpr_moment_map *map, size_t k, const double *moment, size_t width, double *out)
{
    if (!map->products.total) {
        for (size_t i = 0; i < width; i++)
            out[i] = map->matrix[k] * moment[k * width + i];
        return;
    }
    memset(out, 0, width * sizeof *out);
    for (size_t l = 0; l < map->count; l++) {
        double factor = map->matrix[k * map->count + l];
        for (size_t i = 0; factor != 0 && i < width; i++)
            out[i] += factor * moment[l * width + i];
    }
}

static bool has_factors(const hpr_element_frame *frame, const hpr_cell *cell)
{
    if (frame->degree == 0 || cell->shape != frame->shape || cell->edge1[1] != 0 || cell->edge2[0] != 0)
        return false;
    return cell->shape == HPR_SHAPE_PARALLELOGRAM ||
           (cell->shape == HPR_SHAPE_TRIANGLE && cell->edge1[0] == 1 && cell->edge2[1] == 1);
}

/* sqrt(2a + 1) P_a(2x - 1), or without the root. */
static void legendre_rows(int degree, size_t count, const double *x, bool normal,
                          double (*row)[HPR_FACTOR_POINTS])
{
    for (size_t i = 0; i < count; i++) {
        double before = 0, now = 1;
        for (int a = 0; a <= degree; a++) {
            row[a][i] = normal ? hpr_legendre_norm[a] * now : now;
            double next = hpr_legendre_raise[a] * (2 * x[i] - 1) * now - hpr_legendre_lower[a] * before;
            before = now;
            now = next;
        }
    }
}

/* Y_ab is phi_k where P_a is 1, on the edge s = 1 - t. */
static void triangle_rows(hpr_isa isa, const hpr_element_frame *frame, size_t count, const double *t,
                          hpr_factor_tables *tables)
{
    double edge[HPR_FACTOR_POINTS], recurrences[4 * HPR_FACTOR_POINTS], *next = tables->second;
    for (size_t j = 0; j < count; j++)
        edge[j] = 1 - t[j];
    hpr_frame_basis_many(isa, frame, count, edge, t, HPR_FACTOR_POINTS, tables->rows, recurrences);
    for (int a = 0; a <= frame->degree; a++) {
        for (int b = 0; a + b <= frame->degree; b++, next += HPR_FACTOR_POINTS) {
            int d = a + b;
            memcpy(next, tables->rows + (size_t)(d * (d + 1) / 2 + b) * HPR_FACTOR_POINTS,
                   count * sizeof *next);
        }
    }
}

bool hpr_factors_make(hpr_isa isa, const hpr_gauss_table *gauss, const hpr_element_frame *frame,
                      const hpr_cell *cell, const int nodes[2], hpr_factor_tables *tables,
                      hpr_factors *factors)
{
    double x[HPR_FACTOR_POINTS], y[HPR_FACTOR_POINTS];
    const size_t first = hpr_lanes_padded((size_t)nodes[0]), second = hpr_lanes_padded((size_t)nodes[1]);
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    if (!has_factors(frame, cell))
        return false;
    const hpr_gauss_rule *along = &gauss->legendre[nodes[0]],
                         *across = triangle ? &gauss->jacobi[nodes[1]] : &gauss->legendre[nodes[1]];
    for (size_t i = 0; i < first; i++)
        x[i] = cell->origin[0] + along->node[i] * cell->edge1[0];
    for (size_t j = 0; j < second; j++)
        y[j] = cell->origin[1] + across->node[j] * cell->edge2[1];
    legendre_rows(frame->degree, first, x, !triangle, tables->first);
    if (triangle)
        triangle_rows(isa, frame, second, y, tables);
    else
        legendre_rows(frame->degree, second, y, true, (double(*)[HPR_FACTOR_POINTS])tables->second);
    *factors = (hpr_factors){.degree = frame->degree,
                             .total = triangle,
                             .nodes = {(size_t)nodes[0], (size_t)nodes[1]},
                             .first = tables->first[0],
                             .second = tables->second,
                             .wide_first = tables->wide_first,
                             .wide_second = tables->wide_second};
    return true;
}

void hpr_own_moments(hpr_isa isa, const hpr_element_frame *frame, const hpr_points *points,
                     const double *kernel, double *moment, hpr_moment_scratch *scratch)
{
    size_t count = (size_t)points->count;
    for (size_t first = 0; first < count; first += HPR_TABLE_POINTS) {
        size_t left = count - first,
               padded = hpr_lanes_padded(left < HPR_TABLE_POINTS ? left : HPR_TABLE_POINTS);
        hpr_frame_basis_many(isa, frame, padded, points->s + first, points->t + first, HPR_TABLE_POINTS,
                             scratch->basis, scratch->recurrences);
        const hpr_row_product product = {.left = kernel + first,
                                         .right = scratch->basis,
                                         .right_stride = HPR_TABLE_POINTS,
                                         .left_count = 1,
                                         .right_count = hpr_basis_count(frame->shape, frame->degree),
                                         .vectors = padded / HPR_LANES};
        hpr_sums_of(isa)->rows(&product, moment, &scratch->sums);
    }
}
