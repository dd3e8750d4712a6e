#include "quadrature/constants.h"

#include "math/lanes.h"

#include <string.h>

/* Points of all rules for one element. */
enum {
    LEAST_NODES = 2,
    POINTS = 203,
    MOST_POINTS = HPR_FAR_NODES * HPR_FAR_NODES
}; /* 2^2 + 3^2 + ... + 8^2 */
_Static_assert(HPR_FAR_NODES == 8, "POINTS is for up to 8 nodes per axis");

/* Numbers of an element, one array each; with four corners, of triangles the last is there twice. */
enum {
    MIDDLE = 0,
    RADIUS = 3,
    LENGTH,
    NORMAL,
    OFFSET = 8,
    CORNER = 9,
    CORNERS = 4,
    AREA = CORNER + 3 * CORNERS,
    NUMBERS
};

/* Coordinates are measured from the first receiver's origin, in a unit of about the size of it all, for
 * sixteenth powers of distances stand in the sums: a power of two, so that no bit changes. */
typedef struct measure {
    hpr_vec3 origin;
    double scale; /* units to a metre */
} measure;

typedef struct side {
    const hpr_panel *panel;
    measure measure;
    size_t stride;
    double *number;               /* [NUMBERS][stride] */
    double *point;                /* [POINTS][x, y, z, weight][stride], the rules one after the other */
    bool made[HPR_FAR_NODES + 1]; /* rules whose points are there */
} side;

/* A point of the receiver at hand, with its weight. */
typedef struct place {
    double x, y, z, weight;
} place;

typedef struct receiver {
    double number[NUMBERS];
    place place[POINTS];
    bool made[HPR_FAR_NODES + 1];
} receiver;

/* What is asked of pairs. */
typedef struct limits {
    double tolerance, slack;
    double least_height; /* below it rounding of the coordinates would be seen */
} limits;

static size_t padded(size_t count)
{
    return (count + HPR_LANES - 1) / HPR_LANES * HPR_LANES;
}

size_t hpr_constants_scratch(size_t recv_count, size_t send_count)
{
    return NUMBERS * padded(recv_count) + (NUMBERS + 4 * POINTS + 2) * padded(send_count);
}

static size_t first_point(int nodes)
{
    size_t n = (size_t)nodes; /* 2^2 + ... + (n - 1)^2 */
    return (n - 1) * n * (2 * n - 1) / 6 - 1;
}

static double reach_of(const hpr_panel *panel, hpr_vec3 origin)
{
    double reach = 0;
    for (size_t i = 0; i < panel->count; i++) {
        const hpr_element_frame *f = &panel->frame[i];
        hpr_vec3 offset = hpr_sub(f->origin, origin);
        const hpr_vec3 all[3] = {offset, f->edge1, f->edge2};
        for (int k = 0; k < 3; k++)
            reach = fmax(reach, fmax(fmax(fabs(all[k].x), fabs(all[k].y)), fabs(all[k].z)));
    }
    return reach;
}

static measure measure_of(const hpr_constants_task *task)
{
    measure m = {.origin = task->recv.frame[0].origin, .scale = 1};
    double reach = fmax(reach_of(&task->recv, m.origin), reach_of(&task->send, m.origin));
    if (reach > 0 && reach < INFINITY)
        m.scale = ldexp(1, -ilogb(reach));
    return m;
}

static hpr_element_frame measured(const hpr_element_frame *frame, const measure *m)
{
    hpr_element_frame f = *frame;
    f.origin = hpr_sub(f.origin, m->origin);
    return hpr_frame_rescaled(&f, m->scale);
}

/* Elements beyond the last are the last again. */
static hpr_element_frame frame_of(const side *s, size_t index)
{
    return measured(&s->panel->frame[index < s->panel->count ? index : s->panel->count - 1], &s->measure);
}

static double *numbers(const side *s, int what)
{
    return s->number + (size_t)what * s->stride;
}

static void put(const side *s, int what, size_t i, hpr_vec3 x)
{
    numbers(s, what)[i] = x.x;
    numbers(s, what + 1)[i] = x.y;
    numbers(s, what + 2)[i] = x.z;
}

static void describe(const side *s, size_t i)
{
    const hpr_element_frame frame = frame_of(s, i), *f = &frame;
    hpr_cell whole = hpr_cell_whole(f);
    hpr_vec3 corner[CORNERS];
    int count = hpr_cell_corners(f, &whole, corner);
    double at = f->shape == HPR_SHAPE_TRIANGLE ? 1.0 / 3 : 0.5, radius = 0, length = 0;
    hpr_vec3 middle = hpr_frame_point(f, at, at);
    for (int k = 0; k < count; k++) {
        radius = fmax(radius, hpr_length(hpr_sub(corner[k], middle)));
        length = fmax(length, hpr_length(hpr_sub(corner[(k + 1) % count], corner[k])));
    }
    put(s, MIDDLE, i, middle);
    put(s, NORMAL, i, f->normal);
    numbers(s, RADIUS)[i] = radius;
    numbers(s, LENGTH)[i] = length;
    numbers(s, AREA)[i] = f->area_m2;
    numbers(s, OFFSET)[i] = hpr_dot(f->normal, f->origin);
    for (int k = 0; k < CORNERS; k++)
        put(s, CORNER + 3 * k, i, corner[k < count ? k : count - 1]);
}

