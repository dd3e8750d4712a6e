#include "solver/losses.h"

#include "basis/basis.h"
#include "direct/lambert.h"
#include "math/gauss.h"
#include "math/hash.h"
#include "math/vec3.h"

#include <math.h>
#include <omp.h>
#include <string.h>

enum {
    MAX_LAMBERT_PATCHES = 512, /* more patches, and all fractions are sampled */
    CELL_NODES = 6,
    MANY_LEAVES = 1000, /* are small, so that what they see varies little over them */
    MAX_DEPTH = 48,
    MAX_CELLS = 20000, /* per leaf */
    RAYS = 1 << 20,    /* about so many in all */
    LEAST_RAYS = 4,
    MOST_RAYS = 4096 /* of a leaf */
};

hpr_fractions hpr_losses_at(const hpr_losses *losses, size_t patch, const double point[3])
{
    const hpr_patches *patches = losses->solution->patches;
    hpr_fractions f = {0, 1};
    for (size_t j = 0; j < patches->count; j++) {
        if (j == patch || j == patches->twin[patch] || (patches->twin[j] != HPR_NONE && patches->twin[j] < j))
            continue;
        double corner[4][3], offset[3];
        size_t count = hpr_patch_corners(patches, j, corner);
        double part =
            hpr_lambert_fraction(point, patches->normal + 3 * patch, (const double(*)[3])corner, count);
        hpr_subtract3(point, patches->origin + 3 * j, offset);
        f.out -= part;
        if (patches->twin[j] == HPR_NONE && hpr_dot3(offset, patches->normal + 3 * j) < 0)
            f.back += part;
    }
    return f;
}

double hpr_losses_radiosity(const hpr_losses *losses, size_t leaf, size_t channel, size_t k)
{
    const hpr_solution *solution = losses->solution;
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, at = n * (e->dof[leaf] + k) + channel;
    size_t node = e->leaf[leaf], patch = n * e->patch[node] + channel;
    double reflected = hpr_mass_varies(losses->mass, leaf)
                           ? losses->reflected[at]
                           : solution->patches->reflectance[patch] * solution->irradiance[at];
    return reflected + (k == 0 ? solution->patches->exitance[patch] * sqrt(e->area_m2[node]) : 0);
}

/* A leaf while its losses are integrated. Values: [2][channels] on backs, escaped. */
typedef struct leaf_integral {
    const hpr_losses *e;
    double tolerance; /* absolute, W */
    size_t leaf, patch;
    uint32_t node;
    hpr_element_frame frame;
    hpr_cell
        cell; /* triangle of the leaf's parameters over which boxes lie, collapsed: a = u (1 - v), b = v */
    int cells, nodes; /* boxes so far, nodes per axis of a box */
} leaf_integral;

static void leaf_point(const leaf_integral *l, double s, double t, double point[3])
{
    const hpr_elements *elements = l->e->solution->elements;
    for (int k = 0; k < 3; k++) {
        size_t i = 3 * (size_t)l->node + (size_t)k;
        point[k] = elements->origin[i] + s * elements->edge1[i] + t * elements->edge2[i];
    }
}

static void leaf_radiosity(const leaf_integral *l, double s, double t, double *radiosity)
{
    const hpr_losses *e = l->e;
    double basis[HPR_MAX_BASIS];
    double scale = hpr_frame_scale(&l->frame);
    size_t n = e->solution->channel_count, count = hpr_basis_count(l->frame.shape, l->frame.degree);
    bool open = hpr_coverage_open(e->coverage, l->leaf, s, t), varies = hpr_mass_varies(e->mass, l->leaf);
    const double *coefficient =
        (varies ? e->reflected : e->solution->irradiance) + n * e->solution->elements->dof[l->leaf];
    hpr_frame_basis(&l->frame, s, t, basis);
    for (size_t c = 0; c < n; c++) {
        double value = 0;
        for (size_t k = 0; k < count && open; k++)
            value += scale * basis[k] * coefficient[n * k + c];
        double rho = varies ? 1 : e->solution->patches->reflectance[n * l->patch + c];
        radiosity[c] = e->solution->patches->exitance[n * l->patch + c] + rho * value;
    }
}

/* Adds weight * B * f. */
static void add_point(const leaf_integral *l, double s, double t, double weight, hpr_fractions f,
                      double *radiosity, double *sum)
{
    size_t n = l->e->solution->channel_count;
    leaf_radiosity(l, s, t, radiosity);
    for (size_t c = 0; c < n; c++) {
        sum[c] += weight * f.back * radiosity[c];
        sum[n + c] += weight * f.out * radiosity[c];
    }
}

