#include "visibility/occluders.h"

#include "patch/weld.h"

#include <stdlib.h>
#include <string.h>

/* A polygon on its way to an occluder. */
typedef struct polygon {
    int count; /* 0: merged into another or left out */
    bool merged;
    uint32_t vertex[HPR_OCCLUDER_CORNERS]; /* welded */
    hpr_vec3 normal;
    double drift; /* no point of the patches in it is farther than this from it */
} polygon;

/* Polygons in an order of their own. */
typedef struct sort_key {
    double value;
    uint32_t polygon;
} sort_key;

typedef struct merger {
    hpr_context *context;
    const hpr_patches *patches;
    const uint32_t *listed;
    double slack;
    size_t count;
    polygon *polygons;
    double *position; /* [4 count][3] */
    uint32_t *id;     /* [4 count] welded */
    size_t *first;    /* [4 count + 1] into around */
    uint32_t *number; /* [4 count] polygons around each vertex */
    uint32_t *around; /* those polygons */
    sort_key *keys;   /* [count] */
} merger;

/* Along no plane, edge or diagonal that is likely to occur. */
static const hpr_vec3 skew = {0.2887, 0.6173, 0.4391};

static hpr_vec3 place(const merger *m, uint32_t vertex)
{
    return hpr_vec3_load(m->position + 3 * (size_t)vertex);
}

static void set_polygon(merger *m, size_t p)
{
    polygon *it = &m->polygons[p];
    it->count = m->patches->shape[m->listed[p]] == HPR_SHAPE_TRIANGLE ? 3 : 4;
    it->normal = hpr_vec3_load(m->patches->normal + 3 * (size_t)m->listed[p]);
    for (int k = 0; k < it->count; k++) {
        uint32_t own = (uint32_t)(4 * p) + (uint32_t)k;
        it->vertex[k] = m->id[own];
        it->drift = fmax(it->drift, hpr_length(hpr_sub(place(m, own), place(m, it->vertex[k]))));
    }
}

/* Welding made two of its corners one: it is left as it is. */
static bool is_sliver(const polygon *it)
{
    for (int k = 0; k < it->count; k++) {
        for (int i = 0; i < k; i++) {
            if (it->vertex[i] == it->vertex[k])
                return true;
        }
    }
    return false;
}

/* Which polygons meet at each vertex. */
static void index_vertices(merger *m)
{
    for (size_t p = 0; p < m->count; p++) {
        for (int k = 0; k < m->polygons[p].count && !is_sliver(&m->polygons[p]); k++)
            m->first[m->polygons[p].vertex[k] + 1]++;
    }
    for (size_t v = 0; v < 4 * m->count; v++)
        m->first[v + 1] += m->first[v];
    for (size_t p = 0; p < m->count; p++) {
        for (int k = 0; k < m->polygons[p].count && !is_sliver(&m->polygons[p]); k++) {
            uint32_t v = m->polygons[p].vertex[k];
            m->around[m->first[v] + m->number[v]++] = (uint32_t)p;
        }
    }
}

static void forget(merger *m, uint32_t vertex, uint32_t p)
{
    uint32_t *list = m->around + m->first[vertex], last = m->number[vertex];
    for (uint32_t i = 0; i < last; i++) {
        if (list[i] == p) {
            memmove(list + i, list + i + 1, (last - i - 1) * sizeof *list);
            m->number[vertex]--;
            return;
        }
    }
}

static bool has_vertex(const polygon *it, uint32_t vertex)
{
    for (int k = 0; k < it->count; k++) {
        if (it->vertex[k] == vertex)
            return true;
    }
    return false;
}

/* Twice the area as a vector (Newell). */
static hpr_vec3 area_vector(const merger *m, const uint32_t *vertex, int count)
{
    hpr_vec3 sum = {0, 0, 0}, origin = place(m, vertex[0]);
    for (int k = 1; k + 1 < count; k++)
        sum = hpr_add(
            sum, hpr_cross(hpr_sub(place(m, vertex[k]), origin), hpr_sub(place(m, vertex[k + 1]), origin)));
    return sum;
}

