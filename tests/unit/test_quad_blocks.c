/*
 * Elements that are quadrilaterals against the two triangles that each is made of: the same polynomials have
 * the same moments, so K_quad = sum over both of M_r K_tri M_sT with M_km = ∫_tri T_k^quad T_m^tri dA. And
 * the halves of a quadrilateral against the whole, through the tree.
 */
#include "blocks.h"
#include "link/tree.h"
#include "math/planar_basis.h"
#include "quadrature/far.h"
#include "shapes.h"

#include <float.h>

/* Corners of a quadrilateral as a frame; recurrence: room for its basis. */
static hpr_element_frame quad_of(int degree, const double (*corner)[3], double *recurrence)
{
    static double scratch[40000];
    hpr_element_frame f = frame_of(HPR_SHAPE_PARALLELOGRAM, degree, corner[0], corner[1], corner[3]);
    hpr_vec3 across = hpr_sub(hpr_vec3_load(corner[2]), f.origin), normal = hpr_cross(f.edge1, f.edge2);
    double square = hpr_dot(normal, normal);
    f.shape = HPR_SHAPE_QUADRILATERAL;
    f.opposite[0] = hpr_dot(hpr_cross(across, f.edge2), normal) / square;
    f.opposite[1] = hpr_dot(hpr_cross(f.edge1, across), normal) / square;
    f.area_m2 *= hpr_shape_measure(f.shape, f.opposite);
    assert_true(hpr_planar_scratch(degree) <= sizeof scratch / sizeof *scratch);
    hpr_planar_make(f.opposite, degree, &hpr_gauss.legendre[degree + 1], recurrence, scratch);
    f.recurrence = recurrence;
    return f;
}

enum { DEGREE = 4, FUNCTIONS = (DEGREE + 1) * (DEGREE + 2) / 2, BLOCK = FUNCTIONS * FUNCTIONS };

/* M of triangle `half` of a quadrilateral, corners 0, 1 + half, 2 + half. */
static hpr_element_frame triangle_of(const hpr_element_frame *quad, const double (*corner)[3], int half,
                                     double *m)
{
    double own[3][3], phi[FUNCTIONS], whole[FUNCTIONS];
    memcpy(own[0], corner[0], sizeof own[0]);
    memcpy(own[1], corner[1 + half], sizeof own[1]);
    memcpy(own[2], corner[2 + half], sizeof own[2]);
    hpr_element_frame f = frame_of(HPR_SHAPE_TRIANGLE, DEGREE, own[0], own[1], own[2]);
    double st[4][2];
    hpr_shape_corners(quad->shape, quad->opposite, st);
    memset(m, 0, BLOCK * sizeof *m);
    const hpr_gauss_rule *along = &hpr_gauss.legendre[DEGREE + 1], *across = &hpr_gauss.jacobi[DEGREE + 1];
    for (int q = 0; q < (DEGREE + 1) * (DEGREE + 1); q++) {
        double t = across->node[q / (DEGREE + 1)], s = along->node[q % (DEGREE + 1)] * (1 - t);
        double weight = across->weight[q / (DEGREE + 1)] * along->weight[q % (DEGREE + 1)] *
                        hpr_frame_jacobian(&f) * hpr_frame_scale(&f) * hpr_frame_scale(quad);
        hpr_frame_basis(&f, s, t, phi);
        hpr_frame_basis(quad, s * st[1 + half][0] + t * st[2 + half][0],
                        s * st[1 + half][1] + t * st[2 + half][1], whole);
        for (int k = 0; k < FUNCTIONS; k++) {
            for (int l = 0; l < FUNCTIONS; l++)
                m[k * FUNCTIONS + l] += weight * whole[k] * phi[l];
        }
    }
    return f;
}

static const double tolerance = 1e-12;

static void integrate(const hpr_element_frame *a, const hpr_element_frame *b, double *block)
{
    hpr_block_result result = block_of(a, b, tolerance, block);
    assert_true(result.status == HPR_BLOCK_WITHIN || result.status == HPR_BLOCK_ROUNDED);
}

/* sum += M_a K M_bT */
static void add_transformed(const double *ma, const double *k, const double *mb, double *sum)
{
    for (int i = 0; i < FUNCTIONS; i++) {
        for (int j = 0; j < FUNCTIONS; j++) {
            for (int p = 0; p < FUNCTIONS; p++) {
                for (int q = 0; q < FUNCTIONS; q++)
                    sum[i * FUNCTIONS + j] +=
                        ma[i * FUNCTIONS + p] * k[p * FUNCTIONS + q] * mb[j * FUNCTIONS + q];
            }
        }
    }
}

static double largest_difference(const double *a, const double *b)
{
    double worst = 0, most = 0;
    for (int i = 0; i < BLOCK; i++) {
        worst = fmax(worst, fabs(a[i] - b[i]));
        most = fmax(most, fabs(b[i]));
    }
    return worst / most;
}

