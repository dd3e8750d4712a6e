/*
 * Form factors by hemicube (Cohen & Greenberg 1985): what five faces of a half cube around the centre of an
 * element show of the others, each pixel with its share of what the element sees. A rasteriser with a depth
 * buffer; it casts no ray.
 */
#ifndef HPR_BASELINE_HEMICUBE_H
#define HPR_BASELINE_HEMICUBE_H

#include "patch/elements.h"

/*
 * factor [leaves][leaves], row-major: F_ij by the hemicube of leaf i; zero on entry. A pixel belongs to the
 * surface nearest along the ray through its middle, and if that shows its front, to the leaf there; what
 * shows its back only hides. resolution: pixels along an edge of the whole cube, even. Runs in parallel,
 * the same bits for any number of threads. Errors: HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_hemicube_factors(const hpr_patches *patches, const hpr_elements *elements, int resolution,
                                double *factor);

#endif
