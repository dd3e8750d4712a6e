/* Pictures from OpenEXR, to compare with: the radiance of the first part, as 32-bit floats. */
#include "base/context.h"

#include <errno.h>
#include <hprad/render.h>
#include <OpenEXR/openexr.h>
#include <stdio.h>
#include <string.h>

enum { MAX_SIDE = 32768 }; /* as pictures of our own */

/* One file that is being read. */
typedef struct source {
    hpr_context *context;
    const char *path;
    exr_context_t exr;
    exr_attr_box2i_t window;
    size_t channel_count;
    const char *const *channel_name;
    hpr_image *image;
    bool tiled;
} source;

static void take_message(exr_const_context_t exr, exr_result_t code, const char *text)
{
    void *user = NULL;
    if (!exr || exr_get_user_data(exr, &user) != EXR_ERR_SUCCESS || !user)
        return;
    const source *from = user;
    hpr_fail(from->context, code == EXR_ERR_OUT_OF_MEMORY ? HPR_ERR_MEMORY : HPR_ERR_FORMAT,
             "cannot read '%s': OpenEXR: %s", from->path, text);
}

static hpr_status check(const source *from, exr_result_t result)
{
    if (result == EXR_ERR_SUCCESS)
        return HPR_OK;
    hpr_status status = result == EXR_ERR_OUT_OF_MEMORY ? HPR_ERR_MEMORY : HPR_ERR_FORMAT;
    return hpr_fail(from->context, status, "cannot read '%s': OpenEXR: %s", from->path,
                    exr_get_default_error_message(result));
}

/* Whether the file has what is asked for. */
static hpr_status check_channels(const source *from, bool *covered)
{
    const exr_attr_chlist_t *list = NULL;
    hpr_status status = check(from, exr_get_channels(from->exr, 0, &list));
    *covered = false;
    for (size_t c = 0; c <= from->channel_count && status == HPR_OK; c++) {
        const char *wanted = c < from->channel_count ? from->channel_name[c] : "A";
        int i = 0;
        while (i < list->num_channels && strcmp(list->entries[i].name.str, wanted) != 0)
            i++;
        bool found = i < list->num_channels;
        if (!found && c < from->channel_count)
            return hpr_fail(from->context, HPR_ERR_FORMAT, "'%s' has no channel %s", from->path, wanted);
        if (found && (list->entries[i].x_sampling != 1 || list->entries[i].y_sampling != 1))
            return hpr_fail(from->context, HPR_ERR_FORMAT, "'%s': channel %s is subsampled", from->path,
                            wanted);
        *covered = *covered || (found && c == from->channel_count);
    }
    return status;
}

static hpr_status check_storage(source *from)
{
    exr_storage_t storage;
    hpr_status status = check(from, exr_get_storage(from->exr, 0, &storage));
    if (status != HPR_OK)
        return status;
    from->tiled = storage == EXR_STORAGE_TILED;
    if (storage != EXR_STORAGE_TILED && storage != EXR_STORAGE_SCANLINE)
        return hpr_fail(from->context, HPR_ERR_UNSUPPORTED, "'%s' holds deep data, not a picture",
                        from->path);
    return HPR_OK;
}

static hpr_status open_image(source *from)
{
    hpr_image *image = from->image;
    exr_attr_box2i_t display;
    bool covered = false;
    hpr_status status = check_storage(from);
    if (status == HPR_OK)
        status = check(from, exr_get_data_window(from->exr, 0, &from->window));
    if (status == HPR_OK)
        status = check(from, exr_get_display_window(from->exr, 0, &display));
    if (status == HPR_OK)
        status = check_channels(from, &covered);
    if (status != HPR_OK)
        return status;
    int64_t wide = (int64_t)from->window.max.x - from->window.min.x + 1;
    int64_t high = (int64_t)from->window.max.y - from->window.min.y + 1;
    if (wide < 1 || wide > MAX_SIDE || high < 1 || high > MAX_SIDE)
        return hpr_fail(from->context, HPR_ERR_FORMAT, "'%s' has %lld x %lld pixels: sides must be 1 to %d",
                        from->path, (long long)wide, (long long)high, MAX_SIDE);
    image->channel_count = from->channel_count;
    image->width = (int)wide;
    image->height = (int)high;
    image->left = from->window.min.x - display.min.x;
    image->top = from->window.min.y - display.min.y;
    image->full_width = display.max.x - display.min.x + 1;
    image->full_height = display.max.y - display.min.y + 1;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    status = hpr_allocate_into(from->context, &image->radiance, pixels, from->channel_count * sizeof(float),
                               "a picture");
    if (status == HPR_OK)
        status = hpr_allocate_into(from->context, &image->coverage, pixels, sizeof(float), "a picture");
    for (size_t i = 0; status == HPR_OK && !covered && i < pixels; i++)
        image->coverage[i] = 1;
    return status;
}

