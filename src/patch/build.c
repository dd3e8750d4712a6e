/* From a scene's faces to patches: weld, merge, drop what has no area or was there before. */
#include "math/twofold.h"
#include "patch/overlap.h"
#include "patch/paint.h"
#include "patch/weld.h"

#include <stdlib.h>
#include <string.h>

/* A face or a merged pair of faces: corners as vertices of the scene, counter-clockwise. */
typedef struct facet {
    uint32_t vertex[4];     /* [3] = HPR_NONE: triangle */
    uint32_t face, partner; /* partner: the merged second face, or HPR_NONE */
    bool skew;              /* four corners, but no parallelogram */
    bool empty;             /* kept for its place only */
} facet;

typedef struct edge {
    uint32_t low, high; /* welded ids */
    uint32_t face;
} edge;

typedef struct builder {
    const hpr_scene *scene;
    hpr_context *context;
    bool for_factors; /* what is dropped keeps its place, and there are no quadrilaterals */
    double tolerance; /* the weld distance */
    uint32_t *id;     /* [vertex_count] welded */
    edge *edges;      /* sorted; three per triangle */
    size_t edge_count;
    bool *taken; /* [face_count] merged into an earlier face, or degenerate */
    facet *facets;
    size_t facet_count;
    hpr_patches *patches;
} builder;

static hpr_vec3 position(const builder *b, uint32_t vertex)
{
    return hpr_vec3_load(b->scene->position + 3 * (size_t)b->id[vertex]);
}

static bool is_triangle(const builder *b, size_t face)
{
    return b->scene->face_vertex[4 * face + 3] == HPR_NONE;
}

/* No area: two corners are one, or the height is rounding next to the longest edge. */
static bool degenerate(const builder *b, const uint32_t *vertex)
{
    static const double flat = 1e-12;
    hpr_vec3 p = position(b, vertex[0]), q = position(b, vertex[1]), r = position(b, vertex[2]);
    hpr_vec3 e1 = hpr_sub(q, p), e2 = hpr_sub(r, p), e3 = hpr_sub(r, q);
    double longest2 = fmax(fmax(hpr_dot(e1, e1), hpr_dot(e2, e2)), hpr_dot(e3, e3));
    return !(hpr_length(hpr_cross(e1, e2)) > flat * longest2);
}

static int compare_edges(const void *left, const void *right)
{
    const edge *a = left, *b = right;
    if (a->low != b->low)
        return a->low < b->low ? -1 : 1;
    if (a->high != b->high)
        return a->high < b->high ? -1 : 1;
    return a->face < b->face ? -1 : a->face > b->face;
}

static edge edge_of(const builder *b, size_t face, int side)
{
    const uint32_t *vertex = b->scene->face_vertex + 4 * face;
    uint32_t p = b->id[vertex[side]], q = b->id[vertex[(side + 1) % 3]];
    return (edge){p < q ? p : q, p < q ? q : p, (uint32_t)face};
}

static void collect_edges(builder *b)
{
    for (size_t f = 0; f < b->scene->face_count; f++) {
        for (int side = 0; is_triangle(b, f) && !b->taken[f] && side < 3; side++)
            b->edges[b->edge_count++] = edge_of(b, f, side);
    }
    qsort(b->edges, b->edge_count, sizeof *b->edges, compare_edges);
}

/* Is every attribute that the scene interpolates over the facet affine: value2 = value0 + s (value1 - value0)
 * + t (value3 - value0), with (s,t) the parameters of corner 2? */
static bool attributes_affine(const builder *b, const uint32_t v[4], const double opposite[2])
{
    static const double float32_slack = 4 * 0x1p-23;
    const double s = opposite[0], t = opposite[1];
    const hpr_scene *scene = b->scene;
    const struct {
        const double *value;
        size_t width;
    } attribute[] = {{scene->uv, 2}, {scene->colour, scene->channel_count}, {scene->glow_uv, 2}};
    for (size_t i = 0; i < sizeof attribute / sizeof *attribute; i++) {
        size_t n = attribute[i].width;
        for (size_t c = 0; c < n; c++) {
            double a[4], largest = 1;
            int missing = 0;
            for (int k = 0; k < 4; k++) {
                a[k] = attribute[i].value[n * v[k] + c];
                missing += isnan(a[k]);
                largest = fmax(largest, fabs(a[k]));
            }
            double gap = a[0] + a[2] - a[1] - a[3] - (s - 1) * (a[1] - a[0]) - (t - 1) * (a[3] - a[0]);
            if (missing ? missing < 4 : fabs(gap) > float32_slack * largest)
                return false;
        }
    }
    return true;
}

