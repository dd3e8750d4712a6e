/* Kernel blocks: form factors and moments of the open set, reciprocity, tolerance, invariance. */
#include "blocks.h"
#include "open_cases.h"
#include "shapes.h"

#include <float.h>

/* Demanded of each block, relative to its largest entry; what rounding and estimates may add to it. */
static const double demanded = 1e-12, bound = 5e-12;

static double block_a[HPR_MAX_BASIS * HPR_MAX_BASIS], block_b[HPR_MAX_BASIS * HPR_MAX_BASIS];

static void form_factors_of_the_open_set(void **state)
{
    (void)state;
    int failures = 0;
    double worst = 0;
    for (int i = 0; i < OPEN_FACTORS; i++) {
        const open_factor *c = &open_factors[i];
        hpr_element_frame one = frame_of_corners(0, c->count1, c->corner1);
        hpr_element_frame two = frame_of_corners(0, c->count2, c->corner2);
        double block;
        hpr_block_result result = block_of(&one, &two, demanded, &block);
        double factor = block * sqrt(two.area_m2 / one.area_m2);
        double error = c->value ? fabs(factor / c->value - 1) : fabs(factor);
        bool good = c->value ? error <= bound && result.seen : factor == 0 && !result.seen;
        good = good && result.status < HPR_BLOCK_SHORT;
        print_message("%-24s F12 %.16g  error %.1e  kernels %llu%s\n", c->id, factor, error,
                      (unsigned long long)result.kernel_count,
                      result.status >= HPR_BLOCK_SHORT ? "  SHORT" : "");
        failures += !good;
        worst = fmax(worst, error);
    }
    print_message("worst error %.1e, bound %.0e\n", worst, bound);
    assert_int_equal(failures, 0);
}

/* Errors relative to the largest entry of the block, as the tolerance is. */
static void moments_of_the_open_set(void **state)
{
    (void)state;
    int failures = 0;
    for (int i = 0; i < OPEN_BLOCKS; i++) {
        const open_block *c = &open_blocks[i];
        hpr_shape shape = c->triangles ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM;
        hpr_element_frame recv = frame_of(shape, c->degree, c->recv[0], c->recv[1], c->recv[2]);
        hpr_element_frame send = frame_of(shape, c->degree, c->send[0], c->send[1], c->send[2]);
        size_t n = frame_basis(&send);
        hpr_block_result result = block_of(&recv, &send, demanded, block_a);
        double worst = 0, largest = largest_entry(block_a, n * n);
        for (int k = 0; k < c->entry_count; k++) {
            const open_entry *e = &c->entry[k];
            double error = fabs(block_a[(size_t)e->row * n + (size_t)e->column] - e->value) / largest;
            if (!(error <= bound))
                print_error("%s: K[%d][%d] = %.17g, expected %.17g\n", c->id, e->row, e->column,
                            block_a[(size_t)e->row * n + (size_t)e->column], e->value);
            worst = fmax(worst, error);
        }
        double trusted = fmax(bound, pow(10, -c->digits));
        print_message("%-26s degree %2d, %2d entries: error %.1e of the largest, bound %.0e, kernels %llu\n",
                      c->id, c->degree, c->entry_count, worst, trusted,
                      (unsigned long long)result.kernel_count);
        failures += !(worst <= trusted) || result.status >= HPR_BLOCK_SHORT;
    }
    assert_int_equal(failures, 0);
}

