#include "link/environment_moments.h"

#include "quadrature/block.h"
#include "quadrature/cuts.h"

#include <omp.h>
#include <string.h>

enum {
    MAX_CLOSED_PATCHES = 512, /* whether a patch is unobstructed takes a look at all pairs of others */
    CUTTING_DEPTH = 1,        /* cells of this depth are cut at contacts */
    MAX_DEPTH = 12,           /* quarterings of a cell */
    MAX_CELLS = 2000,         /* of a leaf */
    RAYS = 1 << 23,           /* about so many in all, but LEAST_SIDE^2 per lattice of each point at least */
    LEAST_SIDE = 2,
    MOST_SIDE = 16
};

typedef enum treatment { CLOSED_FORM, CLIPPED, SAMPLED, TREATMENTS } treatment;

typedef struct worker {
    hpr_block_scratch *scratch;
    uint64_t counts[HPR_COUNTER_COUNT];
} worker;

typedef struct projection {
    const hpr_environment *environment;
    const hpr_coverage *coverage;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_quadrature *quadrature;
    double tolerance;
    int side;           /* of sampled points */
    uint8_t *treatment; /* [leaves] */
    double *error;      /* [leaves] of the mean of V */
    double *moment;
} projection;

/* A leaf while its moments are integrated. */
typedef struct leaf_integral {
    const projection *p;
    worker *worker;
    hpr_element_frame frame;
    size_t patch, leaf, count; /* count: of functions */
    int nodes;                 /* along each axis of a cell */
    int cells;
    double allowed, error; /* of a cell and in all, absolute, of a moment */
    double *moment;        /* [count] */
} leaf_integral;

static hpr_element_frame patch_frame(const hpr_patches *patches, size_t patch, bool back)
{
    hpr_element_frame frame = {
        .shape = (hpr_shape)patches->shape[patch],
        .origin = hpr_vec3_load(patches->origin + 3 * patch),
        .edge1 = hpr_vec3_load((back ? patches->edge2 : patches->edge1) + 3 * patch),
        .edge2 = hpr_vec3_load((back ? patches->edge1 : patches->edge2) + 3 * patch),
        .normal = hpr_vec3_load(patches->normal + 3 * patch),
        .area_m2 = patches->area_m2[patch],
        .opposite = {patches->opposite[2 * patch + back], patches->opposite[2 * patch + !back]}};
    if (back)
        frame.normal = hpr_scale(frame.normal, -1);
    return frame;
}

/* Nothing is open at these points, and if all that a leaf sees is unobstructed, then nowhere on it. */
static bool closed_at_points(const leaf_integral *l)
{
    double third = l->frame.shape == HPR_SHAPE_TRIANGLE ? 0.2 : 0.25;
    for (int k = 0; k < 4; k++) {
        double at[2] = {(1 + 2 * (k % 2)) * third, (1 + 2 * (k / 2)) * third};
        if (l->frame.shape == HPR_SHAPE_QUADRILATERAL)
            hpr_shape_uniform(l->frame.shape, l->frame.opposite, at[0], at[1], at);
        hpr_vec3 x = hpr_frame_point(&l->frame, at[0], at[1]);
        if (k == 3 && l->frame.shape == HPR_SHAPE_TRIANGLE)
            x = hpr_frame_point(&l->frame, 1.0 / 3, 1.0 / 3);
        if (hpr_environment_opening(l->p->environment, l->patch, x).part > 0)
            return false;
    }
    return true;
}

/* ∫ T_k V = sqrt(A) delta_k0 - sum over all sides j of sqrt(A_j) K_kj: what does not see them sees out. */
static void by_closure(leaf_integral *l)
{
    static const double tolerance = 1e-12;
    const hpr_patches *patches = l->p->patches;
    double column[HPR_MAX_BASIS];
    if (closed_at_points(l))
        return;
    l->moment[0] = sqrt(l->frame.area_m2);
    for (size_t j = 0; j < patches->count; j++) {
        bool second = patches->twin[j] != HPR_NONE && patches->side[j] != 0;
        for (int back = 0; back < 2 && !second && j != l->patch && j != patches->twin[l->patch]; back++) {
            hpr_block_task task = {.recv = l->frame,
                                   .send = patch_frame(patches, j, back),
                                   .tolerance = tolerance,
                                   .negligible = tolerance,
                                   .contact_m = patches->weld_m};
            hpr_block_result result = hpr_block(l->p->quadrature, &task, column, l->worker->scratch);
            for (size_t k = 0; k < l->count; k++)
                l->moment[k] -= sqrt(patches->area_m2[j]) * column[k];
            l->worker->counts[HPR_COUNT_BLOCKS] += result.seen;
            l->worker->counts[HPR_COUNT_KERNEL] += result.kernel_count;
            l->worker->counts[HPR_COUNT_SHORT] += result.status == HPR_BLOCK_SHORT;
            l->worker->counts[HPR_COUNT_ROUNDED] += result.status == HPR_BLOCK_ROUNDED;
        }
    }
}

