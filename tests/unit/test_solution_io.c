#include "io/json_text.h"
#include "io/solution_mesh.h"
#include "random_solution.h"

#include <locale.h>

static void assert_same_column(const hpr_column *a, const hpr_column *b)
{
    const void *x, *y;
    memcpy(&x, a->array, sizeof x);
    memcpy(&y, b->array, sizeof y);
    assert_int_equal(a->count, b->count);
    size_t bytes = a->count * a->components * hpr_component_bytes(a->component);
    if (bytes && memcmp(x, y, bytes) != 0)
        fail_msg("%s.%s differs", a->group, a->key);
}

static void assert_same_paint(const hpr_patches *a, const hpr_patches *b)
{
    const hpr_paint *p = a->paint, *q = b->paint;
    assert_true((p == NULL) == (q == NULL));
    if (!p)
        return;
    size_t n = a->channel_count;
    assert_int_equal(p->texture_count, q->texture_count);
    for (size_t i = 0; i < p->texture_count; i++) {
        const hpr_texture *s = &p->texture[i], *t = &q->texture[i];
        assert_true(s->width == t->width && s->height == t->height && s->nearest == t->nearest);
        assert_memory_equal(s->wrap, t->wrap, sizeof s->wrap);
        assert_memory_equal(s->texel, t->texel, n * s->width * s->height * sizeof *s->texel);
    }
    assert_memory_equal(p->of_patch, q->of_patch, a->count * sizeof *p->of_patch);
    assert_memory_equal(p->map, q->map, 6 * a->count * sizeof *p->map);
    assert_memory_equal(p->tint, q->tint, 3 * n * a->count * sizeof *p->tint);
    assert_memory_equal(p->glow_of, q->glow_of, a->count * sizeof *p->glow_of);
    assert_memory_equal(p->glow_map, q->glow_map, 6 * a->count * sizeof *p->glow_map);
    assert_memory_equal(p->glow, q->glow, n * a->count * sizeof *p->glow);
}

static void assert_same(hpr_solution *a, hpr_solution *b)
{
    const hpr_elements *e = a->elements, *f = b->elements;
    const hpr_solution_sizes sizes = {a->channel_count, a->patches->count, e->node_count, e->leaf_count,
                                      e->dof[e->leaf_count]};
    hpr_column x[HPR_COLUMN_COUNT], y[HPR_COLUMN_COUNT];
    hpr_solution_columns(&sizes, a, x);
    hpr_solution_columns(&sizes, b, y);
    assert_int_equal(f->node_count, e->node_count);
    assert_int_equal(f->leaf_count, e->leaf_count);
    assert_int_equal(f->patch_count, e->patch_count);
    for (size_t i = 0; i < HPR_COLUMN_COUNT; i++)
        assert_same_column(x + i, y + i);
    assert_same_paint(a->patches, b->patches);
    assert_memory_equal(e->leaf_of_node, f->leaf_of_node, e->node_count * sizeof(uint32_t));
    assert_memory_equal(e->patch_leaf, f->patch_leaf, (e->patch_count + 1) * sizeof(uint32_t));
    assert_string_equal(a->scene_name, b->scene_name);
    assert_int_equal(a->channel_count, b->channel_count);
    for (size_t c = 0; c < a->channel_count; c++)
        assert_string_equal(a->channel_name[c], b->channel_name[c]);
    assert_memory_equal(a->environment, b->environment, a->channel_count * sizeof(double));
    assert_memory_equal(a->energy, b->energy, a->channel_count * sizeof *a->energy);
    assert_true(isnan(b->summary.residual));
    a->summary.residual = b->summary.residual = 0; /* a NaN in the JSON has no payload */
    assert_memory_equal(&a->summary, &b->summary, sizeof a->summary);
    a->summary.residual = b->summary.residual = NAN;
    assert_int_equal(a->patches->degenerate_count, b->patches->degenerate_count);
    assert_int_equal(a->patches->duplicate_count, b->patches->duplicate_count);
    assert_true(a->patches->weld_m == b->patches->weld_m);
    assert_int_equal(a->camera_count, b->camera_count);
    for (size_t i = 0; i < a->camera_count; i++) {
        hpr_camera c = a->camera[i], d = b->camera[i];
        assert_string_equal(c.name, d.name);
        assert_int_equal(c.kind, d.kind);
        assert_memory_equal(c.origin, d.origin, sizeof c - offsetof(hpr_camera, origin));
    }
}

