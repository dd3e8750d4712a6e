#include "solver/mass.h"

#include "basis/basis.h"
#include "math/gauss.h"
#include "patch/paint.h"
#include "quadrature/cuts.h"

#include <math.h>
#include <string.h>

enum {
    MOST_CELLS = 32, /* along an axis of the texture, of a leaf */
    SMALL_CELLS = 8  /* from so many along both polynomials vary little over one, and half the points do */
};

/* A leaf while its matrices are integrated. */
typedef struct leaf_mass {
    const hpr_mass *mass;
    size_t leaf, patch, count;
    hpr_element_frame frame;
    double origin[2], edge1[2], edge2[2]; /* the leaf in the parameters of its patch */
    hpr_affine uv[2];                     /* over the leaf, in cells of the texture */
    bool small;                           /* the cells, next to the element */
    double *rho;                          /* [channels] scratch */
    const hpr_texture *texture;
    const double *map; /* of the texture, in the parameters of the patch */
    double *block;     /* [channels][count][count], lower triangles; NULL: glow is integrated */
    double *glow;      /* its coefficients of the first channel */
} leaf_mass;

/* weight: that of T_k T_l, of which glow has only one. */
static void add_glow(const leaf_mass *l, const double at[2], double weight, const double *basis)
{
    size_t dofs = l->mass->elements->dof[l->mass->elements->leaf_count];
    double scale = hpr_frame_scale(&l->frame);
    for (size_t c = 0; c < l->mass->channel_count; c++) {
        double part = weight / scale * hpr_patch_exitance(l->mass->patches, l->patch, at[0], at[1], c);
        for (size_t k = 0; k < l->count; k++)
            l->glow[c * dofs + k] += part * basis[k];
    }
}

static void add_point(const leaf_mass *l, double s, double t, double weight)
{
    double basis[HPR_MAX_BASIS];
    size_t n = l->count;
    const double at[2] = {l->origin[0] + s * l->edge1[0] + t * l->edge2[0],
                          l->origin[1] + s * l->edge1[1] + t * l->edge2[1]};
    hpr_frame_basis(&l->frame, s, t, basis);
    if (!l->block) {
        add_glow(l, at, weight, basis);
        return;
    }
    hpr_patch_reflectance(l->mass->patches, l->patch, at[0], at[1], l->rho);
    for (size_t c = 0; c < l->mass->channel_count; c++) {
        for (size_t k = 0; k < n; k++) {
            double part = weight * l->rho[c] * basis[k], *row = l->block + (c * n + k) * n;
            for (size_t j = 0; j <= k; j++)
                row[j] += part * basis[j];
        }
    }
}

/*
 * Per axis of a piece: exact for T_k T_l times a bilinear texel times the tint, and 1 - v of a collapsed
 * triangle. The product basis of a parallelogram has twice its degree along a slanting line.
 */
static int count_points(const leaf_mass *l, const hpr_cell *cell)
{
    int degree = l->frame.degree;
    bool along = cell->shape == HPR_SHAPE_PARALLELOGRAM && cell->edge1[0] * cell->edge1[1] == 0 &&
                 cell->edge2[0] * cell->edge2[1] == 0;
    if (!along && l->frame.shape == HPR_SHAPE_PARALLELOGRAM)
        degree *= 2;
    return (l->small ? degree / 2 : degree) + 3;
}

/* Collapsed Gauss rules over the triangles of a piece; parallelograms stay whole. */
static void add_piece(const leaf_mass *l, const hpr_polygon *piece)
{
    hpr_cell cell[HPR_POLYGON_MAX];
    double scale = hpr_frame_scale(&l->frame), density = scale * scale * hpr_frame_jacobian(&l->frame);
    int cells = hpr_cuts_tiles(piece, cell);
    for (int i = 0; i < cells; i++) {
        const double *o = cell[i].origin, *e1 = cell[i].edge1, *e2 = cell[i].edge2;
        double area = fabs(e1[0] * e2[1] - e1[1] * e2[0]) * density;
        bool triangle = cell[i].shape == HPR_SHAPE_TRIANGLE;
        int points = count_points(l, &cell[i]);
        const hpr_gauss_rule *gauss = &hpr_gauss.legendre[points];
        for (int a = 0; a < points; a++) {
            for (int b = 0; b < points; b++) {
                double v = gauss->node[b], shrunk = triangle ? 1 - v : 1, u = gauss->node[a] * shrunk;
                add_point(l, o[0] + u * e1[0] + v * e2[0], o[1] + u * e1[1] + v * e2[1],
                          gauss->weight[a] * gauss->weight[b] * area * shrunk);
            }
        }
    }
}

