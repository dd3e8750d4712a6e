#include "quadrature/constants.h"

#include <string.h>

/* Senders that are gone through side by side. */
enum { LANES = 8 };

/* Points of all rules for one element. */
enum { LEAST_NODES = 2, POINTS = 203 }; /* 2^2 + 3^2 + ... + 8^2 */
_Static_assert(HPR_FAR_NODES == 8, "POINTS is for up to 8 nodes per axis");

/* One side: arrays [points][stride], points of the rules one after the other; the rest [stride]. */
typedef struct side {
    const hpr_panel *panel;
    hpr_shape shape;
    size_t stride;
    double *x, *y, *z, *height;    /* height: over the other's plane, times the weight */
    double *cx, *cy, *cz, *radius; /* circles around the elements */
    double *length;                /* longest edge */
    bool made[HPR_FAR_NODES + 1];  /* rules whose points are there */
} side;

enum { ARRAYS = 4 * POINTS + 5 };

static size_t padded(size_t count)
{
    return (count + LANES - 1) / LANES * LANES;
}

size_t hpr_constants_scratch(size_t recv_count, size_t send_count)
{
    return ARRAYS * (padded(recv_count) + padded(send_count));
}

static size_t first_point(int nodes)
{
    size_t n = (size_t)nodes; /* 2^2 + ... + (n - 1)^2 */
    return (n - 1) * n * (2 * n - 1) / 6 - 1;
}

/* Elements beyond the last are the last again. */
static const hpr_element_frame *frame_of(const side *s, size_t index)
{
    return &s->panel->frame[index < s->panel->count ? index : s->panel->count - 1];
}

static side open_side(const hpr_panel *panel, hpr_vec3 origin, double *memory)
{
    size_t stride = padded(panel->count);
    side s = {.panel = panel, .shape = panel->frame[0].shape, .stride = stride};
    double **arrays[] = {&s.x, &s.y, &s.z, &s.height},
           **single[] = {&s.cx, &s.cy, &s.cz, &s.radius, &s.length};
    for (int k = 0; k < 4; k++, memory += POINTS * stride)
        *arrays[k] = memory;
    for (int k = 0; k < 5; k++, memory += stride)
        *single[k] = memory;
    for (size_t i = 0; i < stride; i++) {
        const hpr_element_frame *f = frame_of(&s, i);
        hpr_cell whole = hpr_cell_whole(f);
        hpr_vec3 corner[4];
        int count = hpr_cell_corners(f, &whole, corner);
        double middle = f->shape == HPR_SHAPE_TRIANGLE ? 1.0 / 3 : 0.5;
        hpr_vec3 centre = hpr_frame_point(f, middle, middle), from = hpr_sub(centre, origin);
        s.cx[i] = from.x;
        s.cy[i] = from.y;
        s.cz[i] = from.z;
        s.radius[i] = s.length[i] = 0;
        for (int k = 0; k < count; k++) {
            s.radius[i] = fmax(s.radius[i], hpr_length(hpr_sub(corner[k], centre)));
            s.length[i] = fmax(s.length[i], hpr_length(hpr_sub(corner[(k + 1) % count], corner[k])));
        }
    }
    return s;
}

static void make_points(const hpr_far *tables, side *s, const hpr_element_frame *other, hpr_vec3 origin,
                        int nodes)
{
    if (s->made[nodes])
        return;
    s->made[nodes] = true;
    hpr_far_rule rule = hpr_far_nodes(tables, s->shape, nodes);
    hpr_vec3 plane = hpr_sub(other->origin, origin);
    double share = s->shape == HPR_SHAPE_TRIANGLE ? 2 : 1; /* of the parameters' area */
    for (size_t p = 0; p < rule.count; p++) {
        size_t row = (first_point(nodes) + p) * s->stride;
        for (size_t i = 0; i < s->stride; i++) {
            const hpr_element_frame *f = frame_of(s, i);
            hpr_vec3 start = hpr_sub(f->origin, origin);
            hpr_vec3 x = hpr_madd(hpr_madd(start, rule.s[p], f->edge1), rule.t[p], f->edge2);
            s->x[row + i] = x.x;
            s->y[row + i] = x.y;
            s->z[row + i] = x.z;
            s->height[row + i] = share * rule.weight[p] * hpr_dot(hpr_sub(x, plane), other->normal);
        }
    }
}