static bool parallelogram(const builder *b, const uint32_t v[4])
{
    hpr_vec3 gap =
        hpr_sub(hpr_add(position(b, v[0]), position(b, v[2])), hpr_add(position(b, v[1]), position(b, v[3])));
    return hpr_length(gap) <= b->tolerance && attributes_affine(b, v, (const double[2]){1, 1});
}

/* Parameters of corner 2 in the plane of the others. Returns its distance to that plane. */
static double find_opposite(const builder *b, const uint32_t v[4], double opposite[2])
{
    hpr_vec3 origin = position(b, v[0]), across = hpr_sub(position(b, v[2]), origin);
    hpr_vec3 edge1 = hpr_sub(position(b, v[1]), origin), edge2 = hpr_sub(position(b, v[3]), origin);
    hpr_vec3 normal = hpr_cross(edge1, edge2);
    double square = hpr_dot(normal, normal);
    opposite[0] = hpr_dot(hpr_cross(across, edge2), normal) / square;
    opposite[1] = hpr_dot(hpr_cross(edge1, across), normal) / square;
    return fabs(hpr_dot(across, normal)) / sqrt(square);
}

/* Strictly convex: the triangles that the diagonals cut off the corners, of areas 1, t, s, s + t - 1 next to
 * s + t of the whole, are more than slivers. */
static bool quadrilateral(const builder *b, const uint32_t v[4])
{
    static const double sliver = 0.02;
    double opposite[2], gap = find_opposite(b, v, opposite), s = opposite[0], t = opposite[1];
    return gap <= b->tolerance && fmin(fmin(1, s), fmin(t, s + t - 1)) >= sliver * (s + t) &&
           attributes_affine(b, v, opposite);
}

/* What two triangles or four corners may be. */
typedef bool outline_test(const builder *b, const uint32_t v[4]);

/* The facet of two triangles that share the first one's edge `side`; false if it does not pass the test. */
static bool merge(const builder *b, size_t face, int side, size_t other, outline_test *passes,
                  uint32_t quad[4])
{
    const uint32_t *v = b->scene->face_vertex + 4 * face, *w = b->scene->face_vertex + 4 * other;
    uint32_t p = b->id[v[side]], q = b->id[v[(side + 1) % 3]];
    for (int k = 0; k < 3; k++) {
        if (b->id[w[k]] != q || b->id[w[(k + 1) % 3]] != p)
            continue; /* the neighbour must run along the edge the other way */
        int count = 0;
        for (int i = 0; i < 3; i++) {
            quad[count++] = v[i];
            if (i == side)
                quad[count++] = w[(k + 2) % 3];
        }
        return passes(b, quad);
    }
    return false;
}

/* The lowest later triangle of the same mesh that makes a facet with `face` that passes, or HPR_NONE. */
static uint32_t find_partner(const builder *b, size_t face, outline_test *passes, uint32_t quad[4])
{
    uint32_t best = HPR_NONE;
    for (int side = 0; side < 3; side++) {
        edge key = edge_of(b, face, side);
        size_t low = 0, high = b->edge_count;
        while (low < high) {
            size_t middle = (low + high) / 2;
            if (compare_edges(&b->edges[middle], &key) <= 0)
                low = middle + 1;
            else
                high = middle;
        }
        for (; low < b->edge_count && b->edges[low].low == key.low && b->edges[low].high == key.high; low++) {
            uint32_t other = b->edges[low].face, candidate[4];
            if (other < best && !b->taken[other] && b->scene->face_mesh[other] == b->scene->face_mesh[face] &&
                merge(b, face, side, other, passes, candidate)) {
                best = other;
                memcpy(quad, candidate, sizeof candidate);
            }
        }
    }
    return best;
}

