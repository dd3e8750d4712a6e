#include "solver/solution.h"

#include "io/glb.h"
#include "io/json_text.h"
#include "io/solution_format.h"
#include "io/solution_mesh.h"
#include "io_support.h"
#include "shapes.h"

#include <locale.h>

static char *copy_of(hpr_context *ctx, const char *text)
{
    char *copy = hpr_duplicate_text(ctx, text);
    assert_non_null(copy);
    return copy;
}

static void *array_of(hpr_context *ctx, size_t count, size_t bytes)
{
    void *array = hpr_allocate(ctx, count, bytes);
    assert_non_null(array);
    return array;
}

static hpr_patches *random_patches(hpr_context *ctx, uint64_t *seed, size_t channels)
{
    enum { COUNT = 7 };
    hpr_patches *p = NULL;
    assert_int_equal(hpr_patches_create(ctx, COUNT, channels, &p), HPR_OK);
    for (size_t i = 0; i < COUNT; i++) {
        double frame[9];
        for (int k = 0; k < 9; k++)
            frame[k] = 10 * random_unit(seed) - 5;
        frame[0] += 1e4; /* far from the origin */
        p->twin[i] = p->material[i] = HPR_NONE;
        if (i == 4)
            shapes_twin(p, 3, 4);
        else
            shapes_set(p, i, i % 2 ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM, frame, frame + 3,
                       frame + 6);
        p->node[i] = (uint32_t)random_bits(seed);
        p->primitive[i] = (uint32_t)random_bits(seed);
        if (i > 2)
            p->material[i] = (uint32_t)i;
        for (size_t c = 0; c < channels; c++) {
            p->reflectance[i * channels + c] = random_unit(seed);
            p->exitance[i * channels + c] = i == 2 ? 100 * random_unit(seed) : 0;
        }
    }
    p->degenerate_count = 3;
    p->duplicate_count = 5;
    return p;
}

static void add_camera(hpr_solution *s, size_t i, const char *name, uint64_t *seed)
{
    hpr_camera *camera = s->camera + i;
    *camera =
        (hpr_camera){.name = copy_of(s->context, name), .right = {1}, .up = {0, 0, 1}, .backward = {0, -1}};
    for (int k = 0; k < 3; k++)
        camera->origin[k] = 10 * random_unit(seed);
    camera->kind = i % 2 ? HPR_CAMERA_ORTHOGRAPHIC : HPR_CAMERA_PERSPECTIVE;
    camera->yfov_rad = 1.0 / 3;
    camera->aspect = i == 2 ? 0 : 16.0 / 9;
    camera->xmag = 1.1;
    camera->ymag = 0.7;
    camera->znear = i == 2 ? 0 : 0.1;
    camera->zfar = i == 3 ? 100 : INFINITY;
}

static void fill_figures(hpr_solution *s, uint64_t *seed)
{
    size_t count;
    const hpr_field *fields = hpr_summary_fields(&count);
    for (size_t i = 0; i < count; i++) {
        char *at = (char *)&s->summary + fields[i].offset;
        double number = random_unit(seed) / 3;
        int whole = (int)(random_bits(seed) >> 40);
        size_t size = (size_t)(random_bits(seed) >> 20);
        if (fields[i].kind == HPR_FIELD_DOUBLE)
            memcpy(at, &number, sizeof number);
        else if (fields[i].kind == HPR_FIELD_INT)
            memcpy(at, &whole, sizeof whole);
        else
            memcpy(at, &size, sizeof size);
    }
    s->summary.residual = NAN;
    s->energy = array_of(s->context, s->channel_count, sizeof *s->energy);
    for (size_t c = 0; c < s->channel_count; c++)
        s->energy[c] = (hpr_energy){random_unit(seed), random_unit(seed) * 1e-300, -0.0, INFINITY};
}

