#include "quadrature/far.h"

#include "math/gauss.h"
#include "math/lanes.h"
#include "math/planar_basis.h"

#include <string.h>

/* Product Gauss on one shape for one degree. */
typedef struct node_set {
    size_t point_count, basis_count;
    double *s, *t, *weight; /* [points] in parameter measure */
    double *phi;            /* [points][functions] weight times phi_k */
} node_set;

struct hpr_far {
    hpr_context *context;
    node_set set[2][HPR_MAX_DEGREE + 1]; /* [shape][degree]; those of a quadrilateral are its own */
    double *memory;
};

enum { EXTRA_NODES = 2 };

static size_t axis_nodes(int degree)
{
    return (size_t)degree + EXTRA_NODES;
}

static size_t set_size(hpr_shape shape, int degree)
{
    return axis_nodes(degree) * axis_nodes(degree) * (3 + hpr_basis_count(shape, degree));
}

/* Triangles in collapsed coordinates (Stroud 1971). */
static void fill_set(hpr_shape shape, int degree, node_set *set, double *memory)
{
    size_t n = axis_nodes(degree);
    bool triangle = shape == HPR_SHAPE_TRIANGLE;
    const hpr_gauss_rule *first = &hpr_gauss.legendre[n], *second = triangle ? &hpr_gauss.jacobi[n] : first;
    set->point_count = n * n;
    set->basis_count = hpr_basis_count(shape, degree);
    set->s = memory;
    set->t = set->s + n * n;
    set->weight = set->t + n * n;
    set->phi = set->weight + n * n;
    for (size_t p = 0; p < n * n; p++) {
        double *phi = set->phi + p * set->basis_count;
        set->t[p] = second->node[p / n];
        set->s[p] = first->node[p % n] * (triangle ? 1 - set->t[p] : 1);
        set->weight[p] = first->weight[p % n] * second->weight[p / n];
        hpr_basis_eval(shape, degree, set->s[p], set->t[p], phi);
        for (size_t k = 0; k < set->basis_count; k++)
            phi[k] *= set->weight[p];
    }
}

hpr_status hpr_far_create(hpr_context *ctx, int max_degree, hpr_far **out)
{
    static const hpr_shape shapes[2] = {HPR_SHAPE_PARALLELOGRAM, HPR_SHAPE_TRIANGLE};
    hpr_far *tables = NULL;
    size_t size = 0;
    if (max_degree < HPR_FAR_NODES - EXTRA_NODES)
        max_degree = HPR_FAR_NODES - EXTRA_NODES;
    for (int degree = 0; degree <= max_degree; degree++)
        size += set_size(shapes[0], degree) + set_size(shapes[1], degree);
    hpr_status status = hpr_allocate_into(ctx, &tables, 1, sizeof *tables, "quadrature tables");
    if (status == HPR_OK) {
        tables->context = ctx;
        status = hpr_allocate_into(ctx, &tables->memory, size, sizeof(double), "quadrature tables");
    }
    if (status == HPR_OK) {
        double *memory = tables->memory;
        for (int i = 0; i < 2; i++) {
            for (int degree = 0; degree <= max_degree; degree++) {
                fill_set(shapes[i], degree, &tables->set[shapes[i]][degree], memory);
                memory += set_size(shapes[i], degree);
            }
        }
    } else {
        hpr_far_destroy(&tables);
    }
    *out = tables;
    return status;
}

void hpr_far_destroy(hpr_far **out)
{
    hpr_far *tables = *out;
    if (!tables)
        return;
    hpr_context *ctx = tables->context;
    hpr_release(ctx, tables->memory);
    hpr_release(ctx, tables);
    *out = NULL;
}

hpr_isa hpr_far_isa(const hpr_far *tables)
{
    return hpr_context_isa_level(tables->context);
}