static void find_range(const hpr_polygon *polygon, const hpr_affine *f, double *low, double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < polygon->count; i++) {
        double value = hpr_affine_at(f, polygon->corner[i][0], polygon->corner[i][1]);
        *low = fmin(*low, value);
        *high = fmax(*high, value);
    }
}

/* The part of a polygon where cell <= f <= cell + 1. */
static hpr_polygon strip(const hpr_polygon *polygon, const hpr_affine *f, double cell)
{
    const hpr_affine over = {f->at_origin - cell, f->along1, f->along2};
    const hpr_affine under = {f->at_origin - cell - 1, f->along1, f->along2};
    hpr_polygon part = hpr_polygon_half(polygon, &over, 1);
    return hpr_polygon_half(&part, &under, -1);
}

/* What lies on a line between two cells is in both and has no area. Cells are counted, for coordinates may be
 * so large that 1 more is the same. */
static void add_polygon(const leaf_mass *l, const hpr_polygon *polygon)
{
    double low[2], high[2];
    find_range(polygon, &l->uv[1], &low[1], &high[1]);
    for (int j = 0; j < MOST_CELLS + 2 && floor(low[1]) + j <= high[1]; j++) {
        hpr_polygon row = strip(polygon, &l->uv[1], floor(low[1]) + j);
        if (row.count < 3)
            continue;
        find_range(&row, &l->uv[0], &low[0], &high[0]);
        for (int i = 0; i < MOST_CELLS + 2 && floor(low[0]) + i <= high[0]; i++) {
            hpr_polygon piece = strip(&row, &l->uv[0], floor(low[0]) + i);
            if (piece.count >= 3)
                add_piece(l, &piece);
        }
    }
}

/* The leaf in the parameters of its patch, and the texture's coordinates over it, in cells: texels, or as
 * many together as a leaf with MOST_CELLS along an axis needs. */
static void place_leaf(leaf_mass *l, const hpr_polygon *whole)
{
    const hpr_elements *e = l->mass->elements;
    const hpr_patches *patches = l->mass->patches;
    const hpr_texture *texture = l->texture;
    const double *map = l->map;
    uint32_t node = e->leaf[l->leaf];
    const uint32_t size[2] = {texture->width, texture->height};
    double tip[2][3];
    for (int k = 0; k < 3; k++) {
        tip[0][k] = e->origin[3 * node + (size_t)k] + e->edge1[3 * node + (size_t)k];
        tip[1][k] = e->origin[3 * node + (size_t)k] + e->edge2[3 * node + (size_t)k];
    }
    hpr_patch_parameters(patches, l->patch, e->origin + 3 * node, &l->origin[0], &l->origin[1]);
    hpr_patch_parameters(patches, l->patch, tip[0], &l->edge1[0], &l->edge1[1]);
    hpr_patch_parameters(patches, l->patch, tip[1], &l->edge2[0], &l->edge2[1]);
    double cells = MOST_CELLS;
    for (int a = 0; a < 2; a++) {
        l->edge1[a] -= l->origin[a];
        l->edge2[a] -= l->origin[a];
    }
    for (int a = 0; a < 2; a++) {
        double low, high, shift = texture->nearest ? 0 : 0.5;
        l->uv[a] =
            (hpr_affine){(map[a] + l->origin[0] * map[2 + a] + l->origin[1] * map[4 + a]) * size[a] - shift,
                         (l->edge1[0] * map[2 + a] + l->edge1[1] * map[4 + a]) * size[a],
                         (l->edge2[0] * map[2 + a] + l->edge2[1] * map[4 + a]) * size[a]};
        find_range(whole, &l->uv[a], &low, &high);
        double together = fmax(1, ceil((high - low) / MOST_CELLS));
        l->uv[a].at_origin /= together;
        l->uv[a].along1 /= together;
        l->uv[a].along2 /= together;
        cells = fmin(cells, (high - low) / together);
    }
    l->small = cells >= SMALL_CELLS;
}

