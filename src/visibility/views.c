#include "visibility/views.h"

#include "visibility/faces.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* A group, or the groups below it, in scene units. Children follow in the order of their patches. */
typedef struct node {
    double low[3], high[3];
    uint32_t child[2]; /* HPR_NONE: a group */
    uint32_t group, group_end;
} node;

/* What is known of a pair of groups. */
typedef struct sight {
    size_t first; /* in the row's list */
    uint32_t count;
    bool hidden; /* one occluder hides all of one from all of the other */
} sight;

/* A group and all groups from `from` on: from itself on, or from the first on if only it is wanted. */
typedef struct row {
    bool wanted;
    uint32_t from;
    sight *sight; /* [group_count - from] */
    uint32_t *list;
    size_t list_count, capacity;
} row;

struct hpr_views {
    hpr_context *context;
    const hpr_visibility *visibility;
    size_t node_count, group_count;
    uint32_t *group;      /* [patches] HPR_NONE: no area */
    uint32_t *group_node; /* [group_count] */
    node *node;           /* [2 patches] the root is the first */
    row *row;             /* [group_count] */
};

/* A patch on its way into the tree. */
typedef struct member {
    uint32_t patch;
    uint32_t facing; /* axis and sign of the normal's largest component */
    double middle[3], low[3], high[3];
} member;

hpr_facet hpr_patch_facet(const hpr_patches *patches, size_t patch)
{
    hpr_facet facet;
    facet.corner_count = hpr_patch_corners(patches, patch, facet.corner);
    memcpy(facet.normal, patches->normal + 3 * patch, sizeof facet.normal);
    return facet;
}

static void set_member(const hpr_visibility *visibility, uint32_t patch, member *it)
{
    hpr_facet facet = hpr_patch_facet(visibility->patches, patch);
    *it = (member){
        .patch = patch, .low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t c = 0; c < facet.corner_count; c++) {
        double own[3];
        hpr_scene_units(visibility, facet.corner[c], own);
        for (int k = 0; k < 3; k++) {
            it->low[k] = hpr_min(it->low[k], own[k]);
            it->high[k] = hpr_max(it->high[k], own[k]);
        }
    }
    uint32_t axis = 0;
    for (uint32_t k = 0; k < 3; k++) {
        it->middle[k] = (it->low[k] + it->high[k]) / 2;
        if (fabs(facet.normal[k]) > fabs(facet.normal[axis]))
            axis = k;
    }
    it->facing = 2 * axis + (facet.normal[axis] < 0);
}

