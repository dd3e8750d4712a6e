/* Patches that lie on each other: where light would arrive twice. */
#ifndef HPR_PATCH_OVERLAP_H
#define HPR_PATCH_OVERLAP_H

#include "patch/patches.h"

typedef struct hpr_overlaps {
    size_t count;      /* pairs of patches */
    uint32_t first[2]; /* the one with the lowest indices, lower index first */
} hpr_overlaps;

/*
 * Finds the pairs of patches that face the same way, lie in one plane (the corners of each within weld_m of
 * the other's) and overlap by more than weld_m in every direction; those that only adjoin do not. In a scene
 * each of the two receives all the light that arrives there. Patches without area are left out. Errors:
 * HPR_ERR_MEMORY.
 */
hpr_status hpr_overlaps_find(const hpr_patches *patches, hpr_overlaps *overlaps);

#endif
