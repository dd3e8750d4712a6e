#include "baseline/lights.h"

#include "math/vec3.h"

static double strongest_channel(const hpr_patches *patches, size_t patch)
{
    double strongest = 0;
    for (size_t c = 0; c < patches->channel_count; c++)
        strongest = fmax(strongest, patches->exitance[patches->channel_count * patch + c]);
    return strongest;
}

/* Area times strength in units of the strongest, so that no sum overflows. A pair of twins counts at its
 * front. */
static double power_of(const hpr_patches *patches, size_t patch, double unit)
{
    double strength = strongest_channel(patches, patch);
    uint32_t twin = patches->twin[patch];
    if (twin != HPR_NONE) {
        if (patches->side[patch] != 0)
            return 0;
        strength = fmax(strength, strongest_channel(patches, twin));
    }
    return patches->area_m2[patch] * (strength / unit);
}

hpr_status hpr_lights_init(const hpr_patches *patches, hpr_lights *lights)
{
    hpr_context *ctx = patches->context;
    size_t count = patches->count;
    *lights = (hpr_lights){.patches = patches};
    hpr_status status = hpr_allocate_into(ctx, &lights->patch, count, sizeof(uint32_t), "lamps");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &lights->cumulated, count, sizeof(double), "lamps");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &lights->density, count, sizeof(double), "lamps");
    if (status != HPR_OK)
        return status;
    double unit = 0, total = 0, sum = 0;
    for (size_t i = 0; i < count; i++)
        unit = fmax(unit, strongest_channel(patches, i));
    for (size_t i = 0; unit > 0 && i < count; i++)
        total += power_of(patches, i, unit);
    for (size_t i = 0; total > 0 && i < count; i++) {
        double power = power_of(patches, i, unit);
        if (!(power > 0))
            continue;
        sum += power;
        lights->patch[lights->count] = (uint32_t)i;
        lights->cumulated[lights->count++] = sum / total;
        lights->density[i] = power / total / patches->area_m2[i];
        if (patches->twin[i] != HPR_NONE)
            lights->density[patches->twin[i]] = lights->density[i];
    }
    return HPR_OK;
}

void hpr_lights_fini(hpr_lights *lights)
{
    if (!lights->patches)
        return;
    hpr_context *ctx = lights->patches->context;
    hpr_release(ctx, lights->patch);
    hpr_release(ctx, lights->cumulated);
    hpr_release(ctx, lights->density);
    *lights = (hpr_lights){0};
}

/* The first lamp whose cumulated chance is above u; the last one takes what rounding leaves. */
static uint32_t lamp_at(const hpr_lights *lights, double u)
{
    size_t low = 0, high = lights->count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (lights->cumulated[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    return lights->patch[low];
}

uint32_t hpr_lights_choose(const hpr_lights *lights, const double from[3], double u, double s, double t,
                           double y[3])
{
    const hpr_patches *patches = lights->patches;
    uint32_t patch = lamp_at(lights, u);
    double at[2];
    hpr_shape_uniform((hpr_shape)patches->shape[patch], patches->opposite + 2 * (size_t)patch, s, t, at);
    for (int k = 0; k < 3; k++) {
        size_t i = 3 * (size_t)patch + (size_t)k;
        y[k] = patches->origin[i] + at[0] * patches->edge1[i] + at[1] * patches->edge2[i];
    }
    double across[3];
    hpr_subtract3(from, y, across);
    bool behind = hpr_dot3(across, patches->normal + 3 * (size_t)patch) < 0;
    return behind && patches->twin[patch] != HPR_NONE ? patches->twin[patch] : patch;
}
