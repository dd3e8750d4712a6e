#include "render/layers.h"

#include <string.h>

static const char *const names[HPR_LAYER_COUNT] = {
    [HPR_LAYER_IRRADIANCE] = "irradiance",
    [HPR_LAYER_DIRECT] = "direct",
    [HPR_LAYER_INDIRECT] = "indirect",
    [HPR_LAYER_EMISSION] = "emission",
    [HPR_LAYER_ALBEDO] = "albedo",
    [HPR_LAYER_NORMAL] = "N",
    [HPR_LAYER_POSITION] = "P",
    [HPR_LAYER_DEPTH] = "Z",
    [HPR_LAYER_DEGREE] = "degree",
    [HPR_LAYER_ERROR] = "error",
    [HPR_LAYER_PATCH] = "patchId",
    [HPR_LAYER_ELEMENT] = "elementId",
};

const char *hpr_layer_name(hpr_layer layer)
{
    return names[layer];
}

bool hpr_layer_averaged(hpr_layer layer)
{
    return layer <= HPR_LAYER_ALBEDO;
}

size_t hpr_layer_components(hpr_layer layer, size_t channel_count)
{
    if (hpr_layer_averaged(layer))
        return channel_count;
    return layer == HPR_LAYER_NORMAL || layer == HPR_LAYER_POSITION ? 3 : 1;
}

hpr_layer hpr_layer_find(const char *name, size_t length)
{
    int layer = 0;
    while (layer < HPR_LAYER_COUNT &&
           (strlen(names[layer]) != length || strncmp(names[layer], name, length) != 0))
        layer++;
    return (hpr_layer)layer;
}
