#include "link/quad_tables.h"

#include "basis/basis.h"
#include "math/planar_basis.h"
#include "quadrature/pair.h"

struct hpr_quad_tables {
    hpr_context *context;
    const hpr_patches *patches;
    const hpr_elements *elements;
    const uint8_t *degree;
    size_t *basis_at, *matrix_at; /* [node_count] */
    double *basis, *matrix;
};

static bool is_inner(const hpr_quad_tables *t, size_t node)
{
    return t->elements->child[node] != HPR_NONE &&
           t->patches->shape[t->elements->patch[node]] == HPR_SHAPE_QUADRILATERAL;
}

static size_t functions(const hpr_quad_tables *t, size_t node)
{
    return hpr_basis_count(HPR_SHAPE_QUADRILATERAL, t->degree[node]);
}

/* Counts the doubles of both arrays; *highest receives the highest degree of an inner node, -1: none. */
static void place(hpr_quad_tables *t, size_t *basis, size_t *matrix, int *highest)
{
    *basis = *matrix = 0;
    *highest = -1;
    for (size_t node = 0; node < t->elements->node_count; node++) {
        if (!is_inner(t, node))
            continue;
        t->basis_at[node] = *basis;
        *basis += hpr_planar_size(t->degree[node]);
        *highest = t->degree[node] > *highest ? t->degree[node] : *highest;
        for (size_t child = t->elements->child[node]; child < t->elements->child[node] + 2u; child++) {
            t->matrix_at[child] = *matrix;
            *matrix += functions(t, node) * functions(t, child);
        }
    }
}

/* The frame of a node with its basis. */
static hpr_element_frame frame_of(const hpr_quad_tables *t, size_t node)
{
    hpr_element_frame frame = hpr_node_frame(t->patches, t->elements, node);
    frame.degree = t->degree[node];
    if (is_inner(t, node))
        frame.recurrence = t->basis + t->basis_at[node];
    return frame;
}

static void make_matrix(const hpr_quad_tables *t, size_t node, int which)
{
    size_t child = t->elements->child[node] + (size_t)which;
    const hpr_element_frame whole = frame_of(t, node), half = frame_of(t, child);
    const hpr_quad_piece piece = hpr_quad_half(whole.opposite, t->elements->axis[node], which);
    double *matrix = t->matrix + t->matrix_at[child], on_whole[HPR_MAX_BASIS], on_half[HPR_MAX_BASIS];
    size_t rows = functions(t, node), columns = functions(t, child);
    int nodes = (whole.degree > half.degree ? whole.degree : half.degree) + 1;
    double factor = hpr_frame_jacobian(&half) * hpr_frame_scale(&whole) * hpr_frame_scale(&half);
    for (int q = 0; q < nodes * nodes; q++) {
        hpr_planar_node x = hpr_planar_gauss(half.opposite, &hpr_gauss.legendre[nodes], nodes, q);
        hpr_frame_basis(&half, x.s, x.t, on_half);
        hpr_frame_basis(&whole, piece.origin[0] + x.s * piece.edge1[0] + x.t * piece.edge2[0],
                        piece.origin[1] + x.s * piece.edge1[1] + x.t * piece.edge2[1], on_whole);
        for (size_t k = 0; k < rows; k++) {
            for (size_t l = 0; l < columns; l++)
                matrix[k * columns + l] += factor * x.weight * on_whole[k] * on_half[l];
        }
    }
}

static hpr_status make_all(hpr_quad_tables *t, int highest)
{
    hpr_context *ctx = t->context;
    const hpr_elements *e = t->elements;
    double *scratch = NULL;
    hpr_status status = hpr_allocate_into(ctx, &scratch, hpr_planar_scratch(highest), sizeof(double),
                                          "the trees of elements");
    for (size_t node = 0; status == HPR_OK && node < e->node_count; node++) {
        if (is_inner(t, node))
            hpr_planar_make(e->opposite + 2 * node, t->degree[node], &hpr_gauss.legendre[t->degree[node] + 1],
                            t->basis + t->basis_at[node], scratch);
    }
    for (size_t node = 0; status == HPR_OK && node < e->node_count; node++) {
        for (int which = 0; which < 2 && is_inner(t, node); which++)
            make_matrix(t, node, which);
    }
    hpr_release(ctx, scratch);
    return status;
}

hpr_status hpr_quad_tables_create(const hpr_patches *patches, const hpr_elements *elements,
                                  const uint8_t *degree, hpr_quad_tables **out)
{
    hpr_context *ctx = elements->context;
    hpr_quad_tables *t = NULL;
    size_t basis, matrix;
    int highest = -1;
    bool any = false;
    *out = NULL;
    for (size_t i = 0; i < patches->count && !any; i++)
        any = patches->shape[i] == HPR_SHAPE_QUADRILATERAL;
    if (!any)
        return HPR_OK;
    hpr_status status = hpr_allocate_into(ctx, &t, 1, sizeof *t, "the trees of elements");
    if (status != HPR_OK)
        return status;
    *t = (hpr_quad_tables){.context = ctx, .patches = patches, .elements = elements, .degree = degree};
    status =
        hpr_allocate_into(ctx, &t->basis_at, elements->node_count, sizeof(size_t), "the trees of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->matrix_at, elements->node_count, sizeof(size_t),
                                   "the trees of elements");
    if (status == HPR_OK) {
        place(t, &basis, &matrix, &highest);
        status = hpr_allocate_into(ctx, &t->basis, basis, sizeof(double), "the trees of elements");
    }
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->matrix, matrix, sizeof(double), "the trees of elements");
    if (status == HPR_OK && highest >= 0)
        status = make_all(t, highest);
    if (status != HPR_OK)
        hpr_quad_tables_destroy(&t);
    *out = t;
    return status;
}

void hpr_quad_tables_destroy(hpr_quad_tables **out)
{
    hpr_quad_tables *t = *out;
    if (!t)
        return;
    hpr_context *ctx = t->context;
    hpr_release(ctx, t->basis_at);
    hpr_release(ctx, t->matrix_at);
    hpr_release(ctx, t->basis);
    hpr_release(ctx, t->matrix);
    hpr_release(ctx, t);
    *out = NULL;
}

const double *hpr_quad_tables_basis(const hpr_quad_tables *t, size_t node)
{
    return t->basis + t->basis_at[node];
}

const double *hpr_quad_tables_matrix(const hpr_quad_tables *t, size_t child)
{
    return t->matrix + t->matrix_at[child];
}