/* Adds weight * V T_k at the point (s,t); weight in parameter measure. */
static void add_value(const leaf_integral *l, double s, double t, double weight, double *sum)
{
    double basis[HPR_MAX_BASIS];
    double factor = weight * hpr_frame_jacobian(&l->frame) * hpr_frame_scale(&l->frame);
    hpr_frame_basis(&l->frame, s, t, basis);
    for (size_t k = 0; k < l->count; k++)
        sum[k] += factor * basis[k];
}

/* Gauss point `index` of nodes x nodes in a cell; weight in the leaf's parameter measure. */
typedef struct cell_point {
    double s, t, weight;
} cell_point;

static cell_point point_of_cell(const hpr_cell *cell, int nodes, int index)
{
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    const hpr_gauss_rule *along = &hpr_gauss.legendre[nodes];
    const hpr_gauss_rule *across = triangle ? &hpr_gauss.jacobi[nodes] : along;
    double area = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]);
    double b = across->node[index / nodes], a = along->node[index % nodes] * (triangle ? 1 - b : 1);
    return (cell_point){cell->origin[0] + a * cell->edge1[0] + b * cell->edge2[0],
                        cell->origin[1] + a * cell->edge1[1] + b * cell->edge2[1],
                        area * across->weight[index / nodes] * along->weight[index % nodes]};
}

static void integrate_cell(leaf_integral *l, const hpr_cell *cell, double *sum)
{
    const projection *p = l->p;
    memset(sum, 0, l->count * sizeof *sum);
    l->cells++;
    for (int k = 0; k < l->nodes * l->nodes; k++) {
        cell_point x = point_of_cell(cell, l->nodes, k);
        double s = x.s, t = x.t;
        hpr_environment_limit(p->environment, l->leaf, &s, &t);
        hpr_opening opening =
            hpr_environment_opening(p->environment, l->patch, hpr_frame_point(&l->frame, s, t));
        add_value(l, x.s, x.t, x.weight * opening.part, sum);
        l->error += x.weight * opening.error * sqrt(l->frame.area_m2);
        l->worker->counts[HPR_COUNT_CLIPS]++;
    }
}

static void quarter(const hpr_cell *cell, hpr_cell part[4])
{
    for (int k = 0; k < 4; k++) {
        /* the last triangle is turned round its corner amid the longest side */
        bool turned = k == 3 && cell->shape == HPR_SHAPE_TRIANGLE;
        double a = turned ? 0.5 : 0.5 * (k % 2), b = turned ? 0.5 : 0.5 * (k / 2), sign = turned ? -0.5 : 0.5;
        part[k].shape = cell->shape;
        for (int i = 0; i < 2; i++) {
            part[k].origin[i] = cell->origin[i] + a * cell->edge1[i] + b * cell->edge2[i];
            part[k].edge1[i] = sign * cell->edge1[i];
            part[k].edge2[i] = sign * cell->edge2[i];
        }
    }
}

/* The corners of a cell in the leaf's parameters. */
static hpr_polygon cell_polygon(const hpr_cell *cell)
{
    static const double corner[2][4][2] = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 0}, {0, 1}}};
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    hpr_polygon polygon = {.count = triangle ? 3 : 4};
    for (int k = 0; k < polygon.count; k++) {
        for (int i = 0; i < 2; i++)
            polygon.corner[k][i] = cell->origin[i] + corner[triangle][k][0] * cell->edge1[i] +
                                   corner[triangle][k][1] * cell->edge2[i];
    }
    return polygon;
}