static int compare_along(const void *left, const void *right, void *axis)
{
    const member *a = left, *b = right;
    double x = a->middle[*(int *)axis], y = b->middle[*(int *)axis];
    if (x != y)
        return x < y ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

static int compare_facing(const void *left, const void *right)
{
    const member *a = left, *b = right;
    if (a->facing != b->facing)
        return a->facing < b->facing ? -1 : 1;
    return a->patch < b->patch ? -1 : a->patch > b->patch;
}

/* Where the members of a node are divided: between ways of facing if there are several, else at the median
 * along the longest side of their box. Members must be in the order of their facing. */
static size_t divide(member *members, size_t count, const node *n)
{
    if (members[0].facing != members[count - 1].facing) {
        size_t best = 0;
        for (size_t i = 1; i < count; i++) {
            bool border = members[i].facing != members[i - 1].facing;
            if (border && (best == 0 || llabs((long long)(2 * i) - (long long)count) <
                                            llabs((long long)(2 * best) - (long long)count)))
                best = i;
        }
        return best;
    }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        axis = n->high[k] - n->low[k] > n->high[axis] - n->low[axis] ? k : axis;
    qsort_r(members, count, sizeof *members, compare_along, &axis);
    return count / 2;
}

static uint32_t add_node(hpr_views *views, member *members, uint32_t first, uint32_t count)
{
    uint32_t index = (uint32_t)views->node_count++;
    node *n = &views->node[index];
    *n = (node){.low = {INFINITY, INFINITY, INFINITY},
                .high = {-INFINITY, -INFINITY, -INFINITY},
                .child = {HPR_NONE, HPR_NONE},
                .group = (uint32_t)views->group_count};
    for (uint32_t i = first; i < first + count; i++) {
        for (int k = 0; k < 3; k++) {
            n->low[k] = hpr_min(n->low[k], members[i].low[k]);
            n->high[k] = hpr_max(n->high[k], members[i].high[k]);
        }
    }
    if (count <= HPR_VIEWS_GROUP && members[first].facing == members[first + count - 1].facing) {
        for (uint32_t i = first; i < first + count; i++)
            views->group[members[i].patch] = n->group;
        views->group_node[views->group_count++] = index;
    } else {
        uint32_t left = (uint32_t)divide(members + first, count, n);
        n->child[0] = add_node(views, members, first, left);
        n->child[1] = add_node(views, members, first + left, count - left);
    }
    n->group_end = (uint32_t)views->group_count;
    return index;
}

static hpr_status make_tree(hpr_views *views)
{
    const hpr_patches *patches = views->visibility->patches;
    member *members = NULL;
    uint32_t count = 0;
    hpr_status status =
        hpr_allocate_into(views->context, &members, patches->count, sizeof *members, "groups of patches");
    if (status != HPR_OK)
        return status;
    for (uint32_t p = 0; p < patches->count; p++) {
        views->group[p] = HPR_NONE;
        if (patches->area_m2[p] > 0)
            set_member(views->visibility, p, &members[count++]);
    }
    qsort(members, count, sizeof *members, compare_facing);
    if (count)
        add_node(views, members, 0, count);
    hpr_release(views->context, members);
    return HPR_OK;
}

/* The convex hull of two boxes: its box, and the planes along an axis that lean on an edge of each box.
 * normal . x <= limit for all of the hull. */
enum { MAX_SIDES = 48 };
typedef struct shaft {
    const node *end[2];
    hpr_extent extent[2];
    double low[3], high[3];
    size_t side_count, last; /* last: the side that had the last candidate outside; its neighbours are next */
    double side[MAX_SIDES][4];
} shaft;

static double corner_along(const node *box, int axis, int far)
{
    return far ? box->high[axis] : box->low[axis];
}

/* A line through a corner of each box, projected along the third axis, is a side if both boxes are on one
 * side of it. */
static void try_side(shaft *sh, int k, int l, const double a[2], const double b[2])
{
    double n[2] = {a[1] - b[1], b[0] - a[0]}, most = -INFINITY, least = INFINITY;
    double length = sqrt(n[0] * n[0] + n[1] * n[1]);
    if (!(length > 0))
        return;
    for (int i = 0; i < 8; i++) {
        const node *box = sh->end[i / 4];
        double height =
            (n[0] * (corner_along(box, k, i & 1) - a[0]) + n[1] * (corner_along(box, l, i >> 1 & 1) - a[1])) /
            length;
        most = hpr_max(most, height);
        least = hpr_min(least, height);
    }
    /* rounding: 1e-15 of coordinates below 1 */
    static const double rounding = 1e-14;
    if (most > rounding && least < -rounding)
        return;
    double *side = sh->side[sh->side_count++], sign = most > rounding ? -1 : 1;
    memset(side, 0, 4 * sizeof *side);
    side[k] = sign * n[0] / length;
    side[l] = sign * n[1] / length;
    side[3] = side[k] * a[0] + side[l] * a[1] + rounding;
}

static void open_shaft(shaft *sh, const node *a, const node *b)
{
    sh->end[0] = a;
    sh->end[1] = b;
    sh->extent[0] = hpr_extent_of(a->low, a->high);
    sh->extent[1] = hpr_extent_of(b->low, b->high);
    sh->side_count = sh->last = 0;
    for (int k = 0; k < 3; k++) {
        sh->low[k] = hpr_min(a->low[k], b->low[k]);
        sh->high[k] = hpr_max(a->high[k], b->high[k]);
    }
    for (int k = 0; k < 3; k++) {
        int l = (k + 1) % 3;
        for (int i = 0; i < 16; i++) {
            const double p[2] = {corner_along(a, k, i & 1), corner_along(a, l, i >> 1 & 1)};
            const double q[2] = {corner_along(b, k, i >> 2 & 1), corner_along(b, l, i >> 3)};
            /* a side of one of the boxes bounds their common box, and a diagonal of one bounds nothing */
            if (p[0] != q[0] && p[1] != q[1])
                try_side(sh, k, l, p, q);
        }
    }
}

/* Does the occluder block every segment between the boxes, without the growth that it has for single ones? */
static bool hides(const hpr_visibility *visibility, const shaft *sh, const hpr_occluder *occluder)
{
    for (int i = 0; i < 8; i++) {
        double x[3], y[3], crossing[3], sine;
        for (int k = 0; k < 3; k++)
            x[k] = corner_along(sh->end[0], k, i >> k & 1);
        for (int j = 0; j < 8; j++) {
            for (int k = 0; k < 3; k++)
                y[k] = corner_along(sh->end[1], k, j >> k & 1);
            if (!hpr_occluder_crossing(visibility, occluder, x, y, crossing, &sine) ||
                !hpr_occluder_holds(occluder, crossing, 0))
                return false;
        }
    }
    return true;
}

/* May an occluder block something between members of the two ends? At least what hpr_visibility_classify says
 * of any pair of them. */
static bool meets(const hpr_views *views, shaft *sh, uint32_t index, bool *hidden)
{
    const hpr_visibility *visibility = views->visibility;
    const hpr_occluder *occluder = &visibility->occluder[index];
    if (hpr_bounds_aside(&visibility->bounds[index], sh->low, sh->high, sh->extent))
        return false;
    const double(*corner)[3] = (const double(*)[3])occluder->corner;
    const hpr_bounds *bounds = &visibility->bounds[index];
    const double *last = sh->side[sh->last];
    if (sh->side_count && hpr_dot3(last, bounds->middle) - bounds->radius >= last[3])
        return false;
    for (size_t s = 0; s < sh->side_count; s++) {
        const double *side = sh->side[s];
        double depth = side[3] - hpr_dot3(side, bounds->middle);
        int outside = 0;
        if (depth > bounds->radius)
            continue;
        while (outside < occluder->edge_count && hpr_dot3(side, corner[outside]) >= side[3])
            outside++;
        if (outside == occluder->edge_count) {
            sh->last = s;
            return false;
        }
    }
    *hidden = hides(visibility, sh, occluder);
    return true;
}

/* The descent of one row through the tree: candidate lists on a stack. */
typedef struct descent {
    const hpr_views *views;
    const node *own;
    row *row;
    uint32_t **stack;
    size_t *capacity;
} descent;

static void hide_all(const descent *d, const node *n)
{
    uint32_t from = n->group < d->row->from ? d->row->from : n->group;
    for (uint32_t g = from; g < n->group_end; g++)
        d->row->sight[g - d->row->from].hidden = true;
}

static hpr_status keep_list(const descent *d, size_t group, size_t base, size_t count)
{
    row *r = d->row;
    sight *it = &r->sight[group - r->from];
    hpr_status status =
        hpr_grow(d->views->context, &r->list, &r->capacity, r->list_count + count, sizeof *r->list);
    if (status != HPR_OK)
        return status;
    it->first = r->list_count;
    it->count = (uint32_t)count;
    memcpy(r->list + r->list_count, *d->stack + base, count * sizeof *r->list);
    r->list_count += count;
    return HPR_OK;
}

/* Goes through the groups of a node, from the row's first on. The candidates of its parent are at `base`
 * on the stack. */
static hpr_status descend(const descent *d, uint32_t index, size_t base, size_t count)
{
    const node *n = &d->views->node[index];
    size_t kept = 0, top = base + count;
    shaft sh;
    if (n->group_end <= d->row->from || count == 0)
        return HPR_OK;
    hpr_status status = hpr_grow(d->views->context, d->stack, d->capacity, top + count, sizeof **d->stack);
    if (status != HPR_OK)
        return status;
    open_shaft(&sh, d->own, n);
    for (size_t i = base; i < base + count; i++) {
        bool hidden = false;
        if (!meets(d->views, &sh, (*d->stack)[i], &hidden))
            continue;
        if (hidden) {
            hide_all(d, n);
            return HPR_OK;
        }
        (*d->stack)[top + kept++] = (*d->stack)[i];
    }
    if (n->child[0] == HPR_NONE)
        return kept ? keep_list(d, n->group, top, kept) : HPR_OK;
    for (int c = 0; status == HPR_OK && c < 2; c++)
        status = descend(d, n->child[c], top, kept);
    return status;
}

static hpr_status fill_row(hpr_views *views, uint32_t own, uint32_t **stack, size_t *capacity)
{
    const hpr_visibility *visibility = views->visibility;
    const node *n = &views->node[own];
    row *r = &views->row[n->group];
    descent d = {.views = views, .own = n, .row = r, .stack = stack, .capacity = capacity};
    hpr_status status = hpr_allocate_into(views->context, &r->sight, views->group_count - r->from,
                                          sizeof *r->sight, "views between groups");
    if (status == HPR_OK)
        status = hpr_grow(views->context, stack, capacity, visibility->divider_count, sizeof **stack);
    if (status != HPR_OK)
        return status;
    memcpy(*stack, visibility->divider, visibility->divider_count * sizeof **stack);
    return descend(&d, 0, 0, visibility->divider_count);
}

static hpr_status fill_rows(hpr_views *views)
{
    hpr_context *ctx = views->context;
    _Atomic int failure = HPR_OK;
#pragma omp parallel num_threads(hpr_context_threads(ctx))
    {
        uint32_t *stack = NULL;
        size_t capacity = 0;
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < views->node_count; i++) {
            const node *n = &views->node[i];
            if (n->child[0] != HPR_NONE || !views->row[n->group].wanted || failure != HPR_OK)
                continue;
            hpr_status status = hpr_cancelled(ctx) ? hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted")
                                                   : fill_row(views, (uint32_t)i, &stack, &capacity);
            if (status != HPR_OK)
                failure = (int)status;
        }
        hpr_release(ctx, stack);
    }
    return (hpr_status)failure;
}

