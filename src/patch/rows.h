/*
 * The rows of a matrix of view factors, and the patches behind each: a row may have several (a quadrilateral
 * that is no parallelogram, a wall around its window, surfaces that are combined) or none (no area).
 */
#ifndef HPR_PATCH_ROWS_H
#define HPR_PATCH_ROWS_H

#include "patch/patches.h"
#include "scene/model.h"

typedef struct hpr_row {
    char *name;               /* "" if none; owned by the rows */
    uint32_t node, primitive; /* of a glTF file; else HPR_NONE */
    bool back;                /* the back of a doubleSided face */
    double area_m2;           /* what its factors refer to */
    double emissivity;        /* of a scene: 1 - reflectance, mean over the channels */
} hpr_row;

/* A mask on its base: they see each other with A F = area_m2, whatever else they see. */
typedef struct hpr_mask {
    uint32_t mask_row, base_row;
    double area_m2;
} hpr_mask;

typedef struct hpr_rows {
    hpr_context *context;
    size_t count;
    hpr_row *row; /* [count] */
    hpr_patches *patches;
    uint32_t *patch_row;     /* [patches->count] HPR_NONE: it only blocks */
    uint32_t *patch_surface; /* [patches->count] patches of one surface do not see each other */
    size_t *first;           /* [count + 1] into member */
    uint32_t *member;        /* patches of each row, rising */
    size_t mask_count;
    hpr_mask *mask;
} hpr_rows;

void hpr_rows_destroy(hpr_rows **rows);

/*
 * Rows of a checked model, as View3D numbers them: surfaces that radiate and masks, in file order, without
 * those that count in the row of another. Subsurfaces, masks and holes are cut out of their base, whose own
 * row is what is left (of masks: what is left plus the masks, which it sees). Where emissivities of combined
 * surfaces differ, the row has their mean by area, with a warning; exact duplicates that face the same way
 * keep a zero row, with a warning. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_rows_of_model(const hpr_model *model, hpr_rows **rows);

/* Rows of a scene: one for each patch, by node, primitive, then face; the front, then the back if
 * doubleSided. What hpr_patches_build drops keeps a zero row. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_rows_of_scene(const hpr_scene *scene, hpr_rows **rows);

/* The first row that is not simply one patch (or nothing at all), or HPR_NONE. */
uint32_t hpr_rows_composite(const hpr_rows *rows);

#endif
