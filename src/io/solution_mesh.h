/* The solution as coloured triangles, for viewers that know glTF only. */
#ifndef HPR_IO_SOLUTION_MESH_H
#define HPR_IO_SOLUTION_MESH_H

#include "solver/solution.h"

typedef struct hpr_solution_mesh {
    hpr_context *context;
    double centre[3]; /* what the positions are relative to */
    double radius;    /* half the diagonal of the scene's box */
    double exposure;  /* colour = clamp(exposure * radiance) */
    size_t vertex_count, index_count;
    float *position;       /* [vertex_count][3] metres */
    float *colour;         /* [vertex_count][3] linear Rec. 709, 0 .. 1 */
    uint32_t *index;       /* [index_count] triangles, counter-clockwise from the front */
    float low[3], high[3]; /* of position */
} hpr_solution_mesh;

/*
 * Every leaf element becomes a grid of max(1, degree) cells per axis whose corners show L = (M + rho H) / pi
 * of this element; where that would be more than about two million vertices, coarser grids, then coarser
 * elements. Exposure: 0.18 over the log-average luminance of the surfaces that shine, weighted by area.
 * Channels R, G, B show as such, else their mean as grey. Errors: HPR_ERR_MEMORY. Fini it in any case.
 */
hpr_status hpr_solution_mesh_init(const hpr_solution *solution, hpr_solution_mesh *mesh);
void hpr_solution_mesh_fini(hpr_solution_mesh *mesh);

#endif
