#include "baseline/factors.h"

#include "baseline/hemicube.h"
#include "baseline/raycast.h"
#include "link/form_factors.h"
#include "patch/rows_build.h"

#include <string.h>

/* Leaves as patches of their own. */
static hpr_status copy_leaves(const hpr_patches *patches, const hpr_elements *e, hpr_patches **out)
{
    hpr_status status = hpr_patches_create(patches->context, e->leaf_count, 1, out);
    if (status != HPR_OK)
        return status;
    hpr_patches *leaves = *out;
    leaves->weld_m = patches->weld_m;
    for (size_t i = 0; i < e->leaf_count; i++) {
        size_t node = e->leaf[i], patch = e->patch[node];
        leaves->shape[i] = patches->shape[patch];
        leaves->twin[i] = leaves->material[i] = HPR_NONE;
        leaves->area_m2[i] = e->area_m2[node];
        memcpy(leaves->origin + 3 * i, e->origin + 3 * node, 3 * sizeof(double));
        memcpy(leaves->edge1 + 3 * i, e->edge1 + 3 * node, 3 * sizeof(double));
        memcpy(leaves->edge2 + 3 * i, e->edge2 + 3 * node, 3 * sizeof(double));
        memcpy(leaves->opposite + 2 * i, e->opposite + 2 * node, 2 * sizeof(double));
        memcpy(leaves->normal + 3 * i, patches->normal + 3 * patch, 3 * sizeof(double));
    }
    return HPR_OK;
}

/* One row for each leaf; leaves of one patch do not see each other. */
static hpr_status make_rows(const hpr_patches *patches, const hpr_elements *e, hpr_rows **out)
{
    hpr_context *ctx = patches->context;
    hpr_rows *rows = NULL;
    size_t count = e->leaf_count;
    hpr_status status = hpr_rows_create(ctx, count, &rows);
    if (status == HPR_OK)
        status = copy_leaves(patches, e, &rows->patches);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->patch_row, count, sizeof *rows->patch_row, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->patch_surface, count, sizeof *rows->patch_surface, "rows");
    if (status == HPR_OK) {
        for (size_t i = 0; i < count; i++) {
            rows->row[i].area_m2 = e->area_m2[e->leaf[i]];
            rows->patch_row[i] = (uint32_t)i;
            rows->patch_surface[i] = e->patch[e->leaf[i]];
        }
        status = hpr_rows_index(rows);
    }
    if (status != HPR_OK)
        hpr_rows_destroy(&rows);
    *out = rows;
    return status;
}

static hpr_status exact_factors(const hpr_rows *rows, double tolerance, double *factor,
                                hpr_factors_done *done)
{
    static const double default_tolerance = 1e-6;
    hpr_form_factors *factors = NULL;
    hpr_status status =
        hpr_form_factors_create(rows, tolerance > 0 ? tolerance : default_tolerance, &factors);
    for (size_t i = 0; status == HPR_OK && i < rows->count; i++)
        hpr_form_factors_row(factors, i, factor + i * rows->count);
    if (status == HPR_OK) {
        done->short_count = factors->done.short_count;
        done->blocked = factors->done.blocked_count > 0;
    }
    hpr_form_factors_destroy(&factors);
    return status;
}

hpr_status hpr_baseline_factors(const hpr_patches *patches, const hpr_elements *elements,
                                const hpr_solve_options *options, const hpr_baseline_options *baseline,
                                double *factor, hpr_factors_done *done)
{
    *done = (hpr_factors_done){0};
    hpr_rows *rows = NULL;
    hpr_status status;
    if (options->method == HPR_METHOD_HEMICUBE) {
        status = hpr_hemicube_factors(patches, elements, baseline->hemicube, factor);
    } else {
        status = make_rows(patches, elements, &rows);
        if (status == HPR_OK && options->method == HPR_METHOD_RAYCAST)
            status = hpr_raycast_factors(rows, baseline->rays, factor, &done->blocked);
        else if (status == HPR_OK)
            status = exact_factors(rows, options->block_tolerance, factor, done);
    }
    hpr_rows_destroy(&rows);
    size_t count = elements->leaf_count;
    for (size_t k = 0; status == HPR_OK && k < count * count; k++)
        done->pair_count += factor[k] != 0;
    return status;
}