/* Takes corner `k` out of a loop unless the loop is strictly convex there. *moved: how far it was off the
 * line between its neighbours; too far if the loop is not convex at all. */
static void straighten(const merger *m, uint32_t *vertex, int *count, int k, hpr_vec3 normal, double *moved)
{
    hpr_vec3 before = place(m, vertex[(k + *count - 1) % *count]), after = place(m, vertex[(k + 1) % *count]);
    hpr_vec3 across = hpr_cross(hpr_sub(after, before), hpr_sub(place(m, vertex[k]), before));
    double inside = hpr_dot(across, normal) / hpr_length(hpr_sub(after, before));
    if (inside < -m->slack)
        return;
    *moved = fmax(*moved, fabs(inside));
    memmove(vertex + k, vertex + k + 1, (size_t)(*count - k - 1) * sizeof *vertex);
    --*count;
}

static double farthest_from_plane(const merger *m, const polygon *plane, const polygon *of)
{
    double farthest = 0;
    hpr_vec3 origin = place(m, plane->vertex[0]);
    for (int k = 0; k < of->count; k++)
        farthest = fmax(farthest, fabs(hpr_dot(plane->normal, hpr_sub(place(m, of->vertex[k]), origin))));
    return farthest;
}

/* The union of two polygons across edge `side` of the first; false if they do not share it or the union is
 * not convex, not planar or too large. */
static bool unite(const merger *m, const polygon *a, int side, const polygon *b, polygon *whole)
{
    uint32_t loop[2 * HPR_OCCLUDER_CORNERS], from = a->vertex[side], to = a->vertex[(side + 1) % a->count];
    bool turned = hpr_dot(a->normal, b->normal) < 0;
    int count = 0, start = -1;
    for (int k = 0; k < b->count; k++) {
        /* b must run along the edge the other way, seen from a's front */
        uint32_t next = b->vertex[(k + (turned ? b->count - 1 : 1)) % b->count];
        if (b->vertex[k] == to && next == from)
            start = k;
    }
    if (start < 0)
        return false;
    for (int k = 0; k < a->count; k++) /* to ... from */
        loop[count++] = a->vertex[(side + 1 + k) % a->count];
    for (int k = 2; k < b->count; k++) /* behind from ... before to */
        loop[count++] = b->vertex[(start + (turned ? b->count - k : k)) % b->count];
    hpr_vec3 area = area_vector(m, loop, count);
    *whole = (polygon){.merged = true, .normal = hpr_scale(area, 1 / hpr_length(area))};
    if (!(hpr_dot(whole->normal, a->normal) > 0))
        return false;
    double moved = 0;
    straighten(m, loop, &count, a->count - 1, whole->normal, &moved);
    straighten(m, loop, &count, 0, whole->normal, &moved);
    if (count > HPR_OCCLUDER_CORNERS)
        return false;
    whole->count = count;
    memcpy(whole->vertex, loop, (size_t)count * sizeof *loop);
    moved += fmax(farthest_from_plane(m, whole, a), farthest_from_plane(m, whole, b));
    whole->drift = fmax(a->drift, b->drift) + moved;
    return whole->drift <= m->slack;
}

/* The neighbour whose union with p has the fewest corners; p itself if there is none. */
static uint32_t best_mate(const merger *m, uint32_t p, polygon *best)
{
    const polygon *it = &m->polygons[p];
    uint32_t mate = p;
    best->count = HPR_OCCLUDER_CORNERS + 1;
    for (int side = 0; side < it->count; side++) {
        uint32_t v = it->vertex[side], w = it->vertex[(side + 1) % it->count];
        for (uint32_t i = 0; i < m->number[v]; i++) {
            uint32_t q = m->around[m->first[v] + i];
            polygon whole;
            if (q != p && has_vertex(&m->polygons[q], w) && unite(m, it, side, &m->polygons[q], &whole) &&
                whole.count < best->count) {
                *best = whole;
                mate = q;
            }
        }
    }
    return mate;
}

