/* From a scene to rows: one for each patch. */
#include "patch/rows_build.h"

#include <stdlib.h>

typedef struct place {
    uint32_t node, primitive, patch;
} place;

static int compare(uint32_t a, uint32_t b)
{
    return a < b ? -1 : a > b;
}

static int compare_places(const void *left, const void *right)
{
    const place *a = left, *b = right;
    int order = compare(a->node, b->node);
    if (!order)
        order = compare(a->primitive, b->primitive);
    return order ? order : compare(a->patch, b->patch);
}

static const char *mesh_name(const hpr_scene *scene, const place *p)
{
    for (size_t m = 0; m < scene->mesh_count; m++) {
        if (scene->mesh_node[m] == p->node && scene->mesh_primitive[m] == p->primitive)
            return scene->mesh_name[m];
    }
    return "";
}

static hpr_status describe(hpr_rows *rows, size_t i, const hpr_scene *scene, const place *p)
{
    const hpr_patches *patches = rows->patches;
    hpr_row *row = &rows->row[i];
    double reflectance = 0;
    for (size_t c = 0; c < patches->channel_count; c++)
        reflectance += patches->reflectance[patches->channel_count * p->patch + c];
    row->node = p->node;
    row->primitive = p->primitive;
    row->back = patches->side[p->patch] != 0;
    row->area_m2 = patches->area_m2[p->patch];
    row->emissivity = 1 - reflectance / (double)patches->channel_count;
    rows->patch_row[p->patch] = (uint32_t)i;
    rows->patch_surface[p->patch] = p->patch;
    return hpr_rows_name(rows, i, mesh_name(scene, p));
}

static hpr_status fill(hpr_rows *rows, const hpr_scene *scene, place *places)
{
    hpr_context *ctx = rows->context;
    size_t n = rows->count;
    hpr_status status = hpr_allocate_into(ctx, &rows->patch_row, n, sizeof *rows->patch_row, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->patch_surface, n, sizeof *rows->patch_surface, "rows");
    if (status != HPR_OK)
        return status;
    for (uint32_t p = 0; p < n; p++)
        places[p] = (place){rows->patches->node[p], rows->patches->primitive[p], p};
    qsort(places, n, sizeof *places, compare_places);
    for (size_t i = 0; status == HPR_OK && i < n; i++)
        status = describe(rows, i, scene, &places[i]);
    return status == HPR_OK ? hpr_rows_index(rows) : status;
}

hpr_status hpr_rows_of_scene(const hpr_scene *scene, hpr_rows **out)
{
    hpr_context *ctx = scene->context;
    hpr_patches *patches = NULL;
    hpr_rows *rows = NULL;
    place *places = NULL;
    *out = NULL;
    hpr_status status = hpr_patches_build_all(scene, &patches);
    if (status == HPR_OK)
        status = hpr_rows_create(ctx, patches->count, &rows);
    if (status == HPR_OK) {
        rows->patches = patches;
        patches = NULL;
        status = hpr_allocate_into(ctx, &places, rows->count, sizeof *places, "rows");
    }
    if (status == HPR_OK)
        status = fill(rows, scene, places);
    hpr_release(ctx, places);
    hpr_patches_destroy(&patches);
    if (status != HPR_OK)
        hpr_rows_destroy(&rows);
    *out = rows;
    return status;
}
