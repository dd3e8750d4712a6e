#include "patch/rows_build.h"

void hpr_rows_destroy(hpr_rows **out)
{
    hpr_rows *rows = *out;
    if (!rows)
        return;
    hpr_context *ctx = rows->context;
    for (size_t i = 0; rows->row && i < rows->count; i++)
        hpr_release(ctx, rows->row[i].name);
    void *arrays[] = {rows->row, rows->patch_row, rows->patch_surface, rows->first, rows->member, rows->mask};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_patches_destroy(&rows->patches);
    hpr_release(ctx, rows);
    *out = NULL;
}

hpr_status hpr_rows_create(hpr_context *ctx, size_t count, hpr_rows **out)
{
    hpr_rows *rows = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &rows, 1, sizeof *rows, "rows");
    if (status != HPR_OK)
        return status;
    rows->context = ctx;
    rows->count = count;
    status = hpr_allocate_into(ctx, &rows->row, count, sizeof *rows->row, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->first, count + 1, sizeof *rows->first, "rows");
    if (status != HPR_OK)
        hpr_rows_destroy(&rows);
    *out = rows;
    return status;
}

hpr_status hpr_rows_name(hpr_rows *rows, size_t row, const char *name)
{
    rows->row[row].name = hpr_duplicate_text(rows->context, name);
    return rows->row[row].name ? HPR_OK : hpr_fail(rows->context, HPR_ERR_MEMORY, "out of memory for rows");
}

hpr_status hpr_rows_index(hpr_rows *rows)
{
    size_t *next = NULL, patch_count = rows->patches->count;
    hpr_status status = hpr_allocate_into(rows->context, &next, rows->count, sizeof *next, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(rows->context, &rows->member, patch_count, sizeof *rows->member, "rows");
    if (status == HPR_OK) {
        for (size_t p = 0; p < patch_count; p++) {
            if (rows->patch_row[p] != HPR_NONE)
                rows->first[rows->patch_row[p] + 1]++;
        }
        for (size_t i = 0; i < rows->count; i++) {
            next[i] = rows->first[i];
            rows->first[i + 1] += rows->first[i];
        }
        for (size_t p = 0; p < patch_count; p++) {
            if (rows->patch_row[p] != HPR_NONE)
                rows->member[next[rows->patch_row[p]]++] = (uint32_t)p;
        }
    }
    hpr_release(rows->context, next);
    return status;
}

uint32_t hpr_rows_composite(const hpr_rows *rows)
{
    for (uint32_t i = 0; i < rows->count; i++) {
        size_t members = rows->first[i + 1] - rows->first[i];
        if (members != 1 && !(members == 0 && rows->row[i].area_m2 == 0))
            return i;
    }
    return rows->mask_count ? rows->mask[0].base_row : HPR_NONE;
}
