/* From a model to rows: cut bases, triangulate, combine. */
#include "math/twofold.h"
#include "patch/carve.h"
#include "patch/rows_build.h"

#include <float.h>

/* Relative to the size of what is cut. */
static const double cut_slack = 1e-12;

/* Vertices are exact, so only rounding may separate what touches. Relative to the model. */
static const double weld = 1e-13;

typedef struct shape {
    hpr_shape kind;
    hpr_vec3 origin, edge1, edge2;
    uint32_t surface;
} shape;

typedef struct builder {
    const hpr_model *model;
    hpr_context *context;
    uint32_t *row;                  /* [model->count] of each surface, HPR_NONE: none */
    bool *repeated;                 /* [model->count] equal to an earlier one */
    uint32_t *inside, *next_inside; /* [model->count] chain of the surfaces whose base it is */
    shape *shapes;
    size_t shape_count, shape_capacity;
    hpr_rows *rows;
} builder;

static hpr_carved piece_of(const hpr_surface *s)
{
    hpr_carved piece = {.count = (int)s->corner_count};
    for (size_t i = 0; i < s->corner_count; i++)
        piece.corner[i] = hpr_vec3_load(s->corner[i]);
    return piece;
}

static double piece_size(const hpr_carved *piece)
{
    double size = 0;
    for (int i = 1; i < piece->count; i++)
        size = fmax(size, hpr_length(hpr_sub(piece->corner[i], piece->corner[0])));
    return size;
}

static hpr_status add_shape(builder *b, uint32_t surface, hpr_shape kind, hpr_vec3 origin, hpr_vec3 first,
                            hpr_vec3 last)
{
    hpr_vec3 edge1 = hpr_sub(first, origin), edge2 = hpr_sub(last, origin), edge3 = hpr_sub(last, first);
    double longest = fmax(hpr_length(edge1), fmax(hpr_length(edge2), hpr_length(edge3)));
    if (!(hpr_length(hpr_cross(edge1, edge2)) / longest > cut_slack * longest))
        return HPR_OK; /* no area */
    hpr_status status =
        hpr_grow(b->context, &b->shapes, &b->shape_capacity, b->shape_count + 1, sizeof *b->shapes);
    if (status == HPR_OK)
        b->shapes[b->shape_count++] = (shape){kind, origin, edge1, edge2, surface};
    return status;
}

/* Opposite sides agree to what their coordinates resolve. */
static bool is_parallelogram(const hpr_vec3 *c)
{
    double largest = 0;
    for (int i = 0; i < 4; i++)
        largest = fmax(largest, fmax(fabs(c[i].x), fmax(fabs(c[i].y), fabs(c[i].z))));
    return hpr_length(hpr_sub(hpr_add(c[0], c[2]), hpr_add(c[1], c[3]))) <= 16 * DBL_EPSILON * largest;
}

/* Corners that lie on the line between their neighbours go: the cuts leave some. */
static void drop_straight(hpr_carved *piece)
{
    double slack = cut_slack * piece_size(piece);
    for (int i = 0; piece->count > 3 && i < piece->count;) {
        int n = piece->count;
        hpr_vec3 before = piece->corner[(i + n - 1) % n], here = piece->corner[i];
        hpr_vec3 line = hpr_sub(piece->corner[(i + 1) % n], before);
        double length = hpr_length(line);
        if (hpr_length(hpr_cross(line, hpr_sub(here, before))) > slack * length) {
            i++;
            continue;
        }
        for (int k = i; k + 1 < n; k++)
            piece->corner[k] = piece->corner[k + 1];
        piece->count--;
        i = 0;
    }
}

static hpr_status add_piece(builder *b, uint32_t surface, hpr_carved *piece)
{
    drop_straight(piece);
    const hpr_vec3 *c = piece->corner;
    if (piece->count == 4 && is_parallelogram(c))
        return add_shape(b, surface, HPR_SHAPE_PARALLELOGRAM, c[0], c[1], c[3]);
    int n = piece->count, apex = 0;
    if (n == 4 && hpr_length(hpr_sub(c[2], c[0])) > hpr_length(hpr_sub(c[3], c[1])))
        apex = 1; /* the shorter diagonal */
    hpr_status status = HPR_OK;
    for (int i = 1; status == HPR_OK && i + 1 < n; i++)
        status = add_shape(b, surface, HPR_SHAPE_TRIANGLE, c[apex], c[(apex + i) % n], c[(apex + i + 1) % n]);
    return status;
}