/* Product Gauss over a box of the cell's collapsed coordinates. radiosity: scratch [channels]. */
static void integrate_box(leaf_integral *l, const double box[4], double *sum, double *radiosity)
{
    int nodes = l->nodes;
    const hpr_gauss_rule *gauss = &hpr_gauss.legendre[nodes];
    const double *o = l->cell.origin, *e1 = l->cell.edge1, *e2 = l->cell.edge2;
    double parameters = hpr_frame_measure(&l->frame);
    double area = fabs(e1[0] * e2[1] - e1[1] * e2[0]) * l->e->solution->elements->area_m2[l->node] /
                  parameters * box[2] * box[3];
    memset(sum, 0, 2 * l->e->solution->channel_count * sizeof *sum);
    l->cells++;
    for (int j = 0; j < nodes; j++) {
        for (int i = 0; i < nodes; i++) {
            double v = box[1] + box[3] * gauss->node[j], a = (box[0] + box[2] * gauss->node[i]) * (1 - v),
                   point[3];
            double s = o[0] + a * e1[0] + v * e2[0], t = o[1] + a * e1[1] + v * e2[1];
            leaf_point(l, s, t, point);
            add_point(l, s, t, gauss->weight[i] * gauss->weight[j] * area * (1 - v),
                      hpr_losses_at(l->e, l->patch, point), radiosity, sum);
        }
    }
}

static double difference(const double *whole, const double *half0, const double *half1, size_t count)
{
    double worst = 0;
    for (size_t i = 0; i < count; i++)
        worst = fmax(worst, fabs(whole[i] - half0[i] - half1[i]));
    return worst;
}

/* Adaptive by halving along the axis that shows the larger difference; adds to `total`. Works on a stack of
 * its own. */
static void integrate_adaptively(leaf_integral *l, const double box[4], const double *whole, int depth,
                                 double *total)
{
    size_t n = 2 * l->e->solution->channel_count;
    double half[2][2][n], radiosity[n], halves[2][2][4], error[2];
    for (int axis = 0; axis < 2; axis++) {
        for (int which = 0; which < 2; which++) {
            double *h = halves[axis][which];
            memcpy(h, box, 4 * sizeof *h);
            h[2 + axis] /= 2;
            h[axis] += which * h[2 + axis];
            integrate_box(l, h, half[axis][which], radiosity);
        }
        error[axis] = difference(whole, half[axis][0], half[axis][1], n);
    }
    int axis = error[1] > error[0];
    if (error[axis] <= l->tolerance || depth >= MAX_DEPTH || l->cells > MAX_CELLS) {
        for (size_t i = 0; i < n; i++)
            total[i] += half[axis][0][i] + half[axis][1][i];
        return;
    }
    for (int which = 0; which < 2; which++)
        integrate_adaptively(l, halves[axis][which], half[axis][which], depth + 1, total);
}

void hpr_losses_cut(const hpr_losses *losses, uint32_t node, const hpr_element_frame *frame, hpr_cuts *pieces)
{
    const hpr_patches *patches = losses->solution->patches;
    const hpr_elements *elements = losses->solution->elements;
    const hpr_polygon whole = hpr_frame_outline(frame);
    uint32_t patch = elements->patch[node];
    size_t own = 3 * (size_t)node;
    hpr_cuts_init(pieces, &whole);
    for (size_t j = 0; j < patches->count; j++) {
        double offset[3];
        const double *normal = patches->normal + 3 * j;
        hpr_subtract3(elements->origin + own, patches->origin + 3 * j, offset);
        hpr_affine height = {hpr_dot3(normal, offset), hpr_dot3(normal, elements->edge1 + own),
                             hpr_dot3(normal, elements->edge2 + own)};
        if (j != patch && j != patches->twin[patch])
            hpr_cuts_along(pieces, &height);
    }
}

/* Fractions are positive and smooth over a piece: where their integral is next to nothing so are they, as in
 * a closed room, and halving would show nothing new. */
static bool is_negligible(const leaf_integral *l, const double *whole)
{
    for (size_t i = 0; i < 2 * l->e->solution->channel_count; i++) {
        if (!(fabs(whole[i]) <= l->tolerance))
            return false;
    }
    return true;
}

static void lose_exactly(leaf_integral *l, double *total)
{
    static const double whole_box[4] = {0, 0, 1, 1};
    double whole[2 * l->e->solution->channel_count], scratch[l->e->solution->channel_count];
    hpr_cuts pieces;
    hpr_cell cell[HPR_POLYGON_MAX];
    hpr_losses_cut(l->e, l->node, &l->frame, &pieces);
    for (int p = 0; p < pieces.count; p++) {
        int count = hpr_cuts_fan(&pieces.piece[p], cell);
        for (int i = 0; i < count; i++) {
            l->cell = cell[i];
            integrate_box(l, whole_box, whole, scratch);
            if (is_negligible(l, whole)) {
                for (size_t k = 0; k < 2 * l->e->solution->channel_count; k++)
                    total[k] += whole[k];
            } else {
                integrate_adaptively(l, whole_box, whole, 0, total);
            }
        }
    }
}

/* A cosine-weighted direction (Malley) from two numbers in [0,1). */
static void cosine_direction(const hpr_patches *patches, size_t patch, const double at[2],
                             double direction[3])
{
    hpr_vec3 n = hpr_vec3_load(patches->normal + 3 * patch), u = hpr_vec3_load(patches->edge1 + 3 * patch);
    u = hpr_scale(u, 1 / hpr_length(u));
    double radius = sqrt(at[0]), angle = 2 * 3.14159265358979323846 * at[1];
    hpr_vec3 d = hpr_madd(hpr_scale(n, sqrt(1 - at[0])), radius * cos(angle), u);
    hpr_vec3_store(direction, hpr_madd(d, radius * sin(angle), hpr_cross(n, u)));
}

