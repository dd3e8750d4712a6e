/* Pictures that vary a material's reflectance over a surface, as linear numbers. */
#ifndef HPR_SCENE_TEXTURE_H
#define HPR_SCENE_TEXTURE_H

#include "base/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hpr_wrap { HPR_WRAP_REPEAT, HPR_WRAP_MIRROR, HPR_WRAP_CLAMP } hpr_wrap;

typedef struct hpr_texture {
    uint32_t width, height;
    uint8_t wrap[2]; /* hpr_wrap along u and v */
    uint8_t nearest; /* 1: a texel is constant; 0: bilinear between texel centres */
    float *texel;    /* [height][width][channels], 0 to 1; the first row is at v = 0 */
} hpr_texture;

/* A copy with texels of its own. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_texture_copy(hpr_context *ctx, const hpr_texture *from, size_t channel_count, hpr_texture *to);

/* value [channels]: the texture at (u,v), u and v from 0 to 1 over the picture. Thread-safe. */
void hpr_texture_sample(const hpr_texture *texture, size_t channel_count, double u, double v, double *value);

/* One channel of it. */
double hpr_texture_channel(const hpr_texture *texture, size_t channel_count, size_t channel, double u,
                           double v);

/* Do the channels of every texel agree? */
bool hpr_texture_is_grey(const hpr_texture *texture, size_t channel_count);

#ifdef __cplusplus
}
#endif

#endif
