#include <hprad/render.h>

#include "io_support.h"

#include <png.h>

typedef struct preview {
    png_image png;
    png_byte *bytes; /* as the file has them */
} preview;

static preview read_back(const char *path)
{
    preview p = {.png = {.version = PNG_IMAGE_VERSION}};
    if (!png_image_begin_read_from_file(&p.png, path))
        fail_msg("%s: %s", path, p.png.message);
    p.bytes = calloc(PNG_IMAGE_SIZE(p.png), 1);
    if (!png_image_finish_read(&p.png, NULL, p.bytes, 0, NULL))
        fail_msg("%s: %s", path, p.png.message);
    return p;
}

static void transfer_function_is_srgb(void **state)
{
    fixture *f = *state;
    enum { N = 1001 };
    static float radiance[3 * N], coverage[N];
    for (int i = 0; i < N; i++) {
        coverage[i] = 1;
        for (int c = 0; c < 3; c++)
            radiance[3 * i + c] = (float)(i % (c + 1) ? 0 : (double)i / 500); /* up to 2: clamped */
    }
    hpr_image image = {.width = N,
                       .height = 1,
                       .channel_count = 3,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    double used = 0;
    assert_int_equal(hpr_image_write_png(f->context, &image, 2, in_folder(f, "a.png"), &used), HPR_OK);
    assert_true(used == 2);
    preview p = read_back(in_folder(f, "a.png"));
    assert_int_equal(p.png.format, PNG_FORMAT_RGB);
    assert_int_equal(p.png.width, N);
    for (int i = 0; i < 3 * N; i++) {
        /* the inverse function, so that the formula under test is not repeated */
        double low = (p.bytes[i] - 0.5) / 255, high = (p.bytes[i] + 0.5) / 255;
        double linear_low = low <= 0.04045 ? low / 12.92 : pow((low + 0.055) / 1.055, 2.4);
        double linear_high = high <= 0.04045 ? high / 12.92 : pow((high + 0.055) / 1.055, 2.4);
        double value = fmin(2 * (double)radiance[i], 1);
        if (value < linear_low - 1e-7 || value > linear_high + 1e-7)
            fail_msg("%g became %d", value, p.bytes[i]);
    }
    free(p.bytes);
}

static void coverage_becomes_straight_alpha(void **state)
{
    fixture *f = *state;
    float radiance[] = {0.25f, 0.5f, 0, /* half covered */ 0, 0, 0, /* not */ 1, 1, 1 /* wholly */};
    float coverage[] = {0.5f, 0, 1};
    hpr_image image = {.width = 3,
                       .height = 1,
                       .channel_count = 3,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL), HPR_OK);
    preview p = read_back(in_folder(f, "a.png"));
    assert_int_equal(p.png.format, PNG_FORMAT_RGBA);
    static const png_byte expected[] = {188, 255, 0,   128, 0,   0,
                                        0,   0,   255, 255, 255, 255}; /* sRGB(1/2) = 188 */
    assert_memory_equal(p.bytes, expected, sizeof expected);
    free(p.bytes);
}

/* Light from outside shows through the holes. */
static void a_sky_leaves_no_holes(void **state)
{
    fixture *f = *state;
    float radiance[] = {0.25f, 0.5f, 0, /* half covered */ 0, 0.5f, 1, /* not */ 1, 1, 1 /* wholly */};
    float coverage[] = {0.5f, 0, 1};
    hpr_image image = {.width = 3,
                       .height = 1,
                       .channel_count = 3,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 1};
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL), HPR_OK);
    preview p = read_back(in_folder(f, "a.png"));
    assert_int_equal(p.png.format, PNG_FORMAT_RGB);
    static const png_byte expected[] = {137, 188, 0, 0, 188, 255, 255, 255, 255}; /* sRGB of 1/4: 137 */
    assert_memory_equal(p.bytes, expected, sizeof expected);
    free(p.bytes);
}

