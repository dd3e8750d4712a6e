/*
 * Pictures as OpenEXR. OpenEXRCore writes into memory through a stream of ours, and the bytes then go through
 * an atomic file: so its errors and the disk's surface in one place, and pipes work. Nothing in the file
 * depends on when or by how many threads it was made.
 */
#include "io/atomic_file.h"

#include <hprad/render.h>
#include <hprad/version.h>
#include <OpenEXR/openexr.h>
#include <string.h>

typedef struct sink {
    hpr_context *context;
    const char *path;
    unsigned char *data;
    size_t bytes, capacity;
    hpr_status status; /* of the sink itself, which OpenEXR would take for a fault of the disk */
} sink;

/* Lengths of names are OpenEXR's. The level is the one that OpenEXR itself moved to: 9 is slower, hardly
 * smaller. */
enum { SHORT_NAME = 31, LONG_NAME = 255, ZIP_LEVEL = 4 };

static const char variance_layer[] = "variance.";

static hpr_status status_of(exr_result_t result)
{
    switch (result) {
    case EXR_ERR_SUCCESS:
        return HPR_OK;
    case EXR_ERR_OUT_OF_MEMORY:
        return HPR_ERR_MEMORY;
    case EXR_ERR_INVALID_ARGUMENT:
    case EXR_ERR_ARGUMENT_OUT_OF_RANGE:
    case EXR_ERR_NAME_TOO_LONG:
    case EXR_ERR_INVALID_ATTR:
        return HPR_ERR_ARG;
    default:
        return HPR_ERR_IO;
    }
}

/* The first text that OpenEXR gives is the one that says most; hpr_fail keeps it. */
static void take_message(exr_const_context_t exr, exr_result_t code, const char *text)
{
    void *user = NULL;
    if (exr && exr_get_user_data(exr, &user) == EXR_ERR_SUCCESS && user) {
        sink *out = user;
        hpr_fail(out->context, status_of(code), "cannot write '%s': OpenEXR: %s", out->path, text);
    }
}

static hpr_status check(const sink *out, exr_result_t result)
{
    if (result == EXR_ERR_SUCCESS)
        return HPR_OK;
    return hpr_fail(out->context, status_of(result), "cannot write '%s': OpenEXR: %s", out->path,
                    exr_get_default_error_message(result));
}

static int64_t take_bytes(exr_const_context_t exr, void *user, const void *buffer, uint64_t bytes,
                          uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    (void)exr;
    (void)fail;
    sink *out = user;
    if (out->status == HPR_OK)
        out->status = hpr_grow(out->context, &out->data, &out->capacity, (size_t)(offset + bytes), 1);
    if (out->status != HPR_OK)
        return -1;
    memcpy(out->data + offset, buffer, (size_t)bytes);
    if (offset + bytes > out->bytes)
        out->bytes = (size_t)(offset + bytes);
    return (int64_t)bytes;
}

static const char *channel_name(const hpr_image *image, const hpr_image_labels *labels, size_t channel)
{
    static const char *const rgb[] = {"R", "G", "B"};
    if (labels && labels->channel_name)
        return labels->channel_name[channel];
    return image->channel_count == 3 ? rgb[channel] : "Y";
}

/* Name of its variance; empty if the picture has none. */
static void variance_name(const hpr_image *image, const hpr_image_labels *labels, size_t channel,
                          char name[LONG_NAME + 1])
{
    name[0] = '\0';
    if (image->variance)
        snprintf(name, LONG_NAME + 1, "%s%s", variance_layer, channel_name(image, labels, channel));
}

static bool is_rgb(const hpr_image *image, const hpr_image_labels *labels)
{
    return image->channel_count == 3 && !strcmp(channel_name(image, labels, 0), "R") &&
           !strcmp(channel_name(image, labels, 1), "G") && !strcmp(channel_name(image, labels, 2), "B");
}

