/* Blocks of parallelograms whose edges run along the same two directions in parallel planes, or along one in
 * any planes: against product Gauss on many panels, and where nothing else is as exact against sums over the
 * parts of one side. */
#include "blocks.h"
#include "quadrature/aligned.h"
#include "quadrature/parallel.h"

#include <float.h>

enum { DEGREE_MAX = 5, BASIS_MAX = (DEGREE_MAX + 1) * (DEGREE_MAX + 1), PANELS = 4, NODES = 12 };
enum { POINTS = PANELS * NODES * PANELS * NODES };

static double block[BASIS_MAX * BASIS_MAX], sum[BASIS_MAX * BASIS_MAX], part[BASIS_MAX * BASIS_MAX];

/* Two parallelograms by origin and edges; the receiver looks up. */
typedef struct placed {
    const char *name;
    bool parallel; /* two directions in common; else one */
    int recv_degree, send_degree;
    double recv[3][3], send[3][3]; /* origin, edge1, edge2 */
} placed;

static const placed cases[] = {
    {"squares", true, 3, 3, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0.3}, {0, 1, 0}, {1, 0, 0}}},
    {"turned half round",
     true,
     2,
     3,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{1, 1, 0.3}, {0, -1, 0}, {-1, 0, 0}}},
    {"edge1 against edge1",
     true,
     3,
     2,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{1, 0, 0.3}, {-1, 0, 0}, {0, 1, 0}}},
    {"edge2 against edge2",
     true,
     1,
     4,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0, 1, 0.4}, {1, 0, 0}, {0, -1, 0}}},
    {"one within the other",
     true,
     3,
     2,
     {{0, 0, 0}, {1, 0, 0}, {0, 0.8, 0}},
     {{0.2, 0.1, 0.3}, {0, 0.3, 0}, {0.4, 0, 0}}},
    {"across each other",
     true,
     2,
     2,
     {{0, 0, 0}, {1, 0, 0}, {0, 0.3, 0}},
     {{0.4, -1, 0.3}, {0, 1.3, 0}, {0.2, 0, 0}}},
    {"beside each other",
     true,
     4,
     1,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{1.1, 0.3, 0.3}, {0, 1, 0}, {0.5, 0, 0}}},
    {"oblique",
     true,
     3,
     3,
     {{0, 0, 0}, {1, 0, 0}, {0.5, 0.8, 0}},
     {{0.3, 0.2, 0.3}, {0.25, 0.4, 0}, {1.2, 0, 0}}},
    {"oblique, turned in space",
     true,
     2,
     3,
     {{1, 2, 3}, {0.6, 0.64, 0.48}, {-0.8, 0.48, 0.36}},
     {{0.96, 1.74, 3.39}, {-0.8, 0.48, 0.36}, {0.6, 0.64, 0.48}}},
    {"constant against degree 5",
     true,
     0,
     5,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0.1, 0, 0.3}, {0, 1, 0}, {1, 0, 0}}},
    {"walls", false, 3, 2, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{-0.3, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
    {"a wall that stands over it",
     false,
     2,
     3,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0, 0.2, 0.3}, {0, 0, 0.8}, {0, -1.3, 0}}},
    {"inclined", false, 3, 3, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0.2, 0, 0.3}, {0, 1, 0}, {0.8, 0, 0.3}}},
    {"inclined, shifted and longer",
     false,
     1,
     4,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0.2, 1.4, 0.5}, {0.4, 0, -0.1}, {0, -1.2, 0}}},
    {"slanted, one in the other's shadow",
     false,
     2,
     2,
     {{0, 0, 0}, {1, 0.3, 0}, {0, 0.8, 0}},
     {{-0.3, 0.2, 0.1}, {0, 0.4, 0}, {0.1, 0.2, 0.7}}},
    {"slanted, against each other",
     false,
     3,
     1,
     {{0, 0, 0}, {0, 1, 0}, {-1, 0.4, 0}},
     {{0.3, 0.8, 0.6}, {0, 0.1, -0.6}, {0, -1, 0}}},
    {"parallel planes, one direction",
     false,
     2,
     3,
     {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0, 0, 0.3}, {0, 1, 0}, {0.9, 0.2, 0}}},
    {"turned in space",
     false,
     3,
     0,
     {{1, 2, 3}, {0.6, 0.64, 0.48}, {-0.8, 0.48, 0.36}},
     {{0.7, 1.28, 3.36}, {-0.8, 0.48, 0.36}, {0, -0.6, 0.8}}},
};

static bool is_found(const placed *c, const hpr_pair *pair, double tolerance)
{
    hpr_parallel parallel;
    hpr_aligned aligned;
    return c->parallel ? hpr_parallel_find(pair, tolerance, &parallel)
                       : hpr_aligned_find(pair, tolerance, &aligned);
}

