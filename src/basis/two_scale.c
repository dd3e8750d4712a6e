#include "basis/two_scale.h"

#include "math/gauss.h"

enum { LINE = HPR_MAX_DEGREE + 1 };

struct hpr_two_scale {
    hpr_context *context;
    int max_degree;
    size_t triangle_count;      /* functions of max_degree on a triangle */
    double line[2][LINE][LINE]; /* [which][whole][half], 0 for half > whole */
    double *triangle;           /* [which][whole][half] */
};

static const double half_root = 0.70710678118654752440; /* of the area: T of a half is sqrt 2 as large */

static void fill_line(hpr_two_scale *tables, const hpr_gauss_rule *rule, int nodes)
{
    for (int which = 0; which < 2; which++) {
        for (int i = 0; i < nodes; i++) {
            /* Along one axis: the first row of the tensor basis at t = 1/2 is p_n(s) p_0. */
            double whole[HPR_MAX_BASIS], half[HPR_MAX_BASIS];
            int degree = tables->max_degree;
            hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, degree, (rule->node[i] + which) / 2, 0.5, whole);
            hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, degree, rule->node[i], 0.5, half);
            for (int n = 0; n <= degree; n++) {
                for (int m = 0; m <= n; m++)
                    tables->line[which][n][m] +=
                        half_root * rule->weight[i] * whole[n * (degree + 1)] * half[m * (degree + 1)];
            }
        }
    }
}

/* The point of the whole that the point (s,t) of a half is (patch/elements.h). */
static void whole_point(int which, double s, double t, double point[2])
{
    double sum = which ? 1 - s - t : 1 - s + t, rest = which ? 1 + s - t : 1 - s - t;
    point[0] = sum / 2;
    point[1] = rest / 2;
}

static void add_triangle_node(hpr_two_scale *tables, int which, double s, double t, double weight)
{
    double whole[HPR_MAX_BASIS], half[HPR_MAX_BASIS], point[2];
    size_t n = tables->triangle_count;
    double *m = tables->triangle + (size_t)which * n * n;
    whole_point(which, s, t, point);
    hpr_basis_eval(HPR_SHAPE_TRIANGLE, tables->max_degree, point[0], point[1], whole);
    hpr_basis_eval(HPR_SHAPE_TRIANGLE, tables->max_degree, s, t, half);
    for (size_t k = 0; k < n; k++) {
        for (size_t l = 0; l < n; l++)
            m[k * n + l] += half_root * weight * whole[k] * half[l];
    }
}

static void fill_triangle(hpr_two_scale *tables, const hpr_gauss_table *gauss, int nodes)
{
    const hpr_gauss_rule *first = &gauss->legendre[nodes], *second = &gauss->jacobi[nodes];
    for (int which = 0; which < 2; which++) {
        for (int j = 0; j < nodes; j++) {
            for (int i = 0; i < nodes; i++) {
                double t = second->node[j], s = first->node[i] * (1 - t);
                add_triangle_node(tables, which, s, t, first->weight[i] * second->weight[j]);
            }
        }
    }
}

hpr_status hpr_two_scale_create(hpr_context *ctx, int max_degree, hpr_two_scale **out)
{
    hpr_two_scale *tables = NULL;
    hpr_gauss_table *gauss = NULL;
    hpr_status status = hpr_allocate_into(ctx, &tables, 1, sizeof *tables, "two-scale relations");
    if (status == HPR_OK) {
        tables->context = ctx;
        tables->max_degree = max_degree;
        tables->triangle_count = hpr_basis_count(HPR_SHAPE_TRIANGLE, max_degree);
        status =
            hpr_allocate_into(ctx, &tables->triangle, 2 * tables->triangle_count * tables->triangle_count,
                              sizeof(double), "two-scale relations");
    }
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &gauss, 1, sizeof *gauss, "two-scale relations");
    if (status == HPR_OK) {
        hpr_gauss_table_init(gauss);
        fill_line(tables, &gauss->legendre[max_degree + 1], max_degree + 1);
        fill_triangle(tables, gauss, max_degree + 1);
    } else {
        hpr_two_scale_destroy(&tables);
    }
    hpr_release(ctx, gauss);
    *out = tables;
    return status;
}

void hpr_two_scale_destroy(hpr_two_scale **out)
{
    hpr_two_scale *tables = *out;
    if (!tables)
        return;
    hpr_context *ctx = tables->context;
    hpr_release(ctx, tables->triangle);
    hpr_release(ctx, tables);
    *out = NULL;
}

/* Functions of the whole and of the half: `along` the halved axis, and their distances in memory along it and
 * across. */
typedef struct layout {
    int along, stride, across;
} layout;

static layout tensor_layout(int axis, int degree)
{
    int n = degree + 1;
    return axis == 0 ? (layout){n, n, 1} : (layout){n, 1, n};
}

/* to += M from, M the matrix from whole to half or, with `up`, its transpose. */
static void apply_tensor(const hpr_two_scale *tables, const hpr_half *half, bool up, const double *from,
                         double *to)
{
    layout w = tensor_layout(half->axis, half->whole_degree),
           h = tensor_layout(half->axis, half->half_degree);
    layout source = up ? h : w, target = up ? w : h;
    int both = w.along < h.along ? w.along : h.along;
    for (int n = 0; n < w.along; n++) {
        const double *row = tables->line[half->which][n];
        for (int m = 0; m <= n && m < h.along; m++) {
            const double *x = from + (up ? m : n) * source.stride;
            double *y = to + (up ? n : m) * target.stride;
            for (int b = 0; b < both; b++)
                y[b * target.across] += row[m] * x[b * source.across];
        }
    }
}

static void apply_triangle(const hpr_two_scale *tables, const hpr_half *half, bool up, const double *from,
                           double *to)
{
    size_t n = tables->triangle_count, rows = hpr_basis_count(half->shape, half->whole_degree),
           columns = hpr_basis_count(half->shape, half->half_degree);
    for (size_t k = 0; k < rows; k++) {
        const double *row = tables->triangle + ((size_t)half->which * n + k) * n;
        for (size_t l = 0; l < columns; l++)
            to[up ? k : l] += row[l] * from[up ? l : k];
    }
}

void hpr_two_scale_pull(const hpr_two_scale *tables, const hpr_half *half, const double *from, double *whole)
{
    if (half->shape == HPR_SHAPE_PARALLELOGRAM)
        apply_tensor(tables, half, true, from, whole);
    else
        apply_triangle(tables, half, true, from, whole);
}

void hpr_two_scale_push(const hpr_two_scale *tables, const hpr_half *half, const double *from, double *to)
{
    if (half->shape == HPR_SHAPE_PARALLELOGRAM)
        apply_tensor(tables, half, false, from, to);
    else
        apply_triangle(tables, half, false, from, to);
}