static hpr_status make_rows(hpr_views *views, const bool *wanted)
{
    hpr_status status = hpr_allocate_into(views->context, &views->row, views->group_count, sizeof *views->row,
                                          "views between groups");
    if (status != HPR_OK)
        return status;
    for (uint32_t g = 0; g < views->group_count; g++) {
        views->row[g].wanted = !wanted;
        views->row[g].from = wanted ? 0 : g;
    }
    for (size_t p = 0; wanted && p < views->visibility->patches->count; p++) {
        if (wanted[p] && views->group[p] != HPR_NONE)
            views->row[views->group[p]].wanted = true;
    }
    return views->visibility->divider_count ? fill_rows(views) : HPR_OK;
}

hpr_status hpr_views_create(const hpr_visibility *visibility, const bool *wanted, hpr_views **out)
{
    hpr_context *ctx = visibility->context;
    size_t count = visibility->patches->count;
    hpr_views *views = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &views, 1, sizeof *views, "views");
    if (status != HPR_OK)
        return status;
    views->context = ctx;
    views->visibility = visibility;
    status = hpr_allocate_into(ctx, &views->group, count, sizeof *views->group, "groups of patches");
    if (status == HPR_OK)
        status =
            hpr_allocate_into(ctx, &views->group_node, count, sizeof *views->group_node, "groups of patches");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &views->node, 2 * count, sizeof *views->node, "groups of patches");
    if (status == HPR_OK)
        status = make_tree(views);
    if (status == HPR_OK)
        status = make_rows(views, wanted);
    if (status != HPR_OK)
        hpr_views_destroy(&views);
    *out = views;
    return status;
}