/* block [n][n] = G+ block, which is symmetric before: a row is a column. */
static void project(const hpr_coverage *coverage, size_t leaf, size_t n, double *block)
{
    for (size_t k = 0; k < n; k++)
        hpr_coverage_project(coverage, leaf, block + k * n);
    for (size_t k = 0; k < n; k++) {
        for (size_t j = 0; j < k; j++) {
            double kept = block[k * n + j];
            block[k * n + j] = block[j * n + k];
            block[j * n + k] = kept;
        }
    }
}

static leaf_mass open_leaf(const hpr_mass *mass, size_t leaf)
{
    const hpr_elements *e = mass->elements;
    return (leaf_mass){.mass = mass,
                       .leaf = leaf,
                       .patch = e->patch[e->leaf[leaf]],
                       .count = e->dof[leaf + 1] - e->dof[leaf],
                       .frame = hpr_leaf_frame(mass->patches, e, leaf)};
}

static void integrate_leaf(const hpr_mass *mass, const hpr_coverage *coverage, size_t leaf, double *rho)
{
    leaf_mass l = open_leaf(mass, leaf);
    l.rho = rho;
    l.texture = hpr_patch_texture(mass->patches, l.patch);
    l.map = mass->patches->paint->map + 6 * l.patch;
    l.block = mass->block + mass->at[leaf];
    const hpr_polygon whole = hpr_frame_outline(&l.frame);
    int parts = 1;
    const hpr_polygon *part = hpr_coverage_parts(coverage, leaf, &parts);
    place_leaf(&l, &whole);
    for (int i = 0; i < (part ? parts : 1); i++)
        add_polygon(&l, part ? &part[i] : &whole);
    size_t n = l.count;
    for (size_t c = 0; c < mass->channel_count; c++) {
        double *block = l.block + c * n * n;
        for (size_t k = 0; k < n; k++) {
            for (size_t j = k + 1; j < n; j++)
                block[k * n + j] = block[j * n + k];
        }
        if (part)
            project(coverage, leaf, n, block);
    }
}

/* Of all of the leaf, as constant emission is, whatever stands on it. */
static void integrate_glow(const hpr_mass *mass, size_t leaf)
{
    const hpr_elements *e = mass->elements;
    leaf_mass l = open_leaf(mass, leaf);
    size_t dofs = e->dof[e->leaf_count];
    l.texture = hpr_patch_glow(mass->patches, l.patch);
    l.map = mass->patches->paint->glow_map + 6 * l.patch;
    l.glow = mass->glow + e->dof[leaf];
    const hpr_polygon whole = hpr_frame_outline(&l.frame);
    place_leaf(&l, &whole);
    add_polygon(&l, &whole);
    for (size_t c = 0; c < mass->channel_count; c++)
        l.glow[c * dofs] -=
            sqrt(l.frame.area_m2) * mass->patches->exitance[mass->channel_count * l.patch + c];
}

/* A patch sends exactly its mean M, however its texture was integrated. */
static void keep_power(const hpr_mass *mass, size_t patch)
{
    const hpr_elements *e = mass->elements;
    size_t dofs = e->dof[e->leaf_count];
    for (size_t c = 0; c < mass->channel_count; c++) {
        double power = 0, *glow = mass->glow + c * dofs;
        for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++)
            power += glow[e->dof[leaf]] * sqrt(e->area_m2[e->leaf[leaf]]);
        for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++)
            glow[e->dof[leaf]] -= power / mass->patches->area_m2[patch] * sqrt(e->area_m2[e->leaf[leaf]]);
    }
}

/* Where the matrices of each leaf begin, and how many numbers there are. */
static size_t place_blocks(hpr_mass *mass)
{
    const hpr_elements *e = mass->elements;
    size_t size = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        size_t count = e->dof[leaf + 1] - e->dof[leaf];
        bool textured = hpr_patch_texture(mass->patches, e->patch[e->leaf[leaf]]);
        mass->at[leaf] = textured ? size : SIZE_MAX;
        size += textured ? mass->channel_count * count * count : 0;
    }
    return size;
}

