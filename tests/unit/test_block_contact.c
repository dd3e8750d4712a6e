/* Kernel blocks of whole enclosures, which close, and of patches that meet otherwise than edge to edge. */
#include "blocks.h"
#include "contour.h"

#include <string.h>

#define Q HPR_SHAPE_PARALLELOGRAM
#define T HPR_SHAPE_TRIANGLE

static const double demanded = 1e-12;

static double block[HPR_MAX_BASIS * HPR_MAX_BASIS];

enum { FACES_MAX = 12, CLOSURE_DEGREE = 8 };

/* A closed room: its faces, and what int_i int_j G is, i < j. */
typedef struct enclosure {
    const char *name;
    int count;
    hpr_element_frame face[FACES_MAX];
    double exact[FACES_MAX][FACES_MAX];
} enclosure;

typedef struct enclosure_errors {
    double closure; /* largest |sum_j sqrt(Aj) K_ij^{k0} - sqrt(Ai) delta_k0| / sqrt(Ai) */
    double entry;   /* largest relative error of K_ij^00 */
    int short_count;
} enclosure_errors;

/* Each pair is integrated once, as the solver does, and its transpose taken for the other direction. */
static enclosure_errors errors_of(const enclosure *e)
{
    static double sum[FACES_MAX][HPR_MAX_BASIS];
    enclosure_errors errors = {0};
    memset(sum, 0, sizeof sum);
    for (int i = 0; i < e->count; i++) {
        for (int j = i + 1; j < e->count; j++) {
            const hpr_element_frame *a = &e->face[i], *b = &e->face[j];
            size_t n = frame_basis(a), m = frame_basis(b);
            double exact = e->exact[i][j] / sqrt(a->area_m2 * b->area_m2);
            errors.short_count += block_of(a, b, demanded, block).status >= HPR_BLOCK_SHORT;
            for (size_t k = 0; k < n; k++)
                sum[i][k] += sqrt(b->area_m2) * block[k * m];
            for (size_t k = 0; k < m; k++)
                sum[j][k] += sqrt(a->area_m2) * block[k];
            errors.entry = fmax(errors.entry, exact > 0 ? fabs(block[0] / exact - 1) : fabs(block[0]));
        }
    }
    for (int i = 0; i < e->count; i++) {
        double own = sqrt(e->face[i].area_m2);
        for (size_t k = 0; k < frame_basis(&e->face[i]); k++)
            errors.closure = fmax(errors.closure, fabs(sum[i][k] / own - (k == 0)));
    }
    return errors;
}

/* Each of up to 11 blocks is demanded to 1e-12 of its largest entry; worst seen: 4e-14. */
static void check_enclosure(enclosure *e, int highest)
{
    static const double bound = 1e-12;
    int failures = 0;
    for (int degree = 0; degree <= highest; degree++) {
        for (int i = 0; i < e->count; i++)
            e->face[i].degree = degree;
        enclosure_errors errors = errors_of(e);
        print_message("%-22s degree %d: closure to %.1e, K^00 to %.1e, bound %.0e, %d blocks short\n",
                      e->name, degree, errors.closure, errors.entry, bound, errors.short_count);
        failures += !(errors.closure <= bound && errors.entry <= bound) || errors.short_count;
    }
    assert_int_equal(failures, 0);
}

/* The six inward faces of [0,a] x [0,b] x [0,c]: first corner, second, last, and the one opposite. */
static void box_corners(double a, double b, double c, double corner[6][4][3])
{
    const double face[6][4][3] = {
        {{0, 0, 0}, {0, b, 0}, {0, b, c}, {0, 0, c}}, {{a, 0, 0}, {a, 0, c}, {a, b, c}, {a, b, 0}},
        {{0, 0, 0}, {0, 0, c}, {a, 0, c}, {a, 0, 0}}, {{0, b, 0}, {a, b, 0}, {a, b, c}, {0, b, c}},
        {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0}}, {{0, 0, c}, {0, b, c}, {a, b, c}, {a, 0, c}}};
    memcpy(corner, face, sizeof face);
}

