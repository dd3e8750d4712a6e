#include "link/shut.h"

#include <math.h>
#include <omp.h>

enum { DIRECTIONS = 64 };

size_t hpr_region_at(const hpr_region *region, const size_t *first, size_t patch, double s, double t)
{
    size_t end = first[patch + 1] - 1;
    for (size_t i = first[patch]; i < end; i++) {
        if (hpr_polygon_holds(&region[i].outline, s, t))
            return i;
    }
    return end;
}

/* Number of what a ray sees: a region, `nothing` for the back of a patch, `outside`. */
static uint32_t look(const hpr_visibility *visibility, double slack, const hpr_region *region,
                     const size_t *first, const double from[3], const double direction[3], uint32_t nothing,
                     uint32_t outside)
{
    bool back = false;
    hpr_hit hit = hpr_visibility_first_hit(visibility, from, direction, slack, INFINITY, false, &back);
    if (hit.patch == HPR_NONE)
        return outside;
    return back ? nothing : (uint32_t)hpr_region_at(region, first, hit.patch, hit.s, hit.t);
}

/* What the middle of a region sees, [DIRECTIONS]. */
static void look_around(const hpr_visibility *visibility, double slack, const hpr_region *all,
                        const size_t *first, size_t index, uint32_t *seen)
{
    static const double golden = 2.39996322972865332;
    const hpr_patches *patches = hpr_visibility_patches(visibility);
    const hpr_region *region = &all[index];
    size_t p = 3 * (size_t)region->patch;
    hpr_vec3 n = hpr_vec3_load(patches->normal + p), e1 = hpr_vec3_load(patches->edge1 + p);
    hpr_vec3 x = hpr_vec3_load(patches->origin + p), e2 = hpr_vec3_load(patches->edge2 + p);
    for (int i = 0; i < region->outline.count; i++) {
        const double *corner = region->outline.corner[i];
        x = hpr_madd(x, corner[0] / region->outline.count, e1);
        x = hpr_madd(x, corner[1] / region->outline.count, e2);
    }
    hpr_vec3 u = hpr_scale(e1, 1 / hpr_length(e1)), v = hpr_cross(n, u);
    uint32_t outside = (uint32_t)first[patches->count];
    double from[3], direction[3];
    hpr_vec3_store(from, x);
    for (int i = 0; i < DIRECTIONS; i++) {
        double square = (i + 0.5) / DIRECTIONS, radius = sqrt(square);
        hpr_vec3 d = hpr_madd(hpr_scale(n, sqrt(1 - square)), radius * cos(i * golden), u);
        hpr_vec3_store(direction, hpr_madd(d, radius * sin(i * golden), v));
        seen[i] = look(visibility, slack, all, first, from, direction, (uint32_t)index, outside);
    }
}

/* The representative of a space. */
static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void unite(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    parent[a > b ? a : b] = a < b ? a : b;
}

static bool shines(const hpr_patches *patches, size_t patch)
{
    for (size_t c = 0; c < patches->channel_count; c++) {
        if (patches->exitance[patches->channel_count * patch + c] > 0)
            return true;
    }
    return false;
}

/* Region i sees region j, or the outside: one space, and with light if one of them shines on the other. */
static void connect(const hpr_patches *patches, const hpr_region *region, uint32_t *parent, uint32_t i,
                    uint32_t j, uint32_t outside)
{
    unite(parent, i, j);
    if (i != j && j != outside && (shines(patches, region[i].patch) || shines(patches, region[j].patch)))
        unite(parent, i, outside);
}

static bool sees_only_backs(const uint32_t *seen, size_t i)
{
    bool only = true;
    for (size_t k = 0; only && k < DIRECTIONS; k++)
        only = seen[i * DIRECTIONS + k] == i;
    return only;
}

/* What stands on something covers it, and is covered by it. */
static void cover(hpr_region *region, const size_t *first, size_t count, const uint32_t *seen)
{
    for (size_t i = 0; i < count; i++) {
        if (region[i].covered || region[i].against == HPR_NONE)
            continue;
        size_t other =
            hpr_region_at(region, first, region[i].against, region[i].against_at[0], region[i].against_at[1]);
        region[i].covered = sees_only_backs(seen, i) || sees_only_backs(seen, other);
    }
}

hpr_status hpr_regions_shut(const hpr_visibility *visibility, double slack, hpr_region *region,
                            const size_t *first)
{
    const hpr_patches *patches = hpr_visibility_patches(visibility);
    hpr_context *ctx = patches->context;
    size_t count = first[patches->count];
    uint32_t *parent = NULL, *seen = NULL; /* [count + 1], the last is the outside; [count][DIRECTIONS] */
    hpr_status status = hpr_allocate_into(ctx, &parent, count + 1, sizeof *parent, "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &seen, count * DIRECTIONS, sizeof *seen, "covered elements");
    if (status != HPR_OK)
        goto done;
    for (uint32_t i = 0; i <= count; i++)
        parent[i] = i;
#pragma omp parallel for schedule(dynamic, 16) num_threads(hpr_context_threads(ctx))
    for (size_t i = 0; i < count; i++) {
        look_around(visibility, slack, region, first, i, seen + i * DIRECTIONS);
    }
    cover(region, first, count, seen);
    for (uint32_t i = 0; i < count; i++) {
        for (size_t k = 0; k < DIRECTIONS && !region[i].covered; k++)
            connect(patches, region, parent, i, seen[i * DIRECTIONS + k], (uint32_t)count);
    }
    for (uint32_t i = 0; i < count; i++)
        region[i].shut = region[i].covered || root_of(parent, i) != root_of(parent, (uint32_t)count);
done:
    hpr_release(ctx, parent);
    hpr_release(ctx, seen);
    return status;
}