static side open_side(const hpr_panel *panel, const measure *m, double *memory)
{
    side s = {.panel = panel, .measure = *m, .stride = padded(panel->count), .number = memory};
    s.point = memory + NUMBERS * s.stride;
    for (size_t i = 0; i < s.stride; i++)
        describe(&s, i);
    return s;
}

/* Place of a point, its weight for means over the element. */
static place place_of(const hpr_element_frame *f, const hpr_far_rule *rule, size_t p)
{
    double share = f->shape == HPR_SHAPE_TRIANGLE ? 2 : 1; /* of the parameters' area */
    hpr_vec3 x = hpr_frame_point(f, rule->s[p], rule->t[p]);
    return (place){x.x, x.y, x.z, share * rule->weight[p]};
}

static void make_points(const hpr_far *tables, side *s, int nodes)
{
    if (s->made[nodes])
        return;
    s->made[nodes] = true;
    for (size_t i = 0; i < s->stride; i++) {
        const hpr_element_frame frame = frame_of(s, i), *f = &frame;
        hpr_far_rule rule = hpr_far_nodes(tables, f->shape, nodes);
        for (size_t p = 0; p < rule.count; p++) {
            double *row = s->point + 4 * (first_point(nodes) + p) * s->stride + i;
            place at = place_of(f, &rule, p);
            row[0] = at.x;
            row[s->stride] = at.y;
            row[2 * s->stride] = at.z;
            row[3 * s->stride] = at.weight;
        }
    }
}

static void make_places(const hpr_far *tables, receiver *r, const hpr_element_frame *f, int nodes)
{
    if (r->made[nodes])
        return;
    r->made[nodes] = true;
    hpr_far_rule rule = hpr_far_nodes(tables, f->shape, nodes);
    for (size_t p = 0; p < rule.count; p++)
        r->place[first_point(nodes) + p] = place_of(f, &rule, p);
}

/* Least and largest height of an element's corners over a plane. */
typedef struct heights {
    double least, most;
} heights;

HPR_LANES_BODY double height_of(const double *at, size_t stride, double nx, double ny, double nz,
                                double offset)
{
    return nx * at[0] + ny * at[stride] + nz * at[2 * stride] - offset;
}

HPR_LANES_BODY heights heights_of(const double *corner, size_t stride, double nx, double ny, double nz,
                                  double offset)
{
    double a = height_of(corner, stride, nx, ny, nz, offset),
           b = height_of(corner + 3 * stride, stride, nx, ny, nz, offset),
           c = height_of(corner + 6 * stride, stride, nx, ny, nz, offset),
           d = height_of(corner + 9 * stride, stride, nx, ny, nz, offset);
    return (heights){hpr_min(hpr_min(a, b), hpr_min(c, d)), hpr_max(hpr_max(a, b), hpr_max(c, d))};
}

/* Where a height varies from 1 - share to 1 + share. */
HPR_LANES_BODY double share_of(heights h)
{
    return (h.most - h.least) / (h.most + h.least);
}

/* What is foretold of a receiver and all senders. need: nodes, 0 if they do not see each other, one more than
 * there are if they are for other rules; error: on so many, relative. A height is a linear factor, which
 * takes half a node: errors grow by its share of half of rho. */
HPR_LANES_BODY void foresee_body(const double *restrict own, const double *restrict number, size_t stride,
                                 const limits *limits, double *restrict need, double *restrict error)
{
    const double tolerance = limits->tolerance, slack = limits->slack, least_height = limits->least_height;
    for (size_t j = 0; j < stride; j++) {
        const double *it = number + j;
        heights over = heights_of(own + CORNER, 1, it[NORMAL * stride], it[(NORMAL + 1) * stride],
                                  it[(NORMAL + 2) * stride], it[OFFSET * stride]);
        heights under = heights_of(it + CORNER * stride, stride, own[NORMAL], own[NORMAL + 1],
                                   own[NORMAL + 2], own[OFFSET]);
        double dx = it[0] - own[0], dy = it[stride] - own[1], dz = it[2 * stride] - own[2];
        double distance = sqrt(dx * dx + dy * dy + dz * dz) - own[RADIUS] - it[RADIUS * stride];
        double b = 2 * distance / hpr_max(own[LENGTH], it[LENGTH * stride]), rho = b + sqrt(b * b + 1);
        double falls = 1 / (rho * rho), share = hpr_max(share_of(over), share_of(under));
        double on = (64 + 32 * share * rho) * falls, nodes = LEAST_NODES, left = 0;
#pragma GCC unroll 8
        for (int n = LEAST_NODES; n <= HPR_FAR_NODES; n++) {
            on *= falls;
            nodes += on > tolerance ? 1 : 0;
            left = hpr_max(left, on > tolerance ? 0 : on);
        }
        double most = hpr_min(over.most, under.most), least = hpr_min(over.least, under.least);
        nodes = least < -slack ? HPR_FAR_NODES + 1 : nodes;
        nodes = most < least_height ? HPR_FAR_NODES + 1 : nodes;
        nodes = distance > 0 ? nodes : HPR_FAR_NODES + 1;
        need[j] = most <= slack ? 0 : nodes;
        error[j] = left;
    }
}

