/* Reading View3D's .vs3: every element, and every refusal with its place and value. */
#include "failing_allocator.h"
#include "io/vs3_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

typedef struct fixture {
    char path[64];
    char warning[512];
    hpr_context *context;
    hpr_model *model;
} fixture;

static void keep_warning(void *user, hpr_log_level level, const char *text)
{
    fixture *f = user;
    if (level == HPR_LOG_WARNING)
        snprintf(f->warning, sizeof f->warning, "%s", text);
}

static int set_up(void **state)
{
    static fixture f;
    f = (fixture){.path = "/tmp/hprad_vs3_XXXXXX"};
    int fd = mkstemp(f.path);
    assert_true(fd >= 0);
    close(fd);
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.log = keep_warning;
    options.user = &f;
    assert_int_equal(hpr_context_create(&options, &f.context), HPR_OK);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    hpr_model_destroy(&f->model);
    hpr_context_destroy(&f->context);
    unlink(f->path);
    return 0;
}

static void write_bytes(const fixture *f, const char *text, size_t bytes)
{
    FILE *file = fopen(f->path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, bytes, file), bytes);
    assert_int_equal(fclose(file), 0);
}

static hpr_status read_text(fixture *f, const char *text)
{
    write_bytes(f, text, strlen(text));
    hpr_model_destroy(&f->model);
    return hpr_vs3_read(f->context, f->path, &f->model);
}

static void must_read(fixture *f, const char *text)
{
    if (read_text(f, text) != HPR_OK)
        fail_msg("%s", hpr_context_error(f->context));
}

#define SQUARE                                                                                               \
    "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nV 5 .25 .25 0\nV 6 .75 .25 0\nV 7 .75 .75 0\n"         \
    "V 8 .25 .75 0\n"

static void every_element_is_read(void **state)
{
    fixture *f = *state;
    must_read(f, "\xef\xbb\xbfT first\r\nt The / last\n! comment\n/ another\n\n"
                 "c encl=1 EMIT=1 eps=1.e-5 ! comment\n" SQUARE "S 1 1 2 3 4 0 0 .5 a wall ! named\n"
                 "s 2 5 6 7 8 1 1 1. win\nObstr 3 1 2 3 0 0 0 0\nm 4 8 7 6 5 1 0 .25 mask\n"
                 "N 5 5 6 7 0 1 0 0 hole\nEnd\nnot read");
    const hpr_model *m = f->model;
    assert_int_equal(m->count, 5);
    assert_true(m->closed && m->exchange);
    assert_true(m->tolerance == 1e-5);
    assert_string_equal(m->surface[0].name, "a wall");
    const hpr_surface_kind kinds[] = {HPR_SURFACE_RADIATES, HPR_SURFACE_RADIATES, HPR_SURFACE_OBSTRUCTS,
                                      HPR_SURFACE_MASKS, HPR_SURFACE_IS_ABSENT};
    for (size_t i = 0; i < 5; i++)
        assert_int_equal(m->surface[i].kind, kinds[i]);
    assert_int_equal(m->surface[0].base, HPR_NONE);
    assert_int_equal(m->surface[1].base, 0);
    assert_int_equal(m->surface[1].combine, 0);
    assert_int_equal(m->surface[2].corner_count, 3);
    assert_true(m->surface[0].emissivity == 0.5 && m->surface[0].area_m2 == 1 &&
                m->surface[0].normal[2] == 1);
    assert_string_equal(f->warning, "");
}

static void control_words_without_effect_are_named_once(void **state)
{
    fixture *f = *state;
    must_read(f, "C maxU=8 list=3 maxU=9\nC maxU=1 out=1\n" SQUARE "S 1 1 2 3 4 0 0 .5\n");
    assert_non_null(strstr(f->warning, ": control words without effect: maxU, list, out"));
    assert_null(strstr(strstr(f->warning, "maxU") + 1, "maxU"));
}

/* R, Q and T on two or three lines; quarter turns are exact. */
static void planes_are_placed(void **state)
{
    fixture *f = *state;
    must_read(f, "F 3A\nS 1 r 0 0 .5 wall\n 3. 0. 0. 0 90 3. 2.\nS 2 Q 0 0 .5 ceiling\n3 0 3 0 180\n"
                 "2 0 3 0 ! half\n3 1 2 1\nS 3 T 0 0 .5 roof\n1 2 3 30 60\n0 0 1 0 0 1\n*\n");
    const double wall[4][3] = {{3, 0, 0}, {0, 0, 0}, {0, 0, 2}, {3, 0, 2}};
    const double ceiling[4][3] = {{1, 0, 3}, {0, 0, 3}, {0, 1, 3}, {1, 1, 3}};
    for (int i = 0; i < 12; i++)
        assert_true(f->model->surface[0].corner[i / 3][i % 3] == wall[i / 3][i % 3]);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++)
            assert_true(f->model->surface[1].corner[i][k] == ceiling[i][k]);
    }
    const double *n = f->model->surface[2].normal, pi = 3.14159265358979323846;
    const double expected[3] = {sin(pi / 3) * sin(pi / 6), sin(pi / 3) * cos(pi / 6), cos(pi / 3)};
    for (int k = 0; k < 3; k++)
        assert_true(fabs(n[k] - expected[k]) < 4e-16);
}

