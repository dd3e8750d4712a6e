/* Product Gauss on two separate cells; triangles through collapsed coordinates (Stroud 1971). */
#include "quadrature/rule.h"

static void fill(const hpr_gauss_table *gauss, const hpr_element_frame *frame, const hpr_affine *height,
                 const hpr_cell *cell, const int nodes[2], hpr_points *points)
{
    bool triangle = cell->shape == HPR_SHAPE_TRIANGLE;
    const hpr_gauss_rule *first = &gauss->legendre[nodes[0]];
    const hpr_gauss_rule *second = triangle ? &gauss->jacobi[nodes[1]] : &gauss->legendre[nodes[1]];
    double jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]);
    points->count = 0;
    for (int j = 0; j < nodes[1]; j++) {
        double b = second->node[j];
        for (int i = 0; i < nodes[0]; i++) {
            double a = triangle ? first->node[i] * (1 - b) : first->node[i];
            int k = points->count++;
            double s = cell->origin[0] + a * cell->edge1[0] + b * cell->edge2[0];
            double t = cell->origin[1] + a * cell->edge1[1] + b * cell->edge2[1];
            hpr_vec3 x = hpr_frame_point(frame, s, t);
            points->s[k] = s;
            points->t[k] = t;
            points->x[k] = x.x;
            points->y[k] = x.y;
            points->z[k] = x.z;
            points->weight[k] = first->weight[i] * second->weight[j] * jacobian * hpr_affine_at(height, s, t);
        }
    }
}

void hpr_points_product(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                        hpr_group *group, hpr_group_sink sink, void *user)
{
    fill(gauss, &pair->recv, &pair->recv_height, &rule->recv, rule->recv_nodes, &group->recv);
    fill(gauss, &pair->send, &pair->send_height, &rule->send, rule->send_nodes, &group->send);
    group->scale = 1;
    sink(user, group);
}
