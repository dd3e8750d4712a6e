#include <hprad/render.h>

#include "io_support.h"

#include <OpenEXR/openexr.h>

enum { MOST_CHANNELS = 9 };

typedef struct picture {
    hpr_image image;
    float *read[MOST_CHANNELS]; /* by sorted channel name */
    char name[MOST_CHANNELS][64];
    int read_channels;
    char software[64], scene[64], camera[64], interop[64];
    exr_attr_chromaticities_t chroma;
    bool has_chroma;
} picture;

/* noise: incompressible; else smooth */
static void fill(picture *p, int width, int height, size_t channels, bool noise)
{
    size_t pixels = (size_t)width * (size_t)height;
    *p = (picture){.image = {.width = width, .height = height, .channel_count = channels}};
    p->image.radiance = calloc(pixels * channels, sizeof(float));
    p->image.coverage = calloc(pixels, sizeof(float));
    uint64_t seed = 88172645463325252u;
    for (size_t i = 0; i < pixels * channels; i++) {
        uint32_t bits = (uint32_t)(random_bits(&seed) >> 32) & 0xbfffffffu; /* finite */
        float value = (float)i / 7;
        if (noise)
            memcpy(&value, &bits, 4);
        p->image.radiance[i] = value;
    }
    for (size_t i = 0; i < pixels; i++)
        p->image.coverage[i] = (float)random_unit(&seed);
}

static void empty(picture *p)
{
    free(p->image.radiance);
    free(p->image.coverage);
    free(p->image.variance);
    for (int c = 0; c < p->read_channels; c++)
        free(p->read[c]);
}

static void read_text(exr_context_t exr, const char *name, char text[64])
{
    const char *value = NULL;
    int32_t length = 0;
    text[0] = '\0';
    if (exr_attr_get_string(exr, 0, name, &length, &value) == EXR_ERR_SUCCESS)
        snprintf(text, 64, "%.*s", (int)length, value);
}

static void silent(exr_const_context_t exr, exr_result_t code, const char *text)
{
    (void)exr;
    (void)code;
    (void)text;
}

static void read_chunk(exr_context_t exr, picture *p, int y)
{
    exr_chunk_info_t chunk;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_read_scanline_chunk_info(exr, 0, y, &chunk), EXR_ERR_SUCCESS);
    assert_int_equal(exr_decoding_initialize(exr, 0, &chunk, &pipe), EXR_ERR_SUCCESS);
    for (int c = 0; c < pipe.channel_count; c++) {
        assert_int_equal(pipe.channels[c].data_type, EXR_PIXEL_FLOAT);
        pipe.channels[c].decode_to_ptr = (uint8_t *)(p->read[c] + (size_t)y * (size_t)p->image.width);
        pipe.channels[c].user_pixel_stride = 4;
        pipe.channels[c].user_line_stride = 4 * p->image.width;
        pipe.channels[c].user_bytes_per_element = 4;
        pipe.channels[c].user_data_type = EXR_PIXEL_FLOAT;
    }
    assert_int_equal(exr_decoding_choose_default_routines(exr, 0, &pipe), EXR_ERR_SUCCESS);
    assert_int_equal(exr_decoding_run(exr, 0, &pipe), EXR_ERR_SUCCESS);
    assert_int_equal(exr_decoding_destroy(exr, &pipe), EXR_ERR_SUCCESS);
}

static void read_back(picture *p, const char *path)
{
    exr_context_t exr = NULL;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = silent; /* absent attributes are asked for */
    assert_int_equal(exr_start_read(&exr, path, &init), EXR_ERR_SUCCESS);
    exr_attr_box2i_t window;
    exr_compression_t compression;
    exr_storage_t storage;
    const exr_attr_chlist_t *channels;
    int32_t lines;
    assert_int_equal(exr_get_data_window(exr, 0, &window), EXR_ERR_SUCCESS);
    assert_int_equal(window.min.x, 0);
    assert_int_equal(window.min.y, 0);
    assert_int_equal(window.max.x, p->image.width - 1);
    assert_int_equal(window.max.y, p->image.height - 1);
    exr_get_compression(exr, 0, &compression);
    exr_get_storage(exr, 0, &storage);
    assert_int_equal(compression, EXR_COMPRESSION_ZIP);
    assert_int_equal(storage, EXR_STORAGE_SCANLINE);
    assert_int_equal(exr_get_channels(exr, 0, &channels), EXR_ERR_SUCCESS);
    p->read_channels = channels->num_channels;
    assert_true(p->read_channels <= MOST_CHANNELS);
    for (int c = 0; c < p->read_channels; c++) {
        snprintf(p->name[c], sizeof p->name[c], "%s", channels->entries[c].name.str);
        p->read[c] = calloc((size_t)p->image.width * (size_t)p->image.height, 4);
    }
    read_text(exr, "software", p->software);
    read_text(exr, "scene", p->scene);
    read_text(exr, "camera", p->camera);
    read_text(exr, "colorInteropID", p->interop);
    p->has_chroma = exr_attr_get_chromaticities(exr, 0, "chromaticities", &p->chroma) == EXR_ERR_SUCCESS;
    exr_get_scanlines_per_chunk(exr, 0, &lines);
    for (int y = 0; y < p->image.height; y += lines)
        read_chunk(exr, p, y);
    assert_int_equal(exr_finish(&exr), EXR_ERR_SUCCESS);
}