HPR_LANES_BODY hpr_lanes height_over(bool fused, const hpr_lanes x[3], const hpr_lanes plane[4])
{
    hpr_lanes across = hpr_lanes_madd(fused, x[1], plane[1], x[2] * plane[2]);
    return hpr_lanes_madd(fused, x[0], plane[0], across - plane[3]);
}

/* Of a sender's point, its squares of distances from four of the receiver's points, squared again. */
HPR_LANES_BODY hpr_lanes fourth_power(bool fused, const hpr_lanes x[3], const place *from)
{
    hpr_lanes dx = x[0] - from->x, dy = x[1] - from->y, dz = x[2] - from->z;
    hpr_lanes r2 = hpr_lanes_madd(fused, dx, dx, hpr_lanes_madd(fused, dy, dy, dz * dz));
    return r2 * r2;
}

/* Mean of pi G over the receiver and eight senders from j on. Four quotients share one division, which is
 * what the kernel's speed hangs on. */
HPR_LANES_BODY void mean_kernel_body(bool fused, const receiver *r, const side *s, size_t j, int nodes,
                                     double mean[HPR_LANES])
{
    size_t count = (size_t)(nodes * nodes), stride = s->stride;
    const place *from = r->place + first_point(nodes);
    const double *to = s->point + 4 * first_point(nodes) * stride + j;
    hpr_lanes over[MOST_POINTS], own[4], their[4], total = hpr_lanes_of(0);
    for (int k = 0; k < 4; k++) {
        own[k] = hpr_lanes_of(r->number[NORMAL + k]);
        their[k] = hpr_lanes_load(numbers(s, NORMAL + k) + j);
    }
    for (size_t p = 0; p < count; p++) {
        const hpr_lanes x[3] = {hpr_lanes_of(from[p].x), hpr_lanes_of(from[p].y), hpr_lanes_of(from[p].z)};
        over[p] = from[p].weight * height_over(fused, x, their);
    }
    for (size_t q = 0; q < count; q++, to += 4 * stride) {
        const hpr_lanes x[3] = {hpr_lanes_load(to), hpr_lanes_load(to + stride),
                                hpr_lanes_load(to + 2 * stride)};
        hpr_lanes sum = hpr_lanes_of(0);
        size_t p = 0;
        for (; p + 4 <= count; p += 4) {
            hpr_lanes a = fourth_power(fused, x, from + p), b = fourth_power(fused, x, from + p + 1),
                      c = fourth_power(fused, x, from + p + 2), d = fourth_power(fused, x, from + p + 3);
            hpr_lanes first = hpr_lanes_madd(fused, over[p], b, over[p + 1] * a),
                      last = hpr_lanes_madd(fused, over[p + 2], d, over[p + 3] * c);
            hpr_lanes ab = a * b, cd = c * d;
            sum += hpr_lanes_madd(fused, first, cd, last * ab) / (ab * cd);
        }
        for (; p < count; p++)
            sum += over[p] / fourth_power(fused, x, from + p);
        hpr_lanes height = hpr_lanes_load(to + 3 * stride) * height_over(fused, x, own);
        total = hpr_lanes_madd(fused, height, sum, total);
    }
    hpr_lanes_store(mean, total);
}

static void foresee_sse2(const double *own, const double *number, size_t stride, const limits *limits,
                         double *need, double *error)
{
    foresee_body(own, number, stride, limits, need, error);
}

static HPR_TARGET_AVX2 void foresee_avx2(const double *own, const double *number, size_t stride,
                                         const limits *limits, double *need, double *error)
{
    foresee_body(own, number, stride, limits, need, error);
}

static HPR_TARGET_AVX512 void foresee_avx512(const double *own, const double *number, size_t stride,
                                             const limits *limits, double *need, double *error)
{
    foresee_body(own, number, stride, limits, need, error);
}