static facet *add_facet(builder *b, const uint32_t vertex[4], size_t face, uint32_t partner)
{
    facet *f = &b->facets[b->facet_count++];
    memcpy(f->vertex, vertex, sizeof f->vertex);
    f->face = (uint32_t)face;
    f->partner = partner;
    return f;
}

/* Counts a face without area. */
static void drop_face(builder *b, size_t face)
{
    b->patches->degenerate_count++;
    if (b->for_factors)
        add_facet(b, b->scene->face_vertex + 4 * face, face, HPR_NONE)->empty = true;
}

/* A face with four corners stays whole if it is a parallelogram or another convex quadrilateral in a plane,
 * else it falls into two triangles, of which one may have no area. */
static void add_quad(builder *b, size_t face)
{
    const uint32_t *v = b->scene->face_vertex + 4 * face;
    if (!degenerate(b, v) && parallelogram(b, v)) {
        add_facet(b, v, face, HPR_NONE);
        return;
    }
    if (!b->for_factors && !degenerate(b, v) && quadrilateral(b, v)) {
        add_facet(b, v, face, HPR_NONE)->skew = true;
        return;
    }
    uint32_t half[2][4] = {{v[0], v[1], v[2], HPR_NONE}, {v[0], v[2], v[3], HPR_NONE}};
    int added = 0;
    for (int i = 0; i < 2; i++) {
        if (!degenerate(b, half[i])) {
            add_facet(b, half[i], face, HPR_NONE);
            added++;
        }
    }
    if (!added)
        drop_face(b, face);
}

static void collect_facets(builder *b)
{
    for (size_t f = 0; f < b->scene->face_count; f++) {
        const uint32_t *vertex = b->scene->face_vertex + 4 * f;
        b->taken[f] = degenerate(b, vertex) && is_triangle(b, f);
    }
    collect_edges(b);
    for (size_t f = 0; f < b->scene->face_count; f++) {
        uint32_t quad[4];
        if (is_triangle(b, f) && degenerate(b, b->scene->face_vertex + 4 * f)) {
            drop_face(b, f);
            continue;
        }
        if (b->taken[f])
            continue;
        if (!is_triangle(b, f)) {
            add_quad(b, f);
            continue;
        }
        uint32_t partner = find_partner(b, f, parallelogram, quad);
        if (partner != HPR_NONE)
            b->taken[f] = b->taken[partner] = true;
        add_facet(b, partner != HPR_NONE ? quad : b->scene->face_vertex + 4 * f, f, partner);
    }
}

/* Triangles that have found no partner for a parallelogram find one for a quadrilateral. */
static void merge_the_rest(builder *b)
{
    size_t kept = 0;
    for (size_t i = 0; i < b->facet_count; i++) {
        facet f = b->facets[i];
        bool triangle = is_triangle(b, f.face) && f.partner == HPR_NONE;
        if (triangle && b->taken[f.face])
            continue; /* in an earlier one */
        uint32_t partner = triangle ? find_partner(b, f.face, quadrilateral, f.vertex) : HPR_NONE;
        if (partner != HPR_NONE) {
            b->taken[f.face] = b->taken[partner] = true;
            f.partner = partner;
            f.skew = true;
        }
        b->facets[kept++] = f;
    }
    b->facet_count = kept;
}

/* The first face's share of a facet that two triangles make. */
static double first_share(const builder *b, const facet *f)
{
    double area[2];
    if (!f->skew)
        return 0.5;
    for (int i = 0; i < 2; i++) {
        const uint32_t *v = b->scene->face_vertex + 4 * (size_t)(i ? f->partner : f->face);
        hpr_vec3 o = position(b, v[0]);
        area[i] = hpr_length(hpr_cross(hpr_sub(position(b, v[1]), o), hpr_sub(position(b, v[2]), o)));
    }
    return area[0] / (area[0] + area[1]);
}