static void assert_same_pixels(const picture *p, const char *const *name)
{
    size_t pixels = (size_t)p->image.width * (size_t)p->image.height, n = p->image.channel_count;
    assert_int_equal(p->read_channels, n + 1);
    for (int i = 0; i < p->read_channels; i++) {
        size_t c = 0;
        while (c < n && strcmp(name[c], p->name[i]))
            c++;
        assert_true(c < n || !strcmp(p->name[i], "A"));
        for (size_t k = 0; k < pixels; k++) {
            const float *expected = c < n ? p->image.radiance + k * n + c : p->image.coverage + k;
            if (memcmp(expected, p->read[i] + k, 4))
                fail_msg("%dx%d channel %s pixel %zu: %g, not %g", p->image.width, p->image.height,
                         p->name[i], k, (double)p->read[i][k], (double)*expected);
        }
    }
}

static const char *const rgb[] = {"R", "G", "B"};

static void every_size_reads_back_bit_for_bit(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.exr");
    static const int sizes[] = {1, 2, 15, 16, 17, 32, 33, 100};
    for (size_t w = 0; w < 8; w++) {
        for (size_t h = 0; h < 8; h++) {
            for (int noise = 0; noise < 2; noise++) {
                picture p;
                fill(&p, sizes[w], sizes[h], 3, noise);
                assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, path), HPR_OK);
                read_back(&p, path);
                assert_same_pixels(&p, rgb);
                empty(&p);
            }
        }
    }
}

/* Rows of n equal bytes and the rest noise, so that for some n ZIP saves exactly nothing. */
static void chunks_of_equal_length_survive(void **state)
{
    fixture *f = *state;
    const char *path = in_folder(f, "a.exr");
    for (int width = 8; width < 20; width++) {
        for (size_t zeros = 0; zeros < 40; zeros++) {
            picture p;
            fill(&p, width, 1, 3, true);
            memset(p.image.radiance, 0, zeros < 3 * (size_t)width ? 2 * zeros : 0);
            assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, path), HPR_OK);
            read_back(&p, path);
            assert_same_pixels(&p, rgb);
            empty(&p);
        }
    }
}

static void labels_are_written(void **state)
{
    fixture *f = *state;
    picture p;
    fill(&p, 4, 3, 3, false);
    hpr_image_labels labels = {.channel_name = rgb, .scene = "box.gltf", .camera = "front"};
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_OK);
    read_back(&p, in_folder(f, "a.exr"));
    assert_memory_equal(p.software, "hprad ", 6);
    assert_string_equal(p.scene, "box.gltf");
    assert_string_equal(p.camera, "front");
    assert_string_equal(p.interop, "lin_rec709_scene");
    assert_true(p.has_chroma);
    assert_true(p.chroma.red_x == 0.64f && p.chroma.green_y == 0.6f && p.chroma.blue_y == 0.06f &&
                p.chroma.white_x == 0.3127f && p.chroma.white_y == 0.329f);
    empty(&p);
}

static void other_channels_claim_no_colour_space(void **state)
{
    fixture *f = *state;
    static const char *const names[] = {"w700nm", "w550nm",
                                        "a_channel_with_a_name_of_more_than_31_characters", "w450nm"};
    picture p;
    fill(&p, 21, 18, 4, true);
    hpr_image_labels labels = {.channel_name = names};
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_OK);
    read_back(&p, in_folder(f, "a.exr"));
    assert_same_pixels(&p, names);
    assert_string_equal(p.interop, "");
    assert_false(p.has_chroma);
    empty(&p);
}

