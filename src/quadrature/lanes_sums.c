#include "quadrature/lanes_sums.h"

enum { TILE_ROWS = 2, TILE_COLUMNS = 5, GRID_FUNCTIONS = 8 };

HPR_LANES_BODY hpr_lanes kernel_of(hpr_lanes dx, hpr_lanes dy, hpr_lanes dz, hpr_lanes weight, bool fused)
{
    hpr_lanes r2 = hpr_lanes_madd(fused, dx, dx, hpr_lanes_madd(fused, dy, dy, dz * dz));
    return weight / (r2 * r2);
}

HPR_LANES_BODY void kernel_body(const hpr_points *from, size_t i, const hpr_points *to, double scale,
                                double *kernel, bool fused)
{
    const hpr_lanes x = hpr_lanes_of(from->x[i]), y = hpr_lanes_of(from->y[i]), z = hpr_lanes_of(from->z[i]);
    const hpr_lanes by = hpr_lanes_of(scale);
    for (size_t j = 0; j < (size_t)to->count; j += HPR_LANES) {
        hpr_lanes dx = hpr_lanes_load(to->x + j) - x, dy = hpr_lanes_load(to->y + j) - y,
                  dz = hpr_lanes_load(to->z + j) - z;
        hpr_lanes_store(kernel + j, kernel_of(dx, dy, dz, by * hpr_lanes_load(to->weight + j), fused));
    }
}

/* Kernel times X_a and Y_b of a table's points. */
HPR_LANES_BODY void tables_body(const hpr_products *p, size_t vectors, const double *s, const double *t,
                                const double *kernel, hpr_sums_scratch *scratch, bool fused)
{
    for (size_t v = 0; v < vectors; v++) {
        hpr_lanes sv = hpr_lanes_load(s + v * HPR_LANES), tv = hpr_lanes_load(t + v * HPR_LANES);
        hpr_lanes u = hpr_lanes_madd(fused, hpr_lanes_of(p->u[2]), tv,
                                     hpr_lanes_madd(fused, hpr_lanes_of(p->u[1]), sv, hpr_lanes_of(p->u[0])));
        hpr_lanes w = hpr_lanes_madd(fused, hpr_lanes_of(p->w[1]), tv, hpr_lanes_of(p->w[0]));
        hpr_lanes q = hpr_lanes_madd(fused, hpr_lanes_of(-p->c), tv, hpr_lanes_of(1)), q2 = q * q;
        hpr_lanes x = hpr_lanes_load(kernel + v * HPR_LANES), x_before = hpr_lanes_of(0);
        hpr_lanes y = hpr_lanes_of(1), y_before = hpr_lanes_of(0);
        for (int n = 0;; n++) {
            scratch->x[n][v] = x;
            scratch->y[n][v] = y;
            if (n == p->degree)
                break;
            hpr_lanes raise = hpr_lanes_of(hpr_legendre_raise[n]),
                      lower = hpr_lanes_of(-hpr_legendre_lower[n]);
            hpr_lanes x_next = hpr_lanes_madd(fused, raise * u, x, lower * q2 * x_before);
            hpr_lanes y_next = hpr_lanes_madd(fused, raise * w, y, lower * y_before);
            x_before = x;
            y_before = y;
            x = x_next;
            y = y_next;
        }
    }
}

/* sum[a][b] += the products of rows a of x and b of y, few enough of both to stay in registers. */
HPR_LANES_BODY void tile_body(const double *x, size_t x_stride, const double *y, size_t y_stride,
                              size_t vectors, hpr_lanes *sum, size_t sum_stride, int rows, int columns,
                              bool fused)
{
    hpr_lanes s[TILE_ROWS][TILE_COLUMNS];
#pragma GCC unroll 8
    for (int a = 0; a < rows; a++) {
#pragma GCC unroll 8
        for (int b = 0; b < columns; b++)
            s[a][b] = sum[(size_t)a * sum_stride + (size_t)b];
    }
    for (size_t v = 0; v < vectors; v++) {
        hpr_lanes left[TILE_ROWS];
#pragma GCC unroll 8
        for (int a = 0; a < rows; a++)
            left[a] = hpr_lanes_load(x + (size_t)a * x_stride + v * HPR_LANES);
#pragma GCC unroll 8
        for (int b = 0; b < columns; b++) {
            hpr_lanes right = hpr_lanes_load(y + (size_t)b * y_stride + v * HPR_LANES);
#pragma GCC unroll 8
            for (int a = 0; a < rows; a++)
                s[a][b] = hpr_lanes_madd(fused, left[a], right, s[a][b]);
        }
    }
#pragma GCC unroll 8
    for (int a = 0; a < rows; a++) {
#pragma GCC unroll 8
        for (int b = 0; b < columns; b++)
            sum[(size_t)a * sum_stride + (size_t)b] = s[a][b];
    }
}

