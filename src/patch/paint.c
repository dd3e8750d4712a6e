#include "patch/paint.h"

#include <math.h>
#include <string.h>

hpr_status hpr_paint_create(hpr_patches *patches, size_t texture_count, const hpr_texture *texture)
{
    hpr_context *ctx = patches->context;
    size_t n = patches->channel_count;
    hpr_status status = hpr_allocate_into(ctx, &patches->paint, 1, sizeof *patches->paint, "textures");
    if (status != HPR_OK)
        return status;
    hpr_paint *paint = patches->paint;
    status = hpr_allocate_into(ctx, &paint->texture, texture_count, sizeof *paint->texture, "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->of_patch, patches->count, sizeof(uint32_t), "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->map, patches->count, 6 * sizeof(double), "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->tint, patches->count, 3 * n * sizeof(double), "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->glow_of, patches->count, sizeof(uint32_t), "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->glow_map, patches->count, 6 * sizeof(double), "textures");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &paint->glow, patches->count, n * sizeof(double), "textures");
    for (size_t i = 0; status == HPR_OK && i < texture_count; i++) {
        status = hpr_texture_copy(ctx, &texture[i], n, &paint->texture[i]);
        paint->texture_count = i + 1;
    }
    for (size_t i = 0; status == HPR_OK && i < patches->count; i++)
        paint->of_patch[i] = paint->glow_of[i] = HPR_NONE;
    if (status != HPR_OK)
        hpr_paint_destroy(patches);
    return status;
}

void hpr_paint_destroy(hpr_patches *patches)
{
    hpr_paint *paint = patches->paint;
    if (!paint)
        return;
    hpr_context *ctx = patches->context;
    for (size_t i = 0; i < paint->texture_count; i++)
        hpr_release(ctx, paint->texture[i].texel);
    void *arrays[] = {paint->texture, paint->of_patch, paint->map, paint->tint,
                      paint->glow_of, paint->glow_map, paint->glow};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, paint);
    patches->paint = NULL;
}

const hpr_texture *hpr_patch_texture(const hpr_patches *patches, size_t patch)
{
    const hpr_paint *paint = patches->paint;
    return paint && paint->of_patch[patch] != HPR_NONE ? &paint->texture[paint->of_patch[patch]] : NULL;
}

const hpr_texture *hpr_patch_glow(const hpr_patches *patches, size_t patch)
{
    const hpr_paint *paint = patches->paint;
    return paint && paint->glow_of[patch] != HPR_NONE ? &paint->texture[paint->glow_of[patch]] : NULL;
}

bool hpr_patches_glow(const hpr_patches *patches)
{
    size_t i = 0;
    while (i < patches->count && !hpr_patch_glow(patches, i))
        i++;
    return i < patches->count;
}

void hpr_patch_reflectance(const hpr_patches *patches, size_t patch, double s, double t, double *rho)
{
    size_t n = patches->channel_count;
    const hpr_texture *texture = hpr_patch_texture(patches, patch);
    if (!texture) {
        memcpy(rho, patches->reflectance + n * patch, n * sizeof *rho);
        return;
    }
    const double *map = patches->paint->map + 6 * patch, *tint = patches->paint->tint + 3 * n * patch;
    hpr_texture_sample(texture, n, map[0] + s * map[2] + t * map[4], map[1] + s * map[3] + t * map[5], rho);
    for (size_t c = 0; c < n; c++)
        rho[c] = fmin(fmax(rho[c] * (tint[c] + s * tint[n + c] + t * tint[2 * n + c]), 0), 1);
}

double hpr_patch_exitance(const hpr_patches *patches, size_t patch, double s, double t, size_t channel)
{
    size_t n = patches->channel_count;
    const hpr_texture *texture = hpr_patch_glow(patches, patch);
    if (!texture)
        return patches->exitance[n * patch + channel];
    const double *map = patches->paint->glow_map + 6 * patch;
    return patches->paint->glow[n * patch + channel] * hpr_texture_channel(texture, n, channel,
                                                                           map[0] + s * map[2] + t * map[4],
                                                                           map[1] + s * map[3] + t * map[5]);
}

bool hpr_patches_are_grey(const hpr_patches *patches)
{
    size_t n = patches->channel_count;
    for (size_t i = 0; i < n * patches->count; i++) {
        if (patches->reflectance[i] != patches->reflectance[i - i % n] ||
            patches->exitance[i] != patches->exitance[i - i % n])
            return false;
    }
    const hpr_paint *paint = patches->paint;
    for (size_t i = 0; paint && i < 3 * n * patches->count; i++) {
        if (paint->tint[i] != paint->tint[i - i % n])
            return false;
        if (i < n * patches->count && paint->glow[i] != paint->glow[i - i % n])
            return false;
    }
    for (size_t i = 0; paint && i < paint->texture_count; i++) {
        if (!hpr_texture_is_grey(&paint->texture[i], n))
            return false;
    }
    return true;
}
