#include "link/coverage.h"

#include "basis/basis.h"
#include "link/shut.h"
#include "math/dense.h"
#include "quadrature/rule.h"

#include <stdlib.h>
#include <string.h>

/* A segment in which another patch meets a patch's plane, in the patch's parameters. */
typedef struct foot {
    double from[2], to[2];
} foot;

/* In scenes of more patches the search would take minutes: all elements count as open. */
enum { MAX_PATCHES = 20000 };

/* The open part of a leaf, in the leaf's parameters. */
typedef struct trimmed {
    int piece_count;        /* 0: wholly covered */
    double share;           /* of the leaf's area */
    hpr_polygon *piece;     /* [piece_count] */
    double *gram, *inverse; /* [n][n] G and its pseudo-inverse */
} trimmed;

struct hpr_coverage {
    hpr_context *context;
    const hpr_patches *patches;
    const hpr_elements *elements;
    uint32_t *trim_of_leaf; /* [leaf_count] index into trim, HPR_NONE: open */
    bool *cut;              /* [leaf_count] a foot runs through it */
    size_t trim_count, trim_capacity;
    trimmed *trim;
};

/* The box of a patch. */
typedef struct patch_box {
    double low[3], high[3];
    uint32_t patch;
} patch_box;

typedef struct search {
    patch_box *box; /* [patches->count] rising by low[0] */
    double widest;  /* along x */
    hpr_coverage *coverage;
    hpr_visibility *visibility; /* made when the first patch has a foot on it */
    double slack;               /* metres */
    uint32_t patch;
    foot *feet;
    size_t foot_count, foot_capacity;
    bool faced;         /* some patch lies against the patch */
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
    hpr_release(coverage->context, coverage->trim_of_leaf);
    hpr_release(coverage->context, coverage->cut);
    hpr_release(coverage->context, coverage);
    *out = NULL;
}

/* Where the outline of another patch meets the plane of the search's patch: its edges in the plane, or the
 * chord in which it crosses. */
static hpr_status add_feet(search *s, uint32_t other)
{
    const hpr_patches *patches = s->coverage->patches;
    double corner[4][3], height[4], point[8][3];
    size_t count = hpr_patch_corners(patches, other, corner), points = 0;
    for (size_t i = 0; i < count; i++) {
        double offset[3];
        hpr_subtract3(corner[i], patches->origin + 3 * (size_t)s->patch, offset);
        height[i] = hpr_dot3(offset, patches->normal + 3 * (size_t)s->patch);
    }
    hpr_status status = HPR_OK;
    bool coplanar = true;
    for (size_t i = 0; i < count; i++)
        coplanar &= fabs(height[i]) <= s->slack;
    s->faced |=
        coplanar && hpr_dot3(patches->normal + 3 * (size_t)s->patch, patches->normal + 3 * (size_t)other) < 0;
    for (size_t i = 0; i < count && status == HPR_OK; i++) {
        size_t j = (i + 1) % count;
        bool here = fabs(height[i]) <= s->slack, there = fabs(height[j]) <= s->slack;
        if (here && there) {
            foot edge;
            hpr_patch_parameters(patches, s->patch, corner[i], &edge.from[0], &edge.from[1]);
            hpr_patch_parameters(patches, s->patch, corner[j], &edge.to[0], &edge.to[1]);
            status =
                hpr_grow(s->coverage->context, &s->feet, &s->foot_capacity, s->foot_count + 1, sizeof edge);
            if (status == HPR_OK)
                s->feet[s->foot_count++] = edge;
        } else if (here) {
            memcpy(point[points++], corner[i], sizeof *point);
        } else if (!there && height[i] * height[j] < 0) {
            for (int k = 0; k < 3; k++)
                point[points][k] =
                    corner[i][k] + height[i] / (height[i] - height[j]) * (corner[j][k] - corner[i][k]);
            points++;
        }
    }
    if (status == HPR_OK && points == 2) {
        foot chord;
        hpr_patch_parameters(patches, s->patch, point[0], &chord.from[0], &chord.from[1]);
        hpr_patch_parameters(patches, s->patch, point[1], &chord.to[0], &chord.to[1]);
        status = hpr_grow(s->coverage->context, &s->feet, &s->foot_capacity, s->foot_count + 1, sizeof chord);
        if (status == HPR_OK)
            s->feet[s->foot_count++] = chord;
    }
    return status;
}