/* Cuts along the line through two points of the leaf's plane, unless the segment between them is aside. */
static void cut_along(const hpr_element_frame *frame, const hpr_polygon *cell, hpr_vec3 from, hpr_vec3 to,
                      hpr_cuts *pieces)
{
    hpr_vec3 across = hpr_cross(frame->edge1, frame->edge2), end[2] = {from, to};
    double square = hpr_dot(across, across), at[2][2];
    for (int i = 0; i < 2; i++) {
        hpr_vec3 offset = hpr_sub(end[i], frame->origin);
        at[i][0] = hpr_dot(hpr_cross(offset, frame->edge2), across) / square;
        at[i][1] = hpr_dot(hpr_cross(frame->edge1, offset), across) / square;
    }
    for (int axis = 0; axis < 2; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < cell->count; k++) {
            low = fmin(low, cell->corner[k][axis]);
            high = fmax(high, cell->corner[k][axis]);
        }
        if (fmax(at[0][axis], at[1][axis]) <= low || fmin(at[0][axis], at[1][axis]) >= high)
            return;
    }
    double ds = at[1][0] - at[0][0], dt = at[1][1] - at[0][1];
    const hpr_affine line = {at[0][1] * ds - at[0][0] * dt, dt, -ds};
    hpr_cuts_along(pieces, &line);
}

/* A cell cut where occluders stand on the leaf or go through it: there V jumps or has its sharpest kinks. */
static void cut_at_contacts(const leaf_integral *l, const hpr_cell *cell, hpr_cuts *pieces)
{
    size_t count;
    const hpr_convex *outline = hpr_environment_outlines(l->p->environment, &count);
    const hpr_polygon polygon = cell_polygon(cell);
    double touching = l->p->patches->weld_m;
    hpr_cuts_init(pieces, &polygon);
    for (size_t i = 0; i < count; i++) {
        hpr_vec3 contact[HPR_VISIBLE_CORNERS];
        int contacts = 0;
        double most = 0;
        for (int k = 0; k < outline[i].count; k++) {
            hpr_vec3 a = hpr_sub(outline[i].corner[k], l->frame.origin);
            hpr_vec3 b = hpr_sub(outline[i].corner[(k + 1) % outline[i].count], l->frame.origin);
            double ha = hpr_dot(l->frame.normal, a), hb = hpr_dot(l->frame.normal, b);
            most = fmax(most, ha);
            if (fabs(ha) <= touching)
                contact[contacts++] = outline[i].corner[k];
            else if (fabs(hb) > touching && ha * hb < 0)
                contact[contacts++] = hpr_add(l->frame.origin, hpr_madd(a, ha / (ha - hb), hpr_sub(b, a)));
        }
        if (most > touching && contacts >= 2)
            cut_along(&l->frame, &polygon, contact[0], contact[contacts - 1], pieces);
    }
}

static void refine(leaf_integral *l, const hpr_cell *cell, const double *whole, int depth);

/* False if the cell is not cut by any contact. */
static bool refine_pieces(leaf_integral *l, const hpr_cell *cell, int depth)
{
    hpr_cuts pieces;
    hpr_cell part[HPR_POLYGON_MAX];
    double sum[l->count];
    cut_at_contacts(l, cell, &pieces);
    for (int p = 0; p < pieces.count && pieces.count > 1; p++) {
        int count = hpr_cuts_fan(&pieces.piece[p], part);
        for (int i = 0; i < count; i++) {
            integrate_cell(l, &part[i], sum);
            refine(l, &part[i], sum, depth + 1);
        }
    }
    return pieces.count > 1;
}

static void refine(leaf_integral *l, const hpr_cell *cell, const double *whole, int depth)
{
    hpr_cell part[4];
    double sum[4][l->count], worst = 0;
    quarter(cell, part);
    for (int i = 0; i < 4; i++)
        integrate_cell(l, &part[i], sum[i]);
    for (size_t k = 0; k < l->count; k++)
        worst = fmax(worst, fabs(whole[k] - sum[0][k] - sum[1][k] - sum[2][k] - sum[3][k]));
    if (worst > l->allowed && depth < MAX_DEPTH && l->cells < MAX_CELLS) {
        /* Smooth leaves, and most of a closed view, do not get so far as to be cut. */
        bool cut = depth == CUTTING_DEPTH && refine_pieces(l, cell, depth);
        for (int i = 0; i < 4 && !cut; i++)
            refine(l, &part[i], sum[i], depth + 1);
        return;
    }
    l->error += worst;
    for (size_t k = 0; k < 4 * l->count; k++)
        l->moment[k % l->count] += sum[k / l->count][k % l->count];
}