/* Decodes one chunk to its place; (x, y) is its corner in the image. */
static exr_result_t read_chunk(const source *from, const exr_chunk_info_t *chunk, int x, int y)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    size_t n = from->channel_count, width = (size_t)from->image->width;
    size_t first = (size_t)y * width + (size_t)x;
    exr_result_t result = exr_decoding_initialize(from->exr, 0, chunk, &pipe);
    if (result != EXR_ERR_SUCCESS)
        return result;
    for (int i = 0; i < pipe.channel_count; i++) {
        exr_coding_channel_info_t *channel = pipe.channels + i;
        float *to = NULL;
        size_t step = n;
        for (size_t c = 0; c < n; c++) {
            if (!strcmp(channel->channel_name, from->channel_name[c]))
                to = from->image->radiance + first * n + c;
        }
        if (!to && !strcmp(channel->channel_name, "A")) {
            to = from->image->coverage + first;
            step = 1;
        }
        channel->decode_to_ptr = (uint8_t *)to; /* NULL: left out */
        channel->user_pixel_stride = (int32_t)(step * sizeof(float));
        channel->user_line_stride = (int32_t)(step * width * sizeof(float));
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
    }
    result = exr_decoding_choose_default_routines(from->exr, 0, &pipe);
    if (result == EXR_ERR_SUCCESS)
        result = exr_decoding_run(from->exr, 0, &pipe);
    exr_decoding_destroy(from->exr, &pipe);
    return result;
}

static exr_result_t read_lines(const source *from)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(from->exr, 0, &lines);
    for (int y = 0; result == EXR_ERR_SUCCESS && y < from->image->height; y += lines) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(from->exr, 0, from->window.min.y + y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = read_chunk(from, &chunk, 0, y);
    }
    return result;
}

static exr_result_t read_tiles(const source *from)
{
    int32_t wide = 0, high = 0;
    exr_result_t result = exr_get_tile_sizes(from->exr, 0, 0, 0, &wide, &high);
    for (int y = 0; result == EXR_ERR_SUCCESS && y < from->image->height; y += high) {
        for (int x = 0; result == EXR_ERR_SUCCESS && x < from->image->width; x += wide) {
            exr_chunk_info_t chunk;
            result = exr_read_tile_chunk_info(from->exr, 0, x / wide, y / high, 0, 0, &chunk);
            if (result == EXR_ERR_SUCCESS)
                result = read_chunk(from, &chunk, x, y);
        }
    }
    return result;
}

hpr_status hpr_image_read_exr(hpr_context *ctx, const char *path, size_t channel_count,
                              const char *const *channel_name, hpr_image *image)
{
    *image = (hpr_image){0};
    hpr_context_clear_error(ctx);
    FILE *file = fopen(path, "rb"); /* OpenEXR does not tell a file that is missing from a bad one */
    if (!file)
        return hpr_fail(ctx, HPR_ERR_IO, "cannot read '%s': %s", path, strerror(errno));
    fclose(file);
    source from = {.context = ctx,
                   .path = path,
                   .channel_count = channel_count,
                   .channel_name = channel_name,
                   .image = image};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = take_message;
    init.user_data = &from;
    hpr_status status = check(&from, exr_start_read(&from.exr, path, &init));
    if (status == HPR_OK)
        status = open_image(&from);
    if (status == HPR_OK)
        status = check(&from, from.tiled ? read_tiles(&from) : read_lines(&from));
    if (from.exr)
        exr_finish(&from.exr);
    return status;
}