/* Merges p with its neighbours for as long as one fits. */
static void grow(merger *m, uint32_t p)
{
    polygon whole;
    for (uint32_t mate = best_mate(m, p, &whole); mate != p; mate = best_mate(m, p, &whole)) {
        uint32_t low = mate < p ? mate : p, pair[2] = {p, mate};
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < m->polygons[pair[i]].count; k++)
                forget(m, m->polygons[pair[i]].vertex[k], pair[i]);
            m->polygons[pair[i]].count = 0;
        }
        /* both were listed at every corner that is left, so there is room */
        for (int k = 0; k < whole.count; k++)
            m->around[m->first[whole.vertex[k]] + m->number[whole.vertex[k]]++] = low;
        m->polygons[low] = whole;
        p = low;
    }
}

static int compare_keys(const void *left, const void *right)
{
    const sort_key *a = left, *b = right;
    if (a->value != b->value)
        return a->value < b->value ? -1 : 1;
    return a->polygon < b->polygon ? -1 : a->polygon > b->polygon;
}

/* Starts at the outermost polygons along a skew direction: what is left over then stays in one piece, however
 * the patches are numbered. */
static void grow_all(merger *m)
{
    for (size_t p = 0; p < m->count; p++) {
        hpr_vec3 sum = {0, 0, 0};
        for (int k = 0; k < m->polygons[p].count; k++)
            sum = hpr_add(sum, hpr_scale(place(m, m->polygons[p].vertex[k]), 1.0 / m->polygons[p].count));
        m->keys[p] = (sort_key){hpr_dot(skew, sum), (uint32_t)p};
    }
    qsort(m->keys, m->count, sizeof *m->keys, compare_keys);
    for (size_t i = 0; i < m->count; i++) {
        uint32_t p = m->keys[i].polygon;
        if (m->polygons[p].count && !is_sliver(&m->polygons[p]))
            grow(m, p);
    }
}

/* All of b lies in a, which is convex. */
static bool contains(const merger *m, const polygon *a, const polygon *b)
{
    if (farthest_from_plane(m, a, b) > m->slack)
        return false;
    for (int k = 0; k < a->count; k++) {
        hpr_vec3 from = place(m, a->vertex[k]), edge = hpr_sub(place(m, a->vertex[(k + 1) % a->count]), from);
        hpr_vec3 inward = hpr_cross(a->normal, edge);
        double limit = -m->slack * hpr_length(edge);
        for (int i = 0; i < b->count; i++) {
            if (hpr_dot(inward, hpr_sub(place(m, b->vertex[i]), from)) < limit)
                return false;
        }
    }
    return true;
}

/* One number per plane, whichever way its normal points: equal planes have nearly equal ones. */
static size_t make_keys(merger *m)
{
    double centre[3], size = hpr_patches_radius(m->patches, centre);
    size_t count = 0;
    for (size_t p = 0; p < m->count; p++) {
        const polygon *it = &m->polygons[p];
        if (!it->count)
            continue;
        hpr_vec3 offset = hpr_sub(place(m, it->vertex[0]), hpr_vec3_load(centre));
        double distance = size > 0 ? hpr_dot(it->normal, offset) / size : 0;
        m->keys[count++] = (sort_key){fabs(hpr_dot(skew, it->normal) + 0.5857 * distance), (uint32_t)p};
    }
    qsort(m->keys, count, sizeof *m->keys, compare_keys);
    return count;
}

/* Leaves out what lies within another polygon; of equal ones the first stays. */
static void drop_contained(merger *m)
{
    static const double key_slack = 1e-9;
    size_t count = make_keys(m);
    for (size_t i = 0; i < count; i++) {
        for (size_t j = i + 1; j < count && m->keys[j].value <= m->keys[i].value + key_slack; j++) {
            uint32_t p = m->keys[i].polygon, q = m->keys[j].polygon;
            uint32_t low = p < q ? p : q, high = p < q ? q : p;
            polygon *a = &m->polygons[low], *b = &m->polygons[high];
            if (a->count && b->count && contains(m, a, b))
                b->count = 0;
            else if (a->count && b->count && contains(m, b, a))
                a->count = 0;
        }
    }
}

