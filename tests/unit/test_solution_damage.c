#include "io/glb.h"
#include "random_solution.h"

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

/* Every occurrence of `from` in the JSON. */
static void replace_all(unsigned char *data, size_t bytes, const char *from, const char *to)
{
    size_t length = strlen(from);
    for (size_t i = 0; i + length <= bytes; i++) {
        if (!memcmp(data + i, from, length))
            memcpy(data + i, to, length);
    }
}

/* Files of version 1 know nothing of light from outside. */
static void version_1_is_read_as_dark_outside(void **state)
{
    fixture *f = *state;
    static const char *const later[] = {"\"environment",  "\"surroundings\"",     "\"weldDistance\"",
                                        "\"feet\"",       "\"blockedTolerance\"", "\"visibilityError\"",
                                        "\"blockError\"", "\"sampledError\""};
    hpr_solution *s = random_solution(f->context, 51, 3, 0, 1), *back;
    assert_int_equal(hpr_solution_write(f->context, s, in_folder(f, "a.glb")), HPR_OK);
    size_t bytes;
    unsigned char *data = slurp(in_folder(f, "a.glb"), &bytes);
    replace(data, bytes, "HPRAD_radiosity\":{\"version\":6", "HPRAD_radiosity\":{\"version\":1");
    for (size_t i = 0; i < sizeof later / sizeof *later; i++) {
        char other[32];
        snprintf(other, sizeof other, "%s", later[i]);
        other[1] = 'X';
        replace_all(data, bytes, later[i], other);
    }
    spill(in_folder(f, "b.glb"), data, bytes);
    free(data);
    assert_int_equal(hpr_solution_read(f->context, in_folder(f, "b.glb"), &back), HPR_OK);
    for (size_t c = 0; c < 3; c++) {
        assert_true(back->environment[c] == 0 && back->energy[c].environment == 0);
        assert_true(back->energy[c].emitted == s->energy[c].emitted);
    }
    assert_int_equal(back->summary.environment, HPR_ENVIRONMENT_NONE);
    assert_int_equal(back->summary.sweeps, s->summary.sweeps);
    assert_true(back->patches->weld_m > 0);
    for (size_t i = 0; i < 3 * s->patches->count; i++)
        assert_true(back->surroundings[i] == 0 && s->surroundings[i] > 0);
    hpr_solution_destroy(&back);
    hpr_solution_destroy(&s);
}

static void other_files_are_named(void **state)
{
    fixture *f = *state;
    static const char *const cases[][3] = {
        {"HPRAD_radiosity\":{\"version\":6", "HPRAD_radiosity\":{\"version\":7", "newer hprad"},
        {"HPRAD_radiosity\":{\"version\":6", "HPRAD_radiosity\":{\"version\":0", "version is missing"},
        {"HPRAD_radiosity\":{", "HPRAD_RADIOSITY\":{", "not an hprad solution"},
        {"glTF", "glTf", "no .glb file"},
        {"\"uint8\"", "\"uint9\"", "patches.shape"},
        {"\"width\":3", "\"width\":4", "textures.texels"},
        {"\"height\":2", "\"height\":0", "texture 0"},
        {"\"wrapU\":1", "\"wrapU\":3", "texture 0"},
        {"\"texels\":", "\"texelS\":", "textures.texels"},
        {"\"textureMap\"", "\"textureMaP\"", "patches.textureMap"},
        {"\"kind\":\"perspective\"", "\"kind\":\"perspectivE\"", "camera"},
        {"\"lostOnBacks\"", "\"lostOnbacks\"", "lostOnBacks"},
        {"\"environment\":[0.", "\"environment\":[-1", "environment is missing"},
        {"\"environment\":[0.", "\"environmenT\":[0.", "environment is missing"},
        {"\"environment\":2,", "\"environment\":3,", "environment is not sound"},
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(truncated_files_are_refused),   IO_TEST(damaged_files_do_no_harm),
        IO_TEST(unsound_solutions_are_refused), IO_TEST(version_1_is_read_as_dark_outside),
        IO_TEST(other_files_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