/* Trees of depth 2 `subdivide` with degrees 0 .. most, random numbers everywhere. */
static hpr_solution *random_solution(hpr_context *ctx, uint64_t seed, size_t channels, int subdivide,
                                     int most)
{
    static const char *const names[] = {"R", "G", "B", "infrared", "\xc3\xa9t\xc3\xa9"};
    hpr_solution *s = array_of(ctx, 1, sizeof *s);
    s->context = ctx;
    s->scene_name = copy_of(ctx, "scene \"1\".gltf");
    s->channel_count = channels;
    s->channel_name = array_of(ctx, channels, sizeof(char *));
    for (size_t c = 0; c < channels; c++)
        s->channel_name[c] = copy_of(ctx, names[c]);
    s->patches = random_patches(ctx, &seed, channels);
    assert_int_equal(hpr_elements_uniform(s->patches, 0, subdivide, &s->elements), HPR_OK);
    hpr_elements *e = s->elements;
    for (size_t i = 0; i < e->node_count; i++)
        e->degree[i] = (uint8_t)(random_bits(&seed) >> 8) % (uint8_t)(most + 1);
    assert_int_equal(hpr_elements_index(s->patches, e), HPR_OK);
    size_t dofs = e->dof[e->leaf_count];
    s->irradiance = array_of(ctx, dofs * channels, sizeof(double));
    for (size_t i = 0; i < dofs * channels; i++)
        s->irradiance[i] = 20 * random_unit(&seed) - 2;
    s->error = array_of(ctx, e->leaf_count, sizeof(double));
    for (size_t i = 0; i < e->leaf_count; i++) {
        uint64_t payload = 0x7ff8000000001234u + i; /* the payload of a NaN, too */
        memcpy(s->error + i, &payload, sizeof payload);
        if (i % 2)
            s->error[i] = random_unit(&seed);
    }
    s->camera_count = 4;
    s->camera = array_of(ctx, 4, sizeof *s->camera);
    const char *const cameras[] = {"front", "", "a/b \xe2\x9c\x93", "front"};
    for (size_t i = 0; i < 4; i++)
        add_camera(s, i, cameras[i], &seed);
    fill_figures(s, &seed);
    return s;
}

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
    assert_memory_equal(e->leaf_of_node, f->leaf_of_node, e->node_count * sizeof(uint32_t));
    assert_memory_equal(e->patch_leaf, f->patch_leaf, (e->patch_count + 1) * sizeof(uint32_t));
    assert_string_equal(a->scene_name, b->scene_name);
    assert_int_equal(a->channel_count, b->channel_count);
    for (size_t c = 0; c < a->channel_count; c++)
        assert_string_equal(a->channel_name[c], b->channel_name[c]);
    assert_memory_equal(a->energy, b->energy, a->channel_count * sizeof *a->energy);
    assert_true(isnan(b->summary.residual));
    a->summary.residual = b->summary.residual = 0; /* a NaN in the JSON has no payload */
    assert_memory_equal(&a->summary, &b->summary, sizeof a->summary);
    a->summary.residual = b->summary.residual = NAN;
    assert_int_equal(a->patches->degenerate_count, b->patches->degenerate_count);
    assert_int_equal(a->patches->duplicate_count, b->patches->duplicate_count);
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
    for (size_t c = 0; c < 7 * 3; c++)
        s->patches->exitance[c] += 100; /* bright: nothing is clamped at black */
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
        assert_true(mesh.colour[v] > 0 && mesh.colour[v] <= 1);
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

/* A file that was cut or changed is refused with a message, or is a sound solution that can be written. */
static void read_damaged(fixture *f, const unsigned char *data, size_t bytes)
{
    hpr_solution *back;
    spill(in_folder(f, "b.glb"), data, bytes);
    hpr_status status = hpr_solution_read(f->context, in_folder(f, "b.glb"), &back);
    assert_true(status == HPR_OK || (status == HPR_ERR_FORMAT && !back));
    if (status == HPR_OK)
        assert_int_equal(hpr_solution_write(f->context, back, "/dev/null"), HPR_OK);
    else
        assert_message_has(f, "b.glb");
    hpr_solution_destroy(&back);
}

static void truncated_files_are_refused(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 31, 3, 1, 2);
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    size_t bytes;
    unsigned char *data = slurp(in_folder(f, "a.glb"), &bytes);
    for (size_t cut = 0; cut < bytes; cut += 97) {
        read_damaged(f, data, cut);
        /* and with a header that admits it */
        unsigned char *copy = malloc(cut + 4);
        memcpy(copy, data, cut);
        uint32_t length = (uint32_t)cut;
        if (cut >= 12)
            memcpy(copy + 8, &length, 4);
        read_damaged(f, copy, cut);
        free(copy);
    }
    free(data);
    hpr_solution_destroy(&s);
}

