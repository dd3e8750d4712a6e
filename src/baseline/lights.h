/* The lamps of a scene, and how a point on one is chosen. */
#ifndef HPR_BASELINE_LIGHTS_H
#define HPR_BASELINE_LIGHTS_H

#include "patch/patches.h"

typedef struct hpr_lights {
    const hpr_patches *patches; /* borrowed */
    size_t count;               /* lamps; the two sides of a doubleSided one count once */
    uint32_t *patch;            /* [count] */
    double *cumulated;          /* [count] chance of choosing a lamp up to this one */
    double *density;            /* [patches] of choosing a point, 1/m2; 0 if the patch is dark */
} hpr_lights;

/* A lamp is chosen with a chance proportional to its power: area times its strongest channel. Errors:
 * HPR_ERR_MEMORY. Fini accepts a zeroed or half-built struct. */
hpr_status hpr_lights_init(const hpr_patches *patches, hpr_lights *lights);
void hpr_lights_fini(hpr_lights *lights);

/*
 * A random point y of a lamp, uniform in its area, with the density density[patch]; of a doubleSided lamp the
 * side that faces `from`, so that no sample is lost on the other. u chooses the lamp, s and t the point; all
 * in [0, 1). Returns the patch. count must not be 0. Concurrent calls allowed.
 */
uint32_t hpr_lights_choose(const hpr_lights *lights, const double from[3], double u, double s, double t,
                           double y[3]);

#endif