/* Faces 2k and 2k + 1 are opposite, perpendicular to axis k. */
static double box_exchange(const double side[3], int i, int j)
{
    const double first[2] = {0, side[i / 2]}, second[2] = {0, side[j / 2]};
    if (i / 2 != j / 2) {
        /* the third axis is the common edge; i extends along axis j and j along axis i */
        const double edge[2] = {0, side[3 - i / 2 - j / 2]};
        return exchange_perpendicular(second, edge, first, edge);
    }
    const double x[2] = {0, side[(i / 2 + 1) % 3]}, y[2] = {0, side[(i / 2 + 2) % 3]};
    return exchange_parallel(x, y, x, y, side[i / 2]);
}

static void check_box(const char *name, double a, double b, double c, int highest)
{
    const double side[3] = {a, b, c};
    double corner[6][4][3];
    enclosure e = {.name = name, .count = 6};
    box_corners(a, b, c, corner);
    for (int i = 0; i < 6; i++) {
        e.face[i] = frame_of(Q, 0, corner[i][0], corner[i][1], corner[i][3]);
        for (int j = 0; j < 6; j++)
            e.exact[i][j] = i == j ? 0 : box_exchange(side, i, j);
    }
    check_enclosure(&e, highest);
}

static void cube_closes(void **state)
{
    (void)state;
    check_box("cube", 1, 1, 1, CLOSURE_DEGREE);
}

static void box_closes(void **state)
{
    (void)state;
    check_box("box 1.5 x 0.75 x 2", 1.5, 0.75, 2, CLOSURE_DEGREE);
}

/* Its blocks of faces that are near each other take minutes at higher degrees. */
static void long_flat_box_closes(void **state)
{
    (void)state;
    check_box("box 1 x 0.3 x 7", 1, 0.3, 7, 3);
}

/* Convex: every pair sees each other wholly, so the contour integral holds. */
static void check_triangles(const char *name, int count, const double (*corner)[3][3], int highest)
{
    enclosure e = {.name = name, .count = count};
    for (int i = 0; i < count; i++) {
        e.face[i] = frame_of(T, 0, corner[i][0], corner[i][1], corner[i][2]);
        for (int j = 0; j < i; j++)
            e.exact[j][i] = hpr_dot(e.face[i].normal, e.face[j].normal) < 1 - 1e-9
                                ? contour_exchange(3, corner[j], 3, corner[i])
                                : 0; /* halves of one face */
    }
    check_enclosure(&e, highest);
}

