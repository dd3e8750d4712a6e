#include "link/coverage.h"

#include "basis/basis.h"
#include "link/feet.h"
#include "link/shut.h"
#include "math/dense.h"
#include "quadrature/rule.h"

#include <stdlib.h>
#include <string.h>

/* In scenes of more patches the search would take minutes: all elements count as open. */
enum { MAX_PATCHES = 20000 };

/* The open part of a node, in the node's parameters. */
typedef struct trimmed {
    int piece_count;        /* 0: wholly covered */
    double share;           /* of the node's area */
    hpr_polygon *piece;     /* [piece_count] */
    double *gram, *inverse; /* [n][n] of a leaf: G and its pseudo-inverse */
} trimmed;

struct hpr_coverage {
    hpr_context *context;
    const hpr_patches *patches;
    const hpr_elements *elements;
    uint32_t *trim_of_node; /* [node_count] index into trim, HPR_NONE: open, or too intricate */
    bool *cut;              /* [leaf_count] a foot runs through it */
    size_t trim_count, trim_capacity;
    trimmed *trim;
};

typedef struct search {
    hpr_coverage *coverage;
    hpr_feet feet;
    hpr_visibility *visibility; /* made when the first patch has a foot on it */
    double slack;               /* metres */
    uint32_t patch;
    hpr_region *region; /* all patches cut at their feet */
    size_t *first_region, region_capacity;
} search;

void hpr_coverage_destroy(hpr_coverage **out)
{
    hpr_coverage *coverage = *out;
    if (!coverage)
        return;
    for (size_t i = 0; i < coverage->trim_count; i++) {
        hpr_release(coverage->context, coverage->trim[i].piece);
        hpr_release(coverage->context, coverage->trim[i].gram);
        hpr_release(coverage->context, coverage->trim[i].inverse);
    }
    hpr_release(coverage->context, coverage->trim);
    hpr_release(coverage->context, coverage->trim_of_node);
    hpr_release(coverage->context, coverage->cut);
    hpr_release(coverage->context, coverage);
    *out = NULL;
}

/* Is one of the two a side of a sheet, and light counts on its other side and not here? That one faces as the
 * patch does: of two sheets the first counts (hpr_visibility_first_hit shows it), of one the sheet. */
static bool is_under_sheet(const hpr_patches *patches, uint32_t patch, uint32_t against)
{
    uint32_t own = patches->twin[patch], other = patches->twin[against];
    return own != HPR_NONE && other != HPR_NONE ? other < patch : own != other;
}

/* The patch that faces the other way and in which the point, on the search's patch's plane, lies: one of a
 * sheet if that covers it, HPR_NONE if there is none. at: its parameters there. */
static uint32_t lies_against(const search *s, const double point[3], double at[2])
{
    uint32_t found = HPR_NONE;
    const hpr_patches *patches = s->coverage->patches;
    const double *normal = patches->normal + 3 * (size_t)s->patch;
    for (size_t i = 0; s->feet.faced && i < patches->count; i++) {
        double offset[3], u, v;
        if (i == s->patch || i == patches->twin[s->patch] ||
            hpr_dot3(normal, patches->normal + 3 * i) > -0.999)
            continue;
        hpr_subtract3(point, patches->origin + 3 * i, offset);
        if (fabs(hpr_dot3(offset, patches->normal + 3 * i)) > s->slack)
            continue;
        hpr_patch_parameters(patches, i, point, &u, &v);
        if (!hpr_shape_holds((hpr_shape)patches->shape[i], patches->opposite + 2 * i, u, v))
            continue;
        found = (uint32_t)i;
        at[0] = u;
        at[1] = v;
        if (is_under_sheet(patches, s->patch, found))
            break;
    }
    return found;
}

static hpr_polygon patch_outline(const hpr_patches *patches, size_t patch)
{
    const double *opposite = patches->opposite + 2 * patch;
    const hpr_element_frame frame = {.shape = (hpr_shape)patches->shape[patch],
                                     .opposite = {opposite[0], opposite[1]}};
    return hpr_frame_outline(&frame);
}