static void set_optics(const builder *b, const facet *f, size_t i)
{
    const hpr_scene *scene = b->scene;
    hpr_patches *patches = b->patches;
    size_t n = scene->channel_count;
    uint32_t mesh = scene->face_mesh[f->face], material = scene->mesh_material[mesh];
    patches->node[i] = scene->mesh_node[mesh];
    patches->primitive[i] = scene->mesh_primitive[mesh];
    patches->material[i] = material;
    for (size_t c = 0; c < n; c++) {
        double rho = scene->face_reflectance[n * f->face + c],
               radiance = scene->face_radiance[n * f->face + c];
        if (f->partner != HPR_NONE) {
            double share = first_share(b, f), other = scene->face_radiance[n * f->partner + c];
            rho = share * rho + (1 - share) * scene->face_reflectance[n * f->partner + c];
            radiance = other == radiance ? radiance : share * radiance + (1 - share) * other;
        }
        patches->reflectance[n * i + c] = rho;
        patches->exitance[n * i + c] = 3.14159265358979323846 * radiance;
    }
}

/* The corners of a patch at (s,t) = (0,0), (1,0) and (0,1); the back has the last two exchanged. */
typedef struct base {
    uint32_t at[3];
} base;

static base base_of(const facet *f, int side)
{
    uint32_t first = f->vertex[1], second = f->vertex[f->vertex[3] == HPR_NONE ? 2 : 3];
    return (base){{f->vertex[0], side ? second : first, side ? first : second}};
}

/* Texture coordinates, affine in the parameters. */
static void set_map(const double *uv, const base *corners, double map[6])
{
    for (size_t k = 0; k < 3; k++) {
        for (size_t a = 0; a < 2; a++)
            map[2 * k + a] = uv[2 * corners->at[k] + a] - (k ? uv[2 * corners->at[0] + a] : 0);
    }
}

static void set_glow(const builder *b, const facet *f, size_t i, int side)
{
    const hpr_scene *scene = b->scene;
    hpr_paint *paint = b->patches->paint;
    uint32_t mesh = scene->face_mesh[f->face];
    size_t n = scene->channel_count;
    if (!paint || scene->mesh_glow_texture[mesh] == HPR_NONE)
        return;
    const base corners = base_of(f, side);
    paint->glow_of[i] = scene->mesh_glow_texture[mesh];
    set_map(scene->glow_uv, &corners, paint->glow_map + 6 * i);
    for (size_t c = 0; c < n; c++)
        paint->glow[n * i + c] = 3.14159265358979323846 * scene->mesh_glow_factor[n * mesh + c];
}

static void set_paint(const builder *b, const facet *f, size_t i, int side)
{
    const hpr_scene *scene = b->scene;
    hpr_paint *paint = b->patches->paint;
    uint32_t mesh = scene->face_mesh[f->face];
    size_t n = scene->channel_count;
    if (!paint || scene->mesh_texture[mesh] == HPR_NONE)
        return;
    const base corners = base_of(f, side);
    const uint32_t *at = corners.at;
    double *tint = paint->tint + 3 * n * i;
    paint->of_patch[i] = scene->mesh_texture[mesh];
    set_map(scene->uv, &corners, paint->map + 6 * i);
    for (size_t k = 0; k < 3; k++) {
        for (size_t c = 0; c < n; c++)
            tint[n * k + c] = scene->mesh_factor[n * mesh + c] *
                              (scene->colour[n * at[k] + c] - (k ? scene->colour[n * at[0] + c] : 0));
    }
}

/* A patch that only keeps its place. */
static void set_empty(const builder *b, const facet *f, size_t i, int side)
{
    b->patches->shape[i] = HPR_SHAPE_TRIANGLE;
    b->patches->side[i] = (uint8_t)side;
    b->patches->twin[i] = HPR_NONE;
    hpr_vec3_store(b->patches->origin + 3 * i, position(b, f->vertex[0]));
}

