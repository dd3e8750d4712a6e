#include "quadrature/rule.h"

void hpr_rule_points(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_rule *rule,
                     hpr_group *group, hpr_group_sink sink, void *user)
{
    switch (rule->kind) {
    case HPR_RULE_PRODUCT:
        hpr_points_product(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_VERTEX:
        hpr_points_vertex(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_EDGE:
        hpr_points_edge(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_NESTED:
        hpr_points_nested(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_CLIPPED:
        hpr_points_clipped(gauss, pair, rule, group, sink, user);
        return;
    case HPR_RULE_PARALLEL: /* their points are no product of two sides' */
    case HPR_RULE_ALIGNED:
        return;
    }
}

double hpr_group_sum(const hpr_group *group)
{
    const hpr_points *a = &group->recv, *b = &group->send;
    double sum = 0;
    for (int i = 0; i < a->count; i++) {
        double row = 0;
        for (int j = 0; j < b->count; j++) {
            double dx = b->x[j] - a->x[i], dy = b->y[j] - a->y[i], dz = b->z[j] - a->z[i];
            double r2 = dx * dx + dy * dy + dz * dz;
            row += b->weight[j] / (r2 * r2);
        }
        sum += a->weight[i] * row;
    }
    return group->scale * sum / 3.14159265358979323846;
}

hpr_outer_point hpr_outer_at(const hpr_gauss_table *gauss, const hpr_element_frame *outer,
                             const hpr_cell *cell, const hpr_box *box, int nodes, int index)
{
    const hpr_gauss_rule *rule = &gauss->legendre[nodes];
    int i = index % nodes, j = index / nodes;
    double jacobian = fabs(cell->edge1[0] * cell->edge2[1] - cell->edge1[1] * cell->edge2[0]);
    double v = box->low[1] + box->width[1] * rule->node[j];
    double shrink = cell->shape == HPR_SHAPE_TRIANGLE ? 1 - v : 1;
    double a = (box->low[0] + box->width[0] * rule->node[i]) * shrink;
    hpr_outer_point point = {.s = cell->origin[0] + a * cell->edge1[0] + v * cell->edge2[0],
                             .t = cell->origin[1] + a * cell->edge1[1] + v * cell->edge2[1]};
    point.weight = rule->weight[i] * rule->weight[j] * box->width[0] * box->width[1] * shrink * jacobian;
    point.position = hpr_frame_point(outer, point.s, point.t);
    return point;
}

int hpr_polynomial_nodes(int degree, double tolerance)
{
    static const double loose = 1e-3;
    return tolerance > loose ? (degree + 3) / 4 : (degree + 1) / 2;
}
