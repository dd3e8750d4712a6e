/* A planar convex polygon in space. */
#ifndef HPR_MATH_CONVEX_H
#define HPR_MATH_CONVEX_H

#include "math/vec3.h"

enum { HPR_CONVEX_CORNERS = 24 };

/* Corners in order around it, either way. */
typedef struct hpr_convex {
    int count;
    hpr_vec3 corner[HPR_CONVEX_CORNERS];
} hpr_convex;

#endif
