#include "patch/patches.h"

#include "math/vec3.h"
#include "patch/paint.h"

hpr_status hpr_patches_create(hpr_context *ctx, size_t capacity, size_t channel_count, hpr_patches **out)
{
    *out = NULL;
    if (capacity >= HPR_NONE)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "%zu patches are more than 32-bit indices can name", capacity);
    hpr_patches *patches = NULL;
    hpr_status status = hpr_allocate_into(ctx, &patches, 1, sizeof *patches, "patches");
    if (status != HPR_OK)
        return status;
    patches->context = ctx;
    patches->count = capacity;
    patches->channel_count = channel_count;
    const struct {
        void *array; /* address of the pointer */
        size_t item_bytes;
    } columns[] = {
        {&patches->shape, sizeof(uint8_t)},
        {&patches->side, sizeof(uint8_t)},
        {&patches->twin, sizeof(uint32_t)},
        {&patches->node, sizeof(uint32_t)},
        {&patches->primitive, sizeof(uint32_t)},
        {&patches->material, sizeof(uint32_t)},
        {&patches->origin, 3 * sizeof(double)},
        {&patches->edge1, 3 * sizeof(double)},
        {&patches->edge2, 3 * sizeof(double)},
        {&patches->normal, 3 * sizeof(double)},
        {&patches->opposite, 2 * sizeof(double)},
        {&patches->area_m2, sizeof(double)},
        {&patches->reflectance, channel_count * sizeof(double)},
        {&patches->exitance, channel_count * sizeof(double)},
    };
    for (size_t i = 0; status == HPR_OK && i < sizeof columns / sizeof *columns; i++)
        status = hpr_allocate_into(ctx, columns[i].array, capacity, columns[i].item_bytes, "patches");
    if (status != HPR_OK)
        hpr_patches_destroy(&patches);
    *out = patches;
    return status;
}

void hpr_patches_destroy(hpr_patches **out)
{
    hpr_patches *patches = *out;
    if (!patches)
        return;
    hpr_context *ctx = patches->context;
    void *arrays[] = {patches->shape,     patches->side,     patches->twin,    patches->node,
                      patches->primitive, patches->material, patches->origin,  patches->edge1,
                      patches->edge2,     patches->normal,   patches->area_m2, patches->reflectance,
                      patches->exitance,  patches->opposite};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_paint_destroy(patches);
    hpr_release(ctx, patches);
    *out = NULL;
}

size_t hpr_patch_corners(const hpr_patches *patches, size_t patch, double corner[4][3])
{
    const double *origin = patches->origin + 3 * patch;
    const double *edge1 = patches->edge1 + 3 * patch, *edge2 = patches->edge2 + 3 * patch;
    const double *opposite = patches->opposite + 2 * patch;
    hpr_shape shape = (hpr_shape)patches->shape[patch];
    for (int k = 0; k < 3; k++) {
        corner[0][k] = origin[k];
        corner[1][k] = origin[k] + edge1[k];
        corner[2][k] = shape == HPR_SHAPE_TRIANGLE ? origin[k] + edge2[k]
                       : shape == HPR_SHAPE_PARALLELOGRAM
                           ? origin[k] + edge1[k] + edge2[k]
                           : origin[k] + opposite[0] * edge1[k] + opposite[1] * edge2[k];
        corner[3][k] = origin[k] + edge2[k];
    }
    return shape == HPR_SHAPE_TRIANGLE ? 3 : 4;
}

double hpr_patches_radius(const hpr_patches *patches, double centre[3])
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < patches->count; i++) {
        double corner[4][3];
        size_t corner_count = hpr_patch_corners(patches, i, corner);
        for (size_t c = 0; c < corner_count; c++) {
            for (int k = 0; k < 3; k++) {
                low[k] = fmin(low[k], corner[c][k]);
                high[k] = fmax(high[k], corner[c][k]);
            }
        }
    }
    double half[3] = {0};
    for (int k = 0; k < 3; k++) {
        centre[k] = patches->count ? 0.5 * low[k] + 0.5 * high[k] : 0;
        half[k] = patches->count ? 0.5 * high[k] - 0.5 * low[k] : 0;
    }
    return hpr_length(hpr_vec3_load(half));
}

void hpr_patch_parameters(const hpr_patches *patches, size_t patch, const double point[3], double *s,
                          double *t)
{
    hpr_vec3 edge1 = hpr_vec3_load(patches->edge1 + 3 * patch);
    hpr_vec3 edge2 = hpr_vec3_load(patches->edge2 + 3 * patch);
    hpr_vec3 offset = hpr_sub(hpr_vec3_load(point), hpr_vec3_load(patches->origin + 3 * patch));
    hpr_vec3 across = hpr_cross(edge1, edge2);
    double square = hpr_dot(across, across);
    *s = hpr_dot(hpr_cross(offset, edge2), across) / square;
    *t = hpr_dot(hpr_cross(edge1, offset), across) / square;
}