/* Mean of pi G over receiver i and LANES senders from j on. */
static void mean_kernel(const side *r, size_t i, const side *s, size_t j, int nodes, double mean[LANES])
{
    size_t first = first_point(nodes), end = first + (size_t)(nodes * nodes);
    double sum[LANES] = {0};
    for (size_t p = first; p < end; p++) {
        size_t at = p * r->stride + i;
        double x = r->x[at], y = r->y[at], z = r->z[at], h = r->height[at], row[LANES] = {0};
        for (size_t q = first; q < end; q++) {
            const double *restrict sx = s->x + q * s->stride + j, *restrict sy = s->y + q * s->stride + j;
            const double *restrict sz = s->z + q * s->stride + j, *restrict sh =
                                                                      s->height + q * s->stride + j;
            for (int k = 0; k < LANES; k++) {
                double dx = sx[k] - x, dy = sy[k] - y, dz = sz[k] - z;
                double r2 = dx * dx + dy * dy + dz * dz;
                row[k] += sh[k] / (r2 * r2);
            }
        }
        for (int k = 0; k < LANES; k++)
            sum[k] += h * row[k];
    }
    memcpy(mean, sum, sizeof sum);
}

/* The distance, in longest edges, from which on n nodes are enough: hpr_kernel_error is the tolerance there.
 */
static double enough_distance(int nodes, double tolerance)
{
    double rho = pow(64 / tolerance, 0.5 / nodes);
    return (rho - 1 / rho) / 4;
}

/* Nodes for a pair; HPR_FAR_NODES + 1: too near. */
static int choose_nodes(const side *r, size_t i, const side *s, size_t j, const double *enough)
{
    double dx = s->cx[j] - r->cx[i], dy = s->cy[j] - r->cy[i], dz = s->cz[j] - r->cz[i];
    double distance = sqrt(dx * dx + dy * dy + dz * dz) - r->radius[i] - s->radius[j];
    double longest = fmax(r->length[i], s->length[j]);
    int nodes = LEAST_NODES;
    while (nodes <= HPR_FAR_NODES && distance < enough[nodes] * longest)
        nodes++;
    return nodes;
}

uint64_t hpr_constants_block(const hpr_far *tables, const hpr_panel *recv, const hpr_panel *send,
                             double tolerance, double *block, bool *near, double *scratch)
{
    static const double pi = 3.14159265358979323846;
    hpr_vec3 origin = recv->frame[0].origin;
    side r = open_side(recv, origin, scratch);
    side s = open_side(send, origin, scratch + ARRAYS * r.stride);
    double enough[HPR_FAR_NODES + 1], mean[LANES];
    uint64_t evaluations = 0;
    for (int n = LEAST_NODES; n <= HPR_FAR_NODES; n++)
        enough[n] = enough_distance(n, tolerance);
    for (size_t i = 0; i < recv->count; i++) {
        for (size_t j = 0; j < send->count; j += LANES) {
            size_t lanes = send->count - j < LANES ? send->count - j : LANES, at = i * send->count + j;
            int most = 0;
            for (size_t k = 0; k < lanes; k++) {
                int nodes = choose_nodes(&r, i, &s, j + k, enough);
                near[at + k] = nodes > HPR_FAR_NODES;
                most = near[at + k] || nodes < most ? most : nodes;
            }
            if (most > 0) {
                make_points(tables, &r, send->frame, origin, most);
                make_points(tables, &s, recv->frame, origin, most);
                mean_kernel(&r, i, &s, j, most, mean);
                evaluations += (uint64_t)(most * most) * (uint64_t)(most * most) * lanes;
            }
            for (size_t k = 0; k < lanes; k++) {
                double areas = recv->frame[i].area_m2 * send->frame[j + k].area_m2;
                block[at + k] = near[at + k] ? 0 : mean[k] * sqrt(areas) / pi;
            }
        }
    }
    return evaluations;
}
