/* Product Gauss on two separate cells; triangles through collapsed coordinates (Stroud 1971). */
#include "quadrature/lanes_sums.h"

static void fill(const hpr_sums *sums, const hpr_gauss_table *gauss, const hpr_element_frame *frame,
                 const hpr_affine *height, const hpr_cell *cell, const int nodes[2], hpr_points *points)
{
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    const hpr_gauss_rule *first = &gauss->legendre[nodes[0]];
    const hpr_gauss_rule *second = triangle ? &gauss->jacobi[nodes[1]] : &gauss->legendre[nodes[1]];
    double jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]);
    points->count = 0;
    for (int j = 0; j < nodes[1]; j++) {
        double b = second->node[j], wide = triangle ? 1 - b : 1;
        const double start[2] = {cell->origin[0] + b * cell->edge2[0], cell->origin[1] + b * cell->edge2[1]},
                     by[2] = {wide * cell->edge1[0], wide * cell->edge1[1]};
        hpr_vec3 x = hpr_frame_point(frame, start[0], start[1]), d = hpr_frame_vector(frame, by);
        const hpr_point_line line = {
            .at = {start[0], start[1], x.x, x.y, x.z, hpr_affine_at(height, start[0], start[1])},
            .by = {by[0], by[1], d.x, d.y, d.z, by[0] * height->along1 + by[1] * height->along2},
            .count = (size_t)nodes[0],
            .u = first->node,
            .weight = first->weight,
            .scale = second->weight[j] * jacobian,
            .least = -INFINITY};
        sums->line(&line, points);
    }
}

void hpr_points_product(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                        hpr_group *group, hpr_group_sink sink, void *user)
{
    const hpr_sums *sums = hpr_sums_of(group->isa);
    fill(sums, gauss, &pair->recv, &pair->recv_height, &rule->recv, rule->recv_nodes, &group->recv);
    fill(sums, gauss, &pair->send, &pair->send_height, &rule->send, rule->send_nodes, &group->send);
    group->scale = 1;
    sink(user, group);
}