/* K^00 = sqrt(Ai/Aj) F_ij where the areas differ, both ways round. */
static void constants_give_the_form_factor(void **state)
{
    (void)state;
    const double x[2] = {0, 3}, y[2] = {0, 0.5}, u[2] = {1, 1.25}, v[2] = {0.25, 2.25}, h = 0.75;
    const double wall_u[2] = {0, 0.8}, wall_v[2] = {-0.5, 0.3};
    const struct {
        const char *name;
        double exact, recv[3][3], send[3][3];
    } pairs[] = {
        {"parallel",
         exchange_parallel(x, y, u, v, h),
         {{0, 0, 0}, {3, 0, 0}, {0, 0.5, 0}},
         {{1, 0.25, h}, {1, 2.25, h}, {1.25, 0.25, h}}},
        {"perpendicular, partial edge",
         exchange_perpendicular(x, y, wall_u, wall_v),
         {{0, 0, 0}, {3, 0, 0}, {0, 0.5, 0}},
         {{0, -0.5, 0}, {0, 0.3, 0}, {0, -0.5, 0.8}}},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        for (int degree = 0; degree <= 3; degree++) {
            hpr_element_frame a = frame_of(HPR_SHAPE_PARALLELOGRAM, degree, pairs[i].recv[0],
                                           pairs[i].recv[1], pairs[i].recv[2]);
            hpr_element_frame b = frame_of(HPR_SHAPE_PARALLELOGRAM, 3 - degree, pairs[i].send[0],
                                           pairs[i].send[1], pairs[i].send[2]);
            block_of(&a, &b, demanded, block_a);
            block_of(&b, &a, demanded, block_b);
            double f_ab = pairs[i].exact / a.area_m2, f_ba = pairs[i].exact / b.area_m2;
            double ab = fabs(block_a[0] / (sqrt(a.area_m2 / b.area_m2) * f_ab) - 1);
            double ba = fabs(block_b[0] / (sqrt(b.area_m2 / a.area_m2) * f_ba) - 1);
            print_message("%s, areas %g and %g, degrees %d x %d: errors %.1e, %.1e, bound %.0e\n",
                          pairs[i].name, a.area_m2, b.area_m2, degree, 3 - degree, ab, ba, bound);
            assert_true(ab <= bound && ba <= bound);
        }
    }
}

typedef struct reciprocal {
    const char *name;
    hpr_shape recv_shape, send_shape;
    double recv[3][3], send[3][3];
} reciprocal;

#define Q HPR_SHAPE_PARALLELOGRAM
#define T HPR_SHAPE_TRIANGLE

static const reciprocal reciprocals[] = {
    {"separated", Q, Q, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}, {{3, 0, 2}, {3, 1, 2}, {4, 0, 2.5}}},
    {"near", Q, Q, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0.3, 0, 0.1}, {0.3, 1, 0.1}, {1.3, 0, 0.2}}},
    {"shared edge", Q, Q, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {0, 1, 0}, {0.5, 0, 1}}},
    {"shared vertex", Q, Q, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, -1, 0}, {0, 0, 0}, {0, -1.3, 1}}},
    {"T-junction", Q, Q, {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}}, {{0.5, 0, 0}, {-0.25, 0, 0}, {0.5, 0, 1}}},
    {"triangle x square", T, Q, {{0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}}, {{0, 0, 1}, {0, 1, 1}, {1, 0, 1.5}}},
    {"the same, shared edge", T, Q, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
    {"triangles, shared edge",
     T,
     T,
     {{0, 0, 0}, {1, 0.25, 0}, {0, 1, 0}},
     {{0, 0, 0}, {0, 1, 0}, {0, 0.75, 1}}},
    {"triangles, shared vertex",
     T,
     T,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0, 0, 0}, {-0.25, 1, 1}, {1, -0.25, 1}}},
    {"piercing", T, Q, {{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}}, {{0, 0, -0.4}, {0, 1, -0.4}, {0.3, 0, 1}}},
};

/*
 * The solver integrates each pair once and takes the transpose for the other direction, so there reciprocity
 * is exact. Here both directions are integrated, and may halve different sides: they agree to the tolerance.
 */
