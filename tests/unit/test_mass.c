/* Mass blocks of reflectance: closed form, partition of unity, eigenvalues, bits, memory. */
#include "basis/basis.h"
#include "patch/paint.h"
#include "shapes.h"
#include "solver/mass.h"

#include <math.h>

#define EPS 2.220446049250313e-16

enum { SHAPES = 3, MOST = 64 };

static const double origin[3] = {1, 2, 3}, edge1[3] = {2, 0.5, 0}, edge2[3] = {-0.3, 1, 0.2};

/* One patch of each shape, under the texture laid by `map`, and their leaves. */
static void make(hpr_context *ctx, const hpr_texture *texture, const double map[6], int degree, int subdivide,
                 hpr_patches **patches, hpr_elements **elements)
{
    hpr_patches *p = *patches = shapes_create(ctx, SHAPES);
    p->opposite[4] = 1.3;
    p->opposite[5] = 0.8;
    shapes_set(p, 0, HPR_SHAPE_PARALLELOGRAM, origin, edge1, edge2);
    shapes_set(p, 1, HPR_SHAPE_TRIANGLE, origin, edge1, edge2);
    shapes_set(p, 2, HPR_SHAPE_QUADRILATERAL, origin, edge1, edge2);
    assert_int_equal(hpr_paint_create(p, 1, texture), HPR_OK);
    for (size_t i = 0; i < SHAPES; i++) {
        p->paint->of_patch[i] = 0;
        memcpy(p->paint->map + 6 * i, map, 6 * sizeof *map);
        p->paint->tint[3 * i] = 1;
    }
    assert_int_equal(hpr_elements_uniform(p, degree, subdivide, elements), HPR_OK);
}

/* All blocks of a texture, [*count]; to be freed. */
static double *blocks_of(int threads, const hpr_texture *texture, const double map[6], int degree,
                         int subdivide, size_t *count)
{
    hpr_context *ctx = shapes_context(threads, NULL);
    hpr_patches *patches;
    hpr_elements *elements;
    hpr_coverage *coverage = NULL;
    hpr_mass mass;
    make(ctx, texture, map, degree, subdivide, &patches, &elements);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    assert_int_equal(hpr_mass_init(patches, elements, coverage, &mass), HPR_OK);
    *count = 0;
    for (size_t leaf = 0; leaf < elements->leaf_count; leaf++) {
        size_t n = elements->dof[leaf + 1] - elements->dof[leaf];
        assert_true(hpr_mass_varies(&mass, leaf));
        assert_int_equal(mass.at[leaf], *count);
        *count += n * n;
    }
    double *block = malloc(*count * sizeof *block);
    assert_non_null(block);
    memcpy(block, mass.block, *count * sizeof *block);
    hpr_mass_fini(&mass);
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
    return block;
}

/* rho = s on the parallelogram: between Legendre polynomials (a+1) / (2 sqrt((2a+1)(2a+3))) beside 1/2. */
static void a_ramp_has_a_closed_form(void **state)
{
    (void)state;
    enum { DEGREE = 4, N = DEGREE + 1 };
    float texel[] = {0, 1};
    const hpr_texture ramp = {2, 1, {HPR_WRAP_CLAMP, HPR_WRAP_CLAMP}, 0, texel};
    const double map[6] = {0.25, 0, 0.5, 0, 0, 0};
    size_t count;
    double *block = blocks_of(1, &ramp, map, DEGREE, 0, &count), worst = 0;
    for (int k = 0; k < N * N; k++) {
        for (int l = 0; l < N * N; l++) {
            int a = k / N, b = l / N, low = a < b ? a : b;
            double expected = k % N != l % N    ? 0
                              : a == b          ? 0.5
                              : abs(a - b) == 1 ? (low + 1) / (2 * sqrt((2 * low + 1) * (2 * low + 3)))
                                                : 0;
            worst = fmax(worst, fabs(block[k * N * N + l] - expected));
        }
    }
    free(block);
    if (!(worst <= 64 * EPS)) /* seen: below 1e-14 */
        fail_msg("%.3g", worst);
}

/* Far above what was seen, 1.3e-14, and far below what one point too few per axis leaves, 1e-6. */
static const double rounding = 1e-12;

/* The blocks of a texture and of its complement add up to the identity, on every shape, whatever the size of
 * texels, and however they lie: the rules are exact for T_k T_l. */
static void complements_add_up_to_one(void **state)
{
    (void)state;
    static const struct {
        uint32_t width, height;
        int degree, subdivide;
        uint8_t nearest;
    } cases[] = {{3, 2, 5, 0, 1}, {5, 7, 3, 1, 0}, {1, 50, 4, 0, 1}, {60, 50, 4, 0, 1}};
    const double map[6] = {0.13, 0.21, 0.7, 0.4, -0.5, 0.9};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint64_t seed = i;
        float texel[2][MOST * MOST];
        for (size_t k = 0; k < MOST * MOST; k++) {
            texel[0][k] = (float)floor(17 * shapes_random(&seed)) / 16;
            texel[1][k] = 1 - texel[0][k]; /* exact */
        }
        double *block[2], worst = 0;
        size_t count;
        for (int t = 0; t < 2; t++) {
            const hpr_texture texture = {cases[i].width,
                                         cases[i].height,
                                         {HPR_WRAP_REPEAT, HPR_WRAP_MIRROR},
                                         cases[i].nearest,
                                         texel[t]};
            block[t] = blocks_of(1, &texture, map, cases[i].degree, cases[i].subdivide, &count);
        }
        size_t at = 0, leaves = (size_t)1 << 2 * cases[i].subdivide;
        for (size_t leaf = 0; leaf < SHAPES * leaves; leaf++) {
            size_t n = hpr_basis_count(leaf < leaves ? HPR_SHAPE_PARALLELOGRAM : HPR_SHAPE_TRIANGLE,
                                       cases[i].degree);
            for (size_t k = 0; k < n * n; k++)
                worst = fmax(worst, fabs(block[0][at + k] + block[1][at + k] - (k % (n + 1) == 0)));
            at += n * n;
        }
        assert_int_equal(at, count);
        free(block[0]);
        free(block[1]);
        if (!(worst <= rounding))
            fail_msg("case %zu: %.3g", i, worst);
    }
}

static void the_same_bits_for_any_thread_count(void **state)
{
    (void)state;
    float texel[] = {0, 0.5F, 1, 0.25F, 0.75F, 0.125F};
    const hpr_texture texture = {3, 2, {HPR_WRAP_REPEAT, HPR_WRAP_REPEAT}, 0, texel};
    const double map[6] = {0.13, 0.21, 1.7, 0.4, -0.5, 1.9};
    size_t count;
    double *one = blocks_of(1, &texture, map, 3, 1, &count);
    for (int threads = 2; threads <= 7; threads += 5) {
        double *more = blocks_of(threads, &texture, map, 3, 1, &count);
        assert_memory_equal(one, more, count * sizeof *one);
        free(more);
    }
    free(one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ramp_has_a_closed_form),
        cmocka_unit_test(complements_add_up_to_one),
        cmocka_unit_test(the_same_bits_for_any_thread_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