hpr_far_rule hpr_far_nodes(const hpr_far *tables, hpr_shape shape, int nodes)
{
    const node_set *set = &tables->set[shape][nodes - EXTRA_NODES];
    return (hpr_far_rule){set->point_count, set->s, set->t, set->weight};
}

/* Corners, then the centre. */
static int sample_points(const hpr_element_frame *frame, hpr_vec3 point[5])
{
    hpr_cell whole = hpr_cell_whole(frame);
    int count = hpr_cell_corners(frame, &whole, point);
    double middle[2];
    hpr_shape_middle(frame->shape, frame->opposite, middle);
    point[count] = hpr_frame_point(frame, middle[0], middle[1]);
    return count;
}

/* The smallest rho over the element's edges as segments. */
static double smallest_rho(const hpr_vec3 *own, int own_count, const hpr_vec3 *other, int other_count)
{
    double least = INFINITY;
    for (int i = 0; i < own_count; i++) {
        hpr_vec3 p = own[i], q = own[(i + 1) % own_count];
        double length = hpr_length(hpr_sub(p, q));
        for (int j = 0; j <= other_count; j++) {
            double a = (hpr_length(hpr_sub(other[j], p)) + hpr_length(hpr_sub(other[j], q))) / length;
            least = fmin(least, a);
        }
    }
    return least + sqrt(fmax(least * least - 1, 0));
}

/* Heights of points over a plane. Returns whether some lie on its front and some on its back, by more than
 * rounding; *front: some lie on its front. */
static bool heights(const hpr_element_frame *plane, const hpr_vec3 *point, int count, double slack,
                    double *height, bool *front)
{
    double least = INFINITY, largest = -INFINITY;
    for (int i = 0; i <= count; i++) {
        height[i] = hpr_dot(hpr_sub(point[i], plane->origin), plane->normal);
        least = fmin(least, height[i]);
        largest = fmax(largest, height[i]);
    }
    *front = largest > slack;
    return least < -slack && largest > slack;
}

hpr_far_view hpr_far_foretell(const hpr_element_frame *recv, const hpr_element_frame *send)
{
    static const double pi = 3.14159265358979323846, rounding = 1e-12;
    hpr_vec3 x[5], y[5];
    double x_height[5], y_height[5], largest = 0, nearest2 = INFINITY;
    int nx = sample_points(recv, x), ny = sample_points(send, y);
    double slack = rounding * sqrt(fmax(recv->area_m2, send->area_m2));
    bool x_front, y_front;
    hpr_far_view view = {.recv_rho = smallest_rho(x, nx, y, ny), .send_rho = smallest_rho(y, ny, x, nx)};
    view.recv_straddles = heights(send, x, nx, slack, x_height, &x_front);
    view.send_straddles = heights(recv, y, ny, slack, y_height, &y_front);
    view.hidden = !x_front || !y_front;
    for (int i = 0; i <= nx; i++) {
        for (int j = 0; j <= ny; j++) {
            hpr_vec3 d = hpr_sub(y[j], x[i]);
            double r2 = hpr_dot(d, d);
            nearest2 = fmin(nearest2, r2);
            if (x_height[i] > 0 && y_height[j] > 0)
                largest = fmax(largest, x_height[i] * y_height[j] / (r2 * r2));
        }
    }
    view.norm = nearest2 > slack * slack ? largest / pi * sqrt(recv->area_m2 * send->area_m2) : INFINITY;
    return view;
}

double hpr_far_left_out(double norm, double rho, int degree)
{
    static const double margin = 2;
    return margin * norm * pow(rho, -(degree + 1));
}

/* Points of one side in space, from an origin that both sides share. */
typedef struct side {
    const node_set *set;
    double *x, *y, *z, *height; /* [points]; height: over the other's plane */
    double factor;              /* sqrt of the measure's Jacobian: from parameters and phi to area and T */
} side;