static hpr_element_frame frame_at(int degree, const double at[3][3])
{
    double corner[3][3];
    for (int i = 0; i < 3; i++) {
        corner[0][i] = at[0][i];
        corner[1][i] = at[0][i] + at[1][i];
        corner[2][i] = at[0][i] + at[2][i];
    }
    return frame_of(HPR_SHAPE_PARALLELOGRAM, degree, corner[0], corner[1], corner[2]);
}

/* Points of one side with weight times T_k. */
typedef struct side {
    hpr_vec3 point[POINTS];
    double weighted[POINTS][BASIS_MAX];
} side;

static side recv_side, send_side;

static void fill_side(const hpr_element_frame *f, side *to)
{
    const hpr_gauss_rule *gauss = &hpr_gauss.legendre[NODES];
    size_t n = frame_basis(f);
    for (int p = 0; p < POINTS; p++) {
        int i = p % (PANELS * NODES), j = p / (PANELS * NODES);
        double s = (i / NODES + gauss->node[i % NODES]) / PANELS,
               t = (j / NODES + gauss->node[j % NODES]) / PANELS;
        double weight = gauss->weight[i % NODES] * gauss->weight[j % NODES] / (PANELS * PANELS) * f->area_m2 *
                        hpr_frame_scale(f);
        to->point[p] = hpr_frame_point(f, s, t);
        hpr_frame_basis(f, s, t, to->weighted[p]);
        for (size_t k = 0; k < n; k++)
            to->weighted[p][k] *= weight;
    }
}

/* Product Gauss on PANELS^4 panels, in doubles as they come. */
static void sum_products(const hpr_element_frame *recv, const hpr_element_frame *send, double *to)
{
    size_t n_recv = frame_basis(recv), n_send = frame_basis(send);
    fill_side(recv, &recv_side);
    fill_side(send, &send_side);
    memset(to, 0, n_recv * n_send * sizeof *to);
    for (int i = 0; i < POINTS; i++) {
        double row[BASIS_MAX] = {0};
        for (int j = 0; j < POINTS; j++) {
            hpr_vec3 d = hpr_sub(send_side.point[j], recv_side.point[i]);
            double r2 = hpr_dot(d, d),
                   kernel = -hpr_dot(recv->normal, d) * hpr_dot(send->normal, d) / (r2 * r2);
            for (size_t l = 0; l < n_send; l++)
                row[l] += kernel / 3.14159265358979323846 * send_side.weighted[j][l];
        }
        for (size_t k = 0; k < n_recv; k++) {
            for (size_t l = 0; l < n_send; l++)
                to[k * n_send + l] += recv_side.weighted[i][k] * row[l];
        }
    }
}

/* Panels of 1/4 at a distance of 0.3 leave (b + sqrt(b^2 + 1))^-24, b = 2.4: 1e-16 times the 64 of
 * hpr_kernel_error; worst seen 6e-15, and 1e-11 with a tolerance of 1e-8. */
static void products_give_the_same(void **state)
{
    (void)state;
    static const double tolerances[] = {1e-13, 1e-8, 1e-4};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const placed *c = &cases[i];
        hpr_element_frame recv = frame_at(c->recv_degree, c->recv), send = frame_at(c->send_degree, c->send);
        size_t count = frame_basis(&recv) * frame_basis(&send);
        hpr_pair pair;
        hpr_pair_init(&pair, &recv, &send);
        assert_true(is_found(c, &pair, 1e-13));
        sum_products(&recv, &send, sum);
        for (size_t t = 0; t < sizeof tolerances / sizeof *tolerances; t++) {
            hpr_block_result result = block_of(&recv, &send, tolerances[t], block);
            double error = 0, bound = fmax(tolerances[t], 2e-14) * largest_entry(sum, count);
            for (size_t n = 0; n < count; n++)
                error = fmax(error, fabs(block[n] - sum[n]));
            print_message("%s, tolerance %.0e: %llu kernels, off by %.1e, estimated %.1e\n", c->name,
                          tolerances[t], (unsigned long long)result.kernel_count, error, result.error);
            assert_true(error <= bound && error <= fmax(result.error, bound / 10));
            assert_int_equal(result.status, HPR_BLOCK_WITHIN);
        }
    }
}