static void blocks_are_reciprocal(void **state)
{
    (void)state;
    int failures = 0;
    for (size_t i = 0; i < sizeof reciprocals / sizeof *reciprocals; i++) {
        const reciprocal *r = &reciprocals[i];
        hpr_element_frame a = frame_of(r->recv_shape, 4, r->recv[0], r->recv[1], r->recv[2]);
        hpr_element_frame b = frame_of(r->send_shape, 3, r->send[0], r->send[1], r->send[2]);
        size_t na = frame_basis(&a), nb = frame_basis(&b);
        hpr_block_result forth = block_of(&a, &b, demanded, block_a);
        hpr_block_result back = block_of(&b, &a, demanded, block_b);
        double worst = 0, largest = largest_entry(block_a, na * nb);
        for (size_t k = 0; k < na; k++) {
            for (size_t l = 0; l < nb; l++)
                worst = fmax(worst, fabs(block_a[k * nb + l] - block_b[l * na + k]));
        }
        print_message("%-26s K^00 %.6g  |K_ij - K_jiT| %.1e of the largest entry, bound %.0e%s\n", r->name,
                      block_a[0], worst / largest, bound,
                      forth.status >= HPR_BLOCK_SHORT || back.status >= HPR_BLOCK_SHORT ? "  SHORT" : "");
        failures += !(worst <= bound * largest && largest > 0);
    }
    assert_int_equal(failures, 0);
}

static void random_vector(uint64_t *seed, double scale, double v[3])
{
    double length;
    do {
        for (int k = 0; k < 3; k++)
            v[k] = 2 * shapes_random(seed) - 1;
        length = hpr_length3(v);
    } while (length > 1 || length < 0.3);
    for (int k = 0; k < 3; k++)
        v[k] *= scale;
}

/* An element of about the given size around a centre; not a sliver. */
static hpr_element_frame random_frame(uint64_t *seed, double size, const double centre[3])
{
    for (;;) {
        double first[3], e1[3], e2[3], second[3], last[3];
        random_vector(seed, size, e1);
        random_vector(seed, size, e2);
        hpr_shape shape = shapes_random(seed) < 0.5 ? Q : T;
        int degree = (int)(4 * shapes_random(seed));
        double middle = shape == T ? 1.0 / 3 : 0.5;
        for (int k = 0; k < 3; k++)
            first[k] = centre[k] - middle * (e1[k] + e2[k]);
        hpr_add_scaled3(first, 1, e1, second);
        hpr_add_scaled3(first, 1, e2, last);
        hpr_element_frame f = frame_of(shape, degree, first, second, last);
        double across = hpr_length(hpr_cross(f.edge1, f.edge2));
        if (across > 0.3 * hpr_length(f.edge1) * hpr_length(f.edge2))
            return f;
    }
}

static double frame_size(const hpr_element_frame *f)
{
    return fmax(hpr_length(f->edge1), hpr_length(f->edge2));
}

static double frame_distance(const hpr_element_frame *a, const hpr_element_frame *b)
{
    hpr_vec3 p[4], q[4];
    hpr_cell whole_a = hpr_cell_whole(a), whole_b = hpr_cell_whole(b);
    int np = hpr_cell_corners(a, &whole_a, p), nq = hpr_cell_corners(b, &whole_b, q);
    return hpr_polygon_distance(p, np, q, nq);
}

/* True if an edge of `a` goes through `b`. */
static bool edge_through(const hpr_element_frame *a, const hpr_element_frame *b)
{
    hpr_vec3 p[4];
    hpr_cell whole = hpr_cell_whole(a);
    int n = hpr_cell_corners(a, &whole, p);
    for (int i = 0; i < n; i++) {
        hpr_vec3 from = hpr_sub(p[i], b->origin), along = hpr_sub(p[(i + 1) % n], p[i]);
        double f = -hpr_dot(from, b->normal) / hpr_dot(along, b->normal);
        if (!(f >= 0 && f <= 1))
            continue;
        hpr_vec3 across = hpr_cross(b->edge1, b->edge2), x = hpr_madd(from, f, along);
        double s = hpr_dot(hpr_cross(x, b->edge2), across) / hpr_dot(across, across);
        double t = hpr_dot(hpr_cross(b->edge1, x), across) / hpr_dot(across, across);
        if (s >= 0 && t >= 0 && (b->shape == T ? s + t <= 1 : s <= 1 && t <= 1))
            return true;
    }
    return false;
}

/* The next pair of the sequence at least a tenth of the smaller size apart that sees each other. Planes may
 * cut. */
