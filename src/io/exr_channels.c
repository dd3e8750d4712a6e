#include "io/exr_channels.h"

#include "render/layers.h"

#include <stdio.h>
#include <string.h>

static const char *channel_name(const hpr_image *image, const hpr_image_labels *labels, size_t channel)
{
    static const char *const rgb[] = {"R", "G", "B"};
    if (labels->channel_name)
        return labels->channel_name[channel];
    return image->channel_count == 3 ? rgb[channel] : "Y";
}

static hpr_status check_image(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels)
{
    size_t n = image->channel_count;
    if (image->width < 1 || image->height < 1 || n < 1 || !image->radiance || !image->coverage)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %d x %d pixels and %zu channels cannot be written",
                        image->width, image->height, n);
    if (!labels->channel_name && n != 1 && n != 3)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %zu channels needs their names", n);
    if ((uint64_t)image->width * n * sizeof(float) > INT32_MAX)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %d pixels in %zu channels is too wide", image->width,
                        n);
    for (size_t c = 0; c < n; c++) {
        const char *name = channel_name(image, labels, c);
        if (!name || !name[0])
            return hpr_fail(ctx, HPR_ERR_ARG, "channel %zu of a picture has no name", c);
    }
    return HPR_OK;
}

/* Appends layer.component, or one of the two alone. Errors: HPR_ERR_ARG. */
static hpr_status add(hpr_context *ctx, hpr_exr_channels *list, const char *layer, const char *component,
                      const hpr_exr_channel *like)
{
    hpr_exr_channel *channel = list->channel + list->count;
    *channel = *like;
    int length = snprintf(channel->name, sizeof channel->name, "%s%s%s", layer,
                          layer[0] && component[0] ? "." : "", component);
    if (length > HPR_EXR_LONG_NAME)
        return hpr_fail(ctx, HPR_ERR_ARG, "channel '%.60s...' has a name of %d characters, more than %d",
                        channel->name, length, HPR_EXR_LONG_NAME);
    for (size_t i = 0; i < list->count; i++) {
        if (!strcmp(list->channel[i].name, channel->name))
            return hpr_fail(ctx, HPR_ERR_ARG, "two channels of a picture have the name '%s'", channel->name);
    }
    list->long_names = list->long_names || length > HPR_EXR_SHORT_NAME;
    list->count++;
    return HPR_OK;
}

/* The channels of `pixel` [pixels][channels], one for each of the picture's. */
static hpr_status add_spectrum(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels,
                               const char *layer, const float *pixel, hpr_exr_channel like,
                               hpr_exr_channels *list)
{
    hpr_status status = HPR_OK;
    like.stride = image->channel_count * sizeof(float);
    for (size_t c = 0; pixel && c < image->channel_count && status == HPR_OK; c++) {
        like.pixel = pixel + c;
        status = add(ctx, list, layer, channel_name(image, labels, c), &like);
    }
    return status;
}

static hpr_status add_layer(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels,
                            hpr_layer layer, hpr_exr_channels *list)
{
    static const char *const axes[] = {"X", "Y", "Z"};
    const char *name = hpr_layer_name(layer);
    const float *pixel = image->layer[layer];
    size_t components = hpr_layer_components(layer, image->channel_count);
    bool coarse = labels->half && layer != HPR_LAYER_POSITION && layer != HPR_LAYER_DEPTH;
    hpr_exr_channel like = {.kind = coarse ? HPR_EXR_HALF : HPR_EXR_FLOAT};
    if (hpr_layer_averaged(layer)) {
        like.colour = layer != HPR_LAYER_ALBEDO;
        return add_spectrum(ctx, image, labels, name, pixel, like, list);
    }
    hpr_status status = HPR_OK;
    like.stride = components * sizeof(float);
    for (size_t k = 0; pixel && k < components && status == HPR_OK; k++) {
        like.pixel = pixel + k;
        status = add(ctx, list, name, components == 3 ? axes[k] : "", &like);
    }
    return status;
}

static hpr_status add_numbers(hpr_context *ctx, hpr_layer layer, const uint32_t *pixel,
                              hpr_exr_channels *list)
{
    const hpr_exr_channel like = {.kind = HPR_EXR_UINT, .pixel = pixel, .stride = sizeof *pixel};
    return pixel ? add(ctx, list, hpr_layer_name(layer), "", &like) : HPR_OK;
}

hpr_status hpr_exr_channels_create(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels,
                                   hpr_exr_channels *list)
{
    static const hpr_image_labels none;
    labels = labels ? labels : &none;
    *list = (hpr_exr_channels){0};
    hpr_status status = check_image(ctx, image, labels);
    if (status != HPR_OK)
        return status;
    size_t most = 2 * image->channel_count + 1 + 2;
    for (int layer = 0; layer < HPR_LAYER_PATCH; layer++)
        most += hpr_layer_components((hpr_layer)layer, image->channel_count);
    status = hpr_allocate_into(ctx, &list->channel, most, sizeof *list->channel, "a picture's channels");
    const hpr_exr_channel light = {.kind = labels->half ? HPR_EXR_HALF : HPR_EXR_FLOAT, .colour = true};
    hpr_exr_channel coverage = light;
    coverage.pixel = image->coverage;
    coverage.stride = sizeof(float);
    if (status == HPR_OK)
        status = add_spectrum(ctx, image, labels, "", image->radiance, light, list);
    if (status == HPR_OK)
        status = add(ctx, list, "", "A", &coverage);
    if (status == HPR_OK)
        status = add_spectrum(ctx, image, labels, "variance", image->variance,
                              (hpr_exr_channel){.kind = HPR_EXR_FLOAT}, list);
    for (int layer = 0; layer < HPR_LAYER_PATCH && status == HPR_OK; layer++)
        status = add_layer(ctx, image, labels, (hpr_layer)layer, list);
    if (status == HPR_OK)
        status = add_numbers(ctx, HPR_LAYER_PATCH, image->patch, list);
    if (status == HPR_OK)
        status = add_numbers(ctx, HPR_LAYER_ELEMENT, image->element, list);
    list->rgb = status == HPR_OK && image->channel_count == 3 && !strcmp(list->channel[0].name, "R") &&
                !strcmp(list->channel[1].name, "G") && !strcmp(list->channel[2].name, "B");
    if (status != HPR_OK)
        hpr_exr_channels_release(ctx, list);
    return status;
}

void hpr_exr_channels_release(hpr_context *ctx, hpr_exr_channels *channels)
{
    hpr_release(ctx, channels->channel);
    *channels = (hpr_exr_channels){0};
}