static hpr_status add_surface(builder *b, uint32_t i)
{
    const hpr_surface *s = &b->model->surface[i];
    hpr_carved whole = piece_of(s);
    hpr_carving list = {.context = b->context};
    if (!(s->area_m2 > 0) || b->repeated[i] || s->kind == HPR_SURFACE_IS_ABSENT)
        return HPR_OK;
    double slack = cut_slack * piece_size(&whole);
    hpr_status status = hpr_carving_add(&list, &whole);
    for (uint32_t k = b->inside[i]; status == HPR_OK && k != HPR_NONE; k = b->next_inside[k]) {
        const hpr_surface *hole = &b->model->surface[k];
        hpr_carved outline = piece_of(hole);
        if (hole->area_m2 > 0)
            status = hpr_carve(&list, hpr_vec3_load(s->normal), outline.corner, outline.count, slack);
    }
    for (size_t k = 0; status == HPR_OK && k < list.count; k++)
        status = add_piece(b, i, &list.piece[k]);
    hpr_carving_release(&list);
    return status;
}

static bool has_corner(const hpr_surface *s, const double corner[3])
{
    for (size_t i = 0; i < s->corner_count; i++) {
        if (s->corner[i][0] == corner[0] && s->corner[i][1] == corner[1] && s->corner[i][2] == corner[2])
            return true;
    }
    return false;
}

static bool repeats(const hpr_surface *s, const hpr_surface *earlier)
{
    static const double close = 1e-9; /* equal corners in another order have equal areas but for rounding */
    if (earlier->kind != HPR_SURFACE_RADIATES || s->corner_count != earlier->corner_count ||
        fabs(s->area_m2 - earlier->area_m2) > close * s->area_m2 || hpr_dot3(s->normal, earlier->normal) <= 0)
        return false;
    for (size_t i = 0; i < s->corner_count; i++) {
        if (!has_corner(earlier, s->corner[i]))
            return false;
    }
    return true;
}

/* A subsurface may fill its base; everything else that repeats a surface would count twice. */
static void find_repeated(builder *b)
{
    const hpr_model *model = b->model;
    for (uint32_t i = 0; i < model->count; i++) {
        const hpr_surface *s = &model->surface[i];
        for (uint32_t j = 0; s->kind == HPR_SURFACE_RADIATES && s->area_m2 > 0 && j < i; j++) {
            if (s->base == j || b->repeated[j] || !repeats(s, &model->surface[j]))
                continue;
            b->repeated[i] = true;
            hpr_warn(
                b->context,
                "%s: line %zu: surface %u '%.60s' equals surface %u and faces the same way; its row is zero",
                model->path, s->line, i + 1, s->name, j + 1);
            break;
        }
    }
}

static size_t number_rows(builder *b)
{
    const hpr_model *model = b->model;
    uint32_t count = 0;
    for (size_t i = 0; i < model->count; i++) {
        const hpr_surface *s = &model->surface[i];
        bool has_row = s->kind == HPR_SURFACE_RADIATES || s->kind == HPR_SURFACE_MASKS;
        b->row[i] = !has_row ? HPR_NONE : s->combine != HPR_NONE ? b->row[s->combine] : count++;
    }
    return count;
}

static void list_insides(builder *b)
{
    size_t n = b->model->count;
    for (size_t i = 0; i < n; i++)
        b->inside[i] = b->next_inside[i] = HPR_NONE;
    for (size_t i = n; i-- > 0;) {
        uint32_t base = b->model->surface[i].base;
        if (base == HPR_NONE)
            continue;
        b->next_inside[i] = b->inside[base];
        b->inside[base] = (uint32_t)i;
    }
}

static hpr_status make_patches(builder *b)
{
    hpr_rows *rows = b->rows;
    hpr_context *ctx = b->context;
    size_t n = b->shape_count;
    hpr_status status = hpr_patches_create(ctx, n, 1, &rows->patches);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->patch_row, n, sizeof *rows->patch_row, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rows->patch_surface, n, sizeof *rows->patch_surface, "rows");
    if (status != HPR_OK)
        return status;
    hpr_patches *patches = rows->patches;
    for (size_t i = 0; i < n; i++) {
        const shape *s = &b->shapes[i];
        hpr_vec3 normal;
        double length = hpr_cross_exactly(s->edge1, s->edge2, &normal);
        patches->shape[i] = (uint8_t)s->kind;
        patches->twin[i] = patches->node[i] = patches->primitive[i] = patches->material[i] = HPR_NONE;
        patches->area_m2[i] = s->kind == HPR_SHAPE_TRIANGLE ? length / 2 : length;
        hpr_vec3_store(patches->origin + 3 * i, s->origin);
        hpr_vec3_store(patches->edge1 + 3 * i, s->edge1);
        hpr_vec3_store(patches->edge2 + 3 * i, s->edge2);
        hpr_vec3_store(patches->normal + 3 * i, normal);
        rows->patch_surface[i] = s->surface;
        bool sees = b->model->surface[s->surface].kind == HPR_SURFACE_RADIATES;
        rows->patch_row[i] = sees ? b->row[s->surface] : HPR_NONE;
    }
    double centre[3];
    patches->weld_m = weld * 2 * hpr_patches_radius(patches, centre);
    return HPR_OK;
}