static void damaged_files_do_no_harm(void **state)
{
    fixture *f = *state;
    hpr_solution *s = random_solution(f->context, 32, 1, 0, 1);
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    size_t bytes;
    unsigned char *data = slurp(in_folder(f, "a.glb"), &bytes);
    uint64_t seed = 4711;
    for (int round = 0; round < 6000; round++) {
        size_t at = (size_t)(random_bits(&seed) % bytes);
        unsigned char before[8];
        size_t changed = bytes - at < 4 || round % 2 ? 1 : 4;
        memcpy(before, data + at, changed);
        for (size_t i = 0; i < changed; i++)
            data[at + i] = (unsigned char)(random_bits(&seed) >> 30);
        if (round % 3 == 0 && data[at] < 0x80)
            data[at] = (unsigned char)('0' + data[at] % 10); /* another number in the JSON */
        read_damaged(f, data, bytes);
        memcpy(data + at, before, changed);
    }
    free(data);
    hpr_solution_destroy(&s);
}

typedef void (*spoil)(hpr_solution *s);

static void spoil_shape(hpr_solution *s)
{
    s->patches->shape[1] = 2;
}
static void spoil_twin(hpr_solution *s)
{
    s->patches->twin[1] = 7;
}
static void spoil_area(hpr_solution *s)
{
    s->patches->area_m2[2] = 0;
}
static void spoil_rho(hpr_solution *s)
{
    s->patches->reflectance[2] = 1.5;
}
static void spoil_exitance(hpr_solution *s)
{
    s->patches->exitance[2] = NAN;
}
static void spoil_normal(hpr_solution *s)
{
    s->patches->normal[2] = 3;
}
static void spoil_degree(hpr_solution *s)
{
    s->elements->degree[9] = 17;
}
static void spoil_dofs(hpr_solution *s)
{
    s->elements->degree[s->elements->leaf[0]] = 5;
}
static void spoil_cycle(hpr_solution *s)
{
    s->elements->child[s->elements->child[0]] = s->elements->child[0];
}
static void spoil_root(hpr_solution *s)
{
    s->elements->child[s->elements->child[0]] = 0;
}
static void spoil_share(hpr_solution *s)
{
    s->elements->child[0] = s->elements->child[1];
}
static void spoil_orphan(hpr_solution *s)
{
    s->elements->child[0] = HPR_NONE;
}
static void spoil_range(hpr_solution *s)
{
    s->elements->child[0] = (uint32_t)s->elements->node_count - 1;
}
static void spoil_owner(hpr_solution *s)
{
    s->elements->patch[s->elements->child[0]] = 1;
}
static void spoil_axis(hpr_solution *s)
{
    s->elements->axis[0] = 2;
}
static void spoil_leaf(hpr_solution *s)
{
    s->elements->leaf[0] = s->elements->leaf[1];
}
static void spoil_first(hpr_solution *s)
{
    s->elements->dof[1]++;
}
static void spoil_frame(hpr_solution *s)
{
    s->elements->edge1[4] = INFINITY;
}
static void spoil_value(hpr_solution *s)
{
    s->irradiance[3] = NAN;
}
static void spoil_error(hpr_solution *s)
{
    s->error[1] = -1;
}
static void spoil_camera(hpr_solution *s)
{
    s->camera[0].up[1] = NAN;
}
static void spoil_fov(hpr_solution *s)
{
    s->camera[0].yfov_rad = 4;
}