/* The mean of a polygon's corners, in space. */
static void patch_middle(const hpr_patches *patches, size_t patch, const hpr_polygon *piece, double point[3])
{
    for (size_t k = 0; k < 3; k++) {
        point[k] = patches->origin[3 * patch + k];
        for (int i = 0; i < piece->count; i++)
            point[k] += (piece->corner[i][0] * patches->edge1[3 * patch + k] +
                         piece->corner[i][1] * patches->edge2[3 * patch + k]) /
                        piece->count;
    }
}

static bool is_covered(const search *s, uint32_t node, const hpr_polygon *piece)
{
    const hpr_elements *e = s->coverage->elements;
    double at[2] = {0, 0}, point[3];
    for (int i = 0; i < piece->count; i++) {
        at[0] += piece->corner[i][0] / piece->count;
        at[1] += piece->corner[i][1] / piece->count;
    }
    for (size_t k = 0; k < 3; k++)
        point[k] = e->origin[3 * node + k] + at[0] * e->edge1[3 * node + k] + at[1] * e->edge2[3 * node + k];
    double u, v;
    hpr_patch_parameters(s->coverage->patches, s->patch, point, &u, &v);
    return s->region[hpr_region_at(s->region, s->first_region, s->patch, u, v)].shut;
}

/* A foot in the parameters of a node. */
static hpr_foot node_foot(const search *s, uint32_t node, const hpr_foot *f)
{
    const hpr_patches *patches = s->coverage->patches;
    const hpr_elements *e = s->coverage->elements;
    size_t p = 3 * (size_t)s->patch, n = 3 * (size_t)node;
    hpr_vec3 e1 = hpr_vec3_load(patches->edge1 + p), e2 = hpr_vec3_load(patches->edge2 + p);
    hpr_vec3 origin = hpr_vec3_load(patches->origin + p);
    hpr_vec3 a = hpr_vec3_load(e->edge1 + n), b = hpr_vec3_load(e->edge2 + n), across = hpr_cross(a, b);
    double square = hpr_dot(across, across);
    hpr_foot own;
    for (int end = 0; end < 2; end++) {
        const double *at = end ? f->to : f->from;
        hpr_vec3 x = hpr_sub(hpr_madd(hpr_madd(origin, at[0], e1), at[1], e2), hpr_vec3_load(e->origin + n));
        double *to = end ? own.to : own.from;
        to[0] = hpr_dot(hpr_cross(x, b), across) / square;
        to[1] = hpr_dot(hpr_cross(a, x), across) / square;
    }
    return own;
}

/* G += ∫ over a piece. */
static void add_gram(const trimmed *t, const hpr_element_frame *frame, const hpr_polygon *piece)
{
    hpr_cell cell[HPR_POLYGON_MAX];
    double basis[HPR_MAX_BASIS];
    size_t n = hpr_basis_count(frame->shape, frame->degree);
    int nodes = hpr_total_degree(frame) + 1, count = hpr_cuts_fan(piece, cell);
    const hpr_box whole = hpr_box_unit();
    for (int c = 0; c < count; c++) {
        for (int k = 0; k < nodes * nodes; k++) {
            hpr_outer_point x = hpr_outer_at(&hpr_gauss, &(hpr_element_frame){0}, &cell[c], &whole, nodes, k);
            hpr_frame_basis(frame, x.s, x.t, basis);
            for (size_t i = 0; i < n; i++) {
                for (size_t j = 0; j < n; j++)
                    t->gram[i * n + j] += x.weight * basis[i] * basis[j];
            }
        }
    }
}