#define TILE(a, b)                                                                                           \
    case (a - 1) * TILE_COLUMNS + b:                                                                         \
        tile_body(x, x_stride, y, y_stride, vectors, sum, sum_stride, a, b, fused);                          \
        return

HPR_LANES_BODY void tile_of(const double *x, size_t x_stride, const double *y, size_t y_stride,
                            size_t vectors, hpr_lanes *sum, size_t sum_stride, int rows, int columns,
                            bool fused)
{
    switch ((rows - 1) * TILE_COLUMNS + columns) {
        TILE(1, 1);
        TILE(1, 2);
        TILE(1, 3);
        TILE(1, 4);
        TILE(1, 5);
        TILE(2, 1);
        TILE(2, 2);
        TILE(2, 3);
        TILE(2, 4);
        TILE(2, 5);
    }
}

/* Two rows, or one, against any number of them. */
HPR_LANES_BODY void strip_body(const double *x, size_t x_stride, const double *y, size_t y_stride,
                               size_t vectors, hpr_lanes *sum, size_t sum_stride, int rows, size_t columns,
                               bool fused)
{
    size_t tiles = (columns + TILE_COLUMNS - 1) / TILE_COLUMNS;
    for (size_t k = 0, done = 0; k < tiles; k++) {
        size_t width = (columns - done) / (tiles - k);
        tile_of(x, x_stride, y + done * y_stride, y_stride, vectors, sum + done, sum_stride, rows, (int)width,
                fused);
        done += width;
    }
}