static void tetrahedron_closes(void **state)
{
    (void)state;
    const double v[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    static const int order[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    double corner[4][3][3];
    for (int i = 0; i < 12; i++)
        memcpy(corner[i / 3][i % 3], v[order[i / 3][i % 3]], sizeof v[0]);
    check_triangles("tetrahedron", 4, (const double(*)[3][3])corner, CLOSURE_DEGREE);
}

/* Diagonals alternate, so that edges, vertices and opposite triangles meet in all ways. */
static void triangulated_box_closes(void **state)
{
    (void)state;
    double corner[6][4][3], half[12][3][3];
    box_corners(1, 0.75, 1.25, corner);
    for (int i = 0; i < 12; i++) {
        int odd = i / 2 % 2;
        for (int k = 0; k < 3; k++)
            memcpy(half[i][k], corner[i / 2][(odd + (k ? k + i % 2 : 0)) % 4], sizeof half[i][k]);
    }
    check_triangles("triangulated box", 12, (const double(*)[3][3])half, CLOSURE_DEGREE);
}

/* A rectangle in z = 0 facing up, in x = `at` facing +x (y, z extents) and in y = `at` facing +y (x, z). */
static hpr_element_frame floor_at(double x0, double x1, double y0, double y1)
{
    return frame_of(Q, 0, (double[]){x0, y0, 0}, (double[]){x1, y0, 0}, (double[]){x0, y1, 0});
}

static hpr_element_frame wall_at(double x, double y0, double y1, double z0, double z1)
{
    return frame_of(Q, 0, (double[]){x, y0, z0}, (double[]){x, y1, z0}, (double[]){x, y0, z1});
}

static void assert_exchange(const char *what, double got, double want, double bound)
{
    double error = want != 0 ? fabs(got / want - 1) : fabs(got);
    print_message("%-56s %.16g, expected %.16g, error %.1e, bound %.0e\n", what, got, want, error, bound);
    assert_true(error <= bound);
}

/* As exchange_of, but a rule that runs out of nodes is let pass: the error shows. */
static double exchange(const hpr_element_frame *a, const hpr_element_frame *b)
{
    double k;
    block_of(a, b, demanded, &k);
    return k * sqrt(a->area_m2 * b->area_m2);
}

/*
 * A square stands in the middle of a larger one: only what is in front of it counts (x > 0), and that falls
 * into a rectangle along its foot and two that touch a corner of the foot.
 */
static void standing_square_equals_its_aligned_parts(void **state)
{
    (void)state;
    hpr_element_frame ground = floor_at(-1, 1, -1, 1), wall = wall_at(0, -0.25, 0.5, 0, 0.75);
    hpr_element_frame part[3] = {floor_at(0, 1, -0.25, 0.5), floor_at(0, 1, -1, -0.25),
                                 floor_at(0, 1, 0.5, 1)};
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += exchange(&wall, &part[i]);
    double closed = exchange_perpendicular((double[]){0, 1}, (double[]){-1, 1}, (double[]){0, 0.75},
                                           (double[]){-0.25, 0.5});
    /* three blocks at 1e-12 each, and the whole one */
    assert_exchange("square standing on a larger one, against its parts", exchange(&wall, &ground), sum,
                    5e-12);
    assert_exchange("the same, against the closed form", exchange(&ground, &wall), closed, 5e-12);
}

/* Edges on one line, one reaching past the other's both ends, or sharing one end. */
static void partial_edges_equal_their_closed_forms(void **state)
{
    (void)state;
    static const double extent[][2] = {{0.25, 0.75}, {0.25, 1.25}, {-0.5, 1.5}, {0, 0.5}, {1, 1.75}};
    for (size_t i = 0; i < sizeof extent / sizeof *extent; i++) {
        hpr_element_frame ground = floor_at(0, 1, 0, 1);
        hpr_element_frame wall = wall_at(0, extent[i][0], extent[i][1], 0, 1);
        double closed =
            exchange_perpendicular((double[]){0, 1}, (double[]){0, 1}, (double[]){0, 1}, extent[i]);
        char what[64];
        snprintf(what, sizeof what, "edge [0, 1] against edge [%g, %g]", extent[i][0], extent[i][1]);
        assert_exchange(what, exchange(&ground, &wall), closed, 5e-12);
    }
}

/* A wall that goes on below the floor's plane is cut there: rectangle, then an oblique triangle by hand. */
static void penetrating_patches_are_cut(void **state)
{
    (void)state;
    hpr_element_frame ground = floor_at(0, 1, 0, 1), deep = wall_at(-0.5, 0, 1, -0.7, 1);
    double closed =
        exchange_perpendicular((double[]){0.5, 1.5}, (double[]){0, 1}, (double[]){0, 1}, (double[]){0, 1});
    assert_exchange("wall reaching below the floor, apart", exchange(&ground, &deep), closed, 5e-12);
    /* through the floor itself: in front of the wall lies 0.25 .. 1, over the floor 0 .. 1 */
    hpr_element_frame through = wall_at(0.25, 0.25, 0.75, -0.5, 1);
    closed = exchange_perpendicular((double[]){0, 0.75}, (double[]){0, 1}, (double[]){0, 1},
                                    (double[]){0.25, 0.75});
    assert_exchange("wall through the floor", exchange(&ground, &through), closed, 5e-12);
    /* A triangle from z = -1 to z = 1 above and below the middle of two of its edges, leaning over. */
    const double tip[3] = {2.5, 0.5, 1}, low0[3] = {2.5, 1.5, -1}, low1[3] = {1.5, -0.5, -1};
    const double cut0[3] = {2.5, 1, 0}, cut1[3] = {2, 0, 0};
    hpr_element_frame whole = frame_of(T, 0, tip, low0, low1), part = frame_of(T, 0, tip, cut0, cut1);
    assert_true(exchange(&part, &ground) > 1e-3);
    assert_exchange("triangle cut by the floor's plane", exchange(&ground, &whole), exchange(&ground, &part),
                    5e-12);
}

/* Zero means zero, and is said to be unseen, at a degree too. */
static void assert_unseen(const char *what, hpr_element_frame a, hpr_element_frame b)
{
    a.degree = b.degree = 2;
    for (int turn = 0; turn < 2; turn++) {
        memset(block, 0xff, sizeof block);
        hpr_block_result result =
            turn ? block_of(&b, &a, demanded, block) : block_of(&a, &b, demanded, block);
        double largest = largest_entry(block, frame_basis(&a) * frame_basis(&b));
        print_message("%-56s largest entry %g, kernels %llu\n", what, largest,
                      (unsigned long long)result.kernel_count);
        assert_true(largest == 0 && !result.seen && result.kernel_count == 0);
    }
}

static void what_cannot_see_each_other_is_zero(void **state)
{
    (void)state;
    hpr_element_frame ground = floor_at(0, 1, 0, 1);
    assert_unseen("coplanar, shared edge", ground, floor_at(1, 2, 0, 1));
    assert_unseen("coplanar, apart", ground, floor_at(3, 4, 1, 2));
    assert_unseen("coplanar, overlapping", ground, floor_at(0.5, 2, 0.5, 1));
    assert_unseen("one above the other, both facing up", ground,
                  frame_of(Q, 0, (double[]){0, 0, 1}, (double[]){1, 0, 1}, (double[]){0, 1, 1}));
    assert_unseen("back to back", ground,
                  frame_of(Q, 0, (double[]){0, 0, 0}, (double[]){0, 1, 0}, (double[]){1, 0, 0}));
    assert_unseen("convex edge", ground, wall_at(1, 0, 1, -1, 0));
    assert_unseen("wall facing away, shared edge", ground,
                  frame_of(Q, 0, (double[]){0, 0, 0}, (double[]){0, 0, 1}, (double[]){0, 1, 0}));
    assert_unseen("tilted triangles in one plane",
                  frame_of(T, 0, (double[]){0, 0, 0}, (double[]){1, 0, 1}, (double[]){0, 1, 0.5}),
                  frame_of(T, 0, (double[]){1, 1, 1.5}, (double[]){0, 1, 0.5}, (double[]){1, 0, 1}));
}

/*
 * A triangle on an edge of a square's half, turned up by 5e-9 rad, whose other edge runs over the diagonal at
 * up to 2^-28: what it does not see of that half it sees of the other, through a strip as narrow as that gap,
 * in which no node lies by itself. Contour integrals, 40 digits. The rounding of coordinates moves the fluxes
 * by no more than some roundoffs, and the two fractions add up to at most 1.
 */
static void slit_over_an_edge_is_seen(void **state)
{
    (void)state;
    static const double bound = 1e-14; /* seen: 5e-15 */
    static const double corner[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0x1p-28}};
    static const double exact[2] = {0.99999999736582194951, 2.6341780227343155544e-9};
    hpr_element_frame upper = frame_of(T, 0, corner[1], corner[0], corner[4]), half[2];
    half[0] = frame_of(T, 0, corner[0], corner[1], corner[2]);
    half[1] = frame_of(T, 0, corner[0], corner[2], corner[3]);
    double sum = 0;
    for (int i = 0; i < 2; i++) {
        hpr_block_task task = {.recv = upper, .send = half[i], .tolerance = 1e-13};
        hpr_block_result result = hpr_block(bench.quadrature, &task, block, bench.scratch);
        double to_fraction = sqrt(half[i].area_m2 / upper.area_m2), fraction = to_fraction * block[0];
        print_message("slit, half %d: %.17g, off by %.2e, estimated %.2e\n", i, fraction, fraction - exact[i],
                      to_fraction * result.error);
        assert_true(fabs(fraction - exact[i]) <= bound);
        assert_true(fabs(fraction - exact[i]) <= to_fraction * result.error);
        sum += fraction;
    }
    assert_true(sum <= 1 + bound);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_closes),
        cmocka_unit_test(box_closes),
        cmocka_unit_test(long_flat_box_closes),
        cmocka_unit_test(tetrahedron_closes),
        cmocka_unit_test(triangulated_box_closes),
        cmocka_unit_test(standing_square_equals_its_aligned_parts),
        cmocka_unit_test(partial_edges_equal_their_closed_forms),
        cmocka_unit_test(penetrating_patches_are_cut),
        cmocka_unit_test(what_cannot_see_each_other_is_zero),
        cmocka_unit_test(slit_over_an_edge_is_seen),
    };
    return cmocka_run_group_tests(tests, bench_open, bench_close);
}
