/* The simple evaluation of kernel blocks: one group of points after the other, one receiver point at a time.
 */
#include "quadrature/evaluation.h"

static void kernel_row(const hpr_points *from, int i, const hpr_points *to, double scale, double *kernel)
{
    for (int j = 0; j < to->count; j++) {
        double dx = to->x[j] - from->x[i], dy = to->y[j] - from->y[i], dz = to->z[j] - from->z[i];
        double r2 = dx * dx + dy * dy + dz * dz;
        kernel[j] = scale * to->weight[j] / (r2 * r2);
    }
}

/* sum over `count` inner points from the first on of kernel * phi_l */
static void transport(hpr_block_scratch *scratch, const hpr_group_side *inner, size_t first, size_t count)
{
    const double *kernel = scratch->kernel + first;
    hpr_frame_basis_many(HPR_ISA_SSE2, inner->frame, count, inner->points->s + first,
                         inner->points->t + first, HPR_TABLE_POINTS, scratch->moments.basis,
                         scratch->moments.recurrences);
    for (size_t l = 0; l < inner->basis_count; l++) {
        const double *basis = scratch->moments.basis + l * HPR_TABLE_POINTS;
        for (size_t j = 0; j < count; j++)
            scratch->transported[l] += kernel[j] * basis[j];
    }
}

/* part += left rightT, left [n_recv], right [n_send] */
static void add_product(const hpr_evaluation *e, const double *left, const double *right)
{
    for (size_t k = 0; k < e->n_recv; k++) {
        for (size_t l = 0; l < e->n_send; l++)
            e->scratch->part[k * e->n_send + l] += left[k] * right[l];
    }
}

static void add_group(void *user, const hpr_group *group)
{
    hpr_evaluation *e = user;
    hpr_block_scratch *scratch = e->scratch;
    /* Each outer point costs an update of the whole block, so the side with fewer points is the outer one. */
    bool by_recv = group->recv.count <= group->send.count;
    const hpr_group_sides sides = hpr_evaluation_sides(e, group, by_recv);
    const hpr_group_side *outer = &sides.outer, *inner = &sides.inner;
    const double scale = group->scale / 3.14159265358979323846;
    size_t count = (size_t)inner->points->count;
    for (int i = 0; i < outer->points->count; i++) {
        kernel_row(outer->points, i, inner->points, scale * outer->points->weight[i], scratch->kernel);
        if (e->sampled)
            hpr_evaluation_sample(e, outer, i, inner, scratch->kernel);
        for (size_t l = 0; l < inner->basis_count; l++)
            scratch->transported[l] = 0;
        for (size_t first = 0; first < count; first += HPR_TABLE_POINTS)
            transport(scratch, inner, first,
                      count - first < HPR_TABLE_POINTS ? count - first : HPR_TABLE_POINTS);
        hpr_frame_basis(outer->frame, outer->points->s[i], outer->points->t[i], scratch->outer_basis);
        add_product(e, by_recv ? scratch->outer_basis : scratch->transported,
                    by_recv ? scratch->transported : scratch->outer_basis);
    }
    e->result->kernel_count += (uint64_t)group->recv.count * (uint64_t)group->send.count;
}

static void nothing(hpr_evaluation *e)
{
    (void)e;
}

const hpr_evaluator hpr_evaluator_simple = {nothing, add_group, nothing};