static void everything_comes_back_bit_for_bit(void **state)
{
    fixture *f = *state;
    static const struct {
        size_t channels;
        int subdivide, most;
    } cases[] = {{3, 0, 0}, {3, 2, 3}, {1, 1, 16}, {5, 1, 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_solution *s = random_solution(f->context, 99 + i, cases[i].channels, cases[i].subdivide,
                                          cases[i].most),
                     *back;
        assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
        hpr_status status = hpr_solution_read(f->context, in_folder(f, "a.glb"), &back);
        assert_string_equal(hpr_context_error(f->context), "");
        assert_int_equal(status, HPR_OK);
        assert_same(s, back);
        hpr_solution_destroy(&back);
        hpr_solution_destroy(&s);
    }
}

static void same_solution_same_bytes(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 5, 3, 1, 2), *back;
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    assert_int_equal(hpr_solution_read(f->context, in_folder(f, "a.glb"), &back), HPR_OK);
    assert_int_equal(hpr_solution_write(f->context, back, in_folder(f, "b.glb")), HPR_OK);
    size_t a_bytes, b_bytes;
    unsigned char *a = slurp(in_folder(f, "a.glb"), &a_bytes), *b = slurp(in_folder(f, "b.glb"), &b_bytes);
    assert_int_equal(a_bytes, b_bytes);
    assert_memory_equal(a, b, a_bytes);
    free(a);
    free(b);
    hpr_solution_destroy(&back);
    hpr_solution_destroy(&s);
}

/* JSON numbers, in a locale that writes 0,5. */
static void locale_does_not_matter(void **state)
{
    fixture *f = *state;
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8"))
        skip();
    char text[HPR_NUMBER_BYTES];
    assert_string_equal(hpr_number_text(0.5, text), "0.5");
    hpr_solution *s = random_solution(f->context, 5, 3, 0, 2), *back;
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    assert_int_equal(hpr_solution_read(f->context, in_folder(f, "a.glb"), &back), HPR_OK);
    assert_same(s, back);
    hpr_solution_destroy(&back);
    hpr_solution_destroy(&s);
    setlocale(LC_NUMERIC, "C");
}

static void no_patches_no_cameras(void **state)
{
    fixture *f = *state;
    hpr_context *ctx = f->context;
    hpr_solution *s = random_solution(ctx, 5, 3, 0, 0), *back;
    hpr_elements_destroy(&s->elements);
    hpr_patches_destroy(&s->patches);
    for (size_t i = 0; i < s->camera_count; i++)
        hpr_release(ctx, s->camera[i].name);
    s->camera_count = 0;
    assert_int_equal(hpr_patches_create(ctx, 0, 3, &s->patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(s->patches, 1, 1, &s->elements), HPR_OK);
    assert_int_equal(hpr_solution_write(ctx, s, in_folder(f, "a.glb")), HPR_OK);
    assert_int_equal(hpr_solution_read(ctx, in_folder(f, "a.glb"), &back), HPR_OK);
    assert_same(s, back);
    hpr_solution_destroy(&back);
    hpr_solution_destroy(&s);
}

/* Text that is no UTF-8 must not break the JSON. */
static void odd_names_become_text(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 5, 3, 0, 0), *back;
    hpr_release(f->context, s->scene_name);
    s->scene_name = copy_of(f->context, "a\xff\xc3 \xed\xa0\x80\t.gltf");
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    assert_int_equal(hpr_solution_read(f->context, in_folder(f, "a.glb"), &back), HPR_OK);
#define NO "\xef\xbf\xbd"
    assert_string_equal(back->scene_name, "a" NO NO " " NO NO NO "\t.gltf");
#undef NO
    hpr_solution_destroy(&back);
    hpr_solution_destroy(&s);
}

static double triangle_area(const float *a, const float *b, const float *c, const double *normal)
{
    double u[3], v[3], across[3];
    for (int k = 0; k < 3; k++) {
        u[k] = (double)b[k] - (double)a[k];
        v[k] = (double)c[k] - (double)a[k];
    }
    hpr_cross3(u, v, across);
    return 0.5 * hpr_dot3(across, normal);
}

/* The triangles of every patch cover it once, facing its front: their signed area along its normal is its
 * own. */
static void mesh_covers_every_patch(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 21, 3, 2, 4);
    hpr_solution_mesh mesh;
    assert_int_equal(hpr_solution_mesh_init(s, &mesh), HPR_OK);
    double area_m2 = 0, expected = 0;
    size_t at = 0;
    for (size_t i = 0; i < s->patches->count; i++) {
        const double *normal = s->patches->normal + 3 * i;
        double own = 0;
        while (own < 0.999999 * s->patches->area_m2[i] && at < mesh.index_count) {
            const uint32_t *t = mesh.index + at;
            double part = triangle_area(mesh.position + 3 * t[0], mesh.position + 3 * t[1],
                                        mesh.position + 3 * t[2], normal);
            assert_true(part > 0);
            own += part;
            at += 3;
        }
        area_m2 += own;
        expected += s->patches->area_m2[i];
    }
    assert_int_equal(at, mesh.index_count);
    if (fabs(area_m2 - expected) > 1e-5 * expected) /* float positions: 1e-6 of the size each */
        fail_msg("area %g, not %g", area_m2, expected);
    for (size_t v = 0; v < 3 * mesh.vertex_count; v++) {
        assert_true(mesh.colour[v] >= 0 && mesh.colour[v] <= 1);
        assert_true(mesh.position[v] >= mesh.low[v % 3] && mesh.position[v] <= mesh.high[v % 3]);
    }
    hpr_solution_mesh_fini(&mesh);
    hpr_solution_destroy(&s);
}