/* G of a leaf and its pseudo-inverse. */
static hpr_status make_gram(hpr_context *ctx, const hpr_element_frame *frame, trimmed *t)
{
    static const double determined = 1e-3;
    size_t n = hpr_basis_count(frame->shape, frame->degree);
    double *work = NULL;
    hpr_status status = hpr_allocate_into(ctx, &t->gram, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->inverse, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &work, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK) {
        for (int i = 0; i < t->piece_count; i++)
            add_gram(t, frame, &t->piece[i]);
        memcpy(t->inverse, t->gram, n * n * sizeof(double));
        hpr_dense_pseudo_inverse(n, t->inverse, determined, work);
    }
    hpr_release(ctx, work);
    return status;
}

/* Takes a copy of the pieces. */
static hpr_status keep_trim(search *s, uint32_t node, trimmed *t)
{
    hpr_coverage *coverage = s->coverage;
    hpr_context *ctx = coverage->context;
    uint32_t leaf = coverage->elements->leaf_of_node[node];
    const hpr_polygon *piece = t->piece;
    t->piece = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &t->piece, (size_t)t->piece_count, sizeof *piece, "covered elements");
    if (status == HPR_OK) {
        memcpy(t->piece, piece, (size_t)t->piece_count * sizeof *piece);
        status =
            hpr_grow(ctx, &coverage->trim, &coverage->trim_capacity, coverage->trim_count + 1, sizeof *t);
    }
    if (status == HPR_OK && leaf != HPR_NONE) {
        const hpr_element_frame frame = hpr_leaf_frame(coverage->patches, coverage->elements, leaf);
        status = make_gram(ctx, &frame, t);
    }
    if (status == HPR_OK) {
        coverage->trim_of_node[node] = (uint32_t)coverage->trim_count;
        coverage->trim[coverage->trim_count++] = *t;
    } else {
        hpr_release(ctx, t->piece);
        hpr_release(ctx, t->gram);
        hpr_release(ctx, t->inverse);
    }
    return status;
}

static hpr_status trim_node(search *s, uint32_t node)
{
    static const double nothing = 1e-6; /* an open part this small of a node is the cuts' rounding */
    const hpr_elements *e = s->coverage->elements;
    const hpr_element_frame frame = hpr_node_frame(s->coverage->patches, e, node);
    const hpr_polygon whole = hpr_frame_outline(&frame);
    double slack = s->slack / sqrt(e->area_m2[node]);
    hpr_cuts cuts;
    trimmed t = {0};
    hpr_cuts_init(&cuts, &whole);
    for (size_t i = 0; i < s->feet.count; i++) {
        hpr_foot own = node_foot(s, node, &s->feet.foot[i]);
        if (hpr_foot_cuts(&own, frame.shape, frame.opposite, slack))
            hpr_cuts_segment(&cuts, own.from, own.to, slack);
    }
    int open = 0;
    for (int i = 0; i < cuts.count; i++) {
        if (!is_covered(s, node, &cuts.piece[i]))
            cuts.piece[open++] = cuts.piece[i];
    }
    bool covered = open < cuts.count;
    if (e->leaf_of_node[node] != HPR_NONE)
        s->coverage->cut[e->leaf_of_node[node]] = cuts.count > 1 && open > 0;
    if (covered)
        open = hpr_cuts_merge(cuts.piece, open, slack);
    if (open > HPR_COVERAGE_PIECES)
        return HPR_OK; /* too intricate: taken as open */
    t.piece = cuts.piece;
    t.piece_count = open;
    for (int i = 0; i < t.piece_count; i++)
        t.share += hpr_polygon_area(&t.piece[i]) / hpr_polygon_area(&whole);
    if (t.share < nothing)
        t.piece_count = 0;
    return covered ? keep_trim(s, node, &t) : HPR_OK;
}