static side place_points(const node_set *set, const hpr_element_frame *frame, const hpr_element_frame *other,
                         hpr_vec3 origin, double *memory)
{
    size_t n = set->point_count;
    side s = {set, memory, memory + n, memory + 2 * n, memory + 3 * n, 0};
    hpr_vec3 start = hpr_sub(frame->origin, origin), plane = hpr_sub(other->origin, origin);
    for (size_t p = 0; p < n; p++) {
        hpr_vec3 x = hpr_madd(hpr_madd(start, set->s[p], frame->edge1), set->t[p], frame->edge2);
        s.x[p] = x.x;
        s.y[p] = x.y;
        s.z[p] = x.z;
        s.height[p] = hpr_dot(hpr_sub(x, plane), other->normal);
    }
    s.factor = sqrt(hpr_frame_jacobian(frame));
    return s;
}

size_t hpr_far_scratch(void)
{
    size_t n = axis_nodes(HPR_MAX_DEGREE);
    return 9 * n * n + HPR_MAX_BASIS + 2 * set_size(HPR_SHAPE_QUADRILATERAL, HPR_MAX_DEGREE);
}

/* The nodes of an element: those of its shape, or made in `memory` [set_size]. */
static node_set set_of(const hpr_far *tables, const hpr_element_frame *frame, double *memory)
{
    if (frame->shape != HPR_SHAPE_QUADRILATERAL)
        return tables->set[frame->shape][frame->degree];
    size_t n = axis_nodes(frame->degree), points = n * n;
    node_set set = {points,
                    hpr_basis_count(frame->shape, frame->degree),
                    memory,
                    memory + points,
                    memory + 2 * points,
                    memory + 3 * points};
    for (size_t p = 0; p < points; p++) {
        hpr_planar_node node = hpr_planar_gauss(frame->opposite, &hpr_gauss.legendre[n], (int)n, (int)p);
        double *phi = set.phi + p * set.basis_count;
        set.s[p] = node.s;
        set.t[p] = node.t;
        set.weight[p] = node.weight;
        hpr_frame_basis(frame, node.s, node.t, phi);
        for (size_t k = 0; k < set.basis_count; k++)
            phi[k] *= node.weight;
    }
    return set;
}

/* One row of G, and the sum of the squares with weights. */
HPR_LANES_BODY double kernel_row(bool fused, const side *recv, size_t p, const side *send, double *kernel)
{
    const size_t count = send->set->point_count, whole = count - count % HPR_LANES;
    const double *weight = send->set->weight, at[4] = {recv->x[p], recv->y[p], recv->z[p], recv->height[p]};
    const hpr_lanes x = hpr_lanes_of(at[0]), y = hpr_lanes_of(at[1]), z = hpr_lanes_of(at[2]),
                    h = hpr_lanes_of(at[3]);
    hpr_lanes squares = hpr_lanes_of(0);
    for (size_t q = 0; q < whole; q += HPR_LANES) {
        hpr_lanes dx = hpr_lanes_load(send->x + q) - x, dy = hpr_lanes_load(send->y + q) - y,
                  dz = hpr_lanes_load(send->z + q) - z;
        hpr_lanes r2 = hpr_lanes_madd(fused, dx, dx, hpr_lanes_madd(fused, dy, dy, dz * dz));
        hpr_lanes k = h * hpr_lanes_load(send->height + q) / (r2 * r2);
        squares = hpr_lanes_madd(fused, hpr_lanes_load(weight + q) * k, k, squares);
        hpr_lanes_store(kernel + q, k);
    }
    double sum2 = 0;
    for (int k = 0; k < HPR_LANES; k++)
        sum2 += squares[k];
    for (size_t q = whole; q < count; q++) {
        double dx = send->x[q] - at[0], dy = send->y[q] - at[1], dz = send->z[q] - at[2];
        double r2 = dx * dx + dy * dy + dz * dz;
        kernel[q] = at[3] * send->height[q] / (r2 * r2);
        sum2 += weight[q] * kernel[q] * kernel[q];
    }
    return recv->set->weight[p] * sum2;
}

