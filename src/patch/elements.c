#include "patch/elements.h"

#include "math/planar_basis.h"
#include "math/vec3.h"

#include <hprad/solve.h>
#include <string.h>

/*
 * The frame of a node in the parameters of its patch: (s,t) = origin + a edge1 + b edge2; of a quadrilateral
 * in those of the bilinear map. All entries are dyadic, so halving is exact, and neighbours get the same bits
 * for a shared vertex.
 */
typedef struct frame {
    double origin[2], edge1[2], edge2[2];
} frame;

static frame child_frame(const frame *parent, hpr_shape shape, int axis, int which)
{
    frame child = *parent;
    for (int k = 0; k < 2; k++) {
        double o = parent->origin[k], a = parent->edge1[k], b = parent->edge2[k];
        if (shape == HPR_SHAPE_TRIANGLE) {
            /* The new vertex m halves the side v1-v2; children (m, v0, v1) and (m, v2, v0). */
            child.origin[k] = o + 0.5 * (a + b);
            child.edge1[k] = which ? 0.5 * (b - a) : -0.5 * (a + b);
            child.edge2[k] = which ? -0.5 * (a + b) : 0.5 * (a - b);
        } else if (axis == 0) {
            child.origin[k] = which ? o + 0.5 * a : o;
            child.edge1[k] = 0.5 * a;
        } else {
            child.origin[k] = which ? o + 0.5 * b : o;
            child.edge2[k] = 0.5 * b;
        }
    }
    return child;
}

/* From the bilinear map to the parameters of the patch. */
static void place_quadrilateral(const hpr_patches *patches, hpr_elements *elements, uint32_t node,
                                uint32_t patch, frame *f)
{
    const double *opposite = patches->opposite + 2 * (size_t)patch, width[2] = {f->edge1[0], f->edge2[1]};
    double measure;
    hpr_quad_piece piece = hpr_quad_box(opposite, f->origin, width, &measure);
    memcpy(f->origin, piece.origin, sizeof f->origin);
    memcpy(f->edge1, piece.edge1, sizeof f->edge1);
    memcpy(f->edge2, piece.edge2, sizeof f->edge2);
    memcpy(elements->opposite + 2 * (size_t)node, piece.opposite, sizeof piece.opposite);
    elements->area_m2[node] =
        patches->area_m2[patch] * (measure / hpr_shape_measure(HPR_SHAPE_QUADRILATERAL, opposite));
}

static void place_node(const hpr_patches *patches, hpr_elements *elements, uint32_t node, uint32_t patch,
                       const frame *f, int level)
{
    const double *origin = patches->origin + 3 * patch;
    const double *edge1 = patches->edge1 + 3 * patch, *edge2 = patches->edge2 + 3 * patch;
    elements->patch[node] = patch;
    elements->child[node] = HPR_NONE;
    elements->area_m2[node] = ldexp(patches->area_m2[patch], -level);
    frame piece = *f;
    if (patches->shape[patch] == HPR_SHAPE_QUADRILATERAL)
        place_quadrilateral(patches, elements, node, patch, &piece);
    f = &piece;
    for (int k = 0; k < 3; k++) {
        elements->origin[3 * node + k] = origin[k] + (f->origin[0] * edge1[k] + f->origin[1] * edge2[k]);
        elements->edge1[3 * node + k] = f->edge1[0] * edge1[k] + f->edge1[1] * edge2[k];
        elements->edge2[3 * node + k] = f->edge2[0] * edge1[k] + f->edge2[1] * edge2[k];
    }
}

typedef struct build {
    const hpr_patches *patches;
    hpr_elements *elements;
    uint32_t patch, next; /* next free node */
    int depth;
    uint8_t order;
} build;

/* Recursion is as deep as the tree, at most 2 HPR_MAX_SUBDIVIDE levels. */
static void build_node(build *b, uint32_t node, const frame *f, int level)
{
    hpr_elements *elements = b->elements;
    place_node(b->patches, elements, node, b->patch, f, level);
    elements->degree[node] = b->order;
    if (level == b->depth)
        return;
    hpr_shape shape = (hpr_shape)b->patches->shape[b->patch];
    int axis = shape != HPR_SHAPE_TRIANGLE ? level % 2 : 0;
    uint32_t child = b->next;
    b->next += 2;
    elements->child[node] = child;
    elements->axis[node] = (uint8_t)axis;
    for (int which = 0; which < 2; which++) {
        frame g = child_frame(f, shape, axis, which);
        build_node(b, child + (uint32_t)which, &g, level + 1);
    }
}

/* The arrays of nodes, so that they are made and grown alike. */
enum { NODE_COLUMNS = 9 };

typedef struct column {
    void *array; /* address of the pointer */
    size_t item_bytes;
} column;

