#include "quadrature/aligned.h"

#include "quadrature/polar.h"

#include <float.h>
#include <string.h>

enum { MAX_DEPTH = 60, MAX_CELLS = 5000 };

/* Edge `which` of an element. */
static hpr_vec3 edge_of(const hpr_element_frame *frame, int which)
{
    return which ? frame->edge2 : frame->edge1;
}

/* b without its part along e, that part in units of e being *part. */
static hpr_vec3 across(hpr_vec3 b, hpr_vec3 e, double *part)
{
    *part = hpr_dot(b, e) / hpr_dot(e, e);
    return hpr_madd(b, -*part, e);
}

/* The part of [0, 1] on which start + slope * x > 0. */
static void front_range(double start, double slope, double range[2])
{
    range[0] = start >= 0 ? 0 : slope > 0 ? -start / slope : 1;
    range[1] = start + slope >= 0 ? 1 : slope < 0 ? -start / slope : 0;
}

/* The two edges that agree best in direction; returns how far an end of the sender's is off. */
static double best_edges(const hpr_pair *pair, hpr_aligned *a)
{
    double least = INFINITY, part;
    for (int i = 0; i < 4; i++) {
        hpr_vec3 e = edge_of(&pair->recv, i / 2), f = edge_of(&pair->send, i % 2);
        double aside = hpr_length(across(f, e, &part));
        if (aside < least) {
            least = aside;
            a->recv_edge = i / 2;
            a->send_edge = i % 2;
        }
    }
    return least;
}

/* Height over the other's plane where the common direction is gone through halfway: at 0, and per coordinate
 * across. */
static void across_height(const hpr_affine *height, int edge, double of[2])
{
    of[0] = height->at_origin + (edge ? height->along2 : height->along1) / 2;
    of[1] = edge ? height->along1 : height->along2;
}

static double frames_distance(const hpr_pair *pair)
{
    hpr_cell whole[2] = {hpr_cell_whole(&pair->recv), hpr_cell_whole(&pair->send)};
    hpr_vec3 a[4], b[4];
    int na = hpr_cell_corners(&pair->recv, &whole[0], a), nb = hpr_cell_corners(&pair->send, &whole[1], b);
    return hpr_polygon_distance(a, na, b, nb);
}

bool hpr_aligned_find(const hpr_pair *pair, double tolerance, hpr_aligned *a)
{
    static const double share = 0.05, rounding = 4 * DBL_EPSILON;
    const hpr_element_frame *recv = &pair->recv, *send = &pair->send;
    if (recv->shape != HPR_SHAPE_PARALLELOGRAM || send->shape != HPR_SHAPE_PARALLELOGRAM)
        return false;
    double moved = best_edges(pair, a), part, middle, height[2];
    double known = rounding * (hpr_length(recv->edge1) + hpr_length(recv->edge2) + hpr_length(send->edge1) +
                               hpr_length(send->edge2) + hpr_length(send->origin));
    if (moved > known && moved > share * tolerance * frames_distance(pair))
        return false;
    hpr_vec3 e = edge_of(recv, a->recv_edge), f = edge_of(send, a->send_edge);
    a->unit = hpr_length(e);
    across(f, e, &part);
    hpr_vec3 offset = across(hpr_madd(send->origin, 0.5, f), e, &middle);
    a->along = (hpr_overlap){middle - fabs(part) / 2, fabs(part), part < 0};
    a->offset = hpr_scale(offset, 1 / a->unit);
    a->recv_across = hpr_scale(across(edge_of(recv, !a->recv_edge), e, &a->recv_slant), 1 / a->unit);
    a->send_across = hpr_scale(across(edge_of(send, !a->send_edge), e, &a->send_slant), 1 / a->unit);
    across_height(&pair->recv_height, a->recv_edge, height);
    front_range(height[0], height[1], a->recv_range);
    across_height(&pair->send_height, a->send_edge, height);
    front_range(height[0], height[1], a->send_range);
    return true;
}

typedef struct integral {
    const hpr_gauss_table *gauss;
    const hpr_aligned *aligned;
    double recv_height[2], send_height[2];
    double tolerance, factor;
    int n_recv, n_send, functions, degree[2], cap;
    int span_count;
    hpr_span span[3];
    hpr_correlation correlation[3];
    double *moment; /* [3][functions] */
    double *values; /* [functions][HPR_NODES_MAX] of P_a at nodes */
    double *row;    /* [n_recv n_send] integral over d */
    double *rows;   /* [n_send][n_recv n_send] that, times p(w), over w */
    double *part;
    int cells;
    bool complete;
    uint64_t kernels;
    /* of the moments that are being summed */
    double square, middle, half; /* q^2; the span's middle and half of its length */
    double *to;
} integral;

static const double pi = 3.14159265358979323846;

