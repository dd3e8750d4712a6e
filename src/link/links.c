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
    hpr_release(ctx, links->note);
    hpr_release(ctx, links->block);
    hpr_release(ctx, links->row);
    hpr_release(ctx, links->row_link);
    hpr_release(ctx, links);
    *out = NULL;
}

size_t hpr_link_size(const hpr_links *links, const hpr_link *link)
{
    return hpr_tree_count(links->tree, link->recv, link->recv_degree) *
           hpr_tree_count(links->tree, link->send, link->send_degree);
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

/* One end of a link. */
typedef struct link_end {
    size_t node, count;
    int degree;
} link_end;

static link_end end_of(const hpr_tree *tree, size_t node, int degree)
{
    return (link_end){node, hpr_tree_count(tree, node, degree), degree};
}

/* to += block from, or blockT from if the receiver of the link is the one that sends here. */
static void carry(const hpr_links *links, const hpr_link *link, bool forward, size_t channels,
                  const double *radiosity, double *irradiance)
{
    const hpr_tree *tree = links->tree;
    const double *block = links->block + link->offset;
    link_end recv = end_of(tree, link->recv, link->recv_degree),
             send = end_of(tree, link->send, link->send_degree);
    link_end from = forward ? send : recv, to = forward ? recv : send;
    double stretch = link->partly ? hpr_tree_stretch(tree, from.node) * hpr_tree_stretch(tree, to.node) : 1;
    for (size_t c = 0; c < channels; c++) {
        double room[HPR_MAX_BASIS], sum[HPR_MAX_BASIS];
        const double *sent =
            hpr_tree_take(tree, from.node, from.degree, radiosity + c * tree->dof_count, room);
        memset(sum, 0, to.count * sizeof *sum);
        if (forward)
            add_rows(block, recv.count, send.count, sent, sum);
        else
            add_columns(block, recv.count, send.count, sent, sum);
        for (size_t k = 0; k < to.count && stretch != 1; k++)
            sum[k] *= stretch;
        hpr_tree_add(tree, to.node, to.degree, sum, irradiance + c * tree->dof_count);
    }
}

void hpr_links_gather(const hpr_links *links, size_t node, size_t channels, const double *radiosity,
                      double *irradiance)
{
    const hpr_tree *tree = links->tree;
    size_t room = hpr_tree_room(tree, node);
    for (size_t c = 0; c < channels; c++)
        memset(irradiance + c * tree->dof_count + tree->dof[node], 0, room * sizeof *irradiance);
    for (size_t r = links->row[node]; r < links->row[node + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        carry(links, link, link->recv == node, channels, radiosity, irradiance);
    }
}

void hpr_links_scatter(const hpr_links *links, size_t node, size_t channels, const double *radiosity,
                       double *irradiance, bool *reached)
{
    const uint32_t *patch = links->tree->elements->patch;
    for (size_t r = links->row[node]; r < links->row[node + 1]; r++) {
        const hpr_link *link = &links->link[links->row_link[r]];
        bool forward = link->send == node;
        reached[patch[forward ? link->recv : link->send]] = true;
        carry(links, link, forward, channels, radiosity, irradiance);
    }
}
