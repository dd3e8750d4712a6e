#include "scene/texture.h"

#include <math.h>
#include <string.h>

hpr_status hpr_texture_copy(hpr_context *ctx, const hpr_texture *from, size_t channel_count, hpr_texture *to)
{
    size_t count = (size_t)from->width * from->height;
    *to = *from;
    to->texel = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &to->texel, count, channel_count * sizeof *to->texel, "a texture");
    if (status == HPR_OK)
        memcpy(to->texel, from->texel, count * channel_count * sizeof *to->texel);
    return status;
}

/* Into one period of the texture first, so that indices stay small whatever the coordinates are. */
static double bring_near(double x, hpr_wrap wrap)
{
    switch (wrap) {
    case HPR_WRAP_REPEAT:
        return x - floor(x);
    case HPR_WRAP_MIRROR:
        return x - 2 * floor(x / 2);
    default:
        return fmin(fmax(x, 0), 1);
    }
}

/* The texel at index i, -1 <= i <= 2 size. */
static size_t texel_at(int64_t i, uint32_t size, hpr_wrap wrap)
{
    int64_t n = size;
    if (wrap == HPR_WRAP_CLAMP)
        return (size_t)(i < 0 ? 0 : i < n ? i : n - 1);
    int64_t period = wrap == HPR_WRAP_MIRROR ? 2 * n : n;
    i = (i % period + period) % period;
    return (size_t)(i < n ? i : period - 1 - i);
}

/* The texels around a point and their weights; of one that is constant per texel, one. */
typedef struct mixture {
    int count;
    size_t texel[4];
    double weight[4];
} mixture;

static mixture mix(const hpr_texture *texture, double u, double v)
{
    double shift = texture->nearest ? 0 : 0.5, part[2], at[2] = {u, v};
    const uint32_t size[2] = {texture->width, texture->height};
    size_t index[2][2];
    for (int k = 0; k < 2; k++) {
        hpr_wrap wrap = (hpr_wrap)texture->wrap[k];
        double x = bring_near(at[k], wrap) * size[k] - shift, low = floor(x);
        part[k] = texture->nearest ? 0 : x - low;
        index[k][0] = texel_at((int64_t)low, size[k], wrap);
        index[k][1] = texel_at((int64_t)low + 1, size[k], wrap);
    }
    mixture m = {.count = texture->nearest ? 1 : 4};
    for (int k = 0; k < m.count; k++) {
        m.weight[k] = (k % 2 ? part[0] : 1 - part[0]) * (k / 2 ? part[1] : 1 - part[1]);
        m.texel[k] = index[1][k / 2] * texture->width + index[0][k % 2];
    }
    return m;
}

static double channel_of(const hpr_texture *texture, const mixture *m, size_t channel_count, size_t channel)
{
    double value = 0;
    for (int k = 0; k < m->count; k++)
        value += m->weight[k] * (double)texture->texel[channel_count * m->texel[k] + channel];
    return value;
}

void hpr_texture_sample(const hpr_texture *texture, size_t channel_count, double u, double v, double *value)
{
    const mixture m = mix(texture, u, v);
    for (size_t c = 0; c < channel_count; c++)
        value[c] = channel_of(texture, &m, channel_count, c);
}

double hpr_texture_channel(const hpr_texture *texture, size_t channel_count, size_t channel, double u,
                           double v)
{
    const mixture m = mix(texture, u, v);
    return channel_of(texture, &m, channel_count, channel);
}

bool hpr_texture_is_grey(const hpr_texture *texture, size_t channel_count)
{
    size_t count = (size_t)texture->width * texture->height * channel_count;
    for (size_t i = 0; i < count; i++) {
        if (texture->texel[i] != texture->texel[i - i % channel_count])
            return false;
    }
    return true;
}