static void node_columns(hpr_elements *elements, column columns[NODE_COLUMNS])
{
    const column all[NODE_COLUMNS] = {
        {&elements->patch, sizeof(uint32_t)},    {&elements->child, sizeof(uint32_t)},
        {&elements->axis, sizeof(uint8_t)},      {&elements->degree, sizeof(uint8_t)},
        {&elements->origin, 3 * sizeof(double)}, {&elements->edge1, 3 * sizeof(double)},
        {&elements->edge2, 3 * sizeof(double)},  {&elements->opposite, 2 * sizeof(double)},
        {&elements->area_m2, sizeof(double)},
    };
    memcpy(columns, all, sizeof all);
}

static hpr_status allocate_nodes(hpr_elements *elements)
{
    column columns[NODE_COLUMNS];
    hpr_status status = HPR_OK;
    node_columns(elements, columns);
    for (size_t i = 0; status == HPR_OK && i < NODE_COLUMNS; i++)
        status = hpr_allocate_into(elements->context, columns[i].array, elements->node_count,
                                   columns[i].item_bytes, "elements");
    return status;
}

hpr_status hpr_elements_uniform(const hpr_patches *patches, int order, int subdivide, hpr_elements **out)
{
    hpr_context *ctx = patches->context;
    *out = NULL;
    if (order < 0 || order > HPR_MAX_ORDER || subdivide < 0 || subdivide > HPR_MAX_SUBDIVIDE)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d or subdivision %d is out of range (0 .. %d, 0 .. %d)",
                        order, subdivide, HPR_MAX_ORDER, HPR_MAX_SUBDIVIDE);
    size_t per_patch = ((size_t)2 << (2 * subdivide)) - 1;
    if (patches->count >= HPR_NONE / per_patch)
        return hpr_fail(ctx, HPR_ERR_MEMORY,
                        "%zu patches in 4^%d elements each are more than 32-bit indices can name",
                        patches->count, subdivide);
    hpr_elements *elements = NULL;
    hpr_status status = hpr_allocate_into(ctx, &elements, 1, sizeof *elements, "elements");
    if (status != HPR_OK)
        return status;
    elements->context = ctx;
    elements->patch_count = patches->count;
    elements->node_count = patches->count * per_patch;
    status = allocate_nodes(elements);
    if (status != HPR_OK)
        goto done;
    build b = {.patches = patches,
               .elements = elements,
               .next = (uint32_t)patches->count,
               .depth = 2 * subdivide,
               .order = (uint8_t)order};
    for (b.patch = 0; b.patch < patches->count; b.patch++) {
        const frame whole = {{0, 0}, {1, 0}, {0, 1}};
        build_node(&b, b.patch, &whole, 0);
    }
    status = hpr_elements_index(patches, elements);
done:
    if (status != HPR_OK)
        hpr_elements_destroy(&elements);
    *out = elements;
    return status;
}

typedef struct refiner {
    build b;
    hpr_split_choice *choose;
    void *user;
    bool building; /* else the new nodes are only counted */
    size_t count;  /* new nodes */
} refiner;

/* node: of the piece, if it is being built */
static void refine_piece(refiner *r, uint32_t node, const frame *f, hpr_piece_of_leaf piece)
{
    hpr_elements *elements = r->b.elements;
    for (int k = 0; k < 2; k++) {
        piece.origin[k] = f->origin[k];
        piece.edge1[k] = f->edge1[k];
        piece.edge2[k] = f->edge2[k];
    }
    int axis = r->choose(r->user, &piece);
    if (axis < 0)
        return;
    hpr_shape shape = (hpr_shape)r->b.patches->shape[r->b.patch];
    uint32_t child = r->b.next;
    r->count += 2;
    if (r->building) {
        r->b.next += 2;
        elements->child[node] = child;
        elements->axis[node] = (uint8_t)axis;
    }
    piece.level++;
    piece.depth++;
    for (uint32_t which = 0; which < 2; which++) {
        frame g = child_frame(f, shape, axis, (int)which);
        if (r->building) {
            place_node(r->b.patches, elements, child + which, r->b.patch, &g, piece.level);
            elements->degree[child + which] = elements->degree[node];
        }
        refine_piece(r, child + which, &g, piece);
    }
}

/* Walks down to the leaves that there were, with the frames of the nodes. */
static void refine_below(refiner *r, uint32_t node, const frame *f, int level)
{
    const hpr_elements *elements = r->b.elements;
    uint32_t child = elements->child[node];
    if (child == HPR_NONE) {
        refine_piece(
            r, node, f,
            (hpr_piece_of_leaf){.patch = r->b.patch, .leaf = elements->leaf_of_node[node], .level = level});
        return;
    }
    hpr_shape shape = (hpr_shape)r->b.patches->shape[r->b.patch];
    for (uint32_t which = 0; which < 2; which++) {
        frame g = child_frame(f, shape, elements->axis[node], (int)which);
        refine_below(r, child + which, &g, level + 1);
    }
}

