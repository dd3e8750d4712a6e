/* Fast blocks against the plain loops over the same points: every kind of rule, shape, degree and instruction
 * set. */
#include "blocks.h"
#include "math/planar_basis.h"

#include <float.h>

/* Corners in order; 3 make a triangle, 4 a parallelogram or, if `opposite` is not 1, 1, a quadrilateral. */
typedef struct side {
    hpr_shape shape;
    double corner[3][3];
    double opposite[2];
} side;

typedef struct pair {
    const char *name;
    side recv, send;
    bool blocked, sampled;
} pair;

#define SQUARE HPR_SHAPE_PARALLELOGRAM
#define TRIANGLE HPR_SHAPE_TRIANGLE
#define QUAD HPR_SHAPE_QUADRILATERAL

#define FLOOR(shape, a, b)                                                                                   \
    {                                                                                                        \
        shape, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},                                                            \
        {                                                                                                    \
            a, b                                                                                             \
        }                                                                                                    \
    }
#define ABOVE(shape, a, b)                                                                                   \
    {                                                                                                        \
        shape, {{0.1, 0, 2.5}, {0.1, 1, 2.6}, {1.2, 0, 2.5}},                                                \
        {                                                                                                    \
            a, b                                                                                             \
        }                                                                                                    \
    }
#define TILTED(shape, a, b)                                                                                  \
    {                                                                                                        \
        shape, {{0.3, 0, 0.2}, {0.3, 1, 0.25}, {1.3, 0, 0.4}},                                               \
        {                                                                                                    \
            a, b                                                                                             \
        }                                                                                                    \
    }
#define STANDING(shape, a, b)                                                                                \
    {                                                                                                        \
        shape, {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}},                                                            \
        {                                                                                                    \
            a, b                                                                                             \
        }                                                                                                    \
    }

static const pair pairs[] = {
    {"apart", FLOOR(SQUARE, 0, 0), ABOVE(SQUARE, 0, 0), false, false},
    {"apart, triangle and quadrilateral", FLOOR(TRIANGLE, 0, 0), ABOVE(QUAD, 1.1, 0.7), false, false},
    {"near", FLOOR(SQUARE, 0, 0), TILTED(TRIANGLE, 0, 0), false, false},
    {"near, quadrilaterals", FLOOR(QUAD, 0.8, 1.2), TILTED(QUAD, 0.9, 1.3), false, false},
    {"an edge in common", FLOOR(SQUARE, 0, 0), STANDING(SQUARE, 0, 0), false, false},
    {"an edge in common, triangles", FLOOR(TRIANGLE, 0, 0), STANDING(TRIANGLE, 0, 0), false, false},
    {"past a blocker", FLOOR(SQUARE, 0, 0), ABOVE(TRIANGLE, 0, 0), true, false},
    {"past a blocker, quadrilaterals", FLOOR(QUAD, 0.8, 1.2), ABOVE(QUAD, 1.1, 0.7), true, false},
    {"rays", FLOOR(SQUARE, 0, 0), ABOVE(SQUARE, 0, 0), true, true},
};

/* So far apart that their rules have few points. */
#define FAR(shape, a, b)                                                                                     \
    {                                                                                                        \
        shape, {{2, 1.5, 3.1}, {2, 2.5, 3.1}, {2.9, 1.5, 3.4}},                                              \
        {                                                                                                    \
            a, b                                                                                             \
        }                                                                                                    \
    }

static const pair far_pairs[] = {
    {"far", FLOOR(SQUARE, 0, 0), FAR(SQUARE, 0, 0), false, false},
    {"far, triangles", FLOOR(TRIANGLE, 0, 0), FAR(TRIANGLE, 0, 0), false, false},
    {"far, square and triangle", FLOOR(SQUARE, 0, 0), FAR(TRIANGLE, 0, 0), false, false},
    {"far, triangle and quadrilateral", FLOOR(TRIANGLE, 0, 0), FAR(QUAD, 1.1, 0.7), false, false},
};

static hpr_element_frame frame_of_side(const side *of, int degree, double *recurrence)
{
    static double scratch[40000];
    hpr_element_frame f = frame_of(of->shape, degree, of->corner[0], of->corner[1], of->corner[2]);
    if (of->shape != QUAD)
        return f;
    memcpy(f.opposite, of->opposite, sizeof f.opposite);
    f.area_m2 *= hpr_shape_measure(f.shape, f.opposite);
    assert_true(hpr_planar_scratch(degree) <= sizeof scratch / sizeof *scratch);
    hpr_planar_make(f.opposite, degree, &hpr_gauss.legendre[degree + 1], recurrence, scratch);
    f.recurrence = recurrence;
    return f;
}

/* What one instruction set needs. */
typedef struct machine {
    const char *isa;
    hpr_context *context;
    hpr_quadrature *quadrature;
    hpr_block_scratch *scratch;
    hpr_patches *patches;
    hpr_visibility *visibility;
} machine;