static void random_pair(uint64_t *seed, hpr_element_frame *a, hpr_element_frame *b)
{
    double block[256];
    for (;;) {
        double centre[3] = {0}, other[3];
        random_vector(seed, 0.5 + 2 * shapes_random(seed), other);
        *a = random_frame(seed, 1, centre);
        *b = random_frame(seed, 0.3 + 1.2 * shapes_random(seed), other);
        double size = fmin(frame_size(a), frame_size(b));
        if (!edge_through(a, b) && !edge_through(b, a) && frame_distance(a, b) >= 0.1 * size &&
            block_of(a, b, 1e-2, block).seen)
            return;
    }
}

enum { PAIRS = 60 };

/* Error of a block at each demand, against the same at 1e-13. */
static void tolerance_is_honoured(void **state)
{
    (void)state;
    static const double demand[] = {1e-4, 1e-6, 1e-8, 1e-10};
    enum { DEMANDS = sizeof demand / sizeof *demand };
    double worst[DEMANDS] = {0}, cost[DEMANDS + 1] = {0};
    int worst_pair[DEMANDS] = {0}, missed = 0;
    uint64_t seed = 2026;
    for (int pair = 0; pair < PAIRS; pair++) {
        hpr_element_frame a, b;
        random_pair(&seed, &a, &b);
        size_t count = frame_basis(&a) * frame_basis(&b);
        cost[DEMANDS] += (double)block_of(&a, &b, 1e-13, block_a).kernel_count;
        double largest = largest_entry(block_a, count);
        for (int d = 0; d < DEMANDS; d++) {
            hpr_block_result result = block_of(&a, &b, demand[d], block_b);
            if (result.status >= HPR_BLOCK_SHORT) {
                print_error("pair %d stopped short of %.0e\n", pair, demand[d]);
                missed++;
            }
            cost[d] += (double)result.kernel_count;
            double error = 0;
            for (size_t k = 0; k < count; k++)
                error = fmax(error, fabs(block_a[k] - block_b[k]));
            double ratio = error / (demand[d] * largest);
            if (ratio > worst[d]) {
                worst[d] = ratio;
                worst_pair[d] = pair;
            }
            if (ratio > 1) {
                missed++;
                print_error("pair %d (%s degree %d, %s degree %d, distance %.3g of sizes %.3g, %.3g): "
                            "demanded %.0e, error %.2e, K^00 %.3g, largest %.3g\n",
                            pair, a.shape == T ? "triangle" : "parallelogram", a.degree,
                            b.shape == T ? "triangle" : "parallelogram", b.degree, frame_distance(&a, &b),
                            frame_size(&a), frame_size(&b), demand[d], error / largest, block_a[0], largest);
            }
        }
    }
    for (int d = 0; d < DEMANDS; d++)
        print_message("demanded %.0e: worst error %.1e of the demand (pair %d), kernels per pair %.3g\n",
                      demand[d], worst[d], worst_pair[d], cost[d] / PAIRS);
    print_message("reference 1e-13: kernels per pair %.3g\n", cost[DEMANDS] / PAIRS);
    assert_int_equal(missed, 0);
}

static hpr_element_frame moved(const hpr_element_frame *f, double scale, double offset)
{
    double corner[3][3];
    for (int i = 0; i < 3; i++) {
        hpr_vec3 p = hpr_frame_point(f, i == 1, i == 2);
        hpr_vec3_store(corner[i],
                       (hpr_vec3){scale * p.x + offset, scale * p.y + offset, scale * p.z + offset});
    }
    return frame_of(f->shape, f->degree, corner[0], corner[1], corner[2]);
}

/* The corners of a frame as numbers, so that scaled copies of it are exact. */
static hpr_element_frame rounded(const hpr_element_frame *f)
{
    return moved(f, 1, 0);
}