static void set_geometry(const builder *b, const facet *f, size_t i, int side)
{
    hpr_patches *patches = b->patches;
    bool triangle = f->vertex[3] == HPR_NONE;
    hpr_vec3 origin = position(b, f->vertex[0]);
    hpr_vec3 edge1 = hpr_sub(position(b, f->vertex[1]), origin);
    hpr_vec3 edge2 = hpr_sub(position(b, f->vertex[triangle ? 2 : 3]), origin);
    double *opposite = patches->opposite + 2 * i;
    hpr_shape shape = triangle  ? HPR_SHAPE_TRIANGLE
                      : f->skew ? HPR_SHAPE_QUADRILATERAL
                                : HPR_SHAPE_PARALLELOGRAM;
    if (f->skew)
        find_opposite(b, f->vertex, opposite);
    if (side) {
        double turned[2] = {opposite[1], opposite[0]};
        memcpy(opposite, turned, sizeof turned);
        hpr_vec3 swap = edge1;
        edge1 = edge2;
        edge2 = swap;
    }
    hpr_vec3 normal;
    double length = hpr_cross_exactly(edge1, edge2, &normal);
    patches->shape[i] = (uint8_t)shape;
    patches->side[i] = (uint8_t)side;
    patches->twin[i] = HPR_NONE;
    patches->area_m2[i] = length * hpr_shape_measure(shape, opposite);
    hpr_vec3_store(patches->origin + 3 * i, origin);
    hpr_vec3_store(patches->edge1 + 3 * i, edge1);
    hpr_vec3_store(patches->edge2 + 3 * i, edge2);
    hpr_vec3_store(patches->normal + 3 * i, normal);
}

/* Facets by their welded corners, so that equal ones are neighbours, the earliest first. */
typedef struct corner_key {
    uint32_t id[4]; /* sorted */
    uint32_t facet;
} corner_key;

static int compare_keys(const void *left, const void *right)
{
    const corner_key *a = left, *b = right;
    for (int i = 0; i < 4; i++) {
        if (a->id[i] != b->id[i])
            return a->id[i] < b->id[i] ? -1 : 1;
    }
    return a->facet < b->facet ? -1 : a->facet > b->facet;
}

static int compare_ids(const void *left, const void *right)
{
    const uint32_t *a = left, *b = right;
    return *a < *b ? -1 : *a > *b;
}

static hpr_vec3 facet_normal(const builder *b, const facet *f)
{
    hpr_vec3 o = position(b, f->vertex[0]);
    return hpr_cross(hpr_sub(position(b, f->vertex[1]), o), hpr_sub(position(b, f->vertex[2]), o));
}

/* hidden[2 f + side]: this side of facet f faces like a side of an earlier facet with the same corners. */
static hpr_status find_duplicates(const builder *b, bool *hidden)
{
    corner_key *keys = NULL;
    hpr_status status = hpr_allocate_into(b->context, &keys, b->facet_count, sizeof *keys, "patches");
    if (status != HPR_OK)
        return status;
    for (size_t f = 0; f < b->facet_count; f++) {
        for (int i = 0; i < 4; i++) {
            uint32_t v = b->facets[f].vertex[i];
            keys[f].id[i] = v == HPR_NONE ? HPR_NONE : b->id[v];
        }
        qsort(keys[f].id, 4, sizeof(uint32_t), compare_ids);
        keys[f].facet = (uint32_t)f;
    }
    qsort(keys, b->facet_count, sizeof *keys, compare_keys);
    bool seen[2] = {false, false}; /* sides of the group so far: along and against its first facet's normal */
    hpr_vec3 normal = {0, 0, 0};
    for (size_t k = 0; k < b->facet_count; k++) {
        const facet *f = &b->facets[keys[k].facet];
        bool first = k == 0 || memcmp(keys[k].id, keys[k - 1].id, sizeof keys[k].id) != 0;
        if (first) {
            normal = facet_normal(b, f);
            seen[0] = seen[1] = false;
        }
        uint32_t material = b->scene->mesh_material[b->scene->face_mesh[f->face]];
        bool both = material != HPR_NONE && b->scene->material[material].double_sided;
        int against = hpr_dot(facet_normal(b, f), normal) < 0;
        for (int side = 0; side <= both; side++) {
            int facing = against ^ side;
            hidden[2 * (size_t)keys[k].facet + (size_t)side] = seen[facing];
            seen[facing] = true;
        }
    }
    hpr_release(b->context, keys);
    return HPR_OK;
}