/* False if this processor lacks it. The only patch is a small rectangle between. */
static bool open_machine(const char *isa, machine *m)
{
    static const double corner[3][3] = {{0.3, 0.35, 1.2}, {0.9, 0.35, 1.2}, {0.3, 0.8, 1.3}};
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.isa = isa;
    *m = (machine){.isa = isa};
    if (hpr_context_create(&options, &m->context) != HPR_OK)
        return false;
    assert_int_equal(hpr_quadrature_create(m->context, &m->quadrature), HPR_OK);
    assert_int_equal(hpr_block_scratch_create(m->context, &m->scratch), HPR_OK);
    assert_int_equal(hpr_patches_create(m->context, 1, 1, &m->patches), HPR_OK);
    hpr_element_frame f = frame_of(SQUARE, 0, corner[0], corner[1], corner[2]);
    m->patches->shape[0] = SQUARE;
    hpr_vec3_store(m->patches->origin, f.origin);
    hpr_vec3_store(m->patches->edge1, f.edge1);
    hpr_vec3_store(m->patches->edge2, f.edge2);
    hpr_vec3_store(m->patches->normal, f.normal);
    m->patches->area_m2[0] = f.area_m2;
    assert_int_equal(hpr_visibility_create(m->patches, &m->visibility), HPR_OK);
    return true;
}

static void close_machine(machine *m)
{
    hpr_visibility_destroy(&m->visibility);
    hpr_patches_destroy(&m->patches);
    hpr_block_scratch_destroy(&m->scratch);
    hpr_quadrature_destroy(&m->quadrature);
    hpr_context_destroy(&m->context);
}

static double block[HPR_MAX_BASIS * HPR_MAX_BASIS], plain[HPR_MAX_BASIS * HPR_MAX_BASIS];

/* The largest difference, relative to the largest entry. */
static double difference(const machine *m, const pair *p, int recv_degree, int send_degree, double tolerance)
{
    static double recurrence[2][6000];
    const uint32_t blocker = 0;
    hpr_block_task task = {.recv = frame_of_side(&p->recv, recv_degree, recurrence[0]),
                           .send = frame_of_side(&p->send, send_degree, recurrence[1]),
                           .tolerance = tolerance,
                           .visibility = m->visibility,
                           .blockers = &blocker,
                           .blocker_count = p->blocked,
                           .clip = !p->sampled};
    task.contact_m = pair_contact(&task.recv, &task.send);
    hpr_block_result fast = hpr_block(m->quadrature, &task, block, m->scratch);
    hpr_block_result simple = hpr_block_ref(m->quadrature, &task, plain, m->scratch);
    size_t count = frame_basis(&task.recv) * frame_basis(&task.send);
    double worst = 0, most = largest_entry(plain, count);
    for (size_t i = 0; i < count; i++)
        worst = fmax(worst, fabs(block[i] - plain[i]));
    assert_true(most > 0);
    assert_int_equal(fast.kernel_count, simple.kernel_count);
    assert_int_equal(fast.status, simple.status);
    return worst / most;
}

typedef struct asked {
    int recv, send;
    double tolerance;
} asked;

/* The largest difference of pairs at all that is asked. Both sum the same numbers; products may lose a tenth
 * of the tolerance, see block_simd.c. Rays decide by the same hashes. */
static double check_pairs(machine *m, size_t pair_count, const pair *all, size_t asked_count,
                          const asked *what)
{
    double worst = 0;
    for (size_t i = 0; i < pair_count; i++) {
        for (const asked *a = what; a < what + asked_count; a++) {
            double off = difference(m, &all[i], a->recv, a->send, a->tolerance);
            double bound = fmax(0.1 * a->tolerance, 4e-14);
            if (!(off <= bound))
                fail_msg("%s, %s, degrees %d and %d, tolerance %.0e: off by %.1e, bound %.1e", m->isa,
                         all[i].name, a->recv, a->send, a->tolerance, off, bound);
            worst = fmax(worst, off);
        }
    }
    return worst;
}

static void check(const char *isa)
{
    static const asked near_asked[] = {{0, 0, 1e-12}, {0, 3, 1e-9}, {2, 1, 1e-12},
                                       {4, 4, 1e-3},  {5, 2, 1e-6}, {7, 8, 1e-3}},
                       far_asked[] = {{3, 3, 1e-12}, {1, 2, 1e-12}};
    machine m;
    if (!open_machine(isa, &m)) {
        print_message("%s: not on this processor\n", isa);
        skip();
    }
    double near = check_pairs(&m, sizeof pairs / sizeof *pairs, pairs, sizeof near_asked / sizeof *near_asked,
                              near_asked),
           far = check_pairs(&m, sizeof far_pairs / sizeof *far_pairs, far_pairs,
                             sizeof far_asked / sizeof *far_asked, far_asked);
    print_message("%s: %.1e at most, far %.1e\n", isa, near, far);
    close_machine(&m);
}

static void with_sse2(void **state)
{
    (void)state;
    check("sse2");
}

static void with_avx2(void **state)
{
    (void)state;
    check("avx2");
}

static void with_avx512(void **state)
{
    (void)state;
    check("avx512");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(with_sse2),
        cmocka_unit_test(with_avx2),
        cmocka_unit_test(with_avx512),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
