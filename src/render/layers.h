/* Names and sizes of a picture's layers. */
#ifndef HPR_RENDER_LAYERS_H
#define HPR_RENDER_LAYERS_H

#include "base/context.h"

#include <hprad/render.h>

/* Numbers per pixel, for a picture of so many channels. */
size_t hpr_layer_components(hpr_layer layer, size_t channel_count);

/* Whether a layer is a mean over the pixel, like the radiance; else it belongs to one point. */
bool hpr_layer_averaged(hpr_layer layer);

#endif