/*
 * Rays from all over the leaf in all directions, each from a point of its own: what shows only backs, as
 * under an open box, may be a small part of the leaf. A Kronecker sequence (Roberts 2018: powers of the root
 * of x^5 = x + 1) moved at random.
 */
static void lose_by_rays(leaf_integral *l, double *total)
{
    static const double step[4] = {0.8566748838545029, 0.733891856627126, 0.6287067210378087,
                                   0.5385972572236101};
    const hpr_losses *e = l->e;
    double scratch[e->solution->channel_count],
        near = 1e-9 * hpr_patches_radius(e->solution->patches, (double[3]){0}) + e->solution->patches->weld_m;
    for (size_t r = 0; r < e->rays; r++) {
        double at[4], point[3], direction[3];
        for (size_t k = 0; k < 4; k++) {
            at[k] = hpr_hash_unit(4 * l->leaf + k + 1) + (double)(r + 1) * step[k];
            at[k] -= floor(at[k]);
        }
        hpr_shape_uniform(l->frame.shape, l->frame.opposite, at[0], at[1], at);
        leaf_point(l, at[0], at[1], point);
        cosine_direction(e->solution->patches, l->patch, at + 2, direction);
        bool back = false;
        hpr_hit hit = hpr_visibility_first_hit(e->visibility, point, direction, near, INFINITY, false, &back);
        hpr_fractions f = {hit.patch != HPR_NONE && back, hit.patch == HPR_NONE};
        if (f.back + f.out > 0)
            add_point(l, at[0], at[1], e->solution->elements->area_m2[l->node] / (double)e->rays, f, scratch,
                      total);
    }
}

static void lose_from_leaf(const hpr_losses *e, size_t leaf)
{
    uint32_t node = e->solution->elements->leaf[leaf], patch = e->solution->elements->patch[node];
    leaf_integral l = {.e = e,
                       .leaf = leaf,
                       .patch = patch,
                       .node = node,
                       .tolerance = e->tolerance / (double)e->solution->elements->leaf_count,
                       .frame = hpr_leaf_frame(e->solution->patches, e->solution->elements, leaf)};
    double *total = e->lost + 2 * e->solution->channel_count * leaf;
    int degree = e->solution->elements->degree[node];
    l.nodes =
        e->solution->elements->leaf_count < MANY_LEAVES || degree + 2 > CELL_NODES ? CELL_NODES : degree + 2;
    if (e->shaded[patch])
        lose_by_rays(&l, total);
    else
        lose_exactly(&l, total);
}

static hpr_status prepare(hpr_losses *l)
{
    const hpr_solution *solution = l->solution;
    hpr_context *ctx = solution->context;
    size_t leaves = solution->elements->leaf_count, patches = solution->patches->count;
    hpr_status status = hpr_visibility_create(solution->patches, &l->visibility);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &l->shaded, patches, sizeof *l->shaded, "energy terms");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &l->done, leaves, sizeof *l->done, "energy terms");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &l->lost, 2 * solution->channel_count * leaves, sizeof(double),
                                   "energy terms");
    if (status != HPR_OK)
        return status;
    l->rays = LEAST_RAYS;
    while (l->rays < MOST_RAYS && 2 * leaves * l->rays <= RAYS)
        l->rays *= 2;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t i = 0; i < patches; i++)
        l->shaded[i] = patches > MAX_LAMBERT_PATCHES || !hpr_visibility_unobstructed(l->visibility, i);
    return HPR_OK;
}

static void sum_up(const hpr_losses *l, hpr_energy *energy)
{
    size_t n = l->solution->channel_count;
    for (size_t leaf = 0; leaf < l->solution->elements->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++) {
            energy[c].lost_on_backs += l->lost[2 * n * leaf + c];
            energy[c].escaped += l->lost[2 * n * leaf + n + c];
        }
    }
}

hpr_status hpr_losses_add(hpr_losses *losses, hpr_energy *energy)
{
    hpr_context *ctx = losses->solution->context;
    size_t leaves = losses->solution->elements->leaf_count;
    hpr_status status = prepare(losses);
    if (status == HPR_OK)
        status = hpr_losses_on_nodes(losses);
    if (status == HPR_OK) {
#pragma omp parallel for schedule(dynamic, 8) num_threads(hpr_context_threads(ctx))
        for (size_t leaf = 0; leaf < leaves; leaf++) {
            if (!losses->done[leaf] && !hpr_cancelled(ctx))
                lose_from_leaf(losses, leaf);
        }
        sum_up(losses, energy);
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted during the energy balance");
    }
    hpr_visibility_destroy(&losses->visibility);
    hpr_release(ctx, losses->shaded);
    hpr_release(ctx, losses->done);
    hpr_release(ctx, losses->lost);
    return status;
}
