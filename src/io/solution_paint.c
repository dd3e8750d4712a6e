#include "io/solution_paint.h"

#include "io/json_text.h"
#include "io/solution_column.h"
#include "patch/paint.h"

#include <math.h>
#include <string.h>

enum { PATCH_COLUMNS = 6, TEXTURES_SINCE = 5, GLOW_SINCE = 6, MOST_TEXELS = 1 << 26 };

/* What a patch has of its own; paint may be NULL. */
static void patch_columns(const hpr_patches *patches, hpr_column columns[PATCH_COLUMNS])
{
    hpr_paint *paint = patches->paint;
    size_t n = patches->channel_count, count = patches->count;
    const hpr_column all[PATCH_COLUMNS] = {
        {"patches", "texture", HPR_UINT32, 1, count, false, TEXTURES_SINCE, paint ? &paint->of_patch : NULL},
        {"patches", "textureMap", HPR_FLOAT64, 6, count, false, TEXTURES_SINCE, paint ? &paint->map : NULL},
        {"patches", "tint", HPR_FLOAT64, 3 * n, count, false, TEXTURES_SINCE, paint ? &paint->tint : NULL},
        {"patches", "glowTexture", HPR_UINT32, 1, count, false, GLOW_SINCE, paint ? &paint->glow_of : NULL},
        {"patches", "glowMap", HPR_FLOAT64, 6, count, false, GLOW_SINCE, paint ? &paint->glow_map : NULL},
        {"patches", "glow", HPR_FLOAT64, n, count, false, GLOW_SINCE, paint ? &paint->glow : NULL},
    };
    memcpy(columns, all, sizeof all);
}

static hpr_column texel_column(hpr_texture *texture, size_t channel_count)
{
    return (hpr_column){
        "textures", "texels",       HPR_FLOAT32,    channel_count, (size_t)texture->width * texture->height,
        false,      TEXTURES_SINCE, &texture->texel};
}

hpr_status hpr_solution_write_paint(hpr_glb_builder *glb, cJSON *extension, const hpr_patches *patches)
{
    bool *ok = &glb->ok;
    hpr_paint *paint = patches->paint;
    if (!paint)
        return HPR_OK;
    hpr_status status = HPR_OK;
    cJSON *textures = hpr_json_array(extension, "textures", ok);
    for (size_t i = 0; status == HPR_OK && i < paint->texture_count; i++) {
        hpr_texture *texture = &paint->texture[i];
        cJSON *item = hpr_json_object(textures, NULL, ok);
        hpr_json_number(item, "width", texture->width, ok);
        hpr_json_number(item, "height", texture->height, ok);
        hpr_json_number(item, "wrapU", texture->wrap[0], ok);
        hpr_json_number(item, "wrapV", texture->wrap[1], ok);
        hpr_json_number(item, "nearest", texture->nearest, ok);
        const hpr_column column = texel_column(texture, patches->channel_count);
        status = hpr_column_write(glb, item, &column);
    }
    hpr_column columns[PATCH_COLUMNS];
    patch_columns(patches, columns);
    cJSON *group = cJSON_GetObjectItemCaseSensitive(extension, "patches");
    for (size_t i = 0; status == HPR_OK && i < PATCH_COLUMNS; i++) {
        if (columns[i].since < GLOW_SINCE || hpr_patches_glow(patches))
            status = hpr_column_write(glb, group, columns + i);
    }
    return status;
}

static hpr_status broken(const hpr_glb *glb, const char *what, size_t index)
{
    return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s: %s %zu is not sound", glb->path,
                    HPR_EXTENSION_NAME, what, index);
}

