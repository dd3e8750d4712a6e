#include "quadrature/touching.h"

hpr_wing hpr_wing_make(const hpr_element_frame *frame, const hpr_affine *height, const hpr_cell *cell)
{
    double second[2] = {cell->edge2[0] - cell->edge1[0], cell->edge2[1] - cell->edge1[1]};
    return (hpr_wing){.cell = cell,
                      .first = hpr_frame_vector(frame, cell->edge1),
                      .second = hpr_frame_vector(frame, second),
                      .first_height = cell->edge1[0] * height->along1 + cell->edge1[1] * height->along2,
                      .second_height = second[0] * height->along1 + second[1] * height->along2,
                      .jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0])};
}

void hpr_wing_append(const hpr_wing *wing, hpr_points *points, double x1, double x2, hpr_vec3 position,
                     double weight)
{
    const hpr_cell *cell = wing->cell;
    int k = points->count++;
    points->s[k] = cell->origin[0] + (x1 - x2) * cell->edge1[0] + x2 * cell->edge2[0];
    points->t[k] = cell->origin[1] + (x1 - x2) * cell->edge1[1] + x2 * cell->edge2[1];
    points->x[k] = position.x;
    points->y[k] = position.y;
    points->z[k] = position.z;
    points->weight[k] = weight * wing->jacobian;
}
