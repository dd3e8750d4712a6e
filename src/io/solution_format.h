/*
 * The tables of the extension HPRAD_radiosity that its writer and its reader share, and what it holds.
 *
 * The extension stands at the root of the glTF, version 6, or 5 if there are no emissive textures, 4
 * if there are none at all, 3 if also no quadrilaterals; a newer one is refused. Version 1 has no
 * environment, version 2 no links, solver or errors of blocks in the summary. Lengths are in metres, light in
 * SI units per channel. It holds no times: the same solution gives the same bytes. An array is an object
 * {bufferView, componentType, components, count}: `count` items of `components` little-endian numbers (uint8,
 * uint32, uint64, float64, float32), tightly packed in that buffer view, which begins at a multiple of 8
 * bytes in the file; an empty array has no buffer view. 4294967295 means "none". Numbers in the JSON that are
 * not finite are the texts "NaN", "Infinity",
 * "-Infinity".
 *
 * - version: 3 to 6. scene: the file's name. channels: their names, mostly R, G, B. exposure: see the end
 * - environment: the radiance from outside, W/m2/sr, one number per channel
 * - patches.count: one per side of a surface; .degenerateCount, .duplicateCount: faces that were left out
 * - patches.shape, .side (uint8): 0 parallelogram, 1 triangle, 2 quadrilateral; 1 for the back of a
 *   doubleSided face
 * - patches.twin, .node, .primitive, .material (uint32): the patch on the other side, or none; where it
 *   comes from (the material may be none)
 * - patches.origin, .edge1, .edge2, .normal, .area (float64): x = origin + s edge1 + t edge2 with
 *   0 <= s, t <= 1, and s + t <= 1 for a triangle. Every patch blocks light from both sides
 * - patches.opposite (2 float64, version 4): (a,b) of a quadrilateral, whose (s,t) are in the convex one with
 *   the corners (0,0), (1,0), (a,b), (0,1); else unused
 * - patches.reflectance, .exitance (float64 per channel): rho, the mean over the patch; M in W/m2
 * - textures[] (version 5): width, height; wrapU, wrapV (0 repeat, 1 mirror, 2 clamp to edge); nearest (1: a
 *   texel is constant, 0: bilinear between texel centres); texels (float32 per texel and channel), linear
 * - patches.texture (uint32, version 5): its texture, or none; .textureMap (6 float64), .tint (3 times one
 *   float64 per channel): rho(s,t) = (tint0 + s tint1 + t tint2) texture(u, v), at most 1, with
 *   (u, v) = map0 + s map1 + t map2, 0 to 1 over the picture, whose first row of texels is at v = 0
 * - patches.glowTexture (uint32, version 6): its emissive texture, or none; .glowMap (6 float64), .glow
 * (float64 per channel): M(s,t) = glow texture(u, v) in W/m2, of which exitance is the mean
 * - elements.count, .leafCount: nodes and leaves of the patches' binary trees; node i < patches.count is the
 *   root of patch i
 * - elements.patch, .child (uint32): its patch; the first of two consecutive children, none for a leaf
 * - elements.axis, .degree (uint8): the parameter that the children halve, 0: s, 1: t (a triangle v0, v1, v2
 *   with m amid v1 and v2 has the children m, v0, v1 and m, v2, v0; a quadrilateral is cut between the
 *   middles of the sides from (0,0) to (1,0) and from (0,1) to (a,b), axis 0, or of the other two); p <= 16
 * - elements.origin, .edge1, .edge2, .area (float64), .opposite (2 float64, version 4): the node's own frame
 * - solution.coefficientCount: per channel
 * - solution.leaf (uint32 per leaf): its node; by patch, then first child first
 * - solution.firstCoefficient (uint64 per leaf, and one more): where its (p+1)^2 or (p+1)(p+2)/2 begin
 * - solution.irradiance (float64 per coefficient and channel): H(x) = sum_k irradiance[k] T_k(x); its
 *   indirect part if summary.direct is 0 (exact): then D(x), the light straight from the emitters, is added;
 *   in W/m2 * m; T_k is the orthonormal basis of basis/basis.h, on a
 *   quadrilateral that of math/planar_basis.h over its (s,t), divided by the root of |edge1 x edge2|
 * - solution.surroundings (float64 per patch and channel): S, W/m2. With V(x) the open part of the view,
 * light from outside adds (pi L - S) V(x) to H if summary.environment is 1
 * - solution.error (float64 per leaf): estimated L2 error of H, in W/m2 * m; NaN: unknown
 * - cameras[]: name, kind (perspective, orthographic), origin, right, up, backward, yfov, aspectRatio (0: the
 *   picture's), xmag, ymag, znear, zfar
 * - summary: options and counts of the solve; method 0: hprad's own, as is meant where it is missing
 * - energy[] (W per channel): emitted, environment, absorbed, lostOnBacks, escaped;
 *   the last two NaN where a full matrix was solved
 *
 * What other programs show is an unlit mesh with the vertex colours clamp(exposure * radiance, 0, 1), linear
 * Rec. 709, and the cameras. It is a picture of the solution and is not read back.
 */
