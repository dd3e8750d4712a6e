#include "app/study_error.h"

#include "math/planar_basis.h"
#include "reconstruct/reconstruct.h"

#include <math.h>
#include <string.h>

/* Halvings below a patch that are followed: as many as a tree can have. */
enum { MOST_HALVINGS = 2 * (HPR_MAX_SUBDIVIDE + HPR_MAX_FEET + HPR_MAX_GRADE) };

/* Node `index` of n x n over the parameters of a leaf; the weights add up to 1. */
static hpr_planar_node place_node(hpr_shape shape, const double opposite[2], int n, int index)
{
    const hpr_gauss_rule *rule = &hpr_gauss.legendre[n];
    hpr_planar_node node;
    if (shape == HPR_SHAPE_QUADRILATERAL) {
        node = hpr_planar_gauss(opposite, rule, n, index);
    } else {
        bool triangle = shape == HPR_SHAPE_TRIANGLE;
        const hpr_gauss_rule *first = triangle ? &hpr_gauss.jacobi[n] : rule;
        node.s = first->node[index / n];
        node.t = rule->node[index % n] * (triangle ? 1 - node.s : 1);
        node.weight = first->weight[index / n] * rule->weight[index % n];
    }
    node.weight /= hpr_shape_measure(shape, opposite);
    return node;
}

/* Gauss points of a leaf of the measuring mesh, appended. */
static void place_points(hpr_yardstick *y, const hpr_elements *e, size_t leaf, int n)
{
    const hpr_patches *patches = y->truth->patches;
    size_t node = e->leaf[leaf], patch = e->patch[node];
    hpr_shape shape = (hpr_shape)patches->shape[patch];
    for (int i = 0; i < n * n; i++) {
        hpr_planar_node x = place_node(shape, e->opposite + 2 * node, n, i);
        double point[3];
        for (int k = 0; k < 3; k++)
            point[k] = e->origin[3 * node + k] + x.s * e->edge1[3 * node + k] + x.t * e->edge2[3 * node + k];
        size_t at = y->count++;
        hpr_patch_parameters(patches, patch, point, &y->place[2 * at], &y->place[2 * at + 1]);
        y->patch[at] = (uint32_t)patch;
        y->weight[at] = e->area_m2[node] * x.weight;
    }
}

/* Makes pieces like the truth's elements, and halves them on to `subdivide` halvings per axis. The pieces
 * come in the order of the tree, so that the truth's nodes can be followed. */
typedef struct follower {
    const hpr_elements *truth;
    int subdivide;
    uint32_t next[MOST_HALVINGS + 1]; /* node of the next piece of each depth, HPR_NONE: below a leaf */
} follower;

static int follow(void *user, const hpr_piece_of_leaf *piece)
{
    follower *f = user;
    int depth = piece->depth;
    uint32_t node = depth ? f->next[depth] : piece->patch, child = HPR_NONE;
    if (depth && node != HPR_NONE)
        f->next[depth]++; /* the sibling comes next */
    if (node != HPR_NONE)
        child = f->truth->child[node];
    if (depth == MOST_HALVINGS || (child == HPR_NONE && piece->level >= 2 * f->subdivide))
        return -1;
    f->next[depth + 1] = child;
    return child != HPR_NONE ? f->truth->axis[node] : piece->level % 2;
}

/* The cells that are integrated over. */
static hpr_status make_mesh(const hpr_solution *truth, int subdivide, hpr_elements **mesh)
{
    follower *f = NULL;
    hpr_status status = hpr_elements_uniform(truth->patches, 0, 0, mesh);
    if (status == HPR_OK)
        status = hpr_allocate_into(truth->context, &f, 1, sizeof *f, "points to measure at");
    if (status == HPR_OK) {
        *f = (follower){.truth = truth->elements, .subdivide = subdivide};
        status = hpr_elements_refine(truth->patches, *mesh, follow, f);
    }
    hpr_release(truth->context, f);
    return status;
}