static void rounded_coordinates_are_planar_enough(void **state)
{
    fixture *f = *state;
    must_read(f, "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 1e-6\nV 4 0 1 0\nS 1 1 2 3 4 0 0 .5 a\n");
}

static void no_area_is_warned_about(void **state)
{
    fixture *f = *state;
    must_read(f, "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 2 0 0\nS 1 1 2 3 0 0 0 .5 thin\n");
    assert_non_null(strstr(f->warning, "line 5: surface 1 'thin' has no area"));
    assert_true(f->model->surface[0].area_m2 == 0);
}

/* text, status, two parts of the message (after the file's name) */
static const struct {
    const char *text;
    hpr_status status;
    const char *parts[2];
} refused[] = {
    {"", HPR_ERR_FORMAT, {"no surfaces", ""}},
    {"F 3\nQ 1\n", HPR_ERR_FORMAT, {"line 2:", "'Q'"}},
    {"F 3\nX 1 2 3\n", HPR_ERR_UNSUPPORTED, {"line 2:", "(X)"}},
    {"F 2\n", HPR_ERR_UNSUPPORTED, {"line 1:", "'2'"}},
    {"F\n", HPR_ERR_FORMAT, {"line 1:", "3 or 3a"}},
    {"F 3\nF 3\n", HPR_ERR_FORMAT, {"line 2:", "second"}},
    {"V 1 0 0 0\n", HPR_ERR_FORMAT, {"line 1:", "F 3"}},
    {"S 1 1 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 1:", "F 3"}},
    {"F 3\nV 2 0 0 0\n", HPR_ERR_FORMAT, {"line 2:", "'2'"}},
    {"F 3\nV 1 0 nan 0\n", HPR_ERR_FORMAT, {"line 2: coordinate y", "'nan'"}},
    {"F 3\nV 1 0 1e999 0\n", HPR_ERR_FORMAT, {"line 2: coordinate y", "'1e999'"}},
    {"F 3\nV 1 0 0\n", HPR_ERR_FORMAT, {"line 2: coordinate z", "missing"}},
    {"F 3\nV 1 0 0 0 7\n", HPR_ERR_FORMAT, {"line 2:", "'7' is one word too many"}},
    {SQUARE "S 1 1 2 3 9 0 0 .5\n", HPR_ERR_FORMAT, {"line 10: vertex v4", "'9'"}},
    {SQUARE "S 1 0 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 10: vertex v1", "'0'"}},
    {SQUARE "S 1 -1 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 10: vertex v1", "'-1'"}},
    {SQUARE "S 2 1 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 10:", "'2'"}},
    {SQUARE "S 1 1 2 3 4 1 0 .5\n", HPR_ERR_FORMAT, {"line 10: base", "'1'"}},
    {SQUARE "S 1 1 2 3 4 0 7 .5\n", HPR_ERR_FORMAT, {"line 10: cmb", "'7'"}},
    {SQUARE "S 1 1 2 3 4 0 0 1.5\n", HPR_ERR_FORMAT, {"line 10: emittance", "'1.5'"}},
    {SQUARE "S 1 1 2 3 4 0 0\n", HPR_ERR_FORMAT, {"line 10: emittance", "missing"}},
    {SQUARE "S 1 1 3 2 4 0 0 .5 bow\n", HPR_ERR_FORMAT, {"line 10: surface 1 'bow'", "cross"}},
    {SQUARE "S 1 1 2 5 4 0 0 .5 dart\n", HPR_ERR_FORMAT, {"line 10: surface 1 'dart'", "corner: 3"}},
    {SQUARE "V 9 1 1 .01\nS 1 1 2 9 4 0 0 .5 bent\n", HPR_ERR_FORMAT, {"line 11: surface 1 'bent'", "plane"}},
    {SQUARE "M 1 1 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 10:", "(M) needs a base"}},
    {SQUARE "N 1 1 2 3 4 0 0 .5\n", HPR_ERR_FORMAT, {"line 10:", "(N) needs a base"}},
    {SQUARE "S 1 1 2 3 4 0 0 .5\nS 2 8 7 6 5 1 0 .5\n", HPR_ERR_FORMAT, {"line 11:", "same way"}},
    {SQUARE "S 1 1 2 3 4 0 0 .5\nM 2 5 6 7 8 1 0 .5\n", HPR_ERR_FORMAT, {"line 11:", "mask must face"}},
    {SQUARE "S 1 5 6 7 8 0 0 .5\nS 2 1 2 3 4 1 0 .5\n", HPR_ERR_FORMAT, {"line 11:", "reaches out"}},
    {SQUARE "V 9 .2 .2 1\nV 10 .4 .2 1\nV 11 .4 .4 1\nS 1 1 2 3 4 0 0 .5\nS 2 9 10 11 0 1 0 .5\n",
     HPR_ERR_FORMAT,
     {"line 14:", "not in the plane of its base"}},
    {SQUARE "V 9 .5 .2 .2\nS 1 1 2 3 4 0 0 .5\nS 2 5 6 9 0 1 0 .5\n",
     HPR_ERR_FORMAT,
     {"line 12:", "not parallel"}},
    {SQUARE "S 1 1 2 3 4 0 0 .5\nN 2 5 6 7 8 1 0 .5\nS 3 5 6 7 8 2 0 .5\n",
     HPR_ERR_FORMAT,
     {"line 12:", "its base is a mask or a null surface, number: 2"}},
    {SQUARE "O 1 1 2 3 4 0 0 .5\nS 2 5 6 7 8 0 1 .5\n", HPR_ERR_FORMAT, {"line 11:", "no row: 1"}},
    {SQUARE "S 1 1 2 3 4 0 0 .5\nO 2 5 6 7 8 0 1 .5\n", HPR_ERR_FORMAT, {"line 11:", "surface: 1"}},
    {SQUARE "S 1 1 2 3 4 0 0 .5\nS 2 5 6 7 8 0 1 .5\nS 3 5 6 7 8 0 2 .5\n",
     HPR_ERR_FORMAT,
     {"line 12:", "itself combined: 2"}},
    {"C encl=2\n", HPR_ERR_FORMAT, {"line 1: encl", "'2'"}},
    {"C eps=0\n", HPR_ERR_FORMAT, {"line 1: eps", "'0'"}},
    {"C encl\n", HPR_ERR_FORMAT, {"line 1:", "'encl': expected name=value"}},
    {"F 3a\nV 1 0 0 0\n", HPR_ERR_FORMAT, {"line 2:", "F 3"}},
    {"F 3a\nS 1 Z 0 0 .5\n", HPR_ERR_FORMAT, {"line 2:", "'Z'"}},
    {"F 3a\nS 1 R 0 0 .5 a\n1 2 3\n", HPR_ERR_FORMAT, {"line 3:", "file ends"}},
    {"F 3a\nS 1 R 0 0 .5 a\n1 2 3 0 90 1\nEnd\n", HPR_ERR_FORMAT, {"line 4:", "'End'"}},
    {"F 3a\nS 1 R 0 0 .5 a\n1 2 3 0 90 1 2 3\n", HPR_ERR_FORMAT, {"line 3:", "'3' is one word too many"}},
    {"F 3a\nS 1 R 0 0 .5 a\n1 2 3 0 90 -1 2\n", HPR_ERR_FORMAT, {"line 3:", "-1"}},
};