/* The patch cut at its feet. */
static hpr_status add_regions(search *s)
{
    const hpr_patches *patches = s->coverage->patches;
    double slack = s->slack / sqrt(patches->area_m2[s->patch]), point[3];
    size_t first = s->first_region[s->patch];
    hpr_polygon whole = patch_outline(patches, s->patch);
    hpr_cuts cuts;
    hpr_cuts_init(&cuts, &whole);
    for (size_t i = 0; i < s->feet.count; i++)
        hpr_cuts_segment(&cuts, s->feet.foot[i].from, s->feet.foot[i].to, slack);
    hpr_status status = hpr_grow(s->coverage->context, &s->region, &s->region_capacity,
                                 first + (size_t)cuts.count, sizeof *s->region);
    for (int i = 0; status == HPR_OK && i < cuts.count; i++) {
        patch_middle(patches, s->patch, &cuts.piece[i], point);
        hpr_region *region = &s->region[first + (size_t)i];
        *region = (hpr_region){.outline = cuts.piece[i], .patch = s->patch};
        region->against = lies_against(s, point, region->against_at);
        region->covered = region->against != HPR_NONE && is_under_sheet(patches, s->patch, region->against);
    }
    s->first_region[s->patch + 1] = first + (size_t)cuts.count;
    return status;
}

/* Which regions are shut; none if no patch has a foot on it or another against it. */
static hpr_status find_regions(search *s)
{
    const hpr_patches *patches = s->coverage->patches;
    bool found = false;
    hpr_status status = hpr_allocate_into(s->coverage->context, &s->first_region, patches->count + 1,
                                          sizeof *s->first_region, "covered elements");
    for (s->patch = 0; status == HPR_OK && s->patch < patches->count; s->patch++) {
        status = hpr_feet_find(&s->feet, s->patch);
        found |= s->feet.count > 0 || s->feet.faced;
        if (status == HPR_OK)
            status = add_regions(s);
    }
    if (status == HPR_OK && found)
        status = hpr_visibility_create(s->coverage->patches, &s->visibility);
    if (status == HPR_OK && found)
        status = hpr_regions_shut(s->visibility, s->slack, s->region, s->first_region);
    return status;
}

/* A node and what is below it. What lies wholly in the open or in the covered part is so at the first look.
 */
static hpr_status trim_below(search *s, uint32_t node)
{
    uint32_t child = s->coverage->elements->child[node];
    hpr_status status = trim_node(s, node);
    for (uint32_t k = 0; status == HPR_OK && child != HPR_NONE && k < 2; k++)
        status = trim_below(s, child + k);
    return status;
}

static hpr_status trim_all(search *s)
{
    hpr_status status = find_regions(s);
    for (s->patch = 0; status == HPR_OK && s->patch < s->coverage->patches->count; s->patch++) {
        status = hpr_feet_find(&s->feet, s->patch);
        if (status != HPR_OK || (s->feet.count == 0 && !s->feet.faced))
            continue;
        status = trim_below(s, s->patch);
    }
    return status;
}

hpr_status hpr_coverage_create(const hpr_patches *patches, const hpr_elements *elements, hpr_coverage **out)
{
    hpr_context *ctx = patches->context;
    hpr_coverage *coverage = NULL;
    double centre[3];
    search s = {.feet = {.patches = patches},
                .slack = fmax(patches->weld_m, 1e-9 * hpr_patches_radius(patches, centre))};
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &coverage, 1, sizeof *coverage, "covered elements");
    if (status != HPR_OK)
        return status;
    *coverage = (hpr_coverage){.context = ctx, .patches = patches, .elements = elements};
    s.coverage = coverage;
    status = hpr_allocate_into(ctx, &coverage->trim_of_node, elements->node_count,
                               sizeof *coverage->trim_of_node, "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &coverage->cut, elements->leaf_count, sizeof *coverage->cut,
                                   "covered elements");
    if (status == HPR_OK)
        status = hpr_feet_init(patches, s.slack, &s.feet);
    if (status == HPR_OK) {
        for (size_t i = 0; i < elements->node_count; i++)
            coverage->trim_of_node[i] = HPR_NONE;
        if (patches->count <= MAX_PATCHES)
            status = trim_all(&s);
    }
    hpr_visibility_destroy(&s.visibility);
    hpr_feet_fini(&s.feet);
    hpr_release(ctx, s.region);
    hpr_release(ctx, s.first_region);
    if (status != HPR_OK)
        hpr_coverage_destroy(&coverage);
    *out = coverage;
    return status;
}