static void make_patches(builder *b, const bool *hidden)
{
    size_t count = 0;
    for (size_t f = 0; f < b->facet_count; f++) {
        const facet *facet = &b->facets[f];
        uint32_t material = b->scene->mesh_material[b->scene->face_mesh[facet->face]];
        bool both = material != HPR_NONE && b->scene->material[material].double_sided;
        size_t made = 0;
        for (int side = 0; side <= both; side++) {
            bool dropped = facet->empty || hidden[2 * f + (size_t)side];
            b->patches->duplicate_count += dropped && !facet->empty;
            if (dropped && !b->for_factors)
                continue;
            if (dropped)
                set_empty(b, facet, count, side);
            else
                set_geometry(b, facet, count, side);
            set_optics(b, facet, count);
            set_paint(b, facet, count, side);
            set_glow(b, facet, count, side);
            count++;
            made += !dropped;
        }
        if (made == 2) {
            b->patches->twin[count - 1] = (uint32_t)(count - 2);
            b->patches->twin[count - 2] = (uint32_t)(count - 1);
        }
    }
    b->patches->count = count;
}

static hpr_status allocate_builder(builder *b)
{
    size_t faces = b->scene->face_count;
    hpr_context *ctx = b->context;
    hpr_status status = hpr_allocate_into(ctx, &b->id, b->scene->vertex_count, sizeof *b->id, "patches");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b->edges, 3 * faces, sizeof *b->edges, "patches");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b->taken, faces, sizeof *b->taken, "patches");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b->facets, 2 * faces, sizeof *b->facets, "patches");
    if (status == HPR_OK)
        status = hpr_patches_create(ctx, 4 * faces, b->scene->channel_count, &b->patches);
    if (status == HPR_OK && b->scene->texture_count && !b->for_factors)
        status = hpr_paint_create(b->patches, b->scene->texture_count, b->scene->texture);
    return status;
}

static hpr_status warn_of_overlaps(const builder *b)
{
    const hpr_patches *p = b->patches;
    hpr_overlaps found;
    hpr_status status = hpr_overlaps_find(p, &found);
    if (status != HPR_OK || found.count == 0)
        return status;
    uint32_t i = found.first[0], j = found.first[1];
    hpr_warn(b->context,
             "%s: %zu pairs of patches lie in one plane, face the same way and overlap in part: there light "
             "counts "
             "twice; the first are patch %u (node %u, primitive %u) and patch %u (node %u, primitive %u)",
             b->scene->path, found.count, i, p->node[i], p->primitive[i], j, p->node[j], p->primitive[j]);
    return HPR_OK;
}

static hpr_status build(const hpr_scene *scene, bool for_factors, hpr_patches **patches)
{
    builder b = {.scene = scene, .context = scene->context, .for_factors = for_factors};
    bool *hidden = NULL;
    *patches = NULL;
    hpr_status status = allocate_builder(&b);
    if (status != HPR_OK)
        goto done;
    double low[3], high[3];
    b.tolerance = hpr_scene_bounds(scene, low, high) ? hpr_weld_distance(low, high) : 0;
    status = hpr_weld(scene->context, scene->position, scene->vertex_count, b.tolerance, b.id);
    if (status != HPR_OK)
        goto done;
    collect_facets(&b);
    if (!for_factors)
        merge_the_rest(&b);
    status = hpr_allocate_into(b.context, &hidden, 2 * b.facet_count, sizeof *hidden, "patches");
    if (status == HPR_OK)
        status = find_duplicates(&b, hidden);
    if (status != HPR_OK)
        goto done;
    make_patches(&b, hidden);
    b.patches->weld_m = b.tolerance;
    if (b.patches->degenerate_count)
        hpr_warn(b.context, "%s: %zu faces without area dropped", scene->path, b.patches->degenerate_count);
    if (b.patches->duplicate_count)
        hpr_warn(b.context,
                 "%s: %zu patches dropped because an equal one that faces the same way came before",
                 scene->path, b.patches->duplicate_count);
    status = warn_of_overlaps(&b);
done:
    hpr_release(b.context, hidden);
    hpr_release(b.context, b.id);
    hpr_release(b.context, b.edges);
    hpr_release(b.context, b.taken);
    hpr_release(b.context, b.facets);
    if (status != HPR_OK)
        hpr_patches_destroy(&b.patches);
    *patches = b.patches;
    return status;
}

hpr_status hpr_patches_build(const hpr_scene *scene, hpr_patches **patches)
{
    return build(scene, false, patches);
}

hpr_status hpr_patches_build_all(const hpr_scene *scene, hpr_patches **patches)
{
    return build(scene, true, patches);
}
