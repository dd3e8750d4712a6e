/* The irradiance at single points, through the links but for what receiving elements leave out. */
#ifndef HPR_LINK_SPOTS_H
#define HPR_LINK_SPOTS_H

#include "link/links.h"

/* A point of a leaf, in the leaf's parameters. */
typedef struct hpr_spot {
    size_t leaf;
    double s, t;
} hpr_spot;

typedef struct hpr_spots_task {
    const hpr_links *links;
    const hpr_coverage *coverage;
    size_t channel_count;
    const double *sent;
    double tolerance;
    size_t count;
    const hpr_spot *spot;           /* [count] */
    const hpr_block_keeper *keeper; /* gets what was gathered, and is asked for it; or NULL */
    uint32_t call;                  /* its number, by which the keeper knows it */
} hpr_spots_task;

/*
 * irradiance [count][channels] = ∫ G(x,y) V(x,y) B(y) dA_y, x the spot, B what the nodes send that the spot's
 * leaf and its ancestors are linked with, sent [channels][tree's dofs] (solver/operator.h): Sloan's iterate,
 * of which the solution is the projection. 0 where something covers the spot. Each integral over a node is as
 * exact as `tolerance`, relative; what comes between is clipped, or sampled if there is too much of it. Same
 * bits for any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED. Source: Sloan 1976.
 */
hpr_status hpr_spots_gather(const hpr_spots_task *task, double *irradiance);

#endif