/* The sender in `cut` parts along edge1, constants: sqrt(A) K_k0 adds up. */
static double off_by_parts(const hpr_element_frame *recv, const hpr_element_frame *send, double at)
{
    size_t count = frame_basis(recv);
    block_of(recv, send, 1e-13, block);
    memset(sum, 0, sizeof sum);
    for (int i = 0; i < 2; i++) {
        hpr_element_frame half = *send;
        double length = i ? 1 - at : at;
        if (i)
            half.origin = hpr_madd(half.origin, at, half.edge1);
        half.edge1 = hpr_scale(half.edge1, length);
        half.area_m2 *= length;
        block_of(recv, &half, 1e-13, part);
        for (size_t k = 0; k < count; k++)
            sum[k] += part[k] * sqrt(length);
    }
    double error = 0;
    for (size_t k = 0; k < count; k++)
        error = fmax(error, fabs(sum[k] - block[k]));
    return error / largest_entry(block, count);
}

/* Gaps down to a millionth of the size, where the pair nearly counts as touching; worst seen 1.2e-14. */
static void parts_add_up_however_near(void **state)
{
    (void)state;
    static const double bound = 5e-14;
    for (size_t i = 0; i < sizeof cases / sizeof *cases && cases[i].parallel; i++) {
        for (double gap = 0.1; gap > 5e-7; gap /= 10) {
            hpr_element_frame recv = frame_at(4, cases[i].recv), send = frame_at(0, cases[i].send);
            double height = hpr_dot(recv.normal, hpr_sub(send.origin, recv.origin));
            send.origin = hpr_madd(send.origin, gap - height, recv.normal);
            double error = off_by_parts(&recv, &send, 0.37);
            print_message("%s, gap %.0e: off by %.1e\n", cases[i].name, gap, error);
            assert_true(error <= bound);
        }
    }
}

/* Walls that come near, and one that goes through the plane; worst seen 1.1e-15. */
static void parts_of_walls_add_up(void **state)
{
    (void)state;
    static const double bound = 5e-15;
    static const double wall[3][3] = {{-0.1, 0.2, 0}, {0, 1, 0}, {0, 0, 1}},
                        floor_at[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (int inclined = 0; inclined < 2; inclined++) {
        for (double gap = 0.1; gap > 5e-5; gap /= 10) {
            hpr_element_frame recv = frame_at(4, floor_at), send = frame_at(0, wall);
            send.origin.x = -gap;
            if (inclined) { /* through the floor's plane, which it meets at a distance of gap */
                send.origin = (hpr_vec3){-gap - 0.2, 0.2, -0.1};
                send.edge2 = (hpr_vec3){0.8, 0, 0.4};
                send.area_m2 = hpr_length(send.edge2);
                send.normal = hpr_scale(hpr_cross(send.edge1, send.edge2), 1 / send.area_m2);
            }
            double error = off_by_parts(&recv, &send, 0.37);
            print_message("%s, gap %.0e: off by %.1e\n", inclined ? "inclined" : "upright", gap, error);
            assert_true(error <= bound);
        }
    }
}

/* What is not parallel is none of them, however little it is off; what only rounding turns is. */
static void others_are_refused(void **state)
{
    (void)state;
    const placed *c = &cases[0];
    hpr_parallel parallel;
    hpr_pair pair;
    for (int i = 0; i < 3; i++) {
        hpr_element_frame recv = frame_at(1, c->recv), send = frame_at(1, c->send);
        double *moved = i == 0 ? &send.edge1.z : i == 1 ? &send.edge1.x : &send.edge2.y;
        *moved += 1e-10;
        hpr_pair_init(&pair, &recv, &send);
        assert_false(hpr_parallel_find(&pair, 1e-10, &parallel));
        assert_true(hpr_parallel_find(&pair, 1e-7, &parallel));
        *moved = DBL_EPSILON;
        hpr_pair_init(&pair, &recv, &send);
        assert_true(hpr_parallel_find(&pair, 1e-15, &parallel));
    }
    hpr_element_frame recv = frame_at(1, c->recv), turned = frame_at(1, c->send);
    turned.edge1 = (hpr_vec3){0.6, 0.8, 0};
    turned.edge2 = (hpr_vec3){0.8, -0.6, 0};
    hpr_pair_init(&pair, &recv, &turned);
    assert_false(hpr_parallel_find(&pair, 1e-3, &parallel));
    hpr_aligned aligned;
    assert_false(hpr_aligned_find(&pair, 1e-3, &aligned));
    turned.edge1.z = 1e-10;
    turned.edge1.y = 1e-10;
    turned.edge1.x = 1;
    hpr_pair_init(&pair, &recv, &turned);
    assert_false(hpr_aligned_find(&pair, 1e-10, &aligned));
    assert_true(hpr_aligned_find(&pair, 1e-7, &aligned));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_give_the_same),
        cmocka_unit_test(parts_add_up_however_near),
        cmocka_unit_test(parts_of_walls_add_up),
        cmocka_unit_test(others_are_refused),
    };
    return cmocka_run_group_tests(tests, bench_open, bench_close);
}