static void refine_all(refiner *r)
{
    for (r->b.patch = 0; r->b.patch < r->b.patches->count; r->b.patch++) {
        const frame whole = {{0, 0}, {1, 0}, {0, 1}};
        refine_below(r, r->b.patch, &whole, 0);
    }
}

hpr_status hpr_elements_refine(const hpr_patches *patches, hpr_elements *elements, hpr_split_choice *choose,
                               void *user)
{
    column columns[NODE_COLUMNS];
    hpr_status status = HPR_OK;
    refiner r = {.b = {.patches = patches, .elements = elements, .next = (uint32_t)elements->node_count},
                 .choose = choose,
                 .user = user};
    refine_all(&r);
    size_t count = elements->node_count + r.count;
    if (count >= HPR_NONE)
        return hpr_fail(elements->context, HPR_ERR_MEMORY,
                        "%zu elements are more than 32-bit indices can name", count);
    node_columns(elements, columns);
    for (size_t i = 0; status == HPR_OK && i < NODE_COLUMNS; i++) {
        size_t capacity = elements->node_count;
        status = hpr_grow(elements->context, columns[i].array, &capacity, count, columns[i].item_bytes);
    }
    if (status != HPR_OK)
        return status;
    r.building = true;
    refine_all(&r);
    elements->node_count = count;
    return hpr_elements_index(patches, elements);
}

/* Both axes of the leaves that are marked. */
static int quarter(void *user, const hpr_piece_of_leaf *piece)
{
    const bool *marked = user;
    return marked[piece->leaf] && piece->depth < 2 ? piece->level % 2 : -1;
}

hpr_status hpr_elements_split(const hpr_patches *patches, hpr_elements *elements, const bool *marked)
{
    return hpr_elements_refine(patches, elements, quarter, (void *)marked);
}

static void release_index(hpr_elements *elements)
{
    hpr_release(elements->context, elements->leaf);
    hpr_release(elements->context, elements->leaf_of_node);
    hpr_release(elements->context, elements->patch_leaf);
    hpr_release(elements->context, elements->dof);
    hpr_release(elements->context, elements->recurrence);
    hpr_release(elements->context, elements->recurrence_at);
    elements->recurrence = NULL;
    elements->recurrence_at = NULL;
    elements->leaf = NULL;
    elements->leaf_of_node = NULL;
    elements->patch_leaf = NULL;
    elements->dof = NULL;
    elements->leaf_count = 0;
}

void hpr_elements_destroy(hpr_elements **out)
{
    hpr_elements *elements = *out;
    if (!elements)
        return;
    hpr_context *ctx = elements->context;
    release_index(elements);
    void *arrays[] = {elements->patch,  elements->child,   elements->axis,
                      elements->degree, elements->origin,  elements->edge1,
                      elements->edge2,  elements->area_m2, elements->opposite};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, elements);
    *out = NULL;
}

/* Appends the leaves below `node`, first child first. */
static void append_leaves(hpr_elements *elements, uint32_t node)
{
    while (elements->child[node] != HPR_NONE) {
        append_leaves(elements, elements->child[node]);
        node = elements->child[node] + 1;
    }
    elements->leaf_of_node[node] = (uint32_t)elements->leaf_count;
    elements->leaf[elements->leaf_count++] = node;
}

static bool is_quadrilateral(const hpr_patches *patches, const hpr_elements *elements, uint32_t node)
{
    return patches->shape[elements->patch[node]] == HPR_SHAPE_QUADRILATERAL;
}

/* Where the basis of each leaf begins. Returns how many doubles all take. */
static size_t place_recurrences(const hpr_patches *patches, hpr_elements *elements)
{
    size_t next = 0;
    for (size_t i = 0; i < elements->leaf_count; i++) {
        uint32_t node = elements->leaf[i];
        elements->recurrence_at[i] = next;
        if (is_quadrilateral(patches, elements, node))
            next += hpr_planar_size(elements->degree[node]);
    }
    return next;
}

static void make_recurrences(const hpr_patches *patches, hpr_elements *elements, double *scratch)
{
    for (size_t i = 0; i < elements->leaf_count; i++) {
        uint32_t node = elements->leaf[i];
        int degree = elements->degree[node];
        if (is_quadrilateral(patches, elements, node))
            hpr_planar_make(elements->opposite + 2 * (size_t)node, degree, &hpr_gauss.legendre[degree + 1],
                            elements->recurrence + elements->recurrence_at[i], scratch);
    }
}

