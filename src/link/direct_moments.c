#include "link/direct_moments.h"

#include "direct/lambert.h"
#include "math/planar_basis.h"
#include "quadrature/block.h"
#include "quadrature/far.h"

#include <math.h>
#include <omp.h>
#include <string.h>

typedef struct worker {
    hpr_block_scratch *scratch;
    uint64_t counts[HPR_COUNTER_COUNT];
} worker;

typedef struct projection {
    const hpr_direct *direct;
    const hpr_coverage *coverage;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_quadrature *quadrature;
    double open_tolerance, blocked_tolerance;
    double *moment;
} projection;

static hpr_element_frame emitter_frame(const hpr_emitter *emitter)
{
    return (hpr_element_frame){.shape = emitter->shape,
                               .origin = emitter->origin,
                               .edge1 = emitter->edge1,
                               .edge2 = emitter->edge2,
                               .normal = emitter->normal,
                               .area_m2 = emitter->area_m2,
                               .opposite = {emitter->opposite[0], emitter->opposite[1]}};
}

/* Nodes per axis with which product Gauss over the leaf, and Lambert's formula at the nodes, is exact to
 * rounding: the kernel's coefficients fall like rho^-n. 0: too many, or the kernel has a kink. */
static int smooth_nodes(const hpr_element_frame *recv, const hpr_element_frame *send)
{
    enum { MAX_NODES = 8 };
    static const double rounding = 1e-15;
    hpr_far_view view = hpr_far_foretell(recv, send);
    if (view.hidden || view.recv_straddles || view.send_straddles || !(view.recv_rho > 1))
        return 0;
    double nodes = ceil((log(1 / rounding) / log(view.recv_rho) + recv->degree) / 2);
    return nodes <= MAX_NODES ? (int)fmax(nodes, 1) : 0;
}

/* The block of the leaf and the constant of the emitter: ∫ T_k F dA / sqrt(A_e), F Lambert's fraction. */
static void integrate_smooth(const hpr_element_frame *recv, const hpr_element_frame *send, int nodes,
                             double *column)
{
    bool triangle = recv->shape == HPR_SHAPE_TRIANGLE, skew = recv->shape == HPR_SHAPE_QUADRILATERAL;
    const hpr_gauss_rule *first = &hpr_gauss.legendre[nodes],
                         *second = triangle ? &hpr_gauss.jacobi[nodes] : first;
    hpr_cell whole = hpr_cell_whole(send);
    hpr_vec3 at[4];
    double corner[4][3], normal[3], phi[HPR_MAX_BASIS];
    size_t corners = (size_t)hpr_cell_corners(send, &whole, at),
           count = hpr_basis_count(recv->shape, recv->degree);
    for (size_t i = 0; i < corners; i++)
        hpr_vec3_store(corner[i], at[i]);
    hpr_vec3_store(normal, recv->normal);
    double factor = hpr_frame_jacobian(recv) * hpr_frame_scale(recv) / sqrt(send->area_m2);
    memset(column, 0, count * sizeof *column);
    for (int k = 0; k < nodes * nodes; k++) {
        double t = second->node[k / nodes], s = first->node[k % nodes] * (triangle ? 1 - t : 1), point[3];
        double part = factor * first->weight[k % nodes] * second->weight[k / nodes];
        if (skew) {
            hpr_planar_node node = hpr_planar_gauss(recv->opposite, first, nodes, k);
            s = node.s;
            t = node.t;
            part = factor * node.weight;
        }
        hpr_vec3_store(point, hpr_frame_point(recv, s, t));
        double fraction = hpr_lambert_fraction(point, normal, (const double(*)[3])corner, corners);
        double weight = part * fraction;
        hpr_frame_basis(recv, s, t, phi);
        for (size_t i = 0; i < count; i++)
            column[i] += weight * phi[i];
    }
}

static hpr_block_result integrate(const projection *p, worker *w, const hpr_block_task *task, double *column)
{
    int nodes = task->blocker_count || task->recv_part ? 0 : smooth_nodes(&task->recv, &task->send);
    if (nodes == 0)
        return hpr_block(p->quadrature, task, column, w->scratch);
    integrate_smooth(&task->recv, &task->send, nodes, column);
    return (hpr_block_result){.seen = true};
}

