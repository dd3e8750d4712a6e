#include "io/csv_points.h"

#include "io_support.h"

#include <fcntl.h>
#include <hprad/scene.h>

static hpr_status read_text(fixture *f, const char *text, size_t *count, double **point, double **normal)
{
    spill(in_folder(f, "p.csv"), text, strlen(text));
    return hpr_points_read(f->context, in_folder(f, "p.csv"), count, point, normal);
}

static void columns_come_in_any_order(void **state)
{
    fixture *f = *state;
    static const char *const texts[] = {
        "x,y,z,nx,ny,nz\n1,2.5,-3e-1,0,0,1\n4,5,6,1,0,0\n",
        "x,y,z,nx,ny,nz\r\n1,2.5,-3e-1,0,0,1\r\n\r\n4,5,6,1,0,0", /* CRLF, an empty line, no last line end */
        "\xef\xbb\xbfname,nz,ny,nx,z,y,x,note\n\"a, \"\"b\"\"\",1,0,0,-0.3,2.5,1,\n b ,0,0,1,6,5,4,\"\"\n",
        " \"x\" , y ,z,nx,ny,nz\n 1 ,\t2.5,\"-.3\",0,0,1\n4,5,6,1,0,0\n \n",
    };
    static const double point[] = {1, 2.5, -0.3, 4, 5, 6}, normal[] = {0, 0, 1, 1, 0, 0};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        size_t count;
        double *p, *n;
        assert_int_equal(read_text(f, texts[i], &count, &p, &n), HPR_OK);
        assert_int_equal(count, 2);
        assert_memory_equal(p, point, sizeof point);
        assert_memory_equal(n, normal, sizeof normal);
        hpr_release(f->context, p);
        hpr_release(f->context, n);
    }
}