/* The bases of leaves that are quadrilaterals, if there are any. */
static hpr_status index_recurrences(const hpr_patches *patches, hpr_elements *elements)
{
    hpr_context *ctx = elements->context;
    double *scratch = NULL;
    int highest = -1;
    for (size_t i = 0; i < elements->leaf_count; i++) {
        uint32_t node = elements->leaf[i];
        if (is_quadrilateral(patches, elements, node) && elements->degree[node] > highest)
            highest = elements->degree[node];
    }
    if (highest < 0)
        return HPR_OK;
    hpr_status status = hpr_allocate_into(ctx, &elements->recurrence_at, elements->leaf_count,
                                          sizeof *elements->recurrence_at, "the bases of quadrilaterals");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &elements->recurrence, place_recurrences(patches, elements),
                                   sizeof(double), "the bases of quadrilaterals");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &scratch, hpr_planar_scratch(highest), sizeof(double),
                                   "the bases of quadrilaterals");
    if (status == HPR_OK)
        make_recurrences(patches, elements, scratch);
    hpr_release(ctx, scratch);
    return status;
}

hpr_status hpr_elements_index(const hpr_patches *patches, hpr_elements *elements)
{
    hpr_context *ctx = elements->context;
    release_index(elements);
    size_t leaf_count = 0;
    for (size_t i = 0; i < elements->node_count; i++)
        leaf_count += elements->child[i] == HPR_NONE;
    hpr_status status =
        hpr_allocate_into(ctx, &elements->leaf, leaf_count, sizeof *elements->leaf, "the index of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &elements->leaf_of_node, elements->node_count,
                                   sizeof *elements->leaf_of_node, "the index of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &elements->patch_leaf, elements->patch_count + 1,
                                   sizeof *elements->patch_leaf, "the index of elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &elements->dof, leaf_count + 1, sizeof *elements->dof,
                                   "the index of elements");
    if (status != HPR_OK) {
        release_index(elements);
        return status;
    }
    for (size_t i = 0; i < elements->node_count; i++)
        elements->leaf_of_node[i] = HPR_NONE;
    for (size_t i = 0; i < elements->patch_count; i++) {
        elements->patch_leaf[i] = (uint32_t)elements->leaf_count;
        append_leaves(elements, (uint32_t)i);
    }
    elements->patch_leaf[elements->patch_count] = (uint32_t)elements->leaf_count;
    for (size_t i = 0; i < elements->leaf_count; i++) {
        uint32_t node = elements->leaf[i];
        size_t n = (size_t)elements->degree[node] + 1;
        bool tensor = patches->shape[elements->patch[node]] == HPR_SHAPE_PARALLELOGRAM;
        elements->dof[i + 1] = elements->dof[i] + (tensor ? n * n : n * (n + 1) / 2);
    }
    status = index_recurrences(patches, elements);
    if (status != HPR_OK)
        release_index(elements);
    return status;
}

/* The half of a quadrilateral that a point is in, and its parameters there. */
static int enter_half(const double opposite[2], int axis, double *s, double *t)
{
    hpr_quad_piece half[2] = {hpr_quad_half(opposite, axis, 0), hpr_quad_half(opposite, axis, 1)};
    /* The line that they share runs along an edge of the second from its origin. */
    const double *along = axis ? half[1].edge1 : half[1].edge2, *from = half[1].origin;
    double side = along[0] * (*t - from[1]) - along[1] * (*s - from[0]);
    int which = axis ? side >= 0 : side <= 0;
    const hpr_quad_piece *in = &half[which];
    double x = *s - in->origin[0], y = *t - in->origin[1];
    double area = in->edge1[0] * in->edge2[1] - in->edge1[1] * in->edge2[0];
    *s = (x * in->edge2[1] - y * in->edge2[0]) / area;
    *t = (in->edge1[0] * y - in->edge1[1] * x) / area;
    return which;
}

size_t hpr_elements_locate(const hpr_patches *patches, const hpr_elements *elements, size_t patch, double s,
                           double t, double *leaf_s, double *leaf_t)
{
    bool triangle = patches->shape[patch] == HPR_SHAPE_TRIANGLE;
    bool skew = patches->shape[patch] == HPR_SHAPE_QUADRILATERAL;
    uint32_t node = (uint32_t)patch;
    while (elements->child[node] != HPR_NONE) {
        int which;
        if (triangle) {
            double rest = 1 - s - t;
            which = t > s;
            double across = which ? t - s : s - t;
            s = which ? across : rest;
            t = which ? rest : across;
        } else if (skew) {
            which = enter_half(elements->opposite + 2 * (size_t)node, elements->axis[node], &s, &t);
        } else {
            double *halved = elements->axis[node] ? &t : &s;
            which = *halved >= 0.5;
            *halved = which ? 2 * *halved - 1 : 2 * *halved;
        }
        node = elements->child[node] + (uint32_t)which;
    }
    *leaf_s = s;
    *leaf_t = t;
    return elements->leaf_of_node[node];
}