const hpr_patches *hpr_coverage_patches(const hpr_coverage *coverage)
{
    return coverage->patches;
}

void hpr_coverage_count(const hpr_coverage *coverage, size_t *partly, size_t *wholly)
{
    *partly = *wholly = 0;
    for (size_t i = 0; i < coverage->trim_count; i++) {
        if (coverage->trim[i].gram)
            ++*(coverage->trim[i].piece_count ? partly : wholly);
    }
}

static const trimmed *trim_of_node(const hpr_coverage *coverage, size_t node)
{
    uint32_t index = coverage->trim_of_node[node];
    return index == HPR_NONE ? NULL : &coverage->trim[index];
}

static const trimmed *trim_of(const hpr_coverage *coverage, size_t leaf)
{
    return trim_of_node(coverage, coverage->elements->leaf[leaf]);
}

bool hpr_coverage_cut(const hpr_coverage *coverage, size_t leaf)
{
    return coverage->cut[leaf];
}

const hpr_polygon *hpr_coverage_node_parts(const hpr_coverage *coverage, size_t node, int *count)
{
    const trimmed *trim = trim_of_node(coverage, node);
    *count = trim ? trim->piece_count : 0;
    return trim ? trim->piece : NULL;
}

double hpr_coverage_node_share(const hpr_coverage *coverage, size_t node)
{
    const trimmed *trim = trim_of_node(coverage, node);
    return trim ? trim->share : 1;
}

const hpr_polygon *hpr_coverage_parts(const hpr_coverage *coverage, size_t leaf, int *count)
{
    return hpr_coverage_node_parts(coverage, coverage->elements->leaf[leaf], count);
}

double hpr_coverage_open_share(const hpr_coverage *coverage, size_t leaf)
{
    return hpr_coverage_node_share(coverage, coverage->elements->leaf[leaf]);
}

bool hpr_coverage_open(const hpr_coverage *coverage, size_t leaf, double s, double t)
{
    const trimmed *trim = trim_of(coverage, leaf);
    bool open = !trim;
    for (int i = 0; !open && i < trim->piece_count; i++)
        open = hpr_polygon_holds(&trim->piece[i], s, t);
    return open;
}

static size_t leaf_functions(const hpr_coverage *coverage, size_t leaf)
{
    return coverage->elements->dof[leaf + 1] - coverage->elements->dof[leaf];
}

/* value = matrix value */
static void multiply(const double *matrix, size_t n, double *value)
{
    double kept[HPR_MAX_BASIS];
    memcpy(kept, value, n * sizeof *kept);
    for (size_t k = 0; k < n; k++) {
        value[k] = 0;
        for (size_t l = 0; l < n; l++)
            value[k] += matrix[k * n + l] * kept[l];
    }
}

void hpr_coverage_project(const hpr_coverage *coverage, size_t leaf, double *moment)
{
    const trimmed *trim = trim_of(coverage, leaf);
    if (trim)
        multiply(trim->inverse, leaf_functions(coverage, leaf), moment);
}

void hpr_coverage_weigh(const hpr_coverage *coverage, size_t leaf, double *coefficient)
{
    const trimmed *trim = trim_of(coverage, leaf);
    if (trim)
        multiply(trim->gram, leaf_functions(coverage, leaf), coefficient);
}

double hpr_coverage_mean(const hpr_coverage *coverage, size_t leaf, const double *coefficient, size_t stride)
{
    const trimmed *trim = trim_of(coverage, leaf);
    if (!trim)
        return coefficient[0];
    double sum = 0;
    for (size_t l = 0; l < leaf_functions(coverage, leaf); l++)
        sum += trim->gram[l] * coefficient[l * stride];
    return sum;
}
