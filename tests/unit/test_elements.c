#include "shapes.h"

#include "patch/elements.h"
#include "patch/even.h"

static hpr_patches *two_shapes(hpr_context *ctx)
{
    hpr_patches *patches = shapes_create(ctx, 2);
    shapes_set(patches, 0, HPR_SHAPE_PARALLELOGRAM, (double[]){0.1, -3, 2}, (double[]){2, 0.3, 0.1},
               (double[]){-0.5, 1.7, 0.9});
    shapes_set(patches, 1, HPR_SHAPE_TRIANGLE, (double[]){5.1, 0.7, -2}, (double[]){1.3, 0.2, -0.4},
               (double[]){0.2, 0.9, 1.1});
    return patches;
}

static void point_at(const double *origin, const double *edge1, const double *edge2, double s, double t,
                     double point[3])
{
    for (int k = 0; k < 3; k++)
        point[k] = origin[k] + (s * edge1[k] + t * edge2[k]);
}

static void corners_and_parameters(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = two_shapes(ctx);
    const double st[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (size_t i = 0; i < 2; i++) {
        double corner[4][3];
        size_t count = hpr_patch_corners(patches, i, corner);
        assert_int_equal(count, i ? 3 : 4);
        for (size_t c = 0; c < count; c++) {
            const double *want = i && c == 2 ? st[3] : st[c];
            double s, t;
            hpr_add_scaled3(corner[c], 0.37, patches->normal + 3 * i, corner[c]); /* projected away again */
            hpr_patch_parameters(patches, i, corner[c], &s, &t);
            /* eps times the condition of the frame (~3) times the offset; worst seen 4e-16 */
            assert_true(fabs(s - want[0]) < 4e-15 && fabs(t - want[1]) < 4e-15);
        }
    }
    double centre[3], radius;
    hpr_patches *box = shapes_create(ctx, 6);
    shapes_box(box, 0, (double[]){10, 0, -1}, (double[]){2, 0, 0}, (double[]){0, 4, 0}, (double[]){0, 0, 4},
               true);
    radius = hpr_patches_radius(box, centre);
    assert_true(radius == 3 && centre[0] == 11 && centre[1] == 2 && centre[2] == 1);
    hpr_patches_destroy(&box);
    box = shapes_create(ctx, 0);
    assert_true(hpr_patches_radius(box, centre) == 0 && centre[0] == 0);
    hpr_patches_destroy(&box);
    hpr_patches_destroy(&patches);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void leaves_share_out_the_patch(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = two_shapes(ctx);
    for (int n = 0; n <= 4; n++) {
        hpr_elements *elements = NULL;
        assert_int_equal(hpr_elements_uniform(patches, 2, n, &elements), HPR_OK);
        assert_int_equal(elements->leaf_count, 2u << (2 * n));
        assert_int_equal(elements->patch_leaf[0], 0);
        assert_int_equal(elements->patch_leaf[1], 1u << (2 * n));
        assert_int_equal(elements->patch_leaf[2], 2u << (2 * n));
        for (size_t i = 0; i < 2; i++) {
            double area = 0, worst = 0;
            for (size_t l = elements->patch_leaf[i]; l < elements->patch_leaf[i + 1]; l++) {
                uint32_t node = elements->leaf[l];
                double across[3];
                hpr_cross3(elements->edge1 + 3 * node, elements->edge2 + 3 * node, across);
                double own = hpr_dot3(across, patches->normal + 3 * i) / (i ? 2 : 1); /* > 0: same front */
                worst = fmax(worst, fabs(own / elements->area_m2[node] - 1));
                area += elements->area_m2[node];
                assert_int_equal(elements->patch[node], i);
                assert_int_equal(elements->leaf_of_node[node], l);
                assert_int_equal(elements->dof[l + 1] - elements->dof[l], i ? 6 : 9);
            }
            /* the sum of 4^n equal terms rounds 4^n times */
            if (worst > 4e-15 || fabs(area / patches->area_m2[i] - 1) > ldexp(0x1p-53, 2 * n))
                fail_msg("N = %d, patch %zu: element area off by %g, sum %.17g of %.17g", n, i, worst, area,
                         patches->area_m2[i]);
        }
        hpr_elements_destroy(&elements);
    }
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Halving N times per axis halves every edge N times: no slivers on triangles. */
static void triangles_keep_their_shape(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = two_shapes(ctx);
    hpr_elements *elements = NULL;
    assert_int_equal(hpr_elements_uniform(patches, 0, 3, &elements), HPR_OK);
    double corner[4][3], side[3], longest_patch = 0, longest = 0;
    hpr_patch_corners(patches, 1, corner);
    for (int c = 0; c < 3; c++) {
        hpr_subtract3(corner[c], corner[(c + 1) % 3], side);
        longest_patch = fmax(longest_patch, hpr_length3(side));
    }
    for (size_t l = elements->patch_leaf[1]; l < elements->patch_leaf[2]; l++) {
        const double *edge1 = elements->edge1 + 3 * elements->leaf[l];
        const double *edge2 = elements->edge2 + 3 * elements->leaf[l];
        hpr_subtract3(edge2, edge1, side);
        longest = fmax(longest, fmax(hpr_length3(side), fmax(hpr_length3(edge1), hpr_length3(edge2))));
    }
    /* The four similarity classes of newest vertex bisection; a median is no longer than the longest side. */
    if (longest > longest_patch / 8 * (1 + 1e-14))
        fail_msg("longest side %g of a leaf, expected at most %g", longest, longest_patch / 8);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void locate_keeps_the_point(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = two_shapes(ctx);
    hpr_elements *elements = NULL;
    assert_int_equal(hpr_elements_uniform(patches, 0, 4, &elements), HPR_OK);
    uint64_t seed = 1;
    double worst = 0;
    for (int n = 0; n < 100000; n++) {
        size_t i = (size_t)n % 2;
        double s = shapes_random(&seed), t = shapes_random(&seed), u, v, x[3], y[3];
        if (i && s + t > 1) {
            s = 1 - s;
            t = 1 - t;
        }
        if (n % 7 == 0)
            s = 0.5; /* on borders too */
        if (n % 11 == 0)
            t = i ? fmin(s, 1 - s) : 0;
        if (i && s + t > 1)
            t = 1 - s;
        size_t leaf = hpr_elements_locate(patches, elements, i, s, t, &u, &v);
        assert_in_range(leaf, elements->patch_leaf[i], elements->patch_leaf[i + 1] - 1);
        uint32_t node = elements->leaf[leaf];
        double slack = 4e-15; /* rounding of 1 - s - t, doubled by each of the levels that halve an edge */
        if (u < -slack || v < -slack || (i ? u + v : fmax(u, v)) > 1 + slack)
            fail_msg("patch %zu (%.17g, %.17g): outside its leaf at (%.17g, %.17g)", i, s, t, u, v);
        point_at(patches->origin + 3 * i, patches->edge1 + 3 * i, patches->edge2 + 3 * i, s, t, x);
        point_at(elements->origin + 3 * node, elements->edge1 + 3 * node, elements->edge2 + 3 * node, u, v,
                 y);
        double scale = hpr_length3(patches->origin + 3 * i) + hpr_length3(patches->edge1 + 3 * i) +
                       hpr_length3(patches->edge2 + 3 * i);
        hpr_subtract3(x, y, y);
        worst = fmax(worst, hpr_length3(y) / scale);
    }
    /* A handful of roundings of eps/2; worst seen 2.0e-16. */
    if (worst > 1e-15)
        fail_msg("a located point moved by %g of the patch's coordinates", worst);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Neighbours in one patch meet in vertices of the same bits, and vertices stay on the patch's outer edges. */
static void vertices_meet(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 2);
    const double zero[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    shapes_set(patches, 0, HPR_SHAPE_PARALLELOGRAM, zero, x, y);
    shapes_set(patches, 1, HPR_SHAPE_TRIANGLE, zero, x, y);
    hpr_elements *elements = NULL;
    assert_int_equal(hpr_elements_uniform(patches, 0, 2, &elements), HPR_OK);
    size_t seen[2][5][5] = {0};
    for (size_t l = 0; l < elements->leaf_count; l++) {
        uint32_t node = elements->leaf[l];
        size_t i = elements->patch[node];
        for (int c = 0; c < (i ? 3 : 4); c++) {
            double p[3];
            point_at(elements->origin + 3 * node, elements->edge1 + 3 * node, elements->edge2 + 3 * node,
                     c == 1 || (!i && c == 2), c >= 2, p);
            double a = 4 * p[0], b = 4 * p[1];
            assert_true(a == floor(a) && b == floor(b) && a >= 0 && b >= 0 && p[2] == 0);
            assert_true(i ? a + b <= 4 : a <= 4 && b <= 4);
            seen[i][(int)a][(int)b]++;
        }
    }
    for (int a = 0; a <= 4; a++) {
        for (int b = 0; b <= 4; b++) {
            assert_int_equal(seen[0][a][b], (a % 4 ? 2 : 1) * (b % 4 ? 2 : 1));
            assert_true((seen[1][a][b] > 0) == (a + b <= 4));
        }
    }
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* A tree of its own form: one child split once more, by another axis. */
static void index_follows_any_tree(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 1);
    const double zero[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    shapes_set(patches, 0, HPR_SHAPE_PARALLELOGRAM, zero, x, y);
    hpr_elements *elements = NULL;
    assert_int_equal(hpr_elements_uniform(patches, 0, 1, &elements), HPR_OK);
    uint32_t first = elements->child[0];
    elements->child[0] = HPR_NONE;
    elements->node_count = 1;
    assert_int_equal(hpr_elements_index(patches, elements), HPR_OK);
    assert_int_equal(elements->leaf_count, 1);
    elements->child[0] = first;
    elements->axis[0] = 1;
    elements->child[first] = HPR_NONE; /* lower half stays whole */
    elements->axis[first + 1] = 1;     /* upper half is halved again */
    elements->child[first + 1] = first + 2;
    elements->child[first + 2] = elements->child[first + 3] = HPR_NONE;
    elements->degree[first + 1] = 9; /* inner nodes carry no coefficients */
    elements->degree[first + 3] = 3;
    elements->node_count = first + 4;
    assert_int_equal(hpr_elements_index(patches, elements), HPR_OK);
    assert_int_equal(elements->leaf_count, 3);
    assert_int_equal(elements->leaf[0], first);
    assert_int_equal(elements->leaf[2], first + 3);
    assert_int_equal(elements->dof[3], 1 + 1 + 16);
    double u, v;
    assert_int_equal(hpr_elements_locate(patches, elements, 0, 0.3, 0.875, &u, &v), 2);
    assert_true(u == 0.3 && v == 0.5);
    assert_int_equal(hpr_elements_locate(patches, elements, 0, 0.3, 0.625, &u, &v), 1);
    assert_int_equal(hpr_elements_locate(patches, elements, 0, 0.9, 0.25, &u, &v), 0);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static double longest_side(const hpr_patches *patches, const hpr_elements *e, size_t node)
{
    hpr_vec3 a = hpr_vec3_load(e->edge1 + 3 * node), b = hpr_vec3_load(e->edge2 + 3 * node);
    double longest = fmax(hpr_length(a), hpr_length(b));
    bool triangle = patches->shape[e->patch[node]] == HPR_SHAPE_TRIANGLE;
    return triangle ? fmax(longest, hpr_length(hpr_sub(b, a))) : longest;
}

/* A floor, a leg on it and a triangle: no leaf is longer than the limit, and none was halved in vain. */
static void even_elements_are_as_long_as_allowed(void **state)
{
    (void)state;
    static const double longest_m = 0.3;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    hpr_elements *e = NULL;
    shapes_set(patches, 0, HPR_SHAPE_PARALLELOGRAM, (double[]){0, 0, 0}, (double[]){5, 0, 0},
               (double[]){0, 4, 0});
    shapes_set(patches, 1, HPR_SHAPE_PARALLELOGRAM, (double[]){1, 1, 0}, (double[]){0.05, 0, 0},
               (double[]){0, 0, 0.71});
    shapes_set(patches, 2, HPR_SHAPE_TRIANGLE, (double[]){0, 0, 1}, (double[]){3, 0.2, 0},
               (double[]){0.4, 0.1, 1});
    assert_int_equal(hpr_elements_uniform(patches, 2, 0, &e), HPR_OK);
    assert_int_equal(hpr_elements_even(patches, e, longest_m), HPR_OK);
    assert_int_equal(e->patch_leaf[1] - e->patch_leaf[0], 32 * 16); /* 5/32 by 4/16 */
    assert_int_equal(e->patch_leaf[2] - e->patch_leaf[1], 4);       /* along its height alone */
    for (size_t node = 0; node < e->node_count; node++) {
        double longest = longest_side(patches, e, node);
        assert_true(e->child[node] == HPR_NONE ? longest <= longest_m * (1 + 1e-11) : longest > longest_m);
        assert_int_equal(e->degree[node], 2);
    }
    assert_int_equal(hpr_elements_even(patches, e, 0), HPR_ERR_ARG);
    assert_int_equal(hpr_elements_even(patches, e, NAN), HPR_ERR_ARG);
    hpr_elements_destroy(&e);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* The length found takes what is allowed, and the next shorter one more. */
static void the_length_within_a_number_of_coefficients(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = two_shapes(ctx);
    for (size_t most = 1; most < 5000; most *= 3) {
        double length[2];
        size_t dofs[2];
        assert_int_equal(hpr_elements_even_within(patches, 2, most, &length[0]), HPR_OK);
        length[1] = length[0] * exp2(-1.0 / 8);
        for (int k = 0; k < 2; k++) {
            hpr_elements *e = NULL;
            assert_int_equal(hpr_elements_uniform(patches, 2, 0, &e), HPR_OK);
            assert_int_equal(hpr_elements_even(patches, e, length[k]), HPR_OK);
            dofs[k] = e->dof[e->leaf_count];
            hpr_elements_destroy(&e);
        }
        assert_true(dofs[0] <= (most < 15 ? 15 : most)); /* 9 + 6 functions on the two patches */
        assert_true(dofs[1] > most);
    }
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 5000), *many = NULL;
    hpr_elements *elements = NULL;
    assert_int_equal(hpr_elements_uniform(patches, -1, 0, &elements), HPR_ERR_ARG);
    assert_int_equal(hpr_elements_uniform(patches, 17, 0, &elements), HPR_ERR_ARG);
    assert_int_equal(hpr_elements_uniform(patches, 0, 11, &elements), HPR_ERR_ARG);
    assert_int_equal(hpr_elements_uniform(patches, 0, 10, &elements), HPR_ERR_MEMORY);
    assert_null(elements);
    assert_int_equal(hpr_patches_create(ctx, HPR_NONE, 1, &many), HPR_ERR_MEMORY);
    assert_null(many);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    shapes_allocator allocator = {.fail_at = SIZE_MAX};
    hpr_context *ctx = shapes_context(1, &allocator);
    size_t before = allocator.alive, failures = 0;
    for (size_t k = 0;; k++) {
        hpr_patches *patches = NULL;
        hpr_elements *elements = NULL;
        allocator.fail_at = allocator.calls + k;
        hpr_status status = hpr_patches_create(ctx, 3, 2, &patches);
        if (status == HPR_OK)
            status = hpr_elements_uniform(patches, 1, 1, &elements);
        hpr_elements_destroy(&elements);
        hpr_patches_destroy(&patches);
        assert_int_equal(allocator.alive, before);
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        failures++;
    }
    assert_int_equal(failures, 15 + 14); /* allocations of patches and of elements */
    allocator.fail_at = SIZE_MAX;
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_and_parameters),
        cmocka_unit_test(leaves_share_out_the_patch),
        cmocka_unit_test(triangles_keep_their_shape),
        cmocka_unit_test(locate_keeps_the_point),
        cmocka_unit_test(vertices_meet),
        cmocka_unit_test(index_follows_any_tree),
        cmocka_unit_test(even_elements_are_as_long_as_allowed),
        cmocka_unit_test(the_length_within_a_number_of_coefficients),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