static const double floor_corner[4][3] = {{0, 0, 0}, {2, 0, 0}, {1.5, 1.5, 0}, {0, 1, 0}};
static const double other[][4][3] = {
    {{2, 0, 0}, {0, 0, 0}, {0, 0, 1}, {2, 0, 1.5}},               /* at an edge */
    {{1.25, 0, 0}, {0.5, 0, 0}, {0.25, 0, 1}, {2, 0, 1.5}},       /* at a part of an edge */
    {{2, 0, 0}, {3, 0, 1}, {3, 1, 2}, {2, 1, 0.75}},              /* at a corner: not flat, see below */
    {{0, 1, 0.01}, {1.5, 1.5, 0.01}, {2, 0, 0.02}, {0, 0, 0.01}}, /* nearly on it: not flat */
    {{0, 1, 1}, {1.5, 1.5, 1}, {2, 0, 1}, {0, 0, 1}},             /* opposite */
    {{10, 11, 20}, {11.5, 11.5, 20}, {12, 10, 20}, {10, 10, 20}}, /* far */
};

/* Puts corner 2 into the plane of the others. */
static void flatten(double corner[4][3])
{
    hpr_element_frame f = frame_of(HPR_SHAPE_PARALLELOGRAM, 0, corner[0], corner[1], corner[3]);
    hpr_vec3 x = hpr_vec3_load(corner[2]);
    hpr_vec3_store(corner[2], hpr_madd(x, -hpr_dot(f.normal, hpr_sub(x, f.origin)), f.normal));
}

static void blocks_are_those_of_triangles(void **state)
{
    (void)state;
    static double recurrence[2][1000], block[BLOCK], part[BLOCK], sum[BLOCK], m[2][2][BLOCK];
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) {
        double corner[4][3];
        memcpy(corner, other[i], sizeof corner);
        flatten(corner);
        hpr_element_frame a = quad_of(DEGREE, floor_corner, recurrence[0]);
        hpr_element_frame b = quad_of(DEGREE, (const double(*)[3])corner, recurrence[1]);
        integrate(&a, &b, block);
        memset(sum, 0, sizeof sum);
        for (int p = 0; p < 4; p++) {
            hpr_element_frame s = triangle_of(&a, floor_corner, p / 2, m[0][p / 2]);
            hpr_element_frame t = triangle_of(&b, (const double(*)[3])corner, p % 2, m[1][p % 2]);
            integrate(&s, &t, part);
            add_transformed(m[0][p / 2], part, m[1][p % 2], sum);
        }
        double error = largest_difference(block, sum);
        /* five blocks to the tolerance */
        if (!(error <= 5 * tolerance))
            fail_msg("pair %zu: off by %.2e of the largest entry, bound %.1e", i, error, 5 * tolerance);
    }
}

/* Product Gauss through the bilinear map, as links use it. */
static void far_blocks_are_blocks(void **state)
{
    (void)state;
    static double recurrence[2][1000], block[BLOCK], far_block[BLOCK];
    hpr_far *tables = NULL;
    double *scratch = hpr_allocate(bench.context, hpr_far_scratch(), sizeof *scratch);
    assert_non_null(scratch);
    assert_int_equal(hpr_far_create(bench.context, DEGREE, &tables), HPR_OK);
    hpr_element_frame a = quad_of(DEGREE, floor_corner, recurrence[0]);
    hpr_element_frame b = quad_of(DEGREE, other[5], recurrence[1]);
    integrate(&a, &b, block);
    hpr_far_block(tables, &a, &b, far_block, scratch);
    /* the kernel's coefficients fall like 30^-n, n = 2 DEGREE + 2 for the lowest that is wrong */
    assert_true(largest_difference(far_block, block) <= 5 * tolerance);
    hpr_far_destroy(&tables);
    hpr_release(bench.context, scratch);
}

static hpr_patches *one_quad(void)
{
    hpr_patches *patches = shapes_create(bench.context, 1);
    patches->opposite[0] = 0.7;
    patches->opposite[1] = 1.6;
    shapes_set(patches, 0, HPR_SHAPE_QUADRILATERAL, (double[]){0.1, -3, 2}, (double[]){2, 0.3, 0.1},
               (double[]){-0.5, 1.7, 0.9});
    return patches;
}

static double value_at(const hpr_element_frame *frame, const double *coefficient, double s, double t)
{
    double phi[HPR_MAX_BASIS], sum = 0;
    hpr_frame_basis(frame, s, t, phi);
    for (size_t k = 0; k < hpr_basis_count(frame->shape, frame->degree); k++)
        sum += coefficient[k] * phi[k];
    return sum * hpr_frame_scale(frame);
}