hpr_status hpr_mass_init(const hpr_patches *patches, const hpr_elements *elements,
                         const hpr_coverage *coverage, hpr_mass *mass)
{
    hpr_context *ctx = patches->context;
    size_t n = patches->channel_count;
    *mass = (hpr_mass){.patches = patches, .elements = elements, .channel_count = n};
    if (!patches->paint)
        return HPR_OK;
    double *rho = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &mass->at, elements->leaf_count, sizeof *mass->at, "reflectance");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &mass->block, place_blocks(mass), sizeof *mass->block, "reflectance");
    if (status == HPR_OK && hpr_patches_glow(patches))
        status = hpr_allocate_into(ctx, &mass->glow, elements->dof[elements->leaf_count], n * sizeof(double),
                                   "emission");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &rho, elements->leaf_count, n * sizeof *rho, "reflectance");
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t leaf = 0; leaf < (status == HPR_OK ? elements->leaf_count : 0); leaf++) {
        if (mass->at[leaf] != SIZE_MAX && !hpr_cancelled(ctx))
            integrate_leaf(mass, coverage, leaf, rho + n * leaf);
        if (hpr_mass_glows(mass, leaf) && !hpr_cancelled(ctx))
            integrate_glow(mass, leaf);
    }
    for (size_t patch = 0; status == HPR_OK && mass->glow && patch < patches->count; patch++) {
        if (hpr_patch_glow(patches, patch))
            keep_power(mass, patch);
    }
    hpr_release(ctx, rho);
    if (status == HPR_OK && hpr_cancelled(ctx))
        status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while integrating textures");
    return status;
}

void hpr_mass_fini(hpr_mass *mass)
{
    if (!mass->patches)
        return;
    hpr_release(mass->patches->context, mass->at);
    hpr_release(mass->patches->context, mass->block);
    hpr_release(mass->patches->context, mass->glow);
    *mass = (hpr_mass){0};
}

bool hpr_mass_glows(const hpr_mass *mass, size_t leaf)
{
    return mass->glow && hpr_patch_glow(mass->patches, mass->elements->patch[mass->elements->leaf[leaf]]);
}

static bool has_matrices(const hpr_mass *mass, size_t leaf)
{
    return mass->at && mass->at[leaf] != SIZE_MAX;
}

bool hpr_mass_varies(const hpr_mass *mass, size_t leaf)
{
    return has_matrices(mass, leaf) || hpr_mass_glows(mass, leaf);
}

void hpr_mass_reflect(const hpr_mass *mass, size_t leaf, size_t channel, size_t stride,
                      const double *irradiance, double *radiosity)
{
    const hpr_elements *e = mass->elements;
    size_t n = e->dof[leaf + 1] - e->dof[leaf];
    if (!has_matrices(mass, leaf)) {
        double rho =
            mass->patches->reflectance[mass->patches->channel_count * e->patch[e->leaf[leaf]] + channel];
        for (size_t k = 0; k < n; k++)
            radiosity[k * stride] = rho * irradiance[k * stride];
        return;
    }
    const double *block = mass->block + mass->at[leaf] + channel * n * n;
    for (size_t k = 0; k < n; k++) {
        double sum = 0;
        for (size_t j = 0; j < n; j++)
            sum += block[k * n + j] * irradiance[j * stride];
        radiosity[k * stride] = sum;
    }
}

void hpr_mass_ripple(const hpr_mass *mass, size_t leaf, size_t channel, size_t stride, double *radiosity)
{
    const hpr_elements *e = mass->elements;
    if (!hpr_mass_glows(mass, leaf))
        return;
    const double *glow = mass->glow + channel * e->dof[e->leaf_count];
    for (size_t k = e->dof[leaf]; k < e->dof[leaf + 1]; k++)
        radiosity[(k - e->dof[leaf]) * stride] += glow[k];
}

void hpr_mass_emit(const hpr_mass *mass, size_t leaf, size_t channel, double *radiosity)
{
    const hpr_elements *e = mass->elements;
    uint32_t node = e->leaf[leaf];
    radiosity[0] +=
        sqrt(e->area_m2[node]) * mass->patches->exitance[mass->channel_count * e->patch[node] + channel];
    hpr_mass_ripple(mass, leaf, channel, 1, radiosity);
}
