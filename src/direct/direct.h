/*
 * Direct light evaluated at points: D(x) = sum over emitters of M_e times the fraction of e that x sees, by
 * Lambert's formula on what clipping leaves of the emitter; exact for constant polygonal emitters.
 */
#ifndef HPR_DIRECT_DIRECT_H
#define HPR_DIRECT_DIRECT_H

#include "math/vec3.h"
#include "patch/elements.h"
#include "visibility/visibility.h"

typedef struct hpr_direct hpr_direct;

/* True if the scene's emitters are few enough to be evaluated at every point; else they go through the basis.
 */
bool hpr_direct_affordable(const hpr_patches *patches);

/*
 * For each leaf and each emitter: cannot see it, sees it wholly, or the list of occluders that may come
 * between. Borrows patches and elements. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE.
 */
hpr_status hpr_direct_create(const hpr_patches *patches, const hpr_elements *elements, hpr_direct **direct);
void hpr_direct_destroy(hpr_direct **direct);

/* One emitter: a planar polygon of constant exitance. */
typedef struct hpr_emitter {
    hpr_shape shape;
    hpr_vec3 origin, edge1, edge2, normal;
    double area_m2;
    double opposite[2];     /* of a quadrilateral (patch/shape.h) */
    const double *exitance; /* [channels] W/m2 */
} hpr_emitter;

/* How a leaf sees an emitter. */
typedef struct hpr_sight {
    hpr_verdict verdict;
    const uint32_t *blockers; /* [blocker_count] that may come between */
    size_t blocker_count;
} hpr_sight;

size_t hpr_direct_emitter_count(const hpr_direct *direct);
/* Borrowed from `direct`. */
hpr_emitter hpr_direct_emitter(const hpr_direct *direct, size_t emitter);
hpr_sight hpr_direct_sight(const hpr_direct *direct, size_t leaf, size_t emitter);
/* What the blockers of a sight are numbered in. */
const hpr_visibility *hpr_direct_visibility(const hpr_direct *direct);

/*
 * Adds D(x), W/m2, to irradiance [channels] at parameters (s,t) of a leaf. At an emitter's edge: the limit
 * from inside the leaf. Never allocates; concurrent calls allowed.
 */
void hpr_direct_add(const hpr_direct *direct, size_t leaf, double s, double t, double *irradiance);

#endif