/* The moments at so many places d. */
static void add_places(void *user, int count, const double *place, const double *weight)
{
    integral *it = user;
    double kernel[HPR_NODES_MAX], xi[HPR_NODES_MAX],
        (*p)[HPR_NODES_MAX] = (double(*)[HPR_NODES_MAX])it->values;
    for (int j = 0; j < count; j++) {
        double r2 = place[j] * place[j] + it->square;
        kernel[j] = weight[j] / (r2 * r2);
        xi[j] = (place[j] - it->middle) / it->half;
        p[0][j] = 1;
        p[1][j] = xi[j];
    }
    for (int a = 1; a + 1 < it->functions; a++) {
        double up = (2 * a + 1.0) / (a + 1), down = a / (a + 1.0);
        for (int j = 0; j < count; j++)
            p[a + 1][j] = up * xi[j] * p[a][j] - down * p[a - 1][j];
    }
    for (int a = 0; a < it->functions; a++) {
        double sum = 0;
        for (int j = 0; j < count; j++)
            sum += kernel[j] * p[a][j];
        it->to[a] += sum;
    }
    it->kernels += (uint64_t)count;
}

/* ∫ P_a / (d^2 + q^2)^2 from `low` to `high`. */
static void span_moments(integral *it, double low, double high, double *moment)
{
    enum { CAP = 10 };
    double length = high - low, gap = low > 0 ? low : high < 0 ? -high : 0;
    int nodes = hpr_kernel_nodes(length, sqrt(it->square + gap * gap), it->tolerance);
    it->middle = low + length / 2;
    it->half = length / 2;
    it->to = moment;
    memset(moment, 0, (size_t)it->functions * sizeof *moment);
    if (nodes > CAP) {
        const hpr_line line = {.gauss = it->gauss,
                               .isa = HPR_ISA_SSE2,
                               .distance = sqrt(it->square),
                               .begin = low,
                               .end = high,
                               .tolerance = it->tolerance,
                               .degree = it->functions - 1};
        hpr_polar_line(&line, add_places, it);
        return;
    }
    double place[HPR_NODES_MAX], weight[HPR_NODES_MAX];
    const hpr_gauss_rule *gauss = &it->gauss->legendre[nodes + it->functions / 2];
    for (int j = 0; j < nodes + it->functions / 2; j++) {
        place[j] = low + length * gauss->node[j];
        weight[j] = length * gauss->weight[j];
    }
    add_places(it, nodes + it->functions / 2, place, weight);
}

/* row = the integral over d at v and w, of all pairs of functions along it. */
static void set_row(integral *it, double v, double w)
{
    const hpr_aligned *a = it->aligned;
    hpr_vec3 gap = hpr_madd(hpr_madd(a->offset, w, a->send_across), -v, a->recv_across);
    double shift = w * a->send_slant - v * a->recv_slant;
    int pairs = it->n_recv * it->n_send;
    it->square = hpr_dot(gap, gap);
    memset(it->row, 0, (size_t)pairs * sizeof *it->row);
    for (int s = 0; s < it->span_count; s++) {
        double *moment = it->moment + s * it->functions;
        span_moments(it, it->span[s].low + shift, it->span[s].high + shift, moment);
        for (int kl = 0; kl < pairs; kl++) {
            const double *c = it->correlation[s].coefficient + kl * it->functions;
            double sum = 0;
            for (int i = 0; i < it->functions; i++)
                sum += c[i] * moment[i];
            it->row[kl] += sum;
        }
    }
}

/* values[n] = sqrt(2n+1) P_n(2x - 1), n < count */
static void across_values(double x, int count, double *values)
{
    hpr_legendre(2 * x - 1, count, values);
    for (int n = 0; n < count; n++)
        values[n] *= sqrt(2 * n + 1);
}

/* part += value_v[k2] * rows, all of it at one v. */
static void add_rows(const integral *it, const double *value_v)
{
    int nr = it->n_recv, ns = it->n_send;
    bool recv_first = it->aligned->recv_edge == 0, send_first = it->aligned->send_edge == 0;
    for (int k2 = 0; k2 < nr; k2++) {
        for (int l2 = 0; l2 < ns; l2++) {
            const double *rows = it->rows + l2 * nr * ns;
            for (int kl1 = 0; kl1 < nr * ns; kl1++) {
                int k1 = kl1 / ns, l1 = kl1 % ns;
                int k = recv_first ? k1 * nr + k2 : k2 * nr + k1,
                    l = send_first ? l1 * ns + l2 : l2 * ns + l1;
                it->part[k * ns * ns + l] += value_v[k2] * rows[kl1];
            }
        }
    }
}

/* v from range[0][0] to range[0][1], w from range[1][0] to range[1][1]. */
typedef struct strip {
    double range[2][2];
} strip;