static void unsound_solutions_are_refused(void **state)
{
    fixture *f = *state;
    static const struct {
        spoil change;
        const char *message;
    } cases[] = {
        {spoil_shape, "patch 1 "},     {spoil_twin, "patch 1 "},     {spoil_area, "patch 2 "},
        {spoil_rho, "patch 0 "},       {spoil_exitance, "patch 0 "}, {spoil_normal, "patch 0 "},
        {spoil_degree, "element 9 "},  {spoil_dofs, "contradict"},   {spoil_cycle, "two places"},
        {spoil_root, "is not sound"},  {spoil_share, "not sound"},   {spoil_orphan, "no tree"},
        {spoil_range, "element 0 "},   {spoil_owner, "element 0 "},  {spoil_axis, "element 0 "},
        {spoil_leaf, "solution.leaf"}, {spoil_first, "solution.f"},  {spoil_frame, "element 1 "},
        {spoil_value, "irradiance"},   {spoil_error, "error"},       {spoil_camera, "camera"},
        {spoil_fov, "camera"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_solution *s = random_solution(f->context, 41, 3, 1, 1), *back;
        /* written through the table, since the mesh of an unsound solution cannot be made */
        assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
        size_t bytes;
        unsigned char *data = slurp(in_folder(f, "a.glb"), &bytes);
        hpr_glb glb;
        assert_int_equal(hpr_glb_read(f->context, in_folder(f, "a.glb"), &glb), HPR_OK);
        cases[i].change(s);
        const hpr_elements *e = s->elements;
        const hpr_solution_sizes sizes = {3, s->patches->count, e->node_count, e->leaf_count,
                                          e->dof[e->leaf_count]};
        hpr_column columns[HPR_COLUMN_COUNT];
        hpr_solution_columns(&sizes, s, columns);
        const cJSON *extension =
            cJSON_GetObjectItem(cJSON_GetObjectItem(glb.root, "extensions"), HPR_EXTENSION_NAME);
        for (size_t c = 0; c < HPR_COLUMN_COUNT; c++) {
            const cJSON *group = cJSON_GetObjectItem(extension, columns[c].group);
            const cJSON *view = cJSON_GetObjectItem(cJSON_GetObjectItem(group, columns[c].key), "bufferView");
            const unsigned char *at;
            size_t length;
            void *array;
            assert_int_equal(hpr_glb_view(&glb, (size_t)view->valuedouble, &at, &length), HPR_OK);
            memcpy(&array, columns[c].array, sizeof array);
            memcpy(data + (at - glb.data), array, length);
        }
        hpr_glb_fini(&glb);
        spill(in_folder(f, "a.glb"), data, bytes);
        free(data);
        if (i >= sizeof cases / sizeof *cases - 2) /* cameras are JSON: the mesh does not look at them */
            assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
        hpr_status status = hpr_solution_read(f->context, in_folder(f, "a.glb"), &back);
        if (status != HPR_ERR_FORMAT)
            fail_msg("case %zu was accepted", i);
        assert_message_has(f, "a.glb");
        assert_message_has(f, cases[i].message);
        assert_null(back);
        hpr_solution_destroy(&s);
    }
}

/* Replaces a text in the file by one of the same length. */
static void replace(unsigned char *data, size_t bytes, const char *from, const char *to)
{
    size_t length = strlen(from);
    assert_int_equal(length, strlen(to));
    for (size_t i = 0; i + length <= bytes; i++) {
        if (!memcmp(data + i, from, length)) {
            memcpy(data + i, to, length);
            return;
        }
    }
    fail_msg("no '%s' in the file", from);
}

static void other_files_are_named(void **state)
{
    fixture *f = *state;
    static const char *const cases[][3] = {
        {"HPRAD_radiosity\":{\"version\":1", "HPRAD_radiosity\":{\"version\":2", "newer hprad"},
        {"HPRAD_radiosity\":{\"version\":1", "HPRAD_radiosity\":{\"version\":0", "version is missing"},
        {"HPRAD_radiosity\":{", "HPRAD_RADIOSITY\":{", "not an hprad solution"},
        {"glTF", "glTf", "no .glb file"},
        {"\"uint8\"", "\"uint9\"", "patches.shape"},
        {"\"kind\":\"perspective\"", "\"kind\":\"perspectivE\"", "camera"},
        {"\"lostOnBacks\"", "\"lostOnbacks\"", "lostOnBacks"},
    };
    hpr_solution *s = random_solution(f->context, 51, 3, 0, 1), *back;
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t bytes;
        unsigned char *data = slurp(in_folder(f, "a.glb"), &bytes);
        replace(data, bytes, cases[i][0], cases[i][1]);
        spill(in_folder(f, "b.glb"), data, bytes);
        free(data);
        assert_int_equal(hpr_solution_read(f->context, in_folder(f, "b.glb"), &back), HPR_ERR_FORMAT);
        assert_message_has(f, cases[i][2]);
        assert_message_has(f, "b.glb");
    }
    assert_int_equal(hpr_solution_read(f->context, in_folder(f, "none.glb"), &back), HPR_ERR_IO);
    assert_message_has(f, "No such file");
    assert_int_equal(hpr_solution_read(f->context, f->folder, &back), HPR_ERR_IO);
    assert_message_has(f, "Is a directory");
    hpr_solution_destroy(&s);
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
        IO_TEST(truncated_files_are_refused),
        IO_TEST(damaged_files_do_no_harm),
        IO_TEST(unsound_solutions_are_refused),
        IO_TEST(other_files_are_named),
        IO_TEST(failures_leave_nothing),
        IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