void hpr_views_destroy(hpr_views **out)
{
    hpr_views *views = *out;
    if (!views)
        return;
    hpr_context *ctx = views->context;
    for (size_t i = 0; views->row && i < views->group_count; i++) {
        hpr_release(ctx, views->row[i].sight);
        hpr_release(ctx, views->row[i].list);
    }
    void *arrays[] = {views->group, views->group_node, views->node, views->row};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    hpr_release(ctx, views);
    *out = NULL;
}

/* Candidates between the cursor's patch and the patches of one group; made when first asked for. */
typedef struct narrowed {
    size_t turn; /* that of the cursor when it was made */
    sight sight;
} narrowed;

struct hpr_views_cursor {
    const hpr_views *views;
    size_t patch, turn;
    node box;           /* of the patch */
    narrowed *narrowed; /* [group_count] */
    uint32_t *list;     /* room for all lists of any group */
    size_t list_count;
};

/* What is known of two groups, and where its list is. */
static sight sight_between(const hpr_views *views, uint32_t i, uint32_t j, const uint32_t **list)
{
    static const uint32_t none;
    *list = &none;
    if (!views->visibility->divider_count)
        return (sight){0};
    const row *r = &views->row[i];
    if (!r->wanted || r->from > j) {
        r = &views->row[j];
        j = i;
    }
    const sight *it = &r->sight[j - r->from];
    if (it->count)
        *list = r->list + it->first;
    return *it;
}