/* Gives the picture variances, which are its radiances backwards. */
static void add_variances(picture *p)
{
    size_t values = (size_t)p->image.width * (size_t)p->image.height * p->image.channel_count;
    p->image.variance = calloc(values, sizeof(float));
    for (size_t i = 0; i < values; i++)
        p->image.variance[i] = p->image.radiance[values - 1 - i];
}

static void variances_are_a_layer(void **state)
{
    fixture *f = *state;
    static const char *const long_names[] = {"a_channel_with_29_characters_"};
    for (size_t channels = 1; channels <= 3; channels += 2) {
        picture p;
        const hpr_image_labels labels = {.channel_name = channels == 1 ? long_names : rgb};
        fill(&p, 21, 18, channels, true);
        add_variances(&p);
        assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_OK);
        read_back(&p, in_folder(f, "a.exr"));
        assert_int_equal(p.read_channels, 2 * channels + 1);
        for (size_t c = 0; c < channels; c++) {
            char name[64];
            int at = 0;
            snprintf(name, sizeof name, "variance.%s", labels.channel_name[c]);
            while (at < p.read_channels && strcmp(p.name[at], name))
                at++;
            assert_true(at < p.read_channels);
            for (size_t k = 0; k < 21 * 18; k++)
                assert_memory_equal(p.image.variance + k * channels + c, p.read[at] + k, 4);
        }
        empty(&p);
    }
}

static void channels_that_leave_no_name_are_refused(void **state)
{
    fixture *f = *state;
    char longest[248];
    memset(longest, 'x', 247);
    longest[247] = '\0';
    const char *const taken[] = {"R", "variance.R"}, *const too_long[] = {longest};
    for (int i = 0; i < 2; i++) {
        picture p;
        const hpr_image_labels labels = {.channel_name = i ? too_long : taken};
        fill(&p, 4, 4, i ? 1 : 2, false);
        add_variances(&p);
        assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")),
                         HPR_ERR_ARG);
        longest[246] = '\0'; /* with "variance." 255 characters, the most that OpenEXR takes */
        if (i == 1)
            assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")),
                             HPR_OK);
        longest[246] = 'x';
        empty(&p);
    }
}

/* Layers, numbers and a window of a larger picture, in scanlines and tiles, whole and half: read by our own
 * reader, which the tests of the command compare with one in Python. */
static void layers_and_windows_read_back(void **state)
{
    fixture *f = *state;
    enum { WIDTH = 150, HEIGHT = 70 };
    static uint32_t number[WIDTH * HEIGHT];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        number[i] = UINT32_MAX - i;
    for (int i = 0; i < 4; i++) {
        picture p;
        hpr_image back;
        fill(&p, WIDTH, HEIGHT, 3, false);
        p.image.left = 7;
        p.image.top = 11;
        p.image.full_width = 200;
        p.image.full_height = 100;
        p.image.layer[HPR_LAYER_IRRADIANCE] = p.image.layer[HPR_LAYER_POSITION] = p.image.radiance;
        p.image.layer[HPR_LAYER_DEPTH] = p.image.coverage;
        p.image.element = number;
        const hpr_image_labels labels = {.channel_name = rgb, .half = i & 1, .tiled = i >> 1};
        const char *const *names[] = {rgb,
                                      (const char *const[]){"irradiance.R", "irradiance.G", "irradiance.B"},
                                      (const char *const[]){"P.X", "P.Y", "P.Z"}};
        assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_OK);
        for (int layer = 0; layer < 3; layer++) {
            assert_int_equal(hpr_image_read_exr(f->context, in_folder(f, "a.exr"), 3, names[layer], &back),
                             HPR_OK);
            assert_true(back.width == WIDTH && back.height == HEIGHT && back.left == 7 && back.top == 11 &&
                        back.full_width == 200 && back.full_height == 100);
            double allowed = labels.half && layer < 2 ? 0x1p-11 : 0; /* half has 11 bits */
            for (size_t k = 0; k < 3 * WIDTH * HEIGHT; k++)
                assert_true(fabs((double)(back.radiance[k] - p.image.radiance[k])) <=
                            allowed * (double)p.image.radiance[k]);
            hpr_image_fini(f->context, &back);
        }
        const char *const element[] = {"elementId"};
        assert_int_equal(hpr_image_read_exr(f->context, in_folder(f, "a.exr"), 1, element, &back), HPR_OK);
        for (size_t k = 0; k < WIDTH * HEIGHT; k++)
            assert_true(back.radiance[k] == (float)number[k]);
        hpr_image_fini(f->context, &back);
        empty(&p);
    }
}