static hpr_status place_all(hpr_yardstick *y, const hpr_yardstick_points *points)
{
    hpr_context *ctx = y->context;
    hpr_elements *mesh = NULL;
    hpr_status status = make_mesh(y->truth, points->subdivide, &mesh);
    size_t count =
        status == HPR_OK ? mesh->leaf_count * (size_t)points->per_edge * (size_t)points->per_edge : 0;
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &y->patch, count, sizeof *y->patch, "points to measure at");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &y->place, count, 2 * sizeof *y->place, "points to measure at");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &y->weight, count, sizeof *y->weight, "points to measure at");
    if (status == HPR_OK) {
        for (size_t leaf = 0; leaf < mesh->leaf_count; leaf++)
            place_points(y, mesh, leaf, points->per_edge);
    }
    hpr_elements_destroy(&mesh);
    return status;
}

/* H of a solution at all points; value [count][channels]. */
static hpr_status evaluate(const hpr_yardstick *y, const hpr_solution *solution, double *value)
{
    hpr_reconstruction r = {0};
    size_t n = solution->channel_count;
    hpr_status status = hpr_reconstruction_init(solution, &r);
    if (status == HPR_OK) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(hpr_context_threads(y->context))
        for (size_t i = 0; i < y->count; i++)
            hpr_reconstruct_point(&r, y->patch[i], y->place[2 * i], y->place[2 * i + 1], value + n * i);
    }
    hpr_reconstruction_fini(&r);
    return status;
}

/* H at the points that were given; value [probe_count][channels]. */
static hpr_status probe(const hpr_yardstick *y, const hpr_solution *solution, double *value)
{
    hpr_context *ctx = y->context;
    double *radiosity = NULL;
    uint32_t *patch = NULL;
    hpr_status status = hpr_allocate_into(ctx, &radiosity, y->probe_count * solution->channel_count,
                                          sizeof *radiosity, "points to measure at");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &patch, y->probe_count, sizeof *patch, "points to measure at");
    if (status == HPR_OK)
        status = hpr_solution_probe(ctx, solution, y->probe_count, y->probe, y->probe_normal, value,
                                    radiosity, patch);
    hpr_release(ctx, radiosity);
    hpr_release(ctx, patch);
    return status;
}

hpr_status hpr_yardstick_init(const hpr_solution *truth, const hpr_yardstick_points *points, hpr_yardstick *y)
{
    hpr_context *ctx = truth->context;
    size_t n = truth->channel_count;
    *y = (hpr_yardstick){.context = ctx,
                         .truth = truth,
                         .probe_count = points->probe_count,
                         .probe = points->probe,
                         .probe_normal = points->probe_normal};
    hpr_status status = place_all(y, points);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &y->value, y->count * n, sizeof *y->value, "points to measure at");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &y->probe_value, y->probe_count * n, sizeof *y->probe_value,
                                   "points to measure at");
    if (status == HPR_OK)
        status = evaluate(y, truth, y->value);
    if (status == HPR_OK)
        status = probe(y, truth, y->probe_value);
    for (size_t i = 0; status == HPR_OK && points->known && i < y->probe_count * n; i++)
        y->probe_value[i] = isnan(y->probe_value[i]) ? NAN : points->known[i];
    if (status != HPR_OK)
        hpr_yardstick_fini(y);
    return status;
}

void hpr_yardstick_fini(hpr_yardstick *y)
{
    if (!y->context)
        return;
    void *arrays[] = {y->patch, y->place, y->weight, y->value, y->probe_value};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(y->context, arrays[i]);
    *y = (hpr_yardstick){0};
}

/* 0 / 0 is 0: nothing there, nothing missed. */
static double relative(double error, double norm)
{
    return error == 0 ? 0 : error / norm;
}