static void add_emitter(const projection *p, worker *w, size_t leaf, size_t k)
{
    hpr_sight sight = hpr_direct_sight(p->direct, leaf, k);
    if (sight.verdict == HPR_SEES_NOTHING)
        return;
    double tolerance = sight.blocker_count ? p->blocked_tolerance : p->open_tolerance;
    hpr_emitter emitter = hpr_direct_emitter(p->direct, k);
    hpr_block_task task = {.recv = hpr_leaf_frame(p->patches, p->elements, leaf),
                           .send = emitter_frame(&emitter),
                           .tolerance = tolerance,
                           .negligible = tolerance,
                           .contact_m = p->patches->weld_m,
                           .visibility = hpr_direct_visibility(p->direct),
                           .blockers = sight.blockers,
                           .blocker_count = sight.blocker_count,
                           .clip = true};
    task.recv_part = hpr_coverage_parts(p->coverage, leaf, &task.recv_part_count);
    if (task.recv_part && task.recv_part_count == 0)
        return; /* covered */
    double column[HPR_MAX_BASIS];
    hpr_block_result result = integrate(p, w, &task, column);
    const hpr_elements *e = p->elements;
    size_t first = e->dof[leaf], dofs = e->dof[e->leaf_count];
    for (size_t c = 0; c < p->patches->channel_count; c++) {
        double sent = sqrt(emitter.area_m2) * emitter.exitance[c];
        for (size_t i = first; i < e->dof[leaf + 1]; i++)
            p->moment[c * dofs + i] += sent * column[i - first];
    }
    w->counts[HPR_COUNT_BLOCKS] += result.seen;
    w->counts[HPR_COUNT_KERNEL] += result.kernel_count;
    w->counts[HPR_COUNT_RAYS] += result.ray_count;
    w->counts[HPR_COUNT_CLIPS] += result.clip_count;
    w->counts[HPR_COUNT_SHORT] += result.status >= HPR_BLOCK_SHORT;
    w->counts[HPR_COUNT_ROUNDED] += result.status == HPR_BLOCK_ROUNDED;
}

static void project_all(const projection *p, worker *workers, hpr_context *ctx)
{
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t leaf = 0; leaf < p->elements->leaf_count; leaf++) {
        for (size_t k = 0; k < hpr_direct_emitter_count(p->direct) && !hpr_cancelled(ctx); k++)
            add_emitter(p, &workers[omp_get_thread_num()], leaf, k);
    }
}

hpr_status hpr_direct_moments(const hpr_direct *direct, const hpr_coverage *coverage,
                              const hpr_elements *elements, double open_tolerance, double blocked_tolerance,
                              double *moment, size_t *short_count)
{
    const hpr_patches *patches = hpr_coverage_patches(coverage);
    hpr_context *ctx = patches->context;
    int threads = hpr_context_threads(ctx);
    worker *workers = NULL;
    projection p = {.direct = direct,
                    .coverage = coverage,
                    .patches = patches,
                    .elements = elements,
                    .open_tolerance = open_tolerance,
                    .blocked_tolerance = blocked_tolerance,
                    .moment = moment};
    hpr_status status = hpr_quadrature_create(ctx, &p.quadrature);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &workers, (size_t)threads, sizeof *workers, "direct light");
    for (int t = 0; status == HPR_OK && t < threads; t++)
        status = hpr_block_scratch_create(ctx, &workers[t].scratch);
    if (status == HPR_OK)
        project_all(&p, workers, ctx);
    for (int t = 0; workers && t < threads; t++) {
        for (int c = 0; c < HPR_COUNTER_COUNT; c++)
            hpr_count(ctx, (hpr_counter)c, workers[t].counts[c]);
        *short_count += workers[t].counts[HPR_COUNT_SHORT];
        hpr_block_scratch_destroy(&workers[t].scratch);
    }
    hpr_release(ctx, workers);
    hpr_quadrature_destroy(&p.quadrature);
    if (status == HPR_OK && hpr_cancelled(ctx))
        status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while direct light was projected");
    return status;
}
