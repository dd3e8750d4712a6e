/*
 * Planar patches x(s,t) = origin + s edge1 + t edge2: parallelograms, triangles and convex quadrilaterals,
 * with (s,t) in the domain of their shape (patch/shape.h). A patch is one side: its front is where edge1 x
 * edge2 points. A doubleSided face gives two patches, twins, with edge1 and edge2 exchanged. Every patch
 * blocks light from both sides.
 */
#ifndef HPR_PATCH_PATCHES_H
#define HPR_PATCH_PATCHES_H

#include "patch/shape.h"
#include "scene/scene.h"

typedef struct hpr_paint hpr_paint; /* patch/paint.h */

typedef struct hpr_patches {
    hpr_context *context;
    size_t count, channel_count;
    uint8_t *shape;                          /* [count] hpr_shape */
    uint8_t *side;                           /* [count] 0: front of its face, 1: back of a doubleSided face */
    uint32_t *twin;                          /* [count] patch on the other side, or HPR_NONE */
    uint32_t *node, *primitive, *material;   /* [count] where it comes from; material may be HPR_NONE */
    double *origin, *edge1, *edge2, *normal; /* [count][3] metres; normal has length 1 */
    double *opposite;    /* [count][2] of a quadrilateral: parameters of the corner opposite to the origin */
    double *area_m2;     /* [count] */
    double *reflectance; /* [count][channels] area mean of rho */
    double *exitance;    /* [count][channels] M = pi Le, W/m2 */
    hpr_paint *paint;    /* textures, NULL: none; then rho(x) is not its mean (patch/paint.h) */
    size_t degenerate_count; /* faces dropped because they have no area */
    double weld_m;           /* vertices within this distance were made one; touching is judged by it */
    size_t duplicate_count;  /* patches dropped because an equal, same-facing one came before */
} hpr_patches;

/* Allocates arrays for `capacity` patches, all zero, count = capacity. */
hpr_status hpr_patches_create(hpr_context *ctx, size_t capacity, size_t channel_count, hpr_patches **patches);
void hpr_patches_destroy(hpr_patches **patches);

/*
 * Makes the patches of a scene: welds vertices within 4 float32 ulp of the scene's size, merges adjacent
 * triangles of one mesh to parallelograms (lowest index first), what is left of them in one plane to convex
 * quadrilaterals, drops degenerate faces and exact same-facing duplicates and counts them. Order: face order;
 * a doubleSided face gives its front, then its back. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_patches_build(const hpr_scene *scene, hpr_patches **patches);

/* The same for matrices of view factors: what would be dropped stays in its place as a patch without area,
 * edges and normal, so that dropping renumbers nothing; and there are no quadrilaterals. */
hpr_status hpr_patches_build_all(const hpr_scene *scene, hpr_patches **patches);

/* Corners in order: 4 or 3 points. Returns their number. */
size_t hpr_patch_corners(const hpr_patches *patches, size_t patch, double corner[4][3]);

/* Half the diagonal of the box of all corners, and its centre. Zero for no patches. */
double hpr_patches_radius(const hpr_patches *patches, double centre[3]);

/* Parameters of the point of the patch's plane nearest to `point`. */
void hpr_patch_parameters(const hpr_patches *patches, size_t patch, const double point[3], double *s,
                          double *t);

#endif