/* Of one channel; what is larger than what `row` has replaces it. */
static void measure_channel(const hpr_yardstick *y, const double *value, size_t channel, hpr_study_row *row)
{
    size_t n = y->truth->channel_count;
    double off1 = 0, all1 = 0, off2 = 0, all2 = 0, off_most = 0, all_most = 0;
    double face_area = 0, face_off = 0, face_all = 0, mean_off = 0, mean_all = 0;
    for (size_t i = 0; i < y->count; i++) {
        double w = y->weight[i], exact = y->value[n * i + channel], off = value[n * i + channel] - exact;
        off1 += w * fabs(off);
        all1 += w * fabs(exact);
        off2 += w * off * off;
        all2 += w * exact * exact;
        off_most = fmax(off_most, fabs(off));
        all_most = fmax(all_most, fabs(exact));
        face_area += w;
        face_off += w * off;
        face_all += w * exact;
        if (i + 1 == y->count || y->patch[i + 1] != y->patch[i]) {
            mean_off = fmax(mean_off, fabs(face_off) / face_area);
            mean_all = fmax(mean_all, fabs(face_all) / face_area);
            face_area = face_off = face_all = 0;
        }
    }
    row->error_l1 = fmax(row->error_l1, relative(off1, all1));
    row->error_l2 = fmax(row->error_l2, sqrt(relative(off2, all2)));
    row->error_linf = fmax(row->error_linf, relative(off_most, all_most));
    row->error_face_means = fmax(row->error_face_means, relative(mean_off, mean_all));
}

static void measure_probes(const hpr_yardstick *y, const double *value, hpr_study_row *row)
{
    size_t n = y->truth->channel_count;
    for (size_t c = 0; c < n; c++) {
        double off_most = 0, all_most = 0, off2 = 0, all2 = 0;
        size_t matched = 0;
        for (size_t i = 0; i < y->probe_count; i++) {
            double exact = y->probe_value[n * i + c];
            if (isnan(exact))
                continue;
            double off = value[n * i + c] - exact;
            matched++;
            off2 += off * off;
            all2 += exact * exact;
            off_most = fmax(off_most, fabs(off));
            all_most = fmax(all_most, fabs(exact));
        }
        if (!matched)
            continue;
        row->error_points = fmax(row->error_points, relative(off_most, all_most)); /* NaN gives way */
        row->error_points_l2 = fmax(row->error_points_l2, sqrt(relative(off2, all2)));
    }
}

static bool same_patches(const hpr_solution *a, const hpr_solution *b)
{
    const hpr_patches *p = a->patches, *q = b->patches;
    return a->channel_count == b->channel_count && p->count == q->count &&
           !memcmp(p->origin, q->origin, 3 * p->count * sizeof *p->origin) &&
           !memcmp(p->edge1, q->edge1, 3 * p->count * sizeof *p->edge1) &&
           !memcmp(p->edge2, q->edge2, 3 * p->count * sizeof *p->edge2);
}

hpr_status hpr_yardstick_measure(const hpr_yardstick *y, const hpr_solution *solution, hpr_study_row *row)
{
    hpr_context *ctx = y->context;
    size_t n = y->truth->channel_count;
    double *value = NULL, *probed = NULL;
    if (!same_patches(y->truth, solution))
        return hpr_fail(ctx, HPR_ERR_FORMAT,
                        "the solution to compare with is not of this scene: its surfaces "
                        "or channels differ");
    hpr_status status = hpr_allocate_into(ctx, &value, y->count * n, sizeof *value, "points to measure at");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &probed, y->probe_count * n, sizeof *probed, "points to measure at");
    if (status == HPR_OK)
        status = evaluate(y, solution, value);
    if (status == HPR_OK)
        status = probe(y, solution, probed);
    if (status == HPR_OK) {
        row->error_l1 = row->error_l2 = row->error_linf = row->error_face_means = 0;
        row->error_points = row->error_points_l2 = NAN;
        for (size_t c = 0; c < n; c++)
            measure_channel(y, value, c, row);
        measure_probes(y, probed, row);
    }
    hpr_release(ctx, value);
    hpr_release(ctx, probed);
    return status;
}