static void scaling_by_powers_of_two_changes_no_bit(void **state)
{
    (void)state;
    static const int power[] = {-40, -7, 1, 20};
    int compared = 0;
    for (size_t i = 0; i < sizeof reciprocals / sizeof *reciprocals; i++) {
        const reciprocal *r = &reciprocals[i];
        hpr_element_frame a = frame_of(r->recv_shape, 2, r->recv[0], r->recv[1], r->recv[2]);
        hpr_element_frame b = frame_of(r->send_shape, 3, r->send[0], r->send[1], r->send[2]);
        a = rounded(&a);
        b = rounded(&b);
        size_t count = frame_basis(&a) * frame_basis(&b);
        block_of(&a, &b, 1e-8, block_a);
        for (int k = 0; k < 4; k++) {
            hpr_element_frame c = moved(&a, ldexp(1, power[k]), 0), d = moved(&b, ldexp(1, power[k]), 0);
            block_of(&c, &d, 1e-8, block_b);
            for (size_t n = 0; n < count; n++) {
                if (block_a[n] != block_b[n])
                    fail_msg("%s at 2^%d: entry %zu is %.17g, not %.17g", r->name, power[k], n, block_b[n],
                             block_a[n]);
            }
            compared++;
        }
    }
    print_message("%d blocks equal bit for bit\n", compared);
}

/* 1e3 away, a coordinate keeps 1e-13; near pairs (distance 0.1) turn that into 1e-11. */
static void translation_changes_little(void **state)
{
    (void)state;
    double worst = 0;
    for (size_t i = 0; i < sizeof reciprocals / sizeof *reciprocals; i++) {
        const reciprocal *r = &reciprocals[i];
        hpr_element_frame a = frame_of(r->recv_shape, 3, r->recv[0], r->recv[1], r->recv[2]);
        hpr_element_frame b = frame_of(r->send_shape, 3, r->send[0], r->send[1], r->send[2]);
        hpr_element_frame c = moved(&a, 1, 1e3 + 1.0 / 3), d = moved(&b, 1, 1e3 + 1.0 / 3);
        size_t count = frame_basis(&a) * frame_basis(&b);
        block_of(&a, &b, demanded, block_a);
        block_of(&c, &d, demanded, block_b);
        double error = 0, largest = largest_entry(block_a, count);
        for (size_t n = 0; n < count; n++)
            error = fmax(error, fabs(block_a[n] - block_b[n]) / largest);
        if (!(error <= 1e-10))
            fail_msg("%s: changed by %.2e of the largest entry, bound 1e-10", r->name, error);
        worst = fmax(worst, error);
    }
    print_message("moved by 1000.33 in x, y, z: worst change %.1e of the largest entry, bound 1e-10\n",
                  worst);
}

/* What the budget does not reach is completed roughly: the block says so, and by how much it may err. */
static void budget_is_kept_and_said(void **state)
{
    (void)state;
    const double gap = 0.1, low[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double high[4][3] = {{0, 0, gap}, {0.2, 1, gap}, {1.1, 1.2, gap}, {0.9, 0.2, gap}};
    hpr_block_task task = {
        .recv = frame_of_corners(1, 4, low), .send = frame_of_corners(1, 4, high), .tolerance = 1e-9};
    hpr_block_result full = hpr_block_ref(bench.quadrature, &task, block_a, bench.scratch);
    task.kernel_limit = 1000000;
    hpr_block_result cut = hpr_block_ref(bench.quadrature, &task, block_b, bench.scratch);
    double error = 0;
    for (int k = 0; k < 16; k++)
        error = fmax(error, fabs(block_b[k] - block_a[k]));
    print_message("%.2e kernels instead of %.2e: off by %.2e, estimated %.2e\n", (double)cut.kernel_count,
                  (double)full.kernel_count, error, cut.error);
    assert_int_equal(full.status, HPR_BLOCK_WITHIN);
    assert_int_equal(cut.status, HPR_BLOCK_SHORT);
    assert_true(cut.kernel_count < full.kernel_count / 8); /* seen: a 27th, 16 for each rule */
    assert_true(error <= cut.error && cut.error < 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(form_factors_of_the_open_set),
        cmocka_unit_test(moments_of_the_open_set),
        cmocka_unit_test(constants_give_the_form_factor),
        cmocka_unit_test(blocks_are_reciprocal),
        cmocka_unit_test(tolerance_is_honoured),
        cmocka_unit_test(scaling_by_powers_of_two_changes_no_bit),
        cmocka_unit_test(translation_changes_little),
        cmocka_unit_test(budget_is_kept_and_said),
    };
    return cmocka_run_group_tests(tests, bench_open, bench_close);
}
