/*
 * A closed convex room of 300 triangles of very different sizes: every receiver closes at every degree up to
 * 8, but errors that cancel would close too, so that single entries are compared with other rules.
 */
#include "blocks.h"
#include "contour.h"
#include "convex_room.h"
#include "halving.h"
#include "lambert_outer.h"

static const double demanded = 1e-12;

/* Sums of 300 blocks, each demanded to 1e-12 of its largest entry. Worst seen: 1.7e-13;
 * entries of slivers 8e-13: rounding of the corners. */
static const double bound = 1e-12;

static convex_room room;
static hpr_element_frame face[CONVEX_ROOM_FACES];
static double contact_m;

static int open_room(void **state)
{
    convex_size most = {0, 0, 0}, least = {INFINITY, INFINITY, INFINITY};
    double slenderest = INFINITY;
    convex_room_make(&room, 2026);
    for (int i = 0; i < room.count; i++) {
        convex_size size = convex_measure((const double(*)[3])room.corner[i]);
        const double(*c)[3] = (const double(*)[3])room.corner[i];
        face[i] = frame_of(HPR_SHAPE_TRIANGLE, 0, c[0], c[1], c[2]);
        most.area = fmax(most.area, size.area);
        least.area = fmin(least.area, size.area);
        slenderest = fmin(slenderest, size.height / size.longest);
    }
    contact_m = 2e-13; /* as for a .vs3 model of this size */
    print_message("%d triangles, areas %.1e to %.1e, heights down to %.1e of the longest edge\n", room.count,
                  least.area, most.area, slenderest);
    return bench_open(state);
}

static hpr_block_result block_in_room(int i, int j, int recv_degree, int send_degree, double *block)
{
    hpr_block_task task = {.recv = face[i], .send = face[j], .tolerance = demanded, .contact_m = contact_m};
    task.recv.degree = recv_degree;
    task.send.degree = send_degree;
    return hpr_block(bench.quadrature, &task, block, bench.scratch);
}

/* Largest |sum_j sqrt(A_j) K_ij^{k0} - sqrt(A_i) delta_k0| / sqrt(A_i). */
static double closure_of(int i, int degree, int *short_count)
{
    static double block[HPR_MAX_BASIS * HPR_MAX_BASIS];
    double sum[HPR_MAX_BASIS] = {0}, worst = 0, own = sqrt(face[i].area_m2);
    size_t n = hpr_basis_count(HPR_SHAPE_TRIANGLE, degree);
    for (int j = 0; j < room.count; j++) {
        if (j == i)
            continue;
        *short_count += block_in_room(i, j, degree, degree, block).status >= HPR_BLOCK_SHORT;
        for (size_t k = 0; k < n; k++)
            sum[k] += sqrt(face[j].area_m2) * block[k * n];
    }
    for (size_t k = 0; k < n; k++)
        worst = fmax(worst, fabs(sum[k] / own - (k == 0)));
    return worst;
}

/* Every pair is integrated once. */
static void constants_close(void **state)
{
    (void)state;
    static double row[CONVEX_ROOM_FACES];
    double worst = 0;
    int short_count = 0;
    memset(row, 0, sizeof row);
    for (int i = 0; i < room.count; i++) {
        for (int j = i + 1; j < room.count; j++) {
            double block;
            short_count += block_in_room(i, j, 0, 0, &block).status >= HPR_BLOCK_SHORT;
            row[i] += sqrt(face[j].area_m2 / face[i].area_m2) * block;
            row[j] += sqrt(face[i].area_m2 / face[j].area_m2) * block;
        }
    }
    for (int i = 0; i < room.count; i++)
        worst = fmax(worst, fabs(row[i] - 1));
    print_message("all rows of view factors: closure to %.1e, bound %.0e, %d short\n", worst, bound,
                  short_count);
    assert_true(worst <= bound && short_count == 0);
}

/* The smallest, the most slender, the largest, then any. */
static int receiver(int k)
{
    int smallest = 0, slenderest = 0, largest = 0;
    double slender = INFINITY;
    for (int i = 0; i < room.count; i++) {
        convex_size size = convex_measure((const double(*)[3])room.corner[i]);
        smallest = face[i].area_m2 < face[smallest].area_m2 ? i : smallest;
        largest = face[i].area_m2 > face[largest].area_m2 ? i : largest;
        if (size.height / size.longest < slender) {
            slender = size.height / size.longest;
            slenderest = i;
        }
    }
    const int first[] = {smallest, slenderest, largest};
    return k < 3 ? first[k] : (k * 97) % room.count;
}