/* The cells of the leaf's open part, up to `room` of them; their number. */
static int open_cells(const leaf_integral *l, hpr_cell *cell, int room)
{
    int parts, count = 0;
    const hpr_polygon *part = hpr_coverage_parts(l->p->coverage, l->leaf, &parts);
    const hpr_polygon outline = hpr_frame_outline(&l->frame);
    if (!part && l->frame.shape == HPR_SHAPE_QUADRILATERAL)
        count = hpr_cuts_fan(&outline, cell);
    else if (!part)
        cell[count++] = hpr_cell_whole(&l->frame);
    for (int i = 0; i < parts && count + HPR_POLYGON_MAX <= room; i++)
        count += hpr_cuts_fan(&part[i], cell + count);
    return count;
}

enum { MAX_OPEN_CELLS = HPR_COVERAGE_PIECES * HPR_POLYGON_MAX };

static void by_clipping(leaf_integral *l)
{
    static const double share = 0.25, least = 1e-6; /* of the tolerance, per cell; of a leaf in the open */
    hpr_cell cell[MAX_OPEN_CELLS];
    int count = open_cells(l, cell, MAX_OPEN_CELLS);
    double sum[l->count], total = 0;
    l->nodes = 3 + l->frame.degree / 2;
    for (int i = 0; i < count; i++) {
        integrate_cell(l, &cell[i], sum);
        total += sum[0];
    }
    l->allowed = share * fmax(l->p->tolerance * total, least * sqrt(l->frame.area_m2));
    for (int i = 0; i < count; i++) {
        if (count > 1)
            integrate_cell(l, &cell[i], sum);
        refine(l, &cell[i], sum, 0);
    }
}

/* Along each axis of an element, for the coarser of two rules: more than V of the element's own degree needs,
 * for V varies more than that. */
static int ray_nodes(int degree)
{
    return degree + 3;
}

/* Rays from nodes x nodes points of a cell: adds to the moments, returns the square of the standard error of
 * the first. */
static double sample_cell(leaf_integral *l, const hpr_cell *cell, int nodes, uint64_t seed, double *sum)
{
    const projection *p = l->p;
    double square = 0, area = l->frame.area_m2;
    for (int k = 0; k < nodes * nodes; k++) {
        cell_point x = point_of_cell(cell, nodes, k);
        hpr_opening opening = hpr_environment_sample(
            p->environment, l->patch, hpr_frame_point(&l->frame, x.s, x.t), p->side, seed + (uint64_t)k);
        double part = x.weight / hpr_frame_measure(&l->frame);
        add_value(l, x.s, x.t, x.weight * opening.part, sum);
        square += part * part * opening.error * opening.error * area;
    }
    l->worker->counts[HPR_COUNT_RAYS] += (uint64_t)(4 * p->side * p->side * nodes * nodes);
    return square;
}

/* The mean of two Gauss rules; what they differ by shows what the points miss. */
static void by_rays(leaf_integral *l)
{
    hpr_cell cell[MAX_OPEN_CELLS];
    int count = open_cells(l, cell, MAX_OPEN_CELLS), nodes = ray_nodes(l->frame.degree);
    uint64_t seed = (uint64_t)l->leaf << 20;
    double sum[2][l->count], square = 0;
    memset(sum, 0, sizeof sum);
    for (int i = 0; i < count; i++) {
        for (int rule = 0; rule < 2; rule++) {
            square += sample_cell(l, &cell[i], nodes + rule, seed, sum[rule]) / 4;
            seed += (uint64_t)((nodes + rule) * (nodes + rule));
        }
    }
    for (size_t k = 0; k < l->count; k++)
        l->moment[k] += (sum[0][k] + sum[1][k]) / 2;
    l->error = sqrt(square + pow((sum[0][0] - sum[1][0]) / 2, 2));
}

static void integrate_leaf(const projection *p, worker *w, size_t leaf)
{
    const hpr_elements *e = p->elements;
    leaf_integral l = {.p = p,
                       .worker = w,
                       .frame = hpr_leaf_frame(p->patches, e, leaf),
                       .patch = e->patch[e->leaf[leaf]],
                       .leaf = leaf,
                       .count = e->dof[leaf + 1] - e->dof[leaf],
                       .moment = p->moment + e->dof[leaf]};
    if (p->treatment[leaf] == CLOSED_FORM)
        by_closure(&l);
    else if (p->treatment[leaf] == CLIPPED)
        by_clipping(&l);
    else
        by_rays(&l);
    p->error[leaf] = l.error / sqrt(l.frame.area_m2);
}