/* One texture, its texels borrowed from the file. */
static hpr_status find_texture(const hpr_glb *glb, const cJSON *item, size_t index, size_t channel_count,
                               hpr_texture *texture)
{
    static const char *const keys[] = {"width", "height", "wrapU", "wrapV", "nearest"};
    static const double most[] = {MOST_TEXELS, MOST_TEXELS, HPR_WRAP_CLAMP, HPR_WRAP_CLAMP, 1};
    size_t value[5], bytes;
    const unsigned char *data;
    for (int k = 0; k < 5; k++) {
        if (!hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(item, keys[k]), most[k], &value[k]))
            return broken(glb, "texture", index);
    }
    if (value[0] == 0 || value[1] == 0 || value[0] * value[1] > MOST_TEXELS)
        return broken(glb, "texture", index);
    *texture = (hpr_texture){.width = (uint32_t)value[0],
                             .height = (uint32_t)value[1],
                             .wrap = {(uint8_t)value[2], (uint8_t)value[3]},
                             .nearest = (uint8_t)value[4]};
    const hpr_column column = texel_column(texture, channel_count);
    hpr_status status = hpr_column_find(glb, item, HPR_EXTENSION_VERSION, &column, &data, &bytes);
    memcpy(&texture->texel, &data, sizeof data); /* only copied from */
    return status;
}

static hpr_status check_paint(const hpr_glb *glb, const hpr_patches *patches)
{
    const hpr_paint *paint = patches->paint;
    size_t n = 3 * patches->channel_count;
    for (size_t i = 0; i < paint->texture_count; i++) {
        const hpr_texture *texture = &paint->texture[i];
        for (size_t k = 0; k < patches->channel_count * texture->width * texture->height; k++) {
            if (!(texture->texel[k] >= 0 && texture->texel[k] <= 1))
                return broken(glb, "texture", i);
        }
    }
    for (size_t i = 0; i < patches->count; i++) {
        bool sound = paint->of_patch[i] == HPR_NONE || paint->of_patch[i] < paint->texture_count;
        for (size_t k = 0; k < 6; k++)
            sound = sound && isfinite(paint->map[6 * i + k]);
        for (size_t k = 0; k < n; k++)
            sound = sound && isfinite(paint->tint[n * i + k]);
        sound = sound && (paint->glow_of[i] == HPR_NONE || paint->glow_of[i] < paint->texture_count);
        for (size_t k = 0; k < 6; k++)
            sound = sound && isfinite(paint->glow_map[6 * i + k]);
        for (size_t k = 0; k < patches->channel_count; k++)
            sound = sound && isfinite(paint->glow[patches->channel_count * i + k]) &&
                    paint->glow[patches->channel_count * i + k] >= 0;
        if (!sound)
            return broken(glb, "the texture of patch", i);
    }
    return HPR_OK;
}

static hpr_status take_patches(const hpr_glb *glb, const cJSON *extension, size_t version,
                               const hpr_patches *patches)
{
    hpr_column columns[PATCH_COLUMNS];
    patch_columns(patches, columns);
    const cJSON *group = cJSON_GetObjectItemCaseSensitive(extension, "patches");
    for (size_t i = 0; i < PATCH_COLUMNS; i++) {
        const unsigned char *data;
        size_t bytes;
        hpr_status status = hpr_column_find(glb, group, version, columns + i, &data, &bytes);
        if (status != HPR_OK)
            return status;
        void *array;
        memcpy(&array, columns[i].array, sizeof array);
        if (data)
            memcpy(array, data, bytes);
    }
    return check_paint(glb, patches);
}

hpr_status hpr_solution_read_paint(const hpr_glb *glb, const cJSON *extension, size_t version,
                                   hpr_patches *patches)
{
    const cJSON *textures = cJSON_GetObjectItemCaseSensitive(extension, "textures"), *item;
    if (version < TEXTURES_SINCE || !textures)
        return HPR_OK;
    if (!cJSON_IsArray(textures))
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s: textures is no list", glb->path,
                        HPR_EXTENSION_NAME);
    size_t count = (size_t)cJSON_GetArraySize(textures), i = 0;
    hpr_texture *texture = NULL;
    hpr_status status = hpr_allocate_into(glb->context, &texture, count, sizeof *texture, "textures");
    cJSON_ArrayForEach(item, textures)
    {
        if (status == HPR_OK)
            status = find_texture(glb, item, i, patches->channel_count, &texture[i]);
        i++;
    }
    if (status == HPR_OK)
        status = hpr_paint_create(patches, count, texture);
    hpr_release(glb->context, texture);
    return status == HPR_OK ? take_patches(glb, extension, version, patches) : status;
}
