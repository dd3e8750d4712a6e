/* Welding: vertices that lie within a distance become one. */
#ifndef HPR_PATCH_WELD_H
#define HPR_PATCH_WELD_H

#include "base/context.h"

/* 4 float32 ulp of the scene's size (the longest side of its box): what node transforms of float32 vertices
 * lose. */
double hpr_weld_distance(const double low[3], const double high[3]);

/* id[count]: the lowest of the points, position [count][3], within `distance` that is a representative
 * itself, in index order. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_weld(hpr_context *ctx, const double *position, size_t count, double distance, uint32_t *id);

#endif