static hpr_status allocate(merger *m)
{
    hpr_context *ctx = m->context;
    size_t corners = 4 * m->count;
    const struct {
        void *array; /* address of the pointer */
        size_t count, item_bytes;
    } columns[] = {
        {&m->polygons, m->count, sizeof *m->polygons},
        {&m->position, 3 * corners, sizeof *m->position},
        {&m->id, corners, sizeof *m->id},
        {&m->first, corners + 1, sizeof *m->first},
        {&m->number, corners, sizeof *m->number},
        {&m->around, corners, sizeof *m->around},
        {&m->keys, m->count, sizeof *m->keys},
    };
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < sizeof columns / sizeof *columns; i++)
        status =
            hpr_allocate_into(ctx, columns[i].array, columns[i].count, columns[i].item_bytes, "occluders");
    return status;
}

static void release(merger *m)
{
    void *arrays[] = {m->polygons, m->position, m->id, m->first, m->number, m->around, m->keys};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(m->context, arrays[i]);
}

static hpr_status merge(merger *m)
{
    for (size_t p = 0; p < m->count; p++) {
        double corner[4][3];
        size_t count = hpr_patch_corners(m->patches, m->listed[p], corner);
        memcpy(m->position + 12 * p, corner, sizeof corner);
        if (count == 3) /* no vertex of its own */
            memcpy(m->position + 12 * p + 9, corner[0], sizeof corner[0]);
    }
    /* The fourth corner of a parallelogram that was merged from triangles is off its vertex by as much as
     * vertices are welded over: taken as one with it, so that no light gets through between two faces. */
    double one = fmax(m->slack / 2, 1.5 * m->patches->weld_m);
    hpr_status status = hpr_weld(m->context, m->position, 4 * m->count, one, m->id);
    if (status != HPR_OK)
        return status;
    for (size_t p = 0; p < m->count; p++)
        set_polygon(m, p);
    index_vertices(m);
    grow_all(m);
    drop_contained(m);
    return HPR_OK;
}

static void store(const merger *m, size_t p, hpr_convex *outline, hpr_occluder_plane *plane)
{
    const polygon *it = &m->polygons[p];
    outline->count = it->count;
    for (int k = 0; k < it->count; k++)
        outline->corner[k] = place(m, it->vertex[k]);
    hpr_vec3_store(plane->normal, it->normal);
    hpr_vec3_store(plane->origin, it->merged ? outline->corner[0] : place(m, (uint32_t)(4 * p)));
}

hpr_status hpr_occluders_merge(const hpr_patches *patches, const uint32_t *listed, size_t listed_count,
                               double slack, hpr_convex **outline, hpr_occluder_plane **plane,
                               size_t *occluder_count)
{
    merger m = {.context = patches->context,
                .patches = patches,
                .listed = listed,
                .slack = slack,
                .count = listed_count};
    size_t kept = 0;
    *outline = NULL;
    *plane = NULL;
    hpr_status status = allocate(&m);
    if (status == HPR_OK)
        status = merge(&m);
    for (size_t p = 0; status == HPR_OK && p < m.count; p++)
        kept += m.polygons[p].count > 0;
    if (status == HPR_OK)
        status = hpr_allocate_into(m.context, outline, kept, sizeof **outline, "occluders");
    if (status == HPR_OK)
        status = hpr_allocate_into(m.context, plane, kept, sizeof **plane, "occluders");
    *occluder_count = 0;
    for (size_t p = 0; status == HPR_OK && p < m.count; p++) {
        if (m.polygons[p].count) {
            store(&m, p, &(*outline)[*occluder_count], &(*plane)[*occluder_count]);
            ++*occluder_count;
        }
    }
    release(&m);
    return status;
}