static void choose_treatments(const projection *p, size_t patch)
{
    const hpr_visibility *visibility = hpr_environment_visibility(p->environment);
    const hpr_elements *e = p->elements;
    bool unobstructed =
        p->patches->count <= MAX_CLOSED_PATCHES && hpr_visibility_unobstructed(visibility, patch);
    for (size_t leaf = e->patch_leaf[patch]; leaf < e->patch_leaf[patch + 1]; leaf++) {
        int parts;
        bool whole = !hpr_coverage_parts(p->coverage, leaf, &parts);
        p->treatment[leaf] = !hpr_environment_affordable(p->environment) ? SAMPLED
                             : unobstructed && whole                     ? CLOSED_FORM
                                                                         : CLIPPED;
    }
}

static void treat(const projection *p, worker *workers, hpr_context *ctx)
{
    size_t done = 0, count = p->elements->leaf_count;
#pragma omp parallel num_threads(hpr_context_threads(ctx))
    {
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < p->patches->count; i++)
            choose_treatments(p, i);
#pragma omp for schedule(dynamic, 1)
        for (size_t leaf = 0; leaf < count; leaf++) {
            if (hpr_cancelled(ctx))
                continue;
            integrate_leaf(p, &workers[omp_get_thread_num()], leaf);
#pragma omp critical(hpr_environment_progress)
            hpr_stage_progress(ctx, (double)++done / (double)count);
        }
    }
}

static void sum_up(const projection *p, hpr_environment_figures *figures)
{
    const hpr_elements *e = p->elements;
    size_t count[TREATMENTS] = {0};
    double square = 0, area = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        uint32_t node = e->leaf[leaf];
        count[p->treatment[leaf]]++;
        square += p->error[leaf] * p->error[leaf] * e->area_m2[node];
        area += e->area_m2[node];
    }
    *figures = (hpr_environment_figures){.closed_form = count[CLOSED_FORM],
                                         .clipped = count[CLIPPED],
                                         .sampled = count[SAMPLED],
                                         .error = area > 0 ? sqrt(square / area) : 0};
}

/* Rays are shared out evenly. */
static int choose_side(const hpr_elements *elements)
{
    double points = 0;
    for (size_t leaf = 0; leaf < elements->leaf_count; leaf++) {
        int nodes = ray_nodes(elements->degree[elements->leaf[leaf]]);
        points += nodes * nodes + (nodes + 1) * (nodes + 1);
    }
    int side = LEAST_SIDE;
    while (side < MOST_SIDE && points * 4 * (side + 1) * (side + 1) <= RAYS)
        side++;
    return side;
}

hpr_status hpr_environment_moments(const hpr_environment *environment, const hpr_coverage *coverage,
                                   const hpr_elements *elements, double tolerance, double *moment,
                                   hpr_environment_figures *figures)
{
    static const char what[] = "light from outside";
    const hpr_patches *patches = hpr_coverage_patches(coverage);
    hpr_context *ctx = patches->context;
    int threads = hpr_context_threads(ctx);
    worker *workers = NULL;
    projection p = {.environment = environment,
                    .coverage = coverage,
                    .patches = patches,
                    .elements = elements,
                    .tolerance = tolerance,
                    .side = choose_side(elements),
                    .moment = moment};
    hpr_status status = hpr_quadrature_create(ctx, &p.quadrature);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &p.treatment, elements->leaf_count, sizeof *p.treatment, what);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &p.error, elements->leaf_count, sizeof *p.error, what);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &workers, (size_t)threads, sizeof *workers, what);
    for (int t = 0; status == HPR_OK && t < threads; t++)
        status = hpr_block_scratch_create(ctx, &workers[t].scratch);
    if (status == HPR_OK) {
        treat(&p, workers, ctx);
        sum_up(&p, figures);
    }
    for (int t = 0; workers && t < threads; t++) {
        for (int c = 0; c < HPR_COUNTER_COUNT; c++)
            hpr_count(ctx, (hpr_counter)c, workers[t].counts[c]);
        hpr_block_scratch_destroy(&workers[t].scratch);
    }
    void *arrays[] = {workers, p.treatment, p.error};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_quadrature_destroy(&p.quadrature);
    if (status == HPR_OK && hpr_cancelled(ctx))
        status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while light from outside was projected");
    return status;
}