static void mean_sse2(const receiver *r, const side *s, size_t j, int nodes, double mean[HPR_LANES])
{
    mean_kernel_body(false, r, s, j, nodes, mean);
}

static HPR_TARGET_AVX2 void mean_avx2(const receiver *r, const side *s, size_t j, int nodes,
                                      double mean[HPR_LANES])
{
    mean_kernel_body(false, r, s, j, nodes, mean);
}

static HPR_TARGET_AVX512 void mean_avx512(const receiver *r, const side *s, size_t j, int nodes,
                                          double mean[HPR_LANES])
{
    mean_kernel_body(true, r, s, j, nodes, mean);
}

/* The two loops, compiled for an instruction set. */
typedef struct loops {
    void (*foresee)(const double *, const double *, size_t, const limits *, double *, double *);
    void (*mean)(const receiver *, const side *, size_t, int, double *);
} loops;

static const loops loops_of[] = {[HPR_ISA_SSE2] = {foresee_sse2, mean_sse2},
                                 [HPR_ISA_AVX2] = {foresee_avx2, mean_avx2},
                                 [HPR_ISA_AVX512] = {foresee_avx512, mean_avx512}};

/* One call, with what its pairs share. */
typedef struct work {
    const hpr_constants_task *task;
    const loops *loops;
    limits limits;
    side recv, send;
    double *need, *error; /* [send.stride] of the receiver at hand */
    hpr_constants_result result;
} work;

/* Eight senders from j on; the kinds and the entries are those of sender j. */
static void integrate_group(work *w, size_t i, receiver *r, size_t j, double *block, uint8_t *kind)
{
    static const double pi = 3.14159265358979323846;
    const hpr_constants_task *task = w->task;
    const double *nodes = w->need + j;
    size_t lanes = task->send.count - j < HPR_LANES ? task->send.count - j : HPR_LANES;
    double mean[HPR_LANES];
    int most = 0;
    for (size_t k = 0; k < lanes; k++) {
        int need = (int)nodes[k];
        if (kind[k] != HPR_PAIR_WANTED)
            continue;
        block[k] = 0;
        if (need > HPR_FAR_NODES)
            kind[k] = HPR_PAIR_LEFT;
        else if (need > most)
            most = need;
    }
    if (most == 0)
        return;
    make_points(task->tables, &w->send, most);
    const hpr_element_frame recv = frame_of(&w->recv, i);
    make_places(task->tables, r, &recv, most);
    w->loops->mean(r, &w->send, j, most, mean);
    for (size_t k = 0; k < lanes; k++) {
        if (kind[k] != HPR_PAIR_WANTED || nodes[k] == 0)
            continue;
        block[k] = mean[k] * sqrt(recv.area_m2 * numbers(&w->send, AREA)[j + k]) / pi;
        w->result.error = fmax(w->result.error, w->error[j + k]);
        w->result.pair_count++;
        w->result.kernel_count += (uint64_t)(most * most) * (uint64_t)(most * most);
    }
}

/* Coordinates are rounded to so much, half of the largest. */
static double rounding_of(const side *s)
{
    double farthest = 0;
    for (size_t i = 0; i < s->stride; i++) {
        hpr_vec3 middle = {numbers(s, MIDDLE)[i], numbers(s, MIDDLE + 1)[i], numbers(s, MIDDLE + 2)[i]};
        farthest = fmax(farthest, hpr_length(middle) + numbers(s, RADIUS)[i]);
    }
    return 0x1p-53 * farthest;
}

hpr_constants_result hpr_constants_block(const hpr_constants_task *task, double *block, uint8_t *kind,
                                         double *scratch)
{
    static const double roundings = 8; /* in a height: of the point, of the plane and of their product */
    const measure m = measure_of(task);
    work w = {.task = task,
              .loops = &loops_of[hpr_far_isa(task->tables)],
              .limits = {.tolerance = task->tolerance, .slack = task->slack_m * m.scale}};
    w.recv = open_side(&task->recv, &m, scratch);
    w.send = open_side(&task->send, &m, scratch + NUMBERS * w.recv.stride);
    w.need = w.send.point + 4 * POINTS * w.send.stride;
    w.error = w.need + w.send.stride;
    w.limits.least_height = roundings * fmax(rounding_of(&w.recv), rounding_of(&w.send)) / task->tolerance;
    for (size_t i = 0; i < task->recv.count; i++) {
        receiver r;
        for (int k = 0; k < NUMBERS; k++)
            r.number[k] = numbers(&w.recv, k)[i];
        memset(r.made, 0, sizeof r.made);
        w.loops->foresee(r.number, w.send.number, w.send.stride, &w.limits, w.need, w.error);
        for (size_t j = 0; j < task->send.count; j += HPR_LANES)
            integrate_group(&w, i, &r, j, block + i * task->send.count + j, kind + i * task->send.count + j);
    }
    return w.result;
}