static hpr_status list_masks(builder *b)
{
    const hpr_model *model = b->model;
    hpr_rows *rows = b->rows;
    hpr_status status = hpr_allocate_into(b->context, &rows->mask, model->count, sizeof *rows->mask, "rows");
    for (size_t i = 0; status == HPR_OK && i < model->count; i++) {
        const hpr_surface *s = &model->surface[i];
        if (s->kind != HPR_SURFACE_MASKS || !(s->area_m2 > 0))
            continue;
        uint32_t base_row = b->row[s->base];
        rows->row[b->row[i]].area_m2 += s->area_m2;
        if (base_row != HPR_NONE) {
            rows->row[base_row].area_m2 += s->area_m2;
            rows->mask[rows->mask_count++] = (hpr_mask){b->row[i], base_row, s->area_m2};
        }
    }
    return status;
}

/* Areas are those of the patches, so that the factors of one patch are as exact as its block. */
static hpr_status describe_rows(builder *b)
{
    const hpr_model *model = b->model;
    hpr_rows *rows = b->rows;
    hpr_status status = HPR_OK;
    double *weight = NULL;
    for (size_t p = 0; p < rows->patches->count; p++) {
        if (rows->patch_row[p] != HPR_NONE)
            rows->row[rows->patch_row[p]].area_m2 += rows->patches->area_m2[p];
    }
    status = hpr_allocate_into(b->context, &weight, rows->count, sizeof *weight, "rows");
    for (size_t i = 0; status == HPR_OK && i < model->count; i++) {
        const hpr_surface *s = &model->surface[i];
        if (b->row[i] == HPR_NONE)
            continue;
        hpr_row *row = &rows->row[b->row[i]];
        if (s->combine == HPR_NONE) {
            row->node = row->primitive = HPR_NONE;
            row->emissivity = s->emissivity;
            status = hpr_rows_name(rows, b->row[i], s->name);
        } else if (s->emissivity != row->emissivity) {
            double total = weight[b->row[i]] + s->area_m2;
            hpr_warn(
                b->context,
                "%s: line %zu: surface %zu '%.60s' is combined with one of another emittance; the row has "
                "their mean by area",
                model->path, s->line, i + 1, s->name);
            if (total > 0)
                row->emissivity += (s->emissivity - row->emissivity) * (s->area_m2 / total);
        }
        weight[b->row[i]] += s->area_m2;
    }
    hpr_release(b->context, weight);
    return status;
}

hpr_status hpr_rows_of_model(const hpr_model *model, hpr_rows **out)
{
    hpr_context *ctx = model->context;
    builder b = {.model = model, .context = ctx};
    size_t n = model->count;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &b.row, n, sizeof *b.row, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b.repeated, n, sizeof *b.repeated, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b.inside, n, sizeof *b.inside, "rows");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &b.next_inside, n, sizeof *b.next_inside, "rows");
    if (status == HPR_OK)
        status = hpr_rows_create(ctx, number_rows(&b), &b.rows);
    if (status == HPR_OK) {
        find_repeated(&b);
        list_insides(&b);
    }
    for (uint32_t i = 0; status == HPR_OK && i < n; i++)
        status = add_surface(&b, i);
    if (status == HPR_OK)
        status = make_patches(&b);
    if (status == HPR_OK)
        status = hpr_rows_index(b.rows);
    if (status == HPR_OK)
        status = list_masks(&b);
    if (status == HPR_OK)
        status = describe_rows(&b);
    void *arrays[] = {b.row, b.repeated, b.inside, b.next_inside, b.shapes};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    if (status != HPR_OK)
        hpr_rows_destroy(&b.rows);
    *out = b.rows;
    return status;
}