/* side[i][0] s + side[i][1] t >= side[i][2] inside; returns the number of sides. */
static int domain_sides(hpr_shape shape, const double opposite[2], double side[4][3])
{
    bool triangle = shape == HPR_SHAPE_TRIANGLE;
    const double fixed[4][3] = {{1, 0, 0}, {0, 1, 0}, {-1, triangle ? -1 : 0, -1}, {0, -1, -1}};
    memcpy(side, fixed, sizeof fixed);
    if (shape == HPR_SHAPE_QUADRILATERAL) {
        double a = opposite[0], b = opposite[1], c[2] = {hypot(a - 1, b), hypot(a, b - 1)};
        const double skew[2][3] = {{-b / c[0], (a - 1) / c[0], -b / c[0]},
                                   {(b - 1) / c[1], -a / c[1], -a / c[1]}};
        memcpy(side[2], skew, sizeof skew);
    }
    return triangle ? 3 : 4;
}

/* Does the segment run through the inside of a parameter domain, by more than `slack` parameters? */
static bool runs_inside(const foot *f, hpr_shape shape, const double opposite[2], double slack)
{
    double low = 0, high = 1; /* the part of the segment inside, clipped by the sides moved inward */
    double d[2] = {f->to[0] - f->from[0], f->to[1] - f->from[1]}, side[4][3];
    int sides = domain_sides(shape, opposite, side);
    for (int i = 0; i < sides; i++) {
        double at = side[i][0] * f->from[0] + side[i][1] * f->from[1] - side[i][2] - slack;
        double along = side[i][0] * d[0] + side[i][1] * d[1];
        if (along == 0) {
            if (at <= 0)
                return false;
        } else if (along > 0) {
            low = fmax(low, -at / along);
        } else {
            high = fmin(high, -at / along);
        }
    }
    return (high - low) * hypot(d[0], d[1]) > slack;
}