static hpr_status check_image(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels)
{
    size_t n = image->channel_count;
    if (image->width < 1 || image->height < 1 || n < 1 || !image->radiance || !image->coverage)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %d x %d pixels and %zu channels cannot be written",
                        image->width, image->height, n);
    bool named = labels && labels->channel_name;
    if (!named && n != 1 && n != 3)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %zu channels needs their names", n);
    if ((uint64_t)image->width * n * sizeof(float) > INT32_MAX)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %d pixels in %zu channels is too wide", image->width,
                        n);
    for (size_t c = 0; c < n; c++) {
        const char *name = channel_name(image, labels, c);
        if (!name || !name[0] || !strcmp(name, "A"))
            return hpr_fail(ctx, HPR_ERR_ARG, "channel %zu of a picture has the name '%s'", c,
                            name ? name : "");
        size_t layer = strlen(variance_layer);
        if (image->variance && (strlen(name) + layer > LONG_NAME || !strncmp(name, variance_layer, layer)))
            return hpr_fail(ctx, HPR_ERR_ARG, "channel '%s' leaves no name for its variance", name);
        for (size_t d = 0; d < c; d++) {
            if (!strcmp(name, channel_name(image, labels, d)))
                return hpr_fail(ctx, HPR_ERR_ARG, "two channels of a picture have the name '%s'", name);
        }
    }
    return HPR_OK;
}

static exr_result_t set_text(exr_context_t exr, const char *name, const char *text)
{
    return text && text[0] ? exr_attr_set_string(exr, 0, name, text) : EXR_ERR_SUCCESS;
}