static void faults_are_named_with_line_and_column(void **state)
{
    fixture *f = *state;
    static const char *const cases[][2] = {
        {"", "empty"},
        {"x,y,z,nx,ny\n", "line 1: no column 'nz'"},
        {"x,y,z,nx,ny,nz,x\n", "line 1: more than one column 'x'"},
        {"1,2,3,0,0,1\n", "line 1: no column 'x'"},
        {"x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,3,0,0\n", "line 3: 5 fields, but the header has 6"},
        {"x,y,z,nx,ny,nz\n\n1,2,3,0,0,1,9\n", "line 3: 7 fields"},
        {"x,y,z,nx,ny,nz\n1,2,3,0,abc,1\n", "line 2: column 'ny': 'abc' is not a finite number"},
        {"x,y,z,nx,ny,nz\n1,2x,3,0,0,1\n", "line 2: column 'y': '2x'"},
        {"x,y,z,nx,ny,nz\n1,\"2\"5x,3,0,0,1\n", "line 2: column 'y': '25x'"},
        {"x,y,z,nx,ny,nz\n1,,3,0,0,1\n", "line 2: column 'y': ''"},
        {"x,y,z,nx,ny,nz\nnan,2,3,0,0,1\n", "line 2: column 'x': 'nan'"},
        {"x,y,z,nx,ny,nz\n1,2,inf,0,0,1\n", "line 2: column 'z': 'inf'"},
        {"x,y,z,nx,ny,nz\n1,2,3,0,0,0\n", "line 2: columns 'nx', 'ny', 'nz': the normal is zero"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t count = 1;
        double *p, *n;
        assert_int_equal(read_text(f, cases[i][0], &count, &p, &n), HPR_ERR_FORMAT);
        assert_message_has(f, "p.csv: ");
        assert_message_has(f, cases[i][1]);
        assert_true(count == 0 && !p && !n);
    }
    size_t count;
    double *p, *n;
    spill(in_folder(f, "p.csv"), "x,y,z,nx,ny,nz\n1,2\0,3,0,0,1\n", 29);
    assert_int_equal(hpr_points_read(f->context, in_folder(f, "p.csv"), &count, &p, &n), HPR_ERR_FORMAT);
    assert_message_has(f, "line 2: a zero byte");
    assert_int_equal(hpr_points_read(f->context, in_folder(f, "none.csv"), &count, &p, &n), HPR_ERR_IO);
    assert_message_has(f, "none.csv': No such file");
    assert_int_equal(hpr_points_read(f->context, f->folder, &count, &p, &n), HPR_ERR_IO);
    assert_message_has(f, "Is a directory");
}

static void no_rows_are_no_points(void **state)
{
    fixture *f = *state;
    size_t count = 1;
    double *p, *n;
    assert_int_equal(read_text(f, "x,y,z,nx,ny,nz\n", &count, &p, &n), HPR_OK);
    assert_int_equal(count, 0);
    hpr_release(f->context, p);
    hpr_release(f->context, n);
}

static void dash_is_standard_input_and_output(void **state)
{
    fixture *f = *state;
    spill(in_folder(f, "in.csv"), "x,y,z,nx,ny,nz\n1,2,3,0,0,1\n", 27);
    int in = dup(STDIN_FILENO), out = dup(STDOUT_FILENO), file;
    assert_true((file = open(in_folder(f, "in.csv"), O_RDONLY)) >= 0);
    dup2(file, STDIN_FILENO);
    close(file);
    size_t count;
    double *p, *n;
    hpr_status read_status = hpr_points_read(f->context, "-", &count, &p, &n);
    dup2(in, STDIN_FILENO);
    close(in);
    assert_int_equal(read_status, HPR_OK);
    assert_int_equal(count, 1);
    uint32_t patch = 7;
    const char *name = "Y";
    hpr_probe_table table = {1, 1, &name, p, n, p, n, &patch};
    fflush(stdout);
    assert_true((file = open(in_folder(f, "out.csv"), O_WRONLY | O_CREAT, 0600)) >= 0);
    dup2(file, STDOUT_FILENO);
    close(file);
    hpr_status status = hpr_probe_write(f->context, &table, "-");
    hpr_status second = hpr_probe_write(f->context, &table, NULL);
    dup2(out, STDOUT_FILENO);
    close(out);
    assert_int_equal(status, HPR_OK);
    assert_int_equal(second, HPR_OK);
    size_t bytes;
    char *text = (char *)slurp(in_folder(f, "out.csv"), &bytes);
#define TABLE "x,y,z,nx,ny,nz,irradiance_y,radiosity_y,patch,status\n1,2,3,0,0,1,1,0,7,ok\n"
    assert_string_equal(text, TABLE TABLE);
    free(text);
    hpr_release(f->context, p);
    hpr_release(f->context, n);
}

static void probe_table_is_tidy(void **state)
{
    fixture *f = *state;
    static const char *const names[] = {"R", "G", "B"};
    const double point[] = {0.1, 1.0 / 3, -0.0, 1e300, 2, 3}, normal[] = {0, 0, 1, 1, 0, 0};
    const double irradiance[] = {1, 2, 0.1, NAN, NAN, NAN}, radiosity[] = {3, 4, 5, NAN, NAN, NAN};
    const uint32_t patch[] = {12, HPR_NONE};
    hpr_probe_table table = {2, 3, names, point, normal, irradiance, radiosity, patch};
    assert_int_equal(hpr_probe_write(f->context, &table, in_folder(f, "o.csv")), HPR_OK);
    size_t bytes;
    char *text = (char *)slurp(in_folder(f, "o.csv"), &bytes);
    assert_string_equal(text, "x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,"
                              "radiosity_r,radiosity_g,radiosity_b,patch,status\n"
                              "0.10000000000000001,0.33333333333333331,-0,0,0,1,1,2,0.10000000000000001,"
                              "3,4,5,12,ok\n"
                              "1.0000000000000001e+300,2,3,1,0,0,nan,nan,nan,nan,nan,nan,-1,nomatch\n");
    free(text);
    /* what was written can be read: its extra columns are skipped, every bit is there */
    size_t count;
    double *p, *n;
    assert_int_equal(hpr_points_read(f->context, in_folder(f, "o.csv"), &count, &p, &n), HPR_OK);
    assert_int_equal(count, 2);
    assert_memory_equal(p, point, sizeof point);
    hpr_release(f->context, p);
    hpr_release(f->context, n);
}

static void odd_channel_names_are_quoted(void **state)
{
    fixture *f = *state;
    static const char *const names[] = {"400,5 \"NM\""};
    hpr_probe_table table = {.channel_count = 1, .channel_name = names};
    assert_int_equal(hpr_probe_write(f->context, &table, in_folder(f, "o.csv")), HPR_OK);
    size_t bytes;
    char *text = (char *)slurp(in_folder(f, "o.csv"), &bytes);
    assert_string_equal(text, "x,y,z,nx,ny,nz,\"irradiance_400,5 \"\"nm\"\"\",\"radiosity_400,5 \"\"nm\"\"\","
                              "patch,status\n");
    free(text);
}

static void failures_leave_nothing(void **state)
{
    fixture *f = *state;
    enum { COUNT = 5000 };
    double *zeros = calloc(3 * COUNT, sizeof *zeros);
    uint32_t *patch = calloc(COUNT, sizeof *patch);
    const char *name = "Y";
    hpr_probe_table table = {COUNT, 1, &name, zeros, zeros, zeros, zeros, patch};
    assert_int_equal(hpr_probe_write(f->context, &table, "/dev/full"), HPR_ERR_IO);
    assert_message_has(f, "No space left");
    assert_int_equal(hpr_probe_write(f->context, &table, in_folder(f, "no/o.csv")), HPR_ERR_IO);
    f->cancel = 1;
    assert_int_equal(hpr_probe_write(f->context, &table, in_folder(f, "o.csv")), HPR_ERR_INTERRUPTED);
    size_t count;
    double *p, *n;
    spill(in_folder(f, "p.csv"), "x,y,z,nx,ny,nz\n", 15);
    assert_int_equal(hpr_points_read(f->context, in_folder(f, "p.csv"), &count, &p, &n), HPR_ERR_INTERRUPTED);
    remove(in_folder(f, "p.csv"));
    f->cancel = 0;
    assert_int_equal(count_files(f->folder, false), 0);
    if (mount_small(f)) {
        assert_int_equal(hpr_probe_write(f->context, &table, in_folder(f, "o.csv")), HPR_ERR_IO);
        assert_message_has(f, "No space left");
        assert_int_equal(count_files(f->folder, false), 0);
    }
    free(zeros);
    free(patch);
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    hpr_status status = HPR_ERR_MEMORY;
    char text[2000] = "x,y,z,nx,ny,nz\n"; /* enough rows to grow more than once */
    for (int i = 0; i < 40; i++)
        strcat(text, "1,2,3,0,0,1\n");
    for (long k = 0; status != HPR_OK; k++) {
        long live = f->live;
        size_t count;
        double *p, *n;
        f->allocations_left = k;
        status = read_text(f, text, &count, &p, &n);
        f->allocations_left = -1;
        assert_true(status == HPR_OK || (status == HPR_ERR_MEMORY && !p && !n));
        hpr_release(f->context, p);
        hpr_release(f->context, n);
        assert_int_equal(f->live, live);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(columns_come_in_any_order), IO_TEST(faults_are_named_with_line_and_column),
        IO_TEST(no_rows_are_no_points),     IO_TEST(dash_is_standard_input_and_output),
        IO_TEST(probe_table_is_tidy),       IO_TEST(odd_channel_names_are_quoted),
        IO_TEST(failures_leave_nothing),    IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