static int compare_boxes(const void *left, const void *right)
{
    const patch_box *a = left, *b = right;
    if (a->low[0] != b->low[0])
        return a->low[0] < b->low[0] ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

static patch_box box_of(const hpr_patches *patches, uint32_t patch)
{
    double corner[4][3];
    size_t count = hpr_patch_corners(patches, patch, corner);
    patch_box box = {.patch = patch};
    for (int k = 0; k < 3; k++) {
        box.low[k] = box.high[k] = corner[0][k];
        for (size_t i = 1; i < count; i++) {
            box.low[k] = fmin(box.low[k], corner[i][k]);
            box.high[k] = fmax(box.high[k], corner[i][k]);
        }
    }
    return box;
}

static hpr_status make_boxes(search *s)
{
    const hpr_patches *patches = s->coverage->patches;
    hpr_status status =
        hpr_allocate_into(s->coverage->context, &s->box, patches->count, sizeof *s->box, "covered elements");
    for (uint32_t i = 0; status == HPR_OK && i < patches->count; i++) {
        s->box[i] = box_of(patches, i);
        s->widest = fmax(s->widest, s->box[i].high[0] - s->box[i].low[0]);
    }
    if (status == HPR_OK)
        qsort(s->box, patches->count, sizeof *s->box, compare_boxes);
    return status;
}

static bool boxes_meet(const patch_box *a, const patch_box *b, double slack)
{
    bool apart = false;
    for (int k = 0; k < 3; k++)
        apart |= a->low[k] > b->high[k] + slack || b->low[k] > a->high[k] + slack;
    return !apart;
}

/* The first box that begins at x or after it. */
static size_t first_from(const search *s, double x)
{
    size_t low = 0, high = s->coverage->patches->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (s->box[middle].low[0] < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Feet that cut the patch are kept. */
static hpr_status find_feet(search *s)
{
    const hpr_patches *patches = s->coverage->patches;
    hpr_shape shape = (hpr_shape)patches->shape[s->patch];
    double size = sqrt(patches->area_m2[s->patch]);
    patch_box own = box_of(patches, s->patch);
    hpr_status status = HPR_OK;
    s->foot_count = 0;
    s->faced = false;
    for (size_t i = first_from(s, own.low[0] - s->widest - s->slack);
         i < patches->count && s->box[i].low[0] <= own.high[0] + s->slack && status == HPR_OK; i++) {
        uint32_t other = s->box[i].patch;
        if (other != s->patch && other != patches->twin[s->patch] && boxes_meet(&own, &s->box[i], s->slack))
            status = add_feet(s, other);
    }
    size_t kept = 0;
    for (size_t i = 0; i < s->foot_count; i++) {
        if (runs_inside(&s->feet[i], shape, patches->opposite + 2 * (size_t)s->patch, s->slack / size))
            s->feet[kept++] = s->feet[i];
    }
    s->foot_count = kept;
    return status;
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
    for (size_t i = 0; s->faced && i < patches->count; i++) {
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

/* A foot in the parameters of a leaf. */
static foot leaf_foot(const search *s, uint32_t node, const foot *f)
{
    const hpr_patches *patches = s->coverage->patches;
    const hpr_elements *e = s->coverage->elements;
    size_t p = 3 * (size_t)s->patch, n = 3 * (size_t)node;
    hpr_vec3 e1 = hpr_vec3_load(patches->edge1 + p), e2 = hpr_vec3_load(patches->edge2 + p);
    hpr_vec3 origin = hpr_vec3_load(patches->origin + p);
    hpr_vec3 a = hpr_vec3_load(e->edge1 + n), b = hpr_vec3_load(e->edge2 + n), across = hpr_cross(a, b);
    double square = hpr_dot(across, across);
    foot own;
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

/* Takes a copy of the pieces. */
static hpr_status keep_trim(search *s, size_t leaf, trimmed *t)
{
    static const double determined = 1e-3;
    hpr_coverage *coverage = s->coverage;
    hpr_context *ctx = coverage->context;
    const hpr_element_frame frame = hpr_leaf_frame(coverage->patches, coverage->elements, leaf);
    size_t n = hpr_basis_count(frame.shape, frame.degree);
    double *work = NULL;
    const hpr_polygon *piece = t->piece;
    t->piece = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &t->piece, (size_t)t->piece_count, sizeof *piece, "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->gram, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &t->inverse, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &work, n * n, sizeof(double), "covered elements");
    if (status == HPR_OK)
        status =
            hpr_grow(ctx, &coverage->trim, &coverage->trim_capacity, coverage->trim_count + 1, sizeof *t);
    if (status == HPR_OK) {
        memcpy(t->piece, piece, (size_t)t->piece_count * sizeof *piece);
        for (int i = 0; i < t->piece_count; i++)
            add_gram(t, &frame, &t->piece[i]);
        memcpy(t->inverse, t->gram, n * n * sizeof(double));
        hpr_dense_pseudo_inverse(n, t->inverse, determined, work);
        coverage->trim_of_leaf[leaf] = (uint32_t)coverage->trim_count;
        coverage->trim[coverage->trim_count++] = *t;
    } else {
        hpr_release(ctx, t->piece);
        hpr_release(ctx, t->gram);
        hpr_release(ctx, t->inverse);
    }
    hpr_release(ctx, work);
    return status;
}

static hpr_status trim_leaf(search *s, size_t leaf)
{
    static const double nothing = 1e-6; /* an open part this small of a leaf is the cuts' rounding */
    uint32_t node = s->coverage->elements->leaf[leaf];
    const hpr_element_frame frame = hpr_leaf_frame(s->coverage->patches, s->coverage->elements, leaf);
    const hpr_polygon whole = hpr_frame_outline(&frame);
    double slack = s->slack / sqrt(s->coverage->elements->area_m2[node]);
    hpr_cuts cuts;
    trimmed t = {0};
    hpr_cuts_init(&cuts, &whole);
    for (size_t i = 0; i < s->foot_count; i++) {
        foot own = leaf_foot(s, node, &s->feet[i]);
        if (runs_inside(&own, frame.shape, frame.opposite, slack))
            hpr_cuts_segment(&cuts, own.from, own.to, slack);
    }
    int open = 0;
    for (int i = 0; i < cuts.count; i++) {
        if (!is_covered(s, node, &cuts.piece[i]))
            cuts.piece[open++] = cuts.piece[i];
    }
    bool covered = open < cuts.count;
    s->coverage->cut[leaf] = cuts.count > 1 && open > 0;
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
    return covered ? keep_trim(s, leaf, &t) : HPR_OK;
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
    for (size_t i = 0; i < s->foot_count; i++)
        hpr_cuts_segment(&cuts, s->feet[i].from, s->feet[i].to, slack);
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
        status = find_feet(s);
        found |= s->foot_count > 0 || s->faced;
        if (status == HPR_OK)
            status = add_regions(s);
    }
    if (status == HPR_OK && found)
        status = hpr_visibility_create(s->coverage->patches, &s->visibility);
    if (status == HPR_OK && found)
        status = hpr_regions_shut(s->visibility, s->slack, s->region, s->first_region);
    return status;
}

static hpr_status trim_all(search *s)
{
    const hpr_elements *e = s->coverage->elements;
    hpr_status status = find_regions(s);
    for (s->patch = 0; status == HPR_OK && s->patch < s->coverage->patches->count; s->patch++) {
        status = find_feet(s);
        if (status != HPR_OK || (s->foot_count == 0 && !s->faced))
            continue;
        for (size_t leaf = e->patch_leaf[s->patch]; status == HPR_OK && leaf < e->patch_leaf[s->patch + 1];
             leaf++)
            status = trim_leaf(s, leaf);
    }
    return status;
}

hpr_status hpr_coverage_create(const hpr_patches *patches, const hpr_elements *elements, hpr_coverage **out)
{
    hpr_context *ctx = patches->context;
    hpr_coverage *coverage = NULL;
    double centre[3];
    search s = {.slack = fmax(patches->weld_m, 1e-9 * hpr_patches_radius(patches, centre))};
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &coverage, 1, sizeof *coverage, "covered elements");
    if (status != HPR_OK)
        return status;
    *coverage = (hpr_coverage){.context = ctx, .patches = patches, .elements = elements};
    s.coverage = coverage;
    status = hpr_allocate_into(ctx, &coverage->trim_of_leaf, elements->leaf_count,
                               sizeof *coverage->trim_of_leaf, "covered elements");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &coverage->cut, elements->leaf_count, sizeof *coverage->cut,
                                   "covered elements");
    if (status == HPR_OK)
        status = make_boxes(&s);
    if (status == HPR_OK) {
        for (size_t i = 0; i < elements->leaf_count; i++)
            coverage->trim_of_leaf[i] = HPR_NONE;
        if (patches->count <= MAX_PATCHES)
            status = trim_all(&s);
    }
    hpr_visibility_destroy(&s.visibility);
    void *arrays[] = {s.feet, s.box, s.region, s.first_region};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
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
    for (size_t i = 0; i < coverage->trim_count; i++)
        ++*(coverage->trim[i].piece_count ? partly : wholly);
}

static const trimmed *trim_of(const hpr_coverage *coverage, size_t leaf)
{
    uint32_t index = coverage->trim_of_leaf[leaf];
    return index == HPR_NONE ? NULL : &coverage->trim[index];
}

bool hpr_coverage_cut(const hpr_coverage *coverage, size_t leaf)
{
    return coverage->cut[leaf];
}

const hpr_polygon *hpr_coverage_parts(const hpr_coverage *coverage, size_t leaf, int *count)
{
    const trimmed *trim = trim_of(coverage, leaf);
    *count = trim ? trim->piece_count : 0;
    return trim ? trim->piece : NULL;
}

double hpr_coverage_open_share(const hpr_coverage *coverage, size_t leaf)
{
    const trimmed *trim = trim_of(coverage, leaf);
    return trim ? trim->share : 1;
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

void hpr_coverage_project(const hpr_coverage *coverage, size_t leaf, double *moment)
{
    const trimmed *trim = trim_of(coverage, leaf);
    if (!trim)
        return;
    double kept[HPR_MAX_BASIS];
    size_t n = leaf_functions(coverage, leaf);
    memcpy(kept, moment, n * sizeof *kept);
    for (size_t k = 0; k < n; k++) {
        moment[k] = 0;
        for (size_t l = 0; l < n; l++)
            moment[k] += trim->inverse[k * n + l] * kept[l];
    }
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