/* All 300 receivers would take half an hour: 4 up to degree 4, 2 above. */
static void polynomials_close(void **state)
{
    (void)state;
    for (int degree = 1; degree <= 8; degree++) {
        int count = degree <= 4 ? 4 : 2, short_count = 0;
        double worst = 0;
        for (int k = 0; k < count; k++)
            worst = fmax(worst, closure_of(receiver(k), degree, &short_count));
        print_message("degree %d, %d receivers: closure to %.1e, bound %.0e, %d short\n", degree, count,
                      worst, bound, short_count);
        assert_true(worst <= bound && short_count == 0);
    }
}

static void any_pair(uint64_t *seed, int pair[2])
{
    do {
        for (int i = 0; i < 2; i++)
            pair[i] = (int)(room.count * convex_random(seed));
    } while (hpr_dot(face[pair[0]].normal, face[pair[1]].normal) > 1 - 1e-6); /* of one face of the hull */
}

/* A1 F12 by whichever of the other rules is sure to 3e-13. */
static double exchange_otherwise(const int pair[2], int count[3])
{
    static const double sure = 3e-13;
    const double(*one)[3] = (const double(*)[3])room.corner[pair[0]],
          (*two)[3] = (const double(*)[3])room.corner[pair[1]];
    const hpr_element_frame *a = &face[pair[0]], *b = &face[pair[1]];
    double error, value = contour_exchange_within(3, one, 3, two, &error);
    int which = 0;
    for (int turn = 0; turn < 2 && error > sure * value; turn++) {
        value = turn ? lambert_exchange(two, one, &error) : lambert_exchange(one, two, &error);
        which = 1;
    }
    if (error > sure * value) {
        value = halving_entry(a, b, 0, 0, 30000) * sqrt(a->area_m2 * b->area_m2);
        which = 2;
    }
    count[which]++;
    return value;
}

static void view_factors_are_those_of_other_rules(void **state)
{
    (void)state;
    enum { ENTRIES = 200 };
    uint64_t seed = 1;
    int count[3] = {0, 0, 0}, wrong = 0;
    double worst = 0;
    for (int e = 0; e < ENTRIES; e++) {
        int pair[2];
        double block;
        any_pair(&seed, pair);
        block_in_room(pair[0], pair[1], 0, 0, &block);
        double value = block * sqrt(face[pair[0]].area_m2 * face[pair[1]].area_m2);
        double expected = exchange_otherwise(pair, count), error = fabs(value / expected - 1);
        worst = fmax(worst, error);
        if (!(error <= bound)) {
            print_error("triangles %d, %d: A F %.17g, expected %.17g, error %.1e\n", pair[0], pair[1], value,
                        expected, error);
            wrong++;
        }
    }
    print_message("%d view factors by the contour, %d by Lambert's formula, %d by halving: worst error %.1e, "
                  "bound %.0e\n",
                  count[0], count[1], count[2], worst, bound);
    assert_int_equal(wrong, 0);
}

/* Any entries of blocks of any degree, relative to the block's largest, as the tolerance is. */
static void entries_are_those_of_halving(void **state)
{
    (void)state;
    enum { ENTRIES = 200, MOST = 100 };
    static double block[HPR_MAX_BASIS * HPR_MAX_BASIS];
    uint64_t seed = 2;
    int wrong = 0, passed = 0;
    double worst = 0;
    for (int e = 0; e < ENTRIES;) {
        int pair[2], degree = 1 + (int)(8 * convex_random(&seed));
        size_t n = hpr_basis_count(HPR_SHAPE_TRIANGLE, degree);
        size_t k = (size_t)((double)n * convex_random(&seed)), l = (size_t)((double)n * convex_random(&seed));
        any_pair(&seed, pair);
        hpr_element_frame a = face[pair[0]], b = face[pair[1]];
        a.degree = b.degree = degree;
        double expected = halving_entry(&a, &b, k, l, MOST);
        if (isnan(expected)) {
            passed++;
            continue;
        }
        block_in_room(pair[0], pair[1], degree, degree, block);
        double error = fabs(block[k * n + l] - expected) / largest_entry(block, n * n);
        worst = fmax(worst, error);
        if (!(error <= bound)) {
            print_error("triangles %d, %d, degree %d: K[%zu][%zu] %.17g, expected %.17g, error %.1e\n",
                        pair[0], pair[1], degree, k, l, block[k * n + l], expected, error);
            wrong++;
        }
        e++;
    }
    print_message("%d entries, %d pairs too near for it passed over: worst error %.1e, bound %.0e\n",
                  (int)ENTRIES, passed, worst, bound);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constants_close),
        cmocka_unit_test(polynomials_close),
        cmocka_unit_test(view_factors_are_those_of_other_rules),
        cmocka_unit_test(entries_are_those_of_halving),
    };
    return cmocka_run_group_tests(tests, open_room, bench_close);
}
