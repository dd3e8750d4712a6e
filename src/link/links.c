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

static size_t patch_dofs(const hpr_elements *elements, size_t patch)
{
    return first_dof(elements, patch + 1) - first_dof(elements, patch);
}

size_t hpr_link_block(const hpr_links *links, const hpr_link *link, size_t leaf_i, size_t leaf_j,
                      size_t *stride)
{
    const hpr_elements *e = links->elements;
    *stride = patch_dofs(e, link->send);
    return link->offset + (e->dof[leaf_i] - first_dof(e, link->recv)) * *stride +
           (e->dof[leaf_j] - first_dof(e, link->send));
}

/* a . b in eight interleaved sums, so that the compiler may use vectors without changing the order. */
static double dot(const double *a, const double *b, size_t count)
{
    double sum[8] = {0};
    size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        for (size_t k = 0; k < 8; k++)
            sum[k] += a[i + k] * b[i + k];
    }
    for (; i < count; i++)
        sum[0] += a[i] * b[i];
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

/* to += factor from */
static void add_scaled(double *restrict to, double factor, const double *restrict from, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] += factor * from[i];
}

/* What the patch receives through links in which it is the receiver: rows of the matrix. */
static void gather_rows(const hpr_links *links, const hpr_link *link, size_t row, size_t row_end,
                        size_t channels, const double *radiosity, double *irradiance)
{
    const hpr_elements *e = links->elements;
    size_t dofs = e->dof[e->leaf_count], columns = patch_dofs(e, link->send), from = first_dof(e, link->send);
    for (size_t r = row; r < row_end; r++) {
        const double *k = links->block + link->offset + (r - first_dof(e, link->recv)) * columns;
        for (size_t c = 0; c < channels; c++)
            irradiance[c * dofs + r] += dot(k, radiosity + c * dofs + from, columns);
    }
}

/* The same where it is the sender: columns of the matrix. */
static void gather_columns(const hpr_links *links, const hpr_link *link, size_t column, size_t column_end,
                           size_t channels, const double *radiosity, double *irradiance)
{
    const hpr_elements *e = links->elements;
    size_t dofs = e->dof[e->leaf_count], columns = patch_dofs(e, link->send), from = first_dof(e, link->recv);
    for (size_t r = 0; r < patch_dofs(e, link->recv); r++) {
        const double *k = links->block + link->offset + r * columns + (column - first_dof(e, link->send));
        for (size_t c = 0; c < channels; c++)
            add_scaled(irradiance + c * dofs + column, radiosity[c * dofs + from + r], k,
                       column_end - column);
    }
}

void hpr_links_gather(const hpr_links *links, size_t patch, size_t leaf, size_t leaf_end, size_t channels,
                      const double *radiosity, double *irradiance)
{
    const hpr_elements *e = links->elements;
    size_t dofs = e->dof[e->leaf_count], low = e->dof[leaf], high = e->dof[leaf_end];
    for (size_t c = 0; c < channels; c++)
        memset(irradiance + c * dofs + low, 0, (high - low) * sizeof *irradiance);
    for (size_t r = links->row[patch]; r < links->row[patch + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        if (link->send == patch)
            gather_columns(links, link, low, high, channels, radiosity, irradiance);
        else
            gather_rows(links, link, low, high, channels, radiosity, irradiance);
    }
}
