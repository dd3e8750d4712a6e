#include "link/links.h"

#include <string.h>

void hpr_links_destroy(hpr_links **out)
{
    hpr_links *links = *out;
    if (!links)
        return;
    hpr_context *ctx = links->context;
    hpr_release(ctx, links->link);
    hpr_release(ctx, links->block);
    hpr_release(ctx, links->row);
    hpr_release(ctx, links->row_link);
    hpr_release(ctx, links);
    *out = NULL;
}

static size_t first_dof(const hpr_elements *elements, size_t patch)
{
    return elements->dof[elements->patch_leaf[patch]];
}

size_t hpr_link_block(const hpr_links *links, const hpr_link *link, size_t leaf_i, size_t leaf_j)
{
    const hpr_elements *e = links->elements;
    size_t send_dofs = first_dof(e, link->send + 1u) - first_dof(e, link->send);
    size_t n_i = e->dof[leaf_i + 1] - e->dof[leaf_i];
    return link->offset + (e->dof[leaf_i] - first_dof(e, link->recv)) * send_dofs +
           n_i * (e->dof[leaf_j] - first_dof(e, link->send));
}

/* H += K B, K row-major [rows][columns]. */
static void apply(const double *block, size_t rows, size_t columns, size_t channels, const double *radiosity,
                  double *irradiance)
{
    for (size_t k = 0; k < rows; k++) {
        for (size_t l = 0; l < columns; l++) {
            for (size_t c = 0; c < channels; c++)
                irradiance[k * channels + c] += block[k * columns + l] * radiosity[l * channels + c];
        }
    }
}

/* H += KT B, K row-major [columns][rows]. */
static void apply_transposed(const double *block, size_t rows, size_t columns, size_t channels,
                             const double *radiosity, double *irradiance)
{
    for (size_t l = 0; l < columns; l++) {
        for (size_t k = 0; k < rows; k++) {
            for (size_t c = 0; c < channels; c++)
                irradiance[k * channels + c] += block[l * rows + k] * radiosity[l * channels + c];
        }
    }
}

void hpr_links_gather(const hpr_links *links, size_t patch, size_t leaf, size_t channels,
                      const double *radiosity, double *irradiance)
{
    const hpr_elements *e = links->elements;
    size_t rows = e->dof[leaf + 1] - e->dof[leaf];
    memset(irradiance, 0, rows * channels * sizeof *irradiance);
    for (size_t r = links->row[patch]; r < links->row[patch + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        bool transposed = link->send == patch;
        size_t other = transposed ? link->recv : link->send;
        for (size_t j = e->patch_leaf[other]; j < e->patch_leaf[other + 1]; j++) {
            size_t columns = e->dof[j + 1] - e->dof[j];
            const double *b = radiosity + e->dof[j] * channels;
            if (transposed)
                apply_transposed(links->block + hpr_link_block(links, link, j, leaf), rows, columns, channels,
                                 b, irradiance);
            else
                apply(links->block + hpr_link_block(links, link, leaf, j), rows, columns, channels, b,
                      irradiance);
        }
    }
}