static void files_that_cannot_be_read_are_refused(void **state)
{
    fixture *f = *state;
    picture p;
    hpr_image back;
    fill(&p, 40, 30, 3, true);
    const char *path = in_folder(f, "a.exr");
    static const char *const other[] = {"R", "G", "Y"};
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, path), HPR_OK);
    assert_int_equal(hpr_image_read_exr(f->context, path, 3, other, &back), HPR_ERR_FORMAT);
    hpr_image_fini(f->context, &back);
    assert_int_equal(hpr_image_read_exr(f->context, in_folder(f, "no.exr"), 3, rgb, &back), HPR_ERR_IO);
    size_t bytes;
    unsigned char *whole = slurp(path, &bytes);
    for (size_t cut = 0; cut < bytes; cut += bytes / 40) {
        spill(path, whole, cut);
        assert_int_equal(hpr_image_read_exr(f->context, path, 3, rgb, &back), HPR_ERR_FORMAT);
        assert_non_null(strstr(hpr_context_error(f->context), "a.exr"));
        hpr_image_fini(f->context, &back);
    }
    free(whole);
    empty(&p);
}

static void same_picture_same_bytes(void **state)
{
    fixture *f = *state;
    picture p;
    fill(&p, 40, 40, 3, true);
    size_t a_bytes, b_bytes;
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "a.exr")), HPR_OK);
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "b.exr")), HPR_OK);
    unsigned char *a = slurp(in_folder(f, "a.exr"), &a_bytes), *b = slurp(in_folder(f, "b.exr"), &b_bytes);
    assert_int_equal(a_bytes, b_bytes);
    assert_memory_equal(a, b, a_bytes);
    free(a);
    free(b);
    empty(&p);
}

static void bad_pictures_are_refused(void **state)
{
    fixture *f = *state;
    static const char *const twice[] = {"R", "R", "B"}, *const alpha[] = {"R", "A", "B"};
    picture p;
    fill(&p, 4, 4, 3, false);
    hpr_image_labels labels = {.channel_name = twice};
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_ERR_ARG);
    labels.channel_name = alpha;
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, &labels, in_folder(f, "a.exr")), HPR_ERR_ARG);
    p.image.width = 0;
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "a.exr")), HPR_ERR_ARG);
    assert_int_equal(count_files(f->folder, false), 0);
    empty(&p);
}

static void failures_leave_nothing(void **state)
{
    fixture *f = *state;
    picture p;
    fill(&p, 200, 200, 3, true);
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "no/a.exr")), HPR_ERR_IO);
    assert_message_has(f, "No such file");
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, "/dev/full"), HPR_ERR_IO);
    assert_message_has(f, "No space left");
    f->cancel = 1;
    assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "a.exr")),
                     HPR_ERR_INTERRUPTED);
    f->cancel = 0;
    assert_int_equal(count_files(f->folder, false), 0);
    if (mount_small(f)) {
        assert_int_equal(hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "a.exr")), HPR_ERR_IO);
        assert_message_has(f, "a.exr");
        assert_message_has(f, "No space left");
        assert_int_equal(count_files(f->folder, false), 0);
    }
    empty(&p);
}

static void every_allocation_may_fail(void **state)
{
    fixture *f = *state;
    picture p;
    fill(&p, 40, 40, 3, true);
    hpr_status status = HPR_ERR_MEMORY;
    for (long k = 0; status != HPR_OK; k++) {
        long live = f->live;
        f->allocations_left = k;
        status = hpr_image_write_exr(f->context, &p.image, NULL, in_folder(f, "a.exr"));
        f->allocations_left = -1;
        assert_int_equal(f->live, live);
        assert_true(status == HPR_OK || status == HPR_ERR_MEMORY);
        assert_int_equal(count_files(f->folder, false), status == HPR_OK);
    }
    empty(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IO_TEST(every_size_reads_back_bit_for_bit),
        IO_TEST(chunks_of_equal_length_survive),
        IO_TEST(labels_are_written),
        IO_TEST(other_channels_claim_no_colour_space),
        IO_TEST(variances_are_a_layer),
        IO_TEST(channels_that_leave_no_name_are_refused),
        IO_TEST(layers_and_windows_read_back),
        IO_TEST(files_that_cannot_be_read_are_refused),
        IO_TEST(same_picture_same_bytes),
        IO_TEST(bad_pictures_are_refused),
        IO_TEST(failures_leave_nothing),
        IO_TEST(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
