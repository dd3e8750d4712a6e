#include "patch/weld.h"

#include "scene/scene.h"

#include <math.h>
#include <string.h>

double hpr_weld_distance(const double low[3], const double high[3])
{
    double size = 0;
    for (int a = 0; a < 3; a++)
        size = fmax(size, high[a] - low[a]);
    return size > 0 ? 4 * 0x1p-23 * size : 0;
}

/* Representatives by the grid cell that they lie in; open addressing with chains through `next`. */
typedef struct grid {
    const double *position;
    double cell, distance;
    size_t mask;
    uint32_t *bucket; /* [mask + 1] first representative, HPR_NONE */
    uint32_t *next;   /* [vertex_count] */
} grid;

static void cell_of(const grid *grid, const double *p, int64_t cell[3])
{
    for (int a = 0; a < 3; a++)
        cell[a] = (int64_t)floor(p[a] / grid->cell);
}

static size_t bucket_of(const grid *grid, const int64_t cell[3])
{
    uint64_t hash = 0x9E3779B97F4A7C15u;
    for (int a = 0; a < 3; a++)
        hash = (hash ^ (uint64_t)cell[a]) * 0xD6E8FEB86659FD93u, hash ^= hash >> 32;
    return (size_t)hash & grid->mask;
}

static bool near(const grid *grid, uint32_t a, uint32_t b)
{
    const double *p = grid->position + 3 * (size_t)a, *q = grid->position + 3 * (size_t)b;
    double d2 = 0;
    for (int k = 0; k < 3; k++)
        d2 += (p[k] - q[k]) * (p[k] - q[k]);
    return d2 <= grid->distance * grid->distance;
}

/* Lowest representative near `v`, else `v` itself, which then becomes one. */
static uint32_t find(grid *grid, uint32_t v)
{
    int64_t cell[3];
    cell_of(grid, grid->position + 3 * (size_t)v, cell);
    uint32_t best = v;
    for (int i = 0; i < 27; i++) {
        int64_t neighbour[3] = {cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1};
        for (uint32_t r = grid->bucket[bucket_of(grid, neighbour)]; r != HPR_NONE; r = grid->next[r]) {
            if (r < best && near(grid, r, v))
                best = r;
        }
    }
    if (best == v) {
        size_t bucket = bucket_of(grid, cell);
        grid->next[v] = grid->bucket[bucket];
        grid->bucket[bucket] = v;
    }
    return best;
}

hpr_status hpr_weld(hpr_context *ctx, const double *position, size_t count, double distance, uint32_t *id)
{
    size_t buckets = 16;
    while (buckets < 2 * count)
        buckets *= 2;
    grid grid = {
        .position = position, .distance = distance, .cell = distance > 0 ? distance : 1, .mask = buckets - 1};
    hpr_status status = hpr_allocate_into(ctx, &grid.bucket, buckets, sizeof *grid.bucket, "welding");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &grid.next, count, sizeof *grid.next, "welding");
    if (status == HPR_OK) {
        memset(grid.bucket, 0xff, buckets * sizeof *grid.bucket);
        for (size_t v = 0; v < count; v++)
            id[v] = find(&grid, (uint32_t)v);
    }
    hpr_release(ctx, grid.bucket);
    hpr_release(ctx, grid.next);
    return status;
}