static void add_strip(integral *it, const strip *c, const int nodes[2])
{
    const hpr_gauss_rule *first = &it->gauss->legendre[nodes[0]], *second = &it->gauss->legendre[nodes[1]];
    double width[2] = {c->range[0][1] - c->range[0][0], c->range[1][1] - c->range[1][0]};
    double value_v[HPR_MAX_DEGREE + 1], value_w[HPR_MAX_DEGREE + 1];
    int pairs = it->n_recv * it->n_send;
    for (int i = 0; i < nodes[0]; i++) {
        double v = c->range[0][0] + width[0] * first->node[i];
        double weight_v =
            it->factor * width[0] * first->weight[i] * (it->recv_height[0] + v * it->recv_height[1]);
        memset(it->rows, 0, (size_t)(pairs * it->n_send) * sizeof *it->rows);
        for (int j = 0; j < nodes[1]; j++) {
            double w = c->range[1][0] + width[1] * second->node[j];
            double weight =
                weight_v * width[1] * second->weight[j] * (it->send_height[0] + w * it->send_height[1]);
            set_row(it, v, w);
            across_values(w, it->n_send, value_w);
            for (int l2 = 0; l2 < it->n_send; l2++) {
                for (int kl = 0; kl < pairs; kl++)
                    it->rows[l2 * pairs + kl] += weight * value_w[l2] * it->row[kl];
            }
        }
        across_values(v, it->n_recv, value_v);
        add_rows(it, value_v);
    }
}

/* Distance of all points of the two sides at these v and w. */
static double strip_distance(const integral *it, const strip *c)
{
    const hpr_aligned *a = it->aligned;
    hpr_vec3 recv[2], send[2];
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 2; i++) {
        recv[i] = hpr_scale(a->recv_across, c->range[0][i]);
        send[i] = hpr_madd(a->offset, c->range[1][i], a->send_across);
        for (int j = 0; j < 2; j++) {
            double shift = c->range[1][j] * a->send_slant - c->range[0][i] * a->recv_slant;
            low = fmin(low, shift);
            high = fmax(high, shift);
        }
    }
    double gap = fmax(fmax(a->along.first + low - 1, -(a->along.first + high + a->along.length)), 0);
    double q = hpr_outline_distance(recv, 2, send, 2);
    return sqrt(q * q + gap * gap);
}

static void refine(integral *it, const strip *c, int depth)
{
    const hpr_vec3 side[2] = {it->aligned->recv_across, it->aligned->send_across};
    const double slant[2] = {it->aligned->recv_slant, it->aligned->send_slant};
    double distance = strip_distance(it, c), length[2];
    int nodes[2];
    for (int i = 0; i < 2; i++) {
        length[i] = sqrt(hpr_dot(side[i], side[i]) + slant[i] * slant[i]) * (c->range[i][1] - c->range[i][0]);
        nodes[i] = hpr_kernel_nodes(length[i], distance, it->tolerance);
    }
    int axis = length[1] > length[0];
    bool stop = depth >= MAX_DEPTH || it->cells >= MAX_CELLS;
    if (nodes[axis] > it->cap && !stop) {
        strip half[2] = {*c, *c};
        double middle = (c->range[axis][0] + c->range[axis][1]) / 2;
        half[0].range[axis][1] = half[1].range[axis][0] = middle;
        refine(it, &half[0], depth + 1);
        refine(it, &half[1], depth + 1);
        return;
    }
    it->complete &= nodes[axis] <= it->cap;
    it->cells++;
    for (int i = 0; i < 2; i++) {
        int degree = it->degree[i] + 1 + (slant[i] != 0 ? it->functions - 1 : 0);
        nodes[i] = (nodes[i] < it->cap ? nodes[i] : it->cap) + (degree + 1) / 2;
        nodes[i] = nodes[i] < HPR_NODES_MAX ? nodes[i] : HPR_NODES_MAX;
    }
    add_strip(it, c, nodes);
}

/* The tables of correlations, and what else lies in the scratch. */
static void prepare(integral *it, double *scratch)
{
    size_t table = (size_t)(it->n_recv * it->n_send * it->functions),
           pairs = (size_t)(it->n_recv * it->n_send);
    it->span_count = hpr_overlap_spans(&it->aligned->along, it->span);
    for (int s = 0; s < it->span_count; s++) {
        it->correlation[s] = (hpr_correlation){it->n_recv, it->n_send, it->functions, scratch};
        hpr_correlate(it->gauss, &it->aligned->along, &it->span[s], &it->correlation[s]);
        scratch += table;
    }
    it->moment = scratch;
    it->values = it->moment + 3 * it->functions;
    it->row = it->values + HPR_NODES_MAX * it->functions;
    it->rows = it->row + pairs;
}

bool hpr_aligned_add(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_aligned *aligned,
                     double tolerance, double *part, double *scratch, uint64_t *kernels)
{
    integral it = {.gauss = gauss,
                   .aligned = aligned,
                   .tolerance = tolerance,
                   .factor = 1 / (pi * pow(aligned->unit, 4)),
                   .n_recv = pair->recv.degree + 1,
                   .n_send = pair->send.degree + 1,
                   .functions = pair->recv.degree + pair->send.degree + 2,
                   .degree = {pair->recv.degree, pair->send.degree},
                   .cap = hpr_kernel_nodes(1, 0.5, tolerance),
                   .part = part,
                   .complete = true};
    const strip whole = {
        {{aligned->recv_range[0], aligned->recv_range[1]}, {aligned->send_range[0], aligned->send_range[1]}}};
    across_height(&pair->recv_height, aligned->recv_edge, it.recv_height);
    across_height(&pair->send_height, aligned->send_edge, it.send_height);
    prepare(&it, scratch);
    refine(&it, &whole, 0);
    *kernels += it.kernels;
    return it.complete;
}
