/*
 * Pictures as OpenEXR. OpenEXRCore writes into memory through a stream of ours, and the bytes then go through
 * an atomic file: so its errors and the disk's surface in one place, and pipes work. Nothing in the file
 * depends on when or by how many threads it was made.
 */
#include "io/atomic_file.h"
#include "io/exr_channels.h"

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

/* The level is the one that OpenEXR itself moved to: 9 is slower, hardly smaller. */
enum { ZIP_LEVEL = 4, TILE = 64 };

/* What is written. */
typedef struct picture {
    const hpr_image *image;
    const hpr_image_labels *labels;
    const hpr_exr_channels *channels;
} picture;

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

static exr_result_t set_text(exr_context_t exr, const char *name, const char *text)
{
    return text && text[0] ? exr_attr_set_string(exr, 0, name, text) : EXR_ERR_SUCCESS;
}

static exr_result_t add_channels(exr_context_t exr, const hpr_exr_channels *list)
{
    static const exr_pixel_type_t type[] = {
        [HPR_EXR_FLOAT] = EXR_PIXEL_FLOAT, [HPR_EXR_HALF] = EXR_PIXEL_HALF, [HPR_EXR_UINT] = EXR_PIXEL_UINT};
    exr_result_t result = EXR_ERR_SUCCESS;
    for (size_t i = 0; result == EXR_ERR_SUCCESS && i < list->count; i++) {
        const hpr_exr_channel *channel = list->channel + i;
        result =
            exr_add_channel(exr, 0, channel->name, type[channel->kind],
                            channel->colour ? EXR_PERCEPTUALLY_LOGARITHMIC : EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    return result;
}

/* A window of a picture is its data window; what is around it is told by the display window. */
static exr_result_t add_windows(exr_context_t exr, const hpr_image *image, bool tiled)
{
    const exr_attr_box2i_t data = {
        .min = {.x = image->left, .y = image->top},
        .max = {.x = image->left + image->width - 1, .y = image->top + image->height - 1}};
    exr_attr_box2i_t display = data;
    if (image->full_width && image->full_height)
        display = (exr_attr_box2i_t){.max = {.x = image->full_width - 1, .y = image->full_height - 1}};
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    exr_result_t result = exr_initialize_required_attr(exr, 0, &display, &data, 1, &centre, 1,
                                                       EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    if (result == EXR_ERR_SUCCESS && tiled)
        result = exr_set_tile_descriptor(exr, 0, TILE, TILE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    return result;
}

static exr_result_t describe(exr_context_t exr, const picture *p)
{
    static const exr_attr_chromaticities_t rec709 = {0.64f, 0.33f, 0.30f,   0.60f,
                                                     0.15f, 0.06f, 0.3127f, 0.3290f};
    int part;
    bool tiled = p->labels && p->labels->tiled;
    exr_result_t result = exr_set_longname_support(exr, p->channels->long_names);
    if (result == EXR_ERR_SUCCESS)
        result = exr_add_part(exr, NULL, tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = add_windows(exr, p->image, tiled);
    if (result == EXR_ERR_SUCCESS)
        result = add_channels(exr, p->channels);
    if (result == EXR_ERR_SUCCESS && p->channels->rgb) {
        result = exr_attr_set_chromaticities(exr, 0, "chromaticities", &rec709);
        if (result == EXR_ERR_SUCCESS)
            result = set_text(exr, "colorInteropID", "lin_rec709_scene");
    }
    char software[64];
    snprintf(software, sizeof software, "hprad %s", hpr_version());
    if (result == EXR_ERR_SUCCESS)
        result = set_text(exr, "software", software);
    if (result == EXR_ERR_SUCCESS && p->labels)
        result = set_text(exr, "scene", p->labels->scene);
    if (result == EXR_ERR_SUCCESS && p->labels)
        result = set_text(exr, "camera", p->labels->camera);
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

/* Points every channel of the chunk to its pixels; (x, y) is its corner in the image. */
static void aim(exr_encode_pipeline_t *pipe, const picture *p, int x, int y)
{
    size_t first = (size_t)y * (size_t)p->image->width + (size_t)x;
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *channel = pipe->channels + i;
        size_t c = 0;
        while (strcmp(channel->channel_name, p->channels->channel[c].name) != 0)
            c++; /* the file has no others */
        const hpr_exr_channel *from = p->channels->channel + c;
        channel->encode_from_ptr = (const uint8_t *)from->pixel + first * from->stride;
        channel->user_pixel_stride = (int32_t)from->stride;
        channel->user_line_stride = (int32_t)(from->stride * (size_t)p->image->width);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = from->kind == HPR_EXR_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    }
}

/* What encoding keeps from chunk to chunk. */
typedef struct encoder {
    exr_encode_pipeline_t pipe;
    exr_result_t (*compress)(exr_encode_pipeline_t *);
    bool begun;
} encoder;

static exr_result_t write_chunk(exr_context_t exr, encoder *e, const exr_chunk_info_t *chunk,
                                const picture *p, int x, int y)
{
    exr_result_t result = e->begun ? exr_encoding_update(exr, 0, chunk, &e->pipe)
                                   : exr_encoding_initialize(exr, 0, chunk, &e->pipe);
    if (result != EXR_ERR_SUCCESS)
        return result;
    aim(&e->pipe, p, x, y);
    if (!e->begun) {
        result = exr_encoding_choose_default_routines(exr, 0, &e->pipe);
        e->compress = e->pipe.compress_fn;
        e->pipe.encoding_user_data = &e->compress;
        if (e->compress)
            e->pipe.compress_fn = compress_chunk;
    }
    e->begun = true;
    return result == EXR_ERR_SUCCESS ? exr_encoding_run(exr, 0, &e->pipe) : result;
}

static exr_result_t write_lines(exr_context_t exr, encoder *e, const picture *p)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(exr, 0, &lines);
    for (int y = 0; result == EXR_ERR_SUCCESS && y < p->image->height; y += lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(exr, 0, p->image->top + y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = write_chunk(exr, e, &chunk, p, 0, y);
    }
    return result;
}

static exr_result_t write_tiles(exr_context_t exr, encoder *e, const picture *p)
{
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int y = 0; y < p->image->height; y += TILE) {
        for (int x = 0; result == EXR_ERR_SUCCESS && x < p->image->width; x += TILE) {
            exr_chunk_info_t chunk;
            result = exr_write_tile_chunk_info(exr, 0, x / TILE, y / TILE, 0, 0, &chunk);
            if (result == EXR_ERR_SUCCESS)
                result = write_chunk(exr, e, &chunk, p, x, y);
        }
    }
    return result;
}

static exr_result_t write_pixels(exr_context_t exr, const picture *p)
{
    encoder e = {.pipe = EXR_ENCODE_PIPELINE_INITIALIZER};
    exr_result_t result = p->labels && p->labels->tiled ? write_tiles(exr, &e, p) : write_lines(exr, &e, p);
    exr_encoding_destroy(exr, &e.pipe);
    return result;
}

/* Half ends at 65504; what is above rounds to infinity, and that should not pass unseen. */
static void warn_of_range(const sink *out, const picture *p)
{
    static const float largest = 65504;
    size_t pixels = (size_t)p->image->width * (size_t)p->image->height, beyond = 0;
    for (size_t c = 0; c < p->channels->count; c++) {
        const hpr_exr_channel *channel = p->channels->channel + c;
        for (size_t i = 0; channel->kind == HPR_EXR_HALF && i < pixels; i++) {
            float value;
            memcpy(&value, (const char *)channel->pixel + i * channel->stride, sizeof value);
            beyond += value > largest || value < -largest;
        }
    }
    if (beyond)
        hpr_warn(out->context, "'%s': %zu values are beyond 65504 and infinite in half precision", out->path,
                 beyond);
}

static hpr_status encode(sink *out, const picture *p)
{
    exr_context_t exr = NULL;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = take_message;
    init.user_data = out;
    init.write_fn = take_bytes;
    init.zip_level = ZIP_LEVEL;
    exr_result_t result = exr_start_write(&exr, out->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (result == EXR_ERR_SUCCESS)
        result = describe(exr, p);
    if (result == EXR_ERR_SUCCESS)
        result = exr_write_header(exr);
    if (result == EXR_ERR_SUCCESS)
        result = write_pixels(exr, p);
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
    hpr_exr_channels channels;
    hpr_status status = hpr_exr_channels_create(ctx, image, labels, &channels);
    if (status != HPR_OK)
        return status;
    const picture p = {.image = image, .labels = labels, .channels = &channels};
    hpr_atomic_file file;
    sink out = {.context = ctx, .path = path};
    status = hpr_atomic_open(ctx, path, &file); /* first: a bad path is the commonest mistake */
    if (status == HPR_OK)
        status = encode(&out, &p);
    if (status == HPR_OK)
        status = hpr_atomic_write(&file, out.data, out.bytes);
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    if (status == HPR_OK)
        warn_of_range(&out, &p);
    hpr_atomic_abort(&file);
    hpr_release(ctx, out.data);
    hpr_exr_channels_release(ctx, &channels);
    return status;
}