/* Entries in the lists of the group that has most, over all groups. */
static size_t longest_row(const hpr_views *views)
{
    size_t longest = 0;
    const uint32_t *list;
    for (uint32_t i = 0; i < views->group_count; i++) {
        size_t length = 0;
        for (uint32_t j = 0; j < views->group_count; j++) {
            if (views->row[i].wanted || views->row[j].wanted)
                length += sight_between(views, i, j, &list).count;
        }
        longest = length > longest ? length : longest;
    }
    return longest;
}

hpr_status hpr_views_cursor_create(const hpr_views *views, hpr_views_cursor **out)
{
    hpr_context *ctx = views->context;
    hpr_views_cursor *cursor = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &cursor, 1, sizeof *cursor, "a cursor of views");
    if (status != HPR_OK)
        return status;
    cursor->views = views;
    cursor->patch = SIZE_MAX;
    status = hpr_allocate_into(ctx, &cursor->narrowed, views->group_count, sizeof *cursor->narrowed,
                               "a cursor of views");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &cursor->list, longest_row(views), sizeof *cursor->list,
                                   "a cursor of views");
    if (status != HPR_OK)
        hpr_views_cursor_destroy(&cursor);
    *out = cursor;
    return status;
}

void hpr_views_cursor_destroy(hpr_views_cursor **out)
{
    hpr_views_cursor *cursor = *out;
    if (!cursor)
        return;
    hpr_context *ctx = cursor->views->context;
    hpr_release(ctx, cursor->narrowed);
    hpr_release(ctx, cursor->list);
    hpr_release(ctx, cursor);
    *out = NULL;
}

static void move_cursor(hpr_views_cursor *cursor, size_t patch)
{
    member box;
    set_member(cursor->views->visibility, (uint32_t)patch, &box);
    memcpy(cursor->box.low, box.low, sizeof box.low);
    memcpy(cursor->box.high, box.high, sizeof box.high);
    cursor->patch = patch;
    cursor->turn++;
    cursor->list_count = 0;
}

/* The candidates between the cursor's patch and a group, narrowed out of those of the patch's own group. */
static const narrowed *narrow(hpr_views_cursor *cursor, uint32_t group)
{
    const hpr_views *views = cursor->views;
    narrowed *it = &cursor->narrowed[group];
    if (it->turn == cursor->turn)
        return it;
    const uint32_t *list;
    sight whole = sight_between(views, views->group[cursor->patch], group, &list);
    *it = (narrowed){.turn = cursor->turn, .sight = {.first = cursor->list_count, .hidden = whole.hidden}};
    if (!whole.count)
        return it;
    shaft sh;
    open_shaft(&sh, &cursor->box, &views->node[views->group_node[group]]);
    for (uint32_t i = 0; i < whole.count && !it->sight.hidden; i++) {
        bool hidden = false;
        if (meets(views, &sh, list[i], &hidden))
            cursor->list[cursor->list_count++] = list[i];
        it->sight.hidden = hidden;
    }
    it->sight.count = (uint32_t)(cursor->list_count - it->sight.first);
    return it;
}

hpr_verdict hpr_views_classify(const hpr_views *views, hpr_views_cursor *cursor, size_t p, size_t q,
                               uint32_t *blockers, size_t *blocker_count)
{
    const hpr_visibility *visibility = views->visibility;
    if (blocker_count)
        *blocker_count = 0;
    if (views->group[p] == HPR_NONE || views->group[q] == HPR_NONE || p == q)
        return HPR_SEES_NOTHING;
    if (cursor->patch != p)
        move_cursor(cursor, p);
    const sight it = narrow(cursor, views->group[q])->sight;
    if (it.hidden)
        return HPR_SEES_NOTHING;
    hpr_facet a = hpr_patch_facet(visibility->patches, p), b = hpr_patch_facet(visibility->patches, q);
    return hpr_visibility_classify(visibility, &a, &b, cursor->list + it.first, it.count, blockers,
                                   blocker_count);
}

hpr_verdict hpr_views_between(const hpr_views *views, size_t p, size_t q)
{
    const uint32_t *list;
    const sight it = sight_between(views, views->group[p], views->group[q], &list);
    return it.hidden ? HPR_SEES_NOTHING : it.count ? HPR_SEES_PARTLY : HPR_SEES_WHOLLY;
}

size_t hpr_views_groups(const hpr_views *views)
{
    return views->group_count;
}

size_t hpr_views_lists(const hpr_views *views)
{
    size_t count = 0;
    for (size_t i = 0; i < views->group_count; i++)
        count += views->row[i].list_count;
    return count;
}