static exr_result_t describe(exr_context_t exr, const hpr_image *image, const hpr_image_labels *labels)
{
    static const exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.30f,   0.60f,
                                                     0.15f, 0.06f, 0.3127f, 0.3290f};
    int part;
    bool long_names = false;
    char variance[LONG_NAME + 1];
    for (size_t c = 0; c < image->channel_count; c++) {
        variance_name(image, labels, c, variance);
        long_names = long_names || strlen(channel_name(image, labels, c)) > SHORT_NAME ||
                     strlen(variance) > SHORT_NAME;
    }
    exr_result_t result = exr_set_longname_support(exr, long_names);
    if (result == EXR_ERR_SUCCESS)
        result = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result =
            exr_initialize_required_attr_simple(exr, 0, image->width, image->height, EXR_COMPRESSION_ZIP);
    for (size_t c = 0; result == EXR_ERR_SUCCESS && c < image->channel_count; c++) {
        variance_name(image, labels, c, variance);
        result = exr_add_channel(exr, 0, channel_name(image, labels, c), EXR_PIXEL_FLOAT,
                                 EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
        if (result == EXR_ERR_SUCCESS && image->variance)
            result = exr_add_channel(exr, 0, variance, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    if (result == EXR_ERR_SUCCESS)
        result = exr_add_channel(exr, 0, "A", EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (result == EXR_ERR_SUCCESS && is_rgb(image, labels)) {
        result = exr_attr_set_chromaticities(exr, 0, "chromaticities", &rec709);
        if (result == EXR_ERR_SUCCESS)
            result = set_text(exr, "colorInteropID", "lin_rec709_scene");
    }
    char software[64];
    snprintf(software, sizeof software, "hprad %s", hpr_version());
    if (result == EXR_ERR_SUCCESS)
        result = set_text(exr, "software", software);
    if (result == EXR_ERR_SUCCESS && labels)
        result = set_text(exr, "scene", labels->scene);
    if (result == EXR_ERR_SUCCESS && labels)
        result = set_text(exr, "camera", labels->camera);
    return result;
}

/*
 * ZIP by OpenEXR, except that a chunk which compression does not make smaller is stored as it is: a reader
 * takes a chunk of full length for a plain one, and OpenEXR (through 3.4) forgets the case of equal length.
 */
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipe)
{
    exr_result_t (*const *compress)(exr_encode_pipeline_t *) = pipe->encoding_user_data;
    exr_result_t result = (*compress)(pipe);
    if (result == EXR_ERR_SUCCESS && pipe->compressed_bytes >= pipe->packed_bytes) {
        memcpy(pipe->compressed_buffer, pipe->packed_buffer, pipe->packed_bytes);
        pipe->compressed_bytes = pipe->packed_bytes;
    }
    return result;
}

/* Points every channel of the chunk that begins at line y to its pixels. */
static void aim(exr_encode_pipeline_t *pipe, const hpr_image *image, const hpr_image_labels *labels, int y)
{
    size_t n = image->channel_count, row = (size_t)y * (size_t)image->width;
    char variance[LONG_NAME + 1];
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *channel = pipe->channels + i;
        const float *from = image->coverage + row;
        size_t stride = sizeof(float);
        for (size_t c = 0; c < n; c++) {
            const float *values = NULL;
            variance_name(image, labels, c, variance);
            if (!strcmp(channel->channel_name, channel_name(image, labels, c)))
                values = image->radiance;
            else if (!strcmp(channel->channel_name, variance))
                values = image->variance;
            if (values) {
                from = values + row * n + c;
                stride = n * sizeof(float);
            }
        }
        channel->encode_from_ptr = (const uint8_t *)from;
        channel->user_pixel_stride = (int32_t)stride;
        channel->user_line_stride = (int32_t)(stride * (size_t)image->width);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
}

static exr_result_t write_pixels(exr_context_t exr, const hpr_image *image, const hpr_image_labels *labels)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t (*compress)(exr_encode_pipeline_t *) = NULL;
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &lines);
    for (int y = 0; result == EXR_ERR_SUCCESS && y < image->height; y += lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(exr, 0, y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = y == 0 ? exr_encoding_initialize(exr, 0, &chunk, &pipe)
                            : exr_encoding_update(exr, 0, &chunk, &pipe);
        if (result != EXR_ERR_SUCCESS)
            break;
        aim(&pipe, image, labels, y);
        if (y == 0) {
            result = exr_encoding_choose_default_routines(exr, 0, &pipe);
            compress = pipe.compress_fn;
            pipe.encoding_user_data = &compress;
            if (compress)
                pipe.compress_fn = compress_chunk;
        }
        if (result == EXR_ERR_SUCCESS)
            result = exr_encoding_run(exr, 0, &pipe);
    }
    exr_encoding_destroy(exr, &pipe);
    return result;
}

static hpr_status encode(sink *out, const hpr_image *image, const hpr_image_labels *labels)
{
    exr_context_t exr = NULL;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = take_message;
    init.user_data = out;
    init.write_fn = take_bytes;
    init.zip_level = ZIP_LEVEL;
    exr_result_t result = exr_start_write(&exr, out->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (result == EXR_ERR_SUCCESS)
        result = describe(exr, image, labels);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(exr);
    if (result == EXR_ERR_SUCCESS)
        result = write_pixels(exr, image, labels);
    hpr_status status = check(out, result);
    if (exr) {
        result = exr_finish(&exr);
        if (status == HPR_OK)
            status = check(out, result);
    }
    return out->status != HPR_OK ? out->status : status;
}

hpr_status hpr_image_write_exr(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels,
                               const char *path)
{
    hpr_context_clear_error(ctx);
    hpr_status status = check_image(ctx, image, labels);
    if (status != HPR_OK)
        return status;
    hpr_atomic_file file;
    sink out = {.context = ctx, .path = path};
    status = hpr_atomic_open(ctx, path, &file); /* first: a bad path is the commonest mistake */
    if (status == HPR_OK)
        status = encode(&out, image, labels);
    if (status == HPR_OK)
        status = hpr_atomic_write(&file, out.data, out.bytes);
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    hpr_release(ctx, out.data);
    return status;
}
