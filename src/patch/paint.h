/*
 * Reflectance and emission that vary over a patch. On a patch with a texture
 *   rho(s,t) = (tint0 + s tint1 + t tint2) texture(u, v),   (u, v) = map0 + s map1 + t map2,
 * the tint being the material's factor times the vertex colour; anywhere else rho is the patch's mean. What
 * vertex colours above 1 make of it is cut off at 1. With an emissive texture M(s,t) = glow texture(u, v), of
 * which the patch's exitance is the mean.
 */
#ifndef HPR_PATCH_PAINT_H
#define HPR_PATCH_PAINT_H

#include "patch/patches.h"

struct hpr_paint {
    size_t texture_count;
    hpr_texture *texture; /* owned */
    uint32_t *of_patch;   /* [patches] texture of each, or HPR_NONE */
    double *map;          /* [patches][3][2] */
    double *tint;         /* [patches][3][channels] */
    uint32_t *glow_of;    /* [patches] emissive texture of each, or HPR_NONE */
    double *glow_map;     /* [patches][3][2] */
    double *glow;         /* [patches][channels] W/m2 */
};

/* Gives the patches room for paint, with none on any; textures [texture_count] are copied. Errors:
 * HPR_ERR_MEMORY. */
hpr_status hpr_paint_create(hpr_patches *patches, size_t texture_count, const hpr_texture *texture);
void hpr_paint_destroy(hpr_patches *patches);

/* The texture of a patch, NULL: rho is constant on it. */
const hpr_texture *hpr_patch_texture(const hpr_patches *patches, size_t patch);

/* The emissive texture of a patch, NULL: M is constant on it. */
const hpr_texture *hpr_patch_glow(const hpr_patches *patches, size_t patch);

/* rho [channels] at the point (s,t) of a patch. Thread-safe. */
void hpr_patch_reflectance(const hpr_patches *patches, size_t patch, double s, double t, double *rho);

/* Has some patch an emissive texture? */
bool hpr_patches_glow(const hpr_patches *patches);

/* M of a channel at the point (s,t) of a patch. Thread-safe. */
double hpr_patch_exitance(const hpr_patches *patches, size_t patch, double s, double t, size_t channel);

/* Do the channels of rho and of M agree on every patch, everywhere? */
bool hpr_patches_are_grey(const hpr_patches *patches);

#endif