static void one_channel_is_grey(void **state)
{
    fixture *f = *state;
    float radiance[] = {0, 0.5f, 1}, coverage[] = {1, 1, 1};
    hpr_image image = {.width = 1,
                       .height = 3,
                       .channel_count = 1,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL), HPR_OK);
    preview p = read_back(in_folder(f, "a.png"));
    assert_int_equal(p.png.format, PNG_FORMAT_GRAY);
    static const png_byte expected[] = {0, 188, 255};
    assert_memory_equal(p.bytes, expected, 3);
    free(p.bytes);
}

static void exposure_makes_the_log_average_middle_grey(void **state)
{
    fixture *f = *state;
    /* 0.5 and 8 average to 2 in the logarithm; empty, black and unreal pixels do not count */
    float radiance[] = {0.25f, 8, 7, 0, NAN, INFINITY, 1e-9f, -1}, coverage[] = {0.5f, 1, 0, 1, 1, 1, 1, 1};
    hpr_image image = {.width = 8,
                       .height = 1,
                       .channel_count = 1,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    double used = 0;
    assert_int_equal(hpr_image_write_png(f->context, &image, 0, in_folder(f, "a.png"), &used), HPR_OK);
    assert_true(fabs(used - 0.09) < 1e-15);
    preview p = read_back(in_folder(f, "a.png"));
    assert_int_equal(p.bytes[2 * 4], 0); /* NaN is black */
    assert_int_equal(p.bytes[2 * 5], 255);
    assert_int_equal(p.bytes[2 * 7], 0);
    free(p.bytes);
    memset(radiance, 0, sizeof radiance);
    assert_int_equal(hpr_image_write_png(f->context, &image, 0, in_folder(f, "a.png"), &used), HPR_OK);
    assert_true(used == 1);
}

static void failures_leave_nothing(void **state)
{
    fixture *f = *state;
    enum { SIDE = 300 };
    float *radiance = calloc(3 * SIDE * SIDE, sizeof *radiance),
          *coverage = calloc(SIDE * SIDE, sizeof *coverage);
    uint64_t seed = 1234567;
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
        radiance[i] = (float)random_unit(&seed);
        coverage[i / 3] = 1;
    }
    hpr_image image = {.width = SIDE,
                       .height = SIDE,
                       .channel_count = 3,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    assert_int_equal(hpr_image_write_png(f->context, &image, NAN, in_folder(f, "a.png"), NULL), HPR_ERR_ARG);
    assert_int_equal(hpr_image_write_png(f->context, &image, -1, in_folder(f, "a.png"), NULL), HPR_ERR_ARG);
    image.channel_count = 2;
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL), HPR_ERR_ARG);
    image.channel_count = 3;
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, f->folder, NULL), HPR_ERR_IO);
    assert_message_has(f, "Is a directory");
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, "/dev/full", NULL), HPR_ERR_IO);
    assert_message_has(f, "No space left");
    f->cancel = 1;
    assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL),
                     HPR_ERR_INTERRUPTED);
    f->cancel = 0;
    assert_int_equal(count_files(f->folder, false), 0);
    if (mount_small(f)) {
        assert_int_equal(hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL), HPR_ERR_IO);
        assert_message_has(f, "a.png");
        assert_message_has(f, "No space left");
        assert_int_equal(count_files(f->folder, false), 0);
    }
    free(radiance);
    free(coverage);
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    float radiance[] = {1}, coverage[] = {1};
    hpr_image image = {.width = 1,
                       .height = 1,
                       .channel_count = 1,
                       .radiance = radiance,
                       .coverage = coverage,
                       .environment = 0};
    hpr_status status = HPR_ERR_MEMORY;
    for (long k = 0; status != HPR_OK; k++) {
        long live = f->live;
        f->allocations_left = k;
        status = hpr_image_write_png(f->context, &image, 1, in_folder(f, "a.png"), NULL);
        f->allocations_left = -1;
        assert_int_equal(f->live, live);
        assert_true(status == HPR_OK || status == HPR_ERR_MEMORY);
        assert_int_equal(count_files(f->folder, false), status == HPR_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(transfer_function_is_srgb),
        IO_TEST(coverage_becomes_straight_alpha),
        IO_TEST(a_sky_leaves_no_holes),
        IO_TEST(one_channel_is_grey),
        IO_TEST(exposure_makes_the_log_average_middle_grey),
        IO_TEST(failures_leave_nothing),
        IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