/* Sums of squares of G, G P_s and P_r G P_s. */
typedef struct squares {
    double all, sent, carried;
} squares;

/* block [rows][columns] = sum over the points of both; kernel, row: scratch for a row of points and of
 * functions */
HPR_LANES_BODY squares sum_body(bool fused, const side *r, const side *s, double *restrict block,
                                double *kernel, double *restrict row)
{
    const size_t rows = r->set->basis_count, columns = s->set->basis_count;
    squares sum = {0, 0, 0};
    memset(block, 0, rows * columns * sizeof *block);
    for (size_t p = 0; p < r->set->point_count; p++) {
        sum.all += kernel_row(fused, r, p, s, kernel);
        memset(row, 0, columns * sizeof *row);
        for (size_t q = 0; q < s->set->point_count; q++) {
            for (size_t l = 0; l < columns; l++)
                row[l] += kernel[q] * s->set->phi[q * columns + l];
        }
        for (size_t l = 0; l < columns; l++)
            sum.sent += r->set->weight[p] * row[l] * row[l];
        for (size_t k = 0; k < rows; k++) {
            for (size_t l = 0; l < columns; l++)
                block[k * columns + l] += r->set->phi[p * rows + k] * row[l];
        }
    }
    for (size_t i = 0; i < rows * columns; i++)
        sum.carried += block[i] * block[i];
    return sum;
}

static squares sum_sse2(const side *r, const side *s, double *block, double *kernel, double *row)
{
    return sum_body(false, r, s, block, kernel, row);
}

static HPR_TARGET_AVX2 squares sum_avx2(const side *r, const side *s, double *block, double *kernel,
                                        double *row)
{
    return sum_body(true, r, s, block, kernel, row);
}

static HPR_TARGET_AVX512 squares sum_avx512(const side *r, const side *s, double *block, double *kernel,
                                            double *row)
{
    return sum_body(true, r, s, block, kernel, row);
}

hpr_far_result hpr_far_block(const hpr_far *tables, const hpr_element_frame *recv,
                             const hpr_element_frame *send, double *block, double *scratch)
{
    static const double pi = 3.14159265358979323846;
    double *own_sets = scratch + 9 * axis_nodes(HPR_MAX_DEGREE) * axis_nodes(HPR_MAX_DEGREE) + HPR_MAX_BASIS;
    const node_set recv_nodes = set_of(tables, recv, own_sets);
    const node_set send_nodes =
        set_of(tables, send, own_sets + set_size(HPR_SHAPE_QUADRILATERAL, HPR_MAX_DEGREE));
    const node_set *recv_set = &recv_nodes, *send_set = &send_nodes;
    double *next = scratch;
    side r = place_points(recv_set, recv, send, recv->origin, next);
    next += 4 * recv_set->point_count;
    side s = place_points(send_set, send, recv, recv->origin, next);
    next += 4 * send_set->point_count;
    double *kernel = next, *row = next + send_set->point_count;
    static squares (*const sum_of[])(const side *, const side *, double *, double *, double *) = {
        [HPR_ISA_SSE2] = sum_sse2, [HPR_ISA_AVX2] = sum_avx2, [HPR_ISA_AVX512] = sum_avx512};
    const squares sum = sum_of[hpr_context_isa_level(tables->context)](&r, &s, block, kernel, row);
    double factor = r.factor * s.factor / pi;
    for (size_t i = 0; i < recv_set->basis_count * send_set->basis_count; i++)
        block[i] *= factor;
    return (hpr_far_result){.norm = factor * sqrt(sum.all),
                            .recv_error = factor * sqrt(fmax(sum.sent - sum.carried, 0)),
                            .send_error = factor * sqrt(fmax(sum.all - sum.sent, 0)),
                            .kernel_count = recv_set->point_count * send_set->point_count};
}
