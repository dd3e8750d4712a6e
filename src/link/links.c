#include "link/links.h"

#include <string.h>

void hpr_links_destroy(hpr_links **out)
{
    hpr_links *links = *out;
    if (!links)
        return;
    hpr_context *ctx = links->context;
    hpr_tree_destroy(&links->tree);
    hpr_release(ctx, links->link);
    hpr_release(ctx, links->partly);
    hpr_release(ctx, links->block);
    hpr_release(ctx, links->row);
    hpr_release(ctx, links->row_link);
    hpr_release(ctx, links);
    *out = NULL;
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

/* to [rows] += block [rows x columns] from [columns] */
static void add_rows(const double *block, size_t rows, size_t columns, const double *from, double *to)
{
    for (size_t r = 0; r < rows; r++)
        to[r] += dot(block + r * columns, from, columns);
}

/* to [columns] += blockT from [rows] */
static void add_columns(const double *block, size_t rows, size_t columns, const double *from, double *to)
{
    for (size_t r = 0; r < rows; r++)
        add_scaled(to, from[r], block + r * columns, columns);
}

void hpr_links_gather(const hpr_links *links, size_t node, size_t channels, const double *radiosity,
                      double *irradiance)
{
    const hpr_tree *tree = links->tree;
    size_t own = hpr_tree_count(tree, node), at = tree->dof[node];
    for (size_t c = 0; c < channels; c++)
        memset(irradiance + c * tree->dof_count + at, 0, own * sizeof *irradiance);
    for (size_t r = links->row[node]; r < links->row[node + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        bool receives = link->recv == node;
        size_t other = receives ? link->send : link->recv, count = hpr_tree_count(tree, other);
        const double *block = links->block + link->offset;
        for (size_t c = 0; c < channels; c++) {
            const double *from = radiosity + c * tree->dof_count + tree->dof[other];
            double *to = irradiance + c * tree->dof_count + at;
            if (receives)
                add_rows(block, own, count, from, to);
            else
                add_columns(block, count, own, from, to);
        }
    }
}

void hpr_links_scatter(const hpr_links *links, size_t node, size_t channels, const double *radiosity,
                       double *irradiance, bool *reached)
{
    const hpr_tree *tree = links->tree;
    size_t own = hpr_tree_count(tree, node);
    for (size_t r = links->row[node]; r < links->row[node + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        bool receives = link->recv == node;
        size_t other = receives ? link->send : link->recv, count = hpr_tree_count(tree, other);
        const double *block = links->block + link->offset;
        reached[tree->elements->patch[other]] = true;
        for (size_t c = 0; c < channels; c++) {
            const double *from = radiosity + c * tree->dof_count + tree->dof[node];
            double *to = irradiance + c * tree->dof_count + tree->dof[other];
            if (receives)
                add_columns(block, own, count, from, to);
            else
                add_rows(block, count, own, from, to);
        }
    }
}