#ifndef HPR_IO_SOLUTION_FORMAT_H
#define HPR_IO_SOLUTION_FORMAT_H

#include "solver/solution.h"

#define HPR_EXTENSION_NAME "HPRAD_radiosity"
enum {
    HPR_EXTENSION_VERSION = 6,
    HPR_EXTENSION_VERSION_WITHOUT_GLOW = 5,
    HPR_EXTENSION_VERSION_WITHOUT_TEXTURES = 4,
    HPR_EXTENSION_VERSION_WITHOUT_QUADRILATERALS = 3
};

typedef enum hpr_component { HPR_UINT8, HPR_UINT32, HPR_UINT64, HPR_FLOAT64, HPR_FLOAT32 } hpr_component;

/* Name in the file, and bytes. */
const char *hpr_component_name(hpr_component component);
size_t hpr_component_bytes(hpr_component component);

/* The sizes that all arrays follow from. */
typedef struct hpr_solution_sizes {
    size_t channels, patches, nodes, leaves, dofs;
} hpr_solution_sizes;

/* One array of the file: `count` items of `components` numbers each. */
typedef struct hpr_column {
    const char *group, *key; /* object and member within the extension */
    hpr_component component;
    size_t components, count;
    bool derived; /* follows from the others: checked when read, not taken */
    size_t since; /* the version from which on it must be there; in older files all of it may be 0 */
    void *array;  /* address of the pointer in the solution, NULL if there is no solution */
} hpr_column;

enum { HPR_COLUMN_COUNT = 28 };

/* Lists the arrays; `solution` may be NULL. */
void hpr_solution_columns(const hpr_solution_sizes *sizes, hpr_solution *solution,
                          hpr_column columns[HPR_COLUMN_COUNT]);

typedef enum hpr_field_kind { HPR_FIELD_INT, HPR_FIELD_SIZE, HPR_FIELD_DOUBLE } hpr_field_kind;

/* A member of a structure that is written by name. */
typedef struct hpr_field {
    const char *key;
    hpr_field_kind kind;
    size_t offset;
    size_t since; /* the version from which on it must be there; older files may leave it 0 */
} hpr_field;

/* Members of hpr_solve_summary, hpr_energy and the numbers of hpr_camera; *count receives how many. */
const hpr_field *hpr_summary_fields(size_t *count);
const hpr_field *hpr_energy_fields(size_t *count);
const hpr_field *hpr_camera_fields(size_t *count);

/* The four vectors of hpr_camera, as offsets of double[3]. */
enum { HPR_CAMERA_VECTORS = 4 };
extern const hpr_field hpr_camera_vectors[HPR_CAMERA_VECTORS];

#endif