/* Sums of the lanes of eight at once. */
HPR_LANES_BODY hpr_lanes sums_of(const hpr_lanes *of)
{
    hpr_lanes by_two[4], by_four[2];
#pragma GCC unroll 4
    for (int k = 0; k < 4; k++)
        by_two[k] = __builtin_shufflevector(of[2 * k], of[2 * k + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
                    __builtin_shufflevector(of[2 * k], of[2 * k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
#pragma GCC unroll 2
    for (int k = 0; k < 2; k++)
        by_four[k] = __builtin_shufflevector(by_two[2 * k], by_two[2 * k + 1], 0, 1, 8, 9, 4, 5, 12, 13) +
                     __builtin_shufflevector(by_two[2 * k], by_two[2 * k + 1], 2, 3, 10, 11, 6, 7, 14, 15);
    return __builtin_shufflevector(by_four[0], by_four[1], 0, 1, 2, 3, 8, 9, 10, 11) +
           __builtin_shufflevector(by_four[0], by_four[1], 4, 5, 6, 7, 12, 13, 14, 15);
}

/* sum[n a + b] += sum_v x[a][v] y[b][v]; with `total` those of a + b >= n are left as they are or not. */
HPR_LANES_BODY void square_body(const double *x, size_t x_stride, const double *y, size_t y_stride,
                                size_t vectors, hpr_lanes *sum, size_t rows, size_t columns, bool total,
                                bool fused)
{
    for (size_t a = 0; a < rows; a += TILE_ROWS)
        strip_body(x + a * x_stride, x_stride, y, y_stride, vectors, sum + a * columns, columns,
                   a + 1 < rows ? 2 : 1, total ? columns - a : columns, fused);
}

static size_t closed_up(hpr_lanes *sum, size_t n)
{
    size_t count = 0;
    for (size_t a = 0; a < n; a++) {
        for (size_t b = 0; a + b < n; b++)
            sum[count++] = sum[a * n + b];
    }
    return count;
}

HPR_LANES_BODY void moments_body(const hpr_products *p, size_t count, const double *s, const double *t,
                                 const double *kernel, double *moment, size_t stride,
                                 hpr_sums_scratch *scratch, bool fused)
{
    const size_t n = (size_t)p->degree + 1, row = HPR_TABLE_POINTS;
    hpr_lanes *sum = scratch->sum;
    size_t functions = n * n;
    for (size_t k = 0; k < functions; k++)
        sum[k] = hpr_lanes_of(0);
    for (size_t begin = 0; begin < count; begin += HPR_TABLE_POINTS) {
        size_t left = hpr_lanes_padded(count - begin) / HPR_LANES;
        size_t vectors = left < HPR_TABLE_VECTORS ? left : HPR_TABLE_VECTORS;
        tables_body(p, vectors, s + begin, t + begin, kernel + begin, scratch, fused);
        square_body((const double *)scratch->x, row, (const double *)scratch->y, row, vectors, sum, n, n,
                    p->total, fused);
    }
    if (p->total)
        functions = closed_up(sum, n);
    for (size_t k = 0; k < functions; k += HPR_LANES) {
        hpr_lanes eight = sums_of(sum + k);
        for (size_t i = 0; i < HPR_LANES && k + i < functions; i++)
            moment[(k + i) * stride] = eight[i];
    }
}

/* What a tile of sums over inner points takes; sums and rows of the basis are so many doubles apart. */
typedef struct grid_sums {
    size_t points;
    const hpr_lanes *kernel;
    const double *basis;
    double *sum;
    size_t stride, basis_stride;
    bool wide;  /* each number of the basis stands eight times */
    bool fresh; /* the sums are 0 before */
} grid_sums;

/* sum of one eight of outer points; functions at most GRID_FUNCTIONS. (A single one would be fused number
 * by number by GCC 12.) */
HPR_LANES_BODY void grid_tile(const grid_sums *g, int functions, bool fused)
{
    hpr_lanes sum[GRID_FUNCTIONS];
    const double *basis = g->basis;
#pragma GCC unroll 8
    for (int l = 0; l < functions; l++)
        sum[l] = g->fresh ? hpr_lanes_of(0) : hpr_lanes_load(g->sum + (size_t)l * g->stride);
    for (size_t j = 0; j < g->points; j++, basis += g->wide ? HPR_LANES : 1) {
        hpr_lanes kernel = g->kernel[j];
#pragma GCC unroll 8
        for (int l = 0; l < functions; l++) {
            const double *at = basis + (size_t)l * g->basis_stride;
            sum[l] = hpr_lanes_madd(fused && functions > 1, kernel,
                                    g->wide ? hpr_lanes_load(at) : hpr_lanes_of(*at), sum[l]);
        }
    }
#pragma GCC unroll 8
    for (int l = 0; l < functions; l++)
        hpr_lanes_store(g->sum + (size_t)l * g->stride, sum[l]);
}

#define GRID_TILE(count)                                                                                     \
    case count:                                                                                              \
        grid_tile(g, count, fused);                                                                          \
        return

HPR_LANES_BODY void grid_tile_of(const grid_sums *g, int functions, bool fused)
{
    switch (functions) {
        GRID_TILE(1);
        GRID_TILE(2);
        GRID_TILE(3);
        GRID_TILE(4);
        GRID_TILE(5);
        GRID_TILE(6);
        GRID_TILE(7);
        GRID_TILE(8);
    }
}

/* sum[l] += the products of kernels and row l of the basis, all functions. */
HPR_LANES_BODY void grid_tiles(grid_sums g, size_t functions, bool fused)
{
    size_t tiles = (functions + GRID_FUNCTIONS - 1) / GRID_FUNCTIONS;
    for (size_t k = 0, done = 0; k < tiles; k++) {
        size_t width = (functions - done) / (tiles - k);
        grid_tile_of(&g, (int)width, fused);
        g.basis += width * g.basis_stride;
        g.sum += width * g.stride;
        done += width;
    }
}

/* Eight outer points. */
typedef struct eight {
    hpr_lanes x, y, z, weight;
} eight;

HPR_LANES_BODY eight eight_of(const hpr_points *points, size_t first, double scale)
{
    return (eight){hpr_lanes_load(points->x + first), hpr_lanes_load(points->y + first),
                   hpr_lanes_load(points->z + first),
                   hpr_lanes_of(scale) * hpr_lanes_load(points->weight + first)};
}

/* |y - x|^2 of one inner point from eight outer ones */
HPR_LANES_BODY hpr_lanes squared_distance(const hpr_points *inner, size_t at, const eight *o, bool fused)
{
    hpr_lanes dx = hpr_lanes_of(inner->x[at]) - o->x, dy = hpr_lanes_of(inner->y[at]) - o->y,
              dz = hpr_lanes_of(inner->z[at]) - o->z;
    return hpr_lanes_madd(fused, dx, dx, hpr_lanes_madd(fused, dy, dy, dz * dz));
}

/*
 * Kernels from eight outer points to inner ones from `start` on, and those of the last one again up to the
 * end of the last four. One division serves four: it costs more than all else. The product of four r^2 runs
 * over no sooner than that of two r^4.
 */
HPR_LANES_BODY void kernels_body(const eight *o, const hpr_points *inner, size_t start, size_t points,
                                 hpr_lanes *kernel, bool fused)
{
    for (size_t j = 0; j < points; j += 4) {
        hpr_lanes r2[4], inverse[4];
        size_t at[4];
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++) {
            at[k] = start + (j + k < points ? j + k : points - 1);
            r2[k] = squared_distance(inner, at[k], o, fused);
        }
        hpr_lanes ab = r2[0] * r2[1], cd = r2[2] * r2[3], share = hpr_lanes_of(1) / (ab * cd);
        hpr_lanes of_ab = share * cd, of_cd = share * ab;
        inverse[0] = of_ab * r2[1];
        inverse[1] = of_ab * r2[0];
        inverse[2] = of_cd * r2[3];
        inverse[3] = of_cd * r2[2];
#pragma GCC unroll 4
        for (size_t k = 0; k < 4; k++)
            kernel[j + k] = inverse[k] * inverse[k] * (o->weight * hpr_lanes_of(inner->weight[at[k]]));
    }
}

HPR_LANES_BODY size_t rows_end(const hpr_points *outer, size_t first)
{
    return (size_t)outer->count < first + HPR_ROWS ? (size_t)outer->count : first + HPR_ROWS;
}

HPR_LANES_BODY void grid_body(const hpr_points *outer, size_t first, const hpr_points *inner, size_t start,
                              double scale, size_t functions, const double *basis, double *moment,
                              hpr_sums_scratch *scratch, bool fused)
{
    size_t left = (size_t)inner->count - start, points = left < HPR_TABLE_POINTS ? left : HPR_TABLE_POINTS;
    for (size_t i = first; i < rows_end(outer, first); i += HPR_LANES) {
        const eight o = eight_of(outer, i, scale);
        kernels_body(&o, inner, start, points, scratch->kernel, fused);
        const grid_sums g = {points,   scratch->kernel,  basis, moment + (i - first),
                             HPR_ROWS, HPR_TABLE_POINTS, false, false};
        grid_tiles(g, functions, fused);
    }
}

/* Place of the product X_a Y_b among an element's functions. */
HPR_LANES_BODY size_t function_of(const hpr_factors *f, size_t a, size_t b)
{
    size_t d = a + b;
    return f->total ? d * (d + 1) / 2 + b : a * ((size_t)f->degree + 1) + b;
}

/* How many Y_b go with X_a. */
HPR_LANES_BODY size_t second_count(const hpr_factors *f, size_t a)
{
    return (size_t)f->degree + 1 - (f->total ? a : 0);
}

/* Sums along the first axis of `rows` rows of nodes, into scratch->x [degree + 1][rows]. */
HPR_LANES_BODY void along_first(const hpr_factors *f, size_t rows, hpr_sums_scratch *scratch, bool fused)
{
    const size_t functions = (size_t)f->degree + 1;
    for (size_t j = 0; j < rows; j++) {
        const grid_sums g = {
            f->nodes[0],      scratch->kernel + j * f->nodes[0], f->wide_first, (double *)&scratch->x[0][j],
            HPR_TABLE_POINTS, f->nodes[0] * HPR_LANES,           true,          true};
        grid_tiles(g, functions, fused);
    }
}

/* Of those sums, of rows from j on, sums along the second axis, in order of a, then b. */
HPR_LANES_BODY void along_second(const hpr_factors *f, size_t j, size_t rows, hpr_sums_scratch *scratch,
                                 bool fused)
{
    const double *second = f->wide_second + j * HPR_LANES;
    hpr_lanes *sum = scratch->sum;
    for (size_t a = 0; a <= (size_t)f->degree; a++) {
        size_t count = second_count(f, a);
        const grid_sums g = {rows,      scratch->x[a],           second, (double *)sum,
                             HPR_LANES, f->nodes[1] * HPR_LANES, true,   j == 0};
        grid_tiles(g, count, fused);
        sum += count;
        second += f->total ? count * f->nodes[1] * HPR_LANES : 0;
    }
}

/* Each number of the rows eight times. */
HPR_LANES_BODY void widen(const double *row, size_t rows, size_t count, double *wide)
{
    for (size_t k = 0; k < rows; k++, row += HPR_FACTOR_POINTS) {
        for (size_t i = 0; i < count; i++, wide += HPR_LANES)
            hpr_lanes_store(wide, hpr_lanes_of(row[i]));
    }
}

HPR_LANES_BODY void factored_body(const hpr_points *outer, size_t first, const hpr_points *inner,
                                  const hpr_factors *f, double scale, double *moment,
                                  hpr_sums_scratch *scratch, bool fused)
{
    const size_t functions = (size_t)f->degree + 1, fit = HPR_TABLE_POINTS / f->nodes[0],
                 most = fit < HPR_TABLE_VECTORS ? fit : HPR_TABLE_VECTORS;
    widen(f->first, functions, f->nodes[0], f->wide_first);
    widen(f->second, f->total ? functions * (functions + 1) / 2 : functions, f->nodes[1], f->wide_second);
    for (size_t i = first; i < rows_end(outer, first); i += HPR_LANES) {
        const eight o = eight_of(outer, i, scale);
        const hpr_lanes *sum = scratch->sum;
        for (size_t j = 0; j < f->nodes[1]; j += most) {
            size_t rows = f->nodes[1] - j < most ? f->nodes[1] - j : most;
            kernels_body(&o, inner, j * f->nodes[0], rows * f->nodes[0], scratch->kernel, fused);
            along_first(f, rows, scratch, fused);
            along_second(f, j, rows, scratch, fused);
        }
        for (size_t a = 0; a < functions; a++) {
            for (size_t b = 0; b < second_count(f, a); b++)
                hpr_lanes_store(moment + function_of(f, a, b) * HPR_ROWS + (i - first), *sum++);
        }
    }
}

/* table[k][point] = phi_k of the points of a grid. */
HPR_LANES_BODY void spread_body(const hpr_factors *f, double *table)
{
    const size_t n0 = f->nodes[0], n1 = f->nodes[1], last = hpr_lanes_padded(n0 * n1) - HPR_LANES;
    const double *second = f->second;
    for (size_t a = 0; a <= (size_t)f->degree; a++) {
        const double *in_first = f->first + a * HPR_FACTOR_POINTS;
        for (size_t b = 0; b < second_count(f, a); b++) {
            const double *in_second = second + b * HPR_FACTOR_POINTS;
            double *row = table + function_of(f, a, b) * HPR_ROWS;
            hpr_lanes_store(row + last, hpr_lanes_of(0));
            for (size_t j = 0; j < n1; j++) {
                for (size_t i = 0; i < n0; i += HPR_LANES)
                    hpr_lanes_store(row + j * n0 + i,
                                    hpr_lanes_of(in_second[j]) * hpr_lanes_load(in_first + i));
            }
        }
        second += f->total ? second_count(f, a) * HPR_FACTOR_POINTS : 0;
    }
}

/* Two left rows and all right ones at a time. */
HPR_LANES_BODY void rows_body(const hpr_row_product *p, double *to, hpr_sums_scratch *scratch, bool fused)
{
    hpr_lanes *sum = scratch->sum;
    for (size_t k = 0; k < p->left_count; k += TILE_ROWS) {
        size_t rows = k + 1 < p->left_count ? TILE_ROWS : 1, count = rows * p->right_count;
        for (size_t i = 0; i < count; i++)
            sum[i] = hpr_lanes_of(0);
        square_body(p->left + k * p->left_stride, p->left_stride, p->right, p->right_stride, p->vectors, sum,
                    rows, p->right_count, false, fused);
        for (size_t i = 0; i < count; i += HPR_LANES) {
            hpr_lanes some = sums_of(sum + i);
            double *at = to + k * p->right_count + i;
            if (i + HPR_LANES <= count) {
                hpr_lanes_store(at, hpr_lanes_load(at) + some);
                continue;
            }
            for (size_t q = 0; i + q < count; q++)
                at[q] += some[q];
        }
    }
}

/* exp of |x| < 700: Taylor's series, after the nearest multiple of ln 2, of which the product with an integer
 * is exact but for a small part, is taken out. Within 2 ulp. */
HPR_LANES_BODY hpr_lanes exponential(hpr_lanes x, bool fused)
{
    static const double inverse_factorial[] = {1.0 / 6227020800,
                                               1.0 / 479001600,
                                               1.0 / 39916800,
                                               1.0 / 3628800,
                                               1.0 / 362880,
                                               1.0 / 40320,
                                               1.0 / 5040,
                                               1.0 / 720,
                                               1.0 / 120,
                                               1.0 / 24,
                                               1.0 / 6,
                                               0.5,
                                               1,
                                               1};
    static const double to_integer = 0x1.8p52, per_octave = 0x1.71547652b82fep0,
                        octave = 0x1.62e42fee00000p-1, rest = 0x1.a39ef35793c76p-33;
    hpr_lanes shifted = x * hpr_lanes_of(per_octave) + hpr_lanes_of(to_integer);
    hpr_lanes n = shifted - hpr_lanes_of(to_integer);
    hpr_lanes r = (x - n * hpr_lanes_of(octave)) - n * hpr_lanes_of(rest);
    hpr_lanes sum = hpr_lanes_of(inverse_factorial[0]);
#pragma GCC unroll 16
    for (int k = 1; k < 14; k++)
        sum = hpr_lanes_madd(fused, sum, r, hpr_lanes_of(inverse_factorial[k]));
    return (hpr_lanes)((hpr_lanes_bits)sum + ((hpr_lanes_bits)shifted << 52));
}

HPR_LANES_BODY void hyperbolic_body(double low, double width, const double *node, size_t count, double *sine,
                                    double *cosine, bool fused)
{
    for (size_t i = 0; i < count; i += HPR_LANES) {
        hpr_lanes x = hpr_lanes_madd(fused, hpr_lanes_of(width), hpr_lanes_load(node + i), hpr_lanes_of(low));
        hpr_lanes up = hpr_lanes_of(0.5) * exponential(x, fused), down = hpr_lanes_of(0.25) / up;
        hpr_lanes_store(sine + i, up - down);
        hpr_lanes_store(cosine + i, up + down);
    }
}

HPR_LANES_BODY hpr_lanes greater(hpr_lanes a, hpr_lanes b)
{
    const hpr_lanes_bits first = a > b;
    return (hpr_lanes)(((hpr_lanes_bits)a & first) | ((hpr_lanes_bits)b & ~first));
}

HPR_LANES_BODY double largest_body(const double *entry, size_t count)
{
    hpr_lanes most = hpr_lanes_of(0);
    size_t i = 0;
    double all = 0;
    for (; i + HPR_LANES <= count; i += HPR_LANES) {
        hpr_lanes some = hpr_lanes_load(entry + i);
        most = greater(greater(some, -some), most);
    }
    for (size_t k = 0; k < HPR_LANES; k++)
        all = most[k] > all ? most[k] : all;
    for (; i < count; i++) {
        double size = entry[i] < 0 ? -entry[i] : entry[i];
        all = size > all ? size : all;
    }
    return all;
}

HPR_LANES_BODY void line_body(const hpr_point_line *line, hpr_points *points, bool fused)
{
    size_t first = (size_t)points->count;
    double *const to[5] = {points->s + first, points->t + first, points->x + first, points->y + first,
                           points->z + first};
    for (size_t i = 0; i < line->count; i += HPR_LANES) {
        hpr_lanes u = hpr_lanes_load(line->u + i);
#pragma GCC unroll 8
        for (int k = 0; k < 5; k++)
            hpr_lanes_store(to[k] + i,
                            hpr_lanes_madd(fused, u, hpr_lanes_of(line->by[k]), hpr_lanes_of(line->at[k])));
        hpr_lanes height = hpr_lanes_madd(fused, u, hpr_lanes_of(line->by[5]), hpr_lanes_of(line->at[5]));
        hpr_lanes_store(points->weight + first + i, hpr_lanes_of(line->scale) *
                                                        hpr_lanes_load(line->weight + i) *
                                                        greater(height, hpr_lanes_of(line->least)));
    }
    points->count += (int)line->count;
}

/* The same functions for each instruction set. */
#define SUMS_ON(isa, target, fused)                                                                          \
    target static void kernel_##isa(const hpr_points *from, size_t i, const hpr_points *to, double scale,    \
                                    double *kernel)                                                          \
    {                                                                                                        \
        kernel_body(from, i, to, scale, kernel, fused);                                                      \
    }                                                                                                        \
                                                                                                             \
    target static void moments_##isa(const hpr_products *products, size_t count, const double *s,            \
                                     const double *t, const double *kernel, double *moment, size_t stride,   \
                                     hpr_sums_scratch *scratch)                                              \
    {                                                                                                        \
        moments_body(products, count, s, t, kernel, moment, stride, scratch, fused);                         \
    }                                                                                                        \
                                                                                                             \
    target static void grid_##isa(const hpr_points *outer, size_t first, const hpr_points *inner,            \
                                  size_t start, double scale, size_t functions, const double *basis,         \
                                  double *moment, hpr_sums_scratch *scratch)                                 \
    {                                                                                                        \
        grid_body(outer, first, inner, start, scale, functions, basis, moment, scratch, fused);              \
    }                                                                                                        \
                                                                                                             \
    target static void factored_##isa(const hpr_points *outer, size_t first, const hpr_points *inner,        \
                                      const hpr_factors *factors, double scale, double *moment,              \
                                      hpr_sums_scratch *scratch)                                             \
    {                                                                                                        \
        factored_body(outer, first, inner, factors, scale, moment, scratch, fused);                          \
    }                                                                                                        \
                                                                                                             \
    target static void spread_##isa(const hpr_factors *factors, double *table)                               \
    {                                                                                                        \
        spread_body(factors, table);                                                                         \
    }                                                                                                        \
                                                                                                             \
    target static void rows_##isa(const hpr_row_product *product, double *to, hpr_sums_scratch *scratch)     \
    {                                                                                                        \
        rows_body(product, to, scratch, fused);                                                              \
    }                                                                                                        \
                                                                                                             \
    target static double largest_##isa(const double *entry, size_t count)                                    \
    {                                                                                                        \
        return largest_body(entry, count);                                                                   \
    }                                                                                                        \
                                                                                                             \
    target static void line_##isa(const hpr_point_line *line, hpr_points *points)                            \
    {                                                                                                        \
        line_body(line, points, fused);                                                                      \
    }                                                                                                        \
                                                                                                             \
    target static void hyperbolic_##isa(double low, double width, const double *node, size_t count,          \
                                        double *sine, double *cosine)                                        \
    {                                                                                                        \
        hyperbolic_body(low, width, node, count, sine, cosine, fused);                                       \
    }                                                                                                        \
                                                                                                             \
    static const hpr_sums sums_##isa = {kernel_##isa,   moments_##isa, grid_##isa,                           \
                                        factored_##isa, spread_##isa,  rows_##isa,                           \
                                        line_##isa,     largest_##isa, hyperbolic_##isa};

SUMS_ON(sse2, , false)
SUMS_ON(avx2, HPR_TARGET_AVX2, true)
SUMS_ON(avx512, HPR_TARGET_AVX512, true)

const hpr_sums *hpr_sums_of(hpr_isa isa)
{
    static const hpr_sums *const sums[] = {
        [HPR_ISA_SSE2] = &sums_sse2, [HPR_ISA_AVX2] = &sums_avx2, [HPR_ISA_AVX512] = &sums_avx512};
    return sums[isa];
}