/* The leaves share out the patch, a point is found in one of them, and what the root has pushed down is the
 * same polynomial there; pulled up it comes back. */
static void leaves_carry_what_the_root_has(void **state)
{
    (void)state;
    enum { ORDER = 5, LEVELS = 3 };
    hpr_patches *patches = one_quad();
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    hpr_tree *tree = NULL;
    uint64_t seed = 3;
    assert_int_equal(hpr_elements_uniform(patches, ORDER, LEVELS, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    assert_int_equal(hpr_tree_create(coverage, elements, 0, &tree), HPR_OK);
    double area = 0;
    for (size_t i = 0; i < elements->leaf_count; i++)
        area += elements->area_m2[elements->leaf[i]];
    assert_true(fabs(area / patches->area_m2[0] - 1) <= 64 * DBL_EPSILON);
    size_t dofs = elements->dof[elements->leaf_count], count = hpr_tree_count(tree, 0, ORDER);
    double *node = hpr_allocate(bench.context, tree->dof_count, sizeof *node), root[HPR_MAX_BASIS];
    double *leaf = hpr_allocate(bench.context, dofs, sizeof *leaf);
    assert_true(node && leaf);
    for (size_t k = 0; k < count; k++)
        root[k] = node[tree->dof[0] + k] = shapes_random(&seed) - 0.5;
    hpr_tree_push(tree, 0, node, leaf);
    const hpr_element_frame whole = hpr_tree_frame(tree, 0, ORDER);
    double worst = 0, largest = 0;
    for (int i = 0; i < 1000; i++) {
        double u = shapes_random(&seed), v = shapes_random(&seed), st[2], s, t;
        hpr_shape_uniform(whole.shape, whole.opposite, u, v, st);
        size_t at = hpr_elements_locate(patches, elements, 0, st[0], st[1], &s, &t);
        const hpr_element_frame own = hpr_leaf_frame(patches, elements, at);
        hpr_vec3 gap = hpr_sub(hpr_frame_point(&own, s, t), hpr_frame_point(&whole, st[0], st[1]));
        assert_true(hpr_length(gap) <= 64 * DBL_EPSILON);
        assert_true(hpr_shape_holds(own.shape, own.opposite, s, t));
        double exact = value_at(&whole, root, st[0], st[1]);
        worst = fmax(worst, fabs(value_at(&own, leaf + elements->dof[at], s, t) - exact));
        largest = fmax(largest, fabs(exact));
    }
    /* six levels of sums of 21 terms; worst seen 2e-14 */
    if (!(worst <= 2e-13 * largest))
        fail_msg("pushed: off by %.2e of %.2e", worst, largest);
    hpr_tree_pull(tree, 0, leaf, node);
    for (size_t k = 0; k < count; k++) {
        if (!(fabs(node[tree->dof[0] + k] - root[k]) <= 1e-13))
            fail_msg("function %zu: %.17g comes back as %.17g", k, root[k], node[tree->dof[0] + k]);
    }
    hpr_release(bench.context, node);
    hpr_release(bench.context, leaf);
    hpr_tree_destroy(&tree);
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
}

/* Every allocation of elements and tree fails once. */
static void no_memory(void **state)
{
    (void)state;
    hpr_status status = HPR_ERR_MEMORY;
    shapes_allocator allocator = {.fail_at = SIZE_MAX};
    hpr_context *ctx = shapes_context(1, &allocator);
    size_t before = allocator.alive;
    for (size_t k = 0; status != HPR_OK; k++) {
        hpr_patches *patches = NULL;
        hpr_elements *elements = NULL;
        hpr_quad_tables *tables = NULL;
        static const uint8_t degree[31] = {2};
        allocator.fail_at = allocator.calls + k;
        status = hpr_patches_create(ctx, 1, 1, &patches);
        if (status == HPR_OK) {
            patches->shape[0] = HPR_SHAPE_QUADRILATERAL;
            patches->opposite[0] = patches->opposite[1] = patches->area_m2[0] = patches->edge1[0] =
                patches->edge2[1] = 1;
            status = hpr_elements_uniform(patches, 1, 1, &elements);
        }
        if (status == HPR_OK)
            status = hpr_quad_tables_create(patches, elements, degree, &tables);
        hpr_quad_tables_destroy(&tables);
        hpr_elements_destroy(&elements);
        hpr_patches_destroy(&patches);
        assert_int_equal(allocator.alive, before);
        assert_true(status == HPR_OK || status == HPR_ERR_MEMORY);
    }
    allocator.fail_at = SIZE_MAX;
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_those_of_triangles),
        cmocka_unit_test(far_blocks_are_blocks),
        cmocka_unit_test(leaves_carry_what_the_root_has),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, bench_open, bench_close);
}