static void faults_are_named(void **state)
{
    fixture *f = *state;
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        hpr_status status = read_text(f, refused[i].text);
        const char *said = hpr_context_error(f->context);
        bool names = !strncmp(said, f->path, strlen(f->path));
        if (status != refused[i].status || !names || !strstr(said, refused[i].parts[0]) ||
            !strstr(said, refused[i].parts[1]) || f->model)
            fail_msg("case %zu: '%s' (%s), expected '%s' and '%s'", i, said, hpr_status_string(status),
                     refused[i].parts[0], refused[i].parts[1]);
    }
}

static void bytes_that_are_no_text_are_refused(void **state)
{
    fixture *f = *state;
    write_bytes(f, "F 3\nV 1 \0 0\n", 12);
    assert_int_equal(hpr_vs3_read(f->context, f->path, &f->model), HPR_ERR_FORMAT);
    assert_non_null(strstr(hpr_context_error(f->context), "line 2: a zero byte"));
    assert_int_equal(hpr_vs3_read(f->context, "/nowhere.vs3", &f->model), HPR_ERR_IO);
    assert_non_null(strstr(hpr_context_error(f->context), "/nowhere.vs3"));
}

static hpr_status read_small(hpr_context *ctx, void *data)
{
    const fixture *f = data;
    hpr_model *model = NULL;
    hpr_status status = hpr_vs3_read(ctx, f->path, &model);
    hpr_model_destroy(&model);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    must_read(f, "T t\n" SQUARE "S 1 1 2 3 4 0 0 .5 a\nS 2 5 6 7 8 1 1 .5 b\n");
    assert_true(sweep_allocations(read_small, f, 1) > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_element_is_read, set_up, tear_down),
        cmocka_unit_test_setup_teardown(control_words_without_effect_are_named_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(planes_are_placed, set_up, tear_down),
        cmocka_unit_test_setup_teardown(rounded_coordinates_are_planar_enough, set_up, tear_down),
        cmocka_unit_test_setup_teardown(no_area_is_warned_about, set_up, tear_down),
        cmocka_unit_test_setup_teardown(faults_are_named, set_up, tear_down),
        cmocka_unit_test_setup_teardown(bytes_that_are_no_text_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(every_allocation_may_fail, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