/* A constant on each element shows as that constant at all its vertices: neighbours do not bleed in. */
static void mesh_shows_the_radiance(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 22, 3, 2, 0);
    hpr_elements *e = s->elements;
    for (size_t i = 0; i < 3 * e->leaf_count; i++)
        s->irradiance[i] = fabs(s->irradiance[i]) + 1e-3;
    hpr_solution_mesh mesh;
    assert_int_equal(hpr_solution_mesh_init(s, &mesh), HPR_OK);
    size_t v = 0;
    for (size_t i = 0; i < e->leaf_count; i++) {
        uint32_t node = e->leaf[i], patch = e->patch[node];
        size_t corners = s->patches->shape[patch] == HPR_SHAPE_TRIANGLE ? 3 : 4;
        for (size_t k = 0; k < 3 * corners; k++, v++) {
            double h = s->irradiance[3 * i + k % 3] / sqrt(e->area_m2[node]);
            double l =
                (s->patches->exitance[3 * patch + k % 3] + s->patches->reflectance[3 * patch + k % 3] * h) /
                3.14159265358979323846;
            double expected = fmin(l * mesh.exposure, 1);
            if (fabs((double)mesh.colour[v] - expected) > 1e-6) /* twice rounded to float */
                fail_msg("element %zu: %g, not %g", i, (double)mesh.colour[v], expected);
        }
    }
    assert_int_equal(v, 3 * mesh.vertex_count);
    hpr_solution_mesh_fini(&mesh);
    hpr_solution_destroy(&s);
}

static void mesh_stays_below_two_million(void **state)
{
    fixture *f = *state;
    static const int subdivide[] = {4, 8}, order[] = {16, 1};
    for (int i = 0; i < 2; i++) {
        hpr_solution *s = random_solution(f->context, 23, 3, 0, 0);
        hpr_elements_destroy(&s->elements);
        hpr_release(f->context, s->irradiance);
        assert_int_equal(hpr_elements_uniform(s->patches, order[i], subdivide[i], &s->elements), HPR_OK);
        s->irradiance = array_of(f->context, 3 * s->elements->dof[s->elements->leaf_count], sizeof(double));
        hpr_solution_mesh mesh;
        assert_int_equal(hpr_solution_mesh_init(s, &mesh), HPR_OK);
        if (mesh.vertex_count > 2000000 || mesh.vertex_count < 100000)
            fail_msg("%zu vertices", mesh.vertex_count);
        hpr_solution_mesh_fini(&mesh);
        hpr_solution_destroy(&s);
    }
}

static void failures_leave_nothing(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 61, 3, 2, 4);
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "no/a.glb")), HPR_ERR_IO);
    assert_int_equal(hpr_solution_write(f->context, s, "/dev/full"), HPR_ERR_IO);
    assert_message_has(f, "No space left");
    f->cancel = 1;
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_ERR_INTERRUPTED);
    f->cancel = 0;
    assert_int_equal(count_files(f->folder, false), 0);
    if (mount_small(f)) {
        assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_ERR_IO);
        assert_message_has(f, "No space left");
        assert_int_equal(count_files(f->folder, false), 0);
    }
    hpr_solution_destroy(&s);
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 71, 3, 0, 1);
    hpr_status status = HPR_ERR_MEMORY;
    for (long k = 0; status != HPR_OK; k++) {
        long live = f->live;
        f->allocations_left = k;
        status = hpr_solution_write(f->context, s, in_folder(f, "a.glb"));
        f->allocations_left = -1;
        assert_int_equal(f->live, live);
        assert_true(status == HPR_OK || status == HPR_ERR_MEMORY);
        assert_int_equal(count_files(f->folder, false), status == HPR_OK);
    }
    status = HPR_ERR_MEMORY;
    for (long k = 0; status != HPR_OK; k++) {
        long live = f->live;
        hpr_solution *back;
        f->allocations_left = k;
        status = hpr_solution_read(f->context, in_folder(f, "a.glb"), &back);
        f->allocations_left = -1;
        assert_true(status == HPR_OK || (status == HPR_ERR_MEMORY && !back));
        hpr_solution_destroy(&back);
        assert_int_equal(f->live, live);
    }
    hpr_solution_destroy(&s);
}

int main(int argc, char **argv)
{
    if (argc == 2) { /* for gltf-validator: writes an example under the given name */
        void *state;
        if (fixture_setup(&state))
            return 1;
        fixture *f = state;
        hpr_solution *s = random_solution(f->context, 1, 3, 2, 4);
        hpr_status status = hpr_solution_write(f->context, s, argv[1]);
        hpr_solution_destroy(&s);
        return fixture_teardown(&state) || status != HPR_OK;
    }
    const struct CMUnitTest tests[] = {
        IO_TEST(everything_comes_back_bit_for_bit),
        IO_TEST(same_solution_same_bytes),
        IO_TEST(locale_does_not_matter),
        IO_TEST(no_patches_no_cameras),
        IO_TEST(odd_names_become_text),
        IO_TEST(mesh_covers_every_patch),
        IO_TEST(mesh_shows_the_radiance),
        IO_TEST(mesh_stays_below_two_million),
        IO_TEST(failures_leave_nothing),
        IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
