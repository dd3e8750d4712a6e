/*
 * Who sees whom among patches, and past what: what is found for groups of patches is inherited by their
 * pairs, and what is found for a pair of patches by their elements.
 */
#ifndef HPR_VISIBILITY_VIEWS_H
#define HPR_VISIBILITY_VIEWS_H

#include "visibility/visibility.h"

typedef struct hpr_views hpr_views;

/*
 * Puts patches into groups of up to HPR_VIEWS_GROUP that lie together and face alike, and finds for each pair
 * of groups the occluders that meet the shaft between their boxes, out of those of the pair's ancestors in
 * the tree of groups. wanted [patches]: only pairs with a wanted patch will be asked for; NULL: all. Time
 * grows like the number of pairs of groups times the length of their lists, memory like the lists of the
 * pairs of groups; where nothing can come between anything (a convex room), both are negligible. Runs in
 * parallel. Borrows `visibility`. Errors: HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
enum { HPR_VIEWS_GROUP = 16 };
hpr_status hpr_views_create(const hpr_visibility *visibility, const bool *wanted, hpr_views **views);
void hpr_views_destroy(hpr_views **views);

/* The facet that a whole patch is. */
hpr_facet hpr_patch_facet(const hpr_patches *patches, size_t patch);

/* What one thread remembers of the patch that it asked for last. */
typedef struct hpr_views_cursor hpr_views_cursor;

hpr_status hpr_views_cursor_create(const hpr_views *views, hpr_views_cursor **cursor);
void hpr_views_cursor_destroy(hpr_views_cursor **cursor);

/*
 * What hpr_visibility_classify says for two whole patches, with the same blockers: room for
 * hpr_visibility_occluder_count, or NULL. HPR_SEES_NOTHING for a patch without area. The cursor narrows the
 * candidates between p and the groups of one q after the other, so many calls with the same p are cheap; the
 * result does not depend on it. Concurrent calls allowed with distinct cursors.
 */
hpr_verdict hpr_views_classify(const hpr_views *views, hpr_views_cursor *cursor, size_t p, size_t q,
                               uint32_t *blockers, size_t *blocker_count);

/*
 * What is known of two patches by their groups alone: HPR_SEES_NOTHING if one occluder hides them,
 * HPR_SEES_WHOLLY if nothing can come between them (though they may face away), HPR_SEES_PARTLY if only
 * hpr_views_classify can tell. Patches with area only. Concurrent calls allowed.
 */
hpr_verdict hpr_views_between(const hpr_views *views, size_t p, size_t q);

/* How many groups there are, and how many entries the lists of their pairs have in all (4 bytes each; 16 more
 * per pair of groups). */
size_t hpr_views_groups(const hpr_views *views);
size_t hpr_views_lists(const hpr_views *views);

#endif
